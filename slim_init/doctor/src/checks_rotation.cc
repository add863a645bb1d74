// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "checks.h"
#include "reference_so3.h"

namespace slim_init::evaluation {
namespace {

const char kHowToTurn[] =
    "Record twenty seconds in which it is turned by hand about all three axes before a scene with "
    "texture.";

/// What rests on the agreement of both rotations, where that could not be had.
void noneChecked(Findings* findings) {
  const auto notChecked = [findings](const char* check, const char* unit, const char* what) {
    add(findings, check, Severity::kNotChecked, kNotComputed, unit).sentence =
        std::string(what) + " not checked: see rotation_agreement";
  };
  notChecked("gyro_scale", "", "Scale of the gyro");
  notChecked("time_offset", "ms", "Time offset");
  notChecked("extrinsic_rotation", "deg", "Extrinsic rotation");
}

/// "z" or "-0.71, 0.00, 0.71"
std::string axisText(const Eigen::Vector3d& axis) {
  const char* names[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis(k)) > 0.99) return std::string("axis ") + names[k];
  }
  return "axis (" + number(axis.x(), 2) + ", " + number(axis.y(), 2) + ", " + number(axis.z(), 2) +
         ")";
}

std::string matrixText(const Eigen::Matrix3d& R) {
  std::string text = "[";
  for (int k = 0; k < 9; ++k) {
    char entry[32];
    std::snprintf(entry, sizeof(entry), "%s%.5f", k > 0 ? ", " : "", R(k / 3, k % 3));
    text += entry;
  }
  return text + "]";
}

void checkScale(const RotationAlignment& a, const DoctorOptions& options, Findings* findings) {
  const double off = std::abs(a.gyro_scale - 1.0);
  const bool known = off > options.significance * a.gyro_scale_sigma;
  Finding& f =
      add(findings, "gyro_scale", known ? severityAbove(off, options.gyro_scale) : Severity::kOk,
          a.gyro_scale, "");
  f.min = 1.0 - options.gyro_scale.warn;
  f.max = 1.0 + options.gyro_scale.warn;
  f.sentence = "The gyro turns " + number(a.gyro_scale, 4) + " times (+- " +
               number(a.gyro_scale_sigma, 2) + ") as fast as the camera";
  if (f.severity == Severity::kOk) {
    if (a.gyro_scale_sigma > 0.5 * options.gyro_scale.warn) {
      f.severity = Severity::kNotChecked;
      f.sentence += ": too uncertain to check";
      f.advice = kHowToTurn;
    }
    return;
  }
  if (a.gyro_scale > 0.8 * kDegPerRad && a.gyro_scale < 1.25 * kDegPerRad) {
    f.sentence += ": it is in deg/s";
    f.advice = "Multiply angular_velocity by 0.0174533 in the driver or its settings.";
  } else {
    f.advice =
        "Check the focal length (a wrong one changes how far the camera seems to turn), the "
        "image size it was calibrated at, and the unit and range of the gyro.";
  }
}

void checkTimeOffset(const DoctorData& data, const RotationAlignment& a,
                     const DoctorOptions& options, Findings* findings) {
  const double difference = a.td - data.calibration.td;
  const bool known = std::abs(difference) > options.significance * a.td_sigma;
  Finding& f =
      add(findings, "time_offset",
          known ? severityAbove(std::abs(difference), options.time_offset_s) : Severity::kOk,
          1e3 * a.td, "ms");
  f.min = 1e3 * (data.calibration.td - options.time_offset_s.warn);
  f.max = 1e3 * (data.calibration.td + options.time_offset_s.warn);
  f.sentence = "The time offset td measures " + number(1e3 * a.td) + " ms (+- " +
               number(1e3 * a.td_sigma, 2) + "), configured are " +
               number(1e3 * data.calibration.td) + " ms";
  if (f.severity != Severity::kOk) {
    f.advice = "Set td: " + number(a.td) +
               " (t_imu = t_image + td), or correct the stamps in the "
               "driver of camera or IMU.";
  } else if (a.td_sigma > 0.5 * options.time_offset_s.warn) {
    f.severity = Severity::kNotChecked;
    f.sentence += ": too uncertain to check";
    f.advice = "Record twenty seconds in which it is turned to and fro quickly, by hand.";
  }
}

/// The measured rotation against the configured one, in the camera's frame.
struct ExtrinsicDifference {
  Eigen::Matrix3d R_b_c;       ///< measured; what the motion leaves open as configured
  Eigen::Vector3d difference;  ///< Log(configured^T measured) [rad]
  double sigmas = 0.0;         ///< its length in standard deviations
  double sigma = 0.0;          ///< largest standard deviation [rad]
  int open = 0;                ///< axes about which the motion says nothing
};

ExtrinsicDifference extrinsicDifference(const Eigen::Matrix3d& configured,
                                        const RotationAlignment& a, double floor) {
  constexpr double kOpen = 0.1;  // [rad]; what is known is known better by far
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      a.R_covariance + floor * floor * Eigen::Matrix3d::Identity());
  ExtrinsicDifference d;
  d.R_b_c = a.R_b_c;
  d.sigma = std::sqrt(axes.eigenvalues()(2));
  d.open = static_cast<int>((axes.eigenvalues().array() > kOpen * kOpen).count());
  if (d.open == 1) {
    // Turns about one axis fit with any rotation about it: take the one nearest to the configured.
    constexpr int kSteps = 3600;
    const Eigen::Vector3d axis = axes.eigenvectors().col(2);
    double nearest = -4.0;
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::Matrix3d R =
          a.R_b_c * reference::expSo3(2.0 * 3.14159265358979 * step / kSteps * axis);
      const double trace = (configured.transpose() * R).trace();
      if (trace <= nearest) continue;
      nearest = trace;
      d.R_b_c = R;
    }
  }
  d.difference = reference::logSo3(configured.transpose() * d.R_b_c);
  Eigen::Vector3d along = axes.eigenvectors().transpose() * d.difference;
  if (d.open == 1) along(2) = 0.0;
  d.sigmas = std::sqrt((along.array().square() / axes.eigenvalues().array()).sum());
  return d;
}

