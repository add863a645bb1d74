// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An initializer that shares nothing with ours but the interface, behind the host adapter and in a
// host: an implementation of IInitializer needs no KeyframeWindow.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/initializer.h"
#include "slim_init/state_at.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "support/exact_window.h"
#include "support/text_parts.h"
#include "vins_adapter/host_streams.h"

namespace slim_init::vins_adapter {
namespace {

/// Knows the true state of every frame (in a world of its own, turned about z and shifted) and
/// keeps what it was given in plain vectors.
class Oracle : public IInitializer {
 public:
  explicit Oracle(const ExactWindow& exact, double readout_s = 0.0)
      : calibration_(exact.calibration) {
    calibration_.readout_s = readout_s;
    for (const NavState& state : exact.truth) {
      NavState moved = state;
      moved.R_w_b = turn_ * state.R_w_b;
      moved.p_w_b = turn_ * state.p_w_b + Eigen::Vector3d(7.0, -3.0, 2.0);
      moved.v_w_b = turn_ * state.v_w_b;
      truth_.push_back(moved);
    }
  }

  AddStatus addImu(const ImuSample& sample) override {
    const AddStatus status = check_.checkImu(sample);
    if (status == AddStatus::kRestarted) forget();
    if (isAdded(status)) imu_.push_back(sample);
    return status;
  }
  AddStatus addFrame(FrameObservation frame) override {
    const double t = calibration_.imuTime(frame.t);
    const AddStatus status = check_.checkFrame(t);
    if (status == AddStatus::kRestarted) forget();
    if (isAdded(status)) times_.push_back(t);
    last_frame = std::move(frame);
    return status;
  }
  AddStatus addLines(double /*stamp*/, std::vector<LineObservation> lines) override {
    last_lines = std::move(lines);
    return AddStatus::kNotSupported;
  }
  void setTd(double td) override { calibration_.td = td; }
  void reset() override {
    forget();
    check_ = StreamCheck(check_.options());
  }

  InitResult initialize(const Priors& priors) override {
    known_sensors = priors.sensors;
    InitResult result;
    if (times_.size() < 8) {
      result.status = InitStatus::kTooFewKeyframes;
      result.message = "the oracle needs eight frames";
      return result;
    }
    result.status = InitStatus::kSuccess;
    result.message = "as foretold";
    result.gravity_w = Eigen::Vector3d(0, 0, -calibration_.gravity_magnitude);
    // Every second frame, to have some between its keyframes.
    for (std::size_t i = times_.size() - 7; i < times_.size(); i += 2) {
      result.states.push_back(at(times_[i]));
    }
    result.gyro_bias = result.states.back().gyro_bias;
    result.accel_bias = result.states.back().accel_bias;
    if (contradict) result.states.clear();
    if (recovers && !priors.healthy.empty()) continueFrame(priors.healthy, &result);
    return result;
  }
  bool statesAt(const InitResult& result, const std::vector<double>& times, double max_reach_s,
                std::vector<NavState>* states, std::string* error) const override {
    if (too_few_states) return states->clear(), true;
    StateAtOptions options;
    options.max_reach_s = max_reach_s;
    return slim_init::statesAt(result, imu_, times, options, states, error);
  }

  InitializerInfo info() const override {
    InitializerInfo info;
    info.method = "oracle";
    info.calibration = calibration_;
    info.counts = check_.counts();
    if (!imu_.empty()) info.imu = {imu_.front().t, imu_.back().t};
    info.window_span_s = 0.7;
    return info;
  }

  FrameObservation last_frame;
  std::vector<LineObservation> last_lines;
  KnownSensors known_sensors;
  std::vector<StatePrior> given;  ///< healthy states
  bool recovers = true;
  bool contradict = false;      ///< success without states
  bool too_few_states = false;  ///< statesAt() forgets to fill them

