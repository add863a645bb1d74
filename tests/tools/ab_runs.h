// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/run_program.h"

namespace slim_init {

/// `slim_init ab` in a folder of its own.
class AbRuns : public ProgramTest {
 protected:
  /// `slim_init ab LINE`, which has to succeed; the report goes to `out`.
  ProgramRun ran(const std::string& line, const std::string& out = "out") const {
    return succeeds("ab " + line + " --out @" + out);
  }
  nlohmann::json summaryOf(const std::string& out = "out") const {
    return nlohmann::json::parse(readFile(folder.file(out) + "/summary.json"));
  }
  nlohmann::json summary(const std::string& line, const std::string& out = "out") const {
    ran(line, out);
    return summaryOf(out);
  }
};

}  // namespace slim_init
