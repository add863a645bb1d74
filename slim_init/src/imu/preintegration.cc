// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/preintegration.h"

#include <algorithm>
#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

// What samples that are missing would have said is no white noise: the longer nobody looked, the
// less the mean of both ends says about the mean between them. Variance per interval that is
// missing, in those that the assumed densities make of the same time; fitted to 0.01 to 0.1 s taken
// out of five recorded flights (docs/derivation.md, 4.2).
constexpr double kGyroUnseen = 35.0;
constexpr double kAccelUnseen = 4.5;

ImuNoise noiseBetween(const ImuNoise& noise, double intervals) {
  if (!(intervals > kMissing)) return noise;
  return {noise.gyro_density * std::sqrt(kGyroUnseen * intervals),
          noise.accel_density * std::sqrt(kAccelUnseen * intervals)};
}

ImuSample interpolate(const ImuSample& a, const ImuSample& b, double t) {
  const double w = (t - a.t) / (b.t - a.t);
  ImuSample out;
  out.t = t;
  out.gyro = a.gyro + w * (b.gyro - a.gyro);
  out.accel = a.accel + w * (b.accel - a.accel);
  return out;
}

// What a step hands to the propagation of its covariance: Exp and right Jacobian of the rotation, R
// [f]x at both ends, derivative of the mean acceleration by the accelerometer bias.
struct StepDerivatives {
  const Eigen::Matrix3d &E, &Jr, &Rf_a, &Rf_b, &dacc_dba;
};

// Linear error propagation over the step, block by block (a product of 9x9 matrices would spend
// most of its time on zeros):
//   theta' = E^T theta + h Jr n_g
//   v'     = v + G theta + h D n_g + h R n_a      G = d v'/d theta, D = its
//   gyro noise part p'     = p + h v + h/2 (v' - v)
// The white noise of the averaged samples is that of one sample per step: neighbouring steps share
// samples, so that the average loses nothing in sum.
inline void propagateCovariance(const StepDerivatives& at, double h, const ImuNoise& noise,
                                Matrix9d* covariance) {
  const double var_gyro = noise.gyro_density * noise.gyro_density / h;
  const double var_accel = noise.accel_density * noise.accel_density / h;
  const Eigen::Matrix3d& E = at.E;
  const Eigen::Matrix3d G = -0.5 * h * (at.Rf_a + at.Rf_b * E.transpose());
  const Eigen::Matrix3d B = h * at.Jr;
  const Eigen::Matrix3d D = -0.5 * h * at.Rf_b * B;
  Matrix9d& P = *covariance;
  const Eigen::Matrix3d tt = P.block<3, 3>(0, 0), tv = P.block<3, 3>(0, 3);
  const Eigen::Matrix3d tp = P.block<3, 3>(0, 6), vv = P.block<3, 3>(3, 3);
  const Eigen::Matrix3d vp = P.block<3, 3>(3, 6), pp = P.block<3, 3>(6, 6);
  // Noise of the step: on theta, on the velocity increment, and between them.
  const Eigen::Matrix3d n_tt = var_gyro * B * B.transpose();
  const Eigen::Matrix3d n_tv = var_gyro * B * D.transpose();
  const Eigen::Matrix3d n_vv =
      var_gyro * D * D.transpose() + var_accel * h * h * at.dacc_dba * at.dacc_dba.transpose();
  // u = G theta + noise, the error of the velocity increment, against everything before the step.
  const Eigen::Matrix3d ut = G * tt, uv = G * tv, up = G * tp;
  const Eigen::Matrix3d uu = ut * G.transpose() + n_vv;
  const Eigen::Matrix3d Et = E.transpose();
  const Eigen::Matrix3d vu = uv.transpose();
  P.block<3, 3>(0, 0) = Et * tt * E + n_tt;
  P.block<3, 3>(0, 3) = Et * (tv + ut.transpose()) + n_tv;
  P.block<3, 3>(0, 6) = Et * (tp + h * tv + 0.5 * h * ut.transpose()) + 0.5 * h * n_tv;
  P.block<3, 3>(3, 3) = vv + uv + vu + uu;
  P.block<3, 3>(3, 6) = vp + h * vv + 0.5 * h * vu + up + h * uv + 0.5 * h * uu;
  const Eigen::Matrix3d half = h * vp.transpose() + 0.5 * h * up.transpose() + 0.5 * h * h * vu;
  P.block<3, 3>(6, 6) = pp + half + half.transpose() + h * h * vv + 0.25 * h * h * uu;
  P.block<3, 3>(3, 0) = P.block<3, 3>(0, 3).transpose();
  P.block<3, 3>(6, 0) = P.block<3, 3>(0, 6).transpose();
  P.block<3, 3>(6, 3) = P.block<3, 3>(3, 6).transpose();
}

