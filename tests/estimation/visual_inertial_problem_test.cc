// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The minimisation against Ceres (landmarks as parameters there, eliminated here), among gross
// errors, and rejection.
#include "estimation/visual_inertial_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <random>

#include "estimation/refine_window.h"
#include "geometry/so3.h"
#include "support/ceres_window.h"
#include "support/exact_window.h"
#include "support/track_views.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

ExactWindow noisyWindow(unsigned seed) {
  ExactWindowOptions options;
  options.accel_bias = Eigen::Vector3d(0.05, -0.08, 0.1);
  options.seed = seed;
  options.points = 60;
  return noisyWindow(options);
}

TEST(VisualInertialProblem, NoiseFreeMinimumIsTheTruth) {
  const ExactWindow exact = makeExactWindow(ExactWindowOptions());
  RefinementOptions options;
  options.tolerance = 1e-10;
  options.max_iterations = 30;
  InertialOptions inertial;
  inertial.gyro_bias_prior = 10.0;
  // The noise sets where the minimisation ends, and with it the last digits of the cost below.
  inertial.accel_noise_factor = 10.0;
  inertial.gyro_noise_factor = 3.0;
  const WindowState truth = trueState(exact);
  const std::vector<Preintegration> pre =
      preintegrateInflated(*exact.window, truth.gyro_bias, truth.accel_bias, inertial);
  VisualInertialProblem map(*exact.window, exact.window->lineTracks(), pre, options, inertial);
  WindowState state = moved(truth, 0.02, 3, true);
  const MapSummary summary = map.minimize(options.max_iterations, options.tolerance, &state);
  ASSERT_TRUE(summary.valid);
  EXPECT_TRUE(summary.converged);
  // What is left are line parameters that the views hardly determine; they move no state.
  EXPECT_LT(summary.visual_cost, 1e-4);
  EXPECT_LT((state.p_b0 - truth.p_b0).norm(), 1e-7 * truth.p_b0.norm());
  EXPECT_LT((state.v_b0 - truth.v_b0).norm(), 1e-7 * truth.v_b0.norm());
  EXPECT_LT((state.gravity_b0 - truth.gravity_b0).norm(), 1e-6);
  EXPECT_LT((state.gyro_bias - truth.gyro_bias).norm(), 1e-7 * truth.gyro_bias.norm() + 1e-8);
}

// A line by two points on it: redundant parameters, the same residuals and minimum.
struct CeresLine {
  LineView view;
  RotationStart start;
  Eigen::Vector3d t_b_c;
  double sqrt_information;
  template <typename T>
  bool operator()(const T* w, const T* p, const T* A, const T* B, T* r) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const Eigen::Matrix<T, 3, 3> Rt = start.at(w).transpose();
    const V position(p[0], p[1], p[2]);
    const V a = Rt * (V(A[0], A[1], A[2]) - position) - t_b_c.cast<T>();
    const V b = Rt * (V(B[0], B[1], B[2]) - position) - t_b_c.cast<T>();
    const V n = a.cross(b) / a.cross(b).norm();
    r[0] = T(sqrt_information) * view.start_b.cast<T>().dot(n);
    r[1] = T(sqrt_information) * view.end_b.cast<T>().dot(n);
    return true;
  }
};

TEST(VisualInertialProblem, SameMinimumAsCeres) {
  const ExactWindow exact = noisyWindow(5);
  const InitWindow& window = *exact.window;
  RefinementOptions options;
  const InertialOptions inertial;
  options.tolerance = 1e-16;
  const WindowState truth = trueState(exact);
  const std::vector<Preintegration> pre =
      preintegrateInflated(window, truth.gyro_bias, truth.accel_bias, inertial);
  VisualInertialProblem map(window, window.lineTracks(), pre, options, inertial);
  WindowState ours = truth;
  const MapSummary summary = map.minimize(200, options.tolerance, &ours);
  ASSERT_TRUE(summary.valid && summary.converged);

  const int n = window.size();
  const Eigen::Vector3d& t_b_c = window.calibration().t_b_c;
  CeresWindow ceres_window(truth, pre, exact.calibration.gravity_magnitude, inertial);
  std::vector<Eigen::Vector3d> X(window.pointTracks().size());
  std::vector<std::array<Eigen::Vector3d, 2>> ends(window.lineTracks().size());
  for (std::size_t t = 0; t < X.size(); ++t) {
    const Track& track = window.pointTracks()[t];
    const std::vector<PointView> views = pointViews(window, track);
    X[t] = CeresWindow::placeOf(views, truth, t_b_c);
    ceres_window.addPoint(views, t_b_c, map.sigmaPoint(), options.cauchy_sigmas, &X[t]);
  }
  for (std::size_t t = 0; t < ends.size(); ++t) {
    const Track& track = window.lineTracks()[t];
    if (track.size() < kMinLineViews) continue;
    const std::vector<LineView> views = lineViews(window, track);
    LineParameters start;
    ASSERT_TRUE(triangulate(views.data(), static_cast<int>(views.size()), truth, t_b_c, &start));
    const double rho = std::max(std::abs(start.inverse_distance), 1e-2) *
                       (start.inverse_distance < 0.0 ? -1.0 : 1.0);
    const Eigen::Vector3d foot = start.origin + start.frame.col(0) / rho;
    ends[t] = {foot, foot + start.frame.col(1)};
    for (const LineView& view : views) {
      const int k = view.keyframe;
      ceres_window.problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CeresLine, 2, 3, 3, 3, 3>(
              new CeresLine{view, ceres_window.starts[k], t_b_c, 1.0 / map.sigmaLine()}),
          new ceres::CauchyLoss(options.cauchy_sigmas), ceres_window.w[k].data(),
          ceres_window.p[k].data(), ends[t][0].data(), ends[t][1].data());
    }
  }
  const double ceres_cost = ceres_window.solve(500, 1e-15);

  EXPECT_NEAR(summary.cost, ceres_cost, 1e-6 * summary.cost);
  for (int k = 0; k < n; ++k) {
    EXPECT_LT((ours.p_b0.col(k) - ceres_window.p[k]).norm(), 1e-6 * truth.p_b0.col(n - 1).norm())
        << k;
    EXPECT_LT((ours.v_b0.col(k) - ceres_window.v[k]).norm(), 1e-6) << k;
  }
  EXPECT_LT((ours.gyro_bias - ceres_window.bg).norm(), 1e-8);
}

