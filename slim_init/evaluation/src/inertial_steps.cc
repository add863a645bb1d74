// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "inertial_steps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace slim_init::evaluation {
namespace {

// Below this angle the series is exact to double precision.
constexpr double kSmallAngle = 1e-5;

Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

ImuSample interpolate(const ImuSample& a, const ImuSample& b, double t) {
  const double u = (t - a.t) / (b.t - a.t);
  ImuSample sample;
  sample.t = t;
  sample.gyro = (1.0 - u) * a.gyro + u * b.gyro;
  sample.accel = (1.0 - u) * a.accel + u * b.accel;
  return sample;
}

}  // namespace

bool inertialSteps(const std::vector<ImuSample>& imu, double t0, double t1, double max_gap_s,
                   std::vector<InertialStep>* steps) {
  steps->clear();
  if (imu.size() < 2 || !(t0 < t1) || t0 < imu.front().t || t1 > imu.back().t) return false;
  // The first sample after t0; there is one before it because imu covers t0.
  auto next = std::upper_bound(imu.begin(), imu.end(), t0,
                               [](double t, const ImuSample& sample) { return t < sample.t; });
  if (next == imu.begin() || next == imu.end()) return false;
  ImuSample from = interpolate(*std::prev(next), *next, t0);
  for (;; ++next) {
    if (next->t - std::prev(next)->t > max_gap_s) return false;
    const bool last = next->t >= t1;
    const ImuSample to = last ? interpolate(*std::prev(next), *next, t1) : *next;
    steps->push_back({to.t - from.t, 0.5 * (from.gyro + to.gyro), 0.5 * (from.accel + to.accel)});
    if (last) return true;
    from = to;
  }
}

Eigen::Matrix3d expSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + hat(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

Eigen::Vector3d logSo3(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

Eigen::Matrix3d rightJacobianSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  if (angle < kSmallAngle) return Eigen::Matrix3d::Identity() - 0.5 * W + W * W / 6.0;
  const double angle2 = angle * angle;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / angle2 * W +
         (angle - std::sin(angle)) / (angle2 * angle) * W * W;
}

}  // namespace slim_init::evaluation
