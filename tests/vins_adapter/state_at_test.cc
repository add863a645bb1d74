// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/state_at.h"

#include <gtest/gtest.h>

#include "geometry/so3.h"
#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

// Truth that is the preintegrator's own, so that forward and backward have to meet to rounding.
class StateAtTest : public ::testing::Test {
 protected:
  static ExactWindowOptions biased() {
    ExactWindowOptions options;
    options.accel_bias = Eigen::Vector3d(0.05, -0.04, 0.03);
    return options;
  }
  InitResult estimate(const std::vector<NavState>& keyframes) const {
    InitResult result;
    result.states = keyframes;
    result.gravity_w = Eigen::Vector3d(0.0, 0.0, -exact_.calibration.gravity_magnitude);
    return result;
  }
  std::string sentence(const std::vector<NavState>& keyframes, const std::vector<ImuSample>& imu,
                       const std::vector<double>& times, const StateAtOptions& options) const {
    std::vector<NavState> states(1);
    std::string error;
    EXPECT_FALSE(statesAt(estimate(keyframes), imu, times, options, &states, &error));
    EXPECT_EQ(states.size(), 1u) << "changed on a refusal";
    return error;
  }
  const ExactWindow exact_ = makeExactWindow(biased());
};

TEST_F(StateAtTest, MeetsTheTruthBetweenBeforeAndAfterTheKeyframes) {
  // Only keyframes 3 and 6 are known; the others are before, between and after.
  const std::vector<NavState> known = {exact_.truth[3], exact_.truth[6]};
  std::vector<double> times;
  for (const NavState& state : exact_.truth) times.push_back(state.t);
  std::vector<NavState> states;
  std::string error;
  StateAtOptions options;
  ASSERT_TRUE(statesAt(estimate(known), exact_.imu, times, options, &states, &error)) << error;
  ASSERT_EQ(states.size(), times.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    EXPECT_EQ(states[k].t, times[k]);
    EXPECT_LT((states[k].p_w_b - exact_.truth[k].p_w_b).norm(), 1e-6) << k;
    EXPECT_LT((states[k].v_w_b - exact_.truth[k].v_w_b).norm(), 1e-6) << k;
    EXPECT_LT(logSO3(states[k].R_w_b.transpose() * exact_.truth[k].R_w_b).norm(), 1e-6) << k;
    EXPECT_EQ(states[k].accel_bias, exact_.truth[k].accel_bias);
  }
}

TEST_F(StateAtTest, TheNearerKeyframeWeighsMore) {
  std::vector<NavState> known = {exact_.truth[3], exact_.truth[4]};
  known[1].p_w_b.x() += 0.1;  // as if the two disagreed
  const double t3 = known[0].t, t4 = known[1].t;
  std::vector<NavState> bent, straight;
  const std::vector<double> times = {t3, 0.75 * t3 + 0.25 * t4, 0.25 * t3 + 0.75 * t4, t4};
  const StateAtOptions options;
  ASSERT_TRUE(statesAt(estimate(known), exact_.imu, times, options, &bent, nullptr));
  known[1].p_w_b.x() -= 0.1;
  ASSERT_TRUE(statesAt(estimate(known), exact_.imu, times, options, &straight, nullptr));
  const double expected[] = {0.0, 0.025, 0.075, 0.1};
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(bent[i].p_w_b.x() - straight[i].p_w_b.x(), expected[i], 1e-9) << i;
  }
}

TEST_F(StateAtTest, RefusesWithValueAndBound) {
  const std::vector<NavState> known = {exact_.truth[3], exact_.truth[6]};
  StateAtOptions options;
  options.max_reach_s = 0.3;
  EXPECT_EQ(sentence({}, exact_.imu, {0.0}, options), "there is no keyframe to start from");
  EXPECT_EQ(sentence(known, exact_.imu, {kNotComputed}, options), "a requested time is not finite");
  EXPECT_EQ(sentence(known, exact_.imu, {known[0].t - 0.5}, options),
            "the requested time is 0.5 s before the window (limit 0.3 s)");
  EXPECT_EQ(sentence(known, exact_.imu, {known[1].t + 0.5}, options),
            "the requested time is 0.5 s after the window (limit 0.3 s)");
  std::vector<ImuSample> imu = exact_.imu;
  while (imu.back().t > known[1].t - 0.1) imu.pop_back();
  expectParts(sentence(known, imu, {known[1].t + 0.1}, options), "do not cover");
  const auto holed = withGap(exact_.imu, known[0].t + 0.1, known[0].t + 0.2);
  expectParts(sentence(known, holed, {known[0].t + 0.05}, options), "gap in the IMU data 0.1");
}

}  // namespace
}  // namespace slim_init
