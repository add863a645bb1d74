// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "load_sequence.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <utility>
#include <vector>

#include "exit_code.h"
#include "motion.h"
#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/rig_errors.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/evaluation/track_images.h"
#include "slim_init/evaluation/truth.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/simulation/world.h"
#include "slim_init/text.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kImageRateHz = 20.0;  // EuRoC's

// A camera sees about a twentieth of the points on all walls, and a tenth of the segments.
constexpr int kWorldPointsPerTrackedPoint = 20;
constexpr int kWorldSegmentsPerTrackedLine = 10;

/// The rig of --config, otherwise EuRoC's.
Calibration calibrationFor(const AbOptions& options) {
  const Calibration& of_files = options.config->calibration;
  Calibration calibration = options.config_file.empty() ? eurocCalibration() : of_files;
  calibration.sigmas = of_files.sigmas;
  calibration.sigma_px = of_files.sigma_px;
  calibration.sigma_line_px = of_files.sigma_line_px;
  options.setReadout(&calibration);
  return calibration;
}

/// The camera of --config without its distortion, otherwise EuRoC's.
simulation::PinholeCamera cameraOf(const AbOptions& options) {
  simulation::PinholeCamera camera = options.features.camera;
  if (!options.config_file.empty()) {
    const feature_tracker_lines::CameraParameters& from = options.config->camera;
    camera.width = from.width;
    camera.height = from.height;
    // In the middle of its image a MEI camera has this focal length.
    camera.fx = from.fx / (1.0 + from.xi);
    camera.fy = from.fy / (1.0 + from.xi);
    camera.cx = from.cx;
    camera.cy = from.cy;
  }
  return camera;
}

/// Sets the truth of the sequence: that of the trajectory, with the biases of the nearest state of
/// `truth`.
void setTruth(std::unique_ptr<simulation::Trajectory> trajectory, std::vector<NavState> truth,
              evaluation::Sequence* sequence) {
  const std::shared_ptr<const simulation::Trajectory> path = std::move(trajectory);
  sequence->truth = [path, truth = std::move(truth)](double t) {
    if (!path->covers(t)) return NavState();
    NavState state = simulation::stateAt(*path, t);
    const NavState& nearest = truth[evaluation::nearestState(truth, t)];
    state.gyro_bias = nearest.gyro_bias;
    state.accel_bias = nearest.accel_bias;
    return state;
  };
}

/// Fills sequence.frames with what a front end would have seen.
void addFeatures(const AbOptions& options, const simulation::Trajectory& trajectory,
                 const std::vector<double>& image_times, LoadedSequence* loaded) {
  evaluation::Sequence* sequence = &loaded->sequence;
  simulation::WorldOptions world_options;
  world_options.kind = options.world;
  world_options.seed = options.seed;
  world_options.points =
      std::max(world_options.points, kWorldPointsPerTrackedPoint * options.features.max_points);
  world_options.segments =
      std::max(world_options.segments, kWorldSegmentsPerTrackedLine * options.features.max_lines);
  simulation::FeatureSimulationOptions features = options.features;
  features.seed = options.seed;
  features.camera = cameraOf(options);

  std::vector<Eigen::Vector3d> path_w;
  const double td = sequence->calibration.td;
  for (const double t : image_times) path_w.push_back(trajectory.at(t + td).p_w_b);
  const simulation::World world = simulation::makeWorld(world_options, path_w);
  loaded->simulated.emplace();
  sequence->frames = simulation::simulateFeatures(trajectory, world, sequence->calibration,
                                                  image_times, features, &*loaded->simulated);
}

