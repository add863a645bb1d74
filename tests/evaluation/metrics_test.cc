// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/metrics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "evaluation/circle_sequence.h"

namespace slim_init::evaluation {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = 3.14159265358979323846;

std::vector<Eigen::Vector3d> randomPoints(int count, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(engine);
    const double y = coordinate(engine);
    points.emplace_back(x, y, coordinate(engine));
  }
  return points;
}

std::vector<Eigen::Vector3d> transformed(const std::vector<Eigen::Vector3d>& points,
                                         const Similarity& similarity) {
  std::vector<Eigen::Vector3d> result;
  for (const Eigen::Vector3d& p : points) {
    result.push_back(similarity.s * similarity.R * p + similarity.t);
  }
  return result;
}

Similarity someSimilarity(double s, double angle) {
  Similarity similarity;
  similarity.s = s;
  similarity.R =
      Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  similarity.t = Eigen::Vector3d(3.0, -4.0, 5.0);
  return similarity;
}

double costOf(const std::vector<Eigen::Vector3d>& source,
              const std::vector<Eigen::Vector3d>& target, const Similarity& similarity) {
  double sum = 0.0;
  const auto mapped = transformed(source, similarity);
  for (std::size_t i = 0; i < source.size(); ++i) sum += (target[i] - mapped[i]).squaredNorm();
  return sum;
}

TEST(AlignSimilarity, RecoversKnownTransforms) {
  for (const double s : {0.01, 1.0, 250.0}) {
    for (const double angle : {0.0, 1e-8, 1.0, kPi - 1e-8, kPi}) {
      const Similarity truth = someSimilarity(s, angle);
      const auto source = randomPoints(10, 7);
      Similarity found;
      ASSERT_EQ(alignSimilarity(source, transformed(source, truth), &found), "");
      EXPECT_NEAR(found.s / s, 1.0, 1e-12) << "angle " << angle;
      EXPECT_NEAR((found.R - truth.R).norm(), 0.0, 1e-10) << "angle " << angle;
      EXPECT_NEAR((found.t - truth.t).norm(), 0.0, 1e-10 * (1.0 + s)) << "angle " << angle;
    }
  }
}

TEST(AlignSimilarity, NeverReflects) {
  const auto source = randomPoints(10, 3);
  std::vector<Eigen::Vector3d> mirrored;
  for (const Eigen::Vector3d& p : source) mirrored.emplace_back(p.x(), p.y(), -p.z());
  Similarity found;
  ASSERT_EQ(alignSimilarity(source, mirrored, &found), "");
  EXPECT_NEAR(found.R.determinant(), 1.0, 1e-12);
  EXPECT_LT(found.s, 1.0);
  EXPECT_GT(costOf(source, mirrored, found), 0.1);
}

TEST(AlignSimilarity, IsTheMinimumOfTheCostUnderNoise) {
  const Similarity truth = someSimilarity(1.7, 0.8);
  const auto source = randomPoints(10, 11);
  auto target = transformed(source, truth);
  const auto noise = randomPoints(10, 12);
  for (std::size_t i = 0; i < target.size(); ++i) target[i] += 0.05 * noise[i];
  Similarity found;
  ASSERT_EQ(alignSimilarity(source, target, &found), "");
  const double cost = costOf(source, target, found);
  for (int axis = 0; axis < 7; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      Similarity moved = found;
      if (axis < 3) {
        moved.R = found.R * Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
      } else if (axis < 6) {
        moved.t[axis - 3] += step;
      } else {
        moved.s += step;
      }
      EXPECT_GT(costOf(source, target, moved), cost) << "axis " << axis;
    }
  }
  EXPECT_NEAR(found.s, 1.7, 0.1);
}

