// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "checks.h"
#include "reference_so3.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

const char kHowToTurn[] =
    "Record 20 s in which the rig is turned by hand about all three axes in front of a textured "
    "scene.";

/// The checks that need both rotations to agree, where they do not.
void noneChecked(Findings* findings) {
  const char kWhy[] = " not checked: see rotation_agreement";
  add(findings, notChecked("gyro_scale", ""), text("Scale of the gyro", kWhy));
  add(findings, notChecked("time_offset", "ms"), text("Time offset", kWhy));
  add(findings, notChecked("extrinsic_rotation", "deg"), text("Extrinsic rotation", kWhy));
  add(findings, notChecked("extrinsic_translation", "mm"), text("Extrinsic translation", kWhy));
}

/// A value that is right as far as one can tell from it: it is too uncertain.
void setUncertain(Finding* finding, const std::string& how, const std::string& advice) {
  finding->severity = Severity::kNotChecked;
  finding->message += ": too uncertain to check" + how;
  finding->advice = advice;
}

/// "z" or "-0.71, 0.00, 0.71"
std::string axisText(const Eigen::Vector3d& axis) {
  const char* names[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis(k)) > 0.99) return std::string("axis ") + names[k];
  }
  return text("axis (", number(axis.x(), 2), ", ", number(axis.y(), 2), ", ", number(axis.z(), 2),
              ')');
}

/// The calibration as measured, floors included: by `slim`, or by the rotations alone, which say
/// nothing about the translation.
CalibrationEstimate measuredBy(const RotationAlignment& a, const WindowEstimates& answers,
                               const DoctorOptions& options) {
  CalibrationEstimate found;
  if (answers.calibration.has_value()) {
    found = *answers.calibration;
  } else {
    found.R_b_c = a.R_b_c;
    found.td = a.td;
    found.covariance.topLeftCorner<3, 3>() = a.R_covariance;
    found.covariance(6, 6) = a.td_sigma * a.td_sigma;
  }
  const auto add_floor = [&found](int first, double sigma) {
    found.covariance.diagonal().segment<3>(first).array() += sigma * sigma;
  };
  add_floor(0, options.extrinsic_floor_deg / kDegPerRad);
  add_floor(3, options.translation_floor_m);
  return found;
}

void checkScale(const RotationAlignment& a, const DoctorOptions& options, Findings* findings) {
  const double off = std::abs(a.gyro_scale - 1.0), may_be = options.gyro_scale.warn;
  const bool known = off > options.significance * a.gyro_scale_sigma;
  Finding& f =
      add(findings,
          {"gyro_scale", known ? severityAbove(off, options.gyro_scale) : Severity::kOk,
           a.gyro_scale, 1.0 - may_be, 1.0 + may_be, ""},
          text("The gyro measures ", number(a.gyro_scale, 4), " times (+- ",
               number(a.gyro_scale_sigma, 2), ") the rate of the camera"),
          "Check the focal length (an incorrect one scales the rotation of the camera), the image "
          "size at which it was calibrated, and the unit and range of the gyro.");
  if (f.severity == Severity::kOk) {
    if (a.gyro_scale_sigma > 0.5 * may_be) setUncertain(&f, "", kHowToTurn);
  } else if (a.gyro_scale > 0.8 * kDegPerRad && a.gyro_scale < 1.25 * kDegPerRad) {
    f.message += ": it is in deg/s";
    f.advice = "Multiply angular_velocity by 0.0174533 in the driver or its settings.";
  }
}

/// What `slim` makes of a calibration that is off.
const char* consequence(Severity severity) {
  return severity == Severity::kError ? ", beyond what slim estimates"
                                      : "; slim estimates it, but a correct value is better";
}

/// True where the file has to be changed.
bool checkTimeOffset(const DoctorData& data, const CalibrationEstimate& a,
                     const DoctorOptions& options, Findings* findings) {
  const double sigma = a.tdSigma();
  const double configured = data.calibration.td, may_be = options.time_offset_s.warn;
  const double off = std::abs(a.td - configured);
  const bool known = off > options.significance * sigma;
  Finding& f =
      add(findings,
          {"time_offset", known ? severityAbove(off, options.time_offset_s) : Severity::kOk,
           1e3 * a.td, 1e3 * (configured - may_be), 1e3 * (configured + may_be), "ms"},
          text("The measured time offset td is ", number(1e3 * a.td), " ms (+- ",
               number(1e3 * sigma, 2), "), the configured one ", number(1e3 * configured), " ms"),
          text("Set td: ", number(a.td),
               " (t_imu = t_image + td), or correct the stamps in the driver of camera or IMU."));
  if (f.severity != Severity::kOk) {
    f.message += consequence(f.severity);
    return true;
  }
  if (sigma > 0.5 * may_be) {
    setUncertain(&f, "", "Record 20 s in which the rig is turned back and forth quickly by hand.");
  }
  return false;
}

