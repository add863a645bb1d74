# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The report of one run of `slim_init ab`. Its text is in templates/run.j2."""
from . import figures, render, statistics
from .data import methods_of
from .method_tables import (ACCEPTED, ACCURACY, CALIBRATION, DOWNSTREAM, FIRST_ANSWER, TIME, difference_table,
                            method_table)
from .suite_tables import select
from .tables import Table, count, number

# All others are compared with this method.
REFERENCE = "slim"

SUBSETS = (("excited", "Excited windows"), (None, "All windows"))


def _subset_tables(run, columns):
    """The same columns over both sets of windows, as far as they have any: triples of title, number
    of windows and table."""
    result = []
    for subset, title in SUBSETS:
        windows = select(run.windows, subset)
        if windows.empty:
            continue
        summaries = statistics.summarize(windows, methods_of(run.windows))
        result.append((title, windows.groupby(["run", "trial"]).ngroups,
                       method_table(columns, summaries, run.has_truth)))
    return result


def _option_text(value):
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return "%g" % value if isinstance(value, float) else value


def _option_table(run):
    table = Table(["option", "value"], names=2)
    for key, value in run.options.items():
        table.add(key, _option_text(value))
    table.add("true gyro bias", run.info.get("gyro_bias_truth", "?"))
    table.add("program", run.program)
    return table


def _status_table(run):
    counts = statistics.statuses(run.windows)
    attempted = run.windows.groupby("method")["attempted"].sum()
    table = Table(["method", "windows", "with estimate"] +
                  [name.replace("_", " ") for name in counts.columns])
    for method, row in counts.iterrows():
        table.add(method, count(row.sum()), count(attempted[method]), *map(count, row))
    return table


def _feature_table(tracking):
    table = Table(["per image, median", "all", "in the image before"])
    for name in ("points", "lines"):
        table.add(name, *[number("%.0f", tracking[name + end]) for end in ("", "_carried")])
    return table


def build(run, out):
    """Draws the pictures into the folder `out` and returns the context of the template."""
    methods = methods_of(run.windows)
    differences = None
    if run.has_truth and REFERENCE in methods and len(methods) > 1 and not run.is_ablation:
        differences = difference_table(run.windows, REFERENCE)
    windows = run.windows.drop_duplicates("trial")
    return {
        "title": "A/B initialization on %s" % run.sequence,
        "info": run.info, "has_truth": run.has_truth, "has_downstream": run.has_downstream,
        "reference": REFERENCE, "excited": int(windows["excited"].sum()),
        "options": _option_table(run), "accuracy": _subset_tables(run, ACCURACY),
        "variants": ["`%s`: %s" % item for item in run.info.get("method_notes", {}).items()],
        "accepted": _subset_tables(run, ACCEPTED),
        "first_answer": (_subset_tables(run, FIRST_ANSWER)
                         if run.info.get("first_keyframes") else []),
        "first_keyframes": run.info.get("first_keyframes"),
        "calibration": _subset_tables(run, CALIBRATION) if run.has_rig_errors else [],
        "downstream": _subset_tables(run, DOWNSTREAM) if run.has_downstream else [],
        "differences": differences, "pictures": figures.draw(run.windows, out, run.is_growing),
        "statuses": _status_table(run),
        "tracking": run.info.get("tracking"),
        "features": _feature_table(run.info["tracking"]) if run.info.get("tracking") else None,
        "simulated": run.info.get("simulated", {}),
        "times": method_table(TIME, statistics.summarize(run.windows), run.has_truth),
        "stages": statistics.stage_times(run.windows),
    }


def write(run, out):
    """Writes report.md, report.html and the pictures into `out`. Returns the two reports."""
    return render.write("run.j2", build(run, out), out)
