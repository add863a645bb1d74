// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What was known of the sensors before a window: exact without noise, less error and an honest
// covariance with it; not used where it says no more than the priors, or where the data contradict
// it; and from a host to the solver.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "geometry/so3.h"
#include "slim_init/initializer.h"
#include "support/chi_square.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/fed_initializer.h"
#include "support/gaussian.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

constexpr double kDeg = M_PI / 180.0;
constexpr double kGyroSigma = 1e-3, kAccelSigma = 0.03;

InitResult solveKnowing(const ExactWindow& exact, const ImuBiases& known,
                        const InitializerOptions& options = dataSheetOptions()) {
  Calibration calibration = exact.calibration;
  calibration.imu_biases = known;
  const auto window = madeWindow(calibration, exact.keyframes, exact.imu);
  return slimSolver(options)->solve(*window);
}

ImuBiases knownBiases(const Vector3d& gyro, const Vector3d& accel, double gyro_sigma = kGyroSigma,
                      double accel_sigma = kAccelSigma) {
  ImuBiases known;
  known.gyro = gyro;
  known.accel = accel;
  known.gyro_sigma = gyro_sigma;
  known.accel_sigma = accel_sigma;
  return known;
}

// Biases far beyond the priors about zero.
ExactWindowOptions largeBiases() {
  ExactWindowOptions options;
  options.calibration_sigmas = kExactCalibration;
  options.gyro_bias = Vector3d(0.3, -0.2, 0.25);
  options.accel_bias = Vector3d(0.6, -0.5, 0.4);
  return options;
}

TEST(KnownBiases, AreExactWithoutNoise) {
  const ExactWindowOptions options = largeBiases();
  const ExactWindow exact = makeExactWindow(options);
  const InitResult known = solveKnowing(exact, knownBiases(options.gyro_bias, options.accel_bias));
  ASSERT_TRUE(known.success()) << known.message;
  EXPECT_TRUE(known.warnings.empty());
  EXPECT_LT(std::abs(scaleError(known.states, exact.truth)), 1e-6);
  EXPECT_LT((known.gyro_bias - options.gyro_bias).norm(), 1e-7);
  EXPECT_LT((known.accel_bias - options.accel_bias).norm(), 1e-6);
  for (const NavState& state : known.states) {
    EXPECT_LT((state.accel_bias - options.accel_bias).norm(), 1e-6);
    EXPECT_LT((state.gyro_bias - options.gyro_bias).norm(), 1e-7);
  }
  // About zero such an accelerometer bias costs scale, though the tail of its prior gives way.
  const InitResult unknown = slimSolver(dataSheetOptions())->solve(*exact.window);
  EXPECT_GT(std::abs(scaleError(unknown.states, exact.truth)),
            std::max(1e-4, 20.0 * std::abs(scaleError(known.states, exact.truth))));
}

TEST(KnownBiases, LessErrorAndAsMuchAsReported) {
  InitializerOptions options = dataSheetOptions();
  options.refinement.min_sigma_px = 0.01;
  constexpr int kWindows = 100;
  double of_scale = 0.0, of_bias = 0.0, known_squares = 0.0, unknown_squares = 0.0;
  Gaussian draw(5);
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    ExactWindowOptions drawn = drawnWithExactCalibration(seed, options.inertial.accel_bias_prior);
    drawn.interval_s = 0.15;
    const ExactWindow exact = makeExactWindow(drawn);
    const NavState& truth = exact.truth.front();
    const Vector3d gyro = truth.gyro_bias + kGyroSigma * draw.vector(),
                   accel = truth.accel_bias + kAccelSigma * draw.vector();
    const InitResult known = solveKnowing(exact, knownBiases(gyro, accel), options);
    ASSERT_TRUE(known.hasEstimate()) << "seed " << seed << ": " << known.message;
    const double error = scaleError(known.states, exact.truth);
    of_scale += std::pow(error / known.scale_sigma, 2);
    const Vector3d bias_error = known.accel_bias - truth.accel_bias;
    of_bias += bias_error.dot(known.covariance.bottomRightCorner<3, 3>().llt().solve(bias_error));
    known_squares += error * error;
    const InitResult unknown = slimSolver(options)->solve(*exact.window);
    unknown_squares += std::pow(scaleError(unknown.states, exact.truth), 2);
  }
  EXPECT_TRUE(isChiSquare(of_scale, kWindows)) << of_scale;
  EXPECT_TRUE(isChiSquare(of_bias, 3 * kWindows)) << of_bias;
  EXPECT_LT(known_squares, 0.8 * unknown_squares);
}

