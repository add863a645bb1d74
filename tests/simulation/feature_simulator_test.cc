// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/feature_simulator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "support/frames.h"
#include "support/made_trajectory.h"

namespace slim_init::simulation {
namespace {

// A body at the origin, looking along world x.
std::unique_ptr<Trajectory> standing() {
  return std::make_unique<MadeTrajectory>(0.0, 1e6, [](double) { return Kinematics(); });
}

// A camera that looks along the body's x axis, a hand's breadth from its centre.
Calibration rig() {
  Calibration calibration;
  calibration.R_b_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.t_b_c = Eigen::Vector3d(0.05, -0.02, 0.03);
  return calibration;
}

std::vector<double> times(int frames, double rate_hz = 20.0) {
  std::vector<double> t;
  for (int k = 0; k < frames; ++k) t.push_back(k / rate_hz);
  return t;
}

FeatureSimulationOptions noiseFree() {
  FeatureSimulationOptions options;
  options.pixel_noise = 0.0;
  options.line_noise = 0.0;
  return options;
}

// A motion in a world, as a user would set it up.
struct Scene {
  std::unique_ptr<Trajectory> trajectory;
  World world;
  Calibration calibration = rig();

  std::vector<FrameObservation> run(const FeatureSimulationOptions& options, int frames = 200,
                                    FeatureSimulationCounts* counts = nullptr) const {
    return simulateFeatures(*trajectory, world, calibration, times(frames), options, counts);
  }
};

Scene scene(const std::string& motion, const std::string& kind, double duration = 30.0) {
  Scene s;
  s.trajectory = makeBuiltinTrajectory(motion, duration, s.calibration.R_b_c, 1);
  std::vector<Eigen::Vector3d> path;
  for (double t = 0.0; t <= duration; t += 0.05) path.push_back(s.trajectory->at(t).p_w_b);
  WorldOptions options;
  options.kind = kind;
  s.world = makeWorld(options, path);
  return s;
}

// A standing camera before a wall of points at many depths, with parallel and other lines; nothing
// ever leaves the view.
Scene stillScene(int points = 3000) {
  Scene s;
  s.trajectory = standing();
  s.world.hull = {Eigen::Vector3d::Constant(-50.0), Eigen::Vector3d::Constant(50.0)};
  for (int i = 0; i < points; ++i) {
    const double depth = 3.0 + 0.01 * (i % 700);
    // Evenly spread by the golden ratio, well inside the view.
    const double u = std::fmod(0.618033988749895 * i, 1.0) - 0.5;
    const double v = std::fmod(0.754877666246693 * i, 1.0) - 0.5;
    s.world.points.emplace_back(depth, u * depth, 0.7 * v * depth);
  }
  for (int i = 0; i < 60; ++i) {
    const double depth = 4.0 + 0.05 * i;
    const double v = (i - 30) / 75.0;
    Eigen::Vector3d a(depth, -0.4 * depth, v * depth);
    Eigen::Vector3d b(depth + 0.3, -0.1 * depth, v * depth);
    if (i % 3 == 0) std::swap(a.y(), a.z());
    s.world.segments.push_back({a, b});
  }
  return s;
}

// Pose of the camera, computed apart from the code under test.
struct Camera {
  Camera(const Scene& s, double t) {
    const Kinematics body = s.trajectory->at(t);
    R_w_c = body.R_w_b * s.calibration.R_b_c;
    p_w_c = body.p_w_b + body.R_w_b * s.calibration.t_b_c;
  }
  Eigen::Vector3d see(const Eigen::Vector3d& p_w) const {
    return R_w_c.transpose() * (p_w - p_w_c);
  }
  Eigen::Matrix3d R_w_c;
  Eigen::Vector3d p_w_c;
};

Eigen::Vector3d normalOf(const LineObservation& o) {
  return o.start_bearing.cross(o.end_bearing).normalized();
}

// Index of the world point or segment for an exact observation; -1 where none fits.
int findPoint(const Scene& s, double t, const PointObservation& o) {
  constexpr double kSame = 1e-9;  // [rad]
  const Camera camera(s, t);
  for (int i = 0; i < static_cast<int>(s.world.points.size()); ++i) {
    const Eigen::Vector3d p_c = camera.see(s.world.points[i]);
    if (p_c.z() > 0.0 && (p_c.normalized() - o.bearing).norm() < kSame) return i;
  }
  return -1;
}

int findSegment(const Scene& s, double t, const LineObservation& o) {
  constexpr double kOnPlane = 1e-9;
  const Camera camera(s, t);
  const Eigen::Vector3d n = normalOf(o);
  for (int i = 0; i < static_cast<int>(s.world.segments.size()); ++i) {
    const Eigen::Vector3d a = camera.see(s.world.segments[i].start).normalized();
    const Eigen::Vector3d b = camera.see(s.world.segments[i].end).normalized();
    if (std::abs(n.dot(a)) < kOnPlane && std::abs(n.dot(b)) < kOnPlane) return i;
  }
  return -1;
}

// Equal to the last bit: the points, or the lines, of all frames.
template <typename List>
void expectSame(const std::vector<FrameObservation>& a, const std::vector<FrameObservation>& b,
                List FrameObservation::*list) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].t, b[k].t);
    ASSERT_TRUE(sameObservations(a[k].*list, b[k].*list)) << k;
  }
}

