// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/partial_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cstdlib>
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

EvenMatrix lowerOf(const MatrixXd& A) {
  const int n = static_cast<int>(A.rows());
  EvenMatrix out(n);
  for (int j = 0; j < n; ++j) {
    // What is above the diagonal must not matter.
    out.column(j).setConstant(1e30);
    out.column(j).segment(j, n - j) = A.col(j).tail(n - j);
  }
  return out;
}

TEST(PartialCholesky, LeavesFactorAndSchurComplement) {
  for (int n = 1; n <= 21; ++n) {
    const MatrixXd A = positive(n, n);
    const MatrixXd L = A.llt().matrixL();
    for (int eliminated = 0; eliminated <= n; ++eliminated) {
      EvenMatrix at = lowerOf(A);
      ASSERT_TRUE(partialCholesky(at.data(), at.stride(), n, eliminated));
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
          ASSERT_NEAR(at.column(j)[i], expected, 1e-9 * n) << n << " " << eliminated;
        }
      }
    }
  }
}

TEST(PartialCholesky, RefusesWhatIsNotPositiveDefinite) {
  MatrixXd A = positive(9, 2);
  A(7, 7) = -1.0;
  EvenMatrix at = lowerOf(A);
  EXPECT_FALSE(partialCholesky(at.data(), at.stride(), 9, 9));
  // It is not reached.
  at = lowerOf(A);
  EXPECT_TRUE(partialCholesky(at.data(), at.stride(), 9, 7));
  A(7, 7) = std::numeric_limits<double>::quiet_NaN();
  at = lowerOf(A);
  EXPECT_FALSE(partialCholesky(at.data(), at.stride(), 9, 9));
}

TEST(SubtractOuterProduct3, IsThatOfThreeColumns) {
  for (int n = 1; n <= 9; ++n) {
    std::srand(n);
    const MatrixXd A = positive(n, n), P = MatrixXd::Random(n, 3);
    EvenMatrix C = lowerOf(A);
    MatrixXd padded = MatrixXd::Zero(C.stride(), 3);
    padded.topRows(n) = P;
    subtractOuterProduct3(C.data(), C.stride(), n, padded.data(), C.stride());
    const MatrixXd expected = A - P * P.transpose();
    for (int j = 0; j < n; ++j) {
      for (int i = j; i < n; ++i) EXPECT_NEAR(C.column(j)[i], expected(i, j), 1e-13 * n);
    }
  }
}

TEST(PropagatedCovariance, IsThatOfTheInverse) {
  for (const int n : {4, 7, 12}) {
    for (const int rows : {1, 2, 5, 6}) {
      const MatrixXd information = positive(n, n);
      MatrixXd T = MatrixXd::Random(rows, n);
      // Leading zeros of odd and even number.
      for (int r = 0; r < rows; ++r) T.row(r).head(std::min(r, n - 1)).setZero();
      EvenMatrix L = lowerOf(information);
      ASSERT_TRUE(partialCholesky(L.data(), L.stride(), n, n));
      const MatrixXd expected = T * information.inverse() * T.transpose();
      const MatrixXd covariance = propagatedCovariance(L, T);
      ASSERT_EQ(covariance.rows(), rows);
      EXPECT_LT((covariance - expected).norm(), 1e-9 * (1.0 + expected.norm())) << n << " " << rows;
      EXPECT_EQ(covariance, covariance.transpose());
    }
  }
}

}  // namespace
}  // namespace slim_init
