// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The pieces of the front end, each on its own.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "corner_detector.h"
#include "edge_fit.h"
#include "image_pyramid.h"
#include "line_detector.h"
#include "outliers.h"
#include "patch_anchor.h"
#include "point_tracker.h"
#include "room_walk.h"
#include "row_camera.h"

namespace slim_init::feature_tracker_lines {
namespace {

// An image of value(x, y), as grey levels.
template <typename Value>
cv::Mat painted(int width, int height, const Value& value) {
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at<uchar>(y, x) = cv::saturate_cast<uchar>(value(x, y));
  }
  return image;
}

cv::Mat flatImage(double brightness, double noise, std::uint64_t seed) {
  cv::Mat image(480, 752, CV_8UC1, cv::Scalar(brightness));
  if (noise > 0.0) addNoise(noise, seed, &image);
  return image;
}

std::vector<cv::Point2f> cornersOf(const ImagePyramid& pyramid, double factor,
                                   cv::Mat mask = cv::Mat()) {
  const cv::Size size = pyramid.level(0).size();
  CornerDetector detector(size, 20.0, 8.0);
  if (mask.empty()) mask = cv::Mat(size, CV_8UC1, cv::Scalar(255));
  std::vector<cv::Point2f> corners;
  detector.detect(pyramid.derivative(0), factor * kNoiseEigenvalue * pyramid.noise * pyramid.noise,
                  1000, detector.cells(), &mask, &corners);
  return corners;
}

std::vector<cv::Point2f> cornersOf(const cv::Mat& image, double factor, cv::Mat mask = cv::Mat()) {
  ImagePyramid pyramid;
  buildImagePyramid(image, 21, 3, 0, &pyramid);
  return cornersOf(pyramid, factor, std::move(mask));
}

// A far point, seen in the row that is exposed when the camera has turned towards it.
TEST(RowCameraTest, TurnsARayToTheMiddleRow) {
  const Camera lens(eurocCamera());
  RowExposure rows;
  rows.readout_s = 0.03;
  rows.rate_c = Eigen::Vector3d(0.8, -1.5, 0.4);
  const Eigen::Vector3d far = Eigen::Vector3d(0.2, -0.3, 1.0).normalized();  // at the middle row
  for (const double v : {0.0, 100.0, 240.0, 479.0}) {
    const double dt = (v / 480.0 - 0.5) * 0.03;
    const Eigen::Vector3d seen = expSO3(rows.rate_c * dt).transpose() * far;
    EXPECT_LT((RowCamera(lens, rows).atMiddleRow(seen, v) - far).norm(), 1e-14);
    EXPECT_LT((RowCamera(lens, rows).atOwnRow(far, v) - seen).norm(), 1e-14);
  }
  rows.readout_s = 0.0;
  EXPECT_EQ(RowCamera(lens, rows).atMiddleRow(far, 0.0), far);
  EXPECT_EQ(RowCamera(lens, rows).atOwnRow(far, 0.0), far);
}

TEST(RowCameraTest, ProjectsIntoTheRowThatIsExposedThen) {
  const Camera lens(smallCamera());
  RowExposure rows;
  rows.readout_s = 0.03;
  rows.rate_c = Eigen::Vector3d(1.5, -1.0, 2.0);
  const RowCamera camera(lens, rows);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(60.0, 20.0), Eigen::Vector2d(180.0, 119.0),
                                       Eigen::Vector2d(300.0, 215.0)}) {
    const Eigen::Vector3d middle = camera.bearing(pixel);
    EXPECT_EQ(middle, camera.atMiddleRow(lens.bearing(pixel), pixel.y()));
    Eigen::Vector2d back;
    ASSERT_TRUE(camera.project(middle, &back));
    EXPECT_LT((back - pixel).norm(), 0.01);
    EXPECT_LT((camera.atOwnRow(middle, pixel.y()) - lens.bearing(pixel)).norm(), 1e-12);
    // All rows at once: the lens itself.
    Eigen::Vector2d plain, expected;
    ASSERT_TRUE(RowCamera(lens).project(middle, &plain) && lens.project(middle, &expected));
    EXPECT_EQ(plain, expected);
    EXPECT_EQ(RowCamera(lens).bearing(pixel), lens.bearing(pixel));
  }
  Eigen::Vector2d pixel(1.0, 2.0);
  EXPECT_FALSE(camera.project(-Eigen::Vector3d::UnitZ(), &pixel));
  EXPECT_EQ(pixel, Eigen::Vector2d(1.0, 2.0));
}

TEST(ImageNoise, IsMeasuredOnFlatAndOnTexturedImages) {
  for (const double sigma : {1.0, 2.0, 5.0, 10.0}) {
    // The tenth percentile of the blocks lies some ten percent low.
    EXPECT_NEAR(measureNoise(flatImage(120.0, sigma, 3)), 0.9 * sigma, 0.07 * sigma);
    cv::Mat ramp = painted(752, 480, [](int x, int y) { return 60.0 + 0.1 * x + 0.2 * y; });
    addNoise(sigma, 5, &ramp);
    EXPECT_NEAR(measureNoise(ramp), 0.9 * sigma, 0.09 * sigma);
  }
}

