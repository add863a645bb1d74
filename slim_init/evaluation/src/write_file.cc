// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/write_file.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace slim_init::evaluation {

namespace fs = std::filesystem;

std::string writeFile(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << bytes;
  file.close();
  return file.good() ? "" : path + " cannot be written";
}

std::string checkWritable(const std::string& path) {
  std::error_code none;
  const fs::path file = fs::absolute(path, none);
  const fs::path needed = fs::exists(file, none) ? file : file.parent_path();
  const bool good = !fs::is_directory(path, none) && access(needed.c_str(), W_OK) == 0;
  return good ? "" : path + " cannot be written";
}

}  // namespace slim_init::evaluation
