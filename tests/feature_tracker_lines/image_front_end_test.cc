// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The whole front end on rendered rooms with an exact truth.
#include "slim_init/feature_tracker_lines/image_front_end.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>
#include <tuple>

#include "room_walk.h"
#include "support/frames.h"

namespace slim_init::feature_tracker_lines {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Eigen::Vector3d kRoom(2.2, 1.5, 2.4);

FrontEndOptions smallOptions() {
  FrontEndOptions options;
  options.points.max_points = 100;
  options.points.min_distance_px = 12.0;
  options.lines.min_length_px = 24.0;
  return options;
}

struct Outcome {
  TrackErrors errors;
  ImageReport report;                                                          // of the last image
  int outliers = 0, overruled = 0;                                             // points; images
  double points = 0.0, lines = 0.0, persisting = 0.0, lines_persisting = 0.0;  // a frame, mean
  int known_rotation = 0;                                                      // images
  FrameObservation last;
};

// Every observation is counted and has its row.
void expectComplete(const FrameObservation& frame, const ImageReport& report, int height) {
  EXPECT_EQ(static_cast<int>(frame.points.size()), report.points_tracked + report.points_new);
  EXPECT_EQ(static_cast<int>(frame.lines.size()),
            report.lines_matched + report.lines_carried + report.lines_new);
  expectOwnRows(frame, height);
}

Outcome run(RoomWalk* walk, const FrontEndOptions& options, int images,
            ImageFrontEnd* given = nullptr) {
  ImageFrontEnd own(walk->parameters, walk->calibration, options);
  ImageFrontEnd& front_end = given != nullptr ? *given : own;
  Outcome outcome;
  bool bias_known = false;  // before the image
  for (int k = 0; k < images; ++k) {
    FrameObservation frame;
    EXPECT_EQ(walk->feed(k, walk->image(k), &front_end, &frame), ImageStatus::kTracked);
    outcome.errors.add(*walk, k, frame);
    outcome.report = front_end.report();
    expectComplete(frame, outcome.report, walk->parameters.height);
    outcome.outliers += outcome.report.points_outliers;
    outcome.overruled += outcome.report.rotation_overruled ? 1 : 0;
    const double steps = images - 1;
    outcome.persisting += countIn(idSet(outcome.last.points), frame.points) / steps;
    outcome.lines_persisting += countIn(idSet(outcome.last.lines), frame.lines) / steps;
    outcome.points += static_cast<double>(frame.points.size()) / images;
    outcome.lines += static_cast<double>(frame.lines.size()) / images;
    const bool used = outcome.report.rotation_from_gyro && !outcome.report.rotation_overruled;
    if (bias_known && used) ++outcome.known_rotation;
    bias_known = outcome.report.gyro_bias_known;
    outcome.last = frame;
  }
  return outcome;
}

// Rich texture without noise, repetitive bricks with it, and every lens.
TEST(FrontEndPoints, PersistAndStayWhereTheyWere) {
  CameraParameters wide = smallCamera(), mirror = smallCamera();
  wide.model = CameraModel::kKannalaBrandt;
  wide.fx = wide.fy = 110.0;  // about 180 degrees across
  wide.distortion = {-0.02, 0.005, -0.002, 0.0003};
  mirror.model = CameraModel::kMei;
  mirror.xi = 0.9;
  mirror.fx = mirror.fy = 280.0;
  mirror.distortion = {-0.1, 0.05, 0.0005, -0.0003};
  struct Case {
    CameraParameters camera;
    WallTexture texture;
    double noise;
    int samples, images;
    double persisting, median_px, p90_px, wrong;  // bounds
  };
  const Case cases[] = {{smallCamera(), textures::rich, 0.0, 2, 30, 80.0, 0.08, 0.25, 0.01},
                        {smallCamera(), textures::bricks, 2.0, 3, 30, 60.0, 0.2, 1.0, 0.04},
                        {wide, textures::rich, 0.0, 2, 20, 70.0, 0.15, 0.5, 0.03},
                        {mirror, textures::rich, 0.0, 2, 20, 70.0, 0.15, 0.5, 0.03}};
  for (const Case& one : cases) {
    SCOPED_TRACE(&one - cases);
    RoomWalk walk(one.camera, BoxRoom(kRoom, one.texture), Motion(), one.samples);
    walk.noise = one.noise;
    const Outcome outcome = run(&walk, smallOptions(), one.images);
    EXPECT_GT(outcome.persisting, one.persisting);
    EXPECT_LT(TrackErrors::quantile(outcome.errors.point_px, 0.5), one.median_px);
    EXPECT_LT(TrackErrors::quantile(outcome.errors.point_px, 0.9), one.p90_px);
    EXPECT_LT(outcome.errors.pointsBeyond(1.5), one.wrong);
  }
}

// A tremor of the hand turns the rows of one image by several pixels against each other, and
// differently in the next one.
template <typename Texture>
Outcome runRolling(double readout_s, double believed_s, const Texture& texture) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, texture), Motion{1.0, 1.0, 0.05}, 2);
  walk.readout_s = readout_s;
  walk.calibration.readout_s = believed_s;
  return run(&walk, smallOptions(), 30);
}