TEST(KnownBiases, WithoutEffectWhereThePriorsSayAsMuch) {
  const ExactWindow exact = makeExactWindow(drawnWithExactCalibration(3, 0.1));
  const InitResult without = slimSolver(dataSheetOptions())->solve(*exact.window);
  const InertialOptions priors;
  const InitResult same =
      solveKnowing(exact, knownBiases(Vector3d(0.1, 0, 0), Vector3d(0, 0.1, 0),
                                      priors.gyro_bias_prior, priors.accel_bias_prior));
  EXPECT_TRUE(sameBytes(same, without));
  const InitResult less =
      solveKnowing(exact, knownBiases(exact.truth[0].gyro_bias, exact.truth[0].accel_bias,
                                      priors.gyro_bias_prior, 0.9 * priors.accel_bias_prior));
  EXPECT_NE(less.scale, without.scale);
  EXPECT_LT(less.scale_sigma, without.scale_sigma);
}

TEST(KnownBiases, ThatTheDataContradictAreNotUsed) {
  const ExactWindow exact = makeExactWindow(drawnWithExactCalibration(4, 0.1));
  const NavState& truth = exact.truth.front();
  const InitResult without = slimSolver(dataSheetOptions())->solve(*exact.window);
  ASSERT_TRUE(without.success()) << without.message;
  const auto contradicted = [&](const Vector3d& gyro_error, const Vector3d& accel_error) {
    InitResult result = solveKnowing(
        exact, knownBiases(truth.gyro_bias + gyro_error, truth.accel_bias + accel_error));
    const bool warned = !result.warnings.empty();
    if (warned) {
      EXPECT_NE(result.warnings.back().find("contradict the data"), std::string::npos);
      result.warnings.pop_back();
      EXPECT_TRUE(sameBytes(result, without));
    }
    return warned;
  };
  EXPECT_FALSE(contradicted(Vector3d::Zero(), Vector3d::Zero()));
  EXPECT_FALSE(contradicted(Vector3d(kGyroSigma, 0, 0), Vector3d(0, kAccelSigma, 0)));
  EXPECT_TRUE(contradicted(Vector3d(0, 10 * kGyroSigma, 0), Vector3d::Zero()));
  EXPECT_TRUE(contradicted(Vector3d::Zero(), Vector3d(10 * kAccelSigma, 0, 10 * kAccelSigma)));
}

// Wrong by less than the data can tell, it must not make an answer that is far off.
TEST(KnownBiases, ThatAreWrongMakeNoWrongScale) {
  int warned = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ExactWindow exact = makeExactWindow(drawnWithExactCalibration(seed, 0.1));
    const NavState& truth = exact.truth.front();
    const double sign = seed % 2 == 0 ? 1.0 : -1.0;
    const InitResult result =
        solveKnowing(exact, knownBiases(truth.gyro_bias + Vector3d(0, 0.02 * sign, 0),
                                        truth.accel_bias + Vector3d(0.2, 0.2, -0.2) * sign));
    warned += result.warnings.empty() ? 0 : 1;
    if (result.success()) {
      EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), 0.25) << "seed " << seed;
    }
  }
  EXPECT_GE(warned, 19);
}

TEST(KnownSensors, SayWhatIsOutOfBounds) {
  KnownSensors known;
  EXPECT_EQ(known.validate(), "");
  known.biases.accel_sigma = 0.0;
  EXPECT_NE(known.validate().find("accel_sigma is 0, must be in"), std::string::npos)
      << known.validate();
  known = KnownSensors();
  known.biases.gyro.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(known.validate().find("gyro"), std::string::npos);
  known = KnownSensors();
  known.calibration.emplace().R_b_c *= 1.1;
  EXPECT_NE(known.validate().find("no rotation"), std::string::npos);
  known.calibration = OptionalCalibration();
  EXPECT_EQ(known.validate(), "");
}