TEST(AlignSimilarity, PlanarCollinearAndTwoPointsHaveAScale) {
  const Similarity truth = someSimilarity(2.5, 1.1);
  std::vector<Eigen::Vector3d> planar = randomPoints(10, 5);
  for (Eigen::Vector3d& p : planar) p.z() = 0.0;
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 10; ++i) line.emplace_back(0.1 * i * i, 0.2 * i * i, -0.1 * i * i);
  const std::vector<Eigen::Vector3d> two = {{0, 0, 0}, {1, 2, 3}};
  for (const auto& source : {planar, line, two}) {
    const auto target = transformed(source, truth);
    Similarity found;
    ASSERT_EQ(alignSimilarity(source, target, &found), "");
    EXPECT_NEAR(found.s, 2.5, 1e-12);
    EXPECT_NEAR(found.R.determinant(), 1.0, 1e-12);
    EXPECT_NEAR(costOf(source, target, found), 0.0, 1e-20);
  }
}

TEST(AlignSimilarity, DegenerateInputIsASentence) {
  Similarity found;
  const std::vector<Eigen::Vector3d> same(10, Eigen::Vector3d(1, 2, 3));
  EXPECT_NE(alignSimilarity(same, randomPoints(10, 1), &found), "");
  EXPECT_NE(alignSimilarity({}, {}, &found), "");
  EXPECT_NE(alignSimilarity({same[0]}, {same[0]}, &found), "");
  EXPECT_NE(alignSimilarity(same, {same[0]}, &found), "");
  auto bad = randomPoints(10, 1);
  bad[4].y() = kNan;
  EXPECT_NE(alignSimilarity(bad, randomPoints(10, 1), &found), "");
  EXPECT_NE(alignSimilarity(randomPoints(10, 1), bad, &found), "");
  bad[4].y() = std::numeric_limits<double>::infinity();
  EXPECT_NE(alignSimilarity(bad, randomPoints(10, 1), &found), "");
}

TEST(AlignSimilarity, MotionlessTruthHasScaleZero) {
  Similarity found;
  ASSERT_EQ(alignSimilarity(randomPoints(10, 1),
                            std::vector<Eigen::Vector3d>(10, Eigen::Vector3d(1, 2, 3)), &found),
            "");
  EXPECT_NEAR(found.s, 0.0, 1e-15);
}

class WindowMetricsTest : public ::testing::Test {
 protected:
  WindowMetricsTest() {
    for (int k = 0; k < 10; ++k) truth_.push_back(circle_.state(0.25 * k));
    result_ = perfectResult(truth_, circle_.g);
  }

  Circle circle_;
  std::vector<NavState> truth_;
  InitResult result_;
};

TEST_F(WindowMetricsTest, ScaleIsTruthOverEstimate) {
  for (NavState& state : result_.states) state.p_w_b /= 1.1;
  WindowMetrics m = evaluateWindow(result_, truth_);
  ASSERT_TRUE(m.computed()) << m.failure;
  EXPECT_NEAR(m.scale, 1.1, 1e-12);
  EXPECT_NEAR(m.scale_error, 0.1, 1e-12);
  EXPECT_NEAR(m.pose_rmse, 0.0, 1e-12);  // alignment takes the scale out
  EXPECT_TRUE(m.success());
  for (NavState& state : result_.states) state.p_w_b /= 1.5;
  m = evaluateWindow(result_, truth_);
  EXPECT_NEAR(m.scale, 1.65, 1e-12);
  EXPECT_FALSE(m.success());
}

TEST_F(WindowMetricsTest, AnEstimateThatRunsTheWrongWayIsNoSuccess) {
  for (NavState& state : result_.states) state.p_w_b = -state.p_w_b;
  const WindowMetrics metrics = evaluateWindow(result_, truth_);
  ASSERT_TRUE(metrics.computed()) << metrics.failure;
  EXPECT_LT(metrics.scale, 0.0);
  EXPECT_GT(metrics.scale_error, 1.0);
}

