// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "backend/simulated_sequence.h"

#include <memory>
#include <vector>

#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/simulation/trajectory.h"
#include "support/exact_window.h"

namespace slim_init {
namespace {

constexpr double kImageRate = 10.0;  // [Hz]; what VINS-Mono's tracker hands to its estimator

}  // namespace

evaluation::Sequence makeSimulatedSequence(const SimulatedSequenceOptions& options) {
  evaluation::Sequence sequence;
  sequence.name = options.motion;
  sequence.calibration = eurocCalibration();
  sequence.calibration.sigma_px = simulation::FeatureSimulationOptions().pixel_noise;
  const std::shared_ptr<const simulation::Trajectory> trajectory =
      simulation::makeBuiltinTrajectory(options.motion, options.duration_s,
                                        sequence.calibration.R_b_c, options.seed);
  if (trajectory == nullptr) return sequence;

  simulation::ImuSimulationOptions imu;
  imu.noise = sequence.calibration.imu_noise;
  imu.gravity_magnitude = sequence.calibration.gravity_magnitude;
  imu.seed = options.seed;
  sequence.imu = simulation::simulateImu(*trajectory, imu);

  sequence.truth = [trajectory, imu](double t) {
    if (!trajectory->covers(t)) return NavState();
    NavState state = simulation::stateAt(*trajectory, t);
    state.gyro_bias = imu.gyro_bias;
    state.accel_bias = imu.accel_bias;
    return state;
  };
  std::vector<double> times;
  std::vector<Eigen::Vector3d> path;
  for (int k = 0; k / kImageRate <= sequence.imu.back().t; ++k) {
    const double t = k / kImageRate;
    times.push_back(t);
    path.push_back(sequence.truth(t).p_w_b);
  }

  simulation::WorldOptions world;
  world.seed = options.seed;
  simulation::FeatureSimulationOptions features;
  features.outlier_rate = options.outlier_rate;
  features.track_life = 1.8 * kImageRate;  // [frames]; 36 at 20 Hz by default
  features.seed = options.seed;
  sequence.frames = simulation::simulateFeatures(*trajectory, simulation::makeWorld(world, path),
                                                 sequence.calibration, times, features);
  return sequence;
}

}  // namespace slim_init
