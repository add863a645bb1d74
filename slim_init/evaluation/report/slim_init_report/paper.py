# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""What the SLIM-init paper printed (paper_figures.json), to stand beside what is measured here.
Methods go by the names of this program; the paper's own method is `slim-paper`."""
import json
import math
import os

with open(os.path.join(os.path.dirname(__file__), "paper_figures.json"), encoding="utf-8") as _file:
    FIGURES = json.load(_file)

SEQUENCES = FIGURES["sequences"]


def sequence_of(name):
    """The paper's name of a sequence: "MH_01" for "MH_01_easy"; "" for one that it has not."""
    return name[:5] if name[:5] in SEQUENCES else ""


def printed(*path):
    """A figure by the keys of the file; a list has one for each sequence. NaN where it printed
    nothing."""
    value = FIGURES
    for key in path:
        value = dict(zip(SEQUENCES, value)) if isinstance(value, list) else value
        value = value.get(key, {})
    return math.nan if value == {} else value
