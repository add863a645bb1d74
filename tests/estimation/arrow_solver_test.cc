// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/arrow_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdlib>

namespace slim_init {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Normal equations as IMU factors and tracks leave them: random factors over two neighbouring
// keyframes and everything that is not a pose or a velocity, and over all poses.
MatrixXd normalEquations(const StateLayout& at, bool dense_velocities) {
  std::srand(7);
  const int size = at.size();
  const int globals = size - at.gyroBias();
  MatrixXd J = MatrixXd::Zero(0, size);
  for (int i = 0; i + 1 < at.n; ++i) {
    MatrixXd rows = MatrixXd::Zero(20, size);
    rows.middleCols(at.pose(i), 12).setRandom();
    rows.middleCols(at.velocity(i), 6).setRandom();
    rows.rightCols(globals).setRandom();
    J.conservativeResize(J.rows() + 20, size);
    J.bottomRows(20) = rows;
  }
  MatrixXd visual = MatrixXd::Zero(8 * at.n, size);
  visual.leftCols(dense_velocities ? 9 * at.n : 6 * at.n).setRandom();
  return J.transpose() * J + visual.transpose() * visual + MatrixXd::Identity(size, size);
}

VectorXd reference(const StateLayout& at, const MatrixXd& H, const VectorXd& g, double damping) {
  const int m = at.size() - StateLayout::kGauge;
  MatrixXd A = H.bottomRightCorner(m, m);
  A.diagonal() *= 1.0 + damping;
  VectorXd step = VectorXd::Zero(at.size());
  step.tail(m) = -A.llt().solve(g.tail(m));
  return step;
}

TEST(ArrowSolver, TakesTheStepOfTheDenseSystem) {
  for (const int n : {2, 3, 4, 7, 10}) {
    for (const bool rigs : {false, true}) {
      for (const bool dense : {false, true}) {
        const StateLayout at(n, rigs);
        const MatrixXd H = normalEquations(at, dense);
        const VectorXd g = VectorXd::Random(at.size());
        // Only the lower triangle counts.
        const MatrixXd lower = H.triangularView<Eigen::Lower>();
        ArrowSolver solver(at, dense);
        // Again with memory that has been used.
        for (const double damping : {1e-6, 0.5, 0.0}) {
          VectorXd step;
          ASSERT_TRUE(solver.solve(lower, g, damping, &step));
          const VectorXd expected = reference(at, H, g, damping);
          EXPECT_LT((step - expected).norm(), 1e-10 * expected.norm())
              << n << " keyframes, rig " << rigs << ", dense " << dense;
        }
      }
    }
  }
}

TEST(ArrowSolver, RefusesWhatIsNotPositiveDefinite) {
  const StateLayout at(5, true);
  const VectorXd g = VectorXd::Ones(at.size());
  for (const int unknown : {at.pose(2), at.velocity(3), at.td()}) {
    MatrixXd H = normalEquations(at, false);
    H(unknown, unknown) = -1.0;
    ArrowSolver solver(at, false);
    VectorXd step;
    EXPECT_FALSE(solver.solve(H, g, 1e-6, &step)) << unknown;
  }
  // The gauge is not solved for.
  MatrixXd H = normalEquations(at, false);
  H(at.pose(0), at.pose(0)) = -1.0;
  ArrowSolver solver(at, false);
  VectorXd step;
  EXPECT_TRUE(solver.solve(H, g, 1e-6, &step));
}

}  // namespace
}  // namespace slim_init
