// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A compact sliding-window visual-inertial estimator in the manner of VINS-Mono (Qin et al. 2018),
// written from the papers: the worth of an initial estimate shows here.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::backend {

/// What became of one frame.
struct FrameReport {
  /// Empty, or a message why there is no estimate: the state is then not to be used, and only
  /// seed() and reset() help.
  std::string problem;
  /// Points of the newest frame that other frames saw too, and how many of them lie within three
  /// standard deviations of where the window has them.
  int newest_views = 0;
  int newest_inliers = 0;

  bool ok() const { return problem.empty(); }
};

/// Ten keyframes and the newest frame; IMU factors with bias random walk (Forster et al. 2017),
/// inverse-distance reprojections with a Cauchy loss, marginalisation of the oldest keyframe into a
/// prior that keeps its first linearisation point. Not thread-safe; deterministic.
///
/// Until it is seeded it collects frames; then every frame is propagated, optimised and slid. World
/// w: z up, whatever origin and heading the seed has.
class SlidingWindowEstimator {
 public:
  static constexpr int kWindowFrames = 11;  ///< ten keyframes and the newest frame

  /// Taken as it is.
  static std::unique_ptr<SlidingWindowEstimator> make(const Calibration& calibration);
  virtual ~SlidingWindowEstimator() = default;

  /// Next sample; one that is not finite or not after the last is dropped and counted.
  virtual void addImu(const ImuSample& sample) = 0;

  /// Next frame; the samples up to it (stamp + td) have to be there. Lines are ignored. A frame
  /// that is not after the last one or beyond the IMU data is dropped, and `problem` names the
  /// reason; the estimate then stays as it was.
  virtual FrameReport addFrame(const FrameObservation& frame) = 0;

  /// Starts, or restarts, from states of the frames in the window, in the order of stamps(), on
  /// the IMU clock. The prior and the points' depths are forgotten; then as addFrame().
  virtual FrameReport seed(const std::vector<NavState>& states) = 0;

  virtual bool seeded() const = 0;
  /// Camera stamps of the frames in the window [s].
  virtual std::vector<double> stamps() const = 0;
  /// States of the frames in the window; empty while not seeded.
  virtual std::vector<NavState> states() const = 0;
  /// The last of states().
  virtual NavState newest() const = 0;

  /// Puts these samples (ascending) in the place of those that it holds of the same time, as a host
  /// does that has learned which were damaged. Fewer than two change nothing.
  virtual void replaceImu(const std::vector<ImuSample>& samples) = 0;

  /// Replaces the states of the window without touching prior, points or frames, to see what
  /// follows: for tests. Sizes must agree.
  virtual void overwrite(const std::vector<NavState>& states) = 0;

  /// Forgets states, prior and depths; frames and tracks stay, as before the first seed().
  virtual void unseed() = 0;

  /// Forgets everything but calibration and counts.
  virtual void reset() = 0;
};

/// Failure detection of the host: empty, or a message naming the rule, the value and the bound.
/// `previous` and `current` are consecutive newest states, `report` belongs to the second.
std::string detectFailure(const NavState& previous, const NavState& current,
                          const FrameReport& report);

}  // namespace slim_init::backend
