// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Starts of a host that solves at every image: anywhere in a sequence with provisional estimates,
// and of a body that stands and then moves.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slim_init/evaluation/downstream.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init::evaluation {

/// Errors of the newest state of an estimate against the ground truth, and their squares over the
/// covariance that the estimate states, per degree of freedom. NaN without ground truth or without
/// a covariance.
struct NewestErrors {
  double velocity = kNotComputed;           ///< length of the error, in the body frame [m/s]
  double velocity_squared = kNotComputed;   ///< three degrees of freedom
  double tilt_deg = kNotComputed;           ///< angle between the two verticals in the body [deg]
  double tilt_squared = kNotComputed;       ///< two
  double log_scale = kNotComputed;          ///< of the trajectory; NaN where that has no scale
  double log_scale_squared = kNotComputed;  ///< one
};

/// Where an initializer is fed from.
struct Start {
  std::size_t first = 0;  ///< frame
  double t = 0.0;         ///< times of the start count from here [s, IMU clock]
};

/// A start at every `stride`-th image, at most `limit` (0: all), whose data last for `seconds`.
std::vector<Start> startsEvery(int stride, int limit, double seconds, const Sequence& sequence);

/// Distance from the place of rest at which a motion has begun [m].
inline constexpr double kOnsetDistance = 0.02;

/// Every time that the true position stays within 5 mm for a second and then leaves by
/// kOnsetDistance, which is `t`; fed from the rest on. None without ground truth.
std::vector<Start> motionOnsets(const Sequence& sequence);

/// How an initializer is fed and solved.
struct StartRun {
  InitializerOptions initializer;
  double last_s = 2.0;  ///< a start without an estimate by then has none [s]
  /// Solves go on up to here, whatever came before [s]; negative: until the first estimate.
  double look_s = -1.0;
  DownstreamRunner downstream;  ///< from the first estimate; empty: none
};

/// One solve.
struct StartRecord {
  int start = 0;           ///< its number
  double t_start = 0.0;    ///< Start::t [s]
  bool with_prior = true;  ///< SlimOptions::start_from_rest
  double after_s = 0.0;    ///< Start::t to the newest image [s]; negative: before it
  InitStatus status = InitStatus::kInvalidInput;
  NewestErrors errors;
  double scale_sigma = kNotComputed;
  double solve_ms = kNotComputed;
  bool first = false;           ///< the first estimate of the start: provisional or success
  bool from_rest = false;       ///< the odometry frame is that of the rest
  bool false_rest = false;      ///< `stationary` from a rest at more than 0.03 m/s
  DownstreamRecord downstream;  ///< of a first estimate

  bool answered() const {
    return status == InitStatus::kProvisional || status == InitStatus::kSuccess;
  }
};

/// A fresh initializer per start, fed as a host feeds it and solved at every image. Returns an
/// empty string, or a message when the options cannot be used.
std::string runStarts(const Sequence& sequence, const std::vector<Start>& starts,
                      const StartRun& run, std::vector<StartRecord>* records);

/// Figures of the first estimates of `starts` starts, and of those at `look_s` where that is not
/// negative. `title` begins the first line.
std::string startsTable(const std::string& title, const std::vector<StartRecord>& records,
                        std::size_t starts, double look_s);
/// One line per solve, with a header.
std::string startsCsv(const std::vector<StartRecord>& records);

}  // namespace slim_init::evaluation
