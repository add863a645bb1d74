// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The keyframe pairs of a window with their common points, built once and never changed, their
// epipolar residuals and the direction of translation that most of them agree with at a known
// rotation (docs/derivation.md, 1.1 and 1.3), and what is passed between the steps of the rotation
// stage: rotations at a bias, baselines, masks.
#pragma once

#include <Eigen/Core>
#include <iterator>
#include <vector>

#include "imu/preintegration.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Distances [keyframes] between the two keyframes of a pair. The derivative of a rotation by the
/// bias grows with the gap while its noise does not; doubling it keeps the number of pairs low.
inline constexpr int kGaps[] = {1, 2, 4, 8};
inline constexpr int kLongestGap = *(std::end(kGaps) - 1);
/// Pairs with fewer common points are neither used nor tested.
inline constexpr int kMinPointsPerPair = 6;
/// Gap [keyframes] over which a camera has turned enough to say something of the calibration, a
/// bias still unknown turns it little, and the tracks have not yet drifted: that of the first bias
/// and of the rotations that are freed.
inline constexpr int kShortGap = 2;
/// Largest gap [keyframes] at which observations are tested and a bias is rated: a wrong one shows
/// at long gaps, but over longer ones the rotation is less certain and clean tracks have drifted.
inline constexpr int kLongGap = 4;

/// Cutoffs c of the robust weights in successive rounds of re-weighting, in standard deviations of
/// a residual. The first ones are wide where the start may be wrong.
using CutoffSchedule = std::vector<double>;
/// Where little is known of the rotation: 40 are 24 px, what eight degrees of extrinsic rotation
/// make of a quick turn.
inline const CutoffSchedule kWideStart = {40.0, 10.0, 3.0, 3.0};

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

/// Two keyframes i < j with the points seen in both.
struct KeyframePair {
  int i = 0, j = 0;
  PairPoints points;
  std::vector<int> observation_i,
      observation_j;        ///< of every point, into InitWindow::pointObservations()
  bool use_points = false;  ///< enough points to enter

  int gap() const { return j - i; }
};

/// All pairs of a window 1, 2, 4 and 8 keyframes apart, ascending in the gap and then in i.
class KeyframePairs {
 public:
  /// Pairs more than `max_gap` keyframes apart are left out; those with fewer than
  /// kMinPointsPerPair common points do not use them.
  KeyframePairs(const InitWindow& window, int max_gap);

  std::size_t size() const { return pairs_.size(); }
  const KeyframePair& operator[](std::size_t p) const { return pairs_[p]; }
  std::vector<KeyframePair>::const_iterator begin() const { return pairs_.begin(); }
  std::vector<KeyframePair>::const_iterator end() const { return pairs_.end(); }

  int keyframes() const { return keyframes_; }
  /// Standard deviation of a bearing [rad].
  double sigma() const { return sigma_; }
  /// Pairs that use their points.
  int pointPairs() const;

 private:
  int keyframes_;
  double sigma_;
  std::vector<KeyframePair> pairs_;
};

/// What turns the rotations of the gyroscope: its bias (3) [rad/s], and the error of the window's
/// calibration, which has the extrinsic rotation R_b_c Exp(3) [rad] and td later by the last [s].
using RotationUnknowns = Eigen::Matrix<double, 7, 1>;

/// Rotation of a pair as the gyroscope has it.
struct PairRotation {
  Eigen::Matrix3d R_ci_cj = Eigen::Matrix3d::Identity();
  /// R Exp(J d) for unknowns d more.
  Eigen::Matrix<double, 3, 7> J = Eigen::Matrix<double, 3, 7>::Zero();
};
/// One per pair.
using PairRotations = std::vector<PairRotation>;

/// Bias [rad/s] and td [s] may be this far from where the gyro was integrated: the correction of
/// first order is then wrong by 1e-6 rad over two seconds, a hundredth of what the points know.
inline constexpr double kRelinearizeTolerance = 1e-3;

/// The gyroscope between the keyframes. Exact in the extrinsic rotation, of first order about bias
/// and td of the last integration. Keeps a reference to the window.
class GyroRotations {
 public:
  /// Integrates at unknowns of zero.
  explicit GyroRotations(const InitWindow& window);

  /// Integrates anew at `x` where the last integration is further off than kRelinearizeTolerance.
  void linearizeNear(const RotationUnknowns& x);

  /// Rotations of the pairs up to `max_gap` keyframes apart; the identity for the others.
  PairRotations at(const RotationUnknowns& x, const KeyframePairs& pairs, int max_gap) const;

 private:
  void integrate(const Eigen::Vector3d& gyro_bias, double td);

  const InitWindow& window_;
  std::vector<Preintegration> pre_;
  std::vector<ImuInstant> instants_;  // at the keyframes
  double td_ = 0.0;                   // of both, against that of the window
};

/// Direction of translation per pair, unit, in c_i; zero where it is not known.
using Baselines = std::vector<Eigen::Vector3d>;

/// Finds the baselines of the pairs up to `max_gap` keyframes apart by consensus at known
/// rotations; those that are known compete (PairPoints::consensusBaseline()). Longer pairs keep
/// theirs. Returns the mean over the points of the squared residual, truncated [sigma^2].
double findBaselines(const KeyframePairs& pairs, const PairRotations& rotations, int max_gap,
                     const ConsensusOptions& options, Baselines* baselines);

/// Per pair and point: 1 used, 0 left out. Without entries every point is used.
using PointMasks = std::vector<Eigen::ArrayXd>;

/// Leaves out the points of a pair of which an observation is dropped. `keep`: as
/// withObservations() takes it.
PointMasks masksOf(const KeyframePairs& pairs, const std::vector<char>& keep);

}  // namespace slim_init
