// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/init_session.h"

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/keyframe_window.h"
#include "slim_init/ros/stamp_clock.h"

namespace slim_init::node {
namespace {

/// Answers with the next of a list of statuses; the streams are real.
class ScriptedInitializer : public IInitializer {
 public:
  explicit ScriptedInitializer(double td = 0.0, double readout_s = 0.0)
      : window_(calibrationWith(td, readout_s), WindowOptions(), StreamOptions::liveData()) {}

  AddStatus addImu(const ImuSample& sample) override { return window_.addImu(sample); }
  AddStatus addFrame(FrameObservation frame) override {
    last_frame = frame;
    return window_.addFrame(std::move(frame));
  }
  AddStatus addLines(double stamp, std::vector<LineObservation> lines) override {
    last_lines = lines;
    const AddStatus status = window_.addLines(stamp, std::move(lines));
    if (status == AddStatus::kAdded) ++late_lines;
    return status;
  }
  void setTd(double td) override { window_.setTd(td); }
  InitResult initialize(const Priors& /*priors*/) override {
    InitResult result;
    result.status = script.empty() ? InitStatus::kTooFewKeyframes : script.front();
    if (!script.empty()) script.pop_front();
    return result;
  }
  bool statesAt(const InitResult& /*result*/, const std::vector<double>& /*times*/,
                double /*max_reach_s*/, std::vector<NavState>* /*states*/,
                std::string* /*error*/) const override {
    return false;
  }
  void reset() override { window_.reset(); }
  InitializerInfo info() const override {
    InitializerInfo info;
    info.calibration = window_.calibration();
    info.counts = window_.counts();
    return info;
  }

  std::deque<InitStatus> script;
  int late_lines = 0;
  FrameObservation last_frame;
  std::vector<LineObservation> last_lines;

 private:
  static Calibration calibrationWith(double td, double readout_s) {
    Calibration calibration;
    calibration.td = td;
    calibration.readout_s = readout_s;
    return calibration;
  }
  KeyframeWindow window_;
};

InitSessionOptions everyFrame(bool expect_lines) {
  InitSessionOptions options;
  options.attempt_interval_s = 0.0;
  options.expect_lines = expect_lines;
  return options;
}

class InitSessionTest : public ::testing::Test {
 protected:
  void startAt5s() {
    make(everyFrame(false));
    scripted_->script = {InitStatus::kSuccess};
    session_->addPoints(frame(5.0));
    next_imu_ = 4.9;
    imuUpTo(5.0);
    ASSERT_TRUE(session_->poll().has_value());
  }
  void make(const InitSessionOptions& options, double td = 0.0, double readout_s = 0.0) {
    auto initializer = std::make_unique<ScriptedInitializer>(td, readout_s);
    scripted_ = initializer.get();
    session_ = std::make_unique<InitSession>(std::move(initializer), options);
  }

  static FrameObservation frame(double t) {
    FrameObservation f;
    f.t = t;
    f.points.resize(1);
    f.points[0].id = 7;
    return f;
  }
  static std::vector<LineObservation> line() {
    std::vector<LineObservation> lines(1);
    lines[0].id = 3;
    lines[0].start_bearing = Eigen::Vector3d(0.1, 0.0, 1.0).normalized();
    return lines;
  }
  /// Samples every 5 ms; the last one is exactly at t.
  void imuUpTo(double t) {
    for (; next_imu_ < t - 0.0025; next_imu_ += 0.005) addImu(next_imu_);
    addImu(t);
    next_imu_ = t + 0.005;
  }
  void addImu(double t) {
    ImuSample sample;
    sample.t = t;
    sample.accel.z() = 9.81;
    session_->addImu(sample);
  }

