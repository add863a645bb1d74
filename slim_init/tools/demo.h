// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ab_options.h"

namespace slim_init::tools {

/// The command line of `slim_init demo`.
struct DemoCommand {
  std::string asl;                     ///< recording with images; empty: the built-in one, features
  std::string out = "slim_init_demo";  ///< folder of page and data
  int stride = 0;                      ///< images between two starts; 0: as it suits the recording
  bool quiet = false;
};

/// All options, bound to the fields of `command`; see abOptionTable().
std::vector<AbOption> demoOptionTable(DemoCommand* command);

/// Compares `slim`, `vins` and `openvins` on one recording twice, as recorded and with the errors
/// of a home-made rig, and writes a page. Returns the exit code.
int runDemo(const DemoCommand& command);

}  // namespace slim_init::tools
