// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/track_truth.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "support/euroc_camera.h"

namespace slim_init::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using feature_tracker_lines::Camera;
using feature_tracker_lines::CameraParameters;
using testing_support::eurocCamera;

constexpr double kDegree = 3.141592653589793 / 180.0;
constexpr double kInterval = 0.05;  // [s] of the images

// A wall at x = 5 and a box in front of it.
Scene wallAndBox() {
  Scene scene;
  scene.kind = "test";
  scene.looks = {Look()};
  scene.solids = {{"wall", Shape::kBox, {5.1, 0, 0}, {0.1, 10, 10}, 0.0, 2, 0},
                  {"box", Shape::kBox, {2.5, 0, 0}, {0.5, 0.4, 0.4}, 0.0, 2, 0},
                  {"pipe", Shape::kCylinder, {3.0, -1.5, 0}, {0.1, 0.1, 3.0}, 0.0, 2, 0}};
  return scene;
}

// The camera slides sideways, looking along x.
CameraPose poseAt(double frame) {
  CameraPose pose;
  pose.R_w_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  pose.R_w_c = pose.R_w_c * Eigen::AngleAxisd(0.005 * frame, Vector3d::UnitY()).toRotationMatrix();
  pose.t_w_c = Vector3d(0.0, 0.03 * frame, 0.01 * frame);
  return pose;
}

PointObservation seePoint(FeatureId id, const Vector3d& place_w, const CameraPose& pose,
                          const Vector2d& error = Vector2d::Zero()) {
  const Camera camera(eurocCamera());
  PointObservation seen;
  seen.id = id;
  EXPECT_TRUE(camera.project(pose.R_w_c.transpose() * (place_w - pose.t_w_c), &seen.pixel));
  seen.pixel += error;
  seen.bearing = camera.bearing(seen.pixel);
  return seen;
}

LineObservation seeLine(FeatureId id, const Vector3d& start_w, const Vector3d& end_w,
                        const CameraPose& pose) {
  LineObservation seen;
  seen.id = id;
  seen.start_bearing = (pose.R_w_c.transpose() * (start_w - pose.t_w_c)).normalized();
  seen.end_bearing = (pose.R_w_c.transpose() * (end_w - pose.t_w_c)).normalized();
  return seen;
}

TrackQuality evaluate(const Scene& scene, const std::vector<FrameObservation>& frames) {
  TrackTruth truth(scene, eurocCamera());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    // The same path between the images: a frame follows the one before after kInterval.
    truth.addFrame(frames[i], [i](double dt) { return poseAt(i + dt / kInterval); });
  }
  return truth.evaluate();
}

std::vector<FrameObservation> frames(int count) {
  std::vector<FrameObservation> list(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) list[static_cast<std::size_t>(i)].t = kInterval * i;
  return list;
}

TEST(TrackTruth, ExactPointsHaveNoErrorAndMovedOnesTheirOwn) {
  std::vector<FrameObservation> list = frames(11);
  const Vector3d on_wall(5.0, 1.5, 0.6);
  const Vector3d on_box(2.0, 0.1, -0.2);
  for (int i = 0; i < 11; ++i) {
    FrameObservation& frame = list[static_cast<std::size_t>(i)];
    frame.points.push_back(seePoint(1, on_wall, poseAt(i)));
    // Drifts by 0.3 px an image.
    frame.points.push_back(seePoint(2, on_box, poseAt(i), Vector2d(0.3 * i, 0.0)));
  }
  const TrackQuality quality = evaluate(wallAndBox(), list);
  EXPECT_EQ(quality.frames, 11);
  EXPECT_EQ(quality.point_tracks, 2);
  EXPECT_EQ(quality.point_tracks_without_truth, 0);
  ASSERT_EQ(quality.points.size(), 20u);
  for (const PointError& e : quality.points) {
    EXPECT_FALSE(e.occluded);
    EXPECT_EQ(e.age, e.frame);
    EXPECT_NEAR(e.error_px, e.id == 1 ? 0.0 : 0.3 * e.frame, 1e-6);
  }
  // Keyframes are every fifth image: 0 to 5, 5 to 10, each 1.5 px of drift.
  ASSERT_EQ(quality.keyframe_points.size(), 4u);
  for (const PointError& e : quality.keyframe_points) {
    EXPECT_EQ(e.age, 5);
    // Seen anew from where the drift has led, hence not exact.
    EXPECT_NEAR(e.error_px, e.id == 1 ? 0.0 : 1.5, 0.05);
  }
}

