// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/recorded.h"

#include <array>
#include <filesystem>

#include "datasets/csv_table.h"
#include "slim_init/evaluation/truth.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

const std::array<const char*, 1> kImageColumns = {"timestamp"};

void convertImages(const CsvTable& table, RecordedMotion* motion) {
  std::size_t beyond_imu = 0, beyond_truth = 0;
  const double imu_end = motion->imu.back().t;
  for (const CsvRow& row : table.rows) {
    const double t = relativeSeconds(row.stamp_ns, motion->t0_ns);
    if (t < 0.0 || t > imu_end) {
      ++beyond_imu;
    } else if (t < motion->truth.front().t || t > motion->truth.back().t) {
      ++beyond_truth;
    } else {
      motion->image_times.push_back(t);
    }
  }
  const auto describe = [&](std::size_t count, const char* what, double begin, double end) {
    return text(count, " of ", table.rows.size(), " images of ", table.path, " lie outside the ",
                what, " (", begin, " s to ", end, " s after the first IMU sample)");
  };
  const std::string outside_imu = describe(beyond_imu, "IMU data", 0.0, imu_end);
  const std::string outside_truth =
      describe(beyond_truth, "ground truth", motion->truth.front().t, motion->truth.back().t);
  if (motion->image_times.empty()) {
    const double first = relativeSeconds(table.rows.front().stamp_ns, motion->t0_ns);
    const double last = relativeSeconds(table.rows.back().stamp_ns, motion->t0_ns);
    fail(beyond_imu == table.rows.size() ? outside_imu
         : beyond_imu > 0                ? outside_imu + ", " + outside_truth
                                         : outside_truth,
         "; the images span ", first, " s to ", last, " s, so none can be used");
  }
  if (beyond_imu > 0) motion->notes.push_back(outside_imu + " and were discarded");
  if (beyond_truth > 0) {
    motion->notes.push_back(outside_truth + " and were discarded");
  }
}

RecordedMotion readMotion(const std::string& directory, double max_imu_gap_s) {
  std::error_code code;
  if (!fs::is_directory(directory, code)) fail(directory, " is not a directory");
  const auto file = [&](const char* name) { return (fs::path(directory) / name).string(); };
  const CsvTable imu = readTable(file("imu0.csv"), imuFormat(RowOrder::kReject));
  const CsvTable images = readTable(
      file("cam0_timestamps.csv"),
      {kImageColumns.data(), {kImageColumns.size()}, false, RowOrder::kReject, kMinImages});
  const CsvTable truth = readTable(file("groundtruth.csv"), truthFormat(RowOrder::kReject));

  RecordedMotion read;
  read.name = lastComponent(directory);
  read.t0_ns = imu.rows.front().stamp_ns;
  read.imu = imuSamples(imu, read.t0_ns);
  if (const std::string gaps = imuGapNote(imu.path, read.imu, max_imu_gap_s, &imu); !gaps.empty()) {
    read.notes.push_back(gaps);
  }
  read.speeds = readSpeeds(file("speed0.csv"), read.t0_ns);
  read.truth = truthStates(truth, read.t0_ns);
  read.has_velocity_and_bias = truth.columns > kPoseColumns;
  convertImages(images, &read);
  if (!read.has_velocity_and_bias) {
    read.notes.push_back(truth.path + ": " + deriveVelocities(&read.truth).note);
  }
  return read;
}

}  // namespace

ReadStatus readRecordedMotion(const std::string& directory, double max_imu_gap_s,
                              RecordedMotion* motion) {
  return statusOf([&] { *motion = readMotion(directory, max_imu_gap_s); });
}

ReadStatus readPoses(const std::string& path, std::int64_t* t0_ns, std::vector<NavState>* states) {
  return statusOf([&] {
    const CsvTable table = readTable(path, truthFormat(RowOrder::kReject, 1));
    *states = truthStates(table, table.rows.front().stamp_ns);
    *t0_ns = table.rows.front().stamp_ns;
  });
}

}  // namespace slim_init::evaluation