/// The measured rotation against the configured one, in the camera's frame.
struct ExtrinsicDifference {
  Eigen::Matrix3d R_b_c;       ///< measured; as configured where the motion leaves it open
  Eigen::Vector3d difference;  ///< Log(configured^T measured) [rad]
  double sigmas = 0.0;         ///< its length in standard deviations
  double sigma = 0.0;          ///< largest standard deviation [rad]
  int open = 0;                ///< axes about which the motion contains no information
};

ExtrinsicDifference extrinsicDifference(const Eigen::Matrix3d& configured,
                                        const CalibrationEstimate& a) {
  constexpr double kOpen = 0.1;  // [rad]; what the motion determines is known far better
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(a.covariance.topLeftCorner<3, 3>());
  ExtrinsicDifference d;
  d.R_b_c = a.R_b_c;
  d.sigma = std::sqrt(axes.eigenvalues()(2));
  d.open = static_cast<int>((axes.eigenvalues().array() > kOpen * kOpen).count());
  if (d.open == 1) {
    // Turns about one axis fit any rotation about it: the one nearest to the configured is taken.
    // The trace of Q Exp(angle axis) is a constant, a cosine and a sine of the angle.
    const Eigen::Vector3d axis = axes.eigenvectors().col(2);
    const Eigen::Matrix3d Q = configured.transpose() * a.R_b_c;
    const double angle =
        std::atan2((Q * reference::skew(axis)).trace(), Q.trace() - axis.dot(Q * axis));
    d.R_b_c = a.R_b_c * reference::expSo3(angle * axis);
  }
  d.difference = reference::logSo3(configured.transpose() * d.R_b_c);
  Eigen::Vector3d along = axes.eigenvectors().transpose() * d.difference;
  if (d.open == 1) along(2) = 0.0;
  d.sigmas = std::sqrt((along.array().square() / axes.eigenvalues().array()).sum());
  return d;
}

/// True where the file has to be changed.
bool checkExtrinsic(const DoctorData& data, const CalibrationEstimate& a,
                    const DoctorOptions& options, Findings* findings) {
  const ExtrinsicDifference d = extrinsicDifference(data.calibration.R_b_c, a);
  const double angle = kDegPerRad * d.difference.norm();
  const std::string sigma = number(kDegPerRad * d.sigma, 2);
  if (data.calibration.sigmas.rotation_deg >= CalibrationSigmas::kUnknownRotationDeg) {
    const bool found = d.open == 0;
    Finding f = notChecked("extrinsic_rotation", "deg");
    if (found) f.severity = Severity::kNote;
    add(findings, f,
        text("The camera-to-IMU rotation is not configured; the recording determines it to ", sigma,
             " deg"),
        found ? "" : kHowToTurn);
    return found;
  }
  const bool known = d.open < 2 && d.sigmas > options.significance;
  Finding f = atMost("extrinsic_rotation", angle, options.extrinsic_deg, "deg");
  if (!known) f.severity = Severity::kOk;
  f.message = text("The camera-to-IMU rotation differs by ", number(angle), " deg ",
                   d.open == 0 ? "(+- " + sigma + ") " : "or more ", "from the configured one",
                   d.open > 0 ? ": the rig turns about one axis only" : "");
  const bool off = f.severity != Severity::kOk;
  if (off) {
    f.message +=
        text(", about the camera's ", axisText(d.difference.normalized()), consequence(f.severity));
    f.advice = text(
        "extrinsicRotation is camera to IMU (p_imu = R p_cam); the measured one is "
        "below. ",
        f.severity == Severity::kError
            ? "Look for the transposed matrix or other axes of IMU or camera."
            : "A calibration of the other camera of a stereo pair looks like this; "
              "check that intrinsics and extrinsic are those of this camera.");
  } else if (kDegPerRad * d.sigma > 0.5 * options.extrinsic_deg.warn) {
    setUncertain(&f, " to " + number(options.extrinsic_deg.warn) + " deg", kHowToTurn);
  }
  findings->push_back(f);
  return off;
}

/// True where the file has to be changed. `known`: `slim` has measured it.
bool checkTranslation(const DoctorData& data, const CalibrationEstimate& a, bool known,
                      const DoctorOptions& options, Findings* findings) {
  constexpr double kMmPerM = 1e3;
  Finding f = notChecked("extrinsic_translation", "mm");
  f.max = kMmPerM * options.max_translation_m;
  if (!known) {
    add(findings, f, "Extrinsic translation not checked: too few windows that slim can solve",
        kHowToTurn);
    return false;
  }
  // What the accelerometer has wrong, the lever arm makes up for.
  if (std::any_of(findings->begin(), findings->end(), [](const Finding& other) {
        return other.check == "gravity" && other.severity >= Severity::kWarning;
      })) {
    add(findings, f, "Extrinsic translation not checked: the measured gravity is incorrect",
        "Correct the accelerometer first.");
    return false;
  }
  const double off = (a.t_b_c - data.calibration.t_b_c).norm();
  const double sigma = std::sqrt(a.covariance.diagonal().segment<3>(3).maxCoeff());
  const bool is_off = off > options.max_translation_m && off > options.significance * sigma;
  f.value = kMmPerM * off;
  f.severity = is_off ? Severity::kWarning : Severity::kOk;
  f.message = text("The camera-to-IMU translation differs by ", number(kMmPerM * off), " mm (+- ",
                   number(kMmPerM * sigma, 2), ") from the configured one");
  if (is_off) {
    f.message += consequence(f.severity);
    f.advice = "Measure the camera's centre in the frame of the IMU; the measured one is below.";
  } else if (!(sigma < 0.5 * options.max_translation_m)) {
    setUncertain(&f, "", kHowToTurn);
  }
  findings->push_back(f);
  return is_off;
}

