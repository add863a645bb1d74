// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Noise-free windows are recovered to 1e-6 relative: accelerometer bias zero, IMU samples whose
// integration is exact, eq. (11) off. With eq. (11) on, the shrinkage is documented.
#include <gtest/gtest.h>

#include "slim_init/baselines/baselines.h"
#include "support/exact_window.h"
#include "support/method_name.h"

namespace slim_init {
namespace {

constexpr double kRelative = 1e-6;

baselines::BaselineOptions withoutEquation11() {
  baselines::BaselineOptions options;
  options.slim_paper.use_line_epipolar = false;
  return options;
}

InitializerOptions preciseOptions() {
  InitializerOptions options;
  options.refinement.tolerance = 1e-12;  // slim stops at a third of a sigma, noise or not
  options.inertial.gyro_bias_prior = 10.0;
  return options;
}

void expectRecovered(const ExactWindow& exact, const InitResult& result,
                     const Eigen::Vector3d& gyro_bias) {
  ASSERT_TRUE(result.success()) << result.message;
  ASSERT_EQ(result.states.size(), exact.truth.size());
  double path = 0.0, speed = 0.0;
  for (std::size_t k = 0; k < exact.truth.size(); ++k) {
    speed = std::max(speed, exact.truth[k].v_w_b.norm());
    path = std::max(path, (exact.truth[k].p_w_b - exact.truth[0].p_w_b).norm());
  }
  EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), kRelative);
  EXPECT_LT(gravityErrorRad(result.gravity_b0, exact.truth[0]), kRelative);
  EXPECT_LT(velocityRmse(result.states, exact.truth), kRelative * speed);
  EXPECT_LT(positionRmse(result.states, exact.truth), kRelative * path);
  EXPECT_LT((result.gyro_bias - gyro_bias).norm(), kRelative * gyro_bias.norm());
  // World frame: gravity along -z, first body at the origin with zero yaw.
  EXPECT_LT((result.gravity_w - Eigen::Vector3d(0, 0, -exact.calibration.gravity_magnitude)).norm(),
            1e-12);
  EXPECT_LT(result.states[0].p_w_b.norm(), 1e-12);
  EXPECT_NEAR(std::atan2(result.states[0].R_w_b(1, 0), result.states[0].R_w_b(0, 0)), 0.0, 1e-9);
}

class NoiseFree : public ::testing::TestWithParam<std::string> {
 protected:
  void checkWindow(ExactWindowOptions options, const std::string& trace) const {
    // Clutter inside the VP's inlier threshold bends it, noise or not.
    options.parallel_lines_only = true;
    const ExactWindow exact = makeExactWindow(options);
    SCOPED_TRACE(trace);
    expectRecovered(exact, solver_->solve(*exact.window), options.gyro_bias);
  }

  const std::unique_ptr<WindowSolver> solver_ =
      baselines::makeMethod(GetParam(), preciseOptions(), withoutEquation11());
};

TEST_P(NoiseFree, RecoversEverythingForManyScenes) {
  ASSERT_NE(solver_, nullptr);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ExactWindowOptions options;
    options.seed = seed;
    checkWindow(options, "seed " + std::to_string(seed));
  }
}

TEST_P(NoiseFree, KeyframesOnSamplesAndBetween) {
  for (double offset : {0.0, 1e-7, 0.0025, 0.004999}) {
    ExactWindowOptions options;
    options.keyframe_offset_s = offset;
    checkWindow(options, "offset " + std::to_string(offset));
  }
}

TEST_P(NoiseFree, OtherWindowLengthsAndIntervals) {
  for (int keyframes : {6, 10, 15}) {
    for (double interval : {0.25, 0.4}) {
      ExactWindowOptions options;
      options.keyframes = keyframes;
      options.interval_s = interval;
      checkWindow(options, std::to_string(keyframes) + " keyframes " + std::to_string(interval) +
                               " s apart");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, NoiseFree,
                         ::testing::ValuesIn(baselines::namesOf(baselines::methods())),
                         methodTestName);

TEST(NoiseFreeEquation11, PullsTheScaleDownAndMoreWithMoreWeight) {
  ExactWindowOptions options;
  options.parallel_lines_only = true;
  const ExactWindow exact = makeExactWindow(options);
  double last = 0.0;
  for (double weight : {0.01, 0.1, 1.0, 10.0}) {
    baselines::BaselineOptions paper;
    paper.slim_paper.line_epipolar_weight = weight;
    const InitResult result =
        baselines::makeMethod("slim-paper", InitializerOptions(), paper)->solve(*exact.window);
    ASSERT_TRUE(result.hasEstimate());
    const double error = scaleError(result.states, exact.truth);
    RecordProperty("scale_error_at_weight_" + std::to_string(weight), std::to_string(error));
    EXPECT_LT(error, last) << "weight " << weight;
    last = error;
  }
  EXPECT_LT(last, -0.01);  // 2 % of the scale are gone at weight 10, in the absence of any noise
}

}  // namespace
}  // namespace slim_init
