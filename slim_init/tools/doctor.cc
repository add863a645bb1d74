// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <string>

#include "exit_code.h"
#include "load_sequence.h"
#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/doctor/doctor_images.h"
#include "slim_init/evaluation/write_file.h"
#include "subcommand.h"

namespace slim_init::tools {

namespace {

/// The command line of `slim_init doctor`. Exactly one of `asl` and `bag` is given.
struct DoctorCommand {
  std::string asl;           ///< folder of the recording
  std::string bag;           ///< file of the recording
  std::string config_file;   ///< the host's configuration; empty: sensor.yaml beside the data
  std::string options_file;  ///< YAML with a section `slim_init:`; empty: that of the configuration
  int limit = 0;             ///< images; 0: all
  std::string json;          ///< file; empty: none
  bool quiet = false;
};

int examineRecording(const DoctorCommand& command) {
  if (command.asl.empty() == command.bag.empty()) check("give one of --asl DIR and --bag FILE");
  if (!command.bag.empty() && command.config_file.empty()) {
    check("--bag needs --config YAML: camera, extrinsic and topics are there");
  }
  Config config;
  std::string error;
  if (!command.config_file.empty() &&
      !loadConfig(command.config_file, command.options_file, &config, &error)) {
    check(error);
  }
  const double max_imu_gap_s = config.options.window.max_imu_gap_s;
  const auto images = command.asl.empty()
                          ? openBag(command.bag, topicsOf(config), "", max_imu_gap_s)
                          : openAsl(command.asl, max_imu_gap_s);
  if (command.config_file.empty()) {
    configureFromData(command.asl, command.options_file, &config);
  }
  std::vector<std::string> notes = config.notes;
  notes.insert(notes.end(), images->notes.begin(), images->notes.end());
  for (const std::string& note : notes) std::cerr << "slim_init: note: " << note << "\n";
  // First: a minute of work should not end with a folder that is not there.
  if (!command.json.empty()) check(evaluation::checkWritable(command.json), "--json: ");

  evaluation::DoctorData data;
  {
    ProgressBar bar(images->name, !command.quiet);
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
    check(evaluation::writeFile(command.json, evaluation::doctorJson(report)), "--json: ");
  }
  if (!command.quiet) {
    const bool color = isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr;
    std::cout << evaluation::doctorText(report, color);
  }
  return report.exitCode();
}

}  // namespace

Subcommand doctorSubcommand() {
  const auto command = std::make_shared<DoctorCommand>();
  DoctorCommand& c = *command;
  const std::vector<AbOption> table = {
      {"asl", &c.asl, "DIR", "Recording in ASL layout"},
      {"bag", &c.bag, "FILE",
       "Recording as a bag; topics are imu_topic and image_topic of --config"},
      {"config", &c.config_file, "FILE",
       "The host's YAML file, to be checked; needed with --bag (default with --asl: the "
       "sensor.yaml files beside the data)"},
      {"options", &c.options_file, "FILE",
       "YAML file whose section slim_init: takes precedence over --config's"},
      {"limit", &c.limit, "N", "Stop after this many images (0: no limit)", "", 0, 1000000000},
      {"json", &c.json, "FILE", "Write the findings here as well, for machines"},
      {"quiet", &c.quiet, "", "No progress bar and no table"},
  };
  return {"doctor", "Check a recording and its configuration: why does it not initialize?", table,
          [command](const Typed& /*typed*/) {
            try {
              return examineRecording(*command);
            } catch (const std::exception& problem) {
              throw Failure(kExitBadInput, problem.what());
            }
          }};
}

}  // namespace slim_init::tools
