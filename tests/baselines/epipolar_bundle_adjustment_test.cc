// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "epipolar_bundle_adjustment.h"

#include <gtest/gtest.h>

#include "support/exact_window.h"
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
  // A baseline without length has no direction.
  state.p_b0.col(3) = state.p_b0.col(2);
  state.R_b0_bk[3] = state.R_b0_bk[2];
  EXPECT_TRUE(std::isfinite(
      adjustEpipolar(*exact.window, preintegrated(exact, truth), tight, &state).first_cost));
}

TEST(AdjustEpipolar, LowersTheCostOnNoisyDataAndConverges) {
  const ExactWindow exact = noisyWindow(Motion::kExcited, 1);
  WindowState state = movedBy(trueState(exact), 0.005);
  const std::vector<Preintegration> pre = preintegrated(exact, state);
  const EpipolarAdjustment out = adjustEpipolar(*exact.window, pre, DrtViBaOptions(), &state);
  ASSERT_TRUE(out.valid);
  EXPECT_TRUE(out.converged);
  EXPECT_LT(out.cost, 0.5 * out.first_cost);

  // The cost is level there along every axis: with a wrong derivative it is not. In standard
  // deviations; an error of a tenth in one term makes 1e-3.
  DrtViBaOptions tight;
  tight.tolerance = 1e-14;
  adjustEpipolar(*exact.window, pre, tight, &state);
  const int size = StateLayout(state.size()).size();
  for (int i = StateLayout::kGauge; i < size; ++i) {
    const auto cost = [&](double d) {
      WindowState moved = retract(state, d * Eigen::VectorXd::Unit(size, i));
      return adjustEpipolar(*exact.window, pre, DrtViBaOptions(), &moved).first_cost;
    };
    const double before = cost(-1e-5), at = cost(0.0), after = cost(1e-5);
    const double curvature = std::abs(after + before - 2.0 * at) * 1e10;
    EXPECT_LT(std::abs(after - before) * 5e4, 1e-5 * std::sqrt(curvature)) << i;
  }
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
