# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The tables of several runs: the paper's tables I to IV and Fig. 6, and a row per run and method.

`runs` are data.Run; subset: "excited" (a column of windows.csv that must be true) or None for all
windows."""
import math

import numpy

from . import paper
from .data import methods_of, pool
from .method_tables import TIME, Column, method_table, named_table
from .statistics import summarize
from .tables import Cell, Table, count, number

# The errors of the paper's tables by their keys there: root mean squares over successful windows.
ERRORS = {"scale_rmse": Column("scale", "success.scale_error.rmse", "%.3f", dagger=True),
          "gravity_rmse_deg": Column("gravity deg", "success.gravity_error_deg.rmse", "%.3f",
                                     dagger=True),
          "velocity_rmse": Column("velocity m/s", "success.velocity_rmse.rmse", "%.3f", dagger=True),
          "pose_rmse": Column("pose m", "success.pose_rmse.rmse", "%.4f", dagger=True)}
ERROR_TITLES = {"scale_rmse": "Scale RMSE", "gravity_rmse_deg": "Gravity direction RMSE [deg]",
                "velocity_rmse": "Velocity RMSE [m/s] (difference of speeds)",
                "pose_rmse": "Pose RMSE [m]"}
TITLES = [error.title for error in ERRORS.values()]


def select(windows, subset):
    """The windows of a subset."""
    return windows[windows[subset]] if subset else windows


def summaries_of(run, subset=None):
    """Statistics of one run; methods without a window in the subset keep their row."""
    return summarize(select(run.windows, subset), methods_of(run.windows))


def set_beside(cell, pattern, printed):
    """Puts the paper's figure beside ours."""
    if math.isfinite(printed):
        cell.beside = pattern % printed
    return cell


def run_table(runs):
    """What was run."""
    table = Table(["run", "group", "features", "true gyro bias", "trials", "windows", "excited",
                   "not evaluated", "notes"], names=4)
    for run in runs:
        trials = run.info.get("trials", {})
        first = run.windows["method"] == methods_of(run.windows)[0]
        table.add(run.name, run.group, run.features, run.info.get("gyro_bias_truth", "?"),
                  count(trials.get("trials", 0)), count(trials.get("windows", 0)),
                  count((run.windows["excited"] & first).sum()),
                  count(trials.get("trials", 0) - trials.get("windows", 0)),
                  count(len(run.info.get("notes", []))))
    return table


def accuracy_tables(runs, subset):
    """The paper's Table I, a table per error: a row per method, a column per sequence and the mean
    over them (not over windows), the printed figures beside."""
    summaries = [summaries_of(run, subset) for run in runs]
    return [_accuracy_table(key, runs, summaries, methods_of(pool(runs))) for key in ERRORS]


def _accuracy_table(key, runs, summaries, methods):
    error = ERRORS[key]
    table = Table(["method"] + [run.name for run in runs] + ["mean"],
                  title=ERROR_TITLES[key])
    for method in methods:
        row, printed = [], []
        for run, summary in zip(runs, summaries):
            cell = error.cell(summary[method]) if method in summary else Cell("-")
            printed.append(paper.printed("table_1", key, method, paper.sequence_of(run.sequence)))
            row.append(set_beside(cell, "%.3f", printed[-1]))
        # Over the sequences shown, or not at all: means over different ones do not compare. NaN of
        # one sequence makes the mean NaN.
        row.append(set_beside(number(error.pattern, numpy.mean([cell.value for cell in row])),
                              "%.3f", numpy.mean(printed)))
        table.add(method, *row)
    for column in range(1, len(table.columns)):
        table.mark_best(column)
    return table


def success_table(runs, subset):
    """The paper's Table II: a row per method, a column per group, the groups' windows together."""
    methods = methods_of(pool(runs))
    table = Table(["method"])
    rows = {method: [] for method in methods}
    for group in dict.fromkeys(run.group for run in runs):
        members = [run for run in runs if run.group == group]
        table.columns.append("%s (%s)" % (group, ", ".join(run.name for run in members)))
        pooled = pool(members)
        summaries = summarize(select(pooled, subset), methods_of(pooled))
        for method in methods:
            rate = summaries[method]["success/windows"] if method in summaries else math.nan
            rows[method].append(set_beside(number("%.1f", rate, 100.0), "%.1f", paper.printed(
                "table_2_success_pct", group, method)))
    for method in methods:
        table.add(method, *rows[method])
    for column in range(1, len(table.columns)):
        table.mark_best(column, lowest=False)
    return table


