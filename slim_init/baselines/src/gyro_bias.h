// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Step 1: gyroscope bias from rotation-only constraints, eq. (1) of the paper; without the VP term
// it is the bias estimator of DRT (He et al. 2023, section 4.1).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "imu/preintegration.h"
#include "lines/vanishing_point.h"
#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init::baselines {

/// Minimum number of common points of a keyframe pair.
inline constexpr int kMinPointsOfPair = 6;
/// Maximum valid estimate [rad/s].
inline constexpr double kMaxGyroBias = 1.0;

/// How the point residuals of a pair enter the robust cost rho (Cauchy).
enum class PairLoss {
  /// rho(lambda^2): the residual of a pair is the eigenvalue itself, scale in rad^2 (DRT's
  /// release).
  kEigenvalue,
  /// rho(lambda): lambda is the sum of squared point residuals, eq. (1) of the paper; the Cauchy
  /// scale is taken from the expected noise of the pair's points.
  kSumOfSquares,
};

/// What to minimise.
struct GyroBiasProblem {
  PairLoss pair_loss = PairLoss::kEigenvalue;
  /// VP term of eq. (1); null without it. One entry per keyframe.
  const std::vector<VanishingPoint>* vanishing_points = nullptr;
  SlimPaperOptions vp_options;  ///< of that term
};

/// Result of step 1.
struct GyroBiasEstimate {
  bool valid = false;  ///< a pair had enough points, the bias is finite and <= kMaxGyroBias
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
  int point_pairs = 0;  ///< keyframe pairs with enough common points
};

/// VP residual of eq. (4), r = d_j x (R_cj_ci d_i) with the sign of d_i such that both point the
/// same way, and its derivative under R_bi_bj Exp(phi).
/// R_cj_ci = R_b_c^T R_bi_bj^T R_b_c: note the transpose (eq. (5) takes b_i to b_j).
void vpResidual(const Eigen::Vector3d& d_i, const Eigen::Vector3d& d_j,
                const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                Eigen::Vector3d* residual, Eigen::Matrix3d* jacobian);

/// The indicator of IV-B-2 for a pair of keyframes, `vp_i` the earlier one: both found, same id,
/// age of the later one >= min_track_age, `consistency` of both <= consistency_threshold_deg.
bool isReliablePair(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                    const std::array<double, 2>& consistency_rad, const SlimPaperOptions& options);

/// Rms of e^vp = n . d over the inliers, eq. (3) [rad]; `lines` of its keyframe.
double consistencyOf(const VanishingPoint& vp, const std::vector<WindowLine>& lines);

/// Minimises the rotation-only cost over the gyroscope bias from zero, re-integrating the gyro at
/// each new estimate. Fails (valid == false) when no pair has enough points: vanishing
/// points alone leave the rotation about the dominant axis open.
GyroBiasEstimate estimateGyroBias(const InitWindow& window, const GyroBiasProblem& problem);

}  // namespace slim_init::baselines
