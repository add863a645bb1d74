// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An initializer that shares nothing with ours but the interface, behind the host adapter and in a
// host: an implementation of IInitializer needs no KeyframeWindow.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include "support/text_parts.h"
#include "vins_adapter/host_streams.h"
#include "vins_adapter/oracle.h"

namespace slim_init::vins_adapter {
namespace {

class ForeignInitializer : public FedAdapter {
 protected:
  ForeignInitializer() { makeOracle(); }
  void makeOracle(double readout_s = 0.0) {
    auto oracle = std::make_unique<Oracle>(exact_, readout_s);
    oracle_ = oracle.get();
    make(std::move(oracle));
  }

  Oracle* oracle_ = nullptr;
};

TEST_F(ForeignInitializer, SeedsAndRecoversAHost) {
  EXPECT_EQ(adapter_->info().method, "oracle");
  EXPECT_EQ(adapter_->info().window_span_s, 0.7);
  feed(0, 6);
  HostResult answer = adapter_->seed(stamps(6));
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.message, "the oracle needs eight frames");

  feed(7, 20);
  answer = adapter_->seed(stamps(20));
  ASSERT_TRUE(answer.success()) << answer.message;
  ASSERT_EQ(answer.window.states.size(), static_cast<std::size_t>(kHostFrames));
  EXPECT_EQ(answer.window.states[0].P, Eigen::Vector3d::Zero());
  EXPECT_NEAR(hostYaw(answer.window.states[0].R), 0.0, 1e-12);
  EXPECT_NEAR((answer.window.states[10].P - answer.window.states[2].P).norm(),
              (exact_.truth[20].p_w_b - exact_.truth[12].p_w_b).norm(), 1e-3);
  EXPECT_FALSE(answer.frame.ok);
  // The host flies in the true frame and fails.
  feed(21, 30);
  const HostResult again = adapter_->recover(stamps(30), {toHostState(exact_.truth[24], 0.0)});
  ASSERT_TRUE(again.success()) << again.message;
  EXPECT_TRUE(again.frame.ok);
  for (int i = 0; i < kHostFrames; ++i) {
    EXPECT_LT((again.window.states[i].P - exact_.truth[20 + i].p_w_b).norm(), 2e-3) << i;
    EXPECT_LT((again.window.states[i].V - exact_.truth[20 + i].v_w_b).norm(), 2e-3) << i;
  }
}

// All healthy states that differ in what they know go to the initializer, ascending in time.
TEST_F(ForeignInitializer, ReceivesTheHealthyStates) {
  feed(0, 30);
  const std::vector<HostState> healthy = statesOf(20, 24);
  ASSERT_TRUE(adapter_->recover(stamps(30), {healthy}).success());
  ASSERT_EQ(oracle_->given.size(), 2u) << "at least a quarter of a second apart";
  EXPECT_NEAR(oracle_->given[0].state.t, exact_.truth[21].t, 1e-9);
  EXPECT_NEAR(oracle_->given[1].state.t, exact_.truth[24].t, 1e-9);
  EXPECT_EQ(oracle_->given[1].state.v_w_b, exact_.truth[24].v_w_b);
  EXPECT_GT(oracle_->given[1].covariance.diagonal().tail<9>().minCoeff(), 0.0);
  oracle_->recovers = false;
  EXPECT_EQ(adapter_->recover(stamps(30), {healthy}).message, "oracle has no recovery");
}

// What an IMU has not measured from a healthy state on is passed; later, a host that has had no
// healthy state for a second has been carried by what is wrong.
TEST_F(ForeignInitializer, HealthyStatesArePropagatedOverTheDamageThatFollows) {
  const std::vector<HostState> healthy = statesOf(10, 12);
  const std::vector<ImuSample> clean = exact_.imu;
  for (const int damaged : {13, 24}) {
    const double first = exact_.truth[damaged].t + 0.02;
    exact_.imu = host_health::disturbed(clean, first, first + 0.2, {120.0, 0.0, 0.0});
    makeOracle();
    feed(0, 32);
    adapter_->recover(stamps(32), healthy);
    ASSERT_FALSE(oracle_->given.empty());
    const double t = oracle_->given.back().state.t;
    EXPECT_EQ(t > first, damaged == 13) << t;
    EXPECT_EQ(t<exact_.truth[13].t, damaged> 13) << t;
  }
}

TEST_F(ForeignInitializer, CountsRestartsAndTimeOffsetAreItsOwn) {
  feed(0, 20);
  EXPECT_EQ(adapter_->info().counts.frames.added(), 21);
  EXPECT_EQ(
      adapter_->addImu(exact_.imu[next_].t, Eigen::Vector3d(400, 0, 0), Eigen::Vector3d::Zero()),
      AddStatus::kGlitch);
  EXPECT_EQ(adapter_->addLines(exact_.keyframes[20].t, exact_.keyframes[20].lines),
            AddStatus::kNotSupported);
  adapter_->setTd(0.25);
  EXPECT_EQ(adapter_->info().calibration.td, 0.25);
  next_ = 0;
  feed(0, 0);
  EXPECT_EQ(adapter_->info().counts.restarts(), 1);
  EXPECT_FALSE(adapter_->seed(stamps(20)).success());
}

// What was learned in flight is there for starts and recoveries, and not for the watchdog, which is
// to judge by itself.
TEST_F(ForeignInitializer, IsToldWhatIsKnownOfTheSensors) {
  feed(0, 20);
  ASSERT_TRUE(adapter_->seed(stamps(20)).success());
  EXPECT_FALSE(std::isfinite(oracle_->known_sensors.biases.accel_sigma));
  HostState healthy = toHostState(exact_.truth[20], 0.0);
  healthy.Ba = Eigen::Vector3d(0.1, 0.2, 0.3);
  const double end = healthy.stamp;
  for (int i = 250; i >= 0; --i) {
    healthy.stamp = end - 0.1 * i;
    adapter_->learn(healthy);
  }
  ASSERT_TRUE(adapter_->recover(stamps(20), {healthy}).success());
  EXPECT_EQ(oracle_->known_sensors.biases.accel, healthy.Ba);
  EXPECT_LT(oracle_->known_sensors.biases.accel_sigma, 0.05);
  watch(statesOf(10, 20));
  EXPECT_FALSE(std::isfinite(oracle_->known_sensors.biases.accel_sigma));
  // A restart of the streams forgets the states, not the sensors, which then are of another run.
  adapter_->seed(stamps(20));
  const double sigma = oracle_->known_sensors.biases.accel_sigma;
  next_ = 0;
  feed(0, 0);
  adapter_->seed(stamps(20));
  EXPECT_EQ(oracle_->known_sensors.biases.accel, healthy.Ba);
  EXPECT_GT(oracle_->known_sensors.biases.accel_sigma, sigma);
}

// A bias that has jumped is suspect until a window solved anew agrees with the host.
TEST_F(ForeignInitializer, AJumpOfABiasIsJudgedByAnAnswer) {
  feed(0, 20);
  std::vector<HostState> window = statesOf(17, 20);
  EXPECT_FALSE(watch(window).suspect);
  for (HostState& state : window) state.Ba.x() += 0.6;
  const HostHealth jumped = watch(window);
  EXPECT_TRUE(jumped.suspect);
  EXPECT_TRUE(jumped.healthy) << jumped.reason;
  expectParts(jumped.reason, "accelerometer bias has moved");
  EXPECT_FALSE(watch(window).suspect) << "the answer agreed";
  // The states of another flight are no jump.
  adapter_->flightEnded();
  for (HostState& state : window) state.Ba.x() -= 0.6;
  EXPECT_FALSE(watch(window).suspect);
}

// The initializer does not see damage of the IMU data: over a little of it, its answer is no
// evidence. Where most of its window is damaged a host would never be judged.
TEST_F(ForeignInitializer, AWindowOverLittleDamageDoesNotSpeakAgainstTheHost) {
  constexpr int kDamaged = 20;
  const std::vector<ImuSample> clean = exact_.imu;
  const double first = exact_.truth[kDamaged].t + 0.02;
  struct Case {
    double seconds;
    std::vector<int> speaks, silent;  // frames; the oracle's window has 0.6 s
  };
  for (const Case& one : {Case{0.2, {17, 20, 29, 34}, {23, 24, 25, 26, 27, 28}},
                          Case{0.45, {17, 20, 27, 34}, {28, 29, 30}}}) {
    exact_.imu = host_health::disturbed(clean, first, first + one.seconds, {120.0, 0.0, 0.0});
    makeOracle();
    std::set<int> contradicted;
    for (int k = 0; k < 35; ++k) {
      feed(k, k);
      if (k < 3) continue;
      std::vector<HostState> window = statesOf(k - 3, k);
      for (HostState& state : window) state.V *= 3.0;
      if (contains(watch(window).reason, "independent window")) contradicted.insert(k);
    }
    for (const int k : one.speaks) EXPECT_EQ(contradicted.count(k), 1u) << one.seconds << ", " << k;
    for (const int k : one.silent) EXPECT_EQ(contradicted.count(k), 0u) << one.seconds << ", " << k;
  }
}

// Nor does it see what moves in the images. For ever that is no excuse: the host may have its poses
// wrong.
TEST_F(ForeignInitializer, AWindowOverAViewThatMovesDoesNotSpeakAgainstTheHost) {
  constexpr int kBegin = 20, kEnd = 80;
  exact_ = makeExactWindow(atTenHertz(kEnd));
  for (int k = kBegin; k < kEnd; ++k) {
    const double shift = 8.0 * (k % 10 - 4) / exact_.calibration.focal_px;
    for (PointObservation& point : exact_.keyframes[k].points) {
      if (point.id % 10 >= 5) continue;
      point.bearing = (point.bearing + shift * Eigen::Vector3d(1.0, 0.5, 0.0)).normalized();
    }
  }
  makeOracle();
  oracle_->then = [](const Priors& /*priors*/, InitResult* result) {
    for (NavState& state : result->states) {
      state.R_w_b = expSO3(Eigen::Vector3d(0.15, 0.0, 0.0)) * state.R_w_b;
    }
  };
  feed(0, kHostFrames - 2);
  for (int k = kHostFrames - 1; k < kEnd; ++k) {
    feed(k, k);
    const HostPreparation frame =
        adapter_->prepare(window(k), exact_.calibration.R_b_c, exact_.calibration.t_b_c);
    EXPECT_EQ(frame.moving.size() > 10, k >= kBegin) << k << ' ' << frame.message;
    const bool speaks = contains(watch(window(k)).reason, "independent window");
    // Between the two a part of the oracle's window is from before.
    if (k >= kBegin + 48 && k <= kBegin + 55) continue;
    EXPECT_EQ(speaks, k < kBegin || k > kBegin + 48) << k;
  }
}

// Rolling shutter: every observation gets its row, whichever way it comes.
TEST_F(ForeignInitializer, RowsAreSet) {
  FrameObservation frame = exact_.keyframes[0];
  ASSERT_FALSE(frame.points.empty());
  ASSERT_FALSE(frame.lines.empty());
  frame.points[0].pixel.y() = 120.0;
  frame.lines[0].start_pixel.y() = 480.0;
  frame.lines[0].end_pixel.y() = 240.0;
  frame.points[0].row = 0.5;  // as given, where the height is not known
  adapter_->addFrame(frame);
  EXPECT_EQ(oracle_->last_frame.points[0].row, 0.5);

  options_.image_height = 480;
  makeOracle(0.04);
  adapter_->addFrame(frame);
  EXPECT_NEAR(oracle_->last_frame.points[0].row, -0.25, 1e-12);
  EXPECT_NEAR(oracle_->last_frame.lines[0].start_row, 0.5, 1e-12);
  EXPECT_NEAR(oracle_->last_frame.lines[0].end_row, 0.0, 1e-12);
  EXPECT_EQ(adapter_->addLines(frame.t, frame.lines), AddStatus::kNotSupported);
  EXPECT_NEAR(oracle_->last_lines[0].start_row, 0.5, 1e-12);
}

// A host that changes its td: each frame is that of the IMU data it was paired with.
TEST_F(ForeignInitializer, EveryFrameHasItsOwnTd) {
  feed(0, 15);
  // From here on stamps 30 ms earlier and a td of 30 ms: the same exposures.
  const double td = 0.03;
  adapter_->setTd(td);
  for (int k = 16; k <= 20; ++k) {
    exact_.keyframes[k].t -= td;
    feed(k, k);
  }
  const HostResult answer = adapter_->seed(stamps(20));
  ASSERT_TRUE(answer.success()) << answer.message;
  for (int i = 1; i < kHostFrames; ++i) {
    EXPECT_NEAR((answer.window.states[i].P - answer.window.states[0].P).norm(),
                (exact_.truth[10 + i].p_w_b - exact_.truth[10].p_w_b).norm(), 2e-3)
        << i;
  }
}

// The adapter relies on success, so it checks it.
TEST_F(ForeignInitializer, ContradictionsAreNotPassedOn) {
  feed(0, 20);
  oracle_->then = [](const Priors&, InitResult* result) { result->states.clear(); };
  HostResult answer = adapter_->seed(stamps(20));
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.result.status, InitStatus::kNumericalFailure);
  EXPECT_EQ(answer.message, "oracle reported success without states");
  oracle_->then = nullptr;
  oracle_->too_few_states = true;
  answer = adapter_->seed(stamps(20));
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.message, "oracle returned 0 states for 11 stamps");
}

}  // namespace
}  // namespace slim_init::vins_adapter
