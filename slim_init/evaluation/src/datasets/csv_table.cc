// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/csv_table.h"

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "slim_init/evaluation/truth.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxQuaternionNormError = 1e-2;
constexpr std::size_t kPoseColumns = 8;  // of a ground truth without velocities and biases
constexpr std::size_t kForwardColumns = 3;
constexpr int kMinTruthRows = 4;  // a cubic through the neighbours

std::string readText(const std::string& path) {
  std::error_code code;
  if (!fs::exists(path, code)) fail(path, " does not exist");
  if (!fs::is_regular_file(path, code)) fail(path, " is not a regular file");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  // Streaming an empty file would set the fail bit of `content`; that is "too few rows", not an
  // error of reading.
  if (file && file.peek() != std::ifstream::traits_type::eof()) content << file.rdbuf();
  if (!file.is_open() || file.bad() || content.fail()) fail(path, " cannot be read");
  return content.str();
}

/// Splits a file into rows of numbers; the first column is an integer stamp, ascending.
class TableParser {
 public:
  TableParser(const std::string& path, const CsvFormat& format) : format_(format) {
    table_.path = path;
  }

  CsvTable parse() {
    const std::string text = readText(table_.path);
    std::istringstream lines(text);
    if (text.compare(0, 3, "\xEF\xBB\xBF") == 0)
      lines.ignore(3);  // byte order mark of some editors
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      line = trimmed(line);
      if (!line.empty() && line[0] != '#') parseRow(line);
    }
    const int not_finite = table_.disorder.unreadable;
    table_.disorder = sortByStamp(&table_.rows);
    table_.disorder.unreadable = not_finite;
    if (static_cast<int>(table_.rows.size()) < format_.min_rows) {
      fail(table_.path, " has ", table_.rows.size(), " rows of data (minimum ", format_.min_rows,
           ')');
    }
    return std::move(table_);
  }

 private:
  static std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string::npos) return "";
    return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
  }

  std::string place() const { return text(table_.path, " line ", line_); }
  /// A problem of a field: "is not a number".
  [[noreturn]] void refuse(std::size_t column, const std::string& field, const char* why) const {
    fail(place(), " column ", column + 1, " (", format_.names[column], "): ", quoted(field), why);
  }

  void checkColumnCount(const std::string& line, std::size_t count) {
    const std::vector<std::size_t>& allowed = format_.allowed;
    if (table_.columns == 0 && std::count(allowed.begin(), allowed.end(), count) > 0) {
      table_.columns = count;
    }
    if (count == table_.columns) return;
    std::string wanted;
    for (const std::size_t one : allowed) wanted += text(wanted.empty() ? "" : " or ", one);
    if (table_.columns != 0) wanted = text(table_.columns);
    fail(place(), " has ", count, " columns, must have ", wanted, ": ", quoted(line));
  }

  void parseRow(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');) fields.push_back(trimmed(cell));
    checkColumnCount(line, fields.size());
    CsvRow row;
    row.line = line_;
    row.stamp_ns = parseStamp(fields[0]);
    bool finite = true;
    for (std::size_t column = 1; column < fields.size(); ++column) {
      if (format_.last_is_text && column + 1 == format_.names.size()) {
        row.text = fields[column];
      } else {
        row.values[column - 1] = parseNumber(fields[column], column);
        finite = finite && std::isfinite(row.values[column - 1]);
      }
    }
    if (finite) {
      table_.rows.push_back(std::move(row));
    } else {
      ++table_.disorder.unreadable;
    }
  }

  std::int64_t parseStamp(const std::string& field) const {
    const char* const end = field.data() + field.size();
    std::int64_t stamp_ns = 0;
    const auto parsed = std::from_chars(field.data(), end, stamp_ns);
    if (parsed.ec != std::errc() || parsed.ptr != end || stamp_ns < 0) {
      refuse(0, field, " is not a whole number of nanoseconds");
    }
    return stamp_ns;
  }

  double parseNumber(const std::string& field, std::size_t column) const {
    char* stopped = nullptr;  // (from_chars for double needs GCC 11)
    const double value = std::strtod(field.c_str(), &stopped);
    if (field.empty() || stopped != field.c_str() + field.size()) {
      refuse(column, field, " is not a number");
    }
    return value;
  }

  const CsvFormat& format_;
  CsvTable table_;
  int line_ = 0;
};

}  // namespace

CsvTable readTable(const std::string& path, const CsvFormat& format,
                   std::vector<std::string>* notes) {
  CsvTable table = TableParser(path, format).parse();
  noteDisorder(path, format.things, table.disorder, notes);
  return table;
}

CsvFormat imageFormat(int min_rows) {
  return {"images", {"timestamp", "filename"}, {1, 2}, min_rows, /*last_is_text=*/true};
}

std::string quoted(const std::string& text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) shown += c >= 32 && c < 127 ? c : '?';
  return shown + (text.size() > kLongest ? "...'" : "'");
}

double relativeSeconds(std::int64_t stamp_ns, std::int64_t t0_ns) {
  return 1e-9 * static_cast<double>(stamp_ns - t0_ns);
}

namespace {

Eigen::Vector3d vectorAt(const CsvRow& row, std::size_t first) {
  return {row.values[first], row.values[first + 1], row.values[first + 2]};
}

}  // namespace

