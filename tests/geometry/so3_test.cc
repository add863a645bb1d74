// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/so3.h"

#include <gtest/gtest.h>

#include <vector>

#include "reference_so3.h"
#include "support/jacobian_check.h"

namespace slim_init {
namespace {

constexpr double kExact = 1e-14;       // one rotation composed of a few roundings
constexpr double kDifferences = 1e-7;  // central differences with step 1e-6

// Zero, tiny, at the seam of the series (|theta| = 0.1), moderate, near pi.
std::vector<Eigen::Vector3d> interestingVectors() {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.8, 0.5).normalized();
  std::vector<Eigen::Vector3d> out = {Eigen::Vector3d::Zero()};
  for (double angle :
       {1e-200, 1e-12, 1e-8, 1e-4, 0.0999999, 0.1000001, 1.0, 2.5, 3.1, M_PI - 1e-6}) {
    out.push_back(angle * axis);
    out.push_back(-angle * Eigen::Vector3d::UnitZ());
  }
  return out;
}

TEST(So3, SkewIsTheCrossProduct) {
  const Eigen::Vector3d a(1, 2, 3), b(-2, 0.5, 4);
  EXPECT_EQ((skew(a) * b - a.cross(b)).norm(), 0.0);
}

TEST(So3, ExpAgreesWithAngleAxis) {
  for (const Eigen::Vector3d& theta : interestingVectors()) {
    const double angle = theta.norm();
    const Eigen::Vector3d axis =
        angle > 0 ? Eigen::Vector3d(theta / angle) : Eigen::Vector3d::UnitX();
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    EXPECT_LT((expSO3(theta) - expected).norm(), kExact) << theta.transpose();
  }
}

// What simulation and evaluation use in place of the core's own, so that the truth does not share
// its mistakes.
TEST(So3, TheReferenceAgrees) {
  for (const Eigen::Vector3d& theta : interestingVectors()) {
    const Eigen::Matrix3d R = expSO3(theta);
    EXPECT_LT((reference::expSo3(theta) - R).norm(), kExact) << theta.transpose();
    const double tolerance = theta.norm() > 3.0 ? 1e-8 : 1e-14;
    EXPECT_LT((reference::logSo3(R) - theta).norm(), tolerance) << theta.transpose();
    EXPECT_LT((reference::rightJacobianSo3(theta) - rightJacobian(theta)).norm(), 1e-12)
        << theta.transpose();
    EXPECT_EQ(reference::skew(theta), skew(theta));
  }
}

TEST(So3, LogInvertsExp) {
  for (const Eigen::Vector3d& theta : interestingVectors()) {
    // Near pi the rotation matrix determines the vector to sqrt(eps) only.
    const double tolerance = theta.norm() > 3.0 ? 1e-8 : 1e-14;
    EXPECT_LT((logSO3(expSO3(theta)) - theta).norm(), tolerance) << theta.transpose();
  }
}

TEST(So3, LogAtPiReturnsOneOfTheTwoAxes) {
  const Eigen::Matrix3d R = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Vector3d theta = logSO3(R);
  EXPECT_NEAR(theta.norm(), M_PI, kExact);
  EXPECT_NEAR(std::abs(theta.x()), M_PI, kExact);
}

TEST(So3, RightJacobianAgreesWithDifferences) {
  for (const Eigen::Vector3d& theta : interestingVectors()) {
    const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return logSO3(expSO3(theta).transpose() * expSO3(theta + d));
    };
    EXPECT_TRUE(jacobiansAgree(rightJacobian(theta), numericJacobian(f, 3, 1e-6), kDifferences))
        << theta.transpose();
  }
}

TEST(So3, RightJacobianInverseIsTheInverse) {
  for (const Eigen::Vector3d& theta : interestingVectors()) {
    const Eigen::Matrix3d product = rightJacobian(theta) * rightJacobianInverse(theta);
    EXPECT_LT((product - Eigen::Matrix3d::Identity()).norm(), 1e-12) << theta.transpose();
  }
}

TEST(So3, TangentBasisIsOrthonormal) {
  for (const Eigen::Vector3d& v : interestingVectors()) {
    const Eigen::Vector3d u = (v + Eigen::Vector3d(1, 0.2, 0)).normalized();
    const Eigen::Matrix<double, 3, 2> B = tangentBasis(u);
    EXPECT_LT((B.transpose() * B - Eigen::Matrix2d::Identity()).norm(), kExact);
    EXPECT_LT((B.transpose() * u).norm(), kExact);
  }
}

TEST(So3, NearestRotationKeepsRotationsAndRepairsRoundedOnes) {
  const Eigen::Matrix3d R = expSO3({0.3, -0.2, 1.1});
  EXPECT_LT((nearestRotation(R) - R).norm(), kExact);
  const Eigen::Matrix3d rounded = (R * 1e3).array().round() / 1e3;
  const Eigen::Matrix3d repaired = nearestRotation(rounded);
  EXPECT_LT((repaired.transpose() * repaired - Eigen::Matrix3d::Identity()).norm(), kExact);
  EXPECT_NEAR(repaired.determinant(), 1.0, kExact);
  EXPECT_LT((repaired - R).norm(), 3e-3);
}

TEST(So3, GravityAlignedAttitudePutsGravityDownAndYawToZero) {
  for (const Eigen::Vector3d& gravity_b :
       {Eigen::Vector3d(0, 0, -9.8), Eigen::Vector3d(1, 2, -9), Eigen::Vector3d(-9.5, 0.1, 2),
        Eigen::Vector3d(9.8, 0, 0), Eigen::Vector3d(-9.8, 0, 0)}) {
    const Eigen::Matrix3d R_w_b = gravityAlignedAttitude(gravity_b);
    EXPECT_LT((R_w_b * gravity_b.normalized() + Eigen::Vector3d::UnitZ()).norm(), kExact);
    EXPECT_NEAR(R_w_b.determinant(), 1.0, kExact);
    if (std::abs(gravity_b.x()) == 9.8) continue;  // a vertical x axis has no yaw
    EXPECT_NEAR(std::atan2(R_w_b(1, 0), R_w_b(0, 0)), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace slim_init
