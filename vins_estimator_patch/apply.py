#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Inserts slim_init into your own checkout of VINS-Mono or VINS-Fusion, or takes it out again.

Every insertion is a marked block of whole lines beside an anchor that has to be found exactly once.
Nothing else is touched, so that --revert gives back the same bytes. Either all files are written or
none. Applying twice changes nothing; applying a newer version of this tool replaces the old blocks.
"""
import argparse
import os
import re
import stat
import sys
import tempfile

BEGIN = ">>> slim_init"
END = "<<< slim_init"


class Problem(Exception):
    """A message for the user."""


class Insertion:
    """Lines of ours before or after the lines of the host that read like `anchor`.

    Whitespace does not count in the comparison: checkouts differ in indentation and line ends.
    """

    def __init__(self, anchor, where, code):
        assert where in ("before", "after")
        self.anchor = anchor if isinstance(anchor, list) else [anchor]
        self.where = where
        self.code = code.strip("\n").split("\n")


def condensed(line):
    return re.sub(r"\s+", "", line)


# ------------------------------------------------------------------------------ what is inserted

MEMBER = Insertion(
    "IntegrationBase *tmp_pre_integration;", "after", """
    slim_init::vins_adapter::HostGlue slim_init_glue;
""")

FRAME = Insertion(
    'ROS_DEBUG("Adding feature points %lu", image.size());', "after", """
    slim_init_glue.addFrame(header, image, td);
""")

AFTER_STOCK = Insertion(
    "if(result)", "before", """
            slim_init_glue.recordStock(*this, result);
""")

HEALTHY = Insertion(
    "key_poses.clear();", "before", """
        slim_init_glue.rememberHealthy(*this);
""")


# A calibration that was found is the host's starting value, also after a reset: seed() has written
# it to ric, tic and td where the host estimates them.
FOUND_CALIBRATION = """
                if (result && ESTIMATE_EXTRINSIC)
                {
                    ESTIMATE_EXTRINSIC = 1;
                    RIC[0] = ric[0];
                    TIC[0] = tic[0];
                }
                if (result && ESTIMATE_TD)
                    TD = td;"""


def indented(code):
    return code.replace("\n", "\n    ")


# What the host does after a frame that went well, once the adapter has filled its window.
def recovery(solve, finish=""):
    return Insertion(["if (failureDetection())", "{"], "after", """
            if (slim_init_glue.recover(*this))
            {""" + solve + """
                if (!failureDetection())
                {
                    slideWindow();
                    f_manager.removeFailures();
                    last_R = Rs[WINDOW_SIZE];
                    last_P = Ps[WINDOW_SIZE];
                    last_R0 = Rs[0];
                    last_P0 = Ps[0];""" + finish + """
                    return;
                }
            }
""")


# Of both nodes. The topics are private: /vins_estimator/slim_init/...
NODE_CALLBACKS = Insertion(
    "Estimator estimator;", "after", """
#include <std_msgs/Bool.h>
#include <std_msgs/String.h>

ros::Publisher slim_init_pub;

void slim_init_report(slim_init::vins_adapter::ReportLevel level, const std::string &text)
{
    using slim_init::vins_adapter::ReportLevel;
    if (level == ReportLevel::kError)
        ROS_ERROR_STREAM("slim_init: " << text);
    else if (level == ReportLevel::kWarn)
        ROS_WARN_STREAM("slim_init: " << text);
    else if (level == ReportLevel::kInfo)
        ROS_INFO_STREAM("slim_init: " << text);
    if (!slim_init_pub)
        return;
    std_msgs::String msg;
    msg.data = text;
    slim_init_pub.publish(msg);
}

void slim_init_lines_callback(const sensor_msgs::PointCloudConstPtr &lines_msg)
{
    estimator.slim_init_glue.addLines(*lines_msg);
}

