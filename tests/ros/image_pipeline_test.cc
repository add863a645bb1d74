// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/image_pipeline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "slim_init/feature_tracker_lines/image_message.h"
#include "support/euroc_camera.h"
#include "support/frames.h"

namespace slim_init::node {
namespace {

using feature_tracker_lines::ImageFrontEnd;

constexpr int kWidth = 240, kHeight = 180;
constexpr double kImageInterval = 0.05, kImuInterval = 0.005;

Config smallCamera() {
  Config config;
  config.camera = cameraOf(kWidth, kHeight, 150.0, 150.0, 119.5, 89.5);
  config.calibration.focal_px = 150.0;
  config.calibration.td = 0.003;
  return config;
}

/// Blots that drift to the right.
cv::Mat imageAt(double t) {
  cv::Mat image(kHeight, kWidth, CV_8UC1, cv::Scalar(100));
  for (int i = 0; i < 60; ++i) {
    const double x = 120.0 + 150.0 * std::sin(12.9898 * i) + 30.0 * t;
    const double y = 90.0 + 100.0 * std::sin(78.233 * i);
    constexpr int kShift = 8;
    cv::circle(image, cv::Point(std::lround(256.0 * x), std::lround(256.0 * y)), 5 << kShift,
               cv::Scalar(30 + (i * 53) % 200), cv::FILLED, cv::LINE_AA, kShift);
  }
  return image;
}

ImuSample sampleAt(double t) {
  ImuSample sample;
  sample.t = t;
  sample.gyro = Eigen::Vector3d(0.01, 0.02, -0.01);
  sample.accel.z() = 9.81;
  return sample;
}

/// Ids of points, and of lines, begin with zero.
FrameObservation withIdsFromZero(FrameObservation frame) {
  const auto shift = [](auto* list) {
    const std::set<FeatureId> ids = idSet(*list);
    for (auto& one : *list) one.id -= *ids.begin();
  };
  shift(&frame.points);
  shift(&frame.lines);
  return frame;
}

/// What `slim_init ab` would hand to the initializer: IMU up to the first sample at or after an
/// image, images before the first sample left out.
std::vector<FrameObservation> offLine(const Config& config, const std::vector<double>& images,
                                      const std::vector<double>& imu) {
  ImageFrontEnd front_end(config.camera, config.calibration, config.front_end);
  std::vector<FrameObservation> frames;
  std::size_t next = 0;
  for (const double t : images) {
    const double t_imu = t + config.calibration.td;
    if (t_imu < imu.front()) continue;
    while (next < imu.size() && (next == 0 || imu[next - 1] < t_imu)) {
      front_end.addImu(sampleAt(imu[next++]));
    }
    FrameObservation frame;
    front_end.addImage(t, imageAt(t), &frame);
    frames.push_back(frame);
  }
  return frames;
}

class ImagePipelineTest : public ::testing::Test {
 protected:
  ImagePipelineTest() {
    options_.publish_rate_hz = 0.0;
    for (int k = 0; k < 20; ++k) images_.push_back(kImageInterval * k);
    for (int k = 16; k < 240; ++k) imu_.push_back(kImuInterval * k);  // from 0.08 s on
  }

  static void drain(ImagePipeline* pipeline, std::vector<TrackedFrame>* out) {
    bool worked = true;
    while (worked) {
      if (std::optional<TrackedFrame> tracked = pipeline->track(&worked)) {
        out->push_back(std::move(*tracked));
      }
    }
  }

  /// IMU messages come `imu_delay` after their images [s]; negative: before.
  std::vector<TrackedFrame> run(ImagePipeline* pipeline, double imu_delay) {
    std::vector<TrackedFrame> out;
    std::size_t next = 0;
    for (const double t : images_) {
      while (next < imu_.size() && imu_[next] + imu_delay <= t) {
        pipeline->addImu(sampleAt(imu_[next++]));
        drain(pipeline, &out);
      }
      pipeline->addImage(t, imageAt(t));
      drain(pipeline, &out);
    }
    while (next < imu_.size()) {
      pipeline->addImu(sampleAt(imu_[next++]));
      drain(pipeline, &out);
    }
    return out;
  }

