// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Triangulation of tracks between poses of a host: the only one of this library and the adapter.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::host_health {

/// Pose of a camera in the world.
struct CameraPose {
  Eigen::Matrix3d R_w_c = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_w_c = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();    ///< from the body to the camera, in w [m]
};

/// The camera of a body at `state`.
CameraPose cameraOf(const NavState& state, const Calibration& calibration);

/// Times of frames and states that are the same differ by no more [s].
constexpr double kSameTime = 1e-4;

/// The frame at `t` [s], or null.
const FrameObservation* frameAt(const std::vector<FrameObservation>& frames, double t);

/// Two unit vectors at right angles to the unit vector `direction` and to each other.
Eigen::Matrix<double, 3, 2> tangentOf(const Eigen::Vector3d& direction);

/// One observation of a track: a camera, and a unit bearing in it.
struct TrackView {
  const CameraPose* camera = nullptr;
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();
};

/// The place of a track: origin + (direction + tangent * offset) / inverse_depth. A point without
/// parallax has an inverse depth as well, with a large variance.
struct TrackPlace {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();      ///< camera of the newest view, in w [m]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< in w, of length one to 1e-3
  Eigen::Matrix<double, 3, 2> tangent;                   ///< in w
  double inverse_depth = 0.0;                            ///< [1/m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of offset [rad] and inverse depth
  double chi_square = 0.0;                               ///< of the views
  int dof = 0;                                           ///< its degrees of freedom
};

/// Finds the place of a track from two views or more, oldest first. `sigma` is the standard
/// deviation of a bearing [rad], `sigma_position` that of a camera's position [m]. The inverse
/// depth has a prior of 0.3 +- 1 1/m, which only matters without parallax. False for fewer views,
/// or if the place is behind a camera that saw it.
bool findPlace(const std::vector<TrackView>& views, double sigma, double sigma_position,
               TrackPlace* place);

/// Observation residual of a place in a camera: the tangent coordinates of the expected bearing at
/// the observed one.
struct PlaceResidual {
  Eigen::Vector2d r = Eigen::Vector2d::Zero();    ///< [rad]
  Eigen::Matrix<double, 2, 3> by_expected;        ///< of the ray, which is in w
  Eigen::Matrix<double, 2, 3> by_place;           ///< of offset and inverse depth
  Eigen::Vector3d ray = Eigen::Vector3d::Zero();  ///< from the camera, in w, scaled
};

/// The residual of `place` in `camera`, which saw it at `bearing` with `basis` =
/// tangentOf(bearing). False if the place is behind the camera or at more than 80 deg from the
/// bearing.
bool residualOf(const TrackPlace& place, const CameraPose& camera, const Eigen::Vector3d& bearing,
                const Eigen::Matrix<double, 3, 2>& basis, PlaceResidual* residual);

}  // namespace slim_init::host_health
