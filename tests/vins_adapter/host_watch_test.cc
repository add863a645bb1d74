// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the adapter knows about a host in flight: its IMU intervals, what a carried state is worth,
// whether the host's states are right. Every judgement from both sides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "host_health/flight.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/initializer.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "slim_init/vins_adapter/host_convention.h"
#include "support/exact_window.h"
#include "support/text_parts.h"
#include "vins_adapter/host_streams.h"

namespace slim_init::vins_adapter {
namespace {

using namespace host_health;  // NOLINT: the vocabulary of these tests

class AdapterInFlight : public FedAdapter {
 protected:
  AdapterInFlight() { exact_ = flightOf(Motion::kExcited, 0.0); }
  void fly(const std::vector<ImuSample>& imu, int frames = kFrames) {
    exact_.imu = imu;
    options_.watchdog = true;
    make(makeInitializer(exact_.calibration, InitializerOptions()));
    feed(0, frames - 1);
  }
  HostPreparation prepare(const std::vector<HostState>& states) {
    return adapter_->prepare(states, exact_.calibration.R_b_c, exact_.calibration.t_b_c);
  }
  // Intervals between the frames from `first` on; each has its length.
  std::vector<HostImuInterval> intervals(int first) {
    std::vector<double> stamps;
    for (int k = first; k < kFrames; ++k) stamps.push_back(exact_.keyframes[k].t);
    const std::vector<HostImuInterval> result = adapter_->imuIntervals(stamps);
    EXPECT_EQ(result.size(), stamps.size() - 1);
    for (std::size_t i = 0; i < result.size(); ++i) {
      const double sum = std::accumulate(result[i].dt.begin(), result[i].dt.end(), 0.0);
      EXPECT_NEAR(sum, stamps[i + 1] - stamps[i], 1e-9) << i;
    }
    return result;
  }
};

// At rest a host keeps old keyframes; some hosts do not tell of the images that they receive.
TEST_F(AdapterInFlight, WhatTheWindowKeepsAtRestJudgesTheImuData) {
  constexpr int kRest = 210;
  const NavState last = exact_.truth.back();
  const FrameObservation seen = exact_.keyframes.back();
  NavState rest = last;
  rest.v_w_b.setZero();
  for (int k = 1; k <= kRest; ++k) {
    rest.t = last.t + 0.1 * k;
    exact_.truth.push_back(rest);
    exact_.keyframes.push_back(seen);
    exact_.keyframes.back().t = rest.t;
  }
  while (exact_.imu.back().t > last.t) exact_.imu.pop_back();
  ImuSample sample = exact_.imu.back();
  for (int i = 0; sample.t < rest.t; ++i) {
    sample.t += 0.005;
    sample.accel = rest.accel_bias + rest.R_w_b.transpose() * exact_.calibration.gravity_magnitude *
                                         Eigen::Vector3d::UnitZ();
    sample.gyro = rest.gyro_bias + Eigen::Vector3d::Constant(1e-4 * (i % 5));
    exact_.imu.push_back(sample);
  }
  const std::vector<ImuSample> clean = exact_.imu;
  enum { kTells, kTellsNothing, kIsWatched };
  for (const int host : {kTells, kTellsNothing, kIsWatched}) {
    for (const bool damaged : {true, false}) {
      const double begin = damaged ? rest.t - 0.095 : rest.t;
      fly(disturbed(clean, begin, rest.t - 0.005, {40.0, 0.0, 0.0}), kHostFrames);
      HostPreparation prepared;
      for (int k = kHostFrames; k < kFrames + kRest; ++k) {
        if (host == kTells) adapter_->received(exact_.keyframes[k].t);
        // One wrong stamp, and a td that changes, do not matter.
        if (host == kTells && k == 20) adapter_->received(1000.0);
        if (k == kFrames) adapter_->setTd(1e-3);
        feed(k, k);
        std::vector<HostState> states = window(std::min(k, kFrames));
        states[kHostFrames - 2] = toHostState(exact_.truth[k - 1], 0.0);
        states[kHostFrames - 1] = toHostState(exact_.truth[k], 0.0);
        if (host == kIsWatched && k + 1 < kFrames + kRest) {
          watch(states);
        } else {
          prepared = prepare(states);
        }
      }
      ASSERT_FALSE(prepared.intervals.empty());
      EXPECT_EQ(prepared.intervals.back().damaged, damaged) << host << prepared.message;
    }
  }
}

TEST_F(AdapterInFlight, AWrongScaleIsFoundAndARightOneIsSane) {
  fly(exact_.imu);
  std::vector<HostState> states = window(kFrames - 1);
  HostHealth health = watch(states);
  EXPECT_TRUE(health.healthy && !health.suspect && health.reason.empty()) << health.reason;
  for (HostState& state : states) {
    state.P *= 4.0;
    state.V *= 4.0;
  }
  health = watch(states);
  EXPECT_TRUE(health.suspect);
  health = watch(states);
  EXPECT_FALSE(health.healthy);
  EXPECT_NE(health.reason, "");
}

// A turn about one axis shows no extrinsic: a host that has found it earlier knows it.
TEST_F(AdapterInFlight, TurningAboutOneAxisAHostIsConfirmed) {
  ExactWindowOptions options = atTenHertz(2 * kFrames);
  options.angular_rate = [](double t) {
    return Eigen::Vector3d(0.0, 0.0, 0.3 * std::sin(1.5 * t));
  };
  exact_ = noisyWindow(options);
  const Calibration right = exact_.calibration;
  exact_.calibration.R_b_c.setIdentity();
  exact_.calibration.sigmas.rotation_deg = 180.0;
  exact_.calibration.sigmas.translation_m = 0.05;
  options_.estimate_extrinsic = true;
  fly(exact_.imu, 30);
  int confirmed = 0;
  for (int k = 30; k < options.keyframes; ++k) {
    feed(k, k);
    const HostHealth health = adapter_->watch(window(k), right.R_b_c, right.t_b_c, true);
    EXPECT_TRUE(health.healthy) << health.reason;
    EXPECT_FALSE(health.calibration) << "it was given, not found";
    confirmed += std::isnan(health.confirmed_stamp) ? 0 : 1;
  }
  EXPECT_GE(confirmed, 5);
}

// Rows of a rolling shutter are seen at other times than the stamp.
TEST_F(AdapterInFlight, ARollingShutterIsNoMotionOfTheScene) {
  ExactWindowOptions options = atTenHertz(kFrames);
  options.angular_rate = [](double t) {
    return Eigen::Vector3d(2.0 * std::sin(5.0 * t), 2.0 * std::cos(3.8 * t), std::sin(4.4 * t));
  };
  for (const double readout_s : {0.0, 0.033}) {
    options.readout_s = readout_s;
    exact_ = noisyWindow(options);
    fly(exact_.imu, kHostFrames);
    std::size_t moving = 0;
    for (int k = kHostFrames; k < kFrames; ++k) {
      feed(k, k);
      const HostPreparation frame = prepare(window(k));
      EXPECT_EQ(frame.message, "") << k;
      moving += frame.moving.size();
      if (k % 5 > 0) continue;
      EXPECT_LT(watch(window(k)).reprojection_px, 2.5) << k;
    }
    EXPECT_LT(moving, 10u) << readout_s;
  }
}

TEST_F(AdapterInFlight, IntervalsAreCleanAndKnown) {
  fly(disturbed(exact_.imu, exact_.truth[30].t + 0.02, exact_.truth[30].t + 0.045, {100, 0, 0}));
  const std::vector<HostImuInterval> found = intervals(28);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const HostImuInterval& interval = found[i];
    EXPECT_EQ(interval.damaged, i == 2) << i;
    EXPECT_EQ(interval.dt.size(), interval.accel.size());
    EXPECT_EQ(interval.dt.size(), interval.gyro.size());
    for (const Eigen::Vector3d& accel : interval.accel) EXPECT_LT(accel.norm(), 60.0);
    EXPECT_EQ(interval.sigma_v > 0.0, interval.damaged);
  }
  EXPECT_GT(adapter_->info().counts.imu[AddStatus::kGlitch], 0);
  EXPECT_NEAR(adapter_->lastDamage().second, exact_.keyframes[30].t + 0.045, 0.01);
}

// The host wants its newest frame while the damage goes on.
TEST_F(AdapterInFlight, IntervalsReachIntoDamageThatGoesOn) {
  fly(disturbed(exact_.imu, exact_.truth[kFrames - 3].t + 0.03, 1e9, {120, 0, 0}));
  const std::vector<HostImuInterval> found = intervals(30);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].damaged, i + 2 >= found.size()) << i;
    for (const Eigen::Vector3d& accel : found[i].accel) EXPECT_LT(accel.norm(), 40.0);
    EXPECT_EQ(found[i].sigma_theta, 0.0);
  }
  EXPECT_NEAR(found.back().sigma_v, kUnknownAccel * 0.1, 1e-9);
  const HostPropagation carried =
      adapter_->propagate(window(kFrames - 2).back(), exact_.keyframes[kFrames - 1].t);
  ASSERT_TRUE(carried.ok) << carried.message;
  EXPECT_LT((carried.state.V - exact_.truth[kFrames - 1].v_w_b).norm(), kUnknownAccel * 0.1);
}

