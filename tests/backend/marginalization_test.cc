// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The prior against the batch problem that it stands for.
#include <ceres/crs_matrix.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <memory>
#include <vector>

#include "geometry/so3.h"
#include "inertial_cost.h"
#include "prior.h"
#include "reprojection_cost.h"
#include "support/exact_window.h"

namespace slim_init::backend {
namespace {

struct Point {
  std::vector<std::pair<int, Eigen::Vector3d>> views;  ///< frame and bearing
  double lambda = 0.2;
};

/// Five frames, their IMU factors, an anchor and points; noisy, so that no residual is zero.
class SmallProblem {
 public:
  explicit SmallProblem(unsigned seed, bool anchored = true) : anchored_(anchored) {
    ExactWindowOptions options;
    options.keyframes = 5;
    options.points = 40;
    options.seed = seed;
    const ExactWindow exact = noisyWindow(options);
    calibration = exact.calibration;
    for (int k = 0; k < 5; ++k) {
      auto frame = std::make_unique<Frame>();
      frame->id = k;
      frame->set(exact.truth[static_cast<std::size_t>(k)]);
      frames.push_back(std::move(frame));
    }
    anchor_ = anchorAt(*frames.front());
    for (int k = 0; k < 4; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const NavState& state = exact.truth[i];
      links_.push_back(preintegrate(exact.imu, state.t, exact.truth[i + 1].t,
                                    {state.gyro_bias, state.accel_bias}, calibration.imu_noise,
                                    PreintegrationParts::kWithCovariance));
    }
    std::map<FeatureId, Point> tracks;
    for (int k = 0; k < 5; ++k) {
      for (const PointObservation& point : exact.keyframes[static_cast<std::size_t>(k)].points) {
        // A third of the points is first seen a frame later, so that some do not touch frame 0.
        if (k == 0 && point.id % 3 == 0) continue;
        tracks[point.id].views.emplace_back(k, point.bearing);
      }
    }
    for (const auto& [id, point] : tracks) {
      if (point.views.size() >= 3) points.push_back(point);
    }
  }

  std::unique_ptr<InertialCost> inertial(int k) const {
    const auto i = static_cast<std::size_t>(k);
    return InertialCost::create(links_[i], frames[i]->R_ref, frames[i + 1]->R_ref,
                                Eigen::Vector3d(0, 0, -calibration.gravity_magnitude), 1e-3, 1e-1);
  }
  std::unique_ptr<PriorCost> anchor() const { return std::make_unique<PriorCost>(anchor_, frames); }
  std::unique_ptr<ReprojectionCost> view(const Point& point, std::size_t v) const {
    return std::make_unique<ReprojectionCost>(
        *frames[static_cast<std::size_t>(point.views[0].first)],
        *frames[static_cast<std::size_t>(point.views[v].first)], calibration, point.views[0].second,
        point.views[v].second, calibration.sigmaBearing());
  }
  double* pose(int k) { return frames[static_cast<std::size_t>(k)]->pose.data(); }
  double* motion(int k) { return frames[static_cast<std::size_t>(k)]->motion.data(); }

  /// The factors whose first frame is one of these.
  void addFactors(int first, int last, ceres::Problem* problem) {
    if (first == 0 && anchored_) {
      problem->AddResidualBlock(anchor().release(), nullptr, pose(0), motion(0));
    }
    for (int k = first; k <= last; ++k) {
      problem->AddResidualBlock(inertial(k).release(), nullptr, pose(k), motion(k), pose(k + 1),
                                motion(k + 1));
    }
    for (Point& point : points) {
      if (point.views[0].first < first || point.views[0].first > last) continue;
      for (std::size_t v = 1; v < point.views.size(); ++v) {
        problem->AddResidualBlock(view(point, v).release(), nullptr, pose(point.views[0].first),
                                  pose(point.views[v].first), &point.lambda);
      }
    }
  }

