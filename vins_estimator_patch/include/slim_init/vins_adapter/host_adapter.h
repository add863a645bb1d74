// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// An initializer as a VINS-Mono style host needs it: streams in, the state at every stamp of the
// host's window out, at start-up and after a failure.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "slim_init/host_health/flight_monitor.h"
#include "slim_init/initializer.h"
#include "slim_init/types.h"
#include "slim_init/vins_adapter/host_convention.h"

namespace slim_init::vins_adapter {

/// What initializes the host.
enum class HostMode {
  kStock,   ///< the host alone; the adapter is not used
  kSlim,    ///< the adapter in place of the host's own initialization
  kShadow,  ///< the host decides, the adapter solves the same windows and both are recorded
};

/// "stock", "slim", "shadow".
const char* toString(HostMode mode);

/// The inverse of toString(); false for any other text.
bool parseHostMode(const std::string& text, HostMode* mode);

/// Options of the adapter; those of the method are InitializerOptions.
struct HostOptions {
  bool reinit = false;  ///< recover() solves; off: it declines and the host resets itself

  /// A stamp of the host may lie this long before the first or after the last keyframe of the
  /// solved window [s]; the IMU alone carries the state there, and the host's next optimization
  /// refines it. In slow motion the keyframes of a host lie far apart and reach further back than
  /// our window (about 2 s). With 1 s a recovery in slow motion is refused, and the host resets.
  double max_reach_s = 2.5;

  /// The host's states are watched (HostAdapter::watch()).
  bool watchdog = false;

  /// Solves run in a thread of the adapter. The host's thread waits at most this long per frame for
  /// one that is nearly done [ms]; a later frame gets the estimate, propagated to its stamps.
  /// Negative: every solve runs in the calling thread, so that equal calls give equal estimates
  /// (lock step).
  double max_wait_ms = 10.0;

  /// Samples beyond are no measurements (the initializer drops and counts them).
  ImuLimits imu;

  /// The host estimates td, or the extrinsic, itself: what the initializer has found is its
  /// starting value (`HostResult::result.calibration`). Where it does not, its own stays.
  bool estimate_td = false;
  bool estimate_extrinsic = false;

  /// Rows of the images [px], from which the rows of the observations follow (setRows()), and the
  /// exposure times of a rolling shutter; 0: those of the observations stay as they are.
  int image_height = 0;

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// A host's state, propagated.
struct HostPropagation {
  bool ok = false;      ///< false: the IMU data do not reach
  std::string message;  ///< what it is worth, or why there is none
  HostState state;
  double position_sigma = kNotComputed;  ///< worst axis [m]
  double yaw_sigma_deg = kNotComputed;
  double start_sigma = 0.0;  ///< of `position_sigma`, what does not come from the propagation [m]
};

/// What seed() or recover() returned.
struct HostResult {
  InitResult result;               ///< the initializer's, in its own world and at its own keyframes
  HostWindow window;               ///< one state per requested stamp; empty unless success()
  std::string message;             ///< for a person: what was decided and why
  double stamp = kNotComputed;     ///< the newest requested stamp [s], camera clock
  double data_s = kNotComputed;    ///< from the first frame after a (re)start to `stamp` [s]
  double solve_ms = kNotComputed;  ///< of the solve, in whichever thread it ran
  HostPropagation frame;           ///< ok: the window continues it, as uncertain as this says
  /// Of recover(): the solve has not finished, or IMU samples that it needs to reach the newest
  /// frame have arrived and are held back. Nothing was decided; bridge() fills the window until the
  /// next frame.
  bool pending = false;
  /// Of recover(): the initializer has a window, but ignores the states that it was given.
  bool no_recovery = false;

  bool success() const { return !window.states.empty(); }
};

/// The watchdog's finding (HostAdapter::watch()).
using host_health::HostHealth;

/// Seeds and recovers a host from an initializer, of whatever kind, that buffers its own data, so
/// that nothing is lost when the host clears its state. Adds to it the host's stamps, the host's
/// convention, a lock and a thread: streams may come from other threads than seed(), recover() and
/// watch(), which belong to one, and solves run in a third (HostOptions::max_wait_ms). Never
/// throws, prints or exits.
class HostAdapter {
 public:
  /// An adapter around `initializer`. Null initializer or invalid options: null, and a message in
  /// `error` (may be null).
  static std::unique_ptr<HostAdapter> create(std::unique_ptr<IInitializer> initializer,
                                             const HostOptions& options, std::string* error);

  ~HostAdapter();

