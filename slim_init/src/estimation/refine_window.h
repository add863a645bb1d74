// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The refinement of `slim` around the minimisation: noise from the data, rejection and a second
// solve.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "estimation/state_factor.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// The refined window.
struct RefinedWindow {
  bool valid = false;
  WindowState state;  ///< with the rig error
  /// Information of the error vector without the gauge (StateLayout, from index kGauge on).
  Eigen::MatrixXd information;
  Eigen::MatrixXd visual_information;  ///< VisualInertialProblem::visualInformation()
  Eigen::VectorXd visual_gradient;     ///< VisualInertialProblem::visualGradient()
  /// Robust visual cost per degree of freedom before any rejection, at the calibration's noise.
  double chi2 = 0.0;
  /// Cost of the IMU factors and bias priors per residual row, after the last solve.
  double inertial_chi2 = 0.0;
  double inlier_fraction = 0.0;  ///< point observations kept, of those handed in
  /// Of points behind the camera after the first solve; also if a later one failed.
  double behind_fraction = 0.0;
  double sigma_px = 0.0;       ///< noise of a point estimated from the data, floored [px]
  double sigma_line_px = 0.0;  ///< the same of a line end point
  double cost = 0.0;           ///< of the first solve, comparable between starts on the same data
  SpeedUse speeds;             ///< VisualInertialProblem::speedUse()
};

/// Preintegrations with covariance at the biases, from the noise that is to be assumed of the
/// window's IMU (assumedImuNoise(); the gyroscope's times `gyro_noise`), between the keyframe times
/// moved by `td_shift` [s].
std::vector<Preintegration> preintegrateInflated(const InitWindow& window,
                                                 const Eigen::Vector3d& gyro_bias,
                                                 const Eigen::Vector3d& accel_bias,
                                                 const InertialOptions& inertial,
                                                 double td_shift = 0.0, double gyro_noise = 1.0);

/// What every refinement of a window shares. Keeps references: the arguments outlive it.
struct RefinementInput {
  const InitWindow& tracks;                ///< points pruned
  const std::vector<Preintegration>& pre;  ///< by preintegrateInflated()
  const RefinementOptions& options;
  const InertialOptions& inertial;
  WorkBudget& budget;  ///< counts its work; used up, a minimisation ends
  WindowPriors priors = {};
};

/// Another start if the first minimum does not fit; none: the first one stands.
using OtherStart = std::function<std::optional<WindowState>()>;

/// Refines from `start`, or from `other` if the cost is lower there. `lines` as the constructor of
/// VisualInertialProblem takes them, `input.pre` made at the gyroscope bias of the start. If the
/// budget ends a minimisation, the result is not valid.
RefinedWindow refineWindow(const RefinementInput& input, const std::vector<Track>& lines,
                           const WindowState& start, const OtherStart& other = nullptr);

}  // namespace slim_init
