// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/imu_propagation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "slim_init/text.h"

namespace slim_init::host_health {
namespace {

constexpr double kHealthyTilt = 0.5 / 57.29577951308232;  // [rad]
constexpr double kHealthyVelocity = 0.1;                  // [m/s]
constexpr double kHealthyGyroBias = 2e-3;                 // [rad/s]
constexpr double kHealthyAccelBias = 0.05;                // [m/s^2]

}  // namespace

Eigen::Matrix3d skewOf(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Eigen::Matrix3d expOf(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + skewOf(v);
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

Eigen::Vector3d logOf(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

ImuSample between(const ImuSample& a, const ImuSample& b, double t) {
  const double weight = (t - a.t) / (b.t - a.t);
  ImuSample sample;
  sample.t = t;
  sample.accel = a.accel + weight * (b.accel - a.accel);
  sample.gyro = a.gyro + weight * (b.gyro - a.gyro);
  return sample;
}

double PropagatedState::positionSigma() const {
  return std::sqrt(covariance.diagonal().segment<3>(6).maxCoeff());
}
double PropagatedState::velocitySigma() const {
  return std::sqrt(covariance.diagonal().segment<3>(3).maxCoeff());
}
double PropagatedState::yawSigma() const { return std::sqrt(covariance(2, 2)); }

PropagatedCovariance healthyCovariance() {
  Eigen::Matrix<double, 15, 1> sigma;
  sigma << kHealthyTilt, kHealthyTilt, 0.0, Eigen::Vector3d::Constant(kHealthyVelocity),
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(kHealthyGyroBias),
      Eigen::Vector3d::Constant(kHealthyAccelBias);
  return sigma.cwiseAbs2().asDiagonal();
}

// Errors of attitude to the right of R_w_b, and position before velocity.
StatePrior toStatePrior(const PropagatedState& propagated) {
  PropagatedCovariance T = PropagatedCovariance::Zero();
  T.block<3, 3>(0, 0) = propagated.state.R_w_b.transpose();
  T.block<3, 3>(3, 6).setIdentity();
  T.block<3, 3>(6, 3).setIdentity();
  T.block<6, 6>(9, 9).setIdentity();
  StatePrior prior;
  prior.state = propagated.state;
  prior.covariance = T * propagated.covariance * T.transpose();
  return prior;
}

std::vector<ImuSample> samplesBetween(const std::deque<ImuSample>& samples, double t_i,
                                      double t_j) {
  std::vector<ImuSample> result;
  if (samples.empty() || !(t_i < t_j) || t_i < samples.front().t || t_j > samples.back().t) {
    return result;
  }
  const auto after = [](double t, const ImuSample& s) { return t < s.t; };
  auto it = std::upper_bound(samples.begin(), samples.end(), t_i, after);
  result.push_back(it == samples.end() ? samples.back() : between(*std::prev(it), *it, t_i));
  for (; it != samples.end() && it->t < t_j; ++it) result.push_back(*it);
  if (it != samples.end()) result.push_back(between(*std::prev(it), *it, t_j));
  return result;
}

ImuWidening wideningOf(const std::deque<ImuDamage>& damage, double t_i, double t_j) {
  ImuWidening result;
  for (const ImuDamage& d : damage) {
    const double hole = std::min(d.last, t_j) - std::max(d.first, t_i);
    if (hole <= 0.0) continue;
    result.damaged = true;
    result.sigma_theta = std::hypot(result.sigma_theta, d.gyro_sigma * hole);
    result.sigma_v = std::hypot(result.sigma_v, d.accel_sigma * hole);
    result.sigma_p = std::hypot(result.sigma_p, 0.5 * d.accel_sigma * hole * (t_j - t_i));
  }
  return result;
}

bool propagateState(const PropagatedState& from, double t, const std::deque<ImuSample>& samples,
                    const std::deque<ImuDamage>& damage, const Eigen::Vector3d& gravity_w,
                    const ImuNoise& noise, PropagatedState* result, std::string* error) {
  if (t <= from.state.t) {
    *result = from;
    return true;
  }
  const std::vector<ImuSample> path = samplesBetween(samples, from.state.t, t);
  if (path.empty()) {
    *error = text("the IMU data do not cover the ", t - from.state.t,
                  " s over which a state is to be propagated");
    return false;
  }
  PropagatedState c = from;
  const Eigen::Vector3d bg = c.state.gyro_bias, ba = c.state.accel_bias;
  PropagatedCovariance F = PropagatedCovariance::Identity();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double dt = path[i].t - path[i - 1].t;
    if (!(dt > 0.0)) continue;
    const Eigen::Matrix3d R = c.state.R_w_b;
    const Eigen::Vector3d rate = 0.5 * (path[i - 1].gyro + path[i].gyro) - bg;
    const Eigen::Matrix3d R_next = R * expOf(rate * dt);
    const Eigen::Vector3d force =
        0.5 * (R * (path[i - 1].accel - ba) + R_next * (path[i].accel - ba));
    F.setIdentity();
    F.block<3, 3>(0, 9) = -R * dt;
    F.block<3, 3>(3, 0) = -skewOf(force) * dt;
    F.block<3, 3>(3, 12) = -R * dt;
    F.block<3, 3>(6, 3) = Eigen::Matrix3d::Identity() * dt;
    c.covariance = F * c.covariance * F.transpose();
    // What lies between two samples is known to their difference.
    const double gyro_step = 0.5 * (path[i].gyro - path[i - 1].gyro).norm() * dt;
    const double accel_step = 0.5 * (path[i].accel - path[i - 1].accel).norm() * dt;
    const double q_theta =
        noise.gyro_density * noise.gyro_density * dt + gyro_step * gyro_step / 3.0;
    const double q_v =
        noise.accel_density * noise.accel_density * dt + accel_step * accel_step / 3.0;
    c.covariance.diagonal().segment<3>(0).array() += q_theta;
    c.covariance.diagonal().segment<3>(3).array() += q_v;
    for (const ImuDamage& d : damage) {
      const double begin = std::max(path[i - 1].t, std::max(d.first, from.state.t));
      const double end = std::min(path[i].t, d.last);
      if (end <= begin) continue;
      // Constant over the interval, so that its parts add up and not their squares.
      const double first = std::max(d.first, from.state.t);
      const double grown = (end - first) * (end - first) - (begin - first) * (begin - first);
      const double accel = d.accel_sigma * d.accel_sigma * grown;
      c.covariance.diagonal().segment<3>(0).array() += d.gyro_sigma * d.gyro_sigma * grown;
      c.covariance.diagonal().segment<3>(3).array() += accel;
      c.covariance.diagonal().segment<3>(6).array() += 0.25 * accel * (end - first) * (end - first);
    }
    c.state.p_w_b += c.state.v_w_b * dt + 0.5 * (force + gravity_w) * dt * dt;
    c.state.v_w_b += (force + gravity_w) * dt;
    c.state.R_w_b = R_next;
    c.state.t = path[i].t;
  }
  c.state.t = t;
  *result = c;
  return true;
}

}  // namespace slim_init::host_health
