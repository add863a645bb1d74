// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "exit_code.h"
#include "load_sequence.h"
#include "motion.h"
#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/recorded.h"
#include "slim_init/evaluation/report.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/evaluation/write_file.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/options.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/simulation/rendering.h"
#include "slim_init/simulation/scene.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/text.h"
#include "subcommand.h"

namespace slim_init::tools {
namespace {

using feature_tracker_lines::CameraParameters;

/// The command line of `slim_init simulate`.
struct SimulateOptions {
  std::string csv;       ///< file of poses; one of these three
  std::string builtin;   ///< name of a motion
  std::string recorded;  ///< folder with real IMU data and image times
  simulation::SceneOptions scene;
  double start_s = 0.0;     ///< from the first image that could be rendered
  double duration_s = 0.0;  ///< of the images; 0: to the end of the motion, 20 s of a built-in one
  std::string config;       ///< YAML with camera and extrinsic; empty: EuRoC's cam0
  double image_scale = 1.0;
  double rate_hz = 20.0;  ///< of images where the motion has no image times of its own
  simulation::SpeedSimulationOptions speed;  ///< noise below zero: none are written
  double imu_rate_hz = 200.0;                ///< where the IMU is simulated
  simulation::SensorOptions sensor;
  double motion_blur_ms = 0.0;
  double readout_s = 0.0;            ///< rolling shutter; 0: that of `config`
  unsigned seed = 1;                 ///< of all of them
  simulation::RenderOptions render;  ///< its work_directory is `out`
  std::string out = "out/simulate";
  std::string bag;  ///< file; empty: none
  bool quiet = false;

