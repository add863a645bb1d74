// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/metrics.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "reference_so3.h"
#include "slim_init/evaluation/truth.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

// A cloud whose root-mean-square radius is below this has no shape to align [m].
constexpr double kMinSpread = 1e-9;

// Thresholds of DRT's release.
constexpr double kExcitationBound = 5e-3;
constexpr int kMaxQuietPairs = 1;

// A truth belongs to a state when their times are the same but for rounding [s].
constexpr double kSameTime = 1e-6;

constexpr double kNoBound = std::numeric_limits<double>::infinity();
constexpr double kRadToDeg = 57.29577951308232;

using Points = Eigen::Map<const Eigen::Matrix3Xd>;

// One point a column.
Points columnsOf(const std::vector<Eigen::Vector3d>& points) {
  return Points(points.empty() ? nullptr : points.front().data(), 3,
                static_cast<Eigen::Index>(points.size()));
}

Eigen::Matrix3Xd centred(const Points& points) {
  return points.colwise() - Eigen::Vector3d(points.rowwise().mean());
}

// atan2 keeps small angles, which acos of a dot product loses.
double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

bool finite(const NavState& state) {
  return state.R_w_b.allFinite() && state.p_w_b.allFinite() && state.v_w_b.allFinite();
}

Eigen::Vector3d meanGyroBias(const std::vector<NavState>& truth) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const NavState& state : truth) sum += state.gyro_bias / static_cast<double>(truth.size());
  return sum;
}

/// Does not exist for a true bias of zero.
double biasErrorPercent(const Eigen::Vector3d& bias, const Eigen::Vector3d& true_bias) {
  if (!(true_bias.norm() > 0.0)) return kNotComputed;
  return 100.0 * std::abs(bias.norm() - true_bias.norm()) / true_bias.norm();
}

std::string findNotFinite(const InitResult& result, const std::vector<NavState>& truth) {
  for (std::size_t k = 0; k < truth.size(); ++k) {
    if (!finite(result.states[k])) {
      return "estimate at keyframe " + std::to_string(k) + " is not finite";
    }
    if (std::abs(result.states[k].t - truth[k].t) > kSameTime) {  // false without times
      return "ground truth at keyframe " + std::to_string(k) + " is that of another time";
    }
    if (!finite(truth[k]) || !truth[k].gyro_bias.allFinite()) {
      return "ground truth at keyframe " + std::to_string(k) + " is not finite";
    }
  }
  if (!result.gravity_b0.allFinite()) return "estimated gravity is not finite";
  if (!(result.gravity_b0.norm() > 0.0)) return "estimated gravity is zero";
  if (!result.gyro_bias.allFinite()) return "estimated gyro bias is not finite";
  return "";
}

// Specific force integrated in the frame of the first body.
Eigen::Vector3d integrateForce(const std::vector<InertialStep>& steps) {
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_bi_b = Eigen::Matrix3d::Identity();
  for (const InertialStep& step : steps) {
    const Eigen::Matrix3d half = reference::expSo3(0.5 * step.dt * step.gyro);
    const Eigen::Vector3d force = R_bi_b * half * step.accel;
    dv += force * step.dt;
    R_bi_b = R_bi_b * half * half;
  }
  return dv;
}

}  // namespace

