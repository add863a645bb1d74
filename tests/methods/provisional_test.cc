// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Answers before the scale is known: the integral over the scale, the prior on the motion in
// refinement and profile alike, the covariance over many windows, both sides of every gate, and
// what a host sees of it.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "geometry/so3.h"
#include "pipeline/solver_support.h"
#include "priors/sensor_priors.h"
#include "scale/scale_profile.h"
#include "slim_init/initializer.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/fake_solver.h"
#include "support/fed_initializer.h"
#include "support/true_state.h"
#include "support/unlimited_budget.h"

namespace slim_init {
namespace {

// Data that are a draw from what the estimator assumes, images at 20 Hz.
ExactWindowOptions shortWindowOptions(unsigned seed, int keyframes) {
  ExactWindowOptions options = drawnWithExactCalibration(seed, 0.1);
  options.keyframes = keyframes;
  options.interval_s = 0.05;
  return options;
}

InitializerOptions solverOptions() {
  InitializerOptions options = dataSheetOptions();
  options.provisional.enabled = true;
  return options;
}

InitResult solve(const ExactWindow& exact, const InitializerOptions& options) {
  WorkBudget budget = unlimitedBudget();
  return slimSolver(options)->solve(*exact.window, {nullptr, true}, &budget);
}

const GateValue* gateOf(const InitResult& result, GateName name) {
  for (const GateValue& gate : result.gates) {
    if (gate.name == name) return &gate;
  }
  return nullptr;
}

// A window refined with the prior, and its cost over the scale.
struct Refined {
  ExactWindow exact;
  std::vector<Preintegration> pre;
  RefinedWindow window;
  MotionPrior motion;

  ScaleCost cost() const {
    return ScaleCost(window, pre, exact.calibration, assumedImuBiases({}, dataSheetNoise()),
                     motion);
  }
};

Refined refineShortWindow(unsigned seed, const MotionPrior& motion) {
  Refined out;
  out.motion = motion;
  out.exact = makeExactWindow(shortWindowOptions(seed, 9));
  const WindowState state = trueState(out.exact);
  const InertialOptions inertial = dataSheetNoise();
  out.pre = preintegrateInflated(*out.exact.window, state.gyro_bias, state.accel_bias, inertial);
  RefinementOptions refinement;
  refinement.use_lines = false;
  refinement.tolerance = 1e-8;
  refinement.max_iterations = 200;
  WorkBudget budget = unlimitedBudget();
  out.window = refineWindow(
      {*out.exact.window, out.pre, refinement, inertial, budget, {WindowPriors().rig, motion}}, {},
      state);
  EXPECT_TRUE(out.window.valid);
  out.pre = preintegrateInflated(*out.exact.window, out.window.state.gyro_bias,
                                 out.window.state.accel_bias, inertial);
  return out;
}

// The same prior in both: the minimum of the refinement is that of the profile. A tight one moves
// the scale by far more than the tolerance of this test, so that it cannot be missing in either.
TEST(Provisional, RefinementAndProfileHaveTheSamePrior) {
  MotionPrior tight;
  tight.speed_sigma = 0.05;
  tight.acceleration_sigma = 0.5;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Refined refined = refineShortWindow(seed, tight);
    const ScaleProfile profile = profileScale(refined.cost());
    ASSERT_TRUE(profile.valid);
    EXPECT_NEAR(profile.log_ratio, 0.0, 0.05) << "seed " << seed;
    const ScaleCost without(refined.window, refined.pre, refined.exact.calibration,
                            assumedImuBiases({}, dataSheetNoise()));
    EXPECT_GT(std::abs(profileScale(without).log_ratio), 0.15) << "seed " << seed;
    EXPECT_GT(refined.cost()(0.3), without(0.3));
  }
}

TEST(Provisional, MomentsAreThoseOfTheDensity) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Refined refined = refineShortWindow(seed, MotionPrior());
    const ScaleCost cost = refined.cost();
    const ScaleMoments moments = integrateScale(cost);
    ASSERT_TRUE(moments.valid);
    // By a fine grid over the ratio itself.
    double sum = 0.0, mean = 0.0, square = 0.0;
    const double at_one = cost(0.0);
    for (double ratio = 0.0321; ratio < 31.9; ratio += 2e-3) {
      const double w = std::exp(-0.5 * (cost(std::log(ratio)) - at_one));
      sum += w;
      mean += w * ratio;
      square += w * ratio * ratio;
    }
    mean /= sum;
    const double sigma = std::sqrt(square / sum - mean * mean);
    EXPECT_NEAR(moments.mean, mean, 0.02 * sigma + 2e-3) << "seed " << seed;
    EXPECT_NEAR(std::sqrt(moments.variance), sigma, 0.03 * sigma) << "seed " << seed;
  }
}

