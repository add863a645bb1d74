// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/row_compensation.h"

#include <algorithm>
#include <vector>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// The camera's rotation about the middle row, R_ck_c(dt), at every sample near one keyframe.
class CameraRotation {
 public:
  CameraRotation(const InitWindow& window, double t, double reach, const Eigen::Vector3d& gyro_bias)
      : R_b_c_(window.calibration().R_b_c), gyro_bias_(gyro_bias) {
    const std::vector<ImuSample>& imu = window.imu();
    const auto before = [](const ImuSample& s, double time) { return s.t < time; };
    auto first = std::lower_bound(imu.begin(), imu.end(), t - reach, before);
    auto last = std::lower_bound(imu.begin(), imu.end(), t + reach, before);
    if (first != imu.begin()) --first;
    if (last != imu.end()) ++last;
    samples_ = {first, last};
    t_ = t;
  }

  // R_ck_c for a row exposed dt after the keyframe. Beyond the samples the last rate holds.
  Eigen::Matrix3d at(double dt) const {
    const double sign = dt < 0.0 ? -1.0 : 1.0;
    Eigen::Matrix3d R_bk_b = Eigen::Matrix3d::Identity();
    double t = t_;
    const double end = t_ + dt;
    // Steps of constant rate between the instants where the samples change.
    while (sign * (end - t) > 0.0) {
      const double next = nextChange(t, sign, end);
      const Eigen::Vector3d rate = rateAt(0.5 * (t + next)) - gyro_bias_;
      R_bk_b = R_bk_b * expSO3(rate * (next - t));
      t = next;
    }
    return R_b_c_.transpose() * R_bk_b * R_b_c_;
  }

 private:
  double nextChange(double t, double sign, double end) const {
    double next = end;
    for (const ImuSample& s : samples_) {
      if (sign * (s.t - t) > 1e-9 && sign * (next - s.t) > 0.0) next = s.t;
    }
    return next;
  }

  Eigen::Vector3d rateAt(double t) const {
    if (samples_.empty()) return gyro_bias_;
    if (t <= samples_.front().t) return samples_.front().gyro;
    for (std::size_t i = 1; i < samples_.size(); ++i) {
      if (t > samples_[i].t) continue;
      const ImuSample &a = samples_[i - 1], &b = samples_[i];
      return a.gyro + (t - a.t) / (b.t - a.t) * (b.gyro - a.gyro);
    }
    return samples_.back().gyro;
  }

  Eigen::Matrix3d R_b_c_;
  Eigen::Vector3d gyro_bias_;
  double t_ = 0.0;
  std::vector<ImuSample> samples_;
};

double reachOf(const InitWindow& window) {
  double reach = 0.0;
  for (const WindowPoint& s : window.pointObservations()) reach = std::max(reach, std::abs(s.row));
  for (int k = 0; k < window.size(); ++k) {
    for (const WindowLine& s : window.linesOfKeyframe(k)) {
      reach = std::max({reach, std::abs(s.start_row), std::abs(s.end_row)});
    }
  }
  return reach * window.calibration().readout_s;
}

void compensate(const std::vector<CameraRotation>& rotation, double readout_s, WindowLine* line) {
  line->start_bearing =
      rotation[line->keyframe].at(line->start_row * readout_s) * line->start_bearing;
  line->end_bearing = rotation[line->keyframe].at(line->end_row * readout_s) * line->end_bearing;
  const Eigen::Vector3d normal = line->start_bearing.cross(line->end_bearing);
  if (normal.norm() > 0.0) line->normal = normal.normalized();
}

}  // namespace

std::shared_ptr<const InitWindow> withRowsCompensated(const InitWindow& window,
                                                      const Eigen::Vector3d& gyro_bias) {
  const double reach = reachOf(window);
  if (!(reach > 0.0)) return nullptr;
  std::vector<CameraRotation> rotation;
  for (const double t : window.times()) rotation.emplace_back(window, t, reach, gyro_bias);

  const double readout_s = window.calibration().readout_s;
  const auto common = std::make_shared<InitWindow::Common>(*window.common_);
  for (WindowLine& line : common->line_observations) compensate(rotation, readout_s, &line);
  for (std::vector<WindowLine>& lines : common->keyframe_lines) {
    for (WindowLine& line : lines) compensate(rotation, readout_s, &line);
  }
  const std::shared_ptr<InitWindow> out(new InitWindow(window));
  out->common_ = common;
  for (WindowPoint& s : out->point_observations_) {
    s.bearing = rotation[s.keyframe].at(s.row * readout_s) * s.bearing;
  }
  return out;
}

}  // namespace slim_init
