// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "solvers/loosely_coupled.h"

#include <sstream>

#include "geometry/so3.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

// States in the gravity-aligned world from the alignment in b0.
void setStates(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_b0_bk,
               const AlignmentEstimate& alignment, InitResult* result) {
  const Eigen::Matrix3d R_w_b0 = gravityAlignedAttitude(alignment.gravity_b0);
  result->gravity_w = Eigen::Vector3d(0.0, 0.0, -window.calibration().gravity_magnitude);
  result->gravity_b0 = alignment.gravity_b0;
  result->scale = alignment.scale;
  result->scale_sigma = alignment.scale_sigma;
  for (int k = 0; k < window.size(); ++k) {
    NavState state;
    state.t = window.times()[k];
    state.R_w_b = R_w_b0 * R_b0_bk[k];
    state.p_w_b = R_w_b0 * alignment.positions_b0.col(k);
    state.v_w_b = R_w_b0 * alignment.velocities_b0.col(k);
    state.gyro_bias = result->gyro_bias;
    state.accel_bias = result->accel_bias;
    result->states.push_back(state);
  }
}

}  // namespace

bool acceptGyroBias(const GyroBiasEstimate& bias, const GyroBiasOptions& options,
                    InitResult* result) {
  result->counts.gyro_bias_iterations = bias.iterations;
  result->counts.vp_pairs = bias.vp_pairs;
  std::ostringstream message;
  if (bias.point_pairs == 0) {
    message << "0 keyframe pairs have at least " << options.min_points_per_pair
            << " common points, needs 1";
    fail(InitStatus::kTooFewTracks, message.str(), result);
    return false;
  }
  if (!bias.valid) {
    message << "gyroscope bias of " << bias.gyro_bias.norm() << " rad/s, must be at most "
            << options.max_bias;
    fail(InitStatus::kNumericalFailure, message.str(), result);
    return false;
  }
  result->gyro_bias = bias.gyro_bias;
  return true;
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

  MotionMeasures motion;
  motion.parallax_px = medianParallaxPx(window, R_c0_ck);
  motion.rotation_deg = maxRotationDeg(R_b0_bk);
  motion.excitation = forceDeviation(pre, R_b0_bk);
  result->gates = motionGates(motion, options.gates);

  AlignmentEstimate alignment;
  if (translation.valid) {
    const Eigen::Matrix3Xd centres_b0 = calibration.R_b_c * translation.centres_c0;
    alignment = alignLinear({window, pre, R_b0_bk, centres_b0, line_terms});
  }
  clock->lap("alignment");

  if (alignment.valid) {
    const std::vector<GateValue> gates =
        alignmentGates(translation.linkage(), alignment.scale, alignment.residual_rms,
                       alignment.scale_sigma, options.gates);
    result->gates.insert(result->gates.end(), gates.begin(), gates.end());
    result->accel_bias.setZero();
    setStates(window, R_b0_bk, alignment, result);
  }
  decide(options.gates.mode == GateMode::kOn, result);
  keepObservable(pre, R_b0_bk, calibration.gravity_magnitude, result);
  clock->lap("verdict");
  if (alignment.valid || !result->success()) return;

  // No gate has refused, and yet there is no answer.
  if (!translation.valid) {
    std::ostringstream message;
    message << translation.tracks << " tracks over at least " << options.alignment.min_track_length
            << " keyframes with parallax, needs " << options.alignment.min_tracks;
    fail(InitStatus::kTooFewTracks, message.str(), result);
  } else {
    fail(InitStatus::kNumericalFailure,
         "the alignment is singular: a pivot of its scaled system is below 1e-14", result);
  }
}

}  // namespace slim_init
