#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Faults in flight: plays a bag with ground truth at rate 1 through a patched VINS-Mono, with faults
in its data, and judges the recorded odometry.

fault_bag.py run BAG CONFIG OUT TRACKER MODE [EVENT@SECONDS]...
    Writes OUT/faulted.bag, plays it through the host (TRACKER slim or stock, MODE slim or stock),
    records OUT/recorded.bag and judges it. Ground truth: BAG.groundtruth.csv. Without events:
    false alarms. ROS packages slim_init and vins_estimator have to be found (vins_mono.md).
fault_bag.py judge OUT...
    Judges again; of several folders one row for each kind of event.

Events, SECONDS after the first message of the bag, and how long [s]:
    accel:A:S  gyro:W:S    added to x of the accelerometer [m/s^2], to y of the gyroscope [rad/s]
    noise:A,W:S            white noise on both    clip:A,W:S   saturation at these values
    frozen:S               the same sample again and again
    no-imu:S  no-images:S  nothing:S              messages missing
    blank:S  upside-down:S                        images grey, turned by 180 deg
    texture:P,V:S          a texture that moves at V px/s over the fraction P of the image
"""
import bisect
import csv
import json
import math
import os
import subprocess
import sys

import numpy as np

import ab_bag
from ab_bag import fail, heading, interpolated

KINDS = {"accel": 1, "gyro": 1, "noise": 2, "clip": 2, "frozen": 0, "no-imu": 0, "no-images": 0,
         "nothing": 0, "blank": 0, "upside-down": 0, "texture": 2}  # and how many sizes they have
NODE = "/vins_estimator/"
TOPICS = {"odometry": NODE + "odometry", "status": NODE + "slim_init/status",
          "health": NODE + "slim_init/health", "frame": NODE + "slim_init/frame"}
VELOCITY, TILT = 0.3, 3.0  # [m/s], [deg]: the odometry is back
FALSE_VELOCITY, FALSE_TILT = 0.5, 5.0  # an all-clear with larger errors is false
STEADY_S = 0.5  # for so long
FRAME_S = 2.0  # over which the frame before and after is measured
REACH_S = 6.0  # an event's errors and latencies: up to so long after its end
LARGE_M = 1.0  # an error that needs a warning
GAP_S = 0.35  # without odometry nothing is back
ROUNDING = 1e-4  # of the stamps in the rows of health and frame [s]
DAMAGE_SEED = 1


# ----------------------------------------------------------------------------------------- faults


def event_of(word):
    """{kind, sizes, at, seconds} of KIND[:SIZES]:SECONDS@AT."""
    try:
        name, at = word.split("@")
        kind, *sizes, seconds = name.split(":")
        sizes = [float(size) for size in ",".join(sizes).split(",") if size]
        event = {"name": name, "kind": kind, "sizes": sizes, "at": float(at),
                 "seconds": float(seconds)}
    except ValueError:
        fail("%s is no event: KIND[:SIZES]:SECONDS@AT" % word)
    if kind not in KINDS or len(sizes) != KINDS[kind] or not event["seconds"] > 0.0:
        fail("%s is no event: kinds are %s" % (word, ", ".join(sorted(KINDS))))
    return event


class Faults:
    """Changes the samples of a stream in its order; times in seconds after its beginning."""

    def __init__(self, events):
        self.events = events
        self.random = np.random.RandomState(DAMAGE_SEED)
        self.held = None
        self.texture = None

    def active(self, t):
        return [one for one in self.events if one["at"] <= t < one["at"] + one["seconds"]]

    def imu(self, t, accel, gyro):
        """The sample as it is to be sent: two arrays, or None."""
        events = self.active(t)
        if self.held is None or not any(one["kind"] == "frozen" for one in events):
            self.held = (accel, gyro)
        for one in events:
            kind, sizes = one["kind"], one["sizes"]
            if kind in ("no-imu", "nothing"):
                return None
            if kind == "accel":
                accel = accel + [sizes[0], 0.0, 0.0]
            elif kind == "gyro":
                gyro = gyro + [0.0, sizes[0], 0.0]
            elif kind == "noise":
                accel = accel + sizes[0] * self.random.randn(3)
                gyro = gyro + sizes[1] * self.random.randn(3)
            elif kind == "clip":
                accel, gyro = np.clip(accel, -sizes[0], sizes[0]), np.clip(gyro, -sizes[1], sizes[1])
            elif kind == "frozen":
                accel, gyro = self.held
        return accel, gyro

    def image(self, t, pixels):
        """The image as it is to be sent, grey levels [row, column], or None."""
        for one in self.active(t):
            if one["kind"] in ("no-images", "nothing"):
                return None
            if one["kind"] == "blank":
                pixels = np.full_like(pixels, 128)
            elif one["kind"] == "upside-down":
                pixels = pixels[::-1, ::-1]
            elif one["kind"] == "texture":
                pixels = self.covered(pixels, one["sizes"], t - one["at"])
        return pixels

    def covered(self, pixels, sizes, seconds):
        """The left part of the image behind a texture that moves along (2, 1)."""
        rows, columns = pixels.shape
        if self.texture is None or self.texture.shape != pixels.shape:
            blocks = sum(np.kron(self.random.rand(rows // size + 1, columns // size + 1),
                                 np.ones((size, size)))[:rows, :columns] for size in (12, 31))
            for axis in (0, 1):
                blocks = (np.roll(blocks, 1, axis) + 2.0 * blocks + np.roll(blocks, -1, axis)) / 4.0
            self.texture = 20.0 + 105.0 * blocks
        moved = self.texture
        for axis, part in ((1, 2.0), (0, 1.0)):
            whole, rest = divmod(sizes[1] * seconds * part / math.sqrt(5.0), 1.0)
            moved = ((1.0 - rest) * np.roll(moved, int(whole), axis) +
                     rest * np.roll(moved, int(whole) + 1, axis))
        covered = pixels.copy()
        edge = int(round(sizes[0] * columns))
        covered[:, :edge] = moved[:, :edge]
        return covered


def inject(bag, out, imu_topic, image_topic, events):
    """Writes the faulted copy of a bag; its first time [s]."""
    import rosbag
    faults = Faults(events)
    with rosbag.Bag(bag) as source, rosbag.Bag(out, "w") as sink:
        began = None  # by the stamps: the clock of the recorder may be another
        missing = {imu_topic, image_topic}
        for topic, message, t in source.read_messages(topics=[imu_topic, image_topic]):
            began = began or message.header.stamp.to_sec()
            missing.discard(topic)
            since = message.header.stamp.to_sec() - began
            if topic == imu_topic:
                a, w = message.linear_acceleration, message.angular_velocity
                sent = faults.imu(since, np.array([a.x, a.y, a.z]), np.array([w.x, w.y, w.z]))
                if sent is None:
                    continue
                a.x, a.y, a.z = sent[0]
                w.x, w.y, w.z = sent[1]
            elif faults.active(since):
                if message.encoding not in ("mono8", "8UC1"):
                    fail("images of encoding %s are not supported" % message.encoding)
                pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
                pixels = pixels[:, :message.width]
                sent = faults.image(since, pixels)
                if sent is None:
                    continue
                if sent is not pixels:
                    message.step, message.data = message.width, sent.astype(np.uint8).tobytes()
            sink.write(topic, message, t)
    if missing:
        fail("%s has no messages of %s" % (bag, ", ".join(sorted(missing))))
    return began


# ------------------------------------------------------------------------------------------ judge


def rotations(q):
    """Matrices of quaternions w, x, y, z, one in each row."""
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
                    ).transpose(2, 0, 1)


def read_truth(path):
    """Rows of stamp [s], position, quaternion w x y z."""
    rows = ab_bag.table_of(path, 8, "poses")
    return rows if len(rows) >= 10 else fail("%s has no poses" % path)


class Flight:
    """A recorded odometry against the ground truth. All times are stamps of the bag [s]."""

    def __init__(self, odometry, truth, health, frame):
        """`odometry`: stamp, time of arrival, position, quaternion w x y z, velocity in the world;
        `truth`: stamp, position, quaternion; `health`: (stamp, state); `frame`: stamp, stamp of the
        frame's origin, standard deviations of position [m] and yaw [deg]."""
        inside = (odometry[:, 0] > truth[0, 0] + 0.05) & (odometry[:, 0] < truth[-1, 0] - 0.05)
        odometry = odometry[inside]
        self.t, self.late = odometry[:, 0], odometry[:, 1] - odometry[:, 0]
        self.p = odometry[:, 2:5]
        R, v = rotations(odometry[:, 5:9]), odometry[:, 9:12]
        signs = np.sign(np.sum(truth[1:, 4:] * truth[:-1, 4:], axis=1))
        truth = truth.copy()
        truth[1:, 4:] *= np.cumprod(np.where(signs == 0, 1, signs))[:, None]
        now = interpolated(truth, self.t)
        self.q = now[:, :3]
        S = rotations(now[:, 3:])
        around = [interpolated(truth, self.t + dt)[:, :3] for dt in (-0.025, 0.025)]
        u = (around[1] - around[0]) / 0.05
        self.velocity = np.linalg.norm(np.einsum("nji,nj->ni", R, v) -
                                       np.einsum("nji,nj->ni", S, u), axis=1)
        cosine = np.clip(np.sum(R[:, 2] * S[:, 2], axis=1), -1.0, 1.0)
        self.tilt = np.degrees(np.arccos(cosine))
        D = np.einsum("nij,nkj->nik", S, R)
        self.yaw = np.arctan2(D[:, 1, 0] - D[:, 0, 1], D[:, 0, 0] + D[:, 1, 1])
        self.health, self.frame = sorted(health), frame

    def between(self, first, last):
        return (self.t >= first) & (self.t <= last)

    def frame_of(self, chosen):
        """Yaw [rad] and translation that bring the odometry onto the ground truth."""
        yaw = math.atan2(np.mean(np.sin(self.yaw[chosen])), np.mean(np.cos(self.yaw[chosen])))
        turn = heading(yaw)
        return yaw, turn, np.mean(self.q[chosen] - self.p[chosen] @ turn.T, axis=0)

    def right(self, k):
        return self.velocity[k] <= VELOCITY and self.tilt[k] <= TILT

    def back(self, end):
        """Time from `end` until the odometry is right for STEADY_S; None: never."""
        for k in np.flatnonzero(self.t >= end):
            near = np.flatnonzero((self.t >= self.t[k]) & (self.t <= self.t[k] + STEADY_S))
            steady = near[-1] + 1 < len(self.t) and self.t[near[-1] + 1] - self.t[k] < STEADY_S + GAP_S
            steady = steady and np.all(np.diff(self.t[near]) < GAP_S)
            if steady and all(self.right(j) for j in near):
                return self.t[k] - end
        return None

    def state(self, t):
        """The last one published up to `t`: a row a second, and one a frame in trouble."""
        k = bisect.bisect_right([row[0] for row in self.health], t + ROUNDING)
        return self.health[k - 1][1] if k > 0 else "none"

    def sigmas(self, t):
        """Variances of position and yaw of the frame at `t`."""
        k = bisect.bisect_right(list(self.frame[:, 0]), t + ROUNDING)
        return self.frame[k - 1, 2:] ** 2 if k > 0 else np.zeros(2)

    def false_clears(self, first, last):
        """All-clears in [first, last] at which the odometry was not right."""
        count = 0
        for before, after in zip(self.health, self.health[1:]):
            if not (before[1] != "good" and after[1] == "good" and first <= after[0] <= last):
                continue
            k = int(np.argmin(np.abs(self.t - after[0])))
            count += self.velocity[k] > FALSE_VELOCITY or self.tilt[k] > FALSE_TILT
        return int(count)

    def judge(self, event, until):
        """One row of the result. `until`: the next event or the end [s]; times are stamps."""
        begin, end = event["at"], event["at"] + event["seconds"]
        last = min(until, end + REACH_S)
        row = {"event": event["name"], "at": event["at"], "judged": False}
        before = self.between(begin - FRAME_S, begin)
        if np.sum(before) < 5 or not self.right(np.flatnonzero(before)[-1]):
            return row
        row.update({"judged": True, "back_s": self.back(end), "moved_m": None, "turned_deg": None,
                    "position_over_sigma": None, "yaw_over_sigma": None})
        yaw, turn, shift = self.frame_of(before)
        seen = self.between(begin, last)
        if row["back_s"] is not None and row["back_s"] > last - end:
            row["back_s"] = None
        error = np.linalg.norm(self.p @ turn.T + shift - self.q, axis=1)
        row["largest_m"] = float(np.max(error[seen])) if np.any(seen) else None
        since = self.sigmas(begin)
        unwarned = uncovered = 0.0
        for k in np.flatnonzero(seen):
            if error[k] <= LARGE_M:
                continue
            interval = min(self.t[k] - self.t[k - 1], GAP_S)
            if self.state(self.t[k]) == "good":
                unwarned += interval
                variance = max(self.sigmas(self.t[k])[0] - since[0], 0.0)
                uncovered += interval if error[k] > 3.0 * math.sqrt(variance) else 0.0
        row.update({"good_beyond_1m_s": unwarned, "unwarned_s": uncovered,
                    "false_clears": self.false_clears(begin, last)})
        row["late_s"] = float(np.max(self.late[seen])) if np.any(seen) else None
        if row["back_s"] is not None:
            after = self.between(end + row["back_s"] + STEADY_S,
                                 min(until, end + row["back_s"] + STEADY_S + FRAME_S))
            if np.sum(after) >= 3:
                self.compare(after, (yaw, turn, shift), since, row)
        return row

    def compare(self, after, frame, since, row):
        """How far the frame has moved, in metres, degrees and standard deviations."""
        yaw, turn, shift = frame
        offset = np.mean(self.p[after] @ turn.T + shift - self.q[after], axis=0)
        turned = self.frame_of(after)[0] - yaw
        row["moved_m"] = float(np.linalg.norm(offset))
        row["turned_deg"] = abs(math.degrees(math.atan2(math.sin(turned), math.cos(turned))))
        added = self.sigmas(self.t[np.flatnonzero(after)[-1]]) - since
        if added[0] > 0.0 and added[1] > 0.0:
            row["position_over_sigma"] = row["moved_m"] / math.sqrt(3.0 * added[0])
            row["yaw_over_sigma"] = row["turned_deg"] / math.sqrt(added[1])

    def alarms(self, events, settle):
        """Alarms more than `settle` s after the end of each event and before the next."""
        count = 0
        for before, after in zip(self.health, self.health[1:]):
            near = any(one["at"] - 0.2 <= after[0] <= one["at"] + one["seconds"] + settle
                       for one in events)
            count += before[1] == "good" and after[1] != "good" and not near
        return count


