// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab` on recordings with images, as a user runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>

#include "evaluation/scratch_folder.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "support/csv.h"
#include "support/euroc_camera.h"
#include "support/text_parts.h"
#include "tools/ab_runs.h"

namespace slim_init {
namespace {

namespace fs = std::filesystem;

/// A camera that moves sideways before a wall full of squares, swinging at 0.8 Hz, for `kSeconds`.
struct Wall {
  static constexpr double kSeconds = 4.0;
  static constexpr double kFocal = 220.0;
  static constexpr std::int64_t kT0Ns = 1500000000000000000;

  static evaluation::WriterRig rig() {
    evaluation::WriterRig rig;
    // Camera axes: x to the right = -y of the body, y down = -z, z ahead = x.
    rig.calibration.R_b_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    rig.camera = cameraOf(320, 240, kFocal, kFocal, 160.0, 120.0);
    return rig;
  }

  static NavState truth(double t) {
    const double w = 2.0 * M_PI * 0.8;
    NavState state;
    state.p_w_b = Eigen::Vector3d(0.0, 0.25 * std::sin(w * t), 0.15 * std::sin(0.7 * w * t));
    state.v_w_b =
        Eigen::Vector3d(0.0, 0.25 * w * std::cos(w * t), 0.105 * w * std::cos(0.7 * w * t));
    state.gyro_bias = Eigen::Vector3d(0.01, -0.02, 0.03);
    return state;
  }

  static ImuSample imu(double t) {
    const double w = 2.0 * M_PI * 0.8;
    ImuSample sample;
    sample.gyro = truth(t).gyro_bias;
    sample.accel = Eigen::Vector3d(0.0, -0.25 * w * w * std::sin(w * t),
                                   9.81007 - 0.15 * 0.49 * w * w * std::sin(0.7 * w * t));
    return sample;
  }

  /// Squares at depths from 2 to 5 m, the far ones first.
  static cv::Mat image(double t) {
    const Eigen::Vector3d p = truth(t).p_w_b;
    cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(90));
    for (int i = 0; i < 60; ++i) {
      const double depth = 5.0 - 0.05 * i;
      const double y = 2.4 * std::sin(12.9898 * i) - p.y();
      const double z = 1.8 * std::sin(78.233 * i) - p.z();
      constexpr int kShift = 8;  // of sub-pixel corners
      const auto fixed = [](double value) { return static_cast<int>(std::lround(256.0 * value)); };
      const double u = 160.0 - kFocal * y / depth;
      const double v = 120.0 - kFocal * z / depth;
      const double half = kFocal * 0.11 / depth;
      const cv::Point corners[] = {{fixed(u - half), fixed(v - half)},
                                   {fixed(u + half), fixed(v - half)},
                                   {fixed(u + half), fixed(v + half)},
                                   {fixed(u - half), fixed(v + half)}};
      cv::fillConvexPoly(picture, corners, 4, cv::Scalar(20 + (i * 53) % 220), cv::LINE_AA, kShift);
    }
    return picture;
  }

  static void writeAsl(const std::string& directory) {
    evaluation::RecordedMotion recording;
    recording.t0_ns = kT0Ns;
    for (int k = 0; k <= static_cast<int>(200 * kSeconds); ++k) {
      const double t = k / 200.0;
      recording.imu.push_back(imu(t));
      recording.imu.back().t = t;
      if (k % 2 == 0) {
        recording.truth.push_back(truth(t));
        recording.truth.back().t = t;
      }
      if (k % 10 == 0) recording.image_times.push_back(t);
    }
    ASSERT_EQ(evaluation::writeAslFolder(directory, rig(), recording), "");
    for (const double t : recording.image_times) {
      ASSERT_EQ(evaluation::writeAslImage(directory, recording.stampNs(t), image(t)), "");
    }
  }

  static void writeBag(const std::string& file) {
    writeAsl(file + ".asl");
    ASSERT_EQ(evaluation::writeBag(file + ".asl", {"/wall/imu", "/wall/image", "", true}, file),
              "");
  }

