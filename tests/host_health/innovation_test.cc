// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The innovation test of a frame: each culprit, from both sides, and how often a healthy host is
// accused.
#include "slim_init/host_health/innovation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/so3.h"
#include "host_health/flight.h"
#include "pose_residual.h"
#include "slim_init/evaluation/recorded.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/simulation/world.h"
#include "support/exact_window.h"
#include "support/gaussian.h"
#include "support/jacobian_check.h"
#include "support/text_parts.h"

namespace slim_init::host_health {
namespace {

// Observations that belong to a texture and that do not, and how many of each are kept out.
struct KeptOut {
  int seen = 0, kept_out = 0, scene = 0, wronged = 0;
  void add(const FrameObservation& frame, const std::set<FeatureId>& texture,
           const std::vector<FeatureId>& moving) {
    for (const PointObservation& point : frame.points) {
      const bool moves = texture.count(point.id) > 0;
      const int found = std::binary_search(moving.begin(), moving.end(), point.id) ? 1 : 0;
      ++(moves ? seen : scene);
      (moves ? kept_out : wronged) += found;
    }
  }
};

std::string named(double px, Motion motion) {
  return std::to_string(px) + " px, motion " + std::to_string(static_cast<int>(motion));
}

void expectTheImuIsNotBlamed(int k, const Innovation& result) {
  EXPECT_NE(result.culprit, Culprit::kImu) << k << ": " << result.message;
  EXPECT_NE(result.culprit, Culprit::kUnclear) << k << ": " << result.message;
}

// A flight, with what is done to it.
struct Flight {
  explicit Flight(const ExactWindow& exact)
      : calibration(exact.calibration),
        states(exact.truth),
        truth(exact.truth),
        frames(exact.keyframes),
        imu(exact.imu.begin(), exact.imu.end()) {
    for (std::size_t k = 0; k < frames.size(); ++k) frames[k].t = truth[k].t;
  }
  void disturb(double first, double last, const std::function<void(ImuSample*)>& change) {
    for (ImuSample& sample : imu) {
      if (sample.t >= first && sample.t < last) change(&sample);
    }
  }
  // Adds a force [m/s^2] to the samples of the interval before a frame.
  void pushInterval(int newest, double by) {
    disturb(truth[static_cast<std::size_t>(newest) - 1].t,
            truth[static_cast<std::size_t>(newest)].t,
            [by](ImuSample* sample) { sample->accel.x() += by; });
  }
  // Keeps the points of frame `k` that `keep` names.
  template <typename Keep>
  void thin(std::size_t k, const Keep& keep) {
    std::vector<PointObservation>& points = frames[k].points;
    points.erase(std::remove_if(points.begin(), points.end(),
                                [&](const auto& point) { return !keep(point.id); }),
                 points.end());
  }
  // From frame `begin` on the given part of the tracks moves by (px, px/2) per frame; returns them.
  std::set<FeatureId> moveTexture(int begin, double part, double px) {
    std::set<FeatureId> moving;
    for (std::size_t k = static_cast<std::size_t>(begin); k < frames.size(); ++k) {
      const double shift = px * static_cast<double>(k + 1 - static_cast<std::size_t>(begin));
      for (PointObservation& point : frames[k].points) {
        if (static_cast<double>(point.id * 37 % 100) >= 100.0 * part) continue;
        moving.insert(point.id);
        Eigen::Vector3d image = point.bearing / point.bearing.z();
        image.head<2>() += Eigen::Vector2d(shift, 0.5 * shift) / calibration.focal_px;
        point.bearing = image.normalized();
      }
    }
    return moving;
  }
  // From frame `begin` on a texture that moves by (px, px/2) per frame hides the given part of the
  // view, so that all of its tracks are new. A tracker that takes it for the scene rejects the
  // `others`: they live for two frames. Returns the tracks of the texture, which live for `life`.
  enum class Others { kRejected, kTracked };
  std::set<FeatureId> coverWithTexture(int begin, double part, double px, int life = 1000,
                                       Others others = Others::kRejected) {
    constexpr FeatureId kTexture = 10000, kShortLived = 2000000;
    std::set<FeatureId> moving;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> inside(-0.5, 0.5);
    std::normal_distribution<double> noise(0.0, kNoisePx / calibration.focal_px);
    std::vector<Eigen::Vector2d> texture;
    for (std::size_t k = static_cast<std::size_t>(begin); k < frames.size(); ++k) {
      const auto age = static_cast<FeatureId>(k) - begin;
      std::vector<PointObservation> points;
      for (PointObservation point : frames[k].points) {
        if (static_cast<double>(point.id * 37 % 100) < 100.0 * part) continue;
        if (others == Others::kRejected) point.id += kShortLived * (1 + age / 2);
        points.push_back(point);
      }
      const std::size_t hidden = frames[k].points.size() - points.size();
      const double shift = px * static_cast<double>(age) / calibration.focal_px;
      while (texture.size() < hidden) texture.emplace_back(inside(random), inside(random));
      for (std::size_t i = 0; i < hidden; ++i) {
        PointObservation point;
        point.id = kTexture * (1 + age / life) + static_cast<FeatureId>(i);
        point.bearing << texture[i].x() + shift + noise(random),
            texture[i].y() + 0.5 * shift + noise(random), 1.0;
        point.bearing.normalize();
        points.push_back(point);
        moving.insert(point.id);
      }
      frames[k].points = std::move(points);
    }
    return moving;
  }
  PropagatedState predicted(int newest) const {
    PropagatedState from, result;
    from.state = states[static_cast<std::size_t>(newest) - 1];
    from.covariance = healthyCovariance();
    std::string error;
    EXPECT_TRUE(propagateState(from, truth[static_cast<std::size_t>(newest)].t, imu, damage,
                               Eigen::Vector3d(0, 0, -calibration.gravity_magnitude),
                               calibration.imu_noise, &result, &error))
        << error;
    return result;
  }
  std::vector<NavState> optimized(int newest) const {
    return {states.begin() + std::max(0, newest - kHostFrames + 1), states.begin() + newest};
  }
  Innovation at(int newest, const TrackTrust& trust = {}) const {
    return innovationOf({optimized(newest), predicted(newest), frames, calibration}, trust);
  }
  // Through a monitor, from frame 11 on.
  std::map<int, Innovation> watch() const {
    InnovationMonitor monitor;
    std::map<int, Innovation> result;
    for (int k = kHostFrames; k < static_cast<int>(frames.size()); ++k) {
      result[k] = judged(k, &monitor);
    }
    return result;
  }
  Innovation judged(int newest, InnovationMonitor* monitor) const {
    return monitor->judge({optimized(newest), predicted(newest), frames, calibration});
  }

