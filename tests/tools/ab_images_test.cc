// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab` on recordings with images, as a user runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "tools/run_program.h"

namespace slim_init {
namespace {

namespace fs = std::filesystem;

nlohmann::json summaryOf(const std::string& out) {
  return nlohmann::json::parse(readFile(out + "/summary.json"));
}

/// windows.csv without times and without the name of the recording, its first column.
std::string windowsOf(const std::string& out) {
  std::istringstream lines(withoutTimes(readFile(out + "/windows.csv")));
  std::string rows;
  for (std::string line; std::getline(lines, line);) rows += line.substr(line.find(',')) + "\n";
  return rows;
}

/// A camera that moves sideways before a wall full of squares, swinging at 0.8 Hz, for `kSeconds`.
struct Wall {
  static constexpr double kSeconds = 4.0;
  static constexpr double kFocal = 220.0;
  static constexpr std::int64_t kT0Ns = 1500000000000000000;

  static evaluation::WriterRig rig() {
    evaluation::WriterRig rig;
    // Camera axes: x to the right = -y of the body, y down = -z, z ahead = x.
    rig.calibration.R_b_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    rig.camera.width = 320;
    rig.camera.height = 240;
    rig.camera.fx = rig.camera.fy = kFocal;
    rig.camera.cx = 160.0;
    rig.camera.cy = 120.0;
    return rig;
  }

  static NavState truth(double t) {
    const double w = 2.0 * 3.14159265358979 * 0.8;
    NavState state;
    state.p_w_b = Eigen::Vector3d(0.0, 0.25 * std::sin(w * t), 0.15 * std::sin(0.7 * w * t));
    state.v_w_b =
        Eigen::Vector3d(0.0, 0.25 * w * std::cos(w * t), 0.105 * w * std::cos(0.7 * w * t));
    state.gyro_bias = Eigen::Vector3d(0.01, -0.02, 0.03);
    return state;
  }

  static ImuSample imu(double t) {
    const double w = 2.0 * 3.14159265358979 * 0.8;
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

  static void write(evaluation::SequenceWriter* writer) {
    for (int k = 0; k <= static_cast<int>(200 * kSeconds); ++k) {
      ASSERT_EQ(writer->addImu(kT0Ns + 5000000LL * k, imu(k / 200.0)), "");
      if (k % 2 == 0) {
        ASSERT_EQ(writer->addTruth(kT0Ns + 5000000LL * k, truth(k / 200.0)), "");
      }
      if (k % 10 == 0) {
        ASSERT_EQ(writer->addImage(kT0Ns + 5000000LL * k, image(k / 200.0)), "");
      }
    }
    ASSERT_EQ(writer->finish(), "");
  }

  static void writeAsl(const std::string& directory) {
    std::string error;
    const auto writer = evaluation::makeAslWriter(directory, rig(), &error);
    ASSERT_NE(writer, nullptr) << error;
    write(writer.get());
  }

  static void writeBag(const std::string& file) {
    std::string error;
    const auto writer = evaluation::makeBagWriter(file, {"/wall/imu", "/wall/image"}, &error);
    ASSERT_NE(writer, nullptr) << error;
    write(writer.get());
  }

  /// The host's configuration file for this rig.
  static std::string config() {
    return R"(%YAML:1.0
imu_topic: "/wall/imu"
image_topic: "/wall/image"
model_type: PINHOLE
camera_name: camera
image_width: 320
image_height: 240
distortion_parameters: {k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0}
projection_parameters: {fx: 220.0, fy: 220.0, cx: 160.0, cy: 120.0}
extrinsicRotation: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0., 0., 1., -1., 0., 0., 0., -1., 0.]
extrinsicTranslation: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [0., 0., 0.]
g_norm: 9.81007
td: 0.0
slim_init:
  noise: {gyro_density: 1.7e-4, accel_density: 2.0e-3}
)";
  }
};

/// Runs `ab` on the arguments; the report goes to `out`.
ProgramRun ab(const ScratchFolder& folder, const std::string& out,
              std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"ab", "--out", folder.file(out)});
  return runProgram(folder, arguments);
}

