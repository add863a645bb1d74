// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "rotation/track_pruning.h"
#include "support/exact_window.h"
#include "support/gaussian.h"

namespace slim_init {
namespace {

using Eigen::Vector3d;

const Vector3d kGyroBias = ExactWindowOptions().gyro_bias;

ExactWindowOptions excited() {
  ExactWindowOptions options = atTenHertz(15);
  options.pixel_noise = 0.6;  // one sigma
  options.imu_noise = true;
  return options;
}

/// The window with the tracks for which `isDrop` at one place of the image each, with the noise of
/// any other, and moved by `slide_px` a keyframe.
std::shared_ptr<const InitWindow> withDrops(const ExactWindowOptions& options,
                                            const std::function<bool(FeatureId)>& isDrop,
                                            double slide_px = 0.0) {
  const ExactWindow exact = makeExactWindow(options);
  Gaussian gaussian(7);
  std::vector<FrameObservation> frames = exact.keyframes;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (PointObservation& point : frames[k].points) {
      if (!isDrop(point.id)) continue;
      const double angle = static_cast<double>(point.id), focal = exact.calibration.focal_px;
      const double u = 0.6 * gaussian() + slide_px * static_cast<double>(k), v = 0.6 * gaussian();
      point.bearing =
          Vector3d(0.3 * std::cos(angle) + u / focal, 0.3 * std::sin(angle) + v / focal, 1.0);
      point.bearing.normalize();
    }
  }
  return windowOf(exact, frames);
}

bool everyFifth(FeatureId id) { return id % 5 == 0; }

int numberOf(const std::vector<char>& standing) {
  return static_cast<int>(std::count(standing.begin(), standing.end(), 1));
}

TEST(StaticTracks, DropsInATurningCameraStandAndTheSceneDoesNot) {
  // The rows of a rolling shutter are where they are: what stands has no motion to compensate.
  for (const double readout_s : {0.0, 0.03}) {
    ExactWindowOptions options = excited();
    options.readout_s = readout_s;
    const auto window = withDrops(options, everyFifth);
    const std::vector<char> standing = staticTracks(*window, kGyroBias);
    ASSERT_EQ(standing.size(), window->pointTracks().size());
    int drops = 0, found = 0;
    for (std::size_t i = 0; i < standing.size(); ++i) {
      const bool drop = everyFifth(window->pointTracks()[i].id);
      drops += drop ? 1 : 0;
      found += standing[i];
      EXPECT_TRUE(drop || !standing[i]) << window->pointTracks()[i].id;
    }
    EXPECT_GT(drops, 10);
    EXPECT_GE(found, 0.8 * drops) << "of tracks with fifteen observations and noise as assumed";
    int taken_out = 0;
    const auto scene = withoutStaticTracks(*window, kGyroBias, &taken_out);
    ASSERT_NE(scene, nullptr);
    EXPECT_EQ(taken_out, found);
    EXPECT_EQ(scene->pointTracks().size(), window->pointTracks().size() - found);
  }
}

TEST(StaticTracks, WhatSlidesIsOfTheScene) {
  const auto window = withDrops(excited(), everyFifth, 0.6);
  EXPECT_EQ(numberOf(staticTracks(*window, kGyroBias)), 0);
}

TEST(StaticTracks, WhereTheCameraDoesNotTurnTheyMayBeFarAway) {
  ExactWindowOptions options = excited();
  options.motion = Motion::kConstantVelocity;
  const auto window = withDrops(options, everyFifth);
  EXPECT_EQ(numberOf(staticTracks(*window, kGyroBias)), 0);
}

// In hover everything stands in the image, and a wrong rotation must not take it all.
TEST(StaticTracks, MostTracksAreRight) {
  ExactWindowOptions options = excited();
  options.motion = Motion::kHover;
  const auto window = withDrops(options, [](FeatureId) { return false; });
  EXPECT_EQ(numberOf(staticTracks(*window, kGyroBias + Vector3d(0.1, 0.0, 0.0))), 0);
  const auto tenth = [](int tenths) { return [tenths](FeatureId id) { return id % 10 < tenths; }; };
  EXPECT_GT(numberOf(staticTracks(*withDrops(excited(), tenth(4)), kGyroBias)), 0);
  EXPECT_EQ(numberOf(staticTracks(*withDrops(excited(), tenth(8)), kGyroBias)), 0);
}

TEST(StaticTracks, AFewAreLeft) {
  const auto window = withDrops(excited(), [](FeatureId id) { return id % 50 == 0; });
  const int few = numberOf(staticTracks(*window, kGyroBias));
  EXPECT_GT(few, 0);
  EXPECT_LT(few, 0.05 * static_cast<double>(window->pointTracks().size()));
  int taken_out = -1;
  EXPECT_EQ(withoutStaticTracks(*window, kGyroBias, &taken_out), nullptr);
  EXPECT_EQ(taken_out, 0);
}

}  // namespace
}  // namespace slim_init
