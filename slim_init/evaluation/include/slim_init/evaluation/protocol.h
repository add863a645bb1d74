// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Every method on the same windows of a sequence.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/evaluation/metrics.h"
#include "slim_init/evaluation/rig_errors.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/options.h"
#include "slim_init/window_solver.h"

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

/// Starts an estimator from an estimate and the keyframes it belongs to; `calibration` is what the
/// method was given. Called once per method and window; has no memory.
using DownstreamRunner = std::function<DownstreamRecord(
    const Sequence& sequence, const Calibration& calibration, const InitResult& answer)>;

/// Largest ProtocolOptions::threads.
inline constexpr int kMaxThreads = 256;

/// Windows as in the paper: ten keyframes 0.22 s apart (V-D).
inline WindowOptions paperWindow() {
  WindowOptions window;
  window.keyframes = window.min_keyframes = 10;
  window.min_interval_s = 0.22;
  window.max_span_s = 0.0;
  return window;
}

/// Which windows are cut, and what is run on them (docs/evaluation.md, "Protocol").
struct ProtocolOptions {
  int stride = 10;      ///< images between the starts of two trials; 10 as in the paper (V-C)
  int max_windows = 0;  ///< stop after solving this many windows; 0: no limit
  ImuLimits imu;        ///< samples beyond are dropped, as in a running system
  /// A window counts when it is full: window.keyframes keyframes that span window.max_span_s.
  WindowOptions window = paperWindow();
  /// Protocol of the first estimate: in every trial a method solves at every image, from
  /// first_keyframes keyframes until the window is full, until it accepts; that estimate counts, or
  /// else the last. 0: full windows only.
  int first_keyframes = 0;
  /// Runs an estimator from every estimate that a method accepts; empty: none.
  DownstreamRunner downstream;
  /// With rig.random every trial is cut and solved with an assumedCalibration() of its own. All
  /// other errors of a rig are in the sequence already (applyRigErrors()).
  RigErrors rig;
  /// Windows solved at the same time. Estimates and their order do not depend on it; wall times do.
  int threads = 1;
};

/// What one method said about one window.
struct MethodRecord {
  InitResult answer;    ///< without its covariance
  int keyframes = 0;    ///< of the window solved; fewer than WindowRecord's where it accepted
  double data_s = 0.0;  ///< first to last keyframe of that window [s]
  WindowMetrics metrics;
  /// The result has a state where there is no ground truth, as near to the window as a correction
  /// of td may take it: it cannot be judged.
  bool without_truth = false;
  CalibrationErrors calibration;   ///< of a method that estimates it
  double solve_ms = kNotComputed;  ///< wall time of that solve(), measured around the call
  /// CPU time of the calling thread over the same call: what the machine does besides is not in it.
  double solve_cpu_ms = kNotComputed;
  DownstreamRecord downstream;  ///< of an accepted estimate, where an estimator was run

  /// An estimate was returned, whatever its status.
  bool attempted() const { return answer.hasEstimate(); }
  bool accepted() const { return answer.success(); }
};

/// One window (the longest of its trial) and every method's estimate, in the order of
/// ProtocolResult::methods.
struct WindowRecord {
  int trial = 0;                ///< the trial starts at image trial * stride
  double t_start = 0.0;         ///< first keyframe, IMU clock of the sequence [s]
  std::int64_t t_start_ns = 0;  ///< the same as a stamp of the recording
  double duration_s = 0.0;      ///< first to last keyframe
  int keyframes = 0;
  Excitation excitation;
  CalibrationDifference rig;  ///< calibration given to the methods minus the true one
  std::vector<MethodRecord> methods;
};

/// Where the trials went: trials = windows + the other six.
struct ProtocolCounts {
  int frames = 0;
  int trials = 0;
  int windows = 0;
  int without_truth = 0;  ///< a keyframe has no ground truth; not solved
  int not_evaluable = 0;  ///< solved, and an estimate has a state without ground truth; in no table
  int ended = 0;          ///< the data end before the window is full
  int interrupted = 0;    ///< no full window within twice its nominal length: a gap
  int repeated = 0;       ///< same keyframes as the window before (trials that start in a gap)
  int invalid = 0;        ///< KeyframeWindow refused the data
};

/// Every window with every method's estimate, and the account of all trials.
struct ProtocolResult {
  std::vector<std::string> methods;
  std::vector<WindowRecord> windows;
  ProtocolCounts counts;
  std::string first_refusal;  ///< sentence of the first trial counted as invalid
  int first_keyframes = 0;    ///< of the anytime protocol; 0 without it
  bool has_truth = true;      ///< false: no error of any window was computed
  StreamCounts dropped;       ///< messages and observations rejected on the way, over all windows
};

/// Called at every trial with the number cut and the number in all, on the thread of runProtocol().
using ProgressCallback = std::function<void(int done, int total)>;

/// Runs every solver on the windows of a sequence: a trial every `stride` images, each cut once
/// from a fresh KeyframeWindow and given to every solver in turn, on one thread. A trial whose
/// data end before its longest window is full does not count, for any method. With several threads
/// different windows are solved at the same time, so solvers and options.downstream must allow
/// parallel calls (WindowSolver promises that).
ProtocolResult runProtocol(const Sequence& sequence,
                           const std::vector<const WindowSolver*>& solvers,
                           const ProtocolOptions& options = {},
                           const ProgressCallback& progress = {});

}  // namespace slim_init::evaluation
