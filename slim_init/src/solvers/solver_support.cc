// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "solvers/solver_support.h"

#include <sstream>

#include "slim_init/options.h"

namespace slim_init {

InitResult startResult(const InitWindow& window) {
  InitResult result;
  result.counts.keyframes = window.size();
  result.counts.point_tracks = static_cast<int>(window.pointTracks().size());
  result.counts.point_observations = static_cast<int>(window.pointSightings().size());
  result.counts.line_tracks = static_cast<int>(window.lineTracks().size());
  result.counts.line_observations = static_cast<int>(window.lineSightings().size());
  return result;
}

void fail(InitStatus status, const std::string& message, InitResult* result) {
  result->status = status;
  result->message = message;
}

std::vector<Eigen::Matrix3d> cameraRotations(const std::vector<Eigen::Matrix3d>& R_b0_bk,
                                             const Eigen::Matrix3d& R_b_c) {
  std::vector<Eigen::Matrix3d> R_c0_ck;
  R_c0_ck.reserve(R_b0_bk.size());
  for (const Eigen::Matrix3d& R : R_b0_bk) R_c0_ck.push_back(R_b_c.transpose() * R * R_b_c);
  return R_c0_ck;
}

bool hasEnoughKeyframes(const InitWindow& window, InitResult* result) {
  if (window.size() >= kMinKeyframes) return true;
  std::ostringstream message;
  message << "window holds " << window.size() << " keyframes, needs " << kMinKeyframes;
  fail(InitStatus::kTooFewKeyframes, message.str(), result);
  return false;
}

void keepObservable(const std::vector<Preintegration>& pre,
                    const std::vector<Eigen::Matrix3d>& R_b0_bk, double gravity_magnitude,
                    InitResult* result) {
  const InitStatus status = result->status;
  if (status != InitStatus::kStationary && status != InitStatus::kPureRotation) return;
  result->states.clear();
  result->scale = kNotComputed;
  result->scale_sigma = kNotComputed;
  result->gravity_w.setConstant(kNotComputed);
  result->gravity_b0.setConstant(kNotComputed);
  result->accel_bias.setConstant(kNotComputed);
  if (status == InitStatus::kPureRotation) return;
  // At rest the mean specific force is minus gravity.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < pre.size(); ++i) force += R_b0_bk[i] * pre[i].dv;
  result->gravity_b0 = -gravity_magnitude * force.normalized();
  result->gravity_w = Eigen::Vector3d(0.0, 0.0, -gravity_magnitude);
}

}  // namespace slim_init
