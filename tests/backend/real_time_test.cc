// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The test host played at rate 1: a frame comes when its time has come, whether the host is ready
// or not. Solves run in the adapter's thread. Tracks are simulated; what is measured is time.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "backend/host_run.h"

namespace slim_init::backend {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kDuration = 16.0;   // [s]
constexpr double kMaxWaitMs = 10.0;  // of the adapter
constexpr double kLatency = 0.15;    // of the odometry, p90 [s]
// A machine that is busy stops any program for a moment; solves in the host's own thread made the
// odometry late by seconds, and ever more.
constexpr double kWorstLatency = 1.0;   // [s]
constexpr double kVelocityError = 0.3;  // [m/s]

struct Flight {
  std::vector<double> late;         // from the time of a frame to its odometry [s]
  double wrong_since_event = 0.0;   // longest time with a wrong velocity [s]
  std::vector<std::string> events;  // what the host said at starts and failures
  int failed = 0, recovered = 0, started = 0, reset = 0;
};

// Spikes of the IMU and states that are thrown off, one every four seconds. A spike begins with the
// stamp of a frame, so that the sample which the frame needs is held back. At rate 1 if the host
// waits for solves; in lock step if max_wait_ms is negative.
Flight fly(double max_wait_ms) {
  const evaluation::Sequence sequence = makeSimulatedSequence({"figure-eight", kDuration});
  HostRun run(sequence, 0, max_wait_ms);
  const std::vector<double> events = {4.0, 8.0, 12.0};
  run.imu_filter = [&](ImuSample* sample) {
    for (const double event : events) {
      if (sample->t < event || sample->t >= event + 0.04) continue;
      sample->accel += Eigen::Vector3d(380, -190, 270);
      sample->gyro += Eigen::Vector3d(1.5, 4.0, -2.0);
    }
  };
  std::size_t thrown = 0;
  run.before_frame = [&](TestHost* host, double stamp) {
    if (thrown == events.size() || stamp < events[thrown] + 2.0) return;
    ++thrown;
    std::vector<NavState> states = host->estimator().states();
    for (NavState& state : states) state.v_w_b += Eigen::Vector3d(6, 0, 0);
    if (!states.empty()) host->estimator().overwrite(states);
  };

  Flight flight;
  const auto begin = Clock::now();
  const double first = sequence.frames.front().t;
  double wrong_since = kNotComputed;
  for (;;) {
    // The next frame is there when its time has come.
    const std::chrono::duration<double> due(static_cast<double>(flight.late.size()) * 0.1);
    if (max_wait_ms >= 0.0) {
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(due));
    }
    const HostStep* step = run.next();
    if (step == nullptr) break;
    const double now = std::chrono::duration<double>(Clock::now() - begin).count();
    flight.late.push_back(now - (run.stamp() - first));
    flight.failed += step->failed ? 1 : 0;
    flight.recovered += step->recovered ? 1 : 0;
    flight.started += step->seeded ? 1 : 0;
    flight.reset += step->reset ? 1 : 0;
    if (step->failed || step->seeded) {
      std::ostringstream event;
      event << run.stamp() << " s: " << step->message;
      flight.events.push_back(event.str());
    }
    if (!step->tracking || flight.started == 0) continue;
    const NavState& truth = run.truth();
    const double error =
        (step->state.R_w_b.transpose() * step->state.v_w_b - truth.R_w_b.transpose() * truth.v_w_b)
            .norm();
    if (error < kVelocityError) {
      wrong_since = kNotComputed;
    } else if (std::isnan(wrong_since)) {
      wrong_since = run.stamp();
    }
    if (std::isnan(wrong_since)) continue;
    flight.wrong_since_event = std::max(flight.wrong_since_event, run.stamp() - wrong_since + 0.1);
  }
  return flight;
}

void expectUninterrupted(const Flight& flight) {
  EXPECT_EQ(flight.started, 1);
  EXPECT_EQ(flight.reset, 0);
  EXPECT_EQ(flight.recovered, flight.failed);
  EXPECT_GE(flight.failed, 3);
  EXPECT_LE(flight.wrong_since_event, 0.6);
}

TEST(RealTime, OdometryKeepsUpThroughFailures) {
  const Flight flight = fly(kMaxWaitMs);
  std::cout << flight.late.size() << " frames, odometry late by " << quantile(flight.late, 0.5)
            << " s (median), " << quantile(flight.late, 0.95) << " s (p95), "
            << quantile(flight.late, 1.0) << " s at worst; " << flight.failed << " failures, "
            << flight.recovered << " recoveries; velocity off for at most "
            << flight.wrong_since_event << " s\n";
  for (const std::string& event : flight.events) std::cout << event << '\n';
  expectUninterrupted(flight);
  EXPECT_LE(quantile(flight.late, 0.9), kLatency);
  EXPECT_LE(quantile(flight.late, 1.0), kWorstLatency);
}

TEST(RealTime, InLockStepTheSameFlightIsNeverInterrupted) { expectUninterrupted(fly(-1.0)); }

}  // namespace
}  // namespace slim_init::backend