TEST(FrontEndRollingShutter, KnownRotationTestsEveryPointAtItsOwnRow) {
  const Outcome known = runRolling(0.03, 0.03, textures::rich),
                ignored = runRolling(0.03, 0.0, textures::rich),
                global = runRolling(0.0, 0.0, textures::rich);
  // Told the rows, the outlier check passes about as many points as with a global shutter; taken
  // for a global one it rejects good points or gives up the gyroscope.
  EXPECT_LT(TrackErrors::quantile(known.errors.point_px, 0.5), 0.15);
  EXPECT_LT(known.errors.pointsBeyond(1.5), 0.02);
  EXPECT_GT(known.persisting, 0.95 * global.persisting);
  EXPECT_LT(known.outliers, 2 * global.outliers + 30);
  EXPECT_EQ(global.overruled, 0);  // the tremor is no damage of the gyroscope
  EXPECT_GT(ignored.outliers + 50 * ignored.overruled, 2 * known.outliers + 50 * known.overruled);
}

TEST(FrontEndRollingShutter, LinesAreThoseOfTheMiddleRow) {
  const Outcome known = runRolling(0.03, 0.03, textures::panels),
                ignored = runRolling(0.03, 0.0, textures::panels),
                global = runRolling(0.0, 0.0, textures::panels);
  // Turned to the middle row by their own times, the lines are as straight and as long-lived as
  // with a global shutter; taken for one, they are off by what the rows turn.
  EXPECT_LT(TrackErrors::quantile(known.errors.line_offset_px, 0.5), 0.25);
  EXPECT_GT(TrackErrors::quantile(ignored.errors.line_offset_px, 0.5),
            2.0 * TrackErrors::quantile(known.errors.line_offset_px, 0.5));
  EXPECT_GT(known.lines_persisting, 0.9 * global.lines_persisting);
  EXPECT_GE(known.errors.line_pairs_right, 0.97 * known.errors.line_pairs);
}

// The threshold follows the noise, in the dark as well.
TEST(FrontEndPoints, BlankWallsGiveNone) {
  for (const auto& [brightness, noise, most_points] :
       {std::tuple(128.0, 4.0, 0.0), std::tuple(20.0, 1.5, 2.0)}) {
    const auto flat = [light = brightness](int, double, double) { return light; };
    RoomWalk walk(smallCamera(), BoxRoom(kRoom, flat), Motion(), 1);
    walk.noise = noise;
    const Outcome outcome = run(&walk, smallOptions(), 5);
    EXPECT_LE(outcome.points, most_points) << brightness;
    EXPECT_EQ(outcome.lines, 0.0) << brightness;
  }
}

// All of a dark room lies in a few grey levels. It is brightened for tracking, unless the host's
// file says equalize: 0; few points are filled up on the next level in any case.
Outcome runDark(double light, double noise, bool equalize) {
  const auto texture = [light](int wall, double u, double v) {
    return light * textures::panels(wall, u, v);
  };
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, texture), Motion(), 3);
  walk.noise = noise;
  FrontEndOptions options = smallOptions();
  options.host.equalize = equalize;
  return run(&walk, options, 20);
}

TEST(FrontEndPoints, ADarkRoomKeepsItsPointsAndLines) {
  const Outcome brightened = runDark(0.05, 1.0, true), as_it_is = runDark(0.05, 1.0, false);
  for (const Outcome* outcome : {&brightened, &as_it_is}) {
    EXPECT_GT(outcome->points, 20.0);  // nine on the image alone
    EXPECT_GT(outcome->persisting, 0.9 * outcome->points);
    EXPECT_LT(TrackErrors::quantile(outcome->errors.point_px, 0.5), 0.4);
    EXPECT_LT(outcome->errors.pointsBeyond(1.5), 0.02);
  }
  EXPECT_LT(as_it_is.lines, 5.0);
  EXPECT_GT(brightened.lines, 50.0);
}

// Where the points suffice none of the next level are taken, and none becomes less accurate.
TEST(FrontEndPoints, ADarkRoomWithEnoughPointsKeepsTheSame) {
  const Outcome brightened = runDark(0.12, 0.5, true), as_it_is = runDark(0.12, 0.5, false);
  EXPECT_NEAR(brightened.points, as_it_is.points, 1.0);
  EXPECT_GT(brightened.lines, 1.3 * as_it_is.lines);
  EXPECT_NEAR(TrackErrors::quantile(brightened.errors.point_px, 0.9),
              TrackErrors::quantile(as_it_is.errors.point_px, 0.9), 0.02);
  EXPECT_LE(brightened.errors.pointsBeyond(1.5), as_it_is.errors.pointsBeyond(1.5));
}

// Not dark: bit for bit what it is without.
TEST(FrontEndPoints, ABrightRoomIsTrackedAsItIs) {
  const Outcome with = runDark(1.0, 1.0, true), without = runDark(1.0, 1.0, false);
  EXPECT_TRUE(sameFrame(with.last, without.last));
  EXPECT_EQ(with.report.image_noise, without.report.image_noise);
}

// Fraction of the points `before` that the frame has too; NaN if there were none. `before` becomes
// those of the frame.
double keptOf(std::set<FeatureId>* before, const FrameObservation& frame) {
  const double kept = countIn(*before, frame.points) / static_cast<double>(before->size());
  *before = idSet(frame.points);
  return kept;
}

