# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The page of `slim_init demo`: one recording with two calibrations, and who was right."""
import os

from . import figures, render
from .data import InputError, methods_of
from .tables import Table, count, number

TITLES = ("as recorded", "as a home-made rig has it")
CORRECT, INCORRECT, NONE = "correct", "incorrect", "no start"


def outcomes(run):
    """How often each method started with a correct scale, with an incorrect one, and not at all,
    and the median scale error of its starts [%]."""
    result = {}
    for method in methods_of(run.windows):
        rows = run.windows[run.windows["method"] == method]
        started = rows["status"] == "success"
        right = started & (rows["scale_error"] < figures.RIGHT_SCALE_ERROR)
        result[method] = {CORRECT: int(right.sum()), INCORRECT: int((started & ~right).sum()),
                          NONE: int((~started).sum()),
                          "error": 100.0 * rows.loc[started, "scale_error"].median()}
    return result


def _list_text(words):
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def sentence(found):
    """Who was right, in one sentence."""
    def part(by_method):
        total = sum(next(iter(by_method.values()))[key] for key in (CORRECT, INCORRECT, NONE))
        return total, _list_text(["`%s` in %d" % (method, counts[CORRECT])
                                  for method, counts in by_method.items()])
    total, recorded = part(found[0])
    total_home, home = part(found[1])
    return ("Of %d starts %s, a scale within 10 %% of the ground truth was found by %s; of %d starts "
            "%s, by %s." % (total, TITLES[0], recorded, total_home, TITLES[1], home))


def _table(found):
    table = Table(["calibration", "method", CORRECT, INCORRECT, NONE, "scale error %, median"], names=2)
    for title, by_method in zip(TITLES, found):
        for method, counts in by_method.items():
            table.add(title, method, *(count(counts[key]) for key in (CORRECT, INCORRECT, NONE)),
                      number("%.1f", counts["error"]))
    return table


def write(runs, out):
    """Writes report.md, report.html and the picture into `out`. Returns the two pages."""
    if len(runs) != 2 or not all(run.has_truth for run in runs):
        raise InputError("the page of the demo needs two runs with ground truth")
    found = [outcomes(run) for run in runs]
    picture = "starts.png"
    figures.start_outcomes(list(zip(TITLES, found)), (CORRECT, INCORRECT, NONE),
                           os.path.join(out, picture))
    return render.write("demo.j2", {
        "title": "Who starts with the correct scale?", "sentence": sentence(found),
        "picture": picture, "table": _table(found),
        "commands": [run.info.get("command", "?") for run in runs],
        "features": runs[0].features, "program": runs[0].program,
    }, out)