TEST(AbAsl, RunsFromPixelsToTheReport) {
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  const ProgramRun run = ab(folder, "out",
                            {"--asl", folder.file("wall"), "--methods", "drt-l,slim-paper",
                             "--frames", folder.file("frames")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const auto json = summaryOf(folder.file("out"));
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
  EXPECT_TRUE(contains(readFile(folder.file("out/report.md")), "81 of 81 images tracked"));

  // A debug image per tracked image, named by its stamp.
  int pictures = 0;
  for (const auto& entry : fs::directory_iterator(folder.file("frames"))) {
    ++pictures;
    EXPECT_EQ(entry.path().extension(), ".png");
  }
  EXPECT_EQ(pictures, 81);
  const cv::Mat picture =
      cv::imread(folder.file("frames/") + std::to_string(Wall::kT0Ns + 50000000) + ".png");
  EXPECT_EQ(picture.size(), cv::Size(320, 240));
  EXPECT_EQ(picture.channels(), 3);
}

TEST(AbAsl, EqualRunsGiveEqualWindows) {
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  for (const char* out : {"first", "second"}) {
    ASSERT_EQ(ab(folder, out, {"--asl", folder.file("wall")}).exit_code, 0);
  }
  EXPECT_GT(windowsOf(folder.file("first")).size(), 1000u);
  EXPECT_EQ(windowsOf(folder.file("first")), windowsOf(folder.file("second")));
}

TEST(AbAsl, TheTruthIsTakenAtTheTimeOffsetOfTheConfiguration) {
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  folder.write("config.yaml", Wall::config());
  std::string late = Wall::config();
  late.replace(late.find("td: 0.0"), 7, "td: 0.5");
  folder.write("late.yaml", late);
  ASSERT_EQ(ab(folder, "right",
               {"--asl", folder.file("wall"), "--methods", "drt-l", "--config",
                folder.file("config.yaml")})
                .exit_code,
            0);
  const ProgramRun run = ab(
      folder, "late",
      {"--asl", folder.file("wall"), "--methods", "drt-l", "--config", folder.file("late.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err, "10 of 81 images lie outside the IMU data")) << run.err;
  const auto windows = readFile(folder.file("late/windows.csv"));
  EXPECT_TRUE(contains(windows, "wall,0,0.5,1500000000500000000,2.25,10,")) << windows;
}

TEST(AbAsl, WithoutTruthTheReportHasVerdictsOnly) {
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  fs::remove_all(folder.file("wall/mav0/state_groundtruth_estimate0"));
  const ProgramRun run = ab(folder, "out", {"--asl", folder.file("wall"), "--methods", "drt-l"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err, "state_groundtruth_estimate0/data.csv does not exist")) << run.err;
  EXPECT_FALSE(contains(run.out, "scale rmse")) << run.out;
  const auto json = summaryOf(folder.file("out"));
  EXPECT_EQ(json["has_truth"], false);
  EXPECT_EQ(json["gyro_bias_truth"], "none");
  const auto& all = json["methods"]["drt-l"]["all"];
  EXPECT_EQ(all["windows"], 4);
  EXPECT_EQ(all["attempted"], 4);
  EXPECT_TRUE(all["success_rate"].is_null());
}

TEST(AbAsl, UnreadableImagesAreCountedAndTheRunGoesOn) {
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  for (const int k : {7, 8}) {
    folder.write("wall/mav0/cam0/data/" + std::to_string(Wall::kT0Ns + 50000000LL * k) + ".png",
                 "torn");
  }
  cv::imwrite(
      folder.file("wall/mav0/cam0/data/") + std::to_string(Wall::kT0Ns + 50000000LL * 60) + ".png",
      cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)));
  fs::remove(folder.file("wall/mav0/cam0/data/") + std::to_string(Wall::kT0Ns + 50000000LL * 70) +
             ".png");
  const ProgramRun run = ab(folder, "out", {"--asl", folder.file("wall"), "--methods", "drt-l"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(contains(run.err, "2 of 80 images cannot be read")) << run.err;
  EXPECT_TRUE(contains(run.err, "1 of 80 images were refused")) << run.err;
  EXPECT_TRUE(contains(run.err, "1 of 81 images of")) << run.err;
  EXPECT_EQ(summaryOf(folder.file("out"))["tracking"]["tracked"], 77);
}

TEST(AbAsl, BadInputExitsWithTwoAndASentence) {
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  const auto refused = [&](const std::string& part) {
    const ProgramRun run = ab(folder, "out", {"--asl", folder.file("wall")});
    EXPECT_EQ(run.exit_code, 2) << part;
    EXPECT_EQ(run.err.rfind("slim_init: ", 0), 0u) << run.err;
    EXPECT_TRUE(contains(run.err, part)) << part << " in: " << run.err;
    EXPECT_FALSE(fs::exists(folder.file("out")));
  };
  fs::remove(folder.file("wall/mav0/cam0/sensor.yaml"));
  refused("no calibration that can be used");
  folder.write("wall/mav0/imu0/data.csv", "1,2,3\n");
  refused("imu0/data.csv line 1 has 3 columns, must have 7");
  fs::remove_all(folder.file("wall"));
  refused("is not a directory");
}

TEST(AbBag, GivesTheSameWindowsAsTheFolderBitForBit) {
  // rosbag is optional; that a build without it says so is tested in image_sequence_test.
  if (!evaluation::rosbagSupported()) GTEST_SKIP() << "this build is without rosbag";
  const ScratchFolder folder;
  Wall::writeAsl(folder.file("wall"));
  Wall::writeBag(folder.file("wall.bag"));
  folder.write("config.yaml", Wall::config());
  const std::string config = folder.file("config.yaml");
  ASSERT_EQ(ab(folder, "asl", {"--asl", folder.file("wall"), "--config", config}).exit_code, 0);
  ProgramRun run = ab(folder, "bag", {"--bag", folder.file("wall.bag"), "--config", config});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(windowsOf(folder.file("asl")).size(), 1000u);
  EXPECT_EQ(windowsOf(folder.file("asl")), windowsOf(folder.file("bag")));
  EXPECT_EQ(summaryOf(folder.file("bag"))["dataset"], "wall");

  // The truth may also be named, or be absent.
  fs::rename(evaluation::groundtruthFileOf(folder.file("wall.bag")), folder.file("truth.csv"));
  run = ab(folder, "named",
           {"--bag", folder.file("wall.bag"), "--config", config, "--groundtruth",
            folder.file("truth.csv")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(windowsOf(folder.file("asl")), windowsOf(folder.file("named")));
  run = ab(folder, "none", {"--bag", folder.file("wall.bag"), "--config", config});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(summaryOf(folder.file("none"))["has_truth"], false);
}

TEST(AbBag, BadBagsExitWithTwoAndASentence) {
  // rosbag is optional; that a build without it says so is tested in image_sequence_test.
  if (!evaluation::rosbagSupported()) GTEST_SKIP() << "this build is without rosbag";
  const ScratchFolder folder;
  Wall::writeBag(folder.file("wall.bag"));
  folder.write("config.yaml", Wall::config());
  std::string other = Wall::config();
  other.replace(other.find("/wall/image"), 11, "/cam0/image");
  folder.write("other.yaml", other);
  const auto refused = [&](const std::string& config, const std::string& part) {
    const ProgramRun run =
        ab(folder, "out", {"--bag", folder.file("wall.bag"), "--config", folder.file(config)});
    EXPECT_EQ(run.exit_code, 2) << part;
    EXPECT_TRUE(contains(run.err, part)) << part << " in: " << run.err;
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
class Snippet : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(SLIM_INIT_SNIPPET)) {
      // The EuRoC recordings are not part of the repository (their licence is not ours).
      GTEST_SKIP() << "no recording at " << SLIM_INIT_SNIPPET;
    }
  }
  ScratchFolder folder_;
};

TEST_F(Snippet, RunsEndToEndAndKeepsItsTracks) {
  const ProgramRun run = ab(folder_, "out", {"--asl", SLIM_INIT_SNIPPET});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = summaryOf(folder_.file("out"));
  EXPECT_EQ(json["dataset"], "euroc_v1_01_snippet");
  EXPECT_EQ(json["tracking"]["tracked"], 65);
  EXPECT_GE(json["tracking"]["points_carried"].get<double>(), 100.0);
  EXPECT_GE(json["tracking"]["lines_carried"].get<double>(), 40.0);
}

TEST_F(Snippet, EveryWindowIsStationaryWithGravityAndGyroBias) {
  const ProgramRun run =
      ab(folder_, "out", {"--asl", SLIM_INIT_SNIPPET, "--gates", "on", "--stride", "5"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = summaryOf(folder_.file("out"));
  ASSERT_FALSE(json["methods"].empty());
  for (const auto& [name, method] : json["methods"].items()) {
    const auto& all = method["all"];
    const int windows = all["windows"].get<int>();
    EXPECT_GE(windows, 4) << name;
    EXPECT_EQ(all["accepted"], 0) << name;  // no scale is claimed
    // These two refuse for want of parallax or of a solution, in their own words.
    if (name == "vins" || name == "openvins") continue;
    EXPECT_EQ(all["statuses"].value("stationary", 0), windows) << name << ": " << all["statuses"];
    ASSERT_TRUE(all["partial"].contains("stationary")) << name;
    EXPECT_EQ(all["partial"]["stationary"]["windows"], windows) << name;
    EXPECT_LE(all["partial"]["stationary"]["gravity_max_deg"].get<double>(), 1.0) << name;
    EXPECT_LE(all["partial"]["stationary"]["gyro_bias_max_pct"].get<double>(), 3.0) << name;
  }
}

}  // namespace
}  // namespace slim_init
