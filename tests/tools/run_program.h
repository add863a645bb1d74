// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "support/text_parts.h"

namespace slim_init {

struct ProgramRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Arguments are plain words of the test; quoting keeps scratch paths with spaces whole. The
/// report in Python is written only where a test asks for it: it takes longer than most runs.
inline ProgramRun runProgram(const ScratchFolder& folder, std::vector<std::string> arguments,
                             const std::string& program = SLIM_INIT_PROGRAM) {
  if (arguments.size() > 1 && arguments.front() == "ab" &&
      std::find(arguments.begin(), arguments.end(), "--report") == arguments.end()) {
    arguments.insert(arguments.begin() + 1, {"--report", "off"});
  }
  // Windows of one size, as in the paper, where a test does not ask for others: they take a tenth
  // of the time.
  const auto has = [&arguments](const char* name) {
    return std::find(arguments.begin(), arguments.end(), name) != arguments.end();
  };
  if (arguments.size() > 1 && arguments.front() == "ab" && !has("--keyframes") &&
      !has("--options") && !has("--config") && !has("--help")) {
    arguments.insert(arguments.end(), {"--keyframes", "10"});
  }
  std::string command = "\"" + program + "\"";
  for (const std::string& argument : arguments) command += " \"" + argument + "\"";
  command += " >\"" + folder.file("stdout") + "\" 2>\"" + folder.file("stderr") + "\" </dev/null";
  const int status = std::system(command.c_str());
  ProgramRun run;
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  run.out = readFile(folder.file("stdout"));
  run.err = readFile(folder.file("stderr"));
  return run;
}

/// The same with the arguments as one line, with spaces between them; @NAME is the file of that
/// name in the folder, and two quotes are an empty word.
inline std::vector<std::string> words(const ScratchFolder& folder, const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) {
    if (word[0] == '@') word = folder.file(word.substr(1));
    words.push_back(word == "''" ? "" : word);
  }
  return words;
}

/// The program in a folder of its own.
class ProgramTest : public ::testing::Test {
 protected:
  /// `slim_init LINE`; see words().
  ProgramRun typed(const std::string& line) const {
    return runProgram(folder, words(folder, line));
  }
  /// The same, which has to succeed.
  ProgramRun succeeds(const std::string& line) const {
    const ProgramRun run = typed(line);
    EXPECT_EQ(run.exit_code, 0) << line << ": " << run.err;
    return run;
  }
  /// The same with bad input: a sentence with all of `parts` and nothing else.
  void expectRefused(const std::string& line, const std::string& parts) const {
    SCOPED_TRACE(line);
    const ProgramRun run = typed(line);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err.rfind("slim_init: ", 0), 0u) << run.err;
    expectParts(run.err, parts);
  }

  const ScratchFolder folder;
};

/// windows.csv without its last three columns, which hold times. None holds a comma or a quote, so
/// cutting from the right is safe.
inline std::string withoutTimes(const std::string& csv) {
  std::istringstream lines(csv);
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    for (int i = 0; i < 3; ++i)
      line.resize(line.rfind(',') == std::string::npos ? 0 : line.rfind(','));
    result += line + "\n";
  }
  return result;
}

}  // namespace slim_init
