// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "start_record.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
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

// Angle between the two directions of gravity in the body [deg].
double tiltDifference(const HostState& a, const HostState& b) {
  const Eigen::Vector3d up_a = a.R.row(2), up_b = b.R.row(2);
  return kDegrees * std::atan2(up_a.cross(up_b).norm(), up_a.dot(up_b));
}

std::string number(double value, int precision, bool fixed = false) {
  if (!std::isfinite(value)) return "";
  return fixed ? roundedText(precision, std::fixed, value) : roundedText(precision, value);
}

std::string quoted(std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  return text(std::quoted(message, '"', '"'));  // quotes in it are doubled
}

}  // namespace

std::string startRecordHeader() {
  return "stamp_s,data_s,mode,action,slim_status,slim_ms,slim_scale_sigma,slim_path_m,"
         "slim_speed_mps,stock_tried,stock_success,stock_ms,stock_path_m,stock_speed_mps,"
         "path_ratio_stock_to_slim,tilt_difference_deg,gyro_bias_difference_rps,message";
}

std::string startRecordRow(HostMode mode, const std::string& action, const HostResult& answer,
                           const StockStart* stock) {
  const HostWindow &slim = answer.window, other = stock == nullptr ? HostWindow() : stock->window;
  const auto flag = [stock](bool StockStart::*of) {
    return stock == nullptr ? "" : stock->*of ? "1" : "0";
  };
  double tilt = kNotComputed, gyro_bias = kNotComputed;
  if (!slim.states.empty() && !other.states.empty()) {
    tilt = tiltDifference(other.states.back(), slim.states.back());
    gyro_bias = (other.states.back().Bg - slim.states.back().Bg).norm();
  }
  const std::vector<std::string> fields = {number(answer.stamp, 9, true),
                                           number(answer.data_s, 3, true),
                                           toString(mode),
                                           action,
                                           toString(answer.result.status),
                                           number(answer.solve_ms, 4),
                                           number(answer.result.scale_sigma, 4),
                                           number(pathLength(slim), 6),
                                           number(speed(slim), 6),
                                           flag(&StockStart::tried),
                                           flag(&StockStart::success),
                                           number(stock == nullptr ? kNotComputed : stock->ms, 4),
                                           number(pathLength(other), 6),
                                           number(speed(other), 6),
                                           number(pathLength(other) / pathLength(slim), 6),
                                           number(tilt, 4),
                                           number(gyro_bias, 4),
                                           quoted(answer.message)};
  std::string row;
  for (std::size_t i = 0; i < fields.size(); ++i) row += (i > 0 ? "," : "") + fields[i];
  return row;
}

}  // namespace slim_init::vins_adapter