  /// `t` [s] on the IMU clock, specific force [m/s^2] and angular rate [rad/s] in the body, both as
  /// measured. A sample that is not added was dropped and counted.
  AddStatus addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro);

  /// `frame.t` is the host's stamp, camera clock. Lines may be in it or follow through addLines().
  AddStatus addFrame(FrameObservation frame);

  /// The lines of the image with that stamp. Frame and lines may come in either order; a second
  /// message for one stamp is unmatched.
  AddStatus addLines(double stamp, std::vector<LineObservation> lines);

  /// A velocity of Calibration::speed_sensor, `sample.t` on the IMU clock
  /// (IInitializer::addSpeed()).
  AddStatus addSpeed(const SpeedSample& sample);

  /// The stamp [s] of an image that the host has received, whether or not it will use it: a host
  /// drops images while it has no IMU data, and its tracks go on. Without these calls only the
  /// frames in use are known, and what it drops is a gap in the images.
  void received(double stamp);

  /// The host's present estimate of the time offset [s] (as Calibration::td), for the frames that
  /// follow. Without it the calibration's holds.
  void setTd(double td);

  /// Solves the newest window and returns the state at every stamp (ascending, camera clock) in a
  /// world with zero first position and zero first yaw: that of the body at stamp + td, with the td
  /// that the host had for that frame, whatever the initializer has found. Declines when the
  /// initializer does, and when a stamp lies further than max_reach_s outside its window or outside
  /// the IMU data.
  HostResult seed(const std::vector<double>& stamps);

  /// After a failure: as seed(), but position and yaw continue from healthy states of the host,
  /// ascending in time. If the window alone is refused, velocity, attitude and biases of the newest
  /// of them that the data agree with, propagated by the IMU, are a prior
  /// (Priors::healthy). Stamps further than max_reach_s before the solved window get the
  /// states that the host had there, as long as these are among them.
  HostResult recover(const std::vector<double>& stamps, const std::vector<HostState>& healthy);

  /// While a recovery is being solved: the healthy states (as above) at the stamps that they are
  /// of, and the newest of them propagated by the IMU to the stamps after it. Declines if the IMU
  /// data do not reach.
  HostResult bridge(const std::vector<double>& stamps, const std::vector<HostState>& healthy) const;

  /// A healthy state of the host in flight. After 20 s without interruption its biases, and the
  /// calibration that it estimates or that an estimate has found, are remembered for its next
  /// starts, each as well as it is known by then. Only seed() and recover() use it: watch() solves
  /// without.
  void learn(const HostState& healthy);

  /// The last healthy state before a failure. Until learn() has another, it is propagated as
  /// the IMU data arrive: propagate(), recover() and bridge() go on from it when those of its time
  /// are no longer buffered.
  void lose(const HostState& healthy);

  /// The host has thrown its states away: what watch() and prepare() remember of them, and a solve
  /// at work for them, is dropped. The streams and what is known of the sensors stay.
  void flightEnded();

  /// Carries a state of the host on by the IMU to the frame of a stamp, and says how well it is
  /// known there: glitches and missing samples widen it.
  HostPropagation propagate(const HostState& from, double stamp) const;

  /// Before the optimization of a frame in flight: compares the pose that the IMU predicts for it
  /// with the pose that its tracks want (host_health/innovation.h), and says which of the two is
  /// not to be believed. `window`: all states of the host, the newest as it has predicted it.
  /// `ric`, `tic`: the host's present extrinsic.
  HostPreparation prepare(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                          const Eigen::Vector3d& tic);

  /// After it: judges the host's window by its tracks, its IMU data and by windows that are solved
  /// without its states: once a second, with every frame if the others speak against the host, and
  /// with `wants_evidence` as soon as the one before has finished. One call per frame of the host
  /// in flight, before the window slides. `ric`, `tic` as above.
  HostHealth watch(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                   const Eigen::Vector3d& tic, bool wants_evidence = false);

  /// The intervals between consecutive stamps (ascending, camera clock): one less than stamps,
  /// empty if the buffer does not cover them.
  std::vector<HostImuInterval> imuIntervals(const std::vector<double>& stamps) const;

  /// Begin and end of the newest interval [s, camera clock] in which IMU data are missing or are
  /// implausible; minus infinity: all that is buffered is usable.
  std::pair<double, double> lastDamage() const;

  HostOptions options() const;
  InitializerInfo info() const;  ///< the initializer's, with what the adapter has discarded before

 private:
  struct State;
  explicit HostAdapter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace slim_init::vins_adapter