  Config config_ = smallCamera();
  ImagePipelineOptions options_;
  std::vector<double> images_, imu_;
};

TEST_F(ImagePipelineTest, GivesTheFramesOfTheProgramWhateverTheDelay) {
  const std::vector<FrameObservation> expected = offLine(config_, images_, imu_);
  ASSERT_GT(expected.back().points.size(), 15u);
  for (const double delay : {0.0, 0.004, 0.13, -0.05}) {
    ImagePipeline pipeline(config_, options_);
    const std::vector<TrackedFrame> out = run(&pipeline, delay);
    // The first image is tracked but has no velocities and is not published.
    ASSERT_EQ(out.size() + 1, expected.size()) << delay;
    for (std::size_t i = 0; i < out.size(); ++i) {
      EXPECT_TRUE(sameFrame(out[i].frame, expected[i + 1]));
      EXPECT_TRUE(sameFrame(out[i].previous, expected[i]));
    }
    EXPECT_EQ(pipeline.counts().images_before_imu, 2) << delay;  // at 0 and 0.05 s
    EXPECT_EQ(pipeline.counts().images_without_imu, 0) << delay;
    EXPECT_EQ(pipeline.counts().images, 20);
    EXPECT_EQ(pipeline.waiting(), 0);
  }
}

TEST_F(ImagePipelineTest, WithoutImuItTracksAfterTheWait) {
  imu_.clear();
  options_.max_imu_wait_s = 0.2;
  ImagePipeline pipeline(config_, options_);
  run(&pipeline, 0.0);
  EXPECT_EQ(pipeline.counts().images_tracked, 16);
  EXPECT_EQ(pipeline.counts().images_without_imu, 16);
  EXPECT_EQ(pipeline.waiting(), 4);
  EXPECT_TRUE(std::isnan(pipeline.imageAheadOfImu()));
}

TEST_F(ImagePipelineTest, PublishesAtTheRateOfTheHost) {
  options_.publish_rate_hz = 10.0;
  ImagePipeline pipeline(config_, options_);
  const std::vector<TrackedFrame> out = run(&pipeline, 0.0);
  EXPECT_EQ(pipeline.counts().images_tracked, 18);
  ASSERT_EQ(out.size(), 8u);  // 0.2 s .. 0.9 s: the first image is at 0.1 s
  for (std::size_t i = 1; i < out.size(); ++i) {
    EXPECT_NEAR(out[i].frame.t - out[i - 1].frame.t, 0.1, 1e-9);
  }
  // Velocities are over the images that are tracked, not those that are published.
  EXPECT_NEAR(out[3].frame.t - out[3].previous.t, 0.05, 1e-9);
}

// VINS-Mono rejects outliers in the images that it publishes, which a rate of the images that is
// no multiple makes irregular.
TEST_F(ImagePipelineTest, TheProfileOfTheHostPublishesWhatItHasChecked) {
  config_.front_end.profile = feature_tracker_lines::TrackerProfile::kVins;
  options_.publish_rate_hz = 10.0;
  ImagePipeline pipeline(config_, options_);
  int published = 0, checked = 0;
  for (int k = 0; k < 60; ++k) {
    const double t = 0.04 * k;  // 25 Hz
    for (int i = 8 * k; i < 8 * (k + 1); ++i) pipeline.addImu(sampleAt(kImuInterval * (i + 3)));
    pipeline.addImage(t, imageAt(t));
    bool worked = false;
    const bool now = pipeline.track(&worked).has_value();
    EXPECT_TRUE(!now || pipeline.frontEnd().report().publishable) << k;
    published += now ? 1 : 0;
    checked += worked && pipeline.frontEnd().report().publishable ? 1 : 0;
  }
  EXPECT_EQ(published, checked - 1) << "all but the first, which has no velocities";
  EXPECT_NEAR(published, 24, 2);
}

// A velocity of zero would be one more observation that td is zero.
TEST_F(ImagePipelineTest, AHostThatEstimatesTdGetsPointsWithAVelocity) {
  Config config = smallCamera();
  for (const bool estimate_td : {false, true}) {
    config.estimate_td = estimate_td;
    ImagePipeline pipeline(config, options_);
    int without = 0, with = 0;
    for (const TrackedFrame& tracked : run(&pipeline, 0.0)) {
      const int known = countIn(idSet(tracked.previous.points), tracked.frame.points);
      with += known;
      without += static_cast<int>(tracked.frame.points.size()) - known;
    }
    EXPECT_GT(with, 100);
    EXPECT_EQ(without > 0, !estimate_td) << without;
  }
}

TEST_F(ImagePipelineTest, AFullQueueDropsTheOldestAndWaitsForNoImuData) {
  options_.image_queue = 5;
  options_.max_imu_wait_s = 10.0;
  ImagePipeline pipeline(config_, options_);
  pipeline.addImu(sampleAt(0.0));
  bool worked = false;
  for (const double t : images_) pipeline.addImage(t, imageAt(t));
  EXPECT_EQ(pipeline.waiting(), 5);
  EXPECT_EQ(pipeline.counts().images_overrun, 15);
  EXPECT_NEAR(pipeline.imageAheadOfImu(), 0.953, 1e-9);
  pipeline.track(&worked);
  EXPECT_TRUE(worked);
  EXPECT_EQ(pipeline.counts().images_without_imu, 1);
  pipeline.track(&worked);
  EXPECT_FALSE(worked) << "there is room, and samples may come";
  options_.image_queue = 1;
  ImagePipeline shortest(config_, options_);
  shortest.addImu(sampleAt(0.0));
  shortest.addImage(images_.front(), imageAt(images_.front()));
  shortest.track(&worked);
  EXPECT_FALSE(worked) << "nor does the only image hurry";
}

TEST_F(ImagePipelineTest, ImagesThatCannotBeUsedAreCountedAndTheNextIsTracked) {
  ImagePipeline pipeline(config_, options_);
  for (int k = 0; k < 60; ++k) pipeline.addImu(sampleAt(kImuInterval * k));
  pipeline.addImage(0.05, imageAt(0.05));
  pipeline.addImage(0.10, cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)));
  pipeline.addImage(0.15, cv::Mat());
  pipeline.addImage(0.20, imageAt(0.20));
  std::vector<TrackedFrame> out;
  drain(&pipeline, &out);
  EXPECT_EQ(pipeline.counts().images_refused, 2);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].frame.t, 0.20);
}

