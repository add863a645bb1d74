// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are a host's configuration file.
#include "fuzz_target.h"
#include "slim_init/config/config.h"

using slim_init::fuzz::Folder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  folder.write("host.yaml", std::string(reinterpret_cast<const char*>(data), size));
  const std::string path = folder.file("host.yaml");

  slim_init::Config config;
  std::string error;
  if (slim_init::loadConfig(path, &config, &error)) {
    FUZZ_CHECK(config.calibration.validate().empty(), config.calibration.validate());
    FUZZ_CHECK(config.options.validate().empty(), config.options.validate());
  } else {
    FUZZ_CHECK(!error.empty(), "refused without a word");
  }
  error.clear();
  slim_init::Config options;
  FUZZ_CHECK(slim_init::loadOptions(path, &options, &error) || !error.empty(),
             "refused without a word");
  error.clear();
  slim_init::HostKeys keys;
  FUZZ_CHECK(slim_init::loadHostKeys(path, &keys, &error) || !error.empty(),
             "refused without a word");
  return 0;
}