TEST(TrackTruth, HiddenPointIsSaidSo) {
  std::vector<FrameObservation> list = frames(14);
  // Just beside the box's silhouette, on the wall; the camera's slide to +y hides it.
  const Vector3d on_wall(5.0, -1.2, 0.0);
  for (int i = 0; i < 14; ++i) {
    list[static_cast<std::size_t>(i)].points.push_back(seePoint(1, on_wall, poseAt(i)));
  }
  const TrackQuality quality = evaluate(wallAndBox(), list);
  ASSERT_EQ(quality.points.size(), 13u);
  EXPECT_FALSE(quality.points.front().occluded);
  EXPECT_TRUE(quality.points.back().occluded);
}

TEST(TrackTruth, CornerOfABoxBelongsToTheBox) {
  // The first observation is half a pixel beside the corner, where the ray passes the box and meets
  // the wall 3 m behind it.
  const Vector3d corner(2.0, 0.4, 0.4);
  std::vector<FrameObservation> list = frames(11);
  for (int i = 0; i < 11; ++i) {
    list[static_cast<std::size_t>(i)].points.push_back(
        seePoint(1, corner, poseAt(i), Vector2d(-0.5, -0.5)));
  }
  const TrackQuality quality = evaluate(wallAndBox(), list);
  ASSERT_EQ(quality.points.size(), 10u);
  for (const PointError& e : quality.points) EXPECT_LT(e.error_px, 0.05);
}

TEST(TrackTruth, LinesOnASurfaceAndOnAnEdge) {
  std::vector<FrameObservation> list = frames(11);
  const Vector3d a(5.0, 1.0, -0.5), b(5.0, 2.0, 0.7);  // on the wall
  for (int i = 0; i < 11; ++i) {
    FrameObservation& frame = list[static_cast<std::size_t>(i)];
    const double slide = 0.02 * i;  // the ends of a segment are not the same places
    frame.lines.push_back(seeLine(1, a + slide * (b - a), b - slide * (b - a), poseAt(i)));
    frame.lines.push_back(seeLine(2, {2.0, 0.4, -0.4}, {2.0, 0.4, 0.4}, poseAt(i)));  // an edge
    // Jumps to a parallel line 3 cm away after the third image.
    const Vector3d jump(0.0, 0.0, i > 3 ? 0.03 : 0.0);
    frame.lines.push_back(
        seeLine(3, Vector3d(5.0, 1.0, 1.0) + jump, Vector3d(5.0, 2.0, 1.0) + jump, poseAt(i)));
    // On the pipe there is no line to be found again.
    frame.lines.push_back(seeLine(4, {2.9, -1.5, -0.4}, {2.9, -1.5, 0.4}, poseAt(i)));
  }
  const TrackQuality quality = evaluate(wallAndBox(), list);
  EXPECT_EQ(quality.line_tracks, 4);
  EXPECT_EQ(quality.line_tracks_without_truth, 1);
  ASSERT_EQ(quality.lines.size(), 30u);
  const double jump_px = 0.03 / 5.0 * Camera(eurocCamera()).focalPx();
  for (const LineError& e : quality.lines) {
    const double expected = e.id == 3 && e.frame > 3 ? jump_px : 0.0;
    EXPECT_NEAR(e.offset_px, expected, 0.15 * jump_px * (expected > 0.0 ? 1.0 : 0.0) + 1e-6)
        << e.id;
    EXPECT_LT(e.angle_deg, expected > 0.0 ? 0.1 : 1e-5);
  }
  ASSERT_EQ(quality.keyframe_lines.size(), 6u);
  int lost = 0;
  for (const LineError& e : quality.keyframe_lines) {
    lost += e.end_px > kSameLinePx ? 1 : 0;
  }
  EXPECT_EQ(lost, 1);  // the jump, between the first two keyframes
}

