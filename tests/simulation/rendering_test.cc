// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The picture and the ray caster must show the same scene. Tests that draw need POV-Ray; without it
// they are skipped with a line that says so.
#include "slim_init/simulation/rendering.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "evaluation/scratch_folder.h"
#include "simulation/needs_povray.h"
#include "simulation/ray_caster.h"
#include "support/euroc_camera.h"
#include "support/text_parts.h"

namespace slim_init::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using feature_tracker_lines::Camera;
using feature_tracker_lines::CameraModel;
using feature_tracker_lines::CameraParameters;

// EuRoC's cam0 at half size, through different lenses.
CameraParameters lensOf(CameraModel model, bool distorted) {
  CameraParameters camera = cameraOf(376, 240, 229.3, 228.6, 183.4, 123.9);
  camera.model = model;
  if (!distorted) return camera;
  switch (model) {
    case CameraModel::kPinhole: camera.distortion = {-0.283, 0.0739, 2e-4, 2e-5}; break;
    case CameraModel::kKannalaBrandt: camera.distortion = {-0.01, 0.005, 0.0, 0.0}; break;
    case CameraModel::kMei:
      camera.distortion = {-0.1, 0.02, 1e-4, 1e-4};
      camera.xi = 0.8;
      camera.fx *= 1.8;
      camera.fy *= 1.8;
      break;
  }
  return camera;
}

// Looks along +x of w, a little turned about all axes: whatever is mirrored or transposed shows.
CameraPose turnedPose() {
  Eigen::Matrix3d R_ahead;
  R_ahead << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  CameraPose pose;
  pose.R_w_c = Eigen::AngleAxisd(0.15, Vector3d(1, 2, 3).normalized()).toRotationMatrix() * R_ahead;
  pose.t_w_c = Vector3d(0.0, 0.1, -0.05);
  return pose;
}

// Solids that shine without any light, each with a brightness of its own.
Scene shiningScene() {
  Scene scene;
  scene.ambient = 0.0;
  const auto add = [&](const Solid& solid, double glow) {
    Look look;
    look.bright = 1.0;
    look.glow = glow;
    scene.looks.push_back(look);
    scene.solids.push_back(solid);
    scene.solids.back().look = static_cast<int>(scene.looks.size()) - 1;
  };
  add({"back", Shape::kBox, {10, 0, 0}, {0.1, 40, 40}, 0.0, 2, 0}, 0.05);
  add({"front", Shape::kBox, {2.1, 0.3, 0.1}, {0.1, 0.6, 0.35}, 0.0, 2, 0}, 0.9);
  add({"turned", Shape::kBox, {3.0, -1.0, 0.3}, {0.4, 0.3, 0.5}, 35.0, 2, 0}, 0.6);
  add({"pipe", Shape::kCylinder, {3.0, -0.1, -0.9}, {0.2, 1.5, 0.2}, 0.0, 1, 0}, 0.3);
  add({"post", Shape::kCylinder, {2.5, 1.3, 0.0}, {0.15, 0.25, 0.8}, 20.0, 2, 0}, 0.75);
  return scene;
}

cv::Mat renderOne(const Scene& scene, const CameraParameters& camera, const CameraPose& pose,
                  const RenderOptions& options) {
  std::string error;
  const auto renderer = Renderer::start(scene, camera, {pose}, options, &error);
  EXPECT_NE(renderer, nullptr) << error;
  if (renderer == nullptr) return {};
  const cv::Mat picture = renderer->next(&error);
  EXPECT_FALSE(picture.empty()) << error;
  return picture;
}

struct Lens {
  const char* name;
  CameraModel model;
  bool distorted;
};

class Rendering : public testing::TestWithParam<Lens> {};

