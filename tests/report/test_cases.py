# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Which runs the suite makes, and with which arguments."""
import os
import sys
import unittest

from scratch import Scratch

SUITE = os.path.normpath(os.path.join(os.path.dirname(__file__), "../../slim_init/evaluation/suite"))
sys.path.insert(0, SUITE)
import cases as suite  # noqa: E402

SIMULATED = ["simulated/corridor-walk", "simulated/constant-velocity-12",
             "simulated/constant-velocity", "simulated/pure-rotation", "simulated/hover",
             "simulated/circle", "simulated/figure-eight"]


def option(case, name):
    """The value after --name, or None."""
    return case.arguments[case.arguments.index("--" + name) + 1] if "--" + name in case.arguments \
        else None


class Cases(Scratch):
    def cases(self, **config):
        found, notes = suite.list_cases(dict(config))
        return {case.name: case for case in found}, notes

    def refused(self, part, **config):
        with self.assertRaises(suite.ConfigError) as caught:
            suite.list_cases(dict(config))
        self.assertIn(part, str(caught.exception))

    def test_motions_are_always_there(self):
        found, notes = self.cases()
        self.assertEqual(list(found), SIMULATED + ["ablation/simulated/corridor-walk",
                                                   "ablation/simulated/constant-velocity-12"])
        self.assertEqual(notes, [])
        walk = found["simulated/corridor-walk"]
        self.assertEqual(walk.arguments, [
            "--builtin", "corridor-walk", "--world", "corridor", "--points", "12", "--outliers",
            "0.03", "--drift", "0.04", "--seed", "1", "--keyframes", "10"])
        ablation = found["ablation/simulated/corridor-walk"]
        self.assertEqual(option(ablation, "methods"), "slim,slim-paper")
        self.assertIn("--ablation", ablation.arguments)

    def test_growing_windows(self):
        self.assertFalse([name for name in self.cases()[0] if name.startswith("growing/")])
        found, _ = self.cases(growing=True, downstream=5)
        self.assertEqual([name for name in found if name.startswith("growing/")],
                         ["growing/" + name.replace("/", "-") for name in SIMULATED])
        case = found["growing/simulated-circle"]
        self.assertIsNone(option(case, "keyframes"))
        self.assertEqual(option(case, "downstream"), "5")
        self.assertEqual(option(found["simulated/circle"], "keyframes"), "10")

    def test_options_reach_every_run(self):
        found, _ = self.cases(methods="slim-paper,drt-l", stride=20, limit=7, seed=3, threads=2,
                              downstream=10, gates="on", options="o.yaml")
        walk = found["simulated/corridor-walk"]
        for name, value in (("methods", "slim-paper,drt-l"), ("stride", "20"), ("limit", "7"),
                            ("seed", "3"), ("threads", "2"), ("downstream", "10"),
                            ("gates", "on"), ("options", "o.yaml")):
            self.assertEqual(option(walk, name), value)
        ablation = found["ablation/simulated/corridor-walk"]
        self.assertEqual(option(ablation, "methods"), "slim-paper")
        self.assertIsNone(option(ablation, "downstream"))

    def test_quick(self):
        for value in (True, "true", 1):
            walk = self.cases(quick=value)[0]["simulated/circle"]
            self.assertEqual((option(walk, "limit"), option(walk, "duration")), ("5", "10"))
        self.assertEqual(option(self.cases(quick=True, limit=2)[0]["simulated/circle"], "limit"), "2")
        self.assertIsNone(option(self.cases(quick="false")[0]["simulated/circle"], "limit"))

    def test_without_variants_there_is_no_ablation(self):
        found, notes = self.cases(methods="drt-l")
        self.assertEqual(list(found), SIMULATED)
        self.assertEqual(notes, ["no ablation: none of the methods has variants"])

    def test_recordings_without_images(self):
        imu = self.write("MH_03/imu0.csv")
        self.write("V1_01/imu0.csv")
        self.write("papers/read.me")
        found, notes = self.cases(recorded=self.folder)
        self.assertEqual(list(found)[:2], ["recorded/MH_03", "recorded/V1_01"])
        self.assertIn("ablation/recorded/MH_03", found)
        self.assertEqual(notes, ["recorded: papers has no imu0.csv and was skipped"])
        hall = found["recorded/MH_03"]
        self.assertEqual(option(hall, "recorded"), os.path.dirname(imu))
        self.assertEqual(option(hall, "world"), "hall")
        self.assertEqual(option(found["recorded/V1_01"], "world"), "room")
        self.assertEqual(hall.inputs[0], imu)
        self.assertEqual(len(hall.inputs), 3)

    def test_sequences_of_euroc_by_name(self):
        table = self.write("machine_hall/MH_01_easy/mav0/imu0/data.csv")
        self.write("machine_hall/MH_01_easy/mav0/cam0/data.csv")
        bag = self.write("vicon/V2_01_easy/V2_01_easy.bag")
        self.refused("V2_01_easy.bag is a bag and needs config=YAML", euroc=self.folder)
        found, notes = self.cases(euroc=self.folder, config="rig.yaml")
        self.assertEqual(list(found)[:2], ["images/MH_01", "images/V2_01"])
        folder = found["images/MH_01"]
        self.assertEqual(folder.arguments[:2], ["--asl", table[:-len("/mav0/imu0/data.csv")]])
        self.assertEqual(folder.inputs[0], table)
        self.assertIsNone(option(folder, "config"))
        self.assertIsNone(option(folder, "seed"))  # has no effect with images
        self.assertEqual(found["images/V2_01"].arguments[:4], ["--bag", bag, "--config", "rig.yaml"])
        self.assertIn("ablation/images/V2_01", found)
        self.assertEqual(len(notes), 1)
        self.assertIn("euroc: not found: MH_02_easy, MH_03_medium", notes[0])

    def test_a_choice_of_cases(self):
        found, notes = self.cases(cases="simulated/c*,ablation/*walk")
        self.assertEqual(list(found), ["simulated/corridor-walk", "simulated/constant-velocity-12",
                                       "simulated/constant-velocity", "simulated/circle",
                                       "ablation/simulated/corridor-walk"])
        self.assertEqual(notes, ["only the cases simulated/c*, ablation/*walk"])
        self.refused("cases: 'circle' is none of simulated/", cases="circle")

    def test_bad_folders(self):
        none = self.path("none")
        self.refused("recorded: there is no folder", recorded=none)
        self.refused("euroc: there is no folder", euroc=none)
        self.refused("holds a recording (imu0.csv)", recorded=self.folder)
        self.refused("none of EuRoC's sequences", euroc=self.folder)
        self.write("imu0.csv")
        self.refused("name the folder above", recorded=self.folder)

    def test_the_program(self):
        program = self.write("build/bin/slim_init")
        folder = self.path("slim_init/evaluation/suite")
        os.chmod(program, 0o755)
        self.assertEqual(suite.find_program({}, folder), program)
        self.assertEqual(suite.find_program({"program": program}, "/"), program)
        os.chmod(program, 0o644)
        with self.assertRaises(suite.ConfigError):
            suite.find_program({"program": program}, folder)


if __name__ == "__main__":
    unittest.main()
