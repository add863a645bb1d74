// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "load_images.h"

#include <filesystem>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/rig_errors.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/evaluation/track_images.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<evaluation::ImageSequence> openImages(const AbOptions& options,
                                                      evaluation::ReadStatus* status) {
  const double max_imu_gap_s = options.initializer.window.max_imu_gap_s;
  if (!options.asl.empty()) return evaluation::openAslFolder(options.asl, max_imu_gap_s, status);
  evaluation::BagTopics topics;
  if (!options.config->imu_topic.empty()) topics.imu = options.config->imu_topic;
  if (!options.config->image_topic.empty()) topics.image = options.config->image_topic;
  topics.speed = options.config->speed_topic;
  topics.speed_forward_only = options.config->speed_forward_only;
  std::string truth = evaluation::groundtruthFileOf(options.bag);
  std::error_code code;
  if (!fs::exists(truth, code)) truth.clear();
  return evaluation::openRosbag(options.bag, topics, truth, max_imu_gap_s, status);
}

void noteTracking(const evaluation::TrackingSummary& tracking, const std::string& name,
                  std::vector<std::string>* notes) {
  const auto note = [&](int count, const std::string& what) {
    if (count == 0) return;
    notes->push_back(name + ": " + std::to_string(count) + " of " +
                     std::to_string(tracking.images) + " images " + what);
  };
  const std::string first =
      tracking.first_problem.empty() ? "" : "; first: " + tracking.first_problem;
  note(tracking.outside_imu, "lie outside the IMU data and were discarded");
  note(tracking.unreadable, "cannot be read and were discarded" + first);
  note(tracking.refused, "were refused by the front end and discarded" + first);
  note(tracking.images_without_gyro, "were tracked without a rotation from the gyro");
}

}  // namespace

std::string configureFromData(const std::string& source, const std::string& options_file,
                              const evaluation::ImageSequence& images, Config* config) {
  if (!images.calibration().has_value()) {
    return source + " has no calibration that can be used (" + images.calibrationProblem() +
           "); give one with --config YAML";
  }
  config->calibration = images.calibration()->calibration;
  config->camera = images.calibration()->camera;
  std::string error;
  if (!options_file.empty() && !loadOptions(options_file, config, &error)) {
    return "--options: " + error;
  }
  return "";
}

std::string loadImages(const AbOptions& options, LoadedSequence* loaded) {
  evaluation::ReadStatus status;
  const std::unique_ptr<evaluation::ImageSequence> images = openImages(options, &status);
  if (images == nullptr) return status.message;
  Config config;
  if (!options.config_file.empty()) {
    config = *options.config;
  } else if (std::string sentence =
                 configureFromData(options.asl, options.options_file, *images, &config);
             !sentence.empty()) {
    return sentence;
  }

  evaluation::Sequence& sequence = loaded->sequence;
  sequence.name = images->name();
  options.setReadout(&config.calibration);
  sequence.calibration = config.calibration;
  sequence.t0_ns = images->t0Ns();
  sequence.imu = images->imu();
  sequence.notes = images->notes();
  sequence.speeds = images->speeds();
  discardUncalibratedSpeeds(&sequence);
  // The front end runs on the same rig as the methods: wrong calibration, worse IMU.
  std::vector<ImuSample> imu = sequence.imu;
  if (std::string sentence = evaluation::disturbImu(options.rig, &imu); !sentence.empty()) {
    return images->name() + ": " + sentence;
  }
  images->replaceImu(std::move(imu));
  const Calibration assumed =
      evaluation::assumedCalibration(config.calibration, options.rig, evaluation::kAllTrials);
  if (std::string sentence = assumed.validate(); !sentence.empty()) {
    return images->name() + ": the calibration with its errors: " + sentence;
  }

  evaluation::TrackingSummary tracking;
  {
    ProgressBar bar(images->name() + ": images", !options.quiet);
    // One thread, as the times in the report say; OpenCV's own cost more than they save here.
    cv::setNumThreads(1);
    if (std::string sentence = evaluation::trackImages(
            images.get(), config.camera, assumed, config.front_end,
            [&bar](int done, int total) { bar.update(done, total); }, &sequence.frames, &tracking);
        !sentence.empty()) {
      return sentence;
    }
  }
  noteTracking(tracking, images->name(), &sequence.notes);
  sequence.tracking = std::move(tracking);

  std::vector<double> times;
  for (const FrameObservation& frame : sequence.frames) times.push_back(frame.t);
  return addTruth(images->truth(), images->hasVelocityAndBias(), images->name(), times, loaded);
}

}  // namespace slim_init::tools
