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
FAILED = ("invalid_input", "numerical_failure")


def finite(values):
    """The finite ones as an array of numbers."""
    array = numpy.asarray(values, dtype=float)
    return array[numpy.isfinite(array)]


def root_mean_square(values):
    """NaN for no value."""
    values = finite(values)
    return float(numpy.sqrt(numpy.mean(values ** 2))) if len(values) else numpy.nan


def mean(values):
    """NaN for no value."""
    values = finite(values)
    return float(numpy.mean(values)) if len(values) else numpy.nan


def quantile(values, share):
    """Order statistic with linear interpolation between neighbours; NaN for no value."""
    values = finite(values)
    return float(numpy.percentile(values, 100.0 * share)) if len(values) else numpy.nan


def median(values):
    """The mean of the middle two for an even count; NaN for no value."""
    return quantile(values, 0.5)


def ratio(part, whole):
    """NaN where the whole is nothing."""
    return part / whole if whole else numpy.nan


def summarize_method(rows):
    """The statistics by key of one method over the windows in `rows`."""
    attempted = rows[rows["attempted"]]
    success = attempted[attempted["success"]]
    accepted = rows[rows["status"] == "success"]
    # An error exists where the answer could be compared with the truth.
    evaluated = accepted[numpy.isfinite(accepted["scale_error"])]
    downstream = accepted[accepted["downstream"]]
    has_truth = bool(rows["has_truth"].all())
    within = {bound: int((evaluated["scale_error"] < bound).sum()) for bound in (0.1, 0.5)}
    s = {"windows": len(rows), "attempted": len(attempted), "success": len(success),
         "success_rate": ratio(len(success), len(rows)) if has_truth else numpy.nan}

    # Over successful windows.
    for key, column in (("scale", "scale_error"), ("gravity", "gravity_error_deg"),
                        ("velocity", "velocity_rmse"), ("pose", "pose_rmse")):
        unit = "_deg" if key == "gravity" else ""
        s[key + "_rmse" + unit] = root_mean_square(success[column])
        s[key + "_median" + unit] = median(success[column])
        s[key + "_p90" + unit] = quantile(success[column], 0.9)
    s["velocity_vec_rmse"] = root_mean_square(success["velocity_vec_rmse"])
    s["gyro_bias_err_pct"] = root_mean_square(success["gyro_bias_err_pct"])
    s["gyro_bias_vec_rmse"] = root_mean_square(success["gyro_bias_vec_err"])

    # Over windows that the method itself accepted.
    s["accepted"] = len(accepted)
    s["accepted_within_0_1"], s["accepted_within_0_5"] = within[0.1], within[0.5]
    s["accepted_beyond_0_25"] = int((evaluated["scale_error"] > 0.25).sum())
    for key in ("0_1", "0_5"):
        rate = ratio(s["accepted_within_" + key], len(accepted))
        s["accepted_within_%s_rate" % key] = rate if has_truth else numpy.nan
    s["accepted_scale_error_max"] = quantile(evaluated["scale_error"], 1.0)
    s["accepted_rate"] = ratio(len(accepted), len(rows))
    s["accepted_scale_rmse"] = root_mean_square(evaluated["scale_error"])
    s["accepted_scale_median"] = median(evaluated["scale_error"])
    s["accepted_gravity_rmse_deg"] = root_mean_square(evaluated["gravity_error_deg"])
    s["accepted_velocity_rmse"] = root_mean_square(evaluated["velocity_rmse"])
    for key, values in (
            ("scale_over_sigma", evaluated["scale_error"] / evaluated["scale_sigma"]),
            ("td_rmse_ms", evaluated["td_error_ms"]),
            ("td_over_sigma", evaluated["td_error_ms"] / evaluated["td_sigma_ms"]),
            ("rotation_rmse_deg", evaluated["rotation_error_deg"]),
            ("rotation_over_sigma", evaluated["rotation_over_sigma"]),
            ("readout_rmse_ms", evaluated["readout_error_ms"])):
        s["accepted_" + key] = root_mean_square(values)
    s["accept_s_median"] = median(accepted["answer_s"])
    s["accept_s_p90"] = quantile(accepted["answer_s"], 0.9)
    s["accept_keyframes_median"] = median(accepted["answer_keyframes"])
    right = evaluated[evaluated["scale_error"] < 0.1]
    s["right_rate"] = ratio(len(right), len(rows)) if has_truth else numpy.nan
    s["right_s_median"] = median(right["answer_s"])
    s["right_s_p90"] = quantile(right["answer_s"], 0.9)

    # Over accepted answers from which the back end was run.
    s["downstream_runs"] = len(downstream)
    s["downstream_diverged"] = int(downstream["downstream_diverged"].sum())
    s["downstream_divergence_rate"] = ratio(s["downstream_diverged"], len(downstream))
    for key, column in (("ate", "downstream_ate"), ("scale", "downstream_scale_error")):
        s["downstream_%s_median" % key] = median(downstream[column])
        s["downstream_%s_p90" % key] = quantile(downstream[column], 0.9)

    s["waiting"] = int(rows["status"].isin(WAITING).sum())
    s["refused"] = int(rows["status"].isin(REFUSED).sum())
    s["failed"] = len(rows) - s["accepted"] - s["waiting"] - s["refused"]

    # Over windows with an estimate: an early "wait" is no fast solution.
    s["solve_ms_median"] = median(attempted["solve_ms"])
    s["solve_cpu_ms_median"] = median(attempted["solve_cpu_ms"])
    s["solve_cpu_ms_mean"] = mean(attempted["solve_cpu_ms"])
    s["solve_cpu_ms_p90"] = quantile(attempted["solve_cpu_ms"], 0.9)
    return s


def summarize(windows, methods=None):
    """A row per method (in their order of occurrence, or as listed) with their statistics.
    A method without a window has zeros and NaN."""
    methods = methods_of(windows) if methods is None else methods
    rows = [summarize_method(windows[windows["method"] == method]) for method in methods]
    return pandas.DataFrame(rows, index=methods)


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
    return {method: {name: median(values) for name, values in stages.items()}
            for method, stages in times.items()}
