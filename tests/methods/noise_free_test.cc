// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Noise-free windows are recovered to 1e-6 relative: accelerometer bias zero, IMU samples whose
// integration is exact, eq. (11) off. With eq. (11) on, the shrinkage is documented.
#include <gtest/gtest.h>

#include "methods/method_checks.h"
#include "slim_init/baselines/baselines.h"
#include "support/method_name.h"

namespace slim_init {
namespace {

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

class NoiseFree : public ::testing::TestWithParam<std::string> {
 protected:
  void checkWindow(ExactWindowOptions options, const std::string& trace) const {
    // Clutter inside the VP's inlier threshold bends it, noise or not.
    options.parallel_lines_only = true;
    const ExactWindow exact = makeExactWindow(options);
    SCOPED_TRACE(trace);
    const InitResult result = solver_->solve(*exact.window);
    ASSERT_NO_FATAL_FAILURE(expectRecovered(exact, result, 1e-6));
    // World frame: gravity along -z, first body at the origin with zero yaw.
    const Eigen::Vector3d gravity_w(0, 0, -exact.calibration.gravity_magnitude);
    EXPECT_LT((result.gravity_w - gravity_w).norm(), 1e-12);
    const Eigen::Matrix3d& R = result.states[0].R_w_b;
    EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), 0.0, 1e-9);
  }

  const std::unique_ptr<WindowSolver> solver_ =
      baselines::makeMethod(GetParam(), preciseOptions(), withoutEquation11());
};

TEST_P(NoiseFree, RecoversEverythingForManyScenes) {
  ASSERT_NE(solver_, nullptr);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    checkWindow(seeded(seed), "seed " + std::to_string(seed));
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