/// Lines for the parts that are off; the others stay as the file has them.
std::string linesFor(const DoctorData& data, CalibrationEstimate found, bool td, bool rotation,
                     bool translation) {
  host_health::FileCalibration file = data;
  file.has_rotation = file.has_rotation || !rotation;
  file.has_translation = file.has_translation || !translation;
  if (!rotation) found.R_b_c = data.calibration.R_b_c;
  if (!td) found.td = data.calibration.td;
  if (!translation) found.t_b_c = data.calibration.t_b_c;
  found.readout_s = data.calibration.readout_s;
  return host_health::calibrationLines(file, found);
}

void checkEpipolar(const RotationAlignment& a, const DoctorOptions& options, Findings* findings) {
  if (a.pairs < rotation_alignment::kMinPairs) return;
  add(findings, atMost("epipolar", a.residual_px, options.epipolar_px, "px"),
      text("Tracked points scatter by ", number(a.residual_px, 2),
           " px about their epipolar lines (median)"),
      "Possible causes: incorrect intrinsics, a rolling shutter, a moving scene.");
}

/// Fills `f`; true where the data suffice to compare camera and gyro, and both measure the same
/// motion.
bool rotationsAgree(const RotationAlignment& a, const DoctorOptions& options, Finding* f) {
  using namespace rotation_alignment;  // NOLINT: the bounds of the comparison
  if (a.status == AlignmentStatus::kTooFewPairs) {
    f->message = text("Rotation of camera against gyro not checked: only ", a.pairs,
                      " pairs of images have ", kMinPoints, " points in common and IMU data");
    return false;
  }
  const std::string camera_rate = number(kDegPerRad * a.camera_rate, 2);
  if (a.status == AlignmentStatus::kTooLittleTurn) {
    f->message = text("Rotation of camera against gyro not checked: the camera turns at ",
                      camera_rate, " deg/s (rms, minimum ", number(kDegPerRad * kMinRate, 2), ')');
    f->advice = kHowToTurn;
    return false;
  }
  f->value = a.correlation;
  f->severity = Severity::kOk;
  f->message = text("The correlation of camera and gyro rates is ", number(a.correlation), " over ",
                    a.pairs, " image pairs");
  if (a.mirrored_correlation >= options.min_correlation &&
      a.mirrored_correlation > a.correlation + options.mirrored_margin) {
    f->severity = Severity::kError;
    f->message += ", but " + number(a.mirrored_correlation) + " with an axis reversed";
    f->advice =
        "Axes of the IMU are left-handed (one sign is reversed, or two axes are swapped), or "
        "the images are mirrored.";
    return false;
  }
  if (a.correlation >= options.min_correlation) return true;
  // A slow rotation is lost in the noise of the tracks; a fast one of either sensor is not.
  constexpr double kFast = 3.0;  // times the least rate
  const bool fast = std::max(a.camera_rate, a.gyro_rate) > kFast * kMinRate;
  f->severity = fast ? Severity::kError : Severity::kNotChecked;
  f->message += text(": they do not turn together (", camera_rate, " deg/s against ",
                     number(kDegPerRad * a.gyro_rate, 2), ')');
  f->advice = text(
      "Check that camera and IMU are on one rigid body and from one recording, that their clocks "
      "agree within ",
      number(kMaxOffset), " s, and that neither the image nor the gyro is frozen.");
  return false;
}

}  // namespace

std::string checkRotation(const DoctorData& data, const RotationAlignment& a,
                          const WindowEstimates& answers, const DoctorOptions& options,
                          Findings* findings) {
  checkEpipolar(a, options, findings);
  Finding f = notChecked("rotation_agreement", "");
  f.min = options.min_correlation;
  const bool agree = rotationsAgree(a, options, &f);
  findings->push_back(f);
  if (!agree) {
    noneChecked(findings);
    return "";
  }
  const CalibrationEstimate measured = measuredBy(a, answers, options);
  checkScale(a, options, findings);
  const bool td = checkTimeOffset(data, measured, options, findings);
  const bool rotation = checkExtrinsic(data, measured, options, findings);
  const bool translation =
      checkTranslation(data, measured, answers.calibration.has_value(), options, findings);
  return linesFor(data, measured, td, rotation, translation);
}

}  // namespace slim_init::evaluation