// Exposures that change: by half from one image to the next, and a little darker each time, past
// the bound at which the factor changes. Both images of a step get the same brightness.
TEST(FrontEndPoints, ChangesOfTheExposureKeepTheTracks) {
  for (const bool ramp : {false, true}) {
    RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::rich), Motion(), 2);
    ImageFrontEnd front_end(walk.parameters, walk.calibration, smallOptions());
    std::set<FeatureId> before;
    double noise = kNan;
    int changes = 0;
    for (int k = 0; k < 15; ++k) {
      cv::Mat image = walk.image(k);
      image.convertTo(image, CV_8U, ramp ? 0.45 * std::pow(0.96, k) : k % 2 == 0 ? 0.5 : 0.75);
      addNoise(ramp ? 0.5 : 1.0, static_cast<std::uint64_t>(k) + 1, &image);
      FrameObservation frame;
      ASSERT_EQ(walk.feed(k, image, &front_end, &frame), ImageStatus::kTracked);
      const double kept = keptOf(&before, frame);
      if (k > 0) {
        EXPECT_GT(kept, 0.8) << ramp << " " << k;
        changes += front_end.report().image_noise > 1.5 * noise ? 1 : 0;
      }
      noise = front_end.report().image_noise;
    }
    EXPECT_EQ(changes, ramp ? 1 : 0);
  }
}

// Image k under a lamp that flickers: bands over the rows of a rolling shutter, elsewhere in every
// image.
cv::Mat withBands(const cv::Mat& image, int k, double amplitude) {
  cv::Mat bands = image.clone();
  for (int y = 0; y < image.rows; ++y) {
    const double phase = 2.0 * M_PI * (2.4 * y / image.rows + 0.37 * k);
    cv::Mat row = bands.row(y);
    image.row(y).convertTo(row, CV_8U, 1.0 + amplitude * std::sin(phase));
  }
  return bands;
}

// Mean fraction of the points that are found again in the next image.
double keptUnderBands(double amplitude, const FrontEndOptions& options) {
  constexpr int kImages = 15;
  const auto dim = [](int wall, double u, double v) { return 0.8 * textures::rich(wall, u, v); };
  RoomWalk walk(eurocCamera(), BoxRoom(kRoom, dim), Motion(), 1);
  ImageFrontEnd front_end(walk.parameters, walk.calibration, options);
  std::set<FeatureId> before;
  double sum = 0.0;
  for (int k = 0; k < kImages; ++k) {
    FrameObservation frame;
    const cv::Mat image = withBands(walk.image(k), k, amplitude);
    EXPECT_EQ(walk.feed(k, image, &front_end, &frame), ImageStatus::kTracked);
    const double kept = keptOf(&before, frame);
    if (k > 0) sum += kept / (kImages - 1);
  }
  return sum;
}

TEST(FrontEndPoints, BandsOfAFlickeringLampKeepTheTracks) {
  FrontEndOptions options;
  options.lines.enabled = false;
  const double still = keptUnderBands(0.0, options);
  EXPECT_GT(still, 0.95);
  EXPECT_GT(keptUnderBands(0.1, options), still - 0.05);
  EXPECT_GT(keptUnderBands(0.2, options), 0.7);
  // If the brightness is not matched, the same bands end the tracks.
  options.profile = TrackerProfile::kVins;
  options.host.equalize = false;
  EXPECT_GT(keptUnderBands(0.0, options), 0.9);
  EXPECT_LT(keptUnderBands(0.2, options), 0.55);
}

// Images in which the points of the last frame were seen.
std::vector<int> livesIn(double light, double noise, int images, TrackErrors* errors) {
  const auto texture = [light](int wall, double u, double v) {
    return light * textures::panels(wall, u, v);
  };
  RoomWalk walk(eurocCamera(), BoxRoom(kRoom, texture), Motion(), 1);
  walk.noise = noise;
  ImageFrontEnd front_end(walk.parameters, walk.calibration, FrontEndOptions());
  std::map<FeatureId, int> seen;
  FrameObservation frame;
  for (int k = 0; k < images; ++k) {
    EXPECT_EQ(walk.feed(k, walk.image(k), &front_end, &frame), ImageStatus::kTracked);
    errors->add(walk, k, frame);
    for (const PointObservation& point : frame.points) ++seen[point.id];
  }
  std::vector<int> lives;
  for (const PointObservation& point : frame.points) lives.push_back(seen[point.id]);
  return lives;
}

TEST(FrontEndPoints, ADimNoisyRoomIsFollowedOnTheNextLevel) {
  constexpr int kImages = 16;
  TrackErrors errors;
  const std::vector<int> lives = livesIn(0.15, 4.0, kImages, &errors);
  // None on the image alone.
  EXPECT_GE(std::count_if(lives.begin(), lives.end(), [](int n) { return n >= 10; }), 25);
  EXPECT_LT(TrackErrors::quantile(errors.point_px, 0.5), 0.6);
  EXPECT_LT(errors.pointsBeyond(2.0), 0.05);
}

