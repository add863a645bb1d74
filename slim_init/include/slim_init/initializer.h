// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The door that a back end sees and swaps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/keyframe_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/window_solver.h"

namespace slim_init {

/// An initializer as a host holds it: data in, verdict out. A back end that holds one of these runs
/// any method without knowing which. Never throws, prints or exits.
class IInitializer {
 public:
  virtual ~IInitializer() = default;

  /// Name of the method, e.g. "slim".
  virtual const std::string& name() const = 0;

  virtual AddStatus addImu(const ImuSample& sample) = 0;
  virtual AddStatus addFrame(const FrameObservation& frame) = 0;

  /// Lines that come after their frame, by its stamp; false when there is no such frame or it has
  /// lines already. An initializer without use for them keeps this default.
  virtual bool addLines(double /*t*/, const std::vector<LineObservation>& /*lines*/) {
    return false;
  }

  /// Solves the newest window. The data stay, so it may be called again at any time.
  virtual InitResult initialize() = 0;

  /// Solves the newest window after a failure of the host and joins the answer to the host's old
  /// odometry frame: position and yaw continue from `last_healthy` (its time must lie within the
  /// buffered IMU data), carried on by the IMU to the window; gravity, velocities and biases are
  /// the new ones. Refusals are as for initialize(), plus kInvalidInput when `last_healthy` is not
  /// finite, not a rotation or outside the buffer, or when the IMU has a gap above
  /// WindowOptions::max_imu_gap_s between it and the window.
  virtual InitResult recover(const NavState& last_healthy) = 0;

  /// Forgets all data.
  virtual void reset() = 0;

  /// The data as this initializer sees it: counts of dropped messages, buffered samples.
  virtual const KeyframeWindow& window() const = 0;
};

/// An initializer that solves with `slim`. Invalid calibration or options: null, and a message in
/// `error` (may be null).
std::unique_ptr<IInitializer> makeInitializer(const Calibration& calibration,
                                              const InitializerOptions& options,
                                              std::string* error = nullptr);

/// Pairs a keyframe window with any solver, which must not be null. Invalid calibration or options:
/// as above.
std::unique_ptr<IInitializer> makeInitializer(std::unique_ptr<WindowSolver> solver,
                                              const Calibration& calibration,
                                              const WindowOptions& options,
                                              std::string* error = nullptr);

}  // namespace slim_init
