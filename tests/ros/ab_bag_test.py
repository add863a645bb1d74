#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""launch/ab_bag.py without ROS: the copies of the file, the commands it gives, numbers and report."""
import csv
import io
import math
import os
import re
import shlex
import sys
import unittest
import xml.etree.ElementTree

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "launch", "ab_bag.py")
CONFIG = os.path.join(ROOT, "config", "euroc.yaml")
sys.path.insert(0, os.path.dirname(SCRIPT))
sys.dont_write_bytecode = True
import ab_bag  # noqa: E402
from scratch import Scratch, run_to_end  # noqa: E402

BEGAN = 1000.0
# What stands in for rosbag, rosrun and roslaunch. The "host" of roslaunch writes the odometry that
# lies prepared for its mode, with a moment's delay, and waits to be ended.
PROGRAM = """#!%s
import os, shutil, sys, time
name, folder = os.path.basename(sys.argv[0]), os.path.dirname(os.path.abspath(sys.argv[0]))
with open(os.path.join(folder, "log"), "a") as file:
    file.write(" ".join([name] + sys.argv[1:]) + "\\n")
if name == "rosbag" and sys.argv[1] == "info":
    print("%.1f")
if name == "roslaunch":
    config = [word.split(":=")[1] for word in sys.argv if word.startswith("estimator_config:=")][0]
    out = os.path.dirname(config)
    prepared = os.path.join(folder, os.path.basename(out) + ".odometry")
    if not os.path.exists(prepared):
        sys.exit(7)
    shutil.copy(prepared, os.path.join(out, "vins_result_no_loop.csv"))
    if 'initializer: "slim"' in open(config).read() and not os.path.exists(
            os.path.join(folder, "unpatched")):
        open(os.path.join(out, "slim_init_starts.csv"), "w").close()
    try:
        time.sleep(60)
    except KeyboardInterrupt:
        with open(os.path.join(folder, "log"), "a") as file:
            file.write("ended\\n")
if name == "rosbag" and sys.argv[1] == "play":
    time.sleep(1.0)
""" % (sys.executable, BEGAN)


def way(t):
    return (2.0 * math.cos(t), 3.0 * math.sin(0.7 * t), 0.5 * math.sin(1.3 * t))


def rows(first, last, scale=1.0, yaw=0.0, kick=0.0):
    """Lines of an odometry or of a truth: the way from `first` to `last` s, 20 Hz, scaled, turned,
    with `kick` m added to x in its second half."""
    lines = []
    for k in range(int(20 * first), int(20 * last)):
        t = k / 20.0
        x, y, z = way(t)
        c, s = math.cos(yaw), math.sin(yaw)
        p = (scale * (c * x - s * y) + (kick if t > 0.5 * (first + last) else 0.0),
             scale * (s * x + c * y), scale * z)
        lines.append("%d,%.6f,%.6f,%.6f,1,0,0,0,0,0,0" % ((round((BEGAN + t) * 1e9),) + p))
    return "\n".join(["#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z"] + lines) + "\n"


