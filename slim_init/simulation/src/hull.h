// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The walls around a path, for worlds of features and scenes of pictures alike.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "slim_init/simulation/world.h"

namespace slim_init::simulation {

/// Smallest box around the finite places of a path; a box without size at zero if there are none.
Box boundsOf(const std::vector<Eigen::Vector3d>& path_w);

/// Axis of the longest horizontal extent; x, which the built-in motions face, where the extents are
/// much the same.
int longAxis(const Box& box);

/// The natural size around the middle of the path, grown so that the path keeps `path_margin` [m]
/// from every wall. A corridor is as long as the path and some metres more at each end; of its
/// `half_size` only the y component counts, which is half its width.
Box makeHull(bool corridor, const Eigen::Vector3d& half_size, double path_margin, const Box& path);

}  // namespace slim_init::simulation
