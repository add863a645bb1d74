// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The result of a suite for people: a page, and the short form for a terminal.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "slim_init/evaluation/page.h"
#include "suite_tables.h"

namespace slim_init::tools {

/// A set of cases that is looked at together.
struct SuiteGroup {
  std::string title;   ///< "EuRoC, from images"
  std::string prefix;  ///< of the files of its pictures
  SuiteResults results;
  bool ablation = false;
  bool degenerate = false;
  CaseKind kind = CaseKind::kBuiltin;
  std::vector<evaluation::Comparison> comparisons;  ///< with kReference, all windows
};

/// Everything that a suite has to tell.
struct SuiteReport {
  std::string command;
  std::string program;  ///< version and commit
  std::string processor;
  std::vector<std::string> methods;
  std::vector<SuiteResult> results;
  std::vector<SuiteGroup> groups;   ///< point into `results`
  std::vector<std::string> notes;   ///< what was looked for and is not there
  std::vector<std::string> failed;  ///< cases that could not be run, a sentence each
  std::vector<std::pair<std::string, std::string>> pictures;  ///< files and titles
  std::string picture_note;
};

/// The method that all others are compared with.
inline constexpr char kReference[] = "slim";

/// Sorts report->results, which may not grow any more, into groups and compares the methods.
void groupResults(SuiteReport* report);

evaluation::Page suitePage(const SuiteReport& report);
std::string suiteText(const SuiteReport& report);
std::string suiteJson(const SuiteReport& report, const std::string& directory);

}  // namespace slim_init::tools
