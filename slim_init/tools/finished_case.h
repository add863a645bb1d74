// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is kept of a finished case beside its journal, so that it is not loaded, tracked and solved
// again.
#pragma once

#include <string>

#include "run_case.h"
#include "slim_init/evaluation/journal.h"

namespace slim_init::tools {

/// Writes `file`, at once as a whole. Returns an empty string, or a sentence naming it.
std::string writeFinishedCase(const std::string& file, const std::string& fingerprint,
                              const CaseResult& result);

/// Reads what writeFinishedCase() wrote and takes the windows from the journal. False where the
/// file is not there, cannot be read, has another fingerprint, or where the journal lacks a window.
/// Of RunInfo: dataset, truth, notes, variants and pictures; of the counts all.
bool readFinishedCase(const std::string& file, const std::string& fingerprint,
                      const evaluation::WindowJournal& journal, CaseResult* result);

}  // namespace slim_init::tools
