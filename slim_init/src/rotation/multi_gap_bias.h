// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Gyroscope bias, extrinsic rotation and td of `slim`: noise-normalised epipolar cost over keyframe
// pairs at several gaps, with vanishing points weighted by their own covariance, under the priors.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/minimize.h"
#include "lines/vanishing_point.h"
#include "priors/sensor_priors.h"
#include "rotation/keyframe_pairs.h"
#include "rotation/normalized_epipolar_pair.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init {

/// VP residual in the tangent plane of d_j, whitened by the covariances of both directions.
/// `residual` 2, `jacobian` 2x3 under R_bi_bj Exp(phi). The sign of d_i is chosen freely.
void whitenedVpResidual(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                        const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                        Eigen::Vector2d* residual, Eigen::Matrix<double, 2, 3>* jacobian);

/// One weighted cost per pair; of pairs that did not enter it is not set.
using WeightedPairs = std::vector<NormalizedEpipolarPair>;

/// Minimum of the cost, with what belongs to it.
struct RotationMinimum {
  RotationUnknowns x = RotationUnknowns::Zero();
  Baselines baselines;     ///< of the last evaluation
  WeightedPairs weighted;  ///< of the last round
  int iterations = 0;      ///< accepted steps
};

/// The cost over RotationUnknowns (docs/derivation.md, 1.2) of one window. Pairs are built once;
/// baselines, masks and weights are values that the caller passes in and gets back. The one thing
/// that calls leave behind is where the gyro was last integrated. Keeps references to
/// its arguments.
class MultiGapProblem {
 public:
  /// `vanishing_points` may be null, else one per keyframe. `rig`: of extrinsic rotation and td.
  MultiGapProblem(const InitWindow& window, const std::vector<VanishingPoint>* vanishing_points,
                  const InertialOptions& inertial, const RigPrior& rig);

  const KeyframePairs& pairs() const { return pairs_; }
  /// The bias at the mean of its prior, the calibration as given.
  RotationUnknowns priorMean() const;
  /// Whether a pair enters a minimisation up to `max_gap` keyframes: consecutive ones only where
  /// longer ones have few points (kMinKeyframesToSkip, kPointsToSkip).
  bool enters(const KeyframePair& pair, int max_gap) const;

  /// Rotations of the pairs up to `max_gap`, integrated anew there if need be
  /// (GyroRotations::linearizeNear()).
  PairRotations rotationsAt(const RotationUnknowns& x, int max_gap);

  /// Iteratively re-weighted Levenberg-Marquardt over the pairs up to `max_gap` keyframes and the
  /// points that `masks` leave: a round per cutoff, the last one to convergence. `baselines`: for
  /// the weights of the first round; where one is not known all points of its pair weigh alike.
  RotationMinimum minimize(const RotationUnknowns& start, int max_gap,
                           const CutoffSchedule& schedule, const PointMasks& masks,
                           Baselines baselines);

  /// Weights as a round of minimize() begins. Baselines that are not known are filled in.
  WeightedPairs weigh(const RotationUnknowns& x, int max_gap, double cutoff_sigmas,
                      const PointMasks& masks, Baselines* baselines);

  /// The baselines that minimise the cost at `minimum`.
  Baselines baselinesAt(const RotationMinimum& minimum, int max_gap) const;

 private:
  // A point enters once per gap; its information counts about once.
  double shareOf(int max_gap) const;
  // Cost of eq. 1.2; the baselines that minimise it are written.
  QuadraticModel<7> evaluate(const RotationUnknowns& x, int max_gap, const WeightedPairs& weighted,
                             Baselines* baselines) const;
  void addPoints(std::size_t p, const PairRotation& rotation, double share,
                 const NormalizedEpipolarPair& weighted, Eigen::Vector3d* baseline,
                 QuadraticModel<7>* sum) const;
  void addVanishingPoints(std::size_t p, const PairRotation& rotation, double share,
                          QuadraticModel<7>* sum) const;
  void addPriors(const RotationUnknowns& x, QuadraticModel<7>* sum) const;
  bool sameVanishingPoint(const KeyframePair& pair) const;

  const InitWindow& window_;
  const std::vector<VanishingPoint>* vps_;
  const Eigen::Vector3d known_bias_;  // or zero [rad/s]
  const double gyro_bias_prior_;      // [rad/s]
  const RigPrior rig_;
  const KeyframePairs pairs_;
  const int shortest_gap_;
  GyroRotations gyro_;
};

}  // namespace slim_init
