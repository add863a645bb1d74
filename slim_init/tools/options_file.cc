// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "ab_options.h"
#include "exit_code.h"
#include "methods.h"
#include "slim_init/config/config.h"

namespace slim_init::tools {
namespace {

evaluation::OptionValue valueOf(const OptionField& option) {
  return std::visit(
      [](const auto& value) -> evaluation::OptionValue {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, OptionWord>) {
          return value.get();
        } else if constexpr (std::is_integral_v<std::remove_pointer_t<T>>) {
          return static_cast<std::int64_t>(*value);
        } else {
          return *value;
        }
      },
      option.value);
}

// The note of loadConfig() on keys that the file's `method` does not read becomes one on keys that
// none of the compared methods reads.
std::vector<std::string> notesFor(const Config& config, const std::string& method_list) {
  const std::vector<std::string> methods =
      method_list.empty() ? methodNames() : splitList(method_list);
  std::vector<std::string> notes = config.notes;
  notes.erase(std::remove(notes.begin(), notes.end(), noteUnreadKeys(config, {config.method})),
              notes.end());
  const std::string note = noteUnreadKeys(config, methods);
  if (!note.empty()) notes.push_back(note);
  return notes;
}

}  // namespace

void readConfiguration(AbOptions* options) {
  AbOptions& o = *options;
  Config config;
  std::string error;
  if (!o.config_file.empty()) {
    if (!loadConfig(o.config_file, o.options_file, &config, &error)) check(error);
  } else if (!o.options_file.empty() && !loadOptions(o.options_file, &config, &error)) {
    check(error, "--options: ");
  }
  o.config = std::make_shared<const Config>(config);
  o.file_notes = notesFor(config, o.methods);
  o.initializer = config.options;

  // The same table three times: as read, as used here, as it is by default. The report has the
  // window and the gates under names of their own, as --keyframes and --gates may win.
  const std::set<std::string> set_elsewhere = {"window.keyframes", "window.min_keyframes",
                                               "window.min_interval_s", "window.max_span_s",
                                               "gates.mode"};
  // Features that are simulated need no front end.
  Config used = config;
  const Config fresh;
  used.method = fresh.method;
  if (!o.hasImages()) {
    if (o.config_file.empty()) used.calibration.imu_noise = fresh.calibration.imu_noise;
    used.front_end = fresh.front_end;
  }
  Config defaults;
  const OptionTable keys_read = configTable(&config);
  const OptionTable keys_used = configTable(&used);
  const OptionTable keys_default = configTable(&defaults);
  std::string unused;
  for (std::size_t i = 0; i < keys_read.size(); ++i) {
    if (set_elsewhere.count(keys_read[i].key) > 0) continue;
    const std::string name = "slim_init." + keys_read[i].key;
    const evaluation::OptionValue value = valueOf(keys_read[i]);
    if (value == valueOf(keys_default[i])) continue;
    if (value == valueOf(keys_used[i])) {
      o.file_values.emplace_back(name, value);
    } else {
      unused += (unused.empty() ? "" : ", ") + name;
    }
  }
  if (!unused.empty()) {
    o.file_notes.push_back((o.options_file.empty() ? o.config_file : o.options_file) +
                           ": not used here: " + unused + " (--methods names the methods)");
  }
}

}  // namespace slim_init::tools
