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

/// An initializer as a host holds it: data in, result out. A back end that holds one of these runs
/// any method without knowing which, nor where its data is kept. Never throws, prints or exits.
///
/// Threads: while one thread solves (initialize(), recover()), others may call everything else. The
/// solve sees the data as they were when it began, and holds no lock that a call which adds data
/// waits for. There is one solve at a time. A result of streams that have been restarted or reset
/// since is returned all the same; the next solve does not depend on it.
class IInitializer {
 public:
  virtual ~IInitializer() = default;

  /// Name of the method, e.g. "slim".
  virtual const std::string& name() const = 0;

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

  /// Prior sensor knowledge for initialize() and recover(); without
  /// this, and with an empty one, nothing. Kept by reset(). Where the data contradict the biases,
  /// these are not used, and InitResult::warnings says so. One that KnownSensors::validate()
  /// refuses is ignored. An initializer without use for it keeps this default.
  virtual void setKnownSensors(const KnownSensors& /*known*/) {}

  /// Forgets all data and counts.
  virtual void reset() = 0;

  // ----------------------------------------------------------------------------------- result out

  /// Solves the newest window. The data stays, so it may be called again at any time. kSuccess
  /// means that there is an estimate and that every enforced gate passed (InitResult::validate()).
  /// A body at rest is kStationary; then its first motion is solved with the rest as a prior
  /// (SlimOptions::start_from_rest).
  /// With ProvisionalOptions::enabled kProvisional comes earlier: states whose scale is not known
  /// yet, with a covariance to take as a prior. A host that does not do so waits on.
  virtual InitResult initialize() = 0;

  /// Solves the newest window after a failure of the host, in the host's old odometry frame.
  /// `healthy`: states of the host from before the failure with their covariance, ascending in
  /// time, within the buffered IMU data. Position and yaw continue from them, by the IMU alone;
  /// gravity, velocities and biases are those of the estimate.
  ///
  /// The window is solved alone first. A healthy state agrees with that estimate if velocity, tilt
  /// and biases, propagated to the same time by the IMU, differ by no more than both covariances
  /// allow. If the newest one agrees with a success, that success is the result. Otherwise the
  /// frames after the newest state that agrees are solved with this state as a prior: four
  /// keyframes can be enough, at constant velocity and in hover too. If none agrees, a success of
  /// the window alone is the result; without one the newest state is the prior. Parts of a state
  /// that the data contradict are not used and are named (InitResult::prior_dropped, message).
  ///
  /// Refusals are as for initialize(), plus kInvalidInput if `healthy` is empty or no state of it
  /// is finite, a rotation, within the buffer and without too long a gap of the IMU after it. An
  /// initializer without recovery keeps this default, kTooFewKeyframes.
  virtual InitResult recover(const std::vector<StatePrior>& /*healthy*/) {
    InitResult none;
    none.status = InitStatus::kTooFewKeyframes;
    none.message = name() + " has no recovery";
    return none;
  }

  /// States of a successful `result` of this initializer at other times: `times` ascend [s, IMU
  /// clock] and lie at most `max_reach_s` before the first or after the last keyframe; the IMU
  /// alone carries the state there. While the body stood (InitResult::at_rest_since) its state is
  /// that of the first keyframe, however long before. Where it cannot, returns false, leaves
  /// `states` as it was and puts a message with value and bound into `error` (may be null).
  /// slim_init/state_at.h does this for any buffer of samples.
  virtual bool statesAt(const InitResult& result, const std::vector<double>& times,
                        double max_reach_s, std::vector<NavState>* states,
                        std::string* error) const = 0;

  // ------------------------------------------------------------------------------ what it works on

  virtual Calibration calibration() const = 0;  ///< td as last set
  /// Since construction or reset().
  virtual StreamCounts counts() const = 0;
  /// The IMU data that recover() can start in: first and last time [s]; NaN while there is none.
  virtual TimeSpan bufferedImu() const = 0;
  /// The time that a full window spans [s] where every frame can be a keyframe; without max_span_s
  /// and with slow frames it is up to twice as long. Frames far older than this do not influence
  /// the next estimate.
  virtual double maxWindowSpan() const = 0;
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
