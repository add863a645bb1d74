// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <cmath>

#include "checks.h"
#include "reference_so3.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::evaluation {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2] in one g

double medianAccelNorm(const std::vector<ImuSample>& imu) {
  std::vector<double> norms;
  for (const ImuSample& sample : imu) norms.push_back(sample.accel.norm());
  return median(norms);
}

/// Whether accelerations are in g: their norm is then about one.
bool isInG(double accel_norm) { return accel_norm > 0.8 && accel_norm < 1.25; }

/// Factor from the unit of the samples to m/s^2.
double accelFactor(const std::vector<ImuSample>& imu) {
  return isInG(medianAccelNorm(imu)) ? kStandardGravity : 1.0;
}

/// Norm of the mean specific force over windows of 5 s, rotated by the gyro into the body frame at
/// the start of each window: accelerations average out, gravity does not. Median over the windows;
/// NaN where the recording is shorter than one. `scale`: gyro over true rate; `bias` [rad/s].
double turnedGravity(const std::vector<ImuSample>& imu, double scale, const Eigen::Vector3d& bias) {
  constexpr double kWindow = 5.0;      // [s]
  constexpr double kLeastShare = 0.9;  // of a window that has to hold samples
  std::vector<double> norms;
  std::size_t k = 0;
  while (k + 1 < imu.size()) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const double begin = imu[k].t;
    for (; k + 1 < imu.size() && imu[k + 1].t <= begin + kWindow; ++k) {
      const double dt = imu[k + 1].t - imu[k].t;
      const Eigen::Vector3d step = (0.5 * (imu[k].gyro + imu[k + 1].gyro) / scale - bias) * dt;
      sum += R * reference::expSo3(0.5 * step) * (0.5 * dt * (imu[k].accel + imu[k + 1].accel));
      R *= reference::expSo3(step);
    }
    if (imu[k].t - begin < kLeastShare * kWindow) {
      if (k + 1 < imu.size() && imu[k].t == begin) ++k;  // a gap longer than the window
      continue;
    }
    norms.push_back(sum.norm() / (imu[k].t - begin));
  }
  return median(norms);
}

/// Scatter of a value over windows of `window_s`: root mean square deviation of its means over 0.2
/// s from their mean; median over the windows. The short means remove vibration, which is no
/// motion. NaN without a whole window.
double scatterOverWindows(const std::vector<ImuSample>& imu, Eigen::Vector3d ImuSample::*value,
                          double window_s) {
  constexpr double kMeanOver = 0.2;    // [s]
  constexpr double kLeastShare = 0.8;  // of a window that has to hold samples
  std::vector<double> scatters;
  std::size_t k = 0;
  while (k < imu.size()) {
    const double begin = imu[k].t;
    double last = begin;
    std::vector<Eigen::Vector3d> means;
    while (k < imu.size() && imu[k].t <= begin + window_s) {
      const double slot = imu[k].t;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
      for (; k < imu.size() && imu[k].t < slot + kMeanOver; ++k, ++count) {
        sum += imu[k].*value;
        last = imu[k].t;
      }
      means.push_back(sum / count);
    }
    if (last - begin < kLeastShare * window_s) continue;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& m : means) center += m / static_cast<double>(means.size());
    double sum2 = 0.0;
    for (const Eigen::Vector3d& m : means) sum2 += (m - center).squaredNorm();
    scatters.push_back(std::sqrt(sum2 / static_cast<double>(means.size())));
  }
  return median(scatters);
}

void checkGravity(const DoctorData& data, const RotationAlignment& alignment,
                  const DoctorOptions& options, Findings* findings) {
  const double g = data.calibration.gravity_magnitude;
  const double norm = medianAccelNorm(data.imu);
  const double factor = accelFactor(data.imu);
  const bool turned = alignment.status == AlignmentStatus::kSolved &&
                      alignment.correlation >= options.min_correlation;
  double measured = factor * norm;
  if (turned || alignment.status == AlignmentStatus::kTooLittleTurn) {
    const double over_windows =
        factor * turnedGravity(data.imu, turned ? alignment.gyro_scale : 1.0,
                               turned ? alignment.gyro_bias : alignment.gyro_mean);
    if (std::isfinite(over_windows)) measured = over_windows;
  }

  Finding& u = add(findings, "accel_unit", Severity::kOk, norm, "m/s^2");
  u.min = g * (1.0 - options.gravity.fail);
  u.max = g * (1.0 + options.gravity.fail);
  u.message = "The accelerometer reads " + number(norm) + " (median of its norm)";
  if (isInG(norm)) {
    u.severity = Severity::kError;
    u.message += ": that is gravity in g, not in m/s^2";
    u.advice = "Multiply linear_acceleration by " + number(kStandardGravity, 6) +
               " in the driver or its settings.";
  } else if (norm < 0.5 * g) {
    u.severity = Severity::kError;
    u.message += ", far less than gravity";
    u.advice =
        "Gravity has been removed from the data, or the unit is another one: use the raw "
        "accelerometer in m/s^2.";
  } else if (norm > 2.0 * g) {
    u.severity = Severity::kError;
    u.message += ", far more than gravity";
    u.advice = "Convert linear_acceleration to m/s^2; raw counts and milli-g look like this.";
  }
  if (u.severity != Severity::kOk && factor == 1.0) return;  // the unit of gravity is unknown

  const double off = std::abs(measured / g - 1.0);
  Finding& f = add(findings, "gravity", severityAbove(off, options.gravity), measured, "m/s^2");
  f.min = g * (1.0 - options.gravity.warn);
  f.max = g * (1.0 + options.gravity.warn);
  f.message =
      "The measured gravity is " + number(measured) + " m/s^2, the configured one " + number(g);
  advise(&f,
         "Calibrate the accelerometer's scale and bias at rest; if gravity is correct at rest, "
         "check that gyro and accelerometer have the same axes.");
}

