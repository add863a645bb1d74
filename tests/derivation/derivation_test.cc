// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The formulas of docs/derivation.md against the code, where no other test holds them.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "epipolar_pair.h"
#include "estimation/refine_window.h"
#include "estimation/visual_inertial_problem.h"
#include "geometry/so3.h"
#include "linear_alignment.h"
#include "rotation/normalized_epipolar_pair.h"
#include "support/gaussian.h"
#include "support/jacobian_check.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

using namespace baselines;  // NOLINT: what these tests compare with

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A line and cameras that see it without noise; the camera is the body.
struct LineViews {
  Vector3d point, direction;  // in b0, unit direction
  WindowState state;
  std::vector<LineView> views;

  // Normal of the interpretation plane of view k in b0, for a state near `state`.
  Vector3d normal(int k, const WindowState& at) const {
    return at.R_b0_bk[k] * views[k].start_b.cross(views[k].end_b).normalized();
  }
};

LineViews makeLineViews(unsigned seed, int count) {
  Gaussian random(seed);
  LineViews out;
  out.point = Vector3d(0, 0, 4) + 0.5 * random.vector();
  out.direction = random.vector().normalized();
  out.state.p_b0.setZero(3, count);
  out.state.v_b0.setZero(3, count);
  for (int k = 0; k < count; ++k) {
    out.state.R_b0_bk.push_back(k == 0 ? Matrix3d(Matrix3d::Identity())
                                       : expSO3(0.2 * random.vector()));
    if (k > 0) out.state.p_b0.col(k) = 0.7 * random.vector();
    const auto seen = [&](double along) -> Vector3d {
      return (out.state.R_b0_bk[k].transpose() *
              (out.point + along * out.direction - out.state.p_b0.col(k)))
          .normalized();
    };
    out.views.push_back({k, seen(-0.5 - 0.2 * k), seen(0.7 + 0.1 * k)});
  }
  return out;
}

// det [N_i N_j N_k], and the sum a N_i.c_i + b N_j.c_j + c N_k.c_k with the coefficients of the
// identity (N_j x N_k . D) N_i + (N_k x N_i . D) N_j + (N_i x N_j . D) N_k = det D.
Eigen::Vector2d threeViewConstraints(const LineViews& line, int i, int j, int k,
                                     const WindowState& at) {
  const Vector3d N_i = line.normal(i, at), N_j = line.normal(j, at), N_k = line.normal(k, at);
  const double a = N_j.cross(N_k).dot(line.direction);
  const double b = N_k.cross(N_i).dot(line.direction);
  const double c = N_i.cross(N_j).dot(line.direction);
  const double det = N_i.dot(N_j.cross(N_k));
  EXPECT_LT((a * N_i + b * N_j + c * N_k - det * line.direction).norm(), 1e-14);
  return {det,
          a * N_i.dot(at.p_b0.col(i)) + b * N_j.dot(at.p_b0.col(j)) + c * N_k.dot(at.p_b0.col(k))};
}

TEST(Lines, Equation9IsTheBaselineAlongTheLineTimesTheSineBetweenThePlanes) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const LineViews line = makeLineViews(seed, 2);
    const Vector3d N_i = line.normal(0, line.state), N_j = line.normal(1, line.state);
    const double sine = N_i.cross(N_j).norm();
    const auto residual = [&](const Vector3d& baseline_b0) {
      const Matrix3d& R_i = line.state.R_b0_bk[0];
      return lineEpipolarResidual(R_i.transpose() * N_i, line.state.R_b0_bk[1].transpose() * N_j,
                                  R_i.transpose() * line.state.R_b0_bk[1],
                                  R_i.transpose() * baseline_b0);
    };
    const Vector3d t = line.state.p_b0.col(1) - line.state.p_b0.col(0);
    EXPECT_NEAR(std::abs(residual(t)), std::abs(t.dot(line.direction)) * sine, 1e-12);
    // The part of the baseline across the line, the only one that the images are moved by, is not
    // in it; the part along the line, which moves nothing, is all of it.
    const Vector3d along = t.dot(line.direction) * line.direction;
    EXPECT_NEAR(residual(t - along), 0.0, 1e-12);
    EXPECT_NEAR(residual(along), residual(t), 1e-12);
  }
}

