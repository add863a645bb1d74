// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "epipolar_bundle_adjustment.h"

#include <gtest/gtest.h>

#include "support/exact_window.h"
#include "support/jacobian_check.h"
#include "support/true_state.h"

namespace slim_init::baselines {
namespace {

std::vector<Preintegration> preintegrated(const ExactWindow& exact, const WindowState& state) {
  return preintegrateWindow(*exact.window, state.gyro_bias, state.accel_bias,
                            PreintegrationParts::kWithCovariance);
}

WindowState movedBy(const WindowState& state, double size) {
  Eigen::VectorXd step = size * Eigen::VectorXd::Ones(StateLayout(state.size()).size());
  step.head(StateLayout::kGauge).setZero();
  for (Eigen::Index i = 0; i < step.size(); i += 2) step[i] *= -0.7;
  return retract(state, step);
}

TEST(EpipolarResidual, VanishesAtTheTruthForEveryPair) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const WindowState truth = trueState(exact);
  const Eigen::Matrix3d& R_b_c = exact.calibration.R_b_c;
  int checked = 0;
  for (const Track& track : exact.window->pointTracks()) {
    for (int a = track.begin; a + 1 < track.end; ++a) {
      const WindowPoint& i = exact.window->pointObservations()[a];
      const WindowPoint& j = exact.window->pointObservations()[track.end - 1];
      double r = 1.0;
      ASSERT_TRUE(epipolarResidual(truth, i.keyframe, j.keyframe, R_b_c * i.bearing,
                                   R_b_c * j.bearing, exact.calibration.t_b_c, &r, nullptr));
      EXPECT_LT(std::abs(r), 1e-12);
      ++checked;
    }
  }
  EXPECT_GT(checked, 200);
}

TEST(EpipolarResidual, DerivativesAgreeWithDifferences) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const WindowState state = movedBy(trueState(exact), 0.02);
  const Eigen::Vector3d f_i = Eigen::Vector3d(0.2, -0.1, 1.0).normalized();
  const Eigen::Vector3d f_j = Eigen::Vector3d(-0.3, 0.25, 0.9).normalized();
  const StateLayout at(state.size());
  const int i = 2, j = 7;
  double r = 0.0;
  Eigen::Matrix<double, 1, 12> J;
  ASSERT_TRUE(epipolarResidual(state, i, j, f_i, f_j, exact.calibration.t_b_c, &r, &J));
  EXPECT_GT(std::abs(r), 1e-3);
  const auto f = [&](const Eigen::VectorXd& d) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(at.size());
    step.segment<6>(at.pose(i)) = d.head<6>();
    step.segment<6>(at.pose(j)) = d.tail<6>();
    double value = 0.0;
    epipolarResidual(retract(state, step), i, j, f_i, f_j, exact.calibration.t_b_c, &value,
                     nullptr);
    return Eigen::VectorXd::Constant(1, value).eval();
  };
  EXPECT_TRUE(jacobiansAgree(J, numericJacobian(f, 12, 1e-5), 1e-8));
}

TEST(EpipolarResidual, HasNoDirectionOfABaselineWithoutLength) {
  WindowState state;
  state.R_b0_bk.assign(2, Eigen::Matrix3d::Identity());
  state.p_b0 = Eigen::Matrix3Xd::Zero(3, 2);
  double r = 0.0;
  EXPECT_FALSE(epipolarResidual(state, 0, 1, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(),
                                Eigen::Vector3d::Zero(), &r, nullptr));
}

TEST(AdjustEpipolar, ReturnsFromAPerturbedStartToTheTruth) {
  // The true accelerometer bias is zero, where the prior has it.
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const WindowState truth = trueState(exact);
  WindowState state = movedBy(truth, 0.01);
  DrtViBaOptions tight;
  tight.tolerance = 1e-14;
  // Derivatives of the preintegration at the truth: the first-order bias is then exact there.
  const EpipolarAdjustment out =
      adjustEpipolar(*exact.window, preintegrated(exact, truth), tight, &state);
  ASSERT_TRUE(out.valid);
  EXPECT_GT(out.residuals, 1000);
  EXPECT_LT(out.cost, 1e-9 * out.first_cost);
  EXPECT_LT((state.p_b0 - truth.p_b0).norm(), 1e-5);
  EXPECT_LT((state.v_b0 - truth.v_b0).norm(), 1e-5);
  EXPECT_LT((state.gyro_bias - truth.gyro_bias).norm(), 1e-6);
  EXPECT_LT((state.accel_bias - truth.accel_bias).norm(), 1e-4);
}

TEST(AdjustEpipolar, LowersTheCostOnNoisyDataAndConverges) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 1);
  WindowState state = movedBy(trueState(exact), 0.005);
  const EpipolarAdjustment out =
      adjustEpipolar(*exact.window, preintegrated(exact, state), DrtViBaOptions(), &state);
  ASSERT_TRUE(out.valid);
  EXPECT_TRUE(out.converged);
  EXPECT_LT(out.cost, 0.5 * out.first_cost);
}

TEST(AdjustEpipolar, OneIterationIsOneStep) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  WindowState state = movedBy(trueState(exact), 0.005);
  DrtViBaOptions once;
  once.max_iterations = 1;
  const EpipolarAdjustment out =
      adjustEpipolar(*exact.window, preintegrated(exact, state), once, &state);
  EXPECT_EQ(out.iterations, 1);
}

}  // namespace
}  // namespace slim_init::baselines
