// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Tracks of points and lines as a front end would deliver them, without images.
#pragma once

#include <string>
#include <vector>

#include "slim_init/simulation/trajectory.h"
#include "slim_init/simulation/world.h"
#include "slim_init/types.h"

namespace slim_init::simulation {

/// Pinhole camera of the simulation (EuRoC cam0 without distortion).
struct PinholeCamera {
  int width = 752;
  int height = 480;
  double fx = 458.654, fy = 457.296, cx = 367.215, cy = 248.375;  ///< [px]
};

/// Number, noise and faults of the simulated tracks.
struct FeatureSimulationOptions {
  PinholeCamera camera;
  int max_points = 100;              ///< points tracked in one frame
  double min_point_distance = 15.0;  ///< of a new point from all tracked ones [px], as trackers do
  int max_lines = 25;                ///< lines tracked in one frame
  double pixel_noise = 0.6;          ///< point observation, standard deviation per axis [px]
  double line_noise = 0.7;           ///< line end point, standard deviation per axis [px]
  double drift = 0.0;                ///< random walk of a point track, per frame and axis [px]
  double outlier_rate =
      0.0;  ///< fraction of point tracks that leave their point at constant velocity
  double outlier_speed = 0.8;  ///< standard deviation of that velocity [px/frame]
  double track_life = 36.0;    ///< mean life of a track [frames]; tracks end earlier out of sight
  double line_slide = 0.25;    ///< largest fraction of a segment cut from each end, drawn per frame
  double min_line_length_px = 25.0;  ///< shorter segments are not seen
  unsigned seed = 1;
};

/// What was simulated, for reports.
struct FeatureSimulationCounts {
  int point_tracks = 0;
  int outlier_tracks = 0;
  int line_tracks = 0;
};

/// Projects the world at the camera poses T_w_b(t + td) * T_b_c for every image time t (ascending,
/// on the camera clock). Times outside the trajectory are clamped.
///
/// With a rolling shutter (calibration.readout_s) every point and both end points of every line are
/// seen by the camera as it is when their own row is exposed, rowTime() after t: the row depends on
/// the pose and the pose on the row, which is solved to 1e-13 s. `row` is that in which the noisy
/// observation lies, as a tracker would tell it.
///
/// A track ends when its point leaves the view or its life, drawn once, is over; lost tracks are
/// replaced by random ones of what is in view. Ids start at 0, separately for points and lines,
/// and are never reused. Observations are ascending in id. Point, line, noise, life and outlier
/// streams are independent and derived from the seed: equal seeds give equal bytes, the points do
/// not change when the lines are switched off, and noise levels do not change which tracks there
/// are.
std::vector<FrameObservation> simulateFeatures(const Trajectory& trajectory, const World& world,
                                               const Calibration& calibration,
                                               const std::vector<double>& image_times,
                                               const FeatureSimulationOptions& options,
                                               FeatureSimulationCounts* counts = nullptr);

}  // namespace slim_init::simulation