// A large image is tracked at half its size; what comes out is in pixels of the camera.
TEST(FrontEndLarge, IsTrackedAtHalfItsSize) {
  RoomWalk walk(hdCamera(), BoxRoom(kRoom, textures::panels), Motion(), 1);
  walk.noise = 2.0;
  FrontEndOptions options;
  options.mask = cv::Mat(720, 1280, CV_8UC1, cv::Scalar(255));
  options.mask.colRange(0, 300).setTo(0);
  ImageFrontEnd front_end(walk.parameters, walk.calibration, options);
  const Outcome outcome = run(&walk, options, 10, &front_end);
  EXPECT_EQ(front_end.debugImage().size(), cv::Size(640, 360));
  EXPECT_GT(outcome.points, 30.0);
  EXPECT_GT(outcome.persisting, 0.8 * outcome.points);
  EXPECT_GT(outcome.lines, 30.0);
  // Half a pixel there is a quarter of a pixel here.
  EXPECT_LT(TrackErrors::quantile(outcome.errors.point_px, 0.5), 0.5);
  EXPECT_LT(outcome.errors.pointsBeyond(3.0), 0.02);
  EXPECT_GE(outcome.errors.line_pairs_right, 0.97 * outcome.errors.line_pairs);
  double rightmost = 0.0;
  for (const PointObservation& point : outcome.last.points) {
    EXPECT_LT(point.bearing.cross(walk.camera().bearing(point.pixel)).norm(), 1e-6);
    EXPECT_GE(point.pixel.x(), 299.0);
    rightmost = std::max(rightmost, point.pixel.x());
  }
  EXPECT_GT(rightmost, 900.0);
  for (const LineObservation& line : outcome.last.lines) {
    EXPECT_LT(line.start_bearing.cross(walk.camera().bearing(line.start_pixel)).norm(), 1e-9);
    EXPECT_NEAR(line.length_px, (line.end_pixel - line.start_pixel).norm(), 1e-9);
    EXPECT_GE(line.length_px, 2.0 * 0.7 * options.lines.min_length_px);
  }
}

// Intervals of 50 ms with some twice and once eight times as long: what moved evenly is expected in
// proportion. Bricks show it, since a point that is expected elsewhere is found on the next one.
TEST(FrontEndRates, UnevenIntervalsKeepTheTracks) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::bricks), Motion{1.5}, 2);
  ImageFrontEnd front_end(walk.parameters, walk.calibration, smallOptions());
  TrackErrors errors;
  std::set<FeatureId> before;
  for (const int k : {0, 1, 2, 4, 5, 7, 8, 9, 11, 13, 14, 22, 23, 24}) {
    FrameObservation frame;
    ASSERT_EQ(walk.feed(k, walk.image(k), &front_end, &frame), ImageStatus::kTracked);
    errors.add(walk, k, frame);
    const double kept = keptOf(&before, frame);
    if (k > 2) {
      EXPECT_GT(kept, k == 22 ? 0.5 : 0.8) << k;
    }
  }
  EXPECT_LT(errors.pointsBeyond(1.5), 0.02);
}

TEST(FrontEndLines, PanelsKeepTheirLinesAndIdentities) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::panels), Motion(), 3);
  walk.noise = 2.0;
  const Outcome outcome = run(&walk, smallOptions(), 31);
  EXPECT_GT(outcome.lines_persisting, 25.0);
  EXPECT_LT(TrackErrors::quantile(outcome.errors.line_angle_deg, 0.5), 0.15);
  EXPECT_LT(TrackErrors::quantile(outcome.errors.line_offset_px, 0.5), 0.15);
  EXPECT_GT(outcome.errors.line_pairs, 100);
  EXPECT_GE(outcome.errors.line_pairs_right, 0.98 * outcome.errors.line_pairs);
  for (const LineObservation& line : outcome.last.lines) {
    EXPECT_NEAR(line.start_bearing.norm(), 1.0, 1e-9);
    EXPECT_GE(line.detection_confidence, 0.0);
    EXPECT_LE(line.detection_confidence, 1.0);
    EXPECT_GE(line.match_quality, 0.0);
    EXPECT_LE(line.match_quality, 1.0);
    Eigen::Vector2d pixel;
    ASSERT_TRUE(walk.camera().project(line.end_bearing, &pixel));
    EXPECT_LT((pixel - line.end_pixel).norm(), 1e-6);
  }
}

TEST(FrontEndLines, NoMoreThanTheCap) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::panels), Motion(), 1);
  FrontEndOptions options = smallOptions();
  options.lines.max_lines = 7;
  const Outcome outcome = run(&walk, options, 6);
  EXPECT_EQ(outcome.last.lines.size(), 7U);
  options.lines.enabled = false;
  RoomWalk again(smallCamera(), BoxRoom(kRoom, textures::panels), Motion(), 1);
  const Outcome without = run(&again, options, 3);
  EXPECT_TRUE(without.last.lines.empty());
}

TEST(FrontEndBias, IsFoundFromTheTracksAndUsed) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::rich), Motion(), 2);
  walk.gyro_bias = Eigen::Vector3d(0.02, -0.03, 0.08);
  const Outcome outcome = run(&walk, smallOptions(), 40);
  ASSERT_TRUE(outcome.report.gyro_bias_known);
  EXPECT_LT((outcome.report.gyro_bias - walk.gyro_bias).norm(), 0.005)
      << outcome.report.gyro_bias.transpose();
  EXPECT_GT(outcome.known_rotation, 20);
  EXPECT_LT(outcome.errors.pointsBeyond(1.5), 0.01);
}

