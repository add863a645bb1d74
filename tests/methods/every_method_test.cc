// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What is asked of every method: exact without noise, within named tolerances with it, refusals
// that say why and return what is observable, and no change by what must not change the answer.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/baselines/baselines.h"
#include "support/chi_square.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/method_name.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

using baselines::BaselineOptions;

std::unique_ptr<WindowSolver> makeSolver(const std::string& method,
                                         const InitializerOptions& options = {},
                                         const BaselineOptions& baseline_options = {}) {
  return baselines::makeMethod(method, options, baseline_options, nullptr, baselines::allMethods());
}

/// Eq. (11) shrinks the scale, noise or not.
BaselineOptions withoutEquation11() {
  BaselineOptions options;
  options.slim_paper.use_line_epipolar = false;
  return options;
}

class EveryMethod : public ::testing::TestWithParam<std::string> {
 protected:
  static InitResult solve(const InitWindow& window, GateMode mode = GateMode::kOwn) {
    InitializerOptions options;
    options.gates.mode = mode;
    return makeSolver(GetParam(), options)->solve(window);
  }
  static InitResult solve(const ExactWindow& exact, GateMode mode = GateMode::kOwn) {
    return solve(*exact.window, mode);
  }
  // The whole systems end their minimisations by a relative decrease of the cost.
  static bool isWholeSystem() { return GetParam() == "vins" || GetParam() == "openvins"; }

  // Everything is recovered, to this share of its size.
  static double exactness() { return isWholeSystem() ? 1e-4 : 1e-6; }
  void expectRecovered(ExactWindowOptions options, const std::string& trace) const {
    SCOPED_TRACE(trace);
    // Clutter inside the VP's inlier threshold bends it, noise or not.
    options.parallel_lines_only = true;
    const ExactWindow exact = makeExactWindow(options);
    const InitResult result = exact_solver_->solve(*exact.window);
    ASSERT_TRUE(result.success()) << result.message;
    ASSERT_EQ(result.states.size(), exact.truth.size());
    // From the world of the answer to that of the truth: a shift, and a turn about the vertical.
    const NavState &first = result.states[0], &first_truth = exact.truth[0];
    const Eigen::Matrix3d M = first_truth.R_w_b * first.R_w_b.transpose();
    const Eigen::Matrix3d turn =
        expSO3(Eigen::Vector3d(0, 0, std::atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1))));
    double path = 0.0, speed = 0.0, position_error2 = 0.0, velocity_error2 = 0.0;
    for (std::size_t k = 0; k < exact.truth.size(); ++k) {
      const Eigen::Vector3d& v = exact.truth[k].v_w_b;
      const Eigen::Vector3d p = exact.truth[k].p_w_b - first_truth.p_w_b;
      speed = std::max(speed, v.norm());
      path = std::max(path, p.norm());
      velocity_error2 += (turn * result.states[k].v_w_b - v).squaredNorm();
      position_error2 += (turn * (result.states[k].p_w_b - first.p_w_b) - p).squaredNorm();
    }
    const double n = static_cast<double>(exact.truth.size());
    const Eigen::Vector3d& gyro_bias = first_truth.gyro_bias;
    EXPECT_LT(std::abs(scaleError(result.states, exact.truth)), exactness());
    EXPECT_LT(gravityErrorRad(result.gravity_b0, first_truth), exactness());
    EXPECT_LT(std::sqrt(velocity_error2 / n), exactness() * speed);
    EXPECT_LT(std::sqrt(position_error2 / n), exactness() * path);
    EXPECT_LT((result.gyro_bias - gyro_bias).norm(), exactness() * gyro_bias.norm());
    // World frame: gravity along -z, first body at the origin with zero yaw.
    const Eigen::Vector3d gravity_w(0, 0, -exact.calibration.gravity_magnitude);
    EXPECT_LT((result.gravity_w - gravity_w).norm(), 1e-12);
    EXPECT_LT(first.p_w_b.norm(), 1e-12);
    EXPECT_NEAR(std::atan2(first.R_w_b(1, 0), first.R_w_b(0, 0)), 0.0, 1e-9);
  }

 private:
  static InitializerOptions exactOptions() {
    InitializerOptions options;
    options.refinement.tolerance = 1e-12;  // slim stops at a third of a sigma, noise or not
    options.inertial.gyro_bias_prior = 10.0;
    return options;
  }
  const std::unique_ptr<WindowSolver> exact_solver_ =
      makeSolver(GetParam(), exactOptions(), withoutEquation11());
};

