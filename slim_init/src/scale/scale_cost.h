// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The cost of a window over its scale, everything else minimised.
//
// In the alignment of DRT the noisy visual displacements multiply the unknown scale, and noise on a
// regressor shrinks its coefficient. Here the camera centres C(x) = A x + c0 that the IMU predicts
// are linear in x = [v_0, b_a, g], the visual shape is the measurement, and for each scale a small
// least-squares problem with a fixed |g| is left (docs/derivation.md, 3.2 and 5.1).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/refine_window.h"
#include "estimation/state_factor.h"
#include "imu/preintegration.h"
#include "scale/linear_motion.h"
#include "slim_init/options.h"
#include "slim_init/types.h"

namespace slim_init {

/// Sum of |J x + r|^2 over what is known of x = [v_0, b_a, g] besides the shape:
/// x^T H x - 2 b^T x + constant.
struct UnknownsPrior {
  Eigen::Matrix<double, 9, 9> H = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> b = Eigen::Matrix<double, 9, 1>::Zero();
  double constant = 0.0;

  void add(const Eigen::Matrix<double, 3, 9>& J, const Eigen::Vector3d& r);
  /// b_a about `mean` [m/s^2].
  void addAccelBias(const Eigen::Vector3d& mean, double sigma);
};

/// Information that holds a shape along itself, in units of the mean of the diagonal: stiff enough
/// that the rest cannot stretch it, far from what rounding allows.
inline constexpr double kLengthWeight = 1e3;

/// The cost as a function of the scale.
class ScaleCost {
 public:
  /// Of a linear start. `shape`: camera centres in b0, stacked, about their mean; `information`: of
  /// the shape, the length held (kLengthWeight). The ratio is in metres per unit of the shape.
  ScaleCost(const LinearMotion& motion, const Eigen::VectorXd& shape,
            const Eigen::MatrixXd& information, const UnknownsPrior& prior,
            double gravity_magnitude);

  /// Of a refined window. The visual cost does not depend on the scale: it is a quadratic about the
  /// refined shape. `refined` valid; `pre` with derivatives and covariance, the widened noise
  /// included, one per keyframe pair, between the exposures under the estimated td. `calibration`
  /// of the window; the estimated error of the rig is taken as exact. `prior` of the biases,
  /// and `motion` of the motion, as the refinement had them, b_a without a tail. The ratio is that
  /// to the scale of the refined window.
  ScaleCost(const RefinedWindow& refined, const std::vector<Preintegration>& pre,
            const Calibration& calibration, const ImuBiases& prior,
            const std::optional<MotionPrior>& motion = std::nullopt);

  /// Cost at scale ratio exp(log_ratio), minimised over all else [sigma^2]. Infinite where that is
  /// singular, everywhere if the visual information does not determine the shape. `x`: there,
  /// [v_0, b_a, g]; undefined where the cost is infinite.
  double operator()(double log_ratio, Eigen::Matrix<double, 9, 1>* x = nullptr) const;

 private:
  // Products of the columns of [A, c0 - ratio shape] over the inverse of their covariance.
  using Products = Eigen::Matrix<double, 10, 10>;

  void predictCentres(const LinearMotion& imu, const WindowState& body,
                      const std::vector<Preintegration>& pre,
                      const std::optional<MotionPrior>& motion);
  bool conditionShape(const RefinedWindow& refined, const Calibration& calibration,
                      const WindowState& body, const std::vector<Preintegration>& pre,
                      const ImuBiases& prior);
  bool weighted(double ratio, Products* products) const;

  bool valid_ = false;
  double gravity_magnitude_;
  UnknownsPrior prior_;
  // Of a start, whose covariance is ratio^2 times that of the shape: products of [A, c0, shape].
  bool of_shape_ = false;
  Eigen::Matrix<double, 11, 11> of_columns_;
  // Of a refined window: centres of cameras 1 .. N-1 relative to camera 0, in b0.
  Eigen::Matrix<double, Eigen::Dynamic, 9> by_unknowns_;  // of the IMU, by x
  Eigen::VectorXd offset_;                                // of the IMU at x = 0
  Eigen::VectorXd shape_;                                 // of the images at ratio 1
  Eigen::MatrixXd by_attitudes_;  // difference of both, by [attitudes, gyroscope bias]
  // Covariance of the difference: S0 - ratio S1 + ratio^2 S2. Lower triangles.
  Eigen::MatrixXd S0_, S1_, S2_;
};

}  // namespace slim_init
