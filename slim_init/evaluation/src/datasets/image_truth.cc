// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/csv_table.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/truth.h"

namespace slim_init::evaluation {

void ImageSequence::readTruth(const std::string& path) {
  const CsvTable table = readTable(path, truthFormat(RowOrder::kSort));
  truth_ = truthStates(table, t0_ns_);
  has_velocity_and_bias_ = table.columns > kPoseColumns;
  note(disorderNote(path, "rows", table.disorder));
  if (!has_velocity_and_bias_) note(path + ": " + deriveVelocities(&truth_).note);
}

void ImageSequence::note(const std::string& sentence) {
  if (!sentence.empty()) notes_.push_back(sentence);
}

}  // namespace slim_init::evaluation