// Those that hosts run; the gates of this project tell what is degenerate.
class HostMethod : public EveryMethod {};

// ---- without noise ----

TEST_P(EveryMethod, RecoversManyScenes) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double interval : {0.25, 0.4}) {
      ExactWindowOptions options = seeded(seed);
      options.interval_s = interval;
      expectRecovered(options, "seed " + std::to_string(seed) + ", " + std::to_string(interval));
    }
  }
}

TEST_P(EveryMethod, RecoversKeyframesOnSamplesAndBetween) {
  for (const double offset : {0.0, 1e-7, 0.0025, 0.004999}) {
    ExactWindowOptions options;
    options.keyframe_offset_s = offset;
    expectRecovered(options, "offset " + std::to_string(offset));
  }
}

TEST_P(HostMethod, RecoversOtherWindowLengths) {
  for (const int keyframes : {6, 15}) {
    for (const double interval : {0.25, 0.4}) {
      ExactWindowOptions options;
      options.keyframes = keyframes;
      options.interval_s = interval;
      expectRecovered(options,
                      std::to_string(keyframes) + " keyframes, " + std::to_string(interval));
    }
  }
}

TEST(Equation11, PullsTheScaleDownAndMoreWithMoreWeight) {
  ExactWindowOptions options;
  options.parallel_lines_only = true;
  const ExactWindow exact = makeExactWindow(options);
  double last = 0.0;
  for (const double weight : {0.01, 0.1, 1.0, 10.0}) {
    BaselineOptions paper;
    paper.slim_paper.line_epipolar_weight = weight;
    const InitResult result = makeSolver("slim-paper", {}, paper)->solve(*exact.window);
    ASSERT_TRUE(result.hasEstimate());
    const double error = scaleError(result.states, exact.truth);
    RecordProperty("scale_error_at_weight_" + std::to_string(weight), std::to_string(error));
    EXPECT_LT(error, last) << "weight " << weight;
    last = error;
  }
  EXPECT_LT(last, -0.01);  // 2 % of the scale are gone at weight 10, in the absence of any noise
}

// ---- with noise ----

// Accelerations of 1.4 m/s^2 over 2.25 s, 100 points at 0.6 px, EuRoC's IMU, no accelerometer bias.
TEST_P(EveryMethod, StaysWithinToleranceWithNoise) {
  std::vector<double> scale, gravity_deg;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kExcited, seed);
    const InitResult result = solve(exact);
    ASSERT_TRUE(result.hasEstimate()) << "seed " << seed << ": " << result.message;
    scale.push_back(std::abs(scaleError(result.states, exact.truth)));
    gravity_deg.push_back(gravityErrorRad(result.gravity_b0, exact.truth[0]) * 180.0 / M_PI);
  }
  std::sort(scale.begin(), scale.end());
  std::sort(gravity_deg.begin(), gravity_deg.end());
  EXPECT_LT(scale[15], 0.03);
  EXPECT_LT(gravity_deg[15], isWholeSystem() ? 1.0 : 0.3);
  if (!isWholeSystem()) {
    EXPECT_LT(scale.back(), 0.12);
  }
}