TEST(ImagePyramidTest, ALargeImageIsHalvedUntilItIsSmallEnough) {
  EXPECT_EQ(halvingsFor(cv::Size(752, 480)), 0);
  EXPECT_EQ(halvingsFor(cv::Size(752, 960)), 0);
  EXPECT_EQ(halvingsFor(cv::Size(752, 961)), 1);
  EXPECT_EQ(halvingsFor(cv::Size(1280, 720)), 1);
  EXPECT_EQ(halvingsFor(cv::Size(1504, 1920)), 1);
  EXPECT_EQ(halvingsFor(cv::Size(1504, 1930)), 2);
}

TEST(ImagePyramidTest, UpperLevelsShareItsMemoryAndHaveLessNoise) {
  const cv::Mat image = flatImage(128.0, 6.0, 4);
  ImagePyramid pyramid, halved;
  buildImagePyramid(image, 21, 3, 0, &pyramid);
  buildImagePyramid(image, 21, 2, 1, &halved);
  EXPECT_EQ(pyramid.from(0).level(0).data, pyramid.level(0).data);
  EXPECT_EQ(pyramid.from(0).noise, pyramid.noise);
  const ImagePyramid upper = pyramid.from(1);
  EXPECT_EQ(upper.level(0).data, pyramid.level(1).data);
  EXPECT_EQ(upper.max_level, pyramid.max_level - 1);
  // The same image, whichever way it was halved.
  EXPECT_EQ(cv::norm(halved.level(0), upper.level(0), cv::NORM_INF), 0.0);
  EXPECT_EQ(halved.halvings, upper.halvings);
  EXPECT_NEAR(halved.noise, upper.noise, 1e-12);
  EXPECT_LT(upper.noise, 0.4 * pyramid.noise);
  EXPECT_NEAR(halved.from(1).noise, pyramid.from(2).noise, 1e-12);
  EXPECT_TRUE(pyramid.from(pyramid.max_level + 1).empty());
  EXPECT_EQ(levelNoise(0.0, 2), kLeastNoise);
}

TEST(ImagePyramidTest, RowsAreScaledLinearlyBetweenTheMiddlesOfTheBands) {
  ImagePyramid image;
  buildImagePyramid(cv::Mat(80, 60, CV_8UC1, cv::Scalar(100)), 21, 1, 0, &image);
  scaleRows({0.5, 1.0}, &image);
  for (const auto& [row, grey] : {std::pair(0, 50), std::pair(19, 50), std::pair(39, 75),
                                  std::pair(60, 100), std::pair(79, 100)}) {
    EXPECT_NEAR(image.level(0).at<uchar>(row, 30), grey, 1) << row;
  }
  EXPECT_NEAR(image.level(1).at<uchar>(0, 15), 50, 1);
  scaleRows({1.5}, &image);
  EXPECT_NEAR(image.level(0).at<uchar>(0, 30), 75, 1);
  EXPECT_NEAR(image.level(0).at<uchar>(79, 30), 150, 1);
}

TEST(ImageNoise, SaturatedAndTinyImagesHaveTheLeast) {
  EXPECT_EQ(measureNoise(flatImage(255.0, 0.0, 1)), kLeastNoise);
  EXPECT_EQ(measureNoise(flatImage(0.0, 0.0, 1)), kLeastNoise);
  EXPECT_EQ(measureNoise(cv::Mat(10, 10, CV_8UC1, cv::Scalar(99))), kLeastNoise);
}

// The constant is what noise makes: well below it there are plenty. The noise of the levels above
// is that of white noise that makes corners as strong.
TEST(Corners, NoneFromNoiseOnAnyLevel) {
  for (const double sigma : {0.5, 1.0, 3.0, 8.0}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      ImagePyramid pyramid;
      buildImagePyramid(flatImage(128.0, sigma, seed), 21, 3, 0, &pyramid);
      for (int level = 0; level <= (sigma < 3.0 ? 0 : 2); ++level) {
        EXPECT_TRUE(cornersOf(pyramid.from(level), 2.0).empty()) << sigma << " " << level;
        EXPECT_GT(cornersOf(pyramid.from(level), 0.4).size(), level == 0 ? 20U : 5U)
            << sigma << " " << level;
      }
    }
  }
}

// Under a lens cap, at night, or overexposed.
TEST(Corners, NoneFromNoiseThatIsClipped) {
  for (const double brightness : {0.0, 1.0, 254.0, 255.0}) {
    for (const double sigma : {1.0, 4.0}) {
      const cv::Mat image = flatImage(brightness, sigma, 7);
      EXPECT_GT(measureNoise(image), 0.4 * sigma) << brightness;
      EXPECT_TRUE(cornersOf(image, 2.0).empty()) << brightness << " " << sigma;
    }
  }
}

