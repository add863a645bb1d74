// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/journal.h"

#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kFormat = "slim_init windows 1";

// What a line holds, once for writing and for reading: `field` takes a key and a reference.

template <typename Visitor>
void visit(Visitor& field, Eigen::Vector3d& v) {
  field("x", v.x());
  field("y", v.y());
  field("z", v.z());
}

template <typename Visitor>
void visit(Visitor& field, GateValue& gate) {
  field("name", gate.name);
  field("explanation", gate.explanation);
  field("unit", gate.unit);
  field("value", gate.value);
  field("threshold", gate.threshold);
  field("upper_bound", gate.upper_bound);
  field("passed", gate.passed);
  field("enforced", gate.enforced);
  field("status_if_failed", gate.status_if_failed);
}

template <typename Visitor>
void visit(Visitor& field, StageTime& stage) {
  field("name", stage.name);
  field("ms", stage.ms);
}

template <typename Visitor>
void visit(Visitor& field, WindowMetrics& metrics) {
  field("scale", metrics.scale);
  field("scale_error", metrics.scale_error);
  field("pose_rmse", metrics.pose_rmse);
  field("velocity_rmse", metrics.velocity_rmse);
  field("velocity_vec_rmse", metrics.velocity_vec_rmse);
  field("gravity_error_deg", metrics.gravity_error_deg);
  field("gyro_bias_err_pct", metrics.gyro_bias_err_pct);
  field("gyro_bias_vec_err", metrics.gyro_bias_vec_err);
  field("failure", metrics.failure);
}

template <typename Visitor>
void visit(Visitor& field, PartialMetrics& partial) {
  field("gravity_error_deg", partial.gravity_error_deg);
  field("gyro_bias_err_pct", partial.gyro_bias_err_pct);
  field("gyro_bias_vec_err", partial.gyro_bias_vec_err);
}

template <typename Visitor>
void visit(Visitor& field, DownstreamRecord& downstream) {
  field("ran", downstream.ran);
  field("diverged", downstream.diverged);
  field("message", downstream.message);
  field("seconds", downstream.seconds);
  field("ate", downstream.ate);
  field("scale_error", downstream.scale_error);
}

template <typename Visitor>
void visit(Visitor& field, MethodRecord& record) {
  field("status", record.status);
  field("message", record.message);
  field("attempted", record.attempted);
  field("keyframes", record.keyframes);
  field("data_s", record.data_s);
  field("metrics", record.metrics);
  field("partial", record.partial);
  field("scale_sigma", record.scale_sigma);
  field("gates", record.gates);
  field("point_tracks", record.point_tracks);
  field("line_tracks", record.line_tracks);
  field("solve_ms", record.solve_ms);
  field("solve_cpu_ms", record.solve_cpu_ms);
  field("stages", record.stages);
  field("downstream", record.downstream);
}

template <typename Visitor>
void visit(Visitor& field, Excitation& excitation) {
  field("mean_deviation", excitation.mean_deviation);
  field("quiet_pairs", excitation.quiet_pairs);
  field("excited", excitation.excited);
}

template <typename Visitor>
void visit(Visitor& field, WindowRecord& window) {
  field("trial", window.trial);
  field("t_start", window.t_start);
  field("t_start_ns", window.t_start_ns);
  field("duration_s", window.duration_s);
  field("keyframes", window.keyframes);
  field("excitation", window.excitation);
  field("truth_mismatch", window.truth_mismatch);
  field("p_w_b", window.p_w_b);
  field("methods", window.methods);
}

template <typename T>
constexpr bool kIsPlain = std::is_integral_v<T> || std::is_same_v<T, std::string>;

/// Turns a struct into an object.
struct Writer {
  Json json = Json::object();

  // JSON knows neither NaN nor infinity.
  void operator()(const char* key, double& value) {
    if (std::isfinite(value)) {
      json[key] = value;
    } else if (!std::isnan(value)) {
      json[key] = value > 0.0 ? "inf" : "-inf";
    } else {
      json[key] = nullptr;
    }
  }

  void operator()(const char* key, InitStatus& status) { json[key] = toString(status); }

