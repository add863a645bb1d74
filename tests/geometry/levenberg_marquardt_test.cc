// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "geometry/minimize.h"

namespace slim_init {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Model = QuadraticModel<2>;

// Rosenbrock's function as least squares of [10 (y - x^2), 1 - x], Hessian of Gauss-Newton.
Model rosenbrock(const Vector2d& x) {
  const Vector2d r(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
  Matrix2d J;
  J << -20.0 * x[0], 10.0, -1.0, 0.0;
  Model model;
  model.cost = r.squaredNorm();
  model.gradient = 2.0 * J.transpose() * r;
  model.hessian = 2.0 * J.transpose() * J;
  return model;
}

Matrix2d marquardt(const Model& at, double damping) {
  Matrix2d H = at.hessian;
  H.diagonal() *= 1.0 + damping;
  return H;
}

LevenbergMarquardtOptions optionsOf(int iterations) {
  LevenbergMarquardtOptions options;
  options.max_iterations = iterations;
  options.relative_decrease = 0.0;
  return options;
}

TEST(LevenbergMarquardt, DescendsACurvedValley) {
  Vector2d x(-1.2, 1.0);
  Model at = rosenbrock(x);
  const int accepted = minimizeLevenbergMarquardt(optionsOf(100), rosenbrock, marquardt, &x, &at);
  EXPECT_LT((x - Vector2d(1.0, 1.0)).norm(), 1e-6);
  EXPECT_GT(accepted, 3);
  EXPECT_EQ(at.cost, rosenbrock(x).cost);
}

TEST(LevenbergMarquardt, NeverGoesUphill) {
  for (int iterations = 1; iterations < 30; ++iterations) {
    Vector2d fewer(-1.2, 1.0), more(-1.2, 1.0);
    Model at_fewer = rosenbrock(fewer), at_more = at_fewer;
    minimizeLevenbergMarquardt(optionsOf(iterations), rosenbrock, marquardt, &fewer, &at_fewer);
    minimizeLevenbergMarquardt(optionsOf(iterations + 1), rosenbrock, marquardt, &more, &at_more);
    EXPECT_LE(at_more.cost, at_fewer.cost);
  }
}

TEST(LevenbergMarquardt, EndsWhereTheExpectedDecreaseIsNotWorthAStep) {
  int evaluations = 0;
  const auto counted = [&](const Vector2d& x) {
    ++evaluations;
    return rosenbrock(x);
  };
  LevenbergMarquardtOptions options = optionsOf(100);
  options.relative_decrease = 10.0;  // no step can promise ten times the cost
  Vector2d x(-1.2, 1.0);
  Model at = rosenbrock(x);
  EXPECT_EQ(minimizeLevenbergMarquardt(options, counted, marquardt, &x, &at), 0);
  EXPECT_EQ(evaluations, 0);
  EXPECT_EQ(x, Vector2d(-1.2, 1.0));
}

TEST(LevenbergMarquardt, EndsAtAShortStepAndAtALargeDamping) {
  LevenbergMarquardtOptions options = optionsOf(100);
  options.shortest_step = 1e6;
  Vector2d x(-1.2, 1.0);
  Model at = rosenbrock(x);
  EXPECT_LE(minimizeLevenbergMarquardt(options, rosenbrock, marquardt, &x, &at), 1);

  int refused = 0;
  const auto never = [&](const Model&, const Model&) {
    ++refused;
    return false;
  };
  options = optionsOf(100);
  options.first_damping = 1e-4;
  options.largest_damping = 2e2;
  x = Vector2d(-1.2, 1.0);
  at = rosenbrock(x);
  EXPECT_EQ(minimizeLevenbergMarquardt(options, rosenbrock, marquardt, &x, &at, never), 0);
  // Ten times more after every refusal, up to 1e3, the first above the bound.
  EXPECT_EQ(refused, 7);
  EXPECT_EQ(x, Vector2d(-1.2, 1.0));
}

TEST(LevenbergMarquardt, StaysWhereTheModelIsNotFinite) {
  const auto broken = [](const Vector2d&) {
    Model model;
    model.cost = std::numeric_limits<double>::quiet_NaN();
    return model;
  };
  Vector2d x(-1.2, 1.0);
  Model at = rosenbrock(x);
  EXPECT_EQ(minimizeLevenbergMarquardt(optionsOf(20), broken, marquardt, &x, &at), 0);
  EXPECT_EQ(x, Vector2d(-1.2, 1.0));
  at.gradient[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(minimizeLevenbergMarquardt(optionsOf(20), rosenbrock, marquardt, &x, &at), 0);
  EXPECT_EQ(x, Vector2d(-1.2, 1.0));
}

}  // namespace
}  // namespace slim_init
