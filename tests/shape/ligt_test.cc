// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "shape/ligt.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/exact_window.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Truth {
  std::vector<Matrix3d> R_c0_ck;
  Eigen::Matrix3Xd centres_c0;  // column 0 zero, unit spread
};

Truth cameraTruth(const ExactWindow& exact) {
  Truth truth;
  const Matrix3d& R_b_c = exact.calibration.R_b_c;
  double metres = 0.0;
  truth.centres_c0 = R_b_c.transpose() * trueShape(exact, &metres);
  const Vector3d first = truth.centres_c0.col(0);
  truth.centres_c0.colwise() -= first;
  truth.R_c0_ck = trueCameraRotations(exact);
  return truth;
}

TEST(Ligt, BaseViewsAreThoseWithTheLargestParallax) {
  const auto at = [](double angle) { return Vector3d(std::sin(angle), 0.0, std::cos(angle)); };
  const BaseViews base = chooseBaseViews({at(0.1), at(-0.2), at(0.15), at(0.12)});
  EXPECT_EQ(base.l, 1);
  EXPECT_EQ(base.r, 2);
  EXPECT_NEAR(base.parallax2, std::pow(std::sin(0.35), 2), 1e-15);
  EXPECT_LT(chooseBaseViews({at(0.1)}).parallax2, 0.0);
}

TEST(Ligt, RowVanishesForThreeViewsOfAPoint) {
  const Vector3d X(0.5, -0.3, 4.0);
  const Vector3d c_l(0, 0, 0), c_r(0.4, 0.1, -0.2), c_i(-0.2, 0.3, 0.5);
  const auto u = [&](const Vector3d& c) -> Vector3d { return (X - c).normalized(); };
  const LigtRow row = ligtRow(u(c_l), u(c_r), u(c_i));
  EXPECT_LT((row.block_l * c_l + row.block_r * c_r + row.block_i * c_i).norm(), 1e-16);
  // And not for a wrong position of the third view.
  const Vector3d wrong = c_i + Vector3d(0.1, 0, 0);
  EXPECT_GT((row.block_l * c_l + row.block_r * c_r + row.block_i * wrong).norm(), 1e-5);
}

TEST(Ligt, CentresAreExactWithoutNoiseAndStayNearWithIt) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const double pixel_noise : {0.0, 0.6}) {
      const ExactWindow exact = makeExactWindow(seeded(seed, pixel_noise));
      const Truth truth = cameraTruth(exact);
      const TranslationEstimate estimate = estimateTranslations(*exact.window, truth.R_c0_ck);
      ASSERT_TRUE(estimate.valid);
      // Of the spread of the trajectory.
      const double tolerance = pixel_noise > 0.0 ? 0.03 : 1e-9;
      EXPECT_LT((estimate.centres_c0 - truth.centres_c0).norm(), tolerance) << seed;
      EXPECT_GT(estimate.linkage(), pixel_noise > 0.0 ? 10.0 : 1e6);
    }
  }
}

TEST(Ligt, TooFewTracksAreInvalid) {
  ExactWindowOptions options;
  options.points = 5;
  const ExactWindow few = makeExactWindow(options);
  const TranslationEstimate estimate = estimateTranslations(*few.window, cameraTruth(few).R_c0_ck);
  EXPECT_FALSE(estimate.valid);
  EXPECT_LE(estimate.tracks, 5);
}

TEST(Ligt, TwoDisconnectedHalvesHaveNoLinkage) {
  // Tracks of the first five keyframes never meet those of the last five: two free scales.
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  std::vector<FrameObservation> frames = exact.keyframes;
  for (std::size_t k = 5; k < frames.size(); ++k) {
    for (PointObservation& point : frames[k].points) point.id += 1000000;
  }
  const auto window = windowOf(exact, frames);
  const TranslationEstimate estimate = estimateTranslations(*window, cameraTruth(exact).R_c0_ck);
  ASSERT_TRUE(estimate.valid);
  EXPECT_LT(estimate.linkage(), 10.0);
}

}  // namespace
}  // namespace slim_init
