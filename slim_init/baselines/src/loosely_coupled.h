// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the rotation-translation decoupled methods (drt-l, drt-t, slim-paper) share after step 1.
#pragma once

#include "gyro_bias.h"
#include "imu/preintegration.h"
#include "linear_alignment.h"
#include "pipeline/solver_support.h"
#include "shape/ligt.h"
#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init::baselines {

/// Limits of the gates on an alignment, beside those of GateOptions: ratio of eigenvalues of the
/// translation system, and rms residual of the alignment [m, m/s].
inline constexpr double kMinLinkage = 10.0, kMaxAlignmentResidual = 0.10;

/// Takes the result of step 1. False, with status and message set, when its estimate cannot be
/// used.
bool acceptGyroBias(const GyroBiasEstimate& bias, InitResult* result);

/// The motion in b0 that an alignment has found, at its attitudes and the bias of step 1.
template <typename Alignment>
WindowState stateOf(const std::vector<Eigen::Matrix3d>& R_b0_bk, const Eigen::Vector3d& gyro_bias,
                    const Alignment& alignment) {
  WindowState state;
  state.R_b0_bk = R_b0_bk;
  state.p_b0 = alignment.positions_b0;
  state.v_b0 = alignment.velocities_b0;
  state.gyro_bias = gyro_bias;
  state.gravity_b0 = alignment.gravity_b0;
  return state;
}

/// Root of the summed squared distances of the camera centres from their mean [m]: what one unit of
/// estimateTranslations() is in metres.
double cameraSpread(const InitWindow& window, const WindowState& state);

/// The inverse of setWorldStates(): world states, at least one, in the frame of the first body,
/// with gravity of this size along -z of w and the biases of the newest state.
WindowState windowStateOf(const std::vector<NavState>& states, double gravity_magnitude);

/// What the gates on an alignment compare.
struct AlignmentMeasures {
  double linkage = kNotComputed;       ///< TranslationEstimate::linkage()
  double scale = kNotComputed;         ///< metres per unit of the trajectory
  double residual_rms = kNotComputed;  ///< of velocity and position rows [m, m/s]
  double scale_sigma = kNotComputed;   ///< relative
};

/// Gates on a loosely-coupled answer: "linkage" and "scale_positive" (degenerate alignment),
/// "alignment_residual" (inconsistent residuals), "scale_sigma" (scale too uncertain, bound
/// `max_scale_sigma`). "scale_positive" is enforced for every method: a scale that is not positive
/// contradicts the points being in front of the camera, so there is no answer to accept.
std::vector<GateValue> alignmentGates(const AlignmentMeasures& measures, double max_scale_sigma);

/// The end of a method: the status that the gates give and, where none has refused and yet the
/// alignment is not `solved`, the refusal: too few tracks for the translations, or a singular
/// system.
void decideAlignment(const InitWindow& window, const MotionMeasures& motion,
                     const TranslationEstimate& translation, bool solved,
                     const InitializerOptions& options, InitResult* result);

/// Step 2 of drt-l and slim-paper: re-integration at the solved bias, translations (LiGT), linear
/// alignment with `line_terms`, states, gates. The gates are enforced with GateMode::kOn only: as
/// published, these methods have none. `result` has passed acceptGyroBias().
void solveTranslationAndAlign(const InitWindow& window, const LineTerms& line_terms,
                              const InitializerOptions& options, StageClock* clock,
                              InitResult* result);

}  // namespace slim_init::baselines