TEST(FeatureStreams, EqualSeedsGiveEqualBytesOfIndependentStreams) {
  const Scene s = scene("circle", "room");
  FeatureSimulationOptions options;
  options.drift = 0.04;
  options.outlier_rate = 0.1;
  FeatureSimulationOptions points_only = options, lines_only = options, other_seed = options;
  points_only.max_lines = lines_only.max_points = 0;
  other_seed.seed = 2;
  const auto frames = s.run(options), points = s.run(points_only), lines = s.run(lines_only);
  const auto other = s.run(other_seed, 2);
  EXPECT_NE(frames[0].points[0].pixel, other[0].points[0].pixel);
  EXPECT_NE(frames[0].lines[0].start_pixel, other[0].lines[0].start_pixel);
  expectSame(frames, points, &FrameObservation::points);
  expectSame(frames, lines, &FrameObservation::lines);
  for (const FrameObservation& f : points) ASSERT_TRUE(f.lines.empty());
  for (const FrameObservation& f : lines) ASSERT_TRUE(f.points.empty());
}

TEST(FeatureProjection, NoiseFreeObservationsAreProjectionsOfOneVisiblePoint) {
  const Scene s = scene("figure-eight", "room");
  const auto frames = s.run(noiseFree(), 120);
  const PinholeCamera camera;
  std::map<FeatureId, int> point_of;
  for (std::size_t k = 0; k < frames.size(); k += 7) {
    const double t = frames[k].t;
    ASSERT_GT(frames[k].points.size(), 50U);
    for (const PointObservation& o : frames[k].points) {
      const int i = findPoint(s, t, o);
      ASSERT_GE(i, 0) << "no world point at this bearing";
      ASSERT_EQ(point_of.emplace(o.id, i).first->second, i) << "id changed its point";
      EXPECT_TRUE(s.world.visible(Camera(s, t).p_w_c, s.world.points[i]));
      const Eigen::Vector3d p_c = Camera(s, t).see(s.world.points[i]);
      EXPECT_GT(p_c.z(), 0.2);
      EXPECT_NEAR(o.pixel.x(), camera.fx * p_c.x() / p_c.z() + camera.cx, 1e-9);
      EXPECT_NEAR(o.pixel.y(), camera.fy * p_c.y() / p_c.z() + camera.cy, 1e-9);
      EXPECT_GE(o.pixel.minCoeff(), 5.0);
      EXPECT_LE(o.pixel.x(), camera.width - 5.0);
      EXPECT_LE(o.pixel.y(), camera.height - 5.0);
      EXPECT_NEAR(o.bearing.norm(), 1.0, 1e-12);
    }
  }
}

