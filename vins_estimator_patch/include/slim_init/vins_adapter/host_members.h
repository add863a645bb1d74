// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Members that only some hosts of the VINS family have. Each function does something where the
// member is there and compiles to nothing where it is not; C++11, as host_glue.h.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace slim_init {
namespace vins_adapter {
namespace glue_detail {

// Each has an overload for any arguments, which is the worse match: it is taken where the return
// type of the other does not exist.

/// The time offset between camera and IMU [s]; PL-VINS takes it as zero and has no member.
template <typename Estimator>
auto setTd(Estimator& e, double td) -> decltype(e.td = td, void()) {
  e.td = td;
}
template <typename... Any>
void setTd(const Any&...) {}

/// LVI-SAM: a depth from the lidar is held constant, a triangulated one must not be.
template <typename Feature>
auto forgetLidarDepth(Feature& feature) -> decltype(feature.lidar_depth_flag = false, void()) {
  feature.lidar_depth_flag = false;
}
template <typename... Any>
void forgetLidarDepth(const Any&...) {}

/// DynaVINS: weights found with the old poses say which features moved relative to those.
template <typename Feature>
auto forgetWeight(Feature& feature)
    -> decltype(feature.weight = 1.0, feature.weightNum = 1, void()) {
  feature.weight = 1.0;
  feature.weightNum = 1;
}
template <typename... Any>
void forgetWeight(const Any&...) {}

/// PL-VINS: its lines are in the old world frame; it triangulates those that have no position.
template <typename FeatureManager>
auto forgetLines(FeatureManager& manager)
    -> decltype(manager.linefeature.begin()->is_triangulation = false, void()) {
  for (auto& line : manager.linefeature) line.is_triangulation = false;
}
template <typename... Any>
void forgetLines(const Any&...) {}

/// GVINS: its first optimization holds the first pose by a factor, later ones by the prior, which
/// is gone. True for a host of this kind: it never turns its window back, so that its prior has to
/// hold position and heading as well.
template <typename Estimator>
auto anchorAgain(Estimator& e) -> decltype(e.first_optimization = true, bool()) {
  return e.first_optimization = true;
}
template <typename... Any>
bool anchorAgain(const Any&...) {
  return false;
}

/// The factor that a marginalisation leaves behind, about the first frame: pose and
/// [V, Ba, Bg] as the host's parameter blocks have them. `root` is HostWindow::prior, the states of
/// the window are in place. Without it the host's first optimization has nothing but its own images
/// and inflated IMU noise to hold the scale with. With `anchored` position and heading are held
/// too: GVINS takes its own factor on the first pose into the next prior only where there is no
/// prior yet, and with this one there is.
template <typename Estimator>
auto setPrior(Estimator& e, const std::vector<double>& root, bool anchored)
    -> decltype(e.last_marginalization_info->keep_block_data,
                e.last_marginalization_info->linearized_residuals, e.para_Pose[0][0],
                e.para_SpeedBias[0][0], void()) {
  typedef typename std::remove_pointer<
      typename std::remove_reference<decltype(e.last_marginalization_info)>::type>::type Info;
  constexpr int kColumns = 15, kPose = 7, kMotion = 9, kPoseErrors = 6, kFree = 4;
  constexpr double kAnchor = 120.0;  // [1/m], [1/rad]: of GVINS' own factor
  typedef Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor> Root;
  const int rows = static_cast<int>(root.size()) / kColumns;
  if (rows == 0) return;
  const Eigen::Quaterniond q(Eigen::Matrix3d(e.Rs[0]));
  // The host deletes them with the factor.
  double* const pose = new double[kPose];
  double* const motion = new double[kMotion];
  Eigen::Map<Eigen::Matrix<double, kPose, 1>>(pose) << e.Ps[0], q.coeffs();
  Eigen::Map<Eigen::Matrix<double, kMotion, 1>>(motion) << e.Vs[0], e.Bas[0], e.Bgs[0];
  Info* const info = new Info;
  info->m = 0;
  info->n = kColumns;
  info->parameter_block_data[reinterpret_cast<long>(&e.para_Pose[0][0])] = pose;
  info->parameter_block_data[reinterpret_cast<long>(&e.para_SpeedBias[0][0])] = motion;
  info->keep_block_size.push_back(kPose);
  info->keep_block_size.push_back(kMotion);
  info->keep_block_idx.push_back(0);
  info->keep_block_idx.push_back(kPoseErrors);
  info->keep_block_data.push_back(pose);
  info->keep_block_data.push_back(motion);
  info->linearized_jacobians.setZero(kColumns, kColumns);
  info->linearized_residuals.setZero(kColumns);
  info->linearized_jacobians.topRows(rows) = Eigen::Map<const Root>(root.data(), rows, kColumns);
  if (anchored && rows + kFree <= kColumns) {
    for (int i = 0; i < 3; ++i) {
      info->linearized_jacobians(rows + i, i) = kAnchor;
      // Heading: a turn about the vertical, of a rotation error to the right of R.
      info->linearized_jacobians(rows + 3, 3 + i) = kAnchor * e.Rs[0](2, i);
    }
  }
  if (e.last_marginalization_info != nullptr) delete e.last_marginalization_info;
  e.last_marginalization_info = info;
  e.last_marginalization_parameter_blocks.clear();
  e.last_marginalization_parameter_blocks.push_back(&e.para_Pose[0][0]);
  e.last_marginalization_parameter_blocks.push_back(&e.para_SpeedBias[0][0]);
}
template <typename... Any>
void setPrior(const Any&...) {}

}  // namespace glue_detail

// Depths of a host's features from all their views. VINS-Fusion triangulates a feature from its
// first two images alone. At the start these are a tenth of a second apart: depths are then noise,
// and its first optimization, which has no prior yet, moves poses that were right to fit them.

/// One view of a point: pose of the camera (camera to world, centre in the world) and the image in
/// the plane z = 1.
struct DepthView {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  Eigen::Vector3d ray = Eigen::Vector3d::UnitZ();
};

/// Depth along z in the first camera for which the point is seen best in all views, with the ray of
/// the first view as it is, which is how these hosts keep their features. Where the views do not
/// bound it, or put the point behind the camera, kFarDepth; with less than two views -1.
constexpr double kFarDepth = 100.0;
inline double depthFromAllViews(const std::vector<DepthView>& views) {
  if (views.size() < 2) return -1.0;
  // In view j the point is at a_j + l b_j, with the inverse depth l. First the l that makes these
  // parallel to the rays, then steps on the distances in the image.
  std::vector<Eigen::Vector3d> a, b;
  double numerator = 0.0, denominator = 0.0;
  for (std::size_t j = 1; j < views.size(); ++j) {
    a.push_back(views[j].R.transpose() * (views[0].R * views[0].ray));
    b.push_back(views[j].R.transpose() * (views[0].t - views[j].t));
    const Eigen::Vector3d across_a = views[j].ray.cross(a.back());
    const Eigen::Vector3d across_b = views[j].ray.cross(b.back());
    numerator -= across_a.dot(across_b);
    denominator += across_b.dot(across_b);
  }
  const double least = 1.0 / kFarDepth;
  if (!(denominator > 0.0)) return kFarDepth;
  double inverse = std::fmax(numerator / denominator, least);
  for (int step = 0; step < 5; ++step) {
    double gradient = 0.0, curvature = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) {
      const Eigen::Vector3d p = a[j] + inverse * b[j];
      if (!(p.z() > 1e-3)) continue;
      for (int i = 0; i < 2; ++i) {
        const double residual = p(i) / p.z() - views[j + 1].ray(i) / views[j + 1].ray.z();
        const double slope = (b[j](i) - p(i) / p.z() * b[j].z()) / p.z();
        gradient += slope * residual;
        curvature += slope * slope;
      }
    }
    if (!(curvature > 0.0)) break;
    inverse = std::fmax(inverse - gradient / curvature, least);
  }
  return 1.0 / inverse;
}

/// Sets the depth of every feature of the host that is seen in two images or more, from the poses
/// that are in its window.
template <typename Estimator>
void fillDepths(Estimator& e) {
  for (auto& feature : e.f_manager.feature) {
    std::vector<DepthView> views;
    int i = feature.start_frame;
    for (const auto& seen : feature.feature_per_frame) {
      DepthView view;
      view.R = e.Rs[i] * e.ric[0];
      view.t = e.Ps[i] + e.Rs[i] * e.tic[0];
      view.ray = seen.point;
      views.push_back(view);
      ++i;
    }
    feature.estimated_depth = depthFromAllViews(views);
  }
}

}  // namespace vins_adapter
}  // namespace slim_init
