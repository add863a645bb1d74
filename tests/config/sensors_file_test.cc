// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/config/sensors_file.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace slim_init {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

class SensorsFile : public ::testing::Test {
 protected:
  SensorsFile() {
    known_.biases = {Vector3d(-0.0022, 0.0208, 0.0765), Vector3d(0.1, -1.0 / 3.0, 0.05), 1e-3,
                     0.03};
    CalibrationEstimate& found = known_.calibration.emplace();
    found.R_b_c = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    found.t_b_c = Vector3d(0.01, -0.02, 0.03);
    found.td = -0.011;
    found.covariance.diagonal() << 1e-5, 1e-5, 1e-5, 1e-6, 1e-6, 1e-6, 1e-6, 0.0;
    configured_.td = 0.002;
  }
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  bool save() { return saveSensorsFile(path_, configured_, 1.7e9 + 0.1, known_, &error_); }
  bool load() { return loadSensorsFile(path_, configured_, &stamp_, &read_, &error_); }
  std::string text() const {
    std::ostringstream out;
    out << std::ifstream(path_).rdbuf();
    return out.str();
  }
  // Replaces `from` and expects a message with `wanted`; nothing is read.
  void expectProblem(const std::string& from, const std::string& to, const std::string& wanted) {
    ASSERT_TRUE(save()) << error_;
    std::string changed = text();
    const std::size_t at = changed.find(from);
    ASSERT_NE(at, std::string::npos) << changed;
    std::ofstream(path_) << changed.replace(at, from.size(), to);
    read_ = KnownSensors();
    stamp_ = -1.0;
    EXPECT_FALSE(load());
    EXPECT_NE(error_.find(path_), std::string::npos) << error_;
    EXPECT_NE(error_.find(wanted), std::string::npos) << error_;
    EXPECT_EQ(stamp_, -1.0);
    EXPECT_FALSE(read_.calibration.has_value());
  }

  const std::string folder_ = ::testing::TempDir() + "/sensors_file_test";
  const std::string path_ = folder_ + "/sensors.yaml";
  Calibration configured_;
  KnownSensors known_, read_;
  double stamp_ = 0.0;
  std::string error_;
};

TEST_F(SensorsFile, IsReadAsItWasWritten) {
  ASSERT_TRUE(save()) << error_;
  EXPECT_FALSE(fs::exists(path_ + ".part"));
  ASSERT_TRUE(load()) << error_;
  EXPECT_EQ(stamp_, 1.7e9 + 0.1);
  EXPECT_EQ(read_.biases.gyro, known_.biases.gyro);
  EXPECT_EQ(read_.biases.accel, known_.biases.accel);
  EXPECT_EQ(read_.biases.gyro_sigma, known_.biases.gyro_sigma);
  EXPECT_EQ(read_.biases.accel_sigma, known_.biases.accel_sigma);
  ASSERT_TRUE(read_.calibration.has_value());
  EXPECT_EQ(read_.calibration->R_b_c, known_.calibration->R_b_c);
  EXPECT_EQ(read_.calibration->t_b_c, known_.calibration->t_b_c);
  EXPECT_EQ(read_.calibration->td, known_.calibration->td);
  EXPECT_LT((read_.calibration->covariance - known_.calibration->covariance).norm(), 1e-18);
  known_.calibration = OptionalCalibration();
  ASSERT_TRUE(save()) << error_;
  ASSERT_TRUE(load()) << error_;
  EXPECT_FALSE(read_.calibration.has_value());
}

TEST_F(SensorsFile, ACalibrationOfAnotherRigIsLeftOut) {
  ASSERT_TRUE(save()) << error_;
  const Calibration before = configured_;
  configured_.td += 1e-3;
  ASSERT_TRUE(load()) << error_;
  EXPECT_FALSE(read_.calibration.has_value());
  EXPECT_EQ(read_.biases.gyro, known_.biases.gyro);
  configured_ = before;
  configured_.t_b_c.x() += 1e-3;
  ASSERT_TRUE(load()) << error_;
  EXPECT_FALSE(read_.calibration.has_value());
  configured_ = before;
  ASSERT_TRUE(load()) << error_;
  EXPECT_TRUE(read_.calibration.has_value());
}

TEST_F(SensorsFile, ProblemsAreNamed) {
  EXPECT_FALSE(load());
  EXPECT_NE(error_.find("cannot be opened"), std::string::npos) << error_;
  expectProblem("gyro_bias:", "gyro_byas:", "gyro_bias is missing");
  expectProblem("accel_bias_sigma: 2.9999999999999999e-02", "accel_bias_sigma: -1.",
                "accel_sigma is -1, must be in");
  expectProblem("td:", "td: no\ntd2:", "td is \"no\", must be a number");
  expectProblem("gyro_bias: [", "gyro_bias: [ 1., ", "must be a list of 3 numbers");
  expectProblem("R_b_c: [ 9.", "R_b_c: [ 5.", "no rotation");
}

TEST_F(SensorsFile, ThatCannotBeWrittenLeavesTheOldOne) {
  ASSERT_TRUE(save()) << error_;
  const std::string before = text();
  fs::create_directory(path_ + ".part");  // in the way
  known_.biases.accel_sigma = 0.5;
  EXPECT_FALSE(save());
  EXPECT_NE(error_.find(path_ + " cannot be written"), std::string::npos) << error_;
  EXPECT_EQ(text(), before);
}

}  // namespace
}  // namespace slim_init