  /// Everything, or what is left when the prior stands for frame 0.
  void solve(const Prior* prior) {
    ceres::Problem problem;
    addFactors(prior == nullptr ? 0 : 1, 3, &problem);
    if (prior != nullptr) {
      std::vector<double*> blocks;
      for (const BlockKey& key : prior->blocks) blocks.push_back(blockData(key, frames));
      problem.AddResidualBlock(new PriorCost(*prior, frames), nullptr, blocks);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-18;
    options.gradient_tolerance = 1e-16;
    options.parameter_tolerance = 1e-16;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    ASSERT_TRUE(summary.IsSolutionUsable()) << summary.message;
    for (auto& frame : frames) frame->rebase();
  }

  /// The prior that takes over from frame 0 at the present state.
  Prior marginalizeFirst() const {
    Marginalization marginalization(frames, Prior());
    const BlockKey pose0 = {0, BlockKind::kPose}, motion0 = {0, BlockKind::kMotion};
    if (anchored_) marginalization.add(*anchor(), {pose0, motion0});
    marginalization.add(*inertial(0),
                        {pose0, motion0, {1, BlockKind::kPose}, {1, BlockKind::kMotion}});
    const ceres::TrivialLoss loss;
    for (const Point& point : points) {
      if (point.views[0].first != 0) continue;
      std::vector<std::unique_ptr<ReprojectionCost>> costs;
      std::vector<Marginalization::PointView> views;
      for (std::size_t v = 1; v < point.views.size(); ++v) {
        costs.push_back(view(point, v));
        views.push_back({costs.back().get(), pose0, {point.views[v].first, BlockKind::kPose}});
      }
      marginalization.addPoint(views, point.lambda, loss);
    }
    return marginalization.eliminate({pose0, motion0});
  }

  Calibration calibration;
  Frames frames;
  std::vector<Point> points;

 private:
  bool anchored_;
  Prior anchor_;
  std::vector<Preintegration> links_;
};

std::vector<NavState> statesOf(const SmallProblem& problem) {
  std::vector<NavState> states;
  for (const auto& frame : problem.frames) states.push_back(frame->state());
  return states;
}

class Marginalized : public ::testing::TestWithParam<unsigned> {};

// The prior made at the optimum and what is left of the problem have the optimum of the whole.
TEST_P(Marginalized, SolutionIsThatOfTheBatch) {
  SmallProblem problem(GetParam());
  problem.solve(nullptr);
  const std::vector<NavState> batch = statesOf(problem);
  const Prior prior = problem.marginalizeFirst();
  ASSERT_FALSE(prior.empty());

  // From elsewhere, with other distances.
  for (std::size_t k = 1; k < 5; ++k) {
    NavState moved = batch[k];
    moved.p_w_b += Eigen::Vector3d(0.05, -0.03, 0.02);
    moved.v_w_b += Eigen::Vector3d(-0.1, 0.1, 0.05);
    moved.R_w_b = moved.R_w_b * expSO3(Eigen::Vector3d(0.02, -0.01, 0.03));
    problem.frames[k]->set(moved);
  }
  for (Point& point : problem.points) point.lambda *= 1.1;
  problem.solve(&prior);
  const std::vector<NavState> windowed = statesOf(problem);
  for (std::size_t k = 1; k < 5; ++k) {
    EXPECT_LT((windowed[k].p_w_b - batch[k].p_w_b).norm(), 1e-6) << k;
    EXPECT_LT((windowed[k].v_w_b - batch[k].v_w_b).norm(), 1e-6) << k;
    EXPECT_LT(logSO3(windowed[k].R_w_b.transpose() * batch[k].R_w_b).norm(), 1e-6) << k;
    EXPECT_LT((windowed[k].gyro_bias - batch[k].gyro_bias).norm(), 1e-6) << k;
    EXPECT_LT((windowed[k].accel_bias - batch[k].accel_bias).norm(), 1e-5) << k;
  }
}

// Its information is the Schur complement of the stacked Jacobian, computed apart.
TEST_P(Marginalized, InformationIsTheSchurComplement) {
  SmallProblem problem(GetParam());
  const Prior prior = problem.marginalizeFirst();

  ceres::Problem factors;
  problem.addFactors(0, 0, &factors);
  // What goes, frame 0 and the points seen from it, before what the prior keeps.
  ceres::Problem::EvaluateOptions columns;
  columns.parameter_blocks = {problem.pose(0), problem.motion(0)};
  for (Point& point : problem.points) {
    if (point.views[0].first == 0) columns.parameter_blocks.push_back(&point.lambda);
  }
  const auto gone = static_cast<Eigen::Index>(15 + columns.parameter_blocks.size() - 2);
  for (const BlockKey& key : prior.blocks) {
    columns.parameter_blocks.push_back(blockData(key, problem.frames));
  }
  ceres::CRSMatrix sparse;
  ASSERT_TRUE(factors.Evaluate(columns, nullptr, nullptr, nullptr, &sparse));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int r = 0; r < sparse.num_rows; ++r) {
    for (int i = sparse.rows[r]; i < sparse.rows[r + 1]; ++i)
      J(r, sparse.cols[i]) = sparse.values[i];
  }
  const Eigen::MatrixXd H = J.transpose() * J;
  const Eigen::Index kept = H.rows() - gone;
  const Eigen::MatrixXd schur =
      H.bottomRightCorner(kept, kept) -
      H.bottomLeftCorner(kept, gone) *
          H.topLeftCorner(gone, gone).ldlt().solve(H.topRightCorner(gone, kept));
  EXPECT_LT((prior.J.transpose() * prior.J - schur).norm() / schur.norm(), 1e-8);
  // Positive semi-definite, up to rounding.
  EXPECT_GT(prior.lowest_eigenvalue, -1e-9);
}

// Without an anchor nothing is known about where the window stands and which way it heads, however
// often it is marginalised and wherever its states have moved meanwhile.
TEST_P(Marginalized, PositionAndHeadingStayFree) {
  SmallProblem problem(GetParam(), false);
  Prior prior = problem.marginalizeFirst();
  // The states move away from where the prior was made.
  for (auto& frame : problem.frames) {
    NavState moved = frame->state();
    moved.p_w_b += Eigen::Vector3d(0.1, 0.05, -0.08) * (1.0 + static_cast<double>(frame->id));
    moved.R_w_b = expSO3(Eigen::Vector3d(0.03, 0.02, 0.05)) * moved.R_w_b;
    frame->set(moved);
  }
  Marginalization marginalization(problem.frames, prior);
  const BlockKey pose1 = {1, BlockKind::kPose}, motion1 = {1, BlockKind::kMotion};
  marginalization.add(*problem.inertial(1),
                      {pose1, motion1, {2, BlockKind::kPose}, {2, BlockKind::kMotion}});
  const Prior second = marginalization.eliminate({pose1, motion1});
  ASSERT_GT(second.lowest_eigenvalue, -1e-9);

  // The free directions at the first estimates: a shift, and a turn about the vertical.
  Eigen::MatrixXd free = Eigen::MatrixXd::Zero(second.J.cols(), 4);
  int column = 0;
  for (std::size_t k = 0; k < second.blocks.size(); ++k) {
    const BlockKey& key = second.blocks[k];
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    if (key.kind == BlockKind::kPose) {
      free.block<3, 3>(column, 0).setIdentity();
      free.block<3, 1>(column, 3) = up.cross(second.first[k].x.head<3>());
      free.block<3, 1>(column + 3, 3) = second.first[k].R.transpose() * up;
    } else {
      free.block<3, 1>(column, 3) = up.cross(second.first[k].x.head<3>());
    }
    column += key.size();
  }
  const double scale = second.J.norm();
  for (int d = 0; d < 3; ++d) {
    EXPECT_LT((second.J * free.col(d)).norm() / (scale * free.col(d).norm()), 1e-6) << d;
  }
  EXPECT_LT((second.J * free.col(3)).norm() / (scale * free.col(3).norm()), 1e-3);
}

// What is in the prior keeps its first linearisation point.
TEST(MarginalizedOnce, FirstEstimatesDoNotMove) {
  SmallProblem problem(3);
  const Prior first = problem.marginalizeFirst();
  NavState moved = problem.frames[2]->state();
  moved.p_w_b.x() += 0.5;
  problem.frames[2]->set(moved);
  Marginalization marginalization(problem.frames, first);
  const BlockKey pose1 = {1, BlockKind::kPose}, motion1 = {1, BlockKind::kMotion};
  marginalization.add(*problem.inertial(1),
                      {pose1, motion1, {2, BlockKind::kPose}, {2, BlockKind::kMotion}});
  const Prior second = marginalization.eliminate({pose1, motion1});
  for (std::size_t a = 0; a < first.blocks.size(); ++a) {
    for (std::size_t b = 0; b < second.blocks.size(); ++b) {
      if (first.blocks[a] < second.blocks[b] || second.blocks[b] < first.blocks[a]) continue;
      EXPECT_EQ(first.first[a].x, second.first[b].x);
    }
  }
  // Only the motion of frame 2 is new to the prior, and enters at its present value.
  for (std::size_t b = 0; b < second.blocks.size(); ++b) {
    if (second.blocks[b].frame != 2) continue;
    if (second.blocks[b].kind == BlockKind::kPose) {
      EXPECT_NEAR(second.first[b].x[0], moved.p_w_b.x() - 0.5, 1e-12);
    } else {
      EXPECT_EQ(second.first[b].x.head<3>(), moved.v_w_b);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Marginalized, ::testing::Values(1u, 2u, 3u));

}  // namespace
}  // namespace slim_init::backend
