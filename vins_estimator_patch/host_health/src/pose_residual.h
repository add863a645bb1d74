// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The residual of the innovation test, for its Jacobian test.
#pragma once

#include <Eigen/Core>

#include "slim_init/types.h"
#include "track_place.h"

namespace slim_init::host_health {

/// A track of the newest frame with a known place.
struct PoseTrack {
  FeatureId id = -1;
  TrackPlace place;
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();  ///< in c
  Eigen::Matrix<double, 3, 2> basis;                   ///< tangentOf(bearing)
};

/// Residual of a track at a pose of the body.
struct PoseResidual {
  Eigen::Vector2d r = Eigen::Vector2d::Zero();  ///< [rad]
  Eigen::Matrix<double, 2, 6> J;                ///< by errors [theta, p] of the body in the world
  Eigen::Matrix2d information;                  ///< inverse covariance of pixel and place
  double inverse_depth = 0.0;                   ///< with this observation [1/m]
};

/// False if the place is behind the camera. `sigma` of a bearing [rad].
bool poseResidual(const PoseTrack& track, const CameraPose& camera, double sigma,
                  PoseResidual* residual);

}  // namespace slim_init::host_health
