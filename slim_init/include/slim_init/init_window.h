// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The immutable input of a WindowSolver.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/stream_check.h"
#include "slim_init/types.h"

namespace slim_init {

/// One observation of a point track.
struct WindowPoint : PointObservation {
  int keyframe = 0;  ///< index into InitWindow::times()
};

/// One observation of a line track.
struct WindowLine : LineObservation {
  int keyframe = 0;
  Eigen::Vector3d normal;  ///< unit normal of the interpretation plane (s x e)/|s x e|, in c
};

/// A contiguous range [begin, end) of observations of one track, ascending in keyframe.
struct Track {
  FeatureId id = -1;
  int begin = 0;
  int end = 0;
  int size() const { return end - begin; }
};

/// N keyframes with their tracks and the inertial data between them. Immutable after creation, so
/// every solver sees the same bytes. Tracks are sorted by id; tracks with one observation are
/// discarded.
class InitWindow {
 public:
  /// Builds a window. `keyframes` ascending in time on the IMU clock, `imu` ascending and covering
  /// [first keyframe, last keyframe]; `speeds` ascending, of Calibration::speed_sensor. On a
  /// violated invariant returns null and a message in `error` (may be null) naming the value and
  /// the bound.
  static std::shared_ptr<const InitWindow> create(const Calibration& calibration,
                                                  const std::vector<FrameObservation>& keyframes,
                                                  std::vector<ImuSample> imu,
                                                  std::string* error = nullptr,
                                                  std::vector<SpeedSample> speeds = {});

  static constexpr double kImuMargin = 0.1;  ///< [s]
  /// Between speeds further apart none is interpolated [s]: two messages of a wheel at 10 Hz.
  static constexpr double kMaxSpeedGap = 0.2;

  int size() const { return static_cast<int>(common_->times.size()); }
  /// Keyframe times on the IMU clock [s].
  const std::vector<double>& times() const { return common_->times; }
  const Calibration& calibration() const { return common_->calibration; }
  /// Raw samples covering the window: the first is at or before times().front(), the last at or
  /// after times().back(). Up to kImuMargin more on either side, where there are any, so that the
  /// keyframes can be moved by an error of td.
  const std::vector<ImuSample>& imu() const { return common_->imu; }

  /// Measured velocities, ascending in time; those around the keyframes among them.
  const std::vector<SpeedSample>& speeds() const { return common_->speeds; }

  const std::vector<Track>& pointTracks() const { return point_tracks_; }
  const std::vector<WindowPoint>& pointObservations() const { return point_observations_; }
  const std::vector<Track>& lineTracks() const { return common_->line_tracks; }
  const std::vector<WindowLine>& lineObservations() const { return common_->line_observations; }
  /// Every line of one keyframe, single observations included: a vanishing point needs no track.
  const std::vector<WindowLine>& linesOfKeyframe(int k) const { return common_->keyframe_lines[k]; }

 private:
  /// What all windows that differ in their point tracks alone have in common, never copied.
  struct Common {
    Calibration calibration;
    std::vector<double> times;
    std::vector<ImuSample> imu;
    std::vector<SpeedSample> speeds;
    std::vector<Track> line_tracks;
    std::vector<WindowLine> line_observations;
    std::vector<std::vector<WindowLine>> keyframe_lines;
  };

  InitWindow() = default;
  friend class KeyframeWindow;
  /// As create(), of frames that cleanFrame() has been applied to, at these times of the IMU clock
  /// [s] in place of their own.
  static std::shared_ptr<const InitWindow> fromCleanFrames(
      const Calibration& calibration, const std::vector<const FrameObservation*>& keyframes,
      std::vector<double> times, std::vector<ImuSample> imu, std::string* error,
      std::vector<SpeedSample> speeds);
  friend std::shared_ptr<const InitWindow> withObservations(const InitWindow& window,
                                                            const std::vector<char>& keep);
  friend std::shared_ptr<const InitWindow> withCalibration(const InitWindow& window,
                                                           const Calibration& calibration);
  friend std::shared_ptr<const InitWindow> withoutSpeeds(const InitWindow& window);
  friend std::shared_ptr<const InitWindow> withRowsCompensated(const InitWindow& window,
                                                               const Eigen::Vector3d& gyro_bias);

  std::shared_ptr<const Common> common_;
  std::vector<Track> point_tracks_;
  std::vector<WindowPoint> point_observations_;
};

}  // namespace slim_init
