// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/keyframe_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "data/derived_window.h"
#include "geometry/robust.h"
#include "geometry/so3.h"
#include "rotation/multi_gap_bias.h"
#include "rotation/robust_bias.h"
#include "support/exact_window.h"
#include "support/robust_bias.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(KeyframePairs, AllGapsWithTheirCommonPoints) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const KeyframePairs pairs(*exact.window, 8);
  ASSERT_EQ(pairs.size(), 9u + 8u + 6u + 2u);
  EXPECT_EQ(KeyframePairs(*exact.window, 4).size(), 9u + 8u + 6u);
  EXPECT_EQ(pairs.pointPairs(), 25);
  ExactWindowOptions few;
  few.points = 5;
  EXPECT_EQ(KeyframePairs(*makeExactWindow(few).window, 8).pointPairs(), 0);
  const std::vector<WindowPoint>& s = exact.window->pointObservations();
  std::vector<FeatureId> track_of(s.size());
  for (const Track& track : exact.window->pointTracks()) {
    std::fill_n(track_of.begin() + track.begin, track.size(), track.id);
  }
  int last_gap = 1;
  for (const KeyframePair& pair : pairs) {
    EXPECT_GE(pair.gap(), last_gap);
    last_gap = pair.gap();
    for (int k = 0; k < pair.points.count(); ++k) {
      EXPECT_EQ(s[pair.observation_i[k]].keyframe, pair.i);
      EXPECT_EQ(s[pair.observation_j[k]].keyframe, pair.j);
      EXPECT_EQ(pair.points.bearingsI().row(k).transpose().matrix(),
                s[pair.observation_i[k]].bearing);
      EXPECT_EQ(track_of[pair.observation_i[k]], track_of[pair.observation_j[k]]);
    }
  }
}

TEST(GyroRotations, AreThoseOfTheMotionAtTheTrueBias) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const KeyframePairs pairs(*exact.window, 8);
  const Matrix3d& R_b_c = exact.window->calibration().R_b_c;
  const WindowState truth = trueState(exact);
  GyroRotations gyro(*exact.window);
  gyro.linearizeNear(atBias(truth.gyro_bias));
  const PairRotations at = gyro.at(atBias(truth.gyro_bias), pairs, 4);
  ASSERT_EQ(at.size(), pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Matrix3d R = R_b_c.transpose() * truth.R_b0_bk[pairs[p].i].transpose() *
                       truth.R_b0_bk[pairs[p].j] * R_b_c;
    if (pairs[p].gap() > 4) {
      EXPECT_EQ(at[p].R_ci_cj, Matrix3d::Identity()) << "beyond the gaps asked for";
    } else {
      EXPECT_LT((at[p].R_ci_cj - R).norm(), 1e-9);
    }
  }
}

TEST(GyroRotations, JacobianAgreesWithDifferences) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const KeyframePairs pairs(*exact.window, 8);
  const GyroRotations gyro(*exact.window);
  RotationUnknowns x;
  x << 1e-3, -2e-3, 1e-3, 0.1, -0.2, 0.15, 2e-3;
  const PairRotations at = gyro.at(x, pairs, 8);
  for (int i = 0; i < x.size(); ++i) {
    const RotationUnknowns step = 1e-6 * RotationUnknowns::Unit(i);
    const PairRotations more = gyro.at(x + step, pairs, 8), less = gyro.at(x - step, pairs, 8);
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const Vector3d turned = logSO3(less[p].R_ci_cj.transpose() * more[p].R_ci_cj);
      EXPECT_LT((turned - at[p].J * (2.0 * step)).norm(), 1e-4 * turned.norm() + 1e-13) << i;
    }
  }
}

// Integrated again, a td of 30 ms is as exact as the rates are; before it is first order.
TEST(GyroRotations, AreThoseOfAnotherCalibration) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  RotationUnknowns error = RotationUnknowns::Zero();
  error.tail<4>() << 0.1, -0.05, 0.08, -0.03;
  Calibration off = exact.calibration;
  off.R_b_c = off.R_b_c * expSO3(-error.segment<3>(3));
  off.td -= error[6];
  const auto window = withCalibration(*exact.window, off);
  ASSERT_EQ(window->size(), exact.window->size() - 1) << "the last keyframe is not covered";
  const KeyframePairs pairs(*window, 8);
  GyroRotations gyro(*window), truth(*exact.window);
  gyro.linearizeNear(error);
  const PairRotations at = gyro.at(error, pairs, 8);
  const PairRotations right = truth.at(RotationUnknowns::Zero(), pairs, 8);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    EXPECT_LT((at[p].R_ci_cj - right[p].R_ci_cj).norm(), 1e-9);
  }
}