struct Survival {
  double points = 0.0, lines = 0.0;  // shares of those before the damage
  double wrong = 0.0;                // share of the observations
  int overruled = 0;                 // images
};

// A gyroscope that `damage(&walk)` changes for `images` images from image `first` on, and that is
// whole for eight after them.
template <typename Texture, typename Damage>
Survival surviveGyroDamage(const CameraParameters& camera, const Texture& texture, int first,
                           int images, const Damage& damage, const Motion& motion = Motion()) {
  RoomWalk walk(camera, BoxRoom(kRoom, texture), motion, 2);
  ImageFrontEnd front_end(walk.parameters, walk.calibration, smallOptions());
  std::set<FeatureId> points, lines;
  TrackErrors errors;
  double points_after = 0.0, lines_after = 0.0;
  int overruled = 0;
  for (int k = 0; k < first + images + 8; ++k) {
    walk.gyro_bias.setZero();
    walk.gyro_limit = std::numeric_limits<double>::infinity();
    if (k >= first && k < first + images) damage(&walk);
    FrameObservation frame;
    EXPECT_EQ(walk.feed(k, walk.image(k), &front_end, &frame), ImageStatus::kTracked);
    if (k >= first) errors.add(walk, k, frame);
    overruled += front_end.report().rotation_overruled ? 1 : 0;
    if (k == first - 1) points = idSet(frame.points);
    if (k == first - 1) lines = idSet(frame.lines);
    if (k != first + images + 1) continue;
    points_after = countIn(points, frame.points);
    lines_after = countIn(lines, frame.lines);
  }
  return {points_after / static_cast<double>(points.size()),
          lines_after / static_cast<double>(lines.size()), errors.pointsBeyond(1.5), overruled};
}

// 3 rad/s are 35 px between two images.
TEST(FrontEndBias, DamageOfTheGyroscopeDoesNotKillTheTracks) {
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    const auto turn = [&](RoomWalk* walk) { walk->gyro_bias = 3.0 * Eigen::Vector3d::Unit(axis); };
    const Survival points = surviveGyroDamage(smallCamera(), textures::rich, 16, 4, turn),
                   lines = surviveGyroDamage(smallCamera(), textures::panels, 16, 4, turn);
    EXPECT_GT(points.points, 0.8);
    EXPECT_LT(points.wrong, 0.03);
    EXPECT_LE(points.overruled, 4 + 2);  // an image after a damaged one, too
    EXPECT_GT(lines.lines, 0.7);
  }
}

// Errors that change from image to image by up to several bricks: the tracks must not go to the
// next brick, where KLT and the outlier check find everything in order. With a tremor even motion
// predicts little, too.
TEST(FrontEndBias, NoiseOfTheGyroscopeDoesNotLeadToTheNextBrick) {
  for (const auto& [rate, shake, seed] :
       {std::tuple(0.3, 0.0, 7U), std::tuple(1.0, 0.0, 7U), std::tuple(3.0, 0.0, 7U),
        std::tuple(0.3, 0.0075, 5U), std::tuple(1.0, 0.0075, 6U)}) {
    SCOPED_TRACE(testing::Message() << rate << " " << shake);
    std::mt19937 random(seed);
    std::normal_distribution<double> turn(0.0, rate);
    const auto noise = [&](RoomWalk* walk) {
      walk->gyro_bias = Eigen::Vector3d(turn(random), turn(random), turn(random));
    };
    const Survival points =
        surviveGyroDamage(eurocCamera(), textures::bricks, 16, 20, noise, Motion{1.0, 1.0, shake});
    EXPECT_LT(points.wrong, 0.003);
    EXPECT_GT(points.points, 0.6);
    EXPECT_LE(points.overruled, 20 + 3);
  }
}

// Neither gyroscope nor last flow predict a turn that changes by up to 23 px between images.
TEST(FrontEndBias, SaturationOfTheGyroscopeInJerksDoesNotKillTheTracks) {
  const auto saturate = [](RoomWalk* walk) { walk->gyro_limit = 0.2; };
  const Survival points =
      surviveGyroDamage(eurocCamera(), textures::bricks, 16, 10, saturate, Motion{1.0, 1.0, 0.05});
  EXPECT_GT(points.points, 0.6);
  EXPECT_LT(points.wrong, 0.01);
}

TEST(FrontEndBias, AJumpOfTheBrightnessDoesNotOverruleTheGyroscope) {
  RoomWalk walk(eurocCamera(), BoxRoom(kRoom, textures::rich), Motion{1.0, 1.0, 0.1}, 2);
  walk.flicker = 40.0;
  EXPECT_EQ(run(&walk, smallOptions(), 30).overruled, 0);
}

// 9 px at the rim leave the points in reach, and only the outlier check can tell.
TEST(FrontEndBias, ASmallDamageAtAKnownBiasIsOverruled) {
  const Survival points = surviveGyroDamage(smallCamera(), textures::rich, 36, 4,
                                            [](RoomWalk* walk) { walk->gyro_bias.z() = 0.8; });
  EXPECT_GT(points.overruled, 0);
  EXPECT_GT(points.points, 0.8);
  EXPECT_LT(points.wrong, 0.03);
}

