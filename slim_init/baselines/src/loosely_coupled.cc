// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "loosely_coupled.h"

#include <cmath>
#include <sstream>

#include "verdict/gates.h"

namespace slim_init::baselines {

bool acceptGyroBias(const GyroBiasEstimate& bias, const GyroBiasOptions& options,
                    InitResult* result) {
  result->counts.gyro_bias_iterations = bias.iterations;
  result->counts.vp_pairs = bias.vp_pairs;
  std::ostringstream message;
  if (bias.point_pairs == 0) {
    message << "0 keyframe pairs with " << options.min_points_per_pair
            << " or more common points (minimum 1)";
    fail(InitStatus::kTooFewTracks, message.str(), result);
    return false;
  }
  if (!bias.valid) {
    message << "gyroscope bias " << bias.gyro_bias.norm() << " rad/s (limit " << options.max_bias
            << ")";
    fail(InitStatus::kNumericalFailure, message.str(), result);
    return false;
  }
  result->gyro_bias = bias.gyro_bias;
  return true;
}

void failAlignment(const TranslationEstimate& translation, const AlignmentOptions& options,
                   InitResult* result) {
  if (translation.valid) {
    fail(InitStatus::kNumericalFailure,
         "the alignment is singular: a pivot of its scaled system is below 1e-14", result);
    return;
  }
  std::ostringstream message;
  message << translation.tracks << " tracks over " << options.min_track_length
          << " or more keyframes with parallax (minimum " << options.min_tracks << ")";
  fail(InitStatus::kTooFewTracks, message.str(), result);
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

  const TranslationEstimate translation = estimateTranslations(window, R_c0_ck, options.alignment);
  clock->lap("translation");

  result->gates = motionGates(measureMotion(window, pre, R_b0_bk), options.gates);

  AlignmentEstimate alignment;
  if (translation.valid) {
    const Eigen::Matrix3Xd centres_b0 = calibration.R_b_c * translation.centres_c0;
    alignment = alignLinear({window, pre, R_b0_bk, centres_b0, line_terms});
  }
  clock->lap("alignment");

  if (alignment.valid) {
    const std::vector<GateValue> gates =
        alignmentGates(translation.linkage(), alignment.scale, alignment.residual_rms,
                       alignment.scale_sigma, gatesInForce(options.gates, window, options.window));
    appendGates(gates, result);
    WindowState state;
    state.R_b0_bk = R_b0_bk;
    state.p_b0 = alignment.positions_b0;
    state.v_b0 = alignment.velocities_b0;
    state.gyro_bias = result->gyro_bias;
    state.gravity_b0 = alignment.gravity_b0;
    setWorldStates(window, state, result);
    // A negative scale of the alignment is a mirrored trajectory.
    result->scale = std::copysign(result->scale, alignment.scale);
    result->scale_sigma = alignment.scale_sigma;
  }
  decide(options.gates.mode == GateMode::kOn, result);
  keepObservable(pre, R_b0_bk, calibration.gravity_magnitude, result);
  clock->lap("verdict");
  if (alignment.valid || !result->success()) return;

  // No gate has refused, and yet there is no answer.
  failAlignment(translation, options.alignment, result);
}

}  // namespace slim_init::baselines
