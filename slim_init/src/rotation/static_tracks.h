// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Points that are no part of the scene because they turn with the camera: parts of the vehicle in
// view, drops and dirt on the lens. Where rotation flow is parallel to an epipolar line, a point
// that lacks it has the image motion of some scene point, so that epipolar residuals do not find
// them (docs/derivation.md, 1.3).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "slim_init/init_window.h"

namespace slim_init {

/// One entry per point track of `window`, nonzero where no observation is further than
/// kOutlierSigmas standard deviations of a bearing from their mean, although the rotation of the
/// camera at `gyro_bias` [rad/s] alone moves a far point by more than kTurnedSigmas after the first
/// one. All zero where more than kMaxStaticFraction of the tracks are such: then it is the rotation
/// that is wrong. Rows of a rolling shutter must not be compensated.
std::vector<char> staticTracks(const InitWindow& window, const Eigen::Vector3d& gyro_bias);

/// The window without staticTracks(), and their number in `static_tracks`. Null, and zero, where
/// they are less than kMinStaticFraction of all: robust weights bear with these, and a scene has
/// some too.
std::shared_ptr<const InitWindow> withoutStaticTracks(const InitWindow& window,
                                                      const Eigen::Vector3d& gyro_bias,
                                                      int* static_tracks);

}  // namespace slim_init
