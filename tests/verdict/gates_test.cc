// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Both sides of every gate, and of the decision.
#include "verdict/gates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "estimation/posterior.h"
#include "geometry/so3.h"
#include "scale/scale_profile.h"
#include "support/exact_window.h"
#include "support/text_parts.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

const GateOptions kOptions;
const ProvisionalOptions kNewest;

const GateValue& find(const std::vector<GateValue>& gates, GateName name) {
  for (const GateValue& gate : gates) {
    if (gate.name == name) return gate;
  }
  ADD_FAILURE() << "no gate " << toString(name);
  return gates.front();
}

MotionMeasures goodMotion() {
  MotionMeasures motion;
  motion.parallax_px = 50.0;
  motion.track_length = 9.0;
  motion.rotation_deg = 20.0;
  motion.excitation = 1.0;
  return motion;
}

TEST(MotionGates, ParallaxAndExcitationOnBothSides) {
  for (const double share : {0.999, 1.001}) {
    MotionMeasures motion = goodMotion();
    motion.parallax_px = share * kOptions.min_parallax_px;
    EXPECT_EQ(find(motionGates(motion, kOptions), GateName::kParallax).passed, share > 1.0);
    motion = goodMotion();
    motion.excitation = share * kOptions.min_excitation;
    const GateValue gate = find(motionGates(motion, kOptions), GateName::kExcitation);
    EXPECT_EQ(gate.passed, share > 1.0);
    EXPECT_EQ(gate.status_if_failed, InitStatus::kTooLittleExcitation);
  }
}

TEST(MotionGates, ShorterTracksNeedMoreParallax) {
  MotionMeasures motion = goodMotion();
  for (const double length : {1.0, 4.0, 9.0, 16.0}) {
    motion.track_length = length;
    for (const double share : {0.999, 1.001}) {
      motion.parallax_px =
          share * kOptions.min_parallax_px * std::max(1.0, 3.0 / std::sqrt(length));
      EXPECT_EQ(parallaxGate(motion, kOptions).passed, share > 1.0) << length << " keyframes";
    }
  }
}

TEST(MotionGates, AMotionThatABiasExplainsIsNoParallax) {
  MotionMeasures motion;
  motion.parallax_px = 10.0 * kOptions.min_parallax_px;
  for (const double share : {0.99, 1.01}) {
    motion.least_motion_px = share * kOptions.min_parallax_px;
    EXPECT_EQ(parallaxGate(motion, kOptions).passed, share > 1.0);
  }
}

TEST(MotionGates, TracksAndImuTogetherNameAMissingParallax) {
  MotionMeasures motion = goodMotion();
  motion.parallax_px = 0.5;
  motion.excitation = kMaxRestDeviation * 0.999;
  const auto status = [&motion] {
    return find(motionGates(motion, kOptions), GateName::kParallax).status_if_failed;
  };
  motion.rotation_deg = kMinRotationDeg * 1.001;
  EXPECT_EQ(status(), InitStatus::kPureRotation);
  motion.rotation_deg = kMinRotationDeg * 0.999;
  EXPECT_EQ(status(), InitStatus::kStationary);
  // The vehicle accelerates, the scene is too far to show it.
  motion.excitation = kMaxRestDeviation * 1.001;
  EXPECT_EQ(status(), InitStatus::kTooLittleExcitation);
}

