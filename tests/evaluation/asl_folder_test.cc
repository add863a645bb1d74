// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// ASL folders: what is written is read back, and what is wrong is named.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "evaluation/image_files.h"
#include "evaluation/scratch_folder.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/options.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;
using feature_tracker_lines::CameraModel;

/// A folder with a TinyRecording in it.
class AslFolderTest : public ::testing::Test {
 protected:
  void SetUp() override { write(TinyRecording::rig()); }

  void write(const WriterRig& rig) {
    fs::remove_all(directory());
    TinyRecording::write(directory(), rig);
  }

  std::string directory() const { return folder_.file("V9_01"); }
  std::string file(const std::string& name) const { return directory() + "/mav0/" + name; }
  std::string image(int k) const {
    return file("cam0/data/" +
                std::to_string(TinyRecording::kT0Ns + k * TinyRecording::kImageStepNs) + ".png");
  }

  void edit(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = readFile(file(name));
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from << " is not in " << name;
    text.replace(at, from.size(), to);
    folder_.write("V9_01/mav0/" + name, text);
  }
  void append(const std::string& name, const std::string& text) const {
    folder_.write("V9_01/mav0/" + name, readFile(file(name)) + text);
  }

  std::unique_ptr<ImageSequence> open() {
    return openAslFolder(directory(), WindowOptions().max_imu_gap_s, &status_);
  }

  /// The same of a folder that is in order.
  std::unique_ptr<ImageSequence> opened() {
    auto sequence = open();
    if (sequence == nullptr) throw std::runtime_error(status_.message);
    return sequence;
  }

  /// By the sensor.yaml files.
  Config configured() const {
    Config config;
    std::string error;
    EXPECT_TRUE(loadSensorFiles(directory(), &config, &error)) << error;
    return config;
  }

  ScratchFolder folder_;
  ReadStatus status_;
};

TEST_F(AslFolderTest, ReadsBackWhatWasWritten) {
  const auto sequence = opened();
  TinyRecording::expectIn(sequence.get());
  EXPECT_EQ(sequence->name, "V9_01");
  EXPECT_TRUE(sequence->notes.empty()) << sequence->notes.front();

  const Config config = configured();
  const WriterRig rig = TinyRecording::rig();
  const Calibration& calibration = config.calibration;
  const auto& camera = config.camera;
  EXPECT_LT((calibration.R_b_c - rig.calibration.R_b_c).norm(), 1e-14);
  EXPECT_EQ(calibration.t_b_c, rig.calibration.t_b_c);
  EXPECT_EQ(calibration.imu_noise.gyro_density, rig.calibration.imu_noise.gyro_density);
  EXPECT_EQ(calibration.imu_noise.accel_density, rig.calibration.imu_noise.accel_density);
  EXPECT_NEAR(calibration.focal_px, 60.666, 1e-3);
  EXPECT_EQ(camera.model, CameraModel::kPinhole);
  EXPECT_EQ(camera.width, 64);
  EXPECT_EQ(camera.height, 48);
  EXPECT_EQ(camera.fx, rig.camera.fx);
  EXPECT_EQ(camera.cy, rig.camera.cy);
  EXPECT_EQ(camera.distortion, rig.camera.distortion);
  // Other readers of the format ask for them.
  expectParts(readFile(file("imu0/sensor.yaml")), "\nrate_hz: 200\n");
  expectParts(readFile(file("cam0/sensor.yaml")), "\nrate_hz: 20\n");
}

TEST_F(AslFolderTest, AnyOfTheUsualFoldersMayBeNamed) {
  for (const std::string& name :
       {directory(), directory() + "/", directory() + "/mav0", directory() + "/mav0/"}) {
    const auto sequence = openAslFolder(name, WindowOptions().max_imu_gap_s, &status_);
    ASSERT_NE(sequence, nullptr) << name << ": " << status_.message;
    EXPECT_EQ(sequence->name, "V9_01") << name;
  }
}

