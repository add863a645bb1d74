// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iostream>
#include <memory>
#include <utility>

#include "exit_code.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/write_file.h"
#include "subcommand.h"

namespace slim_init::tools {

namespace {

/// What `slim_init options` prints or writes.
struct OptionsCommand {
  std::string keys = "user";  ///< user, advanced or all
  std::string update;         ///< repository whose generated files are written; "" prints
};

constexpr std::pair<const char*, OptionKeys> kGroups[] = {
    {"user", OptionKeys::kUser}, {"advanced", OptionKeys::kAdvanced}, {"all", OptionKeys::kAll}};

int update(const std::string& folder) {
  const std::string own = folder + "/config/template.yaml";
  if (!std::ifstream(own)) check(own + " cannot be read, its text is kept");
  for (const GeneratedFile& file : generatedFiles(folder)) {
    const std::string path = folder + "/" + file.path;
    check(evaluation::writeFile(path, file.text));
    std::cout << path << "\n";
  }
  return kExitOk;
}

int runOptions(const OptionsCommand& options) {
  if (!options.update.empty()) return update(options.update);
  for (const auto& [name, keys] : kGroups) {
    if (options.keys == name) std::cout << optionsYaml(keys);
  }
  return kExitOk;
}

}  // namespace

Subcommand optionsSubcommand() {
  const auto options = std::make_shared<OptionsCommand>();
  OptionsCommand& o = *options;
  const std::vector<AbOption> table = {
      {"keys",
       &o.keys,
       "WHICH",
       "Keys to print",
       "",
       0.0,
       0.0,
       OptionScope::kAlways,
       {"user", "advanced", "all"}},
      {"update", &o.update, "DIR",
       "Write config/template.yaml, user.yaml and advanced.yaml of the repository DIR"},
  };
  return {"options", "List the keys of configuration files", table, [options](const Typed& typed) {
            if (typed.options.size() > 1) check("--keys has no effect with --update");
            return runOptions(*options);
          }};
}

}  // namespace slim_init::tools