  template <typename T>
  void operator()(const char* key, std::vector<T>& list) {
    Json& array = json[key] = Json::array();
    for (T& item : list) {
      Writer writer;
      visit(writer, item);
      array.push_back(std::move(writer.json));
    }
  }

  template <typename T>
  void operator()(const char* key, T& value) {
    if constexpr (kIsPlain<T>) {
      json[key] = value;
    } else {
      Writer writer;
      visit(writer, value);
      json[key] = std::move(writer.json);
    }
  }
};

/// The reverse. Throws where a key is missing or its value is none that Writer writes.
struct Reader {
  const Json& json;

  void operator()(const char* key, double& value) {
    const Json& number = json.at(key);
    if (number.is_null()) {
      value = kNotComputed;
    } else if (number.is_string()) {
      value = std::numeric_limits<double>::infinity();
      if (number == "-inf") value = -value;
    } else {
      number.get_to(value);
    }
  }

  void operator()(const char* key, InitStatus& status) {
    const Json& name = json.at(key);
    status = InitStatus::kSuccess;
    while (name != toString(status)) {
      if (status == InitStatus::kNumericalFailure) throw std::domain_error("unknown status");
      status = static_cast<InitStatus>(static_cast<int>(status) + 1);
    }
  }

  template <typename T>
  void operator()(const char* key, std::vector<T>& list) {
    for (const Json& item : json.at(key)) {
      Reader reader{item};
      visit(reader, list.emplace_back());
    }
  }

  template <typename T>
  void operator()(const char* key, T& value) {
    if constexpr (kIsPlain<T>) {
      json.at(key).get_to(value);
    } else {
      Reader reader{json.at(key)};
      visit(reader, value);
    }
  }
};

// Messages may name files, whose bytes need not be text; they are replaced rather than thrown at.
std::string lineOf(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string firstLine(const std::string& fingerprint) {
  return lineOf({{"format", kFormat}, {"fingerprint", fingerprint}});
}

bool readWindow(const std::string& line, WindowRecord* window) {
  try {
    const Json json = Json::parse(line);
    Reader reader{json};
    visit(reader, *window);
    return true;
  } catch (const std::exception&) {  // the JSON library's, or that of an unknown status
    return false;
  }
}

std::string plural(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace

std::string WindowJournal::open(const std::string& file, const std::string& fingerprint,
                                std::string* note) {
  *this = WindowJournal();
  name_ = file;
  note->clear();
  const std::string first = firstLine(fingerprint);

  std::string text;
  {
    std::ifstream old(file, std::ios::binary);
    std::ostringstream buffer;
    if (old.is_open()) buffer << old.rdbuf();
    text = buffer.str();
  }
  const bool kept = text.compare(0, first.size(), first) == 0;
  if (!kept && !text.empty()) {
    *note = file + " is of a run with other data, options or program, so it is begun anew";
  }
  // Behind the last line end stands what an interruption left.
  const std::size_t whole = text.rfind('\n') + 1;
  if (kept) {
    int unreadable = whole < text.size() ? 1 : 0;
    std::istringstream lines(text.substr(first.size(), whole - first.size()));
    for (std::string line; std::getline(lines, line);) {
      WindowRecord window;
      if (readWindow(line, &window)) {
        records_[window.trial] = std::move(window);
      } else {
        ++unreadable;
      }
    }
    if (unreadable > 0) {
      *note = plural(unreadable, "line") + " of " + file + " cut short or not readable, dropped";
    }
    std::error_code code;
    if (whole < text.size()) fs::resize_file(file, whole, code);
    if (code) return file + " cannot be written: " + code.message();
  }

  file_.open(file, std::ios::binary | (kept ? std::ios::app : std::ios::trunc));
  if (!kept) file_ << first << std::flush;
  return file_.good() ? "" : file + " cannot be written";
}

const WindowRecord* WindowJournal::find(int trial) const {
  const auto found = records_.find(trial);
  return found == records_.end() ? nullptr : &found->second;
}

std::string WindowJournal::append(const WindowRecord& record) {
  WindowRecord& copy = records_[record.trial] = record;
  Writer writer;
  visit(writer, copy);
  file_ << lineOf(writer.json) << std::flush;
  return file_.good() ? "" : name_ + " cannot be written";
}

}  // namespace slim_init::evaluation