TEST_F(WindowMetricsTest, APerfectAnswerInAnyWorldHasNoError) {
  // A method's world starts at the first body with zero yaw; yaw and origin are free.
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.9, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (NavState& state : result_.states) {
    state.p_w_b = R * state.p_w_b + Eigen::Vector3d(7, 8, 9);
    state.v_w_b = R * state.v_w_b;
    state.R_w_b = R * state.R_w_b;
  }
  const WindowMetrics m = evaluateWindow(result_, truth_);
  ASSERT_TRUE(m.computed()) << m.failure;
  EXPECT_TRUE(m.success());
  EXPECT_NEAR(m.scale, 1.0, 1e-12);
  EXPECT_NEAR(m.scale_error, 0.0, 1e-12);
  EXPECT_NEAR(m.pose_rmse, 0.0, 1e-12);
  EXPECT_NEAR(m.velocity_rmse, 0.0, 1e-12);
  EXPECT_NEAR(m.velocity_vec_rmse, 0.0, 1e-12);
  EXPECT_NEAR(m.gravity_error_deg, 0.0, 1e-10);
  EXPECT_NEAR(m.gyro_bias_err_pct, 0.0, 1e-10);
  EXPECT_NEAR(m.gyro_bias_vec_err, 0.0, 1e-13);
}