TEST(CalibrationGates, EachHasTwoSidesAndNamesTheEstimate) {
  Calibration handed_in;
  constexpr double kSigmaDeg = 1.0, kSigmaS = 0.002;
  constexpr double kRadPerDeg = M_PI / 180.0;
  const double doubt_deg = kCertainSigmas * kSigmaDeg;
  const double doubt_s = kCertainSigmas * kSigmaS;
  CalibrationEstimate found;
  found.covariance.diagonal().head<3>().setConstant(std::pow(kSigmaDeg * kRadPerDeg, 2));
  found.covariance(6, 6) = kSigmaS * kSigmaS;
  const auto at = [&](double share) {
    const double angle = share * kOptions.max_extrinsic_error_deg + doubt_deg;
    found.R_b_c = expSO3(Eigen::Vector3d(0.0, angle * kRadPerDeg, 0.0));
    found.td = handed_in.td - share * kOptions.max_td_error_s - doubt_s;
    return calibrationGates(handed_in, found, kOptions);
  };
  for (const GateValue& gate : at(0.999)) EXPECT_TRUE(gate.passed) << toString(gate.name);
  for (const GateValue& gate : at(1.001)) {
    EXPECT_FALSE(gate.passed) << toString(gate.name);
    EXPECT_EQ(gate.status_if_failed, InitStatus::kInconsistentResiduals);
  }
  EXPECT_EQ(describe(find(at(1.1), GateName::kExtrinsicRotation)),
            "extrinsic rotation error about 19 deg (sigma 1 deg), less 2.5 sigma: 16.5 deg "
            "(limit 15)");
  found.covariance(6, 6) = kNotComputed;
  EXPECT_FALSE(find(at(0.5), GateName::kTimeOffset).passed);
  handed_in.sigmas.rotation_deg = CalibrationSigmas::kUnknownRotationDeg;
  // No bound on a rotation that was unknown, but on how well it is known now.
  EXPECT_EQ(at(1.1).front().name, GateName::kExtrinsicSigma);
  for (const double share : {0.99, 1.01}) {
    found.covariance.diagonal().head<3>().setConstant(
        std::pow(share * kOptions.max_extrinsic_sigma_deg * kRadPerDeg, 2));
    EXPECT_EQ(at(0.5).front().passed, share < 1.0);
  }
  EXPECT_EQ(at(0.5).front().status_if_failed, InitStatus::kTooLittleExcitation);
}

InitResult withGates(double parallax_px, bool other_passes) {
  InitResult result;
  result.states.resize(4);
  MotionMeasures motion = goodMotion();
  motion.parallax_px = parallax_px;
  motion.rotation_deg = 0.0;
  motion.excitation = kMaxRestDeviation;
  result.gates = motionGates(motion, kOptions);
  GateValue other;
  other.name = GateName::kChi2;
  other.passed = other_passes;
  other.status_if_failed = InitStatus::kInconsistentResiduals;
  result.gates.push_back(other);
  return result;
}

InitResult enforced(InitResult result, GateMode mode) {
  enforceGates(mode, &result);
  decide(false, &result);
  return result;
}

// Whether the other gates pass or not, and whether there is an answer.
TEST(EnforceGates, TheParallaxDecidesWhereItIsTooSmall) {
  InitResult result = enforced(withGates(kOptions.min_parallax_px * 1.001, true), GateMode::kOwn);
  EXPECT_TRUE(find(result.gates, GateName::kParallax).enforced);
  EXPECT_TRUE(find(result.gates, GateName::kChi2).enforced);
  EXPECT_EQ(result.status, InitStatus::kSuccess);
  result = enforced(withGates(kOptions.min_parallax_px * 1.001, false), GateMode::kOwn);
  EXPECT_EQ(result.status, InitStatus::kInconsistentResiduals);

  const double less = kOptions.min_parallax_px * 0.999;
  for (const bool other_passes : {true, false}) {
    result = enforced(withGates(less, other_passes), GateMode::kOn);
    EXPECT_TRUE(find(result.gates, GateName::kParallax).enforced);
    EXPECT_EQ(result.status, InitStatus::kStationary);
  }
  std::ostringstream bound;
  bound << "(minimum " << kOptions.min_parallax_px << ")";
  expectParts(result.message, bound.str());
  result = withGates(less, true);
  result.states.clear();
  enforceGates(GateMode::kOn, &result);
  EXPECT_TRUE(find(result.gates, GateName::kParallax).enforced);
}

// An exception has a reason, which the gate gives; every gate without one is enforced.
TEST(EnforceGates, MeasuredVelocitiesExceptTheExcitation) {
  for (const bool has_speeds : {false, true}) {
    InitResult result = withGates(50.0, true);
    MotionMeasures motion = goodMotion();
    motion.excitation = 0.5 * kOptions.min_excitation;
    motion.has_speeds = has_speeds;
    result.gates = motionGates(motion, kOptions);
    result = enforced(result, GateMode::kOwn);
    const GateValue& gate = find(result.gates, GateName::kExcitation);
    EXPECT_FALSE(gate.passed);
    EXPECT_EQ(gate.enforced, !has_speeds);
    EXPECT_EQ(gate.exception.empty(), !has_speeds);
    EXPECT_EQ(result.success(), has_speeds) << result.message;
  }
}