  Calibration calibration;
  std::vector<NavState> states;  // of the host
  std::vector<NavState> truth;
  std::vector<FrameObservation> frames;
  std::deque<ImuSample> imu;
  std::deque<ImuDamage> damage;
};

TEST(TrackPlace, ExactViewsGiveTheExactPlace) {
  const Flight flight(flightOf(Motion::kExcited, 0.0));
  std::vector<CameraPose> cameras;
  for (const NavState& state : flight.truth) cameras.push_back(cameraOf(state, flight.calibration));
  std::map<FeatureId, std::vector<TrackView>> views;
  for (std::size_t k = 0; k < 20; ++k) {
    for (const PointObservation& point : flight.frames[k].points) {
      views[point.id].push_back({&cameras[k], point.bearing});
    }
  }
  int checked = 0;
  for (const auto& [id, seen] : views) {
    TrackPlace place;
    // A hundredth of a pixel: the prior of the inverse depth does not matter.
    if (seen.size() < 10 || !findPlace(seen, 2e-5, 0.0, &place)) continue;
    EXPECT_LT(place.chi_square, 1e-3) << id;
    EXPECT_EQ(place.dof, 2 * static_cast<int>(seen.size()) - 3);
    ++checked;
  }
  EXPECT_GT(checked, 50);
  TrackPlace place;
  EXPECT_FALSE(findPlace({views.begin()->second.front()}, 1e-3, 0.0, &place));
}

// Over draws of the noise, the inverse depth has the reported variance, with much parallax and
// with little.
TEST(TrackPlace, CovarianceFits) {
  Gaussian normal(3);
  const double sigma = 1e-3;
  for (const double baseline : {1.0, 0.1}) {
    std::vector<CameraPose> cameras(6);
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      cameras[i].p_w_c = Eigen::Vector3d(0.2 * baseline * static_cast<double>(i), 0, 0);
    }
    const Eigen::Vector3d point(0.5, 0.3, 3.0);
    const int draws = 400;
    double square = 0.0, chi_square = 0.0;
    for (int k = 0; k < draws; ++k) {
      std::vector<TrackView> views;
      for (const CameraPose& camera : cameras) {
        const Eigen::Vector3d exact = (point - camera.p_w_c).normalized();
        const Eigen::Vector2d noise = sigma * Eigen::Vector2d{normal(), normal()};
        views.push_back({&camera, (exact + tangentOf(exact) * noise).normalized()});
      }
      TrackPlace place;
      ASSERT_TRUE(findPlace(views, sigma, 0.0, &place));
      const double exact = 1.0 / (point - cameras.back().p_w_c).norm();
      square += std::pow(place.inverse_depth - exact, 2) / place.covariance(2, 2) / draws;
      chi_square += place.chi_square / place.dof / draws;
    }
    // Their standard deviations are 0.07 and 0.02.
    EXPECT_NEAR(square, 1.0, 0.25) << baseline;
    EXPECT_NEAR(chi_square, 1.0, 0.1) << baseline;
  }
}

TEST(Innovation, ResidualHasTheRightJacobian) {
  const Flight flight(flightOf(Motion::kExcited, 0.0));
  std::vector<CameraPose> cameras;
  for (int k = 0; k < 10; ++k) cameras.push_back(cameraOf(flight.truth[k], flight.calibration));
  int checked = 0;
  for (const PointObservation& seen : flight.frames[10].points) {
    std::vector<TrackView> views;
    for (std::size_t k = 0; k < 10; ++k) {
      for (const PointObservation& point : flight.frames[k].points) {
        if (point.id == seen.id) views.push_back({&cameras[k], point.bearing});
      }
    }
    PoseTrack track;
    track.bearing = seen.bearing;
    track.basis = tangentOf(seen.bearing);
    if (!findPlace(views, 1e-3, 0.0, &track.place)) continue;
    // Away from the truth, so that the residual is not zero.
    NavState pose = flight.truth[10];
    pose.p_w_b += Eigen::Vector3d(0.1, -0.05, 0.02);
    pose.R_w_b = expSO3(Eigen::Vector3d(0.02, 0.05, -0.03)) * pose.R_w_b;
    const auto residualAt = [&](const NavState& at, PoseResidual* result) {
      return poseResidual(track, cameraOf(at, flight.calibration), 1e-3, result);
    };
    const auto residual = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      NavState moved = pose;
      moved.R_w_b = expSO3(d.head<3>()) * pose.R_w_b;
      moved.p_w_b += d.tail<3>();
      PoseResidual result;
      EXPECT_TRUE(residualAt(moved, &result));
      return result.r;
    };
    PoseResidual analytic;
    ASSERT_TRUE(residualAt(pose, &analytic));
    EXPECT_TRUE(jacobiansAgree(analytic.J, numericJacobian(residual, 6, 1e-5), 1e-7)) << seen.id;
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST(Innovation, ExactDataAgreeExactly) {
  const Flight flight(flightOf(Motion::kExcited, 0.0));
  for (int k = kHostFrames; k < 40; k += 4) {
    const Innovation result = flight.at(k);
    EXPECT_EQ(result.culprit, Culprit::kNone) << result.message;
    EXPECT_EQ(result.agree_imu, 1.0);
    EXPECT_EQ(result.agree_images, 1.0);
    EXPECT_LT((result.images.p_w_b - flight.truth[k].p_w_b).norm(), 1e-4) << k;
    EXPECT_LT((result.images.R_w_b - flight.truth[k].R_w_b).norm(), 1e-5) << k;
    EXPECT_TRUE(result.moving.empty());
    EXPECT_EQ(result.accel_sigma, 0.0);
    EXPECT_EQ(result.gyro_sigma, 0.0);
  }
}

// Error over standard deviation of the pose of the images.
TEST(Innovation, CovarianceFits) {
  double square = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
    for (int k = kHostFrames; k < 40; k += 7) {
      const Innovation result = flight.at(k);
      const Eigen::AngleAxisd turn(result.images.R_w_b * flight.truth[k].R_w_b.transpose());
      Eigen::Matrix<double, 6, 1> d;
      d << turn.angle() * turn.axis(), result.images.p_w_b - flight.truth[k].p_w_b;
      square += d.dot(result.covariance.ldlt().solve(d));
      ++count;
    }
  }
  const double ratio = std::sqrt(square / (6.0 * count));
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.5);
}

