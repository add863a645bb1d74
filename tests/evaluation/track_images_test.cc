// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/track_images.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/euroc_camera.h"
#include "support/frames.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

/// Pictures of a card with squares that slides to the right, 2 px an image; the camera turns about
/// nothing.
class SlidingCard : public ImageSequence {
 public:
  explicit SlidingCard(int images) {
    name = "card";
    t0_ns = 1000;
    for (int k = 0; k <= 10 * images; ++k) {
      ImuSample sample;
      sample.t = 0.005 * k;
      sample.accel.z() = 9.81;
      imu.push_back(sample);
    }
    for (int k = 0; k < images; ++k) image_times.push_back(0.05 * k);
  }

  cv::Mat image(std::size_t k, std::string* error) override {
    if (unreadable.count(k) > 0) {
      *error = "image " + std::to_string(k) + " is torn";
      return cv::Mat();
    }
    cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(60));
    for (int i = 0; i < 20; ++i) {
      const int x = 20 + 55 * (i % 5) + 2 * static_cast<int>(k);
      cv::rectangle(picture, cv::Rect(x, 20 + 50 * (i / 5), 22, 22), cv::Scalar(110 + 6 * i),
                    cv::FILLED);
    }
    if (small.count(k) > 0) return picture(cv::Rect(0, 0, 100, 100)).clone();
    return picture;
  }

  void moveImages(double seconds) {
    for (double& t : image_times) t += seconds;
  }

  std::set<std::size_t> unreadable, small;
};

struct Tracked {
  std::string error;
  std::vector<FrameObservation> frames;
  TrackingSummary summary;
};

Tracked track(SlidingCard* card, const Calibration& calibration = Calibration(),
              const std::function<void(int, int)>& progress = {}) {
  const auto camera = cameraOf(320, 240, 200.0, 200.0, 160.0, 120.0);
  Tracked tracked;
  tracked.error = trackImages(card, camera, calibration, feature_tracker_lines::FrontEndOptions(),
                              progress, &tracked.frames, &tracked.summary);
  return tracked;
}

TEST(TrackImages, TracksRunThroughTheWholeRecording) {
  SlidingCard card(12);
  int last_done = 0;
  const Tracked tracked = track(&card, Calibration(), [&](int done, int total) {
    EXPECT_EQ(total, 12);
    EXPECT_GT(done, last_done);
    last_done = done;
  });
  ASSERT_EQ(tracked.error, "");
  EXPECT_EQ(last_done, 12);
  ASSERT_EQ(tracked.frames.size(), 12u);
  EXPECT_EQ(tracked.summary.tracked, 12);
  EXPECT_EQ(tracked.summary.images, 12);
  EXPECT_EQ(tracked.frames[5].t, card.image_times[5]);
  // 80 corners of squares that nothing hides.
  EXPECT_GT(tracked.summary.points, 20.0);
  EXPECT_GT(tracked.summary.points_carried, 0.7 * tracked.summary.points);
  EXPECT_GT(countIn(idSet(tracked.frames.front().points), tracked.frames.back().points), 10);
  EXPECT_GT(tracked.summary.total_ms_median, 0.0);
}

TEST(TrackImages, WhatCannotBeUsedIsCountedAndLeftOut) {
  SlidingCard card(12);
  card.unreadable = {3, 7};
  card.small = {5};
  const Tracked tracked = track(&card);
  ASSERT_EQ(tracked.error, "");
  EXPECT_EQ(tracked.summary.unreadable, 2);
  EXPECT_EQ(tracked.summary.refused, 1);
  EXPECT_EQ(tracked.summary.tracked, 9);
  EXPECT_EQ(tracked.summary.first_problem, "image 3 is torn");
  ASSERT_EQ(tracked.frames.size(), 9u);
  EXPECT_EQ(tracked.frames[3].t, card.image_times[4]);
}

TEST(TrackImages, ImagesOutsideTheImuAreLeftOut) {
  SlidingCard card(12);
  card.moveImages(-0.06);  // images 0 and 1 lie before the first sample
  Tracked tracked = track(&card);
  ASSERT_EQ(tracked.error, "");
  EXPECT_EQ(tracked.summary.outside_imu, 2);
  EXPECT_EQ(tracked.summary.tracked, 10);
  // The offset of the camera's clock brings them back.
  Calibration calibration;
  calibration.td = 0.061;
  tracked = track(&card, calibration);
  EXPECT_EQ(tracked.summary.outside_imu, 0);
  EXPECT_EQ(tracked.summary.tracked, 12);
}

TEST(TrackImages, TooFewImagesAreAnErrorThatCountsThem) {
  SlidingCard card(4);
  card.unreadable = {0, 1};
  card.small = {2};
  const Tracked tracked = track(&card);
  expectParts(tracked.error,
              "card: 1 of 4 images could be tracked|2 cannot be read|1 were refused|first: image 0 "
              "is torn");
}

}  // namespace
}  // namespace slim_init::evaluation