// Over many windows, scale, biases, speed and distance of `slim` miss the truth by as much as it
// reports.
TEST(Slim, StandardDeviationsAreThoseOfItsErrors) {
  InitializerOptions slim_options = dataSheetOptions();
  slim_options.refinement.min_sigma_px = 0.01;  // the tracks do not drift
  const auto solver = makeSolver("slim", slim_options);
  double scale = 0.0, gyro_bias = 0.0, accel_bias = 0.0, speed = 0.0, distance = 0.0;
  constexpr int kWindows = 200;
  for (unsigned seed = 1; seed <= kWindows; ++seed) {
    const ExactWindow exact =
        makeExactWindow(drawnFromTheModel(seed, slim_options.inertial.accel_bias_prior));
    const InitResult result = solver->solve(*exact.window);
    ASSERT_TRUE(result.success()) << "seed " << seed << ": " << result.message;
    scale += std::pow(scaleError(result.states, exact.truth) / result.scale_sigma, 2);
    const int n = static_cast<int>(result.states.size());
    const auto squared = [&](const Eigen::Vector3d& error, int at) {
      return error.dot(result.covariance.block<3, 3>(at, at).llt().solve(error));
    };
    gyro_bias += squared(result.gyro_bias - exact.truth[0].gyro_bias, 9 * n);
    accel_bias += squared(result.states[0].accel_bias - exact.truth[0].accel_bias, 9 * n + 3);
    // Lengths, which do not depend on the yaw between the worlds of answer and truth.
    const auto squared_length = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& truth,
                                    int at) {
      const Eigen::Vector3d along = x.normalized();
      return std::pow(x.norm() - truth.norm(), 2) /
             along.dot(result.covariance.block<3, 3>(at, at) * along);
    };
    const NavState &last = result.states[n - 1], &last_truth = exact.truth[n - 1];
    speed += squared_length(last.v_w_b, last_truth.v_w_b, 9 * (n - 1) + 6);
    distance += squared_length(last.p_w_b - result.states[0].p_w_b,
                               last_truth.p_w_b - exact.truth[0].p_w_b, 9 * (n - 1) + 3);
  }
  EXPECT_TRUE(isChiSquare(scale, kWindows)) << "scale";
  EXPECT_TRUE(isChiSquare(gyro_bias, 3 * kWindows)) << "gyroscope bias";
  EXPECT_TRUE(isChiSquare(accel_bias, 3 * kWindows)) << "accelerometer bias";
  EXPECT_TRUE(isChiSquare(speed, kWindows)) << "speed";
  EXPECT_TRUE(isChiSquare(distance, kWindows)) << "distance";
}

// ---- what a success means ----

double meanBaseline(const std::vector<NavState>& states, const Eigen::Vector3d& t_b_c) {
  double sum = 0.0;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const Eigen::Vector3d before = states[k - 1].p_w_b + states[k - 1].R_w_b * t_b_c;
    sum += (states[k].p_w_b + states[k].R_w_b * t_b_c - before).norm();
  }
  return sum / static_cast<double>(states.size() - 1);
}

// From the exact window to those that hold no scale, with few points and with a wrong calibration.
std::vector<ExactWindow> allKindsOfWindows() {
  std::vector<ExactWindow> windows;
  for (const Motion motion :
       {Motion::kExcited, Motion::kHover, Motion::kPureRotation, Motion::kConstantVelocity}) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      ExactWindowOptions options;
      options.motion = motion;
      options.seed = seed;
      options.pixel_noise = seed == 1 ? 0.0 : 0.6 * seed;
      options.imu_noise = seed > 1;
      options.points = seed == 3 ? 12 : 100;
      // Short windows have little parallax.
      options.interval_s = seed == 4 ? 0.05 : 0.25;
      windows.push_back(makeExactWindow(options));
    }
  }
  return windows;
}

