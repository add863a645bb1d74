// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "sensor_memory.h"

#include <algorithm>
#include <cmath>

namespace slim_init::vins_adapter {
namespace {

// The parts of `found` that are better known than they are `configured`; the others as configured,
// td without a variance. None where no part is. No calibration is better known than one that was
// measured with care.
OptionalCalibration betterThan(const Calibration& configured, const OptionalCalibration& found) {
  if (!found) return found;
  constexpr double kDegToRad = 0.017453292519943295;
  const CalibrationSigmas defaults, &before = configured.sigmas;
  const double rotation = std::max(found->rotationSigmaDeg(), defaults.rotation_deg);
  const double translation = std::max(
      std::sqrt(found->covariance.diagonal().segment<3>(3).maxCoeff()), defaults.translation_m);
  const double td = std::max(found->tdSigma(), defaults.td_s);
  const bool turns = rotation < before.rotation_deg, moves = translation < before.translation_m;
  // Extrinsics come without a td where the host does not estimate it.
  const bool shifts = found->tdSigma() > 0.0 && td < before.td_s;
  if (!turns && !moves && !shifts) return OptionalCalibration();
  CalibrationEstimate better;
  better.R_b_c = turns ? found->R_b_c : configured.R_b_c;
  better.t_b_c = moves ? found->t_b_c : configured.t_b_c;
  better.td = shifts ? found->td : configured.td;
  better.covariance.diagonal().head<3>().setConstant(
      std::pow(kDegToRad * (turns ? rotation : before.rotation_deg), 2));
  better.covariance.diagonal().segment<3>(3).setConstant(
      std::pow(moves ? translation : before.translation_m, 2));
  if (shifts) better.covariance(6, 6) = td * td;
  return better;
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
    restarted_ = false;
  }
  next_ = LearnedSensors{healthy.stamp, {}};
  next_->known.biases = {healthy.Bg, healthy.Ba, kGyroSigma, kAccelSigma};
  next_->known.calibration = betterThan(configured_, calibration);
}

void SensorMemory::learn(const OptionalCalibration& found) {
  if (!found) return;  // a method without one
  learned_.known.calibration = betterThan(configured_, found);
}

KnownSensors SensorMemory::knownAt(double stamp) const {
  KnownSensors known = learned_.known;
  if (std::isnan(learned_.stamp)) return known;
  // The clock of another run may be another one.
  const double age = std::max(0.0, stamp - learned_.stamp);
  const auto widen = [&](double walk, double turn_on, double* sigma) {
    const double between_runs = restarted_ ? turn_on * turn_on : 0.0;
    *sigma = std::sqrt(*sigma * *sigma + walk * walk * age + between_runs);
  };
  widen(kGyroWalk, kGyroTurnOn, &known.biases.gyro_sigma);
  widen(kAccelWalk, kAccelTurnOn, &known.biases.accel_sigma);
  return known;
}

}  // namespace slim_init::vins_adapter
