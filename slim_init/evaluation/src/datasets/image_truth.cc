// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/image_truth.h"

#include <sstream>

#include "datasets/csv_table.h"

namespace slim_init::evaluation {

ReadStatus readTruthFile(const std::string& path, std::int64_t t0_ns, int min_rows,
                         TruthFile* truth) {
  Table table;
  ReadStatus status = readTable(path, truthFormat(RowOrder::kSort, min_rows), &table);
  if (status.ok()) {
    status = truthStates(table, t0_ns, &truth->states, &truth->has_velocity_and_bias);
  }
  if (!status.ok()) return status;
  truth->out_of_order = table.out_of_order;
  truth->repeated = table.repeated;
  const std::string note = disorderNote(path, "rows", table.repeated, table.out_of_order);
  if (!note.empty()) truth->notes.push_back(note);
  if (!truth->has_velocity_and_bias) {
    truth->notes.push_back(path +
                           " holds poses only: true velocities are derivatives of the positions");
  }
  return {};
}

std::string disorderNote(const std::string& source, const std::string& things, int repeated,
                         int out_of_order) {
  if (repeated == 0 && out_of_order == 0) return "";
  std::ostringstream out;
  out << source << ": ";
  if (repeated > 0) {
    out << repeated << " " << things << " with the stamp of another one were dropped";
  }
  if (out_of_order > 0) {
    out << (repeated > 0 ? ", " : "") << out_of_order << " " << things
        << " out of order were sorted in";
  }
  return out.str();
}

}  // namespace slim_init::evaluation
