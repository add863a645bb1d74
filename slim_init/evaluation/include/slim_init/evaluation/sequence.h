// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// What a front end made of the images of a recording. Numbers per tracked image are medians over
/// the images unless they say otherwise; NaN without images.
struct TrackingSummary {
  int images = 0;               ///< of the recording
  int tracked = 0;              ///< a frame came out
  int outside_imu = 0;          ///< before the first or after the last IMU sample: discarded
  int unreadable = 0;           ///< could not be read or decoded
  int refused = 0;              ///< refused by the front end: incorrect size
  std::string first_problem;    ///< sentence of the first image unreadable or refused
  int images_without_gyro = 0;  ///< tracked without a rotation from the gyro
  double points = kNotComputed;
  double points_carried = kNotComputed;  ///< with an id of the image before
  double lines = kNotComputed;
  double lines_carried = kNotComputed;
  double total_ms_median = kNotComputed;  ///< of the front end; reading the image is not in it
};

/// One sequence ready for evaluation: what the sensors said and what was true.
struct Sequence {
  std::string name;
  Calibration calibration;  ///< what the methods are given
  /// What is true, where that differs (rig_errors.h); else `calibration` is.
  std::optional<Calibration> true_calibration;
  std::int64_t t0_ns = 0;                ///< stamp of t = 0 in the recording [ns]
  std::vector<ImuSample> imu;            ///< ascending in time
  std::vector<SpeedSample> speeds;       ///< of calibration.speed_sensor, ascending in time
  std::vector<FrameObservation> frames;  ///< ascending in time
  /// Ground truth at any time on the IMU clock [s]; t is NaN where there is none. Empty: there is
  /// no ground truth at all; windows are solved all the same, and no error is computed.
  std::function<NavState(double t)> truth;
  std::optional<TrackingSummary> tracking;  ///< where the features come from images
  std::vector<std::string> notes;  ///< what the reader of a report must know about the data

  const Calibration& trueCalibration() const {
    return true_calibration.has_value() ? *true_calibration : calibration;
  }
};

/// Sequence::truth, with a NaN for its time where there is none at all.
inline NavState truthAt(const Sequence& sequence, double t) {
  return sequence.truth != nullptr && std::isfinite(t) ? sequence.truth(t) : NavState();
}

}  // namespace slim_init::evaluation
