// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// A table of stamps and numbers; what is written is read back bit for bit. Every call returns an
/// empty string or a sentence.
class CsvFile {
 public:
  /// Replaces the file.
  std::string open(const std::string& path, const std::string& header);
  std::string add(std::int64_t stamp_ns, const Eigen::Ref<const Eigen::VectorXd>& values);
  std::string addText(std::int64_t stamp_ns, const std::string& text);
  std::string finish();

 private:
  std::string problem() const { return file_.good() ? "" : path_ + " cannot be written"; }

  std::string path_;
  std::ofstream file_;
};

/// Ground truth in 17 columns, as in an ASL folder.
std::string openTruth(const std::string& path, CsvFile* file);
std::string writeTruth(std::int64_t stamp_ns, const NavState& state, CsvFile* file);

}  // namespace slim_init::evaluation