struct DamageCase {
  const char* name;
  double seconds;
  std::function<void(ImuSample*)> change;
  double accel, gyro;  // [m/s^2, rad/s]
  int intervals = 1;   // all over damaged, until it is found
};

std::vector<DamageCase> damageCases() {
  const auto push = [](double accel, double gyro) {
    return [accel, gyro](ImuSample* sample) {
      sample->accel.x() += accel;
      sample->gyro.y() += gyro;
    };
  };
  return {
      {"+15 m/s^2", 0.5, push(15, 0), 15, 0},
      {"+60 m/s^2", 0.05, push(60, 0), 60, 0},
      {"+100 m/s^2", 0.025, push(100, 0), 100, 0},
      {"+1000 m/s^2", 0.025, push(1000, 0), 1000, 0},
      {"120 m/s^2", 0.3, push(120, 0), 120, 0},
      {"+3 rad/s", 0.2, push(0, 3), 0, 3},
      {"both", 0.3, push(20, 2), 20, 2},
      {"saturation", 0.5,
       [](ImuSample* sample) { sample->accel = sample->accel.cwiseMin(5.0).cwiseMax(-5.0); }, 5, 0,
       2},
      {"zeros", 0.5,
       [](ImuSample* sample) { sample->accel = sample->gyro = Eigen::Vector3d::Zero(); }, 9.8, 0}};
}

// Without the screen, which finds many of these already: in the first frame whose interval is
// damaged all over (5 m/s^2: in the second), in every other one, and not for long after it.
TEST(Innovation, EachKindOfDamageIsFound) {
  for (const DamageCase& one : damageCases()) {
    for (const double offset : {0.0, 0.03, 0.06}) {
      SCOPED_TRACE(std::string(one.name) + " at " + std::to_string(offset));
      Flight flight(flightOf(Motion::kExcited, kNoisePx));
      const double first = flight.truth[20].t + offset, last = first + one.seconds;
      flight.disturb(first, last, one.change);
      for (const auto& [k, result] : flight.watch()) {
        const double begin = flight.truth[k - 1].t, end = flight.truth[k].t;
        const double damaged = std::min(end, last) - std::max(begin, first);
        const bool all = damaged > 0.75 * (end - begin) || damaged > 0.99 * one.seconds;
        const bool long_enough = begin > first + (one.intervals - 1.25) * (end - begin);
        if (all && long_enough) {
          EXPECT_EQ(result.culprit, Culprit::kImu) << k << ": " << result.message;
          EXPECT_LE(result.damaged_since, begin + 1e-9);
          EXPECT_LT((result.images.p_w_b - flight.truth[k].p_w_b).norm(), 0.03) << k;
          // Of the effect on the velocity of the interval.
          EXPECT_GT(result.accel_sigma * (end - begin), 0.4 * one.accel * damaged) << k;
          EXPECT_GT(result.gyro_sigma * (end - begin), 0.7 * one.gyro * damaged) << k;
          expectParts(result.message, "the IMU data are inconsistent");
          // A limit is named if it is exceeded.
          EXPECT_EQ(result.message.find("in two frames in a row") != std::string::npos,
                    result.mahalanobis < 5.8)
              << result.message;
          EXPECT_EQ(result.message.find("with the IMU") != std::string::npos,
                    result.agree_imu < 0.25)
              << result.message;
        }
        if (end < first || begin > last + 0.11) {
          EXPECT_EQ(result.culprit, Culprit::kNone) << k << ": " << result.message;
        }
      }
    }
  }
}

