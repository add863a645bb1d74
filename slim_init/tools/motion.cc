// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "motion.h"

#include <algorithm>
#include <utility>

#include "exit_code.h"
#include "slim_init/evaluation/truth.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/text.h"

namespace slim_init::tools {
namespace {

constexpr double kTruthStep = 0.005;  // [s] of simulated motion, as EuRoC's 200 Hz

}  // namespace

std::string settleBiases(bool has_bias, const std::string& source,
                         const std::vector<ImuSample>& imu, std::vector<NavState>* truth,
                         std::vector<std::string>* notes) {
  if (has_bias) return "recorded";
  const evaluation::GyroBiasFit fit = evaluation::fitGyroBias(imu, *truth);
  if (!fit.ok) check(fit.message, source);
  notes->push_back(fit.message);
  for (NavState& state : *truth) state.gyro_bias = fit.bias;
  return "fitted";
}

Motion recordedMotion(const std::string& folder, double max_imu_gap_s) {
  Motion motion;
  check(evaluation::readRecordedMotion(folder, max_imu_gap_s, &motion).message);
  motion.gyro_bias_truth = settleBiases(motion.has_velocity_and_bias, folder + ": ", motion.imu,
                                        &motion.truth, &motion.notes);
  std::string error;
  motion.trajectory = simulation::makeSampledTrajectory(motion.truth, &error);
  check(error, folder + ": groundtruth.csv: ");
  return motion;
}

Motion builtinMotion(const std::string& name, double duration_s, const Calibration& calibration,
                     unsigned seed) {
  Motion motion;
  motion.name = name;
  std::string error;
  motion.trajectory =
      simulation::makeBuiltinTrajectory(name, duration_s, calibration.R_b_c, seed, &error);
  check(error, "--builtin: ");
  return motion;
}

void simulateSensors(const Calibration& calibration, double imu_rate_hz, double image_rate_hz,
                     double margin_s, unsigned seed, Motion* motion) {
  simulation::ImuSimulationOptions imu;
  imu.rate_hz = imu_rate_hz;
  imu.noise = calibration.imu_noise;
  imu.gravity_magnitude = calibration.gravity_magnitude;
  imu.seed = seed;
  const simulation::Trajectory& trajectory = *motion->trajectory;
  motion->imu = simulation::simulateImu(trajectory, imu);
  motion->gyro_bias_truth = "simulated";
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
    const double t = trajectory.begin() + margin_s + static_cast<double>(k) / image_rate_hz;
    if (motion->imu.empty() || t > motion->imu.back().t - margin_s) break;
    motion->image_times.push_back(t);
  }
}

void discardUncovered(double td, Motion* motion) {
  std::vector<double>& times = motion->image_times;
  const std::size_t before = times.size();
  const auto uncovered = [&](double time) {
    const double t = time + td;
    return t < motion->imu.front().t || t > motion->imu.back().t || !motion->trajectory->covers(t);
  };
  times.erase(std::remove_if(times.begin(), times.end(), uncovered), times.end());
  if (times.empty()) {
    check(
        text(motion->name, ": none of ", before, " images lies within IMU data and ground truth"));
  }
  if (before == times.size()) return;
  motion->notes.push_back(text(before - times.size(), " of ", before,
                               " images lie outside the IMU data or the ground truth, or in a gap "
                               "of it, and were discarded"));
}

}  // namespace slim_init::tools