TEST(EnforceGates, SwitchedOffNoGateIsEnforced) {
  const InitResult result = enforced(withGates(0.1, false), GateMode::kOff);
  for (const GateValue& gate : result.gates) EXPECT_FALSE(gate.enforced) << toString(gate.name);
  EXPECT_EQ(result.status, InitStatus::kSuccess);
}

// Every measure by this share beyond its bound; negative: within.
PosteriorMeasures beyondBounds(double share) {
  PosteriorMeasures out;
  out.chi2 = kOptions.max_chi2 * (1.0 + share);
  out.inertial_chi2 = kOptions.max_inertial_chi2 * (1.0 + share);
  out.inlier_fraction = kOptions.min_inlier_fraction * (1.0 - share);
  out.mean_acceleration = kMaxMeanAcceleration * (1.0 + share);
  out.point_spread_deg = kMinPointSpreadDeg * (1.0 - share);
  out.scale_sigma = kOptions.max_scale_sigma * (1.0 + share);
  out.other_scale_rise = kMinOtherScaleRise * (1.0 - share);
  out.newest.tilt_deg = kNewest.max_tilt_sigma_deg * (1.0 + share);
  return out;
}

TEST(PosteriorGates, EachHasTwoSides) {
  MotionMeasures motion = goodMotion();
  for (const double share : {-1e-3, 1e-3}) {
    for (const GateValue& gate : posteriorGates(beyondBounds(share), motion, kOptions, kNewest)) {
      EXPECT_EQ(gate.passed, share < 0.0) << toString(gate.name);
    }
  }
  for (const GateValue& gate : posteriorGates(PosteriorMeasures(), motion, kOptions, kNewest)) {
    EXPECT_FALSE(gate.passed) << toString(gate.name) << " of a value that is not known";
  }
  // A motion as violent as that is measured to be.
  motion.excitation = 1.5 * kMaxMeanAcceleration;
  const auto gates = posteriorGates(beyondBounds(0.4), motion, kOptions, kNewest);
  EXPECT_TRUE(find(gates, GateName::kMeanAcceleration).passed);
}

TEST(BiasWarning, BeyondWhatThePriorAllows) {
  InertialOptions inertial;
  for (const double share : {0.99, 1.01}) {
    InitResult result;
    result.covariance = Eigen::MatrixXd::Zero(15, 15);
    result.accel_bias = {share * kCertainSigmas * inertial.accel_bias_prior, 0.0, 0.0};
    appendBiasWarning(inertial, &result);
    EXPECT_EQ(result.warnings.size(), share < 1.0 ? 0u : 1u);
  }
}

TEST(PosteriorGates, AnotherScaleIsNamedWithThatOfTheAnswer) {
  PosteriorMeasures measures;
  measures.scale = 0.41;
  measures.other_scale = 1.37;
  measures.other_scale_rise = 2.5;
  const GateValue gate =
      find(posteriorGates(measures, goodMotion(), kOptions, kNewest), GateName::kOtherScale);
  EXPECT_FALSE(gate.passed);
  EXPECT_EQ(gate.status_if_failed, InitStatus::kScaleTooUncertain);
  EXPECT_EQ(describe(gate),
            "another scale (mean baseline 1.37 m instead of 0.41 m) fits nearly as well: cost "
            "difference 2.5 sigma^2 (minimum 16)");
  // No other minimum at all.
  measures.other_scale = kNotComputed;
  measures.other_scale_rise = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(find(posteriorGates(measures, goodMotion(), kOptions, kNewest), GateName::kOtherScale)
                  .passed);
  // Nobody has looked.
  measures.profiled = false;
  for (const GateValue& other : posteriorGates(measures, goodMotion(), kOptions, kNewest)) {
    EXPECT_NE(other.name, GateName::kOtherScale);
  }
}

