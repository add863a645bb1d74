// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim` on rigs that are off: what it finds, how sure it says to be, and what it cannot know.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/so3.h"
#include "pipeline/rotation_stage.h"
#include "slim_init/baselines/baselines.h"
#include "slim_init/types.h"
#include "slim_init/work_budget.h"
#include "support/chi_square.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;

InitializerOptions simulatedImu() {
  InitializerOptions options = dataSheetOptions();
  options.refinement.min_sigma_px = 0.01;  // the tracks do not drift
  return options;
}

ExactWindowOptions noisy(unsigned seed) {
  ExactWindowOptions options = drawnFromTheModel(seed, 0.05);
  options.keyframe_offset_s = 0.0617;  // td is off by up to this much
  return options;
}

double turnBetweenDeg(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return logSO3(a.transpose() * b).norm() / kRadPerDeg;
}

class CalibrationOfSlim : public ::testing::Test {
 protected:
  const std::unique_ptr<WindowSolver> slim_ = baselines::makeMethod("slim", InitializerOptions()),
                                      simulated_ = baselines::makeMethod("slim", simulatedImu());
};

TEST_F(CalibrationOfSlim, AWrongOneIsFoundAcceptedAndNamed) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = makeExactWindow(noisy(seed));
    const InitResult right = slim_->solve(*exact.window);
    ASSERT_TRUE(right.success()) << right.message;
    EXPECT_TRUE(right.warnings.empty()) << "seed " << seed << ": " << right.warnings.front();

    const Eigen::Vector3d turn = 8.0 * kRadPerDeg * Eigen::Vector3d(0.6, 0.0, 0.8);
    const InitResult turned = slim_->solve(*miscalibrated(exact, turn, 0.0, CalibrationSigmas()));
    ASSERT_TRUE(turned.success()) << "seed " << seed << ": " << turned.message;
    ASSERT_TRUE(turned.calibration.has_value());
    EXPECT_LT(turnBetweenDeg(turned.calibration->R_b_c, exact.calibration.R_b_c), 2.5);
    EXPECT_LT(std::abs(scaleError(turned.states, exact.truth)), 0.1);
    EXPECT_TRUE(anyContains(turned.warnings, "correct extrinsicRotation")) << "seed " << seed;
    EXPECT_FALSE(anyContains(turned.warnings, "correct td"));

    const InitResult late =
        slim_->solve(*miscalibrated(exact, Eigen::Vector3d::Zero(), 0.04, CalibrationSigmas()));
    ASSERT_TRUE(late.success()) << "seed " << seed << ": " << late.message;
    EXPECT_NEAR(late.calibration->td, 0.04, 5e-3);
    EXPECT_TRUE(anyContains(late.warnings, "correct td")) << "seed " << seed;
    // The states are those of the exposures, on the clock of the IMU.
    EXPECT_NEAR(late.states.front().t, exact.truth.front().t, 5e-3);
  }
}

TEST_F(CalibrationOfSlim, BeyondTheRangeItIsRefused) {
  InitializerOptions options;
  options.gates.max_td_error_s = 0.01;
  const auto slim = baselines::makeMethod("slim", options);
  const ExactWindow exact = makeExactWindow(noisy(1));
  EXPECT_TRUE(slim->solve(*miscalibrated(exact, Eigen::Vector3d::Zero(), 0.008, {})).success());
  const InitResult late = slim->solve(*miscalibrated(exact, Eigen::Vector3d::Zero(), 0.04, {}));
  EXPECT_EQ(late.status, InitStatus::kInconsistentResiduals);
  EXPECT_EQ(late.message.find("camera-IMU time offset td error about"), 0u) << late.message;
}

TEST_F(CalibrationOfSlim, WhatIsExactIsHeld) {
  const ExactWindow exact = makeExactWindow(noisy(2));
  const InitResult result = slim_->solve(
      *miscalibrated(exact, Eigen::Vector3d::Zero(), 0.0, CalibrationSigmas{0.0, 0.0, 0.0, 0.0}));
  ASSERT_TRUE(result.success()) << result.message;
  ASSERT_TRUE(result.calibration.has_value());
  EXPECT_LT(turnBetweenDeg(result.calibration->R_b_c, exact.calibration.R_b_c), 1e-3);
  EXPECT_NEAR(result.calibration->td, 0.0, 1e-5);
  EXPECT_EQ(result.calibration->covariance.norm(), 0.0);
}

