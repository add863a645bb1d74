// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "python_report.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <system_error>

#include "command_line.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

constexpr char kPackage[] = "slim_init_report";

/// share/slim_init/NAME beside the program: build/bin and build/share, bin and share of an
/// installation, lib/slim_init and share of a catkin space. Empty where there is none.
fs::path sharedFile(const std::string& name) {
  std::error_code code;
  fs::path folder = fs::read_symlink("/proc/self/exe", code).parent_path();
  for (int up = 0; up < 3 && !code && folder.has_relative_path(); ++up) {
    folder = folder.parent_path();
    const fs::path file = folder / "share" / "slim_init" / name;
    if (fs::exists(file, code)) return file;
    code.clear();
  }
  return {};
}

/// Runs a program without input. Returns its exit code, -1 when it could not run.
int run(const std::vector<std::string>& words, const char* redirections = "") {
  const std::string line = shellLine(words) + " </dev/null" + redirections;
  const int status = std::system(line.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Lets python find the package, before anything the user has set.
void setPythonPath(const fs::path& folder) {
  const char* before = std::getenv("PYTHONPATH");
  const std::string path = folder.string() + (before != nullptr ? std::string(":") + before : "");
  setenv("PYTHONPATH", path.c_str(), 1);
  setenv("PYTHONSAFEPATH", "1", 1);  // a random.py of the current folder is not python's
}

/// The words that start the package with a python3 that has its modules; empty and a message where
/// there is none.
std::vector<std::string> packageCommand(std::string* message) {
  const fs::path folder = sharedFile("python");
  if (folder.empty()) {
    *message = std::string("the Python package ") + kPackage +
               " is not beside this program (share/slim_init/python)";
    return {};
  }
  setPythonPath(folder);
  // A python of the user's own may come first in the path and lack what the distribution's has.
  // -B: writes no bytecode beside the sources.
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    constexpr char kHasModules[] =
        "from importlib.util import find_spec\n"
        "raise SystemExit(None in map(find_spec, ('pandas', 'matplotlib', 'jinja2')))";
    if (run({python, "-B", "-c", kHasModules}, " >/dev/null 2>&1") == kExitOk) {
      return {python, "-B", "-m", kPackage};
    }
  }
  *message =
      "no python3 with pandas, matplotlib and jinja2 was found (packages python3-pandas, "
      "python3-matplotlib, python3-jinja2)";
  return {};
}

}  // namespace

ReportOutcome makeReport(const std::string& directory, const std::vector<std::string>& demo) {
  ReportOutcome outcome;
  std::vector<std::string> command = packageCommand(&outcome.message);
  if (command.empty()) {
    outcome.message =
        "no report: " + outcome.message + "; `slim_init report " + directory + "` writes it later";
    return outcome;
  }
  if (!demo.empty()) command.insert(command.end(), {"--demo", "--out", directory});
  command.emplace_back("--");
  if (demo.empty()) command.push_back(directory);
  command.insert(command.end(), demo.begin(), demo.end());
  outcome.written = run(command, " >/dev/null") == kExitOk;
  if (!outcome.written) {
    outcome.code = kExitInternal;
    outcome.message = "the report in " + directory + " could not be written";
  }
  return outcome;
}

int runReport(const std::vector<std::string>& arguments) {
  std::string message;
  std::vector<std::string> command = packageCommand(&message);
  if (command.empty()) {
    std::cerr << "slim_init: report: " << message << "\n";
    return kExitInternal;
  }
  command.insert(command.end(), arguments.begin(), arguments.end());
  const int code = run(command);
  return code < 0 ? static_cast<int>(kExitInternal) : code;
}

}  // namespace slim_init::tools