// Squared length of a Gauss-Newton step from the answer, in standard deviations of the positions.
double stepLeft(const WindowState& answer, VisualInertialProblem* map) {
  WindowState next = answer;
  EXPECT_TRUE(map->resume(1, 1e9, &next).valid) << "one step, whatever its length";
  const int n = answer.size();
  const Eigen::MatrixXd covariance = map->information().inverse();
  Eigen::VectorXd step(3 * (n - 1));
  Eigen::MatrixXd P(3 * (n - 1), 3 * (n - 1));
  for (int a = 1; a < n; ++a) {
    step.segment<3>(3 * (a - 1)) = next.p_b0.col(a) - answer.p_b0.col(a);
    for (int b = 1; b < n; ++b) {
      P.block<3, 3>(3 * (a - 1), 3 * (b - 1)) =
          covariance.block<3, 3>(6 * (a - 1) + 3, 6 * (b - 1) + 3);
    }
  }
  return step.dot(P.ldlt().solve(step));
}

// With observations that are far off, a step that is right for the state can be too long for one of
// the tracks, and no damping of the state makes that one shorter.
TEST(VisualInertialProblem, EndsInAMinimumAlsoAmongGrossErrors) {
  RefinementOptions options;
  const InertialOptions inertial;
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const ExactWindow exact = noisyWindow(seed);
    std::vector<FrameObservation> frames = exact.keyframes;
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal;
    const auto disturb = [&](Eigen::Vector3d* bearing) {
      if (uniform(rng) > 0.1) return;
      *bearing += 0.03 * Eigen::Vector3d{normal(rng), normal(rng), 0.0};
      bearing->normalize();
    };
    for (FrameObservation& frame : frames) {
      for (PointObservation& point : frame.points) disturb(&point.bearing);
      for (LineObservation& line : frame.lines) disturb(&line.end_bearing);
    }
    const auto window = windowOf(exact, frames);
    const WindowState truth = trueState(exact);
    const std::vector<Preintegration> pre =
        preintegrateInflated(*window, truth.gyro_bias, truth.accel_bias, inertial);
    VisualInertialProblem map(*window, window->lineTracks(), pre, options, inertial);
    WindowState state = moved(truth, 0.02, seed, true);
    const MapSummary summary = map.minimize(30, options.tolerance, &state);
    ASSERT_TRUE(summary.valid && summary.converged) << seed;
    worst = std::max(worst, stepLeft(state, &map));
    // A farther start; if its tracks took no steps of their own, four would end where no view fits.
    VisualInertialProblem clean(*exact.window, exact.window->lineTracks(), pre, options, inertial);
    state = moved(truth, 0.05, seed, true);
    clean.minimize(30, options.tolerance, &state);
    // Of the end: the cost that a minimisation returns is that before its last step.
    EXPECT_LT(clean.resume(1, options.tolerance, &state).visual_cost, 1.5 * clean.visualDof())
        << seed;
  }
  // Half a sigma: the last step was shorter than that, and outliers that creep have moved the
  // minimum since.
  EXPECT_LT(worst, 0.25);
}

