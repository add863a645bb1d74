// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu/imu_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/robust.h"
#include "imu/preintegration.h"

namespace slim_init {
namespace {

// ---- Measurement

/// Lengths of the averages [samples] and the longest of them [s]: up to there motion by hand or in
/// flight is close to quadratic over four averages.
constexpr int kAverages[] = {1, 2, 4, 8};
constexpr double kLongestAverage = 0.041;
/// Share of a Gaussian within one standard deviation: robust as the median, and closer to the rms
/// where vibration is a sinusoid (1.24 of it, the median 1.48).
constexpr double kWithinSigma = 0.6827;

// ---- Model, fitted on all recordings at once (docs/derivation.md, section 8)

struct NoiseModel {
  double floor;   ///< factor on the data sheet's density, which is that of one sample at rest
  double share;   ///< of the measured density that is left over an interval between keyframes: the
                  ///< spectrum of a vibration falls towards low frequencies
  double motion;  ///< density per spread of the motion [1/sqrt(Hz)]: scale and axis errors of the
                  ///< IMU, and what the tracks get wrong as they move
};
constexpr NoiseModel kGyro = {1.0, 0.2, 8e-4};
constexpr NoiseModel kAccel = {2.0, 0.5, 7.5e-3};

using Vector6d = Eigen::Matrix<double, 6, 1>;

// Gyroscope and accelerometer of one sample, or the mean of several.
struct Average {
  double t = 0.0;
  Vector6d value = Vector6d::Zero();
};

std::vector<Average> averagesOf(const std::vector<ImuSample>& samples, int length) {
  std::vector<Average> out(samples.size() / length);
  auto sample = samples.begin();
  for (Average& average : out) {
    for (int k = 0; k < length; ++k, ++sample) {
      average.t += sample->t / length;
      average.value.head<3>() += sample->gyro / length;
      average.value.tail<3>() += sample->accel / length;
    }
  }
  return out;
}

// Weights of the third divided difference at the times of four averages, of unit length: with them
// independent errors of the averages keep their standard deviation. The usual weights
// 1 / prod (t_i - t_j) are multiplied by all six differences, which saves the divisions.
Eigen::Vector4d differenceWeights(const Average* at) {
  const double d01 = at[1].t - at[0].t, d12 = at[2].t - at[1].t, d23 = at[3].t - at[2].t;
  const double d02 = d01 + d12, d13 = d12 + d23, d03 = d02 + d23;
  return Eigen::Vector4d(-d12 * d13 * d23, d02 * d03 * d23, -d01 * d03 * d13, d01 * d02 * d12)
      .normalized();
}

// Absolute third differences of the six axes; averages are `interval` apart [s].
std::array<std::vector<double>, 6> thirdDifferences(const std::vector<Average>& averages,
                                                    double interval) {
  std::array<std::vector<double>, 6> out;
  for (auto& axis : out) axis.reserve(averages.size());
  for (std::size_t k = 0; k + 3 < averages.size(); ++k) {
    const Average* first = &averages[k];
    if (first[3].t - first[0].t > kMissing * 3.0 * interval) continue;
    const Eigen::Vector4d weights = differenceWeights(first);
    Vector6d difference = Vector6d::Zero();
    for (int i = 0; i < 4; ++i) difference += weights[i] * first[i].value;
    for (int axis = 0; axis < 6; ++axis) out[axis].push_back(std::abs(difference[axis]));
  }
  return out;
}

// Variance of one axis, mean of three; reorders the values.
double meanVariance(std::vector<double>* axes) {
  double sum = 0.0;
  for (int a = 0; a < 3; ++a) {
    const auto sigma = axes[a].begin() + static_cast<int>(kWithinSigma * axes[a].size());
    std::nth_element(axes[a].begin(), sigma, axes[a].end());
    sum += *sigma * *sigma / 3.0;
  }
  return sum;
}

double medianInterval(const std::vector<ImuSample>& samples) {
  std::vector<double> steps;
  steps.reserve(samples.size());
  for (std::size_t k = 1; k < samples.size(); ++k) steps.push_back(samples[k].t - samples[k - 1].t);
  return median(std::move(steps));
}

void measureMotion(const std::vector<ImuSample>& samples, ImuQuality* out) {
  const double n = static_cast<double>(samples.size());
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), rate = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) {
    force += sample.accel / n;
    rate += sample.gyro / n;
  }
  double force2 = 0.0, rate2 = 0.0;
  for (const ImuSample& sample : samples) {
    force2 += (sample.accel - force).squaredNorm();
    rate2 += (sample.gyro - rate).squaredNorm();
  }
  out->force_spread = std::sqrt(force2 / n);
  out->angular_spread = std::sqrt(rate2 / n);
}

// `factor`: on the data sheet, where the user has given one.
double assumedDensity(const NoiseModel& model, double data_sheet, double measured, double spread,
                      double factor) {
  if (factor > 0.0) return factor * data_sheet;
  const double floor = model.floor * data_sheet, left = model.share * measured,
               motion = model.motion * spread;
  return std::sqrt(floor * floor + left * left + motion * motion);
}

}  // namespace

bool ImuQuality::measured() const {
  return std::isfinite(noise.gyro_density) && std::isfinite(noise.accel_density);
}

ImuQuality measureImuQuality(const std::vector<ImuSample>& samples) {
  ImuQuality out;
  if (samples.size() < 2) return out;
  measureMotion(samples, &out);
  const double interval = medianInterval(samples);
  if (!(interval > 0.0)) return out;
  double gyro2 = std::numeric_limits<double>::infinity(), accel2 = gyro2;
  for (const int length : kAverages) {
    if (length > 1 && length * interval > kLongestAverage) break;
    auto differences = thirdDifferences(averagesOf(samples, length), length * interval);
    const int count = static_cast<int>(differences.front().size());
    if (length == 1) out.differences = count;
    if (count < kFewestForSpread) break;
    gyro2 = std::min(gyro2, meanVariance(&differences[0]) * length * interval);
    accel2 = std::min(accel2, meanVariance(&differences[3]) * length * interval);
  }
  if (out.differences >= kFewestForSpread) out.noise = {std::sqrt(gyro2), std::sqrt(accel2)};
  return out;
}

ImuNoise assumedImuNoise(const ImuNoise& data_sheet, const ImuQuality& quality,
                         const InertialOptions& options) {
  const ImuNoise measured = quality.measured() ? quality.noise : ImuNoise{0.0, 0.0};
  return {assumedDensity(kGyro, data_sheet.gyro_density, measured.gyro_density,
                         quality.angular_spread, options.gyro_noise_factor),
          assumedDensity(kAccel, data_sheet.accel_density, measured.accel_density,
                         quality.force_spread, options.accel_noise_factor)};
}

ImuNoise assumedImuNoise(const InitWindow& window, const InertialOptions& options) {
  const bool both_given = options.gyro_noise_factor > 0.0 && options.accel_noise_factor > 0.0;
  return assumedImuNoise(window.calibration().imu_noise,
                         both_given ? ImuQuality() : measureImuQuality(window.imu()), options);
}

}  // namespace slim_init
