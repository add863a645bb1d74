// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "track_place.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace slim_init::host_health {
namespace {

// Inverse depth of a point of which nothing is known [1/m].
constexpr double kInverseDepth = 0.3;
constexpr double kInverseDepthSigma = 1.0;
// Steps of Gauss-Newton from the linear depth, which is that of exact bearings.
constexpr int kIterations = 1;
// Cosine of the largest angle between what is expected and what is seen.
constexpr double kLeastCosine = 0.17;

// Cross products of ray and bearing are linear in the inverse depth.
double linearInverseDepth(const std::vector<TrackView>& views, const TrackPlace& place) {
  double ab = kInverseDepth * 1e-6, bb = 1e-6;
  for (std::size_t i = 0; i + 1 < views.size(); ++i) {
    const Eigen::Vector3d seen = views[i].camera->R_w_c * views[i].bearing;
    const Eigen::Vector3d a = seen.cross(place.direction);
    const Eigen::Vector3d b = seen.cross(place.origin - views[i].camera->p_w_c);
    ab -= a.dot(b);
    bb += b.squaredNorm();
  }
  return ab / bb;
}

}  // namespace

CameraPose cameraOf(const NavState& state, const Calibration& calibration) {
  const Eigen::Vector3d arm = state.R_w_b * calibration.t_b_c;
  return {state.R_w_b * calibration.R_b_c, state.p_w_b + arm, arm};
}

const FrameObservation* frameAt(const std::vector<FrameObservation>& frames, double t) {
  for (const FrameObservation& frame : frames) {
    if (std::abs(frame.t - t) < kSameTime) return &frame;
  }
  return nullptr;
}

Eigen::Matrix<double, 3, 2> tangentOf(const Eigen::Vector3d& direction) {
  Eigen::Index smallest = 0;
  direction.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = direction.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  basis.col(1) = direction.cross(basis.col(0));
  return basis;
}

bool residualOf(const TrackPlace& place, const CameraPose& camera, const Eigen::Vector3d& bearing,
                const Eigen::Matrix<double, 3, 2>& basis, PlaceResidual* residual) {
  const Eigen::Vector3d baseline = place.origin - camera.p_w_c;
  residual->ray = place.direction + place.inverse_depth * baseline;
  const Eigen::Vector3d expected = camera.R_w_c.transpose() * residual->ray;
  const double along = bearing.dot(expected);
  if (!(along > kLeastCosine * expected.norm())) return false;
  residual->r = basis.transpose() * expected / along;
  residual->by_expected =
      (basis.transpose() - residual->r * bearing.transpose()) * camera.R_w_c.transpose() / along;
  residual->by_place.leftCols<2>() = residual->by_expected * place.tangent;
  residual->by_place.col(2) = residual->by_expected * baseline;
  return true;
}

bool findPlace(const std::vector<TrackView>& views, double sigma, double sigma_position,
               TrackPlace* place) {
  if (views.size() < 2) return false;
  const TrackView& newest = views.back();
  place->origin = newest.camera->p_w_c;
  place->direction = newest.camera->R_w_c * newest.bearing;
  place->tangent = tangentOf(place->direction);
  place->inverse_depth = linearInverseDepth(views, *place);
  const double moved = sigma_position * place->inverse_depth;
  const double weight = 1.0 / (sigma * sigma + moved * moved);
  const double depth_weight = 1.0 / (kInverseDepthSigma * kInverseDepthSigma);
  std::vector<Eigen::Matrix<double, 3, 2>> bases;
  bases.reserve(views.size());
  for (const TrackView& view : views) bases.push_back(tangentOf(view.bearing));
  PlaceResidual residual;
  Eigen::Matrix3d H;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    H.setZero();
    H(2, 2) = depth_weight;
    Eigen::Vector3d g(0.0, 0.0, depth_weight * (place->inverse_depth - kInverseDepth));
    place->chi_square = 0.0;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (!residualOf(*place, *views[i].camera, views[i].bearing, bases[i], &residual)) {
        return false;
      }
      const Eigen::Matrix<double, 3, 2> J = weight * residual.by_place.transpose();
      H.noalias() += J * residual.by_place;
      g.noalias() += J * residual.r;
      place->chi_square += weight * residual.r.squaredNorm();
    }
    if (iteration == kIterations) break;
    const Eigen::Vector3d step = H.ldlt().solve(g);
    place->direction -= place->tangent * step.head<2>();
    place->inverse_depth -= step.z();
  }
  place->dof = 2 * static_cast<int>(views.size()) - 3;
  place->covariance = H.inverse();
  return place->covariance.allFinite();
}

}  // namespace slim_init::host_health
