// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init doctor` on recordings with pixels, as a user runs it.
#include "slim_init/doctor/doctor_images.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "filmed_room.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "tools/run_program.h"

namespace slim_init {
namespace {

namespace fs = std::filesystem;

class DoctorTool : public ProgramTest {
 protected:
  /// A copy to change; its folder with the sensors.
  fs::path copy() const {
    copyRoom(folder.file("copy"));
    return fs::path(folder.file("copy")) / "mav0";
  }

  ProgramRun doctor(const std::string& line) {
    const ProgramRun run = typed("doctor --json @doctor.json " + line);
    json_ = nlohmann::json::parse(readFile(folder.file("doctor.json")), nullptr, false);
    return run;
  }
  std::string severity(const std::string& check) const { return finding(check).at("severity"); }
  double value(const std::string& check) const { return finding(check).at("value"); }
  nlohmann::json finding(const std::string& check) const {
    for (const auto& f : json_.at("findings")) {
      if (f.at("check") == check) return f;
    }
    return {};
  }

  nlohmann::json json_;
};

TEST_F(DoctorTool, IsQuietOnAGoodRecording) {
  const ProgramRun run = doctor("--asl " + filmedRoom());
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_EQ(run.err, "");
  expectParts(run.out, "room: 0 errors, 0 warnings, 1 check not possible");
  EXPECT_EQ(json_.at("worst"), "not_checked") << "clouds have no lines";
  // Five seconds are two windows, too few to compare their lever arms.
  EXPECT_EQ(severity("extrinsic_translation"), "not_checked");
  EXPECT_EQ(severity("lines"), "note");
  EXPECT_NEAR(value("time_offset"), 0.0, 2.0);
  EXPECT_LT(value("extrinsic_rotation"), 0.5);
}

TEST_F(DoctorTool, MeasuresATimeOffsetFromPixels) {
  const fs::path copied = copy(), table = copied / "cam0" / "data.csv";
  std::istringstream rows(readFile(table.string()));
  std::ostringstream late;
  for (std::string row; std::getline(rows, row);) {
    const std::size_t comma = row.find(',');
    if (row[0] != '#') {
      row = std::to_string(std::stoll(row.substr(0, comma)) - 30000000) + row.substr(comma);
    }
    late << row << "\n";
  }
  std::ofstream(table) << late.str();
  std::ofstream(copied / "imu0" / "data.csv", std::ios::app) << "1,0,0,0,0,0,nan\n";
  const ProgramRun run = doctor("--asl @copy");
  EXPECT_EQ(run.exit_code, 1) << run.out << run.err;
  EXPECT_NEAR(value("time_offset"), 30.0, 3.0);
  expectParts(run.out, "-> Set td: 0.0");
  expectParts(run.err, "slim_init: note: |1 IMU samples that cannot be read or are not finite");
  EXPECT_EQ(severity("extrinsic_rotation"), "ok");
}

TEST_F(DoctorTool, FindsATurnedExtrinsicInTheConfiguration) {
  folder.write("good.yaml", roomConfiguration());
  EXPECT_EQ(doctor("--config @good.yaml --asl " + filmedRoom()).exit_code, 0);
  folder.write("turned.yaml", roomConfiguration(roomRig().calibration.R_b_c *
                                                expSO3(Eigen::Vector3d(0, M_PI / 2, 0))));
  const ProgramRun run = doctor("--config @turned.yaml --asl " + filmedRoom());
  EXPECT_EQ(run.exit_code, 2) << run.out << run.err;
  EXPECT_NEAR(value("extrinsic_rotation"), 90.0, 0.5);
  EXPECT_EQ(severity("time_offset"), "ok");
  EXPECT_EQ(severity("gyro_scale"), "ok");
}

TEST_F(DoctorTool, FindsBlackImages) {
  for (const auto& entry : fs::directory_iterator(copy() / "cam0" / "data")) {
    cv::Mat image = cv::Mat::zeros(240, 376, CV_8UC1);
    feature_tracker_lines::addNoise(1.5, 1, &image);
    cv::imwrite(entry.path().string(), image);
  }
  const ProgramRun run = doctor("--asl @copy");
  EXPECT_EQ(run.exit_code, 2) << run.out << run.err;
  EXPECT_EQ(severity("image_black"), "error");
  EXPECT_EQ(severity("time_offset"), "not_checked");
}

TEST_F(DoctorTool, ReadsABag) {
  // rosbag is optional; that a build without it says so is tested in image_sequence_test.
  if (!evaluation::rosbagSupported()) GTEST_SKIP() << "this build has no rosbag";
  ASSERT_EQ(evaluation::writeBag(filmedRoom(), roomTopics(), folder.file("room.bag")), "");
  folder.write("config.yaml", roomConfiguration());
  const ProgramRun run = doctor("--bag @room.bag --config @config.yaml");
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_EQ(severity("time_offset"), "ok");
  EXPECT_EQ(severity("extrinsic_rotation"), "ok");
}

TEST_F(DoctorTool, StopsAtTheLimitAndKeepsQuiet) {
  const ProgramRun run = doctor("--limit 30 --quiet --asl " + filmedRoom());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  EXPECT_TRUE(contains(finding("image_order").at("message"), " images, all in order"));
  EXPECT_TRUE(contains(finding("clocks").at("message"), "0 of 30 images"));
}

TEST_F(DoctorTool, RefusesWhatItCannotUse) {
  expectRefused("doctor", "give one of --asl DIR and --bag FILE");
  expectRefused("doctor --bag x --asl " + filmedRoom(), "give one of");
  expectRefused("doctor --bag x", "--bag needs --config");
  expectRefused("doctor --asl @none", "is not a directory");
  expectRefused("doctor --config @none --asl " + filmedRoom(), "none: the file cannot be opened");
  expectRefused("doctor --json @none/x.json --asl " + filmedRoom(), "--json");
}

TEST_F(DoctorTool, RealImagesStandingStill) {
  // The EuRoC recordings are no part of the repository: their licence is not ours.
  if (!fs::is_directory(SLIM_INIT_SNIPPET)) GTEST_SKIP() << "no recording in " SLIM_INIT_SNIPPET;
  const ProgramRun run = doctor("--asl " SLIM_INIT_SNIPPET);
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_EQ(severity("time_offset"), "not_checked");
  EXPECT_EQ(severity("extrinsic_rotation"), "not_checked");
  expectParts(run.out, "the rig stands still");
}

/// A textured wall seen straight on.
cv::Mat texture() {
  cv::Mat image(240, 376, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<uchar>(y, x) = ((x / 30 + y / 30) % 2) != 0 ? 200 : 60;
    }
  }
  return image;
}

TEST(ImageFacts, MeasuresBlur) {
  const cv::Mat sharp = texture();
  for (const double sigma : {0.8, 2.0, 3.5}) {
    cv::Mat image;
    cv::GaussianBlur(sharp, image, cv::Size(), sigma);
    feature_tracker_lines::addNoise(2.0, 7, &image);
    const double measured = evaluation::imageFacts(0.0, image, cv::Mat(), image.size()).blur_px;
    EXPECT_NEAR(measured, sigma, 0.25 * sigma + 0.2);
  }
  cv::Mat blank(240, 376, CV_8UC1, cv::Scalar(128));
  feature_tracker_lines::addNoise(2.0, 7, &blank);
  EXPECT_TRUE(std::isnan(evaluation::imageFacts(0.0, blank, cv::Mat(), blank.size()).blur_px));
}

TEST(ImageFacts, TellsLightSizeAndRepetition) {
  const cv::Mat image = texture();
  const evaluation::ImageFacts good = evaluation::imageFacts(1.5, image, cv::Mat(), image.size());
  EXPECT_EQ(good.t, 1.5);
  EXPECT_EQ(good.p99, 200.0);
  EXPECT_EQ(good.saturated, 0.0);
  EXPECT_FALSE(good.repeats);
  EXPECT_TRUE(good.right_size);
  EXPECT_TRUE(evaluation::imageFacts(0.0, image, image.clone(), image.size()).repeats);
  cv::Mat other = image.clone();
  other.at<uchar>(3, 3) += 1;
  EXPECT_FALSE(evaluation::imageFacts(0.0, image, other, image.size()).repeats);
  EXPECT_FALSE(evaluation::imageFacts(0.0, image, cv::Mat(), cv::Size(752, 480)).right_size);
  const cv::Mat white(240, 376, CV_8UC1, cv::Scalar(255));
  EXPECT_EQ(evaluation::imageFacts(0.0, white, cv::Mat(), white.size()).saturated, 1.0);
  EXPECT_TRUE(std::isnan(evaluation::imageFacts(0.0, cv::Mat(), cv::Mat(), image.size()).p99));
}

}  // namespace
}  // namespace slim_init
