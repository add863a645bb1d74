// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation_prior.h"

#include "geometry/so3.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

Eigen::Vector3d RowExposure::atMiddleRow(const Eigen::Vector3d& bearing, double v,
                                         int height) const {
  if (!(readout_s > 0.0)) return bearing;
  return expSO3(rowTime(v, height, readout_s) * rate_c) * bearing;
}

Eigen::Vector3d RowExposure::atRow(const Eigen::Vector3d& bearing, double v, int height) const {
  if (!(readout_s > 0.0)) return bearing;
  return expSO3(-rowTime(v, height, readout_s) * rate_c) * bearing;
}

}  // namespace slim_init::feature_tracker_lines
