// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "gyro_bias.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "epipolar_pair.h"
#include "geometry/units.h"
#include "support/exact_window.h"
#include "support/jacobian_check.h"

namespace slim_init::baselines {
namespace {

using Eigen::Vector3d;

// From the points alone.
GyroBiasEstimate estimateOf(const InitWindow& window, PairLoss loss = PairLoss::kEigenvalue) {
  GyroBiasProblem problem;
  problem.pair_loss = loss;
  return estimateGyroBias(window, problem);
}

void expectNear(const GyroBiasEstimate& estimate, const ExactWindow& exact, double relative) {
  ASSERT_TRUE(estimate.valid);
  const Vector3d& truth = exact.truth.front().gyro_bias;
  EXPECT_LT((estimate.gyro_bias - truth).norm() / truth.norm(), relative);
}

TEST(GyroBias, NoiseFreeRecoveryFromZero) {
  for (PairLoss loss : {PairLoss::kEigenvalue, PairLoss::kSumOfSquares}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(seed);
      const ExactWindow exact = makeExactWindow(seeded(seed));
      const GyroBiasEstimate estimate = estimateOf(*exact.window, loss);
      expectNear(estimate, exact, 1e-10);
      EXPECT_EQ(estimate.point_pairs, 9);
    }
  }
}

TEST(GyroBias, NoisyRecoveryStaysWithinTolerance) {
  // 0.6 px at a good excitation: DRT reports 2 % on EuRoC's easier sequences.
  constexpr double kTolerance = 0.08;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const ExactWindow exact = makeExactWindow(seeded(seed, 0.6));
    expectNear(estimateOf(*exact.window), exact, kTolerance);
  }
}

// sqrt(lambda_min) of one pair as a residual; with CauchyLoss Ceres then minimises half of the cost
// with PairLoss::kSumOfSquares.
struct PairResidual {
  const InitWindow* window;
  const EpipolarPair* pair;
  int i;
  bool operator()(const double* bias, double* residual) const {
    const Preintegration pre =
        preintegrate(window->imu(), window->times()[i], window->times()[i + 1],
                     {Eigen::Map<const Vector3d>(bias), Vector3d::Zero()}, ImuNoise(),
                     PreintegrationParts::kRotation);
    const Eigen::Matrix3d& R_b_c = window->calibration().R_b_c;
    *residual = std::sqrt(std::max(pair->evaluate(R_b_c.transpose() * pre.dR * R_b_c).lambda, 0.0));
    return true;
  }
};

TEST(GyroBias, SameMinimumAsCeres) {
  const ExactWindow exact = makeExactWindow(seeded(1, 0.6));
  const InitWindow& window = *exact.window;
  std::vector<EpipolarPair, Eigen::aligned_allocator<EpipolarPair>> pairs(window.size() - 1);
  for (const Track& track : window.pointTracks()) {
    for (int s = track.begin; s + 1 < track.end; ++s) {
      const WindowPoint& a = window.pointObservations()[s];
      const WindowPoint& b = window.pointObservations()[s + 1];
      if (b.keyframe == a.keyframe + 1) pairs[a.keyframe].add(a.bearing, b.bearing);
    }
  }
  double bias[3] = {0, 0, 0};
  ceres::Problem problem;
  for (int i = 0; i + 1 < window.size(); ++i) {
    const double scale =
        3.0 * window.calibration().sigmaBearing() * std::sqrt(2.0 * pairs[i].count());
    problem.AddResidualBlock(new ceres::NumericDiffCostFunction<PairResidual, ceres::CENTRAL, 1, 3>(
                                 new PairResidual{&window, &pairs[i], i}),
                             new ceres::CauchyLoss(scale), bias);
  }
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_QR;
  ceres_options.function_tolerance = 1e-16;
  ceres_options.gradient_tolerance = 1e-16;
  ceres_options.parameter_tolerance = 1e-14;
  ceres_options.max_num_iterations = 200;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem, &summary);
  ASSERT_TRUE(summary.IsSolutionUsable());

  const GyroBiasEstimate estimate = estimateOf(window, PairLoss::kSumOfSquares);
  EXPECT_LT((estimate.gyro_bias - Vector3d(bias[0], bias[1], bias[2])).norm(), 1e-6);
}

