// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/calibration_check.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rotation/camera_check.h"
#include "rotation/constants.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// Unknowns [delta, td, b_g].
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

// One pair: phi = J [delta, td, b_g] + noise.
struct Row {
  Eigen::Vector3d phi;
  Eigen::Matrix<double, 3, 7> J;
  Eigen::Matrix3d information;
  double weight = 1.0;
};

std::vector<Row> rowsOf(const InitWindow& window, const Eigen::Vector3d& gyro_bias,
                        const std::vector<RotationCorrection>& corrections) {
  const std::vector<Eigen::Vector3d> rate = cameraRates(window, gyro_bias);
  std::vector<Row> rows;
  for (const RotationCorrection& pair : corrections) {
    const Eigen::Matrix3d Rt = pair.R_ci_cj.transpose();
    Row row;
    row.phi = pair.phi;
    row.J << Eigen::Matrix3d::Identity() - Rt, rate[pair.j] - Rt * rate[pair.i], pair.dR_dbg;
    const Eigen::Matrix3d floor = kRotationFloor * kRotationFloor * Eigen::Matrix3d::Identity();
    // (information^-1 + floor)^-1 without inverting a matrix that may be singular.
    row.information = (Eigen::Matrix3d::Identity() + pair.information * floor)
                          .partialPivLu()
                          .solve(pair.information);
    rows.push_back(row);
  }
  return rows;
}

struct Solution {
  Vector7d x = Vector7d::Zero();
  Matrix7d covariance = Matrix7d::Identity();
  double scatter = 0.0;  // weighted chi-square per degree of freedom
};

// Least squares with Cauchy weights, re-weighted kRounds times.
Solution solveRobust(std::vector<Row> rows) {
  Vector7d prior;
  prior << Eigen::Vector3d::Constant(kExtrinsicPrior), kTdPrior,
      Eigen::Vector3d::Constant(kBiasPrior);
  Solution out;
  for (int round = 0; round < kRounds; ++round) {
    Matrix7d H = prior.cwiseAbs2().cwiseInverse().asDiagonal();
    Vector7d g = Vector7d::Zero();
    for (const Row& row : rows) {
      H += row.weight * row.J.transpose() * row.information * row.J;
      g += row.weight * row.J.transpose() * (row.information * row.phi);
    }
    const Eigen::LDLT<Matrix7d> ldlt(H);
    out.x = ldlt.solve(g);
    out.covariance = ldlt.solve(Matrix7d::Identity());
    double chi2 = 0.0, weights = 0.0;
    for (Row& row : rows) {
      const Eigen::Vector3d r = row.phi - row.J * out.x;
      const double z2 = r.dot(row.information * r);
      chi2 += row.weight * z2;
      weights += row.weight;
      row.weight = 1.0 / (1.0 + z2 / (3.0 * kOutlierSigmas * kOutlierSigmas));
    }
    out.scatter = chi2 / std::max(3.0 * weights - 7.0, 1.5 * weights);
  }
  return out;
}

}  // namespace

CalibrationCheck checkCalibration(const InitWindow& window, const Eigen::Vector3d& gyro_bias,
                                  const std::vector<RotationCorrection>& corrections) {
  CalibrationCheck out;
  if (static_cast<int>(corrections.size()) < kMinPairs) return out;
  const Solution solution = solveRobust(rowsOf(window, gyro_bias, corrections));
  if (!solution.x.allFinite() || !solution.covariance.allFinite()) return out;
  const Matrix7d covariance = solution.covariance * std::max(solution.scatter, 1.0);
  out.covariance = covariance.topLeftCorner<4, 4>();
  out.extrinsic_error = solution.x.head<3>();
  out.td_error_s = solution.x[3];
  out.valid = true;
  return out;
}

}  // namespace slim_init