/// Empties sequence->speeds, with a note, where the calibration lacks the sensor.
void discardUncalibratedSpeeds(evaluation::Sequence* sequence) {
  if (sequence->calibration.speed_sensor.calibrated || sequence->speeds.empty()) return;
  sequence->notes.push_back(std::to_string(sequence->speeds.size()) +
                            " measured velocities were discarded: speed_rotation and "
                            "speed_translation of the sensor are not in --config");
  sequence->speeds.clear();
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

/// All but the images and the truth.
void take(const evaluation::RecordedMotion& recording, evaluation::Sequence* sequence) {
  sequence->name = recording.name;
  sequence->t0_ns = recording.t0_ns;
  sequence->notes = recording.notes;
  sequence->imu = recording.imu;
  sequence->speeds = recording.speeds;
}

/// --recorded or --builtin.
void loadMotion(const AbOptions& options, LoadedSequence* loaded) {
  evaluation::Sequence& sequence = loaded->sequence;
  sequence.calibration = calibrationFor(options);
  Motion motion;
  if (!options.recorded.empty()) {
    motion = recordedMotion(options.recorded, options.initializer.window.max_imu_gap_s);
  } else {
    motion = builtinMotion(options.builtin, options.duration_s, sequence.calibration, options.seed);
    simulateSensors(sequence.calibration, simulation::ImuSimulationOptions().rate_hz, kImageRateHz,
                    0.0, options.seed, &motion);
  }
  discardUncovered(sequence.calibration.td, &motion);
  take(motion, &sequence);
  loaded->gyro_bias_truth = motion.gyro_bias_truth;
  addSpeeds(options, *motion.trajectory, &sequence);
  addFeatures(options, *motion.trajectory, motion.image_times, loaded);
  setTruth(std::move(motion.trajectory), std::move(motion.truth), &sequence);
}

std::unique_ptr<evaluation::ImageSequence> openImages(const AbOptions& options) {
  const double max_imu_gap_s = options.initializer.window.max_imu_gap_s;
  if (!options.asl.empty()) return openAsl(options.asl, max_imu_gap_s);
  evaluation::BagTopics topics = topicsOf(*options.config);
  topics.speed = options.config->speed_topic;
  topics.speed_forward_only = options.config->speed_forward_only;
  std::string truth = evaluation::groundtruthFileOf(options.bag);
  std::error_code code;
  if (!fs::exists(truth, code)) truth.clear();
  return openBag(options.bag, topics, truth, max_imu_gap_s);
}

void noteTracking(const evaluation::TrackingSummary& tracking, const std::string& name,
                  std::vector<std::string>* notes) {
  const auto note = [&](int count, const std::string& what) {
    if (count == 0) return;
    notes->push_back(text(name, ": ", count, " of ", tracking.images, " images ", what));
  };
  const std::string first =
      tracking.first_problem.empty() ? "" : "; first: " + tracking.first_problem;
  note(tracking.outside_imu, "lie outside the IMU data and were discarded");
  note(tracking.unreadable, "cannot be read and were discarded" + first);
  note(tracking.refused, "were refused by the front end and discarded" + first);
  note(tracking.images_without_gyro, "were tracked without a rotation from the gyro");
}

/// Sets the truth of the sequence from that of a recording. Without biases in it one gyroscope bias
/// is fitted to sequence.imu; without any truth the sequence has none.
void addTruth(const evaluation::ImageSequence& images, LoadedSequence* loaded) {
  evaluation::Sequence& sequence = loaded->sequence;
  const std::string& source = images.name;
  std::vector<NavState> truth = images.truth;
  if (truth.empty()) {
    loaded->gyro_bias_truth = "none";
    sequence.notes.push_back(source + ": without ground truth there are no errors to report");
    return;
  }
  loaded->gyro_bias_truth = settleBiases(images.has_velocity_and_bias, source + ": ", sequence.imu,
                                         &truth, &sequence.notes);
  std::string error;
  auto trajectory = simulation::makeSampledTrajectory(truth, &error);
  check(error, source + ": ground truth: ");
  setTruth(std::move(trajectory), std::move(truth), &sequence);
  const auto frames = sequence.frames.size();
  const auto uncovered = static_cast<std::size_t>(std::count_if(
      sequence.frames.begin(), sequence.frames.end(), [&sequence](const FrameObservation& frame) {
        return !std::isfinite(truthAt(sequence, sequence.calibration.imuTime(frame.t)).t);
      }));
  if (uncovered == frames) check(source + ": no image lies within the ground truth");
  if (uncovered > 0) {
    sequence.notes.push_back(text(source, ": ", uncovered, " of ", frames,
                                  " tracked images lie outside the ground truth or in a gap of it; "
                                  "windows with such a keyframe are not evaluated"));
  }
}

/// Reads --asl or --bag and tracks points and lines through its images, with a progress bar.
void loadImages(const AbOptions& options, LoadedSequence* loaded) {
  const std::unique_ptr<evaluation::ImageSequence> images = openImages(options);
  Config config;
  if (options.config_file.empty()) {
    configureFromData(options.asl, options.options_file, &config);
  } else {
    config = *options.config;
  }

  evaluation::Sequence& sequence = loaded->sequence;
  take(*images, &sequence);
  options.setReadout(&config.calibration);
  sequence.calibration = config.calibration;
  discardUncalibratedSpeeds(&sequence);
  // The front end runs on the same rig as the methods: wrong calibration, worse IMU.
  check(evaluation::disturbImu(options.rig, &images->imu), images->name + ": ");
  const Calibration assumed =
      evaluation::assumedCalibration(config.calibration, options.rig, evaluation::kAllTrials);
  check(assumed.validate(), images->name + ": the calibration with its errors: ");

  evaluation::TrackingSummary tracking;
  {
    ProgressBar bar(images->name + ": images", !options.quiet);
    // One thread, as the times in the report say; OpenCV's own cost more than they save here.
    cv::setNumThreads(1);
    check(evaluation::trackImages(
        images.get(), config.camera, assumed, config.front_end,
        [&bar](int done, int total) { bar.update(done, total); }, &sequence.frames, &tracking));
  }
  noteTracking(tracking, images->name, &sequence.notes);
  sequence.tracking = std::move(tracking);
  addTruth(*images, loaded);
}

}  // namespace

