// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Maximum-likelihood refinement of OpenVINS' dynamic initializer: keyframe states with biases at
// every keyframe, and points, by Ceres.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu/preintegration.h"
#include "slim_init/baselines/baselines.h"
#include "slim_init/init_window.h"

namespace slim_init::baselines {

/// A track with its point in the world.
struct MappedTrack {
  int track = 0;  ///< index into InitWindow::pointTracks()
  Eigen::Vector3d point_w = Eigen::Vector3d::Zero();
};

struct InertialAdjustment {
  bool converged = false;
  double first_cost = 0.0;
  double cost = 0.0;
};

/// Minimises, from `states` and `points`, over the states of all keyframes (own biases each) and
/// the points in the world (gravity (0, 0, -g)),
///   IMU factors with bias random walk, reprojection / sigma with a Cauchy loss,
///   priors on the first yaw and position (gauge) and on the first biases about zero.
/// `pre`: one per consecutive pair, with covariance; the biases enter to first order about it.
InertialAdjustment adjustInertial(const InitWindow& window, const std::vector<Preintegration>& pre,
                                  const OpenVinsOptions& options, std::vector<NavState>* states,
                                  std::vector<MappedTrack>* points);

}  // namespace slim_init::baselines
