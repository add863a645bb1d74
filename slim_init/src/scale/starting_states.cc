// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/starting_states.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "data/derived_window.h"
#include "estimation/speed_factor.h"
#include "geometry/robust.h"
#include "scale/gravity_constrained.h"
#include "shape/ligt.h"

namespace slim_init {
namespace {

// Floor of the distance to a point [m]: a row is divided by it.
constexpr double kMinDistance = 1e-3;
// Rows turn into angles by distances that the first pass finds; the second one uses them.
constexpr int kDistancePasses = 2;
// Factor from one surrogate of the truncated loss to the next, as Yang et al. 2020.
constexpr double kGraduation = 1.4;
// Control parameter mu from which the surrogate is the truncated loss to a thousandth.
constexpr double kTruncated = 1e3;
// 1.4^40 = 7e5: mu reaches kTruncated from any start above 1.5e-3.
constexpr int kMaxGraduations = 40;

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
  if (base.parallax2 < kSmallestAngle * kSmallestAngle) return cost;
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

// The normal matrix of stacked 3-vectors after a rotation of their frame.
Eigen::MatrixXd rotated(const Eigen::MatrixXd& H, const Eigen::Matrix3d& R) {
  Eigen::MatrixXd out(H.rows(), H.cols());
  for (Eigen::Index i = 0; i < H.rows(); i += 3) {
    for (Eigen::Index j = 0; j < H.cols(); j += 3) {
      out.block<3, 3>(i, j) = R * H.block<3, 3>(i, j) * R.transpose();
    }
  }
  return out;
}

// The measured velocities as a cost of x: with the shape they give the scale. A slipping wheel is
// the refinement's matter.
void addSpeeds(const InitWindow& window, LinearMotion* motion) {
  const std::vector<SpeedFactor> speeds = speedFactors(window, 0.0);
  if (speeds.empty()) return;
  const std::vector<ImuInstant> instants =
      imuInstants(window, 0.0, motion->gyro_bias, Eigen::Vector3d::Zero());
  const WindowState at_zero = motion->at(Eigen::Matrix<double, 9, 1>::Zero());
  for (const SpeedFactor& speed : speeds) {
    const SpeedResidual residual =
        speedResidual(at_zero, speed, window.calibration(), instants[speed.keyframe].rate);
    const Eigen::Matrix<double, 3, 9> by_x =
        residual.J.middleCols<3>(3) * motion->velocity.middleRows<3>(3 * speed.keyframe);
    motion->speed_information += by_x.transpose() * by_x;
    motion->speed_gradient -= by_x.transpose() * residual.r;
    motion->speed_cost += residual.r.squaredNorm();
  }
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
  const double bound2 = kOutlierSigmas * kOutlierSigmas * sigma_rad * sigma_rad;

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

std::optional<WindowState> startingState(const InitWindow& window,
                                         const std::vector<Preintegration>& pre,
                                         const TranslationEstimate& translation,
                                         const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  LinearMotion motion = linearMotion(pre, chainRotations(pre), calibration.t_b_c);
  addSpeeds(window, &motion);
  const Eigen::Matrix3Xd shape_b0 = calibration.R_b_c * translation.centres_c0;
  const Eigen::MatrixXd H_b0 = rotated(translation.normal_matrix, calibration.R_b_c);
  const int observations = static_cast<int>(window.pointObservations().size());
  const ReverseEstimate reverse =
      alignReverse(motion, shape_b0, H_b0 * (observations / translation.noise()),
                   calibration.gravity_magnitude, inertial.accel_bias_prior);
  if (!reverse.valid) return std::nullopt;
  WindowState state = motion.at(reverse.x);
  // From the shape, not from the IMU: the error is then in the inertial part, whose cost is
  // quadratic and corrected in one step; residuals of tens of pixels would lie on the flat part
  // of the robust loss.
  for (int k = 0; k < window.size(); ++k) {
    state.p_b0.col(k) = reverse.scale * (shape_b0.col(k) - shape_b0.col(0)) -
                        (motion.lever.segment<3>(3 * k) - motion.lever.head<3>());
  }
  return state;
}

std::optional<WindowState> inertialStartingState(const InitWindow& window,
                                                 const std::vector<Preintegration>& pre,
                                                 const InertialOptions& inertial) {
  const LinearMotion motion = linearMotion(pre, chainRotations(pre), window.calibration().t_b_c);
  const auto consistent = consistentTracks(window, motion, inertial.accel_bias_prior);
  if (!consistent) return std::nullopt;
  return motion.at(consistent->x);
}

std::optional<WindowState> consistentStartingState(const InitWindow& window,
                                                   const std::vector<Preintegration>& pre,
                                                   const InertialOptions& inertial) {
  const Calibration& calibration = window.calibration();
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const auto consistent = consistentTracks(window, linearMotion(pre, R_b0_bk, calibration.t_b_c),
                                           inertial.accel_bias_prior);
  if (!consistent) return std::nullopt;
  std::vector<char> keep(window.pointObservations().size(), kKeepObservation);
  bool all = true;
  for (std::size_t t = 0; t < consistent->agrees.size(); ++t) {
    if (consistent->agrees[t]) continue;
    all = false;
    const Track& track = window.pointTracks()[t];
    std::fill(keep.begin() + track.begin, keep.begin() + track.end, kDropObservation);
  }
  if (all) return std::nullopt;
  const std::shared_ptr<const InitWindow> agreeing = withObservations(window, keep);
  const TranslationEstimate translation =
      estimateTranslations(*agreeing, cameraRotations(R_b0_bk, calibration.R_b_c));
  if (!translation.valid) return std::nullopt;
  return startingState(*agreeing, pre, translation, inertial);
}

}  // namespace slim_init
