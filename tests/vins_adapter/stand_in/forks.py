#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Writes the stand-in of a host: a folder of this one, or a fork of another host with what is
different in it, and with the files of its own that the folder of its name has.

    forks.py NAME FOLDER    FOLDER must not exist
"""
import os
import shutil
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))


class Fork:
    """base: the host that it is a fork of.
    folders: where its folders and files are in the fork, {of the base: of the fork}; "." is the root.
    changes: {file of the fork: [(text of the base, text of the fork), ..]}; a text of the base has
    to occur once. None instead of the list: the fork does not have that file of the base."""

    def __init__(self, base, folders, changes):
        self.base, self.folders, self.changes = base, folders, changes


def feature_parts(lines):
    """Settings of host_parts.h."""
    include = '#include "host_parts.h"'
    return [(include, lines + include)]


def called(name, binary):
    """The build files of a package of that name."""
    return {"package.xml": [("<name>vins_estimator<", "<name>%s<" % name)],
            "CMakeLists.txt": [("project(vins_estimator)", "project(%s)" % name),
                               ("add_executable(vins_estimator ", "add_executable(%s " % binary),
                               ("target_link_libraries(vins_estimator ",
                                "target_link_libraries(%s " % binary)]}


PL_VINS_IMAGE = ("const map<int, vector<pair<int, Eigen::Matrix<double, 5, 1>>>> &image, "
                 "const map<int, vector<pair<int, Vector4d>>> &lines, "
                 "const std_msgs::Header &header")
PL_VINS_OLD_IMAGE = ("const map<int, vector<pair<int, Vector3d>>> &image, "
                     "const std_msgs::Header &header")


def with_its_overloads(text):
    """PL-VINS has processImage() twice; the node does not call the older one. And its optimization
    with lines, which is the one in flight, ends in a double2vector2()."""
    end = text[text.index("void Estimator::double2vector()"):]
    end = end[:end.index("\n}\n") + 3]
    text = text.replace(end, end + "\n" + end.replace("double2vector()", "double2vector2()"))
    start = text.index("void Estimator::processImage")
    body = text[text.index("{\n", start):]
    return (text[:start] + "void Estimator::processImage(%s)\n" % PL_VINS_IMAGE +
            body.replace("{\n", "{\n    (void)lines;\n", 1) +
            "\n// An older overload, which the node does not call, with the same lines.\n" +
            "void Estimator::processImage(%s)\n" % PL_VINS_OLD_IMAGE + body)


def forks():
    gvins = called("gvins", "${PROJECT_NAME}")
    pl_vins = called("plvins_estimator", "plvins_estimator")
    lvi_sam = called("lvi_sam", "${PROJECT_NAME}_visual_odometry")
    return {
        "vins_rgbd": Fork("vins_mono", {}, {
            "vins_estimator/CMakeLists.txt": [
                ("src/estimator_node.cpp src/estimator.cpp)",
                 "\n    src/estimator_node.cpp\n    src/estimator.cpp\n"
                 "    src/initial/initial_ex_rotation.cpp\n    )"),
                ("${CERES_LIBRARIES}) ", "${CERES_LIBRARIES} /opt/lib/libSophus.so)")],
            "vins_estimator/src/factor/marginalization_factor.h": feature_parts(
                "#define STAND_IN_FEATURE_SIZE 8\n"),
            "vins_estimator/src/estimator.h": [
                ("  void clearState();\n",
                 "  bool visualInitialAlignWithDepth();\n  void clearState();\n")],
            "vins_estimator/src/estimator.cpp": [("void Estimator::clearState()", """\
bool Estimator::visualInitialAlignWithDepth()
{
    return stock_succeeds;
}

void Estimator::clearState()""")],
        }),
        "gvins": Fork("vins_mono", {"vins_estimator": "estimator"}, {
            "estimator/package.xml": gvins["package.xml"],
            "estimator/CMakeLists.txt": gvins["CMakeLists.txt"] + [
                ("${CERES_LIBRARIES}) ", "${CERES_LIBRARIES})")],
            "estimator/src/estimator.h": [
                ("  IntegrationBase*", "  bool first_optimization = false;\n  IntegrationBase*")],
            "estimator/src/estimator_node.cpp": [
                ("#include <mutex>", "#include <memory>\n#include <mutex>"),
                ("Estimator estimator;",
                 "std::unique_ptr<Estimator> estimator_ptr(new Estimator());"),
                ("return estimator;", "return *estimator_ptr;"),
                ("(auto &imu_msg : imu)", "(auto &imu_data : imu)"),
                ("double t = imu_msg", "double t = imu_data"),
                ("estimator.td;", "estimator_ptr->td;"),
                ("estimator.processImage", "estimator_ptr->processImage"),
                ("estimator.clearState", "estimator_ptr->clearState"),
                ("estimator.setParameter", "estimator_ptr->setParameter")],
        }),
        "pl_vins": Fork("vins_mono", {}, {
            "vins_estimator/package.xml": pl_vins["package.xml"],
            "vins_estimator/CMakeLists.txt": pl_vins["CMakeLists.txt"] + [
                ("${catkin_LIBRARIES} ${OpenCV_LIBS} ${CERES_LIBRARIES}) ", "vinsEstimatorLib)"),
                # What draws includes the header of the estimator and is in a library.
                ("add_executable(",
                 "add_library(vinsEstimatorLib SHARED src/utility/visualization.cpp)\n"
                 "add_executable(")],
            "vins_estimator/src/factor/marginalization_factor.h": feature_parts("""\
