// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What holds for the table of every options struct.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <new>
#include <regex>
#include <string>
#include <typeinfo>
#include <utility>
#include <variant>
#include <vector>

#include "slim_init/option_table.h"

namespace slim_init {

/// First byte and size of the field of a row.
inline std::pair<const void*, std::size_t> memoryOf(const OptionField& option) {
  return std::visit(
      [](const auto& value) -> std::pair<const void*, std::size_t> {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, OptionWord>) {
          return {value.address, value.size};
        } else {
          return {value, sizeof(*value)};
        }
      },
      option.value);
}

/// Values just outside and at a bound of a number, below or above; none for other kinds and for
/// infinite bounds.
struct BoundCase {
  double inside = 0.0, outside = 0.0;
};
inline std::vector<BoundCase> boundCases(const OptionField& option) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double min = option.range.min, max = option.range.max;
  if (std::holds_alternative<int*>(option.value)) return {{min, min - 1.0}, {max, max + 1.0}};
  if (!std::holds_alternative<double*>(option.value)) return {};
  std::vector<BoundCase> cases = {{min, std::nextafter(min, -kInfinity)}};
  if (max < kInfinity) cases.push_back({max, std::nextafter(max, kInfinity)});
  return cases;
}

inline void setNumber(const OptionField& option, double value) {
  if (const auto* whole = std::get_if<int*>(&option.value)) **whole = static_cast<int>(value);
  if (const auto* real = std::get_if<double*>(&option.value)) **real = value;
}

/// The defaults are valid; validate() refuses every number just outside of either bound and what is
/// not a number, naming its key, and takes it at the bound, unless another field forbids it.
template <typename Options>
void expectBothSidesOfItsBounds() {
  Options defaults;
  EXPECT_EQ(defaults.validate(), "");
  const std::size_t rows = optionTable(&defaults).size();
  int tested = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    Options options;
    const OptionField row = optionTable(&options)[i];
    EXPECT_FALSE(row.reason.empty()) << row.key;
    const std::string refusal = row.key + " is ";
    for (const BoundCase& bound : boundCases(row)) {
      options = Options();
      setNumber(row, bound.inside);
      std::string message = options.validate();
      EXPECT_FALSE(message.find(refusal) == 0 && message.find("must be in") != std::string::npos)
          << message;
      setNumber(row, bound.outside);
      message = options.validate();
      EXPECT_EQ(message.find(refusal), 0u) << row.key << " = " << bound.outside << ": " << message;
      EXPECT_NE(message.find("must be in"), std::string::npos) << message;
      ++tested;
    }
    if (std::holds_alternative<double*>(row.value)) {
      options = Options();
      setNumber(row, std::numeric_limits<double>::quiet_NaN());
      EXPECT_EQ(options.validate().find(refusal), 0u) << row.key;
    }
  }
  EXPECT_GT(tested, 0);
}

/// The same of several structs.
template <typename... Options>
void expectBothSidesOfEveryBound() {
  (expectBothSidesOfItsBounds<Options>(), ...);
}

/// Every field of `Options`, which is trivially destructible, has a row: a field that was added and
/// forgotten in the table could be set by no file and would be checked by nobody. C++ cannot list
/// fields; but bytes that a constructor writes are fields, bytes that keep the paint of the memory
/// below are padding.
template <typename Options, typename MakeTable>
void expectEveryFieldHasARow(const MakeTable& makeTable) {
  constexpr std::size_t kSize = sizeof(Options);
  alignas(Options) unsigned char memory[2][kSize];
  const unsigned char paints[2] = {0x5a, 0xa5};
  for (int i = 0; i < 2; ++i) {
    std::memset(memory[i], paints[i], kSize);
    asm volatile("" : : "r"(memory[i]) : "memory");  // the paint is not dead
    new (memory[i]) Options;                         // trivially destructible
    asm volatile("" : : "r"(memory[i]) : "memory");
  }
  std::vector<bool> written(kSize), listed(kSize);
  for (std::size_t i = 0; i < kSize; ++i) written[i] = memory[0][i] == memory[1][i];

  Options options;
  const auto* begin = reinterpret_cast<const unsigned char*>(&options);
  for (const OptionField& row : makeTable(&options)) {
    const auto [field, size] = memoryOf(row);
    const auto* bytes = static_cast<const unsigned char*>(field);
    ASSERT_TRUE(bytes >= begin && bytes + size <= begin + kSize) << row.key;
    std::fill_n(listed.begin() + (bytes - begin), size, true);
  }
  for (std::size_t i = 0; i < kSize; ++i) {
    if (!written[i] || listed[i]) continue;
    ADD_FAILURE() << "byte " << i << " of " << typeid(Options).name()
                  << " belongs to a field without a row";
    return;
  }
}

template <typename Options>
void expectEveryFieldHasARow() {
  expectEveryFieldHasARow<Options>([](Options* options) { return optionTable(options); });
}

/// Units in the comments of a header, "[px]" at the end of `double x = 1.0;  ///< text [px]`, by
/// struct and field.
inline std::map<std::string, std::string> unitsOfHeader(const std::string& path) {
  const std::regex struct_line("^struct ([A-Za-z]+) \\{");
  const std::regex field_line(
      "^  [A-Za-z]+ ([A-Za-z_0-9]+) =[^;]*;\\s*///< .*?(\\[([^\\]]*)\\])?$");
  std::map<std::string, std::string> units;
  std::ifstream file(path);
  std::string name;
  std::smatch match;
  for (std::string line; std::getline(file, line);) {
    if (std::regex_search(line, match, struct_line)) name = match[1];
    if (std::regex_search(line, match, field_line)) units[name + "." + match[1].str()] = match[3];
  }
  return units;
}

/// The header states the unit of every number of a table as the table does.
inline void expectUnitsAgree(const std::map<std::string, std::string>& header,
                             const std::string& struct_name, const OptionTable& table) {
  for (const OptionField& row : table) {
    if (row.key.find('.') != std::string::npos) continue;  // of a struct of its own
    const auto unit = header.find(struct_name + "." + row.key);
    ASSERT_NE(unit, header.end()) << struct_name << "." << row.key << " has no comment";
    EXPECT_EQ(unit->second, row.unit) << struct_name << "." << row.key;
  }
}

}  // namespace slim_init
