// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "python_report.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <system_error>

extern char** environ;

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
int run(std::vector<std::string> words, bool show_output, bool show_errors) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  if (posix_spawn_file_actions_init(&files) != 0) return -1;
  const auto silence = [&files](int descriptor, int mode) {
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", mode, 0);
  };
  silence(STDIN_FILENO, O_RDONLY);
  if (!show_output) silence(STDOUT_FILENO, O_WRONLY);
  if (!show_errors) silence(STDERR_FILENO, O_WRONLY);
  pid_t child = 0;
  const int spawned =
      posix_spawnp(&child, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (spawned != 0) return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
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
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    // -B: writes no bytecode beside the sources.
    const std::vector<std::string> command = {python, "-B", "-m", kPackage};
    std::vector<std::string> check = command;
    check.push_back("--check");
    if (run(check, false, false) == kExitOk) return command;
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
  outcome.written = run(command, false, true) == kExitOk;
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
  const int code = run(command, true, true);
  return code < 0 ? static_cast<int>(kExitInternal) : code;
}

}  // namespace slim_init::tools
