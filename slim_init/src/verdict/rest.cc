// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "verdict/rest.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/robust.h"
#include "geometry/so3.h"
#include "imu/imu_quality.h"
#include "priors/sensor_priors.h"

namespace slim_init {
namespace {

// Least median length of the noise of a bearing [px]. On images that stand it is below 0.1, and
// slow errors of the tracker would pass for motion.
constexpr double kLeastTrackNoise = 0.4;
// Motion of the tracks and of the means of the IMU that a second of rest may have, in standard
// deviations of their noise; two seconds may have twice that: the longer it is seen, the clearer
// motion is. A rig with idling rotors sways by 2 to 3 in two seconds. At the least, the IMU sees a
// hover within 3 mm move by 2.1 in one and 3.9 in two seconds, and the tracks 0.05 m/s by 2.0 and
// 5.7 (false_rest_test).
constexpr double kMaxMotionAtRest = 1.8;
// Standard deviations at rest: velocity [m/s], and what a mean over a rest does not tell about the
// flight after it, of specific force [m/s^2] (that of MH_04 changes by 0.06 as its rotors speed
// up) and rate [rad/s].
constexpr double kRestVelocitySigma = 0.01;
constexpr double kRestForceSigma = 0.05;
constexpr double kRestRateSigma = 2e-4;

// Distances of the tracks and the noise of a bearing, both in rad.
void measureTracks(const InitWindow& window, RestMeasures* out) {
  const std::vector<WindowPoint>& points = window.pointObservations();
  const int third = std::max(1, window.size() / 3);
  std::vector<double> moved, second_differences;
  for (const Track& track : window.pointTracks()) {
    // From one end of the window to the other.
    if (track.size() < window.size()) continue;
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = first;
    for (int k = 0; k < third; ++k) {
      first += points[track.begin + k].bearing / third;
      last += points[track.end - 1 - k].bearing / third;
    }
    moved.push_back((last - first).norm());
    for (int k = track.begin + 1; k + 1 < track.end; ++k) {
      second_differences.push_back(
          (points[k - 1].bearing - 2.0 * points[k].bearing + points[k + 1].bearing).norm());
    }
  }
  out->track_count = static_cast<int>(moved.size());
  if (moved.empty() || second_differences.empty()) return;
  // Of a bearing: a second difference has six times its variance, a difference of means 2 / third.
  const double noise = std::max(median(std::move(second_differences)) / std::sqrt(6.0),
                                kLeastTrackNoise / window.calibration().focal_px);
  const double distance = median(std::move(moved)), by_noise = noise * std::sqrt(2.0 / third);
  out->tracks = distance / by_noise;
  const std::vector<double>& times = window.times();
  const int n = window.size();
  double apart = 0.0;  // of the mean times of both thirds
  for (int k = 0; k < third; ++k) apart += (times[n - 1 - k] - times[k]) / third;
  out->turn_rate = std::sqrt(std::max(0.0, distance * distance - by_noise * by_noise)) / apart;
}

// Rms of the deviation of means over kRestStep from their own mean.
double spreadOfMeans(const std::vector<ImuSample>& samples, double first, double last,
                     Eigen::Vector3d ImuSample::*axis, Eigen::Vector3d* mean, double* step) {
  std::vector<Eigen::Vector3d> means;
  const int steps = std::max(1, static_cast<int>((last - first) / kRestStep));
  *step = (last - first) / steps;
  auto sample = std::lower_bound(samples.begin(), samples.end(), first,
                                 [](const ImuSample& s, double t) { return s.t < t; });
  for (int k = 0; k < steps; ++k) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (; sample != samples.end() && sample->t < first + (k + 1) * *step; ++sample, ++count) {
      sum += (*sample).*axis;
    }
    if (count > 0) means.push_back(sum / count);
  }
  mean->setZero();
  if (means.size() < 2) return kNotComputed;
  for (const Eigen::Vector3d& one : means) *mean += one / static_cast<double>(means.size());
  double sum = 0.0;
  for (const Eigen::Vector3d& one : means) sum += (one - *mean).squaredNorm();
  return std::sqrt(sum / (3.0 * static_cast<double>(means.size() - 1)));
}

}  // namespace

RestMeasures measureRest(const InitWindow& window) {
  RestMeasures out;
  measureTracks(window, &out);
  const ImuQuality quality = measureImuQuality(window.imu());
  if (!quality.measured()) return out;
  const ImuNoise& sheet = window.calibration().imu_noise;
  const double gyro = std::max(quality.noise.gyro_density, sheet.gyro_density);
  const double accel = std::max(quality.noise.accel_density, sheet.accel_density);
  const double first = window.times().front(), last = window.times().back();
  out.span = last - first;
  double step = 0.0;
  out.rate = spreadOfMeans(window.imu(), first, last, &ImuSample::gyro, &out.mean_rate, &step);
  out.rate /= gyro / std::sqrt(step);
  out.force = spreadOfMeans(window.imu(), first, last, &ImuSample::accel, &out.mean_force, &step);
  out.force /= accel / std::sqrt(step);
  out.rate_sigma = gyro / std::sqrt(out.span);
  out.force_sigma = accel / std::sqrt(out.span);
  return out;
}

bool RestMeasures::isRest(double gravity_magnitude, const InertialOptions& inertial) const {
  // Of a dozen tracks over the whole rest 0.05 m/s pass in one window of 30.
  if (track_count < kFewestForSpread) return false;
  const double bound = kMaxMotionAtRest * span / kRestSpan;
  return tracks <= bound && rate <= bound && force <= bound &&
         std::abs(mean_force.norm() - gravity_magnitude) <= 5.0 * inertial.accel_bias_prior &&
         mean_rate.norm() <= inertial.gyro_bias_prior;
}

StatePrior priorAtRest(const RestMeasures& rest, double t, double gravity_magnitude,
                       const ImuBiases& known, const InertialOptions& inertial) {
  const ImuBiases biases = assumedImuBiases(known, inertial);
  const Eigen::Vector3d& before = biases.accel;
  const double across = biases.accel_sigma;
  const Eigen::Vector3d up = (rest.mean_force - before).normalized();
  StatePrior prior;
  prior.at_rest = true;
  prior.state.t = t;
  prior.state.R_w_b = gravityAlignedAttitude(-gravity_magnitude * up);
  prior.state.gyro_bias = rest.mean_rate;
  // f = G up + b_a: the part along gravity is measured, that across it is a tilt.
  prior.state.accel_bias = before + ((rest.mean_force - before).norm() - gravity_magnitude) * up;
  const Eigen::Matrix3d level = Eigen::Matrix3d::Identity() - up * up.transpose();
  const double along2 = std::pow(std::hypot(rest.force_sigma, kRestForceSigma), 2);
  const Eigen::Matrix3d of_bias = across * across * level + along2 * up * up.transpose();
  const Eigen::Matrix3d by_bias = skew(up) / gravity_magnitude;
  prior.covariance.block<3, 3>(0, 0) =
      (across * across + along2) / (gravity_magnitude * gravity_magnitude) * level;
  prior.covariance.block<3, 3>(0, 12) = by_bias * of_bias;
  prior.covariance.block<3, 3>(12, 0) = of_bias * by_bias.transpose();
  prior.covariance.block<3, 3>(12, 12) = of_bias;
  prior.covariance.diagonal().segment<3>(6).setConstant(kRestVelocitySigma * kRestVelocitySigma);
  prior.covariance.diagonal().segment<3>(9).setConstant(
      std::pow(std::hypot(rest.rate_sigma, rest.turn_rate, kRestRateSigma), 2));
  return prior;
}

}  // namespace slim_init
