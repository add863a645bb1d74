#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""launch/fault_bag.py without a host: each fault on a made-up stream, the judge on made-up
odometries whose errors are known, and both through real bags."""
import json
import math
import os
import sys
import unittest

import genmsg
import genpy
import genpy.dynamic
import numpy as np
import rosbag
import rospkg

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "launch"))
sys.dont_write_bytecode = True
import fault_bag  # noqa: E402
from scratch import Scratch, read  # noqa: E402

BEGAN = 1000.0
# What ros-std-msgs and ros-geometry-msgs do not have: the layout of ROS, as far as it is read here.
DEFINITIONS = {
    "sensor_msgs/Imu": "Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] a\n"
    "geometry_msgs/Vector3 angular_velocity\nfloat64[9] b\n"
    "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] c",
    "sensor_msgs/Image": "Header header\nuint32 height\nuint32 width\nstring encoding\n"
    "uint8 is_bigendian\nuint32 step\nuint8[] data",
    "std_msgs/String": "string data",
    "nav_msgs/Odometry": "Header header\nstring child_frame_id\n"
    "geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist"}


def message_class(name):
    """With the definitions of what it contains, which are those of ROS."""
    folders = {package: [os.path.join(rospkg.RosPack().get_path(package), "msg")]
               for package in ("geometry_msgs", "std_msgs")}
    context = genmsg.MsgContext.create_default()
    spec = genmsg.msg_loader.load_msg_from_string(context, DEFINITIONS[name], name)
    genmsg.load_depends(context, spec, folders)
    return genpy.dynamic.generate_dynamic(name, genmsg.compute_full_text(context, spec))[name]


CLASSES = {name: message_class(name) for name in DEFINITIONS}


def path(t):
    return np.array([2.0 * math.cos(t), 3.0 * math.sin(0.7 * t), 0.5 * math.sin(1.3 * t)])


def velocity(t):
    return np.array([-2.0 * math.sin(t), 2.1 * math.cos(0.7 * t), 0.65 * math.cos(1.3 * t)])


def turned(yaw, v):
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


TRUTH = np.array([[0.005 * k] + list(path(0.005 * k)) +
                  [math.cos(0.05 * k * 0.005), 0.0, 0.0, math.sin(0.05 * k * 0.005)]
                  for k in range(4001)])


def odometry(error, late=lambda t: 0.05, first=1.0, last=19.0, yaw=0.5, missing=()):
    """Rows of an odometry whose world is turned by -`yaw`; `error`(t): position [m], yaw [rad] of
    the frame since then, velocity [m/s]."""
    rows = []
    for k in range(int(10 * first), int(10 * last)):
        t = 0.1 * k
        if any(a <= t < b for a, b in missing):
            continue
        shift, turn, off = error(t)
        p = turned(-yaw - turn, path(t)) + [shift, 0.0, 0.0]
        v = turned(-yaw - turn, velocity(t)) + [0.0, off, 0.0]
        half = 0.5 * (0.1 * t - yaw - turn)
        rows.append([t, t + late(t)] + list(p) + [math.cos(half), 0.0, 0.0, math.sin(half)] + list(v))
    return np.array(rows)


def flight(error, health=(), frame=(), **more):
    return fault_bag.Flight(odometry(error, **more), TRUTH, list(health),
                            np.array(frame).reshape(-1, 4))


EVENT = fault_bag.event_of("frozen:1@8")


class Events(unittest.TestCase):
    def test_words(self):
        one = fault_bag.event_of("noise:8,0.5:2@9.5")
        self.assertEqual((one["kind"], one["sizes"], one["at"], one["seconds"]),
                         ("noise", [8.0, 0.5], 9.5, 2.0))
        self.assertEqual(one["name"], "noise:8,0.5:2")
        for word in ("noise:8:2@9", "storm:1@2", "frozen:1", "frozen:0@1", "frozen:x@1"):
            with self.assertRaises(SystemExit, msg=word):
                fault_bag.event_of(word)

    def test_imu(self):
        def sent(word, t, k=0):
            faults = fault_bag.Faults([fault_bag.event_of(word)])
            result = None
            for _ in range(k + 1):  # earlier samples of the stream
                result = faults.imu(t, np.array([1.0, -20.0, 9.8]), np.array([0.1, -3.0, 0.0]))
            return result
        accel, gyro = sent("accel:15:0.5@2", 2.4)
        np.testing.assert_allclose(np.r_[accel, gyro], [16.0, -20.0, 9.8, 0.1, -3.0, 0.0])
        np.testing.assert_allclose(sent("gyro:3:0.5@2", 2.0)[1], [0.1, 0.0, 0.0])
        accel, gyro = sent("clip:5,1:0.5@2", 2.0)
        np.testing.assert_allclose(np.r_[accel, gyro], [1.0, -5.0, 5.0, 0.1, -1.0, 0.0])
        for t in (1.99, 2.5):
            np.testing.assert_allclose(sent("accel:15:0.5@2", t)[0], [1.0, -20.0, 9.8])
        self.assertIsNone(sent("no-imu:1@2", 2.5))
        self.assertIsNone(sent("nothing:1@2", 2.5))
        self.assertIsNotNone(sent("no-images:1@2", 2.5))
        noise = fault_bag.Faults([fault_bag.event_of("noise:8,0.5:9@0")])
        drawn = np.array([np.r_[noise.imu(0.001 * k, np.zeros(3), np.zeros(3))]
                          for k in range(3000)])
        np.testing.assert_allclose(np.std(drawn.reshape(3000, 2, 3), axis=(0, 2)), [8.0, 0.5],
                                   rtol=0.05)
        frozen = fault_bag.Faults([fault_bag.event_of("frozen:1@1")])
        sizes = [frozen.imu(t, np.full(3, t), np.zeros(3))[0][0] for t in (0.9, 1.0, 1.9, 2.0)]
        self.assertEqual(sizes, [0.9, 0.9, 0.9, 2.0])

    def test_images(self):
        pixels = np.arange(120 * 200, dtype=np.uint32).astype(np.uint8).reshape(120, 200)

        def sent(word, t):
            return fault_bag.Faults([fault_bag.event_of(word)]).image(t, pixels)
        self.assertIsNone(sent("no-images:1@2", 2.5))
        self.assertIsNone(sent("nothing:1@2", 2.5))
        self.assertTrue(np.all(sent("blank:1@2", 2.5) == 128))
        np.testing.assert_array_equal(sent("upside-down:1@2", 2.5), pixels[::-1, ::-1])
        np.testing.assert_array_equal(sent("blank:1@2", 3.0), pixels)
        faults = fault_bag.Faults([fault_bag.event_of("texture:0.7,20:9@0")])
        before = faults.image(0.0, pixels).astype(float)
        self.assertGreater(np.std(before[:, :140]), 15.0)
        np.testing.assert_array_equal(before[:, 140:], pixels[:, 140:])
        # A second later by 20 px along (2, 1).
        after = faults.image(1.0, pixels).astype(float)
        moved = np.roll(np.roll(faults.texture, 18, 1), 9, 0)
        self.assertLess(np.median(np.abs(after - moved)[:, :140]), 4.0)
        self.assertGreater(np.median(np.abs(after - before)[:, :140]), 10.0)


class Judge(unittest.TestCase):
    def test_a_flight_without_errors(self):
        row = flight(lambda t: (0.0, 0.0, 0.0)).judge(EVENT, 20.0)
        self.assertTrue(row["judged"])
        self.assertAlmostEqual(row["back_s"], 0.0, delta=0.11)
        for key, bound in (("moved_m", 0.002), ("turned_deg", 0.01), ("largest_m", 0.003)):
            self.assertLess(row[key], bound, key)
        self.assertAlmostEqual(row["late_s"], 0.05)
        self.assertEqual((row["unwarned_s"], row["false_clears"]), (0.0, 0))

    def test_time_back_and_frame(self):
        # From 8.5 s on 2 m/s off, right again from 9.6 s on, 0.4 m and 6 deg away.
        def error(t):
            return ((0.4, math.radians(6.0), 2.0 if t < 9.55 else 0.0) if t > 8.45 else (0.0,) * 3)
        row = flight(error, frame=[[2.0, 1.0, 0.0, 0.0], [9.6, 1.0, 0.2, 3.0]]).judge(EVENT, 20.0)
        self.assertAlmostEqual(row["back_s"], 0.6, delta=0.01)
        self.assertAlmostEqual(row["turned_deg"], 6.0, delta=0.05)
        self.assertAlmostEqual(row["yaw_over_sigma"], 2.0, delta=0.02)
        self.assertGreater(row["moved_m"], 0.1)
        self.assertAlmostEqual(row["position_over_sigma"],
                               row["moved_m"] / (0.2 * math.sqrt(3.0)), places=6)
        # Translation alone.
        row = flight(lambda t: (0.4 if t > 8.45 else 0.0, 0.0, 0.0)).judge(EVENT, 20.0)
        self.assertAlmostEqual(row["moved_m"], 0.4, delta=0.003)
        self.assertIsNone(row["position_over_sigma"])

    def test_never_back(self):
        row = flight(lambda t: (0.0, 0.0, 2.0 if t > 8.0 else 0.0)).judge(EVENT, 20.0)
        self.assertIsNone(row["back_s"])
        self.assertIsNone(row["moved_m"])
        # What comes after the next event is not this one's.
        row = flight(lambda t: (0.0, 0.0, 2.0 if 8.0 < t < 13.0 else 0.0)).judge(EVENT, 12.0)
        self.assertIsNone(row["back_s"])
        # One that stops being published, and one that begins too late.
        row = flight(lambda t: (0.0, 0.0, 0.0), missing=[(8.2, 19.0)]).judge(EVENT, 20.0)
        self.assertIsNone(row["back_s"])
        row = flight(lambda t: (0.0, 0.0, 0.0), missing=[(8.2, 10.0)]).judge(EVENT, 20.0)
        self.assertAlmostEqual(row["back_s"], 1.0, delta=0.01)
        self.assertFalse(flight(lambda t: (0.0,) * 3, first=7.9).judge(EVENT, 20.0)["judged"])
        self.assertFalse(flight(lambda t: (0.0, 0.0, 1.0)).judge(EVENT, 20.0)["judged"])

    def test_warnings(self):
        def error(t):
            return (2.0 if t > 8.45 else 0.0, 0.0, 0.0)
        good, bad = [(2.0, "good"), (8.0, "good")], [(8.5, "wrong"), (9.45, "good")]
        unwarned = flight(error, health=good).judge(EVENT, 20.0)["unwarned_s"]
        self.assertAlmostEqual(unwarned, 6.6, delta=0.11)  # to six seconds after the event
        warned = flight(error, health=good + bad).judge(EVENT, 20.0)["unwarned_s"]
        self.assertAlmostEqual(unwarned - warned, 1.0, delta=0.11)
        # A standard deviation that covers the error is a warning; one that does not is none.
        for sigma, seconds in ((0.7, 0.0), (0.6, unwarned)):
            frame = [[2.0, 1.0, 0.1, 0.1], [8.5, 1.0, math.hypot(0.1, sigma), 0.1]]
            row = flight(error, health=good, frame=frame).judge(EVENT, 20.0)
            self.assertAlmostEqual(row["unwarned_s"], seconds, delta=0.11)
            self.assertAlmostEqual(row["good_beyond_1m_s"], unwarned, delta=0.11)

    def test_all_clears(self):
        health = [(2.0, "good"), (8.5, "suspect"), (10.0, "good")]
        for end, false in ((10.5, 1), (9.5, 0)):
            def error(t, end=end):
                return (0.0, 0.0, 1.0 if 8.45 < t < end else 0.0)
            self.assertEqual(flight(error, health=health).judge(EVENT, 20.0)["false_clears"], false)

    def test_latency_and_alarms(self):
        def late(t):
            return 0.8 if 9.05 < t < 9.15 else 0.07
        one = flight(lambda t: (0.0,) * 3, late=late)
        self.assertAlmostEqual(one.judge(EVENT, 20.0)["late_s"], 0.8)
        self.assertAlmostEqual(one.judge(fault_bag.event_of("frozen:1@10"), 20.0)["late_s"], 0.07)
        health = [(2.0, "good"), (5.0, "suspect"), (5.5, "good"), (8.1, "wrong"), (16.0, "good"),
                  (17.0, "suspect")]
        one = flight(lambda t: (0.0,) * 3, health=health)
        self.assertEqual(one.alarms([], 6.0), 3)
        self.assertEqual(one.alarms([EVENT], 6.0), 2)


class Bags(Scratch):
    def message(self, name, t):
        message = CLASSES[name]()
        if name != "std_msgs/String":
            message.header.stamp = genpy.Time.from_sec(BEGAN + t)
        return message

    def test_inject(self):
        bag, out = self.path("a.bag"), self.path("b.bag")
        with rosbag.Bag(bag, "w") as sink:
            for k in range(300):
                imu = self.message("sensor_msgs/Imu", 0.01 * k)
                imu.linear_acceleration.z = 9.8
                sink.write("/imu0", imu, imu.header.stamp)
                if k % 10 == 0:
                    image = self.message("sensor_msgs/Image", 0.01 * k)
                    image.height, image.width, image.step, image.encoding = 4, 6, 8, "mono8"
                    image.data = bytes(range(32))
                    sink.write("/cam", image, image.header.stamp)
        events = [fault_bag.event_of(word) for word in ("accel:5:1@1", "upside-down:0.5@2",
                                                        "no-images:0.5@0.5")]
        self.assertEqual(fault_bag.inject(bag, out, "/imu0", "/cam", events), BEGAN)
        with rosbag.Bag(out) as result:
            imu = [m for _, m, _ in result.read_messages(topics=["/imu0"])]
            images = [m for _, m, _ in result.read_messages(topics=["/cam"])]
        self.assertEqual((len(imu), len(images)), (300, 25))
        self.assertEqual([sum(m.linear_acceleration.x == x for m in imu) for x in (0.0, 5.0)],
                         [200, 100])
        self.assertEqual(images[0].data, bytes(range(32)))
        turned_images = [m for m in images if m.step == 6]
        self.assertEqual(len(turned_images), 5)
        self.assertEqual(list(turned_images[0].data[:6]), [29, 28, 27, 26, 25, 24])
        with self.assertRaisesRegex(SystemExit, "a.bag has no messages of /camera$"):
            fault_bag.inject(bag, out, "/imu0", "/camera", events)
        with self.assertRaisesRegex(SystemExit, "a.bag has no messages of /camera, /imu1$"):
            fault_bag.inject(bag, out, "/imu1", "/camera", events)

    def record(self, path, rows):
        """What rosbag record would have written: its clock is 77 s before that of the stamps, and
        the IMU samples are 2 to 5 ms on their way."""
        with rosbag.Bag(path, "w") as sink:
            def write(topic, message, t):
                sink.write(topic, message, genpy.Time.from_sec(BEGAN - 77.0 + t))
            for k in range(2000):
                message = self.message("sensor_msgs/Imu", 0.01 * k)
                write("/imu0", message, 0.01 * k + 0.002 + 0.001 * (k % 4))
            for row in rows:
                message = self.message("nav_msgs/Odometry", row[0])
                pose, q, v = (message.pose.pose.position, message.pose.pose.orientation,
                              message.twist.twist.linear)
                pose.x, pose.y, pose.z = row[2:5]
                q.w, q.x, q.y, q.z = row[5:9]
                v.x, v.y, v.z = row[9:12]
                write(fault_bag.TOPICS["odometry"], message, row[1] + 0.002)
            for name, words in (("health", "%.4f,suspect,1,0,0,0,\"\"" % (BEGAN + 8.5)),
                                ("health", "%.4f,good,1,0,0,0,\"\"" % (BEGAN + 7.5)),
                                ("frame", "%.4f,%.4f,0.3,2.0" % (BEGAN + 9.0, BEGAN + 1.0)),
                                ("status", "recover done: x")):
                message = self.message("std_msgs/String", 0.0)
                message.data = words
                write(fault_bag.TOPICS[name], message, 9.0)

    def test_judge_a_recording(self):
        truth = self.write("a.bag.groundtruth.csv", "#timestamp,...\n" + "".join(
            "%d,%s\n" % (round((BEGAN + row[0]) * 1e9), ",".join(map(repr, row[1:].tolist())))
            for row in TRUTH))
        self.record(self.path("recorded.bag"),
                    odometry(lambda t: (0.5 if t > 8.45 else 0.0, 0.0, 0.0)))
        self.write("run.json", json.dumps({
            "truth": truth, "imu_topic": "/imu0", "began": BEGAN, "seconds": 20.0, "cpu_s": 8.0,
            "events": [EVENT]}))
        rows, total = fault_bag.judge(self.folder)
        self.assertAlmostEqual(total["late_worst"], 0.05, places=4)
        self.assertEqual((total["recoveries"], total["alarms"], total["cpu"]), (1, 0, 0.4))
        self.assertAlmostEqual(rows[0]["moved_m"], 0.5, delta=0.003)
        self.assertAlmostEqual(rows[0]["position_over_sigma"], 0.5 / math.sqrt(3.0) / 0.3,
                               delta=0.01)
        line = fault_bag.table(rows)[2]
        self.assertTrue(line.startswith("| frozen:1 | 1 | 1 | 0 | 0.00 / 0.00 | 0.50 / 0.50"),
                        line)
        self.assertIn("1 events judged", fault_bag.summary(rows, [total])[0])
        self.assertTrue(os.path.exists(self.path("judged.csv")))

    def test_a_host_without_odometry(self):
        self.record(self.path("a.bag"), [])
        self.assertEqual(
            fault_bag.read_flight(self.path("a.bag"), TRUTH, "/imu0", BEGAN)[0], None)


class ProcessorTime(unittest.TestCase):
    def test_of_a_child(self):
        sum(k * k for k in range(2000000))
        name = read("/proc/self/comm").strip()
        self.assertGreater(fault_bag.processor_time(os.getppid(), name), 0.0)
        self.assertEqual(fault_bag.processor_time(os.getppid(), "no such name"), 0.0)


if __name__ == "__main__":
    unittest.main()
