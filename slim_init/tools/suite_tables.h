// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The tables of a suite: functions from results to rows.
#pragma once

#include <string>
#include <vector>

#include "run_case.h"
#include "slim_init/evaluation/comparison.h"
#include "slim_init/evaluation/method_tables.h"
#include "slim_init/evaluation/table.h"
#include "suite_cases.h"

namespace slim_init::tools {

/// A case that was run, now or earlier.
struct SuiteResult {
  SuiteCase entry;
  CaseResult run;
};
using SuiteResults = std::vector<const SuiteResult*>;

/// Their windows, for statistics over several sequences.
std::vector<const evaluation::ProtocolResult*> protocolResults(const SuiteResults& results);

/// What was run: a row per case.
evaluation::Table caseTable(const SuiteResults& results);

/// The paper's table I for one metric: a row per method, a column per sequence and the mean over
/// them, each with the printed figure beside. A dagger: over fewer than half of the windows.
std::vector<evaluation::Table> accuracyTables(const SuiteResults& results,
                                              evaluation::SubsetOf subset);

/// Success rate and root mean square, median and 90 % quantile of every error: a row per case and
/// method.
evaluation::Table detailTable(const SuiteResults& results, evaluation::SubsetOf subset);

/// The paper's table II: a row per method, a column per group, the groups' windows together.
evaluation::Table successTable(const SuiteResults& results, evaluation::SubsetOf subset);

/// The paper's table III: a row per case and method; beside the corridor walk the paper's average.
evaluation::Table degenerateTable(const SuiteResults& results);

/// The paper's table IV and the same for `slim`: a row per variant, the windows of all sequences
/// together. `beside`: with the printed figures, which are for degenerate motion, or else that of
/// the gyroscope bias, which is for EuRoC.
evaluation::Table ablationTable(const SuiteResults& results, bool degenerate);

/// The paper's Fig. 6: CPU time of a solve over the windows with an estimate.
evaluation::Table timeTable(const SuiteResults& results);

/// Every method minus `reference` with its 95 % interval, all windows; empty without `reference`.
evaluation::Table differenceTable(const std::vector<evaluation::Comparison>& comparisons,
                                  const std::string& reference);

/// A row per case and method.
evaluation::Table caseMethodTable(const SuiteResults& results,
                                  const evaluation::SummaryColumns& columns,
                                  evaluation::SubsetOf subset);

/// The figures of a table with names in its first two columns (case, method) in which `method` is
/// not among the best of its case: a row per figure. Counts the figures that have a best.
evaluation::Table notFirstTable(const evaluation::Table& table, const std::string& method,
                                int* figures);

}  // namespace slim_init::tools