TEST(Corners, OfABoardAndNotOfItsEdges) {
  cv::Mat image(480, 752, CV_8UC1, cv::Scalar(60));
  // Four corners, 200 px of edge between them, tilted so that the edges are stair steps.
  const std::vector<cv::Point> quad = {{220, 130}, {420, 150}, {400, 350}, {200, 330}};
  cv::fillConvexPoly(image, quad, cv::Scalar(190), cv::LINE_AA);
  cv::GaussianBlur(image, image, cv::Size(), 0.7);
  addNoise(2.0, 9, &image);
  const std::vector<cv::Point2f> corners = cornersOf(image, 2.0);
  ASSERT_EQ(corners.size(), 4U);
  for (const cv::Point& vertex : quad) {
    double nearest = 1e9;
    for (const cv::Point2f& corner : corners) {
      nearest = std::min(nearest, cv::norm(corner - cv::Point2f(vertex)));
    }
    EXPECT_LT(nearest, 3.0);
  }
}

TEST(Corners, KeepOutOfTheMaskAndApart) {
  cv::Mat image(480, 752, CV_8UC1);
  cv::RNG random(4);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, cv::Size(), 2.0);
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  mask.colRange(0, 300).setTo(0);
  const std::vector<cv::Point2f> corners = cornersOf(image, 2.0, mask);
  ASSERT_GT(corners.size(), 100U);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_GE(corners[i].x, 300.0F);
    EXPECT_LT(corners[i].x, 752.0F - 8.0F);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(cv::norm(corners[i] - corners[j]), 19.5);
  }
}

TEST(Corners, ABoundedSearchReachesEveryCellInTurn) {
  cv::Mat image = flatImage(128.0, 1.0, 2);
  ImagePyramid pyramid;
  buildImagePyramid(image, 21, 3, 0, &pyramid);
  CornerDetector detector(image.size(), 20.0, 8.0);
  const int at_a_time = 10;
  // A corner that is only there in the last round must still be found within it.
  const int rounds = (detector.cells() + at_a_time - 1) / at_a_time;
  std::vector<cv::Point2f> corners;
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  for (int i = 0; i < rounds; ++i) {
    detector.detect(pyramid.derivative(0), 100.0, 10, at_a_time, &mask, &corners);
  }
  EXPECT_TRUE(corners.empty());
  cv::rectangle(image, cv::Rect(400, 300, 90, 60), cv::Scalar(220), cv::FILLED);
  buildImagePyramid(image, 21, 3, 0, &pyramid);
  for (int i = 0; i < rounds; ++i) {
    detector.detect(pyramid.derivative(0), 100.0, 10, at_a_time, &mask, &corners);
  }
  EXPECT_EQ(corners.size(), 4U);
}

// Smooth texture about a centre, seen through an affine map.
cv::Mat texture(const Eigen::Vector2d& centre, const Eigen::Matrix2d& affine, double gain,
                double bias) {
  const Eigen::Matrix2d inverse = affine.inverse();
  return painted(120, 120, [&](int x, int y) {
    const Eigen::Vector2d p = inverse * (Eigen::Vector2d(x, y) - centre);
    const double value =
        60.0 * textures::cloud(1, p.x(), p.y(), 5.0) + 60.0 * textures::cloud(2, p.x(), p.y(), 9.0);
    return gain * value + bias;
  });
}

cv::Mat plainTexture(const Eigen::Vector2d& centre) {
  return texture(centre, Eigen::Matrix2d::Identity(), 1.0, 40.0);
}

PatchAnchor anchorAt(const Eigen::Vector2d& here) {
  PatchAnchor anchor;
  EXPECT_TRUE(anchor.set(plainTexture(here), here, 1.0));
  return anchor;
}

TEST(PatchAnchorTest, FindsItselfThroughAffineMapsAndExposure) {
  PatchAnchor anchor = anchorAt({58.3, 61.6});
  const Eigen::Vector2d there(60.45, 59.2);
  Eigen::Matrix2d affine;
  affine << 1.12, -0.08, 0.10, 1.05;
  const PatchAnchor::Match match =
      anchor.align(texture(there, affine, 1.3, 10.0), there + Eigen::Vector2d(0.9, -1.1), 1.0);
  ASSERT_TRUE(match.ok);
  EXPECT_GT(match.correlation, 0.98);
  EXPECT_LT((match.pixel - there).norm(), 0.05);
  EXPECT_EQ(anchor.scale(), 1.0);  // nothing kept yet
  anchor.accept();
  EXPECT_NEAR(anchor.scale(), std::sqrt(affine.determinant()), 0.02);
}

TEST(PatchAnchorTest, ToldOfALargeTurnItFollows) {
  const Eigen::Vector2d here(60.0, 60.0);
  PatchAnchor anchor = anchorAt(here);
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(0.9).toRotationMatrix();
  const cv::Mat now = texture(here, turn, 1.0, 40.0);
  const PatchAnchor::Match untold = anchor.align(now, here, 1.0);
  EXPECT_TRUE(!untold.ok || untold.correlation < 0.8);
  anchor.deform(turn);
  const PatchAnchor::Match told = anchor.align(now, here + Eigen::Vector2d(0.5, 0.5), 1.0);
  ASSERT_TRUE(told.ok);
  EXPECT_LT((told.pixel - here).norm(), 0.05);
}

