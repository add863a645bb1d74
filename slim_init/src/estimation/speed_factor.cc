// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/speed_factor.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "geometry/robust.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

// Re-weightings of the speeds and their common error at one state: an error that the motion
// contradicts is free after these.
constexpr int kSpeedScalePasses = 12;
// A speed, or their common error, with a smaller weight is contradicted: 3.6 standard deviations.
constexpr double kContradictedSpeed = 0.17;

// Between two samples. Their errors are not averaged: the next keyframe may lie between the same.
SpeedFactor interpolated(const SpeedSample& a, const SpeedSample& b, double u,
                         double lateral_sigma) {
  SpeedFactor factor;
  factor.velocity = (1.0 - u) * a.velocity + u * b.velocity;
  Eigen::Matrix3d covariance = (1.0 - u) * a.covariance + u * b.covariance;
  if (a.forward_only || b.forward_only) {
    factor.velocity.tail<2>().setZero();
    const double forward = covariance(0, 0);
    covariance = (lateral_sigma * lateral_sigma) * Eigen::Matrix3d::Identity();
    covariance(0, 0) = forward;
    factor.rows = lateral_sigma > 0.0 ? 3 : 1;
  }
  const int n = factor.rows;
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance.topLeftCorner(n, n));
  factor.W.topLeftCorner(n, n) = llt.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
  return factor;
}

}  // namespace

std::vector<SpeedFactor> speedFactors(const InitWindow& window, double td_shift) {
  const std::vector<SpeedSample>& speeds = window.speeds();
  std::vector<SpeedFactor> factors;
  for (int k = 0; k < window.size(); ++k) {
    const double t = window.times()[k] + td_shift;
    const auto after =
        std::lower_bound(speeds.begin(), speeds.end(), t,
                         [](const SpeedSample& s, double time) { return s.t < time; });
    if (after == speeds.end() || (after == speeds.begin() && after->t > t)) continue;
    const auto before = after == speeds.begin() ? after : std::prev(after);
    const double gap = after->t - before->t;
    if (after->t > t && gap > InitWindow::kMaxSpeedGap) continue;
    factors.push_back(interpolated(*before, *after, gap > 0.0 ? (t - before->t) / gap : 1.0,
                                   window.calibration().speed_sensor.lateral_sigma));
    factors.back().keyframe = k;
  }
  return factors;
}

SpeedResidual speedResidual(const WindowState& state, const SpeedFactor& factor,
                            const Calibration& calibration, const Eigen::Vector3d& rate) {
  const SpeedSensor& sensor = calibration.speed_sensor;
  const BodyOffset offset(state.rig, calibration);
  const Eigen::Matrix3d R_s_b = sensor.R_b_s.transpose();
  const Eigen::Vector3d v_b =
      (state.R_b0_bk[factor.keyframe] * offset.R).transpose() * state.v_b0.col(factor.keyframe);
  SpeedResidual out;
  out.by_scale = factor.W * (R_s_b * (v_b + rate.cross(sensor.t_b_s)));
  out.r = out.by_scale - factor.W * factor.velocity;
  const Eigen::Matrix3d WR = factor.W * R_s_b;
  const Eigen::Matrix3d by_attitude = WR * skew(v_b);
  out.J << by_attitude * offset.R.transpose(),
      WR * (state.R_b0_bk[factor.keyframe] * offset.R).transpose(), WR * skew(sensor.t_b_s),
      -by_attitude * offset.R_b_c;
  return out;
}

SpeedFit fitSpeeds(const std::vector<SpeedResidual>& residuals, double scale_sigma) {
  SpeedFit fit;
  fit.use.keyframes = static_cast<int>(residuals.size());
  fit.weights.assign(residuals.size(), 1.0);
  for (int pass = 0; pass < kSpeedScalePasses; ++pass) {
    double information = fit.scale_weight / (scale_sigma * scale_sigma), gradient = 0.0;
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const SpeedResidual& one = residuals[i];
      information += fit.weights[i] * one.by_scale.squaredNorm();
      gradient += fit.weights[i] * one.by_scale.dot(one.r);
    }
    fit.use.scale_error = -gradient / information;
    const double z = fit.use.scale_error / scale_sigma;
    fit.cost = gemanMcClureCost(z * z);
    fit.scale_weight = gemanMcClure(z * z);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const SpeedResidual& one = residuals[i];
      const double z2 = (one.r + fit.use.scale_error * one.by_scale).squaredNorm();
      fit.cost += gemanMcClureCost(z2);
      fit.weights[i] = gemanMcClure(z2);
    }
  }
  fit.use.contradicted =
      static_cast<int>(std::count_if(fit.weights.begin(), fit.weights.end(), [&fit](double weight) {
        return std::min(weight, fit.scale_weight) < kContradictedSpeed;
      }));
  return fit;
}

}  // namespace slim_init