// The left null space of the track's Jacobian, projected on the poses: 2 m - 4 rows.
MatrixXd eliminatedRows(const LineViews& line) {
  const int m = static_cast<int>(line.views.size());
  LineParameters parameters;
  EXPECT_TRUE(triangulate(line.views.data(), m, line.state, Vector3d::Zero(), &parameters));
  MatrixXd J_track(2 * m, 4), J_pose = MatrixXd::Zero(2 * m, 6 * m);
  for (int a = 0; a < m; ++a) {
    ViewDerivatives<4> view;
    evaluate(line.views[a], parameters, line.state, Vector3d(Vector3d::Zero()), 1.0, &view);
    J_track.middleRows<2>(2 * a) = view.J_track;
    J_pose.block<2, 6>(2 * a, 6 * line.views[a].keyframe) = view.J_pose;
  }
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(J_track).householderQ();
  return Q.rightCols(2 * m - 4).transpose() * J_pose;
}

// Largest part of a row of A, relative to A, outside the row space of B.
double outsideOf(const MatrixXd& A, const MatrixXd& B) {
  const MatrixXd V = Eigen::JacobiSVD<MatrixXd>(B, Eigen::ComputeThinV).matrixV();
  return (A - A * V * V.transpose()).norm() / A.norm();
}

TEST(Lines, EliminatedRowsAreTheTwoConstraintsOfThreeViews) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const LineViews line = makeLineViews(seed, 3);
    const MatrixXd rows = eliminatedRows(line);
    ASSERT_EQ(rows.rows(), 2);
    EXPECT_LT(threeViewConstraints(line, 0, 1, 2, line.state).cwiseAbs().maxCoeff(), 1e-12);
    const MatrixXd constraints = numericJacobian(
        [&](const VectorXd& d) -> VectorXd {
          VectorXd step = VectorXd::Zero(StateLayout(3).size());
          step.head<18>() = d;
          return threeViewConstraints(line, 0, 1, 2, retract(line.state, step));
        },
        18, 1e-5);
    constexpr double kDifferences = 1e-6;  // of the numeric derivative
    EXPECT_LT(outsideOf(constraints, rows), kDifferences) << "seed " << seed;
    EXPECT_LT(outsideOf(rows, constraints), kDifferences) << "seed " << seed;
  }
}

TEST(Lines, MoreViewsAddTwoRowsEach) {
  for (int m : {3, 4, 5, 8}) {
    const LineViews line = makeLineViews(11, m);
    Eigen::JacobiSVD<MatrixXd> svd(eliminatedRows(line));
    svd.setThreshold(1e-9);
    EXPECT_EQ(svd.rank(), 2 * m - 4);
  }
}

constexpr double kSigma = 1.3e-3;  // 0.6 px at EuRoC's focal length [rad]

// Points of a pair; the same for every draw of the noise.
struct Pair {
  Matrix3d R_ci_cj = expSO3({0.05, -0.12, 0.08});
  std::vector<Vector3d> f_i, f_j;
};

Pair makePair(int points, const Vector3d& t) {
  Gaussian random(7);
  Pair pair;
  for (int k = 0; k < points; ++k) {
    const double z = random.uniform(2.0, 8.0);
    const double x = random.uniform(-0.7, 0.7), y = random.uniform(-0.5, 0.5);
    const Vector3d X(x * z, y * z, z);
    pair.f_i.push_back(X.normalized());
    pair.f_j.push_back((pair.R_ci_cj.transpose() * (X - t)).normalized());
  }
  return pair;
}

template <typename Sink>
void addNoisy(const Pair& pair, double sigma, unsigned seed, Sink* sink) {
  Gaussian random(seed);
  const auto noisy = [&](const Vector3d& f) -> Vector3d {
    const double x = random(), y = random();
    return (f + sigma * (tangentBasis(f) * Eigen::Vector2d(x, y))).normalized();
  };
  for (std::size_t k = 0; k < pair.f_i.size(); ++k) {
    const Vector3d f_i = noisy(pair.f_i[k]), f_j = noisy(pair.f_j[k]);
    sink->add(f_i, f_j);
  }
}