void checkExtrinsic(const DoctorData& data, const RotationAlignment& a,
                    const DoctorOptions& options, Findings* findings) {
  const ExtrinsicDifference d =
      extrinsicDifference(data.calibration.R_b_c, a, options.extrinsic_floor_deg / kDegPerRad);
  const double angle = kDegPerRad * d.difference.norm();
  const bool known = d.open < 2 && d.sigmas > options.significance;
  Finding& f =
      add(findings, "extrinsic_rotation",
          known ? severityAbove(angle, options.extrinsic_deg) : Severity::kOk, angle, "deg");
  f.max = options.extrinsic_deg.warn;
  f.sentence = "The camera's rotation to the IMU is " + number(angle) + " deg ";
  if (d.open == 0) f.sentence += "(+- " + number(kDegPerRad * d.sigma, 2) + ") ";
  f.sentence += "off the one configured";
  if (d.open > 0) f.sentence += " or more: it turns about one axis only";
  if (f.severity == Severity::kOk) {
    if (kDegPerRad * d.sigma > 0.5 * options.extrinsic_deg.warn) {
      f.severity = Severity::kNotChecked;
      f.sentence += ": too uncertain to check to " + number(options.extrinsic_deg.warn) + " deg";
      f.advice = kHowToTurn;
    }
    return;
  }
  f.sentence += ", about the camera's " + axisText(d.difference.normalized());
  f.advice = "extrinsicRotation is camera to IMU (p_imu = R p_cam). Measured here: " +
             matrixText(d.R_b_c) + ". ";
  f.advice += f.severity == Severity::kError
                  ? "Look for the transposed matrix or other axes of IMU or camera."
                  : "A calibration of the other camera of a stereo pair looks like this; check "
                    "that intrinsics and extrinsic are those of this camera.";
}

}  // namespace

void checkRotation(const DoctorData& data, const RotationAlignment& a, const DoctorOptions& options,
                   Findings* findings) {
  if (a.pairs >= options.alignment.min_pairs) {
    Finding& f = add(findings, "epipolar", severityAbove(a.residual_px, options.epipolar_px),
                     a.residual_px, "px");
    f.max = options.epipolar_px.warn;
    f.sentence = "Tracked points are " + number(a.residual_px, 2) +
                 " px about their epipolar lines (median)";
    if (f.severity != Severity::kOk) {
      f.advice = "Wrong intrinsics, a rolling shutter, or a scene that moves itself.";
    }
  }

  Finding& f = add(findings, "rotation_agreement", Severity::kNotChecked, kNotComputed, "");
  f.min = options.min_correlation;
  if (a.status == AlignmentStatus::kTooFewPairs) {
    f.sentence = "Rotation of camera against gyro not checked: only " + std::to_string(a.pairs) +
                 " pairs of images have " + std::to_string(options.alignment.min_points) +
                 " points in common and IMU data";
    noneChecked(findings);
    return;
  }
  if (a.status == AlignmentStatus::kTooLittleTurn) {
    f.sentence = "Rotation of camera against gyro not checked: the camera turns by " +
                 number(kDegPerRad * a.camera_rate, 2) + " deg/s (rms), needs " +
                 number(kDegPerRad * options.alignment.min_rate, 2);
    f.advice = kHowToTurn;
    noneChecked(findings);
    return;
  }

  f.value = a.correlation;
  f.severity = Severity::kOk;
  f.sentence = "The rates of camera and gyro correlate by " + number(a.correlation) + " over " +
               std::to_string(a.pairs) + " pairs of images";
  bool agree = true;
  if (a.mirrored_correlation >= options.min_correlation &&
      a.mirrored_correlation > a.correlation + options.mirrored_margin) {
    f.severity = Severity::kError;
    f.sentence += ", but by " + number(a.mirrored_correlation) + " with an axis reversed";
    f.advice =
        "Axes of the IMU are left-handed (one sign is wrong, or two axes are swapped), or "
        "the images are mirrored.";
    agree = false;
  } else if (a.correlation < options.min_correlation) {
    // A slow turn drowns in the noise of the tracks; a fast one of only one of both does not.
    constexpr double kPlain = 3.0;
    const bool plain = std::max(a.camera_rate, a.gyro_rate) > kPlain * options.alignment.min_rate;
    f.severity = plain ? Severity::kError : Severity::kNotChecked;
    f.sentence += ": they do not turn together (" + number(kDegPerRad * a.camera_rate, 2) +
                  " deg/s against " + number(kDegPerRad * a.gyro_rate, 2) + ")";
    f.advice = "Are camera and IMU on one rigid body, of one recording, and their clocks within " +
               number(options.alignment.max_offset_s) + " s? Is the image frozen, or the gyro?";
    agree = false;
  }
  if (!agree) {
    noneChecked(findings);
    return;
  }
  checkScale(a, options, findings);
  checkTimeOffset(data, a, options, findings);
  checkExtrinsic(data, a, options, findings);
}

}  // namespace slim_init::evaluation