// Over many windows with calibrations drawn from their standard deviations, the errors of
// calibration, scale and way miss the truth by as much as is reported.
TEST_F(CalibrationOfSlim, StandardDeviationsAreThoseOfTheErrors) {
  double scale = 0.0, rotation = 0.0, translation = 0.0, td = 0.0, distance = 0.0;
  constexpr int kWindows = 150;
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    ExactWindowOptions options = drawnWithCalibration(seed, 0.1);
    const ExactWindow exact = makeExactWindow(options);
    const InitResult result = simulated_->solve(*exact.window);
    ASSERT_TRUE(result.success()) << "seed " << seed << ": " << result.message;
    const CalibrationEstimate& found = *result.calibration;
    const Calibration& truth = exact.true_calibration;
    const auto squared = [&](const Eigen::Vector3d& error, int at) {
      return error.dot(found.covariance.block<3, 3>(at, at).llt().solve(error));
    };
    rotation += squared(logSO3(found.R_b_c.transpose() * truth.R_b_c), 0);
    translation += squared(truth.t_b_c - found.t_b_c, 3);
    const double late = found.td - truth.td;
    td += std::pow(late / found.tdSigma(), 2);
    scale += std::pow(scaleError(result.states, exact.truth) / result.scale_sigma, 2);
    // The answer is labelled with its own td: the truth has gone on by then.
    const int n = static_cast<int>(result.states.size());
    const auto way = [&](const NavState& last, const NavState& first, double after) {
      return Eigen::Vector3d(last.p_w_b + after * last.v_w_b - first.p_w_b - after * first.v_w_b);
    };
    const Eigen::Vector3d x = way(result.states.back(), result.states.front(), 0.0);
    const Eigen::Vector3d x_true = way(exact.truth.back(), exact.truth.front(), late);
    const Eigen::Vector3d along = x.normalized();
    const Eigen::Matrix3d covariance =
        result.covariance.block<3, 3>(9 * (n - 1) + 3, 9 * (n - 1) + 3);
    distance += std::pow(x.norm() - x_true.norm(), 2) / along.dot(covariance * along);
  }
  EXPECT_TRUE(isChiSquare(rotation, 3 * kWindows)) << "rotation";
  EXPECT_TRUE(isChiSquare(translation, 3 * kWindows)) << "translation";
  EXPECT_TRUE(isChiSquare(td, kWindows)) << "td";
  EXPECT_TRUE(isChiSquare(scale, kWindows)) << "scale";
  EXPECT_TRUE(isChiSquare(distance, kWindows)) << "distance";
}

// Without rotation neither td nor the extrinsic rotation shows in the turns; a straight way at
// constant speed says nothing about td. The posterior is then the prior, and says so.
TEST_F(CalibrationOfSlim, WhatTheMotionDoesNotShowKeepsItsPrior) {
  ExactWindowOptions options = noisy(3);
  options.motion = Motion::kConstantVelocity;
  const ExactWindow exact = makeExactWindow(options);
  CalibrationSigmas prior;
  prior.td_s = 0.005;
  prior.rotation_deg = 0.5;
  prior.translation_m = 0.01;
  const InitResult result =
      slim_->solve(*miscalibrated(exact, Eigen::Vector3d::Zero(), 0.0, prior));
  ASSERT_TRUE(result.calibration.has_value()) << result.message;
  // The motion is not quite free of rotation: it turns at 0.02 rad/s.
  EXPECT_GT(result.calibration->tdSigma(), 0.9 * prior.td_s);
  EXPECT_GT(result.calibration->rotationSigmaDeg(), 0.9 * prior.rotation_deg);
  EXPECT_GT(std::sqrt(result.calibration->covariance(3, 3)), 0.9 * prior.translation_m);
  // And where it is shown, it is not.
  const InitResult excited =
      slim_->solve(*miscalibrated(makeExactWindow(noisy(3)), Eigen::Vector3d::Zero(), 0.0, prior));
  ASSERT_TRUE(excited.success()) << excited.message;
  EXPECT_LT(excited.calibration->tdSigma(), 0.5 * prior.td_s);
  EXPECT_LT(excited.calibration->rotationSigmaDeg(), 0.9 * prior.rotation_deg);
}