TEST(Rotation, MinimumOfTheQuotientIsUnbiasedThatOfTheEigenvalueIsNot) {
  // Little parallax, where the noise decides. Levenberg-Marquardt from the true rotation.
  const Pair pair = makePair(60, {0.10, 0.03, 0.04});
  constexpr int kDraws = 600;
  // Mean of the error over the draws, in units of its scatter; the largest of the three axes.
  const auto bias = [&](const auto& make) {
    Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
    for (unsigned seed = 0; seed < kDraws; ++seed) {
      const auto evaluateAt = make(seed);
      Matrix3d R = pair.R_ci_cj;
      auto now = evaluateAt(R);
      double damping = 1e-3;
      for (int iteration = 0; iteration < 30; ++iteration) {
        Matrix3d H = now.hessian;
        H.diagonal() *= 1.0 + damping;
        const Matrix3d next = R * expSO3(-H.ldlt().solve(now.gradient));
        const auto there = evaluateAt(next);
        damping *= there.lambda < now.lambda ? 0.1 : 10.0;
        if (!(there.lambda < now.lambda)) continue;
        R = next;
        now = there;
      }
      const Vector3d error = logSO3(pair.R_ci_cj.transpose() * R);
      mean += error / kDraws;
      square += error.cwiseAbs2() / kDraws;
    }
    const Vector3d scatter = (square - mean.cwiseAbs2()).cwiseSqrt();
    return (mean.cwiseAbs().array() / scatter.array()).maxCoeff();
  };
  const double quotient = bias([&](unsigned seed) {
    PairPoints points;
    addNoisy(pair, kSigma, seed, &points);
    NormalizedEpipolarPair noisy;
    noisy.weigh(points, {}, Matrix3d::Identity(), Vector3d::Zero(), kSigma, 3.0);
    return [noisy](const Matrix3d& R) { return noisy.evaluate(R, 0.0); };
  });
  const double eigenvalue = bias([&](unsigned seed) {
    EpipolarPair noisy;
    addNoisy(pair, kSigma, seed, &noisy);
    return [noisy](const Matrix3d& R) { return noisy.evaluate(R); };
  });
  // A mean of kDraws draws scatters by 1 / sqrt(kDraws) of one.
  const double noise_of_a_mean = 1.0 / std::sqrt(static_cast<double>(kDraws));
  EXPECT_LT(quotient, 3.5 * noise_of_a_mean);
  EXPECT_GT(eigenvalue, 7.0 * noise_of_a_mean);
}

// What the window holds, and how it moves: position in b0 at a time.
struct MotionCase {
  std::string name;
  std::function<Vector3d(double)> position;
  bool rotates = false;
  int points = 60;
  std::vector<Vector3d> line_directions = {};
  int nullity_bias_known = 0;
  int nullity_bias_free = 0;
};

void PrintTo(const MotionCase& motion, std::ostream* out) { *out << motion.name; }

class Observability : public ::testing::TestWithParam<MotionCase> {
 protected:
  // Gravity along +y of b0, as a camera sees it that looks ahead; the camera is the body.
  static constexpr double kGravity = 9.81;
  static constexpr int kKeyframes = 10;
  static constexpr double kInterval = 0.25;

  static Matrix3d attitude(const MotionCase& motion, double t) {
    if (!motion.rotates) return Matrix3d::Identity();
    return expSO3({0.3 * std::sin(1.1 * t), 0.25 * t, 0.2 * std::sin(1.7 * t)});
  }

