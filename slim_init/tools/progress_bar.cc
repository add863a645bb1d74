// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "progress_bar.h"

#include <unistd.h>

#include <iostream>
#include <utility>

namespace slim_init::tools {
namespace {

constexpr int kWidth = 40;

}  // namespace

ProgressBar::ProgressBar(std::string label, bool wanted)
    : label_(std::move(label)), enabled_(wanted && isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (enabled_ && drawn_percent_ >= 0) std::cerr << "\r\033[K" << std::flush;
}

void ProgressBar::update(int done, int total) {
  if (!enabled_ || total <= 0) return;
  const int percent = static_cast<int>(100LL * done / total);
  if (percent == drawn_percent_) return;
  drawn_percent_ = percent;
  const std::string filled(static_cast<std::size_t>(kWidth * percent / 100), '#');
  const std::string empty(kWidth - filled.size(), '.');
  std::cerr << "\r" << label_ << " [" << filled << empty << "] " << percent << " %" << std::flush;
}

}  // namespace slim_init::tools
