// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What a host reads of a result: gates with their exceptions, covariance, and no contradiction.
#include <gtest/gtest.h>

#include <algorithm>

#include "slim_init/baselines/baselines.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

// The one exception of the gates: parallax between the least and its bound.
TEST(SuccessOfSlim, AnExceptionOfAGateHasAReason) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const auto solve = [&exact](double min_parallax_px, double min_least_parallax_px) {
    InitializerOptions options;
    options.gates.min_parallax_px = min_parallax_px;
    options.gates.min_least_parallax_px = min_least_parallax_px;
    return baselines::makeMethod("slim", options)->solve(*exact.window);
  };
  const auto parallaxOf = [](const InitResult& result) {
    return *std::find_if(result.gates.begin(), result.gates.end(),
                         [](const GateValue& gate) { return gate.name == GateName::kParallax; });
  };
  const double measured = parallaxOf(solve(3.0, 1.5)).value;

  const InitResult accepted = solve(1.5 * measured, 0.99 * measured);
  EXPECT_TRUE(accepted.success()) << accepted.message;
  EXPECT_FALSE(parallaxOf(accepted).passed);
  EXPECT_FALSE(parallaxOf(accepted).enforced);
  EXPECT_FALSE(parallaxOf(accepted).exception.empty());

  const InitResult refused = solve(1.5 * measured, 1.01 * measured);
  EXPECT_FALSE(refused.success());
  EXPECT_TRUE(parallaxOf(refused).enforced);
  EXPECT_TRUE(parallaxOf(refused).exception.empty());
}

class ResultValidation : public ::testing::Test {
 protected:
  ResultValidation() {
    result_.status = InitStatus::kSuccess;
    result_.states.resize(2);
    for (NavState& state : result_.states) state.t = 0.0;
    result_.gravity_w = Eigen::Vector3d(0, 0, -9.81);
    GateValue gate;
    gate.name = GateName::kScaleSigma;
    gate.value = 0.2;
    gate.threshold = 0.1;
    result_.gates.push_back(gate);
  }
  InitResult result_;
};

TEST(StateCovariance, IsOfOneKeyframeAndOfTheBiases) {
  InitResult result;
  EXPECT_TRUE(result.stateCovariance(0).array().isNaN().all()) << "no states";
  result.states.resize(3);
  EXPECT_TRUE(result.stateCovariance(0).array().isNaN().all()) << "no covariance";
  // Row and column can be told from the value, and the matrix is not quite symmetric.
  result.covariance.resize(33, 33);
  for (int row = 0; row < 33; ++row) {
    for (int column = 0; column < 33; ++column) result.covariance(row, column) = 100 * row + column;
  }
  const Eigen::Matrix<double, 15, 15> P = result.stateCovariance(1);
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 15; ++j) {
      const int row = i < 9 ? 9 + i : 18 + i, column = j < 9 ? 9 + j : 18 + j;
      EXPECT_EQ(P(i, j), 50.5 * (row + column)) << i << ", " << j;
    }
  }
  EXPECT_TRUE(result.stateCovariance(3).array().isNaN().all()) << "beyond the last state";
  EXPECT_TRUE(result.stateCovariance(2).allFinite());
}

TEST_F(ResultValidation, AcceptsWhatIsConsistent) {
  EXPECT_EQ(result_.validate(), "");  // failed, but not enforced
  result_.gates[0].enforced = result_.gates[0].passed = true;
  EXPECT_EQ(result_.validate(), "");
  InitResult refused;
  refused.status = InitStatus::kStationary;
  EXPECT_EQ(refused.validate(), "");
}

TEST_F(ResultValidation, NamesWhatContradictsSuccess) {
  InitResult result = result_;
  result.gates[0].enforced = true;
  EXPECT_EQ(result.validate(),
            "success although the enforced gate scale_sigma failed: 0.2 (limit 0.1)");
  result = result_;
  result.states.clear();
  EXPECT_EQ(result.validate(), "success without states");
  result = result_;
  result.states[1].v_w_b.x() = kNotComputed;
  EXPECT_EQ(result.validate(), "success with a state that is not finite");
  result = result_;
  result.gravity_w.z() = kNotComputed;
  EXPECT_EQ(result.validate(), "success without gravity");
  result = result_;
  result.covariance.setIdentity(24, 24);
  EXPECT_EQ(result.validate(), "");
  result.covariance.setIdentity(24, 23);
  EXPECT_EQ(result.validate(), "success with a covariance of 24 x 23, must be 24 x 24 or empty");
}

}  // namespace
}  // namespace slim_init