class AbBag(Scratch):
    def setUp(self):
        super().setUp()
        self.out, self.bag = self.path("out"), self.path("some.bag")
        for name in ("rosbag", "rosrun", "roslaunch"):
            self.write(name, PROGRAM, 0o755)

    def run_script(self, host="true", rate="1", config=CONFIG):
        return run_to_end(sys.executable, SCRIPT, "run", self.bag, config, self.out, "slim,vins",
                          rate, host, "stock", "__name:=ab_bag", timeout=120,
                          env=dict(os.environ, PATH=self.folder + ":" + os.environ["PATH"]))

    def calls(self):
        return self.text_of("log").splitlines()

    def results(self):
        return {row["run"]: row for row in csv.DictReader(io.StringIO(self.text_of("out/ab_bag.csv")))}

    def test_speeds_are_played_to_the_host_that_listens(self):
        for mode in ("stock", "slim"):
            self.write(mode + ".odometry", rows(1, 3))
        run = self.run_script(config=self.write(
            "wheel.yaml", self.text_of(CONFIG) + 'speed_topic: "/wheel"\nmask: "m.png"\n'))
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        played = [call.split("--topics ")[1] for call in self.calls() if "--topics" in call]
        self.assertEqual(played, ["/imu0 /cam0/image_raw", "/imu0 /cam0/image_raw /wheel"])
        # A copy of the file finds what lies beside the file.
        self.assertIn('mask: "%s"\n' % self.path("m.png"), self.text_of("out/slim/host.yaml"))

    def test_two_runs_against_the_truth(self):
        self.write("some.bag.groundtruth.csv", rows(0, 12))
        self.write("stock.odometry", rows(3, 10, scale=0.4, yaw=2.0, kick=1.5))
        # The last line was being written when the host was ended.
        self.write("slim.odometry", rows(1.2, 10, scale=1.05, yaw=-1.0) + "10000000")
        run = self.run_script(rate="0.5")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        calls = self.calls()
        # Host and bag of a run start side by side.
        self.assertEqual([sorted(call.split()[0] for call in part)
                          for part in (calls[:1], calls[1:4], calls[4:7], calls[7:])],
                         [["rosbag"]] + 2 * [["ended", "rosbag", "roslaunch"]] + [["rosrun"]])
        self.assertEqual((calls[3], calls[6]), ("ended", "ended"))
        self.assertEqual(sum("tracker:=stock rviz:=false" in call for call in calls), 2)
        self.assertEqual(sum("--rate 0.5 %s --topics /imu0 /cam0/image_raw" % self.bag in call
                             for call in calls), 2)
        for mode in ("stock", "slim"):
            before = self.text_of(CONFIG).splitlines()
            after = self.text_of("out/%s/host.yaml" % mode).splitlines()
            self.assertIn('initializer: "%s"' % mode, after)
            self.assertIn('output_path: "%s"' % os.path.join(self.out, mode), after)
            self.assertIn("reinit: %d" % (mode == "slim"), after)
            keys = ("initializer:", "output_path:", "reinit:")
            self.assertEqual([line for line in after if not line.startswith(keys)],
                             [line for line in before if not line.startswith(keys)])
        self.assertEqual(calls[-1], "rosrun slim_init slim_init ab --bag %s --config %s --methods "
                         "slim,vins --out %s" % (self.bag, CONFIG, os.path.join(self.out, "ab")))
        stock, slim = self.results()["stock"], self.results()["slim"]
        # Seconds since the bag's start, not since 1970.
        self.assertEqual((stock["first odometry [s]"], slim["first odometry [s]"]), ("3.00", "1.20"))
        self.assertEqual((stock["frames"], slim["frames"]), ("140", "176"))
        self.assertEqual((stock["scale, first 2 s"], slim["scale, first 2 s"]), ("0.400", "1.050"))
        self.assertEqual(slim["scale, whole run"], "1.050")
        self.assertGreater(float(stock["largest error [m]"]), 1.0)
        self.assertLess(float(slim["ATE [m]"]), 0.15)
        self.assertIn("stock started after 3.00 s with a scale of 0.400, incorrect, and drifted",
                      run.stdout)
        self.assertIn("slim started after 1.20 s with a scale of 1.050, 5 % off, and did not "
                      "drift", run.stdout)
        self.assertIn("slim was closer to the ground truth", run.stdout)
        self.assertIn("<th>ATE [m]</th>", self.text_of("out/ab_bag.html"))

    def test_without_truth_start_times_are_reported(self):
        self.write("stock.odometry", "")
        self.write("slim.odometry", rows(1.2, 10))
        run = self.run_script()
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertIn("stock never gave odometry.", run.stdout)
        self.assertIn("slim gave odometry after 1.20 s.", run.stdout)
        self.assertIn("only start times are reported", run.stdout)
        self.assertEqual(self.results()["slim"]["ATE [m]"], "-")
        self.assertNotIn("closer", run.stdout)

    def test_numbers_of_a_known_odometry(self):
        truth = np.array([(0.05 * k,) + way(0.05 * k) for k in range(200)])
        t, x, y, z = truth.T
        result = ab_bag.measured(np.array([t, -y + 1.0, x - 2.0, z]).T, truth, -5.0)
        self.assertAlmostEqual(result["first_s"], 5.0)
        self.assertLess(result["ate_m"], 1e-9)
        self.assertAlmostEqual(result["scale"], 1.0)
        self.assertAlmostEqual(result["scale_run"], 1.0)
        shrunk = truth * [1.0, 0.25, 0.25, 0.25]
        self.assertAlmostEqual(ab_bag.measured(shrunk, truth, 0.0)["scale"], 0.25)
        # A tilt is no heading: it stays as an error.
        self.assertGreater(ab_bag.measured(np.array([t, x, z, -y]).T, truth, 0.0)["ate_m"], 0.5)
        # Truth that covers nothing, and a gap in it.
        self.assertIsNone(ab_bag.measured(truth, truth + [90.0, 0.0, 0.0, 0.0], 0.0)["scale"])
        self.assertTrue(np.isnan(ab_bag.at(truth, np.array([20.0]))).all())
        known = np.isfinite(ab_bag.at(truth[::9], np.array([0.0, 0.2, 0.45])))
        self.assertEqual(known[:, 0].tolist(), [True, False, True])

    def test_without_host_nothing_is_played(self):
        run = self.run_script(host="false")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(len(self.calls()), 1)

    def test_a_host_that_is_not_patched_is_told(self):
        self.write("unpatched", "")
        self.write("stock.odometry", rows(1, 2))
        self.write("slim.odometry", rows(1, 2))
        run = self.run_script()
        self.assertEqual(run.returncode, 1)
        self.assertIn("is its estimator patched", run.stderr)
        self.assertEqual(self.calls()[-1], "ended")

    def test_arguments_of_the_launch_file_may_have_spaces(self):
        launch = xml.etree.ElementTree.parse(os.path.join(ROOT, "launch", "ab_bag.launch"))
        filled = re.sub(r"\$\(arg (\w+)\)", r"/my folder/it's \1", launch.find("node").get("args"))
        names = ("bag", "config", "out", "methods", "rate", "host", "tracker")
        self.assertEqual(shlex.split(filled),  # as roslaunch does
                         ["run"] + ["/my folder/it's " + name for name in names])

    def test_a_host_that_dies_is_told(self):
        run = self.run_script()
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"the host ended with 7; see .*stock/roslaunch.log")

    def test_rviz_missing_is_one_sentence(self):
        def rviz():
            return run_to_end("/bin/sh", os.path.join(ROOT, "launch", "rviz.sh"), "-d", "some.rviz",
                              env=dict(os.environ, PATH=self.folder))
        run = rviz()
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(run.stdout.count("\n"), 1)
        self.assertIn("rviz is not installed", run.stdout)
        self.write("rviz", '#!/bin/sh\necho drawn "$@"\n', 0o755)
        self.assertEqual(rviz().stdout, "drawn -d some.rviz\n")

    def test_a_missing_file_is_told(self):
        run = self.run_script(config="no.yaml")
        self.assertEqual(run.returncode, 1)
        self.assertIn("no.yaml cannot be read", run.stderr)


if __name__ == "__main__":
    unittest.main()
