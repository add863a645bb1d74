// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/normalized_epipolar_pair.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "epipolar_pair.h"
#include "geometry/so3.h"
#include "support/jacobian_check.h"

namespace slim_init {
namespace {

using namespace baselines;  // NOLINT: what these tests compare with

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing_support::jacobiansAgree;
using testing_support::numericJacobian;

constexpr double kSigma = 1.3e-3;  // 0.6 px at EuRoC's focal length [rad]

struct Scene {
  NormalizedEpipolarPair normalized;
  EpipolarPair plain;
  Matrix3d R_ci_cj;
};

Scene makeScene(int points, double sigma, const Vector3d& t, unsigned seed, int outliers = 0) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> gaussian(0.0, 1.0);
  Scene scene;
  scene.R_ci_cj = expSO3({0.05, -0.12, 0.08});
  for (int k = 0; k < points; ++k) {
    const double z = 5.0 + 3.0 * uniform(random);
    const Vector3d X(0.7 * z * uniform(random), 0.5 * z * uniform(random), z);
    const auto noisy = [&](const Vector3d& v, double s) -> Vector3d {
      const Vector3d u = v.normalized();
      const double x = s * gaussian(random), y = s * gaussian(random);
      return (u + tangentBasis(u) * Eigen::Vector2d(x, y)).normalized();
    };
    const Vector3d f_i = noisy(X, sigma);
    const Vector3d f_j =
        noisy(scene.R_ci_cj.transpose() * (X - t), k < outliers ? 20.0 * kSigma : sigma);
    scene.normalized.add(f_i, f_j);
    scene.plain.add(f_i, f_j);
  }
  scene.normalized.resetWeights();
  return scene;
}

TEST(NormalizedEpipolarPair, QuotientIsZeroAtTheTruthWithoutNoise) {
  const Vector3d t(0.3, -0.1, 0.2);
  const Scene scene = makeScene(40, 0.0, t, 1);
  const NormalizedEvaluation at = scene.normalized.evaluate(scene.R_ci_cj, 0.0);
  EXPECT_NEAR(at.lambda, 0.0, 1e-15);
  EXPECT_NEAR(std::abs(at.baseline.dot(t.normalized())), 1.0, 1e-10);
  EXPECT_LT(at.gradient.norm(), 1e-12);
}

TEST(NormalizedEpipolarPair, GradientAgreesWithDifferences) {
  for (double offset : {0.0, 1e-8, 0.01, 0.2}) {
    const Scene scene = makeScene(60, kSigma, {0.4, 0.1, -0.2}, 3);
    const Matrix3d R = scene.R_ci_cj * expSO3(Vector3d(1, -0.5, 0.7) * offset);
    const auto lambda = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, scene.normalized.evaluate(R * expSO3(d), 0.0).lambda);
    };
    EXPECT_TRUE(jacobiansAgree(scene.normalized.evaluate(R, 0.0).gradient.transpose(),
                               numericJacobian(lambda, 3, 1e-5), 1e-5))
        << "offset " << offset;
  }
}

TEST(NormalizedEpipolarPair, HessianIsExactWithoutNoiseAndNeverIndefinite) {
  const Scene scene = makeScene(60, 0.0, {0.4, 0.1, -0.2}, 4);
  const auto gradient = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return scene.normalized.evaluate(scene.R_ci_cj * expSO3(d), 0.0).gradient;
  };
  EXPECT_TRUE(jacobiansAgree(scene.normalized.evaluate(scene.R_ci_cj, 0.0).hessian,
                             numericJacobian(gradient, 3, 1e-5), 1e-4));
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Scene noisy = makeScene(12, 2e-3, {0.05, 0.0, 0.02}, seed);
    const Matrix3d R = noisy.R_ci_cj * expSO3(Vector3d(0.1, 0.3, -0.2) * (seed % 5));
    const Matrix3d H = noisy.normalized.evaluate(R, 1e-6).hessian;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix3d>(H).eigenvalues()[0], -1e-9 * H.norm());
  }
}

TEST(NormalizedEpipolarPair, ExpectationAtTheTruthIsTheNoiseVariance) {
  // The quotient minimised over e is sigma^2 (1 - 2/n): two degrees of freedom go to the baseline.
  constexpr int kPoints = 200, kRuns = 200;
  double sum = 0.0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const Scene scene = makeScene(kPoints, kSigma, {0.5, 0.1, 0.0}, seed);
    sum += scene.normalized.evaluate(scene.R_ci_cj, 0.0).lambda;
  }
  const double expected = kSigma * kSigma * (1.0 - 2.0 / kPoints);
  EXPECT_NEAR(sum / kRuns, expected, 0.03 * expected);
}

