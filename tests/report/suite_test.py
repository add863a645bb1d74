# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The suite under Snakemake: SLIM_INIT_PROGRAM names the program, SLIM_INIT_SNAKEMAKE the engine."""
import os
import subprocess
import unittest

from scratch import Scratch, run_to_end

PROGRAM, SNAKEMAKE = os.environ["SLIM_INIT_PROGRAM"], os.environ["SLIM_INIT_SNAKEMAKE"]
SNAKEFILE = os.path.normpath(os.path.join(os.path.dirname(__file__),
                                          "../../slim_init/evaluation/suite/Snakefile"))
CASES = ["simulated/circle", "ablation/simulated/corridor-walk"]


class Suite(Scratch):
    def snakemake(self, *arguments, **config):
        settings = dict({"program": PROGRAM, "quick": "true", "limit": 2, "out": "out dir",
                         "methods": "slim-paper,drt-l", "cases": ",".join(CASES)}, **config)
        run = run_to_end(
            SNAKEMAKE, "-s", SNAKEFILE, "--cores", "2", "--nocolor", *arguments, "--config",
            *["%s=%s" % item for item in settings.items()], cwd=self.folder,
            stderr=subprocess.STDOUT,
            env=dict(os.environ, HOME=self.folder, XDG_CACHE_HOME=self.path("cache")))
        return run.returncode, run.stdout

    def test_a_dry_run_lists_every_case(self):
        code, text = self.snakemake("-n", cases="")
        self.assertEqual(code, 0, text)
        for case in ("simulated/hover", "simulated/figure-eight",
                     "ablation/simulated/constant-velocity-12"):
            self.assertIn("wildcards: case=%s\n" % case, text)
        self.assertFalse(os.path.exists(self.path("out dir")))

    def test_bad_configuration_is_one_line(self):
        code, text = self.snakemake("-n", recorded=self.path("none"))
        self.assertNotEqual(code, 0)
        self.assertIn("slim_init suite: recorded: there is no folder", text)
        self.assertNotIn("Traceback", text)

    def test_runs_goes_on_and_does_nothing_twice(self):
        code, text = self.snakemake()
        self.assertEqual(code, 0, text)
        for case in CASES:
            for name in ("windows.csv", "summary.json", "report.md", "report.html", "log.txt"):
                self.assertTrue(os.path.exists(self.path("out dir/%s/%s" % (case, name))), case)
        report = self.text_of("out dir/report.md")
        for part in ("snakemake -s slim_init/evaluation/suite/Snakefile --config",
                     "| simulated/circle | Excited |", "## Table IV, ablation",
                     "| circle | drt-l | 2 |", "slim-paper[no-lines]",
                     "- only the cases simulated/circle, ablation/simulated/corridor-walk"):
            self.assertIn(part, report)
        code, text = self.snakemake()
        self.assertEqual(code, 0, text)
        self.assertIn("Nothing to be done", text)
        # Interrupted: one run is not there; the other one stays as it is.
        kept = self.path("out dir/%s/windows.csv" % CASES[0])
        before = os.stat(kept).st_mtime_ns
        os.remove(self.path("out dir/%s/windows.csv" % CASES[1]))
        code, text = self.snakemake()
        self.assertEqual(code, 0, text)
        self.assertTrue(os.path.exists(self.path("out dir/%s/windows.csv" % CASES[1])))
        self.assertEqual(os.stat(kept).st_mtime_ns, before)

    def test_a_case_that_fails_is_named_and_the_others_are_run(self):
        for name in ("imu0.csv", "cam0_timestamps.csv", "groundtruth.csv"):
            self.write("data/V1_01/" + name, "#nothing\n")
        code, text = self.snakemake("--keep-going", recorded="data",
                                    cases="recorded/V1_01,simulated/circle")
        self.assertNotEqual(code, 0)
        self.assertIn("recorded/V1_01/log.txt", text)
        self.assertIn("slim_init: ", self.text_of("out dir/recorded/V1_01/log.txt"))
        self.assertTrue(os.path.exists(self.path("out dir/simulated/circle/report.html")))


if __name__ == "__main__":
    unittest.main()
