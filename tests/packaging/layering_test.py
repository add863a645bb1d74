#!/usr/bin/env python3
# Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
"""Planted violations: layering.py finds each and names it, and nothing in a tree that is in order."""
import os
import sys
import unittest

import layering
from scratch import Scratch, run_to_end

FILES = {
    "slim_init/include/slim_init/types.h": "#include <Eigen/Core>\n",
    "slim_init/src/a.cc": '#include <vector>\n#include "slim_init/types.h"\n',
    "slim_init/simulation/include/slim_init/simulation/world.h": "\n",
    "slim_init/evaluation/src/b.cc": "#include <nlohmann/json.hpp>\n",
}
LINKS = ("slim_init_core:Eigen3::Eigen\nslim_init_evaluation:slim_init_core;"
         "$<BUILD_INTERFACE:nlohmann_json::nlohmann_json>\n")


class Layering(Scratch):
    def violations(self, files=(), links=""):
        return layering.violations_of(self.new_folder({**FILES, **dict(files)}), LINKS + links)

    def test_a_tree_in_order_passes(self):
        self.assertEqual(self.violations(), [])

    def test_the_program_fails(self):
        os.makedirs(self.path("slim_init/src/elsewhere"))
        self.assertEqual(
            run_to_end(sys.executable, layering.__file__, self.folder).returncode, 1)

    def test_includes(self):
        for file, header in (
                ("slim_init/src/imu/p.cc", "<opencv2/core.hpp>"),
                ("slim_init/include/slim_init/p.h", "<ros/ros.h>"),
                ("slim_init/src/p.cc", '"slim_init/simulation/world.h"'),
                ("slim_init/evaluation/src/p.cc", '"slim_init/simulation/world.h"'),
                ("slim_init/reference/p.h", '"slim_init/types.h"'),
                ("feature_tracker_lines/src/p.cc", "<sensor_msgs/Image.h>"),
                ("vins_estimator_patch/src/p.cc", "<opencv2/core.hpp>"),
                ("vins_estimator_patch/host_health/src/p.cc",
                 '"slim_init/vins_adapter/host_state.h"'),
                ("slim_init/baselines/src/p.cc", "<ros/ros.h>"),
                ("feature_tracker_lines/ros/src/p.cc", "<rosbag/bag.h>"),
                ("vins_estimator_patch/src/p.cc", '"estimator.h"')):
            found = self.violations({file: "#include %s\n" % header})
            self.assertRegex(found[0], "^%s: the layer .* must not include %s$" % (
                file, header.strip('<>"')))

    def test_the_order_inside_the_core(self):
        for file, header in (
                ("data/p.cc", "rotation/track_pruning.h"), ("geometry/p.h", "data/p.h"),
                ("lines/p.cc", "estimation/p.h"), ("rotation/p.cc", "scale/p.h"),
                ("shape/p.cc", "rotation/p.h"), ("scale/p.cc", "verdict/p.h"),
                ("estimation/p.cc", "scale/p.h"), ("estimation/p.cc", "verdict/p.h"),
                ("verdict/p.cc", "pipeline/p.h"), ("pipeline/p.cc", "slim.h")):
            # Both exist, so that only the order can object.
            found = self.violations({"slim_init/src/" + header: "\n",
                                     "slim_init/src/" + file: '#include "%s"\n' % header})
            self.assertEqual(found, ["slim_init/src/%s: the core module %s must not include %s" % (
                file, file.split("/")[0], header)])

    def test_the_same_the_right_way_round(self):
        files = {"slim_init/src/" + header: "\n" for header in (
            "geometry/p.h", "rotation/p.h", "estimation/p.h", "verdict/p.h", "slim.h")}
        files["slim_init/src/verdict/p.cc"] = (
            '#include "verdict/p.h"\n#include "estimation/p.h"\n#include "slim_init/types.h"\n')
        files["slim_init/src/slim.cc"] = '#include "slim.h"\n#include "verdict/p.h"\n'
        self.assertEqual(self.violations(files), [])
        files["slim_init/include/slim_init/initializer.h"] = "\n"
        files["slim_init/src/verdict/p.cc"] = '#include "slim_init/initializer.h"\n'
        self.assertEqual(self.violations(files), [
            "slim_init/src/verdict/p.cc: the core module verdict must not include "
            "slim_init/initializer.h"])

    def test_modules_without_a_place_and_private_headers(self):
        self.assertEqual(self.violations({"slim_init/src/elsewhere/p.h": "\n"}), [
            "slim_init/src/elsewhere: the core module has no place in the order"])
        self.assertEqual(self.violations({"slim_init/src/geometry/p.h": "\n",
                                          "slim_init/include/slim_init/p.h":
                                          '#include "geometry/p.h"\n'}), [
            "slim_init/include/slim_init/p.h: the layer public headers must not include "
            "geometry/p.h"])

    def test_links(self):
        for line, library in (
                ("slim_init_core:Eigen3::Eigen;opencv_core", "opencv_core"),
                ("slim_init_host_health:slim_init_core;slim_init_vins_adapter",
                 "slim_init_vins_adapter"),
                ("slim_init_vins_adapter:slim_init_core;slim_init_evaluation",
                 "slim_init_evaluation"),
                ("slim_init_baselines:slim_init_core;slim_init_evaluation", "slim_init_evaluation"),
                ("slim_init_backend:slim_init_evaluation;slim_init_vins_adapter",
                 "slim_init_vins_adapter"),
                ("slim_init_simulation:slim_init_core;$<LINK_ONLY:slim_init_evaluation>",
                 "slim_init_evaluation")):
            self.assertEqual(self.violations(links=line + "\n"), [
                "%s must not link %s" % (line.split(":")[0], library)])


if __name__ == "__main__":
    unittest.main()
