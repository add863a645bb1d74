# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The columns of tables with a row per method, and these tables."""
from dataclasses import dataclass

from .data import methods_of
from .statistics import reduced
from .tables import Cell, Table, count, number

FEW_WINDOWS = "\u2020"  # a dagger


@dataclass
class Column:
    """A figure of one method over one set of windows; `key` of statistics.Summary."""
    title: str
    key: str
    pattern: str = "%.4f"
    factor: float = 1.0
    best: str = "lowest"      # "lowest", "highest" or "" (none is better)
    needs_truth: bool = True  # omitted from the tables of a sequence without ground truth
    dagger: bool = False      # marked where fewer than half of the windows are successful

    def cell(self, summary):
        """The cell of a method."""
        if self.needs_truth and not summary.has_truth:
            return Cell("-")
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


ACCURACY = [percent("success %", "success/windows"),
            Column("scale rmse", "success.scale_error.rmse"),
            Column("scale median", "success.scale_error.median"),
            Column("scale p90", "success.scale_error.p90"),
            Column("gravity deg", "success.gravity_error_deg.rmse", "%.3f"),
            Column("speed m/s", "success.velocity_rmse.rmse"),
            Column("velocity m/s", "success.velocity_vec_rmse.rmse"),
            Column("pose m", "success.pose_rmse.rmse"),
            Column("gyro bias %", "success.gyro_bias_err_pct.rmse", "%.2f"),
            plain("accepted", "accepted"),
            percent("of them |s-1| < 0.1, %", "within_0_1/accepted"),
            plain("solve ms", "attempted.solve_cpu_ms.median", "%.3f")]

TO_ACCEPT = [percent("accepted %", "accepted/windows", "", False),
             plain("time to accept s, median", "accepted.answer_s.median", "%.2f"),
             plain("time to accept s, p90", "accepted.answer_s.p90", "%.2f")]
SCALE_RMSE = Column("scale rmse", "evaluated.scale_error.rmse")
LARGEST = Column("largest", "evaluated.scale_error.max")
OVER_SIGMA = Column("error/sigma", "evaluated.scale_error/scale_sigma.rmse", "%.2f", best="")

ACCEPTED = TO_ACCEPT + [plain("keyframes, median", "accepted.answer_keyframes.median", "%.0f"),
                        SCALE_RMSE, Column("scale median", "evaluated.scale_error.median"), LARGEST,
                        percent("|s-1| < 0.1, %", "within_0_1/accepted"),
                        percent("< 0.5 %", "within_0_5/accepted"),
                        Column("gravity deg", "evaluated.gravity_error_deg.rmse", "%.3f"),
                        Column("speed m/s", "evaluated.velocity_rmse.rmse")]

FIRST_ANSWER = [percent("within 10 %, % of all", "within_0_1/windows"),
                Column("beyond 25 %", "beyond_0_25", "%d", best=""),
                plain("time to estimate within 10 % s, median", "within_0_1.answer_s.median", "%.2f"),
                plain("time to estimate within 10 % s, p90", "within_0_1.answer_s.p90", "%.2f")
                ] + TO_ACCEPT + [percent("of them |s-1| < 0.1, %", "within_0_1/accepted"), LARGEST,
                                 SCALE_RMSE, OVER_SIGMA]

CALIBRATION = [TO_ACCEPT[0], SCALE_RMSE, OVER_SIGMA,
               Column("td ms", "accepted.td_error_ms.rmse", "%.2f", needs_truth=False),
               plain("error/sigma", "accepted.td_error_ms/td_sigma_ms.rmse", "%.2f"),
               Column("rotation deg", "accepted.rotation_error_deg.rmse", "%.3f", needs_truth=False),
               plain("error/sigma", "accepted.rotation_over_sigma.rmse", "%.2f"),
               Column("readout ms", "accepted.readout_error_ms.rmse", "%.2f", needs_truth=False)]

