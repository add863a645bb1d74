// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/dense.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <limits>

namespace slim_init {
namespace {

using Eigen::MatrixXd;

// Positive definite, its condition that of a random matrix squared.
MatrixXd positive(int n, unsigned seed) {
  std::srand(seed);
  const MatrixXd B = MatrixXd::Random(n, n + 3);
  return B * B.transpose() + 0.1 * MatrixXd::Identity(n, n);
}

MatrixXd lowerOf(MatrixXd A) {
  // What is above the diagonal must not matter.
  A.triangularView<Eigen::StrictlyUpper>().setConstant(1e30);
  return A;
}

TEST(EliminateFirst, LeavesFactorAndSchurComplement) {
  for (int n = 1; n <= 21; ++n) {
    const MatrixXd A = positive(n, n);
    const MatrixXd L = A.llt().matrixL();
    for (int eliminated = 0; eliminated <= n; ++eliminated) {
      MatrixXd at = lowerOf(A);
      ASSERT_TRUE(eliminateFirst(at, eliminated));
      const int rest = n - eliminated;
      MatrixXd schur = A.bottomRightCorner(rest, rest);
      if (eliminated > 0) {
        schur -= A.bottomLeftCorner(rest, eliminated) *
                 A.topLeftCorner(eliminated, eliminated).inverse() *
                 A.topRightCorner(eliminated, rest);
      }
      for (int j = 0; j < n; ++j) {
        for (int i = j; i < n; ++i) {
          const double expected = j < eliminated ? L(i, j) : schur(i - eliminated, j - eliminated);
          ASSERT_NEAR(at(i, j), expected, 1e-9 * n) << n << " " << eliminated;
        }
      }
    }
  }
}

TEST(EliminateFirst, RefusesWhatIsNotPositiveDefinite) {
  MatrixXd A = positive(9, 2);
  A(7, 7) = -1.0;
  MatrixXd at = lowerOf(A);
  EXPECT_FALSE(eliminateFirst(at, 9));
  at = lowerOf(A);
  EXPECT_TRUE(eliminateFirst(at, 7)) << "it is not reached";
  A(7, 7) = std::numeric_limits<double>::quiet_NaN();
  at = lowerOf(A);
  EXPECT_FALSE(eliminateFirst(at, 9));
}

TEST(SolveDamped, IsTheSolutionOfTheDampedSystem) {
  for (int n = 1; n <= 21; ++n) {
    const MatrixXd A = positive(n, n);
    const Eigen::VectorXd b = Eigen::VectorXd::Random(n);
    for (const double damping : {0.0, 1e-6, 0.5}) {
      MatrixXd damped = A;
      damped.diagonal() *= 1.0 + damping;
      Eigen::VectorXd x;
      ASSERT_TRUE(solveDamped(lowerOf(A), b, damping, &x));
      EXPECT_LT((damped * x - b).norm(), 1e-9 * b.norm()) << n;
    }
  }
  MatrixXd A = positive(5, 3);
  A(4, 4) = -1.0;
  Eigen::VectorXd x;
  EXPECT_FALSE(solveDamped(A, Eigen::VectorXd::Ones(5), 1e-6, &x));
}

TEST(InverseSeenBy, IsThePropagatedInverse) {
  for (const int n : {4, 7, 12}) {
    for (const int rows : {1, 2, 5, 6}) {
      const MatrixXd information = positive(n, n), T = MatrixXd::Random(rows, n);
      MatrixXd covariance;
      ASSERT_TRUE(inverseSeenBy(information, T, &covariance));
      const MatrixXd expected = T * information.inverse() * T.transpose();
      EXPECT_LT((covariance - expected).norm(), 1e-9 * (1.0 + expected.norm())) << n << " " << rows;
      EXPECT_EQ(covariance, covariance.transpose());
    }
  }
  MatrixXd unused;
  EXPECT_FALSE(inverseSeenBy(-positive(3, 1), MatrixXd::Identity(3, 3), &unused));
}

}  // namespace
}  // namespace slim_init
