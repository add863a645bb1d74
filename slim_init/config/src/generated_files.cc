// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The shipped YAML files, from the table of all keys.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "host_keys.h"
#include "slim_init/config/config.h"
#include "slim_init/text.h"
#include "yaml_value.h"

namespace slim_init {

using namespace config;  // the parts of this library

namespace {

constexpr std::size_t kColumns = 100;

bool belongsTo(const OptionField& option, OptionKeys keys) {
  const Audience audience = keys == OptionKeys::kUser ? Audience::kUser : Audience::kAdvanced;
  return keys == OptionKeys::kAll || option.audience == audience;
}

template <typename Wanted>
OptionTable select(const OptionTable& table, const Wanted& wanted) {
  OptionTable selected;
  std::copy_if(table.begin(), table.end(), std::back_inserter(selected), wanted);
  return selected;
}

OptionTable select(const OptionTable& table, OptionKeys keys) {
  return select(table, [keys](const OptionField& option) { return belongsTo(option, keys); });
}

bool isNoise(const OptionField& option) { return option.key.compare(0, 6, "noise.") == 0; }

std::string number(double value) { return text(value); }

// "0.01 to 5", "from 19.6", "own, on or off", "0 or 1"; empty for a text.
std::string rangeOf(const OptionField& option) {
  if (const auto* word = std::get_if<OptionWord>(&option.value)) return listed(word->words);
  if (std::holds_alternative<bool*>(option.value)) return "0 or 1";
  if (std::holds_alternative<std::string*>(option.value)) return "";
  if (std::isinf(option.range.max)) return "from " + number(option.range.min);
  return number(option.range.min) + " to " + number(option.range.max);
}

// A comment of YAML: reason, and in brackets unit and range, in lines of kColumns.
std::string comment(const OptionField& option, const std::string& indent) {
  std::string brackets = option.unit;
  const std::string range = rangeOf(option);
  if (!range.empty()) brackets += (brackets.empty() ? "" : ", ") + range;
  std::vector<std::string> words;
  std::istringstream reason(option.reason);
  for (std::string word; reason >> word;) words.push_back(word);
  if (!brackets.empty()) words.push_back("[" + brackets + "]");  // never broken

  std::string text, line = indent + "#";
  for (const std::string& word : words) {
    if (line.size() + 1 + word.size() > kColumns) {
      text += line + "\n";
      line = indent + "#";
    }
    line += " " + word;
  }
  return text + line + "\n";
}

// The section `slim_init:` with the keys of `table` and their values.
std::string sectionYaml(const OptionTable& table) {
  std::ostringstream out;
  out << "slim_init:\n";
  std::string open_section;
  for (const OptionField& option : table) {
    const std::size_t dot = option.key.rfind('.');
    const std::string section = dot == std::string::npos ? "" : option.key.substr(0, dot + 1);
    std::string indent = "  ";
    // Each level of the section that is not open yet.
    for (std::size_t begin = 0, end = section.find('.'); end != std::string::npos;
         begin = end + 1, end = section.find('.', begin)) {
      if (open_section.compare(0, end + 1, section, 0, end + 1) != 0) {
        out << indent << section.substr(begin, end - begin) << ":\n";
      }
      indent += "  ";
    }
    open_section = section;
    out << comment(option, indent) << indent << option.key.substr(section.size()) << ": "
        << written(option) << "\n";
  }
  return out.str();
}

constexpr char kUserFileHead[] = R"(%YAML:1.0
# Keys of the section slim_init: that depend on rig, motion or application, with their defaults.
# Copy single keys into the section of your file. `slim_init options --update .` writes this file.

)";

constexpr char kAdvancedHead[] = R"(%YAML:1.0
# Keys of `slim` whose defaults were measured; there is rarely a reason to change one. Copy single
# keys into your file, or give a file like this one to the option --options of `slim_init ab`.
# `slim_init options --update .` writes this file.

)";

// Brings the keys of `table` in a file up to date, each with the comment above it, which reaches up
// to an empty line or another key; a new key comes at the end. Everything else stays.
void updateKeys(const OptionTable& table, const std::string& indent, std::string* file) {
  for (const OptionField& option : table) {
    const std::string key = indent + option.key.substr(option.key.rfind('.') + 1) + ": ";
    // OpenCV takes an empty text without quotes for no value at all.
    const char* quote = std::holds_alternative<std::string*>(option.value) ? "\"" : "";
    const std::string block =
        comment(option, indent) + key + quote + written(option) + quote + "\n";
    const std::size_t line = file->find("\n" + key);
    if (line == std::string::npos) {
      *file += file->empty() || file->back() == '\n' ? block : "\n" + block;
      continue;
    }
    std::size_t begin = line + 1, before = file->rfind('\n', line - 1) + 1;
    while (file->compare(before, indent.size() + 1, indent + "#") == 0) {
      begin = before;
      before = file->rfind('\n', begin - 2) + 1;
    }
    file->replace(begin, file->find('\n', line + 1) + 1 - begin, block);
  }
}

// The template, switched on and with EuRoC's topics.
std::string updatedTemplate(std::string file) {
  Config config;
  config.host.initializer = "slim";
  config.host.reinit = config.host.watchdog = config.host.keep_heading = true;
  config.imu_topic = "/imu0";
  config.image_topic = "/cam0/image_raw";
  updateKeys(switchTable(&config.host), "", &file);
  updateKeys(rigTable(&config), "", &file);
  updateKeys(optionTable(&config.front_end.host), "", &file);
  updateKeys(select(configTable(&config), isNoise), "    ", &file);
  return file;
}

}  // namespace

std::string optionsYaml(OptionKeys keys) {
  Config defaults;
  return "%YAML:1.0\n" + sectionYaml(select(configTable(&defaults), keys));
}

std::vector<GeneratedFile> generatedFiles(const std::string& repository) {
  Config defaults;
  const OptionTable table = configTable(&defaults);
  const auto section = [&table](OptionKeys keys) {
    return sectionYaml(select(table, [keys](const OptionField& option) {
      return belongsTo(option, keys) && !isNoise(option);
    }));
  };
  std::ostringstream the_template;
  the_template << std::ifstream(repository + "/config/template.yaml").rdbuf();
  return {
      {"config/template.yaml", updatedTemplate(the_template.str())},
      {"config/user.yaml", kUserFileHead + section(OptionKeys::kUser)},
      {"config/advanced.yaml", kAdvancedHead + section(OptionKeys::kAdvanced)},
  };
}

}  // namespace slim_init