  SimulateOptions() { speed.noise = -1.0; }
};

constexpr std::int64_t kBuiltinT0Ns = 1400000000000000000;  // a stamp that ros::Time can hold
constexpr double kBuiltinDuration = 20.0;                   // [s]
// IMU and truth reach this far beyond the images: integration and interpolation need neighbours.
constexpr double kMargin = 0.1;  // [s]
constexpr int kSubFrames = 5;    // pictures averaged with motion blur
constexpr int kBands = 16;  // pictures of an image with a rolling shutter, blended between rows

// EuRoC's cam0 (sensor.yaml of the dataset).
CameraParameters eurocCamera() {
  CameraParameters camera;
  camera.fx = 458.654;
  camera.fy = 457.296;
  camera.cx = 367.215;
  camera.cy = 248.375;
  camera.distortion = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  return camera;
}

void loadRig(const SimulateOptions& options, Calibration* calibration, CameraParameters* camera) {
  *calibration = eurocCalibration();
  *camera = eurocCamera();
  if (!options.config.empty()) {
    Config config;
    std::string error;
    if (!loadConfig(options.config, &config, &error)) check(error, "--config: ");
    *calibration = config.calibration;
    *camera = config.camera;
  }
  const double scale = options.image_scale;
  camera->width = static_cast<int>(std::lround(scale * camera->width));
  camera->height = static_cast<int>(std::lround(scale * camera->height));
  camera->fx *= scale;
  camera->fy *= scale;
  // Pixel centres are at whole numbers: the image's edge at -0.5 stays where it is.
  camera->cx = scale * (camera->cx + 0.5) - 0.5;
  camera->cy = scale * (camera->cy + 0.5) - 0.5;
  calibration->focal_px = feature_tracker_lines::Camera(*camera).focalPx();
  if (options.readout_s > 0.0) calibration->readout_s = options.readout_s;
  check(camera->validate());
}

// Keeps the elements in [low, high].
template <typename T>
void cut(double low, double high, std::vector<T>* list) {
  list->erase(std::remove_if(list->begin(), list->end(),
                             [&](const T& x) { return x.t < low || x.t > high; }),
              list->end());
}

// Keeps the images from --start on for --duration; the clock starts at the first that can be
// rendered.
void cutImages(const SimulateOptions& options, const Calibration& calibration, Motion* motion) {
  discardUncovered(calibration.td, motion);
  std::vector<double>& times = motion->image_times;
  const double begin = times.front() + options.start_s;
  const double last = times.back();
  const double end = options.duration_s > 0.0 ? begin + options.duration_s : last;
  // With a tolerance of half a nanosecond: the sum is rounded.
  times.erase(std::remove_if(times.begin(), times.end(),
                             [&](double t) { return t < begin - 5e-10 || t > end + 5e-10; }),
              times.end());
  if (times.size() < 2) {
    check(text("--start ", options.start_s, ", --duration ", options.duration_s,
               " and --rate leave ", times.size(), " images of ", motion->name, ", which span ",
               last - (begin - options.start_s), " s; at least 2 are needed"));
  }
}

Motion csvMotion(const SimulateOptions& options) {
  Motion motion;
  check(evaluation::readPoses(options.csv, &motion).message, "--csv: ");
  const std::vector<NavState> poses = std::exchange(motion.truth, {});
  motion.name = std::filesystem::path(options.csv).stem().string();
  constexpr double kSmoothRate = 20.0;  // [Hz]
  std::string error;
  motion.trajectory = simulation::makeSmoothTrajectory(poses, kSmoothRate, &error);
  check(error, "--csv: " + options.csv + ": ");
  return motion;
}

// Reads or makes the motion that the options name, cut to what the images need; all fields of its
// ground truth are finite. Throws a Failure that names file, line, value or option.
Motion loadMotion(const SimulateOptions& options, const Calibration& calibration) {
  Motion motion;
  if (!options.recorded.empty()) {
    motion = recordedMotion(options.recorded, WindowOptions().max_imu_gap_s);
    if (motion.gyro_bias_truth == "fitted") {
      motion.notes.push_back(
          "the accelerometer bias is not known; the written ground truth has zero instead");
      for (NavState& state : motion.truth) state.accel_bias.setZero();
    }
  } else {
    if (!options.csv.empty()) {
      motion = csvMotion(options);
    } else {
      const double duration = options.duration_s > 0.0 ? options.duration_s : kBuiltinDuration;
      motion = builtinMotion(options.builtin, options.start_s + 2.0 * kMargin + 0.01 + duration,
                             calibration, options.seed);
      motion.t0_ns = kBuiltinT0Ns;
    }
    simulateSensors(calibration, options.imu_rate_hz, options.rate_hz, kMargin, options.seed,
                    &motion);
  }
  cutImages(options, calibration, &motion);
  const double low = motion.image_times.front() + calibration.td - kMargin;
  const double high = motion.image_times.back() + calibration.td + kMargin;
  cut(low, high, &motion.imu);
  // Recorded truth may be sparse: a few more samples for interpolation.
  cut(low - 0.5, high + 0.5, &motion.truth);
  return motion;
}

simulation::CameraPose poseAt(const Motion& motion, const Calibration& calibration, double t_imu) {
  const simulation::Kinematics body = motion.trajectory->at(t_imu);
  simulation::CameraPose pose;
  pose.R_w_c = body.R_w_b * calibration.R_b_c;
  pose.t_w_c = body.p_w_b + body.R_w_b * calibration.t_b_c;
  return pose;
}

// Pictures that are averaged over the exposure.
int subFramesOf(const SimulateOptions& options) {
  return options.motion_blur_ms > 0.0 ? kSubFrames : 1;
}

// Instants within the readout at which pictures are drawn: one for a global shutter.
int bandsOf(const Calibration& calibration) { return calibration.readout_s > 0.0 ? kBands : 1; }

// Poses of all pictures: per image bandsOf(), from the first rows to the last, each of them
// subFramesOf(), spread over the exposure.
std::vector<simulation::CameraPose> posesOf(const SimulateOptions& options, const Motion& motion,
                                            const Calibration& calibration) {
  const double exposure = 1e-3 * options.motion_blur_ms;
  const int sub_frames = subFramesOf(options), bands = bandsOf(calibration);
  std::vector<simulation::CameraPose> poses;
  for (const double t : motion.image_times) {
    for (int band = 0; band < bands; ++band) {
      const double row = ((band + 0.5) / bands - 0.5) * calibration.readout_s;
      for (int i = 0; i < sub_frames; ++i) {
        const double offset = ((i + 0.5) / sub_frames - 0.5) * exposure;
        poses.push_back(poseAt(motion, calibration, t + calibration.td + row + offset));
      }
    }
  }
  return poses;
}

// The mean of the next pictures.
cv::Mat meanOfNext(int count, simulation::Renderer* renderer) {
  cv::Mat sum;
  for (int i = 0; i < count; ++i) {
    std::string error;
    const cv::Mat picture = renderer->next(&error);
    if (picture.empty()) throw Failure(kExitInternal, error);
    sum = i == 0 ? picture : cv::Mat(sum + picture);
  }
  return count > 1 ? cv::Mat(sum / count) : sum;
}

// Draws, exposes and writes every image.
void writeImages(const SimulateOptions& options, const Motion& motion, int bands,
                 simulation::Renderer* renderer) {
  ProgressBar bar(motion.name + " in " + options.scene.kind, !options.quiet);
  const std::size_t count = motion.image_times.size();
  const int sub_frames = subFramesOf(options);
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<cv::Mat> pictures;
    for (int band = 0; band < bands; ++band) pictures.push_back(meanOfNext(sub_frames, renderer));
    const cv::Mat radiance = simulation::mergeBands(pictures);
    const double t = motion.image_times[k];
    const cv::Mat image =
        simulation::expose(radiance, static_cast<std::int64_t>(k), t, options.sensor);
    check(evaluation::writeAslImage(options.out, motion.stampNs(t), image), "", kExitInternal);
    bar.update(static_cast<int>(k + 1), static_cast<int>(count));
  }
}

// What a sequence is made from.
struct Setup {
  Calibration calibration;
  CameraParameters camera;
  Motion motion;
  std::vector<simulation::CameraPose> poses;  // of all pictures
  simulation::Scene scene;
};

// What several options together ask for, and whether it is part of this build and machine.
void checkOptions(const SimulateOptions& o) {
  const int sources =
      (o.csv.empty() ? 0 : 1) + (o.builtin.empty() ? 0 : 1) + (o.recorded.empty() ? 0 : 1);
  if (sources == 0) check("one of --csv FILE, --builtin NAME and --recorded DIR is needed");
  if (sources > 1) check("--csv, --builtin and --recorded exclude each other");
  std::string error;
  if (!simulation::povrayAvailable(o.render.program, &error)) check(error);
  if (!o.bag.empty() && !evaluation::rosbagSupported()) {
    check("--bag: this program was built without the rosbag library");
  }
}

// The speeds of --speed; recorded ones are left out.
std::vector<SpeedSample> speedsOf(const SimulateOptions& options, const Motion& motion,
                                  const Calibration& calibration) {
  if (options.speed.noise < 0.0) return {};
  SpeedSensor sensor = calibration.speed_sensor;
  if (!sensor.calibrated) sensor = simulation::simulatedSpeedSensor(calibration);
  auto speeds = simulation::simulateSpeeds(*motion.trajectory, sensor, options.speed);
  cut(motion.imu.front().t, motion.imu.back().t, &speeds);
  return speeds;
}

Setup prepare(const SimulateOptions& options) {
  Setup setup;
  loadRig(options, &setup.calibration, &setup.camera);
  setup.motion = loadMotion(options, setup.calibration);
  for (const std::string& note : setup.motion.notes) {
    std::cerr << "slim_init: note: " << note << "\n";
  }
  setup.motion.speeds = speedsOf(options, setup.motion, setup.calibration);
  // The scene is built around the whole path of the camera.
  setup.poses = posesOf(options, setup.motion, setup.calibration);
  std::vector<Eigen::Vector3d> path_w;
  for (const simulation::CameraPose& pose : setup.poses) path_w.push_back(pose.t_w_c);
  std::string error;
  if (!simulation::makeScene(options.scene, path_w, &setup.scene, &error)) check(error);
  return setup;
}

void printResult(const SimulateOptions& options, const Setup& setup, double seconds) {
  const std::vector<double>& times = setup.motion.image_times;
  std::cout << roundedText(3, times.size(), " images of ", setup.camera.width, "x",
                           setup.camera.height, " over ", times.back() - times.front(), " s in ",
                           options.out, ", ", seconds / static_cast<double>(times.size()),
                           " s per image\n");
}

int runSimulate(SimulateOptions options) {
  checkOptions(options);
  options.scene.seed = options.speed.seed = options.sensor.seed = options.seed;
  options.render.work_directory = options.out;
  const Setup setup = prepare(options);
  const evaluation::WriterRig rig = {
      setup.calibration, setup.camera,
      "simulated: " + setup.motion.name + " in " + options.scene.kind};
  check(evaluation::writeAslFolder(options.out, rig, setup.motion), "--out: ");
  if (!options.bag.empty()) {
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(options.bag).parent_path(), ignored);
    for (const std::string& file : {options.bag, evaluation::groundtruthFileOf(options.bag)}) {
      check(evaluation::checkWritable(file), "--bag: ");
    }
    const std::int64_t first = setup.motion.stampNs(setup.motion.imu.front().t);
    if (first <= 0) {
      check(text("the first stamp is ", first, " ns, a bag needs positive ones"), "--bag: ");
    }
  }