// A host drops the images for which it has no IMU data. What its tracker has followed from image to
// image gives the pose; what it finds again after a gap in the images are other points.
TEST_F(AdapterInFlight, TracksBridgeAGapInTheImuData) {
  const int before = kFrames - 16, after = kFrames - 2;
  const std::vector<ImuSample> imu =
      withGap(exact_.imu, exact_.truth[before].t + 0.02, exact_.truth[after].t - 0.05);
  std::vector<HostState> states = window(before);
  states.erase(states.begin());
  states.push_back(window(after).back());
  for (const bool images : {false, true}) {
    fly(imu, before + 1);
    feed(after, after);
    for (int k = 0; images && k <= after; ++k) adapter_->received(exact_.keyframes[k].t);
    adapter_->received(kNotComputed);
    const HostPreparation frame = prepare(states);
    EXPECT_TRUE(frame.replaces_newest);
    EXPECT_TRUE(frame.intervals.back().damaged);
    const double error = (frame.newest.P - exact_.truth[after].p_w_b).norm();
    if (images) {
      EXPECT_LT(frame.moving.size(), 5u);
      EXPECT_LT(error, 0.1);
      EXPECT_LT(frame.position_sigma, 0.2);
      EXPECT_LT(frame.yaw_sigma_deg, 2.0);
    } else {
      EXPECT_GT(frame.moving.size(), 20u);
      EXPECT_GT(error, 0.1);
      EXPECT_GT(frame.position_sigma, error) << "nothing says where it is";
      EXPECT_GT(frame.yaw_sigma_deg, 5.0);
    }
  }
}