// Images at 5 Hz whose known rotation was overruled: with a correct gyroscope, 15 images, and then
// with an error of `error` [rad/s], five.
struct Overruled {
  int correct = 0, wrong = 0;
};
Overruled overruledAt5Hz(const Eigen::Vector3d& error) {
  RoomWalk walk(eurocCamera(), BoxRoom(Eigen::Vector3d(1.6, 1.2, 1.7), textures::rich),
                Motion{2.0, 0.5}, 1);
  FrontEndOptions options;
  options.lines.enabled = false;
  ImageFrontEnd front_end(walk.parameters, walk.calibration, options);
  Overruled overruled;
  for (int k = 0; k < 100; k += k < 20 ? 1 : 4) {  // at 20 Hz until the bias is known
    const bool wrong = k >= 80;
    walk.gyro_bias = wrong ? error : Eigen::Vector3d::Zero();
    FrameObservation frame;
    EXPECT_EQ(walk.feed(k, walk.image(k), &front_end, &frame), ImageStatus::kTracked);
    if (k < 20) continue;
    EXPECT_TRUE(wrong || front_end.report().gyro_bias_known) << k;
    (wrong ? overruled.wrong : overruled.correct) += front_end.report().rotation_overruled ? 1 : 0;
  }
  return overruled;
}

// Past near walls the patches become unlike from image to image, as they do with a wrong gyroscope.
TEST(FrontEndBias, TranslationBetweenImagesDoesNotOverruleAKnownRotation) {
  for (int axis = 0; axis < 3; ++axis) {
    const Overruled overruled = overruledAt5Hz(Eigen::Vector3d::Unit(axis));
    EXPECT_EQ(overruled.correct, 0) << axis;
    EXPECT_GE(overruled.wrong, 4) << axis;
  }
}

TEST(FrontEndBias, WithoutImuItTracksAndSaysSo) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::rich), Motion(), 2);
  ImageFrontEnd front_end(walk.parameters, walk.calibration, smallOptions());
  FrameObservation frame;
  for (int k = 0; k < 8; ++k) {
    ASSERT_EQ(front_end.addImage(walk.time(k), walk.image(k), &frame), ImageStatus::kTracked);
    EXPECT_FALSE(front_end.report().rotation_from_gyro);
    EXPECT_EQ(front_end.report().rotation_missing, k > 0);
  }
  EXPECT_GT(front_end.report().points_tracked, 60);
}

// The bounds of the initializer's window hold for the front end's own estimate as well.
TEST(FrontEndBias, GapsAndLimitsOfTheImuAreThoseOfTheOptions) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::rich), Motion(), 1);
  for (const bool wide : {false, true}) {
    FrontEndOptions options = smallOptions();
    if (wide) {
      options.window.max_imu_gap_s = 0.2;
      options.imu.max_accel = 500.0;
    }
    ImageFrontEnd front_end(walk.parameters, walk.calibration, options);
    ImuSample sample;
    sample.accel.z() = 9.81;
    for (int k = 0; k < 8; ++k) {
      sample.t = walk.time(0) + walk.calibration.td + 0.1 * (k - 1);
      EXPECT_EQ(front_end.addImu(sample), AddStatus::kAdded);
    }
    FrameObservation frame;
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(front_end.addImage(walk.time(k), walk.image(k), &frame), ImageStatus::kTracked);
      EXPECT_EQ(front_end.report().rotation_from_gyro, wide && k > 0) << k;
    }
    sample.t += 0.01;
    sample.accel.x() = 400.0;
    EXPECT_EQ(front_end.addImu(sample), wide ? AddStatus::kAdded : AddStatus::kGlitch);
  }
}

class FrontEndFailures : public ::testing::Test {
 protected:
  FrontEndFailures()
      : walk_(smallCamera(), BoxRoom(kRoom, textures::rich), Motion(), 1),
        front_end_(walk_.parameters, walk_.calibration, smallOptions()) {
    for (int k = 0; k < 4; ++k) walk_.feed(k, walk_.image(k), &front_end_, &frame_);
  }
  // Tracked anew, under other ids than `before`.
  void expectAllNew(const FrameObservation& before) const {
    EXPECT_GT(frame_.points.size(), 60U);
    EXPECT_EQ(countIn(idSet(before.points), frame_.points), 0);
  }

  RoomWalk walk_;
  ImageFrontEnd front_end_;
  FrameObservation frame_;
};

