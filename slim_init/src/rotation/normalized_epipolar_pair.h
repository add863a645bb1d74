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

#include "rotation/keyframe_pairs.h"

namespace slim_init {

/// Prior of the baseline in its elimination, in variances of a bearing: half of one keeps the
/// Hessian regular where the parallax is of the order of the noise (docs/derivation.md, 1.1).
inline constexpr double kBaselinePriorSigmas2 = 0.5;
/// Rotation and direction of travel of a pair, fitted to its points; fewer, counted by their
/// weight, do not determine them.
inline constexpr int kPairUnknowns = 5;

/// min over e of e^T M e / e^T N e with derivatives under R Exp(delta), weights fixed.
struct NormalizedEvaluation {
  double lambda = 0.0;                                  ///< the minimum [rad^2]
  Eigen::Vector3d baseline = Eigen::Vector3d::UnitX();  ///< minimiser e, unit, up to sign, in c_i
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();   ///< d lambda / d delta, exact
  /// Gauss-Newton Hessian with the baseline eliminated; positive semidefinite.
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

/// The cost of one pair of keyframes (i, j) with the weights of its points fixed: a value, made of
/// points and weights by weigh().
class NormalizedEpipolarPair {
 public:
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW

  /// Robust weights in [0, 1] summed: the number of points that still count.
  double robustCount() const { return robust_count_; }

  /// Sets the weights of a Geman-McClure loss, 1 / (1 + z^2 / c^2)^2, at R and `baseline`, each
  /// divided by the point's own noise, zero where `mask` is (empty: all are used). z is the point's
  /// residual e . m in units of its standard deviation, `sigma` [rad] that of a bearing,
  /// c = `cutoff_sigmas`. With a baseline of zero all points weigh alike.
  void weigh(const PairPoints& points, const Eigen::ArrayXd& mask, const Eigen::Matrix3d& R_ci_cj,
             const Eigen::Vector3d& baseline, double sigma, double cutoff_sigmas);

  /// Quotient and derivatives. `baseline_prior` [rad^2] regularises the elimination of the baseline
  /// where the parallax is of the order of the noise. A baseline `near` the minimiser saves half of
  /// the time and changes nothing: it is only used where the minimum that it leads to proves to be
  /// the lowest. Zero: none.
  NormalizedEvaluation evaluate(const Eigen::Matrix3d& R_ci_cj, double baseline_prior,
                                const Eigen::Vector3d& near = Eigen::Vector3d::Zero()) const;

  /// NormalizedEvaluation::baseline alone.
  Eigen::Vector3d baseline(const Eigen::Matrix3d& R_ci_cj, const Eigen::Vector3d& near) const;

 private:
  // The quotient e^T M e / e^T N e at R, and the derivatives B of vec(R^T [e]x) by e.
  struct Forms {
    Eigen::Matrix<double, 9, 3> B;
    Eigen::Matrix3d M, N;
  };

  void sum(const PairPoints& points);
  Forms formsAt(const Eigen::Matrix3d& R_ci_cj) const;

  Eigen::ArrayXd weights_;  // with the rows of the points, zero beyond their count
  Eigen::Matrix<double, 9, 9> sums_ = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix3d sum_ii_ = Eigen::Matrix3d::Zero();  // sum w f_i f_i^T
  Eigen::Matrix3d sum_jj_ = Eigen::Matrix3d::Zero();  // sum w f_j f_j^T
  double weight_sum_ = 0.0;
  double robust_count_ = 0.0;
};

}  // namespace slim_init