// The same twice, as from a bag that is played again: the second time costs the sample and the
// image that confirm the jump.
TEST_F(ImagePipelineTest, AJumpInTimeBeginsAnew) {
  for (double& t : images_) t += 3.0;
  for (double& t : imu_) t += 3.0;
  ImagePipeline pipeline(config_, options_);
  const std::size_t first = run(&pipeline, 0.0).size();
  for (double& t : images_) t -= 3.0;
  for (double& t : imu_) t -= 3.0;
  const std::vector<TrackedFrame> second = run(&pipeline, 0.0);
  EXPECT_EQ(pipeline.streamCounts().restarts(), 1);
  EXPECT_EQ(pipeline.streamCounts().frames[AddStatus::kStray], 1);
  // What it costs is before the first IMU sample, which no image may be.
  const std::vector<FrameObservation> expected = offLine(config_, images_, imu_);
  ASSERT_EQ(second.size(), first);
  ASSERT_EQ(second.size() + 1, expected.size());
  EXPECT_NE(second.back().frame.points[0].id, expected.back().points[0].id) << "ids go on";
  EXPECT_TRUE(sameFrame(withIdsFromZero(second.back().frame), withIdsFromZero(expected.back())));
  // A gap between images is a restart as well.
  pipeline.addImage(15.0, imageAt(15.0));
  EXPECT_EQ(pipeline.addImage(15.05, imageAt(15.05)), AddStatus::kRestarted);
  EXPECT_EQ(pipeline.streamCounts().restarts(), 2);
  // In which the IMU has gone on: the image that confirms its end is tracked.
  for (int k = 0; k <= 400; ++k) pipeline.addImu(sampleAt(15.0 + kImuInterval * k));
  pipeline.addImage(15.1, imageAt(15.1));
  pipeline.addImage(16.8, imageAt(16.8));
  EXPECT_EQ(pipeline.addImage(16.85, imageAt(16.85)), AddStatus::kRestarted);
  const std::int64_t tracked = pipeline.counts().images_tracked;
  bool worked = false;
  pipeline.track(&worked);
  EXPECT_EQ(pipeline.counts().images_tracked, tracked + 1);
  // Images whose time has gone back have no samples yet.
  pipeline.addImage(16.3, imageAt(16.3));
  EXPECT_EQ(pipeline.addImage(16.4, imageAt(16.4)), AddStatus::kRestarted);
  EXPECT_TRUE(std::isnan(pipeline.imageAheadOfImu()));
}

