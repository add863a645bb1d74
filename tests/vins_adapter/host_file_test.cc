// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The host's own file, VINS-Mono's and VINS-Fusion's.
#include "slim_init/vins_adapter/host_file.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "evaluation/scratch_folder.h"
#include "support/text_parts.h"

namespace slim_init::vins_adapter {
namespace {

class HostFileTest : public ::testing::Test {
 protected:
  HostFileTest() {
    euroc_ = readFile(std::string(SLIM_INIT_SOURCE_DIR) + "/config/euroc.yaml");
    for (const char* line : {"initializer: slim\n", "reinit: 1\n"}) euroc_ = edited(line, "");
  }
  std::string write(const std::string& name, const std::string& text) {
    folder_.write(name, text);
    return folder_.file(name);
  }
  // The host's file with this text, as read into file_, and the adapter made of it.
  const HostFile& reading(const std::string& text) {
    EXPECT_TRUE(readHostFile(write("host.yaml", text), &file_, &error_)) << error_;
    return file_;
  }
  std::unique_ptr<HostAdapter> opened(const std::string& text) {
    auto adapter = openHostFile(write("host.yaml", text), &file_, &error_);
    EXPECT_NE(adapter, nullptr) << error_;
    return adapter;
  }
  void expectRefused(const std::string& keys, const std::string& sentence) {
    const std::string path = write("host.yaml", "%YAML:1.0\n" + keys);
    EXPECT_FALSE(readHostFile(path, &file_, &error_));
    EXPECT_EQ(error_, path + ": " + sentence);
  }
  // euroc.yaml with `from` replaced.
  std::string edited(const std::string& from, const std::string& to) const {
    std::string text = euroc_;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  const ScratchFolder folder_;
  std::string euroc_;  // without our switches
  HostFile file_;
  std::string error_;
};

TEST_F(HostFileTest, AbsentKeysAreAnUnpatchedHost) {
  file_.mode = HostMode::kSlim;
  EXPECT_EQ(reading(euroc_).mode, HostMode::kStock);
  EXPECT_FALSE(file_.reinit);
  EXPECT_FALSE(file_.watchdog);
  EXPECT_FALSE(file_.keep_heading);
  EXPECT_EQ(file_.max_wait_ms, 10.0);
  EXPECT_FALSE(file_.output_path.empty());
}

// Its rows compare solves that have finished; an estimate that is no success helps no such host.
TEST_F(HostFileTest, ShadowModeWaitsAndProvisionalEstimatesAreOff) {
  const auto adapter = opened(edited("slim_init:\n",
                                     "initializer: shadow\nslim_init:\n"
                                     "  provisional:\n    enabled: 1\n"));
  ASSERT_NE(adapter, nullptr);
  EXPECT_EQ(adapter->options().max_wait_ms, -1.0);
  ASSERT_EQ(file_.notes.size(), 1u);
  expectParts(file_.notes[0], "provisional.enabled is set and has no effect");
}

// GVINS has output_dir and puts $HOME in place of a ~ in front; output_path goes first and is as
// the other hosts take it.
TEST_F(HostFileTest, TheFolderForResultsOfGvins) {
  const char* home = std::getenv("HOME");
  ASSERT_NE(home, nullptr);
  const std::string line = "output_path: \"/tmp\"";
  const auto folder = [this, &line](const std::string& lines) {
    return reading(edited(line, lines)).output_path;
  };
  EXPECT_EQ(folder("output_dir: \"/var/tmp\""), "/var/tmp");
  EXPECT_EQ(folder("output_dir: \"~/output/\""), std::string(home) + "/output/");
  EXPECT_EQ(folder("output_path: \"/a\"\noutput_dir: \"/b\""), "/a");
  EXPECT_EQ(folder("output_path: \"~/output\""), "~/output");
  EXPECT_EQ(folder("no_folder: 1"), "");
}

TEST_F(HostFileTest, OurKeysAndDefaults) {
  const auto adapter = opened(edited("slim_init:\n",
                                     "initializer: slim\nreinit: 1\nslim_init:\n"
                                     "  window:\n    max_span_s: 2\n"
                                     "  imu:\n    max_accel: 300\n"));
  ASSERT_NE(adapter, nullptr);
  EXPECT_EQ(file_.mode, HostMode::kSlim);
  EXPECT_TRUE(adapter->options().reinit);
  EXPECT_TRUE(adapter->options().watchdog);  // as reinit
  EXPECT_TRUE(file_.keep_heading);           // as reinit
  EXPECT_EQ(adapter->options().imu.max_accel, 300.0);
  EXPECT_EQ(adapter->options().imu.max_gyro, ImuLimits().max_gyro);
  EXPECT_EQ(adapter->addImu(1.0, Eigen::Vector3d(299.0, 0, 0), Eigen::Vector3d::Zero()),
            AddStatus::kAdded);
  EXPECT_EQ(adapter->addImu(1.1, Eigen::Vector3d(301.0, 0, 0), Eigen::Vector3d::Zero()),
            AddStatus::kGlitch);
  EXPECT_EQ(adapter->info().method, "slim");
  // Keys in the file win; the rest are the defaults of everything else.
  EXPECT_EQ(adapter->info().window_span_s, 2.0);
  // acc_n and gyr_n are in the file and are not densities; both densities are, so no note.
  EXPECT_EQ(adapter->info().calibration.imu_noise.accel_density, 2.0e-3);
  EXPECT_TRUE(file_.notes.empty()) << file_.notes.front();
}

// The lines that docs/vins_mono.md gives for the file_, comments included.
TEST_F(HostFileTest, TheGuidesLinesAreRead) {
  const std::string guide = readFile(std::string(SLIM_INIT_SOURCE_DIR) + "/docs/vins_mono.md");
  const std::string fence = "```yaml\n";
  const std::size_t begin = guide.find(fence) + fence.size();
  const std::string lines = guide.substr(begin, guide.find("```", begin) - begin);
  ASSERT_TRUE(contains(lines, "slim_init:\n"));
  const auto adapter = opened(euroc_.substr(0, euroc_.find("slim_init:\n")) + lines);
  ASSERT_NE(adapter, nullptr);
  EXPECT_EQ(file_.mode, HostMode::kSlim);
  EXPECT_TRUE(file_.reinit);
  EXPECT_TRUE(file_.notes.empty()) << file_.notes.front();
}

TEST_F(HostFileTest, VinsFusionsLayout) {
  write("cam0.yaml",
        "%YAML:1.0\n---\nmodel_type: PINHOLE\nimage_width: 752\nimage_height: 480\n"
        "distortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 0.0\n   p2: 0.0\n"
        "projection_parameters:\n   fx: 458.0\n   fy: 457.0\n   cx: 367.0\n   cy: 248.0\n");
  const std::string text =
      "%YAML:1.0\nimu: 1\nnum_of_cam: 1\nimage0_topic: \"/cam0/image_raw\"\n"
      "cam0_calib: \"cam0.yaml\"\nestimate_extrinsic: 0\n" +
      matrixKey("body_T_cam0", 4, 4,
                "0., -1., 0., 0.1, 1., 0., 0., 0.2, 0., 0., 1., 0.3, 0., 0., 0., 1.") +
      "g_norm: 9.81\ninitializer: shadow\n";
  const auto adapter = opened(text);
  ASSERT_NE(adapter, nullptr);
  EXPECT_EQ(file_.mode, HostMode::kShadow);
  const Calibration calibration = adapter->info().calibration;
  EXPECT_EQ(calibration.t_b_c, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_NEAR(calibration.R_b_c(1, 0), 1.0, 1e-12);
  EXPECT_NEAR(calibration.focal_px, 457.5, 0.1);
  // What is left of VINS-Mono's file, the host does not read.
  const std::string stale =
      matrixKey("extrinsicRotation", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") +
      "image_topic: \"/stale\"\n";
  const auto by_matrix = opened(text + stale);
  ASSERT_NE(by_matrix, nullptr) << error_;
  EXPECT_NEAR(by_matrix->info().calibration.R_b_c(1, 0), 1.0, 1e-12);
  ASSERT_EQ(file_.notes.size(), 3u) << "and the noise densities";
  expectParts(file_.notes[0], "extrinsicRotation is ignored");

  std::string full_name = text;
  full_name.replace(text.find("cam0.yaml"), 9, folder_.file("cam0.yaml"));
  const auto by_full_name = opened(full_name);
  ASSERT_NE(by_full_name, nullptr) << error_;
  EXPECT_NEAR(by_full_name->info().calibration.focal_px, 457.5, 0.1);
  EXPECT_TRUE(file_.rig.extrinsic_in_one_matrix);
  EXPECT_TRUE(file_.rig.has_rotation);

  for (const auto& [key, value] : {std::pair("num_of_cam: 1", '2'), std::pair("imu: 1", '0')}) {
    std::string other = text;
    other[other.find(key) + std::strlen(key) - 1] = value;
    EXPECT_EQ(openHostFile(write("host.yaml", other), nullptr, &error_), nullptr) << key;
    expectParts(error_, "host.yaml: num_of_cam is ");
  }

  // Without the matrix: looked for where the host does so as well.
  const std::size_t matrix = text.find("body_T_cam0");
  std::string without = text.substr(0, matrix) + text.substr(text.find("g_norm"));
  EXPECT_EQ(openHostFile(write("host.yaml", without), nullptr, &error_), nullptr);
  expectParts(error_, "body_T_cam0 is missing; it is needed unless");
  without.replace(without.find("estimate_extrinsic: 0"), 21, "estimate_extrinsic: 2");
  ASSERT_NE(openHostFile(write("host.yaml", without), &file_, &error_), nullptr) << error_;
  EXPECT_TRUE(file_.rig.extrinsic_in_one_matrix);
  EXPECT_FALSE(file_.rig.has_rotation);
  write("host.yaml", text);

  // What is wrong in the camera's file is said to be there.
  write("cam0.yaml", "%YAML:1.0\n---\nmodel_type: PINHOLE\n");
  const std::string host = folder_.file("host.yaml"), camera = folder_.file("cam0.yaml");
  EXPECT_EQ(openHostFile(host, &file_, &error_), nullptr);
  expectParts(error_, "host.yaml: cam0_calib, " + camera + ": image_width is missing");
  std::filesystem::remove(camera);
  EXPECT_EQ(openHostFile(host, &file_, &error_), nullptr);
  expectParts(error_, "cam0.yaml: the file cannot be opened");
}

TEST_F(HostFileTest, WhatTheHostEstimatesIsHandedOver) {
  auto adapter = opened(euroc_);
  ASSERT_NE(adapter, nullptr);
  EXPECT_FALSE(adapter->options().estimate_td);
  EXPECT_FALSE(adapter->options().estimate_extrinsic);
  EXPECT_EQ(adapter->options().image_height, 480);
  EXPECT_TRUE(file_.rig.has_rotation);

  const std::size_t rotation = euroc_.find("\nextrinsicRotation"),
                    end = euroc_.find("]", euroc_.find("\nextrinsicTranslation")) + 1;
  const std::string switches[][2] = {{"estimate_td: 0", "estimate_td: 1"},
                                     {"estimate_extrinsic: 0", "estimate_extrinsic: 2"}};
  std::string text = euroc_.substr(0, rotation) + euroc_.substr(end);
  for (const auto& [from, to] : switches) {
    ASSERT_NE(text.find(from), std::string::npos);
    text.replace(text.find(from), from.size(), to);
  }
  adapter = opened(text);
  ASSERT_NE(adapter, nullptr);
  EXPECT_TRUE(adapter->options().estimate_td);
  EXPECT_TRUE(adapter->options().estimate_extrinsic);
  EXPECT_FALSE(file_.rig.has_rotation);
  EXPECT_FALSE(file_.rig.extrinsic_in_one_matrix);
  EXPECT_EQ(adapter->info().calibration.sigmas.td_s, 0.03);
  EXPECT_EQ(adapter->info().calibration.sigmas.rotation_deg, 180.0);
  ASSERT_EQ(file_.notes.size(), 1u);
  expectParts(file_.notes[0], "two axes");
}

TEST_F(HostFileTest, RefusesWithFileKeyAndBound) {
  expectRefused("initializer: Slim\n", "initializer is \"Slim\", must be stock, slim or shadow");
  EXPECT_TRUE(reading("%YAML:1.0\nreinit: 1\nwatchdog: 0\n").reinit);
  EXPECT_FALSE(file_.watchdog);
  EXPECT_TRUE(file_.keep_heading);
  EXPECT_TRUE(reading("%YAML:1.0\nreinit: 1\nkeep_heading: 0\n").watchdog);
  EXPECT_FALSE(file_.keep_heading);
  expectRefused("watchdog: 3\n", "watchdog is 3, must be 0, 1, true or false");
  expectRefused("reinit: 2\n", "reinit is 2, must be 0, 1, true or false");
  for (const std::string inside : {"-1", "1000.0"}) {
    EXPECT_EQ(reading("%YAML:1.0\nmax_wait_ms: " + inside + "\n").max_wait_ms, std::stod(inside));
  }
  for (const std::string outside : {"-1.5", "1000.5"}) {
    expectRefused("max_wait_ms: " + outside + "\n",
                  "max_wait_ms is " + outside + ", must be in [-1, 1000]");
  }
  EXPECT_FALSE(readHostFile(folder_.file("absent.yaml"), &file_, &error_));
  expectParts(error_, "absent.yaml: the file cannot be opened");
}

}  // namespace
}  // namespace slim_init::vins_adapter