// One trapezoidal step from sample a to sample b.
void step(const ImuSample& a, const ImuSample& b, const ImuNoise& noise, PreintegrationParts parts,
          Preintegration* out) {
  Preintegration& pre = *out;
  const double h = b.t - a.t;
  const Eigen::Vector3d theta = h * (0.5 * (a.gyro + b.gyro) - pre.gyro_bias);
  const internal::Rodrigues k(theta.squaredNorm());
  const Eigen::Matrix3d K = skew(theta);
  const Eigen::Matrix3d K2 = theta * theta.transpose() -
                             theta.squaredNorm() * Eigen::Matrix3d::Identity();  // K * K, cheaper
  const Eigen::Matrix3d E = Eigen::Matrix3d::Identity() + k.a * K + k.b * K2;
  const Eigen::Matrix3d Jr = Eigen::Matrix3d::Identity() - k.b * K + k.c * K2;

  const Eigen::Matrix3d dR_a = pre.dR;
  const Eigen::Matrix3d J_a = pre.dR_dbg;
  pre.dR = dR_a * E;
  pre.dR_dbg = E.transpose() * J_a - h * Jr;
  pre.dt += h;
  if (parts == PreintegrationParts::kRotation) return;

  const Eigen::Vector3d f_a = a.accel - pre.accel_bias;
  const Eigen::Vector3d f_b = b.accel - pre.accel_bias;
  const Eigen::Vector3d acc = 0.5 * (dR_a * f_a + pre.dR * f_b);
  // d(R f)/d b_g = -R [f]x J, at both ends of the step.
  const Eigen::Matrix3d Rf_a = dR_a * skew(f_a);
  const Eigen::Matrix3d Rf_b = pre.dR * skew(f_b);
  const Eigen::Matrix3d dacc_dbg = -0.5 * (Rf_a * J_a + Rf_b * pre.dR_dbg);
  const Eigen::Matrix3d dacc_dba = -0.5 * (dR_a + pre.dR);

  if (parts == PreintegrationParts::kWithCovariance) {
    propagateCovariance({E, Jr, Rf_a, Rf_b, dacc_dba}, h, noise, &pre.covariance);
  }

  pre.dp += h * pre.dv + 0.5 * h * h * acc;
  pre.dp_dbg += h * pre.dv_dbg + 0.5 * h * h * dacc_dbg;
  pre.dp_dba += h * pre.dv_dba + 0.5 * h * h * dacc_dba;
  pre.dv += h * acc;
  pre.dv_dbg += h * dacc_dbg;
  pre.dv_dba += h * dacc_dba;
}

// A sensor in motion against its data sheet: three times what recorded flights show over windows
// (docs/derivation.md, 4.2), since here nothing measures it.
constexpr double kInMotion = 10.0;

constexpr int kTheta = 0, kPosition = 3, kVelocity = 6, kGyroBias = 9, kAccelBias = 12;

}  // namespace

Preintegration preintegrate(const std::vector<ImuSample>& samples, double t_i, double t_j,
                            const BiasPoint& biases, const ImuNoise& noise,
                            PreintegrationParts parts) {
  Preintegration pre;
  pre.gyro_bias = biases.gyro;
  pre.accel_bias = biases.accel;
  // First sample after t_i; the one before it opens the interval.
  auto next = std::upper_bound(samples.begin(), samples.end(), t_i,
                               [](double t, const ImuSample& s) { return t < s.t; });
  if (next == samples.begin() || next == samples.end()) return pre;
  const double interval =
      (samples.back().t - samples.front().t) / static_cast<double>(samples.size() - 1);
  ImuSample at = interpolate(*(next - 1), *next, t_i);
  for (; next != samples.end() && at.t < t_j; ++next) {
    const ImuSample& before = *(next - 1);
    const ImuSample end = next->t < t_j ? *next : interpolate(before, *next, t_j);
    step(at, end, noiseBetween(noise, (next->t - before.t) / interval), parts, &pre);
    at = end;
  }
  return pre;
}

double coveredShift(const InitWindow& window, double shift) {
  return std::clamp(shift, window.imu().front().t - window.times().front(),
                    window.imu().back().t - window.times().back());
}

std::vector<Preintegration> preintegrateWindow(const InitWindow& window, const BiasPoint& biases,
                                               const ImuNoise& noise, double td_shift,
                                               PreintegrationParts parts) {
  std::vector<Preintegration> pre;
  pre.reserve(window.size() - 1);
  for (int i = 0; i + 1 < window.size(); ++i) {
    pre.push_back(preintegrate(window.imu(), window.times()[i] + td_shift,
                               window.times()[i + 1] + td_shift, biases, noise, parts));
  }
  return pre;
}

std::vector<Preintegration> preintegrateWindow(const InitWindow& window,
                                               const Eigen::Vector3d& gyro_bias,
                                               const Eigen::Vector3d& accel_bias,
                                               PreintegrationParts parts) {
  return preintegrateWindow(window, {gyro_bias, accel_bias}, window.calibration().imu_noise, 0.0,
                            parts);
}

NavState propagate(const NavState& state_i, const Preintegration& pre,
                   const Eigen::Vector3d& gravity_w) {
  NavState state_j = state_i;
  state_j.t = state_i.t + pre.dt;
  state_j.R_w_b = state_i.R_w_b * pre.dR;
  state_j.v_w_b = state_i.v_w_b + gravity_w * pre.dt + state_i.R_w_b * pre.dv;
  state_j.p_w_b = state_i.p_w_b + state_i.v_w_b * pre.dt + 0.5 * gravity_w * pre.dt * pre.dt +
                  state_i.R_w_b * pre.dp;
  return state_j;
}

