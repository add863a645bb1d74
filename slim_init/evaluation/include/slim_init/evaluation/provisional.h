// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// First estimates of a host that solves at every image and takes provisional ones.
#pragma once

#include <string>
#include <vector>

#include "slim_init/evaluation/downstream.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init::evaluation {

/// Errors of the newest state of an estimate against the ground truth, and their squares over the
/// covariance that the estimate states, per degree of freedom. NaN without ground truth or without
/// a covariance.
struct NewestErrors {
  double speed = kNotComputed;              ///< true [m/s]
  double velocity = kNotComputed;           ///< length of the error, in the body frame [m/s]
  double velocity_squared = kNotComputed;   ///< three degrees of freedom
  double tilt_deg = kNotComputed;           ///< angle between the two verticals in the body [deg]
  double tilt_squared = kNotComputed;       ///< two
  double log_scale = kNotComputed;          ///< of the trajectory; NaN where that has no scale
  double log_scale_squared = kNotComputed;  ///< one
};

/// Against the ground truth at the times of the states; nothing where one of them has none.
NewestErrors evaluateNewest(const InitResult& answer, const Sequence& sequence);

/// One solve.
struct ProvisionalRecord {
  int trial = 0;         ///< of the solve: begins at image trial * stride
  double t_start = 0.0;  ///< first image [s]
  double data_s = 0.0;   ///< first image to the newest one [s]
  InitStatus status = InitStatus::kInvalidInput;
  std::string message;
  NewestErrors errors;
  double velocity_sigma = kNotComputed;  ///< gate of that name [m/s]
  double scale_sigma = kNotComputed;
  double solve_ms = kNotComputed;
  bool first = false;           ///< the first estimate of the trial: provisional or success
  DownstreamRecord downstream;  ///< of a first estimate

  bool answered() const {
    return status == InitStatus::kProvisional || status == InitStatus::kSuccess;
  }
};

/// When, and what of it.
struct ProvisionalRun {
  int stride = 20;              ///< images between the starts
  int max_trials = 0;           ///< 0: no limit
  double last_s = 2.0;          ///< a trial without an estimate by then has none [s]
  double look_s = 0.5;          ///< every trial is solved up to here, whatever came before [s]
  DownstreamRunner downstream;  ///< from the first estimate; empty: none
};

/// A fresh initializer of `options`, which should have provisional.enabled, per trial, fed as a
/// host feeds it and solved at every image. Returns an empty string, or a message when the options
/// cannot be used.
std::string runProvisional(const Sequence& sequence, const InitializerOptions& initializer,
                           const ProvisionalRun& options, std::vector<ProvisionalRecord>* records);

/// The figures of a run, one per line.
std::string provisionalTable(const std::vector<ProvisionalRecord>& records, double look_s);
/// One line per solve, with a header.
std::string provisionalCsv(const std::vector<ProvisionalRecord>& records);

}  // namespace slim_init::evaluation