  ScriptedInitializer* scripted_ = nullptr;
  std::unique_ptr<InitSession> session_;
  double next_imu_ = 0.0;
};

// A step within the limits, screened as in a host; the count outlives a restart.
TEST_F(InitSessionTest, ImuSamplesAreScreened) {
  make(everyFrame(false));
  imuUpTo(1.0);
  ImuSample glitch;
  glitch.t = next_imu_;
  glitch.accel = Eigen::Vector3d(100.0, 0.0, 9.81);
  EXPECT_EQ(session_->addImu(glitch), AddStatus::kGlitch);
  next_imu_ += 0.005;
  imuUpTo(1.1);
  EXPECT_EQ(session_->streamCounts().imu[AddStatus::kGlitch], 1);
  EXPECT_EQ(scripted_->info().counts.imu[AddStatus::kGlitch], 0);
  session_->restart();
  EXPECT_EQ(session_->streamCounts().imu[AddStatus::kGlitch], 1);
  EXPECT_EQ(session_->addImu(glitch), AddStatus::kAdded) << "the first sample of a stream";
}

// Rolling shutter: the row of points and of both ends of a line.
TEST_F(InitSessionTest, RowsAreSet) {
  FrameObservation observed = frame(1.0);
  observed.points[0].pixel.y() = 360.0;
  std::vector<LineObservation> lines = line();
  lines[0].start_pixel.y() = 0.0;
  lines[0].end_pixel.y() = 480.0;
  for (const int height : {0, 480}) {
    InitSessionOptions options;
    options.image_height = height;
    make(options, 0.0, 0.02);
    session_->addPoints(observed);
    session_->addLines(1.0, lines);
    const double on = height == 0 ? 0.0 : 1.0;
    EXPECT_NEAR(scripted_->last_frame.points[0].row, on * 0.25, 1e-12);
    EXPECT_NEAR(scripted_->last_lines[0].start_row, on * -0.5, 1e-12);
    EXPECT_NEAR(scripted_->last_lines[0].end_row, on * 0.5, 1e-12);
  }
}

TEST_F(InitSessionTest, AsksWhenTheImuCoversAFrameAndNotBefore) {
  make(everyFrame(false));
  session_->addPoints(frame(0.1));
  EXPECT_FALSE(session_->poll().has_value());
  imuUpTo(0.095);
  EXPECT_FALSE(session_->poll().has_value());
  imuUpTo(0.1);
  const auto attempt = session_->poll();
  ASSERT_TRUE(attempt.has_value());
  EXPECT_EQ(attempt->t, 0.1);
  EXPECT_EQ(attempt->number, 1);
  EXPECT_FALSE(attempt->requested);
  EXPECT_GE(attempt->total_ms, 0.0);
  EXPECT_FALSE(session_->poll().has_value());  // once per frame
}

TEST_F(InitSessionTest, TheTimeOffsetCounts) {
  make(everyFrame(false), /*td=*/0.0625);  // sums below are exact
  session_->addPoints(frame(0.125));
  imuUpTo(0.186);
  EXPECT_FALSE(session_->poll().has_value());
  imuUpTo(0.1875);
  EXPECT_TRUE(session_->poll().has_value());
}

TEST_F(InitSessionTest, KeepsTheInterval) {
  InitSessionOptions options;
  options.expect_lines = false;
  make(options);  // 0.1 s
  int attempts = 0;
  for (int k = 0; k <= 40; ++k) {
    session_->addPoints(frame(0.05 * k));
    imuUpTo(0.05 * k);
    if (session_->poll().has_value()) ++attempts;
  }
  EXPECT_EQ(attempts, 21);
}

TEST_F(InitSessionTest, LinesMeetTheirFrameBeforeOrAfterIt) {
  make(everyFrame(true));
  session_->addLines(0.1, line());
  session_->addPoints(frame(0.1));
  EXPECT_EQ(session_->streamCounts().lines[AddStatus::kAdded], 1);
  EXPECT_EQ(scripted_->late_lines, 0);
  imuUpTo(0.1);
  EXPECT_TRUE(session_->poll().has_value());

  session_->addPoints(frame(0.15));
  imuUpTo(0.2);
  EXPECT_FALSE(session_->poll().has_value()) << "its lines may still come";
  session_->addLines(0.15, line());
  EXPECT_EQ(scripted_->late_lines, 1);
  EXPECT_TRUE(session_->poll().has_value());
  EXPECT_EQ(session_->streamCounts().lines[AddStatus::kUnmatched], 0);
}

TEST_F(InitSessionTest, LostLinesHoldUpOneFrameOnly) {
  make(everyFrame(true));
  session_->addPoints(frame(0.1));
  imuUpTo(0.2);
  EXPECT_FALSE(session_->poll().has_value());
  session_->addPoints(frame(0.15));
  const auto attempt = session_->poll();
  ASSERT_TRUE(attempt.has_value());
  EXPECT_EQ(attempt->t, 0.1);
  session_->expectLines(false);
  EXPECT_EQ(session_->poll()->t, 0.15);
}

TEST_F(InitSessionTest, StopsAtAnAnswerUntilItIsAskedAgain) {
  make(everyFrame(false));
  scripted_->script = {InitStatus::kStationary, InitStatus::kSuccess, InitStatus::kSuccess,
                       InitStatus::kStationary};
  int attempts = 0;
  double t = 0.0;
  const auto run = [&](int frames) {
    for (int k = 0; k < frames; ++k) {
      t += 0.05;
      session_->addPoints(frame(t));
      imuUpTo(t);
      if (session_->poll().has_value()) ++attempts;
    }
  };
  run(10);
  EXPECT_EQ(attempts, 2);
  EXPECT_TRUE(session_->initialized());

  Attempt again = session_->initialize();
  EXPECT_TRUE(again.requested);
  EXPECT_TRUE(again.result.success());
  EXPECT_EQ(again.t, t);
  run(10);
  EXPECT_EQ(attempts, 2);

  again = session_->initialize();  // refused: the node goes on trying
  EXPECT_FALSE(session_->initialized());
  run(3);
  EXPECT_EQ(attempts, 5);
  EXPECT_EQ(session_->counts().successes, 2);
}

TEST_F(InitSessionTest, ARestartForgetsDataAndAnswer) {
  ASSERT_NO_FATAL_FAILURE(startAt5s());
  session_->restart();
  EXPECT_FALSE(session_->initialized());
  EXPECT_EQ(scripted_->info().counts.imu.added(), 0);
  EXPECT_EQ(session_->streamCounts().imu.added(), 21) << "the session counts on";
  // Time may have gone back.
  session_->addPoints(frame(1.0));
  next_imu_ = 0.9;
  imuUpTo(1.0);
  EXPECT_TRUE(session_->poll().has_value());
  EXPECT_EQ(session_->counts().restarts, 1);
}

// The streams show a jump in time, without a call of restart().
TEST_F(InitSessionTest, AJumpInTimeForgetsTheAnswer) {
  ASSERT_NO_FATAL_FAILURE(startAt5s());
  ASSERT_TRUE(session_->initialized());
  session_->addPoints(frame(5.1));  // of the old time, not covered yet
  addImu(1.0);
  EXPECT_TRUE(session_->initialized()) << "a stray stamp until another message confirms it";
  addImu(1.005);
  EXPECT_FALSE(session_->initialized());
  EXPECT_FALSE(session_->poll().has_value());
  session_->addPoints(frame(1.01));
  addImu(1.01);
  const auto attempt = session_->poll();
  ASSERT_TRUE(attempt.has_value());
  EXPECT_EQ(attempt->t, 1.01);
  EXPECT_EQ(session_->streamCounts().restarts(), 1);
  EXPECT_EQ(session_->counts().restarts, 0);
}

TEST_F(InitSessionTest, ASilentImuDoesNotMakeItGrow) {
  make(everyFrame(false));
  for (int k = 1; k <= 1000; ++k) {
    session_->addPoints(frame(0.05 * k));
    EXPECT_FALSE(session_->poll().has_value());
  }
  EXPECT_EQ(session_->counts().frames_uncovered, 950);
}

TEST(InitSessionOptionsTest, NamesFieldValueAndBound) {
  InitSessionOptions options;
  EXPECT_EQ(options.validate(), "");
  options.attempt_interval_s = -1.0;
  EXPECT_EQ(options.validate(), "attempt_interval_s is -1, must be in [0, 60]");
  options.attempt_interval_s = kNotComputed;
  EXPECT_NE(options.validate(), "");
}

TEST(StampClockTest, KeepsNanosecondsAndGoesBelowTheFirstStamp) {
  StampClock clock;
  const std::int64_t first = 1403715273262142976;
  EXPECT_EQ(clock.seconds(first), 0.0);
  EXPECT_DOUBLE_EQ(clock.seconds(first + 1), 1e-9);
  EXPECT_DOUBLE_EQ(clock.seconds(first - 2000000000), -2.0);
  for (const std::int64_t step : {1LL, 123456789LL, 86400123456789LL}) {
    EXPECT_EQ(clock.stampNs(clock.seconds(first + step)), first + step);
  }
}

}  // namespace
}  // namespace slim_init::node
