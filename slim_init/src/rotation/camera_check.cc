// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/camera_check.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/robust.h"
#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "rotation/normalized_epipolar_pair.h"
#include "slim_init/types.h"

namespace slim_init {
namespace {

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

// Normal equations of one pair over [rotation, direction of travel (2), readout].
struct PairSystem {
  Eigen::Matrix<double, kPairUnknowns + 1, kPairUnknowns + 1> H;
  Eigen::Matrix<double, kPairUnknowns + 1, 1> g;
  double chi2 = 0.0, weights = 0.0;
};

PairSystem systemOf(const InitWindow& window, const KeyframePair& pair,
                    const RelativeRotation& rotation, const std::vector<Eigen::Vector3d>& rates,
                    double sigma) {
  const Eigen::Matrix3d& R = rotation.R_ci_cj;
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

}  // namespace

double trackNoise(const KeyframePairs& pairs, const std::vector<RelativeRotation>& rotations) {
  std::vector<double> squares;  // in sigma^2
  for (const RelativeRotation& rotation : rotations) {
    const PairPoints& points = pairs[rotation.pair].points;
    const double count = points.count();
    const double correction = count / std::max(count - kPairUnknowns, 0.5 * count);
    const PointResiduals residuals =
        points.residuals(rotation.R_ci_cj, rotation.baseline, pairs.sigma());
    for (int k = 0; k < points.count(); ++k) squares.push_back(correction * residuals.z2[k]);
  }
  if (static_cast<int>(squares.size()) < kFewestForSpread) return kNotComputed;
  return std::sqrt(noiseVariance(squares)) * pairs.sigma();
}

ReadoutCheck checkReadout(const InitWindow& window, const KeyframePairs& pairs,
                          const std::vector<RelativeRotation>& rotations,
                          const Eigen::Vector3d& gyro_bias, double sigma) {
  ReadoutCheck out;
  const std::vector<Eigen::Vector3d> rates = cameraRates(window, gyro_bias);
  double information = 0.0, gradient = 0.0, chi2 = 0.0, weights = 0.0;
  for (const RelativeRotation& rotation : rotations) {
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

}  // namespace slim_init
