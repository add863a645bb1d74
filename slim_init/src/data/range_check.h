// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>

#include "slim_init/option_table.h"
#include "slim_init/text.h"

namespace slim_init {

/// Collects the first violated bound of an options struct as a message.
class RangeCheck {
 public:
  /// Requires min <= value <= max; a value that is not finite violates it.
  template <typename T>
  RangeCheck& within(const std::string& name, T value, T min, T max) {
    if (message_.empty() && !(value >= min && value <= max)) {
      message_ = text(name, " is ", value, ", must be in [", min, ", ", max, "]");
    }
    return *this;
  }

  /// The same for every number of a table.
  RangeCheck& within(const OptionTable& table) {
    for (const OptionField& option : table) {
      if (const auto* whole = std::get_if<int*>(&option.value)) {
        within(option.key, **whole, static_cast<int>(option.range.min),
               static_cast<int>(option.range.max));
      } else if (const auto* real = std::get_if<double*>(&option.value)) {
        within(option.key, **real, option.range.min, option.range.max);
      }
    }
    return *this;
  }

  /// The same for every number of a struct that has a table.
  template <typename Options>
  static RangeCheck of(Options options) {
    return RangeCheck().within(optionTable(&options));
  }

  /// Requires lower <= upper for two fields.
  template <typename T>
  RangeCheck& ordered(const char* lower_name, T lower, const char* upper_name, T upper) {
    if (message_.empty() && !(lower <= upper)) {
      message_ =
          text(lower_name, " is ", lower, ", must not exceed ", upper_name, " (", upper, ")");
    }
    return *this;
  }

  /// Takes over the message of a nested struct, prefixed with its section.
  RangeCheck& nested(const char* section, const std::string& message) {
    if (message_.empty() && !message.empty()) message_ = std::string(section) + "." + message;
    return *this;
  }

  /// The first violation, or empty.
  const std::string& message() const { return message_; }

 private:
  std::string message_;
};

}  // namespace slim_init
