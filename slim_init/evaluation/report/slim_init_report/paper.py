# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""What the SLIM-init paper printed, to stand beside what is measured here. NaN where it printed
nothing. Methods go by the names of this program; the paper's own method is `slim-paper`."""
import json
import math
import os

with open(os.path.join(os.path.dirname(__file__), "paper_figures.json"), encoding="utf-8") as _file:
    FIGURES = json.load(_file)

SEQUENCES = FIGURES["sequences"]


def sequence_of(name):
    """The paper's name of a sequence: "MH_01" for "MH_01_easy"; "" for one that it has not."""
    return name[:5] if name[:5] in SEQUENCES else ""


def accuracy(key, method, sequence):
    """Table I; key: "scale_rmse", "gravity_rmse_deg", "velocity_rmse" or "pose_rmse"."""
    row = FIGURES["table_1"].get(key, {}).get(method)
    return row[SEQUENCES.index(sequence)] if row and sequence in SEQUENCES else math.nan


def success_pct(method, group):
    """Table II [%]; group: "Machine Hall", "Vicon Room 1" or "Vicon Room 2"."""
    return FIGURES["table_2_success_pct"].get(group, {}).get(method, math.nan)


def degenerate(key, method):
    """Table III, the average over C_01 to C_03: handheld walks through corridors and a lobby."""
    return FIGURES["table_3_average"].get(method, {}).get(key, math.nan)


def ablation(key, variant):
    """Table IV, the same average; variant: "slim-paper[no-lines]"."""
    return FIGURES["table_4_average"].get(variant, {}).get(key, math.nan)


def gyro_bias_pct(variant):
    """EuRoC's average, in the section on the ablation [%]."""
    return FIGURES["gyro_bias_err_pct"].get(variant, math.nan)


def solve_ms(method):
    """EuRoC's mean, in the text to Fig. 6, on an i9-12900K [ms]."""
    return FIGURES["figure_6_solve_ms"].get(method, math.nan)
