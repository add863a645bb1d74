// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/recorded.h"

#include <Eigen/Geometry>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxQuaternionNormError = 1e-2;
constexpr std::size_t kMaxColumns = 17;

const std::array<const char*, 1> kImageColumns = {"timestamp"};
const std::array<const char*, 7> kImuColumns = {"timestamp", "w_x", "w_y", "w_z",
                                                "a_x",       "a_y", "a_z"};
const std::array<const char*, 17> kTruthColumns = {
    "timestamp", "p_x", "p_y",  "p_z",  "q_w",  "q_x",  "q_y",  "q_z", "v_x",
    "v_y",       "v_z", "bw_x", "bw_y", "bw_z", "ba_x", "ba_y", "ba_z"};
constexpr std::size_t kPoseColumns = 8;

/// One parsed row: stamp, then the other columns.
struct Row {
  int line = 0;
  std::int64_t stamp_ns = 0;
  std::array<double, kMaxColumns - 1> values{};
};

struct Table {
  std::string path;
  std::size_t columns = 0;
  std::vector<Row> rows;
};

ReadStatus error(ReadError kind, const std::string& message) { return {kind, message}; }

// Values are quoted from files we know nothing about: cut, and printable only.
std::string quoted(const char* begin, const char* end) {
  std::string text = "'";
  for (const char* c = begin; c != end; ++c) {
    if (text.size() > 40) {
      text += "...";
      break;
    }
    text += *c >= 32 && *c < 127 ? *c : '?';
  }
  return text + "'";
}

ReadStatus readText(const std::string& path, std::string* text) {
  std::error_code code;
  if (!fs::exists(path, code)) return error(ReadError::kMissingFile, path + " does not exist");
  if (!fs::is_regular_file(path, code)) {
    return error(ReadError::kMissingFile, path + " is not a regular file");
  }
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  // Streaming an empty file would set the fail bit of `content`; that is "too few rows", not an
  // error of reading.
  if (file && file.peek() != std::ifstream::traits_type::eof()) content << file.rdbuf();
  if (!file.is_open() || file.bad() || content.fail()) {
    return error(ReadError::kMissingFile, path + " cannot be read");
  }
  *text = content.str();
  return {};
}

/// Splits a file into rows of numbers; the first column is an integer stamp, ascending.
class TableParser {
 public:
  /// `names` are the columns in order; a row may end after any of the counts in `allowed`, and all
  /// rows have as many columns as the first.
  TableParser(const char* const* names, std::vector<std::size_t> allowed)
      : names_(names), allowed_(std::move(allowed)) {}

  ReadStatus parse(const std::string& path, const std::string& text, Table* table) {
    table_ = table;
    table_->path = path;
    table_->rows.reserve(text.size() / 64 + 1);
    const char* cursor = text.data();
    const char* const end = cursor + text.size();
    if (text.compare(0, 3, "\xEF\xBB\xBF") == 0) cursor += 3;  // byte order mark of some editors
    int empty_line = 0;
    for (line_ = 1; cursor < end; ++line_) {
      const void* newline = std::memchr(cursor, '\n', static_cast<std::size_t>(end - cursor));
      const char* line_end = newline != nullptr ? static_cast<const char*>(newline) : end;
      const char* const next = newline != nullptr ? line_end + 1 : end;
      if (line_end > cursor && line_end[-1] == '\r') --line_end;
      trim(&cursor, &line_end);
      if (cursor == line_end) {
        if (empty_line == 0) empty_line = line_;
      } else if (*cursor != '#') {
        if (empty_line != 0) {
          return error(ReadError::kMalformed, path + " line " + std::to_string(empty_line) +
                                                  " is empty, data go on after");
        }
        if (ReadStatus status = parseRow(cursor, line_end); !status.ok()) return status;
      }
      cursor = next;
    }
    return {};
  }

 private:
  static void trim(const char** begin, const char** end) {
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    while (*begin < *end && blank(**begin)) ++*begin;
    while (*begin < *end && blank((*end)[-1])) --*end;
  }

  std::string place() const { return table_->path + " line " + std::to_string(line_); }
  std::string place(std::size_t column) const {
    return place() + " column " + std::to_string(column + 1) + " (" + names_[column] + ")";
  }

  ReadStatus checkColumnCount(const char* begin, const char* end) {
    std::size_t count = 1;
    for (const char* c = begin; c != end; ++c) count += *c == ',' ? 1 : 0;
    if (table_->columns == 0) {
      for (const std::size_t allowed : allowed_) {
        if (count == allowed) table_->columns = count;
      }
    }
    if (count == table_->columns) return {};
    std::ostringstream out;
    out << place() << " has " << count << " columns, must have ";
    if (table_->columns != 0) {
      out << table_->columns;
    } else {
      for (std::size_t i = 0; i < allowed_.size(); ++i) out << (i > 0 ? " or " : "") << allowed_[i];
    }
    out << ": " << quoted(begin, end);
    return error(ReadError::kMalformed, out.str());
  }