void slim_init_recover_callback(const std_msgs::BoolConstPtr &reset_if_refused)
{
    estimator.slim_init_glue.requestRecovery(reset_if_refused->data);
}
""")


def node_start(config_file):
    return Insertion(
        "registerPub(n);", "after", config_file + """
    estimator.slim_init_glue.listen(slim_init_report);
    ros::Subscriber slim_init_sub_lines, slim_init_sub_recover;
    if (estimator.slim_init_glue.open(slim_init_file))
    {
        slim_init_pub = n.advertise<std_msgs::String>("slim_init/status", 1000);
        slim_init_sub_lines = n.subscribe("/feature_tracker_lines/lines", 2000, slim_init_lines_callback);
        slim_init_sub_recover = n.subscribe("slim_init/recover", 10, slim_init_recover_callback);
    }
""")


CMAKE_FIND = Insertion(
    "find_package(OpenCV REQUIRED)", "after", """
find_package(slim_init REQUIRED)
""")

PACKAGE = Insertion(
    "<run_depend>roscpp</run_depend>", "after", """
  <build_depend>slim_init</build_depend>
  <run_depend>slim_init</run_depend>
""")


def cmake_link(target, anchor):
    return Insertion(anchor, "after", "target_link_libraries(%s slim_init::vins_adapter)" % target)


VINS_MONO = {
    "vins_estimator/src/estimator.h": [
        Insertion('#include "factor/marginalization_factor.h"', "after", """
#include <slim_init/vins_adapter/host_glue.h>
"""),
        MEMBER,
    ],
    "vins_estimator/src/estimator.cpp": [
        FRAME,
        Insertion("if( ESTIMATE_EXTRINSIC != 2 && (header.stamp.toSec() - initial_timestamp) > 0.1)",
                  "before", """
            slim_init_glue.timeStock();
            if (slim_init_glue.decides())
            {
                result = slim_init_glue.seed(*this);""" + FOUND_CALIBRATION + """
            }
            else
"""),
        AFTER_STOCK,
        Insertion("TicToc t_solve;", "before", """
        if (slim_init_glue.serveRequest(*this))
        {
            clearState();
            setParameter();
            return;
        }
"""),
        recovery("""
                solveOdometry();"""),
        HEALTHY,
    ],
    "vins_estimator/src/estimator_node.cpp": [
        NODE_CALLBACKS,
        Insertion("double img_t = img_msg->header.stamp.toSec() + estimator.td;", "after", """
                estimator.slim_init_glue.addImu(
                    t,
                    Vector3d(imu_msg->linear_acceleration.x, imu_msg->linear_acceleration.y, imu_msg->linear_acceleration.z),
                    Vector3d(imu_msg->angular_velocity.x, imu_msg->angular_velocity.y, imu_msg->angular_velocity.z));
"""),
        node_start("""
    std::string slim_init_file;
    n.getParam("config_file", slim_init_file);"""),
    ],
    "vins_estimator/CMakeLists.txt": [
        CMAKE_FIND,
        cmake_link("vins_estimator", "target_link_libraries(vins_estimator ${catkin_LIBRARIES} "
                   "${OpenCV_LIBS} ${CERES_LIBRARIES})"),
    ],
    "vins_estimator/package.xml": [PACKAGE],
}

VINS_FUSION = {
    "vins_estimator/src/estimator/estimator.h": [
        Insertion('#include "../factor/marginalization_factor.h"', "after", """
#include <slim_init/vins_adapter/host_glue.h>
"""),
        MEMBER,
    ],
    "vins_estimator/src/estimator/estimator.cpp": [
        Insertion(["void Estimator::processIMU(double t, double dt, const Vector3d "
                   "&linear_acceleration, const Vector3d &angular_velocity)", "{"], "after", """
    slim_init_glue.addImu(t, linear_acceleration, angular_velocity);
"""),
        FRAME,
        Insertion("if(ESTIMATE_EXTRINSIC != 2 && (header - initial_timestamp) > 0.1)", "before", """
                slim_init_glue.timeStock();
                if (slim_init_glue.decides())
                {
                    result = slim_init_glue.seed(*this);""" + indented(FOUND_CALIBRATION) + """
                    if (result)
                        f_manager.triangulate(frame_count, Ps, Rs, tic, ric);
                }
                else
