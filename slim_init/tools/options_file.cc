// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "options_file.h"

#ifdef SLIM_INIT_HAS_FEATURE_TRACKER_LINES

#include <cstdint>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "slim_init/feature_tracker_lines/config.h"

namespace slim_init::tools {
namespace {

using feature_tracker_lines::Config;
using feature_tracker_lines::ConfigKey;
using feature_tracker_lines::configKeys;

evaluation::OptionValue optionValue(const ConfigKey& key) {
  return std::visit(
      [](auto* field) -> evaluation::OptionValue {
        using T = std::remove_pointer_t<decltype(field)>;
        if constexpr (std::is_same_v<T, GateMode>) {
          return std::string(*field == GateMode::kOn    ? "on"
                             : *field == GateMode::kOff ? "off"
                                                        : "own");
        } else if constexpr (std::is_integral_v<T>) {
          return static_cast<std::int64_t>(*field);
        } else {
          return *field;
        }
      },
      key.field);
}

}  // namespace

std::string readOptionsFile(AbOptions* options) {
  Config config;
  std::string error;
  if (!feature_tracker_lines::loadOptions(options->options_file, &config, &error)) {
    return "--options: " + error;
  }
  options->initializer = config.options;

  // The same table three times: as read, as used here, as it is by default. The report has the
  // window's length and the gates under the names of --keyframes and --gates, which may win, and
  // the protocol counts full windows only.
  const std::set<std::string> told_elsewhere = {"window.keyframes", "window.min_keyframes",
                                                "gates.mode"};
  Config used;
  used.options = config.options;
  Config defaults;
  const std::vector<ConfigKey> keys_read = configKeys(&config);
  const std::vector<ConfigKey> keys_used = configKeys(&used);
  const std::vector<ConfigKey> keys_default = configKeys(&defaults);
  std::string unused;
  for (std::size_t i = 0; i < keys_read.size(); ++i) {
    if (told_elsewhere.count(keys_read[i].key) > 0) continue;
    const std::string name = "slim_init." + keys_read[i].key;
    const evaluation::OptionValue value = optionValue(keys_read[i]);
    if (value == optionValue(keys_default[i])) continue;
    if (value == optionValue(keys_used[i])) {
      options->file_values.emplace_back(name, value);
    } else {
      unused += (unused.empty() ? "" : ", ") + name;
    }
  }
  if (!unused.empty()) {
    options->file_notes.push_back(options->options_file + ": not used here: " + unused +
                                  " (--methods names the methods, the rig is EuRoC's with "
                                  "--pixel-noise)");
  }
  return "";
}

}  // namespace slim_init::tools

#else  // SLIM_INIT_HAS_FEATURE_TRACKER_LINES

namespace slim_init::tools {

std::string readOptionsFile(AbOptions* options) {
  return "--options: " + options->options_file +
         " cannot be read: this program was built without feature_tracker_lines "
         "(SLIM_INIT_BUILD_FEATURE_TRACKER_LINES=OFF)";
}

}  // namespace slim_init::tools

#endif  // SLIM_INIT_HAS_FEATURE_TRACKER_LINES
