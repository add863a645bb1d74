// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotation-only epipolar cost of a keyframe pair, normalised by its noise.
//
// The smallest eigenvalue of M = sum w m m^T, m = f_i x R f_j (epipolar_pair.h), is biased: noise
// of standard deviation sigma on the bearings adds sigma^2 N to E[M], with
//   N = sum w (2 I - f_i f_i^T - R f_j f_j^T R^T),
// which depends on the direction and on R. The quotient e^T M e / e^T N e has the expectation
// sigma^2 at the true rotation whatever the baseline e, so its minimum is not (docs/derivation.md).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slim_init {

/// min over e of e^T M e / e^T N e with derivatives under R Exp(delta), weights fixed.
struct NormalizedEvaluation {
  double lambda = 0.0;                                  ///< the minimum [rad^2]
  Eigen::Vector3d baseline = Eigen::Vector3d::UnitX();  ///< minimiser e, unit, up to sign, in c_i
  double noise = 1.0;                                   ///< e^T N e / sum w
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();   ///< d lambda / d delta, exact
  /// Gauss-Newton Hessian with the baseline eliminated; positive semidefinite.
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

/// One pair of keyframes (i, j) with its common points and their robust weights.
class NormalizedEpipolarPair {
 public:
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW

  void add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j);
  int count() const { return static_cast<int>(f_i_.size()); }
  double weightSum() const { return weight_sum_; }

  /// Sets every weight to one and sums.
  void resetWeights();

  /// Sets the weights of a Cauchy loss, 1 / (1 + z^2 / c^2), at R and the current baseline, and
  /// sums again. z is the point's residual e . m in units of its standard deviation, `sigma` [rad]
  /// that of a bearing, c = `cauchy_sigmas`.
  void updateWeights(const Eigen::Matrix3d& R_ci_cj, double sigma, double cauchy_sigmas);

  /// Quotient and derivatives. `baseline_prior` [rad^2] regularises the elimination of the baseline
  /// where the parallax is of the order of the noise.
  NormalizedEvaluation evaluate(const Eigen::Matrix3d& R_ci_cj, double baseline_prior) const;

  /// Residuals z of all points at R, in sigmas, for the baseline that minimises the quotient.
  std::vector<double> residuals(const Eigen::Matrix3d& R_ci_cj, double sigma) const;

 private:
  void sum();
  void residualsInto(const Eigen::Matrix3d& R_ci_cj, double sigma, std::vector<double>* z) const;

  std::vector<Eigen::Vector3d> f_i_, f_j_;
  std::vector<double> weights_;
  Eigen::Matrix<double, 9, 9> sums_ = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix3d sum_ii_ = Eigen::Matrix3d::Zero();  // sum w f_i f_i^T
  Eigen::Matrix3d sum_jj_ = Eigen::Matrix3d::Zero();  // sum w f_j f_j^T
  double weight_sum_ = 0.0;
};

}  // namespace slim_init
