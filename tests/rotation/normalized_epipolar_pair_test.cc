// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/normalized_epipolar_pair.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <string>

#include "epipolar_pair.h"
#include "geometry/so3.h"
#include "support/jacobian_check.h"

namespace slim_init {
namespace {

using namespace baselines;  // NOLINT: what these tests compare with

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSigma = 1.3e-3;  // 0.6 px at EuRoC's focal length [rad]

struct Scene {
  PairPoints points;
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
    const Vector3d X{0.7 * z * uniform(random), 0.5 * z * uniform(random), z};
    const auto noisy = [&](const Vector3d& v, double s) -> Vector3d {
      const Vector3d u = v.normalized();
      const double x = s * gaussian(random), y = s * gaussian(random);
      return (u + tangentBasis(u) * Eigen::Vector2d(x, y)).normalized();
    };
    const Vector3d f_i = noisy(X, sigma);
    const Vector3d f_j =
        noisy(scene.R_ci_cj.transpose() * (X - t), k < outliers ? 20.0 * kSigma : sigma);
    scene.points.add(f_i, f_j);
    scene.plain.add(f_i, f_j);
  }
  scene.normalized.weigh(scene.points, {}, scene.R_ci_cj, Vector3d::Zero(), kSigma, 3.0);
  return scene;
}

// Runs `check` with the name of a cost and the cost by the rotation: of the quotient, and of the
// smallest eigenvalue that the compared methods take.
template <typename Check>
void forBothCosts(const Scene& scene, double baseline_prior, const Check& check) {
  check("quotient",
        [&](const Matrix3d& R) { return scene.normalized.evaluate(R, baseline_prior); });
  check("eigenvalue", [&](const Matrix3d& R) { return scene.plain.evaluate(R); });
}

TEST(NormalizedEpipolarPair, IsZeroAtTheTruthWithoutNoise) {
  const Vector3d t(0.3, -0.1, 0.2);
  const Scene scene = makeScene(40, 0.0, t, 1);
  forBothCosts(scene, 0.0, [&](const char* name, const auto& cost) {
    SCOPED_TRACE(name);
    const auto at = cost(scene.R_ci_cj);
    EXPECT_NEAR(at.lambda, 0.0, 1e-15);
    EXPECT_NEAR(std::abs(at.baseline.dot(t.normalized())), 1.0, 1e-12);
    EXPECT_LT(at.gradient.norm(), 1e-13);
  });
}

TEST(NormalizedEpipolarPair, GradientAgreesWithDifferences) {
  for (const double offset : {0.0, 1e-8, 0.01, 0.2}) {
    for (const double sigma : {0.0, kSigma}) {
      if (offset < 1e-3 && sigma == 0.0) continue;  // the cost is zero to rounding there
      const Scene scene = makeScene(60, sigma, {0.4, 0.1, -0.2}, 3);
      const Matrix3d R = scene.R_ci_cj * expSO3(Vector3d(1, -0.5, 0.7) * offset);
      forBothCosts(scene, 0.0, [&](const char* name, const auto& cost) {
        const auto lambda = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
          return Eigen::VectorXd::Constant(1, cost(R * expSO3(d)).lambda);
        };
        EXPECT_TRUE(
            jacobiansAgree(cost(R).gradient.transpose(), numericJacobian(lambda, 3, 1e-5), 1e-5))
            << name << " offset " << offset << " sigma " << sigma;
      });
    }
  }
}

TEST(NormalizedEpipolarPair, HessianIsExactWithoutNoiseAndNeverIndefinite) {
  const Scene scene = makeScene(60, 0.0, {0.4, 0.1, -0.2}, 4);
  forBothCosts(scene, 0.0, [&](const char* name, const auto& cost) {
    const auto gradient = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return cost(scene.R_ci_cj * expSO3(d)).gradient;
    };
    EXPECT_TRUE(
        jacobiansAgree(cost(scene.R_ci_cj).hessian, numericJacobian(gradient, 3, 1e-5), 1e-4))
        << name;
  });
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Scene noisy = makeScene(12, 2e-3, {0.05, 0.0, 0.02}, seed);
    const Matrix3d R = noisy.R_ci_cj * expSO3(Vector3d(0.1, 0.3, -0.2) * (seed % 5));
    forBothCosts(noisy, 1e-6, [&](const char* name, const auto& cost) {
      const Matrix3d H = cost(R).hessian;
      const double smallest = Eigen::SelfAdjointEigenSolver<Matrix3d>(H).eigenvalues()[0];
      const double rounding = std::string(name) == "quotient" ? 1e-9 : 1e-12;
      EXPECT_GT(smallest, -rounding * H.norm()) << name << " seed " << seed;
    });
  }
}