// Few tracks leave the error of a saturated accelerometer below the limit of a single frame: it is
// found in the second of two, then in each, and not after its end.
TEST(InnovationMonitor, SmallDamageThatGoesOnIsFoundInEachFrame) {
  int found = 0, damaged = 0, accused = 0, clean = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
    for (std::size_t k = 0; k < flight.frames.size(); ++k) {
      flight.thin(k, [](FeatureId id) { return id % 2 == 0; });
    }
    const double first = flight.truth[20].t + 0.05, last = first + 0.5;
    flight.disturb(first, last, [](ImuSample* sample) { sample->accel.x() -= 5.0; });
    for (const auto& [k, result] : flight.watch()) {
      const double begin = flight.truth[k - 1].t, end = flight.truth[k].t;
      const bool wrong = result.culprit == Culprit::kImu;
      if (begin > flight.truth[21].t && end <= last) {
        ++damaged;
        found += wrong ? 1 : 0;
      }
      if (begin < last + 0.11 && end > first) continue;
      ++clean;
      accused += wrong ? 1 : 0;
    }
  }
  std::cout << found << " of " << damaged << " damaged intervals found, " << accused << " of "
            << clean << " clean ones accused\n";
  EXPECT_GE(damaged, 20);
  EXPECT_GE(found, 0.95 * damaged);
  EXPECT_LE(accused, 0.01 * clean);
}

// A track fewer than with a pose that the IMU does not allow either makes no texture of the others:
// every fourth is at the bound of those that agree.
TEST(Innovation, NearlyAllTracksSpeakAgainstTheImu) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
    flight.pushInterval(20, 20.0);
    const double shift = 3.7 * kNoisePx / flight.calibration.focal_px;
    for (PointObservation& point : flight.frames[20].points) {
      if (point.id % 4 != 0) continue;
      point.bearing = (point.bearing.normalized() +
                       shift * tangentOf(point.bearing.normalized()).col(point.id % 8 == 0 ? 0 : 1))
                          .normalized();
    }
    const Innovation result = flight.at(20);
    EXPECT_EQ(result.culprit, Culprit::kImu) << seed << ": " << result.message;
  }
}

// Few tracks, of which some have two views and agree with any pose: those do not speak for the IMU
// where all others contradict it.
TEST(InnovationMonitor, TracksThatAgreeWithBothDoNotSpeakForTheImu) {
  int found = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx, seed, 21));
    for (std::size_t k = 0; k < 21; ++k) {
      flight.thin(k, [k](FeatureId id) { return id % 3 == 0 && (k >= 18 || id % 10 >= 4); });
    }
    flight.pushInterval(20, 20.0);
    const Innovation result = flight.watch().at(20);
    EXPECT_NE(result.culprit, Culprit::kImages) << seed << ": " << result.message;
    found += result.culprit == Culprit::kImu || result.culprit == Culprit::kUnclear ? 1 : 0;
  }
  EXPECT_EQ(found, 40);
}

// In fast motion a tracker has few tracks, and few of these are older than three frames.
TEST(Innovation, ShortTracksSpeakAgainstTheImu) {
  constexpr std::size_t kTracks = 13, kOlder = 3;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
    std::vector<PointObservation>& newest = flight.frames[20].points;
    ASSERT_GT(newest.size(), kTracks);
    newest.resize(kTracks);
    for (int k = 10; k <= 17; ++k) {
      for (PointObservation& point : flight.frames[k].points) {
        const bool older = std::any_of(newest.begin(), newest.begin() + kOlder,
                                       [&](const auto& other) { return other.id == point.id; });
        if (!older) point.id += 1000000;
      }
    }
    EXPECT_EQ(flight.at(20).culprit, Culprit::kNone) << flight.at(20).message;
    flight.pushInterval(20, 30.0);
    EXPECT_EQ(flight.at(20).culprit, Culprit::kImu) << flight.at(20).message;
  }
}

// The rest of the view is static.
TEST(Innovation, AMovingTextureIsKeptOut) {
  for (const double part : {0.3, 0.5, 0.7}) {
    for (const double px : {6.0, 12.0, 30.0}) {
      SCOPED_TRACE(std::to_string(part) + " at " + std::to_string(px) + " px");
      Flight flight(flightOf(Motion::kExcited, kNoisePx));
      const std::set<FeatureId> texture = flight.moveTexture(22, part, px);
      EXPECT_EQ(flight.at(21).culprit, Culprit::kNone);
      // The second time the texture has begun in an older frame of the window.
      for (const int newest : {22, 26}) {
        const Innovation result = flight.at(newest);
        EXPECT_EQ(result.culprit, Culprit::kImages) << newest << ": " << result.message;
        KeptOut count;
        count.add(flight.frames[newest], texture, result.moving);
        EXPECT_GE(count.kept_out, 0.9 * count.seen) << newest;
        EXPECT_LE(count.wronged, 3) << newest;
        EXPECT_GT(count.seen, 10);
      }
    }
  }
}

// Nothing of the scene is left, and all tracks are new and agree with each other: neither the IMU
// nor the host is blamed. A track comes into the host's window with its fourth view.
TEST(InnovationMonitor, ATextureThatIsAllThereIsIsNotTheScene) {
  for (const Motion motion : {Motion::kExcited, Motion::kHover, Motion::kConstantVelocity}) {
    for (const double px : {3.0, 6.0, 12.0, 30.0}) {
      SCOPED_TRACE(named(px, motion));
      Flight flight(flightOf(motion, kNoisePx));
      const std::set<FeatureId> texture = flight.coverWithTexture(16, 0.75, px);
      std::map<FeatureId, int> kept_in;  // frames in a row in which a track was not kept out
      int seen = 0, used = 0;
      for (const auto& [k, result] : flight.watch()) {
        expectTheImuIsNotBlamed(k, result);
        if (k < 16) continue;
        for (const FeatureId id : texture) {
          const bool found = std::binary_search(result.moving.begin(), result.moving.end(), id);
          kept_in[id] = found ? 0 : kept_in[id] + 1;
          ++seen;
          used += kept_in[id] >= 4 ? 1 : 0;
        }
      }
      EXPECT_GT(seen, 1000);
      EXPECT_LT(used, 0.1 * seen);
    }
  }
}