TEST_P(HostMethod, SuccessMeansThatEveryEnforcedGatePassed) {
  int successes = 0, refusals = 0;
  for (const GateMode mode : {GateMode::kOff, GateMode::kOwn, GateMode::kOn}) {
    for (const ExactWindow& exact : allKindsOfWindows()) {
      const InitResult result = solve(exact, mode);
      EXPECT_EQ(result.validate(), "");
      ++(result.success() ? successes : refusals);
      if (!result.success()) continue;
      EXPECT_EQ(result.states.size(), exact.keyframes.size());
      EXPECT_TRUE(result.gyro_bias.allFinite() && result.accel_bias.allFinite());
      if (mode != GateMode::kOn) continue;
      for (const GateValue& gate : result.gates) {
        EXPECT_TRUE(gate.passed || !gate.exception.empty())
            << toString(gate.name) << " is " << gate.value << " (bound " << gate.threshold
            << "), not enforced, and no reason is given";
      }
    }
  }
  EXPECT_GT(successes, 0);
  EXPECT_GT(refusals, 0);
}

TEST_P(HostMethod, ScaleIsTheMeanBaselineInMetres) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const InitResult result = solve(exact);
  ASSERT_TRUE(result.success()) << result.message;
  const Eigen::Vector3d& t_b_c = exact.calibration.t_b_c;
  // Of the camera where the method has found it.
  EXPECT_NEAR(result.scale,
              meanBaseline(result.states, result.calibration ? result.calibration->t_b_c : t_b_c),
              1e-12);
  EXPECT_NEAR(result.scale / meanBaseline(exact.truth, t_b_c), 1.0, 0.05);
}

// ---- motions and data from which no scale can be had ----

// With the gyroscope bias of those without an estimate, and the gravity of one that stands still.
TEST_P(HostMethod, EveryMotionHasItsStatus) {
  struct Case {
    Motion motion;
    InitStatus status;
    double max_bias_error;  // [rad/s]
  };
  constexpr double kAny = std::numeric_limits<double>::infinity();
  for (const Case& one : {Case{Motion::kExcited, InitStatus::kSuccess, kAny},
                          Case{Motion::kConstantVelocity, InitStatus::kTooLittleExcitation, kAny},
                          Case{Motion::kPureRotation, InitStatus::kPureRotation, 1e-2},
                          Case{Motion::kHover, InitStatus::kStationary, 2e-3}}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const ExactWindow exact = noisyWindow(one.motion, seed);
      const InitResult result = solve(exact, GateMode::kOn);
      EXPECT_EQ(result.status, one.status) << "seed " << seed << ": " << result.message;
      if (one.max_bias_error == kAny) continue;
      EXPECT_FALSE(result.hasEstimate());
      EXPECT_LT((result.gyro_bias - exact.truth[0].gyro_bias).norm(), one.max_bias_error);
      if (one.motion != Motion::kHover) continue;
      EXPECT_TRUE(std::isnan(result.scale));
      EXPECT_LT(gravityErrorRad(result.gravity_b0, exact.truth[0]), 0.5 * M_PI / 180);
      EXPECT_TRUE(isWait(result.status));
    }
  }
}

// Twice as uncertain once there is no better attitude to wait for.
TEST(Slim, EveryWindowAnswersForItsAttitude) {
  for (const double interval_s : {0.15, 0.33}) {
    ExactWindowOptions options;
    options.interval_s = interval_s;
    const ExactWindow exact = noisyWindow(options);
    const InitResult result = makeSolver("slim")->solve(*exact.window);
    const auto gate =
        std::find_if(result.gates.begin(), result.gates.end(),
                     [](const GateValue& one) { return one.name == GateName::kTiltSigma; });
    ASSERT_NE(gate, result.gates.end()) << result.message;
    EXPECT_TRUE(gate->enforced && gate->passed) << gate->value;
    EXPECT_EQ(gate->threshold, interval_s < 0.2 ? 1.5 : 3.0);
    EXPECT_EQ(gate->status_if_failed, InitStatus::kScaleTooUncertain);
  }
}

// The result with all forces multiplied by a factor.
InitResult withForces(double factor, Motion motion, unsigned seed) {
  ExactWindow exact = noisyWindow(motion, seed);
  for (ImuSample& sample : exact.imu) sample.accel *= factor;
  return makeSolver("slim")->solve(*windowOf(exact));
}

