// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/gravity_constrained.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace slim_init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kG = 9.81007;

double cost(const Matrix3d& S, const Vector3d& m, const Vector3d& g) {
  return g.dot(S * g) - 2.0 * m.dot(g);
}

// Best cost on a fine grid of directions: the brute-force oracle.
double bruteForce(const Matrix3d& S, const Vector3d& m) {
  double best = std::numeric_limits<double>::infinity();
  const int n = 200000;
  for (int k = 0; k < n; ++k) {
    // Fibonacci sphere.
    const double z = 1.0 - (2.0 * k + 1.0) / n;
    const double angle = k * M_PI * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    best = std::min(best, cost(S, m, kG * Vector3d(r * std::cos(angle), r * std::sin(angle), z)));
  }
  return best;
}

TEST(MinimizeOnSphere, IsGlobalAgainstBruteForce) {
  std::srand(3);
  for (int trial = 0; trial < 20; ++trial) {
    Matrix3d A = Matrix3d::Random();
    if (trial % 4 == 0) A.col(2) = A.col(1);  // singular S
    const Matrix3d S = A * A.transpose();
    const Vector3d m = Vector3d::Random() * std::pow(10.0, trial % 5 - 2);
    const Vector3d g = minimizeOnSphere(S, m, kG);
    EXPECT_NEAR(g.norm(), kG, 1e-12);
    const double best = bruteForce(S, m);
    EXPECT_LE(cost(S, m, g), best + 1e-12 * std::abs(best));
    // The grid is about 0.006 rad fine, so it comes this near.
    EXPECT_NEAR(cost(S, m, g), best, 1e-3 * (S.norm() * kG * kG + m.norm() * kG));
  }
}

TEST(MinimizeOnSphere, UnconstrainedSolutionOnTheSphereIsKept) {
  const Matrix3d S = Vector3d(3, 2, 1).asDiagonal();
  const Vector3d g = kG * Vector3d(1, 2, 2) / 3.0;
  EXPECT_LT((minimizeOnSphere(S, S * g, kG) - g).norm(), 1e-12);
}

TEST(MinimizeOnSphere, HardCaseFillsTheWeakDirection) {
  // m has no part along the weakest axis and the rest is too short to reach the sphere.
  const Matrix3d S = Vector3d(1, 2, 3).asDiagonal();
  const Vector3d m(0.0, 1.0, 2.0);
  const Vector3d g = minimizeOnSphere(S, m, kG);
  EXPECT_NEAR(g.norm(), kG, 1e-12);
  EXPECT_NEAR(g.y(), 1.0, 1e-6);  // (2 - 1) g_y = 1
  EXPECT_NEAR(g.z(), 1.0, 1e-6);  // (3 - 1) g_z = 2
}

TEST(MinimizeOnSphere, IsotropicProblemPointsAlongTheRightHandSide) {
  const Vector3d m(0.3, -0.2, 0.1);
  const Vector3d g = minimizeOnSphere(Matrix3d::Identity(), m, kG);
  EXPECT_LT((g - kG * m.normalized()).norm(), 1e-12);
}

TEST(SolveGravityConstrained, RecoversAConsistentSystem) {
  std::srand(5);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(40, 10);
  Eigen::VectorXd truth = Eigen::VectorXd::Random(10);
  truth.tail<3>() *= kG / truth.tail<3>().norm();
  Eigen::VectorXd x;
  ASSERT_TRUE(solveGravityConstrained(A.transpose() * A, A.transpose() * (A * truth), kG, &x));
  EXPECT_LT((x - truth).norm(), 1e-11);
}

TEST(SolveGravityConstrained, BeatsProjectingTheUnconstrainedSolution) {
  std::srand(6);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(12, 8);
  const Eigen::VectorXd y = 5.0 * Eigen::VectorXd::Random(12);
  const Eigen::MatrixXd H = A.transpose() * A;
  const Eigen::VectorXd b = A.transpose() * y;
  Eigen::VectorXd x;
  ASSERT_TRUE(solveGravityConstrained(H, b, kG, &x));
  EXPECT_NEAR(x.tail<3>().norm(), kG, 1e-12);
  Eigen::VectorXd projected = H.ldlt().solve(b);
  const Vector3d g = kG * projected.tail<3>().normalized();
  projected.tail<3>() = g;
  projected.head<5>() =
      H.topLeftCorner<5, 5>().ldlt().solve(b.head<5>() - H.topRightCorner<5, 3>() * g);
  EXPECT_LT((A * x - y).norm(), (A * projected - y).norm());
}

TEST(SolveGravityConstrained, RefusesSingularAndNonFiniteSystems) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Identity(6, 6);
  Eigen::VectorXd b = Eigen::VectorXd::Ones(6), x = Eigen::VectorXd::Constant(1, 42.0);
  H(1, 1) = 0.0;
  EXPECT_FALSE(solveGravityConstrained(H, b, kG, &x));
  H = Eigen::MatrixXd::Identity(6, 6);
  H.topLeftCorner<2, 2>().setOnes();  // rank one
  EXPECT_FALSE(solveGravityConstrained(H, b, kG, &x));
  H = Eigen::MatrixXd::Identity(6, 6);
  b[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solveGravityConstrained(H, b, kG, &x));
  b[2] = 1.0;
  H(5, 3) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(solveGravityConstrained(H, b, kG, &x));
  EXPECT_EQ(x.size(), 1);  // left alone
}

}  // namespace
}  // namespace slim_init