#define STAND_IN_FEATURE_SIZE 5
#define STAND_IN_MANAGER_EXTRA    \\
  struct Line {                   \\
    bool is_triangulation = true; \\
  };                              \\
  std::list<Line> linefeature;
"""),
            "vins_estimator/src/estimator.h": [
                ("class Estimator : public EstimatorParts<std_msgs::Header, 1> {", """\
using Eigen::Vector4d;
using std::map;
using std::pair;
using std::vector;

class Estimator : public EstimatorParts<std_msgs::Header, 1, NoTimeOffset> {"""),
                ("const ImageFeatures& image, const std_msgs::Header& header);",
                 PL_VINS_IMAGE + ");\n  void processImage(" + PL_VINS_OLD_IMAGE +
                 ");\n  void double2vector2();")],
            "vins_estimator/src/estimator.cpp": with_its_overloads,
            "vins_estimator/src/estimator_node.cpp": [
                ("#include <mutex>\n#include <queue>\n\n", ""),
                # Its samples come one by one, and it has no restart.
                ("std::queue<sensor_msgs::ImuConstPtr> imu_buf;\nstd::mutex m_buf, m_estimator;", """
void send_imu(const sensor_msgs::ImuConstPtr &imu_msg)
{
    double t = imu_msg->header.stamp.toSec();
    ros::ignore(t);
}"""),
                ("""\
        double t = imu_msg->header.stamp.toSec();
        double img_t = img_msg->header.stamp.toSec() + estimator.td;
        (void)t;
        (void)img_t;
""", "        send_imu(imu_msg);\n"),
                ("(image, img_msg", "(image, map<int, vector<pair<int, Vector4d>>>(), img_msg"),
                ("imu_buf.push", "send_imu"),
                ("    imu_buf = std::queue<sensor_msgs::ImuConstPtr>();\n", "")],
        }),
        "lvi_sam": Fork("vins_mono", {
            "vins_estimator/src": "src/visual_odometry/visual_estimator", "vins_estimator": "."
        }, {
            "package.xml": lvi_sam["package.xml"],
            "CMakeLists.txt": lvi_sam["CMakeLists.txt"] + [
                ("add_exec",
                 'file(GLOB visual_odometry_files "src/visual_odometry/visual_estimator/*.cpp")\n'
                 "add_exec"),
                ("src/estimator_node.cpp src/estimator.cpp", "${visual_odometry_files}"),
                (" ${OpenCV_LIBS}", " ${PCL_LIBRARIES} ${OpenCV_LIBS}")],
            "src/visual_odometry/visual_estimator/factor/marginalization_factor.h": feature_parts(
                "#define STAND_IN_FEATURE_SIZE 8\n"
                "#define STAND_IN_FEATURE_EXTRA bool lidar_depth_flag = true;\n"),
            "src/visual_odometry/visual_estimator/node.h": [
                ('#include "estimator.h"\n', """\
#include "estimator.h"

/// Of the next frames; -1: no lidar odometry.
extern int lidar_reset_id;
""")],
            "src/visual_odometry/visual_estimator/estimator.h": [
                ("& image, ", "& image, const std::vector<float>& lidar_initialization_info, "),
                ("  IntegrationBase*", """\
  struct ImageFrame {
    int reset_id;
  };
  std::map<double, ImageFrame> all_image_frame;
  IntegrationBase*""")],
            "src/visual_odometry/visual_estimator/estimator.cpp": [
                ("&image, const", """\
&image,\x20
                             const std::vector<float> &lidar_initialization_info,
                             const"""),
                ('    ROS_DEBUG("Adding feature points %lu", image.size());\n', ""),
                ("    Headers[frame_count] = header;\n", """\
    Headers[frame_count] = header;
    (void)image;
    all_image_frame[header.stamp.toSec()].reset_id = static_cast<int>(lidar_initialization_info[0]);
""")],
            "src/visual_odometry/visual_estimator/estimator_node.cpp": [
                ("m_buf, m_estimator;\n", "m_buf, m_estimator;\nint lidar_reset_id = -1;\n"
                 "const std::string PROJECT_NAME = \"lvi_sam\";\n"),
                ("(image, img_msg", "(image, std::vector<float>(1, lidar_reset_id), img_msg")],
        }),
        "vins_fusion": Fork("vins_mono", {
            "vins_estimator/src/estimator.cpp": "vins_estimator/src/estimator/estimator.cpp"
        }, {
            "vins_estimator/package.xml": [("<name>vins_estimator<", "<name>vins<")],
            "vins_estimator/CMakeLists.txt": [
                ("project(vins_estimator)", "project(vins)"),
                ("add_executable(vins_estimator src/estimator_node.cpp src/estimator.cpp)",
                 "add_library(vins_lib src/estimator/estimator.cpp)"),
                ("target_link_libraries(vins_estimator ", "target_link_libraries(vins_lib "),
                ("${CERES_LIBRARIES}) ", "${CERES_LIBRARIES})")],
            "vins_estimator/src/node.h": [('"estimator.h"', '"estimator/estimator.h"')],
            "vins_estimator/src/estimator.h": None,
            "vins_estimator/src/estimator_node.cpp": None,
            "vins_estimator/src/estimator/estimator.cpp": [
                ('#include "estimator.h"\n', '#include "estimator.h"\n\n#include <ros/ros.h>\n'),
                ("    clearParts();\n", """\
    mProcess.lock();
    accBuf = gyrBuf = std::queue<std::pair<double, Vector3d>>();
    clearParts();
    mProcess.unlock();
"""),
                ("void Estimator::solveOdometry()\n{\n    optimization();\n", """\
void Estimator::processIMU(double t, double dt, const Vector3d &linear_acceleration, \
const Vector3d &angular_velocity)
{
    ros::ignore(t, dt, linear_acceleration, angular_velocity);
"""),
                ("const std_msgs::Header &header", "const double header"),
                ("if( ESTIMATE_EXTRINSIC != 2 && (header.stamp.toSec() ",
                 "if(ESTIMATE_EXTRINSIC != 2 && (header "),
                ("initial_timestamp = header.stamp.toSec();", "initial_timestamp = header;"),
                ("NON_LINEAR;\n                solveOdometry()",
                 "NON_LINEAR;\n                optimization()"),
                ("solveOdometry()", "optimization()")],
        }),
        "dynavins": Fork("vins_fusion", {"vins_estimator/src": "vins_estimator",
                                         "vins_estimator": "."}, {
            "package.xml": [("<name>vins<", "<name>dynaVINS<")],
            "CMakeLists.txt": [
                ("project(vins)", "project(dynaVINS)"),
                ("add_library(vins_lib src/estimator/",
                 "add_executable(vins_node vins_estimator/rosNodeTest.cpp vins_estimator/estimator/"),
                ("target_link_libraries(vins_lib ", "target_link_libraries(vins_node ")],
            "vins_estimator/factor/marginalization_factor.h": feature_parts("""\
#define STAND_IN_FEATURE_EXTRA \\
  double weight = 0.2;         \\
  int weightNum = 7;
"""),
        }),
    }


def moved(path, folders):
    """Of a file of the base: its path in the fork. The longest folder that holds it counts."""
    for old in sorted(folders, key=len, reverse=True):
        if path == old or path.startswith(old + "/"):
            return os.path.normpath(os.path.join(folders[old], path[len(old) + 1:]))
    return path


def changed(text, change, file):
    if callable(change):
        return change(text)
    for old, new in change:
        if text.count(old) != 1:
            raise ValueError("%s: %d times in the base: %s" % (file, text.count(old), old))
        text = text.replace(old, new)
    return text


def make(name, folder):
    """Writes the stand-in `name` to `folder`, which must not exist."""
    fork = forks().get(name)
    if os.path.isdir(os.path.join(HERE, name)):
        shutil.copytree(os.path.join(HERE, name), folder)
    if fork is None:
        return
    left = dict(fork.changes)
    with tempfile.TemporaryDirectory() as scratch:
        base = os.path.join(scratch, fork.base)
        make(fork.base, base)
        for root, _, files in os.walk(base):
            for file in files:
                path = os.path.join(root, file)
                target = moved(os.path.relpath(path, base), fork.folders)
                change = left.pop(target, [])
                if change is None:
                    continue
                with open(path, encoding="utf-8", newline="") as source:
                    text = changed(source.read(), change, target)
                os.makedirs(os.path.dirname(os.path.join(folder, target)), exist_ok=True)
                with open(os.path.join(folder, target), "w", encoding="utf-8", newline="") as out:
                    out.write(text)
    if left:
        raise ValueError("not in the base: %s" % ", ".join(left))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    make(sys.argv[1], sys.argv[2])