TEST(FeatureProjection, NoiseFreeLinesLieOnTheirSegmentAndInTheImage) {
  const Scene s = scene("figure-eight", "room");
  FeatureSimulationCounts counts;
  const auto frames = s.run(noiseFree(), 300, &counts);
  const PinholeCamera camera;
  std::map<FeatureId, int> segment_of;
  int lines = 0;
  for (const FrameObservation& frame : frames) {
    for (const LineObservation& o : frame.lines) {
      ++lines;
      const int i = findSegment(s, frame.t, o);
      ASSERT_GE(i, 0);
      ASSERT_EQ(segment_of.emplace(o.id, i).first->second, i);
      for (const Eigen::Vector2d& pixel : {o.start_pixel, o.end_pixel}) {
        EXPECT_GE(pixel.minCoeff(), -1e-6);
        EXPECT_LE(pixel.x(), camera.width + 1e-6);
        EXPECT_LE(pixel.y(), camera.height + 1e-6);
      }
      EXPECT_GE(o.length_px, 25.0);
      EXPECT_NEAR(o.length_px, (o.end_pixel - o.start_pixel).norm(), 1e-9);
      EXPECT_NEAR(o.start_bearing.norm(), 1.0, 1e-12);
      // The end points keep their order along the segment.
      const Eigen::Vector3d a = Camera(s, frame.t).see(s.world.segments[i].start);
      const Eigen::Vector3d b = Camera(s, frame.t).see(s.world.segments[i].end);
      EXPECT_GT(a.cross(b).dot(o.start_bearing.cross(o.end_bearing)), 0.0);
    }
  }
  EXPECT_GT(lines, 1000);
}

// A camera at the origin, a box of 1 m before it at 3 m, points and a segment at 6 m.
Scene boxScene() {
  Scene s;
  s.calibration.t_b_c.setZero();
  s.trajectory = standing();
  s.world.hull = {Eigen::Vector3d::Constant(-10.0), Eigen::Vector3d::Constant(10.0)};
  s.world.obstacles = {{Eigen::Vector3d(3.0, -0.5, -0.5), Eigen::Vector3d(4.0, 0.5, 0.5)}};
  return s;
}

class FeatureOcclusion : public ::testing::Test {
 protected:
  FeatureSimulationOptions options_ = noiseFree();
};
using FeatureTracks = FeatureOcclusion;
using FeatureErrors = FeatureOcclusion;
using LineErrors = FeatureOcclusion;

TEST_F(FeatureOcclusion, WhatIsHiddenIsNotObserved) {
  Scene s = boxScene();
  s.world.segments = {Segment{{6.0, -0.9, 0.0}, {6.0, 0.9, 0.0}}};
  s.world.points = {{6.0, 0.0, 0.0}, {6.0, 2.0, 0.0}, {3.0, 0.1, 0.1}, {6.0, 0.5, -0.3}};
  const auto frames = s.run(noiseFree(), 50);
  for (const FrameObservation& frame : frames) {
    EXPECT_TRUE(frame.lines.empty());
    ASSERT_EQ(frame.points.size(), 2U);
    for (const PointObservation& o : frame.points) {
      const int i = findPoint(s, frame.t, o);
      EXPECT_TRUE(i == 1 || i == 2) << i;
    }
  }
}

TEST_F(FeatureOcclusion, ATrackEndsBehindABoxAndComesBackUnderANewId) {
  Scene s = boxScene();
  s.world.points = {{6.0, 0.0, 0.0}};
  // Sideways past the box at 0.5 m/s: its back face at 4 m hides the point at 6 m while |y| < 1.5.
  s.trajectory = std::make_unique<MadeTrajectory>(0.0, 20.0, [](double t) {
    Kinematics k;
    k.p_w_b = Eigen::Vector3d(0.0, -2.0 + 0.5 * t, 0.0);
    return k;
  });
  options_.track_life = 1e6;
  const auto frames = s.run(options_, 160);
  for (const FrameObservation& frame : frames) {
    const double y = -2.0 + 0.5 * frame.t;
    const bool hidden = std::abs(y) < 1.5;
    if (std::abs(std::abs(y) - 1.5) < 1e-3) continue;  // grazes the edge
    ASSERT_EQ(frame.points.size(), hidden ? 0U : 1U) << y;
    if (hidden) continue;
    EXPECT_EQ(frame.points[0].id, y < 0.0 ? 0 : 1);
  }
}

TEST_F(FeatureOcclusion, OfAHalfHiddenSegmentTheVisibleHalfIsObserved) {
  Scene s = boxScene();
  s.world.segments = {Segment{{6.0, 0.0, 0.0}, {6.0, 4.0, 0.0}}};
  options_.line_slide = 0.0;
  const auto frames = s.run(options_, 20);
  // The front face at 3 m hides y < 1 at 6 m; nine samples stand 0.5 m apart.
  const PinholeCamera camera;
  for (const FrameObservation& frame : frames) {
    ASSERT_EQ(frame.lines.size(), 1U);
    // World y to the left is image x to the left.
    EXPECT_GE((camera.cx - frame.lines[0].start_pixel.x()) / camera.fx * 6.0, 1.0);
    EXPECT_LE((camera.cx - frame.lines[0].start_pixel.x()) / camera.fx * 6.0, 1.5 + 1e-9);
    EXPECT_NEAR((camera.cx - frame.lines[0].end_pixel.x()) / camera.fx * 6.0, 4.0, 1e-9);
  }
}

