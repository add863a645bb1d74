// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "section.h"

#include <algorithm>

#include "yaml_value.h"

namespace slim_init::config {
namespace {

class SectionReader {
 public:
  SectionReader(const std::string& file, Config* config, SectionLog* log)
      : file_(file), table_(configTable(config)), log_(log) {}

  // The keys of `section`, whose path is `prefix` ("window.").
  void read(const cv::FileNode& section, const std::string& prefix) {
    std::vector<std::string> seen;
    for (cv::FileNodeIterator it = section.begin(); it != section.end(); ++it) {
      const cv::FileNode node = *it;
      const std::string key = prefix + node.name();
      // OpenCV keeps the last of two equal keys and loses the other silently.
      if (std::count(seen.begin(), seen.end(), key) > 0) fail(fullName(key), " is given twice");
      seen.push_back(key);
      if (const OptionField* option = find(key)) {
        config::read(fullName(key), node, *option);
        (*log_)[fullName(key)] = file_;
      } else if (isSection(key)) {
        if (!node.isMap()) wrongKind(fullName(key), node, "a section of keys");
        read(node, key + ".");
      } else {
        unknown(key);
      }
    }
  }

 private:
  static std::string fullName(const std::string& key) { return std::string(kSection) + "." + key; }

  const OptionField* find(const std::string& key) const {
    for (const OptionField& option : table_) {
      if (option.key == key) return &option;
    }
    return nullptr;
  }

  bool isSection(const std::string& key) const {
    return std::any_of(table_.begin(), table_.end(), [&key](const OptionField& option) {
      return option.key.compare(0, key.size() + 1, key + ".") == 0;
    });
  }

  [[noreturn]] void unknown(const std::string& key) const {
    fail(fullName(key), " is not a known key; `slim_init options --keys all` lists them");
  }

  const std::string file_;
  const OptionTable table_;
  SectionLog* const log_;
};

}  // namespace

void readSection(const cv::FileNode& root, const std::string& file, bool required, Config* config,
                 SectionLog* log) {
  const cv::FileNode section = root[kSection];
  if (section.empty()) {
    if (required) fail("the section ", kSection, ": is missing");
    return;
  }
  if (!section.isMap()) wrongKind(kSection, section, "a section of keys");
  SectionReader(file, config, log).read(section, "");
}

}  // namespace slim_init::config
