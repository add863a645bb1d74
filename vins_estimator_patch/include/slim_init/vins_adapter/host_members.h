// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Members that only some hosts of the VINS family have. Each function does something where the
// member is there and compiles to nothing where it is not; C++11, as host_glue.h.
#pragma once

namespace slim_init {
namespace vins_adapter {
namespace glue_detail {

/// An argument of value 0 is an int first and a long second: the overload that takes an int is
/// taken where its return type exists.
typedef int IfThere;
typedef long Otherwise;

/// The time offset between camera and IMU [s]; PL-VINS takes it as zero and has no member.
template <typename Estimator>
auto setTd(Estimator& e, double td, IfThere) -> decltype(e.td = td, void()) {
  e.td = td;
}
template <typename Estimator>
void setTd(Estimator&, double, Otherwise) {}

/// LVI-SAM: a depth from the lidar is held constant, a triangulated one must not be.
template <typename Feature>
auto forgetLidarDepth(Feature& feature, IfThere)
    -> decltype(feature.lidar_depth_flag = false, void()) {
  feature.lidar_depth_flag = false;
}
template <typename Feature>
void forgetLidarDepth(Feature&, Otherwise) {}

/// DynaVINS: weights found with the old poses say which features moved relative to those.
template <typename Feature>
auto forgetWeight(Feature& feature, IfThere)
    -> decltype(feature.weight = 1.0, feature.weightNum = 1, void()) {
  feature.weight = 1.0;
  feature.weightNum = 1;
}
template <typename Feature>
void forgetWeight(Feature&, Otherwise) {}

/// PL-VINS: its lines are in the old world frame; it triangulates those that have no position.
template <typename FeatureManager>
auto forgetLines(FeatureManager& manager, IfThere)
    -> decltype(manager.linefeature.begin()->is_triangulation = false, void()) {
  for (auto& line : manager.linefeature) line.is_triangulation = false;
}
template <typename FeatureManager>
void forgetLines(FeatureManager&, Otherwise) {}

/// GVINS: its first optimization holds the first pose by a factor, later ones by the prior, which
/// is gone.
template <typename Estimator>
auto anchorAgain(Estimator& e, IfThere) -> decltype(e.first_optimization = true, void()) {
  e.first_optimization = true;
}
template <typename Estimator>
void anchorAgain(Estimator&, Otherwise) {}

}  // namespace glue_detail
}  // namespace vins_adapter
}  // namespace slim_init
