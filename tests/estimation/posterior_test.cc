// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/posterior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "geometry/so3.h"

namespace slim_init {
namespace {

WindowState someState(int n) {
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d(normal(rng), normal(rng), normal(rng)); };
  WindowState state;
  state.p_b0.setZero(3, n);
  state.v_b0.setZero(3, n);
  for (int k = 0; k < n; ++k) {
    state.R_b0_bk.push_back(k == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                   : expSO3(0.3 * vector()));
    if (k > 0) state.p_b0.col(k) = vector();
    state.v_b0.col(k) = vector();
  }
  state.gravity_b0 = 9.81 * Eigen::Vector3d(0.2, -0.9, 0.3).normalized();
  return state;
}

// The world states of a state in b0, as the solver hands them on.
struct WorldPose {
  Eigen::Matrix3d R;
  Eigen::Vector3d p, v;
};
WorldPose worldPose(const WindowState& state, int k) {
  const Eigen::Matrix3d A = gravityAlignedAttitude(state.gravity_b0);
  return {A * state.R_b0_bk[k], A * state.p_b0.col(k), A * state.v_b0.col(k)};
}

TEST(Posterior, CovarianceOfTheWorldStatesIsThatOfSamples) {
  const int n = 4;
  const WindowState state = someState(n);
  const StateLayout at(n);
  const int m = at.size() - StateLayout::kGauge;
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(m, m);
  for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = normal(rng);
  // Small errors, so that first order is exact to a percent of the sampling error.
  const Eigen::MatrixXd covariance =
      1e-6 * (A * A.transpose() / m + Eigen::MatrixXd::Identity(m, m));
  const Posterior posterior = posteriorOf(state, covariance.inverse());
  ASSERT_TRUE(posterior.valid);
  ASSERT_EQ(posterior.covariance.rows(), 9 * n + 6);

  const Eigen::MatrixXd L = covariance.llt().matrixL();
  constexpr int kSamples = 4000;
  Eigen::MatrixXd sampled = Eigen::MatrixXd::Zero(9 * n + 6, 9 * n + 6);
  for (int s = 0; s < kSamples; ++s) {
    Eigen::VectorXd e(m);
    for (Eigen::Index i = 0; i < m; ++i) e[i] = normal(rng);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(at.size());
    step.tail(m) = L * e;
    const WindowState moved = retract(state, step);
    Eigen::VectorXd error(9 * n + 6);
    for (int k = 0; k < n; ++k) {
      const WorldPose x = worldPose(state, k), y = worldPose(moved, k);
      error.segment<3>(9 * k) = logSO3(x.R.transpose() * y.R);
      error.segment<3>(9 * k + 3) = y.p - x.p;
      error.segment<3>(9 * k + 6) = y.v - x.v;
    }
    error.segment<3>(9 * n) = moved.gyro_bias - state.gyro_bias;
    error.tail<3>() = moved.accel_bias - state.accel_bias;
    sampled += error * error.transpose() / kSamples;
  }
  EXPECT_LT((posterior.covariance - sampled).norm(), 0.1 * sampled.norm());
  EXPECT_LT((posterior.covariance - posterior.covariance.transpose()).norm(), 1e-15);
}

TEST(Posterior, ScaleSigmaIsThatOfASpreadAlongTheTrajectory) {
  const int n = 5;
  const WindowState state = someState(n);
  const StateLayout at(n);
  const int m = at.size() - StateLayout::kGauge;
  // Positions known to 1 cm each, independently: sigma of the spread is 1 cm over the spread, less
  // the share of the first position, which is fixed.
  Eigen::MatrixXd information = 1e12 * Eigen::MatrixXd::Identity(m, m);
  for (int k = 1; k < n; ++k) {
    information.diagonal().segment<3>(at.pose(k) + 3 - StateLayout::kGauge).setConstant(1e4);
  }
  const Eigen::Matrix3Xd centred = state.p_b0.colwise() - state.p_b0.rowwise().mean();
  const double spread2 = centred.squaredNorm();
  const double expected = 0.01 * std::sqrt(spread2 - centred.col(0).squaredNorm()) / spread2;
  EXPECT_NEAR(posteriorOf(state, information).scale_sigma, expected, 1e-6 * expected);
}

TEST(Posterior, RefusesAnIndefiniteInformation) {
  const WindowState state = someState(4);
  const int m = StateLayout(4).size() - StateLayout::kGauge;
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(m, m);
  information(3, 3) = -1.0;
  EXPECT_FALSE(posteriorOf(state, information).valid);
}

}  // namespace
}  // namespace slim_init
