// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The commands of slim_init_bench. Each takes the arguments after its name and returns the exit
// code.
#pragma once

#include <string>
#include <vector>

namespace slim_init::tools {

/// `faults`: starts of a host whose streams are at fault, as a table.
int runFaultsCommand(const std::vector<std::string>& arguments);

/// `soak`: one host for a day, with faults in its streams, faster than real time. Exit code 1 if
/// memory, the time of a solve or the number of estimates drifts beyond its bound.
int runSoakCommand(const std::vector<std::string>& arguments);

/// `count`: solves every window once per method, for a tool that counts instructions, or to compare
/// the estimates of two builds.
int runCountCommand(const std::vector<std::string>& arguments);

}  // namespace slim_init::tools
