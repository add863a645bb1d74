#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The nodes of slim_init.launch for a while, with faults in what they receive.

soak.py BAG CONFIG WORK_DIR
    Sends the sequence of BAG again and again as fast as the nodes follow, every round later than the
    one before, as a drive with pauses would be. One round in four is as recorded, the others have a
    fault that chance chooses. After every round: whether there was an answer and the error of its
    scale (truth in BAG.groundtruth.csv), and the memory of both nodes. Ends with a table and with 1
    where a node ended, a round as recorded had no answer or one beyond 10 %, or memory grew by more
    than 4 MiB from the second quarter of the rounds to the last.
    SLIM_INIT_NODE_SOAK_ROUNDS is their number (5), SLIM_INIT_NODE_SOAK_SEED the seed (1).
"""
import copy
import csv
import math
import os
import random
import signal
import socket
import subprocess
import sys
import time

NAMES = ("/feature_tracker_lines", "/slim_init")
PAUSE_S = 30.0  # between the stamps of two rounds
START_S = 60.0  # patience with the nodes
AHEAD = 3  # images on their way
STALL_S = 0.2  # an image that is not answered for so long is not going to be
ANSWER_S = 20.0  # patience with the answer to a round as recorded, on a busy machine
WRONG, RIGHT = 0.25, 0.1
GROWTH_MIB = 4.0


# ------------------------------------------------------------------------------------------ faults
# Each changes one message of a round: (message, t since its beginning [s], state of the round, random)
# gives the messages to send instead.

def same(message, t, state, chance):
    return [message]


def gone(message, t, state, chance):
    return [] if during(t) else [message]


def during(t, begin=1.0, end=1.8):
    return begin <= t < end


def drops(share):
    return lambda message, t, state, chance: [] if chance.random() < share else [message]


def sometimes(share, change, when=lambda t: True):
    """`change` of a message, with this probability."""
    def fault(message, t, state, chance):
        if when(t) and chance.random() < share:
            change(message)
        return [message]
    return fault


def imu_spike(message, t, state, chance):
    if not state.get("hit") and t > 1.0:
        state["hit"] = True
        message.linear_acceleration.x += 1000.0
    return [message]


def imu_nan(message):
    message.angular_velocity.y = float("nan")


def imu_stuck(message, t, state, chance):
    if during(t):
        held = state.setdefault("held", message)
        message.angular_velocity, message.linear_acceleration = (
            held.angular_velocity, held.linear_acceleration)
    return [message]


def imu_no_stamp(message):
    message.header.stamp.secs = message.header.stamp.nsecs = 0


def imu_stray(message):
    message.header.stamp.secs += 5000


def imu_back(message, t, state, chance):
    if t > 2.0:
        message.header.stamp.secs -= 5
    return [message]


def image_dark(message, t, state, chance):
    if during(t):
        message.data = bytes(len(message.data))
    return [message]


def image_covered(message, t, state, chance):
    row = bytes(message.width // 2)
    data = bytearray(message.data)
    for y in range(message.height):
        data[y * message.step:y * message.step + len(row)] = row
    message.data = bytes(data)
    return [message]


def image_repeats(message, t, state, chance):
    return [message, copy.copy(message)] if chance.random() < 0.2 else [message]


def image_order(message, t, state, chance):
    if chance.random() < 0.1 and "late" not in state:
        state["late"] = message
        return []
    return [message, state.pop("late")] if "late" in state else [message]


def image_cut(message):
    message.data = message.data[:len(message.data) // 2]


def image_format(message):
    message.encoding = "nonsense"


def image_size(message):
    message.width, message.height, message.step = 16, 16, 16
    message.data = bytes(256)


# name: for the IMU, for the images
FAULTS = {
    "imu-spike": (imu_spike, same),
    "imu-nan": (sometimes(0.1, imu_nan, during), same),
    "imu-gap": (gone, same),
    "imu-drops": (drops(0.1), same),
    "imu-stuck": (imu_stuck, same),
    "imu-no-stamp": (sometimes(0.02, imu_no_stamp), same),
    "imu-stray-stamps": (sometimes(0.005, imu_stray), same),
    "imu-jump-back": (imu_back, same),
    "image-drops": (same, drops(0.3)),
    "image-gone": (same, gone),
    "image-dark": (same, image_dark),
    "image-half-covered": (same, image_covered),
    "image-repeats": (same, image_repeats),
    "image-order": (same, image_order),
    "image-cut-off": (same, sometimes(0.1, image_cut)),
    "image-unknown-format": (same, sometimes(0.1, image_format)),
    "image-other-size": (same, sometimes(0.1, image_size)),
}


# ------------------------------------------------------------------------------------------ helpers

def memory_mib(pid):
    with open("/proc/%d/status" % pid, encoding="utf-8") as file:
        for line in file:
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1024.0
    raise OSError("a process that has ended")


def read_truth(path):
    """Positions by stamp [ns]."""
    with open(path, encoding="utf-8") as file:
        rows = csv.reader(file)
        next(rows)
        return {int(row[0]): tuple(float(x) for x in row[1:4]) for row in rows}


def spread(points):
    middle = [sum(p[i] for p in points) / len(points) for i in range(3)]
    return math.sqrt(sum((p[i] - middle[i]) ** 2 for p in points for i in range(3)))


def quantile(values, q):
    values = sorted(values)
    return values[min(len(values) - 1, int(q * len(values)))] if values else float("nan")


class Nodes:
    """Launched here, under a master of their own."""

    def __init__(self, config, work_dir):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = str(free.getsockname()[1])
        os.environ["ROS_MASTER_URI"] = "http://127.0.0.1:" + port
        os.environ["ROS_IP"] = "127.0.0.1"
        self.log = open(os.path.join(work_dir, "roslaunch.log"), "w", encoding="utf-8")
        self.process = subprocess.Popen(
            ["roslaunch", "-p", port, "slim_init", "slim_init.launch", "config:=" + config,
             "rviz:=false"], stdout=self.log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        self.pids = {}

    def find(self):
        import rosgraph
        from xmlrpc.client import ServerProxy
        end = time.monotonic() + START_S
        while time.monotonic() < end:
            try:
                master = rosgraph.Master("/soak")
                for name in NAMES:
                    self.pids[name] = ServerProxy(master.lookupNode(name)).getPid("/soak")[2]
                return True
            except (OSError, rosgraph.MasterException):
                time.sleep(0.2)
        return False

    def memory(self):
        return [memory_mib(self.pids[name]) for name in NAMES]

    def end(self):
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.log.close()


class Client:
    """Classes of messages are made from what the bag and the publishers say: those of geometry_msgs and
    sensor_msgs for Python need not be installed."""

    def __init__(self, classes):
        import rospy
        rospy.init_node("soak", disable_signals=True)
        self.rospy = rospy
        self.results, self.statuses, self.features = [], [], 0
        self.classes = {}
        self.imu = rospy.Publisher("/imu0", classes["imu"], queue_size=10000, tcp_nodelay=True)
        self.image = rospy.Publisher("/cam0/image_raw", classes["image"], queue_size=1000,
                                     tcp_nodelay=True)
        self.subscribers = [
            rospy.Subscriber("/slim_init/result", rospy.AnyMsg,
                             lambda m: self.results.append(self.decode(m))),
            rospy.Subscriber("/slim_init/status", rospy.AnyMsg,
                             lambda m: self.statuses.append(self.decode(m))),
            rospy.Subscriber("/feature_tracker/feature", rospy.AnyMsg, self.on_feature)]

    def decode(self, message):
        from genpy.dynamic import generate_dynamic
        name = message._connection_header["type"]
        if name not in self.classes:
            definition = message._connection_header["message_definition"]
            self.classes[name] = generate_dynamic(name, definition)[name]
        return self.classes[name]().deserialize(message._buff)

    def on_feature(self, message):
        self.features += 1

    def wait(self, done, seconds):
        end = time.monotonic() + seconds
        while not done():
            if time.monotonic() > end:
                return False
            time.sleep(0.001)
        return True

    def listened_to(self):
        return self.imu.get_num_connections() >= 2 and self.image.get_num_connections() >= 1

    def play(self, messages, shift, fault, chance):
        """One round; the nodes are at most some images behind."""
        first = messages[0][1].header.stamp
        later = self.rospy.Duration(shift)
        states = {"imu": {}, "image": {}}
        sent = 0
        self.features = 0
        for kind, original in messages:
            message = copy.deepcopy(original) if kind == "imu" else copy.copy(original)
            if kind == "image":
                message.header = copy.deepcopy(original.header)
            t = (original.header.stamp - first).to_sec()
            message.header.stamp = original.header.stamp + later
            change = fault[0] if kind == "imu" else fault[1]
            for changed in change(message, t, states[kind], chance):
                (self.imu if kind == "imu" else self.image).publish(changed)
                if kind == "image":
                    sent += 1
                    if not self.wait(lambda: self.features >= sent - AHEAD, STALL_S):
                        sent = self.features + AHEAD
        # What is still on its way.
        before = -1
        while before != (len(self.statuses), len(self.results), self.features):
            before = (len(self.statuses), len(self.results), self.features)
            time.sleep(0.5)


def read_bag(path):
    import rosbag
    messages = []
    with rosbag.Bag(path) as bag:
        for topic, message, _ in bag.read_messages(topics=["/imu0", "/cam0/image_raw"]):
            messages.append(("imu" if topic == "/imu0" else "image", message))
    # Ahead of an image the IMU data that cover it, as a driver would deliver them.
    messages.sort(key=lambda m: m[1].header.stamp.to_nsec() + (20000000 if m[0] == "image" else 0))
    return messages


def scale_error(result, shift, truth):
    """None for a result of another round: the answer may come when the next one has begun."""
    stamps = [stamp.to_nsec() - int(round(shift * 1e9)) for stamp in result.stamps]
    if any(stamp not in truth for stamp in stamps):
        return None
    estimate = [(p.position.x, p.position.y, p.position.z) for p in result.poses]
    return spread(estimate) / spread([truth[stamp] for stamp in stamps]) - 1.0


def report(rounds):
    """The table, a line for a quarter of the rounds."""
    print("| rounds | answers | beyond 25 % | attempts | median ms | p99 ms | front end MiB | "
          "initializer MiB |\n|---|---|---|---|---|---|---|---|")
    for q in range(4):
        part = rounds[q * len(rounds) // 4:(q + 1) * len(rounds) // 4]
        if not part:
            continue
        times = [ms for r in part for ms in r["ms"]]
        print("| %d | %d | %d | %d | %.1f | %.1f | %.1f | %.1f |" % (
            len(part), sum(r["error"] is not None for r in part),
            sum(r["error"] is not None and abs(r["error"]) > WRONG for r in part), len(times),
            quantile(times, 0.5), quantile(times, 0.99), part[-1]["memory"][0],
            part[-1]["memory"][1]))


def problems_of(rounds):
    problems = []
    for k, r in enumerate(rounds):
        if r["fault"] == "none" and (r["error"] is None or not abs(r["error"]) < RIGHT):
            problems.append("round %d is as recorded and has %s" % (
                k, "no answer" if r["error"] is None else "an error of %.3f" % r["error"]))
    if len(rounds) >= 40:  # before that the allocator has not seen everything once
        for i, name in enumerate(NAMES):
            growth = rounds[-1]["memory"][i] - rounds[len(rounds) // 2]["memory"][i]
            if growth > GROWTH_MIB:
                problems.append("%s grew by %.1f MiB" % (name, growth))
    return problems


def main(bag, config, work_dir):
    number = int(os.environ.get("SLIM_INIT_NODE_SOAK_ROUNDS", "5"))
    chance = random.Random(int(os.environ.get("SLIM_INIT_NODE_SOAK_SEED", "1")))
    os.makedirs(work_dir, exist_ok=True)
    # So that the nodes end with us, also where the shell has told us to ignore the first of them.
    for number_of_signal in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number_of_signal, lambda *_: sys.exit("soak: ended by a signal"))
    truth = read_truth(bag + ".groundtruth.csv")
    messages = read_bag(bag)
    length = (messages[-1][1].header.stamp - messages[0][1].header.stamp).to_sec()
    nodes = Nodes(config, work_dir)
    rounds = []
    begin = time.monotonic()
    try:
        if not nodes.find():
            sys.exit("soak: the nodes did not come; %s/roslaunch.log" % work_dir)
        client = Client({kind: type(message) for kind, message in messages})
        if not client.wait(client.listened_to, START_S):
            sys.exit("soak: the nodes do not listen")
        for k in range(number):
            name = "none" if k % 4 == 0 else chance.choice(sorted(FAULTS))
            shift = k * (length + PAUSE_S)
            statuses = len(client.statuses)
            client.play(messages, shift, FAULTS.get(name, (same, same)), chance)

            def errors():
                found = (scale_error(result, shift, truth) for result in client.results[-3:])
                return [error for error in found if error is not None]

            client.wait(errors, ANSWER_S if name == "none" else 0.0)
            error = errors()[0] if errors() else None
            try:
                memory = nodes.memory()
            except OSError as problem:
                sys.exit("soak: a node ended in round %d, %s: %s" % (k, name, problem))
            rounds.append({"fault": name, "error": error, "memory": memory,
                           "ms": [s.total_ms for s in client.statuses[statuses:]]})
            print("%d %s: %s, %.1f and %.1f MiB" % (
                k, name, "no answer" if error is None else "error %.3f" % error, *memory),
                flush=True)
    finally:
        nodes.end()
    print("\n%d rounds, %.0f s of data, in %.0f s\n" % (
        len(rounds), len(rounds) * length, time.monotonic() - begin))
    report(rounds)
    problems = problems_of(rounds)
    for problem in problems:
        print("soak: " + problem)
    return 1 if problems else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
