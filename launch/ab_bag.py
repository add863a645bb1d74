#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""The working part of ab_bag.launch.

ab_bag.py run BAG CONFIG OUT METHODS RATE HOST TRACKER
    HOST true: plays BAG twice through the patched host, which initializes by itself the first time
    and is initialized by slim the second, and compares the two odometries, with the ground truth in
    BAG.groundtruth.csv if that file exists. Then, in any case, the methods off line.
"""
import contextlib
import csv
import html
import math
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np

MODES = ("stock", "slim")
ODOMETRY = "vins_result_no_loop.csv"  # VINS-Mono writes it into output_path, a row a frame
EARLY_S = 2.0  # of odometry, over which the scale at the start is fitted
QUIET_S = 2.0  # without a new row, and the host has worked off what was played
OFF_SCALE = 0.25  # a start that is off by more counts as incorrect
DRIFTED_M = 1.0


def fail(sentence):
    sys.exit("ab_bag: " + sentence)


def read(path):
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except OSError as error:
        fail("%s cannot be read: %s" % (path, error.strerror))


def read_config(path):
    """The text of a configuration file, which names files beside it with their whole paths."""
    folder = os.path.dirname(os.path.abspath(path))
    return re.sub(r'(?m)^((?:mask|fisheye_mask|cam0_calib)[ \t]*:[ \t]*"?)([^"#\s]+)',
                  lambda found: found.group(1) + os.path.join(folder, found.group(2)), read(path))


def with_key(text, key, value):
    """The file with `key: value` at top level: in place of the line there, or at its end."""
    line = '%s: "%s"' % (key, value)
    text, count = re.subn(r"(?m)^%s[ \t]*:.*$" % re.escape(key), lambda _: line, text)
    return text if count else text.rstrip("\n") + "\n" + line + "\n"


def config_of(text, mode, out):
    if mode == "stock":  # the host alone: slim_init would recover it, too
        for key in ("reinit", "watchdog", "keep_heading"):
            text = re.sub(r"(?m)^%s[ \t]*:.*$" % key, key + ": 0", text)
    return with_key(with_key(text, "initializer", mode), "output_path", out)


def topics_of(text, keys):
    """Those of `keys` that have a value in the file."""
    found = [re.search(r'(?m)^%s[ \t]*:[ \t]*"?([^"#\s]+)' % key, text) for key in keys]
    return [topic.group(1) for topic in found if topic]


def topic_of(text, key):
    return (topics_of(text, [key]) or fail("the configuration file has no %s" % key))[0]


# ------------------------------------------------------------------------------------- odometries


def table_of(path, columns, what):
    """Rows that begin with a stamp [ns], which becomes seconds, with `columns` numbers each; sorted by
    stamp, of equal stamps the last. A host that was killed while it wrote leaves half a row."""
    rows = {}
    for line in read(path).splitlines():
        try:
            row = [float(word) for word in line.split(",")[:columns]]
        except ValueError:
            continue
        if len(row) == columns and all(map(math.isfinite, row)):
            rows[row[0]] = [row[0] * 1e-9] + row[1:]
    if not rows and what:
        fail("%s has no %s" % (path, what))
    return np.array([rows[stamp] for stamp in sorted(rows)]).reshape(-1, columns)


def interpolated(table, t):
    """Columns of `table` behind the stamp at the times `t`, linear between its rows."""
    return np.array([np.interp(t, table[:, 0], table[:, k]) for k in range(1, table.shape[1])]).T


def at(truth, t):
    """Positions on `truth` at the times `t`; NaN outside it and in gaps of 0.1 s."""
    stamps = truth[:, 0]
    after = np.clip(np.searchsorted(stamps, t), 1, len(truth) - 1)
    near = (stamps[after] - stamps[after - 1] <= 0.1) | (stamps[after] == t) | (stamps[0] == t)
    known = near & (t >= stamps[0]) & (t <= stamps[-1])
    return np.where(known[:, None], interpolated(truth, t), np.nan)


def heading(yaw):
    """The rotation about z."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def fitted(p, q, with_scale):
    """Scale, scaled rotation and translation that bring the rows of `p` closest to those of `q`:
    rotation about z only, since gravity is observed."""
    u, v = p - p.mean(axis=0), q - q.mean(axis=0)
    cross, dot = np.sum(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]), np.sum(u[:, :2] * v[:, :2])
    square = np.sum(u ** 2)
    scale = 1.0
    if with_scale and square > 0.0:
        scale = float((math.hypot(dot, cross) + np.sum(u[:, 2] * v[:, 2])) / square)
    turn = scale * heading(math.atan2(cross, dot))
    return scale, turn, q.mean(axis=0) - turn @ p.mean(axis=0)


