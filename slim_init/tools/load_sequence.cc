// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "load_sequence.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "load_images.h"
#include "rig.h"
#include "slim_init/evaluation/recorded.h"
#include "slim_init/evaluation/rig_errors.h"
#include "slim_init/evaluation/truth.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/imu_simulator.h"
#include "slim_init/simulation/speed_simulator.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/simulation/world.h"

namespace slim_init::tools {
namespace {

constexpr double kImageRateHz = 20.0;  // EuRoC's

// A camera sees about a twentieth of the points on all walls, and a tenth of the segments.
constexpr int kWorldPointsPerTrackedPoint = 20;
constexpr int kWorldSegmentsPerTrackedLine = 10;

/// The rig of --config, otherwise EuRoC's.
Calibration calibrationFor(const AbOptions& options) {
  Calibration calibration = rigOf(options);
  calibration.sigmas = options.sigmas;
  calibration.sigma_px = options.sigma_px;
  calibration.sigma_line_px = options.sigma_line_px;
  options.setReadout(&calibration);
  return calibration;
}

/// True states at the image times (camera clock, `td` to the IMU clock) that the trajectory covers;
/// the other images are left out of `times` and counted in a note. Biases are left for the caller.
std::vector<NavState> statesAt(const simulation::Trajectory& trajectory, double td,
                               std::vector<double>* times, std::vector<std::string>* notes) {
  const auto uncovered = std::stable_partition(times->begin(), times->end(),
                                               [&](double t) { return trajectory.covers(t + td); });
  if (uncovered != times->end()) {
    notes->push_back(std::to_string(times->end() - uncovered) +
                     " images lie in gaps of the ground truth and were discarded");
    times->erase(uncovered, times->end());
  }
  std::vector<NavState> states;
  for (const double t : *times) states.push_back(simulation::stateAt(trajectory, t + td));
  return states;
}

/// Recorded biases, or one that is fitted. Returns an empty string or a message.
std::string settleBiases(bool has_bias, std::vector<NavState>* truth, LoadedSequence* loaded) {
  evaluation::Sequence& sequence = loaded->sequence;
  loaded->gyro_bias_truth = has_bias ? "recorded" : "fitted";
  if (has_bias) return "";
  const evaluation::GyroBiasFit fit = evaluation::fitGyroBias(sequence.imu, *truth);
  if (!fit.ok) return fit.message;
  sequence.notes.push_back(fit.message);
  for (NavState& state : *truth) state.gyro_bias = fit.bias;
  return "";
}

void setBiases(const std::vector<NavState>& truth, NavState* state) {
  const NavState& nearest =
      truth[static_cast<std::size_t>(evaluation::nearestState(truth, state->t))];
  state->gyro_bias = nearest.gyro_bias;
  state->accel_bias = nearest.accel_bias;
}

/// Truth between the frames; `truth` has the biases.
void setTruthBetween(std::unique_ptr<simulation::Trajectory> trajectory,
                     std::vector<NavState> truth, evaluation::Sequence* sequence) {
  const std::shared_ptr<const simulation::Trajectory> path = std::move(trajectory);
  sequence->truth_between = [path, truth = std::move(truth)](double t) {
    if (!path->covers(t)) return NavState();
    NavState state = simulation::stateAt(*path, t);
    setBiases(truth, &state);
    return state;
  };
}

/// Fills sequence.frames with what a front end would have seen; sequence.truth is the path.
void addFeatures(const AbOptions& options, const simulation::Trajectory& trajectory,
                 const std::vector<double>& image_times, LoadedSequence* loaded) {
  evaluation::Sequence* sequence = &loaded->sequence;
  simulation::WorldOptions world_options;
  world_options.kind = options.world_kind;
  world_options.seed = options.seed;
  world_options.points =
      std::max(world_options.points, kWorldPointsPerTrackedPoint * options.features.max_points);
  world_options.segments =
      std::max(world_options.segments, kWorldSegmentsPerTrackedLine * options.features.max_lines);
  simulation::FeatureSimulationOptions features = options.features;
  features.seed = options.seed;
  features.camera = cameraOf(options);

  std::vector<Eigen::Vector3d> path_w;
  for (const NavState& state : sequence->truth) path_w.push_back(state.p_w_b);
  const simulation::World world = simulation::makeWorld(world_options, path_w);
  loaded->simulated.emplace();
  sequence->frames = simulation::simulateFeatures(trajectory, world, sequence->calibration,
                                                  image_times, features, &*loaded->simulated);
}

/// Simulated speeds in place of recorded ones.
void addSpeeds(const AbOptions& options, const simulation::Trajectory& trajectory,
               evaluation::Sequence* sequence) {
  SpeedSensor& sensor = sequence->calibration.speed_sensor;
  if (options.given.count("speed") > 0) {
    if (!sensor.calibrated) sensor = simulation::simulatedSpeedSensor(sequence->calibration);
    simulation::SpeedSimulationOptions speed = options.speed;
    speed.seed = options.seed;
    sequence->speeds = simulation::simulateSpeeds(trajectory, sensor, speed);
  } else {
    discardUncalibratedSpeeds(sequence);
  }
}

std::string loadRecorded(const AbOptions& options, LoadedSequence* loaded) {
  evaluation::RecordedMotion motion;
  const evaluation::ReadStatus status = evaluation::readRecordedMotion(
      options.recorded, options.initializer.window.max_imu_gap_s, &motion);
  if (!status.ok()) return status.message;

  evaluation::Sequence& sequence = loaded->sequence;
  sequence.name = motion.name;
  sequence.calibration = calibrationFor(options);
  sequence.t0_ns = motion.t0_ns;
  sequence.notes = motion.notes;
  sequence.imu = std::move(motion.imu);
  sequence.speeds = std::move(motion.speeds);
  if (std::string problem = settleBiases(motion.has_velocity_and_bias, &motion.truth, loaded);
      !problem.empty()) {
    return options.recorded + ": " + problem;
  }

  std::string error;
  auto trajectory = simulation::makeSampledTrajectory(motion.truth, &error);
  if (trajectory == nullptr) return options.recorded + ": groundtruth.csv: " + error;
  sequence.truth =
      statesAt(*trajectory, sequence.calibration.td, &motion.image_times, &sequence.notes);
  if (sequence.truth.empty()) {
    return options.recorded + ": every image lies in a gap of groundtruth.csv";
  }
  for (NavState& state : sequence.truth) setBiases(motion.truth, &state);
  addSpeeds(options, *trajectory, &sequence);
  addFeatures(options, *trajectory, motion.image_times, loaded);
  setTruthBetween(std::move(trajectory), std::move(motion.truth), &sequence);
  return "";
}

std::string loadBuiltin(const AbOptions& options, LoadedSequence* loaded) {
  evaluation::Sequence& sequence = loaded->sequence;
  sequence.name = options.builtin;
  sequence.calibration = calibrationFor(options);
  loaded->gyro_bias_truth = "simulated";

  std::string error;
  auto trajectory = simulation::makeBuiltinTrajectory(
      options.builtin, options.duration_s, sequence.calibration.R_b_c, options.seed, &error);
  if (trajectory == nullptr) return "--builtin: " + error;

  simulation::ImuSimulationOptions imu;
  imu.noise = sequence.calibration.imu_noise;
  imu.gravity_magnitude = sequence.calibration.gravity_magnitude;
  imu.seed = options.seed;
  sequence.imu = simulation::simulateImu(*trajectory, imu);

  std::vector<double> image_times;
  for (int k = 0;; ++k) {
    const double t = trajectory->begin() + k / kImageRateHz;
    if (sequence.imu.empty() || t > sequence.imu.back().t) break;
    image_times.push_back(t);
  }
  sequence.truth = statesAt(*trajectory, sequence.calibration.td, &image_times, &sequence.notes);
  for (NavState& state : sequence.truth) {
    state.gyro_bias = imu.gyro_bias;
    state.accel_bias = imu.accel_bias;
  }
  addSpeeds(options, *trajectory, &sequence);
  addFeatures(options, *trajectory, image_times, loaded);
  // The biases are constant: one state has them.
  if (!sequence.truth.empty()) {
    setTruthBetween(std::move(trajectory), {sequence.truth.front()}, &sequence);
  }
  return "";
}

}  // namespace

void discardUncalibratedSpeeds(evaluation::Sequence* sequence) {
  if (sequence->calibration.speed_sensor.calibrated || sequence->speeds.empty()) return;
  sequence->notes.push_back(std::to_string(sequence->speeds.size()) +
                            " measured velocities were discarded: speed_rotation and "
                            "speed_translation of the sensor are not in --config");
  sequence->speeds.clear();
}

std::string addTruth(std::vector<NavState> truth, bool has_bias, const std::string& source,
                     const std::vector<double>& times, LoadedSequence* loaded) {
  evaluation::Sequence& sequence = loaded->sequence;
  sequence.truth.assign(times.size(), NavState());  // t is NaN
  sequence.has_truth = !truth.empty();
  if (!sequence.has_truth) {
    loaded->gyro_bias_truth = "none";
    return "";
  }
  std::string problem = settleBiases(has_bias, &truth, loaded);
  std::string error;
  auto trajectory = simulation::makeSampledTrajectory(truth, &error);
  if (problem.empty() && trajectory == nullptr) problem = "ground truth: " + error;
  if (!problem.empty()) return source + ": " + problem;
  int uncovered = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double t = times[i] + sequence.trueCalibration().td;
    if (!trajectory->covers(t)) {
      ++uncovered;
      continue;
    }
    sequence.truth[i] = simulation::stateAt(*trajectory, t);
    setBiases(truth, &sequence.truth[i]);
  }
  if (uncovered == static_cast<int>(times.size())) {
    return source + ": no image lies within the ground truth";
  }
  if (uncovered > 0) {
    sequence.notes.push_back(source + ": " + std::to_string(uncovered) + " of " +
                             std::to_string(times.size()) +
                             " tracked images lie outside the ground truth or in a gap of it; "
                             "windows with such a keyframe are not evaluated");
  }
  setTruthBetween(std::move(trajectory), std::move(truth), &sequence);
  return "";
}

std::string loadSequence(const AbOptions& options, LoadedSequence* loaded) {
  std::string sentence = options.hasImages()        ? loadImages(options, loaded)
                         : options.recorded.empty() ? loadBuiltin(options, loaded)
                                                    : loadRecorded(options, loaded);
  if (!sentence.empty()) return sentence;
  sentence = evaluation::applyRigErrors(options.rig, options.hasImages(), &loaded->sequence);
  return sentence.empty() ? "" : loaded->sequence.name + ": " + sentence;
}

}  // namespace slim_init::tools
