#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Draws odometry.gif: the ways of VINS-Mono through a fault, seen from above, and their errors.

    odometry.py GROUNDTRUTH.csv EVENT_S OUT.gif NAME=vins_result_no_loop.csv...

GROUNDTRUTH.csv as `slim_init simulate --bag` writes it, from the first image on; the fault comes EVENT_S
seconds after that. The odometry is the file that VINS-Mono writes: stamp [ns] and position [m] in its first
columns. Each is aligned (position and heading) by its part before the fault. The picture plays at the speed
of the flight, from BEFORE_S before the fault to AFTER_S after it.
"""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.animation import FuncAnimation, PillowWriter
import numpy as np

FRAMES_PER_SECOND = 3
BEFORE_S, AFTER_S = 5, 15
MARGIN = 1.0  # about the true way [m]; an odometry that leaves it is lost anyway
LEAST_ERROR = 0.01  # that is drawn [m]


def aligned(t, p, truth):
    """Positions [m] in the frame of the ground truth after a fit of position and heading before t = 0, and
    those of the ground truth."""
    q = np.stack([np.interp(t, truth[:, 0], truth[:, k]) for k in (1, 2, 3)], axis=1)
    before = t < 0
    a, b = p[before] - p[before].mean(0), q[before] - q[before].mean(0)
    heading = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(),
                         (a[:, :2] * b[:, :2]).sum())
    c, s = np.cos(heading), np.sin(heading)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return (p - p[before].mean(0)) @ R.T + q[before].mean(0), q


def load(path, fault):
    """Seconds since the fault, and positions."""
    rows = np.loadtxt(path, delimiter=",", usecols=(0, 1, 2, 3))
    rows[:, 0] = rows[:, 0] * 1e-9 - fault
    return rows


def main(truth_file, event_s, out, *runs):
    truth = load(truth_file, 0.0)
    fault = truth[0, 0] + float(event_s)
    truth[:, 0] -= fault
    figure, (above, over_time) = plt.subplots(1, 2, figsize=(8, 3.2), dpi=75)
    drawn = []
    for name, path in (run.split("=", 1) for run in runs):
        rows = load(path, fault)
        p, q = aligned(rows[:, 0], rows[:, 1:], truth)
        shown = (rows[:, 0] > -BEFORE_S) & (rows[:, 0] < AFTER_S)
        t, p, q = rows[shown, 0], p[shown], q[shown]
        error = np.maximum(np.linalg.norm(p - q, axis=1), LEAST_ERROR)
        way, = above.plot([], [], lw=1.5, label=name)
        curve, = over_time.semilogy([], [], lw=1.5, label=name)
        drawn.append((t, p, error, way, curve))
    shown = (truth[:, 0] > -BEFORE_S) & (truth[:, 0] < AFTER_S)
    t, q = truth[shown, 0], truth[shown, 1:]
    true_way, = above.plot([], [], color="0.8", lw=4, zorder=0, label="ground truth")
    above.set(xlim=(q[:, 0].min() - MARGIN, q[:, 0].max() + MARGIN),
              ylim=(q[:, 1].min() - MARGIN, q[:, 1].max() + MARGIN), xlabel="x [m]", ylabel="y [m]")
    above.set_aspect("equal")
    above.legend(loc="upper left", fontsize=7)
    over_time.set(xlim=(-BEFORE_S, AFTER_S), ylim=(LEAST_ERROR, max(run[2].max() for run in drawn) * 1.5),
                  xlabel="time since the fault [s]", ylabel="position error [m]")
    over_time.axvline(0.0, color="k", ls=":", lw=1)
    over_time.grid(alpha=0.3)
    figure.tight_layout()

    def draw(frame):
        now = frame / FRAMES_PER_SECOND - BEFORE_S
        true_way.set_data(q[t <= now, 0], q[t <= now, 1])
        for times, p, error, way, curve in drawn:
            past = times <= now
            way.set_data(p[past, 0], p[past, 1])
            curve.set_data(times[past], error[past])

    frames = (BEFORE_S + AFTER_S) * FRAMES_PER_SECOND + 1
    FuncAnimation(figure, draw, frames).save(out, PillowWriter(fps=FRAMES_PER_SECOND))


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
