// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Depths from all views of a feature.
#include <gtest/gtest.h>

#include "geometry/so3.h"
#include "slim_init/vins_adapter/host_members.h"
#include "support/gaussian.h"
#include "vins_adapter/stand_in/host_parts.h"

namespace slim_init::vins_adapter {
namespace {

// `count` cameras a `step` apart that turn a little; the point in the world is seen with `noise`.
std::vector<DepthView> viewsOf(const Eigen::Vector3d& point, int count, double step, double noise,
                               unsigned seed = 1) {
  Gaussian normal(seed);
  std::vector<DepthView> views;
  for (int k = 0; k < count; ++k) {
    DepthView view;
    view.R = expSO3(Eigen::Vector3d(0.01 * k, -0.02 * k, 0.03));
    view.t = Eigen::Vector3d(step * k, 0.3 * step * k, 0.1);
    const Eigen::Vector3d p = view.R.transpose() * (point - view.t);
    view.ray = p / p.z() + noise * Eigen::Vector3d{normal(), normal(), 0.0};
    views.push_back(view);
  }
  return views;
}

double trueDepth(const std::vector<DepthView>& views, const Eigen::Vector3d& point) {
  return (views[0].R.transpose() * (point - views[0].t)).z();
}

TEST(HostDepth, IsExactOnExactViews) {
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0.3, -0.2, 4.0), Eigen::Vector3d(1, 1, 20)}) {
    for (const int count : {2, 3, 11}) {
      const std::vector<DepthView> views = viewsOf(point, count, 0.05, 0.0);
      EXPECT_NEAR(depthFromAllViews(views) / trueDepth(views, point), 1.0, 1e-6) << count;
    }
  }
}

// Eleven views over half a metre know the depth that two over five centimetres do not.
TEST(HostDepth, UsesTheWholeBaseline) {
  const Eigen::Vector3d point(0.3, -0.2, 5.0);
  const double noise = 0.7 / 460.0;
  double all = 0.0, two = 0.0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::vector<DepthView> views = viewsOf(point, 11, 0.05, noise, seed);
    const double depth = trueDepth(views, point);
    all += std::pow(depth / depthFromAllViews(views) - 1.0, 2);
    views.resize(2);
    two += std::pow(depth / depthFromAllViews(views) - 1.0, 2);
  }
  EXPECT_LT(std::sqrt(all / 50), 0.04);
  EXPECT_GT(std::sqrt(two / 50), 0.12);
}

TEST(HostDepth, PointsWithoutParallaxAreFarAndOneViewHasNone) {
  EXPECT_EQ(depthFromAllViews({}), -1.0);
  EXPECT_EQ(depthFromAllViews({DepthView()}), -1.0);
  // At rest, and with rays that diverge.
  EXPECT_EQ(depthFromAllViews(viewsOf({0, 0, 5}, 5, 0.0, 0.0)), kFarDepth);
  std::vector<DepthView> diverging(2);
  diverging[1].t = Eigen::Vector3d(0.1, 0, 0);
  diverging[1].ray = Eigen::Vector3d(0.01, 0, 1);
  EXPECT_NEAR(depthFromAllViews(diverging), kFarDepth, 1e-9);
}

TEST(HostDepth, FeaturesBeginAtTheirFrameAndTheExtrinsicCounts) {
  const Eigen::Vector3d point(0.3, -0.2, 6.0);
  const std::vector<DepthView> views = viewsOf(point, 11, 0.05, 0.0);
  EstimatorParts<double, 1> host;
  host.ric[0] = expSO3(Eigen::Vector3d(1.2, -0.4, 0.8));
  host.tic[0] = Eigen::Vector3d(0.1, 0.05, -0.2);
  for (int i = 0; i < 11; ++i) {
    host.Rs[i] = views[i].R * host.ric[0].transpose();
    host.Ps[i] = views[i].t - host.Rs[i] * host.tic[0];
  }
  host.f_manager.feature.resize(2);
  Feature &late = host.f_manager.feature.front(), &once = host.f_manager.feature.back();
  late.start_frame = 4;
  for (int i = 4; i < 9; ++i) late.feature_per_frame.push_back({views[i].ray});
  once.feature_per_frame.push_back({views[0].ray});
  fillDepths(host);
  EXPECT_NEAR(late.estimated_depth, (views[4].R.transpose() * (point - views[4].t)).z(), 1e-5);
  EXPECT_EQ(once.estimated_depth, -1.0);
}

}  // namespace
}  // namespace slim_init::vins_adapter