TEST(PatchAnchorTest, DoesNotRecogniseSomethingElse) {
  const Eigen::Vector2d here(60.0, 60.0);
  const PatchAnchor::Match match = anchorAt(here).align(plainTexture({1000.0, -700.0}), here, 1.0);
  EXPECT_TRUE(!match.ok || match.correlation < 0.8);
}

TEST(PatchAnchorTest, NeedsTextureAndRoom) {
  PatchAnchor anchor;
  EXPECT_FALSE(anchor.set(flatImage(100.0, 0.0, 1), {100.0, 100.0}, 1.0));
  EXPECT_FALSE(anchor.align(flatImage(100.0, 0.0, 1), {100.0, 100.0}, 1.0).ok);
  const cv::Mat image = plainTexture({60.0, 60.0});
  EXPECT_FALSE(anchor.set(image, {4.0, 60.0}, 1.0));
  EXPECT_FALSE(anchor.set(image, {60.0, 119.0}, 1.0));
  ASSERT_TRUE(anchor.set(image, {60.0, 60.0}, 1.0));
  EXPECT_FALSE(anchor.align(image, {2.0, 2.0}, 1.0).ok);
  // Far too much noise for this contrast.
  EXPECT_FALSE(anchor.set(image, {60.0, 60.0}, 40.0));
}

TEST(PatchAnchorTest, RefusesAnEdge) {
  cv::Mat image(120, 120, CV_8UC1, cv::Scalar(60));
  const std::vector<cv::Point> half = {{0, 50}, {119, 71}, {119, 119}, {0, 119}};
  cv::fillConvexPoly(image, half, cv::Scalar(200), cv::LINE_AA);
  cv::GaussianBlur(image, image, cv::Size(), 0.7);
  addNoise(2.0, 3, &image);
  PatchAnchor anchor;
  EXPECT_FALSE(anchor.set(image, {60.0, 60.0}, 2.0));
  cv::rectangle(image, cv::Rect(60, 0, 60, 120), cv::Scalar(120), cv::FILLED);
  EXPECT_TRUE(anchor.set(image, {60.0, 60.0}, 2.0));
}

using Flags = std::vector<unsigned char>;
Flags allInliers(std::size_t count) { return Flags(count, 1); }

struct Scene {
  std::vector<Eigen::Vector3d> rotated_before, before, now;
  Flags inlier;
};

Scene makeScene(const Eigen::Vector3d& translation, double noise_rad, int count, int wrong) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal(0.0, noise_rad);
  const Eigen::Matrix3d R_now_before = expSO3(Eigen::Vector3d(0.02, -0.03, 0.01));
  Scene scene;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d place{2.0 * uniform(random), 1.3 * uniform(random),
                                4.0 + 2.0 * uniform(random)};
    Eigen::Vector3d now = (R_now_before * (place - translation)).normalized();
    for (int axis = 0; axis < 2; ++axis) now[axis] += normal(random);
    scene.inlier.push_back(i < wrong ? 0 : 1);
    // Off its epipolar line by 8 px at 460 px.
    if (i < wrong) {
      const Eigen::Vector3d epipole = R_now_before * translation.normalized();
      now += 8.0 / 460.0 * epipole.cross(now).normalized();
    }
    scene.now.push_back(now.normalized());
    scene.before.push_back(place.normalized());
    scene.rotated_before.push_back(R_now_before * scene.before.back());
  }
  return scene;
}

TEST(KnownRotation, FindsExactlyThePlantedOutliers) {
  for (const Eigen::Vector3d& translation :
       {Eigen::Vector3d(0.05, 0.02, 0.0), Eigen::Vector3d(0.0, 0.0, 0.08),
        Eigen::Vector3d(-0.02, 0.03, 0.05)}) {
    const Scene scene = makeScene(translation, 0.2 / 460.0, 150, 60);
    const EpipoleFit fit = knownRotationInliers(scene.rotated_before, scene.now, 460.0, 1.5);
    EXPECT_EQ(fit.flags, scene.inlier);
    const Eigen::Vector3d expected =
        expSO3(Eigen::Vector3d(0.02, -0.03, 0.01)) * translation.normalized();
    EXPECT_LT(std::acos(std::min(1.0, std::abs(fit.epipole.dot(expected)))), 0.05);
  }
}

TEST(KnownRotation, WithoutTranslationNothingIsWrong) {
  const Scene scene = makeScene(Eigen::Vector3d(1e-9, 0.0, 0.0), 0.2 / 460.0, 100, 0);
  const EpipoleFit fit = knownRotationInliers(scene.rotated_before, scene.now, 460.0, 1.5);
  EXPECT_EQ(fit.flags, allInliers(100));
  // And bit for bit nothing moved.
  const EpipoleFit still = knownRotationInliers(scene.now, scene.now, 460.0, 1.5);
  EXPECT_EQ(still.flags, allInliers(100));
  EXPECT_EQ(still.epipole, Eigen::Vector3d::Zero());
}

