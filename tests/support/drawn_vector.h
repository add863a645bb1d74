// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// Three numbers of `draw`, the last component first. The arguments of a call have no order that
/// all compilers share, so that Vector3d(draw(), draw(), draw()) is another vector with each of
/// them.
template <typename Draw>
Eigen::Vector3d drawnVector(Draw&& draw) {
  const double z = draw(), y = draw(), x = draw();
  return Eigen::Vector3d(x, y, z);
}

}  // namespace slim_init
