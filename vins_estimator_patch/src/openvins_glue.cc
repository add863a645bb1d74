// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/openvins_glue.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>

#include "slim_init/config/config.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/initializer.h"
#include "slim_init/result.h"
#include "slim_init/text.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "slim_init/vins_adapter/host_convention.h"

namespace slim_init::vins_adapter {
namespace {

constexpr double kRadToDeg = 57.29577951308232;
// A refusal is reported again after this time [s].
constexpr double kRepeatReport = 5.0;
// The two answers are compared where ours reaches, by the IMU alone, so far [s].
constexpr double kCompareReach = 2.5;

Calibration calibrationOf(const OpenVinsRig& rig) {
  Calibration calibration;
  calibration.R_b_c = rig.R_b_c;
  calibration.t_b_c = rig.t_b_c;
  calibration.td = rig.td;
  calibration.focal_px = rig.focal_px;
  calibration.gravity_magnitude = rig.gravity;
  calibration.imu_noise.gyro_density = rig.gyro_density;
  calibration.imu_noise.accel_density = rig.accel_density;
  return calibration;
}

std::string inShort(double value, int digits) { return roundedText(digits, std::fixed, value); }

// How far the host's state is from ours at the same time, in what does not depend on the world.
std::string difference(const std::vector<double>& stock, const NavState& ours) {
  const Eigen::Map<const Eigen::Matrix<double, 16, 1>> x(stock.data());
  // JPL's numbers are those of the Hamilton quaternion from body to world.
  const Eigen::Quaterniond q(x[3], x[0], x[1], x[2]);
  const Eigen::Matrix3d R = q.normalized().toRotationMatrix();
  const Eigen::Vector3d v = x.segment<3>(7);
  const double cosine = R.row(2).dot(ours.R_w_b.row(2));
  return "speed " + inShort(v.norm(), 3) + " m/s, slim " + inShort(ours.v_w_b.norm(), 3) +
         " m/s; velocities in the body differ by " +
         inShort((R.transpose() * v - ours.R_w_b.transpose() * ours.v_w_b).norm(), 3) +
         " m/s, tilt by " + inShort(kRadToDeg * std::acos(std::clamp(cosine, -1.0, 1.0)), 2) +
         " deg, gyroscope biases by " + inShort((x.segment<3>(10) - ours.gyro_bias).norm(), 4) +
         " rad/s";
}

}  // namespace

struct OpenVinsGlue::State {
  Listener listener;
  std::unique_ptr<IInitializer> initializer;
  HostMode mode = HostMode::kStock;
  double td = 0.0;
  std::atomic<bool> active{false};

  // The streams go on while a solve runs.
  mutable std::mutex mutex;
  host_health::ImuScreen screen{ImuLimits()};
  double newest_frame = -std::numeric_limits<double>::infinity();
  TimeSpan received;  // stamps of the frames that were added

  // Touched by the solving thread alone.
  TimeSpan solved;  // what had been received
  InitStatus reported_status = InitStatus::kSuccess;
  double reported_stamp = -std::numeric_limits<double>::infinity();
  double own_start = kNotComputed;  // shadow mode: newest image at our first success

  void report(const std::string& text) const {
    if (listener) listener(text);
  }

  // Reported unless it repeats the refusal before.
  void reportAnswer(const InitResult& answer, bool taken, const std::string& problem, double ms) {
    if (!taken && answer.status == reported_status &&
        std::abs(solved.last - reported_stamp) < kRepeatReport) {
      return;
    }
    reported_status = answer.status;
    reported_stamp = solved.last;
    report(std::string(taken ? "seed done" : toString(answer.status)) + ": " +
           (problem.empty() ? withRemedy(answer.message, answer.status) : problem) + " (" +
           inShort(std::isnan(solved.first) ? 0.0 : solved.last - solved.first, 2) +
           " s of data, " + inShort(ms, 1) + " ms)");
    if (!taken) return;
    for (const std::string& warning : answer.warnings) report(warning);
  }

  InitResult ask(MsckfState* state) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      solved = received;
    }
    const auto start = std::chrono::steady_clock::now();
    InitResult answer = initializer->initialize();
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    std::string problem;
    bool taken = answer.success() || answer.provisional();
    if (taken) problem = answer.validate();
    taken = taken && problem.empty() && toMsckfState(answer, td, state, &problem);
    reportAnswer(answer, taken, problem, ms);
    return answer;
  }
};

OpenVinsGlue::OpenVinsGlue() : state_(new State) {}
OpenVinsGlue::~OpenVinsGlue() = default;

void OpenVinsGlue::listen(const Listener& listener) { state_->listener = listener; }

bool OpenVinsGlue::open(const std::string& mode, const std::string& file, const OpenVinsRig& rig) {
  State& state = *state_;
  std::string error;
  Config config;
  state.initializer.reset();
  config.calibration = calibrationOf(rig);  // where the file's section is silent
  if (!parseHostMode(mode, &state.mode)) {
    error = "initializer is \"" + mode + "\", must be stock, slim or shadow";
  } else if (state.mode == HostMode::kStock) {
    return false;
  } else if (file.empty() || loadOptions(file, &config, &error)) {
    state.initializer = makeLiveInitializer(config, &error);
    state.screen = host_health::ImuScreen(config.options.imu);
  }
  if (state.initializer == nullptr) {
    state.report("error: " + error + "; the host initializes by itself");
    return false;
  }
  state.td = rig.td;
  for (const std::string& note : config.notes) state.report(note);
  state.report(std::string("initializer: ") + toString(state.mode) + ", method " +
               state.initializer->info().method);
  state.active = true;
  return true;
}

bool OpenVinsGlue::active() const { return state_->active; }
bool OpenVinsGlue::decides() const { return active() && state_->mode == HostMode::kSlim; }

void OpenVinsGlue::addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro) {
  if (!active()) return;
  ImuSample sample;
  sample.t = t;
  sample.accel = accel;
  sample.gyro = gyro;
  State& state = *state_;
  const std::lock_guard<std::mutex> lock(state.mutex);
  state.screen.pass(sample,
                    [&state](const ImuSample& one) { return state.initializer->addImu(one); });
}

double OpenVinsGlue::newestFrame() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->newest_frame;
}

void OpenVinsGlue::addPoints(double stamp, const std::vector<double>& points) {
  State& state = *state_;
  const std::lock_guard<std::mutex> lock(state.mutex);
  state.newest_frame = std::max(state.newest_frame, stamp);
  if (!isAdded(state.initializer->addFrame(toFrame(stamp, points)))) return;
  if (std::isnan(state.received.first)) state.received.first = stamp;
  state.received.last = stamp;
}

MsckfState OpenVinsGlue::solve() {
  MsckfState state;
  state_->ask(&state);
  return state;
}

void OpenVinsGlue::compare(bool success, double timestamp, const std::vector<double>& stock) {
  State& state = *state_;
  MsckfState own;
  const InitResult answer = state.ask(&own);
  if (!own.empty() && std::isnan(state.own_start)) state.own_start = state.solved.last;
  if (!success || stock.size() != 16) return;
  std::string text =
      "shadow: OpenVINS starts after " + inShort(state.solved.last - state.solved.first, 2) + " s";
  text += std::isnan(state.own_start)
              ? ", slim has not started yet"
              : ", slim after " + inShort(state.own_start - state.solved.first, 2) + " s";
  std::vector<NavState> at;
  if (!own.empty() &&
      state.initializer->statesAt(answer, {timestamp + state.td}, kCompareReach, &at, nullptr)) {
    text += "; " + difference(stock, at.front());
  }
  state.report(text);
}

}  // namespace slim_init::vins_adapter