  /// The host's configuration file for this rig.
  static std::string config() {
    return "%YAML:1.0\nimu_topic: \"/wall/imu\"\nimage_topic: \"/wall/image\"\n"
           "model_type: PINHOLE\ncamera_name: camera\nimage_width: 320\nimage_height: 240\n"
           "distortion_parameters: {k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0}\n"
           "projection_parameters: {fx: 220.0, fy: 220.0, cx: 160.0, cy: 120.0}\n" +
           matrixKey("extrinsicRotation", 3, 3, "0., 0., 1., -1., 0., 0., 0., -1., 0.") +
           matrixKey("extrinsicTranslation", 3, 1, "0., 0., 0.") +
           "g_norm: 9.81007\ntd: 0.0\n"
           "slim_init:\n  noise: {gyro_density: 1.7e-4, accel_density: 2.0e-3}\n";
  }
};

/// With images and configuration of the wall.
class AbAsl : public AbRuns {
 protected:
  void SetUp() override {
    Wall::writeAsl(folder.file("wall"));
    folder.write("config.yaml", Wall::config());
  }
  /// A configuration with `to` in place of `from`.
  void writeConfig(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = Wall::config();
    folder.write(name, text.replace(text.find(from), from.size(), to));
  }
};

TEST_F(AbAsl, RunsFromPixelsToTheReport) {
  const ProgramRun run = ran("--asl @wall --methods drt-l,slim-paper");
  EXPECT_EQ(run.err, "");
  const auto json = summaryOf();
  EXPECT_EQ(json["dataset"], "wall");
  EXPECT_EQ(json["gyro_bias_truth"], "recorded");
  EXPECT_EQ(json["options"]["asl"], folder.file("wall"));
  EXPECT_FALSE(json["options"].contains("seed"));
  EXPECT_FALSE(json["options"].contains("world"));
  EXPECT_EQ(json["tracking"]["images"], 81);
  EXPECT_EQ(json["tracking"]["tracked"], 81);
  EXPECT_GT(json["tracking"]["points_carried"].get<double>(), 30.0);
  const auto& all = json["methods"]["drt-l"]["all"];
  // Windows of 45 image steps start at images 0, 10, 20, 30.
  EXPECT_EQ(all["windows"], 4);
  EXPECT_EQ(all["attempted"], 4);
  EXPECT_GE(all["success"].get<int>(), 3);
  expectParts(run.out, "81 of 81 images tracked");
}

// A wrong td given by --td-error is one given by the configuration, for front end and methods; only
// that the report knows it.
TEST_F(AbAsl, AnErrorOfTheRigIsAWrongConfiguration) {
  writeConfig("early.yaml", "td: 0.0", "td: -0.02");
  const auto run = [this](const std::string& out, const std::string& line) {
    return summary("--asl @wall --methods drt-l --keyframes 10 --config " + line, out);
  };
  const auto wrong = run("wrong", "@config.yaml --td-error 0.02 --seed 4");
  const auto written = run("written", "@early.yaml");
  EXPECT_EQ(wrong["options"]["td_error_s"], 0.02);
  EXPECT_EQ(wrong["options"]["seed"], 4);
  for (const char* key : {"scale_rmse", "velocity_rmse", "gyro_bias_err_pct"}) {
    const double value = written["methods"]["drt-l"]["all"][key];
    EXPECT_NEAR(wrong["methods"]["drt-l"]["all"][key].get<double>(), value, 1e-6 * value) << key;
  }
  EXPECT_TRUE(contains(readFile(folder.file("wrong/windows.csv")), ",-20,0,0,drt-l,"));
  // The IMU of the front end is the methods'.
  const auto slow =
      run("slow", "@config.yaml --imu-rate 100 --imu-jitter 0.002 --imu-dropout 0.02");
  EXPECT_GE(slow["methods"]["drt-l"]["all"]["windows"].get<int>(), 3);
  EXPECT_EQ(slow["tracking"]["images_without_gyro"], 0);
}

TEST_F(AbAsl, TheTruthIsTakenAtTheTimeOffsetOfTheConfiguration) {
  writeConfig("late.yaml", "td: 0.0", "td: 0.5");
  ran("--asl @wall --methods drt-l --config @config.yaml", "right");
  const ProgramRun run =
      ran("--asl @wall --methods drt-l --keyframes 10 --config @late.yaml", "late");
  expectParts(run.err, "10 of 81 images lie outside the IMU data");
  const auto windows = readFile(folder.file("late/windows.csv"));
  expectParts(windows, "wall,0,0.5,1500000000500000000,2.25,10,");
}

TEST_F(AbAsl, UnreadableImagesAreCountedAndTheRunGoesOn) {
  const auto image = [](int k) {
    return "wall/mav0/cam0/data/" + std::to_string(Wall::kT0Ns + 50000000LL * k) + ".png";
  };
  for (const int k : {7, 8}) folder.write(image(k), "torn");
  cv::imwrite(folder.file(image(60)), cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)));
  fs::remove(folder.file(image(70)));
  const ProgramRun run = ran("--asl @wall --methods drt-l");
  expectParts(run.err,
              "2 of 80 images cannot be read|1 of 80 images were refused|1 of 81 images of");
  EXPECT_EQ(summaryOf()["tracking"]["tracked"], 77);
}