TEST_F(FeatureOcclusion, ASegmentThroughTheCameraPlaneIsCutInFrontOfIt) {
  Scene s = boxScene();
  s.world.obstacles.clear();
  s.world.segments = {Segment{{-5.0, 0.5, -0.4}, {8.0, 0.5, -0.4}}};  // passes the camera
  options_.line_slide = 0.0;
  for (const FrameObservation& frame : s.run(options_, 5)) {
    ASSERT_EQ(frame.lines.size(), 1U);
    const LineObservation& o = frame.lines[0];
    EXPECT_EQ(findSegment(s, frame.t, o), 0);
    EXPECT_GE(o.start_pixel.minCoeff(), -1e-6);
    EXPECT_LE(o.start_pixel.y(), 480.0 + 1e-6);
    EXPECT_GT(o.length_px, 200.0);
  }
}

TEST_F(FeatureTracks, IdsAreUniqueAscendingAndNeverUsedAgain) {
  const Scene s = scene("circle", "hall");
  FeatureSimulationOptions options;
  options.outlier_rate = 0.1;
  FeatureSimulationCounts counts;
  const auto frames = s.run(options, 400, &counts);
  const auto check = [&](auto list, int tracks) {
    std::set<FeatureId> seen, previous;
    for (const FrameObservation& frame : frames) {
      const std::vector<FeatureId> now = idsOf(frame.*list);
      ASSERT_TRUE(std::is_sorted(now.begin(), now.end()));
      ASSERT_TRUE(std::adjacent_find(now.begin(), now.end()) == now.end()) << "id twice";
      for (const FeatureId id : now) {
        ASSERT_TRUE(seen.insert(id).second || previous.count(id) > 0) << "lost id came back";
      }
      previous = {now.begin(), now.end()};
    }
    EXPECT_EQ(static_cast<int>(seen.size()), tracks);
    EXPECT_EQ(*seen.begin(), 0);
    EXPECT_EQ(*seen.rbegin(), tracks - 1);
  };
  check(&FrameObservation::points, counts.point_tracks);
  check(&FrameObservation::lines, counts.line_tracks);
}

TEST_F(FeatureTracks, NumbersStayBelowTheLimitAndReachIt) {
  const Scene s = scene("circle", "room");
  for (const FrameObservation& frame : s.run(FeatureSimulationOptions())) {
    EXPECT_LE(frame.points.size(), 100U);
    EXPECT_GE(frame.points.size(), 90U);
    EXPECT_LE(frame.lines.size(), 25U);
    EXPECT_GE(frame.lines.size(), 10U);
  }
}

TEST_F(FeatureTracks, NewPointsKeepTheirDistance) {
  const Scene s = scene("figure-eight", "room");
  options_.max_points = 150;
  for (const double distance : {15.0, 30.0}) {
    options_.min_point_distance = distance;
    std::set<FeatureId> seen;
    for (const FrameObservation& frame : s.run(options_)) {
      for (const PointObservation& o : frame.points) {
        if (!seen.insert(o.id).second) continue;
        for (const PointObservation& other : frame.points) {
          if (other.id >= o.id) continue;  // tracked or chosen before
          ASSERT_GE((other.pixel - o.pixel).norm(), distance);
        }
      }
    }
  }
}

TEST_F(FeatureTracks, MeanLifeIsAsAskedFromTheFirstFrameOn) {
  const Scene s = stillScene();
  for (const double life : {1.0, 12.0, 36.0}) {
    FeatureSimulationOptions options = noiseFree();
    options.max_lines = 0;
    options.track_life = life;
    constexpr int kFrames = 1500;
    FeatureSimulationCounts counts;
    const auto frames = s.run(options, kFrames, &counts);
    // Deaths per track and frame; a death shows as a missing id in the next frame.
    const auto deathRate = [&](int from, int to) {
      int deaths = 0, trials = 0;
      for (int k = from; k + 1 < to; ++k) {
        const int tracks = static_cast<int>(frames[k].points.size());
        deaths += tracks - countIn(idSet(frames[k + 1].points), frames[k].points);
        trials += tracks;
      }
      return std::pair<double, int>(static_cast<double>(deaths) / trials, trials);
    };
    for (const auto& range : {std::pair<int, int>{0, 60}, std::pair<int, int>{60, kFrames}}) {
      const auto [rate, trials] = deathRate(range.first, range.second);
      const double expected = 1.0 / life;
      // Five standard deviations of a binomial share.
      EXPECT_NEAR(rate, expected, 5.0 * std::sqrt(expected * (1.0 - expected) / trials) + 1e-12)
          << "life " << life << " frames " << range.first << " to " << range.second;
    }
  }
}

