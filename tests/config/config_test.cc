// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/config/config.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "support/option_checks.h"
#include "support/text_parts.h"

namespace slim_init {

using namespace feature_tracker_lines;

namespace {

const std::string kConfigDir = SLIM_INIT_SOURCE_DIR "/config/";

// A minimal host file; single lines are replaced or added by the tests.
const std::string kHostFile =
    "%YAML:1.0\nmodel_type: PINHOLE\nimage_width: 752\nimage_height: 480\n"
    "distortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 0.0002\n   p2: 0.00002\n"
    "projection_parameters:\n   fx: 458.0\n   fy: 457.0\n   cx: 367.0\n   cy: 248.0\n" +
    matrixKey("extrinsicRotation", 3, 3, "0., -1., 0., 1., 0., 0., 0., 0., 1.") +
    matrixKey("extrinsicTranslation", 3, 1, "0.1, -0.2, 0.3") +
    "acc_n: 0.08\ngyr_n: 0.004\ng_norm: 9.81\ntd: -0.01\n";

const std::string kRotation = "[0., -1., 0., 1., 0., 0., 0., 0., 1.]";

// A file that is loaded: a host's, or one of our own.
enum class FileOf { kHost, kOurs };
Config loadedFrom(const std::string& path, FileOf whose) {
  Config config;
  std::string error;
  EXPECT_TRUE(whose == FileOf::kHost ? loadConfig(path, &config, &error)
                                     : loadOptions(path, &config, &error))
      << error;
  return config;
}

class ConfigFile : public ::testing::Test {
 protected:
  std::string optionsPath() const { return path_ + ".options.yaml"; }

  void write(const std::string& text) { std::ofstream(path_) << text; }
  void writeOptions(const std::string& text) { std::ofstream(optionsPath()) << text; }

  Config loaded(const std::string& text) {
    write(text);
    return loadedFrom(path_, FileOf::kHost);
  }
  // A file of our own with these keys below slim_init:.
  Config loadedOptions(const std::string& keys) {
    writeOptions("%YAML:1.0\nslim_init:\n" + keys);
    return loadedFrom(optionsPath(), FileOf::kOurs);
  }

  // The minimal file with the first `from` replaced.
  static std::string edited(const std::string& from, const std::string& to) {
    std::string text = kHostFile;
    const std::size_t position = text.find(from);
    EXPECT_NE(position, std::string::npos) << from;
    return text.replace(position, from.size(), to);
  }

  // Loads what was written; expects failure, a message that starts with the file name and holds
  // `words`, and an untouched result.
  void expectError(const std::string& words, const std::string& file = "") {
    Config config;
    config.method = "untouched";
    std::string error;
    const bool loaded = loadConfig(path_, options_, &config, &error);
    EXPECT_FALSE(loaded);
    const std::string& named = file.empty() ? path_ : file;
    EXPECT_EQ(error.compare(0, named.size() + 2, named + ": "), 0) << error;
    EXPECT_TRUE(contains(error, words)) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_EQ(config.method, "untouched");
    EXPECT_FALSE(loadConfig(path_, options_, &config, nullptr));
  }

  void expectRefused(const std::string& text, const std::string& words) {
    write(text);
    expectError(words);
  }
  // The same for a file of our own beside the minimal one.
  void expectOptionsRefused(const std::string& text, const std::string& words) {
    write(kHostFile);
    writeOptions("%YAML:1.0\n" + text);
    options_ = optionsPath();
    expectError(words, optionsPath());
  }