TEST(KnownRotation, FewPairsAreLeftAlone) {
  const Scene scene = makeScene(Eigen::Vector3d(0.1, 0.0, 0.0), 0.0, 2, 2);
  const EpipoleFit fit = knownRotationInliers(scene.rotated_before, scene.now, 460.0, 1.5);
  EXPECT_EQ(fit.flags, allInliers(2));
  EXPECT_TRUE(knownRotationInliers({}, {}, 460.0, 1.5).flags.empty());
}

// Three views of a moving camera; the last third of the points slide along their epipolar lines.
TEST(ThreeViews, FindWhatSlidesAlongTheEpipolarLine) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::Vector3d step(0.02, -0.01, 0.15);
  std::vector<Eigen::Vector3d> first, second, third;
  constexpr int kPoints = 60, kSliding = 20;
  Flags expected = allInliers(kPoints);
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d place{2.0 * uniform(random), 1.5 * uniform(random),
                                5.0 + 2.0 * uniform(random)};
    first.push_back(place.normalized());
    second.push_back((place - step).normalized());
    // Not evenly: the first step is longer than the second.
    Eigen::Vector3d last = (place - 1.7 * step).normalized();
    if (i >= kPoints - kSliding) {
      const Eigen::Vector3d along =
          (step.normalized() - last * last.dot(step.normalized())).normalized();
      last = (last + 6.0 / 460.0 * along).normalized();
      expected[static_cast<std::size_t>(i)] = 0;
    }
    third.push_back(last);
  }
  // No check of two views sees it.
  EXPECT_EQ(knownRotationInliers(first, third, 460.0, 1.5).flags, allInliers(kPoints));
  EXPECT_EQ(threeViewInliers(first, second, third, 460.0, 1.5, 0.6), expected);
  // Nothing to tell by where nothing moves.
  EXPECT_EQ(threeViewInliers(first, first, first, 460.0, 1.5, 0.6), allInliers(kPoints));
  EXPECT_TRUE(threeViewInliers({}, {}, {}, 460.0, 1.5, 0.6).empty());
}

TEST(Fundamental, FindsThePlantedOutliersWithoutKnowingTheRotation) {
  const Scene scene = makeScene(Eigen::Vector3d(0.3, 0.1, 0.0), 0.1 / 460.0, 150, 30);
  const Flags inlier = fundamentalInliers(scene.before, scene.now, 460.0, 1.5);
  int caught = 0, lost = 0;
  for (std::size_t i = 0; i < inlier.size(); ++i) {
    (scene.inlier[i] == 0 ? caught : lost) += inlier[i] == 0 ? 1 : 0;
  }
  EXPECT_GE(caught, 27);
  EXPECT_LE(lost, 3);
}

TEST(Fundamental, RaysFarOffTheAxisAreNotJudged) {
  Scene scene = makeScene(Eigen::Vector3d(0.3, 0.1, 0.0), 0.0, 50, 0);
  scene.before.push_back(Eigen::Vector3d(1.0, 0.0, -0.2).normalized());
  scene.now.push_back(Eigen::Vector3d(0.0, 1.0, -0.2).normalized());
  EXPECT_EQ(fundamentalInliers(scene.before, scene.now, 460.0, 1.5).back(), 1);
}

// One straight 3D edge: a plane through the camera centre parts bright from dark.
cv::Mat edgeImage(const RowCamera& camera, const CameraParameters& size,
                  const Eigen::Vector3d& normal, double dark, double bright) {
  constexpr int kRays = 4;
  cv::Mat image = painted(size.width, size.height, [&](int x, int y) {
    double sum = 0.0;
    for (int s = 0; s < kRays * kRays; ++s) {
      const Eigen::Vector2d pixel(x + (s % kRays + 0.5) / kRays - 0.5,
                                  y + (s / kRays + 0.5) / kRays - 0.5);
      sum += camera.bearing(pixel).dot(normal) > 0.0 ? bright : dark;
    }
    return sum / (kRays * kRays);
  });
  cv::GaussianBlur(image, image, cv::Size(), 0.7);
  return image;
}

// On the plane with this normal, brighter on its side: start x end points there. `half` [rad].
struct Arc {
  Arc(const Eigen::Vector3d& plane, double half) : normal(plane.normalized()) {
    middle = (Eigen::Vector3d::UnitZ() - normal * normal.z()).normalized();
    const Eigen::Vector3d along = normal.cross(middle);
    start = std::cos(half) * middle - std::sin(half) * along;
    end = std::cos(half) * middle + std::sin(half) * along;
  }
  double errorPx(const Edge& edge, double focal_px) const {
    return std::acos(std::min(1.0, edge.normal().dot(normal))) * focal_px;
  }
  Eigen::Vector3d normal, middle, start, end;
};

