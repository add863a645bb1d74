// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The walls around a path, for worlds of features and scenes of pictures alike.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slim_init/simulation/world.h"

namespace slim_init::simulation {

/// Smallest box around the finite places of a path; a box without size at zero if there are none.
Box boundsOf(const std::vector<Eigen::Vector3d>& path_w);

/// The box with all its sides moved outwards [m].
Box grown(const Box& box, double by);

/// Axis of the longest horizontal extent; x, which the built-in motions face, where the extents are
/// much the same.
int longAxis(const Box& box);

/// The natural size of a "corridor", a "hall" or, by any other name, a room around the middle of
/// the path, grown so that the path keeps 0.5 m (corridor) or 1 m from every wall. A corridor is as
/// long as the path and some metres more at each end.
Box makeHull(const std::string& kind, const Box& path);

}  // namespace slim_init::simulation
