// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/feature_message.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "slim_init/vins_adapter/host_glue.h"

namespace slim_init::vins_adapter {
namespace {

// 32-bit floats on the wire.
constexpr double kRounding = 1e-6;

FrameObservation makeFrame() {
  FrameObservation frame;
  frame.t = 1403636580.25;
  for (int i = 0; i < 3; ++i) {
    PointObservation point;
    point.id = 7 + 1000 * i;
    point.bearing = Eigen::Vector3d(0.1 * i, -0.2, 1.0).normalized();
    point.pixel = Eigen::Vector2d(100.5 + i, 50.25);
    frame.points.push_back(point);
    LineObservation line;
    line.id = 40 + i;
    line.start_bearing = Eigen::Vector3d(-0.3, 0.1 * i, 1.0).normalized();
    line.end_bearing = Eigen::Vector3d(0.4, 0.2 * i, 1.0).normalized();
    line.start_pixel = Eigen::Vector2d(10, 20 + i);
    line.end_pixel = Eigen::Vector2d(110, 30 + i);
    line.length_px = 100.5;
    line.detection_confidence = 0.75;
    line.match_quality = 0.5;
    frame.lines.push_back(line);
  }
  return frame;
}

GlueCloud packed(bool lines) {
  const FrameObservation frame = makeFrame();
  GlueCloud cloud;
  cloud.header.stamp.seconds = frame.t;
  std::string error;
  EXPECT_TRUE(lines ? writeLineMessage(frame, &cloud, &error)
                    : writePointMessage(frame, nullptr, &cloud, &error))
      << error;
  return cloud;
}

TEST(FeatureMessage, PointsThereAndBack) {
  const FrameObservation frame = makeFrame();
  FrameObservation back;
  back.lines = frame.lines;
  std::string error;
  ASSERT_TRUE(readPointMessage(packed(false), &back, &error)) << error;
  EXPECT_EQ(back.t, frame.t);
  EXPECT_EQ(back.lines.size(), 3u) << "reading points must not touch the lines";
  ASSERT_EQ(back.points.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(back.points[i].id, frame.points[i].id);
    EXPECT_LT((back.points[i].bearing - frame.points[i].bearing).norm(), kRounding);
    EXPECT_EQ(back.points[i].pixel, frame.points[i].pixel);
  }
}

TEST(FeatureMessage, LinesThereAndBack) {
  const GlueCloud cloud = packed(true);
  ASSERT_EQ(cloud.channels.size(), 10u);
  EXPECT_EQ(cloud.channels[1].name, "end_x");
  const FrameObservation frame = makeFrame();
  FrameObservation back;
  std::string error;
  ASSERT_TRUE(readLineMessage(cloud, &back, &error)) << error;
  ASSERT_EQ(back.lines.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const LineObservation &a = back.lines[i], &b = frame.lines[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_LT((a.start_bearing - b.start_bearing).norm(), kRounding);
    EXPECT_LT((a.end_bearing - b.end_bearing).norm(), kRounding);
    EXPECT_EQ(a.start_pixel, b.start_pixel);
    EXPECT_EQ(a.end_pixel, b.end_pixel);
    EXPECT_EQ(a.length_px, b.length_px);
    EXPECT_EQ(a.detection_confidence, b.detection_confidence);
    EXPECT_EQ(a.match_quality, b.match_quality);
  }
}

TEST(FeatureMessage, PointsCarryTheirVelocity) {
  const FrameObservation previous = makeFrame();
  FrameObservation frame = previous;
  frame.t += 0.1;
  frame.points[0].bearing = Eigen::Vector3d(0.02, -0.2, 1.0).normalized();
  frame.points[1].id = 99;  // new: no velocity
  GlueCloud cloud;
  ASSERT_TRUE(writePointMessage(frame, &previous, &cloud, nullptr));
  EXPECT_NEAR(cloud.channels[3].values[0], 0.2, 1e-5);
  EXPECT_EQ(cloud.channels[3].values[1], 0.0f);
  EXPECT_NEAR(cloud.channels[3].values[2], 0.0, 1e-5);
}

struct Garbage {
  const char* words;
  std::function<void(GlueCloud*)> spoil;
};

TEST(FeatureMessage, GarbageIsRefusedWithASentence) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Garbage> all = {
      {"the stamp is not finite", [](GlueCloud* c) { c->header.stamp.seconds = kNotComputed; }},
      {"channels, must have", [](GlueCloud* c) { c->channels.resize(4); }},
      {"has 2 values for 3 points", [](GlueCloud* c) { c->channels[2].values.pop_back(); }},
      {"has 3 values for 2 points", [](GlueCloud* c) { c->points.pop_back(); }},
      {"of point 1 is not finite", [&](GlueCloud* c) { c->channels[2].values[1] = nan; }},
      {"point 2 is not finite", [&](GlueCloud* c) { c->points[2].x = nan; }},
      {"z of point 0 is 2, must be 1", [](GlueCloud* c) { c->points[0].z = 2.0f; }},
      {"id of point 0 is -1", [](GlueCloud* c) { c->channels[0].values[0] = -1.0f; }},
      {"id of point 0 is 0.5", [](GlueCloud* c) { c->channels[0].values[0] = 0.5f; }},
      {"id of point 1 is 1.67772e+07",  // a float prints with six digits
       [](GlueCloud* c) { c->channels[0].values[1] = 16777216.0f; }},
  };
  for (const bool lines : {false, true}) {
    for (const Garbage& garbage : all) {
      GlueCloud cloud = packed(lines);
      garbage.spoil(&cloud);
      FrameObservation frame;
      frame.t = -1.0;
      std::string error;
      const bool read =
          lines ? readLineMessage(cloud, &frame, &error) : readPointMessage(cloud, &frame, &error);
      EXPECT_FALSE(read) << garbage.words;
      EXPECT_NE(error.find(garbage.words), std::string::npos) << error;
      EXPECT_EQ(error.find(lines ? "line message" : "feature message"), 0u) << error;
      EXPECT_EQ(frame.t, -1.0);
      EXPECT_TRUE(frame.points.empty() && frame.lines.empty());
    }
  }
  GlueCloud cloud = packed(true);
  cloud.channels[1].name = "end_y";
  std::string error;
  FrameObservation frame;
  EXPECT_FALSE(readLineMessage(cloud, &frame, &error));
  EXPECT_EQ(error, "line message: channel 1 is \"end_y\", must be \"end_x\"");
}

// A day of tracks: a float has no more ids.
TEST(FeatureMessage, IdsBeginAnew) {
  FrameObservation frame = makeFrame(), read;
  frame.points[0].id = kMaxMessageId;
  frame.points[1].id = kMaxMessageId + 1;
  frame.lines[0].id = 3 * (kMaxMessageId + 1) + 5;
  GlueCloud points, lines;
  ASSERT_TRUE(writePointMessage(frame, nullptr, &points, nullptr));
  ASSERT_TRUE(writeLineMessage(frame, &lines, nullptr));
  ASSERT_TRUE(readPointMessage(points, &read, nullptr) && readLineMessage(lines, &read, nullptr));
  EXPECT_EQ(read.points[0].id, kMaxMessageId);
  EXPECT_EQ(read.points[1].id, 0);
  EXPECT_EQ(read.lines[0].id, 5);
}

TEST(FeatureMessage, WhatCannotBeWrittenIsRefused) {
  FrameObservation frame = makeFrame();
  frame.points[1].bearing = Eigen::Vector3d(1.0, 0.0, -0.1).normalized();
  GlueCloud cloud;
  std::string error;
  EXPECT_FALSE(writePointMessage(frame, nullptr, &cloud, &error));
  EXPECT_EQ(error, "bearing of point 1007 does not point forward");
  EXPECT_TRUE(cloud.points.empty() && cloud.channels.empty());
}

}  // namespace
}  // namespace slim_init::vins_adapter