TEST(EdgeFitTest, StraightInSpaceThoughCurvedInTheImage) {
  const Camera camera(smallCamera());
  // Far from the centre, where the lens bends it by several pixels.
  const Arc arc({0.08, 1.0, 0.32}, 0.52);
  const cv::Mat image = edgeImage(RowCamera(camera), camera.parameters(), arc.normal, 60.0, 170.0);
  Eigen::Vector2d a, b, m;
  ASSERT_TRUE(camera.project(arc.start, &a) && camera.project(arc.end, &b) &&
              camera.project(arc.middle, &m));
  EXPECT_GT((0.5 * (a + b) - m).norm(), 4.0) << "the image of the edge is not curved";
  // Begun 2 px off and tilted.
  const Eigen::Vector3d off = 2.0 / camera.focalPx() * arc.normal;
  Edge edge;
  ASSERT_TRUE(fitEdge(image, RowCamera(camera), (arc.start + off).normalized(),
                      (arc.end + 0.5 * off).normalized(), 3.0, 0.5, 0.6, 0.5, &edge));
  EXPECT_LT(arc.errorPx(edge, camera.focalPx()), 0.05);
  EXPECT_GT(edge.support, 0.95);
  EXPECT_LT(edge.rms_px, 0.1);
  Eigen::Vector2d pixel;
  ASSERT_TRUE(camera.project(edge.start, &pixel));
  EXPECT_LT((pixel - edge.start_pixel).norm(), 1e-9);
  EXPECT_NEAR(edge.length_px, (a - b).norm(), 5.0);
  // The other sense of brightness is another edge.
  EXPECT_FALSE(fitEdge(image, RowCamera(camera), arc.end, arc.start, 3.0, 0.5, 0.6, 0.5, &edge));
}

TEST(EdgeFitTest, StraightInSpaceThoughBentByTheReadout) {
  const Camera lens(smallCamera());
  RowExposure rows;
  rows.readout_s = 0.03;
  rows.rate_c = Eigen::Vector3d(0.0, 3.0, 1.0);
  const RowCamera camera(lens, rows);
  // An upright edge: every row of it is seen at another time.
  const Arc arc({1.0, 0.1, -0.1}, 0.38);
  const cv::Mat image = edgeImage(camera, lens.parameters(), arc.normal, 60.0, 170.0);
  Edge edge, bent;
  ASSERT_TRUE(fitEdge(image, camera, arc.start, arc.end, 3.0, 0.5, 0.6, 0.5, &edge));
  EXPECT_LT(arc.errorPx(edge, lens.focalPx()), 0.05);
  EXPECT_LT(edge.rms_px, 0.1);
  // Taken for a global shutter, the same edge is elsewhere and no straight line.
  const bool found =
      fitEdge(image, RowCamera(lens), camera.atOwnRow(arc.start, edge.start_pixel.y()),
              camera.atOwnRow(arc.end, edge.end_pixel.y()), 6.0, 0.5, 0.6, 1.5, &bent);
  EXPECT_TRUE(!found || bent.rms_px > 2.0 * edge.rms_px);
}

TEST(EdgeFitTest, NoiseCostsLittleAndABlankImageHasNone) {
  const Camera lens(smallCamera());
  const RowCamera camera(lens);
  const Arc arc({1.0, 0.3, -0.1}, 0.29);
  cv::Mat image = edgeImage(camera, lens.parameters(), arc.normal, 90.0, 130.0);
  addNoise(3.0, 5, &image);
  Edge edge;
  ASSERT_TRUE(fitEdge(image, camera, arc.start, arc.end, 3.0, 3.0, 0.6, 0.5, &edge));
  EXPECT_LT(arc.errorPx(edge, camera.focalPx()), 0.15);
  cv::Mat blank(image.size(), CV_8UC1, cv::Scalar(100));
  addNoise(3.0, 6, &blank);
  EXPECT_FALSE(fitEdge(blank, camera, arc.start, arc.end, 3.0, 3.0, 0.6, 0.5, &edge));
  EXPECT_FALSE(fitEdge(image, camera, arc.start, arc.start, 3.0, 3.0, 0.6, 0.5, &edge));
}

// Segments of an image as it is, without a level of the pyramid in between.
std::vector<cv::Vec4f> segmentsOf(const cv::Mat& image, double min_length, double noise = 0.3) {
  ImagePyramid pyramid;
  buildImagePyramid(image, 5, 0, 0, &pyramid);
  std::vector<cv::Vec4f> segments(3);  // what was there before is no result
  LineDetector(min_length).detect(pyramid.derivative(0), noise, &segments);
  return segments;
}

double lengthOf(const cv::Vec4f& s) { return std::hypot(s[2] - s[0], s[3] - s[1]); }

TEST(LineDetectorTest, NothingInImagesWithoutEdges) {
  for (const double brightness : {0.0, 90.0, 255.0}) {
    EXPECT_TRUE(segmentsOf(cv::Mat(240, 376, CV_8UC1, cv::Scalar(brightness)), 20.0).empty());
  }
  for (const int side : {1, 2, 3, 8}) {
    EXPECT_TRUE(segmentsOf(cv::Mat(side, side, CV_8UC1, cv::Scalar(90)), 20.0).empty()) << side;
  }
  cv::Mat noisy(240, 376, CV_8UC1, cv::Scalar(90));
  addNoise(8.0, 1, &noisy);
  EXPECT_TRUE(segmentsOf(noisy, 20.0).empty());
}