// Tracks that were there before decide: the new ones are more, and agree with each other.
TEST(InnovationMonitor, TheSceneBesideATextureDecides) {
  KeptOut count;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const Motion motion : {Motion::kExcited, Motion::kConstantVelocity}) {
      for (const double px : {2.0, 3.0, 6.0, 12.0}) {
        SCOPED_TRACE(named(px, motion) + ", seed " + std::to_string(seed));
        Flight flight(flightOf(motion, kNoisePx, seed));
        const std::set<FeatureId> texture =
            flight.coverWithTexture(16, 0.7, px, 1000, Flight::Others::kTracked);
        for (const auto& [k, result] : flight.watch()) {
          expectTheImuIsNotBlamed(k, result);
          // Of two views they may be the scene.
          if (k >= 20) count.add(flight.frames[k], texture, result.moving);
        }
      }
    }
  }
  EXPECT_GT(count.scene, 10000);
  EXPECT_GE(count.kept_out, 0.95 * count.seen);
  EXPECT_LE(count.wronged, 0.05 * count.scene);
}

// A handful of tracks from before are where the IMU is, and what is new moves.
TEST(Innovation, AFewTracksOfTheSceneAreNotOutvoted) {
  constexpr int kOlder = 4;
  const Eigen::Matrix3d turn = expSO3(Eigen::Vector3d(0.03, 0.02, 0.0));
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
    std::set<FeatureId> older;
    for (int i = 0; i < kOlder; ++i) older.insert(flight.frames[20].points[i].id);
    for (int k = 10; k <= 20; ++k) {
      for (PointObservation& point : flight.frames[k].points) {
        if (older.count(point.id) > 0) continue;
        if (k <= 17) point.id += 1000000;
        if (k == 20) point.bearing = turn * point.bearing;
      }
    }
    const Innovation result = flight.at(20);
    EXPECT_GE(result.agree_images, 0.7) << seed << ": " << result.message;
    EXPECT_EQ(result.culprit, Culprit::kImages) << seed << ": " << result.message;
  }
}

// Most of the view has moved before, and what has not agrees on another pose by chance.
TEST(Innovation, AFewTracksOfAViewThatMovesAreNotDamage) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
    const Eigen::Matrix3d turn = expSO3(Eigen::Vector3d(0.03, 0.02, 0.0));
    for (std::size_t k = 0; k <= 20; ++k) {
      for (PointObservation& point : flight.frames[k].points) {
        const double shift = 0.05 * static_cast<double>((k + point.id) % 3);
        if (point.id % 8 != 0) {
          point.bearing = (point.bearing + Eigen::Vector3d(shift, -shift, 0.0)).normalized();
        } else if (k == 20) {
          point.bearing = turn * point.bearing;
        }
      }
    }
    const Innovation result = flight.at(20);
    EXPECT_GE(result.tracks, 8) << seed;
    EXPECT_GE(result.agree_images, 0.7) << seed << ": " << result.message;
    EXPECT_EQ(result.culprit, Culprit::kImages) << seed << ": " << result.message;
    EXPECT_TRUE(result.blind);
  }
}

// Tracks of few views agree with a pose far from the IMU's as well as with the IMU.
TEST(InnovationMonitor, YoungTracksOfATextureAreNotDamage) {
  for (const Motion motion : {Motion::kExcited, Motion::kHover}) {
    for (const double px : {2.0, 3.0, 6.0, 12.0}) {
      for (const int life : {3, 4, 5}) {
        SCOPED_TRACE(named(px, motion) + ", " + std::to_string(life) + " frames");
        Flight flight(flightOf(motion, kNoisePx));
        flight.coverWithTexture(16, 0.75, px, life);
        for (const auto& [k, result] : flight.watch()) {
          EXPECT_NE(result.culprit, Culprit::kImu) << k << ": " << result.message;
        }
      }
    }
  }
}

// Most of the view is new at once: something has come before the scene, and for a second its tracks
// do not speak against the IMU, however many they are.
TEST(InnovationMonitor, AViewThatHasBeenReplacedIsNoEvidence) {
  constexpr int kBegin = 16;
  const Eigen::Matrix3d turn = expSO3(Eigen::Vector3d(0.03, 0.02, 0.0));
  for (const int replaced : {0, 5, 7}) {  // of ten
    for (const int turned : {kBegin + 6, kBegin + 14}) {
      Flight flight(flightOf(Motion::kExcited, kNoisePx));
      for (int k = kBegin; k < kFrames; ++k) {
        for (PointObservation& point : flight.frames[k].points) {
          if (point.id % 10 < replaced) point.id += 1000000;
          if (k == turned) point.bearing = turn * point.bearing;
        }
      }
      const bool is_evidence = replaced < 7 || turned > kBegin + 10;
      const Innovation result = flight.watch()[turned];
      EXPECT_EQ(result.culprit, is_evidence ? Culprit::kImu : Culprit::kImages)
          << replaced << " of ten, frame " << turned << ": " << result.message;
    }
  }
}

