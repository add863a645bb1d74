// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/extrinsic_rotation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/robust.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "rotation/free_rotations.h"
#include "rotation/keyframe_pairs.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// How well the turns of both sensors agree under the right extrinsic rotation [rad]: a gyroscope
// bias of 0.05 rad/s over 0.25 s, an error of td of 30 ms in a rate that changes by 0.5 rad/s.
constexpr double kTurnSigma = 0.02;
// The first rotation has to be this good [deg]; from there the rotation stage finds the rest.
constexpr double kMaxHandEyeSigmaDeg = 30.0;
// Pairs of three equations for seven unknowns, with one over for a check.
constexpr int kMinPairs = 4;

// Rotation vectors of both sensors over one pair of keyframes [rad], at a bias of zero.
struct Turn {
  Eigen::Vector3d camera, body;
};

std::vector<Turn> turnsOf(const InitWindow& window) {
  // Neighbours: their rotation the points see alone.
  const KeyframePairs pairs(window, 1);
  const PairRotations gyro = GyroRotations(window).at(RotationUnknowns::Zero(), pairs, 1);
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
  std::vector<Turn> turns;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    RelativeRotation seen;
    if (!pairs[p].use_points || !relativeRotation(pairs[p].points, pairs.sigma(), &seen)) continue;
    // Whatever the window says about R_b_c cancels.
    turns.push_back({logSO3(seen.R_ci_cj), R_b_c * logSO3(gyro[p].R_ci_cj)});
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

}  // namespace

ExtrinsicRotation estimateExtrinsicRotation(const InitWindow& window) {
  static const char* const kAxes[] = {
      "the horizontal axis of the image (tilt the camera up and down)",
      "the vertical axis of the image (pan it left and right)", "the camera's optical axis (roll)"};
  ExtrinsicRotation out;
  const std::string unknown = "the extrinsic rotation is unknown: ";
  const std::vector<Turn> turns = turnsOf(window);
  if (static_cast<int>(turns.size()) < kMinPairs) {
    out.message = unknown + text(turns.size(), " keyframe pairs with enough points to measure it",
                                 " (minimum ", kMinPairs, ")");
    return out;
  }
  out.R_b_c = consensus(turns);
  // A turn says nothing about its own axis.
  Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
  for (const Turn& turn : turns) along += turn.camera * turn.camera.transpose();
  const Eigen::Matrix3d across = along.trace() * Eigen::Matrix3d::Identity() - along;
  const double information = across.selfadjointView<Eigen::Lower>().eigenvalues()[0];
  const double sigma_deg = kDegPerRad * kTurnSigma / std::sqrt(std::max(information, 0.0));
  if (sigma_deg <= kMaxHandEyeSigmaDeg) return out;
  Eigen::Index least = 0;
  along.diagonal().minCoeff(&least);
  out.message = unknown + text("its standard deviation from the motion ",
                               std::lround(std::min(sigma_deg, 180.0)), " deg (limit ",
                               kMaxHandEyeSigmaDeg, "): rotate about ", kAxes[least]);
  return out;
}

}  // namespace slim_init