std::string alignSimilarity(const std::vector<Eigen::Vector3d>& source,
                            const std::vector<Eigen::Vector3d>& target, Similarity* similarity) {
  const std::size_t n = source.size();
  if (n != target.size()) {
    return "alignment of " + std::to_string(n) + " points to " + std::to_string(target.size());
  }
  if (n < 2) return "alignment of " + std::to_string(n) + " points (minimum 2)";
  const Points from = columnsOf(source), to = columnsOf(target);
  const Eigen::Matrix3Xd x = centred(from), y = centred(to);
  const double spread = std::sqrt(x.squaredNorm() / static_cast<double>(n));
  // Finite values can still overflow.
  if (!std::isfinite(spread) || !std::isfinite(y.squaredNorm())) {
    return "alignment of points that are not finite";
  }
  if (!(spread > kMinSpread)) {
    return text("estimated positions are spread over ", spread, " m (minimum for an alignment ",
                kMinSpread, " m)");
  }
  similarity->R = Eigen::umeyama(x, y, /*with_scaling=*/false).topLeftCorner<3, 3>();
  similarity->s = y.cwiseProduct(similarity->R * x).sum() / x.squaredNorm();
  similarity->t = to.rowwise().mean() - similarity->s * similarity->R * from.rowwise().mean();
  return "";
}

Eigen::Vector3d HeadingAlignment::apply(const Eigen::Vector3d& p) const {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * p + t;
}

HeadingAlignment alignHeading(const std::vector<Eigen::Vector3d>& source,
                              const std::vector<Eigen::Vector3d>& target) {
  const Points from = columnsOf(source), to = columnsOf(target);
  const Eigen::Matrix3Xd x = centred(from), y = centred(to);
  const double sine = x.row(0).dot(y.row(1)) - x.row(1).dot(y.row(0));
  const double cosine = x.row(0).dot(y.row(0)) + x.row(1).dot(y.row(1));
  HeadingAlignment alignment;
  alignment.yaw = std::atan2(sine, cosine);
  alignment.t = to.rowwise().mean() - alignment.apply(from.rowwise().mean());
  return alignment;
}

WindowMetrics evaluateWindow(const InitResult& result, const std::vector<NavState>& truth) {
  WindowMetrics metrics;
  const auto setGravityAndBias = [&](WindowMetrics* m) {
    const Eigen::Vector3d true_bias = meanGyroBias(truth);
    const Eigen::Vector3d true_gravity =
        truth.front().R_w_b.transpose() * -Eigen::Vector3d::UnitZ();
    m->gravity_error_deg = kRadToDeg * angleBetween(result.gravity_b0, true_gravity);
    m->gyro_bias_vec_err = (result.gyro_bias - true_bias).norm();
    m->gyro_bias_err_pct = biasErrorPercent(result.gyro_bias, true_bias);
  };
  if (result.states.empty()) {
    if (!truth.empty()) setGravityAndBias(&metrics);
    metrics.failure = "no estimate";
    return metrics;
  }
  if (result.states.size() != truth.size()) {
    metrics.failure = "estimate has " + std::to_string(result.states.size()) + " states for " +
                      std::to_string(truth.size()) + " keyframes";
    return metrics;
  }
  metrics.failure = findNotFinite(result, truth);
  if (!metrics.computed()) return metrics;

  const std::size_t n = truth.size();
  std::vector<Eigen::Vector3d> estimated_p;
  std::vector<Eigen::Vector3d> true_p;
  for (std::size_t k = 0; k < n; ++k) {
    estimated_p.push_back(result.states[k].p_w_b);
    true_p.push_back(truth[k].p_w_b);
  }
  Similarity similarity;
  metrics.failure = alignSimilarity(estimated_p, true_p, &similarity);
  if (!metrics.computed()) return metrics;

  const Eigen::Matrix3d R_b0_w = result.states.front().R_w_b.transpose();
  const Eigen::Matrix3d true_R_b0_w = truth.front().R_w_b.transpose();
  // A path of two seconds is nearly planar, so that the rotation of the similarity hides an
  // estimate that runs the wrong way. Seen from the first body it cannot hide.
  const Points from = columnsOf(estimated_p), to = columnsOf(true_p);
  const double agreement = (R_b0_w * centred(from)).cwiseProduct(true_R_b0_w * centred(to)).sum();
  const Eigen::Matrix3Xd aligned = (similarity.s * similarity.R * from).colwise() + similarity.t;
  double speed_sum = 0.0;
  double velocity_sum = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d& v = result.states[k].v_w_b;
    const Eigen::Vector3d& true_v = truth[k].v_w_b;
    const double speed_error = v.norm() - true_v.norm();
    speed_sum += speed_error * speed_error;
    velocity_sum += (R_b0_w * v - true_R_b0_w * true_v).squaredNorm();
  }
  const double count = static_cast<double>(n);
  WindowMetrics computed;
  computed.scale = agreement < 0.0 ? -similarity.s : similarity.s;
  computed.scale_error = std::abs(computed.scale - 1.0);
  computed.pose_rmse = std::sqrt((to - aligned).squaredNorm() / count);
  computed.velocity_rmse = std::sqrt(speed_sum / count);
  computed.velocity_vec_rmse = std::sqrt(velocity_sum / count);
  setGravityAndBias(&computed);
  // Finite input can still overflow.
  for (const double value :
       {computed.scale, computed.pose_rmse, computed.velocity_rmse, computed.velocity_vec_rmse,
        computed.gravity_error_deg, computed.gyro_bias_vec_err}) {
    if (!std::isfinite(value)) {
      metrics.failure = "an error of the estimate is not finite";
      return metrics;
    }
  }
  return computed;
}

