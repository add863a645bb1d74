// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rotations and unit vectors. Perturbations on the right: R * Exp(theta) (docs/notation.md).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace slim_init {

/// Matrix of the cross product: skew(a) * b = a x b.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

namespace internal {

/// Coefficients of Exp and the right Jacobian for the squared angle t = |theta|^2:
/// a = sin(|theta|)/|theta|, b = (1-cos)/t, c = (|theta|-sin)/|theta|^3.
struct Rodrigues {
  explicit Rodrigues(double t) {
    // IMU steps turn by less than 0.1 rad, where these series are exact to rounding (the first
    // dropped term is below t^5/11! = 3e-18) and much cheaper than sin and cos.
    if (t < 0.01) {
      a = 1.0 - t / 6.0 * (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0)));
      b = 0.5 * (1.0 - t / 12.0 * (1.0 - t / 30.0 * (1.0 - t / 56.0 * (1.0 - t / 90.0))));
      c = 1.0 / 6.0 * (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0))));
    } else {
      const double angle = std::sqrt(t);
      a = std::sin(angle) / angle;
      const double half = std::sin(0.5 * angle);
      b = 2.0 * half * half / t;
      c = (1.0 - a) / t;
    }
  }
  double a, b, c;
};

}  // namespace internal

/// Exponential map of SO(3): rotation by the vector theta [rad].
inline Eigen::Matrix3d expSO3(const Eigen::Vector3d& theta) {
  const internal::Rodrigues k(theta.squaredNorm());
  const Eigen::Matrix3d K = skew(theta);
  return Eigen::Matrix3d::Identity() + k.a * K + k.b * (K * K);
}

/// Right Jacobian: Exp(theta + d) = Exp(theta) Exp(Jr(theta) d) to first order in d.
inline Eigen::Matrix3d rightJacobian(const Eigen::Vector3d& theta) {
  const internal::Rodrigues k(theta.squaredNorm());
  const Eigen::Matrix3d K = skew(theta);
  return Eigen::Matrix3d::Identity() - k.b * K + k.c * (K * K);
}

/// Rotation vector of R [rad], norm in [0, pi]. At pi either of the two axes may come back.
inline Eigen::Vector3d logSO3(const Eigen::Matrix3d& R) {
  // Through the quaternion: well conditioned at 0 and at pi, where acos of the trace is not.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  const double sin_half = q.vec().norm();
  if (sin_half < 1e-12) return 2.0 * q.vec();
  return 2.0 * std::atan2(sin_half, q.w()) / sin_half * q.vec();
}

/// Inverse of rightJacobian(); |theta| < 2 pi.
inline Eigen::Matrix3d rightJacobianInverse(const Eigen::Vector3d& theta) {
  const double t = theta.squaredNorm();
  const Eigen::Matrix3d K = skew(theta);
  double c = 1.0 / 12.0 * (1.0 + t / 60.0 * (1.0 + t / 42.0));
  if (t >= 1e-4) {
    const double angle = std::sqrt(t);
    c = 1.0 / t - 0.5 / (angle * std::tan(0.5 * angle));
  }
  return Eigen::Matrix3d::Identity() + 0.5 * K + c * (K * K);
}

/// How far A is from a rotation: |A^T A - I| + |det A - 1|.
double distanceFromRotation(const Eigen::Matrix3d& A);
/// Largest one of a matrix that counts as a rotation: typed with few digits.
inline constexpr double kRotationTolerance = 1e-3;

/// Nearest rotation (polar decomposition by the SVD); for calibration typed with few digits.
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& A);

/// Orthonormal basis (3x2) of the plane at right angles to the unit vector u.
inline Eigen::Matrix<double, 3, 2> tangentBasis(const Eigen::Vector3d& u) {
  const Eigen::Vector3d axis =
      std::abs(u.x()) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = u.cross(axis).normalized();
  B.col(1) = u.cross(B.col(0));
  return B;
}

/// Attitude R_w_b that turns the measured gravity direction (in b, pointing down) to -z of w, with
/// the x axis of b at zero yaw. When that axis is vertical, the y axis is put at 90 deg instead.
Eigen::Matrix3d gravityAlignedAttitude(const Eigen::Vector3d& gravity_b);

}  // namespace slim_init
