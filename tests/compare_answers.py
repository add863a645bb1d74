#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Compares the answers of two builds, as `slim_init_bench count --answers` writes them.

Prints the largest relative difference of every quantity and method. Ends with 1 where one is
beyond the bound, or where a window has another status.
"""
import argparse
import csv
import math
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bound", type=float, default=1e-9)
    parser.add_argument("first")
    parser.add_argument("second")
    options = parser.parse_args()
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


if __name__ == "__main__":
    sys.exit(main())
