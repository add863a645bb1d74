// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Ten thousand windows of bodies that do not stand: none may pass for a rest.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/simulation/world.h"
#include "support/exact_window.h"
#include "support/made_trajectory.h"
#include "verdict/rest.h"

namespace slim_init {
namespace {

using namespace simulation;  // NOLINT: the vocabulary of this test

constexpr double kImageRate = 20.0;  // [Hz]
constexpr int kImages[] = {21, 41};  // of a window: 1 s and 2 s

struct Moving {
  std::string motion;  // of makeBuiltinTrajectory(), or "straight"
  double speed = 0.0;  // [m/s]
  std::string world = "hall";
};

struct Counts {
  int windows = 0, rests = 0;
};

std::shared_ptr<const InitWindow> windowOf(const std::vector<FrameObservation>& images,
                                           const std::vector<ImuSample>& imu,
                                           const Calibration& calibration) {
  std::vector<ImuSample> samples;
  for (const ImuSample& sample : imu) {
    if (sample.t > images.front().t - 0.02 && sample.t < images.back().t + 0.02) {
      samples.push_back(sample);
    }
  }
  return madeWindow(calibration, images, samples);
}

// One window after the other of `duration_s`.
Counts countRests(const Moving& moving, double duration_s, unsigned seed) {
  Calibration calibration = eurocCalibration();
  const bool straight = moving.motion == "straight";
  std::unique_ptr<Trajectory> trajectory = makeBuiltinTrajectory(
      straight ? "hover" : moving.motion, duration_s, calibration.R_b_c, seed);
  if (moving.speed > 0.0) {  // in place of the motion's own; straight: nothing for the IMU to feel
    const std::shared_ptr<const Trajectory> own = std::move(trajectory);
    const Eigen::Vector3d v = (moving.speed - (straight ? 0.0 : 0.5)) * Eigen::Vector3d::UnitX();
    trajectory = std::make_unique<MadeTrajectory>(0.0, duration_s, [own, straight, v](double t) {
      Kinematics out = own->at(straight ? 0.0 : t);
      if (straight) out.v_w_b = out.a_w_b = out.omega_b = Eigen::Vector3d::Zero();
      out.p_w_b += t * v;
      out.v_w_b += v;
      return out;
    });
  }
  ImuSimulationOptions imu_options;
  imu_options.noise = calibration.imu_noise;
  imu_options.seed = seed;
  const std::vector<ImuSample> imu = simulateImu(*trajectory, imu_options);
  std::vector<double> times;
  std::vector<Eigen::Vector3d> path;
  for (int k = 1; (k + 1) / kImageRate < duration_s; ++k) {
    times.push_back(k / kImageRate);
    path.push_back(trajectory->at(times.back()).p_w_b);
  }
  WorldOptions world;
  world.kind = moving.world;
  world.seed = seed;
  FeatureSimulationOptions features;
  features.seed = seed;
  features.track_life = 200.0;
  const std::vector<FrameObservation> frames =
      simulateFeatures(*trajectory, makeWorld(world, path), calibration, times, features);
  Counts counts;
  for (const int images : kImages) {
    for (std::size_t first = 0; first + images <= frames.size(); first += 4) {
      const auto window =
          windowOf({frames.begin() + first, frames.begin() + first + images}, imu, calibration);
      if (window == nullptr) return counts;
      ++counts.windows;
      const RestMeasures rest = measureRest(*window);
      counts.rests += rest.isRest(calibration.gravity_magnitude, InertialOptions()) ? 1 : 0;
    }
  }
  return counts;
}

TEST(FalseRests, NoneInTenThousandWindowsOfBodiesThatMove) {
  const std::vector<Moving> cases = {{"hover"},
                                     {"hover", 0.0, "room"},
                                     {"pure-rotation"},
                                     {"corridor-walk"},
                                     {"straight", 0.05, "room"},
                                     {"straight", 0.05},
                                     {"straight", 0.1},
                                     {"straight", 0.5},
                                     {"constant-velocity", 0.1},
                                     {"constant-velocity", 1.0},
                                     {"straight", 5.0, "corridor"},
                                     {"straight", 15.0, "corridor"}};
  int windows = 0;
  for (const Moving& moving : cases) {
    Counts of_case;
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const Counts counts = countRests(moving, 10.0, seed);
      of_case.windows += counts.windows;
      of_case.rests += counts.rests;
    }
    EXPECT_EQ(of_case.rests, 0) << moving.motion << " at " << moving.speed << " m/s, of "
                                << of_case.windows;
    windows += of_case.windows;
  }
  RecordProperty("windows", windows);
  EXPECT_GE(windows, 10000);
}

}  // namespace
}  // namespace slim_init