void readImu(const std::string& path, double max_gap_s, RecordedMotion* recording) {
  const CsvFormat format = {
      "IMU samples", {"timestamp", "w_x", "w_y", "w_z", "a_x", "a_y", "a_z"}, {7}, kMinImuSamples};
  const CsvTable table = readTable(path, format, &recording->notes);
  recording->t0_ns = table.rows.front().stamp_ns;
  recording->imu_disorder = table.disorder;
  for (const CsvRow& row : table.rows) {
    ImuSample sample;
    sample.t = relativeSeconds(row.stamp_ns, recording->t0_ns);
    sample.gyro = vectorAt(row, 0);
    sample.accel = vectorAt(row, 3);
    recording->imu.push_back(sample);
  }
  noteImuGaps(path, recording->imu, max_gap_s, &table, &recording->notes);
}

void readSpeeds(const std::string& path, RecordedMotion* recording) {
  if (std::error_code no_file; !fs::exists(path, no_file)) return;
  const CsvFormat format = {"velocities",
                            {"timestamp", "v_x", "sigma_x", "v_y", "sigma_y", "v_z", "sigma_z"},
                            {kForwardColumns, 7}};
  const CsvTable table = readTable(path, format, &recording->notes);
  for (const CsvRow& row : table.rows) {
    const double t = relativeSeconds(row.stamp_ns, recording->t0_ns);
    SpeedSample sample = SpeedSample::forward(t, row.values[0], row.values[1]);
    if (table.columns > kForwardColumns) {
      sample.forward_only = false;
      for (int axis = 0; axis < 3; ++axis) {
        const double sigma = row.values[2 * axis + 1];
        sample.velocity[axis] = row.values[2 * axis];
        sample.covariance(axis, axis) = sigma > 0.0 ? sigma * sigma : sigma;
      }
    }
    recording->speeds.push_back(sample);
  }
}

CsvFormat truthFormat(int min_rows) {
  return {"rows",
          {"timestamp", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z",
           "bw_x", "bw_y", "bw_z", "ba_x", "ba_y", "ba_z"},
          {kPoseColumns, kMaxTableColumns},
          min_rows};
}

std::vector<NavState> truthStates(const CsvTable& table, std::int64_t t0_ns) {
  std::vector<NavState> states;
  for (const CsvRow& row : table.rows) {
    NavState state;
    state.t = relativeSeconds(row.stamp_ns, t0_ns);
    state.p_w_b = vectorAt(row, 0);
    const Eigen::Quaterniond q(row.values[3], row.values[4], row.values[5], row.values[6]);
    if (!(std::abs(q.norm() - 1.0) <= kMaxQuaternionNormError)) {
      fail(table.path, " line ", row.line, " columns 5 to 8 (q_w, q_x, q_y, q_z): norm is ",
           q.norm(), ", must be within ", kMaxQuaternionNormError, " of 1");
    }
    state.R_w_b = q.normalized().toRotationMatrix();
    const bool known = table.columns > kPoseColumns;
    const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kNotComputed);
    state.v_w_b = known ? vectorAt(row, 7) : unknown;
    state.gyro_bias = known ? vectorAt(row, 10) : unknown;
    state.accel_bias = known ? vectorAt(row, 13) : unknown;
    states.push_back(state);
  }
  return states;
}

void readTruth(const std::string& path, RecordedMotion* recording) {
  const CsvTable table = readTable(path, truthFormat(kMinTruthRows), &recording->notes);
  recording->truth = truthStates(table, recording->t0_ns);
  recording->has_velocity_and_bias = table.columns > kPoseColumns;
  if (recording->has_velocity_and_bias) return;
  deriveVelocities(&recording->truth);
  recording->notes.push_back(
      path +
      ": ground truth has no velocities; used are medians of the steps between the positions");
}

void noteImuGaps(const std::string& source, const std::vector<ImuSample>& imu, double max_gap_s,
                 const CsvTable* table, std::vector<std::string>* notes) {
  int gaps = 0;
  std::size_t longest = 1;
  const auto step = [&imu](std::size_t i) { return imu[i].t - imu[i - 1].t; };
  for (std::size_t i = 1; i < imu.size(); ++i) {
    if (step(i) > max_gap_s) ++gaps;
    if (step(i) > step(longest)) longest = i;
  }
  if (gaps == 0) return;
  notes->push_back(
      text(source, " has ", gaps, " IMU gap", gaps > 1 ? "s" : "", " longer than ", max_gap_s,
           " s, the longest ", step(longest), " s ",
           table == nullptr ? "" : text("before line ", table->rows[longest].line, ", "),
           imu[longest - 1].t, " s after the first sample; no window reaches across a gap"));
}

void noteDisorder(const std::string& source, const std::string& things, const Disorder& disorder,
                  std::vector<std::string>* notes) {
  std::string note;
  const auto add = [&](int count, const char* what) {
    if (count > 0) note += text(note.empty() ? "" : ", ", count, ' ', things, what);
  };
  add(disorder.repeated, " with the stamp of another one were discarded");
  add(disorder.out_of_order, " out of order were sorted in");
  add(disorder.unreadable, " that cannot be read or are not finite were discarded");
  if (!note.empty()) notes->push_back(source + ": " + note);
}

std::string lastComponent(const std::string& path_text) {
  std::error_code code;
  fs::path path = fs::absolute(path_text, code).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "a/b/"
  return path.has_filename() ? path.filename().string() : "recorded";
}

}  // namespace slim_init::evaluation
