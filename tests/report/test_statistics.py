# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Statistics against values found by hand."""
import glob
import math
import os
import re
import tempfile
import unittest

from handmade import by_hand, row, write_run
from scratch import Scratch, read
from slim_init_report import data, statistics

FAILED = ("invalid_input", "numerical_failure")
SOURCE = os.path.normpath(os.path.join(os.path.dirname(__file__), "../.."))


def load(rows, **info):
    with tempfile.TemporaryDirectory() as folder:
        return data.load_run(write_run(folder, rows, **info))


class ByHand(unittest.TestCase):
    """What program_test.py does not compare with the figures of the program, which are checked by
    hand in tests/evaluation/report_test.cc."""

    def setUp(self):
        self.windows = load(by_hand()).windows
        self.all = statistics.summarize(self.windows)["hand"]

    def test_counts(self):
        for key, value in (("windows", 5), ("attempted", 4), ("success", 3), ("accepted", 3),
                           ("within_0_1", 1), ("within_0_5", 2), ("waiting", 1),
                           ("refused", 1), ("failed", 0)):
            self.assertEqual(self.all[key], value, key)
        self.assertEqual(statistics.stage_times(self.windows), {"hand": {"one": 0.5, "two": 0.25}})

    def test_figures_that_the_program_does_not_have(self):
        p90 = 0.2 * 0.04 + 0.8 * 0.4  # sorted 0.03, 0.04, 0.4: position 1.8
        for key, value in (("success.gravity_error_deg.median", 0.4),
                           ("success.gravity_error_deg.p90", 10.0 * p90),
                           ("success.pose_rmse.median", 0.16), ("success.pose_rmse.p90", 4.0 * p90),
                           ("evaluated.scale_error.median", 0.4),
                           ("accepted.answer_keyframes.median", 10.0),
                           ("within_0_5/accepted", 2.0 / 3.0), ("attempted.solve_ms.median", 2.5),
                           ("attempted.solve_cpu_ms.mean", 2.0),
                           ("attempted.solve_cpu_ms.p90", 0.3 * 1.5 + 0.7 * 5.0)):
            self.assertAlmostEqual(self.all[key], value, 12, key)

    def test_calibration_over_accepted_windows(self):
        rows = [row(0, "m", 1.02, scale_sigma=0.01, td_error_ms=3.0, td_sigma_ms=2.0,
                    rotation_error_deg=0.4, rotation_over_sigma=0.5, readout_error_ms=1.0),
                row(1, "m", 1.01, scale_sigma=0.01, td_error_ms=-4.0, td_sigma_ms=4.0,
                    rotation_error_deg=0.3),
                row(2, "m", 1.0, "scale_too_uncertain", td_error_ms=99.0, td_sigma_ms=1.0,
                    rotation_error_deg=99.0, readout_error_ms=99.0)]
        summary = statistics.summarize(load(rows).windows)["m"]
        for key, value in (("scale_error/scale_sigma.rmse", math.sqrt((2.0 ** 2 + 1.0 ** 2) / 2.0)),
                           ("td_error_ms.rmse", math.sqrt((9.0 + 16.0) / 2.0)),
                           ("td_error_ms/td_sigma_ms.rmse", math.sqrt((1.5 ** 2 + 1.0 ** 2) / 2.0)),
                           ("rotation_error_deg.rmse", math.sqrt((0.16 + 0.09) / 2.0)),
                           ("rotation_over_sigma.rmse", 0.5), ("readout_error_ms.rmse", 1.0)):
            self.assertAlmostEqual(summary["evaluated." + key], value, 12, key)
        self.assertTrue(math.isnan(self.all["evaluated.td_error_ms.rmse"]))  # nobody estimated it

    def test_statuses_add_up_to_all_windows(self):
        counts = statistics.statuses(self.windows).loc["hand"]
        self.assertEqual(dict(counts), {"scale_too_uncertain": 1, "success": 3,
                         "too_few_tracks": 1})
        self.assertEqual(sum(self.all[key] for key in ("accepted", "waiting", "refused",
                         "failed")), 5)