  const ScratchFolder folder_;
  const std::string path_ = folder_.file("host.yaml");
  std::string options_;  // set to optionsPath() to use a second file
};

using ConfigErrors = ConfigFile;

TEST_F(ConfigFile, ReadsTheHostsKeys) {
  Config config =
      loaded(kHostFile +
             "imu_topic: \"/imu\"\nimage_topic: /cam\nmax_cnt: 200\nmin_dist: 20\nfreq: 0\n"
             "F_threshold: 1.5\nequalize: 0\nfisheye: 1\nestimate_td: 1\nunknown_to_us: {a: 1}\n");
  EXPECT_EQ(config.camera.model, CameraModel::kPinhole);
  EXPECT_EQ(config.camera.width, 752);
  EXPECT_EQ(config.camera.height, 480);
  EXPECT_EQ(config.camera.fx, 458.0);
  EXPECT_EQ(config.camera.fy, 457.0);
  EXPECT_EQ(config.camera.cx, 367.0);
  EXPECT_EQ(config.camera.cy, 248.0);
  EXPECT_EQ(config.camera.distortion, (std::array<double, 4>{-0.28, 0.07, 0.0002, 0.00002}));
  EXPECT_DOUBLE_EQ(config.calibration.focal_px, std::sqrt(458.0 * 457.0));
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_LT((config.calibration.R_b_c - R).norm(), 1e-12);
  EXPECT_EQ(config.calibration.t_b_c, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(config.calibration.gravity_magnitude, 9.81);
  EXPECT_EQ(config.calibration.td, -0.01);
  EXPECT_TRUE(config.estimate_td);
  EXPECT_EQ(config.imu_topic, "/imu");
  EXPECT_EQ(config.image_topic, "/cam");
  EXPECT_EQ(config.front_end.host.max_cnt, 200);
  EXPECT_EQ(config.front_end.host.min_dist, 20);
  EXPECT_EQ(config.front_end.host.freq, 0);
  EXPECT_EQ(config.front_end.host.F_threshold, 1.5);
  EXPECT_FALSE(config.front_end.host.equalize);
  EXPECT_TRUE(config.front_end.host.fisheye);
}

// The trap: 0.08 and 0.004 are tuning values of the host, about forty times the sensor's densities.
TEST_F(ConfigFile, HostNoiseIsNotADensity) {
  Config config = loaded(kHostFile);
  EXPECT_EQ(config.calibration.imu_noise.gyro_density, ImuNoise().gyro_density);
  EXPECT_EQ(config.calibration.imu_noise.accel_density, ImuNoise().accel_density);
  ASSERT_EQ(config.notes.size(), 1u);
  expectParts(config.notes[0], "acc_n and gyr_n");

  config = loaded(kHostFile +
                  "slim_init:\n  noise:\n    gyro_density: 3.e-4\n    accel_density: 4.e-3\n");
  EXPECT_EQ(config.calibration.imu_noise.gyro_density, 3e-4);
  EXPECT_EQ(config.calibration.imu_noise.accel_density, 4e-3);
  EXPECT_TRUE(config.notes.empty());
}

TEST_F(ConfigFile, ReadsKannalaBrandtAndMei) {
  const size_t begin = kHostFile.find("distortion_parameters");
  const size_t end = kHostFile.find("extrinsicRotation");
  std::string text = kHostFile;
  text.replace(begin, end - begin,
               "projection_parameters:\n   k2: 0.01\n   k3: 0.02\n   k4: 0.03\n   k5: 0.04\n"
               "   mu: 190.0\n   mv: 191.0\n   u0: 250.0\n   v0: 251.0\n");
  text.replace(text.find("PINHOLE"), 7, "kannala_brandt");  // the host does not mind the case
  Config config = loaded(text);
  EXPECT_EQ(config.camera.model, CameraModel::kKannalaBrandt);
  EXPECT_EQ(config.camera.distortion, (std::array<double, 4>{0.01, 0.02, 0.03, 0.04}));
  EXPECT_EQ(config.camera.fy, 191.0);
  EXPECT_EQ(config.camera.cx, 250.0);

  text = kHostFile;
  text.replace(begin, end - begin,
               "mirror_parameters:\n   xi: 1.5\ndistortion_parameters:\n   k1: 0.1\n   k2: 0.2\n"
               "   p1: 0.001\n   p2: 0.002\n   k3: 0\nprojection_parameters:\n   gamma1: 800.0\n"
               "   gamma2: 801.0\n   u0: 360.0\n   v0: 240.0\n");
  text.replace(text.find("PINHOLE"), 7, "MEI");
  config = loaded(text);
  EXPECT_EQ(config.camera.model, CameraModel::kMei);
  EXPECT_EQ(config.camera.xi, 1.5);
  EXPECT_EQ(config.camera.fx, 800.0);
  EXPECT_EQ(config.camera.distortion[3], 0.002);
}

TEST_F(ConfigFile, OurKeysOfEveryKind) {
  Config config = loaded(kHostFile +
                         "slim_init:\n"
                         "  method: slim-paper\n"
                         "  sigma_px: 1\n"  // a whole number is a number, and 10.0 is a whole one
                         "  window: {keyframes: 12.0, min_interval_s: 0.3}\n"
                         "  refinement:\n    use_lines: 0.0\n"
                         "  gates:\n    mode: off\n");
  EXPECT_EQ(config.method, "slim-paper");
  EXPECT_EQ(config.calibration.sigma_px, 1.0);
  EXPECT_EQ(config.options.window.keyframes, 12);
  EXPECT_EQ(config.options.window.min_interval_s, 0.3);
  EXPECT_FALSE(config.options.refinement.use_lines);
  EXPECT_EQ(config.options.gates.mode, GateMode::kOff);
}

TEST_F(ConfigFile, AFileOfOurOwnWins) {
  write(kHostFile + "slim_init:\n  sigma_px: 0.8\n  window: {keyframes: 12}\n");
  writeOptions("%YAML:1.0\nslim_init:\n  sigma_px: 0.4\n");
  Config config;
  std::string error;
  ASSERT_TRUE(loadConfig(path_, optionsPath(), &config, &error)) << error;
  EXPECT_EQ(config.calibration.sigma_px, 0.4);
  EXPECT_EQ(config.options.window.keyframes, 12);

  const Config options = loadedFrom(optionsPath(), FileOf::kOurs);
  EXPECT_EQ(options.calibration.sigma_px, 0.4);
  EXPECT_EQ(options.options.window.keyframes, 15);
}

// One set of bounds for the whole way from image to window.
TEST_F(ConfigFile, TheFrontEndHasTheInitializersWindowAndLimits) {
  Config config =
      loaded(kHostFile + "slim_init:\n  window: {max_imu_gap_s: 0.2}\n  imu: {max_accel: 300}\n");
  EXPECT_EQ(config.options.window.max_imu_gap_s, 0.2);
  EXPECT_EQ(config.front_end.window.max_imu_gap_s, 0.2);
  EXPECT_EQ(config.front_end.imu.max_accel, 300.0);
}

TEST_F(ConfigFile, NothingOfAnEarlierFileStays) {
  Config config = loaded(kHostFile + "slim_init:\n  sigma_px: 0.8\n");
  write(kHostFile);
  ASSERT_TRUE(loadConfig(path_, &config, nullptr));
  EXPECT_EQ(config.calibration.sigma_px, Calibration().sigma_px);
}

TEST_F(ConfigFile, RoundedRotationIsMadeARotation) {
  Config config = loaded(
      edited(kRotation, "[0.015, -0.9999, 0.004, 0.9996, 0.015, 0.0257, -0.0258, 0.0038, 0.9997]"));
  const Eigen::Matrix3d& R = config.calibration.R_b_c;
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

// What the host estimates itself is a starting value.
TEST_F(ConfigFile, HostSwitchesRaiseTheStandardDeviations) {
  const CalibrationSigmas defaults;
  Config config = loaded(kHostFile + "estimate_td: 0\nestimate_extrinsic: 0\n");
  EXPECT_EQ(config.calibration.sigmas.td_s, defaults.td_s);
  EXPECT_EQ(config.calibration.sigmas.rotation_deg, defaults.rotation_deg);
  EXPECT_EQ(config.calibration.sigmas.translation_m, defaults.translation_m);

  config = loaded(kHostFile + "estimate_td: 1\nestimate_extrinsic: 1\n");
  EXPECT_EQ(config.calibration.sigmas.td_s, 0.03);
  EXPECT_EQ(config.calibration.sigmas.rotation_deg, 5.0);
  EXPECT_EQ(config.calibration.sigmas.translation_m, 0.05);
  EXPECT_TRUE(config.front_end.use_gyro);
  ASSERT_EQ(config.notes.size(), 1u) << "the densities alone";
  // Our section stays in charge, also with a smaller value, key by key.
  config = loaded(kHostFile +
                  "estimate_td: 1\nestimate_extrinsic: 1\n"
                  "slim_init:\n  calibration_sigmas: {td_s: 0.002, rotation_deg: 2.0}\n");
  EXPECT_EQ(config.calibration.sigmas.td_s, 0.002);
  EXPECT_EQ(config.calibration.sigmas.rotation_deg, 2.0);
  EXPECT_EQ(config.calibration.sigmas.translation_m, 0.05);
}

TEST_F(ConfigFile, AnUnknownExtrinsicMayBeAbsent) {
  const std::string& text = kHostFile;
  const std::size_t rotation = text.find("extrinsicRotation"),
                    translation = text.find("extrinsicTranslation"), end = text.find("acc_n");
  const std::string unknown = "estimate_extrinsic: 2\n";
  Config config = loaded(text.substr(0, rotation) + text.substr(end) + unknown);
  EXPECT_FALSE(config.host.has_rotation);
  EXPECT_FALSE(config.host.has_translation);
  EXPECT_FALSE(config.front_end.use_gyro) << "no prediction through an unknown rotation";
  EXPECT_EQ(config.calibration.R_b_c, Eigen::Matrix3d::Identity());
  EXPECT_EQ(config.calibration.t_b_c, Eigen::Vector3d::Zero());
  EXPECT_EQ(config.calibration.sigmas.rotation_deg, 180.0);
  EXPECT_EQ(config.calibration.sigmas.translation_m, 0.1);
  expectParts(config.notes[0], "about at least two axes");
  // A translation that is given is a guess; a rotation that is given is read.
  config = loaded(text.substr(0, rotation) + text.substr(translation) + unknown);
  EXPECT_TRUE(config.host.has_translation);
  EXPECT_EQ(config.calibration.t_b_c, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(config.calibration.sigmas.translation_m, 0.05);
  config = loaded(text + unknown);
  EXPECT_TRUE(config.host.has_rotation);
  EXPECT_EQ(config.calibration.R_b_c(1, 0), 1.0);
  EXPECT_EQ(config.calibration.sigmas.rotation_deg, 180.0);
}

TEST_F(ConfigErrors, AnAbsentExtrinsicHasToBeLookedFor) {
  const std::string without = kHostFile.substr(0, kHostFile.find("extrinsicRotation")) +
                              kHostFile.substr(kHostFile.find("acc_n"));
  expectRefused(without + "estimate_extrinsic: 1\n",
                "extrinsicRotation is missing; it is needed unless estimate_extrinsic is 2");
  expectRefused(
      without + "estimate_extrinsic: 2\nslim_init:\n  calibration_sigmas: {rotation_deg: 3.0}\n",
      "extrinsicRotation is missing; it is needed if "
      "slim_init.calibration_sigmas.rotation_deg is below 90 (it is 3)");
  expectRefused(without + "estimate_extrinsic: 2\nslim_init:\n  method: drt-l\n",
                "extrinsicRotation is missing; the method drt-l needs it");
  expectRefused(kHostFile + "estimate_extrinsic: 3\n",
                "estimate_extrinsic is 3, must be in [0, 2]");
  expectRefused(kHostFile + "slim_init:\n  calibration_sigmas: {td_s: 2.0}\n",
                "slim_init.calibration_sigmas.td_s is 2, must be in [0, 0.5]");
}

TEST_F(ConfigFile, AVelocitySensorNeedsItsExtrinsic) {
  const std::string rotation = matrixKey("speed_rotation", 3, 3, "0, -1, 0, 1, 0, 0, 0, 0, 1");
  const std::string topic = std::string(kHostFile) + "speed_topic: \"/odom\"\n";
  expectRefused(topic, "speed_rotation is missing");
  expectRefused(topic + rotation, "speed_translation is missing");
  const Config config =
      loaded(topic + rotation + matrixKey("speed_translation", 3, 1, "-0.5, 0, 0.1") +
             "speed_scale_sigma: 0.05\n");
  const SpeedSensor& sensor = config.calibration.speed_sensor;
  EXPECT_TRUE(sensor.calibrated);
  EXPECT_EQ(sensor.R_b_s.col(0), Eigen::Vector3d::UnitY());
  EXPECT_EQ(sensor.t_b_s, Eigen::Vector3d(-0.5, 0.0, 0.1));
  EXPECT_EQ(sensor.scale_sigma, 0.05);
}

TEST_F(ConfigFile, RollingShutter) {
  Config config = loaded(kHostFile + "rolling_shutter: 1\nrolling_shutter_tr: 0.033\n");
  EXPECT_EQ(config.calibration.readout_s, 0.033);
  EXPECT_EQ(config.calibration.sigmas.readout_s, 0.001) << "unless our section says otherwise";
  EXPECT_EQ(config.notes.size(), 1u) << "the densities alone";
  // The switch decides, as in the host.
  config = loaded(kHostFile + "rolling_shutter: 0\nrolling_shutter_tr: 0.033\n");
  EXPECT_EQ(config.calibration.readout_s, 0.0);

  config = loaded(kHostFile + "rolling_shutter: 1\n");
  EXPECT_EQ(config.calibration.readout_s, 0.0);
  ASSERT_EQ(config.notes.size(), 2u);
  expectParts(config.notes[0], "processed as global shutter");

  expectRefused(kHostFile + "rolling_shutter: 1\nrolling_shutter_tr: 33\n",
                "rolling_shutter_tr is 33, must be in [0, 0.2]");
}

class ConfigMask : public ConfigFile {
 protected:
  // An image beside the configuration file whose left half is `left` and whose right half `right`.
  void writeMask(const std::string& name, int width, int height, int left, int right) {
    cv::Mat mask(height, width, CV_8UC1, cv::Scalar(left));
    mask.colRange(width / 2, width).setTo(right);
    ASSERT_TRUE(cv::imwrite(folder_.file(name), mask));
  }
  // The image of the configuration whose keys are `keys`.
  cv::Mat maskOf(const std::string& keys) {
    const Config config = loaded(kHostFile + keys);
    notes_ = config.notes;
    return config.front_end.mask;
  }
  static int usedIn(const cv::Mat& mask) { return cv::countNonZero(mask); }

  std::vector<std::string> notes_;
  static constexpr int kHalf = 376 * 480;
};

TEST_F(ConfigMask, AreasOfTheImageThatAreNotUsed) {
  EXPECT_TRUE(maskOf("").empty());
  EXPECT_TRUE(maskOf("mask: \"\"\n").empty());
  writeMask("slim_init_mask.png", 752, 480, 0, 255);
  cv::Mat mask = maskOf("mask: \"slim_init_mask.png\"\n");
  ASSERT_EQ(mask.size(), cv::Size(752, 480));
  EXPECT_EQ(mask.type(), CV_8UC1);
  EXPECT_EQ(usedIn(mask), kHalf);
  EXPECT_EQ(mask.at<uchar>(100, 375), 0);
  EXPECT_NE(mask.at<uchar>(100, 376), 0);
  // By its full name; grey levels 0 and 1 are as good.
  writeMask("slim_init_mask.png", 752, 480, 1, 0);
  mask = maskOf("mask: \"" + folder_.file("slim_init_mask.png") + "\"\n");
  EXPECT_NE(mask.at<uchar>(100, 375), 0);
  EXPECT_EQ(usedIn(mask), kHalf);
}

TEST_F(ConfigMask, TheHostsMaskOfAFisheye) {
  writeMask("slim_init_fisheye.png", 752, 480, 255, 0);
  writeMask("slim_init_mask.png", 752, 480, 0, 255);
  EXPECT_TRUE(maskOf("fisheye_mask: \"slim_init_fisheye.png\"\n").empty()) << "fisheye is 0";
  EXPECT_EQ(usedIn(maskOf("fisheye: 1\nfisheye_mask: \"slim_init_fisheye.png\"\n")), kHalf);
  EXPECT_EQ(usedIn(maskOf("fisheye: 1\nfisheye_mask: \"slim_init_fisheye.png\"\n"
                          "mask: \"slim_init_mask.png\"\n")),
            0)
      << "what both leave";

  const int circle_of_half = usedIn(maskOf("fisheye: 1\nmask: \"slim_init_mask.png\"\n"));
  EXPECT_LT(circle_of_half, kHalf) << "and not the corners";
  EXPECT_GT(circle_of_half, 0.9 * kHalf);
  // VINS-Mono's file, which no key names.
  EXPECT_TRUE(maskOf("fisheye: 1\n").empty());
  writeMask("fisheye_mask.jpg", 752, 480, 0, 255);
  const cv::Mat mask = maskOf("fisheye: 1\n");
  ASSERT_FALSE(mask.empty());
  EXPECT_EQ(usedIn(mask), kHalf) << "the grey of the compression is not used";
  EXPECT_TRUE(maskOf("fisheye: 0\n").empty());
  EXPECT_EQ(usedIn(maskOf("fisheye: 1\nmask: \"slim_init_mask.png\"\n")), kHalf);
  // LVI-SAM names a file of its package so.
  EXPECT_EQ(usedIn(maskOf("mask: \"/slim_init_mask.png\"\n")), kHalf);
  writeMask("fisheye_mask.jpg", 512, 512, 0, 255);
  EXPECT_TRUE(maskOf("fisheye: 1\n").empty());
  ASSERT_FALSE(notes_.empty());
  expectParts(notes_[0], "fisheye_mask.jpg is 512 x 512, the camera 752 x 480: not used");
}

TEST_F(ConfigMask, WhatCannotBeAMaskIsRefused) {
  const std::string file = folder_.file("slim_init_mask.png");
  const std::string key = "mask: \"slim_init_mask.png\"\n";
  expectRefused(kHostFile + key, "mask: " + file + " cannot be opened");
  std::ofstream(file) << "no image";
  expectError("mask: " + file + " cannot be read as an image");
  writeMask("slim_init_mask.png", 640, 480, 0, 255);
  expectError("mask: " + file + " is 640 x 480, must be 752 x 480");
  writeMask("slim_init_mask.png", 752, 480, 0, 0);
  expectError("mask: " + file + " is 0 everywhere");
}

TEST_F(ConfigErrors, MissingAndMalformedFiles) {
  expectError("cannot be opened");
  expectRefused("", "not a YAML file");
  write("model_type: PINHOLE\n");  // no %YAML line
  expectError("%YAML:1.0");
  expectRefused(edited("   k1: -0.28\n", "\tk1: -0.28\n"), "Tabs");
  expectRefused(edited("0., 0., 1.]", "0., 0., 1.\n"), "not a YAML file");
  expectRefused("%YAML:1.0\n", "model_type is missing");
  expectRefused("\xEF\xBB\xBF" + edited("", ""), "it begins with a byte order mark");
  // With the line as it stands there: a comma in a number is "incorrect indentation" to OpenCV.
  expectRefused(edited("fx: 458.0", "fx: 458,0"), ": line 11: Incorrect indentation:    fx: 458,0");
}

TEST_F(ConfigErrors, MissingKeysAreNamed) {
  expectRefused(edited("model_type: PINHOLE\n", ""), "model_type is missing");
  expectRefused(edited("image_height: 480\n", ""), "image_height is missing");
  expectRefused(edited("   fy: 457.0\n", ""), "projection_parameters.fy is missing");
  expectRefused(edited("   p2: 0.00002\n", ""), "distortion_parameters.p2 is missing");
  expectRefused(edited("extrinsicRotation", "extrinsic_rotation"), "extrinsicRotation is missing");
  expectRefused(edited("extrinsicTranslation", "tic"), "extrinsicTranslation is missing");
  expectRefused(edited("td: -0.01", "Td: -0.01"), "Td is not a known key, must be td");
  expectRefused(edited("   fy: 457.0\n", "   Fy: 457.0\n"),
                "projection_parameters.Fy is not a known key, must be fy");
  expectRefused(kHostFile + "Slim_init: {sigma_px: 1}\n", "Slim_init is not a known key");
}

TEST_F(ConfigErrors, CoefficientsThatTheModelLacksAreNamed) {
  for (const char* value : {"0.1", "0"}) {
    const Config config =
        loaded(edited("   p2: 0.00002\n", std::string("   p2: 0.00002\n   k3: ") + value + "\n"));
    ASSERT_EQ(config.notes.size(), value[1] == '.' ? 2u : 1u) << "and the densities";
    if (value[1] == '.')
      expectParts(config.notes[0], "distortion_parameters.k3 is 0.1 and not used");
  }
}

TEST_F(ConfigErrors, BadHostValues) {
  expectRefused(edited("PINHOLE", "SCARAMUZZA"),
                "model_type is \"SCARAMUZZA\", must be PINHOLE, KANNALA_BRANDT or MEI");
  expectRefused(edited("image_width: 752", "image_width: wide"),
                "image_width is \"wide\", must be a whole number");
  expectRefused(edited("fx: 458.0", "fx: -458.0"),
                "projection_parameters.fx is -458, must be in [1, 100000]");
  expectRefused(edited("752\nimage_height: 480", "1504\nimage_height: 960"),
                "projection_parameters.cx / width is 0.244");
  expectRefused(edited("752\nimage_height: 480", "376\nimage_height: 256"),
                "projection_parameters.cx / width is 0.976");
  expectRefused(edited("cy: 248.0", "cy: 350.0"),
                "projection_parameters.cy / height is 0.729167, must be in [0.3, 0.7]");
  expectRefused(edited("k2: 0.07", "k2: .nan"), "nan, must be a finite number");
  expectRefused(edited("g_norm: 9.81", "g_norm: 1.0"), "g_norm is 1, must be in [9.7, 9.9]");
  expectRefused(edited("td: -0.01", "td: 20.0"), "td is 20, must be in [-1, 1]");
  expectRefused(edited("[0.1, -0.2, 0.3]", "[100., 0., 0.]"),
                "extrinsicTranslation [m] is 100, must be in [0, 10]");
  expectRefused(kHostFile + "max_cnt: 0\n", "max_cnt is 0, must be in [1, 10000]");
  expectRefused(kHostFile + "equalize: 2\n", "equalize is 2, must be 0, 1, true or false");
}

// fuzz_config: OpenCV does not return from this one.
TEST_F(ConfigErrors, AFileOfMoreThanOneDocument) {
  expectRefused("%YAML:1.0\n k: x\n: 4-\n", "line 3 starts further left than the first key");
}

TEST_F(ConfigErrors, ExtrinsicThatIsNoRotation) {
  expectRefused(edited(kRotation, "[0., -1., 0., 1., 0., 0., 0., 0., -1.]"),
                "extrinsicRotation has determinant -1");
  expectRefused(edited(kRotation, "[0., -2., 0., 1., 0., 0., 0., 0., 1.]"),
                "extrinsicRotation is 1 away from the nearest rotation");
  expectRefused(edited(kRotation, "[.nan, -1., 0., 1., 0., 0., 0., 0., 1.]"),
                "extrinsicRotation has a value that is not a number");
  expectRefused(edited("   rows: 3\n   cols: 1\n   dt: d\n   data: [0.1, -0.2, 0.3]",
                       "   rows: 2\n   cols: 1\n   dt: d\n   data: [0.1, -0.2]"),
                "extrinsicTranslation is 2 x 1");
  const std::string d = "   dt: d\n   data: [0.1, -0.2, 0.3";  // of the translation
  expectRefused(edited(d, "   dt: i\n   data: [0.1, -0.2, 0.3"),
                "extrinsicTranslation has dt of whole numbers, must be d");
  expectRefused(edited(d, d + ", 0.4"), "data has 4 numbers, must have 3, and dt must be d");
  // No memory is reserved for what the file says: to OpenCV a word is the largest integer.
  expectRefused(edited("   rows: 3\n   cols: 1\n", "   rows: 2000000000\n   cols: 100\n"),
                "extrinsicTranslation is 2000000000 x 100");
  expectRefused(edited("   rows: 3\n   cols: 1\n", "   rows: \"three\"\n   cols: 1\n"),
                "extrinsicTranslation cannot be read as !!opencv-matrix");
  expectRefused(edited("   cols: 1\n   dt: d\n   data: [0.1, -0.2, 0.3]",
                       "   cols: 1\n   dt: \"2d\"\n   data: [0.1, -0.2, 0.3, 0.4, 0.5, 0.6]"),
                "extrinsicTranslation has 2 channels, must have one");
  expectRefused(edited(matrixKey("extrinsicTranslation", 3, 1, "0.1, -0.2, 0.3"),
                       "extrinsicTranslation: 3\n"),
                "extrinsicTranslation cannot be read as !!opencv-matrix");
}

struct OurError {
  const char* section;
  const char* words;
};
class ConfigSectionErrors : public ConfigFile, public ::testing::WithParamInterface<OurError> {};

TEST_P(ConfigSectionErrors, InTheHostsFileAndInItsOwn) {
  expectRefused(kHostFile + GetParam().section, GetParam().words);
  expectOptionsRefused(GetParam().section, GetParam().words);
  Config config;
  std::string error;
  EXPECT_FALSE(loadOptions(optionsPath(), &config, &error));
  expectParts(error, GetParam().words);
}

const OurError kOurErrors[] = {
    {"slim_init:\n  windw: {keyframes: 10}\n", "slim_init.windw is not a known key"},
    {"slim_init:\n  window: {keyframe: 10}\n", "slim_init.window.keyframe is not a known key;"},
    {"slim_init:\n  gyr_n: 0.004\n", "slim_init.gyr_n is not a known key"},
    {"slim_init:\n  method: best\n", "slim_init.method is \"best\", must be one of"},
    {"slim_init:\n  window: {keyframes: 1}\n",
     "slim_init.window.keyframes is 1, must be in [4, 50]"},
    {"slim_init:\n  window: {keyframes: 4}\n",
     "slim_init.window.min_keyframes is 5, must not exceed keyframes (4)"},
    {"slim_init:\n  window: {keyframes: 10.5}\n", "must be a whole number"},
    {"slim_init:\n  window: 10\n", "slim_init.window is 10, must be a section"},
    {"slim_init:\n  method: {a: 1}\n", "slim_init.method is a section, must be a text"},
    {"slim_init:\n  sigma_px: .nan\n", "nan, must be a finite number"},
    {"slim_init:\n  sigma_px: -.inf\n", "slim_init.sigma_px is -inf, must be a finite number"},
    {"slim_init:\n  noise: {gyro_density: 0.}\n", "slim_init.noise.gyro_density is 0, must be in"},
    {"slim_init:\n  imu: {max_accel: 16}\n",
     "slim_init.imu.max_accel is 16, must be in [19.6, inf]"},
    {"slim_init:\n  gates: {mode: maybe}\n",
     "slim_init.gates.mode is \"maybe\", must be own, on or off"},
    {"slim_init:\n  front_end: {profile: best}\n",
     "slim_init.front_end.profile is \"best\", must be default or vins"},
    {"slim_init:\n  points: {window_px: 20}\n", "slim_init.points.window_px is 20, must be odd"},
    {"slim_init:\n  lines: {min_length_px: 2.}\n",
     "slim_init.lines.min_length_px is 2, must be in"},
    {"slim_init:\n  refinement: {max_iterations: 4000}\n",
     "slim_init.refinement.max_iterations is 4000, must be in [0, 1000]"},
    {"slim_init:\n  refinement: {use_lines: 3}\n",
     "slim_init.refinement.use_lines is 3, must be 0, 1, true or false"},
    {"slim_init: 3\n", "slim_init is 3, must be a section of keys"}};

INSTANTIATE_TEST_SUITE_P(All, ConfigSectionErrors, ::testing::ValuesIn(kOurErrors));

TEST_F(ConfigErrors, AFileOfOurOwnWithoutTheSection) {
  expectOptionsRefused("sigma_px: 0.4\n", "the section slim_init: is missing");
  expectOptionsRefused("slim_init:\n#  sigma_px: 0.4\n", "the section slim_init: is missing");
}

TEST_F(ConfigErrors, ValueOutOfRangeNamesTheFileItCameFrom) {
  // Set in the host's file, found only after the second file was read.
  write(kHostFile + "slim_init:\n  sigma_px: 100\n");
  writeOptions("%YAML:1.0\nslim_init:\n  sigma_line_px: 0.5\n");
  options_ = optionsPath();
  expectError("slim_init.sigma_px is 100");
}

// Of keys at the end of a file that has them already, the host and we would read the first.
TEST_F(ConfigErrors, KeyTwice) {
  const std::string section = "slim_init:\n  sigma_px: 0.5\n";
  expectRefused(kHostFile + section + "  sigma_px: 0.6\n", "slim_init.sigma_px is given twice");
  expectRefused(kHostFile + "slim_init:\n  noise: {gyro_density: 1e-4, gyro_density: 2e-4}\n",
                "slim_init.noise.gyro_density is given twice");
  expectRefused(kHostFile + section + section, "slim_init is given twice");
  expectRefused(kHostFile + "td: 0.03\n", "td is given twice");
  expectRefused(kHostFile + "image_width: 640\n", "image_width is given twice");
  expectRefused(kHostFile + matrixKey("extrinsicTranslation", 3, 1, "0., 0., 0."),
                "extrinsicTranslation is given twice");
  expectRefused(edited("   fy: 457.0\n", "   fx: 457.0\n"),
                "projection_parameters.fx is given twice");
  expectRefused(kHostFile + "initializer: stock\ninitializer: slim\n",
                "initializer is given twice");
  HostKeys keys;
  std::string error;
  EXPECT_FALSE(loadHostKeys(path_, &keys, &error));
  expectParts(error, path_ + ": initializer is given twice");
  expectOptionsRefused(section + section, "slim_init is given twice");
}

TEST_F(ConfigFile, AKeyOfTheHostAloneMayStandTwice) {
  const Config config =
      loaded(kHostFile + "acc_n: 0.1\nmax_solver_time: 0.04\nmax_solver_time: 0.1\n");
  EXPECT_EQ(config.calibration.td, -0.01);
}

// Its content is commented out.
TEST_F(ConfigFile, AKeyWithoutAValueAtTheEndIsAbsent) {
  for (const char* end :
       {"slim_init:\n", "slim_init:\n#  sigma_px: 0.4\n", "slim_init:\n  sigma_px:\n",
        "slim_init:\n  noise:\n#    gyro_density: 1e-4\n", "mask:\n", "initializer:\n"}) {
    const Config config = loaded(kHostFile + end);
    EXPECT_EQ(config.calibration.sigma_px, Calibration().sigma_px) << end;
    EXPECT_EQ(config.calibration.imu_noise.gyro_density, ImuNoise().gyro_density) << end;
    EXPECT_EQ(config.host.mask, "") << end;
    EXPECT_EQ(config.host.initializer, HostKeys().initializer) << end;
  }
  expectRefused(edited("image_height: 480\n", "") + "image_height:\n", "image_height is missing");
  expectRefused(kHostFile + "slim_init:\n  nois:\n", "slim_init.nois is not a known key");
}

TEST(ConfigTable, KeysAreUniqueAndExplained) {
  Config config;
  std::set<std::string> keys;
  std::set<const void*> fields;
  for (const OptionField& option : configTable(&config)) {
    EXPECT_TRUE(keys.insert(option.key).second) << option.key << " stands twice";
    EXPECT_TRUE(fields.insert(memoryOf(option).first).second) << option.key << " shares a field";
    EXPECT_FALSE(option.reason.empty()) << option.key;
    for (const std::string& method : option.methods) {
      // Those that need Ceres are not in this build's registry of methods().
      const std::set<std::string> known = {"slim",      "slim-paper", "drt-l",   "drt-t",
                                           "drt-vi-ba", "vins",       "openvins"};
      EXPECT_EQ(known.count(method), 1u) << option.key << ": " << method;
    }
  }
}

TEST(ConfigTable, FrontEndHasEveryFieldAndKeepsItsBounds) {
  expectBothSidesOfEveryBound<FrontEndOptions, PointTrackerOptions, LineTrackerOptions,
                              HostFrontEnd>();
  expectEveryFieldHasARow<FrontEndOptions>([](FrontEndOptions* options) {
    OptionTable table = optionTable(options);
    // No keys of its own; the host's keys are at the top level of the file.
    appendSection("window", optionTable(&options->window), {}, &table);
    appendSection("imu", optionTable(&options->imu), {}, &table);
    appendSection("host", optionTable(&options->host), {}, &table);
    OptionWord mask;  // read from the files that keys of the host name
    mask.address = &options->mask;
    mask.size = sizeof(options->mask);
    table.push_back(userKey("mask", mask, "image"));
    return table;
  });
}

TEST(ConfigTable, HeadersStateTheSameUnits) {
  const std::string top = SLIM_INIT_SOURCE_DIR;
  Config config;
  const auto front_end = unitsOfHeader(
      top + "/feature_tracker_lines/include/slim_init/feature_tracker_lines/options.h");
  expectUnitsAgree(front_end, "PointTrackerOptions", optionTable(&config.front_end.points));
  expectUnitsAgree(front_end, "LineTrackerOptions", optionTable(&config.front_end.lines));
  expectUnitsAgree(front_end, "HostFrontEnd", optionTable(&config.front_end.host));
}

std::string fileWithKey(const std::string& key, const std::string& value) {
  std::string text = "%YAML:1.0\nslim_init:\n", indent = "  ";
  std::size_t begin = 0;
  for (std::size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', begin)) {
    text += indent + key.substr(begin, dot - begin) + ":\n";
    indent += "  ";
    begin = dot + 1;
  }
  return text + indent + key.substr(begin) + ": " + value + "\n";
}

std::string numberText(const OptionField& option, double value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  const bool real = std::holds_alternative<double*>(option.value);
  return real && out.str().find_first_of(".e") == std::string::npos ? out.str() + ".0" : out.str();
}

TEST_F(ConfigFile, EveryNumberIsRefusedOutsideOfItsRangeByNameOfItsKey) {
  Config defaults;
  int tested = 0;
  for (const OptionField& option : configTable(&defaults)) {
    for (const BoundCase& bound : boundCases(option)) {
      writeOptions(fileWithKey(option.key, numberText(option, bound.outside)));
      Config config;
      std::string error;
      EXPECT_FALSE(loadOptions(optionsPath(), &config, &error)) << option.key;
      EXPECT_NE(error.find(": slim_init." + option.key + " is "), std::string::npos) << error;
      expectParts(error, "must be in [");
      writeOptions(fileWithKey(option.key, numberText(option, bound.inside)));
      const bool taken = loadOptions(optionsPath(), &config, &error);
      EXPECT_TRUE(taken || error.find("must be in [") == std::string::npos) << error;
      ++tested;
    }
  }
  EXPECT_GT(tested, 100);
}

TEST_F(ConfigFile, NotesKeysThatTheMethodDoesNotRead) {
  const auto notes = [this](const std::string& keys) { return loadedOptions(keys).notes; };
  EXPECT_EQ(notes("  method: drt-l\n  slim: {refine: 0}\n")[0],
            "without effect on drt-l: slim_init.slim.refine");
  EXPECT_TRUE(notes("  slim: {refine: 0}\n").empty());
  EXPECT_TRUE(notes("  method: drt-l\n  slim: {refine: 1}\n").empty()) << "the default";

  Config config;
  config.options.slim.refine = false;
  EXPECT_EQ(noteUnreadKeys(config, {"slim", "drt-l"}), "");
  EXPECT_EQ(noteUnreadKeys(config, {"drt-l", "drt-t"}),
            "without effect on drt-l or drt-t: slim_init.slim.refine");
}

// A default, a range or a reason changed? `slim_init options --update .` in the repository.
TEST(ShippedConfigs, GeneratedFilesAreUpToDate) {
  const std::vector<GeneratedFile> files = generatedFiles(SLIM_INIT_SOURCE_DIR);
  ASSERT_EQ(files.size(), 3u);
  for (const GeneratedFile& file : files) {
    EXPECT_TRUE(readFile(SLIM_INIT_SOURCE_DIR "/" + file.path) == file.text)
        << file.path << " is out of date: run `slim_init options --update .` in the repository";
    std::istringstream lines(file.text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

// What is no key of ours stays, and a key that is not there comes at the end.
TEST(ShippedConfigs, TheTemplateIsKeptButForItsKeys) {
  const ScratchFolder folder;
  folder.write("config/template.yaml",
               "%YAML:1.0\n# mine\n\n# old\n# reason\ntd: 7.0\nother: 1\n# old\nimu_topic: x\n");
  const std::string text = generatedFiles(folder.path())[0].text;
  EXPECT_EQ(text.rfind("%YAML:1.0\n# mine\n\n# time offset, t_imu = t_image + td [s, -1 to 1]\n"
                       "td: 0.0\nother: 1\n# topic of the IMU: ROS nodes and bags\n"
                       "imu_topic: \"/imu0\"\n",
                       0),
            0u)
      << text;
  expectParts(text, "\nmask: \"\"\n|\n    gyro_density: 0.00017\n");
}

void expectDefaults(Config* read) {
  Config defaults;
  const OptionTable table = configTable(read), expected = configTable(&defaults);
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (const auto* word = std::get_if<OptionWord>(&table[i].value)) {
      EXPECT_EQ(word->get(), std::get<OptionWord>(expected[i].value).get()) << table[i].key;
    } else {
      std::visit(
          [&](const auto& value) {
            using T = std::decay_t<decltype(value)>;
            if constexpr (std::is_pointer_v<T>) {
              EXPECT_EQ(*value, *std::get<T>(expected[i].value)) << table[i].key;
            }
          },
          table[i].value);
    }
  }
}

// Every bound that it sets is tighter than the default, and nothing else is set.
TEST(ShippedConfigs, TheStrictBoundsAreTighter) {
  Config strict = loadedFrom(kConfigDir + "strict.yaml", FileOf::kOurs);
  EXPECT_TRUE(strict.notes.empty()) << strict.notes[0];
  Config defaults;
  const OptionTable table = configTable(&strict), expected = configTable(&defaults);
  int tighter = 0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const auto* value = std::get_if<double*>(&table[i].value);
    if (value == nullptr || **value == **std::get_if<double*>(&expected[i].value)) continue;
    ++tighter;
    const std::string& key = table[i].key;
    ASSERT_EQ(key.rfind("gates.", 0), 0u) << key;
    const double by = **value - **std::get_if<double*>(&expected[i].value);
    EXPECT_TRUE(key.rfind("gates.max_", 0) == 0 ? by < 0.0 : by > 0.0) << key;
  }
  EXPECT_EQ(tighter, 6);
}

TEST(ShippedConfigs, HoldEveryKeyWithItsDefault) {
  Config config = loadedFrom(kConfigDir + "template.yaml", FileOf::kHost);
  expectDefaults(&config);
  EXPECT_TRUE(config.notes.empty()) << config.notes[0];
  for (const char* file : {"user.yaml", "advanced.yaml"}) {
    Config options = loadedFrom(kConfigDir + file, FileOf::kOurs);
    expectDefaults(&options);
    EXPECT_TRUE(options.notes.empty()) << options.notes[0];
  }
  const auto keys = [](OptionKeys which) {
    int count = 0;
    std::istringstream lines(optionsYaml(which));
    for (std::string line; std::getline(lines, line);) {
      count += line[0] == ' ' && line.find('#') == std::string::npos && line.back() != ':' ? 1 : 0;
    }
    return count;
  };
  const int user = keys(OptionKeys::kUser);
  EXPECT_EQ(user + keys(OptionKeys::kAdvanced), static_cast<int>(configTable(&config).size()));
  EXPECT_EQ(keys(OptionKeys::kAll), static_cast<int>(configTable(&config).size()));
  // What a user has to look through.
  EXPECT_GE(user, 25);
  EXPECT_LE(user, 35);
}

TEST(ShippedConfigs, AllLoad) {
  int loaded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kConfigDir)) {
    if (entry.path().extension() != ".yaml") continue;
    const std::string file = entry.path().string();
    const bool rig = contains(readFile(file), "\nmodel_type:");
    const Config config = loadedFrom(file, rig ? FileOf::kHost : FileOf::kOurs);
    EXPECT_EQ(config.options.validate(), "") << file;
    EXPECT_EQ(config.calibration.validate(), "") << file;
    ++loaded;
  }
  EXPECT_GE(loaded, 6);
}

TEST(ShippedConfigs, EurocIsTheDatasetsCalibration) {
  const Config config = loadedFrom(kConfigDir + "euroc.yaml", FileOf::kHost);
  EXPECT_EQ(config.camera.fx, 458.654);
  EXPECT_NEAR(config.calibration.t_b_c.y(), -0.064676986768, 1e-12);
  EXPECT_NEAR(config.calibration.R_b_c(0, 1), -0.999880929698, 1e-9);
  EXPECT_EQ(config.calibration.imu_noise.gyro_density, 1.6968e-04);
  EXPECT_TRUE(config.notes.empty());
}

// A host without them runs its own initializer, silently.
TEST(ShippedConfigs, EveryRigSwitchesUsOn) {
  for (const char* name : {"template", "euroc", "tum_vi", "realsense_d455"}) {
    HostKeys host;
    std::string error;
    ASSERT_TRUE(loadHostKeys(kConfigDir + name + ".yaml", &host, &error)) << error;
    EXPECT_EQ(host.initializer, "slim") << name;
    EXPECT_TRUE(host.reinit) << name;
  }
}

// Key and value of a line "key: value" at the top level of a file.
std::map<std::string, std::string> topLevelKeys(const std::string& text) {
  std::map<std::string, std::string> keys;
  std::istringstream lines(text);
  const std::regex pattern("^([A-Za-z_0-9]+):[ ]*([^#]*[^# ])?.*$");
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (!std::regex_match(line, match, pattern)) continue;
    EXPECT_TRUE(keys.insert({match[1], match[2]}).second) << match[1] << " stands twice";
  }
  return keys;
}

// All keys that VINS-Mono's nodes read; an absent number is 0 for them.
TEST(ShippedConfigs, TheTemplateIsCompleteForVinsMono) {
  const auto keys = topLevelKeys(readFile(kConfigDir + "template.yaml"));
  std::istringstream read_by_the_nodes(
      "imu_topic image_topic output_path model_type camera_name image_width image_height "
      "distortion_parameters projection_parameters max_solver_time max_num_iterations "
      "keyframe_parallax acc_n acc_w gyr_n gyr_w g_norm estimate_extrinsic extrinsicRotation "
      "extrinsicTranslation td estimate_td rolling_shutter rolling_shutter_tr max_cnt min_dist "
      "freq F_threshold show_track equalize fisheye loop_closure load_previous_pose_graph "
      "fast_relocalization pose_graph_save_path save_image visualize_imu_forward "
      "visualize_camera_size");
  for (std::string key; read_by_the_nodes >> key;) EXPECT_EQ(keys.count(key), 1u) << key;
  EXPECT_EQ(keys.at("max_solver_time"), "0.04");
  EXPECT_EQ(keys.at("gyr_w"), "2e-06");
  // Ours, as the patched host reads them.
  EXPECT_EQ(keys.at("initializer"), "slim");
  for (const char* key : {"reinit", "watchdog", "keep_heading"}) EXPECT_EQ(keys.at(key), "1");
  EXPECT_EQ(keys.at("max_wait_ms"), "10.0");
}

// Whoever opens the template sees these first.
TEST(ShippedConfigs, EightKeysAreOnTheFirstScreen) {
  constexpr std::size_t kScreen = 45;  // lines
  std::istringstream lines(readFile(kConfigDir + "template.yaml"));
  std::string top, line;
  for (std::size_t i = 0; i < kScreen && std::getline(lines, line); ++i) top += line + "\n";
  for (const std::string key :
       {"initializer", "reinit", "estimate_extrinsic", "estimate_td", "rolling_shutter",
        "rolling_shutter_tr", "    gyro_density", "    accel_density"}) {
    EXPECT_NE(top.find("\n" + key + ": "), std::string::npos) << key;
  }
}

}  // namespace
}  // namespace slim_init
