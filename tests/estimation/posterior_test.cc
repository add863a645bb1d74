// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/posterior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <vector>

#include "geometry/so3.h"
#include "support/gaussian.h"

namespace slim_init {
namespace {

WindowState someState(int n) {
  Gaussian normal(4);
  WindowState state;
  state.p_b0.setZero(3, n);
  state.v_b0.setZero(3, n);
  for (int k = 0; k < n; ++k) {
    state.R_b0_bk.push_back(k == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                   : expSO3(0.3 * normal.vector()));
    if (k > 0) state.p_b0.col(k) = normal.vector();
    state.v_b0.col(k) = normal.vector();
  }
  state.gravity_b0 = 9.81 * Eigen::Vector3d(0.2, -0.9, 0.3).normalized();
  return state;
}

// The world states of a state in b0, as the solver hands them on.
struct WorldPose {
  Eigen::Matrix3d R;
  Eigen::Vector3d p, v;
};
std::vector<WorldPose> worldPoses(const WindowState& state) {
  const Eigen::Matrix3d A = gravityAlignedAttitude(state.gravity_b0);
  std::vector<WorldPose> poses;
  for (int k = 0; k < state.size(); ++k) {
    poses.push_back({A * state.R_b0_bk[k], A * state.p_b0.col(k), A * state.v_b0.col(k)});
  }
  return poses;
}

// Attitude, position and velocity of every pose.
Eigen::VectorXd errorsOf(const std::vector<WorldPose>& poses, const std::vector<WorldPose>& truth) {
  Eigen::VectorXd errors(9 * poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    errors.segment<9>(9 * static_cast<Eigen::Index>(k))
        << logSO3(truth[k].R.transpose() * poses[k].R),
        poses[k].p - truth[k].p, poses[k].v - truth[k].v;
  }
  return errors;
}

// A covariance of the state `m` long. Small errors, so that first order is exact to a percent of
// the sampling error.
Eigen::MatrixXd smallCovariance(int m, Gaussian* normal) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(m, m, [&] { return (*normal)(); });
  return 1e-6 * (A * A.transpose() / m + Eigen::MatrixXd::Identity(m, m));
}

// Mean of the squares of errorOf(a draw of the state).
template <typename ErrorOf>
Eigen::MatrixXd sampledCovariance(const WindowState& state, const StateLayout& at,
                                  const Eigen::MatrixXd& covariance, int rows, Gaussian* normal,
                                  const ErrorOf& errorOf) {
  constexpr int kSamples = 4000;
  const Eigen::MatrixXd L = covariance.llt().matrixL();
  Eigen::MatrixXd sampled = Eigen::MatrixXd::Zero(rows, rows);
  for (int s = 0; s < kSamples; ++s) {
    const Eigen::VectorXd e = Eigen::VectorXd::NullaryExpr(L.rows(), [&] { return (*normal)(); });
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
  Gaussian normal(7);
  const Eigen::MatrixXd covariance = smallCovariance(m, &normal);
  const Posterior posterior = posteriorOf(state, covariance.inverse());
  ASSERT_TRUE(posterior.valid);
  ASSERT_EQ(posterior.covariance.rows(), 9 * n + 6);

  const auto errorOf = [&](const WindowState& moved) {
    Eigen::VectorXd error(9 * n + 6);
    error << errorsOf(worldPoses(moved), worldPoses(state)), moved.gyro_bias - state.gyro_bias,
        moved.accel_bias - state.accel_bias;
    return error;
  };
  const Eigen::MatrixXd sampled =
      sampledCovariance(state, at, covariance, 9 * n + 6, &normal, errorOf);
  EXPECT_LT((posterior.covariance - sampled).norm(), 0.1 * sampled.norm());
  EXPECT_LT((posterior.covariance - posterior.covariance.transpose()).norm(), 1e-15);
}

// The same with a rig error: what is sampled is the body at the keyframe times moved by the
// estimate of td, where the true motion goes through other states.
TEST(Posterior, CovarianceOfTheBodyContainsThatOfTheRig) {
  const int n = 4;
  WindowState state = someState(n);
  Gaussian normal(11);
  Calibration calibration;
  calibration.R_b_c = expSO3(normal.vector());
  calibration.t_b_c = 0.1 * normal.vector();
  state.rig.dR = expSO3(0.1 * normal.vector());
  state.rig.dt = 0.05 * normal.vector();
  state.rig.dtd = 0.01;
  std::vector<ImuInstant> instants(n);
  for (ImuInstant& instant : instants) {
    instant = {normal.vector(), 9.81 * normal.vector().normalized()};
  }
  const StateLayout at(n, true);
  const int m = at.size() - StateLayout::kGauge;
  const Eigen::MatrixXd covariance = smallCovariance(m, &normal);
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
    return worldPoses(bodyState(first, calibration.R_b_c, calibration.t_b_c));
  };
  const std::vector<WorldPose> reference = world(state, 0.0);
  const auto errorOf = [&](const WindowState& moved) {
    // The exposures are at td + its error; the label of the states is the estimate.
    return errorsOf(world(moved, -(moved.rig.dtd - state.rig.dtd)), reference);
  };
  const Eigen::MatrixXd sampled = sampledCovariance(state, at, covariance, 9 * n, &normal, errorOf);
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