DOWNSTREAM = [plain("runs", "downstream"),
              percent("diverged %", "diverged/downstream", "lowest", False)] + [
    Column("%s, %s" % (title, what), "downstream.%s.%s" % (column, what), pattern)
    for title, column, pattern in (("ATE m", "downstream_ate", "%.3f"),
                                   ("final scale error", "downstream_scale_error", "%.4f"))
    for what in ("median", "p90")]

TIME = [plain("windows", "attempted")] + [
    Column("CPU ms, " + what, "attempted.solve_cpu_ms." + what, "%.3f", needs_truth=False)
    for what in ("median", "mean", "p90")] + [
    plain("wall ms, median", "attempted.solve_ms.median", "%.3f")]

VERDICTS = [plain("windows", "windows"), plain("with estimate", "attempted"),
            Column("success", "success", "%d", best="")] + [
    plain(name, name) for name in ("accepted", "waiting", "refused", "failed")] + [
    Column("accepted < 0.1 off", "within_0_1", "%d", best=""),
    Column("accepted >= 0.5 off", "beyond_0_5", "%d", best=""),
    Column("largest accepted error", "evaluated.scale_error.max", "%.3f", best="")]

DETAIL = [plain("windows", "windows"), percent("success %", "success/windows")] + [
    Column("%s %s" % (title, what), "success.%s.%s" % (column, what), pattern, dagger=True)
    for title, column, pattern in (("scale", "scale_error", "%.4f"),
                                   ("gravity deg", "gravity_error_deg", "%.3f"),
                                   ("velocity m/s", "velocity_rmse", "%.4f"),
                                   ("pose m", "pose_rmse", "%.4f"))
    for what in ("rmse", "median", "p90")]


def method_table(columns, summaries, has_truth=True, title=""):
    """A row per method; summaries: of statistics.summarize()."""
    return named_table(columns, [((), summaries)], ["method"], has_truth, title)


def named_table(columns, blocks, names, has_truth=True, title=""):
    """A row per method of every block, the best of each block marked. blocks: pairs of the names
    that stand before the method's and the dict of statistics.summarize()."""
    shown = [column for column in columns if has_truth or not column.needs_truth]
    table = Table(names + [column.title for column in shown], names=len(names), title=title)
    for block, summaries in blocks:
        first = len(table.rows)
        for method, summary in summaries.items():
            table.add(*block, method, *[column.cell(summary) for column in shown])
        for c, column in enumerate(shown, start=len(names)):
            if column.best:
                table.mark_best(c, column.best == "lowest", range(first, len(table.rows)))
    return table


def difference_table(windows, reference, title=""):
    """A row per method: its figures minus those of the reference on the windows of both, errors over
    those in which both succeed. No row where no sequence with ground truth has the reference."""
    errors = (("scale rmse", "scale_error", "%+.3f"), ("gravity deg", "gravity_error_deg", "%+.2f"),
              ("velocity m/s", "velocity_rmse", "%+.3f"), ("pose m", "pose_rmse", "%+.3f"))
    table = Table(["method minus %s" % reference, "windows", "both succeed", "success %"] +
                  [name for name, _, _ in errors], title=title)
    known = windows[windows["has_truth"]].set_index(["run", "trial"])
    known = known.assign(ok=known["attempted"] & known["success"])
    own = known[known["method"] == reference]
    for method in methods_of(known):
        pairs = known[known["method"] == method].join(own, rsuffix="_own", how="inner")
        if method == reference or pairs.empty:
            continue
        both = pairs[pairs["ok"] & pairs["ok_own"]]
        table.add(method, count(len(pairs)), count(len(both)),
                  number("%+.1f", pairs["ok"].mean() - pairs["ok_own"].mean(), 100.0),
                  *[number(pattern, reduced(both[column], "rmse") -
                           reduced(both[column + "_own"], "rmse"))
                    for _, column, pattern in errors])
    return table
