// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slim_init::tools {

/// A bar on stderr, drawn on a terminal only: a log or a pipe sees nothing.
class ProgressBar {
 public:
  ProgressBar(std::string label, bool wanted);
  /// Wipes the line, so that what is printed next starts clean.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void update(int done, int total);

 private:
  std::string label_;
  bool enabled_;
  int drawn_percent_ = -1;
};

}  // namespace slim_init::tools
