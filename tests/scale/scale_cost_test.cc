// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
// The cost over the scale of a linear start, and the motion in it.
#include "scale/scale_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "linear_alignment.h"
#include "scale/scale_profile.h"
#include "support/exact_window.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

using namespace baselines;  // NOLINT: what these tests compare with

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Problem {
  ExactWindow exact;
  std::vector<Preintegration> pre;
  std::vector<Matrix3d> R_b0_bk;
  LinearMotion motion;
  Eigen::Matrix3Xd shape;       // true centres in b0, unit spread about their mean
  double true_scale = 0.0;      // metres per unit of shape
  Eigen::MatrixXd information;  // isotropic, up to a common translation
};

Problem makeProblem(const Vector3d& accel_bias, double shape_noise, unsigned seed) {
  ExactWindowOptions options;
  options.accel_bias = accel_bias;
  options.seed = seed;
  Problem p{makeExactWindow(options), {}, {}, {}, {}, 0.0, {}};
  p.pre = preintegrateWindow(*p.exact.window, options.gyro_bias, Vector3d::Zero(),
                             PreintegrationParts::kMean);
  p.R_b0_bk = chainRotations(p.pre);
  p.motion = linearMotion(p.pre, p.R_b0_bk, p.exact.calibration.t_b_c);
  const int n = p.exact.window->size();
  p.shape = trueShape(p.exact, &p.true_scale);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian(0.0, 1.0);
  const double sigma = std::max(shape_noise, 1e-6);
  for (Eigen::Index i = 0; i < p.shape.size(); ++i)
    p.shape.data()[i] += shape_noise * gaussian(random);
  // Information of independent centres with the common translation and the scale projected out.
  Eigen::MatrixXd H = Eigen::MatrixXd::Identity(3 * n, 3 * n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) H.block<3, 3>(3 * i, 3 * j) -= Matrix3d::Identity() / n;
  }
  const Eigen::VectorXd c = Eigen::Map<const Eigen::VectorXd>(p.shape.data(), 3 * n).normalized();
  H -= c * c.transpose();
  p.information = H / (sigma * sigma);
  return p;
}

struct Solution {
  bool valid = false;
  double scale = kNotComputed;  // metres per unit of the shape
  Eigen::Matrix<double, 9, 1> x;
};

Solution solve(const Problem& p, double accel_bias_prior = InertialOptions().accel_bias_prior) {
  Eigen::Matrix3Xd centred = p.shape.colwise() - p.shape.rowwise().mean();
  centred /= centred.norm();
  const Eigen::Map<const Eigen::VectorXd> shape(centred.data(), centred.size());
  const double hold = kLengthWeight * p.information.diagonal().mean();
  UnknownsPrior prior;
  prior.addAccelBias(Eigen::Vector3d::Zero(), accel_bias_prior);
  const ScaleCost cost(p.motion, shape, p.information + hold * shape * shape.transpose(), prior,
                       p.exact.calibration.gravity_magnitude);
  Solution out;
  const double log_scale = lowestMinimum(cost).at;
  out.scale = std::exp(log_scale);
  out.valid = std::isfinite(cost(log_scale, &out.x));
  return out;
}

TEST(LinearMotion, ReproducesTheTruthAtTheTrueUnknowns) {
  // With the bias linearised the positions err in second order only (b_a enters exactly linearly).
  const Problem p = makeProblem(Vector3d(-0.013, 0.10, 0.09), 0.0, 1);
  const Matrix3d R_b0_w = p.exact.truth[0].R_w_b.transpose();
  Eigen::VectorXd x(9);
  x << R_b0_w * p.exact.truth[0].v_w_b, Vector3d(-0.013, 0.10, 0.09),
      R_b0_w * Vector3d(0, 0, -p.exact.calibration.gravity_magnitude);
  const Eigen::VectorXd position = p.motion.position0 + p.motion.position * x;
  const Eigen::VectorXd velocity = p.motion.velocity0 + p.motion.velocity * x;
  for (int k = 0; k < p.exact.window->size(); ++k) {
    const Vector3d p_true = R_b0_w * (p.exact.truth[k].p_w_b - p.exact.truth[0].p_w_b);
    EXPECT_LT((position.segment<3>(3 * k) - p_true).norm(), 1e-10);
    EXPECT_LT((velocity.segment<3>(3 * k) - R_b0_w * p.exact.truth[k].v_w_b).norm(), 1e-10);
  }
}

TEST(ScaleCost, NoiseFreeRecoveryWithAccelerometerBias) {
  const Vector3d accel_bias(-0.013, 0.10, 0.09);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Problem p = makeProblem(accel_bias, 0.0, seed);
    const Solution estimate = solve(p);
    ASSERT_TRUE(estimate.valid);
    // The prior on the bias pulls a little; a shape good to 1e-6 leaves it almost no weight.
    EXPECT_NEAR(estimate.scale / p.true_scale, 1.0, 1e-4);
    EXPECT_LT((estimate.x.segment<3>(3) - accel_bias).norm(), 1e-3);
    EXPECT_LT(gravityErrorRad(estimate.x.tail<3>(), p.exact.truth[0]), 1e-4);
  }
}

TEST(ScaleCost, IsNotAttenuatedByNoiseWhereTheForwardAlignmentIs) {
  // Shape noise of 2 % of the spread, many draws: the forward alignment shrinks the scale.
  double forward = 0.0, reverse = 0.0;
  constexpr int kRuns = 100;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    const Problem p = makeProblem(Vector3d::Zero(), 0.02, seed);
    const AlignmentEstimate f =
        alignLinear({*p.exact.window, p.pre, p.R_b0_bk, p.shape, LineTerms()});
    const Solution r = solve(p);
    ASSERT_TRUE(f.valid && r.valid);
    forward += (f.scale / p.true_scale - 1.0) / kRuns;
    reverse += (r.scale / p.true_scale - 1.0) / kRuns;
  }
  EXPECT_LT(forward, -0.05);
  EXPECT_LT(std::abs(reverse), 0.3 * std::abs(forward));
}

TEST(ScaleCost, TakesTheAccelerometerBiasOffTheScale) {
  // One strong bias: with the unknown pinned to zero the answer is worse.
  const Problem p = makeProblem(Vector3d(0.1, -0.1, 0.1), 0.0, 3);
  const double with = std::abs(solve(p).scale / p.true_scale - 1.0);
  const double without = std::abs(solve(p, 1e-6).scale / p.true_scale - 1.0);
  EXPECT_LT(with, 0.1 * without);
}

TEST(ScaleCost, RefusesWhatIsNotFiniteOrHasNoShape) {
  Problem p = makeProblem(Vector3d::Zero(), 0.0, 1);
  Problem broken = p;
  broken.shape(1, 1) = kNotComputed;
  EXPECT_FALSE(solve(broken).valid);
  broken = p;
  broken.shape.setConstant(1.0);
  EXPECT_FALSE(solve(broken).valid);
  broken = p;
  broken.information(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(solve(broken).valid);
}

}  // namespace
}  // namespace slim_init
