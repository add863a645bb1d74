// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Where tracks start: triangulation of points and lines, and what they do with views that determine
// nothing.
#include "estimation/visual_tracks.h"

#include <gtest/gtest.h>

#include <vector>

#include "geometry/so3.h"
#include "lines/line_track.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

// Four bodies that move sideways and turn.
WindowState someMotion() {
  WindowState state;
  state.p_b0.resize(3, 4);
  state.v_b0.setZero(3, 4);
  for (int k = 0; k < 4; ++k) {
    state.R_b0_bk.push_back(expSO3(0.1 * k * Vector3d(0.3, -0.5, 0.8)));
    state.p_b0.col(k) = 0.2 * k * Vector3d(1.0, 0.3, -0.1);
  }
  return state;
}

const Vector3d kT_b_c(0.05, -0.02, 0.01);

Vector3d bearingOf(const WindowState& state, int k, const Vector3d& X) {
  return (state.R_b0_bk[k].transpose() * (X - state.p_b0.col(k)) - kT_b_c).normalized();
}

std::vector<PointView> pointViews(const WindowState& state, const Vector3d& X) {
  std::vector<PointView> views(state.size());
  for (int k = 0; k < state.size(); ++k) {
    views[k].keyframe = k;
    views[k].bearing_b = bearingOf(state, k, X);
    views[k].tangent_b = tangentBasis(views[k].bearing_b).transpose();
  }
  return views;
}

std::vector<LineView> lineViews(const WindowState& state, const Vector3d& from,
                                const Vector3d& to) {
  std::vector<LineView> views(state.size());
  for (int k = 0; k < state.size(); ++k) {
    views[k].keyframe = k;
    views[k].start_b = bearingOf(state, k, from);
    views[k].end_b = bearingOf(state, k, to);
  }
  return views;
}

TEST(Triangulate, APointIsWhereItIs) {
  const WindowState state = someMotion();
  for (const Vector3d& X : {Vector3d(0.5, -0.3, 3.0), Vector3d(-1.0, 2.0, 8.0)}) {
    const PointParameters point = triangulate(pointViews(state, X).data(), 4, state, kT_b_c);
    EXPECT_LT((point.origin + point.direction / point.inverse_depth - X).norm(), 1e-9 * X.norm());
    for (const PointView& view : pointViews(state, X)) {
      ViewDerivatives<3> at;
      evaluate(view, point, state, kT_b_c, 1.0, &at);
      EXPECT_LT(at.r.norm(), 1e-12);
    }
  }
}

TEST(Triangulate, APointAtInfinityBehindOrTooNearIsClamped) {
  const WindowState state = someMotion();
  // The same direction from everywhere: at infinity.
  std::vector<PointView> views = pointViews(state, Vector3d(0, 0, 5));
  for (PointView& view : views) {
    view.bearing_b = state.R_b0_bk[view.keyframe].transpose() * Vector3d::UnitZ();
  }
  EXPECT_NEAR(triangulate(views.data(), 4, state, kT_b_c).inverse_depth, 0.0, 1e-12);
  // Rays that meet behind the cameras start at infinity.
  views = pointViews(state, Vector3d(0.5, -0.3, 3.0));
  for (PointView& view : views) view.bearing_b = -view.bearing_b;
  EXPECT_EQ(triangulate(views.data(), 4, state, kT_b_c).inverse_depth, 0.0);
  // At 2 cm: not nearer than 10 cm.
  const Vector3d centre = state.p_b0.col(2) + state.R_b0_bk[2] * kT_b_c;
  views = pointViews(state, centre + 0.02 * Vector3d::UnitZ());
  EXPECT_EQ(triangulate(views.data(), 4, state, kT_b_c).inverse_depth, 10.0);
}

TEST(Triangulate, WithoutABaselineThereIsNoDepth) {
  WindowState state = someMotion();
  state.p_b0.setZero();
  for (Eigen::Matrix3d& R : state.R_b0_bk) R.setIdentity();
  const PointParameters point =
      triangulate(pointViews(state, Vector3d(0, 1, 4)).data(), 4, state, kT_b_c);
  EXPECT_EQ(point.inverse_depth, 0.0);
  LineParameters line;
  const auto views = lineViews(state, Vector3d(-1, 0, 4), Vector3d(1, 0.5, 4));
  ASSERT_TRUE(triangulate(views.data(), 4, state, kT_b_c, &line));
  EXPECT_EQ(line.inverse_distance, 0.0);
}

TEST(Triangulate, ALineIsWhereItIs) {
  const WindowState state = someMotion();
  const Vector3d from(-1.0, 0.4, 4.0), to(0.5, -0.2, 5.0);
  const auto views = lineViews(state, from, to);
  LineParameters line;
  ASSERT_TRUE(triangulate(views.data(), 4, state, kT_b_c, &line));
  const Vector3d direction = (to - from).normalized();
  EXPECT_LT(direction.cross(line.frame.col(1)).norm(), 1e-9);
  EXPECT_LT((line.frame.transpose() * line.frame - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  const Vector3d foot = line.origin + line.frame.col(0) / line.inverse_distance;
  EXPECT_LT(direction.cross(foot - from).norm(), 1e-8);
  for (const LineView& view : views) {
    ViewDerivatives<4> at;
    evaluate(view, line, state, kT_b_c, 1.0, &at);
    EXPECT_LT(at.r.norm(), 1e-10);
  }
}

TEST(Triangulate, ASegmentWithoutLengthHasNoLine) {
  const WindowState state = someMotion();
  std::vector<LineView> none = lineViews(state, Vector3d(0, 0, 4), Vector3d(1, 0, 4));
  for (LineView& view : none) view.end_b = view.start_b;
  LineParameters line;
  EXPECT_FALSE(triangulate(none.data(), 4, state, kT_b_c, &line));
}

TEST(TrackParameters, MoveByTheirTangents) {
  PointParameters point;
  point.origin = Vector3d(1, 2, 3);
  point.direction = Vector3d(0.6, 0, 0.8);
  point.tangent = tangentBasis(point.direction);
  point.inverse_depth = 0.2;
  const PointParameters moved = point.moved(Vector3d(0.01, -0.02, 0.05));
  EXPECT_EQ(moved.origin, point.origin);
  EXPECT_NEAR(moved.inverse_depth, 0.25, 1e-15);
  EXPECT_NEAR(moved.direction.norm(), 1.0, 1e-15);
  EXPECT_NEAR(std::acos(moved.direction.dot(point.direction)), std::atan(std::hypot(0.01, 0.02)),
              1e-9);
  EXPECT_LT((moved.tangent.transpose() * moved.direction).norm(), 1e-15);
  LineParameters line;
  line.origin = Vector3d(1, 2, 3);
  line.frame = expSO3(Vector3d(0.1, 0.2, 0.3));
  line.inverse_distance = -0.1;
  Eigen::Vector4d step(0.02, 0.0, -0.01, 0.3);
  const LineParameters turned = line.moved(step);
  EXPECT_LT((turned.frame - expSO3(step.head<3>()) * line.frame).norm(), 1e-15);
  EXPECT_NEAR(turned.inverse_distance, 0.2, 1e-15);
}

}  // namespace
}  // namespace slim_init
