// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What cv::FileStorage must not be given.
#pragma once

#include <string>

namespace slim_init::feature_tracker_lines {

/// OpenCV's YAML parser reads several documents one after the other, and never returns from some
/// texts between them (a `-` soon after the end of the first; seen with 4.6). A file of a
/// camera or a configuration is one map of keys. Empty where `text` is one as far as that goes;
/// otherwise a sentence that names the line. Everything else is left to the parser.
std::string whyNotOneDocument(const std::string& text);

}  // namespace slim_init::feature_tracker_lines
