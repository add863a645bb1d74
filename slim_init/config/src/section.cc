// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "section.h"

#include <algorithm>

#include "slim_init/config/edit_distance.h"
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
        readOption(key, node, *option);
      } else if (const RenamedKey* renamed = findRenamed(key)) {
        readOption(key, node, *find(renamed->key));
        log_->renamed.push_back(*renamed);
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

  static const RenamedKey* findRenamed(const std::string& key) {
    for (const RenamedKey& renamed : renamedKeys()) {
      if (renamed.old_key == key) return &renamed;
    }
    return nullptr;
  }

  bool isSection(const std::string& key) const {
    return std::any_of(table_.begin(), table_.end(), [&key](const OptionField& option) {
      return option.key.compare(0, key.size() + 1, key + ".") == 0;
    });
  }

  // `key` is the name in the file, which may be an earlier one of `option`.
  void readOption(const std::string& key, const cv::FileNode& node, const OptionField& option) {
    config::read(fullName(key), node, option);
    log_->origins[fullName(option.key)] = file_;
    const std::string value = written(option);
    const auto [first, is_new] = given_.insert({option.key, {key, value}});
    if (!is_new && first->second.value != value) {
      fail(fullName(key), " is ", value, " and ", fullName(first->second.name), " is ",
           first->second.value, ", but both are ", option.key, " in this version; give that once");
    }
  }

  [[noreturn]] void unknown(const std::string& key) const {
    const OptionField* nearest = nullptr;
    std::size_t distance = std::max<std::size_t>(2, key.size() / 3) + 1;
    for (const OptionField& known : table_) {
      const std::size_t d = editDistance(key, known.key);
      if (d < distance) {
        distance = d;
        nearest = &known;
      }
    }
    if (nearest != nullptr) {
      fail(fullName(key), " is not a known key; did you mean ", nearest->key, "?");
    }
    fail(fullName(key), " is not a known key; `slim_init options --keys all` lists them");
  }

  struct Given {
    std::string name;  // in the file
    std::string value;
  };

  const std::string file_;
  const OptionTable table_;
  SectionLog* const log_;
  std::map<std::string, Given> given_;
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
