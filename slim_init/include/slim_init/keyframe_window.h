// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The one streaming entry: command line, ROS node and host adapter feed the same class.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/stream_check.h"

namespace slim_init {

/// Result of cutting a window.
struct WindowCut {
  /// kSuccess with a window, or kTooFewKeyframes / kInvalidInput with none.
  InitStatus status = InitStatus::kTooFewKeyframes;
  std::string message;  ///< what was found, what is needed
  std::shared_ptr<const InitWindow> window;
};

/// Ring buffer of IMU samples and frames from which a window can be cut at any moment. Every
/// message passes a StreamCheck first; lines meet their frame here, whichever comes first; the time
/// offset td is applied here and nowhere else (Calibration::imuTime).
///
/// Not thread-safe: one owner feeds and cuts; another thread cuts from a copy, which shares the
/// frames. Memory is bounded by WindowOptions::buffer_s.
class KeyframeWindow {
 public:
  /// Calibration and options are taken as they are; call their validate() first.
  KeyframeWindow(const Calibration& calibration, const WindowOptions& options,
                 const StreamOptions& streams = StreamOptions());

  /// Appends a sample; time must increase. On kRestarted the buffer holds this sample alone.
  AddStatus addImu(const ImuSample& sample);

  /// Appends a frame, `frame.t` its stamp on the camera clock; time must increase. The frame may
  /// run ahead of the IMU: it is used as soon as the samples cover it. On kRestarted the buffer
  /// holds this frame alone. Observations that no solver can use are dropped and counted.
  AddStatus addFrame(FrameObservation frame);

  /// The lines of the frame with this stamp (camera clock [s], to within a tenth of a millisecond),
  /// before or after the frame: kAdded, kWaiting for a frame that is still to come, kUnmatched, or
  /// kNotFinite. No more than kMaxWaitingLines messages wait; the oldest is dropped beyond.
  AddStatus addLines(double stamp, std::vector<LineObservation> lines);
  static constexpr std::size_t kMaxWaitingLines = 100;
  /// Two stamps of one image differ by rounding at most, those of two images by far more [s].
  static constexpr double kSameStamp = 1e-4;

  /// Appends a velocity of Calibration::speed_sensor; time must increase.
  AddStatus addSpeed(const SpeedSample& sample);

  /// The time offset [s] (as Calibration::td) of all frames, also of those in the buffer: a window
  /// has one. A value that Calibration::validate() refuses is ignored.
  void setTd(double td);

  /// Cuts the newest window. Keyframes are chosen backwards from the newest frame that the IMU
  /// covers, each at least `min_interval_s` before the next, up to `keyframes` of them, and never
  /// across a gap in frames (`max_frame_gap_s`) or IMU samples (`max_imu_gap_s`). Where there are
  /// more, and max_span_s allows a longer window, `keyframes` of them are spread over it: a
  /// window that grows keeps its length and thins out. Fewer than `min_keyframes` is
  /// kTooFewKeyframes. `leave_out`: of the keyframes chosen, this many of the
  /// newest are removed again, so that the window is what it was before them; it then needs
  /// kMinKeyframes.
  WindowCut cut(int leave_out = 0) const { return cut(options_, leave_out); }

  /// The same with other keyframes from the same buffer: `selection` in place of the options.
  WindowCut cut(const WindowOptions& selection, int leave_out) const;

  /// The same of the frames within `span` [s, IMU clock]; kMinKeyframes are enough.
  WindowCut cutWithin(const WindowOptions& selection, const TimeSpan& span) const;

  /// IMU samples held, oldest first.
  const std::deque<ImuSample>& imu() const { return imu_; }

  /// Since construction or reset(); restarts of the streams do not clear it.
  const StreamCounts& counts() const { return check_.counts(); }
  const Calibration& calibration() const { return calibration_; }  ///< td as last set
  const WindowOptions& options() const { return options_; }

  /// Forgets all data and counts.
  void reset();

 private:
  struct WaitingLines {
    double stamp = 0.0;
    std::vector<LineObservation> lines;
  };

  void dropData();
  void trim();
  AddStatus merge(std::vector<LineObservation> lines, FrameObservation* observation);
  void mergeWaiting(double stamp, FrameObservation* observation);
  void waitForFrame(double stamp, std::vector<LineObservation> lines);
  double frameTime(int i) const { return calibration_.imuTime(frames_[i]->t); }
  double imuStart(int newest) const;
  std::vector<int> chooseKeyframes(const WindowOptions& selection, const TimeSpan& span,
                                   std::string* reason) const;
  WindowCut makeWindow(const std::vector<int>& chosen, int needed, const std::string& reason) const;
  std::vector<int> spreadKeyframes(const WindowOptions& selection,
                                   const std::vector<int>& frames) const;
  std::vector<ImuSample> samplesCovering(double t_first, double t_last) const;

  Calibration calibration_;
  WindowOptions options_;
  StreamCheck check_;
  std::deque<ImuSample> imu_;
  // t on the camera clock; cleaned (data/clean_frame.h). Shared with copies: never changed.
  std::deque<std::shared_ptr<const FrameObservation>> frames_;
  std::deque<SpeedSample> speeds_;
  std::deque<WaitingLines> waiting_;  // ascending in stamp
};

}  // namespace slim_init
