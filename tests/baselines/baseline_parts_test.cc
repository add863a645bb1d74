// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Parts of the compared systems: structure from motion, closed form, maximum likelihood.
#include <gtest/gtest.h>

#include <numeric>

#include "closed_form.h"
#include "geometry/so3.h"
#include "inertial_bundle_adjustment.h"
#include "structure_from_motion.h"
#include "support/exact_window.h"
#include "support/true_state.h"

namespace slim_init::baselines {
namespace {

Eigen::Matrix3Xd cameraCentresOf(const ExactWindow& exact) {
  const Calibration& calibration = exact.calibration;
  return calibration.R_b_c.transpose() * (trueCentres(exact).colwise() - calibration.t_b_c);
}

TEST(StructureFromMotion, RecoversCamerasUpToScale) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ExactWindow exact = makeExactWindow(seeded(seed));
    const StructureFromMotion sfm = reconstruct(*exact.window, VinsOptions());
    ASSERT_TRUE(sfm.valid()) << "seed " << seed << ": " << sfm.message;
    EXPECT_GT(sfm.points, 50);
    EXPECT_LT(sfm.rms_px, 1e-3);
    const std::vector<Eigen::Matrix3d> rotations = trueCameraRotations(exact);
    const Eigen::Matrix3Xd centres = cameraCentresOf(exact);
    const double scale = centres.norm() / sfm.centres_c0.norm();
    EXPECT_LT((scale * sfm.centres_c0 - centres).norm(), 1e-5 * centres.norm());
    for (std::size_t k = 0; k < rotations.size(); ++k) {
      EXPECT_LT(logSO3(sfm.R_c0_ck[k].transpose() * rotations[k]).norm(), 1e-5);
    }
  }
}

TEST(StructureFromMotion, NamesWhatIsMissing) {
  ExactWindowOptions few;
  few.points = 15;
  StructureFromMotion sfm = reconstruct(*makeExactWindow(few).window, VinsOptions());
  EXPECT_EQ(sfm.status, InitStatus::kTooFewTracks);
  EXPECT_NE(sfm.message.find("(minimum 21)"), std::string::npos) << sfm.message;
  VinsOptions demanding;
  demanding.min_parallax_px = 1e4;
  sfm = reconstruct(*makeExactWindow(ExactWindowOptions()).window, demanding);
  EXPECT_EQ(sfm.status, InitStatus::kTooLittleExcitation);
  EXPECT_NE(sfm.message.find("(minimum 10000)"), std::string::npos) << sfm.message;
  demanding = VinsOptions();
  demanding.min_pose_inliers = 10000;
  sfm = reconstruct(*makeExactWindow(ExactWindowOptions()).window, demanding);
  EXPECT_EQ(sfm.status, InitStatus::kTooFewTracks);
  EXPECT_NE(sfm.message.find("(minimum 10001)"), std::string::npos) << sfm.message;
}

TEST(ClosedForm, IsExactWithTrueRotations) {
  ExactWindowOptions options;
  options.gyro_bias.setZero();
  const ExactWindow exact = makeExactWindow(options);
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const std::vector<Preintegration> pre =
      preintegrateWindow(*exact.window, zero, zero, PreintegrationParts::kMean);
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  std::vector<int> tracks(exact.window->pointTracks().size());
  std::iota(tracks.begin(), tracks.end(), 0);
  const ClosedForm solution = solveClosedForm(
      *exact.window, tracks, linearMotion(pre, R_b0_bk, exact.calibration.t_b_c), R_b0_bk);
  ASSERT_TRUE(solution.valid);
  const WindowState truth = trueState(exact);
  EXPECT_LT((solution.velocity_b0 - truth.v_b0.col(0)).norm(), 1e-7);
  EXPECT_LT((solution.gravity_b0 - truth.gravity_b0).norm(), 1e-7);
  // Every point projects to where it was seen.
  int checked = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Track& track = exact.window->pointTracks()[tracks[i]];
    if (track.size() < 4) continue;
    for (int s = track.begin; s < track.end; ++s) {
      const WindowPoint& observation = exact.window->pointObservations()[s];
      const int k = observation.keyframe;
      const Eigen::Vector3d x_c =
          exact.calibration.R_b_c.transpose() *
          (truth.R_b0_bk[k].transpose() * (solution.points_b0[i] - truth.p_b0.col(k)) -
           exact.calibration.t_b_c);
      EXPECT_LT((x_c.normalized() - observation.bearing).norm(), 1e-6);
      ++checked;
    }
  }
  EXPECT_GT(checked, 100);
}

TEST(AdjustInertial, ReturnsFromAPerturbedStartToTheTruth) {
  ExactWindowOptions options;
  options.gyro_bias = Eigen::Vector3d(0.004, -0.006, 0.005);
  options.accel_bias = Eigen::Vector3d(-0.01, 0.02, 0.015);
  const ExactWindow exact = makeExactWindow(options);
  // Points from the closed form at the truth's biases, in the truth's world.
  const NavState& first = exact.truth[0];
  const std::vector<Preintegration> pre = preintegrateWindow(
      *exact.window, options.gyro_bias, options.accel_bias, PreintegrationParts::kWithCovariance);
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  std::vector<int> tracks;
  for (std::size_t t = 0; t < exact.window->pointTracks().size(); ++t) {
    if (exact.window->pointTracks()[t].size() >= 4) tracks.push_back(static_cast<int>(t));
  }
  const ClosedForm solution = solveClosedForm(
      *exact.window, tracks, linearMotion(pre, R_b0_bk, exact.calibration.t_b_c), R_b0_bk);
  ASSERT_TRUE(solution.valid);
  std::vector<MappedTrack> points;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    points.push_back({tracks[i], first.R_w_b * solution.points_b0[i] + first.p_w_b +
                                     0.02 * Eigen::Vector3d(1, -1, 1)});
  }
  // Everything but the first pose, which the prior keeps, is moved.
  std::vector<NavState> states = exact.truth;
  for (std::size_t k = 1; k < states.size(); ++k) {
    states[k].R_w_b *= expSO3(Eigen::Vector3d(0.01, -0.008, 0.005));
    states[k].p_w_b += Eigen::Vector3d(0.03, 0.02, -0.02);
    states[k].v_w_b += Eigen::Vector3d(-0.02, 0.03, 0.02);
  }
  OpenVinsOptions exactly;
  exactly.function_tolerance = 1e-14;
  exactly.gyro_bias_prior = exactly.accel_bias_prior = 1e3;
  const InertialAdjustment out = adjustInertial(*exact.window, pre, exactly, &states, &points);
  EXPECT_TRUE(out.converged);
  EXPECT_LT(out.cost, 1e-6 * out.first_cost);
  for (std::size_t k = 0; k < states.size(); ++k) {
    EXPECT_LT((states[k].p_w_b - exact.truth[k].p_w_b).norm(), 1e-4);
    EXPECT_LT((states[k].v_w_b - exact.truth[k].v_w_b).norm(), 1e-4);
    EXPECT_LT(logSO3(states[k].R_w_b.transpose() * exact.truth[k].R_w_b).norm(), 1e-4);
    EXPECT_LT((states[k].gyro_bias - options.gyro_bias).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace slim_init::baselines