Calibration eurocCalibration() {
  // T_BS of cam0/sensor.yaml, the same in every EuRoC sequence.
  Eigen::Matrix3d R_b_c;
  R_b_c << 0.0148655429818, -0.999880929698, 0.00414029679422,  //
      0.999557249008, 0.0149672133247, 0.025715529948,          //
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  // Twelve printed digits are a rotation to 1e-12 only; the nearest one is exact.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R_b_c, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Calibration calibration;
  calibration.R_b_c = svd.matrixU() * svd.matrixV().transpose();
  calibration.t_b_c = Eigen::Vector3d(-0.0216401454975, -0.064676986768, 0.00981073058949);
  calibration.focal_px = 458.0;  // between fx 458.654 and fy 457.296
  return calibration;
}

std::unique_ptr<evaluation::ImageSequence> openAsl(const std::string& folder,
                                                   double max_imu_gap_s) {
  evaluation::ReadStatus status;
  auto images = evaluation::openAslFolder(folder, max_imu_gap_s, &status);
  check(status.message);
  return images;
}

evaluation::BagTopics topicsOf(const Config& config) {
  evaluation::BagTopics topics;
  if (!config.imu_topic.empty()) topics.imu = config.imu_topic;
  if (!config.image_topic.empty()) topics.image = config.image_topic;
  return topics;
}

std::unique_ptr<evaluation::ImageSequence> openBag(const std::string& file,
                                                   const evaluation::BagTopics& topics,
                                                   const std::string& truth, double max_imu_gap_s) {
  evaluation::ReadStatus status;
  auto images = evaluation::openRosbag(file, topics, truth, max_imu_gap_s, &status);
  check(status.message);
  return images;
}

void configureFromData(const std::string& source, const std::string& options_file, Config* config) {
  std::string error;
  if (!loadSensorFiles(source, config, &error)) {
    check(text(source, " has no calibration that can be used (", error,
               "); give one with --config YAML"));
  }
  if (!options_file.empty() && !loadOptions(options_file, config, &error)) {
    check(error, "--options: ");
  }
}

LoadedSequence loadSequence(const AbOptions& options) {
  LoadedSequence loaded;
  (options.hasImages() ? loadImages : loadMotion)(options, &loaded);
  check(evaluation::applyRigErrors(options.rig, &loaded.sequence), loaded.sequence.name + ": ");
  return loaded;
}

}  // namespace slim_init::tools