// All four sides in one piece each, with the brighter side to the right of their way.
TEST(LineDetectorTest, SidesOfARectangleWithTheirBrighterSide) {
  for (const bool bright : {true, false}) {
    cv::Mat image(240, 376, CV_8UC1, cv::Scalar(bright ? 50 : 200));
    cv::rectangle(image, cv::Rect(100, 60, 150, 100), cv::Scalar(bright ? 200 : 50), cv::FILLED);
    addNoise(2.0, 1, &image);
    const std::vector<cv::Vec4f> segments = segmentsOf(image, 20.0);
    ASSERT_EQ(segments.size(), 4U);
    const Eigen::Vector2d centre(174.5, 109.5);
    for (const cv::Vec4f& s : segments) {
      EXPECT_TRUE(std::abs(s[0] - s[2]) < 2.0F || std::abs(s[1] - s[3]) < 2.0F);
      EXPECT_GT(lengthOf(s), 90.0);
      const Eigen::Vector2d along(s[2] - s[0], s[3] - s[1]), right(-along.y(), along.x());
      const Eigen::Vector2d inwards = centre - Eigen::Vector2d(s[0], s[1]);
      EXPECT_EQ(right.dot(inwards) > 0.0, bright);
    }
  }
}

TEST(LineDetectorTest, SlantedEdgesAreOneSegment) {
  for (const double degrees : {3.0, 20.0, 40.0, 45.0, 50.0, 70.0, 88.0, 130.0}) {
    const double angle = degrees * 0.017453292519943295;
    const cv::Mat image = painted(240, 240, [angle](int x, int y) {
      const double side = (x - 120) * std::sin(angle) - (y - 120) * std::cos(angle);
      return 120.0 + 60.0 * std::tanh(side);
    });
    const std::vector<cv::Vec4f> segments = segmentsOf(image, 20.0);
    ASSERT_EQ(segments.size(), 1U) << degrees;
    EXPECT_GT(lengthOf(segments[0]), 220.0) << degrees;
    for (const int end : {0, 2}) {
      const double side = (segments[0][end] - 120) * std::sin(angle) -
                          (segments[0][end + 1] - 120) * std::cos(angle);
      EXPECT_LT(std::abs(side), 1.0) << degrees;
    }
  }
}

// What a lens bends stays one segment, whose ends lie on the edge; a corner ends it.
TEST(LineDetectorTest, FollowsABendButNotACorner) {
  const auto height = [](double x) { return 100.0 + 12.0 * std::pow((x - 188.0) / 188.0, 2); };
  cv::Mat image =
      painted(376, 240, [&](int x, int y) { return 120.0 + 60.0 * std::tanh(y - height(x)); });
  const std::vector<cv::Vec4f> bent = segmentsOf(image, 20.0);
  ASSERT_EQ(bent.size(), 1U);
  EXPECT_GT(lengthOf(bent[0]), 360.0);
  for (const int end : {0, 2}) EXPECT_NEAR(bent[0][end + 1], height(bent[0][end]), 0.7);
  image.setTo(50);
  const std::vector<cv::Point> wedge = {{20, 200}, {188, 60}, {356, 200}};
  cv::fillConvexPoly(image, wedge, cv::Scalar(180));
  EXPECT_EQ(segmentsOf(image, 20.0).size(), 3U);
}

TEST(LineDetectorTest, LengthContrastAndNoiseHaveTheirBounds) {
  cv::Mat image(120, 160, CV_8UC1, cv::Scalar(60));
  cv::rectangle(image, cv::Rect(50, 30, 60, 40), cv::Scalar(160), cv::FILLED);
  EXPECT_EQ(segmentsOf(image, 25.0).size(), 4U);
  EXPECT_EQ(segmentsOf(image, 50.0).size(), 2U);
  EXPECT_EQ(segmentsOf(image, 70.0).size(), 0U);
  // A step of c grey levels is a slope of c / 2 at the two pixels beside it; the bound is 4, and 6
  // where a segment starts.
  const auto withStep = [&](int step) {
    image.setTo(100);
    cv::rectangle(image, cv::Rect(50, 30, 60, 40), cv::Scalar(100 + step), cv::FILLED);
    return segmentsOf(image, 25.0).size();
  };
  EXPECT_EQ(withStep(10), 0U);
  EXPECT_EQ(withStep(14), 4U);
  // The same where the noise is known to be as large as the slope.
  EXPECT_EQ(segmentsOf(image, 25.0, 4.0).size(), 4U);
  EXPECT_EQ(segmentsOf(image, 25.0, 8.0).size(), 0U);
}