TEST(PosteriorGates, TheWiderOfPosteriorAndProfileIsTheSigma) {
  Posterior posterior;
  posterior.scale_sigma = 0.05;
  ScaleProfile profile;
  profile.valid = true;
  profile.sigma = 0.04;
  EXPECT_EQ(scaleSigma(posterior, &profile), 0.05);
  profile.sigma = 0.15;
  EXPECT_NEAR(scaleSigma(posterior, &profile), 0.15, 1e-12);
  profile.valid = false;
  EXPECT_EQ(scaleSigma(posterior, &profile), 0.05);
  EXPECT_EQ(scaleSigma(posterior, nullptr), 0.05);
}

// Each kind of window has one key, whatever the others are.
TEST(PosteriorGates, EveryKindOfWindowHasItsBoundOnTheScale) {
  GateOptions options;
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const double span = exact.window->times().back() - exact.window->times().front();
  const auto bound = [&](double full_span_s) {
    WindowOptions window;
    window.max_span_s = full_span_s;
    return gatesInForce(options, *exact.window, window).max_scale_sigma;
  };
  EXPECT_EQ(bound(1.001 * span / 0.9), 0.05) << "expanding";
  EXPECT_EQ(bound(0.999 * span / 0.9), 0.075) << "full";
  WindowOptions fixed_size;
  fixed_size.keyframes = fixed_size.min_keyframes = 10;
  fixed_size.max_span_s = 0.999 * span / 0.9;
  EXPECT_EQ(gatesInForce(options, *exact.window, fixed_size).max_scale_sigma, 0.10);
  for (const double sigma : {0.01, 0.3}) {
    options = GateOptions();
    options.max_scale_sigma = sigma;
    EXPECT_EQ(bound(1.001 * span / 0.9), 0.05);
    EXPECT_EQ(bound(0.999 * span / 0.9), sigma);
    EXPECT_EQ(gatesInForce(options, *exact.window, fixed_size).max_scale_sigma, 0.10);
    options = GateOptions();
    options.max_scale_sigma_expanding = sigma;
    EXPECT_EQ(bound(1.001 * span / 0.9), sigma);
    EXPECT_EQ(bound(0.999 * span / 0.9), 0.075);
    options = GateOptions();
    options.max_scale_sigma_fixed_size = sigma;
    EXPECT_EQ(bound(0.999 * span / 0.9), 0.075);
    EXPECT_EQ(gatesInForce(options, *exact.window, fixed_size).max_scale_sigma, sigma);
  }
}

TEST(PosteriorGates, WithoutExcitationTheUncertainScaleIsNamedSo) {
  MotionMeasures motion = goodMotion();
  PosteriorMeasures measures;
  measures.scale_sigma = 1.0;
  const auto status = [&] {
    return find(posteriorGates(measures, motion, kOptions, kNewest), GateName::kScaleSigma)
        .status_if_failed;
  };
  EXPECT_EQ(status(), InitStatus::kScaleTooUncertain);
  motion.excitation = kOptions.min_excitation * 0.999;
  EXPECT_EQ(status(), InitStatus::kTooLittleExcitation);
}

TEST(Decide, FirstFailureDecidesOnlyWhenEnforced) {
  InitResult result;
  MotionMeasures motion = goodMotion();
  motion.excitation = 0.0123;
  result.gates = motionGates(motion, kOptions);
  decide(true, &result);
  EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation);
  expectParts(result.message, "0.0123|(minimum 0.1)");
  result.gates = motionGates(motion, kOptions);
  decide(false, &result);
  EXPECT_EQ(result.status, InitStatus::kSuccess);
  expectParts(result.message, "not enforced");
  for (const GateValue& gate : result.gates) EXPECT_FALSE(gate.enforced);
}

TEST(MotionGates, WithoutTracksNothingIsClaimedAboutTheMotion) {
  MotionMeasures motion = goodMotion();
  motion.parallax_px = kNotComputed;
  for (double rotation : {0.0, 90.0}) {
    motion.rotation_deg = rotation;
    const GateValue gate = find(motionGates(motion, kOptions), GateName::kParallax);
    EXPECT_FALSE(gate.passed);
    EXPECT_EQ(gate.status_if_failed, InitStatus::kTooFewTracks);
    expectParts(describe(gate), "not measured (minimum ");
  }
}