// Then it may be the host as well.
TEST(InnovationMonitor, BlindnessEnds) {
  Flight flight(flightOf(Motion::kExcited, kNoisePx, 1, 90));
  const int begin = 16;
  flight.coverWithTexture(begin, 1.0, 8.0);
  int blind = 0;
  for (const auto& [k, result] : flight.watch()) {
    const double since = flight.truth[k].t - flight.truth[begin].t;
    // With its third view a track is judged.
    if (since > 0.25 && since < 5.0) {
      EXPECT_EQ(result.culprit, Culprit::kImages) << k << ": " << result.message;
      blind += result.blind ? 1 : 0;
    } else if (since > 5.35) {
      EXPECT_EQ(result.culprit, Culprit::kUnclear) << k << ": " << result.message;
      EXPECT_TRUE(result.moving.empty());
      EXPECT_GE(result.accel_sigma, kUnknownAccel);
    }
  }
  EXPECT_GE(blind, 45);
}

// Damage that has just passed spoils the pose of its frame, which takes the places of all tracks;
// whether that frame was found damaged or not.
TEST(InnovationMonitor, AFrameThatDamageHasSpoiledIsNotAViewThatMoves) {
  constexpr int kLast = 17;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double metres : {0.04, 0.08, 0.2}) {
      for (const bool found : {false, true}) {
        SCOPED_TRACE(std::to_string(metres) + " m, seed " + std::to_string(seed) +
                     (found ? ", found" : ""));
        Flight flight(flightOf(Motion::kExcited, kNoisePx, seed));
        InnovationMonitor monitor;
        const auto push = [](ImuSample* one) { one->accel.x() += 15.0; };
        if (found) flight.disturb(flight.truth[kLast - 1].t, flight.truth[kLast].t, push);
        for (int k = kHostFrames; k < kLast; ++k) flight.judged(k, &monitor);
        EXPECT_EQ(flight.judged(kLast, &monitor).accusesImu(), found);
        flight.disturb(flight.truth[kLast].t, 1e9, push);
        flight.states[kLast].p_w_b.x() += metres;
        flight.states[kLast].v_w_b.x() += 10.0 * metres;
        flight.states[kLast].R_w_b *= expSO3(Eigen::Vector3d(0.0, 0.007, 0.0));
        const Innovation next = flight.judged(kLast + 1, &monitor);
        EXPECT_EQ(next.culprit, Culprit::kImu) << next.message;
        EXPECT_DOUBLE_EQ(next.damaged_since, flight.truth[kLast - 1].t);
        EXPECT_TRUE(next.moving.empty());
        EXPECT_LT((next.best.p_w_b - flight.truth[kLast + 1].p_w_b).norm(), 0.05);
      }
    }
  }
}

// Frames without known tracks do not end damage until it has lasted twice as long, the interval
// before it was found included; and they do not begin it.
TEST(InnovationMonitor, DamageGoesOnWhereNothingIsKnown) {
  constexpr int kLast = 20;
  for (const int damaged : {0, 1, 4}) {
    Flight flight(flightOf(Motion::kExcited, kNoisePx));
    if (damaged > 0) {
      flight.disturb(flight.truth[kLast - damaged].t, 1e9,
                     [](ImuSample* one) { one->accel.x() += 15.0; });
    }
    for (std::size_t k = kLast + 1; k < flight.frames.size(); ++k) flight.frames[k].points.clear();
    for (const auto& [k, result] : flight.watch()) {
      if (k <= kLast) continue;
      SCOPED_TRACE(std::to_string(damaged) + ", " + std::to_string(k) + ": " + result.message);
      EXPECT_EQ(result.culprit, Culprit::kNotJudged);
      EXPECT_EQ(result.goes_on, damaged > 0 && k <= kLast + damaged + 1);
      EXPECT_EQ(result.accusesImu(), result.goes_on);
      EXPECT_EQ(result.accel_sigma > 10.0, result.goes_on);
    }
  }
}

// Poses that no track has agreed with say nothing about tracks.
TEST(InnovationMonitor, AHostThatHasNeverAgreedDoesNotAccuseTheTracks) {
  Flight flight(flightOf(Motion::kExcited, kNoisePx));
  const Flight healthy = flight;
  for (NavState& state : flight.states) state.p_w_b.setZero();
  InnovationMonitor fresh, known;
  for (int k = 14; k < 18; ++k) healthy.judged(k, &known);
  const Innovation unknown = flight.judged(18, &fresh), accused = flight.judged(18, &known);
  EXPECT_TRUE(unknown.moving.empty()) << unknown.message;
  EXPECT_GT(accused.moving.size(), 20u) << accused.message;
}

// Depths are not known there, and do not matter.
TEST(Innovation, WithoutParallaxTheAttitudeIsJudged) {
  for (const Motion motion : {Motion::kHover, Motion::kPureRotation, Motion::kConstantVelocity}) {
    Flight flight(flightOf(motion, kNoisePx));
    for (const auto& [k, result] : flight.watch()) {
      EXPECT_EQ(result.culprit, Culprit::kNone) << k << ": " << result.message;
    }
    flight.disturb(flight.truth[20].t, flight.truth[22].t,
                   [](ImuSample* sample) { sample->gyro.z() += 3.0; });
    EXPECT_EQ(flight.at(21).culprit, Culprit::kImu) << flight.at(21).message;
  }
}

TEST(Innovation, FewTracksAreNotJudged) {
  Flight flight(flightOf(Motion::kExcited, kNoisePx));
  for (FrameObservation& frame : flight.frames) {
    frame.points.resize(std::min<std::size_t>(frame.points.size(), 7));
  }
  const Innovation few = flight.at(20);
  EXPECT_EQ(few.culprit, Culprit::kNotJudged);
  expectParts(few.message, "7 tracks");
  EXPECT_TRUE(few.images.isFinite());
  flight.frames.clear();
  EXPECT_EQ(flight.at(20).culprit, Culprit::kNotJudged);
  Flight broken(flightOf(Motion::kExcited, kNoisePx));
  std::vector<NavState> optimized = broken.optimized(20);
  optimized.back().p_w_b.x() = std::numeric_limits<double>::quiet_NaN();
  const PropagatedState predicted = broken.predicted(20);
  for (const std::vector<NavState>& states : {optimized, std::vector<NavState>()}) {
    const InnovationInput frame = {states, predicted, broken.frames, broken.calibration};
    EXPECT_EQ(innovationOf(frame).culprit, Culprit::kNotJudged);
    EXPECT_EQ(InnovationMonitor().judge(frame).culprit, Culprit::kNotJudged);
  }
}