// Cost and information that the prior adds at one state, and that its gradient leads to the
// minimum.
TEST(VisualInertialProblem, PriorOnTheMotion) {
  const ExactWindow exact = noisyWindow(3);
  const WindowState truth = trueState(exact);
  const InertialOptions inertial;
  const std::vector<Preintegration> pre =
      preintegrateInflated(*exact.window, truth.gyro_bias, truth.accel_bias, inertial);
  MotionPrior prior;
  prior.speed_sigma = 0.15;
  prior.acceleration_sigma = 0.5;
  const auto with = [&](const WindowPriors& priors) {
    return VisualInertialProblem(*exact.window, {}, pre, RefinementOptions(), inertial, priors);
  };
  VisualInertialProblem without = with({}), map = with({WindowPriors().rig, prior});
  WindowState state = truth;
  state.accel_bias.setZero();  // else its prior has a tail in one of them
  const double cost = map.minimize(0, 1.0, &state).cost - without.minimize(0, 1.0, &state).cost;
  const int n = state.size(), middle = MotionPrior::middle(n);
  const double change_sigma = 0.5 * (exact.window->times().back() - exact.window->times().front());
  const Eigen::Vector3d change = state.v_b0.col(n - 1) - state.v_b0.col(0);
  EXPECT_NEAR(cost,
              state.v_b0.col(middle).squaredNorm() / (0.15 * 0.15) +
                  change.squaredNorm() / (change_sigma * change_sigma),
              1e-9 * cost);
  const Eigen::MatrixXd added = map.information() - without.information();
  const auto at = [n](int k) { return StateLayout(n, true).velocity(k) - StateLayout::kGauge; };
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(added.rows(), added.cols());
  expected.diagonal().segment<3>(at(middle)).setConstant(1.0 / (0.15 * 0.15));
  for (const int k : {0, n - 1}) {
    expected.diagonal().segment<3>(at(k)).setConstant(1.0 / (change_sigma * change_sigma));
  }
  for (const auto& [a, b] : {std::pair{0, n - 1}, {n - 1, 0}}) {
    expected.block<3, 3>(at(a), at(b)).diagonal().setConstant(-1.0 / (change_sigma * change_sigma));
  }
  EXPECT_LT((added - expected).norm(), 1e-9 * map.information().norm());
  ASSERT_TRUE(map.minimize(50, 1e-10, &state).converged);
  EXPECT_LT(stepLeft(state, &map), 1e-8);
  EXPECT_GT((state.v_b0 - truth.v_b0).norm(), 0.05) << "it counts";
}

TEST(VisualInertialProblem, PriorOnTheBiases) {
  const ExactWindow exact = noisyWindow(3);
  const WindowState truth = trueState(exact);
  const InertialOptions inertial;
  const std::vector<Preintegration> pre =
      preintegrateInflated(*exact.window, truth.gyro_bias, truth.accel_bias, inertial);
  WindowPriors priors;
  priors.biases = {truth.gyro_bias.array() + 0.01, truth.accel_bias.array() - 0.1, 1e-4, 1e-3};
  VisualInertialProblem map(*exact.window, {}, pre, RefinementOptions(), inertial, priors);
  WindowState state = truth;
  const double inertial_cost = map.minimize(0, 1.0, &state).inertial_cost;
  EXPECT_NEAR(inertial_cost, 3.0 * (1e4 + 1e4), 0.02 * inertial_cost);
  ASSERT_TRUE(map.minimize(50, 1e-10, &state).converged);
  EXPECT_LT(stepLeft(state, &map), 1e-8);
  EXPECT_LT((state.accel_bias - priors.biases.accel).norm(), 0.01) << "about its mean";
}

TEST(VisualInertialProblem, RejectTakesOutWhatIsBeyond) {
  const ExactWindow exact = noisyWindow(2);
  const WindowState truth = trueState(exact);
  RefinementOptions options;
  const InertialOptions inertial;
  const std::vector<Preintegration> pre =
      preintegrateInflated(*exact.window, truth.gyro_bias, truth.accel_bias, inertial);
  VisualInertialProblem map(*exact.window, exact.window->lineTracks(), pre, options, inertial);
  WindowState state = truth;
  ASSERT_TRUE(map.minimize(10, options.tolerance, &state).valid);
  const MapResiduals residuals = map.residuals();
  ASSERT_EQ(static_cast<int>(residuals.points.size()), map.pointViews());
  const double bound = 1.0 / exact.calibration.focal_px;
  int beyond = 0;
  for (double r : residuals.points) beyond += r > bound;
  ASSERT_GT(beyond, 0);
  const int before = map.pointViews();
  map.reject(residuals, bound, 1.0);
  EXPECT_LE(map.pointViews(), before - beyond);  // tracks with one view left go as well
  EXPECT_GE(map.pointViews(), before - 2 * beyond);
  for (double r : map.residuals().points) EXPECT_LE(r, bound);
  EXPECT_TRUE(map.resume(10, options.tolerance, &state).valid);
}

}  // namespace
}  // namespace slim_init
