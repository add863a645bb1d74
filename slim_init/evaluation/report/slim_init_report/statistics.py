# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Statistics over windows, computed from the rows of windows.csv.

`slim_init ab` writes some of them for one run into summary.json; here they are computed over any set
of windows, several runs together included. Definitions: docs/evaluation.md.
"""
import numpy
import pandas

from .data import methods_of

# The answer may become one with more data; the others but "success" and the refused ones are
# failures. As the table of statuses in slim_init/src/data/result.cc has it.
WAITING = ("too_few_keyframes", "too_few_tracks", "stationary", "too_little_excitation",
           "pure_rotation", "provisional", "time_limit")
REFUSED = ("degenerate_alignment", "inconsistent_residuals", "scale_too_uncertain")


def finite(values):
    """The finite ones as an array of numbers."""
    array = numpy.asarray(values, dtype=float)
    return array[numpy.isfinite(array)]


# Of the finite values. Quantiles interpolate between neighbours.
REDUCTIONS = {"rmse": lambda values: numpy.sqrt(numpy.mean(values ** 2)), "mean": numpy.mean,
              "median": numpy.median, "p90": lambda values: numpy.percentile(values, 90.0),
              "max": numpy.max}
# Sets of windows that are not known without ground truth.
OF_TRUTH = ("success", "within_0_1", "within_0_5")


def reduced(values, reduction):
    """NaN for no finite value."""
    values = finite(values)
    return float(REDUCTIONS[reduction](values)) if len(values) else numpy.nan


class Summary:
    """The windows of one method, by what became of them. Its figures are, for example:

    summary["accepted"]                  their number
    summary["accepted/windows"]          the fraction; NaN of nothing, and of errors without ground truth
    summary["accepted.answer_s.p90"]     of the finite values of a column; NaN for none
    summary["accepted.td_error_ms/td_sigma_ms.rmse"]  of the quotients of two columns
    """

    def __init__(self, rows):
        attempted, accepted = rows[rows["attempted"]], rows[rows["status"] == "success"]
        # An error exists where the answer could be compared with the truth.
        evaluated = accepted[numpy.isfinite(accepted["scale_error"])]
        downstream = accepted[accepted["downstream"]]
        self.has_truth = bool(rows["has_truth"].all())
        self.sets = {
            "windows": rows, "attempted": attempted, "success": attempted[attempted["success"]],
            "accepted": accepted, "evaluated": evaluated,
            "within_0_1": evaluated[evaluated["scale_error"] < 0.1],
            "within_0_5": evaluated[evaluated["scale_error"] < 0.5],
            "beyond_0_25": evaluated[evaluated["scale_error"] > 0.25],
            "beyond_0_5": accepted[~(accepted["scale_error"] < 0.5)],
            "downstream": downstream, "diverged": downstream[downstream["downstream_diverged"]],
            "waiting": rows[rows["status"].isin(WAITING)],
            "refused": rows[rows["status"].isin(REFUSED)],
            "failed": rows[~rows["status"].isin(("success",) + WAITING + REFUSED)]}

    def __getitem__(self, key):
        if "." in key:
            name, column, reduction = key.split(".")
            over, _, by = column.partition("/")
            rows = self.sets[name]
            return reduced(rows[over] / rows[by] if by else rows[over], reduction)
        part, _, whole = key.partition("/")
        if not whole:
            return len(self.sets[part])
        known = len(self.sets[whole]) and (self.has_truth or part not in OF_TRUTH)
        return len(self.sets[part]) / len(self.sets[whole]) if known else numpy.nan


def summarize(windows, methods=None):
    """The Summary of each method, in their order of occurrence or as listed; a method without a
    window has zeros and NaN."""
    methods = methods_of(windows) if methods is None else methods
    return {method: Summary(windows[windows["method"] == method]) for method in methods}


def statuses(windows):
    """Windows by method (rows) and name of the status (columns, in alphabetical order)."""
    if not len(windows):
        return pandas.DataFrame()
    counts = pandas.crosstab(windows["method"], windows["status"])
    return counts.reindex(methods_of(windows))


def stage_times(windows):
    """Median wall time [ms] of each stage, by method, over windows with an estimate; stages in the
    order in which they first occur."""
    times = {}
    texts = windows["stages_ms"].where(windows["attempted"], "")
    for method, text in zip(windows["method"], texts):
        of_method = times.setdefault(method, {})
        for stage in filter(None, text.split(";")):
            name, _, value = stage.partition("=")
            of_method.setdefault(name, []).append(float(value) if value else numpy.nan)
    return {method: {name: reduced(values, "median") for name, values in stages.items()}
            for method, stages in times.items()}