// Away from borders every pixel has the brightness of the solid that its ray meets.
TEST_P(Rendering, ShowsTheSolidThatTheRayMeets) {
  NEEDS_POVRAY();
  const ScratchFolder folder;
  RenderOptions options;
  options.work_directory = folder.path();
  const Scene scene = shiningScene();
  const CameraParameters parameters = lensOf(GetParam().model, GetParam().distorted);
  const Camera camera(parameters);
  const CameraPose pose = turnedPose();
  const cv::Mat picture = renderOne(scene, parameters, pose, options);
  ASSERT_EQ(picture.type(), CV_32FC1);
  ASSERT_EQ(picture.cols, parameters.width);
  ASSERT_EQ(picture.rows, parameters.height);
  cv::Mat solids(picture.size(), CV_32SC1);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      solids.at<int>(v, u) = firstSolid(scene, pose.t_w_c, pose.R_w_c * camera.bearing({u, v}));
    }
  }
  std::vector<int> seen(scene.solids.size(), 0);
  // [px] Reach of the cubic interpolation, whose pixels are larger than ours in the corners.
  constexpr int kBorder = 5;
  for (int v = kBorder; v < picture.rows - kBorder; ++v) {
    for (int u = kBorder; u < picture.cols - kBorder; ++u) {
      const int solid = solids.at<int>(v, u);
      ASSERT_GE(solid, 0);
      bool inside = true;
      for (int dv = -kBorder; dv <= kBorder; ++dv) {
        for (int du = -kBorder; du <= kBorder; ++du) {
          inside = inside && solids.at<int>(v + dv, u + du) == solid;
        }
      }
      if (!inside) continue;
      ++seen[static_cast<std::size_t>(solid)];
      ASSERT_NEAR(picture.at<float>(v, u), scene.looks[static_cast<std::size_t>(solid)].glow, 2e-4)
          << scene.solids[static_cast<std::size_t>(solid)].name << " at " << u << ", " << v;
    }
  }
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_GT(seen[i], 100) << scene.solids[i].name;
}

