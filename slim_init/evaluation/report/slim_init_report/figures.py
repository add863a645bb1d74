# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The pictures of a report. Every function takes the rows of windows.csv and the file to write, and
returns the picture's caption, or "" where there is nothing to draw."""
import os

import matplotlib

matplotlib.use("Agg")
import numpy
from matplotlib import pyplot

from .data import methods_of
from .statistics import finite

DPI = 110
# |s - 1| below this is a right answer in the picture of the first answer.
RIGHT_SCALE_ERROR = 0.1


def _colors(methods):
    """The same colour for the same method in every picture of a report."""
    palette = pyplot.get_cmap("tab10" if len(methods) <= 10 else "tab20").colors
    return {method: palette[i % len(palette)] for i, method in enumerate(methods)}


def _save(figure, path):
    figure.savefig(path, dpi=DPI)
    pyplot.close(figure)


def _legend(figure, axes):
    """One legend above all panels, and the room that it takes."""
    handles, labels = max((axis.get_legend_handles_labels() for axis in axes),
                          key=lambda found: len(found[0]))
    columns = min(4, max(1, len(labels)))
    figure.legend(handles, labels, loc="upper center", ncol=columns, fontsize=8)
    height = 0.26 * -(-len(labels) // columns) / figure.get_size_inches()[1]
    figure.tight_layout(rect=(0.0, 0.0, 1.0, 0.98 - height))


def error_cdf(windows, path):
    """Fraction of all windows with an error below x: a curve ends at the fraction with an estimate."""
    panels = (("scale_error", "|s - 1|"), ("gravity_error_deg", "gravity error [deg]"),
              ("velocity_vec_rmse", "velocity error [m/s]"),
              ("gyro_bias_err_pct", "gyro bias error [%]"))
    colors = _colors(methods_of(windows))
    figure, axes = pyplot.subplots(2, 2, figsize=(9.0, 6.8))
    drawn = False
    for axis, (key, title) in zip(axes.flat, panels):
        for method, color in colors.items():
            rows = windows[windows["method"] == method]
            errors = numpy.sort(finite(rows[key]))
            errors = errors[errors > 0.0]
            if not len(errors):
                continue
            drawn = True
            axis.step(errors, 100.0 * numpy.arange(1, len(errors) + 1) / len(rows), where="post",
                      label=method, color=color, linewidth=1.3)
        axis.set_xscale("log")
        axis.set_ylim(0.0, 100.0)
        axis.set_xlabel(title)
        axis.set_ylabel("windows [%]")
        axis.grid(True, which="both", alpha=0.25)
    if not drawn:
        pyplot.close(figure)
        return ""
    _legend(figure, axes.flat)
    _save(figure, path)
    return "Fraction of all windows with an error below x"


def solve_time(windows, path):
    """A box per method over the windows with an estimate: CPU time, which others do not disturb."""
    attempted = windows[windows["attempted"]]
    times = {method: finite(attempted.loc[attempted["method"] == method, "solve_cpu_ms"])
             for method in methods_of(windows)}
    times = {method: values for method, values in times.items() if len(values)}
    if not times:
        return ""
    figure, axis = pyplot.subplots(figsize=(7.5, 1.2 + 0.42 * len(times)), constrained_layout=True)
    axis.boxplot(list(times.values())[::-1], vert=False, whis=(1, 99), showfliers=False,
                 showmeans=True, meanprops={"marker": "D", "markersize": 5})
    axis.set_yticklabels(list(times)[::-1], fontsize=8)
    axis.set_xscale("log")
    axis.set_xlabel("CPU time of a solve [ms]; box: quartiles and median, diamond: mean, "
                    "whiskers: 1 % and 99 %", fontsize=8)
    axis.grid(True, axis="x", which="both", alpha=0.25)
    _save(figure, path)
    return "CPU time of a solve"


def start_outcomes(panels, outcomes, path):
    """A panel per calibration, a bar per method: its starts by outcome.

    panels: titles, each with the counts by method and outcome."""
    colors = ("tab:green", "tab:red", "lightgray")
    figure, axes = pyplot.subplots(1, len(panels), sharey=True, figsize=(9.0, 3.0))
    for axis, (title, by_method) in zip(axes, panels):
        methods = list(by_method)[::-1]
        left = numpy.zeros(len(methods))
        for outcome, color in zip(outcomes, colors):
            widths = numpy.array([by_method[method][outcome] for method in methods], dtype=float)
            axis.barh(methods, widths, left=left, color=color, label=outcome)
            for method, width, begin in zip(methods, widths, left):
                if width:
                    axis.text(begin + 0.5 * width, method, "%d" % width, ha="center", va="center")
            left += widths
        axis.set_title(title, fontsize=10)
        axis.xaxis.get_major_locator().set_params(integer=True)
        axis.set_xlabel("starts")
    _legend(figure, axes)
    _save(figure, path)


def first_answer(windows, path):
    """Fraction of the starts after which a method has accepted an estimate within x seconds of
    data, of windows that expand until it does; dashed: a right one."""
    colors = _colors(methods_of(windows))
    accepted = windows[windows["status"] == "success"]
    if accepted.empty:
        return ""
    right_end = 1.05 * accepted["answer_s"].max()
    figure, axis = pyplot.subplots(figsize=(7.5, 4.2))
    for method, color in colors.items():
        starts = (windows["method"] == method).sum()
        rows = accepted[accepted["method"] == method]
        curves = [(rows, "-", method)]
        if windows["has_truth"].all():
            curves.append((rows[rows["scale_error"] < RIGHT_SCALE_ERROR], "--", None))
        for of_curve, style, label in curves:
            values = numpy.sort(of_curve["answer_s"])
            share = 100.0 * numpy.arange(1, len(values) + 1) / starts
            axis.step(numpy.concatenate([[0.0], values, [right_end]]),
                      numpy.concatenate([[0.0], share, share[-1:] if len(share) else [0.0]]), style,
                      where="post", color=color, label=label, linewidth=1.3)
    axis.set_xlim(0.0, right_end)
    axis.set_ylim(0.0, 101.0)
    axis.set_xlabel("time to the first accepted estimate [s]; dashed: and |s - 1| < %g" %
                    RIGHT_SCALE_ERROR)
    axis.set_ylabel("starts [%]")
    axis.grid(True, alpha=0.25)
    _legend(figure, [axis])
    _save(figure, path)
    return ("Time to the first accepted estimate, windows expanding until the method accepts; "
            "dashed: accepted and |s - 1| < 0.1")


def draw(windows, out, growing, prefix=""):
    """All pictures of one run, or of several together, into the folder `out`; prefix begins their
    files' names; growing: with that of the first estimates. Returns pairs of file and caption."""
    pictures = {"error_cdf.png": error_cdf, "solve_time.png": solve_time,
                "first_answer.png": first_answer if growing else lambda *_: ""}
    drawn = []
    for name, picture in pictures.items():
        path = os.path.join(out, prefix + name)
        if os.path.exists(path):
            os.remove(path)  # of an earlier report
        caption = picture(windows, path)
        if caption:
            drawn.append((prefix + name, caption))
    return drawn
