// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/image_truth.h"

#include <sstream>

#include "datasets/csv_table.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/truth.h"

namespace slim_init::evaluation {

ReadStatus ImageSequence::readTruth(const std::string& path) {
  CsvTable table;
  ReadStatus status = readTable(path, truthFormat(RowOrder::kSort), &table);
  if (status.ok()) status = truthStates(table, t0_ns_, &truth_, &has_velocity_and_bias_);
  if (!status.ok()) return status;
  counts_.truth_repeated = table.repeated;
  note(disorderNote(path, "rows", table.repeated, table.out_of_order));
  if (!has_velocity_and_bias_) note(path + ": " + deriveVelocities(&truth_).note);
  return {};
}

void ImageSequence::note(const std::string& sentence) {
  if (!sentence.empty()) notes_.push_back(sentence);
}

std::string disorderNote(const std::string& source, const std::string& things, int repeated,
                         int out_of_order) {
  if (repeated == 0 && out_of_order == 0) return "";
  std::ostringstream out;
  out << source << ": ";
  if (repeated > 0) {
    out << repeated << " " << things << " with the stamp of another one were discarded";
  }
  if (out_of_order > 0) {
    out << (repeated > 0 ? ", " : "") << out_of_order << " " << things
        << " out of order were sorted in";
  }
  return out.str();
}

}  // namespace slim_init::evaluation
