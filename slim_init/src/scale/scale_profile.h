// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Is another scale as good? The cost of a refined window over its scale, everything else minimised
// (docs/derivation.md, 5.1). A standard deviation is the curvature of this cost at one point; it
// knows neither that the cost is flat on one side nor that there is a second minimum.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/refine_window.h"
#include "estimation/state_factor.h"
#include "imu/preintegration.h"
#include "scale/reverse_alignment.h"
#include "slim_init/options.h"
#include "slim_init/types.h"

namespace slim_init {

/// The cost over q = log(scale / scale of the refined window); the answer is at q = 0.
struct ScaleProfile {
  bool valid = false;  ///< false where the visual information does not determine the shape
  double log_ratio = kNotComputed;  ///< q of the lowest cost; near 0 where the refinement found it
  double cost = kNotComputed;       ///< there [sigma^2], the images' part above its own minimum
  double cost_here = kNotComputed;  ///< of the answer
  /// Ends of the interval about `log_ratio` in which the cost is less than kIntervalRise above the
  /// lowest. Where it stays below up to the end of the search, that end.
  double low = kNotComputed;
  double high = kNotComputed;
  /// The lowest other minimum at least kSameBasin from the answer, ends of the search included: its
  /// q, and its cost above that of the answer; negative where it is the better one. Without one,
  /// NaN and infinity.
  double other_log_ratio = kNotComputed;
  double other_rise = kNotComputed;

  /// Standard deviation of the log scale of the answer that the farther end of the interval stands
  /// for. At least half the range of the search where the interval has no end.
  double sigma() const;

  static constexpr double kIntervalRise = 4.0;  ///< two standard deviations [sigma^2]
  /// [log ratio]; the linear dependence of the states on the scale is good up to here.
  static constexpr double kSameBasin = 0.2;
};

/// The cost as a function of the scale. The visual cost does not depend on it: it is a quadratic
/// about the refined shape. What the accelerometer measures is linear in first velocity,
/// accelerometer bias and gravity.
class ScaleCost {
 public:
  /// `refined` valid; `pre` with derivatives and covariance, the widened noise included, one per
  /// keyframe pair, between the exposures under the estimated td. `calibration` of the window; the
  /// estimated error of the rig is taken as exact. `motion`: a prior on the motion, where the
  /// refinement had one.
  ScaleCost(const RefinedWindow& refined, const std::vector<Preintegration>& pre,
            const Calibration& calibration, const InertialOptions& inertial,
            const std::optional<MotionPrior>& motion = std::nullopt);

  /// Cost at scale ratio exp(log_ratio), minimised over shape, attitudes, velocities, biases and
  /// gravity [sigma^2]. Infinite where that is singular, everywhere if the visual information does
  /// not determine the shape.
  double operator()(double log_ratio) const;

 private:
  static constexpr int kUnknowns = 9;

  void predictCentres(const LinearMotion& imu, const WindowState& body,
                      const std::vector<Preintegration>& pre,
                      const std::optional<MotionPrior>& motion);
  bool conditionShape(const RefinedWindow& refined, const Calibration& calibration,
                      const WindowState& body, const std::vector<Preintegration>& pre,
                      double gyro_bias_prior);

  bool valid_ = false;
  double gravity_magnitude_;
  double accel_bias_information_;
  // Centres of cameras 1 .. N-1 relative to camera 0, in b0.
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>
      by_unknowns_;               // of the IMU, by x = [v_0, b_a, g]
  Eigen::VectorXd offset_;        // of the IMU at x = 0
  Eigen::VectorXd shape_;         // of the images at ratio 1
  Eigen::MatrixXd by_attitudes_;  // difference of both, by [attitudes, gyroscope bias]
  // Of the prior on the motion: middle velocity and change of velocity, whitened.
  Eigen::Matrix<double, 6, 9> motion_by_unknowns_ = Eigen::Matrix<double, 6, 9>::Zero();
  Eigen::Matrix<double, 6, 1> motion_offset_ = Eigen::Matrix<double, 6, 1>::Zero();
  // Covariance of the difference: S0 - ratio S1 + ratio^2 S2.
  // Lower triangles.
  Eigen::MatrixXd S0_, S1_, S2_;
  mutable Eigen::MatrixXd work_;  // of one evaluation
};

/// Searches the profile on a logarithmic grid, from 1/32 to 32 times the scale of the answer.
ScaleProfile profileScale(const ScaleCost& cost);

/// Moments of the scale, as its ratio to that of a refined window.
struct ScaleMoments {
  bool valid = false;
  double mean = 1.0;          ///< of the ratio
  double variance = 0.0;      ///< of the ratio
  double log_variance = 0.0;  ///< of its logarithm
  double log_best = 0.0;      ///< logarithm of the most probable ratio
};

/// Integrates the density exp(-cost / 2) over the ratio, from 1/32 to 32.
ScaleMoments integrateScale(const ScaleCost& cost);

}  // namespace slim_init