TEST(Slim, ForcesInGAreNamed) {
  const auto messageOf = [](Motion motion, double factor, unsigned seed = 1) {
    const InitResult result = withForces(factor, motion, seed);
    EXPECT_FALSE(result.success());
    return result.message;
  };
  const char* hint = "is the accelerometer in g";
  EXPECT_EQ(messageOf(Motion::kHover, 1.0).find(hint), std::string::npos);
  EXPECT_NE(messageOf(Motion::kHover, 1.0 / 9.8).find(hint), std::string::npos);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    EXPECT_NE(messageOf(Motion::kExcited, 1.0 / 9.8, seed).find(hint), std::string::npos) << seed;
  }
}

// Upside down and backwards everything fits, but for the points, which are behind the camera.
TEST(Slim, AnInvertedAccelerometerIsNamed) {
  const char* hint = "is the sign of the accelerometer inverted";
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const InitResult result = withForces(-1.0, Motion::kExcited, seed);
    EXPECT_EQ(result.status, InitStatus::kInconsistentResiduals) << seed << ": " << result.message;
    EXPECT_NE(result.message.find(hint), std::string::npos) << seed << ": " << result.message;
    EXPECT_TRUE(withForces(1.0, Motion::kExcited, seed).success()) << seed;
  }
}

TEST_P(HostMethod, PublishedMethodsHaveNoGatesOfTheirOwn) {
  // But for a scale that is not positive, which is no answer.
  for (GateMode mode : {GateMode::kOwn, GateMode::kOff}) {
    if (GetParam() == "slim" && mode == GateMode::kOwn) continue;  // slim has gates of its own
    int successes = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const InitResult result = solve(noisyWindow(Motion::kConstantVelocity, seed), mode);
      EXPECT_TRUE(result.hasEstimate());
      double scale = result.scale;  // of the alignment, in its own unit, where there is one
      for (const GateValue& gate : result.gates) {
        if (gate.name == GateName::kScalePositive) scale = gate.value;
      }
      if (scale > 1e-6) {
        EXPECT_EQ(result.status, InitStatus::kSuccess) << "seed " << seed;
        EXPECT_NE(result.message.find("not enforced"), std::string::npos) << result.message;
        ++successes;
      } else {
        EXPECT_EQ(result.status, InitStatus::kDegenerateAlignment) << "seed " << seed;
      }
    }
    EXPECT_GE(successes, 3);
  }
}

TEST_P(HostMethod, ANonPositiveScaleIsNeverASuccess) {
  // At rest and without gates the sign of the scale is that of the noise.
  int positive = 0, others = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const InitResult result = solve(noisyWindow(Motion::kHover, seed), GateMode::kOff);
    if (result.scale > 0.0) {
      ++positive;
    } else {
      ++others;
      EXPECT_EQ(result.status, InitStatus::kDegenerateAlignment)
          << "seed " << seed << ": " << result.message;
    }
  }
  // A linear alignment has no say in the sign; the others take the length of a trajectory.
  if (GetParam() == "drt-l" || GetParam() == "slim-paper") {
    EXPECT_GE(positive, 10);
    EXPECT_GE(others, 10);
  } else {
    EXPECT_EQ(others, 0);
  }
}

TEST_P(EveryMethod, AcceptsExcitedMotionAndNoOtherWithTheProjectsGates) {
  for (const Motion motion :
       {Motion::kExcited, Motion::kHover, Motion::kPureRotation, Motion::kConstantVelocity}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const InitResult result = solve(noisyWindow(motion, seed), GateMode::kOn);
      EXPECT_EQ(result.success(), motion == Motion::kExcited)
          << static_cast<int>(motion) << " seed " << seed << ": " << result.message;
      EXPECT_FALSE(result.message.empty());
      if (!result.success()) continue;
      EXPECT_GE(result.stages.size(), 3u);
      EXPECT_EQ(result.counts.keyframes, 10);
      EXPECT_GT(result.counts.point_tracks, 50);
    }
  }
}

