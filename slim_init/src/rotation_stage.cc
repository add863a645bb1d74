// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation_stage.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "data/with_calibration.h"
#include "estimation/constants.h"
#include "geometry/so3.h"
#include "imu/row_compensation.h"
#include "rotation/extrinsic_rotation.h"
#include "rotation/static_tracks.h"

namespace slim_init {
namespace {

using namespace estimation_constants;  // NOLINT: how far a calibration may be off

constexpr double kRadPerDeg = M_PI / 180.0;
// A calibration this near needs no other look at the window: the estimation is linear there.
constexpr double kNearRotation = 1.0 * kRadPerDeg;  // [rad]
constexpr double kNearTd = 3e-3;                    // [s]
// From an error of ten degrees or 50 ms two corrections are exact to kNear*; one more to see it.
constexpr int kMaxRounds = 4;
// Without the steps that follow there is no estimate at all: they have the rest.
constexpr double kShareOfRotations = 0.5;

// What is known about [rotation, td] of the calibration before the data, against `seen`.
struct PriorOfCheck {
  Eigen::Vector4d mean;
  Eigen::Matrix4d covariance;
};

PriorOfCheck priorOfCheck(const Calibration& handed_in, const Calibration& seen) {
  PriorOfCheck prior;
  prior.mean.head<3>() = logSO3(seen.R_b_c.transpose() * handed_in.R_b_c);
  prior.mean[3] = handed_in.td - seen.td;
  const double rotation = handed_in.sigmas.rotation_deg * kRadPerDeg;
  Eigen::Vector4d sigma(rotation, rotation, rotation, handed_in.sigmas.td_s);
  prior.covariance = sigma.cwiseAbs2().asDiagonal();
  return prior;
}

// The most probable [rotation, td] from check and prior; a part of the prior that the check
// contradicts is taken as wide.
Eigen::Vector4d correctionOf(const CalibrationCheck& check, PriorOfCheck prior) {
  Eigen::Vector4d measured;
  measured << check.extrinsic_error, check.td_error_s;
  const Eigen::Vector4d off = measured - prior.mean;
  const double rotation_variance = check.covariance.topLeftCorner<3, 3>().diagonal().maxCoeff();
  const auto beyond = [](double error, double bound, double prior_variance, double variance) {
    return prior_variance > 0.0 && error > bound * std::sqrt(prior_variance + variance);
  };
  if (beyond(off.head<3>().norm(), kBeyondVector, prior.covariance(0, 0), rotation_variance)) {
    const double wide =
        std::max(prior.covariance(0, 0), std::pow(kWideRotationDeg * kRadPerDeg, 2));
    prior.covariance.diagonal().head<3>().setConstant(wide);
  }
  if (beyond(std::abs(off[3]), kBeyondScalar, prior.covariance(3, 3), check.covariance(3, 3))) {
    prior.covariance(3, 3) = std::max(prior.covariance(3, 3), kWideTd * kWideTd);
  }
  const Eigen::Matrix4d sum = prior.covariance + check.covariance;
  return prior.mean + prior.covariance * sum.ldlt().solve(off);
}

bool isNear(const Eigen::Vector4d& correction) {
  return correction.head<3>().norm() < kNearRotation && std::abs(correction[3]) < kNearTd;
}

// Vanishing points and bias of `raw`. With a rolling shutter its rows are turned to the middle row
// by the gyroscope at a bias of zero, and again by the bias found.
void estimateBias(const std::shared_ptr<const InitWindow>& raw, const InitializerOptions& options,
                  WorkBudget* budget, RotationStage* stage) {
  stage->window = raw;
  const auto compensate = [&](const Eigen::Vector3d& gyro_bias) {
    if (!(raw->calibration().readout_s > 0.0)) return;
    if (const auto turned = withRowsCompensated(*raw, gyro_bias)) stage->window = turned;
  };
  compensate(Eigen::Vector3d::Zero());
  const InitWindow& window = *stage->window;
  const std::vector<VanishingPoint>* vps = nullptr;
  if (options.slim.vanishing_points) {
    stage->vanishing_points = trackVanishingPoints(window, options.vanishing_point);
    // Their covariance is that of the segments' noise; clutter among the inliers is not in it
    // (kappa_v).
    for (VanishingPoint& vp : stage->vanishing_points) {
      vp.covariance *= options.vanishing_point.covariance_inflation;
    }
    vps = &stage->vanishing_points;
  }
  stage->bias = estimateRobustGyroBias(window, vps, options.robust_bias, options.inertial, budget);
  if (stage->bias.valid()) compensate(stage->bias.gyro_bias);
}

// One look at the window through a calibration; a second one without what stands in the image.
void solveRotations(const InitializerOptions& options, WorkBudget* budget, RotationStage* stage) {
  const std::shared_ptr<const InitWindow> raw = stage->window;
  estimateBias(raw, options, budget, stage);
  ++stage->rounds;
  stage->static_tracks = 0;
  if (!options.slim.prune_tracks || !stage->bias.gyro_bias.allFinite()) return;
  const std::shared_ptr<const InitWindow> scene =
      withoutStaticTracks(*raw, stage->bias.gyro_bias, &stage->static_tracks);
  if (scene != nullptr) estimateBias(scene, options, budget, stage);
}

}  // namespace

RotationStage estimateRotations(const InitWindow& window, const InitializerOptions& options,
                                WorkBudget* budget) {
  const WorkBudget::Share share(kShareOfRotations, budget);
  const Calibration& handed_in = window.calibration();
  RotationStage stage;
  stage.window = unowned(window);
  if (options.slim.estimate_calibration &&
      handed_in.sigmas.rotation_deg >= CalibrationSigmas::kUnknownRotationDeg) {
    const ExtrinsicRotation found =
        estimateExtrinsicRotation(window, options.robust_bias.refinement.min_points_per_pair);
    stage.message = found.message;
    if (!found.valid) return stage;
    Calibration better = handed_in;
    better.R_b_c = found.R_b_c;
    stage.window = withCalibration(window, better);
  }
  solveRotations(options, budget, &stage);
  CalibrationCheck check;
  while (options.slim.estimate_calibration && stage.bias.point_pairs > 0) {
    check = checkCalibration(*stage.window, stage.bias.gyro_bias, stage.bias.rotations);
    if (!check.valid || stage.rounds >= kMaxRounds) break;
    const Eigen::Vector4d correction =
        correctionOf(check, priorOfCheck(handed_in, stage.window->calibration()));
    if (isNear(correction) || !budget->allows("a better calibration of the rotations")) break;
    Calibration better = stage.window->calibration();
    better.R_b_c = better.R_b_c * expSO3(correction.head<3>());
    better.td += correction[3];
    const std::shared_ptr<const InitWindow> seen = withCalibration(window, better);
    if (seen == nullptr || seen->size() < kMinKeyframes) break;
    stage.window = seen;
    solveRotations(options, budget, &stage);
  }
  const Calibration& found = stage.window->calibration();
  stage.prior.mean.dR = found.R_b_c.transpose() * handed_in.R_b_c;
  stage.prior.mean.dtd = handed_in.td - found.td;
  stage.prior.sigmas = handed_in.sigmas;
  if (check.valid) {
    // Of the calibration handed in, by the check of the one found.
    RigError measured;
    measured.dR = stage.prior.mean.dR.transpose() * expSO3(check.extrinsic_error);
    measured.dtd = check.td_error_s - stage.prior.mean.dtd;
    RigCovariance covariance = RigCovariance::Zero();
    covariance.topLeftCorner<3, 3>() = check.covariance.topLeftCorner<3, 3>();
    covariance(6, 6) = check.covariance(3, 3);
    stage.prior.sigmas = widenedByMeasurement(handed_in.sigmas, measured, covariance);
  }
  return stage;
}

}  // namespace slim_init
