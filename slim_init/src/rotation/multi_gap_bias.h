// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Gyroscope bias of `slim`: noise-normalised epipolar cost over keyframe pairs at several gaps,
// with vanishing points weighted by their own covariance.
#pragma once

#include <Eigen/Core>
#include <Eigen/StdVector>
#include <initializer_list>
#include <vector>

#include "imu/preintegration.h"
#include "lines/vanishing_point.h"
#include "rotation/normalized_epipolar_pair.h"
#include "rotation/rotation_correction.h"
#include "rotation/track_pruning.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// Result of the estimation.
struct MultiGapBiasEstimate {
  bool valid = false;  ///< some pair had data, the bias is finite and at most max_bias
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  ///< [rad/s]
  /// Mean squared residual, truncated at nine [sigma^2]; comparable between starts on the same
  /// data.
  double cost = 0.0;
  /// Inverse covariance of the bias [1/(rad/s)^2], gyro noise included.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  int iterations = 0;
  int point_pairs = 0;
  int vp_pairs = 0;
};

/// VP residual in the tangent plane of d_j, whitened by the covariances of both directions.
/// `residual` 2, `jacobian` 2x3 under R_bi_bj Exp(phi). The sign of d_i is chosen freely.
void whitenedVpResidual(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                        const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                        double inflation, Eigen::Vector2d* residual,
                        Eigen::Matrix<double, 2, 3>* jacobian);

/// Minimises from each of `starts`, without pruning, and keeps the lowest cost. `vanishing_points`
/// may be null, else one per keyframe.
MultiGapBiasEstimate estimateMultiGapBias(const InitWindow& window,
                                          const std::vector<Eigen::Vector3d>& starts,
                                          const std::vector<VanishingPoint>* vanishing_points,
                                          const MultiGapBiasOptions& options);

/// The keyframe pairs of a window with their common points, for repeated pruning and minimisation.
/// Keeps references to its arguments.
class MultiGapProblem {
 public:
  MultiGapProblem(const InitWindow& window, const std::vector<VanishingPoint>* vanishing_points,
                  const MultiGapBiasOptions& options);

  int pointPairs() const { return point_pairs_; }
  int vpPairs() const { return vp_pairs_; }

  /// Consecutive pairs add a third to the time and little to the bias where all longer ones have
  /// points enough; then they are left out of the minimisation, unless `always`.
  void useConsecutivePairs(bool always) { min_gap_ = always ? 1 : default_min_gap_; }

  /// Forgets the baselines of all pairs, so that findBaselines() starts afresh.
  void clearBaselines();

  /// Baselines of all pairs up to `max_gap` keyframes by consensus at a bias. Returns the mean over
  /// their points of the squared residual [sigma^2], truncated at the square of
  /// `truncation_sigmas`. With `reuse` the baseline at hand is kept where it leaves no more than
  /// good data would.
  double findBaselines(const Eigen::Vector3d& gyro_bias, int max_gap, double truncation_sigmas,
                       int hypotheses, bool reuse);

  /// Iteratively re-weighted Levenberg-Marquardt over the pairs up to `max_gap`, from the baselines
  /// at hand: a round per entry of `cutoff_sigmas`, the last one to convergence. Adds the accepted
  /// steps to `iterations` and returns the bias.
  Eigen::Vector3d minimize(const Eigen::Vector3d& start, int max_gap,
                           std::initializer_list<double> cutoff_sigmas, int* iterations);

  /// Sightings that agree with a bias, by consensus at gaps 1, 2 and 4, whatever keepOnly() said.
  TrackPruning prune(const Eigen::Vector3d& gyro_bias, double threshold_sigmas, int hypotheses,
                     bool reuse);

  /// A point of a pair counts only when both sightings are kept and its track is not cut between
  /// them. `keep` as TrackPruning::keep; empty keeps everything.
  void keepOnly(const std::vector<char>& keep);

  /// Robust weights at a bias and the baselines at hand, as minimize() leaves them.
  void refreshWeights(const Eigen::Vector3d& gyro_bias, int max_gap, double cutoff_sigmas);

  /// The pairs `gap` keyframes apart with their rotation freed. `cutoff_sigmas` decreasing, one
  /// round of re-weighting for each; a first one of tens of standard deviations finds rotations
  /// that are degrees off. Pairs whose points do not determine a rotation are left out. Masks and
  /// weights of these pairs are reset.
  std::vector<RotationCorrection> freeRotations(const Eigen::Vector3d& gyro_bias, int gap,
                                                std::initializer_list<double> cutoff_sigmas);

  /// Inverse covariance of a minimiser, for the weights at hand [1/(rad/s)^2]: the curvature of the
  /// cost and the scatter of the tracks' gradients, so that points that enter at several gaps, or
  /// are worse than they should be, count for what they are; and the gyro's white noise over the
  /// window, with `gyro_noise_inflation` times the calibration's density.
  Eigen::Matrix3d information(const Eigen::Vector3d& gyro_bias, double gyro_noise_inflation);

 private:
  struct Pair {
    EIGEN_MAKE_ALIGNED_OPERATOR_NEW
    int i = 0, j = 0;
    NormalizedEpipolarPair points;
    std::vector<int> sighting_i, sighting_j, track;      // of every point
    Eigen::Vector3d baseline = Eigen::Vector3d::Zero();  // zero: not known
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();     // R_ci_cj
    Eigen::Matrix3d dR_dbg = Eigen::Matrix3d::Zero();    // R Exp(dR_dbg d)
    bool use_points = false;
    bool use_vp = false;
  };
  struct Quadratic {
    double cost = 0.0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  };

  // Takes part in the minimisation up to `max_gap`?
  bool enters(const Pair& pair, int max_gap) const {
    return pair.j - pair.i >= min_gap_ && pair.j - pair.i <= max_gap;
  }
  double share(int max_gap) const;
  // Integrates the gyro anew when the last linearisation is further off than `tolerance` [rad/s].
  void linearizeNear(const Eigen::Vector3d& gyro_bias, double tolerance);
  void rotateTo(const Eigen::Vector3d& gyro_bias, int max_gap);
  Quadratic evaluate(const Eigen::Vector3d& gyro_bias, int max_gap);

  const InitWindow& window_;
  const std::vector<VanishingPoint>* vps_;
  const MultiGapBiasOptions& options_;
  const double sigma_;  // of a bearing [rad]
  std::vector<Pair, Eigen::aligned_allocator<Pair>> pairs_;
  std::vector<Preintegration> pre_;  // at the last linearisation
  int point_pairs_ = 0;
  int vp_pairs_ = 0;
  int default_min_gap_ = 1;
  int min_gap_ = 1;
  // Scratch.
  std::vector<Eigen::Matrix3d> attitude_, derivative_;
  PointResiduals residuals_;
  ConsensusScratch consensus_;
};

}  // namespace slim_init