TEST(Provisional, WithoutNoiseTheStateIsRight) {
  ExactWindowOptions options = shortWindowOptions(1, 7);
  options.pixel_noise = 0.0;
  options.imu_noise = false;
  options.accel_bias.setZero();
  const ExactWindow exact = makeExactWindow(options);
  InitializerOptions solver = solverOptions();
  solver.gates.mode = GateMode::kOff;  // sigmas are those of the calibration's 0.6 px
  const InitResult answer = solve(exact, solver);
  ASSERT_EQ(answer.status, InitStatus::kProvisional) << answer.message;
  EXPECT_EQ(answer.validate(), "");
  EXPECT_EQ(answer.covariance.rows(), 9 * 7 + 6);
  const double speed = exact.truth.back().v_w_b.norm();
  // What remains is the pull of the priors.
  EXPECT_LT(newestError(answer, exact).velocity, 0.3 * speed);
  EXPECT_LT(gravityErrorRad(answer.gravity_b0, exact.truth.front()), 0.03);
}

// Over windows drawn from the model but for the motion, which is the same one in all of them,
// squared errors are what the covariance says; that of young windows is inflated, so that they are
// rather below.
TEST(Provisional, CovarianceIsThatOfTheErrors) {
  for (const int keyframes : {7, 11}) {
    double velocity = 0.0, tilt = 0.0;
    int count = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
      const ExactWindow exact = makeExactWindow(shortWindowOptions(seed, keyframes));
      const InitResult answer = solve(exact, solverOptions());
      if (!answer.provisional()) continue;
      const NewestError error = newestError(answer, exact);
      EXPECT_LT(error.velocity, 1.0) << "seed " << seed;
      velocity += error.velocity_squared;
      tilt += error.tilt_squared;
      ++count;
    }
    ASSERT_GE(count, 20) << keyframes;
    EXPECT_GT(velocity / count, 0.4) << keyframes;
    EXPECT_LT(velocity / count, 1.3) << keyframes;
    EXPECT_GT(tilt / count, 0.4) << keyframes;
    EXPECT_LT(tilt / count, 1.3) << keyframes;
  }
}

TEST(Provisional, EveryGateRefusesOnItsOwn) {
  const ExactWindow exact = makeExactWindow(shortWindowOptions(2, 11));
  const InitResult answer = solve(exact, solverOptions());
  ASSERT_TRUE(answer.provisional()) << answer.message;
  EXPECT_FALSE(answer.success());
  for (const auto& [name, option] :
       {std::pair(GateName::kVelocitySigma, &ProvisionalOptions::max_velocity_sigma),
        std::pair(GateName::kTiltSigma, &ProvisionalOptions::max_tilt_sigma_deg),
        std::pair(GateName::kScaleSigma, &ProvisionalOptions::max_scale_sigma)}) {
    const GateValue* gate = gateOf(answer, name);
    ASSERT_NE(gate, nullptr) << toString(name);
    EXPECT_TRUE(gate->passed && gate->enforced) << toString(name);
    InitializerOptions options = solverOptions();
    options.provisional.*option = 1.01 * gate->value;
    EXPECT_TRUE(solve(exact, options).provisional()) << toString(name);
    options.provisional.*option = 0.99 * gate->value;
    const InitResult refused = solve(exact, options);
    EXPECT_EQ(refused.status, InitStatus::kScaleTooUncertain) << toString(name);
    EXPECT_NE(refused.message.find("standard deviation"), std::string::npos) << refused.message;
  }
  // Of those that every answer has.
  InitializerOptions options = solverOptions();
  options.gates.max_chi2 = 0.9 * gateOf(answer, GateName::kChi2)->value;
  EXPECT_EQ(solve(exact, options).status, InitStatus::kInconsistentResiduals);
  options = solverOptions();
  const GateValue* parallax = gateOf(answer, GateName::kParallax);
  options.gates.min_parallax_px *= 1.1 * parallax->value / parallax->threshold;
  EXPECT_FALSE(solve(exact, options).provisional());
  EXPECT_EQ(gateOf(answer, GateName::kExcitation), nullptr)
      << "what the motion lacks is in the sigmas";
}

// At constant velocity the scale, and with it the velocity, is what the prior says: never offered.
TEST(Provisional, ConstantVelocityAndPureRotationAreNotOffered) {
  for (const Motion motion : {Motion::kConstantVelocity, Motion::kPureRotation}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      ExactWindowOptions options = shortWindowOptions(seed, 7);
      options.motion = motion;
      const InitResult answer = solve(makeExactWindow(options), solverOptions());
      EXPECT_FALSE(answer.provisional()) << "seed " << seed << ": " << answer.message;
    }
  }
}

TEST(Provisional, SaysWhyThereIsNone) {
  ExactWindowOptions options = shortWindowOptions(1, 7);
  options.points = 3;
  const InitResult answer = solve(makeExactWindow(options), solverOptions());
  EXPECT_EQ(answer.status, InitStatus::kTooFewTracks) << answer.message;
  const InitResult none =
      FakeSolver("other").solve(*makeExactWindow(shortWindowOptions(1, 7)).window, {nullptr, true});
  EXPECT_EQ(none.status, InitStatus::kTooFewKeyframes);
  EXPECT_EQ(none.message, "other has no provisional estimates");
}

