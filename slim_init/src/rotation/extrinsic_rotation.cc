// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/extrinsic_rotation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "data/derived_window.h"
#include "geometry/robust.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "imu/row_compensation.h"
#include "rotation/calibration_check.h"
#include "rotation/free_rotations.h"
#include "rotation/keyframe_pairs.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// How well the turns of both sensors agree under the right extrinsic rotation [rad]: a gyroscope
// bias of 0.05 rad/s over 0.25 s, an error of td of 30 ms in a rate that changes by 0.5 rad/s.
constexpr double kTurnSigma = 0.02;
// Solutions for rotation, bias and td about the rotation found before; from the one that most
// pairs agree with two corrections are exact to a tenth of a degree.
constexpr int kHandEyeRounds = 4;
// Largest correction [rad] of that rotation: along an axis about which nothing is known any one is
// as good as none.
constexpr double kMaxHandEyeStep = 0.5;
// The first rotation has to be this good [deg]; from there the rotation stage finds the rest.
constexpr double kMaxHandEyeSigmaDeg = 15.0;

// What the points of one pair of keyframes see, and what the gyroscope measures at a bias of zero.
struct Turn {
  int i = 0, j = 0;
  std::size_t pair = 0;  // index into the pairs of the window
  RelativeRotation seen;
  Eigen::Vector3d camera, body;  // rotation vectors of both sensors [rad]
};

std::vector<Turn> turnsOf(const InitWindow& window, const KeyframePairs& pairs) {
  const PairRotations gyro = GyroRotations(window).at(Eigen::Vector3d::Zero(), pairs, 1);
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
  std::vector<Turn> turns;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    if (!pair.use_points) continue;
    Turn turn;
    if (!relativeRotation(pair.points, pairs.sigma(), &turn.seen)) continue;
    turn.i = pair.i;
    turn.j = pair.j;
    turn.pair = p;
    turn.camera = logSO3(turn.seen.R_ci_cj);
    // Whatever the window says about R_b_c cancels.
    turn.body = R_b_c * logSO3(gyro[p].R_ci_cj);
    turns.push_back(turn);
  }
  return turns;
}

double residual(const Eigen::Matrix3d& R_b_c, const Turn& turn) {
  return (turn.body - R_b_c * turn.camera).norm() / kTurnSigma;
}

double truncatedCost(const Eigen::Matrix3d& R_b_c, const std::vector<Turn>& turns) {
  double cost = 0.0;
  for (const Turn& turn : turns) {
    const double z = residual(R_b_c, turn);
    cost += std::min(z * z, kOutlierSigmas * kOutlierSigmas);
  }
  return cost;
}

// Every two turns fix a rotation (Kabsch 1976); the one that most agree with.
Eigen::Matrix3d consensus(const std::vector<Turn>& turns) {
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double lowest = truncatedCost(best, turns);
  for (std::size_t a = 0; a < turns.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Vector3d body = turns[a].body.cross(turns[b].body);
      const Eigen::Vector3d camera = turns[a].camera.cross(turns[b].camera);
      const Eigen::Matrix3d R =
          nearestRotation(turns[a].body * turns[a].camera.transpose() +
                          turns[b].body * turns[b].camera.transpose() + body * camera.transpose());
      const double cost = truncatedCost(R, turns);
      if (cost < lowest) {
        lowest = cost;
        best = R;
      }
    }
  }
  return best;
}

// The rotations of the points against those of the gyroscope seen through `window`, whose
// calibration is the one found so far.
std::vector<RotationCorrection> correctionsOf(const InitWindow& window, const KeyframePairs& pairs,
                                              const std::vector<Turn>& turns) {
  const PairRotations gyro = GyroRotations(window).at(Eigen::Vector3d::Zero(), pairs, 1);
  std::vector<RotationCorrection> corrections;
  for (const Turn& turn : turns) {
    const PairRotation& predicted = gyro[turn.pair];
    const Eigen::Vector3d phi = logSO3(predicted.R_ci_cj.transpose() * turn.seen.R_ci_cj);
    corrections.push_back({turn.pair, turn.i, turn.j, predicted.R_ci_cj, predicted.dR_dbg, phi,
                           turn.seen.information, Eigen::Vector3d::Zero()});
  }
  return corrections;
}

