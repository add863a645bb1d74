// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/write_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>

namespace slim_init::evaluation {

namespace {

namespace fs = std::filesystem;

struct Place {
  fs::path file;  // where a link leads
  fs::path part;  // what is written to
  bool in_place = false;
};

// A pipe or a device is written to; a link stays one.
Place placeOf(const std::string& path) {
  std::error_code problem;
  Place place;
  place.file = fs::exists(path, problem) ? fs::canonical(path, problem) : fs::path(path);
  place.in_place = fs::exists(place.file, problem) && !fs::is_regular_file(place.file, problem);
  place.part = place.file;
  if (!place.in_place) place.part += ".part";
  return place;
}

std::string cannotBeWritten(const std::string& path) { return path + " cannot be written"; }

}  // namespace

std::string writeFile(const std::string& path, const std::string& bytes) {
  const Place place = placeOf(path);
  std::error_code problem;
  std::ofstream file(place.part, std::ios::binary | std::ios::trunc);
  file << bytes;
  file.close();
  bool good = file.good();
  if (good && !place.in_place) {
    fs::rename(place.part, place.file, problem);
    good = !problem;
  }
  if (!good && !place.in_place) fs::remove(place.part, problem);
  return good ? "" : cannotBeWritten(path);
}

std::string checkWritable(const std::string& path) {
  const Place place = placeOf(path);
  // Opening a pipe would wait for who reads it.
  if (place.in_place) {
    std::error_code problem;
    return fs::is_directory(place.file, problem) ? cannotBeWritten(path) : "";
  }
  const bool good = std::ofstream(place.part, std::ios::binary).good();
  std::error_code problem;
  if (good) fs::remove(place.part, problem);
  return good ? "" : cannotBeWritten(path);
}

}  // namespace slim_init::evaluation
