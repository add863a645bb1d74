// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rolling shutter: bearings turned to the instant of the middle row by the gyroscope.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "slim_init/init_window.h"

namespace slim_init {

/// The window with every bearing turned from the exposure of its own row to the time of its
/// keyframe, by the gyroscope at `gyro_bias` [rad/s]: what the camera would have seen of points far
/// away. What is left of the rows is the translation of the camera in between (at most speed times
/// half the readout time). The rows stay, so that the estimation can take it into account.
/// Null with a global shutter: the window is right as it is.
std::shared_ptr<const InitWindow> withRowsCompensated(const InitWindow& window,
                                                      const Eigen::Vector3d& gyro_bias);

}  // namespace slim_init