TEST_F(FrontEndFailures, BadImagesAreRefusedAndForgotten) {
  const FrameObservation before = frame_;
  const cv::Mat good = walk_.image(4);
  EXPECT_EQ(front_end_.addImage(kNan, good, &frame_), ImageStatus::kNotFinite);
  EXPECT_EQ(front_end_.addImage(walk_.time(3), good, &frame_), ImageStatus::kOutOfOrder);
  EXPECT_EQ(front_end_.addImage(walk_.time(1), good, &frame_), ImageStatus::kOutOfOrder);
  EXPECT_EQ(front_end_.addImage(walk_.time(4), cv::Mat(), &frame_), ImageStatus::kBadImage);
  EXPECT_EQ(front_end_.addImage(walk_.time(4), good.rowRange(0, 100), &frame_),
            ImageStatus::kBadImage);
  cv::Mat wide;
  good.convertTo(wide, CV_16U);
  EXPECT_EQ(front_end_.addImage(walk_.time(4), wide, &frame_), ImageStatus::kBadImage);
  EXPECT_EQ(frame_.t, before.t);
  EXPECT_EQ(frame_.points.size(), before.points.size());
  // The next good one goes on from image 3.
  EXPECT_EQ(walk_.feed(4, good, &front_end_, &frame_), ImageStatus::kTracked);
  EXPECT_GT(front_end_.report().points_tracked, 60);
  EXPECT_STREQ(toString(ImageStatus::kBadImage), "bad_image");
}

TEST_F(FrontEndFailures, AnImageThatOpenCvRefusesRestartsTracking) {
  FrontEndOptions options = smallOptions();
  for (const int window_px : {1, 5}) {  // validate() would refuse 1; OpenCV needs at least 3
    options.points.window_px = window_px;
    ImageFrontEnd front_end(walk_.parameters, walk_.calibration, options);
    ASSERT_EQ(front_end.addImage(walk_.time(0), walk_.image(0), &frame_), ImageStatus::kTracked);
    const FrameObservation before = frame_;
    EXPECT_EQ(front_end.addImage(walk_.time(1), walk_.image(1), &frame_),
              window_px == 1 ? ImageStatus::kBadImage : ImageStatus::kTracked);
    if (window_px == 1) {
      EXPECT_EQ(frame_.t, before.t);
    }
    // Its time counts all the same.
    EXPECT_EQ(front_end.addImage(walk_.time(1), walk_.image(1), &frame_), ImageStatus::kOutOfOrder);
  }
}

TEST_F(FrontEndFailures, BlackAndSaturatedImagesEndAllTracksAndTheNextStartsAnew) {
  const FrameObservation before = frame_;
  int k = 4;
  for (const double brightness : {0.0, 255.0}) {
    const cv::Mat flat(walk_.parameters.height, walk_.parameters.width, CV_8UC1,
                       cv::Scalar(brightness));
    EXPECT_EQ(walk_.feed(k++, flat, &front_end_, &frame_), ImageStatus::kTracked);
    EXPECT_TRUE(frame_.points.empty());
    EXPECT_TRUE(frame_.lines.empty());
  }
  EXPECT_EQ(walk_.feed(k, walk_.image(k), &front_end_, &frame_), ImageStatus::kTracked);
  expectAllNew(before);
}

TEST_F(FrontEndFailures, ALongGapEndsAllTracks) {
  const FrameObservation before = frame_;
  EXPECT_EQ(front_end_.addImage(walk_.time(3) + 1.5, walk_.image(3), &frame_),
            ImageStatus::kTracked);
  expectAllNew(before);
}

TEST_F(FrontEndFailures, ResetForgetsAllButTheIds) {
  const FrameObservation before = frame_;
  front_end_.reset();
  EXPECT_EQ(front_end_.report().points_tracked, 0);
  EXPECT_TRUE(front_end_.debugImage().empty());
  EXPECT_EQ(front_end_.addImage(0.0, walk_.image(0), &frame_), ImageStatus::kTracked);
  expectAllNew(before);
}

class FrontEndProfiles : public testing::TestWithParam<TrackerProfile> {};

INSTANTIATE_TEST_SUITE_P(Both, FrontEndProfiles,
                         testing::Values(TrackerProfile::kDefault, TrackerProfile::kVins));

TEST_P(FrontEndProfiles, EqualInputsGiveEqualFramesWhateverTheThreadsOfOpenCv) {
  const auto mixed = [](int wall, double u, double v) {
    return 0.5 * textures::rich(wall, u, v) + 0.5 * textures::panels(wall, u, v);
  };
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, mixed), Motion(), 1);
  std::vector<std::vector<FrameObservation>> frames;
  for (const int threads : {1, 2, 8}) {
    cv::setNumThreads(threads);
    FrontEndOptions options = smallOptions();
    options.profile = GetParam();
    ImageFrontEnd front_end(walk.parameters, walk.calibration, options);
    frames.emplace_back(15);
    for (int k = 0; k < 15; ++k) {
      ASSERT_EQ(front_end.addImage(walk.time(k), walk.image(k), &frames.back()[k]),
                ImageStatus::kTracked);
      ASSERT_FALSE(frames.back()[k].points.empty());
      ASSERT_FALSE(frames.back()[k].lines.empty());
      EXPECT_TRUE(sameFrame(frames.back()[k], frames.front()[k]))
          << "image " << k << ", " << threads << " threads";
    }
  }
  cv::setNumThreads(-1);
}