def measured(odometry, truth, began):
    """What is known of a run, from rows of stamp and position. Times from `began` [s]; without ground
    truth there are times alone."""
    result = {"frames": len(odometry), "first_s": None, "scale": None, "scale_run": None,
              "ate_m": None, "drift_m": None, "path_m": None, "errors": np.zeros((0, 2)),
              "aligned": odometry[:, 1:]}
    if not len(odometry):
        return result
    result["first_s"] = odometry[0, 0] - began
    if not len(truth):
        return result
    q = at(truth, odometry[:, 0])
    known = np.isfinite(q[:, 0])
    t, p, q = odometry[known, 0], odometry[known, 1:], q[known]
    early = t <= odometry[0, 0] + EARLY_S
    if np.sum(early) >= 5:
        # Scale of the odometry: what the truth has to be multiplied by.
        result["scale"] = fitted(q[early], p[early], True)[0]
    if len(t) >= 5:
        _, turn, shift = fitted(p, q, False)
        errors = np.linalg.norm(p @ turn.T + shift - q, axis=1)
        result.update({
            "scale_run": fitted(q, p, True)[0], "ate_m": math.sqrt(np.mean(errors ** 2)),
            "drift_m": np.max(errors), "errors": np.column_stack([t - began, errors]),
            "path_m": np.sum(np.linalg.norm(np.diff(q, axis=0), axis=1)),
            "aligned": odometry[:, 1:] @ turn.T + shift})
    return result


COLUMNS = [("first odometry [s]", "first_s", "%.2f"), ("frames", "frames", "%d"),
           ("scale, first %g s" % EARLY_S, "scale", "%.3f"), ("scale, whole run", "scale_run", "%.3f"),
           ("ATE [m]", "ate_m", "%.3f"), ("largest error [m]", "drift_m", "%.2f"),
           ("path [m]", "path_m", "%.1f")]


def shown(value, form):
    return "-" if value is None else form % value


def verdict(results, has_truth):
    """The comparison in sentences."""
    lines = []
    for mode in MODES:
        r = results[mode]
        if r["first_s"] is None:
            lines.append("%s never gave odometry." % mode)
        elif not has_truth:
            lines.append("%s gave odometry after %.2f s." % (mode, r["first_s"]))
        elif r["scale"] is None:
            lines.append("%s: the ground truth does not cover its first seconds." % mode)
        else:
            off = abs(r["scale"] - 1.0)
            words = "%s started after %.2f s with a scale of %.3f, %s" % (
                mode, r["first_s"], r["scale"],
                "incorrect" if off > OFF_SCALE else "%.0f %% off" % (100.0 * off))
            if r["drift_m"] is not None:
                words += ", and %s (largest error %.2f m)" % (
                    "drifted" if r["drift_m"] > DRIFTED_M else "did not drift", r["drift_m"])
            lines.append(words + ".")
    if not has_truth:
        lines.append("No ground truth beside the bag (BAG.groundtruth.csv): only start times are "
                     "reported.")
        return lines
    known = {mode: results[mode]["ate_m"] for mode in MODES}
    if None not in known.values():
        better = min(MODES, key=lambda mode: known[mode])
        other = [mode for mode in MODES if mode != better][0]
        lines.append("%s was closer to the ground truth: ATE %.3f m, %s %.3f m." % (
            better, known[better], other, known[other]))
    return lines


