// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/trajectory.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "geometry/so3.h"
#include "support/exact_window.h"
#include "support/method_name.h"
#include "support/text_parts.h"

namespace slim_init::simulation {
namespace {

constexpr double kDegree = 3.141592653589793 / 180.0;

std::unique_ptr<Trajectory> builtin(const std::string& name, double duration = 60.0,
                                    unsigned seed = 1) {
  std::string error;
  auto trajectory = makeBuiltinTrajectory(name, duration, eurocCalibration().R_b_c, seed, &error);
  EXPECT_NE(trajectory, nullptr) << error;
  return trajectory;
}

// Largest difference of velocity, acceleration and angular rate to central differences.
void expectConsistent(const Trajectory& trajectory, double tolerance) {
  constexpr double kStep = 1e-4;  // [s]
  for (double t = trajectory.begin() + 0.01; t < trajectory.end() - 0.01; t += 0.0731) {
    const Kinematics before = trajectory.at(t - kStep);
    const Kinematics now = trajectory.at(t);
    const Kinematics after = trajectory.at(t + kStep);
    const Eigen::Vector3d v = (after.p_w_b - before.p_w_b) / (2.0 * kStep);
    const Eigen::Vector3d a = (after.v_w_b - before.v_w_b) / (2.0 * kStep);
    const Eigen::Vector3d omega = (logSO3(now.R_w_b.transpose() * after.R_w_b) -
                                   logSO3(now.R_w_b.transpose() * before.R_w_b)) /
                                  (2.0 * kStep);
    ASSERT_LT((v - now.v_w_b).norm(), tolerance) << "velocity at " << t;
    ASSERT_LT((a - now.a_w_b).norm(), tolerance) << "acceleration at " << t;
    ASSERT_LT((omega - now.omega_b).norm(), tolerance) << "angular rate at " << t;
    ASSERT_LT((now.R_w_b.transpose() * now.R_w_b - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
}

class BuiltinTrajectory : public testing::TestWithParam<std::string> {};

TEST_P(BuiltinTrajectory, DerivativesAreExact) {
  // Third derivatives reach 130 m/s^4 (step of the walk): h^2/6 of that is 2e-7.
  constexpr double kTolerance = 1e-6;
  for (const unsigned seed : {1U, 2U, 99U}) {
    SCOPED_TRACE(seed);
    expectConsistent(*builtin(GetParam(), 60.0, seed), kTolerance);
  }
}

TEST_P(BuiltinTrajectory, SeedSetsPhases) {
  const auto a = builtin(GetParam(), 60.0, 5);
  const auto b = builtin(GetParam(), 60.0, 5);
  const auto c = builtin(GetParam(), 60.0, 6);
  for (const double t : {0.0, 1.7, 30.0, 60.0}) {
    EXPECT_EQ(a->at(t).p_w_b, b->at(t).p_w_b);
    EXPECT_EQ(a->at(t).R_w_b, b->at(t).R_w_b);
    EXPECT_NE(a->at(t).R_w_b, c->at(t).R_w_b);
  }
}

TEST_P(BuiltinTrajectory, ClampsAndCovers) {
  const auto trajectory = builtin(GetParam(), 12.5);
  EXPECT_EQ(trajectory->begin(), 0.0);
  EXPECT_EQ(trajectory->end(), 12.5);
  EXPECT_EQ(trajectory->at(7.0).p_w_b, builtin(GetParam(), 600.0)->at(7.0).p_w_b);
  EXPECT_EQ(trajectory->at(-1.0).p_w_b, trajectory->at(0.0).p_w_b);
  EXPECT_EQ(trajectory->at(20.0).p_w_b, trajectory->at(12.5).p_w_b);
  EXPECT_TRUE(trajectory->covers(0.0));
  EXPECT_TRUE(trajectory->covers(12.5));
  EXPECT_FALSE(trajectory->covers(-0.001));
  EXPECT_FALSE(trajectory->covers(12.501));
}

TEST_P(BuiltinTrajectory, CameraIsUpright) {
  const auto trajectory = builtin(GetParam());
  for (double t = 0.0; t < 60.0; t += 0.1) {
    const Eigen::Vector3d down_w = trajectory->at(t).R_w_b * eurocCalibration().R_b_c.col(1);
    ASSERT_LT(down_w.z(), -std::cos(30.0 * kDegree)) << t;
  }
}

INSTANTIATE_TEST_SUITE_P(All, BuiltinTrajectory, testing::ValuesIn(builtinTrajectoryNames()),
                         methodTestName);

// Extremes of a motion over 60 s and several seeds.
struct Extremes {
  double min_speed = 1e9;         // [m/s]
  double max_speed = 0.0;         // [m/s]
  double max_offset = 0.0;        // distance from the place (0, 0, 1.5) [m]
  double max_turn_deg = 0.0;      // angle from the level forward pose
  double min_forward = 1.0;       // cosine of the camera's axis with world x
  double rms_acceleration = 0.0;  // [m/s^2]
};

Extremes extremesOf(const std::string& name) {
  Extremes e;
  Eigen::Matrix3d R_h_c;
  R_h_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  double sum = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto trajectory = builtin(name, 60.0, seed);
    for (double t = 0.0; t <= 60.0; t += 0.02) {
      const Kinematics k = trajectory->at(t);
      const Eigen::Matrix3d R_w_c = k.R_w_b * eurocCalibration().R_b_c;
      e.min_speed = std::min(e.min_speed, k.v_w_b.norm());
      e.max_speed = std::max(e.max_speed, k.v_w_b.norm());
      e.max_offset = std::max(e.max_offset, (k.p_w_b - Eigen::Vector3d(0, 0, 1.5)).norm());
      const double turn = logSO3(R_h_c.transpose() * R_w_c).norm() / kDegree;
      e.max_turn_deg = std::max(e.max_turn_deg, turn);
      e.min_forward = std::min(e.min_forward, R_w_c(0, 2));
      sum += k.a_w_b.squaredNorm();
      ++count;
    }
  }
  e.rms_acceleration = std::sqrt(sum / count);
  return e;
}

TEST(BuiltinMotion, EachIsWhatItsNameSays) {
  constexpr double kAny = 1e9;
  const struct {
    const char* name;
    double min_speed, max_speed, min_offset, max_offset, min_turn_deg, max_turn_deg;
    double min_forward;  // near one: looks at one wall, so that tracks live
    double min_acceleration, max_acceleration;
  } cases[] = {
      {"hover", 0.0, 0.01, 0.001, 0.003, 0.0, 0.2, -1.0, 0.0, 0.05},
      {"circle", 0.5, 1.7, 0.0, 2.6, 0.0, kAny, 0.75, 0.5, kAny},
      {"figure-eight", 0.5, 1.7, 0.0, 2.6, 0.0, kAny, 0.75, 0.5, kAny},
      // A walking person's bounce.
      {"corridor-walk", 0.6, 1.1, 0.0, kAny, 0.0, kAny, 0.98, 0.5, 2.0},
      {"constant-velocity", 0.45, 0.60, 0.0, kAny, 0.0, kAny, -1.0, 0.0, 0.3},
      {"pure-rotation", 0.0, 0.0, 0.0, 0.0, 25.0, 45.0, -1.0, 0.0, kAny},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.name);
    const Extremes e = extremesOf(one.name);
    EXPECT_GE(e.min_speed, one.min_speed);
    EXPECT_LE(e.max_speed, one.max_speed);
    EXPECT_GE(e.max_offset, one.min_offset);
    EXPECT_LE(e.max_offset, one.max_offset);
    EXPECT_GE(e.max_turn_deg, one.min_turn_deg);
    EXPECT_LE(e.max_turn_deg, one.max_turn_deg);
    EXPECT_GE(e.min_forward, one.min_forward);
    EXPECT_GE(e.rms_acceleration, one.min_acceleration);
    EXPECT_LE(e.rms_acceleration, one.max_acceleration);
  }
  EXPECT_NEAR(builtin("constant-velocity")->at(60.0).p_w_b.x(), 30.0, 1e-9);
  const auto walk = builtin("corridor-walk");
  EXPECT_NEAR(walk->at(60.0).p_w_b.x(), 48.0, 0.3);
  for (double t = 0.0; t < 60.0; t += 0.05) EXPECT_LT(std::abs(walk->at(t).p_w_b.y()), 0.1);
}

TEST(BuiltinMotion, RefusesAnUnknownName) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  std::string error;
  EXPECT_EQ(makeBuiltinTrajectory("spiral", 10.0, I, 1, &error), nullptr);
  expectParts(error, "'spiral'|figure-eight");
}

// Samples of a trajectory at a mean rate; times are shaken by up to a third of the period.
std::vector<NavState> sample(const Trajectory& trajectory, double rate_hz, bool with_velocity,
                             double epoch = 0.0) {
  std::mt19937_64 engine(7);
  std::vector<NavState> samples;
  for (int k = 0; k / rate_hz <= trajectory.end(); ++k) {
    const double shake = (static_cast<double>(engine() % 1000) / 999.0 - 0.5) * 0.66 / rate_hz;
    const double t = std::clamp(k / rate_hz + shake, 0.0, trajectory.end());
    if (!samples.empty() && t + epoch <= samples.back().t) continue;
    samples.push_back(stateAt(trajectory, t));
    samples.back().t += epoch;
    if (!with_velocity) samples.back().v_w_b.setConstant(kNotComputed);
  }
  return samples;
}

struct Errors {
  double p = 0.0, rotation = 0.0, v = 0.0, a = 0.0, omega = 0.0;
};

Errors compare(const Trajectory& truth, const Trajectory& sampled, double from, double to,
               double epoch = 0.0) {
  Errors e;
  for (double t = from; t <= to; t += 0.00317) {
    const Kinematics x = truth.at(t);
    const Kinematics y = sampled.at(t + epoch);
    e.p = std::max(e.p, (x.p_w_b - y.p_w_b).norm());
    e.rotation = std::max(e.rotation, logSO3(x.R_w_b.transpose() * y.R_w_b).norm());
    e.v = std::max(e.v, (x.v_w_b - y.v_w_b).norm());
    e.a = std::max(e.a, (x.a_w_b - y.a_w_b).norm());
    e.omega = std::max(e.omega, (x.omega_b - y.omega_b).norm());
  }
  return e;
}

// Bounds are about four times the cubic's remainder at even times (3/128 f'''' h^4 in value,
// f'''' h^3 / 12 in rate) for the fastest sinusoid of each motion; shaken times stretch the nodes.
// They shrink by 10^4 and 10^3 from 20 to 200 Hz, which a wrong order of interpolation would not.
struct Accuracy {
  const char* name;
  double rate_hz;
  bool with_velocity;
  double p, rotation, v, a, omega;  // [m, rad, m/s, m/s^2, rad/s]
};

void PrintTo(const Accuracy& a, std::ostream* out) {
  *out << a.name << " at " << a.rate_hz << " Hz" << (a.with_velocity ? " with velocities" : "");
}

class SampledAccuracy : public testing::TestWithParam<Accuracy> {};

TEST_P(SampledAccuracy, ReproducesAnalyticMotion) {
  const Accuracy& bound = GetParam();
  const auto truth = builtin(bound.name, 20.0);
  std::string error;
  const auto sampled =
      makeSampledTrajectory(sample(*truth, bound.rate_hz, bound.with_velocity), &error);
  ASSERT_NE(sampled, nullptr) << error;
  const Errors e = compare(*truth, *sampled, 1.0, 19.0);
  EXPECT_LT(e.p, bound.p);
  EXPECT_LT(e.rotation, bound.rotation);
  EXPECT_LT(e.v, bound.v);
  EXPECT_LT(e.a, bound.a);
  EXPECT_LT(e.omega, bound.omega);
}

INSTANTIATE_TEST_SUITE_P(
    Rates, SampledAccuracy,
    testing::Values(Accuracy{"circle", 20.0, true, 2e-5, 2e-5, 1e-4, 1e-2, 2e-3},
                    Accuracy{"circle", 20.0, false, 2e-5, 2e-5, 1e-3, 1e-1, 2e-3},
                    Accuracy{"circle", 200.0, true, 2e-9, 2e-9, 1e-8, 1e-5, 2e-6},
                    Accuracy{"circle", 200.0, false, 2e-9, 2e-9, 1e-6, 1e-3, 2e-6},
                    Accuracy{"corridor-walk", 20.0, true, 8e-5, 2e-4, 9e-4, 5e-2, 1e-2},
                    Accuracy{"corridor-walk", 20.0, false, 8e-5, 2e-4, 4e-3, 4e-1, 1e-2},
                    Accuracy{"corridor-walk", 200.0, true, 8e-9, 2e-8, 9e-8, 5e-5, 1e-5},
                    Accuracy{"corridor-walk", 200.0, false, 8e-9, 2e-8, 4e-6, 4e-3, 1e-5},
                    Accuracy{"pure-rotation", 20.0, true, 1e-12, 5e-5, 1e-12, 1e-12, 2e-3},
                    Accuracy{"pure-rotation", 200.0, false, 1e-12, 5e-9, 1e-10, 1e-7, 2e-6}));

TEST(SampledTrajectory, CubicMotionAndConstantTurnAreExact) {
  const Eigen::Vector3d c0(1, -2, 3), c1(0.5, 0.1, -0.4), c2(0.2, -0.3, 0.1), c3(-0.05, 0.02, 0.1);
  const Eigen::Vector3d omega(0.3, -0.5, 0.8);
  std::vector<NavState> samples;
  for (const double t : {0.0, 0.03, 0.10, 0.14, 0.21, 0.30, 0.33}) {
    NavState s;
    s.t = t;
    s.p_w_b = c0 + t * c1 + t * t * c2 + t * t * t * c3;
    s.v_w_b.setConstant(kNotComputed);
    s.R_w_b = expSO3(t * omega);
    samples.push_back(s);
  }
  const auto trajectory = makeSampledTrajectory(samples);
  ASSERT_NE(trajectory, nullptr);
  constexpr double kRounding = 1e-10;
  for (double t = 0.0; t <= 0.33; t += 0.007) {
    const Kinematics k = trajectory->at(t);
    EXPECT_LT((k.p_w_b - (c0 + t * c1 + t * t * c2 + t * t * t * c3)).norm(), kRounding);
    EXPECT_LT((k.v_w_b - (c1 + 2 * t * c2 + 3 * t * t * c3)).norm(), kRounding);
    EXPECT_LT((k.a_w_b - (2 * c2 + 6 * t * c3)).norm(), kRounding);
    EXPECT_LT((k.omega_b - omega).norm(), kRounding);
    EXPECT_LT((k.R_w_b - expSO3(t * omega)).norm(), kRounding);
  }
}

TEST(SampledTrajectory, AngularRateIsTheDerivativeOfItsOwnRotation) {
  // Coarse samples make the tangent vector large, so that the right Jacobian matters.
  const auto truth = builtin("pure-rotation", 10.0);
  const auto sampled = makeSampledTrajectory(sample(*truth, 4.0, false));
  constexpr double kStep = 1e-5;
  for (double t = 1.0; t < 9.0; t += 0.0371) {
    const Kinematics now = sampled->at(t);
    const Eigen::Vector3d omega = (logSO3(now.R_w_b.transpose() * sampled->at(t + kStep).R_w_b) -
                                   logSO3(now.R_w_b.transpose() * sampled->at(t - kStep).R_w_b)) /
                                  (2.0 * kStep);
    EXPECT_LT((omega - now.omega_b).norm(), 1e-6) << t;
  }
}

TEST(SampledTrajectory, PassesThroughItsSamples) {
  const auto truth = builtin("figure-eight", 5.0);
  const std::vector<NavState> samples = sample(*truth, 20.0, true);
  const auto sampled = makeSampledTrajectory(samples);
  for (const NavState& s : samples) {
    EXPECT_LT((sampled->at(s.t).p_w_b - s.p_w_b).norm(), 1e-12);
    EXPECT_LT((sampled->at(s.t).v_w_b - s.v_w_b).norm(), 1e-12);
    EXPECT_LT((sampled->at(s.t).R_w_b - s.R_w_b).norm(), 1e-12);
  }
  EXPECT_EQ(sampled->at(-5.0).p_w_b, sampled->at(sampled->begin()).p_w_b);
  EXPECT_EQ(sampled->at(50.0).p_w_b, sampled->at(sampled->end()).p_w_b);
}

TEST(SampledTrajectory, WorksOnEpochTimes) {
  // Stamps of 1.4e9 s resolve 0.24 us, which is 0.4 um at 1.5 m/s.
  constexpr double kEpoch = 1403715273.0;
  const auto truth = builtin("circle", 10.0);
  const auto sampled = makeSampledTrajectory(sample(*truth, 200.0, true, kEpoch));
  const Errors e = compare(*truth, *sampled, 1.0, 9.0, kEpoch);
  EXPECT_LT(e.p, 1e-6);
  EXPECT_LT(e.v, 1e-5);
  EXPECT_LT(e.rotation, 1e-6);
}

TEST(SampledTrajectory, DoesNotTrustGaps) {
  const auto truth = builtin("circle", 10.0);
  std::vector<NavState> samples;
  for (int k = 0; k <= 200; ++k) {
    const double t = 0.05 * k;
    const bool in_gap = (t > 4.01 && t < 4.99) || (t > 7.01 && t < 7.99);
    const bool is_island = k == 150 || k == 151;  // two samples at 7.5 s
    if (in_gap && !is_island) continue;
    samples.push_back(stateAt(*truth, t));
  }
  const auto sampled = makeSampledTrajectory(samples);
  ASSERT_NE(sampled, nullptr);
  for (const double t : {0.0, 2.0, 3.99, samples[80].t, 5.001, 6.9, 8.01, samples.back().t}) {
    EXPECT_TRUE(sampled->covers(t)) << t;
  }
  for (const double t : {-0.01, 4.01, 4.5, 4.99, 7.2, 7.52, 7.9, 10.01}) {
    EXPECT_FALSE(sampled->covers(t)) << t;
  }
  // Beside a gap the four samples are taken from this side: as good as elsewhere up to the
  // one-sided remainder, six times the centred one.
  const Errors before = compare(*truth, *sampled, 3.85, 4.0);
  const Errors after = compare(*truth, *sampled, 5.001, 5.15);
  EXPECT_LT(before.p, 1e-4);
  EXPECT_LT(after.p, 1e-4);
  EXPECT_LT(before.v, 5e-4);
  EXPECT_LT(after.v, 5e-4);
  EXPECT_TRUE(sampled->at(4.5).p_w_b.allFinite());
  EXPECT_TRUE(sampled->at(7.52).R_w_b.allFinite());
}

TEST(SampledTrajectory, UsesPositionsWhereAVelocityIsMissing) {
  const auto truth = builtin("circle", 10.0);
  std::vector<NavState> samples = sample(*truth, 100.0, true);
  for (NavState& s : samples) {
    if (s.t > 5.0 && s.t < 5.02) s.v_w_b.y() = std::numeric_limits<double>::quiet_NaN();
  }
  const auto sampled = makeSampledTrajectory(samples);
  const Errors e = compare(*truth, *sampled, 4.8, 5.2);
  EXPECT_LT(e.v, 1e-4);
}

TEST(SmoothTrajectory, FollowsTheMotionAndItsAccelerationIntegratesBack) {
  for (const char* name : {"circle", "corridor-walk"}) {
    SCOPED_TRACE(name);
    const auto truth = builtin(name, 20.0);
    std::string error;
    const auto smooth = makeSmoothTrajectory(sample(*truth, 200.0, true), 20.0, &error);
    ASSERT_NE(smooth, nullptr) << error;
    const Errors e = compare(*truth, *smooth, 1.0, 19.0);
    EXPECT_LT(e.p, 2e-4);
    EXPECT_LT(e.v, 5e-3);
    EXPECT_LT(e.rotation, 5e-4);
    // Velocity and acceleration are the derivatives of this curve, not of the true one: position is
    // continuous with two derivatives, so that Simpson's sums close up to rounding.
    constexpr double kStep = 1e-3;  // [s]
    Eigen::Vector3d p = smooth->at(1.0).p_w_b;
    Eigen::Vector3d v = smooth->at(1.0).v_w_b;
    for (int k = 0; k < 18000; ++k) {
      const double t = 1.0 + k * kStep;
      const Kinematics a = smooth->at(t), b = smooth->at(t + 0.5 * kStep),
                       c = smooth->at(t + kStep);
      p += kStep / 6.0 * (a.v_w_b + 4.0 * b.v_w_b + c.v_w_b);
      v += kStep / 6.0 * (a.a_w_b + 4.0 * b.a_w_b + c.a_w_b);
    }
    constexpr double kKinks = 1e-5;  // [m, m/s] Simpson across the kinks of the acceleration
    EXPECT_LT((p - smooth->at(19.0).p_w_b).norm(), kKinks);
    EXPECT_LT((v - smooth->at(19.0).v_w_b).norm(), kKinks);
  }
}

TEST(SmoothTrajectory, ThinsToTheRateAndPassesThroughWhatIsLeft) {
  const auto truth = builtin("circle", 2.0);
  std::vector<NavState> samples;
  for (int k = 0; k <= 400; ++k) {
    NavState s;
    s.t = k / 200.0;
    s.p_w_b = truth->at(s.t).p_w_b;
    if (k % 10 != 0) s.p_w_b.x() += 0.01;  // only what is left out is wrong
    s.R_w_b = truth->at(s.t).R_w_b;
    samples.push_back(s);
  }
  const auto smooth = makeSmoothTrajectory(samples, 20.0);
  ASSERT_NE(smooth, nullptr);
  EXPECT_EQ(smooth->end(), 2.0);
  for (int k = 0; k <= 400; k += 10) {
    EXPECT_LT((smooth->at(k / 200.0).p_w_b - samples[k].p_w_b).norm(), 1e-12);
  }
}

TEST(SmoothTrajectory, RefusesWhatTheSampledOneRefuses) {
  std::vector<NavState> samples = sample(*builtin("circle", 10.0), 20.0, true);
  std::string error;
  EXPECT_EQ(makeSmoothTrajectory({samples.begin(), samples.begin() + 3}, 20.0, &error), nullptr);
  EXPECT_EQ(makeSmoothTrajectory(samples, 0.0, &error), nullptr);
  expectParts(error, "max_rate_hz");
  samples[9].t = samples[3].t;
  EXPECT_EQ(makeSmoothTrajectory(samples, 20.0, &error), nullptr);
  expectParts(error, "must be after");
}

TEST(SampledTrajectory, RefusesBadSamples) {
  const std::vector<NavState> good = sample(*builtin("circle", 10.0), 20.0, true);
  const auto refused = [&good](const std::string& part, const auto& spoil) {
    std::vector<NavState> bad = good;
    spoil(&bad);
    std::string error;
    EXPECT_EQ(makeSampledTrajectory(bad, &error), nullptr);
    expectParts(error, part);
  };
  refused("is 3", [](auto* bad) { bad->resize(3); });
  EXPECT_NE(makeSampledTrajectory({good.begin(), good.begin() + 4}), nullptr);
  refused("sample 7", [](auto* bad) { (*bad)[7].t = (*bad)[6].t; });
  refused("sample 3", [](auto* bad) { (*bad)[3].p_w_b.x() = kNotComputed; });
  refused("R_w_b", [](auto* bad) { (*bad)[5].R_w_b *= 1.1; });
  EXPECT_EQ(makeSampledTrajectory({}, nullptr), nullptr);
}

}  // namespace
}  // namespace slim_init::simulation
