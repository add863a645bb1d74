// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>

#include "checks.h"
#include "imu/preintegration.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2] in one g

double medianAccelNorm(const std::vector<ImuSample>& imu) {
  std::vector<double> norms;
  for (const ImuSample& sample : imu) norms.push_back(sample.accel.norm());
  return median(norms);
}

/// Factor from the unit of the samples, in which gravity is `gravity`, to m/s^2.
double accelFactor(double gravity) {
  return gravity > 0.8 && gravity < 1.25 ? kStandardGravity : 1.0;
}

/// Norm of the mean specific force over windows of 5 s, rotated by the gyro into the body frame at
/// the start of each window: accelerations average out, gravity does not. Median over the windows;
/// NaN where the recording is shorter than one. `scale`: gyro over true rate; `bias` [rad/s], after
/// the scale.
double turnedGravity(std::vector<ImuSample> imu, double scale, const Eigen::Vector3d& bias) {
  constexpr double kWindow = 5.0;      // [s]
  constexpr double kLeastShare = 0.9;  // of a window that has to hold samples
  for (ImuSample& sample : imu) sample.gyro /= scale;
  std::vector<double> norms;
  for (auto first = imu.begin(); first != imu.end();) {
    const auto end =
        std::upper_bound(first, imu.end(), first->t + kWindow,
                         [](double t, const ImuSample& sample) { return t < sample.t; });
    const auto last = std::prev(end);
    const bool whole = last->t - first->t >= kLeastShare * kWindow;
    if (whole) {
      const Preintegration turned =
          preintegrate(imu, first->t, last->t, {bias, Eigen::Vector3d::Zero()}, ImuNoise(),
                       PreintegrationParts::kMean);
      norms.push_back(turned.dv.norm() / turned.dt);
    }
    first = whole ? last : end;
  }
  return median(norms);
}

/// Whether camera and gyro measure the same motion.
bool isSolved(const RotationAlignment& alignment, const DoctorOptions& options) {
  return alignment.status == AlignmentStatus::kSolved &&
         alignment.correlation >= options.min_correlation;
}

/// In the unit of the samples. The median norm, a substitute, is the motion's if gravity is
/// removed.
double measuredGravity(const DoctorData& data, const RotationAlignment& alignment,
                       const DoctorOptions& options) {
  const bool turned = isSolved(alignment, options);
  if (turned || alignment.status == AlignmentStatus::kTooLittleTurn) {
    const double over_windows = turnedGravity(data.imu, turned ? alignment.gyro_scale : 1.0,
                                              turned ? alignment.gyro_bias : alignment.gyro_mean);
    if (std::isfinite(over_windows)) return over_windows;
  }
  return medianAccelNorm(data.imu);
}

void checkGravity(const DoctorData& data, const RotationAlignment& alignment,
                  const DoctorOptions& options, Findings* findings) {
  const double g = data.calibration.gravity_magnitude;
  const double norm = medianAccelNorm(data.imu);
  const double in_data = measuredGravity(data, alignment, options);
  const double factor = accelFactor(in_data), measured = factor * in_data;

  Finding& u = add(findings,
                   {"accel_unit", Severity::kOk, norm, g * (1.0 - options.gravity.fail),
                    g * (1.0 + options.gravity.fail), "m/s^2"},
                   "The accelerometer reads " + number(norm) + " (median of its norm)");
  const auto isWrong = [&u](const char* how, const std::string& advice) {
    u.severity = Severity::kError;
    u.message += how;
    u.advice = advice;
  };
  if (factor != 1.0) {
    isWrong(": that is gravity in g, not in m/s^2", "Multiply linear_acceleration by " +
                                                        number(kStandardGravity, 6) +
                                                        " in the driver or its settings.");
  } else if (norm < 0.5 * g) {
    isWrong(", far less than gravity",
            "Gravity has been removed from the data, or the unit is another one: use the raw "
            "accelerometer in m/s^2.");
  } else if (norm > 2.0 * g) {
    isWrong(", far more than gravity",
            "Convert linear_acceleration to m/s^2; raw counts and milli-g look like this.");
  }
  if (u.severity != Severity::kOk && factor == 1.0) return;  // the unit of gravity is unknown

  add(findings,
      {"gravity", severityAbove(std::abs(measured / g - 1.0), options.gravity), measured,
       g * (1.0 - options.gravity.warn), g * (1.0 + options.gravity.warn), "m/s^2"},
      "The measured gravity is " + number(measured) + " m/s^2, the configured one " + number(g),
      "Calibrate the accelerometer's scale and bias at rest; if gravity is correct at rest, check "
      "that gyro and accelerometer have the same axes.");
}

void checkGyroRange(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  std::vector<double> norms;
  for (const ImuSample& sample : data.imu) norms.push_back(sample.gyro.norm());
  const double rate = quantile(norms, 0.99);
  Finding& f = add(
      findings, atMost("gyro_range", rate, {options.max_gyro_rate, options.max_gyro_rate}, "rad/s"),
      "The gyro reads up to " + number(rate) + " rad/s (99 % quantile)",
      "Is it in deg/s? Multiply angular_velocity by 0.0174533 in the driver.");
  if (f.severity != Severity::kOk) f.message += ", more than a gyro of 2000 deg/s can measure";
}

void checkGyroBias(const RotationAlignment& alignment, const DoctorOptions& options,
                   Findings* findings) {
  const bool still = alignment.pairs >= rotation_alignment::kMinPairs &&
                     alignment.camera_rate < 0.5 * rotation_alignment::kMinRate;
  if (!still && !isSolved(alignment, options)) {
    Finding f = notChecked("gyro_bias", "rad/s");
    f.max = options.gyro_still.warn;
    add(findings, f,
        "Gyro bias not checked: the images do not determine the rotation of the camera");
    return;
  }
  const double bias = still ? alignment.gyro_mean.norm() : alignment.gyro_bias.norm();
  add(findings, atMost("gyro_bias", bias, options.gyro_still, "rad/s"),
      "The gyro bias is " + number(bias) + " rad/s" +
          (still ? ", its mean while the camera does not turn" : ""),
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
                     const WindowEstimates& answers, const DoctorOptions& options,
                     Findings* findings) {
  if (data.imu.empty()) return;
  const auto check = [findings](const char* name, const char* what, double value, double least,
                                const char* unit, const char* why_unknown) -> Finding& {
    const Severity known = value >= least ? Severity::kOk : Severity::kNote;
    const bool unknown = std::isnan(value);
    return add(findings,
               {name, unknown ? Severity::kNotChecked : known, value, least, kNotComputed, unit},
               unknown ? text("The ", what, " is not known: ", why_unknown)
                       : text("The ", what, " scatters by ", number(value), ' ', unit));
  };
  const bool turns_in_deg = alignment.gyro_scale > 10.0;
  const double turn = alignment.gyro_rate / (turns_in_deg ? alignment.gyro_scale : 1.0);
  check("turning", "angular rate", kDegPerRad * turn, kDegPerRad * rotation_alignment::kMinRate,
        "deg/s", "too few images and IMU samples belong together");
  const double least = options.initializer.gates.min_excitation;
  Finding& a = check("acceleration", "specific force in the windows",
                     accelFactor(measuredGravity(data, alignment, options)) * answers.excitation,
                     least, "m/s^2", "no window was solved up to its motion, see starts");
  if (std::isnan(a.value)) return;
  const bool accelerates = a.value >= least;

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