TEST_F(AslFolderTest, OtherLensesComeBack) {
  WriterRig rig = TinyRecording::rig();
  for (const CameraModel model : {CameraModel::kKannalaBrandt, CameraModel::kMei}) {
    rig.camera.model = model;
    rig.camera.xi = model == CameraModel::kMei ? 1.9 : 0.0;
    write(rig);
    const Config config = configured();
    EXPECT_EQ(config.camera.model, model);
    EXPECT_EQ(config.camera.xi, rig.camera.xi);
    EXPECT_EQ(config.camera.distortion, rig.camera.distortion);
  }
}

TEST_F(AslFolderTest, SensorFilesOfTheDatasetHaveNoDirective) {
  for (const char* name : {"cam0/sensor.yaml", "imu0/sensor.yaml"}) {
    edit(name, "%YAML:1.0\n", "# General sensor definitions.\n");
  }
  EXPECT_EQ(configured().camera.width, 64);
}

struct BadSensor {
  const char* name;
  const char* file;
  const char* from;
  const char* to;
  const char* said;
};

TEST_F(AslFolderTest, UnusableSensorFilesAreNamed) {
  const std::vector<BadSensor> cases = {
      {"lens", "cam0/sensor.yaml", "pinhole", "double-sphere", "camera_model|double-sphere"},
      {"distortion", "cam0/sensor.yaml", "radial-tangential", "fov", "distortion_model|fov"},
      {"count", "cam0/sensor.yaml", "intrinsics: [", "intrinsics: [1.0, ", "intrinsics|5"},
      {"kind", "cam0/sensor.yaml", "resolution: [64", "resolution: [wide", "resolution"},
      {"size", "cam0/sensor.yaml", "resolution: [64", "resolution: [-64", "resolution|-64"},
      {"key", "cam0/sensor.yaml", "intrinsics:", "intrinsic:", "intrinsics is missing"},
      {"rotation", "cam0/sensor.yaml", "data: [", "data: [7", "T_BS|rotation"},
      {"noise", "imu0/sensor.yaml", "gyroscope_noise_density: ", "gyroscope_noise_density: -",
       "gyro_density"},
      {"body", "imu0/sensor.yaml", "data: [1", "data: [0.5", "T_BS is not the identity"},
      {"yaml", "imu0/sensor.yaml", "T_BS:", "T_BS: [", "not a YAML file"},
      {"line", "imu0/sensor.yaml", "%YAML:1.0\n", "# IMU\nx: 3,0\n", "line 2:|x: 3,0"},
      {"documents", "imu0/sensor.yaml", "T_BS:", "...\n- 4\nT_BS:", "comes after the end"},
  };
  for (const BadSensor& bad : cases) {
    SCOPED_TRACE(bad.name);
    const std::string original = readFile(file(bad.file));
    edit(bad.file, bad.from, bad.to);
    Config config;
    std::string error;
    EXPECT_FALSE(loadSensorFiles(directory(), &config, &error));
    EXPECT_EQ(config.camera.width, feature_tracker_lines::CameraParameters().width) << "as it was";
    EXPECT_TRUE(contains(error, bad.file)) << error;
    expectParts(error, bad.said);
    // --config may still bring a calibration, so the data are no error.
    opened();
    folder_.write(std::string("V9_01/mav0/") + bad.file, original);
  }
  fs::remove(file("imu0/sensor.yaml"));
  Config config;
  std::string error;
  EXPECT_FALSE(loadSensorFiles(directory(), &config, &error));
  expectParts(error, "imu0/sensor.yaml: the file cannot be opened");
}

struct BadFolder {
  const char* name;
  std::function<void(const std::string& mav0)> spoil;
  const char* said;
};