  ReadStatus parseRow(const char* begin, const char* end) {
    if (ReadStatus status = checkColumnCount(begin, end); !status.ok()) return status;
    Row row;
    row.line = line_;
    const char* field = begin;
    for (std::size_t column = 0; column < table_->columns; ++column) {
      const char* field_end = field;
      while (field_end < end && *field_end != ',') ++field_end;
      const char* first = field;
      const char* last = field_end;
      trim(&first, &last);
      ReadStatus status = column == 0 ? parseStamp(first, last, &row.stamp_ns)
                                      : parseNumber(first, last, column, &row.values[column - 1]);
      if (!status.ok()) return status;
      field = field_end + 1;
    }
    if (!table_->rows.empty() && row.stamp_ns <= table_->rows.back().stamp_ns) {
      const Row& before = table_->rows.back();
      std::ostringstream out;
      out << place() << ": time " << row.stamp_ns << " ns "
          << (row.stamp_ns == before.stamp_ns
                  ? "repeats that"
                  : "is before the " + std::to_string(before.stamp_ns) + " ns")
          << " of line " << before.line << ", times must increase";
      return error(ReadError::kOutOfOrder, out.str());
    }
    table_->rows.push_back(row);
    return {};
  }

  ReadStatus parseStamp(const char* first, const char* last, std::int64_t* stamp_ns) const {
    const auto parsed = std::from_chars(first, last, *stamp_ns);
    if (parsed.ec == std::errc() && parsed.ptr == last && first != last && *stamp_ns >= 0) {
      return {};
    }
    return error(ReadError::kMalformed,
                 place(0) + ": " + quoted(first, last) + " is not a whole number of nanoseconds");
  }

  ReadStatus parseNumber(const char* first, const char* last, std::size_t column,
                         double* value) const {
    // The field is not empty and starts with no space, so strtod cannot run into the next field: it
    // stops at the comma or the end of the line. (from_chars for double needs GCC 11.)
    char* stopped = nullptr;
    if (first != last) *value = std::strtod(first, &stopped);
    if (first == last || stopped != last) {
      return error(ReadError::kMalformed,
                   place(column) + ": " + quoted(first, last) + " is not a number");
    }
    if (!std::isfinite(*value)) {
      return error(ReadError::kBadValue,
                   place(column) + ": " + quoted(first, last) + " is not finite");
    }
    return {};
  }

  const char* const* names_;
  std::vector<std::size_t> allowed_;
  Table* table_ = nullptr;
  int line_ = 0;
};

ReadStatus readTable(const std::string& path, const char* const* names,
                     const std::vector<std::size_t>& allowed, int min_rows, Table* table) {
  std::string text;
  if (ReadStatus status = readText(path, &text); !status.ok()) return status;
  if (ReadStatus status = TableParser(names, allowed).parse(path, text, table); !status.ok()) {
    return status;
  }
  if (static_cast<int>(table->rows.size()) < min_rows) {
    std::ostringstream out;
    out << path << " has " << table->rows.size() << " rows of data, needs at least " << min_rows;
    return error(ReadError::kTooFewRows, out.str());
  }
  return {};
}

Eigen::Vector3d vectorAt(const Row& row, std::size_t first) {
  return {row.values[first], row.values[first + 1], row.values[first + 2]};
}

// The difference is taken in integers; a double holds 1.4e18 ns only to 256 ns.
double relativeSeconds(std::int64_t stamp_ns, std::int64_t t0_ns) {
  return 1e-9 * static_cast<double>(stamp_ns - t0_ns);
}

ReadStatus convertTruth(const Table& table, RecordedMotion* motion) {
  motion->has_velocity = table.columns > kPoseColumns;
  motion->has_bias = motion->has_velocity;
  motion->truth.reserve(table.rows.size());
  for (const Row& row : table.rows) {
    NavState state;
    state.t = relativeSeconds(row.stamp_ns, motion->t0_ns);
    state.p_w_b = vectorAt(row, 0);
    const Eigen::Quaterniond q(row.values[3], row.values[4], row.values[5], row.values[6]);
    if (!(std::abs(q.norm() - 1.0) <= kMaxQuaternionNormError)) {
      std::ostringstream out;
      out << table.path << " line " << row.line << " columns 5 to 8 (q_w, q_x, q_y, q_z): norm is "
          << q.norm() << ", must be within " << kMaxQuaternionNormError << " of 1";
      return error(ReadError::kBadValue, out.str());
    }
    state.R_w_b = q.normalized().toRotationMatrix();
    if (motion->has_velocity) {
      state.v_w_b = vectorAt(row, 7);
      state.gyro_bias = vectorAt(row, 10);
      state.accel_bias = vectorAt(row, 13);
    } else {
      state.v_w_b.setConstant(kNotComputed);
      state.gyro_bias.setConstant(kNotComputed);
      state.accel_bias.setConstant(kNotComputed);
    }
    motion->truth.push_back(state);
  }
  motion->counts.truth_samples = static_cast<int>(motion->truth.size());
  return {};
}

