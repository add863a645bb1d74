// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "method_lists.h"

#include <algorithm>

namespace slim_init::evaluation {

std::vector<std::string> methodsOf(const std::vector<const ProtocolResult*>& sequences) {
  std::vector<std::string> names;
  for (const ProtocolResult* sequence : sequences) {
    for (const std::string& name : sequence->methods) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

int indexOf(const ProtocolResult& result, const std::string& method) {
  const auto found = std::find(result.methods.begin(), result.methods.end(), method);
  return found == result.methods.end() ? -1 : static_cast<int>(found - result.methods.begin());
}

}  // namespace slim_init::evaluation
