#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of a report of `slim_init ab` from its windows.csv.

    python3 plot_report.py FOLDER
    python3 plot_report.py OUT PREFIX FOLDER...

Writes trajectory.png (only where there is ground truth), error_cdf.png (likewise) and
solve_time.png into FOLDER. The second form takes the windows of several folders together, without
the path, and writes PREFIXerror_cdf.png and PREFIXsolve_time.png into OUT. Exit code 0: done; 1:
windows.csv cannot be used, with a sentence on stderr; 3: there is no matplotlib.
"""
import csv
import math
import os
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.collections import LineCollection
except ImportError:
    sys.exit(3)


def number(text):
    """NaN for an empty field: a number that does not exist."""
    return float(text) if text else math.nan


def read_windows(folders):
    """Rows of their windows.csv by method, in the order in which methods first occur."""
    methods = {}
    for folder in folders:
        path = os.path.join(folder, "windows.csv")
        with open(path, newline="", encoding="utf-8", errors="replace") as file:
            for row in csv.DictReader(file):
                methods.setdefault(row["method"], []).append(row)
    if not methods:
        raise ValueError("no windows")
    return methods


def widest_plane(positions):
    """The two axes in which the path extends furthest, as indices in ascending order."""
    spans = [max(p[i] for p in positions) - min(p[i] for p in positions) for i in range(3)]
    return sorted(sorted(range(3), key=lambda i: -spans[i])[:2])


def draw_trajectory(methods, path):
    """One panel a method: the true path in pieces, each with the colour of its window's error."""
    first = next(iter(methods.values()))
    if len(first) < 2 or not all(row["p_x"] for row in first):
        return
    errors = [number(row["pose_rmse"]) for rows in methods.values() for row in rows
              if row["success"] == "1"]
    errors = sorted(e for e in errors if math.isfinite(e))
    # The worst few would leave all the others in one colour.
    limit = errors[int(0.95 * (len(errors) - 1))] if errors else 1.0
    columns = min(3, len(methods))
    lines = -(-len(methods) // columns)
    figure, axes = pyplot.subplots(lines, columns, squeeze=False, constrained_layout=True,
                                   figsize=(4.2 * columns, 3.6 * lines))
    shown = None
    for axis, (name, rows) in zip(axes.flat, methods.items()):
        positions = [[float(row[key]) for key in ("p_x", "p_y", "p_z")] for row in rows]
        i, j = widest_plane(positions)
        times = [float(row["t_start_s"]) for row in rows]
        steps = sorted(b - a for a, b in zip(times, times[1:]))
        longest = 3.0 * steps[len(steps) // 2]
        good, values, bad = [], [], []
        for k, row in enumerate(rows[:-1]):
            if times[k + 1] - times[k] > longest:
                continue  # a gap in the recording
            piece = [(positions[n][i], positions[n][j]) for n in (k, k + 1)]
            if row["success"] == "1":
                good.append(piece)
                values.append(number(row["pose_rmse"]))
            else:
                bad.append(piece)
        axis.add_collection(LineCollection(bad, colors="black", linewidths=2.0))
        shown = LineCollection(good, cmap="viridis", linewidths=2.0)
        shown.set_array(values)
        shown.set_clim(0.0, limit)
        axis.add_collection(shown)
        axis.autoscale()
        axis.set_aspect("equal", adjustable="datalim")
        axis.set_title("%s: %d of %d failed" % (name, sum(r["success"] != "1" for r in rows),
                                               len(rows)), fontsize=9)
        axis.set_xlabel("xyz"[i] + " [m]")
        axis.set_ylabel("xyz"[j] + " [m]")
    for axis in list(axes.flat)[len(methods):]:
        axis.set_visible(False)
    figure.colorbar(shown, ax=axes, label="pose error [m]")
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def draw_error_cdf(methods, path):
    """Share of all windows with an error below x: a curve ends at the share with an estimate."""
    panels = (("scale_error", "|s - 1|"), ("gravity_error_deg", "gravity error [deg]"),
              ("velocity_vec_rmse", "velocity error [m/s]"),
              ("gyro_bias_err_pct", "gyro bias error [%]"))
    figure, axes = pyplot.subplots(2, 2, figsize=(9.0, 6.8))
    drawn = False
    for axis, (key, title) in zip(axes.flat, panels):
        for name, rows in methods.items():
            errors = sorted(e for e in (number(row[key]) for row in rows)
                            if math.isfinite(e) and e > 0.0)
            if not errors:
                continue
            drawn = True
            shares = [100.0 * (k + 1) / len(rows) for k in range(len(errors))]
            axis.step(errors, shares, where="post", label=name, linewidth=1.3)
        axis.set_xscale("log")
        axis.set_ylim(0.0, 100.0)
        axis.set_xlabel(title)
        axis.set_ylabel("windows [%]")
        axis.grid(True, which="both", alpha=0.25)
    if drawn:
        handles, labels = max((axis.get_legend_handles_labels() for axis in axes.flat),
                              key=lambda found: len(found[0]))
        lines = -(-len(labels) // 4)
        figure.legend(handles, labels, loc="upper center", ncol=min(4, len(labels)), fontsize=8)
        figure.tight_layout(rect=(0.0, 0.0, 1.0, 0.99 - 0.032 * lines))
        figure.savefig(path, dpi=110)
    pyplot.close(figure)


def draw_solve_time(methods, path):
    """A box a method over the windows with an estimate: CPU time, which others do not disturb."""
    times = {name: [number(row["solve_cpu_ms"]) for row in rows if row["attempted"] == "1"]
             for name, rows in methods.items()}
    times = {name: values for name, values in times.items() if values}
    if not times:
        return
    figure, axis = pyplot.subplots(figsize=(7.0, 1.2 + 0.42 * len(times)), constrained_layout=True)
    axis.boxplot(list(times.values())[::-1], vert=False, whis=(1, 99), showfliers=False,
                 showmeans=True, meanprops={"marker": "D", "markersize": 5})
    axis.set_yticklabels(list(times)[::-1], fontsize=8)
    axis.set_xscale("log")
    axis.set_xlabel("CPU time of a solve [ms]; box: quartiles and median, diamond: mean, "
                    "whiskers: 1 % and 99 %", fontsize=8)
    axis.grid(True, axis="x", which="both", alpha=0.25)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def main():
    arguments = sys.argv[1:]
    if len(arguments) == 1:
        out, prefix, folders = arguments[0], "", arguments
    elif len(arguments) > 2:
        out, prefix, folders = arguments[0], arguments[1], arguments[2:]
    else:
        sys.exit("usage: plot_report.py FOLDER | plot_report.py OUT PREFIX FOLDER...")
    try:
        methods = read_windows(folders)
        if not prefix:
            draw_trajectory(methods, os.path.join(out, "trajectory.png"))
        draw_error_cdf(methods, os.path.join(out, prefix + "error_cdf.png"))
        draw_solve_time(methods, os.path.join(out, prefix + "solve_time.png"))
    except (OSError, ValueError, KeyError) as error:
        sys.exit("plot_report.py: %s: %s" % (", ".join(folders), error))


if __name__ == "__main__":
    main()