TEST_F(CalibrationOfSlim, AnUnknownRotationIsFound) {
  CalibrationSigmas unknown;
  unknown.rotation_deg = 180.0;
  unknown.translation_m = 0.1;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = makeExactWindow(noisy(seed));
    const Eigen::Vector3d turn = Eigen::Vector3d(0.3 * seed, 2.0, -1.0);
    const InitResult result = slim_->solve(*miscalibrated(exact, turn, 0.0, unknown));
    ASSERT_TRUE(result.calibration.has_value()) << "seed " << seed << ": " << result.message;
    EXPECT_LT(turnBetweenDeg(result.calibration->R_b_c, exact.calibration.R_b_c),
              3.5 * result.calibration->rotationSigmaDeg())
        << "seed " << seed;
    EXPECT_LT(turnBetweenDeg(result.calibration->R_b_c, exact.calibration.R_b_c), 3.0);
    EXPECT_FALSE(anyContains(result.warnings, "correct extrinsicRotation"))
        << "nothing was claimed about it";
  }
}

TEST_F(CalibrationOfSlim, AnUnknownRotationIsRefusedWithTheAxisThatIsMissing) {
  CalibrationSigmas unknown;
  unknown.rotation_deg = 180.0;
  for (const Motion motion : {Motion::kConstantVelocity, Motion::kHover}) {
    ExactWindowOptions options = noisy(4);
    options.motion = motion;
    const ExactWindow exact = makeExactWindow(options);
    const InitResult result =
        slim_->solve(*miscalibrated(exact, Eigen::Vector3d(1.0, 0.0, 0.0), 0.0, unknown));
    EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation);
    expectParts(result.message, "the extrinsic rotation is unknown|rotate about");
    EXPECT_FALSE(result.hasEstimate());
  }
}

// A camera that swings about its own axes, `swing_c` [rad/s] each at its own frequency, of whose
// rotation nothing is known.
std::shared_ptr<const InitWindow> swinging(const Eigen::Vector3d& swing_c, unsigned seed) {
  ExactWindowOptions options = noisy(seed);
  options.keyframes = 11;
  options.angular_rate = [swing_c](double t) -> Eigen::Vector3d {
    const Eigen::Vector3d phase(std::cos(2.0 * t), std::cos(2.6 * t + 1.0),
                                std::cos(3.1 * t + 2.0));
    return eurocCalibration().R_b_c * swing_c.cwiseProduct(phase);
  };
  ExactWindow exact = makeExactWindow(options);
  exact.calibration.sigmas.rotation_deg = CalibrationSigmas::kUnknownRotationDeg;
  exact.calibration.R_b_c.setIdentity();
  return windowOf(exact);
}

// About one axis: refused, and told to turn about another one. About two: found.
TEST_F(CalibrationOfSlim, ASwingAboutOneAxisIsNotEnoughForAnUnknownRotation) {
  const std::string names[] = {"the horizontal axis of the image", "the vertical axis of the image",
                               "the camera's optical axis"};
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d swing = Eigen::Vector3d::Constant(0.003);
    swing[axis] = 0.6;
    const InitResult one = slim_->solve(*swinging(swing, 1 + axis));
    EXPECT_EQ(one.status, InitStatus::kTooLittleExcitation) << names[axis] << ": " << one.message;
    expectParts(one.message, "the extrinsic rotation is unknown");
    const auto named = [&](int other) {
      return contains(one.message, "rotate about " + names[other % 3]);
    };
    EXPECT_FALSE(named(axis)) << one.message;
    EXPECT_TRUE(named(axis + 1) || named(axis + 2)) << one.message;
    EXPECT_FALSE(one.hasEstimate());

    swing[(axis + 1) % 3] = 0.5;
    const InitResult two = slim_->solve(*swinging(swing, 1 + axis));
    EXPECT_FALSE(contains(two.message, "the extrinsic rotation is unknown"))
        << names[axis] << ": " << two.message;
  }
}

// Noise-free, every observation at its own time.
TEST_F(CalibrationOfSlim, ARollingShutterIsExact) {
  ExactWindowOptions options;
  options.readout_s = 0.033;
  options.keyframe_offset_s = 0.0617;
  const ExactWindow exact = makeExactWindow(options);
  const InitResult result = simulated_->solve(*exact.window);
  ASSERT_TRUE(result.success()) << result.message;
  // Second order in the row times: a lever arm that turns, an acceleration over 17 ms.
  EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 2e-3);
  // Ignored, it costs ten times that.
  ExactWindow ignored = exact;
  ignored.calibration.readout_s = 0.0;
  for (FrameObservation& frame : ignored.keyframes) setRows(0, &frame);
  const InitResult wrong = simulated_->solve(*windowOf(ignored));
  const double error = wrong.hasEstimate() ? std::abs(scaleError(wrong.states, exact.truth)) : 1.0;
  EXPECT_GT(error, 1e-2);
}

