// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Tables of comma-separated numbers whose first column is a stamp, and what all readers share. What
// cannot be read is thrown as a Problem.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "slim_init/evaluation/recorded.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {

/// The first problem of a recording, as a sentence. Caught in this library.
struct Problem {
  std::string sentence;
};

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  throw Problem{text(parts...)};
}

/// What came of reading.
template <typename Read>
ReadStatus statusOf(const Read& read) {
  try {
    read();
  } catch (const Problem& problem) {
    return {problem.sentence};
  }
  return {};
}

inline constexpr std::size_t kMaxTableColumns = 17;

/// One parsed row: stamp, then the other columns.
struct CsvRow {
  int line = 0;  ///< of the file, from 1
  std::int64_t stamp_ns = 0;
  std::array<double, kMaxTableColumns - 1> values{};
  std::string text;  ///< last column, where CsvFormat::last_is_text
};

struct CsvTable {
  std::string path;
  std::size_t columns = 0;
  std::vector<CsvRow> rows;  ///< ascending in time, all values finite
  Disorder disorder;         ///< what was done for that
};

struct CsvFormat {
  const char* things = "";           ///< the rows, in a sentence
  std::vector<const char*> names;    ///< of the columns in order
  std::vector<std::size_t> allowed;  ///< column counts; all rows have as many as the first
  int min_rows = 1;
  bool last_is_text = false;  ///< the last of all names is no number
};

/// What a recording needs to be usable: two samples make the shortest interval, two images the
/// smallest window.
inline constexpr int kMinImuSamples = 2;
inline constexpr std::size_t kMinImages = 2;

/// Stamps of images, with or without their file.
CsvFormat imageFormat(int min_rows);

/// Reads a table. Lines that begin with # are comments; both line ends, a byte order mark and blank
/// lines are accepted. The message of an error names file, line, column and value. Rows
/// out of order are sorted in; those of a repeated stamp and those with a value that is not finite
/// are dropped; a note says how many.
CsvTable readTable(const std::string& path, const CsvFormat& format,
                   std::vector<std::string>* notes);

/// Reads `t0_ns`, `imu` and `imu_disorder`; a step between samples longer than `max_gap_s` is
/// noted.
void readImu(const std::string& path, double max_gap_s, RecordedMotion* recording);

/// Pose, or pose with velocity and biases.
CsvFormat truthFormat(int min_rows);
/// Rows of a truthFormat() table; without velocity columns v_w_b and the biases are NaN. A
/// quaternion whose norm is off 1 by more than 0.01 is an error.
std::vector<NavState> truthStates(const CsvTable& table, std::int64_t t0_ns);
/// Reads `truth` and `has_velocity_and_bias`.
void readTruth(const std::string& path, RecordedMotion* recording);

/// Reads `speeds`: forward speed and its standard deviation, or both for each of the three axes, in
/// the frame of the sensor [m/s]. A standard deviation that is not positive is left to the stream
/// check. Without the file there are none.
void readSpeeds(const std::string& path, RecordedMotion* recording);

/// In quotes, for a sentence. Values are quoted from files we know nothing about: cut, and
/// printable only.
std::string quoted(const std::string& text);

/// Seconds from t0_ns. The difference is taken in integers: a double holds 1.4e18 ns only to 256.
double relativeSeconds(std::int64_t stamp_ns, std::int64_t t0_ns);

/// Notes steps between samples that are longer than a bound. `table` names the lines of `imu`; may
/// be null.
void noteImuGaps(const std::string& source, const std::vector<ImuSample>& imu, double max_gap_s,
                 const CsvTable* table, std::vector<std::string>* notes);

/// Notes "FILE: 2 IMU samples with the stamp of another one were discarded, ...", or nothing.
void noteDisorder(const std::string& source, const std::string& things, const Disorder& disorder,
                  std::vector<std::string>* notes);

/// The last component of a path that says something: "a/b/" is b.
std::string lastComponent(const std::string& path);

/// Sorts by `stamp_ns` and drops what repeats an earlier stamp (the first in the given order
/// stays).
template <typename T>
Disorder sortByStamp(std::vector<T>* items) {
  Disorder disorder;
  // As few as have to go for the rest to ascend: one late stamp does not count those after it.
  std::vector<std::int64_t> last;  // of the longest ascending sequences, by length
  for (const T& item : *items) {
    auto place = std::upper_bound(last.begin(), last.end(), item.stamp_ns);
    if (place == last.end()) place = last.insert(place, 0);
    *place = item.stamp_ns;
  }
  disorder.out_of_order = static_cast<int>(items->size() - last.size());
  std::stable_sort(items->begin(), items->end(),
                   [](const T& a, const T& b) { return a.stamp_ns < b.stamp_ns; });
  const auto kept = std::unique(items->begin(), items->end(),
                                [](const T& a, const T& b) { return a.stamp_ns == b.stamp_ns; });
  disorder.repeated = static_cast<int>(items->end() - kept);
  items->erase(kept, items->end());
  return disorder;
}

}  // namespace slim_init::evaluation
