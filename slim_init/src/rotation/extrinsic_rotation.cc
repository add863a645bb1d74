// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/extrinsic_rotation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "geometry/median.h"
#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "rotation/constants.h"
#include "rotation/keyframe_pairs.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// The rotation R that brings `to` = R `from`, by weighted least squares (Kabsch 1976).
Eigen::Matrix3d kabsch(const Eigen::Matrix3d& sum_to_from) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum_to_from,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs[2] = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

// R_ci_cj as the bearings of a pair have it without any translation: points far away decide, since
// the others scatter and lose weight.
Eigen::Matrix3d rotationOfBearings(const InitWindow& window, const KeyframePair& pair) {
  const std::size_t n = pair.sighting_i.size();
  std::vector<double> weight(n, 1.0), distance(n);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int round = 0; round < kBearingRounds; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t p = 0; p < n; ++p) {
      sum += weight[p] * window.pointSightings()[pair.sighting_i[p]].bearing *
             window.pointSightings()[pair.sighting_j[p]].bearing.transpose();
    }
    R = kabsch(sum);
    for (std::size_t p = 0; p < n; ++p) {
      distance[p] = (window.pointSightings()[pair.sighting_i[p]].bearing -
                     R * window.pointSightings()[pair.sighting_j[p]].bearing)
                        .norm();
    }
    const double scale = std::max(median(distance), 1e-9);
    for (std::size_t p = 0; p < n; ++p) {
      weight[p] = 1.0 / (1.0 + distance[p] * distance[p] / (scale * scale));
    }
  }
  return R;
}

// One pair: both sensors' rotation as a vector, [rad].
struct Turn {
  Eigen::Vector3d camera, body;
};

std::vector<Turn> turnsOf(const InitWindow& window, int min_points) {
  const KeyframePairs pairs(window, 1, min_points);
  std::vector<Turn> turns;
  for (const KeyframePair& pair : pairs) {
    if (!pair.use_points) continue;
    const Preintegration gyro = preintegrate(
        window.imu(), window.times()[pair.i], window.times()[pair.j], Eigen::Vector3d::Zero(),
        Eigen::Vector3d::Zero(), window.calibration().imu_noise, PreintegrationParts::kRotation);
    turns.push_back({logSO3(rotationOfBearings(window, pair)), logSO3(gyro.dR)});
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
    cost += std::min(z * z, kTruncationSigmas * kTruncationSigmas);
  }
  return cost;
}

Eigen::Matrix3d weightedFit(const std::vector<Turn>& turns, const Eigen::Matrix3d& start) {
  Eigen::Matrix3d R = start;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Turn& turn : turns) {
      const double z = residual(R, turn) / kTruncationSigmas;
      sum += turn.body * turn.camera.transpose() / (1.0 + z * z);
    }
    R = kabsch(sum);
  }
  return R;
}

// Every two turns fix a rotation; the one that most agree with, then all of them together.
Eigen::Matrix3d consensus(const std::vector<Turn>& turns) {
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
  double lowest = truncatedCost(best, turns);
  for (std::size_t a = 0; a < turns.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Vector3d body = turns[a].body.cross(turns[b].body);
      const Eigen::Vector3d camera = turns[a].camera.cross(turns[b].camera);
      const Eigen::Matrix3d R =
          kabsch(turns[a].body * turns[a].camera.transpose() +
                 turns[b].body * turns[b].camera.transpose() + body * camera.transpose());
      const double cost = truncatedCost(R, turns);
      if (cost < lowest) {
        lowest = cost;
        best = R;
      }
    }
  }
  return weightedFit(turns, best);
}

}  // namespace

std::string leastTurnedAxis(const Eigen::Vector3d& weights) {
  static const char* const kAxes[] = {
      "the horizontal axis of the image (tilt the camera up and down)",
      "the vertical axis of the image (pan it left and right)", "the camera's optical axis (roll)"};
  Eigen::Index least = 0;
  weights.minCoeff(&least);
  return kAxes[least];
}

ExtrinsicRotation estimateExtrinsicRotation(const InitWindow& window, int min_points_per_pair) {
  ExtrinsicRotation out;
  const std::vector<Turn> turns = turnsOf(window, min_points_per_pair);
  out.pairs = static_cast<int>(turns.size());
  std::ostringstream message;
  if (out.pairs < kMinPairs) {
    message << "the extrinsic rotation is unknown, and " << out.pairs
            << " keyframe pairs have enough points to measure it, needs " << kMinPairs;
    out.message = message.str();
    return out;
  }
  out.R_b_c = consensus(turns);
  // A turn by theta tells nothing about the rotation about its own axis.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Turn& turn : turns) {
    const double z = residual(out.R_b_c, turn);
    const double weight = z < kTruncationSigmas ? 1.0 / (kTurnSigma * kTurnSigma) : 0.0;
    information += weight * (turn.camera.squaredNorm() * Eigen::Matrix3d::Identity() -
                             turn.camera * turn.camera.transpose());
    squares += turn.camera.cwiseAbs2();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  const double least = solver.eigenvalues()[0];
  out.uncertain_axis_c = solver.eigenvectors().col(0);
  out.sigma_deg = least > 0.0 ? kDegPerRad / std::sqrt(least) : kNotComputed;
  out.valid = out.sigma_deg <= kMaxHandEyeSigmaDeg;
  if (out.valid) return out;
  message << "the extrinsic rotation is unknown, and the motion determines it to ";
  if (std::isfinite(out.sigma_deg)) {
    message << std::lround(std::min(out.sigma_deg, 180.0)) << " deg";
  } else {
    message << "nothing";
  }
  message << ", needs " << kMaxHandEyeSigmaDeg << " deg: rotate about " << leastTurnedAxis(squares);
  out.message = message.str();
  return out;
}

}  // namespace slim_init
