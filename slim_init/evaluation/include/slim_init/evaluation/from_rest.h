// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Starts of a body that stands and then moves, with and without the rest as a prior.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init::evaluation {

/// A motion after a rest, as the ground truth has it.
struct MotionOnset {
  std::size_t first = 0;  ///< frame from which an initializer is fed: at rest
  double t = 0.0;         ///< the body is kOnsetDistance from where it stood [s, IMU clock]
};

/// Distance from the place of rest at which a motion has begun [m].
inline constexpr double kOnsetDistance = 0.02;
/// Time after an onset without an accepted estimate after which there is none [s].
inline constexpr double kLongestStart = 3.0;

/// Every time that the true position stays within 5 mm for a second and then leaves by
/// kOnsetDistance. None without ground truth.
std::vector<MotionOnset> motionOnsets(const Sequence& sequence);

/// One start: the first accepted estimate, or the last refusal.
struct FromRestRecord {
  double t_onset = 0.0;     ///< MotionOnset::t [s]
  bool with_prior = false;  ///< SlimOptions::start_from_rest
  InitStatus status = InitStatus::kInvalidInput;
  std::string message;
  double after_s = kNotComputed;    ///< onset to the newest frame [s]; negative: before it
  double log_scale = kNotComputed;  ///< error of the scale, NewestErrors::log_scale
  double scale_sigma = kNotComputed;
  double velocity = kNotComputed;  ///< error of the newest velocity [m/s]
  bool from_rest = false;  ///< the odometry frame is that of the rest (InitResult::at_rest_since)
  int false_rests = 0;     ///< `stationary` from a rest at more than 0.03 m/s

  bool accepted() const { return status == InitStatus::kSuccess; }
};

/// Every onset twice, with the prior and without: a fresh initializer, fed as a host feeds it and
/// solved at every image from the first frame until it accepts, at most kLongestStart after the
/// onset.
/// Returns an empty string, or a message when the options cannot be used.
std::string runFromRest(const Sequence& sequence, const InitializerOptions& initializer,
                        std::vector<FromRestRecord>* records);

/// The figures of a run: a line with the prior and one without.
std::string fromRestTable(const std::vector<FromRestRecord>& records);
/// One line per start, with a header.
std::string fromRestCsv(const std::vector<FromRestRecord>& records);

}  // namespace slim_init::evaluation