// Whatever the IMU has measured wrongly in a gap of the images stays in the poses after it: then
// the tracks are not what is incorrect.
TEST_F(AdapterInFlight, AfterAGapInTheImagesTheTracksDecide) {
  constexpr int kBefore = 22, kAfter = 25, kNewest = 30;
  std::vector<HostState> states;
  for (HostState state : window(kNewest)) {
    const double since = state.stamp - exact_.keyframes[kBefore].t;
    if (since > 1e-3 && state.stamp < exact_.keyframes[kAfter].t - 1e-3) continue;
    if (since > 0.0) state.P.x() += 0.8 * since;
    states.push_back(state);
  }
  for (const bool gap : {false, true}) {
    fly(exact_.imu, kNewest + 1);
    for (int k = 0; k <= kNewest; ++k) {
      if (!gap || k <= kBefore || k >= kAfter) adapter_->received(exact_.keyframes[k].t);
    }
    for (int k = kBefore - 4; k <= kBefore; ++k) EXPECT_LT(prepare(window(k)).moving.size(), 5u);
    const HostPreparation frame = prepare(states);
    if (gap) {
      EXPECT_TRUE(frame.moving.empty()) << frame.message;
    } else {
      EXPECT_GT(frame.moving.size(), 20u) << frame.message;
    }
  }
}