TEST_F(AbAsl, BadInputExitsWithTwoAndASentence) {
  const std::string line = "ab --asl @wall --out @out";
  fs::remove_all(folder.file("wall/mav0/state_groundtruth_estimate0"));
  expectRefused("demo --asl @wall --out @out", "wall has no ground truth");
  fs::remove(folder.file("wall/mav0/cam0/sensor.yaml"));
  expectRefused(line, "no calibration that can be used");
  folder.write("wall/mav0/imu0/data.csv", "1,2,3\n");
  expectRefused(line, "imu0/data.csv line 1 has 3 columns, must have 7");
  fs::remove_all(folder.file("wall"));
  expectRefused(line, "is not a directory");
}

/// With a bag of it as well.
class AbBag : public AbAsl {
 protected:
  void SetUp() override {
    // rosbag is optional; that a build without it says so is tested in image_sequence_test.
    if (!evaluation::rosbagSupported()) GTEST_SKIP() << "this build is without rosbag";
    AbAsl::SetUp();
    Wall::writeBag(folder.file("wall.bag"));
  }
  /// windows.csv without times and without the name of the recording, its first column.
  std::string windowsOf(const std::string& out) const {
    std::istringstream lines(withoutTimes(readFile(folder.file(out) + "/windows.csv")));
    std::string rows;
    for (std::string line; std::getline(lines, line);) rows += line.substr(line.find(',')) + "\n";
    return rows;
  }
};

TEST_F(AbBag, GivesTheSameWindowsAsTheFolderBitForBit) {
  ran("--asl @wall --config @config.yaml", "asl");
  ran("--bag @wall.bag --config @config.yaml", "bag");
  EXPECT_GT(windowsOf("asl").size(), 1000u);
  EXPECT_EQ(windowsOf("asl"), windowsOf("bag"));
  EXPECT_EQ(summaryOf("bag")["dataset"], "wall");

  // The truth may be absent.
  fs::remove(evaluation::groundtruthFileOf(folder.file("wall.bag")));
  const auto none = summary("--bag @wall.bag --config @config.yaml", "none");
  EXPECT_EQ(none["has_truth"], false);
  expectParts(none["notes"].dump(), "without ground truth there are no errors");
}

TEST_F(AbBag, BadBagsExitWithTwoAndASentence) {
  writeConfig("other.yaml", "/wall/image", "/cam0/image");
  const auto refused = [this](const std::string& config, const std::string& part) {
    expectRefused("ab --bag @wall.bag --out @out --config @" + config, part);
    EXPECT_FALSE(fs::exists(folder.file("out")));
  };
  refused("other.yaml",
          "has no topic '/cam0/image' (image_topic); it has /wall/image "
          "(sensor_msgs/Image), /wall/imu (sensor_msgs/Imu)");
  const std::string bytes = readFile(folder.file("wall.bag"));
  folder.write("wall.bag", bytes.substr(0, bytes.size() / 2));
  refused("config.yaml", "cannot be opened as a bag of ROS 1");
  fs::remove(folder.file("wall.bag"));
  refused("config.yaml", "wall.bag does not exist");
}