def read_flight(recorded, truth, imu_topic, began):
    """The flight in a bag of rosbag record, and the messages of the console with their times. At
    rate 1 the clock of the recorder is that of the stamps but for a constant: the smallest delay of
    an IMU sample."""
    import rosbag
    odometry, health, frame, words, delays = [], [], [], [], []
    names = {topic: name for name, topic in TOPICS.items()}
    with rosbag.Bag(recorded) as bag:
        for topic, message, t in bag.read_messages():
            name = names.get(topic)
            if topic == imu_topic:
                delays.append(t.to_sec() - message.header.stamp.to_sec())
            elif name == "odometry":
                p, q = message.pose.pose.position, message.pose.pose.orientation
                v = message.twist.twist.linear
                odometry.append([message.header.stamp.to_sec() - began, t.to_sec() - began, p.x, p.y,
                                 p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z])
            elif name == "health":
                fields = message.data.split(",")
                health.append((float(fields[0]) - began, fields[1]))
            elif name == "frame":
                row = [float(field) for field in message.data.split(",")]
                frame.append([row[0] - began, row[1] - began] + row[2:])
            elif name == "status":
                words.append((t.to_sec() - began, message.data))
    if not odometry or not delays:
        return None, words
    odometry = np.array(odometry)
    odometry[:, 1] -= min(delays)
    truth = truth - np.array([began] + 7 * [0.0])
    return Flight(odometry, truth, health, np.array(frame).reshape(-1, 4)), words


