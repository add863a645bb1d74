// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "calibration_advice.h"

#include <cmath>

#include "slim_init/host_health/imu_propagation.h"

namespace slim_init::vins_adapter {
namespace {

// calibrationLines() asks for two standard deviations. These are asked at every window again, and
// the scatter of a few is itself uncertain: three.
constexpr double kLooksAgain = 1.5 * 1.5;

using host_health::expOf;
using host_health::logOf;

}  // namespace

std::string CalibrationAdvice::add(double stamp, const OptionalCalibration& found) {
  if (given_ || !found.has_value() || std::abs(stamp - newest_) < kApart_s) return "";
  newest_ = stamp;
  const Calibration& old = file_.calibration;
  Window window;
  window.found = *found;
  window.error << logOf(old.R_b_c.transpose() * found->R_b_c), found->t_b_c - old.t_b_c,
      found->td - old.td, found->readout_s - old.readout_s;
  windows_.push_back(window);
  if (windows_.size() > kKept) windows_.pop_front();
  if (static_cast<int>(windows_.size()) < kWindows) return "";
  const std::string lines = host_health::calibrationLines(file_, mean());
  // Later windows may know better.
  if (lines.empty()) return "";
  given_ = true;
  return std::to_string(windows_.size()) +
         " windows agree on a calibration that differs from the file; lines for it:\n" + lines;
}

// Its covariance: the larger of the scatter and of what the windows say of themselves, per window.
CalibrationEstimate CalibrationAdvice::mean() const {
  const auto n = static_cast<double>(windows_.size());
  Error sum = Error::Zero(), claimed = Error::Zero(), scatter = Error::Zero();
  for (const Window& window : windows_) {
    sum += window.error;
    claimed += window.found.covariance.diagonal() / n;
  }
  const Error error = sum / n;
  for (const Window& window : windows_) {
    scatter += (window.error - error).cwiseAbs2() / (n - 1.0);
  }
  const Calibration& old = file_.calibration;
  CalibrationEstimate result;
  result.R_b_c = old.R_b_c * expOf(error.head<3>());
  result.t_b_c = old.t_b_c + error.segment<3>(3);
  result.td = old.td + error(6);
  result.readout_s = old.readout_s + error(7);
  result.covariance = Eigen::MatrixXd((kLooksAgain * scatter.cwiseMax(claimed) / n).asDiagonal());
  return result;
}

}  // namespace slim_init::vins_adapter
