// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/multi_gap_bias.h"

#include <gtest/gtest.h>

#include "gyro_bias.h"
#include "support/exact_window.h"
#include "support/jacobian_check.h"
#include "support/robust_bias.h"

namespace slim_init {
namespace {

using namespace baselines;  // NOLINT: what these tests compare with

using Eigen::Vector3d;

TEST(MultiGapBias, BeatsDrtUnderNoise) {
  std::vector<double> ours, drt;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const ExactWindowOptions options = seeded(seed);
    const ExactWindow exact = noisyWindow(options);
    ours.push_back(relativeError(robustBiasOf(*exact.window).gyro_bias, options.gyro_bias));
    drt.push_back(relativeError(estimateGyroBias(*exact.window, GyroBiasProblem()).gyro_bias,
                                options.gyro_bias));
  }
  EXPECT_LT(median(ours), 0.02);
  EXPECT_LT(median(ours), 0.7 * median(drt));
}

TEST(WhitenedVpResidual, JacobianAgreesWithDifferences) {
  const Eigen::Matrix3d R_b_c = eurocCalibration().R_b_c;
  VanishingPoint a, b;
  a.direction = Vector3d(0.1, -0.3, 0.9).normalized();
  b.direction = Vector3d(0.2, -0.2, 0.95).normalized();
  a.covariance = 1e-4 * (Eigen::Matrix3d::Identity() - a.direction * a.direction.transpose());
  b.covariance = 3e-4 * (Eigen::Matrix3d::Identity() - b.direction * b.direction.transpose());
  for (double sign : {1.0, -1.0}) {
    a.direction *= sign;
    for (const Vector3d& theta : {Vector3d(0, 0, 0), Vector3d(1e-8, 0, 0), Vector3d(0.1, 0.2, 0)}) {
      const Eigen::Matrix3d R = expSO3(theta);
      Eigen::Vector2d z;
      Eigen::Matrix<double, 2, 3> J;
      whitenedVpResidual(a, b, R, R_b_c, &z, &J);
      // The whitening depends on R as well, weakly; the Jacobian leaves that out as Gauss-Newton
      // does. With isotropic covariances it does not depend on R at all.
      const auto f = [&](const Eigen::VectorXd& phi) -> Eigen::VectorXd {
        Eigen::Vector2d out;
        whitenedVpResidual(a, b, R * expSO3(phi), R_b_c, &out, nullptr);
        return out;
      };
      EXPECT_TRUE(jacobiansAgree(J, numericJacobian(f, 3, 1e-6), 0.03)) << theta.transpose();
    }
  }
}

}  // namespace
}  // namespace slim_init