TEST(EpipolarPair, PreSummedMatrixEqualsTheSumOverPoints) {
  const Scene scene = makeScene(30, 1e-3, {0.3, -0.1, 0.2}, 1);
  const Matrix3d R = scene.R_ci_cj * expSO3({0.02, 0.01, -0.03});
  Matrix3d M = Matrix3d::Zero();
  for (int k = 0; k < 30; ++k) {
    const Vector3d f_i = scene.points.bearingsI().row(k).transpose().matrix();
    const Vector3d f_j = scene.points.bearingsJ().row(k).transpose().matrix();
    const Vector3d m = f_i.cross(R * f_j);
    M += m * m.transpose();
  }
  const double smallest = Eigen::SelfAdjointEigenSolver<Matrix3d>(M).eigenvalues()[0];
  EXPECT_NEAR(scene.plain.evaluate(R).lambda, smallest, 1e-14 * M.norm() * 30);
  EXPECT_EQ(scene.plain.count(), 30);
}

TEST(NormalizedEpipolarPair, ABaselineNearbyOrFarAwayChangesNothing) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Scene noisy = makeScene(12, 2e-3, {0.05, 0.0, 0.02}, seed);
    const Matrix3d R = noisy.R_ci_cj * expSO3(Vector3d(0.02, -0.01, 0.03) * (seed % 5));
    const NormalizedEvaluation at = noisy.normalized.evaluate(R, 1e-6);
    // From close by to at right angles, where iterations lead to a maximum or a saddle.
    const Eigen::Matrix<double, 3, 2> T = tangentBasis(at.baseline);
    const Vector3d nears[] = {at.baseline, -(at.baseline + 0.05 * T.col(0)).normalized(),
                              (at.baseline + T.col(1)).normalized(), T.col(0), T.col(1)};
    for (const Vector3d& near : nears) {
      const NormalizedEvaluation again = noisy.normalized.evaluate(R, 1e-6, near);
      EXPECT_NEAR(again.lambda, at.lambda, 1e-8 * (1e-6 + at.lambda));
      EXPECT_LT(again.baseline.cross(at.baseline).norm(), 1e-8);
      EXPECT_LT((again.gradient - at.gradient).norm(), 1e-8 * at.hessian.norm());
      EXPECT_LT(noisy.normalized.baseline(R, near).cross(at.baseline).norm(), 1e-8);
    }
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

TEST(NormalizedEpipolarPair, WeightsSuppressOutliers) {
  Scene scene = makeScene(60, kSigma, {0.5, 0.1, 0.0}, 5, 10);
  NormalizedEvaluation at = scene.normalized.evaluate(scene.R_ci_cj, 0.0);
  const double before = at.lambda;
  for (int k = 0; k < 3; ++k) {
    scene.normalized.weigh(scene.points, {}, scene.R_ci_cj, at.baseline, kSigma, 3.0);
    at = scene.normalized.evaluate(scene.R_ci_cj, 0.0);
  }
  EXPECT_LT(at.lambda, 0.1 * before);
  EXPECT_GT(scene.normalized.robustCount(), 25.0);
  EXPECT_LT(scene.normalized.robustCount(), 55.0);
  EXPECT_EQ(scene.points.residuals(scene.R_ci_cj, at.baseline, kSigma).z2.size(), 60);
}