TEST_F(CalibrationOfSlim, AReadoutTimeThatIsOffIsFound) {
  for (const double off : {-0.005, 0.005}) {
    ExactWindowOptions options = noisy(5);
    options.readout_s = 0.033;
    ExactWindow exact = makeExactWindow(options);
    exact.calibration.readout_s -= off;
    exact.calibration.sigmas.readout_s = 0.005;
    const InitResult result = simulated_->solve(*windowOf(exact));
    ASSERT_TRUE(result.success()) << result.message;
    EXPECT_NEAR(result.calibration->readout_s, options.readout_s,
                std::max(3.5 * result.calibration->readoutSigma(), 1e-4));
    EXPECT_LT(result.calibration->readoutSigma(), 0.003);
  }
}

TEST_F(CalibrationOfSlim, ARollingShutterThatNobodyDeclaredIsFound) {
  for (const double readout_s : {0.0, 0.015, 0.03}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      ExactWindowOptions options = noisy(seed);
      options.readout_s = readout_s;
      ExactWindow exact = makeExactWindow(options);
      exact.calibration.readout_s = 0.0;
      const InitResult result = simulated_->solve(*windowOf(exact));
      ASSERT_TRUE(result.success()) << result.message;
      EXPECT_NEAR(result.calibration->readout_s, readout_s, 3e-3);
      EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 0.05);
      EXPECT_EQ(anyContains(result.warnings, "correct rolling_shutter"), readout_s > 0.0);
    }
  }
}

// It may be longer than those that are looked for where none is given. Its uncertainty stays, too,
// if a host has flown with it.
TEST_F(CalibrationOfSlim, ALongReadoutTimeThatIsRightStays) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    ExactWindowOptions options = noisy(seed);
    options.readout_s = 0.06;
    const ExactWindow exact = makeExactWindow(options);
    for (const GivenCalibration given : {GivenCalibration::kReplaced, GivenCalibration::kKept}) {
      const InitializerOptions slim;
      WorkBudget budget(slim.limits);
      const RotationStage stage = estimateRotations(*exact.window, slim, &budget, given);
      EXPECT_EQ(stage.window->calibration().readout_s, options.readout_s);
      EXPECT_TRUE(given == GivenCalibration::kReplaced ||
                  stage.prior.sigmas.readout_s == exact.calibration.sigmas.readout_s);
    }
  }
}

// An exact readout time is never replaced.
TEST_F(CalibrationOfSlim, AGlobalShutterThatIsDeclaredStaysOne) {
  ExactWindowOptions options = noisy(1);
  options.readout_s = 0.03;
  ExactWindow exact = makeExactWindow(options);
  exact.calibration.readout_s = 0.0;
  exact.calibration.sigmas.readout_s = 0.0;
  const InitResult result = simulated_->solve(*windowOf(exact));
  ASSERT_TRUE(result.calibration.has_value());
  EXPECT_EQ(result.calibration->readout_s, 0.0);
}

// The checks compare with the noise that the tracks have, within its bounds, unless one is given.
TEST_F(CalibrationOfSlim, NoiseOfTheTracksIsMeasured) {
  for (const double noise_px : {0.3, 0.6, 1.5}) {
    ExactWindowOptions options = noisy(3);
    options.pixel_noise = noise_px;
    ExactWindow exact = makeExactWindow(options);
    const InitResult result = simulated_->solve(*exact.window);
    ASSERT_TRUE(result.success()) << result.message;
    EXPECT_NEAR(result.track_noise.measured_px, noise_px, 0.2 * noise_px);
    EXPECT_NEAR(result.track_noise.assumed_px, std::max(noise_px, Calibration::kTypicalSigmaPx),
                0.2 * noise_px);

    exact.calibration.sigma_px = 0.7;
    const InitResult given = simulated_->solve(*windowOf(exact));
    EXPECT_EQ(given.track_noise.assumed_px, 0.7);
    EXPECT_EQ(given.success(), noise_px < 1.0) << given.message;
  }
}

}  // namespace
}  // namespace slim_init
