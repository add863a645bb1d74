// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/backend/downstream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "backend/simulated_sequence.h"
#include "geometry/so3.h"

namespace slim_init::backend {
namespace {

TEST(HeadingAlignment, FindsShiftAndHeading) {
  const Eigen::Matrix3d R = expSO3(Eigen::Vector3d(0, 0, 0.7));
  const Eigen::Vector3d t(1.0, -2.0, 0.5);
  std::vector<Eigen::Vector3d> source = {{0, 0, 0}, {1, 0, 0.2}, {1, 2, -0.4}, {3, 1, 1}};
  std::vector<Eigen::Vector3d> target;
  for (const Eigen::Vector3d& p : source) target.push_back(R * p + t);
  const evaluation::HeadingAlignment alignment = evaluation::alignHeading(source, target);
  EXPECT_NEAR(alignment.yaw, 0.7, 1e-12);
  for (std::size_t k = 0; k < source.size(); ++k) {
    EXPECT_LT((alignment.apply(source[k]) - target[k]).norm(), 1e-12);
  }
}

// Scale and tilt are errors, not gauge: the alignment must not take them out.
TEST(HeadingAlignment, LeavesScaleAndTilt) {
  const std::vector<Eigen::Vector3d> source = {{-1, 0, 0}, {1, 0, 0}};
  const std::vector<Eigen::Vector3d> target = {{-2, 0, -0.1}, {2, 0, 0.1}};
  const evaluation::HeadingAlignment alignment = evaluation::alignHeading(source, target);
  EXPECT_NEAR((alignment.apply(source[1]) - target[1]).norm(), std::hypot(1.0, 0.1), 1e-12);
}

TEST(WindowScaleError, NeedsMotion) {
  std::vector<NavState> states(3), truth(3);
  for (int k = 0; k < 3; ++k) {
    truth[static_cast<std::size_t>(k)].p_w_b.x() = 0.5 * k;
    states[static_cast<std::size_t>(k)].p_w_b.x() = 0.4 * k;
  }
  EXPECT_NEAR(windowScaleError(states, truth), 0.25, 1e-12);
  for (NavState& state : truth) state.p_w_b *= 0.1;  // now 0.041 m about their mean, rms
  EXPECT_TRUE(std::isnan(windowScaleError(states, truth)));
}

TEST(Downstream, SaysWhyItDidNotRun) {
  const evaluation::Sequence sequence = makeSimulatedSequence({"figure-eight", 5.0});
  InitResult answer;
  auto record = runDownstream(sequence, sequence.calibration, answer, 5.0);
  EXPECT_FALSE(record.ran);
  EXPECT_EQ(record.message, "no states to start from");

  for (std::size_t k = 0; k < 10; ++k) answer.states.push_back(truthOfFrame(sequence, 20 + 2 * k));
  record = runDownstream(sequence, sequence.calibration, answer, 5.0);
  EXPECT_FALSE(record.ran);
  EXPECT_EQ(record.message, "the data end too soon after the window");

  answer.states.front().t += 0.03;
  record = runDownstream(sequence, sequence.calibration, answer, 5.0);
  EXPECT_EQ(record.message, "a state of the estimate belongs to no frame of the sequence");
}

// The world of the answer is its own: shifted and turned about the vertical it gives the same.
TEST(Downstream, DoesNotSeeOriginAndHeading) {
  const evaluation::Sequence sequence = makeSimulatedSequence({"figure-eight", 7.0});
  InitResult answer, moved;
  const Eigen::Matrix3d R = expSO3(Eigen::Vector3d(0, 0, 1.0));
  for (std::size_t k = 0; k < 10; ++k) {
    answer.states.push_back(truthOfFrame(sequence, 10 + 2 * k));
    NavState state = answer.states.back();
    state.R_w_b = R * state.R_w_b;
    state.p_w_b = R * state.p_w_b + Eigen::Vector3d(5, 6, 7);
    state.v_w_b = R * state.v_w_b;
    moved.states.push_back(state);
  }
  const auto a = runDownstream(sequence, sequence.calibration, answer, 2.0);
  const auto b = runDownstream(sequence, sequence.calibration, moved, 2.0);
  ASSERT_TRUE(a.ran && b.ran);
  EXPECT_NEAR(a.ate, b.ate, 1e-3);
  EXPECT_NEAR(a.scale_error, b.scale_error, 1e-3);
}

}  // namespace
}  // namespace slim_init::backend
