// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The one description of every option: validate(), the reader of configuration files, the shipped
// YAML files are made from it. A struct's table stands in the source file
// beside its validate(); sections are linked by the key's prefix.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "slim_init/options.h"
#include "slim_init/types.h"

namespace slim_init {

/// Whom a key is meant for.
enum class Audience {
  kUser,      ///< depends on rig, motion or application
  kAdvanced,  ///< part of the method; the default is the one that was measured
};

/// Closed interval of a number; not used by switches and words.
struct OptionRange {
  double min = 0.0;
  double max = 0.0;
};

/// A field of any enumeration, by the names of its values.
struct OptionWord {
  std::vector<std::string> words;
  std::function<std::string()> get;
  std::function<void(const std::string&)> set;  ///< takes one of `words`
  const void* address = nullptr;                ///< of the field
  std::size_t size = 0;                         ///< of the field [bytes]
};

/// Binds a field of an enumeration that has toString(). `values` lists the allowed ones.
template <typename Enum>
OptionWord wordOption(Enum* field, const std::vector<Enum>& values) {
  OptionWord option;
  for (const Enum value : values) option.words.push_back(toString(value));
  option.get = [field] { return std::string(toString(*field)); };
  option.set = [field, values](const std::string& word) {
    for (const Enum value : values) {
      if (word == toString(value)) *field = value;
    }
  };
  option.address = field;
  option.size = sizeof(Enum);
  return option;
}

/// One option, bound to the field that holds its value.
struct OptionField {
  std::string key;  ///< path below the struct: "window.keyframes"
  std::variant<int*, double*, bool*, std::string*, OptionWord> value;
  OptionRange range;
  std::string unit;    ///< "" where there is none
  std::string reason;  ///< what it does and why the default is what it is
  Audience audience = Audience::kAdvanced;
  /// Names of the methods that read it; empty: all of them.
  std::vector<std::string> methods = {};

  /// True where `method` reads this option.
  bool isReadBy(const std::string& method) const;
};

using OptionTable = std::vector<OptionField>;
using OptionValue = decltype(OptionField::value);

/// Rows of a table: a number with its range and unit, or a switch, text or word without.
OptionField userKey(const char* key, OptionValue value, OptionRange range, const char* unit,
                    const char* reason);
OptionField userKey(const char* key, OptionValue value, const char* reason);
OptionField advancedKey(const char* key, OptionValue value, OptionRange range, const char* unit,
                        const char* reason);
OptionField advancedKey(const char* key, OptionValue value, const char* reason);

/// Adds the rows of `section` to `table`, with "prefix." before every key ("" adds none). Rows that
/// name no methods get `methods`.
void appendSection(const std::string& prefix, OptionTable section,
                   const std::vector<std::string>& methods, OptionTable* table);

/// The tables of the structs of options.h, bound to the fields of the argument, which must outlive
/// them.
OptionTable optionTable(WindowOptions* options);
OptionTable optionTable(InertialOptions* options);
OptionTable optionTable(VanishingPointOptions* options);
OptionTable optionTable(RefinementOptions* options);
OptionTable optionTable(SlimOptions* options);
OptionTable optionTable(GateOptions* options);
OptionTable optionTable(ProvisionalOptions* options);
OptionTable optionTable(WorkLimits* options);
OptionTable optionTable(InitializerOptions* options);

/// Of the calibration only what has a key of ours: noise of points and lines.
OptionTable optionTable(Calibration* calibration);
OptionTable optionTable(CalibrationSigmas* sigmas);
OptionTable optionTable(ImuNoise* noise);
OptionTable optionTable(ImuLimits* limits);

}  // namespace slim_init
