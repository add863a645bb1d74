// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "support/euroc_camera.h"

namespace slim_init::feature_tracker_lines {
namespace {

// Rays are asked for to 1e-9 of a radian and pixels to 1e-9; both leave room for rounding only.
constexpr double kRoundTrip = 1e-9;

CameraParameters widePinhole() {  // corners at 60 degrees and more, heavily distorted
  CameraParameters p;
  p.fx = p.fy = 300.0;
  p.distortion = {-0.35, 0.12, 0.002, -0.003};
  return p;
}

CameraParameters kannalaBrandt() {  // a 512 px fisheye of about 190 degrees, TUM-VI like
  CameraParameters p = cameraOf(512, 512, 190.978, 190.973, 254.931, 256.897);
  p.model = CameraModel::kKannalaBrandt;
  p.distortion = {0.0034, 0.0008, -0.0020, 0.0004};
  return p;
}

CameraParameters mei() {  // wide angle, mirror parameter above one
  CameraParameters p = cameraOf(752, 480, 850.0, 848.0, 370.0, 245.0);
  p.model = CameraModel::kMei;
  p.distortion = {-0.12, 0.05, 0.0008, -0.0004};
  p.xi = 1.25;
  return p;
}

CameraParameters meiBelowOne() {
  CameraParameters p = mei();
  p.xi = 0.6;
  p.fx = p.fy = 600.0;
  return p;
}

class CameraRoundTrip : public ::testing::TestWithParam<CameraParameters> {};

TEST_P(CameraRoundTrip, PixelToRayToPixelOverTheImage) {
  ASSERT_EQ(GetParam().validate(), "");
  const Camera camera(GetParam());
  for (double v = 0.25; v < GetParam().height; v += 7.5) {
    for (double u = 0.25; u < GetParam().width; u += 7.5) {
      const Eigen::Vector3d ray = camera.bearing({u, v});
      ASSERT_TRUE(ray.allFinite()) << u << " " << v;
      EXPECT_NEAR(ray.norm(), 1.0, 1e-14);
      Eigen::Vector2d pixel(-1, -1);
      if (!camera.project(ray, &pixel)) {
        // The last half pixel of the grid may lie beyond the image; nothing else may.
        ADD_FAILURE() << "not seen: " << u << " " << v;
        continue;
      }
      EXPECT_LT((pixel - Eigen::Vector2d(u, v)).norm(), kRoundTrip) << u << " " << v;
    }
  }
}

TEST_P(CameraRoundTrip, RayToPixelToRay) {
  const Camera camera(GetParam());
  int seen = 0;
  for (int i = 0; i < 2000; ++i) {
    // A deterministic spread over the sphere (golden angle).
    const double z = 1.0 - 2.0 * (i + 0.5) / 2000;
    const double phi = 2.399963229728653 * i;
    const double s = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d ray(s * std::cos(phi), s * std::sin(phi), z);
    Eigen::Vector2d pixel;
    if (!camera.project(3.7 * ray, &pixel)) continue;  // any length
    ++seen;
    EXPECT_LT((camera.bearing(pixel) - ray).norm(), kRoundTrip) << ray.transpose();
  }
  EXPECT_GT(seen, 50);
}

TEST_P(CameraRoundTrip, FocalIsPixelsPerRadianOnTheAxis) {
  const Camera camera(GetParam());
  const double angle = 1e-5;
  Eigen::Vector2d centre, right, down;
  ASSERT_TRUE(camera.project({0, 0, 1}, &centre));
  ASSERT_TRUE(camera.project({std::sin(angle), 0, std::cos(angle)}, &right));
  ASSERT_TRUE(camera.project({0, std::sin(angle), std::cos(angle)}, &down));
  EXPECT_NEAR(centre.x(), GetParam().cx, 1e-12);
  EXPECT_NEAR(centre.y(), GetParam().cy, 1e-12);
  const double focal = std::sqrt((right - centre).norm() * (down - centre).norm()) / angle;
  EXPECT_NEAR(camera.focalPx(), focal, 1e-3 * focal);
}

TEST_P(CameraRoundTrip, BadArgumentsHaveNoAnswer) {
  const Camera camera(GetParam());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(camera.bearing({nan, 1.0}).array().isNaN().all());
  Eigen::Vector2d pixel(5.0, 6.0);
  EXPECT_FALSE(camera.project({nan, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(camera.project({0.0, 0.0, 0.0}, &pixel));
  EXPECT_FALSE(camera.project({0.0, 0.0, -1.0}, &pixel));
  EXPECT_EQ(pixel, Eigen::Vector2d(5.0, 6.0));
}

INSTANTIATE_TEST_SUITE_P(Models, CameraRoundTrip,
                         ::testing::Values(eurocCamera(), widePinhole(), CameraParameters(),
                                           kannalaBrandt(), mei(), meiBelowOne()));

// OpenCV as an independent reference, on a grid of rays up to `x` and `y` beside the axis.
// `project` takes the ray, K and the distortion.
template <typename Project>
void expectAsOpenCv(const CameraParameters& p, double x_end, double y_end, const Project& project) {
  const Camera camera(p);
  const cv::Matx33d k(p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1);
  const cv::Vec4d d(p.distortion[0], p.distortion[1], p.distortion[2], p.distortion[3]);
  for (double y = -y_end; y <= y_end; y += y_end / 4) {
    for (double x = -x_end; x <= x_end; x += x_end / 6) {
      std::vector<cv::Point2d> expected;
      project(std::vector<cv::Point3d>{{x, y, 1.0}}, k, d, &expected);
      Eigen::Vector2d pixel;
      ASSERT_TRUE(camera.project({x, y, 1.0}, &pixel));
      EXPECT_NEAR(pixel.x(), expected[0].x, 1e-9);
      EXPECT_NEAR(pixel.y(), expected[0].y, 1e-9);
    }
  }
}

TEST(Camera, PinholeAndKannalaBrandtProjectAsOpenCv) {
  const cv::Vec3d zero(0, 0, 0);
  expectAsOpenCv(eurocCamera(), 0.6, 0.4,
                 [&](const auto& ray, const auto& k, const auto& d, auto* pixels) {
                   cv::projectPoints(ray, zero, zero, k, d, *pixels);
                 });
  expectAsOpenCv(kannalaBrandt(), 1.0, 1.0,
                 [&](const auto& ray, const auto& k, const auto& d, auto* pixels) {
                   cv::fisheye::projectPoints(ray, *pixels, zero, zero, k, d);
                 });
}

TEST(Camera, MeiWithoutMirrorIsAPinhole) {
  CameraParameters p = eurocCamera();
  const Camera reference(p);
  p.model = CameraModel::kMei;
  p.xi = 0.0;
  const Camera camera(p);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(3, 4), Eigen::Vector2d(700, 100)}) {
    EXPECT_LT((camera.bearing(pixel) - reference.bearing(pixel)).norm(), 1e-15);
  }
}

// A number worked out by hand: xi = 1, no distortion, ray at 90 degrees: p = (1, 0).
TEST(Camera, MeiKnownValue) {
  CameraParameters p;
  p.model = CameraModel::kMei;
  p.xi = 1.0;
  p.fx = p.fy = 200.0;
  const Camera camera(p);
  Eigen::Vector2d pixel;
  ASSERT_TRUE(camera.project({1, 0, 0}, &pixel));
  EXPECT_NEAR(pixel.x(), p.cx + 200.0, 1e-12);
  EXPECT_NEAR(pixel.y(), p.cy, 1e-12);
  EXPECT_DOUBLE_EQ(camera.focalPx(), 100.0);
}

TEST(Camera, FisheyeSeesBehindTheImagePlane) {
  CameraParameters p = kannalaBrandt();
  p.distortion = {0, 0, 0, 0};
  const Camera camera(p);
  const double theta = 1.65;  // more than 90 degrees
  Eigen::Vector2d pixel;
  // Along the diagonal: the circle of 1.65 rad is larger than the image is wide.
  const double s = std::sin(theta) / std::sqrt(2.0);
  ASSERT_TRUE(camera.project({s, s, std::cos(theta)}, &pixel));
  EXPECT_NEAR((pixel - Eigen::Vector2d(p.cx, p.cy)).norm(), theta * p.fx, 0.05);
  EXPECT_LT(camera.bearing(pixel).z(), 0.0);
}

// Far off the axis barrel distortion turns back: rays from there land inside the image again, on
// top of the true ones, and must not be reported as seen.
TEST(Camera, FoldedRaysAreNotSeen) {
  CameraParameters p = eurocCamera();
  p.distortion = {-0.3, 0.0, 0.0, 0.0};
  const Camera camera(p);
  const double fold = std::sqrt(1.0 / 0.9);  // 1 - 0.9 r^2 = 0
  const double folded = 1.7;                 // distorts to 1.7 (1 - 0.3 * 2.89) = 0.226
  ASSERT_GT(folded, fold);
  Eigen::Vector2d pixel;
  EXPECT_FALSE(camera.project({folded, 0.0, 1.0}, &pixel));
  // And a pixel beyond the largest distorted radius, 2/3 of the fold, has no ray.
  EXPECT_TRUE(camera.bearing({p.cx + p.fx * (0.68 * fold), p.cy}).array().isNaN().all());
  EXPECT_TRUE(camera.bearing({p.cx + p.fx * (0.66 * fold), p.cy}).allFinite());
}

TEST(Camera, PixelsOutsideTheFisheyeCircleHaveNoRay) {
  CameraParameters p = kannalaBrandt();
  p.distortion = {-0.1, 0.0, 0.0, 0.0};  // increases up to sqrt(1 / 0.3) = 1.826 rad, radius 1.217
  const Camera camera(p);
  EXPECT_TRUE(camera.bearing({p.cx + 1.21 * p.fx, p.cy}).allFinite());
  EXPECT_TRUE(camera.bearing({p.cx + 1.22 * p.fx, p.cy}).array().isNaN().all());
}

TEST(CameraParameters, DefaultsAreValidAndBoundsAreNamed) {
  EXPECT_EQ(CameraParameters().validate(), "");
  CameraParameters p;
  p.fx = -1.0;
  EXPECT_EQ(p.validate(), "fx is -1, must be in [1, 100000]");
  p = CameraParameters();
  p.cx = 4000.0;
  EXPECT_EQ(p.validate(), "cx is 4000, must be in [0, 752]");
  p = CameraParameters();
  p.height *= 2;
  EXPECT_EQ(p.validate(), "cy / height is 0.25, must be in [0.3, 0.7]");
  p = CameraParameters();
  p.distortion[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(p.validate().find("distortion[2]"), std::string::npos);
}

}  // namespace
}  // namespace slim_init::feature_tracker_lines