// The images of a host at 3 Hz judge its IMU data, and what misses two of them does not.
TEST_F(AdapterInFlight, ASlowHostIsNotInDoubt) {
  fly(exact_.imu, 1);
  std::vector<HostState> states = statesOf(0, 0);
  for (const int k : {3, 6, 9, 12, 15, 18, 21, 24, 27, 36}) {
    feed(k, k);
    states.push_back(toHostState(exact_.truth[k], 0.0));
    const HostPreparation frame = prepare(states);
    EXPECT_EQ(frame.position_sigma > 0.0, k == 36) << k << ' ' << frame.message;
    EXPECT_FALSE(frame.suspect) << k;
  }
  // The keyframes of a host at 10 Hz may be as far apart.
  fly(exact_.imu, 28);
  for (const int newest : {29, 36}) {
    feed(newest, newest);
    states = statesOf(newest, newest);
    for (int k = 27; k > 0; k -= 3) states.insert(states.begin(), statesOf(k, k).front());
    EXPECT_EQ(prepare(states).position_sigma > 0.0, newest == 36) << newest;
  }
}

// A tracker loses many points in a dark scene: while most agree with the IMU the host is not in
// doubt.
TEST_F(AdapterInFlight, HalfOfTheTracksMayMoveWithoutADoubt) {
  constexpr int kBegin = 33, kNewest = 37;
  const ExactWindow still = exact_;
  for (const int part : {4, 6, 9}) {  // of ten
    exact_ = still;
    for (int k = kBegin; k <= kNewest; ++k) {
      const double shift = 8.0 * (k - kBegin + 1) / exact_.calibration.focal_px;
      for (PointObservation& point : exact_.keyframes[k].points) {
        if (point.id % 10 >= part) continue;
        point.bearing = (point.bearing + shift * Eigen::Vector3d(1.0, 0.5, 0.0)).normalized();
        if (part == 9) point.id += 100000;  // what covers most of the view is new
      }
    }
    fly(exact_.imu, kNewest + 1);
    HostPreparation frame, first;
    for (int k = kBegin - 2; k <= kNewest; ++k) {
      frame = prepare(window(k));
      if (k == kBegin) first = frame;
    }
    EXPECT_GT(frame.moving.size(), exact_.keyframes[kNewest].points.size() * (part - 1) / 10);
    EXPECT_EQ(frame.position_sigma > 0.0, part > 5) << part;
    EXPECT_EQ(frame.message.empty(), part < 5) << frame.message;
    EXPECT_FALSE(frame.replaces_newest);
    EXPECT_EQ(frame.suspect, part == 9) << "no image vouches for the state: " << frame.message;
    EXPECT_EQ(frame.position_sigma > first.position_sigma, part == 9)
        << "the IMU alone is worth less and less";
  }
}

TEST_F(AdapterInFlight, ACarriedStateSaysWhatItIsWorth) {
  fly(exact_.imu);
  HostState from = window(20).back();
  const HostPropagation near = adapter_->propagate(from, exact_.keyframes[25].t);
  const HostPropagation far = adapter_->propagate(from, exact_.keyframes[38].t);
  ASSERT_TRUE(near.ok && far.ok) << near.message << far.message;
  EXPECT_LT((far.state.P - exact_.truth[38].p_w_b).norm(), 0.02);
  EXPECT_GT(far.position_sigma, near.position_sigma);
  EXPECT_LT(far.position_sigma, 1.0);
  expectParts(far.message, "standard deviation");
  from.stamp = -100.0;
  EXPECT_FALSE(adapter_->propagate(from, exact_.keyframes[25].t).ok);
}

}  // namespace
}  // namespace slim_init::vins_adapter