TEST_F(ImagePipelineTest, ObservationsThatTheMessageCannotHoldAreLeftOut) {
  // A fisheye that sees beyond 90 degrees: the pixels at the edge have no (x, y, 1).
  config_.camera.model = feature_tracker_lines::CameraModel::kKannalaBrandt;
  config_.camera.fx = config_.camera.fy = 60.0;
  config_.calibration.focal_px = 60.0;
  ImagePipeline pipeline(config_, options_);
  const std::vector<TrackedFrame> out = run(&pipeline, 0.0);
  ASSERT_FALSE(out.empty());
  for (const TrackedFrame& tracked : out) {
    for (const PointObservation& point : tracked.frame.points) EXPECT_GE(point.bearing.z(), 0.01);
  }
  EXPECT_GT(pipeline.counts().observations_sideways, 0);
}

TEST(ImagePipelineOptionsTest, NameFieldValueAndBound) {
  ImagePipelineOptions options;
  EXPECT_EQ(options.validate(), "");
  options.image_queue = 0;
  EXPECT_EQ(options.validate(), "image_queue is 0, must be in [1, 10000]");
  options = ImagePipelineOptions();
  options.publish_rate_hz = -1.0;
  EXPECT_EQ(options.validate(), "publish_rate_hz is -1, must be in [0, 1000]");
  options = ImagePipelineOptions();
  options.max_imu_wait_s = std::nan("");
  EXPECT_NE(options.validate(), "");
}

/// Stands in for sensor_msgs::Image.
struct ImageMessage {
  std::uint32_t width = 2, height = 2, step = 2;
  std::string encoding = "mono8";
  std::vector<std::uint8_t> data = std::vector<std::uint8_t>(4, 3);
  std::uint8_t is_bigendian = 0;
};

TEST(ImageMessageTest, DecodesWhatIsListedAndRefusesContradictions) {
  constexpr std::uint32_t kMost = 0xFFFFFFFFu;
  const std::vector<std::uint8_t> colours(12, 77);
  const std::pair<ImageMessage, const char*> cases[] = {
      {{}, ""},
      {{2, 2, 6, "rgb8", colours}, ""},
      {{2, 2, 2, "rgb8"}, "claims to be 2 x 2 in rows of 2 bytes (rgb8), but holds 4 bytes"},
      {{2, 2, 4, "mono16", std::vector<std::uint8_t>(8, 77)}, ""},
      // Twelve bits of a camera, 240 of 4095.
      {{2, 2, 4, "mono16", {255, 15, 255, 15, 240, 0, 15, 15}}, ""},
      {{2, 2, 4, "mono16", std::vector<std::uint8_t>(8, 77), 1}, "has 16-bit pixels, most"},
      {{2, 2, 3, "mono16", colours}, "claims to be 2 x 2"},
      {{2, 2, 4, "yuv422", {128, 9, 128, 9, 128, 77, 128, 77}}, ""},
      {{2, 2, 4, "yuv422_yuy2", {9, 128, 9, 128, 77, 128, 77, 77}}, ""},
      {{2, 2, 6, "bayer_rggb16", colours}, "has encoding 'bayer_rggb16', must be mono8"},
      {{2, 2, 2, "mono8", {3, 3, 3}}, "claims to be 2 x 2"},
      {{0, 2, 2}, "claims to be 0 x 2"},
      {{kMost, kMost, kMost}, "claims to be "}};
  for (const auto& [message, said] : cases) {
    cv::Mat grey;
    double largest = 0.0;
    const std::string problem = feature_tracker_lines::decodeImage(message, &grey, &largest);
    EXPECT_EQ(problem.rfind(said, 0), 0u) << problem;
    if (*said != '\0') continue;
    EXPECT_EQ(problem, "");
    EXPECT_EQ(grey.at<std::uint8_t>(1, 0), message.data.back());
  }
}

/// Stands in for sensor_msgs::CompressedImage.
struct CompressedMessage {
  std::string format;
  std::vector<std::uint8_t> data;
};

CompressedMessage compressed(const std::string& format, const cv::Mat& image) {
  CompressedMessage message{format, {}};
  EXPECT_TRUE(cv::imencode(".png", image, message.data));
  return message;
}