 private:
  // Its world is exact: one rigid motion about z joins the two.
  void continueFrame(const std::vector<StatePrior>& healthy, InitResult* result) {
    given = healthy;
    const NavState& last_healthy = healthy.back().state;
    const NavState mine = at(last_healthy.t);
    const Eigen::Matrix3d R = last_healthy.R_w_b * mine.R_w_b.transpose();
    for (NavState& state : result->states) {
      state.R_w_b = R * state.R_w_b;
      state.p_w_b = R * (state.p_w_b - mine.p_w_b) + last_healthy.p_w_b;
      state.v_w_b = R * state.v_w_b;
    }
    result->frame_continued = true;
  }
  NavState at(double t) const {
    return *std::min_element(truth_.begin(), truth_.end(),
                             [t](const NavState& a, const NavState& b) {
                               return std::abs(a.t - t) < std::abs(b.t - t);
                             });
  }
  void forget() {
    imu_.clear();
    times_.clear();
  }

  Eigen::Matrix3d turn_ = expSO3(Eigen::Vector3d(0, 0, 1.1));
  Calibration calibration_;
  StreamCheck check_{StreamOptions::liveData()};
  std::vector<NavState> truth_;
  std::vector<ImuSample> imu_;
  std::vector<double> times_;
};

class ForeignInitializer : public ::testing::Test {
 protected:
  ForeignInitializer() {
    options_.reinit = true;
    options_.max_wait_ms = -1.0;
    make(std::make_unique<Oracle>(exact_));
  }

  void make(std::unique_ptr<Oracle> oracle) {
    oracle_ = oracle.get();
    adapter_ = adapterOf(std::move(oracle), options_);
    next_ = 0;
  }
  void feed(int k) { vins_adapter::feed(exact_, exact_.imu, k, k, &next_, adapter_.get()); }
  std::vector<double> stamps(int last) const { return stampsOf(exact_, last); }
  HostHealth watch(const std::vector<HostState>& states) {
    return adapter_->watch(states, exact_.calibration.R_b_c, exact_.calibration.t_b_c);
  }

  ExactWindow exact_ = makeExactWindow(atTenHertz(35));
  HostOptions options_;
  Oracle* oracle_ = nullptr;
  std::unique_ptr<HostAdapter> adapter_;
  std::size_t next_ = 0;
};

TEST_F(ForeignInitializer, SeedsAndRecoversAHost) {
  EXPECT_EQ(adapter_->method(), "oracle");
  EXPECT_EQ(adapter_->maxWindowSpan(), 0.7);
  for (int k = 0; k <= 6; ++k) feed(k);
  HostResult answer = adapter_->seed(stamps(6));
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.message, "the oracle needs eight frames");

