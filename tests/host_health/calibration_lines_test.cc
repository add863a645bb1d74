// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Lines for the host's file: when they come, and that the file with them is read as what was found.
#include "slim_init/host_health/calibration_lines.h"

#include <gtest/gtest.h>

#include "geometry/so3.h"

namespace slim_init::host_health {
namespace {

constexpr double kRad = 3.14159265358979323846 / 180.0;

class CalibrationLines : public ::testing::Test {
 protected:
  CalibrationLines() {
    file_.calibration.R_b_c = expSO3(Eigen::Vector3d(0.3, -1.2, 0.8));
    file_.calibration.t_b_c = Eigen::Vector3d(0.1, 0.2, 0.3);
    file_.calibration.td = 0.004;
    found_.R_b_c = file_.calibration.R_b_c;
    found_.t_b_c = file_.calibration.t_b_c;
    found_.td = 0.004;
    const double rotation = 0.5 * kRad, translation = 0.01, td = 0.002, readout = 0.001;
    found_.covariance.diagonal() << Eigen::Vector3d::Constant(rotation * rotation),
        Eigen::Vector3d::Constant(translation * translation), td * td, readout * readout;
  }
  bool has(const std::string& text) const {
    return calibrationLines(file_, found_).find(text) != std::string::npos;
  }
  FileCalibration file_;
  CalibrationEstimate found_;
};

TEST_F(CalibrationLines, NothingWithinTwoStandardDeviations) {
  found_.td += 0.0039;
  found_.R_b_c = found_.R_b_c * expSO3(Eigen::Vector3d(0, 0.95 * kRad, 0));
  found_.t_b_c.y() -= 0.019;
  EXPECT_EQ(calibrationLines(file_, found_), "");
}

TEST_F(CalibrationLines, EachKeyBeyondThem) {
  found_.td -= 0.0043;
  EXPECT_EQ(calibrationLines(file_, found_),
            "# time offset: 4.3 ms from the file's, standard deviation 2 ms\ntd: -0.0003\n");
  found_.td = 0.004;
  found_.readout_s = 0.03;
  EXPECT_EQ(calibrationLines(file_, found_),
            "# readout: 30 ms from the file's, standard deviation 1 ms\nrolling_shutter: "
            "1\nrolling_shutter_tr: "
            "0.03\n");
  found_.readout_s = 0.0;
  found_.R_b_c = found_.R_b_c * expSO3(Eigen::Vector3d(0, 1.05 * kRad, 0));
  EXPECT_TRUE(has("standard deviation 0.5 deg\nextrinsicRotation: !!opencv-matrix\n"));
  EXPECT_FALSE(has("extrinsicTranslation"));
  EXPECT_FALSE(has("td:"));
  found_.t_b_c.z() += 0.021;
  EXPECT_TRUE(
      has("# translation: 21 mm from the file's, standard deviation 10 mm\n"
          "extrinsicTranslation: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n"
          "   data: [0.1,\n          0.2,\n          0.321]\n"));
}

// A difference that is certain and does not matter: a td of 1 ms with a sigma of 0.49 ms was
// reported from a recording whose file is right.
TEST_F(CalibrationLines, WhatIsCertainHasToMatterToo) {
  const double rotation = 0.05 * kRad, translation = 0.001, td = 0.0002, readout = 0.0002;
  found_.covariance.diagonal() << Eigen::Vector3d::Constant(rotation * rotation),
      Eigen::Vector3d::Constant(translation * translation), td * td, readout * readout;
  const Calibration& file = file_.calibration;
  const auto with = [&](double ms, double readout_ms, double deg, double mm) {
    found_.td = file.td - 1e-3 * ms;
    found_.readout_s = file.readout_s + 1e-3 * readout_ms;
    found_.R_b_c = file.R_b_c * expSO3(Eigen::Vector3d(deg * kRad, 0, 0));
    found_.t_b_c = file.t_b_c + Eigen::Vector3d(1e-3 * mm, 0, 0);
    return calibrationLines(file_, found_);
  };
  EXPECT_EQ(with(2.9, 4.9, 0.98, 19.5), "");
  const auto key = [](const std::string& lines) {  // of the line behind the comment
    const std::size_t begin = lines.find('\n') + 1;
    return lines.substr(begin, lines.find(':', begin) - begin);
  };
  EXPECT_EQ(key(with(3.1, 4.9, 0.98, 19.5)), "td");
  EXPECT_EQ(key(with(2.9, 5.1, 0.98, 19.5)), "rolling_shutter");
  EXPECT_EQ(key(with(2.9, 4.9, 1.02, 19.5)), "extrinsicRotation");
  EXPECT_EQ(key(with(2.9, 4.9, 0.98, 20.5)), "extrinsicTranslation");
}

// What is held as exact is never contradicted.
TEST_F(CalibrationLines, ExactPartsHaveNoLine) {
  found_.covariance.setZero();
  EXPECT_EQ(calibrationLines(file_, found_), "");
}

TEST_F(CalibrationLines, AnExtrinsicThatTheFileDoesNotHave) {
  file_.has_rotation = file_.has_translation = false;
  EXPECT_TRUE(has("# rotation: standard deviation 0.5 deg\nextrinsicRotation: "));
  EXPECT_TRUE(has("# translation: standard deviation 10 mm\nextrinsicTranslation: "));
}

TEST_F(CalibrationLines, OneMatrixForVinsFusion) {
  file_.extrinsic_in_one_matrix = true;
  EXPECT_EQ(calibrationLines(file_, found_), "");
  found_.t_b_c.z() += 0.021;
  EXPECT_TRUE(has("body_T_cam0: !!opencv-matrix\n   rows: 4\n   cols: 4\n"));
  EXPECT_TRUE(has("0, 0, 0, 1]\n"));
  EXPECT_FALSE(has("extrinsicRotation"));
}

}  // namespace
}  // namespace slim_init::host_health