TEST_P(EveryMethod, TooFewPointsIsTooFewTracks) {
  for (const int points : {0, 3, 7}) {
    for (const int lines : {0, 25}) {
      ExactWindowOptions options;
      options.points = points;
      options.lines = lines;
      options.parallel_lines_only = true;
      const InitResult result = solve(makeExactWindow(options), GateMode::kOff);
      EXPECT_EQ(result.status, InitStatus::kTooFewTracks) << points << ": " << result.message;
      EXPECT_FALSE(result.hasEstimate());
      if (points == 0) {
        EXPECT_FALSE(result.gyro_bias.allFinite());
      }
    }
  }
}

TEST_P(EveryMethod, ThreeKeyframesAreTooFew) {
  for (const int keyframes : {2, 3}) {
    ExactWindowOptions options;
    options.keyframes = keyframes;
    const InitResult result = solve(makeExactWindow(options), GateMode::kOff);
    EXPECT_EQ(result.status, InitStatus::kTooFewKeyframes) << result.message;
    EXPECT_NE(result.message.find("(minimum 4)"), std::string::npos) << result.message;
  }
}

// All points, and all lines, in one place of every image.
TEST_P(EveryMethod, ParallelBearingsAndCoincidentPointsDoNotCrash) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  std::vector<FrameObservation> frames = exact.keyframes;
  for (FrameObservation& frame : frames) {
    for (PointObservation& point : frame.points) point.bearing = Eigen::Vector3d::UnitZ();
    for (LineObservation& line : frame.lines) {
      line.start_bearing = Eigen::Vector3d(0, 0, 1);
      line.end_bearing = Eigen::Vector3d(0, 0.1, 1).normalized();
    }
  }
  const InitResult result = solve(*windowOf(exact, frames), GateMode::kOn);
  EXPECT_NE(result.status, InitStatus::kSuccess) << result.message;
}

// ---- what must not change the answer ----

TEST_P(EveryMethod, DoesNotCareForYawAndOriginOfTheWorld) {
  // The same motion and scene, turned and moved: the sensors see no difference.
  ExactWindowOptions moved;
  moved.yaw_rad = -2.1;
  moved.origin = Eigen::Vector3d(100, -50, 7);
  const InitResult a = solve(makeExactWindow(ExactWindowOptions()));
  const InitResult b = solve(makeExactWindow(moved));
  ASSERT_TRUE(a.success() && b.success());
  ASSERT_EQ(a.states.size(), b.states.size());
  const double same = isWholeSystem() ? 1e-4 : 1e-7;
  EXPECT_NEAR(a.scale, b.scale, same);
  EXPECT_LT((a.gravity_b0 - b.gravity_b0).norm(), same);
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    EXPECT_LT((a.states[k].p_w_b - b.states[k].p_w_b).norm(), same);
    EXPECT_LT((a.states[k].R_w_b - b.states[k].R_w_b).norm(), same);
  }
}

TEST_P(HostMethod, RenamedTracksMatterOnlyByRounding) {
  const ExactWindow exact = noisyWindow();
  std::vector<FrameObservation> frames = exact.keyframes;
  for (FrameObservation& frame : frames) {
    for (PointObservation& point : frame.points) point.id = 1000000 - 7 * point.id;
  }
  const InitResult a = solve(exact), b = solve(*windowOf(exact, frames));
  // slim sums over more and larger numbers before it stops at a third of a sigma.
  const double relative = GetParam() == "slim" ? 1e-6 : 1e-8;
  EXPECT_NEAR(a.scale, b.scale, relative);
  EXPECT_LT((a.gyro_bias - b.gyro_bias).norm(), 0.1 * relative);
}

