// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Common points of two keyframes, their epipolar residuals at a known rotation, and the direction
// of translation that most of them agree with (docs/derivation.md, 1.1 and 1.3).
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// Residuals of the points of a pair.
struct PointResiduals {
  Eigen::ArrayXd z2;     ///< squared residuals in units of their variance
  Eigen::ArrayXd noise;  ///< that variance over sigma^2, |e x f_i|^2 + |R^T e x f_j|^2
};

/// How a baseline is searched.
struct ConsensusOptions {
  double truncation_sigmas = 3.0;  ///< residuals count up to this many standard deviations
  /// Two-point directions tried; 0 rates the one at hand. With 40 % outliers all of twenty contain
  /// one with a probability of 1e-4.
  int hypotheses = 20;
};

/// Direction of translation of a pair.
struct ConsensusBaseline {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, in c_i; zero: none found
  double cost = 0.0;  ///< sum over the points of min(z^2, truncation^2) [sigma^2]
};

/// Unit bearings of the points seen in keyframes i and j.
class PairPoints {
 public:
  using Bearings = Eigen::Array<double, Eigen::Dynamic, 3>;
  /// Points are stored in groups of this many, filled up with zeros, which add nothing to any sum.
  static constexpr int kGroup = 2;

  void add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j);
  int count() const { return count_; }

  /// One row per point, columns contiguous; rows beyond count() are zero.
  const Bearings& bearingsI() const { return f_i_; }
  const Bearings& bearingsJ() const { return f_j_; }

  /// Residuals e . m of all points at R and baseline e (unit, in c_i), `sigma` [rad] the standard
  /// deviation of a bearing.
  PointResiduals residuals(const Eigen::Matrix3d& R_ci_cj, const Eigen::Vector3d& baseline,
                           double sigma) const;

  /// Direction of translation at a known R by consensus: of `first` (skipped when zero) and of the
  /// directions that two points define, the one with the least cost; none is drawn where the first
  /// leaves no more than good data would (kGoodEnough). The points come from a fixed
  /// sequence that starts at `seed`. Where no two points differ the direction is zero and every
  /// point costs truncation^2.
  ConsensusBaseline consensusBaseline(const Eigen::Matrix3d& R_ci_cj, double sigma,
                                      const ConsensusOptions& options, unsigned seed,
                                      const Eigen::Vector3d& first) const;

 private:
  int count_ = 0;
  Bearings f_i_, f_j_;
};

}  // namespace slim_init
