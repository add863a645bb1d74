// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "start_record.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "slim_init/text.h"

namespace slim_init::vins_adapter {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

// Length of the path through the window [m]: its ratio between two windows is that of their scales.
double pathLength(const HostWindow& window) {
  if (window.states.empty()) return kNotComputed;
  double length = 0.0;
  for (std::size_t i = 1; i < window.states.size(); ++i) {
    length += (window.states[i].P - window.states[i - 1].P).norm();
  }
  return length;
}

double speed(const HostWindow& window) {
  return window.states.empty() ? kNotComputed : window.states.back().V.norm();
}

// Angle between the two directions of gravity in the newest body frame [deg].
double tiltDifference(const HostWindow& a, const HostWindow& b) {
  if (a.states.empty() || b.states.empty()) return kNotComputed;
  const Eigen::Vector3d up_a = a.states.back().R.row(2).transpose();
  const Eigen::Vector3d up_b = b.states.back().R.row(2).transpose();
  return kDegrees * std::atan2(up_a.cross(up_b).norm(), up_a.dot(up_b));
}

double gyroBiasDifference(const HostWindow& a, const HostWindow& b) {
  if (a.states.empty() || b.states.empty()) return kNotComputed;
  return (a.states.back().Bg - b.states.back().Bg).norm();
}

std::string number(double value, int precision, bool fixed = false) {
  if (!std::isfinite(value)) return "";
  return fixed ? roundedText(precision, std::fixed, value) : roundedText(precision, value);
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += c == '\n' ? ' ' : c;
  }
  return result + "\"";
}

}  // namespace

std::string startRecordHeader() {
  return "stamp_s,data_s,mode,action,slim_status,slim_ms,slim_scale_sigma,slim_path_m,"
         "slim_speed_mps,stock_tried,stock_success,stock_ms,stock_path_m,stock_speed_mps,"
         "path_ratio_stock_to_slim,tilt_difference_deg,gyro_bias_difference_rps,message";
}

std::string startRecordRow(HostMode mode, const std::string& action, const HostResult& answer,
                           const StockStart* stock) {
  const StockStart none;
  const StockStart& host = stock == nullptr ? none : *stock;
  const std::vector<std::string> fields = {
      number(answer.stamp, 9, true),
      number(answer.data_s, 3, true),
      toString(mode),
      action,
      toString(answer.result.status),
      number(answer.solve_ms, 4),
      number(answer.result.scale_sigma, 4),
      number(pathLength(answer.window), 6),
      number(speed(answer.window), 6),
      stock == nullptr ? ""
      : host.tried     ? "1"
                       : "0",
      stock == nullptr ? ""
      : host.success   ? "1"
                       : "0",
      number(host.ms, 4),
      number(pathLength(host.window), 6),
      number(speed(host.window), 6),
      number(pathLength(host.window) / pathLength(answer.window), 6),
      number(tiltDifference(host.window, answer.window), 4),
      number(gyroBiasDifference(host.window, answer.window), 4),
      quoted(answer.message)};
  std::string row;
  for (std::size_t i = 0; i < fields.size(); ++i) row += (i > 0 ? "," : "") + fields[i];
  return row;
}

}  // namespace slim_init::vins_adapter