TEST(TrackTruth, AngleOfATurnedLine) {
  std::vector<FrameObservation> list = frames(2);
  const Vector3d middle(5.0, 1.6, 0.0);
  for (int i = 0; i < 2; ++i) {
    const double angle = i == 0 ? 0.0 : 2.0 * kDegree;
    const Vector3d half(0.0, 0.4 * std::sin(angle), 0.4 * std::cos(angle));
    list[static_cast<std::size_t>(i)].lines.push_back(
        seeLine(1, middle - half, middle + half, poseAt(i)));
  }
  const TrackQuality quality = evaluate(wallAndBox(), list);
  ASSERT_EQ(quality.lines.size(), 1u);
  // The wall is seen at a slight slant.
  EXPECT_NEAR(quality.lines[0].angle_deg, 2.0, 0.1);
  EXPECT_LT(quality.lines[0].offset_px, 0.01);
}

TEST(TrackTruth, OpenViewHasNoTruth) {
  std::vector<FrameObservation> list = frames(3);
  Scene scene = wallAndBox();
  scene.solids.erase(scene.solids.begin());  // no wall
  for (int i = 0; i < 3; ++i) {
    list[static_cast<std::size_t>(i)].points.push_back(seePoint(1, {5.0, 1.5, 0.6}, poseAt(i)));
  }
  const TrackQuality quality = evaluate(scene, list);
  EXPECT_EQ(quality.point_tracks, 1);
  EXPECT_EQ(quality.point_tracks_without_truth, 1);
  EXPECT_TRUE(quality.points.empty());
}

// A camera that moves while its rows are exposed: seen at their own time the features have no
// error, taken at the stamp they have that of the motion in between.
TEST(TrackTruth, ObservationsAreTakenAtTheirOwnTime) {
  for (const bool told : {true, false}) {
    std::vector<FrameObservation> list = frames(6);
    for (int i = 0; i < 6; ++i) {
      FrameObservation& frame = list[static_cast<std::size_t>(i)];
      const double dt = 0.4 * kInterval * (i % 2 == 0 ? -1 : 1);
      frame.points.push_back(seePoint(1, {5.0, 1.5, 0.6}, poseAt(i + dt / kInterval)));
      // The start on one row, the end on another.
      const Vector3d start(5.0, 1.0, -0.5), end(5.0, 2.0, 0.7);
      LineObservation line = seeLine(2, start, end, poseAt(i + dt / kInterval));
      line.end_bearing = seeLine(2, start, end, poseAt(i - dt / kInterval)).end_bearing;
      if (told) {
        // As if the image took a second to read: the row is its time.
        frame.points.back().row = line.start_row = dt;
        line.end_row = -dt;
      }
      frame.lines.push_back(line);
    }
    const TrackQuality quality = evaluate(wallAndBox(), list);
    ASSERT_EQ(quality.points.size(), 5u);
    ASSERT_EQ(quality.lines.size(), 5u);
    double point_px = 0.0, line_px = 0.0;
    for (const PointError& e : quality.points) point_px = std::max(point_px, e.error_px);
    for (const LineError& e : quality.lines) line_px = std::max(line_px, e.end_px);
    if (told) {
      EXPECT_LT(point_px, 1e-6);
      EXPECT_LT(line_px, 1e-6);
    } else {
      EXPECT_GT(point_px, 0.3);
      EXPECT_GT(line_px, 0.1);
    }
  }
}

}  // namespace
}  // namespace slim_init::simulation
