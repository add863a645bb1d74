#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Draws odometry_error.png: position error of the odometry of VINS-Mono over time.

    odometry_error.py GROUNDTRUTH.csv EVENT_S OUT.png NAME=ODOMETRY.csv...

GROUNDTRUTH.csv as state_groundtruth_estimate0/data.csv of an ASL folder. ODOMETRY.csv: stamp [ns] and
position x, y, z [m] in columns 2 to 5. Each odometry is aligned (position and heading) by its part
before the event, EVENT_S seconds after its first stamp.
"""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def aligned(t, p, truth, event):
    """Positions [m] in the frame of the ground truth, after a fit of position and heading before `event`."""
    q = np.stack([np.interp(t, truth[:, 0] * 1e-9, truth[:, k]) for k in (1, 2, 3)], axis=1)
    before = t < event
    a, b = p[before] - p[before].mean(0), q[before] - q[before].mean(0)
    heading = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(),
                         (a[:, :2] * b[:, :2]).sum())
    c, s = np.cos(heading), np.sin(heading)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return (p - p[before].mean(0)) @ R.T + q[before].mean(0), q


def main(truth_file, event_s, out, *runs):
    truth = np.loadtxt(truth_file, delimiter=",")
    figure, axes = plt.subplots(figsize=(8, 3.2))
    for name, path in (run.split("=", 1) for run in runs):
        rows = np.loadtxt(path, delimiter=",")
        t = rows[:, 1] * 1e-9
        p, q = aligned(t, rows[:, 2:5], truth, t[0] + float(event_s))
        axes.semilogy(t - t[0], np.maximum(np.linalg.norm(p - q, axis=1), 1e-3), label=name)
    axes.axvline(float(event_s), color="k", ls=":", lw=1)
    axes.set(xlabel="time since the first odometry [s]", ylabel="position error [m]")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
