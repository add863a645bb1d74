// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotation-only epipolar cost of one keyframe pair (Kneip and Lynen, ICCV 2013).
//
// With bearings f_i, f_j of a point in cameras i, j and R = R_ci_cj, the epipolar plane normal is
// m = f_i x R f_j; for the right R all normals are at right angles to the baseline, so the smallest
// eigenvalue of M(R) = sum m m^T vanishes.
#pragma once

#include <Eigen/Core>

namespace slim_init::baselines {

/// Smallest eigenvalue of M(R) with its derivatives under R Exp(delta).
struct EpipolarEvaluation {
  double lambda = 0.0;                                  ///< smallest eigenvalue [rad^2]
  Eigen::Vector3d baseline = Eigen::Vector3d::UnitX();  ///< its eigenvector, up to sign, in c_i
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();   ///< d lambda / d delta, exact
  /// Gauss-Newton Hessian with the baseline eliminated (Schur complement); positive semidefinite
  /// and, for lambda -> 0, equal to the exact one.
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

/// Sums over the points of one pair, made once; an evaluation costs the same for 10 or 1000 points.
///
/// e . m = f_j^T (R^T [e]x) f_i is linear in the entries of R^T [e]x, so e^T M e is a quadratic
/// form in them whose 9x9 matrix S = sum (f_i (x) f_j)(f_i (x) f_j)^T does not depend on R.
class EpipolarPair {
 public:
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW

  /// Adds a point by its unit bearings in cameras i and j.
  void add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j);

  int count() const { return count_; }

  /// Smallest eigenvalue and derivatives at R = R_ci_cj.
  EpipolarEvaluation evaluate(const Eigen::Matrix3d& R_ci_cj) const;

 private:
  Eigen::Matrix<double, 9, 9> sums_ = Eigen::Matrix<double, 9, 9>::Zero();
  int count_ = 0;
};

}  // namespace slim_init::baselines
