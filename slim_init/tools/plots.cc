// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "plots.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "plot_script.h"

extern char** environ;

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

// What the script returns.
constexpr int kDrawn = 0;
constexpr int kNoMatplotlib = 3;

constexpr char kScriptFile[] = "plot_report.py";

/// Runs a program without input and output. Returns its exit code, -1 when it could not run.
int run(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  if (posix_spawn_file_actions_init(&files) != 0) return -1;
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null",
                                     descriptor == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
  }
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

}  // namespace

void drawPlots(const std::string& directory, evaluation::RunInfo* info) {
  const std::vector<std::pair<std::string, std::string>> pictures = {
      {"trajectory.png",
       "True path, coloured by the pose error of the windows that begin there; black: failed"},
      {"error_cdf.png", "Share of all windows with an error below x"},
      {"solve_time.png", "Time of a solve"}};
  std::error_code code;
  for (const auto& picture : pictures) fs::remove(fs::path(directory) / picture.first, code);

  const fs::path script = fs::path(directory) / kScriptFile;
  {
    std::ofstream file(script, std::ios::binary | std::ios::trunc);
    file << plotScript();
    if (!file.good()) {
      info->picture_note = "There are no pictures: " + script.string() + " cannot be written.";
      return;
    }
  }
  int result = -1;
  // A python of the user's own may come first in the path and lack what the distribution's has.
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    result = run({python, script.string(), directory});
    if (result == kDrawn) break;
  }
  for (const auto& picture : pictures) {
    if (result == kDrawn && fs::exists(fs::path(directory) / picture.first, code)) {
      info->pictures.push_back(picture);
    }
  }
  if (!info->pictures.empty()) return;
  info->picture_note = "There are no pictures: ";
  info->picture_note += result == kNoMatplotlib || result < 0
                            ? "they need python3 with matplotlib (package python3-matplotlib)"
                            : "the script failed";
  info->picture_note += std::string(". `python3 ") + kScriptFile + " .` in this folder draws them.";
}

}  // namespace slim_init::tools
