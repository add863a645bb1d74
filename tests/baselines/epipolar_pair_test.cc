// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "epipolar_pair.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>
#include <vector>

#include "geometry/so3.h"
#include "support/jacobian_check.h"

namespace slim_init::baselines {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing_support::jacobiansAgree;
using testing_support::numericJacobian;

struct Scene {
  EpipolarPair pair;
  std::vector<Vector3d> f_i, f_j;
  Matrix3d R_ci_cj;
  Vector3d t;
};

// Points 2 to 8 m in front of two cameras a baseline `t` apart, bearings with angular noise.
Scene makeScene(int points, double sigma_rad, const Vector3d& t, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> gaussian(0.0, sigma_rad);
  Scene scene;
  scene.R_ci_cj = expSO3({0.05, -0.12, 0.08});
  scene.t = t;
  for (int k = 0; k < points; ++k) {
    const double z = 5.0 + 3.0 * uniform(random);
    const double y = 0.5 * z * uniform(random), x = 0.7 * z * uniform(random);
    const Vector3d X_i(x, y, z);
    const auto noisy = [&](const Vector3d& v) {
      const double u = gaussian(random), w = gaussian(random);
      return (v.normalized() + tangentBasis(v.normalized()) * Eigen::Vector2d(u, w)).normalized();
    };
    scene.f_i.push_back(noisy(X_i));
    scene.f_j.push_back(noisy(scene.R_ci_cj.transpose() * (X_i - t)));
    scene.pair.add(scene.f_i.back(), scene.f_j.back());
  }
  return scene;
}

TEST(EpipolarPair, PreSummedMatrixEqualsTheSumOverPoints) {
  const Scene scene = makeScene(30, 1e-3, {0.3, -0.1, 0.2}, 1);
  const Matrix3d R = scene.R_ci_cj * expSO3({0.02, 0.01, -0.03});
  Matrix3d M = Matrix3d::Zero();
  for (std::size_t k = 0; k < scene.f_i.size(); ++k) {
    const Vector3d m = scene.f_i[k].cross(R * scene.f_j[k]);
    M += m * m.transpose();
  }
  EXPECT_LT((scene.pair.normalMatrix(R) - M).norm(), 1e-14 * M.norm() * 30);
  EXPECT_EQ(scene.pair.count(), 30);
}

TEST(EpipolarPair, NoiseFreeMinimumIsZeroAtTheTruthWithTheBaselineAsEigenvector) {
  const Scene scene = makeScene(40, 0.0, {0.3, -0.1, 0.2}, 2);
  const EpipolarEvaluation at = scene.pair.evaluate(scene.R_ci_cj);
  EXPECT_NEAR(at.lambda, 0.0, 1e-15);
  EXPECT_NEAR(std::abs(at.baseline.dot(scene.t.normalized())), 1.0, 1e-12);
  EXPECT_LT(at.gradient.norm(), 1e-13);
}

TEST(EpipolarPair, GradientAgreesWithDifferences) {
  for (double offset : {0.0, 1e-8, 0.01, 0.2}) {
    for (double sigma : {0.0, 1.3e-3}) {
      if (offset < 1e-3 && sigma == 0.0) continue;  // the eigenvalue is zero to rounding there
      const Scene scene = makeScene(60, sigma, {0.4, 0.1, -0.2}, 3);
      const Matrix3d R = scene.R_ci_cj * expSO3(Vector3d(1, -0.5, 0.7) * offset);
      const auto lambda = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
        return Eigen::VectorXd::Constant(1, scene.pair.evaluate(R * expSO3(d)).lambda);
      };
      EXPECT_TRUE(jacobiansAgree(scene.pair.evaluate(R).gradient.transpose(),
                                 numericJacobian(lambda, 3, 1e-5), 1e-5))
          << "offset " << offset << " sigma " << sigma;
    }
  }
}

TEST(EpipolarPair, HessianIsExactWithoutNoise) {
  const Scene scene = makeScene(60, 0.0, {0.4, 0.1, -0.2}, 4);
  const auto gradient = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return scene.pair.evaluate(scene.R_ci_cj * expSO3(d)).gradient;
  };
  EXPECT_TRUE(jacobiansAgree(scene.pair.evaluate(scene.R_ci_cj).hessian,
                             numericJacobian(gradient, 3, 1e-5), 1e-4));
}

TEST(EpipolarPair, HessianIsPositiveSemidefinite) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Scene scene = makeScene(12, 2e-3, {0.05, 0.0, 0.02}, seed);
    const Matrix3d R = scene.R_ci_cj * expSO3(Vector3d(0.1, 0.3, -0.2) * (seed % 5));
    const Matrix3d H = scene.pair.evaluate(R).hessian;
    const double smallest = Eigen::SelfAdjointEigenSolver<Matrix3d>(H).eigenvalues()[0];
    EXPECT_GT(smallest, -1e-12 * H.norm()) << "seed " << seed;
  }
}

TEST(EpipolarPair, WithoutTranslationTheTruthStillIsTheMinimum) {
  const Scene scene = makeScene(40, 0.0, Vector3d::Zero(), 5);
  const EpipolarEvaluation at = scene.pair.evaluate(scene.R_ci_cj);
  EXPECT_NEAR(at.lambda, 0.0, 1e-15);
  EXPECT_TRUE(at.hessian.allFinite());
  EXPECT_GT(scene.pair.evaluate(scene.R_ci_cj * expSO3({0.01, 0.01, 0.01})).lambda, 1e-6);
}

}  // namespace
}  // namespace slim_init::baselines