TEST_P(HostMethod, StartOfTimeDoesNotMatter) {
  const ExactWindow exact = noisyWindow();
  std::vector<FrameObservation> frames = exact.keyframes;
  std::vector<ImuSample> imu = exact.imu;
  for (FrameObservation& frame : frames) frame.t += 1024.0;
  for (ImuSample& sample : imu) sample.t += 1024.0;
  const InitResult a = solve(exact), b = solve(*madeWindow(exact.calibration, frames, imu));
  EXPECT_NEAR(a.scale, b.scale, 1e-6);
  EXPECT_LT((a.gyro_bias - b.gyro_bias).norm(), 1e-8);
}

// Eight threads, each with all methods and windows in an order of its own: equal input gives equal
// bytes, whatever a solver has solved before and solves meanwhile.
TEST(Threads, MethodsAtOnceGiveWhatEachGivesAlone) {
  struct Task {
    const WindowSolver* solver;
    std::shared_ptr<const InitWindow> window;
    InitResult alone;
  };
  std::vector<std::unique_ptr<WindowSolver>> solvers;
  std::vector<Task> tasks;
  for (const std::string& name : baselines::namesOf(baselines::allMethods())) {
    solvers.push_back(makeSolver(name));
    for (const unsigned seed : {1u, 2u, 3u}) {
      const std::shared_ptr<const InitWindow> window = noisyWindow(seeded(seed)).window;
      tasks.push_back({solvers.back().get(), window, makeSolver(name)->solve(*window)});
    }
  }
  constexpr std::size_t kThreads = 8;
  std::vector<std::vector<InitResult>> results(kThreads, std::vector<InitResult>(tasks.size()));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kThreads; ++i) {
    threads.emplace_back([&tasks, &results, i] {
      for (std::size_t k = 0; k < tasks.size(); ++k) {
        const std::size_t task = (k + i * tasks.size() / kThreads) % tasks.size();
        results[i][task] = tasks[task].solver->solve(*tasks[task].window);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<InitResult>& of_thread : results) {
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      EXPECT_TRUE(sameBytes(tasks[k].alone, of_thread[k])) << tasks[k].solver->name();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod,
                         ::testing::ValuesIn(baselines::namesOf(baselines::allMethods())),
                         methodTestName);
INSTANTIATE_TEST_SUITE_P(Methods, HostMethod,
                         ::testing::ValuesIn(baselines::namesOf(baselines::methods())),
                         methodTestName);

// ---- the terms of slim-paper ----

class SlimPaperSwitches : public ::testing::Test {
 protected:
  // With these terms only.
  static InitResult solve(const ExactWindow& exact, bool vp, bool epipolar, bool normal) {
    BaselineOptions options;
    options.slim_paper.use_vp = vp;
    options.slim_paper.use_line_epipolar = epipolar;
    options.slim_paper.use_line_normal = normal;
    return makeSolver("slim-paper", {}, options)->solve(*exact.window);
  }
};

TEST_F(SlimPaperSwitches, WithoutLinesTheLineTermsChangeNothing) {
  ExactWindowOptions options;
  options.lines = 0;
  const ExactWindow exact = noisyWindow(options);
  EXPECT_TRUE(sameBytes(solve(exact, true, true, true), solve(exact, false, false, false)));
}

TEST_F(SlimPaperSwitches, EachTermChangesTheAnswerByItself) {
  ExactWindowOptions scene;
  scene.pixel_noise = 0.3;
  scene.parallel_lines_only = true;
  const ExactWindow exact = makeExactWindow(scene);
  const InitResult base = solve(exact, false, false, false);
  EXPECT_NE(solve(exact, true, false, false).gyro_bias, base.gyro_bias);
  for (const bool epipolar : {true, false}) {
    const InitResult with = solve(exact, false, epipolar, !epipolar);
    EXPECT_EQ(with.gyro_bias, base.gyro_bias);  // step 1 does not see the lines
    EXPECT_NE(with.scale, base.scale);
  }
}

}  // namespace
}  // namespace slim_init
