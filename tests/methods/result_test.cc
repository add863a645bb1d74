// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What a host reads of a result: covariance, and no contradiction.
#include "slim_init/result.h"

#include <gtest/gtest.h>

namespace slim_init {
namespace {

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
