// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "loosely_coupled.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slim_init/text.h"
#include "verdict/gates.h"

namespace slim_init::baselines {
namespace {

// Metres per unit of the trajectory below which a scale is no motion at all [m].
constexpr double kMinScale = 1e-6;

}  // namespace

bool acceptGyroBias(const GyroBiasEstimate& bias, InitResult* result) {
  if (bias.point_pairs == 0) {
    fail(InitStatus::kTooFewTracks,
         text("0 keyframe pairs with ", kMinPointsOfPair, " or more common points (minimum 1)"),
         result);
    return false;
  }
  if (!bias.valid) {
    fail(InitStatus::kNumericalFailure,
         text("gyroscope bias ", bias.gyro_bias.norm(), " rad/s (limit ", kMaxGyroBias, ")"),
         result);
    return false;
  }
  result->gyro_bias = bias.gyro_bias;
  return true;
}

double cameraSpread(const InitWindow& window, const WindowState& state) {
  Eigen::Matrix3Xd centres_b0(3, state.size());
  for (int k = 0; k < state.size(); ++k) {
    centres_b0.col(k) = cameraCentre(state, k, window.calibration().t_b_c);
  }
  return (centres_b0.colwise() - centres_b0.rowwise().mean()).norm();
}

WindowState windowStateOf(const std::vector<NavState>& states, double gravity_magnitude) {
  const NavState& first = states.front();
  const Eigen::Matrix3d R_b0_w = first.R_w_b.transpose();
  const int n = static_cast<int>(states.size());
  WindowState state;
  state.p_b0.resize(3, n);
  state.v_b0.resize(3, n);
  for (int k = 0; k < n; ++k) {
    state.R_b0_bk.push_back(R_b0_w * states[k].R_w_b);
    state.p_b0.col(k) = R_b0_w * (states[k].p_w_b - first.p_w_b);
    state.v_b0.col(k) = R_b0_w * states[k].v_w_b;
  }
  state.gyro_bias = states.back().gyro_bias;
  state.accel_bias = states.back().accel_bias;
  state.gravity_b0 = -gravity_magnitude * R_b0_w.col(2);
  return state;
}

std::vector<GateValue> alignmentGates(const AlignmentMeasures& measures, double max_scale_sigma) {
  std::vector<GateValue> gates = {
      makeGate(GateName::kLinkage, "eigenvalue ratio of the translation system", "",
               atLeast(measures.linkage, kMinLinkage), InitStatus::kDegenerateAlignment),
      makeGate(GateName::kScalePositive, "scale", "m", atLeast(measures.scale, kMinScale),
               InitStatus::kDegenerateAlignment),
      makeGate(GateName::kAlignmentResidual, "rms residual of the alignment", "m, m/s",
               atMost(measures.residual_rms, kMaxAlignmentResidual),
               InitStatus::kInconsistentResiduals),
      makeGate(GateName::kScaleSigma, "relative standard deviation of the scale", "",
               atMost(measures.scale_sigma, max_scale_sigma), InitStatus::kScaleTooUncertain)};
  gates[1].enforced = true;
  return gates;
}

void decideAlignment(const InitWindow& window, const MotionMeasures& motion,
                     const TranslationEstimate& translation, bool solved,
                     const InitializerOptions& options, InitResult* result) {
  decide(options.gates.mode == GateMode::kOn, result);
  keepObservable(motion.mean_force, window.calibration().gravity_magnitude, result);
  if (solved || !result->success()) return;
  if (translation.valid) {
    fail(InitStatus::kNumericalFailure,
         "the alignment is singular: a pivot of its scaled system is below 1e-14", result);
    return;
  }
  fail(InitStatus::kTooFewTracks,
       text(translation.tracks, " tracks over ", kMinTrackLength,
            " or more keyframes with parallax (minimum ", kMinTracks, ")"),
       result);
}

void solveTranslationAndAlign(const InitWindow& window, const LineTerms& line_terms,
                              const InitializerOptions& options, StageClock* clock,
                              InitResult* result) {
  const Calibration& calibration = window.calibration();
  const std::vector<Preintegration> pre = preintegrateWindow(
      window, result->gyro_bias, Eigen::Vector3d::Zero(), PreintegrationParts::kMean);
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const std::vector<Eigen::Matrix3d> R_c0_ck = cameraRotations(R_b0_bk, calibration.R_b_c);
  clock->lap("integration");

  const TranslationEstimate translation = estimateTranslations(window, R_c0_ck);
  clock->lap("translation");

  // At rest eq. (1) has no sharp minimum, and a wrong bias looks like motion: what moves even less
  // without its rotation does not move.
  MotionMeasures motion = measureMotion(window, pre, R_b0_bk);
  MotionMeasures at_rest;
  measureTracks(window, {R_c0_ck.size(), Eigen::Matrix3d::Identity()}, &at_rest);
  motion.parallax_px = std::min(motion.parallax_px, at_rest.parallax_px);
  result->gates = motionGates(motion, options.gates);

  AlignmentEstimate alignment;
  if (translation.valid) {
    const Eigen::Matrix3Xd centres_b0 = calibration.R_b_c * translation.centres_c0;
    alignment = alignLinear({window, pre, R_b0_bk, centres_b0, line_terms});
  }
  clock->lap("alignment");

  if (alignment.valid) {
    appendGates(alignmentGates({translation.linkage(), alignment.scale, alignment.residual_rms,
                                alignment.scale_sigma},
                               gatesInForce(options.gates, window, options.window).max_scale_sigma),
                result);
    setWorldStates(window, stateOf(R_b0_bk, result->gyro_bias, alignment), result);
    // A negative scale of the alignment is a mirrored trajectory.
    result->scale = std::copysign(result->scale, alignment.scale);
    result->scale_sigma = alignment.scale_sigma;
  }
  decideAlignment(window, motion, translation, alignment.valid, options, result);
  clock->lap("verdict");
}

}  // namespace slim_init::baselines
