#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""launch/ab_bag.py without ROS: the copy in shadow mode, the commands it gives, the report."""
import os
import stat
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "launch", "ab_bag.py")
CONFIG = os.path.join(ROOT, "config", "euroc.yaml")
STARTS = """stamp_s,slim_status,stock_tried,stock_success,path_ratio_stock_to_slim
1.5,too_few_keyframes,0,0,
2.0,success,1,0,
2.1,success,1,1,0.25
2.2,success,1,1,0.35
"""


class AbBag(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.out = os.path.join(self.folder.name, "out")
        self.log = os.path.join(self.folder.name, "log")

    def tearDown(self):
        self.folder.cleanup()

    def run_script(self, *words):
        """With programs of ours in place of rosbag and rosrun, which write down their calls."""
        for name in ("rosbag", "rosrun"):
            path = os.path.join(self.folder.name, name)
            with open(path, "w", encoding="utf-8") as file:
                file.write('#!/bin/sh\necho %s "$@" >>"%s"\n' % (name, self.log))
            os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
        environment = dict(os.environ, PATH=self.folder.name + ":" + os.environ["PATH"])
        return subprocess.run([sys.executable, SCRIPT] + list(words) + ["__name:=ab_bag"],
                              env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, check=False)

    def calls(self):
        with open(self.log, encoding="utf-8") as file:
            return file.read().splitlines()

    def test_shadow_copy_differs_in_two_keys_only(self):
        run = self.run_script("shadow", CONFIG, self.out, "echo", "estimator")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stdout, "estimator __name:=ab_bag\n")
        with open(CONFIG, encoding="utf-8") as file:
            before = file.read().splitlines()
        with open(os.path.join(self.out, "shadow.yaml"), encoding="utf-8") as file:
            after = file.read().splitlines()
        self.assertIn('initializer: "shadow"', after)
        self.assertIn('output_path: "%s"' % self.out, after)
        keys = ("initializer:", "output_path:")
        self.assertEqual([line for line in after if not line.startswith(keys)],
                         [line for line in before if not line.startswith(keys)])

    def test_plays_the_topics_of_the_config_and_reports(self):
        os.makedirs(self.out)
        with open(os.path.join(self.out, "slim_init_starts.csv"), "w", encoding="utf-8") as file:
            file.write(STARTS)
        run = self.run_script("run", "some.bag", CONFIG, self.out, "slim,vins", "0.5", "true")
        self.assertEqual(run.returncode, 0, run.stderr)
        play, compare = self.calls()
        self.assertTrue(play.startswith("rosbag play --clock"), play)
        self.assertIn("--rate 0.5 some.bag --topics /imu0 /cam0/image_raw", play)
        self.assertEqual(compare, "rosrun slim_init slim_init ab --bag some.bag --config %s "
                         "--methods slim,vins --out %s" % (CONFIG, os.path.join(self.out, "ab")))
        self.assertIn("4 windows were answered by slim, 3 of them tried by the host", run.stdout)
        self.assertIn("host: 2 accepted, the first at 2.1 s", run.stdout)
        self.assertIn("slim: 3 accepted, the first at 2.0 s", run.stdout)
        self.assertIn("median 0.300 over 2 windows", run.stdout)

    def test_without_host_nothing_is_played(self):
        run = self.run_script("run", "some.bag", CONFIG, self.out, "slim", "1", "false")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(len(self.calls()), 1)

    def test_a_host_that_is_not_patched_is_told(self):
        run = self.run_script("run", "some.bag", CONFIG, self.out, "slim", "1", "true")
        self.assertEqual(run.returncode, 1)
        self.assertIn("is its estimator patched", run.stderr)

    def test_rviz_missing_is_one_sentence(self):
        rviz = os.path.join(ROOT, "launch", "rviz.sh")
        environment = dict(os.environ, PATH=self.folder.name)
        run = subprocess.run(["/bin/sh", rviz, "-d", "some.rviz"], env=environment,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             universal_newlines=True, check=False)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertEqual(run.stdout.count("\n"), 1)
        self.assertIn("rviz is not installed", run.stdout)
        program = os.path.join(self.folder.name, "rviz")
        with open(program, "w", encoding="utf-8") as file:
            file.write('#!/bin/sh\necho drawn "$@"\n')
        os.chmod(program, 0o755)
        run = subprocess.run(["/bin/sh", rviz, "-d", "some.rviz"], env=environment,
                             stdout=subprocess.PIPE, universal_newlines=True, check=False)
        self.assertEqual(run.stdout, "drawn -d some.rviz\n")

    def test_a_missing_file_is_told(self):
        run = self.run_script("shadow", "no.yaml", self.out, "echo")
        self.assertEqual(run.returncode, 1)
        self.assertIn("no.yaml cannot be read", run.stderr)


if __name__ == "__main__":
    unittest.main()
