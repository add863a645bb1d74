// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Ids of vanishing points through a window, and their gate.
#include <gtest/gtest.h>

#include "lines/line_scene.h"
#include "lines/vanishing_point.h"

namespace slim_init {
namespace {

using test::axisAngle;
using test::kRadPerDeg;

constexpr int kMiss = -1;

// A window in which keyframe k sees axis `seen[k]` of `axes_c0` (kMiss: nothing but two lines)
// under the true rotations R_c0_ck.
std::shared_ptr<const InitWindow> windowOfAxes(const std::vector<Eigen::Vector3d>& axes_c0,
                                               const std::vector<int>& seen,
                                               const std::vector<Eigen::Matrix3d>& R_c0_ck) {
  std::mt19937 random(21);
  std::vector<FrameObservation> keyframes;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const Eigen::Vector3d axis_ck =
        R_c0_ck[k].transpose() * axes_c0[static_cast<std::size_t>(std::max(0, seen[k]))];
    const auto lines = test::linesToward(axis_ck, seen[k] == kMiss ? 2 : 12, random);
    keyframes.push_back(test::frameOf(0.25 * static_cast<double>(k), lines));
  }
  return test::windowOf(keyframes);
}

std::vector<Eigen::Matrix3d> turning(const Eigen::Vector3d& axis, double step_deg, int count) {
  std::vector<Eigen::Matrix3d> R_c0_ck;
  for (int k = 0; k < count; ++k) {
    R_c0_ck.push_back(
        Eigen::AngleAxisd(k * step_deg * kRadPerDeg, axis.normalized()).toRotationMatrix());
  }
  return R_c0_ck;
}

std::vector<int> ids(const std::vector<VanishingPoint>& vps) {
  std::vector<int> values;
  for (const VanishingPoint& vp : vps) values.push_back(vp.track_id);
  return values;
}

std::vector<int> ages(const std::vector<VanishingPoint>& vps) {
  std::vector<int> values;
  for (const VanishingPoint& vp : vps) values.push_back(vp.age);
  return values;
}

const std::vector<Eigen::Vector3d> kAxes = {Eigen::Vector3d(0.1, -0.05, 1.0).normalized(),
                                            Eigen::Vector3d(0.02, 1.0, 0.05).normalized(),
                                            Eigen::Vector3d(1.0, -0.02, -0.1).normalized()};

TEST(VanishingPointTrack, KeepsItsIdThroughLargeRotationsAndTheFlipOfSign) {
  const std::vector<int> seen(12, 0);
  const auto R_c0_ck = turning(Eigen::Vector3d(0.1, 1.0, 0.2), 30.0, 12);
  const auto window = windowOfAxes(kAxes, seen, R_c0_ck);
  const auto vps = trackVanishingPoints(*window, R_c0_ck, {});
  ASSERT_EQ(vps.size(), seen.size());
  int flips = 0;
  for (std::size_t k = 0; k < vps.size(); ++k) {
    ASSERT_TRUE(vps[k].found);
    EXPECT_LT(axisAngle(R_c0_ck[k] * vps[k].direction, kAxes[0]), 1e-12);
    EXPECT_EQ(vps[k].track_id, 0);
    EXPECT_EQ(vps[k].age, static_cast<int>(k) + 1);
    if (k > 0 && (R_c0_ck[k] * vps[k].direction).dot(R_c0_ck[k - 1] * vps[k - 1].direction) < 0) {
      ++flips;
    }
  }
  EXPECT_EQ(flips, 2) << "a turn of 330 deg takes the axis through z = 0 twice";
}

TEST(VanishingPointTrack, WrongSenseOfRotationLosesTheId) {
  const std::vector<int> seen(4, 0);
  const auto R_c0_ck = turning(Eigen::Vector3d::UnitY(), 10.0, 4);
  const auto window = windowOfAxes(kAxes, seen, R_c0_ck);
  auto R_ck_c0 = R_c0_ck;
  for (Eigen::Matrix3d& R : R_ck_c0) R.transposeInPlace();
  EXPECT_EQ(ids(trackVanishingPoints(*window, R_c0_ck, {})), (std::vector<int>{0, 0, 0, 0}));
  EXPECT_EQ(ids(trackVanishingPoints(*window, R_ck_c0, {})), (std::vector<int>{0, 1, 2, 3}));
}

// After a miss and after other axes it comes back with its id; a miss at the start is no axis.
TEST(VanishingPointTrack, IdsAndAgesOfWhatIsSeen) {
  struct Case {
    std::vector<int> seen, ids, ages;
  };
  const Case cases[] = {
      {{0, 0, kMiss, 0, 0}, {0, 0, -1, 0, 0}, {1, 2, 0, 1, 2}},
      {{kMiss, 1, 1}, {-1, 0, 0}, {0, 1, 2}},
      {{1, 1, 0, 0, 1, 2, 0, 2}, {0, 0, 1, 1, 0, 2, 1, 2}, {1, 2, 1, 2, 1, 1, 1, 1}},
  };
  for (const Case& one : cases) {
    const auto R_c0_ck =
        turning(Eigen::Vector3d(0.2, 1.0, -0.3), 30.0, static_cast<int>(one.seen.size()));
    const auto vps = trackVanishingPoints(*windowOfAxes(kAxes, one.seen, R_c0_ck), R_c0_ck, {});
    EXPECT_EQ(ids(vps), one.ids);
    EXPECT_EQ(ages(vps), one.ages);
  }
}

TEST(VanishingPointTrack, MatchThresholdHasTwoSides) {
  const std::vector<int> seen(2, 0);
  const std::vector<Eigen::Matrix3d> R_c0_ck(2, Eigen::Matrix3d::Identity());
  const auto window = windowOfAxes({Eigen::Vector3d::UnitZ()}, seen, R_c0_ck);
  VanishingPointOptions options;
  options.match_threshold_deg = 6.0;
  for (const double sign : {1.0, -1.0}) {
    const auto inside = turning(Eigen::Vector3d::UnitY(), sign * 5.99, 2);
    const auto outside = turning(Eigen::Vector3d::UnitY(), sign * 6.01, 2);
    EXPECT_EQ(ids(trackVanishingPoints(*window, inside, options)), (std::vector<int>{0, 0}));
    EXPECT_EQ(ids(trackVanishingPoints(*window, outside, options)), (std::vector<int>{0, 1}));
  }
}

// A gyro bias makes the predicted rotation drift by 4 deg per keyframe, 36 deg over the window.
TEST(VanishingPointTrack, MemoryFollowsTheDriftOfTheGyro) {
  const std::vector<int> seen(10, 0);
  const auto R_c0_ck = turning(Eigen::Vector3d::UnitY(), 20.0, 10);
  const auto drifting = turning(Eigen::Vector3d::UnitY(), 24.0, 10);
  const auto vps = trackVanishingPoints(*windowOfAxes(kAxes, seen, R_c0_ck), drifting, {});
  EXPECT_EQ(ids(vps), std::vector<int>(10, 0));
  EXPECT_EQ(vps.back().age, 10);

  // After a miss of one keyframe the drift of two counts, 8 deg: the axis cannot be told.
  const std::vector<int> seen_with_miss = {0, kMiss, 0, 0};
  const auto vps_with_miss = trackVanishingPoints(*windowOfAxes(kAxes, seen_with_miss, R_c0_ck),
                                                  {drifting.begin(), drifting.begin() + 4}, {});
  EXPECT_EQ(ids(vps_with_miss), (std::vector<int>{0, -1, 1, 1}));
}

TEST(VanishingPointTrack, OfTwoAxesTheNearerOne) {
  // 11 deg apart, both within 6 deg of the last observation.
  const auto tilted = [](double angle_deg) {
    return Eigen::Vector3d(Eigen::AngleAxisd(angle_deg * kRadPerDeg, Eigen::Vector3d::UnitY()) *
                           Eigen::Vector3d::UnitZ());
  };
  const std::vector<Eigen::Matrix3d> R_c0_ck(4, Eigen::Matrix3d::Identity());
  for (const auto& [angle_deg, id] : {std::make_pair(5.2, 0), std::make_pair(5.8, 1)}) {
    const std::vector<Eigen::Vector3d> axes = {tilted(0.0), tilted(11.0), tilted(angle_deg)};
    const auto vps =
        trackVanishingPoints(*windowOfAxes(axes, {0, 1, kMiss, 2}, R_c0_ck), R_c0_ck, {});
    EXPECT_EQ(ids(vps), (std::vector<int>{0, 1, -1, id}));
    EXPECT_EQ(ages(vps), (std::vector<int>{1, 1, 0, 1}));
    const auto direct = trackVanishingPoints(*windowOfAxes(axes, {0, 1, 2}, R_c0_ck),
                                             {R_c0_ck.begin(), R_c0_ck.begin() + 3}, {});
    EXPECT_EQ(ids(direct), (std::vector<int>{0, 1, id}));
    EXPECT_EQ(ages(direct), (std::vector<int>{1, 1, 1 + id}));
  }
}

TEST(VanishingPointTrack, NoiseOfTheCalibrationScalesTheCovariance) {
  const std::vector<Eigen::Matrix3d> R_c0_ck(2, Eigen::Matrix3d::Identity());
  const auto window = windowOfAxes(kAxes, {0, 0}, R_c0_ck);
  const auto vps = trackVanishingPoints(*window, R_c0_ck, {});
  const Calibration& calibration = window->calibration();
  const VanishingPoint alone =
      estimateVanishingPoint(window->linesOfKeyframe(0), calibration.sigmaLine(), {});
  ASSERT_TRUE(alone.found);
  EXPECT_EQ(vps[0].covariance, alone.covariance);
  EXPECT_EQ(vps[0].inliers, alone.inliers);
}

TEST(VanishingPointTrack, WrongNumberOfRotationsFindsNothing) {
  const std::vector<Eigen::Matrix3d> R_c0_ck(3, Eigen::Matrix3d::Identity());
  const auto window = windowOfAxes(kAxes, {0, 0, 0}, R_c0_ck);
  const auto vps = trackVanishingPoints(*window, {Eigen::Matrix3d::Identity()}, {});
  ASSERT_EQ(vps.size(), 3U);
  for (const VanishingPoint& vp : vps) {
    EXPECT_FALSE(vp.found);
    EXPECT_EQ(vp.track_id, -1);
  }
}

}  // namespace
}  // namespace slim_init