TEST(GyroBias, TooFewPointsIsNotValid) {
  ExactWindowOptions options;
  options.points = 4;
  const GyroBiasEstimate estimate = estimateOf(*makeExactWindow(options).window);
  EXPECT_FALSE(estimate.valid);
  EXPECT_EQ(estimate.point_pairs, 0);
}

TEST(VpResidual, VanishesAtTheTruthAndIgnoresSigns) {
  const Eigen::Matrix3d R_b_c = eurocCalibration().R_b_c;
  const Eigen::Matrix3d R_bi_bj = expSO3({0.1, -0.2, 0.3});
  const Vector3d d_w = Vector3d(0.2, 1.0, -0.4).normalized();
  const Vector3d d_i = R_b_c.transpose() * d_w;  // b_i is the world here
  const Vector3d d_j = R_b_c.transpose() * R_bi_bj.transpose() * d_w;
  Vector3d r, r_flipped;
  vpResidual(d_i, d_j, R_bi_bj, R_b_c, &r, nullptr);
  vpResidual(-d_i, d_j, R_bi_bj, R_b_c, &r_flipped, nullptr);
  EXPECT_LT(r.norm(), 1e-15);
  EXPECT_LT(r_flipped.norm(), 1e-15);
  // The trap of eq. (5): with the rotation in the wrong sense the residual does not vanish.
  vpResidual(d_i, d_j, R_bi_bj.transpose(), R_b_c, &r, nullptr);
  EXPECT_GT(r.norm(), 0.1);
}

TEST(VpResidual, JacobianAgreesWithDifferences) {
  const Eigen::Matrix3d R_b_c = eurocCalibration().R_b_c;
  const Vector3d d_i = Vector3d(0.1, -0.3, 0.9).normalized();
  for (const Vector3d& theta :
       {Vector3d(0, 0, 0), Vector3d(1e-8, 0, 0), Vector3d(0.3, -0.2, 0.5), Vector3d(0, 3.1, 0)}) {
    const Eigen::Matrix3d R = expSO3(theta);
    for (const Vector3d& d_j : {Vector3d(0.15, -0.25, 0.9), Vector3d(-0.1, 0.3, -0.8)}) {
      const auto f = [&](const Eigen::VectorXd& phi) -> Eigen::VectorXd {
        Vector3d r;
        vpResidual(d_i, d_j.normalized(), R * expSO3(phi), R_b_c, &r, nullptr);
        return r;
      };
      Vector3d r;
      Eigen::Matrix3d J;
      vpResidual(d_i, d_j.normalized(), R, R_b_c, &r, &J);
      EXPECT_TRUE(jacobiansAgree(J, numericJacobian(f, 3, 1e-6), 1e-8)) << theta.transpose();
    }
  }
}