  // Number of directions of the state that the information leaves free.
  int nullity(const MotionCase& motion, bool bias_known) const {
    const Vector3d gravity(0, kGravity, 0);
    Calibration calibration;
    calibration.gravity_magnitude = kGravity;
    WindowState state;
    state.p_b0.resize(3, kKeyframes);
    state.v_b0.resize(3, kKeyframes);
    state.gravity_b0 = gravity;
    constexpr double kDifference = 1e-4;
    const auto& p = motion.position;
    std::vector<ImuSample> imu;
    for (int k = 0; k <= 200 * kKeyframes * kInterval; ++k) {
      const double t = 0.005 * k;
      const Matrix3d R = attitude(motion, t);
      ImuSample sample;
      sample.t = t;
      sample.gyro = logSO3(attitude(motion, t - kDifference).transpose() *
                           attitude(motion, t + kDifference)) /
                    (2.0 * kDifference);
      sample.accel = R.transpose() * ((p(t + kDifference) - 2.0 * p(t) + p(t - kDifference)) /
                                          (kDifference * kDifference) -
                                      gravity);
      imu.push_back(sample);
    }
    std::vector<FrameObservation> frames(kKeyframes);
    for (int k = 0; k < kKeyframes; ++k) {
      const double t = k * kInterval;
      frames[k].t = t;
      state.R_b0_bk.push_back(attitude(motion, t));
      state.p_b0.col(k) = p(t);
      state.v_b0.col(k) = (p(t + kDifference) - p(t - kDifference)) / (2.0 * kDifference);
    }
    const auto seen = [&](int k, const Vector3d& X) -> Vector3d {
      return (state.R_b0_bk[k].transpose() * (X - state.p_b0.col(k))).normalized();
    };
    Gaussian random(1);
    for (int id = 0; id < motion.points; ++id) {
      const double z = random.uniform(3.0, 8.0);
      const double x = random.uniform(-0.6, 0.6), y = random.uniform(-0.4, 0.4);
      for (int k = 0; k < kKeyframes; ++k) {
        PointObservation point;
        point.id = id;
        point.bearing = seen(k, Vector3d(x * z, y * z, z));
        frames[k].points.push_back(point);
      }
    }
    for (int id = 0; id < static_cast<int>(25 * motion.line_directions.size()); ++id) {
      const Vector3d along = motion.line_directions[id / 25];
      const double z = random.uniform(3.0, 8.0);
      const double x = random.uniform(-0.6, 0.6), y = random.uniform(-0.4, 0.4);
      for (int k = 0; k < kKeyframes; ++k) {
        LineObservation line;
        line.id = id;
        line.start_bearing = seen(k, Vector3d(x * z, y * z, z) - 0.7 * along);
        line.end_bearing = seen(k, Vector3d(x * z, y * z, z) + 0.7 * along);
        line.length_px = 100.0;
        frames[k].lines.push_back(line);
      }
    }
    const auto window = madeWindow(calibration, frames, imu);
    RefinementOptions options;
    options.estimate_accel_bias = !bias_known;
    InertialOptions inertial;
    inertial.accel_noise_factor = inertial.gyro_noise_factor = 1.0;
    inertial.accel_bias_prior = inertial.gyro_bias_prior = 1e6;  // none
    const std::vector<Preintegration> pre =
        preintegrateInflated(*window, Vector3d::Zero(), Vector3d::Zero(), inertial);
    VisualInertialProblem map(*window, window->lineTracks(), pre, options, inertial);
    EXPECT_TRUE(map.minimize(0, RefinementOptions().tolerance, &state).valid);
    // In units of 1 m, 1 m/s, 1 m/s^2, 1 rad; gravity by what it does to the acceleration.
    const MatrixXd information = withoutRig(map.information());
    VectorXd unit = VectorXd::Ones(information.rows());
    unit.tail<2>().setConstant(1.0 / kGravity);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(unit.asDiagonal() * information *
                                                         unit.asDiagonal());
    // Free directions have 0.2 at the most, from the damping of the tracks; the weakest observed
    // one, the bias against gravity under rotation, has 150.
    constexpr double kFree = 5.0;
    return static_cast<int>((solver.eigenvalues().array() < kFree).count());
  }
};

TEST_P(Observability, FreeDirectionsAreThoseOfTheDerivation) {
  EXPECT_EQ(nullity(GetParam(), true), GetParam().nullity_bias_known);
  EXPECT_EQ(nullity(GetParam(), false), GetParam().nullity_bias_free);
}

Vector3d still(double) { return Vector3d::Zero(); }
Vector3d steady(double t) { return t * Vector3d(0.4, 0.1, 0.6); }
Vector3d uniformAhead(double t) { return (0.3 * t + 0.5 * t * t) * Vector3d::UnitZ(); }
Vector3d uniformUp(double t) { return (0.3 * t + 0.5 * t * t) * -Vector3d::UnitY(); }
Vector3d straight(double t) {
  return (0.3 * t + 0.4 * std::sin(2.0 * t)) * Vector3d(0.6, 0.0, 0.8);
}
Vector3d excited(double t) {
  return {0.4 * std::sin(2.0 * t), 0.3 * (1.0 - std::cos(2.6 * t)), 0.35 * std::sin(1.5 * t)};
}

INSTANTIATE_TEST_SUITE_P(
    Motions, Observability,
    ::testing::Values(MotionCase{"Excited", excited, true, 60, {}, 0, 0},
                      MotionCase{"ExcitedWithoutRotation", excited, false, 60, {}, 0, 2},
                      MotionCase{"ConstantVelocity", steady, false, 60, {}, 1, 3},
                      MotionCase{"UniformAccelerationLevel", uniformAhead, false, 60, {}, 1, 3},
                      MotionCase{"UniformAccelerationVertical", uniformUp, false, 60, {}, 0, 3},
                      MotionCase{"AlongAStraightLine", straight, false, 60, {}, 0, 2},
                      MotionCase{"PureRotation", still, true, 60, {}, 5, 8},
                      MotionCase{"Stationary", still, false, 60, {}, 5, 8},
                      MotionCase{"VerticalLinesOnly", excited, false, 0, {Vector3d::UnitY()}, 1, 4},
                      MotionCase{"LevelLinesOnly", excited, false, 0, {Vector3d::UnitX()}, 2, 4},
                      MotionCase{"TwoLineDirectionsOnly",
                                 excited,
                                 false,
                                 0,
                                 {Vector3d::UnitX(), Vector3d::UnitY()},
                                 0,
                                 2}),
    [](const auto& motion) { return motion.param.name; });

}  // namespace
}  // namespace slim_init