def table(results):
    rows = [["run"] + [title for title, _, _ in COLUMNS]]
    for mode in MODES:
        rows.append([mode] + [shown(results[mode][key], form) for _, key, form in COLUMNS])
    return rows


def draw(results, truth, path):
    """A picture of trajectories and errors; False without matplotlib."""
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        return False
    figure, (above, errors) = plt.subplots(1, 2, figsize=(12, 5))
    above.plot(truth[:, 1], truth[:, 2], color="0.6", label="ground truth" if len(truth) else None)
    for mode, colour in zip(MODES, ("tab:orange", "tab:blue")):
        r = results[mode]
        above.plot(r["aligned"][:, 0], r["aligned"][:, 1], color=colour, label=mode)
        errors.plot(r["errors"][:, 0], r["errors"][:, 1], color=colour, label=mode)
    above.set(xlabel="x [m]", ylabel="y [m]", title="top view", aspect="equal")
    errors.set(xlabel="since the bag's start [s]", ylabel="[m]", title="position error")
    above.legend()
    errors.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return True


def write_page(results, truth, bag, out):
    lines = verdict(results, len(truth) > 0)
    rows = table(results)
    pictured = draw(results, truth, os.path.join(out, "ab_bag.png"))
    with open(os.path.join(out, "ab_bag.csv"), "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(rows)
    cells = "\n".join("<tr>%s</tr>" % "".join(
        "<%s>%s</%s>" % (tag, html.escape(cell), tag) for cell in row)
        for tag, row in zip(["th"] + ["td"] * len(MODES), rows))
    page = """<!DOCTYPE html>
<html><head><meta charset="utf-8"><title>stock and slim on %s</title>
<style>body{font-family:sans-serif;max-width:70em;margin:2em auto}td,th{padding:.3em .8em;
text-align:right}img{max-width:100%%}</style></head><body>
<h1>stock and slim on %s</h1>
<p>%s</p>
<table>
%s
</table>
<p>Both runs: the whole bag through the same patched host, which initialized by itself (stock) or was
initialized (slim). Times since the bag's start. Scale: of the odometry's path to the true one, 1 is
right. Errors after a fit of position and heading over the run.</p>
%s
</body></html>
""" % (html.escape(os.path.basename(bag)), html.escape(os.path.basename(bag)),
       "<br>\n".join(map(html.escape, lines)), cells,
       '<img src="ab_bag.png" alt="ways and errors">' if pictured else "<p>No picture: matplotlib is "
       "not installed.</p>")
    with open(os.path.join(out, "ab_bag.html"), "w", encoding="utf-8") as file:
        file.write(page)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return lines + ["  ".join(cell.rjust(width) for cell, width in zip(row, widths))
                    for row in rows]


# --------------------------------------------------------------------------------------- the runs


def begin_of(bag):
    """Time of the first message [s]."""
    done = subprocess.run(["rosbag", "info", "--yaml", "--key=start", bag], stdout=subprocess.PIPE,
                          universal_newlines=True, check=False)
    try:
        return float(done.stdout.split()[0])
    except (IndexError, ValueError):
        fail("%s: rosbag info gives no start" % bag)


def play(bag, text, rate, mode):
    topics = [topic_of(text, "imu_topic"), topic_of(text, "image_topic")]
    # The stock host does not listen to it, and would be waited for.
    topics += topics_of(text, ["speed_topic"]) if mode == "slim" else []
    # What is played before the nodes listen is lost; the delay is for the slowest of them.
    return subprocess.call(["rosbag", "play", "--clock", "--quiet", "--wait-for-subscribers",
                            "--delay=3", "--rate", rate, bag, "--topics"] + topics)


@contextlib.contextmanager
def host(config, own, log, tracker, sim_time="true"):
    """VINS-Mono in a roslaunch of its own, with `config` for the tracker and `own` for the
    estimator; ends with the block."""
    with open(log, "w", encoding="utf-8") as sink:
        # A process group of its own: a signal to us must not reach it twice. The nodes run in a
        # folder of their own.
        launch = subprocess.Popen(
            ["roslaunch", "slim_init", "vins_mono_slim.launch",
             "config:=" + os.path.abspath(config), "estimator_config:=" + own,
             "sim_time:=" + sim_time, "tracker:=" + tracker, "rviz:=false"],
            stdout=sink, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            yield launch
            if launch.poll() is not None:
                fail("the host ended with %d; see %s" % (launch.returncode, log))
        finally:
            end(launch)


def wait_until_quiet(path):
    """Until the file has not grown for QUIET_S."""
    size, since = -1, time.monotonic()
    while time.monotonic() - since < QUIET_S:
        now = os.path.getsize(path) if os.path.exists(path) else 0
        if now != size:
            size, since = now, time.monotonic()
        time.sleep(0.1)


def prepare(folder, text, mode):
    """Makes the folder of a run. Returns its configuration file, the odometry that the host writes and
    the log."""
    os.makedirs(folder, exist_ok=True)
    own, odometry, log = (os.path.join(folder, name)
                          for name in ("host.yaml", ODOMETRY, "roslaunch.log"))
    if os.path.exists(odometry):
        os.remove(odometry)  # the host appends
    with open(own, "w", encoding="utf-8") as file:
        file.write(config_of(text, mode, folder))
    return own, odometry, log


def fly(mode, bag, config, text, out, rate, tracker):
    """One run of the host over the whole bag; its odometry."""
    folder = os.path.join(out, mode)
    own, odometry, log = prepare(folder, text, mode)
    print("\n==> %s: the host plays the whole bag (%s)" % (mode, log), flush=True)
    with host(config, own, log, tracker) as launch:
        played = play(bag, text, rate, mode)
        if launch.poll() is None and played != 0:
            fail("%s could not be played" % bag)
        if launch.poll() is None:
            wait_until_quiet(odometry)
    if mode == "slim" and not os.path.exists(os.path.join(folder, "slim_init_starts.csv")):
        fail("the host left no slim_init_starts.csv in %s: is its estimator patched "
             "(vins_estimator_patch/README.md)?" % folder)
    return table_of(odometry, 4, None) if os.path.exists(odometry) else np.zeros((0, 4))


def end(launch):
    """Ends what we have started, as a keypress would."""
    for sign, patience in ((signal.SIGINT, 20.0), (signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0)):
        if launch.poll() is not None:
            return
        try:
            os.killpg(launch.pid, sign)
            launch.wait(patience)
        except (ProcessLookupError, subprocess.TimeoutExpired):
            pass


def run(bag, config, out, methods, rate, host, tracker):
    out = os.path.abspath(out)
    os.makedirs(out, exist_ok=True)
    if host == "true":
        text = read_config(config)
        began = begin_of(bag)
        truth_file = bag + ".groundtruth.csv"
        truth = (table_of(truth_file, 4, "poses") if os.path.exists(truth_file)
                 else np.zeros((0, 4)))
        results = {mode: measured(fly(mode, bag, config, text, out, rate, tracker), truth, began)
                   for mode in MODES}
        report = write_page(results, truth, bag, out)
        print("\n==> Who is right (%s)" % os.path.join(out, "ab_bag.html"))
        print("\n".join("    " + line for line in report), flush=True)
    print("\n==> Off line, every window", flush=True)
    code = subprocess.call(["rosrun", "slim_init", "slim_init", "ab", "--bag", bag, "--config",
                            config, "--methods", methods, "--out", os.path.join(out, "ab")])
    if code != 0:
        fail("slim_init ab ended with %d" % code)
    # A master that roslaunch has started keeps roslaunch running.
    print("\n==> Done: %s. Ctrl-C ends roslaunch where it has started the master."
          % os.path.join(out, "ab_bag.html" if host == "true" else "ab"), flush=True)


def main():
    # A signal ends the host as well: the clean-up is in a finally.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    # roslaunch adds __name:=.. and __log:=.. for nodes that know ROS.
    words = [word for word in sys.argv[1:] if not word.startswith("__")]
    if words[:1] == ["run"] and len(words) == 8:
        run(*words[1:])
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
