// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "options.h"

#include <iostream>
#include <utility>

#include "exit_code.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/write_file.h"

namespace slim_init::tools {

std::vector<AbOption> optionsOptionTable(OptionsCommand* options) {
  OptionsCommand& o = *options;
  return {
      {"keys",
       &o.keys,
       "WHICH",
       "Keys to print",
       "",
       0.0,
       0.0,
       OptionScope::kAlways,
       {"user", "advanced", "compared", "all"}},
      {"update", &o.update, "DIR",
       "Write config/template.yaml, user.yaml, advanced.yaml and compared_methods.yaml of the "
       "repository DIR",
       ""},
  };
}

namespace {

constexpr std::pair<const char*, OptionKeys> kGroups[] = {{"user", OptionKeys::kUser},
                                                          {"advanced", OptionKeys::kAdvanced},
                                                          {"compared", OptionKeys::kCompared},
                                                          {"all", OptionKeys::kAll}};

int update(const std::string& folder) {
  for (const GeneratedFile& file : generatedFiles()) {
    const std::string path = folder + "/" + file.path;
    check(evaluation::writeFile(path, file.text));
    std::cout << path << "\n";
  }
  return kExitOk;
}

}  // namespace

int runOptions(const OptionsCommand& options) {
  if (!options.update.empty()) return update(options.update);
  for (const auto& [name, keys] : kGroups) {
    if (options.keys == name) std::cout << optionsYaml(keys);
  }
  return kExitOk;
}

}  // namespace slim_init::tools