  for (int k = 7; k <= 20; ++k) feed(k);
  answer = adapter_->seed(stamps(20));
  ASSERT_TRUE(answer.success()) << answer.message;
  ASSERT_EQ(answer.window.states.size(), static_cast<std::size_t>(kHostFrames));
  EXPECT_EQ(answer.window.states[0].P, Eigen::Vector3d::Zero());
  EXPECT_NEAR(hostYaw(answer.window.states[0].R), 0.0, 1e-12);
  EXPECT_NEAR((answer.window.states[10].P - answer.window.states[2].P).norm(),
              (exact_.truth[20].p_w_b - exact_.truth[12].p_w_b).norm(), 1e-3);
  EXPECT_FALSE(answer.frame.ok);
  // The host flies in the true frame and fails.
  for (int k = 21; k <= 30; ++k) feed(k);
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
  for (int k = 0; k <= 30; ++k) feed(k);
  const std::vector<HostState> healthy = statesOf(exact_, 20, 24);
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
  const std::vector<HostState> healthy = statesOf(exact_, 10, 12);
  const std::vector<ImuSample> clean = exact_.imu;
  for (const int damaged : {13, 24}) {
    const double first = exact_.truth[damaged].t + 0.02;
    exact_.imu = host_health::disturbed(clean, first, first + 0.2, {120.0, 0.0, 0.0});
    make(std::make_unique<Oracle>(exact_));
    for (int k = 0; k < 33; ++k) feed(k);
    adapter_->recover(stamps(32), healthy);
    ASSERT_FALSE(oracle_->given.empty());
    const double t = oracle_->given.back().state.t;
    EXPECT_EQ(t > first, damaged == 13) << t;
    EXPECT_EQ(t<exact_.truth[13].t, damaged> 13) << t;
  }
}

TEST_F(ForeignInitializer, CountsRestartsAndTimeOffsetAreItsOwn) {
  for (int k = 0; k <= 20; ++k) feed(k);
  EXPECT_EQ(adapter_->counts().frames.added(), 21);
  EXPECT_EQ(
      adapter_->addImu(exact_.imu[next_].t, Eigen::Vector3d(400, 0, 0), Eigen::Vector3d::Zero()),
      AddStatus::kGlitch);
  EXPECT_EQ(adapter_->addLines(exact_.keyframes[20].t, exact_.keyframes[20].lines),
            AddStatus::kNotSupported);
  adapter_->setTd(0.25);
  EXPECT_EQ(adapter_->calibration().td, 0.25);
  next_ = 0;
  feed(0);
  EXPECT_EQ(adapter_->counts().restarts(), 1);
  EXPECT_FALSE(adapter_->seed(stamps(20)).success());
}

// What was learned in flight is there for starts and recoveries, and not for the watchdog, which is
// to judge by itself.
TEST_F(ForeignInitializer, IsToldWhatIsKnownOfTheSensors) {
  for (int k = 0; k <= 20; ++k) feed(k);
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
  watch(statesOf(exact_, 10, 20));
  EXPECT_FALSE(std::isfinite(oracle_->known_sensors.biases.accel_sigma));
  // A restart of the streams forgets the states, not the sensors, which then are of another run.
  adapter_->seed(stamps(20));
  const double sigma = oracle_->known_sensors.biases.accel_sigma;
  next_ = 0;
  feed(0);
  adapter_->seed(stamps(20));
  EXPECT_EQ(oracle_->known_sensors.biases.accel, healthy.Ba);
  EXPECT_GT(oracle_->known_sensors.biases.accel_sigma, sigma);
}

// A bias that has jumped is suspect until a window solved anew agrees with the host.
TEST_F(ForeignInitializer, AJumpOfABiasIsJudgedByAnAnswer) {
  for (int k = 0; k <= 20; ++k) feed(k);
  std::vector<HostState> window = statesOf(exact_, 17, 20);
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
    make(std::make_unique<Oracle>(exact_));
    std::set<int> contradicted;
    for (int k = 0; k < 35; ++k) {
      feed(k);
      if (k < 3) continue;
      std::vector<HostState> window = statesOf(exact_, k - 3, k);
      for (HostState& state : window) state.V *= 3.0;
      if (contains(watch(window).reason, "independent window")) contradicted.insert(k);
    }
    for (const int k : one.speaks) EXPECT_EQ(contradicted.count(k), 1u) << one.seconds << ", " << k;
    for (const int k : one.silent) EXPECT_EQ(contradicted.count(k), 0u) << one.seconds << ", " << k;
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
  make(std::make_unique<Oracle>(exact_, 0.04));
  adapter_->addFrame(frame);
  EXPECT_NEAR(oracle_->last_frame.points[0].row, -0.25, 1e-12);
  EXPECT_NEAR(oracle_->last_frame.lines[0].start_row, 0.5, 1e-12);
  EXPECT_NEAR(oracle_->last_frame.lines[0].end_row, 0.0, 1e-12);
  adapter_->addLines(frame.t, frame.lines);
  EXPECT_NEAR(oracle_->last_lines[0].start_row, 0.5, 1e-12);
}

// A host that changes its td: each frame is that of the IMU data it was paired with.
TEST_F(ForeignInitializer, EveryFrameHasItsOwnTd) {
  for (int k = 0; k <= 15; ++k) feed(k);
  // From here on stamps 30 ms earlier and a td of 30 ms: the same exposures.
  const double td = 0.03;
  adapter_->setTd(td);
  for (int k = 16; k <= 20; ++k) {
    exact_.keyframes[k].t -= td;
    feed(k);
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
  for (int k = 0; k <= 20; ++k) feed(k);
  oracle_->contradict = true;
  HostResult answer = adapter_->seed(stamps(20));
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.result.status, InitStatus::kNumericalFailure);
  EXPECT_EQ(answer.message, "oracle reported success without states");
  oracle_->contradict = false;
  oracle_->too_few_states = true;
  answer = adapter_->seed(stamps(20));
  EXPECT_FALSE(answer.success());
  EXPECT_EQ(answer.message, "oracle returned 0 states for 11 stamps");
}

}  // namespace
}  // namespace slim_init::vins_adapter
