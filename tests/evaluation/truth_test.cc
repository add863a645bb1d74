// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/truth.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>

#include "slim_init/evaluation/recorded.h"
#include "slim_init/options.h"
#include "support/exact_window.h"
#include "support/gaussian.h"

namespace slim_init::evaluation {
namespace {

const Eigen::Vector3d kBias(-0.0022, 0.0208, 0.0765);

/// Gyro of piecewise constant rate between samples and the rotation that follows from it exactly.
/// The integration takes the mean of both ends of a step, so the true rotation is built alike.
RecordedMotion turningFor20s() {
  const double dt = 0.005;
  RecordedMotion motion;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (int k = 0; k * dt <= 20.0; ++k) {
    const double t = k * dt;
    const Eigen::Vector3d rate(0.8 * std::sin(1.3 * t), 0.5 * std::cos(0.7 * t),
                               0.3 + 0.4 * std::sin(2.1 * t));
    if (k > 0) {
      const Eigen::Vector3d phi = 0.5 * (before + rate) * dt;
      q = (q * Eigen::Quaterniond(Eigen::AngleAxisd(phi.norm(), phi.normalized()))).normalized();
    }
    before = rate;
    ImuSample sample;
    sample.t = t;
    sample.gyro = rate + kBias;
    motion.imu.push_back(sample);
    if (k % 10 == 0) {
      NavState state;
      state.t = t;
      state.R_w_b = q.toRotationMatrix();
      motion.truth.push_back(state);
    }
  }
  return motion;
}

/// A path at 100 Hz with 0.1 mm of noise, which is what EuRoC's tracking systems have.
std::vector<NavState> noisyPath(std::vector<Eigen::Vector3d>* velocities) {
  Gaussian noise(3);
  std::vector<NavState> truth;
  for (int k = 0; k < 1000; ++k) {
    NavState state;
    state.t = 0.01 * k;
    const double t = state.t;
    state.p_w_b = Eigen::Vector3d(2.0 * std::sin(t), std::cos(1.3 * t), 0.5 * std::sin(2.0 * t));
    state.p_w_b += 1e-4 * noise.vector();
    velocities->emplace_back(2.0 * std::cos(t), -1.3 * std::sin(1.3 * t), std::cos(2.0 * t));
    truth.push_back(state);
  }
  return truth;
}

double largestVelocityError(const std::vector<NavState>& truth,
                            const std::vector<Eigen::Vector3d>& velocities) {
  double largest = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    largest = std::max(largest, (truth[k].v_w_b - velocities[k]).norm());
  }
  return largest;
}

TEST(DeriveVelocities, FollowANoisyPathAndAreNotMovedByAJump) {
  for (const double jump_m : {0.0, 0.07}) {
    std::vector<Eigen::Vector3d> velocities;
    std::vector<NavState> truth = noisyPath(&velocities);
    for (std::size_t k = 500; k < truth.size(); ++k) truth[k].p_w_b.x() += jump_m;
    deriveVelocities(&truth);
    EXPECT_LT(largestVelocityError(truth, velocities), 0.06) << jump_m;
  }
}

TEST(DeriveVelocities, TakesTheNearestStepsOfARareTruthAndNoneAcrossAGap) {
  std::vector<NavState> truth(5);
  const double times[] = {0.0, 0.1, 0.2, 0.7, 0.8};
  for (int k = 0; k < 5; ++k) {
    truth[k].t = times[k];
    truth[k].p_w_b = Eigen::Vector3d(times[k] * times[k], 0.0, k < 3 ? 0.0 : 5.0);
  }
  deriveVelocities(&truth);
  EXPECT_NEAR(truth[1].v_w_b.x(), 0.2, 1e-12);  // exact for a constant acceleration
  EXPECT_NEAR(truth[2].v_w_b.x(), 0.3, 1e-12);  // from the step before alone
  EXPECT_NEAR(truth[3].v_w_b.x(), 1.5, 1e-12);
  EXPECT_EQ(truth[3].v_w_b.z(), 0.0);
  std::vector<NavState> lonely(1);
  deriveVelocities(&lonely);
  EXPECT_TRUE(std::isnan(lonely[0].v_w_b.x()));
}

TEST(GyroBiasFit, RecoversTheBiasExactly) {
  const RecordedMotion motion = turningFor20s();
  const GyroBiasFit fit = fitGyroBias(motion.imu, motion.truth);
  ASSERT_TRUE(fit.ok) << fit.message;
  EXPECT_NEAR((fit.bias - kBias).norm(), 0.0, 1e-11);
  EXPECT_NEAR(fit.rms_rad, 0.0, 1e-10);
  EXPECT_EQ(fit.spans, 20);
  EXPECT_EQ(fit.spans_rejected, 0);
  EXPECT_NE(fit.message.find("ground truth has no gyro bias"), std::string::npos) << fit.message;
}

TEST(GyroBiasFit, LeavesOutAGlitchOfTheTruth) {
  RecordedMotion motion = turningFor20s();
  for (NavState& state : motion.truth) {
    // Jitter, so that the median residual is not rounding error.
    state.R_w_b = state.R_w_b * Eigen::AngleAxisd(1e-4 * std::sin(50.0 * state.t * state.t),
                                                  Eigen::Vector3d::UnitY())
                                    .toRotationMatrix();
    if (state.t > 10.0) {
      state.R_w_b = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                    state.R_w_b;  // the tracking system lost its world frame once
    }
  }
  const GyroBiasFit fit = fitGyroBias(motion.imu, motion.truth);
  ASSERT_TRUE(fit.ok) << fit.message;
  EXPECT_EQ(fit.spans_rejected, 1);
  EXPECT_NEAR((fit.bias - kBias).norm(), 0.0, 1e-4);
}

TEST(GyroBiasFit, SkipsGapsAndSaysWhenNothingIsLeft) {
  const RecordedMotion motion = turningFor20s();
  const GyroBiasFit fit = fitGyroBias(withGap(motion.imu, 7.2, 7.5), motion.truth);
  ASSERT_TRUE(fit.ok) << fit.message;
  EXPECT_EQ(fit.spans, 19);
  EXPECT_NEAR((fit.bias - kBias).norm(), 0.0, 1e-11);

  const GyroBiasFit none =
      fitGyroBias(motion.imu, {motion.truth.begin(), motion.truth.begin() + 30});
  EXPECT_FALSE(none.ok);
  EXPECT_NE(none.message.find("1 spans"), std::string::npos) << none.message;
  EXPECT_FALSE(fitGyroBias({}, {}).ok);
}

TEST(GyroBiasFit, AgreesWithTheRecordedBiasOfRealData) {
  const std::string data = SLIM_INIT_SHARED_DATA;
  // The EuRoC recordings are not part of the repository (their licence is not ours).
  if (!std::filesystem::is_directory(data)) GTEST_SKIP() << "no recordings at " << data;
  for (const char* name : {"V1_02", "MH_04"}) {
    RecordedMotion motion;
    ASSERT_TRUE(readRecordedMotion(data + "/" + name, WindowOptions().max_imu_gap_s, &motion).ok());
    const GyroBiasFit fit = fitGyroBias(motion.imu, motion.truth);
    ASSERT_TRUE(fit.ok) << fit.message;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const NavState& state : motion.truth) mean += state.gyro_bias;
    mean /= static_cast<double>(motion.truth.size());
    // 0.1 % of the bias; the recorded one is itself an estimate.
    EXPECT_NEAR((fit.bias - mean).norm(), 0.0, 8e-5) << name << " " << fit.message;
  }
}

TEST(NearestState, PicksTheCloserNeighbour) {
  std::vector<NavState> states(3);
  states[0].t = 0.0;
  states[1].t = 1.0;
  states[2].t = 2.0;
  EXPECT_EQ(nearestState(states, -5.0), 0);
  EXPECT_EQ(nearestState(states, 0.4), 0);
  EXPECT_EQ(nearestState(states, 0.6), 1);
  EXPECT_EQ(nearestState(states, 1.0), 1);
  EXPECT_EQ(nearestState(states, 9.0), 2);
  EXPECT_EQ(nearestState({}, 1.0), -1);
}

}  // namespace
}  // namespace slim_init::evaluation
