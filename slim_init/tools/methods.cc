// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "methods.h"

#include <iomanip>
#include <iostream>

#include "exit_code.h"
#include "subcommand.h"

namespace slim_init::tools {

const std::vector<std::string>& methodNames() {
  static const std::vector<std::string> kNames = baselines::namesOf(baselines::allMethods());
  return kNames;
}

Subcommand methodsSubcommand() {
  return {"methods", "List the methods with a line each", {}, [](const Typed& /*typed*/) {
            for (const baselines::Method& method : baselines::allMethods()) {
              std::cout << "  " << std::left << std::setw(12) << method.name << method.description
                        << "\n";
            }
            return static_cast<int>(kExitOk);
          }};
}

}  // namespace slim_init::tools