// Everything changes, and nothing fits: tracks that go anywhere, as those of a camera that has gone
// blank. They do not speak against the IMU.
TEST(Innovation, TracksWithoutOrderAreKeptOut) {
  Flight flight(flightOf(Motion::kExcited, kNoisePx));
  Gaussian normal(9);
  for (PointObservation& point : flight.frames[20].points) {
    point.bearing = (point.bearing + 0.1 * normal.vector()).normalized();
  }
  const Innovation result = flight.at(20);
  EXPECT_EQ(result.culprit, Culprit::kImages) << result.message;
  EXPECT_TRUE(result.blind);
  // If the IMU is known to be damaged there, it may be both.
  TrackTrust trust;
  trust.decide = true;
  const Innovation both = flight.at(20, trust);
  EXPECT_EQ(both.culprit, Culprit::kUnclear) << both.message;
  EXPECT_GE(both.accel_sigma, kUnknownAccel);
  EXPECT_GE(both.gyro_sigma, kUnknownGyro);
}

// The interval is clean: the poses before it say what the velocity is.
TEST(InnovationMonitor, AWrongVelocityOfTheHostIsNotTheImu) {
  Flight flight(flightOf(Motion::kExcited, kNoisePx));
  for (std::size_t k = 20; k < flight.states.size(); ++k) {
    flight.states[k].v_w_b += Eigen::Vector3d(1.5, 0, 0);
  }
  const std::map<int, Innovation> results = flight.watch();
  EXPECT_EQ(results.at(20).culprit, Culprit::kNone);
  EXPECT_EQ(results.at(21).culprit, Culprit::kUnclear) << results.at(21).message;
  expectParts(results.at(21).message, "the host's velocity is 1.");
  for (int k = 22; k < 40; ++k) EXPECT_EQ(results.at(k).culprit, Culprit::kNone) << k;
}

// An extrinsic rotation that is off by 3 deg adds to every turn.
TEST(InnovationMonitor, AMiscalibratedRigIsNoDamage) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    ExactWindowOptions options = atTenHertz(60);
    options.pixel_noise = kNoisePx;
    options.imu_noise = true;
    options.seed = seed;
    const Eigen::Vector3d rate = 3.0 * makeExactWindow(options).calibration.R_b_c.col(2);
    options.angular_rate = [rate](double) { return rate; };
    Flight flight(makeExactWindow(options));
    const Eigen::Vector3d added = expSO3(Eigen::Vector3d(0.034, -0.034, 0.03)) * rate - rate;
    flight.disturb(0.0, 1e9, [&added](ImuSample* one) { one->gyro += added; });
    for (const auto& [k, result] : flight.watch()) {
      EXPECT_FALSE(result.accusesImu()) << k << ": " << result.message;
    }
  }
}

// What a widened prediction allows is no alarm.
TEST(Innovation, KnownDamageIsAllowed) {
  Flight flight(flightOf(Motion::kExcited, kNoisePx));
  const double first = flight.truth[20].t, last = flight.truth[21].t;
  flight.disturb(first, last, [](ImuSample* sample) {
    sample->accel.x() += 15.0;
    sample->gyro.y() += 1.0;
  });
  EXPECT_EQ(flight.at(21).culprit, Culprit::kImu);
  ImuDamage damage;
  damage.first = first;
  damage.last = last;
  damage.accel_sigma = 15.0;
  flight.damage.push_back(damage);
  EXPECT_EQ(flight.at(21).culprit, Culprit::kNone) << flight.at(21).message;
}

// A host's window with errors of the size of a real one's: they drift, and each pose has its own.
class HostErrors {
 public:
  explicit HostErrors(unsigned seed) : normal_(seed) {}

  void step() {
    drift(0.04, &velocity_);
    drift(0.2 / 57.3, &tilt_);
    drift(1e-3, &gyro_bias_);
    drift(0.05, &accel_bias_);
    tilt_.z() = 0.0;
    Eigen::Vector3d scale(scale_, 0, 0);
    drift(0.01, &scale);
    scale_ = scale.x();
    jitter_.push_back({0.02 / 57.3 * normal_.vector(), 0.001 * normal_.vector()});
  }
  // `frame`: the index of step() that made its own error.
  NavState disturbed(const NavState& truth, std::size_t frame, const NavState& origin) const {
    const Eigen::Matrix3d R = expSO3(tilt_);
    NavState state = truth;
    state.p_w_b =
        origin.p_w_b + (1.0 + scale_) * (R * (truth.p_w_b - origin.p_w_b)) + jitter_[frame].second;
    state.R_w_b = expSO3(jitter_[frame].first) * R * truth.R_w_b;
    state.v_w_b = (1.0 + scale_) * (R * truth.v_w_b) + velocity_;
    state.gyro_bias += gyro_bias_;
    state.accel_bias += accel_bias_;
    return state;
  }

 private:
  // Correlated over 3 s.
  void drift(double sigma, Eigen::Vector3d* error) {
    *error = 0.97 * *error + 0.243 * sigma * normal_.vector();
  }

