// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/recorded.h"

#include <filesystem>

#include "datasets/csv_table.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

RecordedMotion readMotion(const std::string& directory, double max_imu_gap_s) {
  std::error_code code;
  if (!fs::is_directory(directory, code)) fail(directory, " is not a directory");
  const auto file = [&](const char* name) { return (fs::path(directory) / name).string(); };
  RecordedMotion read;
  read.name = lastComponent(directory);
  readImu(file("imu0.csv"), max_imu_gap_s, &read);
  readSpeeds(file("speed0.csv"), &read);
  const CsvTable images =
      readTable(file("cam0_timestamps.csv"), imageFormat(kMinImages), &read.notes);
  for (const CsvRow& row : images.rows) {
    read.image_times.push_back(relativeSeconds(row.stamp_ns, read.t0_ns));
  }
  readTruth(file("groundtruth.csv"), &read);
  return read;
}

}  // namespace

ReadStatus readRecordedMotion(const std::string& directory, double max_imu_gap_s,
                              RecordedMotion* motion) {
  return statusOf([&] { *motion = readMotion(directory, max_imu_gap_s); });
}

ReadStatus readPoses(const std::string& path, RecordedMotion* motion) {
  return statusOf([&] {
    const CsvTable table = readTable(path, truthFormat(1), &motion->notes);
    motion->t0_ns = table.rows.front().stamp_ns;
    motion->truth = truthStates(table, motion->t0_ns);
  });
}

}  // namespace slim_init::evaluation