TEST_F(AslFolderTest, ErrorsNameFileLineAndValue) {
  const auto overwrite = [](const char* name, const char* text) {
    return [name, text](const std::string& mav0) { std::ofstream(mav0 + "/" + name) << text; };
  };
  const std::vector<BadFolder> cases = {
      {"no camera", [](const std::string& mav0) { fs::remove_all(mav0 + "/cam0"); },
       "not an ASL folder"},
      {"no IMU", [](const std::string& mav0) { fs::remove(mav0 + "/imu0/data.csv"); },
       "imu0/data.csv does not exist"},
      {"IMU word", overwrite("imu0/data.csv", "1,0,0,0,0,0,9\n2,0,0,x,0,0,9\n"),
       "imu0/data.csv line 2|column 4 (w_z)|'x'"},
      {"one sample", overwrite("imu0/data.csv", "1,0,0,0,0,0,9\n2,0,0,0,0,0,nan\n"),
       "imu0/data.csv has 1 rows|(minimum 2)"},
      {"image stamp", overwrite("cam0/data.csv", "1.5,a.png\n"),
       "cam0/data.csv line 1|'1.5'|whole number"},
      {"images gone", [](const std::string& mav0) { fs::remove_all(mav0 + "/cam0/data"); },
       "names 0 images that exist|.png does not exist"},
      {"truth columns", overwrite("state_groundtruth_estimate0/data.csv", "1,2,3\n"),
       "state_groundtruth_estimate0/data.csv line 1 has 3 columns|8 or 17"},
      {"truth quaternion",
       overwrite("state_groundtruth_estimate0/data.csv",
                 "1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,0\n3,0,0,0,2,0,0,0\n4,0,0,0,1,0,0,0\n"),
       "line 3|norm is 2"},
  };
  for (const BadFolder& bad : cases) {
    SCOPED_TRACE(bad.name);
    write(TinyRecording::rig());
    bad.spoil(directory() + "/mav0");
    EXPECT_EQ(open(), nullptr);
    expectParts(status_.message, bad.said);
  }
  EXPECT_EQ(openAslFolder(directory() + "/nothing", WindowOptions().max_imu_gap_s, &status_),
            nullptr);
  expectParts(status_.message, "is not a directory");
}