CalibrationDifference calibrationDifference(const Calibration& calibration,
                                            const Calibration& truth) {
  const Eigen::Matrix3d turn = truth.R_b_c.transpose() * calibration.R_b_c;
  return {calibration.td - truth.td, kRadToDeg * reference::logSo3(turn).norm(),
          calibration.readout_s - truth.readout_s};
}

CalibrationErrors evaluateCalibration(const CalibrationEstimate& estimate,
                                      const Calibration& truth) {
  CalibrationErrors errors;
  const Eigen::Vector3d turn = reference::logSo3(truth.R_b_c.transpose() * estimate.R_b_c);
  errors.td_s = estimate.td - truth.td;
  errors.rotation_deg = kRadToDeg * turn.norm();
  // Of a global shutter that was taken for one there is nothing to say.
  if (truth.readout_s > 0.0 || estimate.readout_s > 0.0) {
    errors.readout_s = estimate.readout_s - truth.readout_s;
  }
  const auto sigma = [](double value) { return value > 0.0 ? value : kNotComputed; };
  errors.td_sigma_s = sigma(estimate.tdSigma());
  errors.rotation_sigma_deg = sigma(estimate.rotationSigmaDeg());
  errors.readout_sigma_s = sigma(estimate.readoutSigma());
  const Eigen::LLT<Eigen::Matrix3d> factor(estimate.covariance.topLeftCorner<3, 3>());
  if (factor.info() == Eigen::Success) {
    errors.rotation_over_sigma = factor.matrixL().solve(turn).norm() / std::sqrt(3.0);
  }
  return errors;
}

Excitation measureExcitation(const InitWindow& window) {
  Excitation excitation;
  const double g = window.calibration().gravity_magnitude;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<InertialStep> steps;
  for (int k = 0; k + 1 < window.size(); ++k) {
    const double t0 = window.times()[k];
    const double t1 = window.times()[k + 1];
    // A window never reaches across a gap, so no further bound is needed here.
    if (!inertialSteps(window.imu(), t0, t1, kNoBound, &steps)) return Excitation();
    const Eigen::Vector3d mean_force = integrateForce(steps) / (t1 - t0);
    sum += mean_force;
    if (std::abs(mean_force.norm() - g) / g < kExcitationBound) ++excitation.quiet_pairs;
  }
  const Eigen::Vector3d mean_force = sum / static_cast<double>(window.size() - 1);
  excitation.mean_deviation = std::abs(mean_force.norm() - g) / g;
  excitation.excited =
      excitation.mean_deviation > kExcitationBound && excitation.quiet_pairs <= kMaxQuietPairs;
  return excitation;
}

}  // namespace slim_init::evaluation
