// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An initializer that shares nothing with ours but the interface.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/initializer.h"
#include "slim_init/state_at.h"
#include "support/exact_window.h"

namespace slim_init::vins_adapter {

/// Knows the true state of every frame (in a world of its own, turned about z and shifted) and
/// keeps what it was given in plain vectors.
class Oracle : public IInitializer {
 public:
  explicit Oracle(const ExactWindow& exact, double readout_s = 0.0)
      : calibration(exact.calibration) {
    calibration.readout_s = readout_s;
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
    const double t = calibration.imuTime(frame.t);
    const AddStatus status = check_.checkFrame(t);
    if (status == AddStatus::kRestarted) forget();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (isAdded(status)) times_.push_back(t);
    last_frame = std::move(frame);
    return status;
  }
  AddStatus addLines(double /*stamp*/, std::vector<LineObservation> lines) override {
    last_lines = std::move(lines);
    return AddStatus::kNotSupported;
  }
  void setTd(double td) override { calibration.td = td; }
  void reset() override {
    forget();
    check_ = StreamCheck(check_.options());
  }

  InitResult initialize(const Priors& priors) override {
    std::unique_lock<std::mutex> lock(mutex_);
    known_sensors = priors.sensors;
    InitResult result;
    if (times_.size() < 8) {
      result.status = InitStatus::kTooFewKeyframes;
      result.message = "the oracle needs eight frames";
      return result;
    }
    result.status = InitStatus::kSuccess;
    result.message = "as foretold";
    result.gravity_w = Eigen::Vector3d(0, 0, -calibration.gravity_magnitude);
    // Every second frame, to have some between its keyframes.
    for (std::size_t i = times_.size() - 7; i < times_.size(); i += 2) {
      result.states.push_back(at(times_[i]));
    }
    result.gyro_bias = result.states.back().gyro_bias;
    result.accel_bias = result.states.back().accel_bias;
    if (recovers && !priors.healthy.empty()) continueFrame(priors.healthy, &result);
    lock.unlock();
    if (then) then(priors, &result);
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
    info.calibration = calibration;
    info.counts = check_.counts();
    if (!imu_.empty()) info.imu = {imu_.front().t, imu_.back().t};
    info.window_span_s = 0.7;
    return info;
  }

  Calibration calibration;  ///< of the host
  FrameObservation last_frame;
  std::vector<LineObservation> last_lines;
  KnownSensors known_sensors;
  std::vector<StatePrior> given;  ///< healthy states
  bool recovers = true;
  bool too_few_states = false;  ///< statesAt() forgets to fill them
  /// What the test makes of a result.
  std::function<void(const Priors&, InitResult*)> then;

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
    const std::lock_guard<std::mutex> lock(mutex_);
    imu_.clear();
    times_.clear();
  }

  Eigen::Matrix3d turn_ = expSO3(Eigen::Vector3d(0, 0, 1.1));
  StreamCheck check_{StreamOptions::liveData()};
  std::vector<NavState> truth_;
  std::vector<ImuSample> imu_;
  std::vector<double> times_;
  std::mutex mutex_;  // solves run in another thread
};

}  // namespace slim_init::vins_adapter
