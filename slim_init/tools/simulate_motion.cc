// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulate_motion.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "exit_code.h"
#include "slim_init/evaluation/recorded.h"
#include "slim_init/evaluation/truth.h"
#include "slim_init/options.h"
#include "slim_init/simulation/imu_simulator.h"
#include "slim_init/text.h"

namespace slim_init::tools {
namespace {

constexpr std::int64_t kBuiltinT0Ns = 1400000000000000000;  // a stamp that ros::Time can hold
constexpr double kBuiltinDuration = 20.0;                   // [s]
// IMU and truth reach this far beyond the images: integration and interpolation need neighbours.
constexpr double kMargin = 0.1;       // [s]
constexpr double kTruthStep = 0.005;  // [s] of simulated motion, as EuRoC's 200 Hz

// Keeps the elements in [low, high].
template <typename T>
void cut(double low, double high, std::vector<T>* list) {
  list->erase(std::remove_if(list->begin(), list->end(),
                             [&](const T& x) { return x.t < low || x.t > high; }),
              list->end());
}

// Keeps the images from --start on for --duration; the clock starts at the first that can be
// rendered.
void cutImages(const SimulateOptions& options, const Calibration& calibration,
               SimulatedMotion* motion) {
  std::vector<double>& times = motion->image_times;
  const std::size_t before = times.size();
  times.erase(
      std::remove_if(times.begin(), times.end(),
                     [&](double t) { return !motion->trajectory->covers(t + calibration.td); }),
      times.end());
  if (before > times.size()) {
    motion->notes.push_back(
        text(before - times.size(), " of ", before,
             " images lie outside or in gaps of the ground truth and were discarded"));
  }
  if (times.empty()) check(motion->name + ": no image lies within the true motion");
  const double begin = times.front() + options.start_s;
  const double last = times.back();
  const double end = options.duration_s > 0.0 ? begin + options.duration_s : last;
  // With a tolerance of half a nanosecond: the sum is rounded.
  times.erase(std::remove_if(times.begin(), times.end(),
                             [&](double t) { return t < begin - 5e-10 || t > end + 5e-10; }),
              times.end());
  if (times.size() < 2) {
    check(text("--start ", options.start_s, " leaves ", times.size(), " images of ", motion->name,
               ", whose motion is ", last - (begin - options.start_s),
               " s long; at least 2 are needed"));
  }
}

void loadRecorded(const SimulateOptions& options, SimulatedMotion* motion) {
  evaluation::RecordedMotion recorded;
  check(evaluation::readRecordedMotion(options.recorded, WindowOptions().max_imu_gap_s, &recorded)
            .message);
  motion->name = recorded.name;
  motion->t0_ns = recorded.t0_ns;
  motion->notes = recorded.notes;
  motion->image_times = recorded.image_times;
  std::string error;
  motion->trajectory = simulation::makeSampledTrajectory(recorded.truth, &error);
  if (motion->trajectory == nullptr)
    throw Failure(kExitBadInput, options.recorded + ": groundtruth.csv: " + error);
  if (!recorded.has_velocity_and_bias) {
    const evaluation::GyroBiasFit fit = evaluation::fitGyroBias(recorded.imu, recorded.truth);
    if (!fit.ok) check(fit.message, options.recorded + ": ");
    motion->notes.push_back(fit.message);
    motion->notes.push_back(
        "the accelerometer bias is not known; the written ground truth has zero instead");
    for (NavState& state : recorded.truth) {
      state.gyro_bias = fit.bias;
      state.accel_bias.setZero();
    }
  }
  motion->imu = std::move(recorded.imu);
  motion->truth = std::move(recorded.truth);
}

// IMU, truth and image times along a known motion.
void simulateSensors(const SimulateOptions& options, const Calibration& calibration,
                     SimulatedMotion* motion) {
  simulation::ImuSimulationOptions imu;
  imu.rate_hz = options.imu_rate_hz;
  imu.noise = calibration.imu_noise;
  imu.gravity_magnitude = calibration.gravity_magnitude;
  imu.seed = options.seed;
  const simulation::Trajectory& trajectory = *motion->trajectory;
  motion->imu = simulation::simulateImu(trajectory, imu);
  for (std::int64_t k = 0;; ++k) {
    const double t = trajectory.begin() + static_cast<double>(k) * kTruthStep;
    if (t > trajectory.end()) break;
    NavState state = simulation::stateAt(trajectory, t);
    state.gyro_bias = imu.gyro_bias;
    state.accel_bias = imu.accel_bias;
    motion->truth.push_back(state);
  }
  // The first image has IMU data before it, the last one after it.
  for (std::int64_t k = 0;; ++k) {
    const double t = trajectory.begin() + kMargin + static_cast<double>(k) / options.rate_hz;
    if (motion->imu.empty() || t > motion->imu.back().t - kMargin) break;
    motion->image_times.push_back(t);
  }
}

void loadCsv(const SimulateOptions& options, SimulatedMotion* motion) {
  std::vector<NavState> states;
  check(evaluation::readPoses(options.csv, &motion->t0_ns, &states).message, "--csv: ");
  motion->name = std::filesystem::path(options.csv).stem().string();
  constexpr double kSmoothRate = 20.0;  // [Hz]
  std::string error;
  motion->trajectory = simulation::makeSmoothTrajectory(states, kSmoothRate, &error);
  if (motion->trajectory == nullptr)
    throw Failure(kExitBadInput, "--csv: " + options.csv + ": " + error);
}

void loadBuiltin(const SimulateOptions& options, const Calibration& calibration,
                 SimulatedMotion* motion) {
  motion->name = options.builtin;
  motion->t0_ns = kBuiltinT0Ns;
  const double duration = options.start_s + 2.0 * kMargin + 0.01 +
                          (options.duration_s > 0.0 ? options.duration_s : kBuiltinDuration);
  std::string error;
  motion->trajectory = simulation::makeBuiltinTrajectory(options.builtin, duration,
                                                         calibration.R_b_c, options.seed, &error);
  if (motion->trajectory == nullptr) throw Failure(kExitBadInput, "--builtin: " + error);
}

}  // namespace

SimulatedMotion loadSimulatedMotion(const SimulateOptions& options,
                                    const Calibration& calibration) {
  SimulatedMotion motion;
  if (!options.recorded.empty()) {
    loadRecorded(options, &motion);
  } else {
    if (options.csv.empty()) {
      loadBuiltin(options, calibration, &motion);
    } else {
      loadCsv(options, &motion);
    }
    simulateSensors(options, calibration, &motion);
  }
  cutImages(options, calibration, &motion);
  const double low = motion.image_times.front() + calibration.td - kMargin;
  const double high = motion.image_times.back() + calibration.td + kMargin;
  cut(low, high, &motion.imu);
  // Recorded truth may be sparse: a few more samples for interpolation.
  cut(low - 0.5, high + 0.5, &motion.truth);
  return motion;
}

}  // namespace slim_init::tools