void checkGyroRange(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  std::vector<double> norms;
  for (const ImuSample& sample : data.imu) norms.push_back(sample.gyro.norm());
  const double rate = norms.empty() ? kNotComputed : quantile(norms, 0.99);
  const Severity severity = rate > options.max_gyro_rate ? Severity::kError : Severity::kOk;
  Finding& f = add(findings, "gyro_range", severity, rate, "rad/s");
  f.max = options.max_gyro_rate;
  f.message = "The gyro reads up to " + number(rate) + " rad/s (99 % quantile)";
  if (severity != Severity::kOk) {
    f.message += ", more than a gyro of 2000 deg/s can measure";
    f.advice = "Is it in deg/s? Multiply angular_velocity by 0.0174533 in the driver.";
  }
}

void checkGyroBias(const RotationAlignment& alignment, const DoctorOptions& options,
                   Findings* findings) {
  const bool still = alignment.pairs >= rotation_alignment::kMinPairs &&
                     alignment.camera_rate < 0.5 * rotation_alignment::kMinRate;
  const bool solved = alignment.status == AlignmentStatus::kSolved &&
                      alignment.correlation >= options.min_correlation;
  Finding& f = add(findings, "gyro_bias", Severity::kNotChecked, kNotComputed, "rad/s");
  f.max = options.gyro_still.warn;
  if (!still && !solved) {
    f.message = "Gyro bias not checked: the images do not determine the rotation of the camera";
    return;
  }
  f.value = still ? alignment.gyro_mean.norm() : alignment.gyro_bias.norm();
  f.severity = severityAbove(f.value, options.gyro_still);
  f.message = "The gyro bias is " + number(f.value) + " rad/s" +
              (still ? ", its mean while the camera does not turn" : "");
  advise(&f,
         "No MEMS gyro has a bias this large. A gyro in deg/s looks like this (multiply by "
         "0.0174533); otherwise calibrate it at rest.");
}

}  // namespace

void checkImuValues(const DoctorData& data, const RotationAlignment& alignment,
                    const DoctorOptions& options, Findings* findings) {
  if (data.imu.empty()) return;
  checkGravity(data, alignment, options, findings);
  checkGyroRange(data, options, findings);
  checkGyroBias(alignment, options, findings);
}

void checkExcitation(const DoctorData& data, const RotationAlignment& alignment,
                     const DoctorOptions& options, Findings* findings) {
  if (data.imu.empty()) return;
  const double accel =
      accelFactor(data.imu) * scatterOverWindows(data.imu, &ImuSample::accel, options.window_s);
  const bool accelerates = accel >= options.min_acceleration;
  Finding& a =
      add(findings, "acceleration", accelerates ? Severity::kOk : Severity::kNote, accel, "m/s^2");
  a.min = options.min_acceleration;
  a.message = "The specific force scatters by " + number(accel) + " m/s^2 over " +
              number(options.window_s) + " s (median)";
  if (!std::isfinite(accel)) {
    a.severity = Severity::kNotChecked;
    a.message = "The recording is shorter than the window of " + number(options.window_s) + " s";
  }
  const double turn =
      scatterOverWindows(data.imu, &ImuSample::gyro, options.window_s) /
      (std::isfinite(alignment.gyro_scale) && alignment.gyro_scale > 10.0 ? alignment.gyro_scale
                                                                          : 1.0);
  const bool turns = turn >= rotation_alignment::kMinRate;
  Finding& r =
      add(findings, "turning", turns ? Severity::kOk : Severity::kNote, kDegPerRad * turn, "deg/s");
  r.min = kDegPerRad * rotation_alignment::kMinRate;
  r.message = "The angular rate scatters by " + number(kDegPerRad * turn) + " deg/s over " +
              number(options.window_s) + " s (median)";
  if (!std::isfinite(turn)) {
    r.severity = Severity::kNotChecked;
    r.message = "The recording is shorter than the window of " + number(options.window_s) + " s";
  }

  constexpr double kStandingPxPerS = 3.0;  // flow below which the rig stands still [px/s]
  if (accelerates || !(alignment.flow_px_per_s < kStandingPxPerS)) {
    if (a.severity == Severity::kNote) {
      a.message += ", too little to determine the scale";
      a.advice = "Change velocity more while it initializes: up and down, back and forth.";
    }
    return;
  }
  a.message +=
      " and the image moves by " + number(alignment.flow_px_per_s) + " px/s: the rig stands still";
  a.advice =
      "This is no fault, but no monocular initializer can determine the scale until the rig "
      "moves: lift it and move it back and forth.";
}

}  // namespace slim_init::evaluation