TEST_F(AslFolderTest, WhatIsOutOfOrderIsSortedInAndWhatRepeatsIsDropped) {
  const std::int64_t t = TinyRecording::kT0Ns;
  append("imu0/data.csv", std::to_string(t + 1000000) + ",1,2,3,4,5,6\n" +  // between the first two
                              std::to_string(t) + ",9,9,9,9,9,9\n" +        // again
                              std::to_string(t + 2000000) + ",1,2,3,inf,5,6\n");
  std::string rows = readFile(file("imu0/data.csv"));  // and one stamp is late: one fault
  const std::string third = std::to_string(t + 2 * TinyRecording::kImuStepNs);
  rows.replace(rows.find(third), third.size(), std::to_string(t + 300000001));
  std::ofstream(file("imu0/data.csv")) << rows;
  append("cam0/data.csv", std::to_string(t + TinyRecording::kImageStepNs) + ",other.png\n" +
                              std::to_string(t + 1) + "," + std::to_string(t) + ".png\n");
  const std::string truth = readFile(file("state_groundtruth_estimate0/data.csv"));
  const std::size_t second = truth.find('\n', truth.find('\n') + 1) + 1;
  append("state_groundtruth_estimate0/data.csv",
         truth.substr(second, truth.find('\n', second) + 1 - second));
  const auto sequence = opened();
  EXPECT_EQ(sequence->imu_disorder.out_of_order, 3);
  EXPECT_EQ(sequence->imu_disorder.repeated, 1);
  EXPECT_EQ(sequence->imu_disorder.unreadable, 1);
  EXPECT_EQ(sequence->imu.size(), TinyRecording::kImuSamples + 1u);
  EXPECT_EQ(sequence->imu[0].gyro, TinyRecording::imu(0).gyro);  // the first of the two stays
  EXPECT_EQ(sequence->imu[1].gyro, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(sequence->image_disorder.out_of_order, 2);
  EXPECT_EQ(sequence->image_disorder.repeated, 1);
  EXPECT_EQ(sequence->images(), TinyRecording::kImages + 1u);
  EXPECT_EQ(sequence->stampNs(sequence->image_times[1]), t + 1);
  EXPECT_EQ(cv::norm(sequence->image(1, nullptr), TinyRecording::image(0), cv::NORM_INF), 0.0);
  ASSERT_EQ(sequence->notes.size(), 3u);
  expectParts(sequence->notes[0],
              "imu0/data.csv|1 IMU samples with the stamp of another|3 IMU samples out of order|"
              "1 IMU samples that cannot be read or are not finite");
  expectParts(sequence->notes[2], "1 rows with the stamp of another");
}

TEST_F(AslFolderTest, UnreadableImagesAreNamedAndTheRestIsRead) {
  fs::remove(image(3));
  folder_.write("V9_01/mav0/cam0/data/" + fs::path(image(5)).filename().string(),
                readFile(image(5)).substr(0, 60));
  folder_.write("V9_01/mav0/cam0/data/" + fs::path(image(6)).filename().string(), "no image");
  const auto sequence = opened();
  // Without a file: known before anything is decoded.
  EXPECT_EQ(sequence->image_disorder.unreadable, 1);
  ASSERT_EQ(sequence->images(), static_cast<std::size_t>(TinyRecording::kImages - 1));
  ASSERT_EQ(sequence->notes.size(), 1u);
  expectParts(sequence->notes[0], "1 of 20 images");
  EXPECT_TRUE(contains(sequence->notes[0], image(3))) << sequence->notes[0];
  for (const std::size_t k : {4u, 5u}) {
    expectNoImage(sequence.get(), k, "cannot be decoded");
    EXPECT_TRUE(sequence->image(k, nullptr).empty());
  }
  fs::remove(image(7));  // after opening
  expectNoImage(sequence.get(), 6, "is gone");
  EXPECT_EQ(cv::norm(sequence->image(7, nullptr), TinyRecording::image(8), cv::NORM_INF), 0.0);
}

TEST_F(AslFolderTest, ColourBecomesGrey) {
  cv::Mat colour(48, 64, CV_8UC3, cv::Scalar(255, 0, 0));
  ASSERT_TRUE(cv::imwrite(image(0), colour));
  const auto sequence = opened();
  const cv::Mat grey = sequence->image(0, nullptr);
  ASSERT_EQ(grey.type(), CV_8UC1);
  EXPECT_NEAR(grey.at<std::uint8_t>(10, 10), 0.114 * 255, 1.0);  // ITU-R BT.601 blue
}

TEST_F(AslFolderTest, TruthIsOptional) {
  fs::remove_all(file("state_groundtruth_estimate0"));
  const auto sequence = opened();
  EXPECT_TRUE(sequence->truth.empty());
  EXPECT_TRUE(sequence->notes.empty());
}

TEST_F(AslFolderTest, TruthMayHoldPosesOnly) {
  std::string rows;
  for (int k = 0; k < 10; ++k) {
    rows += std::to_string(TinyRecording::kT0Ns + 100000000LL * k) + ",1,2,3,1,0,0,0\n";
  }
  folder_.write("V9_01/mav0/state_groundtruth_estimate0/data.csv", rows);
  const auto sequence = opened();
  ASSERT_EQ(sequence->truth.size(), 10u);
  EXPECT_FALSE(sequence->has_velocity_and_bias);
  EXPECT_EQ(sequence->truth[0].v_w_b, Eigen::Vector3d::Zero());  // the positions stand still
  EXPECT_TRUE(std::isnan(sequence->truth[0].gyro_bias.x()));
}

TEST_F(AslFolderTest, WriterRefusesAnOccupiedFolder) {
  const auto refusal = [](const std::string& directory) {
    return writeAslFolder(directory, TinyRecording::rig(), TinyRecording::recording());
  };
  expectParts(refusal(directory()), "holds files already");
  folder_.write("occupied", "");
  expectParts(refusal(folder_.file("occupied")), "cannot be made");
  expectParts(writeAslImage(folder_.file("none"), 1, TinyRecording::image(0)), "cannot be written");
}

}  // namespace
}  // namespace slim_init::evaluation
