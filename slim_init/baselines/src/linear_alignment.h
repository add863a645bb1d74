// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Step 2b: scale, gravity and velocities from up-to-scale camera positions and the IMU by linear
// least squares (He et al. 2023, section 4.2), with the line terms of the paper (eqs. (7)-(12)).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/preintegration.h"
#include "line_selection.h"
#include "slim_init/init_window.h"

namespace slim_init::baselines {

/// The line terms; null pointer or zero weight leaves a term out.
struct LineTerms {
  const std::vector<PairLines>* lines = nullptr;
  bool use_epipolar = false;     ///< eq. (11)
  bool use_normal = false;       ///< eq. (12)
  double epipolar_weight = 0.0;  ///< constant of eq. (13), type e
  double normal_weight = 0.0;    ///< constant of eq. (13), type n
};

/// Input of the alignment; everything in the first body frame b0 unless named otherwise.
struct AlignmentProblem {
  const InitWindow& window;
  const std::vector<Preintegration>& pre;       ///< at the solved gyroscope bias
  const std::vector<Eigen::Matrix3d>& R_b0_bk;  ///< body attitudes
  const Eigen::Matrix3Xd& centres_b0;           ///< up-to-scale camera centres, rotated to b0
  LineTerms line_terms;
};

/// The normal equations x^T H x - 2 b^T x + c over x = [v_0 .. v_{N-1}, s, g].
struct AlignmentSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double c = 0.0;
};

/// Solution of the alignment, in b0.
struct AlignmentEstimate {
  bool valid = false;
  double scale = kNotComputed;                           ///< metres per unit of centres_b0
  Eigen::Vector3d gravity_b0 = Eigen::Vector3d::Zero();  ///< |g| fixed [m/s^2]
  Eigen::Matrix3Xd velocities_b0;                        ///< 3xN [m/s]
  Eigen::Matrix3Xd positions_b0;                         ///< 3xN body positions, column 0 zero [m]
  double residual_rms = kNotComputed;  ///< over position [m] and velocity [m/s] rows alike
  double scale_sigma = kNotComputed;   ///< relative, from the residual and H
};

/// Normal equations of the position and velocity rows of consecutive keyframes, all with unit
/// weight, as in DRT's release.
AlignmentSystem buildBaseRows(const AlignmentProblem& problem);

/// Adds the line terms of `problem` (eqs. (11), (12)).
void addLineRows(const AlignmentProblem& problem, AlignmentSystem* system);

/// Builds and solves. Fails (valid == false) when the system is singular.
AlignmentEstimate alignLinear(const AlignmentProblem& problem);

/// Eq. (9) for t = t_ij^ci: n_i^T [t]x R_ci_cj n_j. Equals -t . (n_i x R n_j), the baseline along
/// the 3D line's own direction times the sine between the planes: not a constraint on the motion
/// (docs/baselines.md).
double lineEpipolarResidual(const Eigen::Vector3d& n_i, const Eigen::Vector3d& n_j,
                            const Eigen::Matrix3d& R_ci_cj, const Eigen::Vector3d& t_ci_cj);

}  // namespace slim_init::baselines