def judge(out):
    """The rows of a run, which are written into OUT/judged.csv, and what holds for all of it."""
    with open(os.path.join(out, "run.json"), encoding="utf-8") as file:
        run = json.load(file)
    flight, words = read_flight(os.path.join(out, "recorded.bag"), read_truth(run["truth"]),
                                run["imu_topic"], run["began"])
    total = {"out": out, "seconds": run["seconds"], "cpu": run["cpu_s"] / run["seconds"],
             "frames": 0, "alarms": 0,
             "recoveries": sum(",recover,success" in word or "recover done" in word
                               for _, word in words)}
    rows = [{"event": one["name"], "at": one["at"], "judged": False} for one in run["events"]]
    if flight is not None and len(flight.t) > 1:
        events = sorted(run["events"], key=lambda one: one["at"])
        ends = [one["at"] for one in events[1:]] + [flight.t[-1] + 1.0]
        rows = [flight.judge(one, end) for one, end in zip(events, ends)]
        total.update({"frames": len(flight.t), "late_p99": float(np.percentile(flight.late, 99)),
                      "late_worst": float(np.max(flight.late)),
                      "alarms": flight.alarms(events, REACH_S)})
    names = ["event", "at", "judged", "back_s", "moved_m", "turned_deg", "largest_m", "late_s",
             "good_beyond_1m_s", "unwarned_s", "false_clears", "position_over_sigma",
             "yaw_over_sigma"]
    with open(os.path.join(out, "judged.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)
    return rows, total


# ----------------------------------------------------------------------------------------- tables


def middle(values, form="%.2f"):
    values = [value for value in values if value is not None]
    return form % float(np.median(values)) if values else "-"


def largest(values, form="%.2f"):
    values = [value for value in values if value is not None]
    return form % max(values) if values else "-"


def table(rows):
    """One line for each kind of event: those of docs/benchmark.md, and what was not warned of."""
    lines = ["| event | runs | back within 0.5 s | never | back s, median / maximum | moved m, median "
             "/ maximum | turned deg, maximum | late s, maximum | false all-clears | beyond 1 m "
             "without warning s |", "|---|" + 9 * "---:|"]
    for name in sorted({row["event"] for row in rows}):
        of = [row for row in rows if row["event"] == name and row["judged"]]
        get = lambda key: [row[key] for row in of]  # noqa: E731
        back = get("back_s")
        lines.append("| %s | %d | %d | %d | %s / %s | %s / %s | %s | %s | %d | %s |" % (
            name, len(of), sum(b is not None and b <= 0.5 for b in back),
            sum(b is None for b in back), middle(back), largest(back), middle(get("moved_m")),
            largest(get("moved_m")), largest(get("turned_deg"), "%.1f"), largest(get("late_s")),
            sum(get("false_clears")), largest(get("unwarned_s"), "%.1f")))
    return lines


def summary(rows, totals):
    judged = [row for row in rows if row["judged"]]
    lines = ["%d events judged, %d not (no healthy odometry before them)" % (
        len(judged), len(rows) - len(judged))]
    for key in ("position_over_sigma", "yaw_over_sigma"):
        ratios = [row[key] for row in judged if row[key] is not None]
        if ratios:
            lines.append("%s: rms %.2f of %d" % (
                key.replace("_", " "), math.sqrt(np.mean(np.square(ratios))), len(ratios)))
    flown = [total for total in totals if total["frames"]]
    lines.append("%d runs, %.0f s; processor time over time %s (median), %s (maximum)" % (
        len(totals), sum(total["seconds"] for total in totals),
        middle([total["cpu"] for total in totals]), largest([total["cpu"] for total in totals])))
    lines.append("odometry late: p99 %s s (median run), %s s (worst run), worst %s s" % (
        middle([total["late_p99"] for total in flown], "%.3f"),
        largest([total["late_p99"] for total in flown], "%.3f"),
        largest([total["late_worst"] for total in flown], "%.3f")))
    lines.append("alarms without an event: %d; recoveries in runs without events: %d" % (
        sum(total["alarms"] for total in totals),
        sum(total["recoveries"] for total in totals
            if not any(row.get("out") == total["out"] for row in rows))))
    return lines


def report(folders):
    rows, totals = [], []
    for out in folders:
        of, total = judge(out)
        rows += [dict(row, out=out) for row in of]
        totals.append(total)
    print("\n".join(table(rows) + [""] + summary(rows, totals)), flush=True)


# -------------------------------------------------------------------------------------------- run


def processor_time(parent, name):
    """Of the process `name` among the children of `parent` [s]."""
    ticks = 0.0
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/stat" % pid, encoding="utf-8") as file:
                head, tail = file.read().rsplit(")", 1)
        except OSError:
            continue  # it has ended
        fields = tail.split()
        if head.split("(", 1)[1] == name[:15] and int(fields[1]) == parent:
            ticks += float(fields[11]) + float(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def run(bag, config, out, tracker, mode, *words):
    events = sorted((event_of(word) for word in words), key=lambda one: one["at"])
    text = ab_bag.read_config(config)
    imu_topic, image_topic = (ab_bag.topic_of(text, key) for key in ("imu_topic", "image_topic"))
    truth = os.path.abspath(bag + ".groundtruth.csv")
    read_truth(truth)
    out = os.path.abspath(out)
    own, odometry, log = ab_bag.prepare(out, text, mode)
    faulted, recorded = (os.path.join(out, name) for name in ("faulted.bag", "recorded.bag"))
    began = inject(bag, faulted, imu_topic, image_topic, events)
    with ab_bag.host(config, own, log, tracker, "false") as launch:
        record = None
        try:
            record = subprocess.Popen(["rosbag", "record", "--quiet", "-O", recorded, imu_topic] +
                                      list(TOPICS.values()), start_new_session=True)
            if ab_bag.play(faulted, text, "1", mode) != 0:
                fail("%s could not be played" % faulted)
            ab_bag.wait_until_quiet(odometry)
            cpu = processor_time(launch.pid, "vins_estimator")
            if launch.poll() is None and cpu == 0.0:
                fail("vins_estimator has ended; see %s" % log)
        finally:
            if record is not None:
                ab_bag.end(record)
    import rosbag
    with rosbag.Bag(faulted) as source:
        seconds = source.get_end_time() - source.get_start_time()
    os.remove(faulted)
    with open(os.path.join(out, "run.json"), "w", encoding="utf-8") as file:
        json.dump({"bag": os.path.abspath(bag), "truth": truth, "imu_topic": imu_topic,
                   "began": began, "seconds": seconds, "cpu_s": cpu, "mode": mode,
                   "tracker": tracker, "events": events}, file, indent=1)
    report([out])


def main():
    words = sys.argv[1:]
    if words[:1] == ["run"] and len(words) >= 6:
        run(*words[1:])
    elif words[:1] == ["judge"] and len(words) >= 2:
        report(words[1:])
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