TEST_F(WindowMetricsTest, VelocityErrorsByHand) {
  // Speeds 20 % too high at half of the keyframes: sqrt((0.2 * 1.6)^2 / 2).
  for (int k = 0; k < 5; ++k) result_.states[k].v_w_b *= 1.2;
  WindowMetrics m = evaluateWindow(result_, truth_);
  EXPECT_NEAR(m.velocity_rmse, 0.2 * 1.6 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(m.velocity_vec_rmse, 0.2 * 1.6 / std::sqrt(2.0), 1e-12);
  // Right speeds, opposite direction: only the vectors see it.
  result_ = perfectResult(truth_, circle_.g);
  for (NavState& state : result_.states) state.v_w_b *= -1.0;
  m = evaluateWindow(result_, truth_);
  EXPECT_NEAR(m.velocity_rmse, 0.0, 1e-12);
  EXPECT_NEAR(m.velocity_vec_rmse, 2.0 * 1.6, 1e-12);
}

TEST_F(WindowMetricsTest, PoseErrorIsWhatAlignmentCannotExplain) {
  // Alternating offsets out of the plane are orthogonal to every rotation of a symmetric pattern
  // only approximately; a bound on both sides is enough here.
  for (int k = 0; k < 10; ++k) result_.states[k].p_w_b.z() += k % 2 == 0 ? 0.1 : -0.1;
  const WindowMetrics m = evaluateWindow(result_, truth_);
  EXPECT_GT(m.pose_rmse, 0.08);
  EXPECT_LT(m.pose_rmse, 0.1 + 1e-9);
}

TEST_F(WindowMetricsTest, GravityAngleIsTakenInTheFirstBodyFrame) {
  result_.gravity_b0 =
      Eigen::AngleAxisd(2.0 * kPi / 180.0, Eigen::Vector3d::UnitX()).toRotationMatrix() *
      result_.gravity_b0;
  EXPECT_NEAR(evaluateWindow(result_, truth_).gravity_error_deg, 2.0, 1e-10);
  result_.gravity_b0 *= 0.5;  // the length does not matter
  EXPECT_NEAR(evaluateWindow(result_, truth_).gravity_error_deg, 2.0, 1e-10);
  result_.gravity_b0 = -perfectResult(truth_, circle_.g).gravity_b0;
  EXPECT_NEAR(evaluateWindow(result_, truth_).gravity_error_deg, 180.0, 1e-10);
}

TEST_F(WindowMetricsTest, GyroBiasErrorsByHand) {
  result_.gyro_bias = 1.1 * circle_.gyro_bias;
  WindowMetrics m = evaluateWindow(result_, truth_);
  EXPECT_NEAR(m.gyro_bias_err_pct, 10.0, 1e-10);
  EXPECT_NEAR(m.gyro_bias_vec_err, 0.1 * circle_.gyro_bias.norm(), 1e-14);
  result_.gyro_bias = -circle_.gyro_bias;  // the paper's number is blind to direction
  m = evaluateWindow(result_, truth_);
  EXPECT_NEAR(m.gyro_bias_err_pct, 0.0, 1e-10);
  EXPECT_NEAR(m.gyro_bias_vec_err, 2.0 * circle_.gyro_bias.norm(), 1e-14);
  // The truth is the mean over the keyframes.
  for (int k = 0; k < 10; ++k) truth_[k].gyro_bias *= k < 5 ? 0.5 : 1.5;
  result_.gyro_bias = circle_.gyro_bias;
  EXPECT_NEAR(evaluateWindow(result_, truth_).gyro_bias_vec_err, 0.0, 1e-14);
}

TEST_F(WindowMetricsTest, ZeroTrueBiasHasNoPercentage) {
  for (NavState& state : truth_) state.gyro_bias.setZero();
  const WindowMetrics m = evaluateWindow(result_, truth_);
  ASSERT_TRUE(m.computed()) << m.failure;
  EXPECT_TRUE(std::isnan(m.gyro_bias_err_pct));
  EXPECT_TRUE(std::isfinite(m.gyro_bias_vec_err));
}

TEST_F(WindowMetricsTest, ValuesThatAreNotFiniteFailTheWindow) {
  const double inf = std::numeric_limits<double>::infinity();
  const InitResult good = result_;
  const std::vector<std::function<void(InitResult&)>> damages = {
      [](InitResult& r) { r.states[3].p_w_b.x() = kNan; },
      [&](InitResult& r) { r.states[3].v_w_b.y() = inf; },
      [](InitResult& r) { r.states[0].R_w_b(1, 1) = kNan; },
      [](InitResult& r) { r.gravity_b0.z() = kNan; },
      [](InitResult& r) { r.gravity_b0.setZero(); },
      [](InitResult& r) { r.gyro_bias.x() = kNan; },
      [](InitResult& r) { r.states.pop_back(); },
      [](InitResult& r) { r.states.clear(); },
      [](InitResult& r) {
        for (NavState& state : r.states) state.p_w_b.setConstant(1.0);
      },
      [](InitResult& r) {
        for (NavState& state : r.states) state.v_w_b.setConstant(1e200);
      },
  };
  for (std::size_t i = 0; i < damages.size(); ++i) {
    InitResult bad = good;
    damages[i](bad);
    const WindowMetrics m = evaluateWindow(bad, truth_);
    EXPECT_FALSE(m.computed()) << "case " << i;
    EXPECT_FALSE(m.success()) << "case " << i;
    EXPECT_TRUE(std::isnan(m.scale_error)) << "case " << i;
    EXPECT_TRUE(std::isnan(m.velocity_rmse)) << "case " << i;
  }
  truth_[2].v_w_b.x() = kNan;
  EXPECT_FALSE(evaluateWindow(good, truth_).computed());
}

/// A window over [0, 2.25] s with a specific force of our choice and a constant rate about x.
std::shared_ptr<const InitWindow> makeForceWindow(
    const std::function<Eigen::Vector3d(double)>& force, double rate = 0.0) {
  std::vector<ImuSample> imu;
  for (int k = 0; k <= 450; ++k) {
    ImuSample sample;
    sample.t = k / 200.0;
    sample.gyro = Eigen::Vector3d(rate, 0.0, 0.0);
    sample.accel = force(sample.t);
    imu.push_back(sample);
  }
  std::vector<FrameObservation> frames(10);
  for (int k = 0; k < 10; ++k) frames[k].t = 0.25 * k;
  return InitWindow::create(Calibration(), frames, imu);
}

TEST(ExcitationGate, BothSidesOfTheMeanForce) {
  const double g = Calibration().gravity_magnitude;
  const auto along = [g](double factor) {
    return makeForceWindow([=](double) { return Eigen::Vector3d(0.0, 0.0, factor * g); });
  };
  const Excitation strong = measureExcitation(*along(1.006));
  EXPECT_TRUE(strong.excited);
  EXPECT_NEAR(strong.mean_deviation, 0.006, 1e-12);
  EXPECT_EQ(strong.quiet_pairs, 0);
  const Excitation weak = measureExcitation(*along(1.004));
  EXPECT_FALSE(weak.excited);
  EXPECT_EQ(weak.quiet_pairs, 9);
  EXPECT_TRUE(measureExcitation(*along(0.994)).excited);
  EXPECT_FALSE(measureExcitation(*along(0.996)).excited);
}

TEST(ExcitationGate, OneQuietPairIsAllowedTwoAreNot) {
  const double g = Calibration().gravity_magnitude;
  const auto quiet_until = [g](double t_quiet) {
    return makeForceWindow(
        [=](double t) { return Eigen::Vector3d(0.0, 0.0, t <= t_quiet ? g : 1.1 * g); });
  };
  // The step from quiet to strong takes one sample, which belongs to the next pair.
  const Excitation one = measureExcitation(*quiet_until(0.25));
  EXPECT_EQ(one.quiet_pairs, 1);
  EXPECT_TRUE(one.excited);
  const Excitation two = measureExcitation(*quiet_until(0.5));
  EXPECT_EQ(two.quiet_pairs, 2);
  EXPECT_GT(two.mean_deviation, 5e-3);
  EXPECT_FALSE(two.excited);
}

TEST(ExcitationGate, ForceIsIntegratedInTheFrameOfTheFirstKeyframeOfAPair) {
  // A force that turns with the body against its rotation is constant in frame i: rotating by the
  // gyro must bring it back. Without the rotation, the mean over half a turn would nearly vanish.
  const double g = Calibration().gravity_magnitude;
  const double rate = 4.0 * kPi;  // half a turn per pair
  const auto window = makeForceWindow(
      [=](double t) {
        return Eigen::Vector3d(
            1.1 * g * Eigen::AngleAxisd(-rate * t, Eigen::Vector3d::UnitX()).toRotationMatrix() *
            Eigen::Vector3d::UnitZ());
      },
      rate);
  const Excitation excitation = measureExcitation(*window);
  EXPECT_EQ(excitation.quiet_pairs, 0);
  // In frame i the force has turned by half a turn from pair to pair: nine of them leave one ninth.
  EXPECT_NEAR(excitation.mean_deviation, 1.0 - 1.1 / 9.0, 1e-3);
}

TEST(WindowMetrics, GravityAndBiasOfAnAnswerWithoutStates) {
  const Circle circle;
  const std::vector<NavState> truth = {circle.state(1.0), circle.state(1.5)};
  InitResult result;
  result.status = InitStatus::kStationary;
  // Three degrees about an axis at right angles to gravity.
  const Eigen::Vector3d down = truth[0].R_w_b.transpose() * Eigen::Vector3d(0.0, 0.0, -9.81);
  const Eigen::Vector3d axis = down.unitOrthogonal();
  result.gravity_b0 = Eigen::AngleAxisd(3.0 * 3.14159265358979 / 180.0, axis) * down;
  result.gyro_bias = 1.1 * circle.gyro_bias;
  WindowMetrics metrics = evaluateWindow(result, truth);
  EXPECT_EQ(metrics.failure, "no estimate");
  EXPECT_NEAR(metrics.gravity_error_deg, 3.0, 1e-9);
  EXPECT_NEAR(metrics.gyro_bias_err_pct, 10.0, 1e-9);
  EXPECT_NEAR(metrics.gyro_bias_vec_err, 0.1 * circle.gyro_bias.norm(), 1e-12);

  // What was not said is not judged.
  result.gravity_b0.setConstant(kNotComputed);
  metrics = evaluateWindow(result, truth);
  EXPECT_TRUE(std::isnan(metrics.gravity_error_deg));
  EXPECT_NEAR(metrics.gyro_bias_err_pct, 10.0, 1e-9);
  metrics = evaluateWindow(InitResult(), truth);
  EXPECT_TRUE(std::isnan(metrics.gyro_bias_vec_err));
  result = perfectResult(truth, circle.g);
  result.states.clear();
  EXPECT_NEAR(evaluateWindow(result, truth).gravity_error_deg, 0.0, 1e-6);
  EXPECT_TRUE(std::isnan(evaluateWindow(result, {}).gravity_error_deg));
}

}  // namespace
}  // namespace slim_init::evaluation
