// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "alignment/consistent_tracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "alignment/gravity_constrained.h"
#include "translation/ligt.h"

namespace slim_init {
namespace {

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

// A track agrees up to this many standard deviations, root mean square of its residuals.
constexpr double kAgreement = 3.0;
constexpr double kGraduation = 1.4;
constexpr int kMaxGraduations = 40;
// Without parallax a track has no say [rad^2].
constexpr double kMinParallax2 = 1e-8;

// (x^T A x + 2 b^T x + c) / rows: mean squared residual of a track [rad^2].
struct TrackCost {
  Matrix9d A = Matrix9d::Zero();
  Vector9d b = Vector9d::Zero();
  double c = 0.0;
  int rows = 0;
  double operator()(const Vector9d& x) const {
    return std::max(0.0, (x.dot(A * x) + 2.0 * b.dot(x) + c) / rows);
  }
};

}  // namespace

std::vector<char> consistentTracks(const InitWindow& window, const LinearMotion& motion,
                                   const std::vector<Eigen::Matrix3d>& R_b0_bk, double sigma_rad,
                                   double gravity_magnitude, double accel_bias_prior) {
  const std::vector<Track>& tracks = window.pointTracks();
  const std::vector<PointSighting>& sightings = window.pointSightings();
  std::vector<char> agrees(tracks.size(), 1);
  const Eigen::VectorXd c0 = motion.position0 + motion.lever;
  const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;

  // Centres in units of 1 m distance to every point until the first pass knows better.
  Eigen::VectorXd centres;
  std::vector<double> weight(tracks.size(), 1.0);
  std::vector<Eigen::Vector3d> u;
  std::vector<TrackCost> costs(tracks.size());
  const double bound2 = kAgreement * kAgreement * sigma_rad * sigma_rad;
  constexpr int kPasses = 2;
  for (int pass = 0; pass < kPasses; ++pass) {
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      TrackCost& cost = costs[t];
      cost = TrackCost();
      u.clear();
      for (int s = tracks[t].begin; s < tracks[t].end; ++s) {
        u.push_back(R_b0_bk[sightings[s].keyframe] * R_b_c * sightings[s].bearing);
      }
      int l = 0, r = 0;
      double parallax2 = 0.0;
      for (int a = 0; a < tracks[t].size(); ++a) {
        for (int b = a + 1; b < tracks[t].size(); ++b) {
          const double value = u[a].cross(u[b]).squaredNorm();
          if (value > parallax2) {
            parallax2 = value;
            l = a;
            r = b;
          }
        }
      }
      if (parallax2 < kMinParallax2) continue;
      const int k_l = sightings[tracks[t].begin + l].keyframe;
      const int k_r = sightings[tracks[t].begin + r].keyframe;
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      if (pass > 0) {
        const Eigen::Vector3d baseline = centres.segment<3>(3 * k_r) - centres.segment<3>(3 * k_l);
        const double depth = u[l].cross(u[r]).dot(baseline.cross(u[r])) / parallax2;
        point = centres.segment<3>(3 * k_l) + depth * u[l];
      }
      for (int a = 0; a < tracks[t].size(); ++a) {
        if (a == l || a == r) continue;
        const int k = sightings[tracks[t].begin + a].keyframe;
        const LigtRow row = ligtRow(u[l], u[r], u[a]);
        double distance = 1.0;
        if (pass > 0) distance = std::max((point - centres.segment<3>(3 * k)).norm(), 1e-3);
        const double to_angle = 1.0 / (parallax2 * distance);
        const auto at = [&](const auto& stacked) {
          return (to_angle * (row.block_l * stacked.template middleRows<3>(3 * k_l) +
                              row.block_r * stacked.template middleRows<3>(3 * k_r) +
                              row.block_i * stacked.template middleRows<3>(3 * k)))
              .eval();
        };
        const Eigen::Matrix<double, 3, 9> LA = at(motion.position);
        const Eigen::Vector3d Lc = at(c0);
        cost.A.noalias() += LA.transpose() * LA;
        cost.b.noalias() += LA.transpose() * Lc;
        cost.c += Lc.squaredNorm();
        cost.rows += 2;  // three equations, two of them independent
      }
    }

    Vector9d x = Vector9d::Zero();
    const auto solve = [&] {
      Matrix9d A = Matrix9d::Zero();
      Vector9d b = Vector9d::Zero();
      for (std::size_t t = 0; t < tracks.size(); ++t) {
        if (weight[t] == 0.0) continue;
        A += weight[t] * costs[t].A;
        b += weight[t] * costs[t].b;
      }
      const double information = 1.0 / (sigma_rad * sigma_rad);
      A *= information;
      b *= information;
      A.diagonal().segment<3>(3).array() += 1.0 / (accel_bias_prior * accel_bias_prior);
      Eigen::VectorXd solution;
      if (!solveGravityConstrained(A, -b, gravity_magnitude, &solution)) return false;
      x = solution;
      return true;
    };
    std::fill(weight.begin(), weight.end(), 1.0);
    if (!solve()) return agrees;
    double largest = 0.0;
    for (const TrackCost& cost : costs) {
      if (cost.rows > 0) largest = std::max(largest, cost(x));
    }
    // mu grows from a nearly convex surrogate to the truncated cost.
    double mu = largest > bound2 ? bound2 / (2.0 * largest - bound2) : 1e6;
    for (int i = 0; i < kMaxGraduations && mu < 1e3; ++i, mu *= kGraduation) {
      bool settled = true;
      for (std::size_t t = 0; t < tracks.size(); ++t) {
        if (costs[t].rows == 0) continue;
        const double residual2 = costs[t](x);
        const double low = mu / (mu + 1.0) * bound2, high = (mu + 1.0) / mu * bound2;
        weight[t] = 0.0;
        if (residual2 <= low) weight[t] = 1.0;
        if (residual2 > low && residual2 < high) {
          weight[t] = std::sqrt(bound2 * mu * (mu + 1.0) / residual2) - mu;
          settled = false;
        }
      }
      if (!solve()) return agrees;
      if (settled) break;
    }
    centres = motion.position * x + c0;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      agrees[t] = costs[t].rows == 0 || costs[t](x) <= bound2 ? 1 : 0;
    }
  }
  return agrees;
}

}  // namespace slim_init