TEST_F(FeatureErrors, PixelNoiseHasTheSigmaGiven) {
  const Scene s = stillScene();
  const auto exact = s.run(options_, 500);
  options_.pixel_noise = 0.6;
  const auto frames = s.run(options_, 500);
  double n = 0.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (std::size_t i = 0; i < frames[k].points.size(); ++i) {
      const Eigen::Vector2d error = frames[k].points[i].pixel - exact[k].points[i].pixel;
      mean += error;
      covariance += error * error.transpose();
      ++n;
    }
  }
  ASSERT_GT(n, 40000.0);
  mean /= n;
  covariance /= n;
  // Five standard deviations of a mean, a variance and a covariance.
  const double tolerance = 5.0 / std::sqrt(n);
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.6 * tolerance);
  EXPECT_NEAR(covariance(0, 0), 0.36, 0.36 * std::sqrt(2.0) * tolerance);
  EXPECT_NEAR(covariance(1, 1), 0.36, 0.36 * std::sqrt(2.0) * tolerance);
  EXPECT_NEAR(covariance(0, 1), 0.0, 0.36 * tolerance);
}

// Steps of every track between neighbouring frames, by id [px].
std::map<FeatureId, std::vector<Eigen::Vector2d>> stepsOf(
    const std::vector<FrameObservation>& frames) {
  std::map<FeatureId, Eigen::Vector2d> last;
  std::map<FeatureId, std::vector<Eigen::Vector2d>> steps;
  for (const FrameObservation& frame : frames) {
    for (const PointObservation& o : frame.points) {
      const auto it = last.find(o.id);
      if (it != last.end()) steps[o.id].push_back(o.pixel - it->second);
      last[o.id] = o.pixel;
    }
  }
  return steps;
}