// A dark image of a 16-bit camera is none of 12 bits.
TEST(ImageMessageTest, TheScaleOf16BitsIsThatOfTheStream) {
  const ImageMessage dark{2, 2, 4, "mono16", {0, 8, 0, 8, 0, 8, 0, 8}},
      bright{2, 2, 4, "mono16", std::vector<std::uint8_t>(8, 77)};
  double largest = 0.0, of_compressed = 0.0;
  for (const auto& [message, expected] :
       {std::pair{dark, 128}, {bright, 77}, {dark, 8}, {bright, 77}}) {
    cv::Mat grey;
    EXPECT_EQ(feature_tracker_lines::decodeImage(message, &grey, &largest), "");
    EXPECT_EQ(grey.at<std::uint8_t>(0, 0), expected);
    const cv::Mat wide(2, 2, CV_16UC1, const_cast<std::uint8_t*>(message.data.data()));
    const CompressedMessage png = compressed("mono16; png compressed mono16", wide);
    EXPECT_EQ(feature_tracker_lines::decodeCompressedImage(png, &grey, &of_compressed), "");
    EXPECT_EQ(grey.at<std::uint8_t>(0, 0), expected);
  }
}

/// A wall of one colour through the filters of a pattern, 8 x 8.
cv::Mat mosaicOf(const std::string& pattern, char colour) {
  cv::Mat mosaic(8, 8, CV_8UC1);
  for (int i = 0; i < 64; ++i) {
    mosaic.data[i] = pattern[2 * (i / 8 % 2) + i % 2] == colour ? 200 : 0;
  }
  return mosaic;
}

// A red, a green and a blue wall: the grey value tells the colours apart.
TEST(ImageMessageTest, BayerPatternsHaveTheirColours) {
  const std::tuple<char, int> greys[] = {{'r', 60}, {'g', 117}, {'b', 23}};
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    for (const auto& [colour, expected] : greys) {
      const cv::Mat mosaic = mosaicOf(pattern, colour);
      const std::string name = "bayer_" + pattern;
      const ImageMessage raw{8, 8, 8, name + "8", {mosaic.datastart, mosaic.dataend}};
      cv::Mat wide, grey, grey8, grey16;
      double largest = 0.0;
      mosaic.convertTo(wide, CV_16U, 257.0);
      EXPECT_EQ(feature_tracker_lines::decodeImage(raw, &grey, &largest), "");
      for (const int at : {3, 4}) EXPECT_NEAR(grey.at<std::uint8_t>(at, at), expected, 1);
      const CompressedMessage message8 = compressed(name + "8; png compressed ", mosaic);
      EXPECT_EQ(feature_tracker_lines::decodeCompressedImage(message8, &grey8, &largest), "");
      EXPECT_EQ(cv::norm(grey, grey8, cv::NORM_INF), 0.0) << name;
      const CompressedMessage message16 = compressed(name + "16; png compressed ", wide);
      EXPECT_EQ(feature_tracker_lines::decodeCompressedImage(message16, &grey16, &largest), "");
      EXPECT_EQ(cv::norm(grey, grey16, cv::NORM_INF), 0.0) << name;
    }
  }
}

TEST(ImageMessageTest, OnlyCompressedMosaicsAreConverted) {
  const auto grey = [](const CompressedMessage& message) {
    cv::Mat image;
    double largest = 0.0;
    EXPECT_EQ(feature_tracker_lines::decodeCompressedImage(message, &image, &largest), "");
    return image;
  };
  const cv::Mat mosaic = mosaicOf("rggb", 'g');
  for (const char* format : {"mono8; png compressed ", "png", "", "bayer_"}) {
    EXPECT_EQ(cv::norm(grey(compressed(format, mosaic)), mosaic, cv::NORM_INF), 0.0) << format;
  }
  // The sender has converted it.
  const cv::Mat colours(8, 8, CV_8UC3, cv::Scalar(10, 200, 90));
  EXPECT_EQ(cv::norm(grey(compressed("bayer_rggb8; png compressed bgr8", colours)),
                     grey(compressed("bgr8; png compressed bgr8", colours)), cv::NORM_INF),
            0.0);
  cv::Mat none;
  double largest = 0.0;
  const CompressedMessage garbage{"bayer_rggb8; jpeg compressed ", {1, 2, 3}};
  EXPECT_EQ(feature_tracker_lines::decodeCompressedImage(garbage, &none, &largest),
            "cannot be decoded: 3 bytes of 'bayer_rggb8; jpeg compressed '");
  CompressedMessage depth{"32FC1; tiff compressed ", {}};
  cv::imencode(".tiff", cv::Mat(8, 8, CV_32FC1, cv::Scalar(0.5)), depth.data);
  EXPECT_NE(feature_tracker_lines::decodeCompressedImage(depth, &none, &largest), "");
}

}  // namespace
}  // namespace slim_init::node