/// Real images of a vehicle that stands still.
class Snippet : public AbRuns {
 protected:
  void SetUp() override {
    // The EuRoC recordings are not part of the repository (their licence is not ours).
    if (!fs::is_directory(SLIM_INIT_SNIPPET)) GTEST_SKIP() << "no recording " SLIM_INIT_SNIPPET;
  }
};

TEST_F(Snippet, RunsEndToEndAndKeepsItsTracks) {
  const auto json = summary("--asl " SLIM_INIT_SNIPPET);
  EXPECT_EQ(json["dataset"], "euroc_v1_01_snippet");
  EXPECT_EQ(json["tracking"]["tracked"], 65);
  EXPECT_GE(json["tracking"]["points_carried"].get<double>(), 100.0);
  EXPECT_GE(json["tracking"]["lines_carried"].get<double>(), 40.0);
}

TEST_F(Snippet, EveryWindowIsStationaryWithGravityAndGyroBias) {
  const auto json = summary("--asl " SLIM_INIT_SNIPPET " --gates on --stride 5");
  ASSERT_FALSE(json["methods"].empty());
  for (const auto& [name, method] : json["methods"].items()) {
    const auto& all = method["all"];
    const int windows = all["windows"].get<int>();
    EXPECT_GE(windows, 4) << name;
    EXPECT_EQ(all["accepted"], 0) << name;  // no scale is claimed
    // These two refuse for want of parallax or of a solution, in their own words.
    if (name == "vins" || name == "openvins") continue;
    EXPECT_EQ(all["statuses"].value("stationary", 0), windows) << name << ": " << all["statuses"];
  }
  int stationary = 0;
  for (const auto& row : csvRows(readFile(folder.file("out/windows.csv")))) {
    const std::string& method = row.at("method");
    if (row.at("status") != "stationary" || method == "vins" || method == "openvins") continue;
    ++stationary;
    EXPECT_LE(std::stod(row.at("gravity_error_deg")), 1.0) << method;
    EXPECT_LE(std::stod(row.at("gyro_bias_err_pct")), 3.0) << method;
  }
  EXPECT_GE(stationary, 4);
}

// Real images of a moving camera, with a rig that is off: every window that is accepted with the
// right calibration is accepted, as accurately, and the error is found.
class MovingSnippet : public AbRuns {
 protected:
  void SetUp() override {
    // The EuRoC recordings are not part of the repository (their licence is not ours).
    if (!fs::is_directory(SLIM_INIT_MOVING)) GTEST_SKIP() << "no recording at " << SLIM_INIT_MOVING;
  }

  nlohmann::json allOf(const std::string& errors) const {
    return summary("--asl " SLIM_INIT_MOVING " --methods slim --stride 10 " +
                   errors)["methods"]["slim"]["all"];
  }
};

TEST_F(MovingSnippet, AnErrorOfTheRigIsFoundAndCostsNoWindow) {
  const nlohmann::json right = allOf("");
  const int accepted = right["accepted"];
  ASSERT_GE(accepted, 5);
  EXPECT_LT(right["accepted_scale_rmse"].get<double>(), 0.03);
  for (const char* error : {"--td-error -0.02", "--td-error 0.04", "--extrinsic-error 4",
                            "--td-error 0.02 --extrinsic-error 8"}) {
    const nlohmann::json off = allOf(error);
    EXPECT_EQ(off["accepted"], accepted) << error;
    // A handful of windows: their RMSE scatters by more than the 1.3 that the benchmark shows.
    EXPECT_LT(off["accepted_scale_rmse"].get<double>(), 2.0 * right["scale_rmse"].get<double>());
    EXPECT_LT(off["accepted_td_rmse_ms"].get<double>(), 3.0) << error;
    EXPECT_LT(off["accepted_rotation_rmse_deg"].get<double>(), 1.0) << error;
  }
}

// An IMU at 100 Hz with jitter and lost samples.
TEST_F(MovingSnippet, APoorImuCostsNoWindow) {
  const int accepted = allOf("")["accepted"];
  const nlohmann::json poor = allOf("--imu-rate 100 --imu-jitter 0.002 --imu-dropout 0.01");
  EXPECT_EQ(poor["accepted"], accepted);
  EXPECT_LT(poor["accepted_scale_rmse"].get<double>(), 0.03);
}

}  // namespace
}  // namespace slim_init
