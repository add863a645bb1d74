#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Tests of compare_answers.py on planted windows: nothing changed, and each criterion failed."""
import csv
import io
import os
import sys
import unittest
from contextlib import redirect_stdout

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import compare_answers  # noqa: E402
from scratch import Scratch  # noqa: E402

FIELDS = ["t_start_ns", "method", "status", "scale_error", "scale_sigma", "solve_cpu_ms"]
WINDOWS = 200


def windows(change=None):
    rows = []
    for i in range(WINDOWS):
        row = {"t_start_ns": i, "method": "slim", "status": "success",
               "scale_error": 0.04 * (-1) ** i, "scale_sigma": 0.04, "solve_cpu_ms": 5.0}
        if change:
            change(i, row)
        rows.append(row)
        rows.append(dict(row, method="openvins", status="failed"))  # is not compared
    return rows


class CompareFolders(Scratch):
    def compare(self, before, after):
        for name, rows in (("before", before), ("after", after)):
            with open(self.write(name + "/run/windows.csv"), "w", newline="") as file:
                writer = csv.DictWriter(file, FIELDS)
                writer.writeheader()
                writer.writerows(rows)
        options = type("Options", (), {"first": self.path("before"), "second": self.path("after")})
        output = io.StringIO()
        with redirect_stdout(output):
            status = compare_answers.compare_folders(options)
        return status, output.getvalue().splitlines()[-1]

    def check(self, change, expected):
        self.assertEqual(self.compare(windows(), windows(change)), expected)

    def test_the_same_windows(self):
        self.check(None, (0, "nothing got worse"))

    def test_within_the_criteria(self):
        self.check(lambda i, row: row.update(status="stationary") if i == 7 else None,
                   (0, "nothing got worse"))
        self.check(lambda i, row: row.update(scale_error=1.01 * row["scale_error"]),
                   (0, "nothing got worse"))

    def test_each_criterion(self):
        self.check(lambda i, row: row.update(status="stationary") if i < 2 else None,
                   (1, "worse: fewer accepted"))
        self.check(lambda i, row: row.update(scale_error=0.26, scale_sigma=0.3) if i == 7 else None,
                   (1, "worse: more beyond 25 %"))
        self.check(lambda i, row: row.update(scale_error=1.1 * row["scale_error"]),
                   (1, "worse: larger errors"))
        self.check(lambda i, row: row.update(scale_sigma=0.02),
                   (1, "worse: error over sigma outside 0.8 to 1.3"))
        self.check(lambda i, row: row.update(solve_cpu_ms=6.0), (1, "worse: slower"))

    def test_other_windows(self):
        with self.assertRaises(SystemExit):
            self.compare(windows(), windows()[2:])


if __name__ == "__main__":
    unittest.main()