TEST(NormalizedEpipolarPair, MinimumIsLessBiasedThanThePlainEigenvalue) {
  // Mean gradient at the true rotation over many noise draws, in units of its scatter: it should
  // vanish for an unbiased cost.
  constexpr int kRuns = 400;
  const auto meanOverScatter = [&](bool normalized) {
    Vector3d mean = Vector3d::Zero(), square = Vector3d::Zero();
    for (unsigned seed = 0; seed < kRuns; ++seed) {
      std::mt19937_64 random(seed);
      // The same 3D points every time; only the noise differs.
      Scene fixed = makeScene(40, 0.0, {0.06, 0.02, 0.02}, 7);
      Scene noisy;
      noisy.R_ci_cj = fixed.R_ci_cj;
      std::mt19937_64 geometry(7);
      std::uniform_real_distribution<double> uniform(-1.0, 1.0);
      std::normal_distribution<double> gaussian(0.0, 1.0);
      for (int k = 0; k < 40; ++k) {
        const double z = 5.0 + 3.0 * uniform(geometry);
        const double px = uniform(geometry), py = uniform(geometry);
        const Vector3d X(0.7 * z * px, 0.5 * z * py, z);
        const auto perturb = [&](const Vector3d& v) -> Vector3d {
          const Vector3d u = v.normalized();
          const double x = kSigma * gaussian(random), y = kSigma * gaussian(random);
          return (u + tangentBasis(u) * Eigen::Vector2d(x, y)).normalized();
        };
        const Vector3d f_i = perturb(X);
        const Vector3d f_j = perturb(noisy.R_ci_cj.transpose() * (X - Vector3d(0.06, 0.02, 0.02)));
        noisy.normalized.add(f_i, f_j);
        noisy.plain.add(f_i, f_j);
      }
      noisy.normalized.resetWeights();
      const Vector3d g = normalized ? noisy.normalized.evaluate(noisy.R_ci_cj, 0.0).gradient
                                    : noisy.plain.evaluate(noisy.R_ci_cj).gradient;
      mean += g / kRuns;
      square += g.cwiseAbs2() / kRuns;
    }
    return (mean.cwiseAbs().array() / (square - mean.cwiseAbs2()).cwiseSqrt().array()).maxCoeff();
  };
  EXPECT_LT(meanOverScatter(true), 0.5 * meanOverScatter(false));
}

TEST(NormalizedEpipolarPair, WeightsSuppressOutliers) {
  Scene scene = makeScene(60, kSigma, {0.5, 0.1, 0.0}, 5, 10);
  NormalizedEvaluation at = scene.normalized.evaluate(scene.R_ci_cj, 0.0);
  const double before = at.lambda;
  PointResiduals residuals;
  for (int k = 0; k < 3; ++k) {
    scene.normalized.updateWeights(scene.R_ci_cj, at.baseline, kSigma, 3.0, &residuals);
    at = scene.normalized.evaluate(scene.R_ci_cj, 0.0);
  }
  EXPECT_LT(at.lambda, 0.1 * before);
  EXPECT_GT(scene.normalized.robustCount(), 25.0);
  EXPECT_LT(scene.normalized.robustCount(), 55.0);
  scene.normalized.residuals(scene.R_ci_cj, at.baseline, kSigma, &residuals);
  EXPECT_EQ(residuals.z2.size(), 60);
}

TEST(NormalizedEpipolarPair, ConsensusFindsTheBaselineAmongOutliers) {
  const Vector3d t(0.5, 0.1, -0.3);
  const Scene scene = makeScene(60, kSigma, t, 6, 20);
  ConsensusScratch scratch;
  double cost = 0.0;
  const Vector3d e = scene.normalized.consensusBaseline(scene.R_ci_cj, kSigma, 3.0, 40, 0,
                                                        Vector3d::Zero(), 0.0, &scratch, &cost);
  EXPECT_GT(std::abs(e.dot(t.normalized())), std::cos(0.1));
  EXPECT_LT(cost, 60 * 9.0 * 0.6);
  // The same direction handed in wins or is bettered.
  double again = 0.0;
  scene.normalized.consensusBaseline(scene.R_ci_cj, kSigma, 3.0, 40, 0, t.normalized(), 0.0,
                                     &scratch, &again);
  EXPECT_LE(again, cost);
}

TEST(NormalizedEpipolarPair, ScatteredGradientsSumToTheGradient) {
  const Scene scene = makeScene(31, kSigma, {0.4, 0.1, -0.2}, 8);
  const Matrix3d R = scene.R_ci_cj * expSO3({0.002, 0.001, -0.001});
  std::vector<int> track(31);
  for (int k = 0; k < 31; ++k) track[k] = k % 7;
  std::vector<Vector3d> parts(7, Vector3d::Zero());
  scene.normalized.scatterGradients(R, 0.5 * kSigma * kSigma, 2.0, Matrix3d::Identity(), track,
                                    &parts);
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& part : parts) sum += part;
  const Vector3d expected = 2.0 * scene.normalized.evaluate(R, 0.0).gradient;
  EXPECT_LT((sum - expected).norm(), 1e-9 * expected.norm());
}

}  // namespace
}  // namespace slim_init