// Where the anchor is as predicted, KLT is left out; a jump, or a point without a steady step
// before, takes the long way and is found as well. A step that is longer since more time has passed
// is no jump.
class StepsOf : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(IntervalRatios, StepsOf, testing::Values(1.0, 2.0));
TEST_P(StepsOf, SteadyPointsAreRecognisedAndOthersFollowed) {
  const CameraParameters camera = cameraOf(320, 240, 460.0, 460.0, 160.0, 120.0);
  const auto imageAt = [&](double shift) {
    return painted(camera.width, camera.height, [shift](int x, int y) {
      return 140.0 * textures::cloud(1, x - shift, y, 9.0) +
             60.0 * textures::cloud(2, x - shift, y, 5.0);
    });
  };
  FrontEndOptions options;
  PointTracker tracker(camera, options);
  RotationPrior prior;
  prior.measured = true;
  prior.known = true;
  ImagePyramid before, now;
  // Two pixels an image; the last step is twice as long.
  std::vector<double> recognised, kept;
  for (const double shift : {0.0, 2.0, 4.0, 6.0, 8.0, 12.0}) {
    std::swap(before, now);
    prior.dt_s = shift == 12.0 ? 0.05 * GetParam() : 0.05;
    prior.dt_ratio = prior.dt_s / 0.05;
    buildImagePyramid(imageAt(shift), options.points.window_px, options.points.levels, 0, &now);
    ImageReport report;
    tracker.follow(0.0, &before, now, &prior, &report);
    tracker.refill(now, &report);
    int count = 0, old = 0;
    for (const PointTrack& track : tracker.tracks()) {
      if (track.age < 2) continue;
      ++old;
      count += track.recognised ? 1 : 0;
      EXPECT_NEAR(track.pixel.x - track.pixel_before.x, shift == 12.0 ? 4.0 : 2.0, 0.2);
    }
    const bool expected = shift == 12.0 ? prior.dt_ratio == 2.0 : shift > 2.0;
    EXPECT_EQ(tracker.motion(prior).steady, expected) << shift;
    recognised.push_back(count);
    kept.push_back(old);
  }
  ASSERT_GT(kept[1], 20);
  EXPECT_EQ(recognised[1], 0);  // nothing is known of the first step
  EXPECT_GT(recognised[4], 0.8 * kept[4]);
  if (GetParam() == 2.0) {
    EXPECT_GT(recognised[5], 0.8 * kept[5]);
  } else {
    EXPECT_LT(recognised[5], 0.2 * kept[5]);
  }
  EXPECT_GT(kept[5], 0.8 * kept[4]);
}

// Levels of the corners that a first image gets.
std::vector<int> levelsOfCorners(cv::Mat image, double noise) {
  if (noise > 0.0) addNoise(noise, 6, &image);
  CameraParameters camera;
  camera.width = image.cols;
  camera.height = image.rows;
  FrontEndOptions options;
  options.points.max_points = 400;
  PointTracker tracker(camera, options);
  ImagePyramid none, pyramid;
  buildImagePyramid(image, options.points.window_px, options.points.levels, 0, &pyramid);
  ImageReport report;
  RotationPrior prior;
  tracker.follow(0.0, &none, pyramid, &prior, &report);
  tracker.refill(pyramid, &report);
  std::vector<int> levels;
  for (const PointTrack& track : tracker.tracks()) levels.push_back(track.level);
  return levels;
}

// Forty rectangles with four corners each, `step` grey levels brighter than their surroundings.
cv::Mat rectangles(double step) {
  cv::Mat image(480, 752, CV_8UC1, cv::Scalar(100));
  for (int i = 0; i < 40; ++i) {
    cv::rectangle(image, cv::Rect(30 + 90 * (i % 8), 30 + 90 * (i / 8), 44, 40),
                  cv::Scalar(100 + step), cv::FILLED);
  }
  return image;
}

TEST(PointTrackerTest, CornersThatNoiseHidesAreTakenFromTheNextLevel) {
  const auto count = [](const std::vector<int>& levels, int level) {
    return std::count(levels.begin(), levels.end(), level);
  };
  // In sight: all on the image itself, and more than the share up to which the next level fills up.
  const std::vector<int> clear = levelsOfCorners(rectangles(60.0), 4.0);
  EXPECT_GT(count(clear, 0), 120);
  EXPECT_EQ(count(clear, 1), 0);
  // Hidden, and too vague for an anchor: from the next level, up to that share.
  for (const double step : {16.0, 24.0}) {
    const std::vector<int> hidden = levelsOfCorners(rectangles(step), 4.0);
    EXPECT_LT(count(hidden, 0), 5) << step;
    EXPECT_GT(count(hidden, 1), 80) << step;
    EXPECT_LE(hidden.size(), 88U) << step;
  }
  EXPECT_LT(levelsOfCorners(rectangles(4.0), 4.0).size(), 5U);
}

// Blotches of light have the slopes of corners on the next level, but they are not sharp.
TEST(PointTrackerTest, ShadingHasNoCornersOnAnyLevel) {
  const cv::Mat image =
      painted(752, 480, [](int x, int y) { return 60.0 + 120.0 * textures::cloud(1, x, y, 30.0); });
  ImagePyramid pyramid;
  cv::Mat noisy = image.clone();
  addNoise(4.0, 6, &noisy);
  buildImagePyramid(noisy, 21, 3, 0, &pyramid);
  EXPECT_GT(cornersOf(pyramid.from(1), 2.0).size(), 50U);
  EXPECT_LT(levelsOfCorners(image, 4.0).size(), 5U);
}

}  // namespace
}  // namespace slim_init::feature_tracker_lines
