#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Compares the answers of two builds.

Two files, as `slim_init_bench count --answers` writes them: prints the largest relative difference
of every quantity and method. Ends with 1 where one is beyond the bound, or where a window has
another status.

Two folders with the windows.csv of the same runs of `slim_init ab`, as before and after a change of
the method: compares `slim` window by window and prints per run and in all what the change costs.
Ends with 1 where a criterion fails over all windows together (CRITERIA).
"""
import argparse
import csv
import math
import os
import random
import sys

# First column and number of columns; vectors are compared by their norm.
QUANTITIES = {
    "scale": (3, 1),
    "scale_sigma": (4, 1),
    "gyro_bias": (5, 3),
    "accel_bias": (8, 3),
    "gravity": (11, 3),
    "velocity": (14, 3),
}

# What a change may cost over all windows together.
MOST_LOST = 0.005  # share of the accepted windows
MOST_RMSE_RATIO = 1.02  # the lower end of its 95 % interval
ERROR_OVER_SIGMA = (0.8, 1.3)  # rms, unless it was outside before and has come nearer
MOST_P99_RATIO = 1.1  # of the CPU time: equal programs differ by as much
FAR = 0.25  # scale error
DRAWS = 1000


def read(path):
    with open(path, newline="") as file:
        return list(csv.reader(file))


def difference(a, b):
    """Relative; 0 where both are the same NaN or infinity, infinite where one of them is."""
    if a == b or all(math.isnan(x) and math.isnan(y) for x, y in zip(a, b)):
        return 0.0
    apart = math.dist(a, b)
    if not math.isfinite(apart):
        return math.inf
    return apart / max(math.hypot(*a), math.hypot(*b))


def compare_files(options):
    first, second = read(options.first), read(options.second)
    if not first or len(first) != len(second):
        sys.exit(f"{len(first)} answers in {options.first}, {len(second)} in {options.second}")

    largest, problems, equal = {}, 0, 0
    for a, b in zip(first, second):
        equal += a == b
        method, window = a[0], f"{a[0]} at {float(a[1]):.3f} s"
        if a[0] != b[0] or abs(float(a[1]) - float(b[1])) > 1e-9 or a[2] != b[2]:
            print(f"{window}: {a[2]}, in the other {' '.join(b[:3])}")
            problems += 1
            continue
        for name, (begin, count) in QUANTITIES.items():
            apart = difference(*([float(x) for x in row[begin:begin + count]] for row in (a, b)))
            if apart > options.bound:
                print(f"{window}: {name} differs by {apart:.1e}")
                problems += 1
            largest[method, name] = max(apart, largest.get((method, name), 0.0))

    print("method," + ",".join(QUANTITIES))
    for method in dict.fromkeys(row[0] for row in first):
        print(method + "".join(f",{largest.get((method, name), 0.0):.1e}" for name in QUANTITIES))
    print(f"{len(first)} answers, {equal} of them the same to the last digit, {problems} beyond "
          f"{options.bound:g}")
    return 1 if problems else 0


class Window:
    """One window of `slim`."""

    def __init__(self, row):
        number = lambda name: float(row[name] or "nan")
        self.accepted = row["status"] == "success"
        self.error = number("scale_error")
        self.sigma = number("scale_sigma")
        self.cpu_ms = number("solve_cpu_ms")

    def counts(self):
        """Accepted, and the truth says how well."""
        return self.accepted and math.isfinite(self.error)


def read_windows(folder):
    """By run and start."""
    windows = {}
    for parent, _, files in sorted(os.walk(folder)):
        if "windows.csv" not in files:
            continue
        run = os.path.relpath(parent, folder)
        with open(os.path.join(parent, "windows.csv"), newline="") as file:
            for row in csv.DictReader(file):
                if row["method"] == "slim":
                    windows[run, row["t_start_ns"]] = Window(row)
    return windows


def rms(values):
    values = list(values)
    return math.sqrt(sum(x * x for x in values) / len(values)) if values else math.nan


def ratio_interval(pairs):
    """Ratio of the rms errors of windows accepted by both, with its 95 % interval over windows."""
    squares = [(a.error**2, b.error**2) for a, b in pairs if a.counts() and b.counts()]
    if not squares:
        return math.nan, math.nan, math.nan

    def ratio(sample):
        before, after = (sum(s[i] for s in sample) for i in (0, 1))
        if before == after:
            return 1.0
        return math.sqrt(after / before) if before > 0.0 else math.inf

    draw = random.Random(1)
    drawn = sorted(ratio(draw.choices(squares, k=len(squares))) for _ in range(DRAWS))
    return ratio(squares), drawn[int(0.025 * DRAWS)], drawn[int(0.975 * DRAWS)]


def percentile(values, share):
    values = sorted(x for x in values if math.isfinite(x))
    return values[min(len(values) - 1, int(share * len(values)))] if values else math.nan


class Side:
    """The windows of one build."""

    def __init__(self, windows):
        good = [w for w in windows if w.counts()]
        self.accepted = sum(w.accepted for w in windows)
        self.far = sum(abs(w.error) > FAR for w in good)
        self.near = sum(abs(w.error) < 0.1 for w in good) / max(len(good), 1)
        self.rmse = rms(w.error for w in good)
        self.over_sigma = rms(w.error / w.sigma for w in good if w.sigma > 0.0)
        self.p99 = percentile((w.cpu_ms for w in windows), 0.99)


def failures(before, after, ratio_low):
    """The criteria that a change fails, in words."""
    found = []
    if after.accepted < (1.0 - MOST_LOST) * before.accepted:
        found.append("fewer accepted")
    if after.far > before.far:
        found.append("more beyond 25 %")
    if ratio_low > MOST_RMSE_RATIO:
        found.append("larger errors")
    low, high = ERROR_OVER_SIGMA
    outside = lambda x: max(low - x, x - high, 0.0)
    if outside(after.over_sigma) > outside(before.over_sigma):
        found.append("error over sigma outside 0.8 to 1.3")
    if after.p99 > MOST_P99_RATIO * before.p99:
        found.append("slower")
    return found


def compare_folders(options):
    first, second = read_windows(options.first), read_windows(options.second)
    if not first or first.keys() != second.keys():
        sys.exit(f"{len(first)} windows in {options.first}, {len(second)} in {options.second}, "
                 f"{len(first.keys() & second.keys())} in both")
    runs = {}
    for key in first:
        runs.setdefault(key[0], []).append(key)
    print("run,windows,accepted,,within 10 %,,beyond 25 %,,rmse,,ratio,from,to,error over sigma,,"
          "p99 ms,")
    found = []
    for run, keys in [*runs.items(), ("all", list(first))]:
        pairs = [(first[key], second[key]) for key in keys]
        before, after = (Side([pair[i] for pair in pairs]) for i in (0, 1))
        ratio, low, high = ratio_interval(pairs)
        found = failures(before, after, low)
        print(f"{run},{len(keys)},{before.accepted},{after.accepted},{before.near:.3f},"
              f"{after.near:.3f},{before.far},{after.far},{before.rmse:.4f},{after.rmse:.4f},"
              f"{ratio:.3f},{low:.3f},{high:.3f},{before.over_sigma:.2f},{after.over_sigma:.2f},"
              f"{before.p99:.1f},{after.p99:.1f},{'; '.join(found)}")
    print("worse: " + "; ".join(found) if found else "nothing got worse")
    return 1 if found else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bound", type=float, default=1e-9)
    parser.add_argument("first")
    parser.add_argument("second")
    options = parser.parse_args()
    if os.path.isdir(options.first):
        return compare_folders(options)
    return compare_files(options)


if __name__ == "__main__":
    sys.exit(main())
