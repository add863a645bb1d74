// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <iostream>
#include <memory>

#include "command_line.h"
#include "exit_code.h"
#include "load_sequence.h"
#include "python_report.h"
#include "subcommand.h"

namespace slim_init::tools {
namespace {

using Words = std::vector<std::string>;

/// The command line of `slim_init demo`.
struct DemoCommand {
  std::string asl;                     ///< recording with images; empty: the built-in one, features
  std::string out = "slim_init_demo";  ///< folder of page and data
  int stride = 0;                      ///< images between two starts; 0: as it suits the recording
  bool quiet = false;
};

/// A calibration as of a home-made rig: stamps, mounting and IMU of the cheapest kind.
const Words kHomeMade = {"--td-error", "0.02", "--extrinsic-error", "2",
                         "--imu-rate", "100",  "--imu-dropout",     "0.02"};

Words sourceOf(const DemoCommand& command) {
  const auto stride = [&command](int usual) {
    return std::to_string(command.stride > 0 ? command.stride : usual);
  };
  if (!command.asl.empty()) return {"--asl", command.asl, "--stride", stride(8)};
  return {"--builtin", "corridor-walk", "--world", "corridor", "--duration",
          "12",        "--stride",      stride(10)};
}

/// `slim_init ab` with these errors of the rig.
int compare(const DemoCommand& command, const Words& errors, const std::string& out) {
  Words words = sourceOf(command);
  words.insert(words.begin(), "ab");
  words.insert(words.end(), errors.begin(), errors.end());
  words.insert(words.end(), {"--methods", "slim,vins,openvins", "--gates", "own", "--keyframes",
                             "10", "--report", "off", "--out", out});
  if (command.quiet) words.emplace_back("--quiet");
  CommandLine line;
  if (const std::string error = parseCommandLine(words, &line); !error.empty()) {
    std::cerr << "slim_init: demo: " << error << "\n";
    return kExitInternal;
  }
  return line.run();
}

int runDemo(const DemoCommand& command) {
  const std::filesystem::path out(command.out);
  const std::string recorded = (out / "recorded").string();
  const std::string home_made = (out / "home_made").string();
  if (!command.asl.empty() && openAsl(command.asl, WindowOptions().max_imu_gap_s)->truth.empty()) {
    check("--asl: " + command.asl + " has no ground truth, with which the page compares");
  }
  // First the one that refuses a slow IMU.
  if (const int code = compare(command, kHomeMade, home_made); code != kExitOk) return code;
  if (const int code = compare(command, {}, recorded); code != kExitOk) return code;
  const ReportOutcome page = makeReport(command.out, {recorded, home_made});
  if (!page.message.empty()) std::cerr << "slim_init: demo: " << page.message << "\n";
  if (page.written) std::cout << "Page: " << (out / "report.html").string() << "\n";
  return page.code;
}

}  // namespace

Subcommand demoSubcommand() {
  const auto command = std::make_shared<DemoCommand>();
  DemoCommand& c = *command;
  const std::vector<AbOption> table = {
      {"asl", &c.asl, "DIR",
       "Recording with images in ASL layout (default: simulated features of a built-in motion)"},
      {"out", &c.out, "DIR", "Folder for the page and the data"},
      {"stride", &c.stride, "N", "Images between two starts (0: 10, with images 8)", "", 0, 100000},
      {"quiet", &c.quiet, "", "No progress bars and no tables"},
  };
  return {"demo",
          "Compare slim, vins and openvins on a built-in motion, as recorded and miscalibrated",
          table, [command](const Typed& /*typed*/) { return runDemo(*command); }};
}

}  // namespace slim_init::tools