void convertImu(const Table& table, double max_gap_s, RecordedMotion* motion) {
  RecordedCounts& counts = motion->counts;
  motion->t0_ns = table.rows.front().stamp_ns;
  motion->imu.reserve(table.rows.size());
  std::string longest;
  for (const Row& row : table.rows) {
    ImuSample sample;
    sample.t = relativeSeconds(row.stamp_ns, motion->t0_ns);
    sample.gyro = vectorAt(row, 0);
    sample.accel = vectorAt(row, 3);
    if (!motion->imu.empty()) {
      const double step = sample.t - motion->imu.back().t;
      if (step > max_gap_s) ++counts.imu_gaps;
      if (step > counts.largest_imu_gap_s) {
        counts.largest_imu_gap_s = step;
        std::ostringstream out;
        out << step << " s before line " << row.line << ", " << motion->imu.back().t
            << " s after the first sample";
        longest = out.str();
      }
    }
    motion->imu.push_back(sample);
  }
  counts.imu_samples = static_cast<int>(motion->imu.size());
  if (counts.imu_gaps > 0) {
    std::ostringstream out;
    out << table.path << " has " << counts.imu_gaps << " IMU gap"
        << (counts.imu_gaps > 1 ? "s" : "") << " longer than " << max_gap_s << " s, the longest "
        << longest << "; no window reaches across a gap";
    motion->notes.push_back(out.str());
  }
}

ReadStatus convertImages(const Table& table, RecordedMotion* motion) {
  RecordedCounts& counts = motion->counts;
  counts.images = static_cast<int>(table.rows.size());
  const double imu_end = motion->imu.back().t;
  for (const Row& row : table.rows) {
    const double t = relativeSeconds(row.stamp_ns, motion->t0_ns);
    if (t < 0.0 || t > imu_end) {
      ++counts.images_outside_imu;
    } else if (t < motion->truth.front().t || t > motion->truth.back().t) {
      ++counts.images_outside_truth;
    } else {
      motion->image_times.push_back(t);
    }
  }
  const auto describe = [&](int count, const char* what, double begin, double end) {
    std::ostringstream out;
    out << count << " of " << counts.images << " images of " << table.path << " lie outside the "
        << what << " (" << begin << " s to " << end << " s after the first IMU sample)";
    return out.str();
  };
  const std::string outside_imu = describe(counts.images_outside_imu, "IMU data", 0.0, imu_end);
  const std::string outside_truth = describe(counts.images_outside_truth, "ground truth",
                                             motion->truth.front().t, motion->truth.back().t);
  if (motion->image_times.empty()) {
    const double first = relativeSeconds(table.rows.front().stamp_ns, motion->t0_ns);
    const double last = relativeSeconds(table.rows.back().stamp_ns, motion->t0_ns);
    std::ostringstream out;
    out << (counts.images_outside_imu == counts.images ? outside_imu
            : counts.images_outside_imu > 0            ? outside_imu + ", " + outside_truth
                                                       : outside_truth)
        << "; the images span " << first << " s to " << last << " s, so none can be used";
    return error(ReadError::kNoOverlap, out.str());
  }
  if (counts.images_outside_imu > 0) motion->notes.push_back(outside_imu + " and were left out");
  if (counts.images_outside_truth > 0) {
    motion->notes.push_back(outside_truth + " and were left out");
  }
  return {};
}

std::string lastComponent(const std::string& directory) {
  fs::path path = fs::path(directory).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "a/b/"
  std::string name = path.filename().string();
  if (name.empty() || name == "." || name == "..") {
    std::error_code code;
    const fs::path real = fs::canonical(directory, code);
    if (!code) name = real.filename().string();
  }
  return name.empty() ? "recorded" : name;
}

}  // namespace

ReadStatus readRecordedMotion(const std::string& directory, const RecordedOptions& options,
                              RecordedMotion* motion) {
  std::error_code code;
  if (!fs::is_directory(directory, code)) {
    return error(ReadError::kMissingFile, directory + " is not a directory");
  }
  const auto file = [&](const char* name) { return (fs::path(directory) / name).string(); };
  Table imu;
  Table images;
  Table truth;
  ReadStatus status = readTable(file("imu0.csv"), kImuColumns.data(), {kImuColumns.size()},
                                options.min_imu_rows, &imu);
  if (status.ok()) {
    status = readTable(file("cam0_timestamps.csv"), kImageColumns.data(), {kImageColumns.size()},
                       options.min_images, &images);
  }
  if (status.ok()) {
    status = readTable(file("groundtruth.csv"), kTruthColumns.data(),
                       {kPoseColumns, kTruthColumns.size()}, options.min_truth_rows, &truth);
  }
  if (!status.ok()) return status;

  RecordedMotion read;
  read.name = lastComponent(directory);
  convertImu(imu, options.max_imu_gap_s, &read);
  status = convertTruth(truth, &read);
  if (status.ok()) status = convertImages(images, &read);
  if (!status.ok()) return status;
  if (!read.has_velocity) {
    read.notes.push_back(truth.path +
                         " holds poses only: true velocities are derivatives of the positions");
  }
  *motion = std::move(read);
  return {};
}

}  // namespace slim_init::evaluation
