// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "linear_alignment.h"

#include <gtest/gtest.h>

#include "geometry/so3.h"
#include "loosely_coupled.h"
#include "support/exact_window.h"
#include "support/true_state.h"
#include "verdict/gates.h"

namespace slim_init::baselines {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// An alignment problem with the true rotations and the true shape.
class LinearAlignment : public ::testing::Test {
 protected:
  LinearAlignment() : exact_(makeExactWindow(ExactWindowOptions())) {
    pre_ = preintegrateWindow(*exact_.window, exact_.truth[0].gyro_bias, Vector3d::Zero(),
                              PreintegrationParts::kMean);
    R_b0_bk_ = chainRotations(pre_);
    centres_ = trueShape(exact_, &metres_);
    const Vector3d first = centres_.col(0);
    centres_.colwise() -= first;
  }

  AlignmentProblem problem() const {
    return {*exact_.window, pre_, R_b0_bk_, centres_, LineTerms()};
  }

  // The true unknowns [v, s, g].
  Eigen::VectorXd truth() const {
    const int n = exact_.window->size();
    Eigen::VectorXd x(3 * n + 4);
    const Matrix3d R_b0_w = exact_.truth[0].R_w_b.transpose();
    for (int k = 0; k < n; ++k) x.segment<3>(3 * k) = R_b0_w * exact_.truth[k].v_w_b;
    x[3 * n] = metres_;
    x.tail<3>() = R_b0_w * Vector3d(0, 0, -exact_.calibration.gravity_magnitude);
    return x;
  }

