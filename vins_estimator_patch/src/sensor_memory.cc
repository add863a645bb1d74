// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "sensor_memory.h"

#include <algorithm>
#include <cmath>

namespace slim_init::vins_adapter {
namespace {

// No calibration is better than one that was measured with care.
OptionalCalibration withLeastSigmas(OptionalCalibration found) {
  if (!found) return found;
  const CalibrationSigmas least;
  constexpr double kDegToRad = 0.017453292519943295;
  const double variance[] = {std::pow(least.rotation_deg * kDegToRad, 2),
                             std::pow(least.translation_m, 2), std::pow(least.td_s, 2)};
  for (int i = 0; i < 7; ++i) {
    double& of_found = found->covariance(i, i);
    of_found = std::max(of_found, variance[i / 3]);
  }
  return found;
}

}  // namespace

void SensorMemory::learn(const HostState& healthy, const OptionalCalibration& calibration) {
  if (!(healthy.stamp - newest_ >= 0.0 && healthy.stamp - newest_ <= kInterrupted)) {
    flight_began_ = healthy.stamp;
    next_.reset();
  }
  newest_ = healthy.stamp;
  if (healthy.stamp - flight_began_ < kFlight) return;
  if (next_ && healthy.stamp - next_->stamp < kHindsight) return;
  if (next_) {
    learned_ = *next_;
    restored_ = false;
  }
  next_ = LearnedSensors{healthy.stamp, {}};
  next_->known.biases = {healthy.Bg, healthy.Ba, kGyroSigma, kAccelSigma};
  next_->known.calibration = withLeastSigmas(calibration);
}

void SensorMemory::learn(const OptionalCalibration& found) {
  if (found) learned_.known.calibration = withLeastSigmas(found);
}

void SensorMemory::restore(const LearnedSensors& learned) {
  learned_ = learned;
  restored_ = true;
}

KnownSensors SensorMemory::knownAt(double stamp) const {
  KnownSensors known = learned_.known;
  if (std::isnan(learned_.stamp)) return known;
  // The clock of another run may be another one.
  const double age = std::max(0.0, stamp - learned_.stamp);
  const auto widen = [&](double walk, double turn_on, double* sigma) {
    const double between_runs = restored_ ? turn_on * turn_on : 0.0;
    *sigma = std::sqrt(*sigma * *sigma + walk * walk * age + between_runs);
  };
  widen(kGyroWalk, kGyroTurnOn, &known.biases.gyro_sigma);
  widen(kAccelWalk, kAccelTurnOn, &known.biases.accel_sigma);
  return known;
}

}  // namespace slim_init::vins_adapter
