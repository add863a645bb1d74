// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The windows that are solved already, so that an interrupted run can go on. Format:
// docs/evaluation.md.
#pragma once

#include <fstream>
#include <map>
#include <string>

#include "slim_init/evaluation/protocol.h"

namespace slim_init::evaluation {

/// A file with one line of JSON per finished window, under a first line that says what was run.
/// Numbers come back bit by bit. Used from one thread and by one process at a time.
class WindowJournal {
 public:
  /// Opens `file`. What is there is kept when its first line holds `fingerprint`; otherwise the
  /// file is begun anew and `note` says why. A last line cut short by an interruption is dropped,
  /// and so is one that cannot be read; `note` tells how many. `note` is empty where there is
  /// nothing to tell. Returns an empty string, or a sentence naming a file that cannot be written.
  ///
  /// `fingerprint` holds all that bears on the answers: the data, the methods and their options,
  /// those of the protocol, and the version of the program.
  std::string open(const std::string& file, const std::string& fingerprint, std::string* note);

  /// The window of a trial; null where it is not there. Valid until the trial is appended again.
  const WindowRecord* find(int trial) const;

  /// Writes a finished window and flushes the file, so that what was appended survives the end of
  /// the process; find() knows it from then on. A trial that is there already is replaced. Returns
  /// an empty string, or a sentence naming the file.
  std::string append(const WindowRecord& record);

  /// Windows that find() knows.
  int size() const { return static_cast<int>(records_.size()); }

 private:
  std::string name_;
  std::ofstream file_;
  std::map<int, WindowRecord> records_;  ///< by trial
};

}  // namespace slim_init::evaluation