class KnownSensorsOfAHost : public ::testing::Test {
 protected:
  // The rig that is handed in is off by 3 deg and 20 ms.
  KnownSensorsOfAHost() {
    ExactWindowOptions options = drawnFromTheModel(8, 0.1);
    options.interval_s = 0.2;
    options.keyframes = 12;  // the first of them before the samples, at the wrong td
    exact_ = makeExactWindow(options);
    handed_in_ = exact_.calibration;
    handed_in_.R_b_c = exact_.true_calibration.R_b_c * expSO3(Vector3d(3.0 * kDeg, 0, 0));
    handed_in_.td = exact_.true_calibration.td - 0.02;
    initializer_ = make(handed_in_);
  }
  std::unique_ptr<IInitializer> make(const Calibration& calibration) const {
    InitializerOptions options = dataSheetOptions();
    options.window.keyframes = options.window.min_keyframes = 10;
    options.window.max_span_s = 0.0;
    std::string error;
    auto initializer = makeInitializer(calibration, options, &error);
    EXPECT_NE(initializer, nullptr) << error;
    return initializer;
  }
  InitResult ask(IInitializer& initializer, const KnownSensors& known = {}) const {
    initializer.reset();
    feed(initializer, exact_);
    return initializer.initialize({{}, known});
  }
  // What a flight before would have found.
  KnownSensors known() const {
    KnownSensors known;
    CalibrationEstimate& found = known.calibration.emplace();
    found.R_b_c = exact_.true_calibration.R_b_c;
    found.t_b_c = exact_.true_calibration.t_b_c;
    found.td = exact_.true_calibration.td;
    found.covariance.diagonal().head<3>().setConstant(std::pow(0.1 * kDeg, 2));
    found.covariance.diagonal().segment<3>(3).setConstant(1e-6);
    found.covariance(6, 6) = 1e-6;
    known.biases = knownBiases(exact_.truth[0].gyro_bias, exact_.truth[0].accel_bias);
    return known;
  }
  ExactWindow exact_;
  Calibration handed_in_;
  std::unique_ptr<IInitializer> initializer_;
};

TEST_F(KnownSensorsOfAHost, AreUsedForTheAnswer) {
  const InitResult before = ask(*initializer_);
  ASSERT_TRUE(before.success()) << before.message;
  EXPECT_FALSE(before.warnings.empty()) << "the rig is off by 3 deg";
  const InitResult after = ask(*initializer_, known());
  ASSERT_TRUE(after.success()) << after.message;
  EXPECT_TRUE(after.warnings.empty()) << after.warnings.front();
  EXPECT_LT(after.scale_sigma, before.scale_sigma);
  EXPECT_LT(after.calibration->rotationSigmaDeg(), before.calibration->rotationSigmaDeg());
  EXPECT_NEAR(after.calibration->td, exact_.true_calibration.td, 1e-3);
  // What the host has said of its calibration stays: it pairs its frames with that.
  EXPECT_EQ(initializer_->info().calibration.td, handed_in_.td);
  EXPECT_EQ(initializer_->info().calibration.R_b_c, handed_in_.R_b_c);
  EXPECT_TRUE(sameBytes(ask(*initializer_), before));
}

TEST_F(KnownSensorsOfAHost, AreIgnoredWhereTheyAreInvalid) {
  const InitResult before = ask(*initializer_);
  KnownSensors wrong = known();
  wrong.biases.accel_sigma = -1.0;
  EXPECT_TRUE(sameBytes(ask(*initializer_, wrong), before));
}

// Nothing known of the rotation needs much motion about two axes; a rotation from before does not.
TEST_F(KnownSensorsOfAHost, SpareTheSearchForAnUnknownRotation) {
  Calibration unknown = handed_in_;
  unknown.R_b_c = expSO3(Vector3d(0.5, 1.0, -0.7));
  unknown.sigmas.rotation_deg = 180.0;
  const auto initializer = make(unknown);
  const InitResult answer = ask(*initializer, known());
  ASSERT_TRUE(answer.success()) << answer.message;
  EXPECT_LT(logSO3(answer.calibration->R_b_c.transpose() * exact_.true_calibration.R_b_c).norm(),
            0.3 * kDeg);
}

}  // namespace
}  // namespace slim_init
