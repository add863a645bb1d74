// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/write_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>

namespace slim_init::evaluation {

std::string writeFile(const std::string& path, const std::string& bytes) {
  namespace fs = std::filesystem;
  std::error_code problem;
  // A pipe or a device is written to; a link stays one.
  const fs::path place = fs::exists(path, problem) ? fs::canonical(path, problem) : fs::path(path);
  const bool in_place = fs::exists(place, problem) && !fs::is_regular_file(place, problem);
  fs::path part = place;
  if (!in_place) part += ".part";
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file << bytes;
  file.close();
  bool good = file.good();
  if (good && !in_place) {
    fs::rename(part, place, problem);
    good = !problem;
  }
  if (!good && !in_place) fs::remove(part, problem);
  return good ? "" : path + " cannot be written";
}

}  // namespace slim_init::evaluation