class Special(unittest.TestCase):
    def test_every_refusal_and_wait_is_counted(self):
        names = statistics.WAITING + statistics.REFUSED + FAILED
        rows = [row(i, "m", None, name) for i, name in enumerate(names)]
        s = statistics.summarize(load(rows).windows)["m"]
        self.assertEqual((s["windows"], s["waiting"], s["refused"], s["failed"]), (12, 7, 3, 2))
        self.assertEqual(s["success/windows"], 0.0)

    def test_statuses_are_those_of_the_library(self):
        files = glob.glob(os.path.join(SOURCE, "slim_init/src/*/result.cc"))
        self.assertEqual(len(files), 1)
        source = read(files[0])
        rows = re.findall(r'\{"(\w+)", Kind::k(\w+),', source)
        self.assertEqual(rows.pop()[0], "unknown")

        def kind(wanted):
            return {name for name, kind in rows if kind == wanted}
        self.assertEqual(set(statistics.WAITING), kind("Wait"))
        self.assertEqual(set(statistics.REFUSED), kind("Refused"))
        self.assertEqual({"success"} | set(FAILED), kind("Other"))
        # The compiler does not see the order of the names.
        header = read(os.path.join(SOURCE, "slim_init/include/slim_init/result.h"))

        def enumerators(name):
            begin = header.index("enum class %s {" % name)
            found = re.findall(r"^  k(\w+),", header[begin:header.index("};", begin)], re.MULTILINE)
            return [re.sub(r"(?<!^)([A-Z])", r"_\1", one).lower() for one in found]
        self.assertEqual([name for name, _ in rows], enumerators("InitStatus"))
        begin = source.index("kGates[]")
        gates = re.findall(r'"(\w+)"', source[begin:source.index("};", begin)])
        self.assertEqual(gates, enumerators("GateName") + ["unknown"])

    def test_numbers_that_do_not_exist(self):
        s = statistics.summarize(load([row(0, "m", None, "stationary")]).windows)["m"]
        for key in ("success.scale_error.rmse", "success.scale_error.median",
                    "success.gravity_error_deg.p90", "success.pose_rmse.rmse",
                    "attempted.solve_cpu_ms.mean",
                    "within_0_1/accepted", "diverged/downstream"):
            self.assertTrue(math.isnan(s[key]), key)
        # A method without a window, and no window at all.
        windows = load([row(0, "m", None, "stationary")]).windows
        s = statistics.summarize(windows[windows["excited"] & False], ["m"])["m"]
        self.assertEqual((s["windows"], s["accepted"]), (0, 0))
        self.assertTrue(math.isnan(s["success/windows"]))

    def test_without_truth_there_are_no_rates(self):
        rows = [dict(row(i, "m", 1.0), scale="", scale_error="", success=0) for i in range(3)]
        s = statistics.summarize(load(rows, has_truth=False).windows)["m"]
        self.assertTrue(math.isnan(s["success/windows"]))
        self.assertTrue(math.isnan(s["within_0_1/accepted"]))
        self.assertEqual(s["accepted"], 3)

    def test_downstream_runs_of_accepted_answers(self):
        rows = [row(i, "m", 1.0, downstream=int(i < 4), downstream_diverged=int(i == 3),
                    downstream_ate=0.1 * (i + 1)) for i in range(6)]
        s = statistics.summarize(load(rows).windows)["m"]
        self.assertEqual((s["downstream"], s["diverged"]), (4, 1))
        self.assertAlmostEqual(s["downstream.downstream_ate.median"], 0.25)
        self.assertAlmostEqual(s["downstream.downstream_ate.p90"], 0.37)

    def test_several_runs_together(self):
        one = load(by_hand()).windows
        two = load([row(i, "other", 1.1) for i in range(2)]).windows
        together = data.pandas.concat([one, two, one.assign(run="again")], ignore_index=True)
        s = statistics.summarize(together)
        self.assertEqual(list(s), ["hand", "other"])
        self.assertEqual((s["hand"]["windows"], s["other"]["windows"]), (10, 2))
        self.assertAlmostEqual(s["hand"]["success.scale_error.rmse"],
                               statistics.summarize(one)["hand"]["success.scale_error.rmse"])


class BadFolders(Scratch):
    def refused(self, folder, part):
        with self.assertRaises(data.InputError) as caught:
            data.load_run(folder)
        self.assertIn(part, str(caught.exception))

    def test_messages_name_the_file(self):
        self.refused(self.path("none"), "summary.json: No such file")
        write_run(self.folder, by_hand())
        self.write("summary.json", "{")
        self.refused(self.folder, "cannot be read")
        write_run(self.folder, by_hand())
        self.write("windows.csv", "dataset,method\nx,y\n")
        self.refused(self.folder, "lacks the column")


if __name__ == "__main__":
    unittest.main()
