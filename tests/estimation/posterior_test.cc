// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/posterior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "geometry/so3.h"

namespace slim_init {
namespace {

WindowState someState(int n) {
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d{normal(rng), normal(rng), normal(rng)}; };
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

// A covariance of the state `m` long. Small errors, so that first order is exact to a percent of
// the sampling error.
Eigen::MatrixXd smallCovariance(int m, std::mt19937* rng) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(m, m);
  for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = normal(*rng);
  return 1e-6 * (A * A.transpose() / m + Eigen::MatrixXd::Identity(m, m));
}

// Mean of the squares of errorOf(a draw of the state).
template <typename ErrorOf>
Eigen::MatrixXd sampledCovariance(const WindowState& state, const StateLayout& at,
                                  const Eigen::MatrixXd& covariance, int rows, std::mt19937* rng,
                                  const ErrorOf& errorOf) {
  constexpr int kSamples = 4000;
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd L = covariance.llt().matrixL();
  Eigen::MatrixXd sampled = Eigen::MatrixXd::Zero(rows, rows);
  for (int s = 0; s < kSamples; ++s) {
    Eigen::VectorXd e(L.rows());
    for (Eigen::Index i = 0; i < e.size(); ++i) e[i] = normal(*rng);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(at.size());
    step.tail(L.rows()) = L * e;
    const Eigen::VectorXd error = errorOf(retract(state, step));
    sampled += error * error.transpose() / kSamples;
  }
  return sampled;
}

TEST(Posterior, CovarianceOfTheWorldStatesIsThatOfSamples) {
  const int n = 4;
  const WindowState state = someState(n);
  const StateLayout at(n);
  const int m = at.size() - StateLayout::kGauge;
  std::mt19937 rng(7);
  const Eigen::MatrixXd covariance = smallCovariance(m, &rng);
  const Posterior posterior = posteriorOf(state, covariance.inverse());
  ASSERT_TRUE(posterior.valid);
  ASSERT_EQ(posterior.covariance.rows(), 9 * n + 6);

  const auto errorOf = [&](const WindowState& moved) {
    Eigen::VectorXd error(9 * n + 6);
    for (int k = 0; k < n; ++k) {
      const WorldPose x = worldPose(state, k), y = worldPose(moved, k);
      error.segment<3>(9 * k) = logSO3(x.R.transpose() * y.R);
      error.segment<3>(9 * k + 3) = y.p - x.p;
      error.segment<3>(9 * k + 6) = y.v - x.v;
    }
    error.segment<3>(9 * n) = moved.gyro_bias - state.gyro_bias;
    error.tail<3>() = moved.accel_bias - state.accel_bias;
    return error;
  };
  const Eigen::MatrixXd sampled =
      sampledCovariance(state, at, covariance, 9 * n + 6, &rng, errorOf);
  EXPECT_LT((posterior.covariance - sampled).norm(), 0.1 * sampled.norm());
  EXPECT_LT((posterior.covariance - posterior.covariance.transpose()).norm(), 1e-15);
}

// The same with a rig error: what is sampled is the body at the keyframe times moved by the
// estimate of td, where the true motion goes through other states.
TEST(Posterior, CovarianceOfTheBodyContainsThatOfTheRig) {
  const int n = 4;
  WindowState state = someState(n);
  std::mt19937 rng(11);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Eigen::Vector3d{normal(rng), normal(rng), normal(rng)}; };
  Calibration calibration;
  calibration.R_b_c = expSO3(vector());
  calibration.t_b_c = 0.1 * vector();
  state.rig.dR = expSO3(0.1 * vector());
  state.rig.dt = 0.05 * vector();
  state.rig.dtd = 0.01;
  std::vector<ImuInstant> instants(n);
  for (ImuInstant& instant : instants) instant = {vector(), 9.81 * vector().normalized()};
  const StateLayout at(n, true);
  const int m = at.size() - StateLayout::kGauge;
  const Eigen::MatrixXd covariance = smallCovariance(m, &rng);
  const Posterior posterior = posteriorOf(state, covariance.inverse(), calibration, instants);
  ASSERT_TRUE(posterior.valid);
  EXPECT_LT((posterior.rig_covariance - covariance.bottomRightCorner<8, 8>()).norm(), 1e-12);

  // The states of the body `late` seconds after the exposures, in the world of the first of them.
  const auto world = [&](const WindowState& visual, double late) {
    WindowState nominal = visual;
    const BodyOffset offset(visual.rig, calibration);
    for (int k = 0; k < n; ++k) {
      bodyAtNominalTime(visual, k, offset, {-late, instants[k]}, &nominal, nullptr);
    }
    // Into the frame of the first body; the nominal states are bodies already.
    WindowState first = nominal;
    first.rig = RigError();
    first = bodyState(first, calibration.R_b_c, calibration.t_b_c);
    std::vector<WorldPose> poses;
    for (int k = 0; k < n; ++k) poses.push_back(worldPose(first, k));
    return poses;
  };
  const std::vector<WorldPose> reference = world(state, 0.0);
  const auto errorOf = [&](const WindowState& moved) {
    // The exposures are at td + its error; the label of the states is the estimate.
    const std::vector<WorldPose> truth = world(moved, -(moved.rig.dtd - state.rig.dtd));
    Eigen::VectorXd error(9 * n);
    for (int k = 0; k < n; ++k) {
      error.segment<3>(9 * k) = logSO3(reference[k].R.transpose() * truth[k].R);
      error.segment<3>(9 * k + 3) = truth[k].p - reference[k].p;
      error.segment<3>(9 * k + 6) = truth[k].v - reference[k].v;
    }
    return error;
  };
  const Eigen::MatrixXd sampled = sampledCovariance(state, at, covariance, 9 * n, &rng, errorOf);
  const Eigen::MatrixXd stated = posterior.covariance.topLeftCorner(9 * n, 9 * n);
  EXPECT_LT((stated - sampled).norm(), 0.1 * sampled.norm());
  for (int k = 0; k < n; ++k) {
    for (int part : {0, 3, 6}) {
      if (k == 0 && part == 3) continue;  // the origin
      const auto variance = [at = 9 * k + part](const Eigen::MatrixXd& of) {
        return of.diagonal().segment(at, 3).sum();
      };
      EXPECT_NEAR(variance(stated), variance(sampled), 0.1 * variance(sampled));
    }
  }
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