TEST_F(FeatureErrors, DriftIsARandomWalkFromTheFirstSighting) {
  const Scene s = stillScene();
  options_.drift = 0.04;
  const auto frames = s.run(options_, 500);
  for (const PointObservation& o : frames[0].points) EXPECT_GE(findPoint(s, 0.0, o), 0);
  double sum = 0.0, lagged = 0.0, n = 0.0;
  for (const auto& track : stepsOf(frames)) {
    for (std::size_t k = 0; k < track.second.size(); ++k) {
      sum += track.second[k].squaredNorm();
      if (k > 0) lagged += track.second[k].dot(track.second[k - 1]);
      n += 2.0;
    }
  }
  ASSERT_GT(n, 50000.0);
  EXPECT_NEAR(sum / n, 0.0016, 0.0016 * 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(lagged / n, 0.0, 0.0016 * 5.0 / std::sqrt(n));
}

TEST_F(FeatureErrors, OutliersSlideAtConstantVelocityInTheShareGiven) {
  const Scene s = stillScene();
  options_.outlier_rate = 0.2;
  options_.outlier_speed = 0.8;
  FeatureSimulationCounts counts;
  const auto frames = s.run(options_, 1000, &counts);
  int sliding = 0;
  double squared_speed = 0.0;
  const auto all_steps = stepsOf(frames);
  for (const auto& track : all_steps) {
    const Eigen::Vector2d& first = track.second.front();
    for (const Eigen::Vector2d& step : track.second) ASSERT_LT((step - first).norm(), 1e-9);
    if (first.norm() > 1e-9) {
      ++sliding;
      squared_speed += first.squaredNorm();
    }
  }
  const double n = static_cast<double>(all_steps.size());
  const double five_sigma = 5.0 * std::sqrt(0.2 * 0.8 / n);
  EXPECT_NEAR(sliding / n, 0.2, five_sigma);
  EXPECT_NEAR(static_cast<double>(counts.outlier_tracks) / counts.point_tracks, 0.2, five_sigma);
  EXPECT_NEAR(std::sqrt(squared_speed / (2.0 * sliding)), 0.8, 0.8 * 5.0 / std::sqrt(4 * sliding));
  FeatureSimulationCounts clean;
  s.run(noiseFree(), 100, &clean);
  EXPECT_EQ(clean.outlier_tracks, 0);
}

TEST_F(LineErrors, EndPointsSlideAlongTheLine) {
  Scene s = boxScene();
  s.world.obstacles.clear();
  s.world.segments = {Segment{{6.0, -2.0, 0.5}, {6.0, 2.0, 0.5}}};
  options_.line_slide = 0.25;
  const PinholeCamera c;
  double min_cut = 1.0, max_cut = 0.0, sum = 0.0, product = 0.0;
  const int kFrames = 2000;
  for (const FrameObservation& frame : s.run(options_, kFrames)) {
    ASSERT_EQ(frame.lines.size(), 1U);
    const double start = (c.cx - frame.lines[0].start_pixel.x()) / c.fx * 6.0;  // world y
    const double end = (c.cx - frame.lines[0].end_pixel.x()) / c.fx * 6.0;
    const double cut_start = (start + 2.0) / 4.0;
    const double cut_end = (2.0 - end) / 4.0;
    for (const double cut : {cut_start, cut_end}) {
      min_cut = std::min(min_cut, cut);
      max_cut = std::max(max_cut, cut);
      sum += cut;
    }
    product += (cut_start - 0.125) * (cut_end - 0.125);
  }
  EXPECT_GE(min_cut, -1e-9);
  EXPECT_LT(min_cut, 0.005);
  EXPECT_LE(max_cut, 0.25 + 1e-9);
  EXPECT_GT(max_cut, 0.245);
  const double sigma = 0.25 / std::sqrt(12.0);
  EXPECT_NEAR(sum / (2 * kFrames), 0.125, 5.0 * sigma / std::sqrt(2.0 * kFrames));
  EXPECT_NEAR(product / kFrames, 0.0, 5.0 * sigma * sigma / std::sqrt(1.0 * kFrames));
}

TEST_F(LineErrors, EndPointNoiseHasTheSigmaGiven) {
  const Scene s = stillScene(0);
  const auto exact = s.run(options_, 800);
  options_.line_noise = 0.7;
  const auto frames = s.run(options_, 800);
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double n = 0.0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (std::size_t i = 0; i < frames[k].lines.size(); ++i) {
      const LineObservation& o = frames[k].lines[i];
      squares += (o.start_pixel - exact[k].lines[i].start_pixel).cwiseAbs2();
      squares += (o.end_pixel - exact[k].lines[i].end_pixel).cwiseAbs2();
      n += 2.0;
      ASSERT_NEAR(o.length_px, (o.end_pixel - o.start_pixel).norm(), 1e-12);
    }
  }
  ASSERT_GT(n, 20000.0);
  EXPECT_NEAR(squares.x() / n, 0.49, 0.49 * 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(squares.y() / n, 0.49, 0.49 * 5.0 * std::sqrt(2.0 / n));
}

TEST_F(LineErrors, ConfidenceGrowsWithLength) {
  const Scene s = scene("circle", "room");
  double sum[2] = {}, count[2] = {};  // of short and of long lines
  for (const FrameObservation& frame : s.run(FeatureSimulationOptions())) {
    for (const LineObservation& o : frame.lines) {
      ASSERT_GE(o.detection_confidence, 0.0);
      ASSERT_LE(o.detection_confidence, 1.0);
      ASSERT_GE(o.match_quality, 0.0);
      ASSERT_LE(o.match_quality, 1.0);
      if (o.length_px >= 60.0 && o.length_px <= 150.0) continue;
      const int which = o.length_px > 150.0 ? 1 : 0;
      sum[which] += o.detection_confidence;
      ++count[which];
    }
  }
  ASSERT_GT(count[0], 50);
  ASSERT_GT(count[1], 50);
  EXPECT_GT(sum[1] / count[1], sum[0] / count[0] + 0.2);
}

TEST(FeatureStreams, EmptyInputGivesEmptyFrames) {
  Scene s = stillScene();
  s.world = World();
  const auto frames = s.run(FeatureSimulationOptions(), 3);
  ASSERT_EQ(frames.size(), 3U);
  for (const FrameObservation& frame : frames) {
    EXPECT_TRUE(frame.points.empty());
    EXPECT_TRUE(frame.lines.empty());
  }
  EXPECT_TRUE(s.run(FeatureSimulationOptions(), 0).empty());
}

/// A motion that turns and moves fast, seen row by row.
Scene rollingScene(double readout_s) {
  Scene s = scene("figure-eight", "room");
  s.calibration.readout_s = readout_s;
  s.calibration.td = 0.007;
  return s;
}

// Bearing and row belong to the pixel with its noise.
TEST(RollingShutter, NoisyObservationsAreOfTheirNoisyPixel) {
  const PinholeCamera c;
  for (const FrameObservation& frame : rollingScene(0.02).run(FeatureSimulationOptions(), 10)) {
    expectOwnRows(frame, c.height);
    ASSERT_FALSE(frame.points.empty());
    for (const PointObservation& o : frame.points) {
      EXPECT_NEAR(c.fx * o.bearing.x() / o.bearing.z() + c.cx, o.pixel.x(), 1e-9);
      EXPECT_NEAR(c.fy * o.bearing.y() / o.bearing.z() + c.cy, o.pixel.y(), 1e-9);
    }
  }
}

// The point is where the camera sees it at the time of the row that it is seen in.
TEST(RollingShutter, PointsAreSeenAtTheTimeOfTheirRow) {
  const Scene s = rollingScene(0.033);
  const FeatureSimulationOptions options = noiseFree();
  int observations = 0;
  double latest = 0.0, largest_shift = 0.0;
  for (const FrameObservation& frame : s.run(options, 60)) {
    expectOwnRows(frame, options.camera.height);
    for (const PointObservation& o : frame.points) {
      ++observations;
      const double dt = 0.033 * o.row;
      latest = std::max(latest, std::abs(dt));
      const Camera then(s, frame.t + 0.007 + dt), middle(s, frame.t + 0.007);
      double nearest = 1.0, shift = 0.0;
      for (const Eigen::Vector3d& p_w : s.world.points) {
        const double off = (then.see(p_w).normalized() - o.bearing).norm();
        if (off >= nearest) continue;
        nearest = off;
        shift = (middle.see(p_w).normalized() - o.bearing).norm();
      }
      // 1e-9 s at less than 10 rad/s.
      EXPECT_LT(nearest, 1e-8);
      largest_shift = std::max(largest_shift, shift);
    }
  }
  EXPECT_GT(observations, 3000);
  EXPECT_GT(latest, 0.9 * 0.5 * 0.033);
  EXPECT_GT(largest_shift, 0.01);  // many pixels: a global shutter is no approximation
}

// Both ends of a line lie on a segment of the world, each at the time of its own row.
TEST(RollingShutter, LineEndsAreSeenAtTheTimeOfTheirRows) {
  const Scene s = rollingScene(0.033);
  const FeatureSimulationOptions options = noiseFree();
  int observations = 0;
  double different = 0.0;
  for (const FrameObservation& frame : s.run(options, 40)) {
    expectOwnRows(frame, options.camera.height);
    for (const LineObservation& o : frame.lines) {
      ++observations;
      for (const double v : {o.start_pixel.y(), o.end_pixel.y()}) {
        EXPECT_TRUE(v >= 0.0 && v <= options.camera.height) << v;
      }
      different = std::max(different, 0.033 * std::abs(o.start_row - o.end_row));
      const Camera start(s, frame.t + 0.007 + 0.033 * o.start_row),
          end(s, frame.t + 0.007 + 0.033 * o.end_row);
      double nearest = 1.0;
      for (const Segment& segment : s.world.segments) {
        // Sine between the ray and the plane through the segment.
        const auto offPlane = [&](const Camera& camera, const Eigen::Vector3d& bearing) {
          const Eigen::Vector3d normal =
              camera.see(segment.start).cross(camera.see(segment.end)).normalized();
          return std::abs(normal.dot(bearing));
        };
        nearest = std::min(
            nearest, std::max(offPlane(start, o.start_bearing), offPlane(end, o.end_bearing)));
      }
      EXPECT_LT(nearest, 1e-8);
    }
  }
  EXPECT_GT(observations, 500);
  EXPECT_GT(different, 0.005);
}

}  // namespace
}  // namespace slim_init::simulation
