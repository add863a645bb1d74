// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/calibration_check.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/robust.h"
#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "rotation/normalized_epipolar_pair.h"
#include "slim_init/types.h"

namespace slim_init {
namespace {

// Rotations of the gyroscope itself, vibration and scale error [rad]: no pair is more exact.
constexpr double kRotationFloor = 1e-3;
// Rounds of re-weighting; the weights of a dozen pairs have settled by then.
constexpr int kRounds = 5;
// With fewer residuals their spread is not estimated.
constexpr int kMinNoiseResiduals = 40;
// Share of its variance that a Gaussian has within kOutlierSigmas.
constexpr double kVarianceWithinCutoff = 0.9733;
// From the median on the standard deviation has settled to a percent after so many rounds.
constexpr int kNoiseRounds = 10;
// Median of the square of a Gaussian.
constexpr double kMedianOfSquare = 0.45494;
// Factor on the variance of the readout time: a point is in two pairs, and a track that drifts is
// wrong in all of them alike.
constexpr double kReadoutInflation = 2.0;

// Rate of the camera at every keyframe at a gyroscope bias, in c [rad/s].
std::vector<Eigen::Vector3d> cameraRates(const InitWindow& window,
                                         const Eigen::Vector3d& gyro_bias) {
  const Eigen::Matrix3d R_c_b = window.calibration().R_b_c.transpose();
  std::vector<Eigen::Vector3d> rates;
  for (const ImuInstant& at : imuInstants(window, 0.0, gyro_bias, Eigen::Vector3d::Zero())) {
    rates.push_back(R_c_b * at.rate);
  }
  return rates;
}

Eigen::Matrix3d freedRotation(const RotationCorrection& rotation) {
  return rotation.R_ci_cj * expSO3(rotation.phi);
}

// Normal equations of one pair over [rotation, direction of travel (2), readout].
struct PairSystem {
  Eigen::Matrix<double, kPairUnknowns + 1, kPairUnknowns + 1> H;
  Eigen::Matrix<double, kPairUnknowns + 1, 1> g;
  double chi2 = 0.0, weights = 0.0;
};

PairSystem systemOf(const InitWindow& window, const KeyframePair& pair,
                    const RotationCorrection& rotation, const std::vector<Eigen::Vector3d>& rates,
                    double sigma) {
  const Eigen::Matrix3d R = freedRotation(rotation);
  const Eigen::Vector3d& e = rotation.baseline;
  const Eigen::Matrix<double, 3, 2> T = tangentBasis(e);
  const PointResiduals residuals = pair.points.residuals(R, e, sigma);
  const double c2 = kOutlierSigmas * kOutlierSigmas;
  PairSystem out;
  out.H.setZero();
  out.g.setZero();
  for (int k = 0; k < pair.points.count(); ++k) {
    const Eigen::Vector3d f_i = pair.points.bearingsI().row(k).matrix().transpose();
    const Eigen::Vector3d f_j = pair.points.bearingsJ().row(k).matrix().transpose();
    const Eigen::Vector3d f = R * f_j, m = f_i.cross(f);
    // The bearings of rows exposed later, turned back to the middle row.
    const double row_i = window.pointObservations()[pair.observation_i[k]].row;
    const double row_j = window.pointObservations()[pair.observation_j[k]].row;
    const Eigen::Vector3d by_readout =
        row_i * rates[pair.i].cross(f_i).cross(f) + row_j * f_i.cross(R * rates[pair.j].cross(f_j));
    Eigen::Matrix<double, kPairUnknowns + 1, 1> J;
    J << f_j.cross(R.transpose() * e.cross(f_i)), T.transpose() * m, e.dot(by_readout);
    const double unit = 1.0 / (sigma * std::sqrt(residuals.noise[k]));
    const double excess = 1.0 + residuals.z2[k] / c2, w = 1.0 / (excess * excess);
    J *= unit;
    const Eigen::Matrix<double, kPairUnknowns + 1, 1> weighted = w * J;
    out.H.noalias() += weighted * J.transpose();
    out.g += unit * e.dot(m) * weighted;
    out.chi2 += w * residuals.z2[k];
    out.weights += w;
  }
  // Where there is hardly parallax the direction of travel is of no meaning.
  out.H.diagonal().segment<2>(3).array() += kBaselinePriorSigmas2 * out.weights;
  return out;
}

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
  // Standard deviations before any data: a right angle [rad], half a second [s] and what no
  // gyroscope has [rad/s].
  Vector7d prior;
  prior << Eigen::Vector3d::Constant(M_PI / 2), 0.5, Eigen::Vector3d::Constant(0.5);
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

double noiseVariance(const std::vector<double>& squares) {
  double variance = median(squares) / kMedianOfSquare;
  for (int round = 0; round < kNoiseRounds; ++round) {
    const double limit = kOutlierSigmas * kOutlierSigmas * variance;
    double sum = 0.0, within = 0.0, beyond = 0.0;
    for (const double z2 : squares) {
      if (z2 <= limit) {
        sum += z2;
        within += 1.0;
      } else if (z2 <= 4.0 * limit) {
        beyond += 1.0;
      }
    }
    // Gross errors are spread evenly: as many lie within the cutoff as in the range of the same
    // width beyond it, each with a third of the cutoff's square.
    const double good = sum - beyond * limit / 3.0;
    if (!(within > beyond) || !(good > 0.0)) break;
    variance = good / (within - beyond) / kVarianceWithinCutoff;
  }
  return variance;
}

double trackNoise(const KeyframePairs& pairs, const std::vector<RotationCorrection>& rotations) {
  std::vector<double> squares;  // in sigma^2
  for (const RotationCorrection& rotation : rotations) {
    const PairPoints& points = pairs[rotation.pair].points;
    const double count = points.count();
    const double correction = count / std::max(count - kPairUnknowns, 0.5 * count);
    const PointResiduals residuals =
        points.residuals(freedRotation(rotation), rotation.baseline, pairs.sigma());
    for (int k = 0; k < points.count(); ++k) squares.push_back(correction * residuals.z2[k]);
  }
  if (static_cast<int>(squares.size()) < kMinNoiseResiduals) return kNotComputed;
  return std::sqrt(noiseVariance(squares)) * pairs.sigma();
}

ReadoutCheck checkReadout(const InitWindow& window, const KeyframePairs& pairs,
                          const std::vector<RotationCorrection>& rotations,
                          const Eigen::Vector3d& gyro_bias, double sigma) {
  ReadoutCheck out;
  const std::vector<Eigen::Vector3d> rates = cameraRates(window, gyro_bias);
  double information = 0.0, gradient = 0.0, chi2 = 0.0, weights = 0.0;
  for (const RotationCorrection& rotation : rotations) {
    const PairSystem system = systemOf(window, pairs[rotation.pair], rotation, rates, sigma);
    const Eigen::LDLT<Eigen::Matrix<double, kPairUnknowns, kPairUnknowns>> fitted(
        system.H.topLeftCorner<kPairUnknowns, kPairUnknowns>());
    const Eigen::Matrix<double, kPairUnknowns, 1> cross =
        system.H.topRightCorner<kPairUnknowns, 1>();
    const Eigen::Matrix<double, kPairUnknowns, 1> taken = fitted.solve(cross);
    if (!taken.allFinite()) continue;
    information += system.H(kPairUnknowns, kPairUnknowns) - cross.dot(taken);
    gradient += system.g[kPairUnknowns] - taken.dot(system.g.head<kPairUnknowns>());
    chi2 += system.chi2;
    weights += system.weights;
  }
  if (!(information > 0.0) || !(weights > 0.0)) return out;
  out.error_s = -gradient / information;
  out.sigma_s = std::sqrt(kReadoutInflation * std::max(1.0, chi2 / weights) / information);
  out.valid = std::isfinite(out.error_s) && out.sigma_s < 0.5 * kLargestReadout;
  return out;
}

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
