// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// A table of stamps and numbers; what is written is read back bit for bit.
class CsvFile {
 public:
  /// Replaces the file. Like the other calls, returns an empty string or a sentence.
  std::string open(const std::string& path, const std::string& header);
  /// Stamps must increase, values be finite.
  std::string add(std::int64_t stamp_ns, const std::vector<double>& values);
  std::string addText(std::int64_t stamp_ns, const std::string& text);
  std::string finish();

 private:
  std::string checkStamp(std::int64_t stamp_ns);

  std::string path_;
  std::ofstream file_;
  std::int64_t last_ns_ = -1;
};

/// Ground truth in 17 columns, as in an ASL folder.
class TruthCsv {
 public:
  std::string open(const std::string& path);
  std::string add(std::int64_t stamp_ns, const NavState& state);
  std::string finish() { return file_.finish(); }

 private:
  CsvFile file_;
};

}  // namespace slim_init::evaluation
