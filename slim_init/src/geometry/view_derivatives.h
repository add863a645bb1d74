// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// Derivatives of one view of a track: two residuals, whitened.
template <int D>
struct ViewDerivatives {
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 6> J_pose;  ///< against [theta_k, p_k]
  Eigen::Matrix<double, 2, D> J_track;
};

}  // namespace slim_init
