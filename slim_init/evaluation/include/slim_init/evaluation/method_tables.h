// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Tables with a row per method. Definitions of the figures: docs/evaluation.md.
#pragma once

#include <string>
#include <vector>

#include "slim_init/evaluation/report.h"
#include "slim_init/evaluation/table.h"

namespace slim_init::evaluation {

/// A column: a figure of one method over one set of windows.
struct SummaryColumn {
  std::string title;
  bool needs_truth = true;  ///< left out of the tables of a sequence without truth
  Best best = Best::kNone;
  TableCell (*cell)(const SubsetSummary& summary) = nullptr;
};
using SummaryColumns = std::vector<SummaryColumn>;

const SummaryColumns& accuracyColumns();    ///< over successful windows, and how many there are
const SummaryColumns& acceptedColumns();    ///< over what the methods themselves called a success
const SummaryColumns& downstreamColumns();  ///< of the estimator run from the accepted answers
const SummaryColumns& timeColumns();        ///< of a solve
const SummaryColumns& verdictColumns();     ///< where the windows went

/// All windows or the excited ones.
using SubsetOf = SubsetSummary MethodSummary::*;

/// A table without rows whose first columns are `names`.
Table emptyTable(const std::vector<std::string>& names, const SummaryColumns& columns,
                 bool has_truth = true);

/// Appends a row per method, its first cells `names` and the method's name, and marks the best of
/// these rows.
void addMethods(const std::vector<std::string>& names, const SummaryColumns& columns,
                const std::vector<MethodSummary>& summaries, SubsetOf subset, bool has_truth,
                Table* table);

/// The table of one sequence.
Table methodTable(const SummaryColumns& columns, const std::vector<MethodSummary>& summaries,
                  SubsetOf subset, bool has_truth);

}  // namespace slim_init::evaluation
