// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The interface that a back end sees and swaps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/stream_check.h"
#include "slim_init/window_solver.h"

namespace slim_init {

/// What an initializer works on.
struct InitializerInfo {
  std::string method;          ///< e.g. "slim"
  Calibration calibration;     ///< td as last set
  StreamCounts counts;         ///< since construction or reset()
  TimeSpan imu;                ///< samples that a healthy state can lie in [s]; NaN: there are none
  double window_span_s = 0.0;  ///< of a full window, if every frame can be a keyframe; without
                               ///< max_span_s and with slow frames it is up to twice as long.
                               ///< Frames far older than this do not influence the next estimate
};

/// An initializer as a host holds it: data in, result out. A back end that holds one of these runs
/// any method without knowing which, nor where its data is kept. Never throws, prints or exits.
///
/// Threads: while one thread solves (initialize()), others may call everything else. The solve sees
/// the data as they were when it began, and holds no lock that a call which adds data waits for.
/// There is one solve at a time. A result of streams that have been restarted or reset since is
/// returned all the same; the next solve does not depend on it.
class IInitializer {
 public:
  virtual ~IInitializer() = default;

  // ------------------------------------------------------------------------------------ data in

  /// The streams as they are received; what cannot be used is dropped and counted (StreamCheck is
  /// there for every implementation). On kRestarted everything received before is forgotten.
  virtual AddStatus addImu(const ImuSample& sample) = 0;
  /// `frame.t` is the image stamp, camera clock. Its lines may be in it or follow by addLines().
  virtual AddStatus addFrame(FrameObservation frame) = 0;
  /// The lines of the image with this stamp [s], before or after its frame: kAdded, kWaiting,
  /// kUnmatched or kNotFinite. An initializer without use for them keeps this default.
  virtual AddStatus addLines(double /*stamp*/, std::vector<LineObservation> /*lines*/) {
    return AddStatus::kNotSupported;
  }

  /// A velocity measured by Calibration::speed_sensor: wheel odometry, airspeed, optical flow. With
  /// it the scale is known at constant velocity. One that contradicts the motion (a slipping wheel)
  /// is not used and named in InitResult::warnings. An initializer without use for it keeps this
  /// default.
  virtual AddStatus addSpeed(const SpeedSample& /*sample*/) { return AddStatus::kNotSupported; }

  /// Time offset [s] (as Calibration::td) of the frames that follow, from a host that estimates it
  /// online. A value that Calibration::validate() refuses is ignored.
  virtual void setTd(double td) = 0;

  /// Forgets all data and counts.
  virtual void reset() = 0;

  // ----------------------------------------------------------------------------------- result out

  /// Solves the newest window under what is known before. The data stays, so it may be called again
  /// at any time. kSuccess means that there is an estimate and that every enforced gate passed
  /// (InitResult::validate()). A body at rest is kStationary; then its first motion is solved with
  /// the rest as a prior (SlimOptions::start_from_rest).
  /// With ProvisionalOptions::enabled kProvisional comes earlier: states whose scale is not known
  /// yet, with a covariance to take as a prior. A host that does not do so waits on.
  ///
  /// With `priors.healthy` it is the recovery of a host that has failed, in its old odometry frame:
  /// position and yaw continue from a healthy state, by the IMU alone; gravity, velocities and
  /// biases are those of the estimate (InitResult::frame_continued). The window is solved alone
  /// first. A healthy state agrees with that estimate if velocity, tilt and biases, propagated to
  /// the same time by the IMU, differ by no more than both covariances allow. If the newest one
  /// agrees with a success, that success is the result. Otherwise the frames after the newest state
  /// that agrees are solved with this state as a prior: four keyframes can be enough, at constant
  /// velocity and in hover too. If none agrees, a success of the window alone is the result;
  /// without one the newest state is the prior. A part of a state that the data contradict is not
  /// used and is named (InitResult::prior_dropped, message); the velocity, or two parts: a refusal.
  /// Refusals are as for a start, plus kInvalidInput if no state is finite, a rotation, within the
  /// buffer and without too long a gap of the IMU after it.
  ///
  /// An initializer that has no use for a prior ignores it.
  virtual InitResult initialize(const Priors& priors) = 0;
  /// With nothing known before.
  InitResult initialize() { return initialize(Priors()); }

  /// States of a successful `result` of this initializer at other times: `times` ascend [s, IMU
  /// clock] and lie at most `max_reach_s` before the first or after the last keyframe; the IMU
  /// alone carries the state there. While the body stood (InitResult::at_rest_since) its state is
  /// that of the first keyframe, however long before. Where it cannot, returns false, leaves
  /// `states` as it was and puts a message with value and bound into `error` (may be null).
  /// slim_init/state_at.h does this for any buffer of samples.
  virtual bool statesAt(const InitResult& result, const std::vector<double>& times,
                        double max_reach_s, std::vector<NavState>* states,
                        std::string* error) const = 0;

  virtual InitializerInfo info() const = 0;
};

/// An initializer that solves with `slim`. Invalid calibration or options: null, and a message in
/// `error` (may be null).
std::unique_ptr<IInitializer> makeInitializer(const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error = nullptr);

/// Pairs a keyframe window with any solver, which must not be null. Of `options`, `window`, `imu`,
/// `provisional` and `limits` are used: the solver has its own. Invalid calibration or options: as
/// above.
std::unique_ptr<IInitializer> makeInitializer(std::unique_ptr<WindowSolver> solver,
                                              const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error = nullptr);

}  // namespace slim_init