TEST(GyroBias, VpTermAgreesWithExactDirectionsAndNeedsPoints) {
  ExactWindowOptions options;
  options.points = 0;
  const ExactWindow exact = makeExactWindow(options);
  const Vector3d axis_w = Vector3d::UnitZ();
  std::vector<VanishingPoint> vps(exact.truth.size());
  for (std::size_t k = 0; k < vps.size(); ++k) {
    vps[k].found = true;
    vps[k].direction = (exact.truth[k].R_w_b * exact.calibration.R_b_c).transpose() * axis_w;
    vps[k].track_id = 0;
    vps[k].age = static_cast<int>(k) + 1;
  }
  GyroBiasProblem problem;
  problem.pair_loss = PairLoss::kSumOfSquares;
  problem.vanishing_points = &vps;
  problem.vp_options.vp_weight = 1.0;
  problem.vp_options.vp_cauchy_scale = 0.05;
  // One axis leaves the rotation about it open, so that VPs alone are no answer.
  const GyroBiasEstimate alone = estimateGyroBias(*exact.window, problem);
  EXPECT_FALSE(alone.valid);

  options.points = 30;
  const ExactWindow with_points = makeExactWindow(options);
  const GyroBiasEstimate both = estimateGyroBias(*with_points.window, problem);
  ASSERT_TRUE(both.valid);
  EXPECT_LT((both.gyro_bias - options.gyro_bias).norm(), 1e-9);
  vps[4].direction = (vps[4].direction + Vector3d(0.02, -0.01, 0.015)).normalized();
  const GyroBiasEstimate off = estimateGyroBias(*with_points.window, problem);
  EXPECT_GT((off.gyro_bias - both.gyro_bias).norm(), 1e-8) << "vanishing points count";
}

TEST(ReliablePair, EveryConditionHasTwoSides) {
  using Vp = VanishingPoint;
  using Deg = std::array<double, 2>;  // consistencies
  SlimPaperOptions options;
  options.min_track_age = 3;
  options.consistency_threshold_deg = 1.0;
  const struct {
    const char* name;
    bool reliable;
    void (*change)(Vp* i, Vp* j, Deg* deg);
  } cases[] = {
      {"as it is", true, [](Vp*, Vp*, Deg*) {}},
      {"consistencies at the bound", true, [](Vp*, Vp*, Deg* deg) { deg->fill(1.0); }},
      {"the first is not found", false, [](Vp* i, Vp*, Deg*) { i->found = false; }},
      {"the second is not found", false, [](Vp*, Vp* j, Deg*) { j->found = false; }},
      {"another axis", false, [](Vp*, Vp* j, Deg*) { j->track_id = 6; }},
      {"not tracked is not the same axis", false,
       [](Vp* i, Vp* j, Deg*) { i->track_id = j->track_id = -1; }},
      {"the later one is young", false, [](Vp*, Vp* j, Deg*) { j->age = 2; }},
      {"the later one alone is young", false, [](Vp* i, Vp* j, Deg*) { i->age = 9, j->age = 2; }},
      {"the earlier one is young", true, [](Vp* i, Vp*, Deg*) { i->age = 1; }},
      {"the first is inconsistent", false, [](Vp*, Vp*, Deg* deg) { (*deg)[0] = 1.001; }},
      {"the second is inconsistent", false, [](Vp*, Vp*, Deg* deg) { (*deg)[1] = 1.001; }},
      {"the second is unknown", false, [](Vp*, Vp*, Deg* deg) { (*deg)[1] = kNotComputed; }},
  };
  for (const auto& one : cases) {
    Vp vp_i, vp_j;
    vp_i.found = vp_j.found = true;
    vp_i.track_id = vp_j.track_id = 5;
    vp_i.age = 2;
    vp_j.age = 3;
    Deg consistency = {0.5, 0.5};
    one.change(&vp_i, &vp_j, &consistency);
    for (double& value : consistency) value /= kDegPerRad;
    EXPECT_EQ(isReliablePair(vp_i, vp_j, consistency, options), one.reliable) << one.name;
  }
}

TEST(VanishingPoint, ConsistencyIsTheRmsOverTheInliers) {
  std::vector<WindowLine> lines(3);
  for (WindowLine& line : lines) line.normal = Vector3d::UnitX();
  VanishingPoint vp;
  EXPECT_EQ(consistencyOf(vp, lines), 0.0);
  vp.direction = Vector3d(0.3, 0.0, 1.0).normalized();
  vp.inliers = {0, 2};
  lines[2].normal = -Vector3d::UnitZ();
  EXPECT_NEAR(consistencyOf(vp, lines), std::sqrt(0.5), 1e-15);
}

}  // namespace
}  // namespace slim_init::baselines
