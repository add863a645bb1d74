// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What a host's flights teach about its sensors, for its next start.
#pragma once

#include <optional>

#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/types.h"
#include "slim_init/vins_adapter/host_state.h"

namespace slim_init::vins_adapter {

/// What a host has learned of its sensors in flight.
struct LearnedSensors {
  double stamp = kNotComputed;  ///< of the biases [s], camera clock; NaN: none yet
  KnownSensors known;           ///< as well as it was known at that stamp
};

/// Keeps the newest biases and calibration of a host in good health. Not thread-safe.
///
/// Measured in VINS-Mono on V1_01, V1_02, V2_01 and MH_04: after 20 s of flight its accelerometer
/// bias was off by 0.02 m/s^2 per axis (rms; 0.045 at most), its gyroscope bias by 3e-4 rad/s;
/// after 5 s by 0.06 and 8e-4. Before, a start knows as much by itself.
class SensorMemory {
 public:
  static constexpr double kFlight = 20.0;      ///< of flight, until its biases are believed [s]
  static constexpr double kHindsight = 1.0;    ///< a state counts when the host is still well [s]
  static constexpr double kInterrupted = 1.0;  ///< between healthy states: another flight [s]
  static constexpr double kGyroSigma = 1e-3;   ///< [rad/s]
  static constexpr double kAccelSigma = 0.03;  ///< [m/s^2]
  /// Random walk of the biases [rad/s/sqrt(s)], [m/s^2/sqrt(s)]: ten times and twice what EuRoC's
  /// ADIS16448 is said to have.
  static constexpr double kGyroWalk = 2e-4;
  static constexpr double kAccelWalk = 6e-3;
  /// From one run to the next, standard deviations. Between EuRoC's recordings of two days the
  /// biases differ by up to 5e-3 rad/s and 0.04 m/s^2.
  static constexpr double kGyroTurnOn = 5e-3;   // [rad/s]
  static constexpr double kAccelTurnOn = 0.05;  // [m/s^2]

  /// `configured`: what the host's file says of the rig. Of a calibration that is found, the parts
  /// are kept that are better known than that, and none better than CalibrationSigmas.
  explicit SensorMemory(const Calibration& configured) : configured_(configured) {}

  /// A healthy state of the host in flight; `calibration`: as the host estimates it, or none.
  void learn(const HostState& healthy, const OptionalCalibration& calibration);
  /// The calibration of an answer, where the host does not estimate it.
  void learn(const OptionalCalibration& found);

  /// All of it, of `stamp`; nothing has been learned while `stamp` is NaN.
  const LearnedSensors& learned() const { return learned_; }
  /// Stamps begin anew: what is known is of another run.
  void restart() { restarted_ = true; }

  /// What is known of it at another stamp.
  KnownSensors knownAt(double stamp) const;

 private:
  Calibration configured_;
  LearnedSensors learned_;
  bool restarted_ = false;
  double flight_began_ = kNotComputed, newest_ = kNotComputed;  // stamps of healthy states [s]
  std::optional<LearnedSensors> next_;                          // counts after kHindsight
};

}  // namespace slim_init::vins_adapter
