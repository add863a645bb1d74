// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/option_table.h"

#include <algorithm>
#include <utility>

namespace slim_init {

bool OptionField::isReadBy(const std::string& method) const {
  return methods.empty() || std::find(methods.begin(), methods.end(), method) != methods.end();
}

OptionField userKey(const char* key, OptionValue value, OptionRange range, const char* unit,
                    const char* reason, const std::vector<std::string>& methods) {
  return {key, std::move(value), range, unit, reason, Audience::kUser, methods};
}

OptionField userKey(const char* key, OptionValue value, const char* reason,
                    const std::vector<std::string>& methods) {
  return userKey(key, std::move(value), {}, "", reason, methods);
}

OptionField advancedKey(const char* key, OptionValue value, OptionRange range, const char* unit,
                        const char* reason, const std::vector<std::string>& methods) {
  return {key, std::move(value), range, unit, reason, Audience::kAdvanced, methods};
}

OptionField advancedKey(const char* key, OptionValue value, const char* reason,
                        const std::vector<std::string>& methods) {
  return advancedKey(key, std::move(value), {}, "", reason, methods);
}

bool isForComparedMethods(const OptionField& option) { return !option.isReadBy("slim"); }

void appendSection(const std::string& prefix, OptionTable section,
                   const std::vector<std::string>& methods, OptionTable* table) {
  for (OptionField& option : section) {
    if (!prefix.empty()) option.key = prefix + "." + option.key;
    if (option.methods.empty()) option.methods = methods;
    table->push_back(std::move(option));
  }
}

}  // namespace slim_init
