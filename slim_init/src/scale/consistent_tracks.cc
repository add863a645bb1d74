// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/consistent_tracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scale/constants.h"
#include "scale/gravity_constrained.h"
#include "shape/ligt.h"

namespace slim_init {
namespace {

using namespace scale_constants;  // NOLINT: the constants of this module

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

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

// The cost of a track at the centres C(x) = A x + c0: LiGT rows (docs/derivation.md, 2) divided by
// |theta|^2 and by the distance of the point, which turns them into angles. `views`: its
// observations; `u`: their bearings in b0; `centres`: of an earlier pass, stacked, or empty: every
// point is at 1 m. No rows without parallax or with two views only.
TrackCost costOf(const WindowPoint* views, const std::vector<Eigen::Vector3d>& u,
                 const LinearMotion& motion, const Eigen::VectorXd& c0,
                 const Eigen::VectorXd& centres) {
  TrackCost cost;
  const BaseViews base = chooseBaseViews(u);
  if (base.parallax2 < kMinParallax * kMinParallax) return cost;
  const int k_l = views[base.l].keyframe;
  const int k_r = views[base.r].keyframe;
  const bool known = centres.size() > 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  if (known) {
    const Eigen::Vector3d baseline = centres.segment<3>(3 * k_r) - centres.segment<3>(3 * k_l);
    const double depth = u[base.l].cross(u[base.r]).dot(baseline.cross(u[base.r])) / base.parallax2;
    point = centres.segment<3>(3 * k_l) + depth * u[base.l];
  }
  for (int a = 0; a < static_cast<int>(u.size()); ++a) {
    if (a == base.l || a == base.r) continue;
    const int k = views[a].keyframe;
    const LigtRow row = ligtRow(u[base.l], u[base.r], u[a]);
    double distance = 1.0;
    if (known) distance = std::max((point - centres.segment<3>(3 * k)).norm(), kMinDistance);
    const double to_angle = 1.0 / (base.parallax2 * distance);
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
  return cost;
}

// What the minimisation over x knows besides the tracks.
struct Prior {
  double sigma_rad;          // of a bearing
  double gravity_magnitude;  // [m/s^2]
  double accel_bias;         // standard deviation [m/s^2]
};

// Weighted least squares over the tracks, |g| fixed; false where the problem is singular.
bool solveWeighted(const std::vector<TrackCost>& costs, const std::vector<double>& weight,
                   const Prior& prior, Vector9d* x) {
  Matrix9d A = Matrix9d::Zero();
  Vector9d b = Vector9d::Zero();
  for (std::size_t t = 0; t < costs.size(); ++t) {
    if (weight[t] == 0.0) continue;
    A += weight[t] * costs[t].A;
    b += weight[t] * costs[t].b;
  }
  const double information = 1.0 / (prior.sigma_rad * prior.sigma_rad);
  A *= information;
  b *= information;
  A.diagonal().segment<3>(3).array() += 1.0 / (prior.accel_bias * prior.accel_bias);
  return solveGravityConstrained(A, -b, prior.gravity_magnitude, x);
}

// Truncated least squares by graduated non-convexity: Yang, Antonante, Tzoumas and Carlone,
// "Graduated Non-Convexity for Robust Spatial Perception", RA-L 2020, surrogate and weights of
// section IV (TLS), docs/derivation.md 3.3. `bound2`: where the loss is cut off [rad^2].
bool graduate(const std::vector<TrackCost>& costs, double bound2, const Prior& prior, Vector9d* x) {
  std::vector<double> weight(costs.size(), 1.0);
  if (!solveWeighted(costs, weight, prior, x)) return false;
  double largest = 0.0;
  for (const TrackCost& cost : costs) {
    if (cost.rows > 0) largest = std::max(largest, cost(*x));
  }
  // mu grows from a nearly convex surrogate to the truncated cost.
  double mu = largest > bound2 ? bound2 / (2.0 * largest - bound2) : kTruncated;
  for (int i = 0; i < kMaxGraduations && mu < kTruncated; ++i, mu *= kGraduation) {
    bool settled = true;
    for (std::size_t t = 0; t < costs.size(); ++t) {
      if (costs[t].rows == 0) continue;
      const double residual2 = costs[t](*x);
      const double low = mu / (mu + 1.0) * bound2, high = (mu + 1.0) / mu * bound2;
      weight[t] = 0.0;
      if (residual2 <= low) weight[t] = 1.0;
      if (residual2 > low && residual2 < high) {
        weight[t] = std::sqrt(bound2 * mu * (mu + 1.0) / residual2) - mu;
        settled = false;
      }
    }
    if (!solveWeighted(costs, weight, prior, x)) return false;
    if (settled) break;
  }
  return true;
}

}  // namespace

std::optional<ConsistentTracks> consistentTracks(const InitWindow& window,
                                                 const LinearMotion& motion,
                                                 double accel_bias_prior) {
  const std::vector<Track>& tracks = window.pointTracks();
  const std::vector<WindowPoint>& observations = window.pointObservations();
  const Calibration& calibration = window.calibration();
  const double sigma_rad = calibration.sigmaBearing();
  const Eigen::VectorXd c0 = motion.position0 + motion.lever;
  const Prior prior = {sigma_rad, calibration.gravity_magnitude, accel_bias_prior};
  const double bound2 = kAgreementSigmas * kAgreementSigmas * sigma_rad * sigma_rad;

  ConsistentTracks out;
  std::vector<TrackCost> costs(tracks.size());
  std::vector<Eigen::Vector3d> u;
  Eigen::VectorXd centres;  // not known until the first pass has an answer
  for (int pass = 0; pass < kDistancePasses; ++pass) {
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      u.clear();
      for (int s = tracks[t].begin; s < tracks[t].end; ++s) {
        u.push_back(motion.R_b0_bk[observations[s].keyframe] * calibration.R_b_c *
                    observations[s].bearing);
      }
      costs[t] = costOf(&observations[tracks[t].begin], u, motion, c0, centres);
    }
    if (!graduate(costs, bound2, prior, &out.x)) return std::nullopt;
    centres = motion.position * out.x + c0;
  }
  for (const TrackCost& cost : costs) {
    out.agrees.push_back(cost.rows == 0 || cost(out.x) <= bound2 ? 1 : 0);
  }
  return out;
}

}  // namespace slim_init
