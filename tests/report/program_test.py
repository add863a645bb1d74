# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The program and the package together: SLIM_INIT_PROGRAM names the program."""
import math
import os
import unittest

from scratch import Scratch, run_to_end
from slim_init_report import data, statistics

PROGRAM = os.environ["SLIM_INIT_PROGRAM"]


# What summary.json calls otherwise than statistics.Summary.
OURS = {"%s_%s" % (key, what): "%s.%s.%s" % (windows, column, what)
        for key, windows, column in (
            ("scale", "success", "scale_error"), ("velocity", "success", "velocity_rmse"),
            ("velocity_vec", "success", "velocity_vec_rmse"), ("pose", "success", "pose_rmse"),
            ("accepted_scale", "evaluated", "scale_error"), ("accept_s", "accepted", "answer_s"),
            ("right_s", "within_0_1", "answer_s"), ("downstream_ate", "downstream", "downstream_ate"),
            ("downstream_scale", "downstream", "downstream_scale_error"),
            ("solve_cpu_ms", "attempted", "solve_cpu_ms"))
        for what in ("rmse", "median", "p90")}
OURS.update({
    "success_rate": "success/windows", "gravity_rmse_deg": "success.gravity_error_deg.rmse",
    "gyro_bias_err_pct": "success.gyro_bias_err_pct.rmse", "accepted_rate": "accepted/windows",
    "accepted_beyond_0_25": "beyond_0_25", "accepted_within_0_1_rate": "within_0_1/accepted",
    "accepted_scale_error_max": "evaluated.scale_error.max",
    "accepted_scale_over_sigma": "evaluated.scale_error/scale_sigma.rmse",
    "accepted_td_rmse_ms": "accepted.td_error_ms.rmse",
    "accepted_td_over_sigma": "accepted.td_error_ms/td_sigma_ms.rmse",
    "accepted_rotation_rmse_deg": "accepted.rotation_error_deg.rmse",
    "accepted_rotation_over_sigma": "accepted.rotation_over_sigma.rmse",
    "accepted_readout_rmse_ms": "accepted.readout_error_ms.rmse",
    "right_rate": "within_0_1/windows", "downstream_runs": "downstream",
    "downstream_diverged": "diverged", "downstream_divergence_rate": "diverged/downstream"})


class Program(Scratch):
    def setUp(self):
        super().setUp()
        self.out = self.path("out")

    def run_program(self, *arguments, **more):
        return run_to_end(PROGRAM, *arguments, **more)

    def ab(self, *more, **environment):
        return self.run_program("ab", "--builtin", "corridor-walk", "--world", "corridor",
                                "--duration", "10", "--points", "12", "--outliers", "0.1",
                                "--keyframes", "10",
                                "--methods", "slim,slim-paper,drt-l", "--out", self.out, *more,
                                **environment)

    def test_ab_leaves_a_report(self):
        run = self.ab()
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertIn("Report: %s/report.md" % self.out, run.stdout)
        for name in ("report.md", "report.html", "windows.csv", "summary.json", "error_cdf.png"):
            self.assertGreater(os.path.getsize(os.path.join(self.out, name)), 1000, name)
        self.assertIn("slim_init ab --builtin corridor-walk", self.text_of("out/report.md"))

    def test_without_the_modules_there_is_a_line_and_the_data(self):
        # A python that has none of them, and no other in reach.
        python = self.write("bin/python3", "#!/bin/sh\nexit 3\n", 0o755)
        # /usr/bin/python3 cannot be covered up without a mount of our own.
        if run_to_end("unshare", "-rm", "true").returncode != 0:
            self.skipTest("no unshare")
        run = run_to_end(
            "unshare", "-rm", "sh", "-c", 'mount --bind "$0" /usr/bin/python3 && exec "$@"', python,
            PROGRAM, "ab", "--builtin", "circle", "--duration", "4", "--methods", "drt-l",
            "--keyframes", "10", "--out", self.out,
            env=dict(os.environ, PATH=self.path("bin") + ":/bin:/usr/bin"))
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stderr.count("\n"), 1)
        self.assertIn("slim_init: note: no report: no python3 with pandas, matplotlib and jinja2 was "
                      "found (packages python3-pandas, python3-matplotlib, python3-jinja2); "
                      "`slim_init report %s` writes it later" % self.out, run.stderr)
        self.assertIn("Data: %s/summary.json" % self.out, run.stdout)
        self.assertFalse(os.path.exists(os.path.join(self.out, "report.md")))

    def test_report_of_several_runs(self):
        self.assertEqual(self.ab("--report", "off", "--ablation").returncode, 0)
        self.assertFalse(os.path.exists(os.path.join(self.out, "report.md")))
        together = self.path("to gether")
        run = self.run_program("report", "--suite", self.out, "--out", together)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        text = self.text_of("to gether/report.md")
        self.assertIn("## Table IV, ablation", text)
        self.assertIn("without both line residuals", text)
        run = self.run_program("report", self.path("none"))
        self.assertEqual(run.returncode, 2)
        self.assertIn("summary.json", run.stderr)
        self.assertIn("--suite", self.run_program("report", "--help").stdout)

    def test_both_compute_the_same_statistics(self):
        self.assertEqual(self.ab("--report", "off", "--gates", "on").returncode, 0)
        run = data.load_run(self.out)
        self.assertEqual(len(run.info["methods"]), 3)
        for subset, windows in (("all", run.windows),
                                ("excited", run.windows[run.windows["excited"]])):
            summaries = statistics.summarize(windows, data.methods_of(run.windows))
            for method, written in run.info["methods"].items():
                figures = written[subset]
                self.assertGreater(len(figures), 30)
                for key in set(figures) - {"statuses"}:
                    ours, theirs = summaries[method][OURS.get(key, key)], figures[key]
                    if theirs is None:
                        self.assertTrue(math.isnan(ours), key)
                    else:
                        self.assertAlmostEqual(ours, theirs, delta=1e-7 * abs(theirs) + 1e-12,
                                               msg=key)


if __name__ == "__main__":
    unittest.main()
