// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "doctor.h"

#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <string>

#include "exit_code.h"
#include "load_images.h"
#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/doctor/doctor_images.h"
#include "slim_init/evaluation/write_file.h"

namespace slim_init::tools {

std::vector<AbOption> doctorOptionTable(DoctorCommand* command) {
  DoctorCommand& c = *command;
  return {
      {"asl", &c.asl, "DIR", "Recording in ASL layout", ""},
      {"bag", &c.bag, "FILE",
       "Recording as a bag; topics are imu_topic and image_topic of --config", ""},
      {"config", &c.config_file, "FILE",
       "The host's YAML file, to be checked; needed with --bag (default with --asl: the "
       "sensor.yaml files beside the data)",
       ""},
      {"options", &c.options_file, "FILE",
       "YAML file whose section slim_init: takes precedence over --config's", ""},
      {"limit", &c.limit, "N", "Stop after this many images (0: no limit)", "", 0, 1000000000},
      {"json", &c.json, "FILE", "Write the findings here as well, for machines", ""},
      {"quiet", &c.quiet, "", "No progress bar and no table", ""},
  };
}

namespace {

/// Conditions over several options: an empty string, or a message.
std::string checkOptions(const DoctorCommand& c) {
  if (c.asl.empty() == c.bag.empty()) return "give one of --asl DIR and --bag FILE";
  if (!c.bag.empty() && c.config_file.empty()) {
    return "--bag needs --config YAML: camera, extrinsic and topics are there";
  }
  return "";
}

int fail(const std::string& message) {
  std::cerr << "slim_init: " << message << "\n";
  return kExitBadInput;
}

std::unique_ptr<evaluation::ImageSequence> openRecording(const DoctorCommand& command,
                                                         const Config& config,
                                                         evaluation::ReadStatus* status) {
  const double max_imu_gap_s = config.options.window.max_imu_gap_s;
  if (!command.asl.empty()) return evaluation::openAslFolder(command.asl, max_imu_gap_s, status);
  evaluation::BagTopics topics;
  if (!config.imu_topic.empty()) topics.imu = config.imu_topic;
  if (!config.image_topic.empty()) topics.image = config.image_topic;
  return evaluation::openRosbag(command.bag, topics, "", max_imu_gap_s, status);
}

int examineRecording(const DoctorCommand& command) {
  if (const std::string error = checkOptions(command); !error.empty()) return fail(error);
  Config config;
  std::string error;
  if (!command.config_file.empty() &&
      !loadConfig(command.config_file, command.options_file, &config, &error)) {
    return fail("--config: " + error);
  }
  evaluation::ReadStatus status;
  const auto images = openRecording(command, config, &status);
  if (images == nullptr) return fail(status.message);
  if (command.config_file.empty()) {
    error = configureFromData(command.asl, command.options_file, *images, &config);
    if (!error.empty()) return fail(error);
  }
  // First: a minute of work should not end with a folder that is not there.
  if (!command.json.empty()) {
    if (error = evaluation::checkWritable(command.json); !error.empty()) {
      return fail("--json: " + error);
    }
  }

  evaluation::DoctorData data;
  {
    ProgressBar bar(images->name(), !command.quiet);
    cv::setNumThreads(1);
    data = evaluation::readDoctorData(images.get(), config.camera, config.calibration,
                                      config.front_end, command.limit,
                                      [&bar](int done, int total) { bar.update(done, total); });
  }
  evaluation::DoctorOptions options;
  options.max_imu_gap_s = config.options.window.max_imu_gap_s;
  options.time_offset_s.fail = config.options.gates.max_td_error_s;
  options.extrinsic_deg.fail = config.options.gates.max_extrinsic_error_deg;
  options.initializer = config.options;
  data.extrinsic_in_one_matrix = config.host.extrinsic_in_one_matrix;
  data.has_rotation = config.host.has_rotation;
  data.has_translation = config.host.has_translation;
  const evaluation::DoctorReport report = evaluation::examine(data, options);
  if (!command.json.empty()) {
    if (error = evaluation::writeFile(command.json, evaluation::doctorJson(report));
        !error.empty()) {
      return fail("--json: " + error);
    }
  }
  if (!command.quiet) {
    const bool color = isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr;
    std::cout << evaluation::doctorText(report, color);
  }
  return report.exitCode();
}

}  // namespace

int runDoctor(const DoctorCommand& command) {
  try {
    return examineRecording(command);
  } catch (const std::exception& problem) {
    return fail(problem.what());
  }
}

}  // namespace slim_init::tools