TEST(NormalizedEpipolarPair, MaskedPointsDoNotCount) {
  // Ten outliers, left out by hand: what remains is the scene without them.
  Scene scene = makeScene(60, 0.0, {0.5, 0.1, 0.0}, 5);
  PairPoints disturbed;
  for (int k = 0; k < 10; ++k) {
    disturbed.add(Vector3d(0.1, 0.05 * k, 1.0).normalized(), Vector3d(0.1 * k, 0, 1).normalized());
  }
  for (int k = 10; k < 60; ++k) {
    disturbed.add(scene.points.bearingsI().row(k).transpose().matrix(),
                  scene.points.bearingsJ().row(k).transpose().matrix());
  }
  Eigen::ArrayXd mask = Eigen::ArrayXd::Ones(60);
  mask.head(10).setZero();
  NormalizedEpipolarPair pair;
  pair.weigh(disturbed, mask, scene.R_ci_cj, Vector3d::Zero(), kSigma, 3.0);
  EXPECT_EQ(pair.robustCount(), 50.0);
  EXPECT_NEAR(pair.evaluate(scene.R_ci_cj, 0.0).lambda, 0.0, 1e-15);
  const Vector3d e = Vector3d(0.5, 0.1, 0.0).normalized();
  pair.weigh(disturbed, mask, scene.R_ci_cj, e, kSigma, 3.0);
  EXPECT_NEAR(pair.robustCount(), 50.0, 1e-9);
  pair.weigh(disturbed, {}, scene.R_ci_cj, Vector3d::Zero(), kSigma, 3.0);
  EXPECT_EQ(pair.robustCount(), 60.0);
  EXPECT_GT(pair.evaluate(scene.R_ci_cj, 0.0).lambda, 1e-6);
}

TEST(NormalizedEpipolarPair, OneObjectWeighsPairsOfDifferentSizesOneAfterTheOther) {
  // 10 and 9 points take the same storage; nothing of the first may stay.
  const Scene ten = makeScene(10, kSigma, {0.4, 0.1, -0.2}, 2);
  const Scene nine = makeScene(9, kSigma, {0.4, 0.1, -0.2}, 3);
  const Vector3d e = Vector3d(0.4, 0.1, -0.2).normalized();
  NormalizedEpipolarPair reused, fresh;
  reused.weigh(ten.points, {}, ten.R_ci_cj, e, kSigma, 3.0);
  reused.weigh(nine.points, {}, nine.R_ci_cj, e, kSigma, 3.0);
  fresh.weigh(nine.points, {}, nine.R_ci_cj, e, kSigma, 3.0);
  EXPECT_EQ(reused.evaluate(nine.R_ci_cj, 0.0).lambda, fresh.evaluate(nine.R_ci_cj, 0.0).lambda);
}

TEST(PairPoints, ConsensusFindsTheBaselineAmongOutliers) {
  const Vector3d t(0.5, 0.1, -0.3);
  const Scene scene = makeScene(60, kSigma, t, 6, 20);
  const ConsensusOptions options = {3.0, 40};
  const ConsensusBaseline found =
      scene.points.consensusBaseline(scene.R_ci_cj, kSigma, options, 0, Vector3d::Zero());
  EXPECT_GT(std::abs(found.direction.dot(t.normalized())), std::cos(0.1));
  EXPECT_LT(found.cost, 60 * 9.0 * 0.6);
  // The same direction handed in wins or is bettered.
  const ConsensusBaseline again =
      scene.points.consensusBaseline(scene.R_ci_cj, kSigma, options, 0, t.normalized());
  EXPECT_LE(again.cost, found.cost);
}

TEST(PairPoints, AGoodBaselineAtHandIsKept) {
  const Vector3d t(0.5, 0.1, -0.3);
  const Scene scene = makeScene(60, kSigma, t, 6);
  const auto search = [&](const Vector3d& first) {
    return scene.points.consensusBaseline(scene.R_ci_cj, kSigma, {3.0, 40}, 0, first);
  };
  const Vector3d good = t.normalized();
  EXPECT_LT((search(good).direction - good).norm(), 1e-6);
  // A bad one has to compete.
  EXPECT_GT((search(Vector3d::UnitY()).direction - Vector3d::UnitY()).norm(), 0.1);
}

TEST(PairPoints, WithoutHypothesesTheBaselineAtHandIsRated) {
  const Vector3d t(0.5, 0.1, -0.3);
  const Scene scene = makeScene(60, kSigma, t, 6);
  const ConsensusOptions rate = {3.0, 0};
  const ConsensusBaseline rated =
      scene.points.consensusBaseline(scene.R_ci_cj, kSigma, rate, 0, t.normalized());
  EXPECT_LT((rated.direction - t.normalized()).norm(), 1e-6);
  EXPECT_NEAR(rated.cost / 60, 1.0, 0.4);
  const ConsensusBaseline nothing =
      scene.points.consensusBaseline(scene.R_ci_cj, kSigma, rate, 0, Vector3d::Zero());
  EXPECT_EQ(nothing.direction, Vector3d::Zero());
  EXPECT_EQ(nothing.cost, 60 * 9.0);
}

}  // namespace
}  // namespace slim_init