  Gaussian normal_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero(), tilt_ = Eigen::Vector3d::Zero(),
                  gyro_bias_ = Eigen::Vector3d::Zero(), accel_bias_ = Eigen::Vector3d::Zero();
  double scale_ = 0.0;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> jitter_;
};

struct Recording {
  Calibration calibration = eurocCalibration();
  std::vector<ImuSample> imu;
  std::vector<FrameObservation> frames;
  std::vector<NavState> truth;
};

// Ten images a second. False without the data.
bool readRecording(const std::string& name, double pixel_noise, Recording* recording) {
  evaluation::RecordedMotion motion;
  const std::string folder = std::string(SLIM_INIT_RECORDINGS) + "/" + name;
  if (!evaluation::readRecordedMotion(folder, 0.05, &motion).ok()) return false;
  const auto trajectory = simulation::makeSampledTrajectory(motion.truth);
  if (trajectory == nullptr) return false;
  std::vector<double> times;
  std::vector<Eigen::Vector3d> path;
  for (const double t : motion.image_times) {
    if (!trajectory->covers(t) || (!times.empty() && t < times.back() + 0.09)) continue;
    times.push_back(t);
    path.push_back(trajectory->at(t).p_w_b);
  }
  std::size_t nearest = 0;
  for (const double t : times) {
    const simulation::Kinematics motion_at = trajectory->at(t);
    while (nearest + 1 < motion.truth.size() && motion.truth[nearest].t < t) ++nearest;
    NavState state = motion.truth[nearest];
    state.t = t;
    state.R_w_b = motion_at.R_w_b;
    state.p_w_b = motion_at.p_w_b;
    state.v_w_b = motion_at.v_w_b;
    recording->truth.push_back(state);
  }
  simulation::FeatureSimulationOptions features;
  features.max_points = 150;
  features.max_lines = 0;
  features.pixel_noise = pixel_noise;
  features.outlier_rate = 0.03;
  recording->imu = motion.imu;
  recording->frames = simulation::simulateFeatures(*trajectory, simulation::makeWorld({}, path),
                                                   recording->calibration, times, features);
  return true;
}

struct Alarms {
  int frames = 0, alarms = 0;
  std::string first;
};

Alarms alarmsOf(const Recording& recording) {
  Alarms result;
  ImuScreen screen{ImuLimits()};
  InnovationMonitor monitor;
  HostErrors host(3);
  std::size_t next = 0, jumped = 0;
  const Eigen::Vector3d gravity_w(0, 0, -recording.calibration.gravity_magnitude);
  for (std::size_t k = 0; k < recording.frames.size(); ++k) {
    host.step();
    while (next < recording.imu.size() &&
           (next == 0 || recording.imu[next - 1].t < recording.truth[k].t)) {
      screen.add(recording.imu[next++]);
    }
    const std::size_t first = k + 1 - kHostFrames;
    if (k < kHostFrames || recording.truth[k].t - recording.truth[first].t > 1.3) continue;
    std::vector<NavState> optimized;
    for (std::size_t i = first; i < k; ++i) {
      optimized.push_back(host.disturbed(recording.truth[i], i, recording.truth[k - 1]));
    }
    PropagatedState from, predicted, exact, exact_from;
    from.state = optimized.back();
    from.covariance = healthyCovariance();
    exact_from.state = recording.truth[k - 1];
    std::string error;
    const auto carry = [&](const PropagatedState& state, PropagatedState* to) {
      return propagateState(state, recording.truth[k].t, screen.heldUntil(recording.truth[k].t),
                            screen.damage(), gravity_w, recording.calibration.imu_noise, to,
                            &error);
    };
    if (!carry(from, &predicted) || !carry(exact_from, &exact)) continue;
    // The recorded poses jump in some places, by more than the IMU measured: true innovations.
    if ((exact.state.p_w_b - recording.truth[k].p_w_b).norm() > 0.015) jumped = k;
    const std::vector<FrameObservation> frames(
        recording.frames.begin() + static_cast<std::ptrdiff_t>(first),
        recording.frames.begin() + static_cast<std::ptrdiff_t>(k) + 1);
    const Innovation found = monitor.judge({optimized, predicted, frames, recording.calibration});
    if (found.culprit == Culprit::kNotJudged || (jumped > 0 && k < jumped + kHostFrames)) continue;
    ++result.frames;
    if (found.culprit == Culprit::kNone) continue;
    ++result.alarms;
    if (result.first.empty()) result.first = found.message;
  }
  return result;
}

// The goal is one in 30 minutes at 10 Hz, 18,000 frames; here are about 7,000 for each noise.
TEST(Innovation, AHealthyHostIsNotAccused) {
  constexpr double kFalseAlarms = 1.0 / 18000.0;
  int frames = 0, alarms = 0;
  for (const std::string name :
       {"euroc/MH_03", "euroc/MH_04", "euroc/V1_01", "euroc/V1_02", "euroc/V2_01", "tumvi_room5"}) {
    for (const double noise : {0.6, 1.2}) {
      Recording recording;
      if (!readRecording(name, noise, &recording)) continue;
      const Alarms one = alarmsOf(recording);
      frames += one.frames;
      alarms += one.alarms;
      RecordProperty(name + "_" + std::to_string(noise), one.alarms);
      if (one.alarms > 0) std::cout << name << " " << noise << " px: " << one.first << "\n";
    }
  }
  if (frames == 0) GTEST_SKIP() << "no recordings in " << SLIM_INIT_RECORDINGS;
  EXPECT_LE(alarms, std::max(1.0, kFalseAlarms * frames)) << "of " << frames;
}

}  // namespace
}  // namespace slim_init::host_health