  const auto start = std::chrono::steady_clock::now();
  std::string error;
  const auto renderer =
      simulation::Renderer::start(setup.scene, setup.camera, setup.poses, options.render, &error);
  if (renderer == nullptr) throw Failure(kExitBadInput, error);
  writeImages(options, setup.motion, bandsOf(setup.calibration), renderer.get());
  if (!options.bag.empty()) {
    check(evaluation::writeBag(options.out, evaluation::BagTopics(), options.bag),
          "--bag: ", kExitInternal);
  }
  if (!options.quiet) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    printResult(options, setup, elapsed.count());
  }
  return kExitOk;
}

}  // namespace

Subcommand simulateSubcommand() {
  const auto options = std::make_shared<SimulateOptions>();
  SimulateOptions& o = *options;
  constexpr double kMaxSeed = std::numeric_limits<unsigned>::max();
  const std::vector<AbOption> table = {
      {"csv", &o.csv, "FILE",
       "Motion from poses: stamp [ns], position [m], quaternion w x y z of the body, as in "
       "EuRoC's "
       "ground truth; the IMU is simulated"},
      {"builtin", &o.builtin, "NAME", "Built-in motion; the IMU is simulated", "", 0.0, 0.0,
       OptionScope::kAlways, simulation::builtinTrajectoryNames()},
      {"recorded", &o.recorded, "DIR",
       "Folder with imu0.csv, cam0_timestamps.csv, groundtruth.csv: the real IMU and the real "
       "image times are kept"},
      {"scene", &o.scene.kind, "NAME", "Scene", "", 0.0, 0.0, OptionScope::kAlways,
       simulation::sceneNames()},
      {"start", &o.start_s, "X", "Skip this much of the motion [s]", "", 0.0, 1e6},
      {"duration", &o.duration_s, "X",
       "Length of the images [s]; 0: to the end of the motion, 20 s of a built-in one", "", 0.0,
       1e6},
      {"config", &o.config, "FILE",
       "YAML file with camera, extrinsic and td (default: EuRoC's cam0 and IMU)"},
      {"image-scale", &o.image_scale, "X", "Size of the images as a multiple of the camera's", "",
       0.05, 4.0},
      {"rate", &o.rate_hz, "X", "Images per second, not with --recorded", "", 0.1, 1000.0},
      {"imu-rate", &o.imu_rate_hz, "X", "IMU samples per second, not with --recorded", "", 20.0,
       4000.0},
      {"speed", &o.speed.noise, "X",
       "Write the forward speeds of `ab --speed X` into DIR/mav0/speed0/data.csv and the bag's "
       "/speed0",
       "", 0.0, 1.0},
      {"read-noise", &o.sensor.read_noise, "X",
       "Noise in the dark, standard deviation [grey levels]", "", 0.0, 100.0},
      {"shot-noise", &o.sensor.shot_noise, "X", "Variance of the noise per grey level of signal",
       "", 0.0, 100.0},
      {"motion-blur", &o.motion_blur_ms, "X", "Exposure time centred on the stamp [ms]; 0: none",
       "", 0.0, 1000.0},
      {"readout", &o.readout_s, "X",
       "Rolling shutter: time from the first row to the last, the stamp being that of the "
       "middle "
       "row [s]; 0: that of --config",
       "", 0.0, 0.1},
      {"threads", &o.render.threads, "N", "Threads of POV-Ray", "", 1, 512},
      {"seed", &o.seed, "N", "Seed of everything random; equal seeds give equal files", "", 0.0,
       kMaxSeed},
      {"povray", &o.render.program, "PROGRAM", "POV-Ray 3.7, by name or path"},
      {"out", &o.out, "DIR", "Folder for the sequence: DIR/mav0"},
      {"bag", &o.bag, "FILE", "Write a rosbag as well"},
      {"quiet", &o.quiet, "", "No progress bar and no summary"},
  };
  return {"simulate", "Render a motion through a scene: images, IMU data, ground truth", table,
          [options](const Typed& /*typed*/) { return runSimulate(*options); }};
}

}  // namespace slim_init::tools
