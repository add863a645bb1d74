# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The columns of tables with a row per method, and these tables."""
from dataclasses import dataclass

from .tables import Table, count, number

FEW_WINDOWS = "\u2020"  # a dagger


@dataclass
class Column:
    """A figure of one method over one set of windows; `key` as in statistics.py."""
    title: str
    key: str
    pattern: str = "%.4f"
    factor: float = 1.0
    best: str = "lowest"      # "lowest", "highest" or "" (none is better)
    needs_truth: bool = True  # omitted from the tables of a sequence without ground truth
    dagger: bool = False      # marked where fewer than half of the windows are successful

    def cell(self, summary):
        """The cell of a method; summary: a row of statistics.summarize()."""
        if self.pattern == "%d":
            return count(summary[self.key])
        cell = number(self.pattern, summary[self.key], self.factor)
        if self.dagger and cell.text != "-" and 2 * summary["success"] < summary["windows"]:
            cell.text += FEW_WINDOWS
        return cell


def percent(title, key, best="highest", needs_truth=True):
    """A share as a percentage."""
    return Column(title, key, "%.1f", 100.0, best, needs_truth)


def plain(title, key, pattern="%d"):
    """A figure of which none is better, known without ground truth."""
    return Column(title, key, pattern, best="", needs_truth=False)


ACCURACY = [percent("success %", "success_rate"),
            Column("scale rmse", "scale_rmse"), Column("scale median", "scale_median"),
            Column("scale p90", "scale_p90"), Column("gravity deg", "gravity_rmse_deg", "%.3f"),
            Column("speed m/s", "velocity_rmse"), Column("velocity m/s", "velocity_vec_rmse"),
            Column("pose m", "pose_rmse"), Column("gyro bias %", "gyro_bias_err_pct", "%.2f"),
            plain("accepted", "accepted"),
            percent("of them |s-1| < 0.1, %", "accepted_within_0_1_rate"),
            plain("solve ms", "solve_cpu_ms_median", "%.3f")]

ACCEPTED = [percent("accepted %", "accepted_rate", "", False),
            plain("time to accept s, median", "accept_s_median", "%.2f"),
            plain("time to accept s, p90", "accept_s_p90", "%.2f"),
            plain("keyframes, median", "accept_keyframes_median", "%.0f"),
            Column("scale rmse", "accepted_scale_rmse"),
            Column("scale median", "accepted_scale_median"),
            Column("largest", "accepted_scale_error_max"),
            percent("|s-1| < 0.1, %", "accepted_within_0_1_rate"),
            percent("< 0.5 %", "accepted_within_0_5_rate"),
            Column("gravity deg", "accepted_gravity_rmse_deg", "%.3f"),
            Column("speed m/s", "accepted_velocity_rmse")]

FIRST_ANSWER = [percent("within 10 %, % of all", "right_rate"),
                plain("beyond 25 %", "accepted_beyond_0_25"),
                plain("time to estimate within 10 % s, median", "right_s_median", "%.2f"),
                plain("time to estimate within 10 % s, p90", "right_s_p90", "%.2f"),
                percent("accepted %", "accepted_rate", "", False),
                plain("time to accept s, median", "accept_s_median", "%.2f"),
                plain("time to accept s, p90", "accept_s_p90", "%.2f"),
                percent("of them |s-1| < 0.1, %", "accepted_within_0_1_rate"),
                Column("largest", "accepted_scale_error_max"),
                Column("scale rmse", "accepted_scale_rmse"),
                Column("error/sigma", "accepted_scale_over_sigma", "%.2f", best="")]

CALIBRATION = [percent("accepted %", "accepted_rate", "", False),
               Column("scale rmse", "accepted_scale_rmse"),
               Column("error/sigma", "accepted_scale_over_sigma", "%.2f", best=""),
               Column("td ms", "accepted_td_rmse_ms", "%.2f"),
               Column("error/sigma", "accepted_td_over_sigma", "%.2f", best=""),
               Column("rotation deg", "accepted_rotation_rmse_deg", "%.3f"),
               Column("error/sigma", "accepted_rotation_over_sigma", "%.2f", best=""),
               Column("readout ms", "accepted_readout_rmse_ms", "%.2f")]

