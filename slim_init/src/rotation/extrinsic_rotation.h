// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Extrinsic rotation from nothing: the rotations that the points of neighbouring keyframes see
// against those that the gyroscope measures (hand-eye calibration of the rotation,
// docs/derivation.md, 6.2).
#pragma once

#include <Eigen/Core>
#include <string>

#include "slim_init/init_window.h"

namespace slim_init {

/// A first extrinsic rotation, with bias of the gyroscope and td unknown.
struct ExtrinsicRotation {
  Eigen::Matrix3d R_b_c = Eigen::Matrix3d::Identity();
  /// Not empty where the motion does not determine it to kMaxHandEyeSigmaDeg: what is missing, and
  /// about which axis the rig has to turn.
  std::string message;
};

/// From consecutive keyframes, whatever the calibration of the window says about R_b_c: the
/// rotations that the points of a pair see (relativeRotation()), and the extrinsic rotation that
/// most pairs agree with. estimateRotations() goes on with it.
ExtrinsicRotation estimateExtrinsicRotation(const InitWindow& window);

}  // namespace slim_init