// Edges of a bright box against the ray caster, to a fraction of a pixel: a picture that is shifted
// by half a pixel fails.
TEST_P(Rendering, EdgesAgreeToAFractionOfAPixel) {
  NEEDS_POVRAY();
  const ScratchFolder folder;
  RenderOptions options;
  options.work_directory = folder.path();
  Scene scene = shiningScene();
  scene.solids.resize(2);
  scene.looks[0].glow = 0.0;
  scene.looks[1].glow = 0.8;
  const CameraParameters parameters = lensOf(GetParam().model, GetParam().distorted);
  const Camera camera(parameters);
  const CameraPose pose = turnedPose();
  cv::Mat picture = renderOne(scene, parameters, pose, options);
  ASSERT_FALSE(picture.empty());
  // A step between two pixels has no place; blurred, it has one.
  cv::GaussianBlur(picture, picture, cv::Size(), 1.0);
  const auto inBox = [&](double u, double v) {
    return firstSolid(scene, pose.t_w_c, pose.R_w_c * camera.bearing({u, v})) == 1;
  };

  for (const bool along_columns : {false, true}) {
    const int lines = along_columns ? picture.cols : picture.rows;
    const int length = along_columns ? picture.rows : picture.cols;
    double sum[2] = {}, squares[2] = {};
    int count[2] = {};
    for (int line = 4; line < lines - 4; ++line) {
      const auto at = [&](int k, int step) {
        const double value =
            along_columns ? picture.at<float>(k, line + step) : picture.at<float>(line + step, k);
        return value - 0.4;  // half of the box's brightness
      };
      const auto truth = [&](double k) { return along_columns ? inBox(line, k) : inBox(k, line); };
      for (int k = 4; k < length - 5; ++k) {
        if (at(k, 0) * at(k + 1, 0) >= 0.0) continue;
        // Only edges that are crossed, not followed.
        const double along = 0.25 * std::abs(at(k, 2) - at(k, -2));
        if (along > 0.5 * std::abs(at(k + 1, 0) - at(k, 0))) continue;
        double low = k - 1.5, high = k + 2.5;
        if (truth(low) == truth(high)) continue;
        const bool rising = truth(high);
        for (int i = 0; i < 30; ++i) {
          const double middle = 0.5 * (low + high);
          (truth(middle) == rising ? high : low) = middle;
        }
        const double drawn = k + at(k, 0) / (at(k, 0) - at(k + 1, 0));
        sum[rising] += drawn - low;
        squares[rising] += (drawn - low) * (drawn - low);
        ++count[rising];
      }
    }
    for (const int side : {0, 1}) {
      ASSERT_GT(count[side], 40);
      EXPECT_LT(std::abs(sum[side] / count[side]), 0.1);
      EXPECT_LT(std::sqrt(squares[side] / count[side]), 0.2);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, Rendering,
                         testing::Values(Lens{"pinhole", CameraModel::kPinhole, false},
                                         Lens{"radtan", CameraModel::kPinhole, true},
                                         Lens{"kannala_brandt", CameraModel::kKannalaBrandt, true},
                                         Lens{"mei", CameraModel::kMei, true}),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(RenderingRun, FramesComeInOrderAndNothingIsLeftBehind) {
  NEEDS_POVRAY();
  const ScratchFolder folder;
  RenderOptions options;
  options.work_directory = folder.path();
  const CameraParameters camera = cameraOf(94, 60, 57.0, 57.0, 46.0, 30.0);
  std::vector<CameraPose> poses(11, turnedPose());  // two digits in the names of pictures
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i].t_w_c.y() += 0.05 * i;
  std::string error;
  std::vector<cv::Mat> pictures;
  {
    const auto renderer = Renderer::start(shiningScene(), camera, poses, options, &error);
    ASSERT_NE(renderer, nullptr) << error;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      pictures.push_back(renderer->next(&error));
      ASSERT_FALSE(pictures.back().empty()) << error;
    }
    EXPECT_TRUE(renderer->next(&error).empty());
    expectParts(error, "all 11 pictures");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  // Each is the picture of its own pose, and the same with two threads.
  options.threads = 2;
  for (const std::size_t i : {0u, 4u, 10u}) {
    const cv::Mat alone = renderOne(shiningScene(), camera, poses[i], options);
    ASSERT_FALSE(alone.empty());
    EXPECT_EQ(cv::norm(alone, pictures[i], cv::NORM_INF), 0.0) << i;
  }
  // Stopped half-way.
  {
    const auto renderer = Renderer::start(shiningScene(), camera, poses, options, &error);
    ASSERT_NE(renderer, nullptr) << error;
    EXPECT_FALSE(renderer->next(&error).empty()) << error;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(RenderingRun, ProblemsAreSaid) {
  const ScratchFolder folder;
  RenderOptions options;
  options.work_directory = folder.file("work");
  std::string error;
  const CameraParameters camera = lensOf(CameraModel::kPinhole, false);
  options.program = "no-such-renderer";
  EXPECT_EQ(Renderer::start(shiningScene(), camera, {turnedPose()}, options, &error), nullptr);
  expectParts(error, "'no-such-renderer'|package povray");
  EXPECT_FALSE(povrayAvailable("no-such-renderer", &error));
  // A program that writes a reason and fails.
  folder.write("broken", "#!/bin/sh\necho Parse Error in line 7\nexit 3\n");
  std::filesystem::permissions(folder.file("broken"), std::filesystem::perms::owner_all);
  options.program = folder.file("broken");
  {
    const auto renderer =
        Renderer::start(shiningScene(), camera, {turnedPose(), turnedPose()}, options, &error);
    ASSERT_NE(renderer, nullptr) << error;
    EXPECT_TRUE(renderer->next(&error).empty());
    expectParts(error, "exit code 3 at frame 1 of 2|Parse Error in line 7");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.file("work")));

  EXPECT_EQ(Renderer::start(shiningScene(), camera, {}, options, &error), nullptr);
  expectParts(error, "no pose");
}

TEST(EquidistantView, HoldsEveryPixel) {
  for (const CameraModel model :
       {CameraModel::kPinhole, CameraModel::kKannalaBrandt, CameraModel::kMei}) {
    const CameraParameters parameters = lensOf(model, true);
    const Camera camera(parameters);
    EquidistantView view;
    std::string error;
    ASSERT_TRUE(makeEquidistantView(camera, &view, &error)) << error;
    const Vector2d center = view.project(Vector3d::UnitZ());
    EXPECT_DOUBLE_EQ(center.x(), 0.5 * (view.width - 1));
    EXPECT_DOUBLE_EQ(center.y(), 0.5 * (view.height - 1));
    for (int v = 0; v < parameters.height; v += 3) {
      for (int u = 0; u < parameters.width; u += 3) {
        const Vector2d at = view.project(camera.bearing({u, v}));
        ASSERT_TRUE(at.x() >= 1.0 && at.y() >= 1.0 && at.x() <= view.width - 2.0 &&
                    at.y() <= view.height - 2.0)
            << at.transpose();
      }
    }
    // As many pixels as the image has at the axis.
    const Vector2d pixel(parameters.cx, parameters.cy);
    const double step = (view.project(camera.bearing(pixel + Vector2d(0.5, 0.0))) -
                         view.project(camera.bearing(pixel - Vector2d(0.5, 0.0))))
                            .norm();
    EXPECT_NEAR(step, 1.0, 0.02);
  }
  CameraParameters wide = lensOf(CameraModel::kKannalaBrandt, false);
  wide.fx = wide.fy = 110.0;
  EquidistantView view;
  std::string error;
  EXPECT_FALSE(makeEquidistantView(Camera(wide), &view, &error));
  expectParts(error, "87.5 deg");
}

SensorOptions idealSensor() {
  SensorOptions options;
  options.blur_px = options.vignetting = options.exposure_swing = 0.0;
  options.read_noise = options.shot_noise = 0.0;
  return options;
}

double meanOf(const cv::Mat& image) { return cv::mean(image)[0]; }

TEST(Expose, IdealSensorRoundsAndClamps) {
  const cv::Mat radiance = (cv::Mat_<float>(1, 4) << -0.5f, 0.0f, 0.5f, 2.0f);
  const cv::Mat image = expose(radiance, 0, 0.0, idealSensor());
  ASSERT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(image.at<std::uint8_t>(0, 0), 0);
  EXPECT_EQ(image.at<std::uint8_t>(0, 1), 0);
  EXPECT_EQ(image.at<std::uint8_t>(0, 2), 128);
  EXPECT_EQ(image.at<std::uint8_t>(0, 3), 255);
}

TEST(Expose, NoiseHasTheStatedSizeAndFollowsSeedAndIndex) {
  SensorOptions options = idealSensor();
  options.read_noise = 2.0;
  options.shot_noise = 0.05;
  for (const double level : {0.2, 0.6}) {
    const cv::Mat radiance(200, 300, CV_32FC1, cv::Scalar(level));
    const cv::Mat image = expose(radiance, 4, 0.0, options);
    cv::Scalar mean, deviation;
    cv::meanStdDev(image, mean, deviation);
    // 60000 pixels: the standard deviation is known to 0.3 %; rounding adds 1/12.
    EXPECT_NEAR(mean[0], 255.0 * level, 0.05);
    EXPECT_NEAR(deviation[0], std::sqrt(4.0 + 0.05 * 255.0 * level + 1.0 / 12.0), 0.05);
    EXPECT_EQ(cv::norm(image, expose(radiance, 4, 0.0, options), cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(image, expose(radiance, 5, 0.0, options), cv::NORM_INF), 0.0);
    SensorOptions other = options;
    other.seed = 2;
    EXPECT_GT(cv::norm(image, expose(radiance, 4, 0.0, other), cv::NORM_INF), 0.0);
  }
}

TEST(Expose, VignettingExposureAndBlur) {
  const cv::Mat flat(101, 101, CV_32FC1, cv::Scalar(0.8));
  SensorOptions options = idealSensor();
  options.vignetting = 0.3;
  const cv::Mat dim = expose(flat, 0, 0.0, options);
  EXPECT_EQ(dim.at<std::uint8_t>(50, 50), 204);
  EXPECT_NEAR(dim.at<std::uint8_t>(0, 0), 0.7 * 204, 0.51);
  EXPECT_NEAR(dim.at<std::uint8_t>(50, 100), 0.85 * 204, 0.51);

  options = idealSensor();
  options.exposure_swing = 0.2;
  options.exposure_period_s = 4.0;
  EXPECT_NEAR(meanOf(expose(flat, 0, 0.0, options)), 204.0, 0.51);
  EXPECT_NEAR(meanOf(expose(flat, 0, 1.0, options)), 1.2 * 204.0, 0.51);
  EXPECT_NEAR(meanOf(expose(flat, 0, 3.0, options)), 0.8 * 204.0, 0.51);

  options = idealSensor();
  options.blur_px = 2.0;
  cv::Mat point = cv::Mat::zeros(41, 41, CV_32FC1);
  point.at<float>(20, 20) = 10.0f;
  const cv::Mat blurred = expose(point, 0, 0.0, options);
  // The peak of a Gaussian of 2 px is 1/(2 pi 4).
  EXPECT_NEAR(blurred.at<std::uint8_t>(20, 20), 2550.0 / (8.0 * M_PI), 2.0);
  EXPECT_GT(blurred.at<std::uint8_t>(20, 22), blurred.at<std::uint8_t>(20, 24));
}

TEST(MergeBands, BlendsBetweenTheMiddleRowsOfTheBands) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 4; ++i) pictures.emplace_back(80, 10, CV_32FC1, cv::Scalar(10.0 * i));
  const cv::Mat image = mergeBands(pictures);
  ASSERT_EQ(image.size(), pictures.front().size());
  for (int v = 0; v < 80; ++v) {
    // Bands of 20 rows; their middle rows are 10, 30, 50 and 70.
    const double expected = 10.0 * std::min(3.0, std::max(0.0, (v - 10.0) / 20.0));
    EXPECT_NEAR(image.at<float>(v, 4), expected, 1e-5) << v;
  }
  EXPECT_EQ(cv::norm(mergeBands({pictures[2]}), pictures[2], cv::NORM_INF), 0.0);
  EXPECT_TRUE(mergeBands({}).empty());
}

}  // namespace
}  // namespace slim_init::simulation