TEST(FrontEnd, ColourImagesAreTakenAsGrey) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::rich), Motion(), 1);
  ImageFrontEnd grey(walk.parameters, walk.calibration, smallOptions());
  ImageFrontEnd colour(walk.parameters, walk.calibration, smallOptions());
  FrameObservation a, b;
  for (int k = 0; k < 3; ++k) {
    const cv::Mat image = walk.image(k);
    cv::Mat bgr;
    cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
    ASSERT_EQ(grey.addImage(walk.time(k), image, &a), ImageStatus::kTracked);
    ASSERT_EQ(colour.addImage(walk.time(k), bgr, &b), ImageStatus::kTracked);
  }
  EXPECT_TRUE(sameFrame(a, b));
}

TEST(FrontEnd, TheDebugImageShowsLines) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::panels), Motion(), 2);
  ImageFrontEnd front_end(walk.parameters, walk.calibration, smallOptions());
  FrameObservation frame;
  cv::Mat grey;
  for (int k = 0; k < 5; ++k) {
    grey = walk.image(k);
    ASSERT_EQ(walk.feed(k, grey, &front_end, &frame), ImageStatus::kTracked);
  }
  const cv::Mat drawn = front_end.debugImage();
  ASSERT_EQ(drawn.size(), grey.size());
  ASSERT_EQ(drawn.type(), CV_8UC3);
  const auto count = [&drawn](const cv::Scalar& low, const cv::Scalar& high) {
    cv::Mat mask;
    cv::inRange(drawn, low, high, mask);
    return cv::countNonZero(mask);
  };
  EXPECT_GT(count(cv::Scalar(245, 110, 0), cv::Scalar(255, 130, 10)), 50);  // matched
}

TEST_P(FrontEndProfiles, NeitherPointsNorEndsOfLinesLieInTheMaskedArea) {
  RoomWalk walk(smallCamera(), BoxRoom(kRoom, textures::bricks), Motion(), 2);
  const int width = walk.parameters.width, middle = width / 2;
  FrontEndOptions options = smallOptions();
  options.profile = GetParam();
  ImageFrontEnd whole(walk.parameters, walk.calibration, options);
  options.mask = cv::Mat(walk.parameters.height, width, CV_8UC1, cv::Scalar(0));
  options.mask.colRange(middle, width).setTo(255);
  ImageFrontEnd masked(walk.parameters, walk.calibration, options);
  // In the left half, as the mask is looked up; over all images.
  const auto isLeft = [&](const Eigen::Vector2d& pixel) { return cvRound(pixel.x()) < middle; };
  int points_left = 0, ends_left = 0, points = 0, ends = 0;
  for (int k = 0; k < 20; ++k) {
    const cv::Mat image = walk.image(k);
    FrameObservation frame;
    ASSERT_EQ(masked.addImage(walk.time(k), image, &frame), ImageStatus::kTracked);
    for (const PointObservation& point : frame.points) EXPECT_FALSE(isLeft(point.pixel));
    for (const LineObservation& line : frame.lines) {
      EXPECT_FALSE(isLeft(line.start_pixel) || isLeft(line.end_pixel));
    }
    points += static_cast<int>(frame.points.size());
    ends += 2 * static_cast<int>(frame.lines.size());
    ASSERT_EQ(whole.addImage(walk.time(k), image, &frame), ImageStatus::kTracked);
    for (const PointObservation& point : frame.points) points_left += isLeft(point.pixel) ? 1 : 0;
    for (const LineObservation& line : frame.lines) {
      ends_left += (isLeft(line.start_pixel) ? 1 : 0) + (isLeft(line.end_pixel) ? 1 : 0);
    }
  }
  EXPECT_GT(points, 200);
  EXPECT_GT(ends, 20);
  EXPECT_GT(points_left, 200);
  EXPECT_GT(ends_left, 20);
}

// The corners of a fisheye are dark; a mask says what is used in place of the circle.
TEST(FrontEndMask, TakesThePlaceOfTheImageCircle) {
  CameraParameters camera = smallCamera();
  camera.width = camera.height;  // a square has large corners
  camera.cx = camera.cy = 0.5 * camera.width;
  RoomWalk walk(camera, BoxRoom(kRoom, textures::bricks), Motion(), 2);
  const auto inCorners = [&](const cv::Mat& mask) {
    FrontEndOptions options = smallOptions();
    options.host.fisheye = true;
    options.mask = mask;
    ImageFrontEnd front_end(camera, walk.calibration, options);
    FrameObservation frame;
    EXPECT_EQ(front_end.addImage(0.0, walk.image(0), &frame), ImageStatus::kTracked);
    const double radius = 0.5 * camera.width + 1.0;
    const auto isOutside = [&](const Eigen::Vector2d& pixel) {
      return (pixel - Eigen::Vector2d(camera.cx, camera.cy)).norm() > radius;
    };
    std::pair<int, int> outside = {0, 0};  // points and lines
    for (const PointObservation& point : frame.points) outside.first += isOutside(point.pixel);
    for (const LineObservation& line : frame.lines) {
      outside.second += isOutside(line.start_pixel) || isOutside(line.end_pixel);
    }
    return outside;
  };
  EXPECT_EQ(inCorners({}), std::make_pair(0, 0));
  const auto whole = inCorners(cv::Mat(camera.height, camera.width, CV_8UC1, cv::Scalar(255)));
  EXPECT_GT(whole.first, 0);
  EXPECT_GT(whole.second, 0);
}

}  // namespace
}  // namespace slim_init::feature_tracker_lines