"""),
        AFTER_STOCK,
        # This host cannot reset itself here: processImage() runs inside the lock of clearState().
        Insertion("TicToc t_solve;", "before", """
        if (slim_init_glue.serveRequest(*this))
            slim_init_glue.requestReset();
"""),
        recovery("""
                f_manager.triangulate(frame_count, Ps, Rs, tic, ric);
                optimization();""", """
                    updateLatestStates();"""),
        HEALTHY,
    ],
    "vins_estimator/src/rosNodeTest.cpp": [
        NODE_CALLBACKS,
        Insertion("std::chrono::milliseconds dura(2);", "before", """
        if (estimator.slim_init_glue.takeReset())
        {
            estimator.clearState();
            estimator.setParameter();
        }
"""),
        node_start("""
    std::string slim_init_file = config_file;"""),
    ],
    "vins_estimator/CMakeLists.txt": [
        CMAKE_FIND,
        cmake_link("vins_lib", "target_link_libraries(vins_lib ${catkin_LIBRARIES} ${OpenCV_LIBS} "
                   "${CERES_LIBRARIES})"),
    ],
    "vins_estimator/package.xml": [PACKAGE],
}

FLAVOURS = {"vins-mono": VINS_MONO, "vins-fusion": VINS_FUSION}


# ------------------------------------------------------------------------------------ text of files


def comment(path, text):
    if path.endswith(".xml"):
        return "<!-- %s -->" % text
    if path.endswith("CMakeLists.txt"):
        return "# " + text
    return "// " + text


def lines_of(text):
    """Lines with their ends; "\r" alone ends none."""
    return re.findall(r"[^\n]*\n|[^\n]+", text)


def end_of(line):
    return "\r\n" if line.endswith("\r\n") else "\n" if line.endswith("\n") else ""


def stripped(path, text):
    """`text` without our blocks, and how many there were."""
    kept, opened, blocks = [], None, 0
    for number, line in enumerate(lines_of(text), 1):
        content = line.strip()
        if content == comment(path, BEGIN):
            if opened is not None:
                raise Problem("%s:%d: \"%s\" inside the block that starts in line %d; repair the "
                              "file by hand" % (path, number, BEGIN, opened))
            opened, blocks = number, blocks + 1
        elif content == comment(path, END):
            if opened is None:
                raise Problem("%s:%d: \"%s\" without its \"%s\"; repair the file by hand"
                              % (path, number, END, BEGIN))
            opened = None
            if not end_of(line) and kept:
                # The block stands behind a last line without an end, and brought that end along.
                kept[-1] = kept[-1][:-len(end_of(kept[-1]))]
        elif opened is None:
            kept.append(line)
    if opened is not None:
        raise Problem("%s:%d: \"%s\" without its \"%s\"; repair the file by hand"
                      % (path, opened, BEGIN, END))
    return "".join(kept), blocks


def anchored(path, condensed_lines, insertion):
    """Index of the first line of the anchor."""
    wanted = [condensed(line) for line in insertion.anchor]
    found = [i for i in range(len(condensed_lines) - len(wanted) + 1)
             if condensed_lines[i:i + len(wanted)] == wanted]
    if len(found) != 1:
        shown = insertion.anchor[0]
        times = "not found" if not found else "found %d times (lines %s)" % (
            len(found), ", ".join(str(i + 1) for i in found))
        raise Problem("%s: the anchor \"%s\" is %s, must be there once: this checkout differs from "
                      "the one that the tool knows" % (path, shown, times))
    return found[0]


def inserted(path, text, insertions):
    lines = lines_of(text)
    condensed_lines = [condensed(line) for line in lines]
    at = {}
    for insertion in insertions:
        first = anchored(path, condensed_lines, insertion)
        place = first if insertion.where == "before" else first + len(insertion.anchor)
        beside = lines[first if insertion.where == "before" else place - 1]
        eol = end_of(beside) or end_of(lines[0]) or "\n"
        block = "".join(line + eol for line in [comment(path, BEGIN)] + insertion.code +
                        [comment(path, END)])
        if insertion.where == "after" and not end_of(beside):
            block = eol + block[:-len(eol)]
        at.setdefault(place, []).append(block)
    result = []
    for i in range(len(lines) + 1):
        result += at.get(i, [])
        if i < len(lines):
            result.append(lines[i])
    return "".join(result)


# ---------------------------------------------------------------------------------------- the tool


def read(path):
    # One character per byte: whatever encoding the file has comes back as it was.
    with open(path, "rb") as stream:
        return stream.read().decode("latin-1")


def write_all(contents):
    """{path: text}: all of them or none."""
    staged, replaced = {}, {}
    try:
        for path, text in contents.items():
            target = os.path.realpath(path)
            handle, name = tempfile.mkstemp(prefix=".slim_init-", dir=os.path.dirname(target))
            staged[target] = name
            with os.fdopen(handle, "wb") as stream:
                stream.write(text.encode("latin-1"))
                stream.flush()
                os.fsync(stream.fileno())
            os.chmod(name, stat.S_IMODE(os.stat(target).st_mode))
        for target, name in list(staged.items()):
            before = read(target)
            os.replace(name, target)
            del staged[target]
            replaced[target] = before
    except OSError as problem:
        for target, before in replaced.items():
            with open(target, "wb") as stream:
                stream.write(before.encode("latin-1"))
        raise Problem("%s cannot be written: %s; nothing was changed"
                      % (problem.filename or "a file", problem.strerror))
    finally:
        for name in staged.values():
            if os.path.exists(name):
                os.remove(name)


def flavour_of(checkout):
    fits = [name for name, files in FLAVOURS.items()
            if all(os.path.isfile(os.path.join(checkout, path))
                   for path in files if path.endswith((".h", ".cpp")))]
    if len(fits) == 1:
        return fits[0]
    raise Problem("%s: %s; give the folder that holds vins_estimator/, and --flavour if need be"
                  % (checkout, "holds the files of both VINS-Mono and VINS-Fusion" if fits else
                     "holds neither VINS-Mono nor VINS-Fusion"))


def run(options):
    if not os.path.isdir(options.checkout):
        raise Problem("%s: no such folder" % options.checkout)
    flavour = options.flavour or flavour_of(options.checkout)
    present, bare, wanted, blocks = {}, {}, {}, 0
    for path, insertions in FLAVOURS[flavour].items():
        file = os.path.join(options.checkout, path)
        try:
            present[file] = read(file)
        except OSError as problem:
            raise Problem("%s: cannot be read: %s" % (file, problem.strerror))
        bare[file], count = stripped(file, present[file])
        blocks += count
        if not options.revert:
            wanted[file] = inserted(file, bare[file], insertions)
    if options.revert:
        wanted = bare
    changed = {file: text for file, text in wanted.items() if text != present[file]}
    total = sum(len(insertions) for insertions in FLAVOURS[flavour].values())

    if options.revert:
        done = "%d insertions taken out of %d files" % (blocks, len(changed))
        todo = "%d insertions in %d files can be taken out" % (blocks, len(changed))
        nothing = "nothing of slim_init is in it"
    else:
        done = "%d insertions in %d files" % (total, len(wanted))
        todo = "%d insertions in %d files can be made" % (total, len(wanted))
        if blocks:
            done += ", in place of %d earlier ones" % blocks
            todo += ", in place of %d earlier ones" % blocks
        nothing = "already applied, %d insertions in %d files" % (total, len(wanted))
    if not changed:
        return "%s: %s" % (flavour, nothing)
    if options.check:
        return "%s: %s" % (flavour, todo)
    write_all(changed)
    return "%s: %s" % (flavour, done)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("checkout", metavar="CHECKOUT", help="folder that holds vins_estimator/")
    parser.add_argument("--check", action="store_true", help="print what would be done and stop")
    parser.add_argument("--revert", action="store_true", help="remove all insertions")
    parser.add_argument("--flavour", choices=sorted(FLAVOURS), help="default: detected")
    try:
        print(run(parser.parse_args()))
    except Problem as problem:
        print("apply.py: %s" % problem, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
