// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "calibration_advice.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "support/gaussian.h"
#include "support/text_parts.h"

namespace slim_init::vins_adapter {
namespace {

constexpr double kRad = 1.0 / 57.29577951308232;

CalibrationEstimate estimate(double td, double turn_deg) {
  CalibrationEstimate found;
  found.R_b_c = Eigen::AngleAxisd(turn_deg * kRad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  found.td = td;
  found.covariance.diagonal() << Eigen::Vector3d::Constant(std::pow(0.4 * kRad, 2)),
      Eigen::Vector3d::Constant(1e-4), 1e-6, 0.0;
  return found;
}

TEST(CalibrationAdvice, ComesWhenWindowsAgree) {
  CalibrationAdvice advice;
  std::string said;
  int windows = 0;
  for (double t = 0.0; said.empty() && t < 60.0; t += 4.0) {
    said = advice.add(t, estimate(0.02, 3.0));
    ++windows;
  }
  EXPECT_EQ(windows, CalibrationAdvice::kWindows);
  expectParts(said,
              "\ntd: 0.02\n|\nextrinsicRotation:|"
              "# rotation: 3 deg from the file's, standard deviation 0.21 deg");
  EXPECT_EQ(advice.add(100.0, estimate(0.02, 3.0)), "") << "once";
}

TEST(CalibrationAdvice, WindowsWithCommonDataAreOne) {
  CalibrationAdvice advice;
  for (double t = 0.0; t < 3.4; t += 0.1) EXPECT_EQ(advice.add(t, estimate(0.02, 3.0)), "");
  EXPECT_EQ(advice.add(4.0, OptionalCalibration()), "");
}

// A calibration that is correct, as windows see it that say more than they know: one in three is a
// degree off.
TEST(CalibrationAdvice, ACorrectCalibrationStays) {
  Gaussian normal(3);
  int said = 0;
  for (int flight = 0; flight < 200; ++flight) {
    CalibrationAdvice advice;
    for (int k = 0; k < 20; ++k) {
      said += advice.add(4.0 * k, estimate(1e-3 * normal(), normal())).empty() ? 0 : 1;
    }
  }
  EXPECT_LE(said, 2);
}

// Hours without advice: only the newest windows are kept.
TEST(CalibrationAdvice, OldWindowsAreForgotten) {
  constexpr int kKept = CalibrationAdvice::kKept, kOld = 3 * kKept;
  CalibrationAdvice advice;
  std::string said;
  for (int k = 0; k < kOld; ++k) said += advice.add(4.0 * k, estimate(0.0, k % 2 == 0 ? 30 : -30));
  EXPECT_EQ(said, "");
  for (int k = kOld; k <= kOld + kKept; ++k) said += advice.add(4.0 * k, estimate(0.02, 3.0));
  EXPECT_EQ(said.find(std::to_string(kKept) + " windows agree"), 0u) << said;
}

TEST(CalibrationAdvice, AFileWithoutARotationGetsOne) {
  host_health::FileCalibration file;
  file.has_rotation = false;
  CalibrationAdvice advice(file);
  std::string said;
  for (int k = 0; k < CalibrationAdvice::kWindows; ++k) said = advice.add(4.0 * k, estimate(0, 0));
  expectParts(said, "extrinsicRotation");
}

}  // namespace
}  // namespace slim_init::vins_adapter