TEST(Provisional, AHostThatAsksForItGetsItFirst) {
  const ExactWindow exact = makeExactWindow(shortWindowOptions(2, 11));
  for (const bool enabled : {false, true}) {
    InitializerOptions options = solverOptions();
    options.provisional.enabled = enabled;
    const auto initializer = makeFed(exact, options);
    const InitResult result = initializer->initialize();
    EXPECT_EQ(result.provisional(), enabled) << result.message;
    EXPECT_FALSE(result.success());
    if (!enabled) {
      EXPECT_EQ(result.status, InitStatus::kScaleTooUncertain) << result.message;
      continue;
    }
    EXPECT_TRUE(isWait(result.status)) << "who does not know it waits";
    initializer->reset();
    EXPECT_EQ(initializer->initialize().status, InitStatus::kTooFewKeyframes);
  }
}

TEST(Provisional, AHostThatAsksOnceGetsTheAnswerOfOneThatAsksAtEveryImage) {
  const ExactWindow exact = makeExactWindow(shortWindowOptions(2, 14));
  const auto fed = [&exact](bool asks) {
    const auto initializer = makeInitializer(exact.calibration, solverOptions());
    for (const ImuSample& sample : exact.imu) initializer->addImu(sample);
    for (const FrameObservation& frame : exact.keyframes) {
      initializer->addFrame(frame);
      if (asks) initializer->initialize();
    }
    return initializer->initialize();
  };
  const InitResult often = fed(true), once = fed(false);
  ASSERT_TRUE(once.provisional()) << once.message;
  EXPECT_EQ(once.states.back().v_w_b, often.states.back().v_w_b);
  EXPECT_EQ(once.covariance, often.covariance);
}

TEST(Provisional, EarlierAnswersHaveToAgree) {
  const ExactWindow exact = makeExactWindow(shortWindowOptions(2, 11));
  const InitResult now = solve(exact, solverOptions());
  ASSERT_TRUE(now.provisional()) << now.message;
  // Cut at the seventh keyframe: itself.
  InitResult earlier = now;
  earlier.states.resize(7);
  Eigen::MatrixXd P(69, 69);
  P.setZero();
  P.topLeftCorner(63, 63) = now.covariance.topLeftCorner(63, 63);
  P.bottomRightCorner<6, 6>() = now.covariance.bottomRightCorner<6, 6>();
  earlier.covariance = P;
  EXPECT_TRUE(agrees(earlier, now));
  // Errors of that many standard deviations as they come: along a column of the covariance.
  const Eigen::Vector3d bias = P.block<3, 1>(63, 63) / std::sqrt(P(63, 63));
  for (const auto& [sigmas, agree] : {std::make_pair(2.0, true), std::make_pair(12.0, false)}) {
    InitResult other = earlier;
    other.states.back().gyro_bias = other.gyro_bias += sigmas * bias;
    EXPECT_EQ(agrees(other, now), agree) << sigmas;
  }
  for (const auto& [error, agree] : {std::make_pair(1e-3, true), std::make_pair(5.0, false)}) {
    InitResult other = earlier;
    other.states.back().v_w_b *= 1.0 + error;
    EXPECT_EQ(agrees(other, now), agree) << error;
  }
  InitResult beside = earlier;
  beside.states.back().t = now.states.back().t + 0.02;
  EXPECT_FALSE(agrees(beside, now));
  earlier.covariance.resize(0, 0);
  EXPECT_FALSE(agrees(earlier, now));
  EXPECT_FALSE(agrees(InitResult(), now));
}

TEST(Provisional, RecoverJoinsIt) {
  const ExactWindow exact = makeExactWindow(shortWindowOptions(2, 11));
  const auto initializer = makeFed(exact, solverOptions());
  StatePrior healthy;  // of which nothing but the frame is known
  healthy.state = exact.truth[0];
  healthy.covariance.diagonal().setConstant(100.0);
  const InitResult result = initializer->initialize({{healthy}, {}});
  ASSERT_TRUE(result.provisional()) << result.message;
  EXPECT_LT((result.states.front().p_w_b - exact.truth[0].p_w_b).norm(), 1e-6);
}

TEST(Provisional, AnswerThatContradictsItselfIsSeen) {
  InitResult result;
  result.status = InitStatus::kProvisional;
  EXPECT_EQ(result.validate(), "provisional without states");
  result.states.resize(2);
  for (NavState& state : result.states) state.t = 0.0;
  result.gravity_w = Eigen::Vector3d(0, 0, -9.81);
  EXPECT_EQ(result.validate(), "provisional without a finite covariance");
  result.covariance = Eigen::MatrixXd::Identity(24, 24);
  EXPECT_EQ(result.validate(), "");
  result.covariance = Eigen::MatrixXd::Identity(15, 15);
  EXPECT_NE(result.validate().find("must be 24 x 24"), std::string::npos);
}

}  // namespace
}  // namespace slim_init
