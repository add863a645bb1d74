// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/calibration_lines.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "slim_init/text.h"

namespace slim_init::host_health {
namespace {

// A value further from the file's than so many standard deviations is not the file's any more.
constexpr double kContradiction = 2.0;
// And from so much on it matters to a host. Below it are what recordings with a good calibration
// show from window to window (docs/benchmark.md, "Miscalibrated rigs": td drifts by up to 2.2 ms
// within V1_01 and V1_02, the rotation of MH_01 is 0.4 deg from its file, a window knows it to 0.4
// to 1 deg and the lever arm to a centimetre at best), and an error that moves points by less than
// the 1.5 px of 460 px focal length that the hosts of the VINS family count on: 3.3 ms at 1 rad/s.
// A readout that is off by 5 ms costs no accuracy there.
constexpr double kMatteringTd = 0.003;       // [s]
constexpr double kMatteringReadout = 0.005;  // [s]
constexpr double kMatteringRotationDeg = 1.0;
constexpr double kMatteringTranslation = 0.02;  // [m]
// Digits of the values: far below what a window of two seconds can measure.
constexpr int kDigits = 9;
constexpr double kDegPerRad = 180.0 / M_PI;

// Root of the largest variance over all directions.
double largestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

// "KEY: !!opencv-matrix" with its rows.
std::string matrixLines(const std::string& key, const Eigen::MatrixXd& values) {
  const Eigen::IOFormat rows(kDigits, Eigen::DontAlignCols, ", ", ",\n          ");
  return text(key, ": !!opencv-matrix\n   rows: ", values.rows(), "\n   cols: ", values.cols(),
              "\n   dt: d\n   data: [", values.format(rows), "]\n");
}

// "# WHAT OFF UNIT from the file's, standard deviation SIGMA UNIT" or, without a value there, less.
std::string comment(const std::string& what, bool in_file, double off, double sigma,
                    const char* unit) {
  return text("# ", what, ": ", in_file ? roundedText(2, off, " ", unit, " from the file's, ") : "",
              roundedText(2, "standard deviation ", sigma, " ", unit, "\n"));
}

}  // namespace

std::string calibrationLines(const FileCalibration& file, const CalibrationEstimate& found) {
  const Calibration& old = file.calibration;
  const auto contradicts = [](double off, double sigma, double matters) {
    return off > kContradiction * sigma && off > matters;
  };
  std::string lines;

  const double td_off = std::abs(found.td - old.td);
  if (contradicts(td_off, found.tdSigma(), kMatteringTd)) {
    lines += comment("time offset", true, 1e3 * td_off, 1e3 * found.tdSigma(), "ms") +
             roundedText(kDigits, "td: ", found.td, "\n");
  }
  const double readout_off = std::abs(found.readout_s - old.readout_s);
  if (contradicts(readout_off, found.readoutSigma(), kMatteringReadout)) {
    lines += comment("readout", true, 1e3 * readout_off, 1e3 * found.readoutSigma(), "ms") +
             roundedText(kDigits, old.readout_s > 0.0 ? "" : "rolling_shutter: 1\n",
                         "rolling_shutter_tr: ", found.readout_s, "\n");
  }

  const double angle = kDegPerRad * Eigen::AngleAxisd(old.R_b_c.transpose() * found.R_b_c).angle();
  const double t_off = (found.t_b_c - old.t_b_c).norm();
  const double t_sigma = largestSigma(found.covariance.block<3, 3>(3, 3));
  const bool new_rotation =
      !file.has_rotation || contradicts(angle, found.rotationSigmaDeg(), kMatteringRotationDeg);
  const bool new_translation =
      !file.has_translation || contradicts(t_off, t_sigma, kMatteringTranslation);
  const std::string about_rotation =
      comment("rotation", file.has_rotation, angle, found.rotationSigmaDeg(), "deg");
  const std::string about_translation =
      comment("translation", file.has_translation, 1e3 * t_off, 1e3 * t_sigma, "mm");
  if (file.extrinsic_in_one_matrix && (new_rotation || new_translation)) {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.topLeftCorner<3, 3>() = found.R_b_c;
    T.topRightCorner<3, 1>() = found.t_b_c;
    return lines + about_rotation + about_translation + matrixLines("body_T_cam0", T);
  }
  if (new_rotation) lines += about_rotation + matrixLines("extrinsicRotation", found.R_b_c);
  if (new_translation) {
    lines += about_translation + matrixLines("extrinsicTranslation", found.t_b_c);
  }
  return lines;
}

}  // namespace slim_init::host_health
