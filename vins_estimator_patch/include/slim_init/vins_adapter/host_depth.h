// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Depths of a host's features from all their views. VINS-Fusion triangulates a feature from its
// first two images alone. At the start these are a tenth of a second apart: depths are then noise,
// and its first optimization, which has no prior yet, moves poses that were right to fit them.
// Compiled into the host, hence C++11.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace slim_init {
namespace vins_adapter {

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