DOWNSTREAM = [plain("runs", "downstream_runs"),
              percent("diverged %", "downstream_divergence_rate", "lowest", False),
              Column("ATE m, median", "downstream_ate_median", "%.3f"),
              Column("ATE m, p90", "downstream_ate_p90", "%.3f"),
              Column("final scale error, median", "downstream_scale_median"),
              Column("final scale error, p90", "downstream_scale_p90")]

TIME = [plain("windows", "attempted"),
        Column("CPU ms, median", "solve_cpu_ms_median", "%.3f", needs_truth=False),
        Column("CPU ms, mean", "solve_cpu_ms_mean", "%.3f", needs_truth=False),
        Column("CPU ms, p90", "solve_cpu_ms_p90", "%.3f", needs_truth=False),
        plain("wall ms, median", "solve_ms_median", "%.3f")]

VERDICTS = [plain("windows", "windows"), plain("with estimate", "attempted"),
            Column("success", "success", "%d", best=""), plain("accepted", "accepted"),
            plain("waiting", "waiting"), plain("refused", "refused"), plain("failed", "failed"),
            Column("accepted < 0.1 off", "accepted_within_0_1", "%d", best=""),
            Column("accepted >= 0.5 off", "accepted_beyond_0_5", "%d", best=""),
            Column("largest accepted error", "accepted_scale_error_max", "%.3f", best="")]

DETAIL = [plain("windows", "windows"), percent("success %", "success_rate")] + [
    Column("%s %s" % (title, what), "%s_%s%s" % (key, what, unit), pattern, dagger=True)
    for title, key, unit, pattern in (("scale", "scale", "", "%.4f"),
                                      ("gravity deg", "gravity", "_deg", "%.3f"),
                                      ("velocity m/s", "velocity", "", "%.4f"),
                                      ("pose m", "pose", "", "%.4f"))
    for what in ("rmse", "median", "p90")]


def method_table(columns, summaries, has_truth=True, title=""):
    """A row per method; summaries: of statistics.summarize(), a row per method."""
    return named_table(columns, [((), summaries)], ["method"], has_truth, title)


def named_table(columns, blocks, names, has_truth=True, title=""):
    """A row per method of every block, the best of each block marked. blocks: pairs of the names
    that stand before the method's and a table of statistics.summarize()."""
    shown = [column for column in columns if has_truth or not column.needs_truth]
    table = Table(names + [column.title for column in shown], names=len(names), title=title)
    for block, summaries in blocks:
        first = len(table.rows)
        for method, summary in summaries.iterrows():
            summary = summary.copy()
            summary["accepted_beyond_0_5"] = summary["accepted"] - summary["accepted_within_0_5"]
            table.add(*block, method, *[column.cell(summary) for column in shown])
        for c, column in enumerate(shown, start=len(names)):
            if column.best:
                table.mark_best(c, column.best == "lowest", range(first, len(table.rows)))
    return table


def difference_table(comparisons, reference, title=""):
    """A row per method; bold where zero is outside the interval, which stands below the value."""
    columns = (("success %", "success_rate", "%+.1f", 100.0),
               ("scale rmse", "scale_rmse", "%+.3f", 1.0),
               ("gravity deg", "gravity_rmse_deg", "%+.2f", 1.0),
               ("velocity m/s", "velocity_rmse", "%+.3f", 1.0),
               ("pose m", "pose_rmse", "%+.3f", 1.0))
    table = Table(["method minus %s" % reference, "windows", "both succeed"] +
                  [title for title, _, _, _ in columns], title=title)
    for comparison in comparisons:
        cells = [count(comparison.windows), count(comparison.both_success)]
        for _, key, pattern, factor in columns:
            interval = comparison.intervals[key]
            cell = number(pattern, interval.value, factor)
            low, high = (number(pattern, bound, factor) for bound in (interval.low, interval.high))
            cell.beside = "" if "-" in (low.text, high.text) else "%s to %s" % (low.text, high.text)
            cell.best = interval.significant
            cells.append(cell)
        table.add(comparison.method, *cells)
    return table
