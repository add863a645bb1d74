// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The adapter as a host drives it: frames at 10 Hz, windows of eleven of them.
#include "slim_init/vins_adapter/host_adapter.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <thread>

#include "geometry/so3.h"
#include "support/text_parts.h"
#include "vins_adapter/host_streams.h"

namespace slim_init::vins_adapter {
namespace {

class HostAdapterTest : public FedAdapter {
 protected:
  HostAdapterTest() { make(exact_.calibration); }
  using FedAdapter::make;
  void make(const Calibration& calibration) {
    make(makeInitializer(calibration, InitializerOptions()));
  }
  // With biases of zero.
  HostState healthy(int k) const {
    HostState state = toHostState(exact_.truth[k], 0.0);
    state.Ba = state.Bg = Eigen::Vector3d::Zero();
    return state;
  }
};

// Largest errors against the truth, after the turn and shift that put frame 0 of the answer there.
void expectTruth(const HostResult& answer, const std::vector<NavState>& truth, int first,
                 bool aligned, double tolerance) {
  const NavState& origin = truth[first];
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  if (aligned) {
    R = expSO3(Eigen::Vector3d(0.0, 0.0, -hostYaw(origin.R_w_b)));
    p = origin.p_w_b;
  }
  for (std::size_t i = 0; i < answer.window.states.size(); ++i) {
    const NavState& true_state = truth[first + i];
    const HostState& state = answer.window.states[i];
    EXPECT_LT((state.P - R * (true_state.p_w_b - p)).norm(), tolerance) << i;
    EXPECT_LT((state.V - R * true_state.v_w_b).norm(), tolerance) << i;
    EXPECT_LT(logSO3(state.R.transpose() * R * true_state.R_w_b).norm(), tolerance) << i;
    EXPECT_LT((state.Bg - true_state.gyro_bias).norm(), tolerance) << i;
    EXPECT_LT((state.Ba - true_state.accel_bias).norm(), 10.0 * tolerance) << i;
  }
}

TEST_F(HostAdapterTest, FillsEveryFrameOfTheHost) {
  feed(0, 30);
  const HostResult answer = adapter_->seed(stamps(30));
  ASSERT_TRUE(answer.success()) << answer.message;
  ASSERT_EQ(answer.window.states.size(), static_cast<std::size_t>(kHostFrames));
  EXPECT_EQ(answer.window.G, Eigen::Vector3d(0, 0, exact_.calibration.gravity_magnitude));
  EXPECT_EQ(answer.window.states[0].P, Eigen::Vector3d::Zero());
  EXPECT_NEAR(hostYaw(answer.window.states[0].R), 0.0, 1e-12);
  for (int i = 0; i < kHostFrames; ++i) {
    EXPECT_EQ(answer.window.states[i].stamp, exact_.keyframes[20 + i].t) << "bit for bit";
  }
  // Every second frame is no keyframe of ours: 31 frames in 3 s.
  EXPECT_EQ(answer.result.states.size(), 15u);
  expectTruth(answer, exact_.truth, 20, true, 2e-3);
  EXPECT_FALSE(answer.frame.ok);
  EXPECT_NEAR(answer.data_s, 3.0, 1e-6);
}

TEST_F(HostAdapterTest, FramesBeforeAndAfterOurWindow) {
  options_.max_reach_s = 0.3;
  make(exact_.calibration);
  feed(0, 34);
  // The window spans 3 s; the host needs frames 3.2 s and 3.4 s back.
  std::vector<double> old = stamps(34);
  old.front() = exact_.keyframes[2].t;
  EXPECT_TRUE(adapter_->seed(old).success());
  old.front() = exact_.keyframes[0].t;
  HostResult answer = adapter_->seed(old);
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.result.status, InitStatus::kTooFewKeyframes);
  expectParts(answer.message, "s before the window (limit 0.3 s)");
  // A frame that the IMU does not cover yet.
  std::vector<double> early = stamps(34);
  early.push_back(exact_.keyframes[34].t + 0.1);
  answer = adapter_->seed(early);
  EXPECT_FALSE(answer.success());
  expectParts(answer.message, "do not cover");
}

// In slow motion the host's keyframes lie far apart: here they reach 1.2 s further back than our
// window, which is told to be shorter. Without an option on the reach the host is filled
// nevertheless.
TEST_F(HostAdapterTest, FillsTheLongWindowOfSlowMotion) {
  InitializerOptions shorter;
  shorter.window.max_span_s = 2.2;
  make(makeInitializer(exact_.calibration, shorter));
  feed(0, 34);
  std::vector<double> requested;
  std::vector<NavState> truth;
  for (int i = 0; i < kHostFrames; ++i) {
    const int k = 34 * i / (kHostFrames - 1);
    requested.push_back(exact_.keyframes[k].t);
    truth.push_back(exact_.truth[k]);
  }
  const HostResult answer = adapter_->seed(requested);
  ASSERT_TRUE(answer.success()) << answer.message;
  EXPECT_GT(answer.result.states.front().t - truth.front().t, 1.1);
  expectTruth(answer, truth, 0, true, 5e-3);
}

// A host that stands keeps the first frames of its window, and replaces the newest: they are twelve
// seconds old, beyond the reach and beyond the buffer, when it moves.
TEST_F(HostAdapterTest, AllFramesOfAWindowThatStoodHaveStates) {
  ExactWindowOptions options = atTenHertz(140);
  options.motion = Motion::kFromRest;
  options.rest_s = 12.0;
  options.points = 300;
  options.lines = 0;
  options.pixel_noise = 0.3;
  exact_ = makeExactWindow(options);
  make(exact_.calibration);
  std::vector<double> window;
  std::vector<int> frames;
  HostResult answer;
  for (int k = 0; k < options.keyframes && !answer.success(); ++k) {
    feed(k, k);
    if (static_cast<int>(frames.size()) == kHostFrames) {
      // Parallax makes the oldest leave, otherwise the newest is replaced.
      frames.erase(exact_.truth[k].t > options.rest_s + 0.2 ? frames.begin() : frames.end() - 1);
    }
    frames.push_back(k);
    if (static_cast<int>(frames.size()) < kHostFrames) continue;
    window.clear();
    for (const int frame : frames) window.push_back(exact_.keyframes[frame].t);
    answer = adapter_->seed(window);
    if (exact_.truth[k].t > 2.0 && exact_.truth[k].t < options.rest_s) {
      EXPECT_EQ(answer.result.status, InitStatus::kStationary) << answer.message;
    }
  }
  ASSERT_TRUE(answer.success()) << answer.message;
  EXPECT_LT(answer.window.states.front().stamp, 1.0);
  const double seconds = answer.window.states.back().stamp - options.rest_s;
  EXPECT_LT(seconds, 0.8);
  ASSERT_EQ(answer.window.states.size(), static_cast<std::size_t>(kHostFrames));
  const NavState& start = exact_.truth.front();
  const Eigen::Matrix3d R = answer.window.states.front().R * start.R_w_b.transpose();
  for (int i = 0; i < kHostFrames; ++i) {
    const NavState& truth = exact_.truth[frames[i]];
    const HostState& state = answer.window.states[i];
    // Origin and heading where it stood.
    EXPECT_LT((state.P - R * (truth.p_w_b - start.p_w_b)).norm(), 0.01) << i;
    EXPECT_LT((state.V - R * truth.v_w_b).norm(), 0.05) << i;
    EXPECT_LT(logSO3(state.R.transpose() * R * truth.R_w_b).norm(), 0.02) << i;
  }
  // What the back end is given of its first frame is what is known at rest.
  EXPECT_EQ(answer.window.prior.size(), 11u * HostWindow::kPriorColumns);
}

TEST_F(HostAdapterTest, TimeOffset) {
  // The same data, stamped 20 ms early by the camera; td comes from the calibration or the host.
  const double td = 0.02;
  for (const bool by_host : {false, true}) {
    Calibration calibration = exact_.calibration;
    if (!by_host) calibration.td = td;
    make(calibration);
    if (by_host) adapter_->setTd(td);
    for (int k = 0; k <= 33; ++k) exact_.keyframes[k].t = exact_.truth[k].t - td;
    feed(0, 33);
    const std::vector<double> requested = stamps(33);
    const HostResult answer = adapter_->seed(requested);
    ASSERT_TRUE(answer.success()) << answer.message;
    EXPECT_EQ(answer.window.states[4].stamp, requested[4]);
    expectTruth(answer, exact_.truth, 33 - kHostFrames + 1, true, 2e-3);
    EXPECT_EQ(adapter_->info().calibration.td, td);
  }
}

TEST_F(HostAdapterTest, RecoveryContinuesTheOldFrame) {
  feed(0, 30);
  // Tilt and velocity of the failed host do not matter, position and yaw do.
  HostState last = healthy(24);
  const HostResult right = adapter_->recover(stamps(30), {last});
  ASSERT_TRUE(right.success()) << right.message;
  EXPECT_LT(right.frame.position_sigma, 0.1);
  last.V += Eigen::Vector3d(3.0, -2.0, 1.0);
  const HostResult answer = adapter_->recover(stamps(30), {last});
  ASSERT_TRUE(answer.success()) << answer.message;
  EXPECT_TRUE(answer.frame.ok);
  expectTruth(answer, exact_.truth, 20, false, 2e-3);
  // With that velocity it may have flown since no solve has agreed with it.
  EXPECT_GT(answer.frame.position_sigma, 3.0 * (last.stamp - exact_.keyframes[0].t));
  EXPECT_GT(answer.frame.start_sigma, 3.0 * (last.stamp - exact_.keyframes[0].t))
      << "nor does a position that is held know better";
  EXPECT_LT(right.frame.start_sigma, 0.1);
}

// The flight has ended, and a start goes on from its last state: it was correct until then.
TEST_F(HostAdapterTest, AFlightThatHasEndedWasCorrectSinceItsStart) {
  feed(0, 22);
  ASSERT_TRUE(adapter_->seed(stamps(22)).success());
  feed(23, 34);
  adapter_->flightEnded();
  HostState last = healthy(26);
  last.V += Eigen::Vector3d(3.0, -2.0, 1.0);
  const HostResult answer = adapter_->recover(stamps(34), {last});
  ASSERT_TRUE(answer.success()) << answer.message;
  const double since = last.stamp - exact_.keyframes[22].t;
  EXPECT_GT(answer.frame.position_sigma, 3.0 * since);
  EXPECT_LT(answer.frame.position_sigma, 5.0 * since);
}

// IMU data are kept for 10 s.
TEST_F(HostAdapterTest, ALostStateIsCarriedBeyondTheBuffer) {
  constexpr int kImages = 150;
  exact_ = makeExactWindow(atTenHertz(kImages));
  for (const bool lost : {false, true}) {
    make(exact_.calibration);
    const HostState last = toHostState(exact_.truth[4], 0.0);
    for (int k = 0; k < kImages; ++k) {
      // Images may be missing for long.
      if (k < 30 || k > 130) feed(k, k);
      if (lost && k == 5) adapter_->lose(last);
    }
    const NavState& now = exact_.truth.back();
    const HostPropagation there = adapter_->propagate(last, exact_.keyframes.back().t);
    EXPECT_EQ(there.ok, lost) << there.message;
    if (!lost) continue;
    EXPECT_LT((there.state.P - now.p_w_b).norm(), 0.5);
    EXPECT_LT(logSO3(there.state.R.transpose() * now.R_w_b).norm(), 0.01);
    EXPECT_GT(there.position_sigma, 5.0);
    const HostResult answer = adapter_->recover(stamps(kImages - 1), {last});
    ASSERT_TRUE(answer.success()) << answer.message;
    EXPECT_LT((answer.window.states.back().P - now.p_w_b).norm(), 0.5);
    adapter_->learn(toHostState(now, 0.0));
    EXPECT_FALSE(adapter_->propagate(last, exact_.keyframes.back().t).ok) << "there is a newer one";
  }
}

// Samples that are missing for seconds have one error, not one for each step.
TEST_F(HostAdapterTest, ALostStateHasTheWholeErrorOfAGap) {
  exact_ = makeExactWindow(atTenHertz(130));
  const double begin = exact_.truth[4].t;
  exact_.imu = withGap(exact_.imu, begin + 1.5, begin + 4.0);
  const HostState last = toHostState(exact_.truth[4], 0.0);
  std::map<bool, double> sigma;
  for (const bool lost : {false, true}) {
    make(exact_.calibration);
    const int newest = lost ? 106 : 102;  // the samples of ten seconds are kept
    for (int k = 0; k <= newest; ++k) {
      feed(k, k);
      if (lost && k == 5) adapter_->lose(last);
    }
    const HostPropagation there = adapter_->propagate(last, exact_.keyframes[newest].t);
    ASSERT_TRUE(there.ok) << lost << there.message;
    sigma[lost] = there.position_sigma;
  }
  EXPECT_GT(sigma[true], 0.95 * sigma[false]);
  EXPECT_LT(sigma[true], 1.3 * sigma[false]);
}

// In hover the host's window reaches further back than ours and the reach of the IMU: there the
// host gets what it knew.
TEST_F(HostAdapterTest, RecoveryKeepsWhatTheHostKnewBeforeOurWindow) {
  options_.max_reach_s = 0.3;
  make(exact_.calibration);
  feed(0, 34);
  std::vector<double> requested = stamps(34);
  requested[0] = exact_.keyframes[0].t;
  requested[1] = exact_.keyframes[1].t;
  std::vector<HostState> known = {healthy(0), healthy(1), healthy(28)};
  known[1].stamp += 1e-8;  // added to td and back
  known[1].P.z() += 0.01;  // not what the IMU says
  const HostResult answer = adapter_->recover(requested, known);
  ASSERT_TRUE(answer.success()) << answer.message;
  ASSERT_EQ(answer.window.states.size(), requested.size());
  for (std::size_t i = 0; i < requested.size(); ++i) {
    EXPECT_EQ(answer.window.states[i].stamp, requested[i]) << "bit for bit";
  }
  EXPECT_EQ(answer.window.states[0].P, known[0].P);
  EXPECT_EQ(answer.window.states[1].P, known[1].P);
  EXPECT_LT((answer.window.states[2].P - exact_.truth[26].p_w_b).norm(), 0.02);
  EXPECT_EQ(answer.window.prior.size(), 11u * HostWindow::kPriorColumns);
  // One of them is not known.
  known.erase(known.begin() + 1);
  const HostResult refused = adapter_->recover(requested, known);
  EXPECT_FALSE(refused.success());
  EXPECT_FALSE(refused.pending) << "no later frame would change it";
  expectParts(refused.message, "s before the window (limit 0.3 s)");
}

// A spike in the first sample that is not before the newest frame: it arrives and is not used, so
// that no solution reaches the frame. The next frame has the samples.
TEST_F(HostAdapterTest, RecoveryIsPendingWhileTheNewestSampleIsHeldBack) {
  feed(0, 29);
  for (; exact_.imu[next_].t < exact_.keyframes[30].t; ++next_) {
    adapter_->addImu(exact_.imu[next_].t, exact_.imu[next_].accel, exact_.imu[next_].gyro);
  }
  const ImuSample& hit = exact_.imu[next_++];
  adapter_->addImu(hit.t, hit.accel + Eigen::Vector3d(380.0, -190.0, 270.0), hit.gyro);
  adapter_->addFrame(exact_.keyframes[30]);
  const std::vector<HostState> known = {healthy(24)};
  const HostResult held = adapter_->recover(stamps(30), known);
  EXPECT_FALSE(held.success());
  EXPECT_TRUE(held.pending) << held.message;
  EXPECT_TRUE(adapter_->bridge(stamps(30), {healthy(20), healthy(24)}).success());
  feed(31, 31);
  const HostResult next = adapter_->recover(stamps(31), known);
  EXPECT_TRUE(next.success()) << next.message;
  EXPECT_FALSE(next.pending);
}

TEST_F(HostAdapterTest, RecoveryDeclinesWhereItCannot) {
  feed(0, 3);
  EXPECT_EQ(adapter_->recover(stamps(3, 4), {healthy(2)}).result.status,
            InitStatus::kTooFewKeyframes);
  HostState bad = healthy(2);
  bad.P.x() = kNotComputed;
  EXPECT_EQ(adapter_->recover(stamps(3, 4), {bad}).result.status, InitStatus::kInvalidInput);
  std::string error;
  const auto off = HostAdapter::create(makeInitializer(exact_.calibration, InitializerOptions()),
                                       HostOptions(), &error);
  expectParts(off->recover(stamps(3, 4), {healthy(2)}).message, "reinit: 0");
}

TEST_F(HostAdapterTest, AStreamThatJumpsBackStartsAnew) {
  feed(0, 30);
  const ImuSample late = exact_.imu[10];
  // A little late: one message out of order.
  EXPECT_EQ(adapter_->addImu(exact_.imu[next_ - 1].t - 0.5, late.accel, late.gyro),
            AddStatus::kOutOfOrder);
  EXPECT_EQ(adapter_->info().counts.imu[AddStatus::kOutOfOrder], 1);
  EXPECT_EQ(adapter_->info().counts.restarts(), 0);
  // A bag played again: its first sample may be a stray one, the second confirms it.
  EXPECT_EQ(adapter_->addImu(late.t, late.accel, late.gyro), AddStatus::kStray);
  EXPECT_TRUE(adapter_->seed(stamps(30)).success());
  const ImuSample next = exact_.imu[11];
  EXPECT_EQ(adapter_->addImu(next.t, next.accel, next.gyro), AddStatus::kRestarted);
  EXPECT_EQ(adapter_->info().counts.restarts(), 1);
  EXPECT_EQ(adapter_->seed(stamps(30)).result.status, InitStatus::kTooFewKeyframes);
  next_ = 12;
  feed(1, 31);
  const HostResult answer = adapter_->seed(stamps(31));
  EXPECT_TRUE(answer.success()) << answer.message;
  EXPECT_NEAR(answer.data_s, 3.0, 1e-6) << "since the restart";
}

TEST_F(HostAdapterTest, BadStampsAndArguments) {
  feed(0, 30);
  EXPECT_EQ(adapter_->seed({}).message, "the host's window is empty");
  std::vector<double> requested = stamps(30);
  requested[3] = kNotComputed;
  EXPECT_EQ(adapter_->seed(requested).message, "stamp 3 of the host's window is not finite");
  requested[3] = requested[2];
  EXPECT_EQ(adapter_->seed(requested).message,
            "stamp 3 of the host's window is 0 s after the one before, must be after it");
  std::string error;
  EXPECT_EQ(HostAdapter::create(nullptr, HostOptions(), &error), nullptr);
  EXPECT_EQ(error, "the initializer is null");
  HostOptions reach, short_wait, long_wait, height;
  reach.max_reach_s = -1.0;
  short_wait.max_wait_ms = -2.0;
  long_wait.max_wait_ms = 1001.0;
  height.image_height = -1;
  for (const auto& [options, message] :
       {std::pair(reach, "max_reach_s is -1, must be in [0, 60]"),
        std::pair(short_wait, "max_wait_ms is -2, must be in [-1, 1000]"),
        std::pair(long_wait, "max_wait_ms is 1001, must be in [-1, 1000]"),
        std::pair(height, "image_height is -1, must be in [0, 100000]")}) {
    auto initializer = makeInitializer(exact_.calibration, InitializerOptions());
    EXPECT_EQ(HostAdapter::create(std::move(initializer), options, &error), nullptr);
    EXPECT_EQ(error, message);
  }
}

TEST_F(HostAdapterTest, LinesFromAnotherThread) {
  std::atomic<int> fed{0};
  std::thread lines([&] {
    for (int k = 0; k <= 30; ++k) {
      while (fed < k) std::this_thread::yield();
      adapter_->addLines(exact_.keyframes[k].t, exact_.keyframes[k].lines);
    }
  });
  std::vector<FrameObservation> bare = exact_.keyframes;
  for (const ImuSample& s : exact_.imu) adapter_->addImu(s.t, s.accel, s.gyro);
  for (int k = 0; k <= 30; ++k) {
    bare[k].lines.clear();
    adapter_->addFrame(bare[k]);
    fed = k + 1;
    if (k >= 20) adapter_->seed(stamps(k));
  }
  lines.join();
  EXPECT_EQ(adapter_->info().counts.lines[AddStatus::kAdded], 31);
  EXPECT_TRUE(adapter_->seed(stamps(30)).success());
}

}  // namespace
}  // namespace slim_init::vins_adapter
