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

using Pictures = std::vector<std::pair<std::string, std::string>>;  // file and title

/// Has the script in `directory` draw `pictures` there, with these words after the script's name.
/// Keeps those that it drew; returns a sentence where it drew none.
std::string draw(const std::string& directory, const std::vector<std::string>& words,
                 Pictures* pictures) {
  std::error_code code;
  for (const auto& picture : *pictures) fs::remove(fs::path(directory) / picture.first, code);
  const Pictures wanted = std::move(*pictures);
  pictures->clear();

  const fs::path script = fs::path(directory) / kScriptFile;
  {
    std::ofstream file(script, std::ios::binary | std::ios::trunc);
    file << plotScript();
    if (!file.good()) {
      return "There are no pictures: " + script.string() + " cannot be written.";
    }
  }
  int result = -1;
  // A python of the user's own may come first in the path and lack what the distribution's has.
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    std::vector<std::string> command = {python, script.string()};
    command.insert(command.end(), words.begin(), words.end());
    result = run(command);
    if (result == kDrawn) break;
  }
  for (const auto& picture : wanted) {
    if (result == kDrawn && fs::exists(fs::path(directory) / picture.first, code)) {
      pictures->push_back(picture);
    }
  }
  if (!pictures->empty()) return "";
  return std::string("There are no pictures: ") +
         (result == kNoMatplotlib || result < 0
              ? "they need python3 with matplotlib (package python3-matplotlib)."
              : "the script failed.");
}

}  // namespace

void drawPlots(const std::string& directory, evaluation::RunInfo* info) {
  info->pictures = {
      {"trajectory.png",
       "True path, coloured by the pose error of the windows that begin there; black: failed"},
      {"error_cdf.png", "Share of all windows with an error below x"},
      {"solve_time.png", "CPU time of a solve"}};
  info->picture_note = draw(directory, {directory}, &info->pictures);
  if (info->pictures.empty()) {
    info->picture_note +=
        std::string(" `python3 ") + kScriptFile + " .` in this folder draws them.";
  }
}

std::string drawTogether(const std::string& directory, const std::string& prefix,
                         const std::vector<std::string>& folders, const std::string& what,
                         std::vector<std::pair<std::string, std::string>>* pictures) {
  *pictures = {{prefix + "error_cdf.png", what + ": share of all windows with an error below x"},
               {prefix + "solve_time.png", what + ": CPU time of a solve"}};
  std::vector<std::string> words = {directory, prefix};
  words.insert(words.end(), folders.begin(), folders.end());
  return draw(directory, words, pictures);
}

}  // namespace slim_init::tools
