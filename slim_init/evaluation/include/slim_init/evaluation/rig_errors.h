// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Miscalibrated rigs: the calibration given to the methods has an error of a known size,
// and the IMU is worse than the recorded one. The one place in which data are disturbed.
#pragma once

#include <string>
#include <vector>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// Injected calibration errors. None by default.
struct RigErrors {
  double td_s = 0.0;           ///< true td minus that of the calibration given [s]
  double extrinsic_deg = 0.0;  ///< the rotation given is turned by this angle [deg]
  /// Per trial: a td error uniform in [-|td_s|, |td_s|] and the rotation by an angle
  /// uniform in [0, extrinsic_deg] about an axis of its own. Else both as they are, everywhere.
  bool random = false;
  double readout_s = 0.0;     ///< readout time given minus the true one [s]
  double imu_rate_hz = 0.0;   ///< 0: the recorded rate
  double imu_jitter_s = 0.0;  ///< standard deviation of the stamps of the samples [s]
  double imu_dropout = 0.0;   ///< fraction of the samples that are missing
  unsigned seed = 1;          ///< of axes, draws, jitter and missing samples

  bool disturbsImu() const;
  bool any() const;
};

/// Trial of assumedCalibration() for what does not change from trial to trial.
inline constexpr int kAllTrials = -1;

/// Calibration given to the methods in place of the true one. The image stamps stay: with a td that
/// is too small by td_s every frame is believed earlier by as much. With errors.random, kAllTrials
/// has the errors of the rows alone. The rotation is turned in the camera's frame, R_b_c
/// Exp(delta).
Calibration assumedCalibration(const Calibration& truth, const RigErrors& errors, int trial);

/// The samples of a worse IMU, ascending in time: at equal intervals from the first sample on, each
/// the mean over an interval around it, as sensors average what they sample faster; stamped late or
/// early by a normally distributed error that is cut off at 0.45 intervals, so that their order
/// stays, and each missing with the same probability. Returns an empty string, or a sentence when
/// the requested rate is above that of the samples.
std::string disturbImu(const RigErrors& errors, std::vector<ImuSample>* imu);

/// Disturbs a sequence: its IMU, and from now on it is believed to have been recorded with the
/// assumedCalibration(); the true one is kept (Sequence::true_calibration). Of random errors, which
/// are drawn by the protocol trial by trial, those of the rows. Returns an empty string, or a
/// sentence.
std::string applyRigErrors(const RigErrors& errors, Sequence* sequence);

}  // namespace slim_init::evaluation
