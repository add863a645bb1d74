// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotation vectors for what makes the truth (simulation) and what judges by it (evaluation). Not
// the core's geometry/so3.h on purpose: a mistake there would be in the truth as well, and nobody
// would see it. tests/geometry holds the two against each other. Neither of the two libraries may
// include the other, so this header has a folder of its own; it is not installed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace slim_init::reference {

/// Matrix of the cross product: skew(a) * b = a x b.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

/// Rotation of angle |phi| [rad] about phi.
inline Eigen::Matrix3d expSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + skew(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

/// Rotation vector of R [rad], angle in [0, pi].
inline Eigen::Vector3d logSo3(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

/// Right Jacobian: Exp(phi + d) = Exp(phi) Exp(J d) to first order in d.
inline Eigen::Matrix3d rightJacobianSo3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double angle2 = angle * angle;
  // Below this angle the series is exact to machine precision, the closed form is not.
  constexpr double kSmallAngle = 1e-3;
  double first = 0.5 - angle2 / 24.0, second = 1.0 / 6.0 - angle2 / 120.0;
  if (angle >= kSmallAngle) {
    first = (1.0 - std::cos(angle)) / angle2;
    second = (angle - std::sin(angle)) / (angle2 * angle);
  }
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() - first * K + second * K * K;
}

}  // namespace slim_init::reference
