// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/row_compensation.h"

#include <vector>

#include "geometry/so3.h"
#include "imu/preintegration.h"

namespace slim_init {
namespace {

// The camera `dt` after the keyframe at `t`, R_ck_c. Beyond the samples the last rate holds.
Eigen::Matrix3d cameraRotation(const InitWindow& window, double t, double dt,
                               const Eigen::Vector3d& gyro_bias) {
  const std::vector<ImuSample>& imu = window.imu();
  const auto between = [&](double from, double to) {
    return preintegrate(imu, from, to, {gyro_bias, Eigen::Vector3d::Zero()}, ImuNoise(),
                        PreintegrationParts::kRotation)
        .dR;
  };
  const double end = std::clamp(t + dt, imu.front().t, imu.back().t);
  Eigen::Matrix3d R_bk_b = Eigen::Matrix3d::Identity();
  if (end > t) R_bk_b = between(t, end);
  if (end < t) R_bk_b = between(end, t).transpose();
  const Eigen::Vector3d rate = (dt < 0.0 ? imu.front() : imu.back()).gyro - gyro_bias;
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
  return R_b_c.transpose() * R_bk_b * expSO3(rate * (t + dt - end)) * R_b_c;
}

}  // namespace

std::shared_ptr<const InitWindow> withRowsCompensated(const InitWindow& window,
                                                      const Eigen::Vector3d& gyro_bias) {
  const double readout_s = window.calibration().readout_s;
  if (!(readout_s > 0.0)) return nullptr;
  const auto turned = [&](int keyframe, double row, const Eigen::Vector3d& bearing) {
    return Eigen::Vector3d(
        cameraRotation(window, window.times()[keyframe], row * readout_s, gyro_bias) * bearing);
  };
  const auto compensate = [&](WindowLine* line) {
    line->start_bearing = turned(line->keyframe, line->start_row, line->start_bearing);
    line->end_bearing = turned(line->keyframe, line->end_row, line->end_bearing);
    const Eigen::Vector3d normal = line->start_bearing.cross(line->end_bearing);
    if (normal.norm() > 0.0) line->normal = normal.normalized();
  };
  const auto common = std::make_shared<InitWindow::Common>(*window.common_);
  for (WindowLine& line : common->line_observations) compensate(&line);
  for (std::vector<WindowLine>& lines : common->keyframe_lines) {
    for (WindowLine& line : lines) compensate(&line);
  }
  const std::shared_ptr<InitWindow> out(new InitWindow(window));
  out->common_ = common;
  for (WindowPoint& s : out->point_observations_) s.bearing = turned(s.keyframe, s.row, s.bearing);
  return out;
}

}  // namespace slim_init
