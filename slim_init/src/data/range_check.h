// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <sstream>
#include <string>

namespace slim_init {

/// Collects the first violated bound of an options struct as a message.
class RangeCheck {
 public:
  /// Requires min <= value <= max; a value that is not finite violates it.
  template <typename T>
  RangeCheck& within(const char* name, T value, T min, T max) {
    if (sentence_.empty() && !(value >= min && value <= max)) {
      std::ostringstream out;
      out << name << " is " << value << ", must be in [" << min << ", " << max << "]";
      sentence_ = out.str();
    }
    return *this;
  }

  /// Requires lower <= upper for two fields.
  template <typename T>
  RangeCheck& ordered(const char* lower_name, T lower, const char* upper_name, T upper) {
    if (sentence_.empty() && !(lower <= upper)) {
      std::ostringstream out;
      out << lower_name << " is " << lower << ", must not exceed " << upper_name << " (" << upper
          << ")";
      sentence_ = out.str();
    }
    return *this;
  }

  /// Adopts the message of a nested struct, prefixed with its section.
  RangeCheck& nested(const char* section, const std::string& sentence) {
    if (sentence_.empty() && !sentence.empty()) sentence_ = std::string(section) + "." + sentence;
    return *this;
  }

  /// The first violation, or empty.
  const std::string& sentence() const { return sentence_; }

 private:
  std::string sentence_;
};

}  // namespace slim_init