TEST(GyroRotations, IntegratesAnewBeyondTheToleranceOnly) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const KeyframePairs pairs(*exact.window, 8);
  const Vector3d small = Vector3d::Constant(5e-4), bias = ExactWindowOptions().gyro_bias;
  GyroRotations untouched(*exact.window), within(*exact.window), beyond(*exact.window);
  within.linearizeNear(atBias(small));
  beyond.linearizeNear(atBias(bias));
  const std::size_t longest = pairs.size() - 1;
  EXPECT_EQ(within.at(atBias(bias), pairs, 8)[longest].R_ci_cj,
            untouched.at(atBias(bias), pairs, 8)[longest].R_ci_cj);
  EXPECT_NE(beyond.at(atBias(bias), pairs, 8)[longest].R_ci_cj,
            untouched.at(atBias(bias), pairs, 8)[longest].R_ci_cj);
}

TEST(FindBaselines, FindsThoseOfTheMotionAndKeepsWhatIsBeyondTheGaps) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const KeyframePairs pairs(*exact.window, 8);
  const WindowState truth = trueState(exact);
  GyroRotations gyro(*exact.window);
  gyro.linearizeNear(atBias(truth.gyro_bias));
  Baselines found(pairs.size(), Eigen::Vector3d::Zero());
  found.back() = Vector3d::UnitY();
  EXPECT_LT(findBaselines(pairs, gyro.at(atBias(truth.gyro_bias), pairs, 4), 4, {}, &found), 1e-3);
  EXPECT_EQ(found.back(), Vector3d::UnitY());
  const Calibration& calibration = exact.window->calibration();
  const auto centre = [&](int k) { return cameraCentre(truth, k, calibration.t_b_c); };
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (pairs[p].gap() > 4) continue;
    const Vector3d t = calibration.R_b_c.transpose() * (truth.R_b0_bk[pairs[p].i].transpose() *
                                                        (centre(pairs[p].j) - centre(pairs[p].i)));
    EXPECT_NEAR(std::abs(found[p].dot(t.normalized())), 1.0, 1e-5) << p;
  }
}

TEST(MasksOf, LeaveOutDroppedObservations) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  const InitWindow& window = *exact.window;
  const KeyframePairs pairs(window, 8);
  std::vector<char> keep(window.pointObservations().size(), kKeepObservation);
  for (const Eigen::ArrayXd& mask : masksOf(pairs, keep)) EXPECT_TRUE((mask == 1.0).all());
  int track = 0;
  while (window.pointTracks()[track].size() < 6) ++track;
  const int begin = window.pointTracks()[track].begin;
  keep[begin + 1] = kDropObservation;
  const PointMasks masks = masksOf(pairs, keep);
  int left_out = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    for (int k = 0; k < pairs[p].points.count(); ++k) {
      const int a = pairs[p].observation_i[k], b = pairs[p].observation_j[k];
      const bool dropped = a == begin + 1 || b == begin + 1;
      EXPECT_EQ(masks[p][k], dropped ? 0.0 : 1.0);
      left_out += masks[p][k] == 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(left_out, 0);
}

TEST(MultiGapProblem, ConsecutivePairsEnterWhereLongerOnesHaveFewPoints) {
  const auto consecutiveEnter = [&](int keyframes, int points) {
    ExactWindowOptions window;
    window.keyframes = keyframes;
    window.points = points;
    const ExactWindow exact = makeExactWindow(window);
    const MultiGapProblem problem(*exact.window, nullptr, InertialOptions(), RigPrior());
    EXPECT_TRUE(problem.enters(problem.pairs()[keyframes - 1], 8)) << "two keyframes apart";
    return problem.enters(problem.pairs()[0], 8);
  };
  EXPECT_FALSE(consecutiveEnter(10, 100));
  EXPECT_TRUE(consecutiveEnter(10, 15));
  EXPECT_TRUE(consecutiveEnter(7, 100));
}

TEST(MultiGapProblem, EqualCallsGiveEqualAnswersWhateverWasCalledBefore) {
  const ExactWindowOptions window = seeded(1, 0.6);
  const ExactWindow exact = makeExactWindow(window);
  MultiGapProblem problem(*exact.window, nullptr, InertialOptions(), RigPrior());
  const int max_gap = kLongestGap;
  const auto minimum = [&]() {
    return problem.minimize(atBias(window.gyro_bias), max_gap, kNarrowStart, {},
                            Baselines(problem.pairs().size(), Eigen::Vector3d::Zero()));
  };
  const RotationUnknowns first = minimum().x;
  // At another bias, with other weights: nothing of it stays but where the gyro was integrated.
  Baselines elsewhere(problem.pairs().size(), Eigen::Vector3d::Zero());
  problem.weigh(atBias(Vector3d(0.3, -0.3, 0.3)), max_gap, 3.0, {}, &elsewhere);
  EXPECT_LT((minimum().x - first).norm(), 1e-9);
}

TEST(CutoffSchedules, EndAtTheCutoffOfTheConsensus) {
  for (const CutoffSchedule& schedule : {kNarrowStart, kWideStart}) {
    ASSERT_GE(schedule.size(), 1u);
    ASSERT_LE(schedule.size(), 4u);
    EXPECT_EQ(schedule.back(), kOutlierSigmas);
    for (std::size_t c = 1; c < schedule.size(); ++c) EXPECT_LE(schedule[c], schedule[c - 1]);
  }
}

}  // namespace
}  // namespace slim_init