def _add_errors(summary, name, printed):
    """The errors of a row of tables III and IV; printed: the paper's table, or None."""
    return [set_beside(error.cell(summary), "%.3f",
                       paper.printed(printed, name, key) if printed else math.nan)
            for key, error in ERRORS.items()]


def degenerate_table(runs):
    """The paper's Table III: a row per run and method; beside the corridor walk the average of the
    paper's own walks."""
    table = Table(["run", "method", "success %"] + TITLES +
                  ["accepted", "accepted >= 0.5 off"], names=2)
    for run in runs:
        printed = "table_3_average" if run.options.get("builtin") == "corridor-walk" else None
        first = len(table.rows)
        for method, s in summaries_of(run).items():
            table.add(run.name, method, number("%.1f", s["success/windows"], 100.0),
                      *_add_errors(s, method, printed), count(s["accepted"]),
                      count(s["beyond_0_5"]))
        for column in range(2, 3 + len(ERRORS)):
            table.mark_best(column, column > 2, range(first, len(table.rows)))
    return table


def ablation_table(runs, degenerate):
    """The paper's Table IV and the same for `slim`: a row per variant, the windows of all runs
    together. degenerate: beside it the printed errors, which are for degenerate motion; else the
    printed gyroscope bias error, which is for EuRoC."""
    table = Table(["variant", "what is changed", "success %"] + TITLES +
                  ["gyro bias %", "accepted", "CPU ms, median"], names=2)
    notes = runs[0].info.get("method_notes", {})
    blocks = {}
    for variant, s in summarize(pool(runs)).items():
        blocks.setdefault(variant.split("[")[0], []).append(len(table.rows))
        bias = number("%.3f", s["success.gyro_bias_err_pct.rmse"])
        if not degenerate:
            set_beside(bias, "%.3f", paper.printed("gyro_bias_err_pct", variant))
        table.add(variant, notes.get(variant, ""), number("%.1f", s["success/windows"], 100.0),
                  *_add_errors(s, variant, "table_4_average" if degenerate else None), bias,
                  count(s["accepted"]), number("%.3f", s["attempted.solve_cpu_ms.median"]))
    for rows in blocks.values():
        for column in range(2, 4 + len(ERRORS)):
            table.mark_best(column, column > 2, rows)
    return table


def time_table(runs):
    """The paper's Fig. 6: CPU time of a solve over the windows with an estimate."""
    table = method_table(TIME, summarize(pool(runs)))
    mean = table.columns.index("CPU ms, mean")
    for row in table.rows:
        set_beside(row[mean], "%.3f", paper.printed("figure_6_solve_ms", row[0].text))
    return table


def run_method_table(runs, columns, subset=None, title=""):
    """A row per run and method."""
    has_truth = any(run.has_truth for run in runs)
    return named_table(columns, [((run.name,), summaries_of(run, subset)) for run in runs],
                       ["run", "method"], has_truth, title)


def not_first_table(table, method):
    """The figures of a table with run and method in its first columns in which `method` is not
    among the best of its run: a row per figure. Returns it and the number of figures that have a
    best one."""
    result = Table(["run", "figure", method, "best", "of"], names=2)
    figures = 0
    for run in dict.fromkeys(row[0].text for row in table.rows):
        rows = [row for row in table.rows if row[0].text == run]
        own = [row for row in rows if row[1].text == method]
        for column in range(table.names, len(table.columns)):
            best = [row for row in rows if row[column].best]
            if not own or not best:
                continue
            figures += 1
            if not own[0][column].best:
                result.add(run, table.columns[column], own[0][column].text, best[0][column].text,
                           best[0][1].text)
    return result, figures