TEST(Measures, ForceDeviationIsZeroAtConstantVelocityAndRmsOtherwise) {
  // A body at constant velocity that turns feels gravity from changing sides; in b0 it is constant.
  std::vector<Preintegration> pre(4);
  std::vector<Eigen::Matrix3d> R;
  for (int i = 0; i < 5; ++i) R.push_back(expSO3(Eigen::Vector3d(0.3, -0.1, 0.2) * i));
  for (const double acceleration : {0.0, 0.4}) {
    for (int i = 0; i < 4; ++i) {
      pre[i].dt = 0.25;
      const double along_x = i % 2 == 0 ? acceleration : -acceleration;
      pre[i].dv = R[i].transpose() * Eigen::Vector3d(along_x, 0, 9.8) * 0.25;
    }
    MotionMeasures motion;
    measureForce(pre, R, &motion);
    EXPECT_NEAR(motion.excitation, acceleration, 1e-14);
    EXPECT_LT((motion.mean_force - Eigen::Vector3d(0, 0, 9.8)).norm(), 1e-13);
  }
}

TEST(Measures, MaxRotation) {
  EXPECT_NEAR(
      maxRotationDeg({Eigen::Matrix3d::Identity(), expSO3({0, 0, 0.5}), expSO3({0, 0.1, 0})}),
      0.5 * 180 / M_PI, 1e-10);
}

MotionMeasures measured(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck) {
  MotionMeasures motion;
  measureTracks(window, R_c0_ck, &motion);
  return motion;
}

TEST(Measures, ParallaxIgnoresRotationAndSeesTranslation) {
  for (Motion motion : {Motion::kPureRotation, Motion::kExcited}) {
    ExactWindowOptions options;
    options.motion = motion;
    const ExactWindow exact = makeExactWindow(options);
    std::vector<Eigen::Matrix3d> R = trueCameraRotations(exact);
    const double parallax = measured(*exact.window, R).parallax_px;
    // A bias of the gyroscope turns all keyframes at one rate.
    for (std::size_t k = 0; k < R.size(); ++k) {
      R[k] = expSO3(exact.window->times()[k] * Eigen::Vector3d(0.02, -0.03, 0.01)) * R[k];
    }
    EXPECT_GT(measured(*exact.window, R).parallax_px, kOptions.min_parallax_px);
    const double least = leastMotionPx(*exact.window, 0.2, R);
    EXPECT_EQ(least > kOptions.min_parallax_px, motion == Motion::kExcited) << least;
    // The camera sits 7 cm from the body's centre, so that turning moves it a little.
    if (motion == Motion::kPureRotation) {
      EXPECT_LT(parallax, kOptions.min_parallax_px);
    } else {
      EXPECT_GT(parallax, 20.0);
    }
  }
}

TEST(Measures, ParallaxSeesMotionThatReturnsToItsStart) {
  // Out and back: first and last observation agree, the ones between do not.
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  std::vector<FrameObservation> frames = exact.keyframes;
  for (int k = 0; k < 5; ++k) {
    frames[9 - k].points = exact.keyframes[k].points;
  }
  const auto window = windowOf(exact, frames);
  std::vector<Eigen::Matrix3d> R = trueCameraRotations(exact);
  std::copy_n(R.begin(), 5, R.rbegin());
  EXPECT_GT(measured(*window, R).parallax_px, 10.0);
  EXPECT_EQ(measured(*window, R).track_length, 10.0);
}

TEST(Measures, ParallaxWithoutTracksIsUnknown) {
  ExactWindowOptions options;
  options.points = 0;
  const ExactWindow exact = makeExactWindow(options);
  const std::vector<Eigen::Matrix3d> R(10, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(std::isnan(measured(*exact.window, R).parallax_px));
  const GateValue gate = parallaxGate(measured(*exact.window, R), kOptions);
  EXPECT_EQ(gate.status_if_failed, InitStatus::kTooFewTracks);
  EXPECT_FALSE(gate.passed);
  EXPECT_EQ(describe(gate).find("nan"), std::string::npos) << describe(gate);
}

}  // namespace
}  // namespace slim_init
