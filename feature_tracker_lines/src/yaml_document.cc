// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/yaml_document.h"

#include <algorithm>
#include <cstddef>
#include <sstream>

namespace slim_init::feature_tracker_lines {
namespace {

constexpr std::size_t kNowhere = std::string::npos;

bool isContent(const std::string& line, std::size_t at) {
  return at != kNowhere && line[at] != '#';
}

}  // namespace

std::string whyNotOneDocument(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::size_t first_column = kNowhere;  // of the first key
  bool ended = false;                   // by a line of three dots
  for (int number = 1; std::getline(lines, line); ++number) {
    const auto problem = [number](const std::string& what) {
      return "line " + std::to_string(number) + " " + what;
    };
    // The parser sees no more of it.
    line.resize(std::min(line.size(), line.find_first_of(std::string("\0\r", 2))));
    const bool before = first_column == kNowhere;
    const bool starts = before && line.compare(0, 3, "---") == 0;
    const std::size_t at = line.find_first_not_of(' ', starts ? 3 : 0);
    if (!isContent(line, at) || (before && line[at] == '%')) continue;
    if (ended) return problem("comes after the end of the document ('...')");
    if (line.compare(at, 3, "...") == 0) {
      if (isContent(line, line.find_first_not_of(' ', at + 3))) {
        return problem("has more than the '...' that ends the document");
      }
      ended = true;
    } else if (before) {
      if (std::string("{[!").find(line[at]) != kNowhere) {
        return problem("starts with '" + line.substr(at, 1) + "', must start with a key");
      }
      first_column = at;
    } else if (at < first_column) {
      return problem("starts further left than the first key");
    }
  }
  return "";
}

}  // namespace slim_init::feature_tracker_lines
