// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The run of an estimator that was started from a method's estimate.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// The end of one run. NaN where there is no ground truth or the run never began.
struct DownstreamRecord {
  bool ran = false;  ///< the estimate has states to start from, and the data reached far enough
  bool diverged = false;      ///< the estimator's own failure detection, or an error above a bound
  std::string message;        ///< of a run that diverged or never began: one sentence
  double seconds = 0.0;       ///< from the last keyframe of the seed to the last state
  double ate = kNotComputed;  ///< positions after alignment by position and heading [m]
  double scale_error = kNotComputed;  ///< |s - 1| of the last window
};

/// Starts an estimator from an estimate and the keyframes it belongs to. Called once per method and
/// window; has no memory.
using DownstreamRunner =
    std::function<DownstreamRecord(const Sequence& sequence, const InitResult& answer)>;

/// target = R_z(yaw) source + t: the alignment of two worlds that share gravity and scale.
struct HeadingAlignment {
  double yaw = 0.0;  ///< [rad]
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Eigen::Vector3d apply(const Eigen::Vector3d& p) const;
};

/// Least squares over positions; equal sizes, at least one. Yaw is zero where the points stand on
/// one vertical.
HeadingAlignment alignHeading(const std::vector<Eigen::Vector3d>& source,
                              const std::vector<Eigen::Vector3d>& target);

}  // namespace slim_init::evaluation