NavState propagateTo(const NavState& state, double t, const std::vector<ImuSample>& samples,
                     const Eigen::Vector3d& gravity_w) {
  if (!(t > state.t)) return state;
  NavState moved = propagate(state,
                             preintegrate(samples, state.t, t, {state.gyro_bias, state.accel_bias},
                                          ImuNoise(), PreintegrationParts::kMean),
                             gravity_w);
  moved.t = t;
  return moved;
}

std::vector<Eigen::Matrix3d> chainRotations(const std::vector<Preintegration>& pre) {
  std::vector<Eigen::Matrix3d> R_b0_bk(1, Eigen::Matrix3d::Identity());
  R_b0_bk.reserve(pre.size() + 1);
  for (const Preintegration& p : pre) R_b0_bk.push_back(R_b0_bk.back() * p.dR);
  return R_b0_bk;
}

std::vector<Eigen::Matrix3d> cameraRotations(const std::vector<Eigen::Matrix3d>& R_b0_bk,
                                             const Eigen::Matrix3d& R_b_c) {
  std::vector<Eigen::Matrix3d> R_c0_ck;
  R_c0_ck.reserve(R_b0_bk.size());
  for (const Eigen::Matrix3d& R : R_b0_bk) R_c0_ck.push_back(R_b_c.transpose() * R * R_b_c);
  return R_c0_ck;
}

// Five samples at 200 Hz [s].
constexpr double kInstantSpan = 0.012;

std::vector<ImuInstant> imuInstants(const InitWindow& window, double td_shift,
                                    const Eigen::Vector3d& gyro_bias,
                                    const Eigen::Vector3d& accel_bias) {
  const std::vector<ImuSample>& imu = window.imu();
  std::vector<ImuInstant> instants;
  instants.reserve(window.size());
  for (const double keyframe : window.times()) {
    const double t = keyframe + td_shift;
    auto first = std::lower_bound(imu.begin(), imu.end(), t - kInstantSpan,
                                  [](const ImuSample& s, double time) { return s.t < time; });
    if (first == imu.end()) --first;
    ImuInstant sum;
    int count = 0;
    for (auto sample = first; sample != imu.end() && sample->t <= t + kInstantSpan; ++sample) {
      sum.rate += sample->gyro;
      sum.force += sample->accel;
      ++count;
    }
    if (count == 0) {
      // A slow IMU: the sample after the instant.
      sum = {first->gyro, first->accel};
      count = 1;
    }
    instants.push_back({sum.rate / count - gyro_bias, sum.force / count - accel_bias});
  }
  return instants;
}

StatePrior propagatePrior(const StatePrior& prior, double t, const std::vector<ImuSample>& samples,
                          double gravity_magnitude, const ImuNoise& noise) {
  if (!(t > prior.state.t)) return prior;
  ImuNoise in_motion = noise;
  in_motion.gyro_density *= kInMotion;
  in_motion.accel_density *= kInMotion;
  const NavState& from = prior.state;
  const Preintegration pre = preintegrate(samples, from.t, t, {from.gyro_bias, from.accel_bias},
                                          in_motion, PreintegrationParts::kWithCovariance);
  StatePrior carried = prior;
  carried.state = propagate(from, pre, Eigen::Vector3d(0.0, 0.0, -gravity_magnitude));
  const Eigen::Matrix3d& R = from.R_w_b;
  Eigen::Matrix<double, 15, 15> F = Eigen::Matrix<double, 15, 15>::Identity();
  F.block<3, 3>(kTheta, kTheta) = pre.dR.transpose();
  F.block<3, 3>(kTheta, kGyroBias) = pre.dR_dbg;
  F.block<3, 3>(kVelocity, kTheta) = -R * skew(pre.dv);
  F.block<3, 3>(kVelocity, kGyroBias) = R * pre.dv_dbg;
  F.block<3, 3>(kVelocity, kAccelBias) = R * pre.dv_dba;
  F.block<3, 3>(kPosition, kTheta) = -R * skew(pre.dp);
  F.block<3, 3>(kPosition, kVelocity).diagonal().setConstant(pre.dt);
  F.block<3, 3>(kPosition, kGyroBias) = R * pre.dp_dbg;
  F.block<3, 3>(kPosition, kAccelBias) = R * pre.dp_dba;
  // The preintegration's errors are [theta, v, p], the last two in the first body.
  Eigen::Matrix<double, 15, 9> G = Eigen::Matrix<double, 15, 9>::Zero();
  G.block<3, 3>(kTheta, 0).setIdentity();
  G.block<3, 3>(kVelocity, 3) = R;
  G.block<3, 3>(kPosition, 6) = R;
  carried.covariance = F * prior.covariance * F.transpose() + G * pre.covariance * G.transpose();
  return carried;
}

}  // namespace slim_init
