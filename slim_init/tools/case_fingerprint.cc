// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "case_fingerprint.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include "source_commit.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kFnvOffset = 14695981039346656037ull;
constexpr std::uint64_t kFnvPrime = 1099511628211ull;

/// FNV-1a over the bytes of a file; a file that cannot be read adds nothing.
void addFile(const fs::path& path, std::uint64_t* hash) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(1 << 16);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0) {
    for (std::streamsize i = 0; i < file.gcount(); ++i) {
      *hash ^= static_cast<unsigned char>(block[static_cast<std::size_t>(i)]);
      *hash *= kFnvPrime;
    }
  }
}

std::string hex(std::uint64_t value) {
  std::ostringstream out;
  out << std::hex << value;
  return out.str();
}

/// Of the program and those of its libraries that are files of their own: a build of changed
/// sources has the commit of the one before.
std::uint64_t programHash() {
  std::set<std::string> files;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const std::size_t slash = line.find('/');
    if (slash == std::string::npos) continue;
    const fs::path path = line.substr(slash);
    if (path.filename().string().find("slim_init") != std::string::npos) files.insert(path);
  }
  std::error_code code;
  const fs::path self = fs::read_symlink("/proc/self/exe", code);
  if (!code) files.insert(self);
  std::uint64_t hash = kFnvOffset;
  for (const std::string& file : files) addFile(file, &hash);
  return hash;
}

std::uint64_t dataHash(const AbOptions& options) {
  std::uint64_t hash = kFnvOffset;
  for (const char* name : {"imu0.csv", "cam0_timestamps.csv", "groundtruth.csv"}) {
    if (!options.recorded.empty()) addFile(fs::path(options.recorded) / name, &hash);
  }
  for (const char* name : {"imu0/data.csv", "imu0/sensor.yaml", "cam0/data.csv", "cam0/sensor.yaml",
                           "state_groundtruth_estimate0/data.csv"}) {
    if (options.asl.empty()) break;
    addFile(fs::path(options.asl) / "mav0" / name, &hash);
    addFile(fs::path(options.asl) / name, &hash);
  }
  for (const std::string& file : {options.config_file, options.options_file, options.groundtruth}) {
    if (!file.empty()) addFile(file, &hash);
  }
  if (!options.bag.empty()) {
    std::error_code code;
    hash ^= static_cast<std::uint64_t>(fs::file_size(options.bag, code));
    hash *= kFnvPrime;
    hash ^= static_cast<std::uint64_t>(
        fs::last_write_time(options.bag, code).time_since_epoch().count());
    hash *= kFnvPrime;
  }
  return hash;
}

std::string valueText(const evaluation::OptionValue& value) {
  std::ostringstream out;
  out.precision(17);
  if (const auto* list = std::get_if<std::vector<std::string>>(&value)) {
    for (const std::string& item : *list) out << item << ",";
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    out << *text;
  } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    out << *integer;
  } else {
    out << std::get<double>(value);
  }
  return out.str();
}

}  // namespace

std::string caseFingerprint(const AbOptions& options) {
  static const std::string kProgram = std::string("slim_init ") + SLIM_INIT_VERSION + " " +
                                      sourceCommit() + " " + hex(programHash());
  std::string line = kProgram + "; data " + hex(dataHash(options));
  for (const auto& [key, value] : describeAbOptions(options)) {
    line += "; " + key + "=" + valueText(value);
  }
  if (options.ablation) line += "; ablation";
  for (char& c : line) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return line;
}

}  // namespace slim_init::tools
