#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The working part of ab_bag.launch.

ab_bag.py shadow CONFIG OUT COMMAND...   writes OUT/shadow.yaml, CONFIG in shadow mode with its results
                                         in OUT, then becomes COMMAND
ab_bag.py run BAG CONFIG OUT METHODS RATE HOST
                                         plays BAG (HOST true), then compares off line and reports
"""
import csv
import os
import re
import subprocess
import sys

STARTS = "slim_init_starts.csv"  # written by the patched host into its output_path


def fail(sentence):
    sys.exit("ab_bag: " + sentence)


def read(path):
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except OSError as error:
        fail("%s cannot be read: %s" % (path, error.strerror))


def with_key(text, key, value):
    """The file with `key: value` at top level: in place of the line there, or at its end."""
    line = '%s: "%s"' % (key, value)
    text, count = re.subn(r"(?m)^%s[ \t]*:.*$" % re.escape(key), lambda _: line, text)
    return text if count else text.rstrip("\n") + "\n" + line + "\n"


def shadow_config(text, out):
    return with_key(with_key(text, "initializer", "shadow"), "output_path", out)


def topic_of(text, key):
    found = re.search(r'(?m)^%s[ \t]*:[ \t]*"?([^"#\s]+)' % key, text)
    if not found:
        fail("the configuration file has no %s" % key)
    return found.group(1)


def number(text):
    try:
        return float(text)
    except ValueError:
        return None


def median(values):
    values = sorted(values)
    middle = len(values) // 2
    return values[middle] if len(values) % 2 else 0.5 * (values[middle - 1] + values[middle])


def starts_report(rows):
    """A few lines about the starts that host and slim answered side by side."""
    tried = [row for row in rows if row["stock_tried"] == "1"]
    lines = ["%d windows were answered by slim, %d of them tried by the host" %
             (len(rows), len(tried))]
    for name, column, yes in (("host", "stock_success", "1"),
                              ("slim", "slim_status", "success")):
        accepted = [row for row in rows if row[column] == yes]
        first = ("the first at %s s" % accepted[0]["stamp_s"]) if accepted else "none at all"
        lines.append("%s: %d accepted, %s" % (name, len(accepted), first))
    ratios = [number(row["path_ratio_stock_to_slim"]) for row in rows]
    ratios = [ratio for ratio in ratios if ratio is not None]
    if ratios:
        lines.append("length of the path, host to slim: median %.3f over %d windows" %
                     (median(ratios), len(ratios)))
    return lines


def play(bag, config, rate):
    text = read(config)
    # What is played before the nodes listen is lost; the delay is for the slowest of them.
    return subprocess.call(["rosbag", "play", "--clock", "--quiet", "--wait-for-subscribers",
                            "--delay=3", "--rate", rate, bag, "--topics",
                            topic_of(text, "imu_topic"), topic_of(text, "image_topic")])


def run(bag, config, out, methods, rate, host):
    os.makedirs(out, exist_ok=True)
    if host == "true":
        if play(bag, config, rate) != 0:
            fail("%s could not be played" % bag)
        path = os.path.join(out, STARTS)
        if not os.path.exists(path):
            fail("the host left no %s: is its estimator patched (vins_estimator_patch/README.md)?" %
                 path)
        with open(path, newline="", encoding="utf-8") as file:
            report = starts_report(list(csv.DictReader(file)))
        print("\n==> Side by side in the host (%s)" % path)
        print("\n".join("    " + line for line in report), flush=True)
    print("\n==> Off line, every window", flush=True)
    code = subprocess.call(["rosrun", "slim_init", "slim_init", "ab", "--bag", bag, "--config",
                            config, "--methods", methods, "--out", os.path.join(out, "ab")])
    if code != 0:
        fail("slim_init ab ended with %d" % code)


def main():
    # roslaunch adds __name:=.. and __log:=.. for nodes that know ROS.
    words = [word for word in sys.argv[1:] if not word.startswith("__")]
    if words[:1] == ["shadow"] and len(words) >= 4:
        config, out = words[1], os.path.abspath(words[2])
        os.makedirs(out, exist_ok=True)
        with open(os.path.join(out, "shadow.yaml"), "w", encoding="utf-8") as file:
            file.write(shadow_config(read(config), out))
        command = words[3:] + [word for word in sys.argv[1:] if word.startswith("__")]
        os.execvp(command[0], command)
    elif words[:1] == ["run"] and len(words) == 7:
        run(*words[1:])
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