// The axis of the camera about which it has turned least, in words, with how to turn about it.
std::string leastTurnedAxis(const std::vector<Turn>& turns) {
  static const char* const kAxes[] = {
      "the horizontal axis of the image (tilt the camera up and down)",
      "the vertical axis of the image (pan it left and right)", "the camera's optical axis (roll)"};
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Turn& turn : turns) squares += turn.camera.cwiseAbs2();
  Eigen::Index least = 0;
  squares.minCoeff(&least);
  return kAxes[least];
}

std::shared_ptr<const InitWindow> withRotation(const InitWindow& window,
                                               const Eigen::Matrix3d& R_b_c) {
  Calibration better = window.calibration();
  better.R_b_c = R_b_c;
  return withCalibration(window, better);
}

// Corrects the rotation by the one that the pairs agree on with bias of the gyroscope and td
// unknown, which are in exact rotations too. Returns its largest standard deviation over all axes
// [deg], NaN where there is none.
double refine(const InitWindow& window, const KeyframePairs& pairs, const std::vector<Turn>& turns,
              Eigen::Matrix3d* R_b_c) {
  double sigma_deg = kNotComputed;
  for (int round = 0; round < kHandEyeRounds; ++round) {
    const auto turned = withRotation(window, *R_b_c);
    if (turned == nullptr) break;
    const CalibrationCheck check =
        checkCalibration(*turned, Eigen::Vector3d::Zero(), correctionsOf(*turned, pairs, turns));
    if (!check.valid) break;
    // Of the rotation alone [rad], with what is known about td before.
    const double td_sigma = window.calibration().sigmas.td_s;
    const Eigen::Vector3d with_td = check.covariance.block<3, 1>(0, 3);
    const double sum = check.covariance(3, 3) + td_sigma * td_sigma;
    const Eigen::Vector3d error = check.extrinsic_error - with_td * (check.td_error_s / sum);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
        check.covariance.topLeftCorner<3, 3>() - with_td * with_td.transpose() / sum);
    sigma_deg = kDegPerRad * std::sqrt(std::max(0.0, axes.eigenvalues()[2]));
    if (!(error.norm() < kMaxHandEyeStep)) break;
    *R_b_c = *R_b_c * expSO3(error);
  }
  return sigma_deg;
}

}  // namespace

ExtrinsicRotation estimateExtrinsicRotation(const InitWindow& window) {
  ExtrinsicRotation out;
  std::shared_ptr<const InitWindow> seen = unowned(window);
  std::vector<Turn> turns;
  double sigma_deg = kNotComputed;
  out.message = "the extrinsic rotation is unknown: ";
  // With a rolling shutter the rows are turned to the middle one as soon as the rotation is known.
  const int passes = window.calibration().readout_s > 0.0 ? 2 : 1;
  for (int pass = 0; pass < passes; ++pass) {
    if (pass > 0) {
      const auto turned = withRotation(window, out.R_b_c);
      if (turned == nullptr) break;
      seen = withRowsCompensated(*turned, Eigen::Vector3d::Zero());
    }
    // Neighbours: their rotation the points see alone.
    const KeyframePairs pairs(*seen, 1);
    turns = turnsOf(*seen, pairs);
    if (static_cast<int>(turns.size()) < kMinPairs) {
      out.message += text(turns.size(), " keyframe pairs with enough points to measure it",
                          " (minimum ", kMinPairs, ")");
      return out;
    }
    out.R_b_c = consensus(turns);
    sigma_deg = refine(window, pairs, turns, &out.R_b_c);
  }
  out.valid = sigma_deg <= kMaxHandEyeSigmaDeg;
  if (out.valid) {
    out.message.clear();
    return out;
  }
  const std::string sigma = std::isfinite(sigma_deg)
                                ? text(std::lround(std::min(sigma_deg, 180.0)), " deg")
                                : "not measured";
  out.message += text("its standard deviation from the motion ", sigma, " (limit ",
                      kMaxHandEyeSigmaDeg, "): rotate about ", leastTurnedAxis(turns));
  return out;
}

}  // namespace slim_init