  ExactWindow exact_;
  std::vector<Preintegration> pre_;
  std::vector<Matrix3d> R_b0_bk_;
  Eigen::Matrix3Xd centres_;
  double metres_ = 0.0;  // per unit of the shape
};

TEST_F(LinearAlignment, RecoversScaleGravityVelocityPosition) {
  const AlignmentEstimate estimate = alignLinear(problem());
  ASSERT_TRUE(estimate.valid);
  const Eigen::VectorXd x = truth();
  const int n = exact_.window->size();
  EXPECT_NEAR(estimate.scale, x[3 * n], 1e-10);
  EXPECT_LT((estimate.gravity_b0 - x.tail<3>()).norm(), 1e-9);
  for (int k = 0; k < n; ++k) {
    EXPECT_LT((estimate.velocities_b0.col(k) - x.segment<3>(3 * k)).norm(), 1e-9);
    const Vector3d p =
        exact_.truth[0].R_w_b.transpose() * (exact_.truth[k].p_w_b - exact_.truth[0].p_w_b);
    EXPECT_LT((estimate.positions_b0.col(k) - p).norm(), 1e-9);
  }
  EXPECT_LT(estimate.residual_rms, 1e-6);
}

TEST_F(LinearAlignment, Equation12AddsNothingAtAConsistentSolution) {
  // The projections of a vanishing r^p vanish: eq. (12) re-weights, it does not measure.
  const std::vector<PairLines> lines = selectLines(*exact_.window, LineSelectionOptions());
  AlignmentProblem with_lines = problem();
  with_lines.line_terms = {&lines, false, true, 0.0, 10.0};
  std::size_t used = 0;
  for (const PairLines& pair : lines) used += pair.normal.size();
  ASSERT_GT(used, 20u);
  const AlignmentEstimate plain = alignLinear(problem());
  const AlignmentEstimate weighted = alignLinear(with_lines);
  ASSERT_TRUE(weighted.valid);
  EXPECT_NEAR(weighted.scale, plain.scale, 1e-10);
  // Repeated rows are no new knowledge: the reported uncertainty stays.
  EXPECT_NEAR(weighted.residual_rms, plain.residual_rms, 1e-7);
}

TEST_F(LinearAlignment, Equation12NormalStandsInTheBodyFrame) {
  // The term equals n_b . r^p with n_b = R_b_c n_c, evaluated by hand for one line and pair.
  std::vector<PairLines> lines(exact_.window->size() - 1);
  const WindowLine& observation = exact_.window->lineObservations()[0];
  const int i = observation.keyframe;
  ASSERT_LT(i + 1, exact_.window->size());
  lines[i].normal.push_back({0, 1, 0.75});
  AlignmentProblem with_line = problem();
  with_line.line_terms = {&lines, false, true, 0.0, 2.0};
  const AlignmentSystem a = buildBaseRows(problem());
  AlignmentSystem b = a;
  addLineRows(with_line, &b);
  Eigen::VectorXd x = truth();
  x[3 * exact_.window->size()] *= 1.3;  // off the solution, so that r^p does not vanish
  const auto cost = [&x](const AlignmentSystem& s) {
    const Eigen::MatrixXd H = s.H.selfadjointView<Eigen::Lower>();
    return x.dot(H * x) - 2.0 * s.b.dot(x) + s.c;
  };
  const double s = x[3 * exact_.window->size()];
  const double dt = pre_[i].dt;
  const Vector3d r_b0 = s * (centres_.col(i + 1) - centres_.col(i)) - x.segment<3>(3 * i) * dt -
                        0.5 * dt * dt * x.tail<3>() - R_b0_bk_[i] * pre_[i].dp -
                        (R_b0_bk_[i + 1] - R_b0_bk_[i]) * exact_.calibration.t_b_c;
  const Vector3d n_b = exact_.calibration.R_b_c * observation.normal;
  const double r = n_b.dot(R_b0_bk_[i].transpose() * r_b0);
  EXPECT_NEAR(cost(b) - cost(a), 2.0 * 0.75 * r * r, 1e-9 * cost(b));
}

TEST_F(LinearAlignment, Equation11ShrinksTheScale) {
  // Even without noise: the term is quadratic in the scale alone, with its minimum at zero.
  const std::vector<PairLines> lines = selectLines(*exact_.window, LineSelectionOptions());
  double last = alignLinear(problem()).scale;
  for (double weight : {0.01, 0.1, 1.0}) {
    AlignmentProblem with_lines = problem();
    with_lines.line_terms = {&lines, true, false, weight, 0.0};
    const AlignmentEstimate estimate = alignLinear(with_lines);
    ASSERT_TRUE(estimate.valid);
    EXPECT_LT(estimate.scale, last) << "weight " << weight;
    last = estimate.scale;
  }
  EXPECT_LT(last, 0.99 * alignLinear(problem()).scale);
}

TEST_F(LinearAlignment, ScaleSigmaGrowsWithTheResidual) {
  Eigen::Matrix3Xd disturbed = centres_;
  std::srand(4);
  disturbed += 0.002 * Eigen::Matrix3Xd::Random(3, disturbed.cols());
  AlignmentProblem noisy = {*exact_.window, pre_, R_b0_bk_, disturbed, LineTerms()};
  const AlignmentEstimate estimate = alignLinear(noisy);
  ASSERT_TRUE(estimate.valid);
  EXPECT_GT(estimate.scale_sigma, 1e-4);
  EXPECT_LT(estimate.scale_sigma, 0.1);
}

TEST_F(LinearAlignment, NotFiniteInputIsInvalid) {
  Eigen::Matrix3Xd broken = centres_;
  broken(1, 3) = kNotComputed;
  EXPECT_FALSE(alignLinear({*exact_.window, pre_, R_b0_bk_, broken, LineTerms()}).valid);
}

TEST(AlignmentGates, EachOnBothSides) {
  const double e = 1e-3, max_sigma = 0.1;
  const auto passes = [&](GateName name, const AlignmentMeasures& measures) {
    for (const GateValue& gate : alignmentGates(measures, max_sigma)) {
      if (gate.name == name) return gate.passed;
    }
    ADD_FAILURE() << "no gate " << toString(name);
    return false;
  };
  EXPECT_TRUE(passes(GateName::kLinkage, {kMinLinkage * (1 + e), 1, 0, 0}));
  EXPECT_FALSE(passes(GateName::kLinkage, {kMinLinkage * (1 - e), 1, 0, 0}));
  EXPECT_TRUE(passes(GateName::kScalePositive, {100, 1.001e-6, 0, 0}));
  EXPECT_FALSE(passes(GateName::kScalePositive, {100, 0.999e-6, 0, 0}));
  EXPECT_FALSE(passes(GateName::kScalePositive, {100, -1.0, 0, 0}));
  EXPECT_TRUE(passes(GateName::kAlignmentResidual, {100, 1, kMaxAlignmentResidual * (1 - e), 0}));
  EXPECT_FALSE(passes(GateName::kAlignmentResidual, {100, 1, kMaxAlignmentResidual * (1 + e), 0}));
  EXPECT_TRUE(passes(GateName::kScaleSigma, {100, 1, 0, max_sigma * (1 - e)}));
  EXPECT_FALSE(passes(GateName::kScaleSigma, {100, 1, 0, max_sigma * (1 + e)}));
}

TEST(AlignmentGates, UnknownValuesDoNotPass) {
  for (const GateValue& gate : alignmentGates({}, 0.1)) {
    EXPECT_FALSE(gate.passed) << toString(gate.name);
  }
}

TEST(AlignmentGates, ANonPositiveScaleIsRefusedForEveryMethod) {
  InitResult result;
  result.gates = alignmentGates({1.0, -0.5, 0.0, 0.0}, 0.1);  // linkage fails as well
  decide(false, &result);
  EXPECT_EQ(result.status, InitStatus::kDegenerateAlignment);
  EXPECT_NE(result.message.find("scale -0.5 m (minimum "), std::string::npos) << result.message;
}

}  // namespace
}  // namespace slim_init::baselines
