// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The profile of the cost over the scale: against the minimum of the full problem with the scale
// held, against the posterior, and in windows where another scale is as good.
#include "verdict/scale_profile.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "estimation/inertial_factor.h"
#include "estimation/posterior.h"
#include "estimation/visual_inertial_problem.h"
#include "geometry/so3.h"
#include "slim_init/window_solver.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/track_views.h"
#include "support/true_state.h"
#include "verdict/constants.h"

namespace slim_init {
namespace {

using namespace testing_support;  // NOLINT: the vocabulary of these tests

// Factors of a vibrating vehicle, whatever the samples of the simulated one look like.
InertialOptions widenedNoise() {
  InertialOptions inertial;
  inertial.accel_noise_factor = 10.0;
  inertial.gyro_noise_factor = 3.0;
  return inertial;
}

// Squares instead of the robust loss, points only: what the profile is exact for.
RefinementOptions leastSquares() {
  RefinementOptions options;
  options.use_lines = false;
  options.use_vanishing_points = false;
  options.cauchy_sigmas = 1e4;
  options.tolerance = 1e-10;
  options.max_iterations = 50;
  return options;
}

ExactWindow noisyWindow(Motion motion, int keyframes, unsigned seed) {
  ExactWindowOptions options;
  options.motion = motion;
  options.keyframes = keyframes;
  options.pixel_noise = 0.6;
  options.angular_noise = true;
  options.imu_noise = true;
  options.accel_bias = Eigen::Vector3d(0.05, -0.08, 0.1);
  options.seed = seed;
  options.points = 40;
  options.lines = 0;
  return makeExactWindow(options);
}

// A window at its minimum, with what the profile needs.
struct Minimum {
  ExactWindow exact;
  InertialOptions inertial;
  std::vector<Preintegration> pre;
  RefinedWindow refined;
  double cost = 0.0;
  double sigma_bearing = 0.0;

  ScaleCost scaleCost() const { return ScaleCost(refined, pre, exact.calibration, inertial); }
};

Minimum minimumOf(Motion motion, int keyframes, unsigned seed, const InertialOptions& inertial) {
  Minimum out;
  out.exact = noisyWindow(motion, keyframes, seed);
  out.inertial = inertial;
  WindowState state = trueState(out.exact);
  out.pre = preintegrateInflated(*out.exact.window, state.gyro_bias, state.accel_bias, inertial);
  VisualInertialProblem map(*out.exact.window, {}, out.pre, nullptr, leastSquares(), inertial);
  const MapSummary summary = map.minimize(leastSquares().max_iterations, &state);
  EXPECT_TRUE(summary.valid);
  out.refined.valid = summary.valid;
  out.refined.state = state;
  out.refined.information = map.information();
  out.refined.visual_information = map.visualInformation();
  out.refined.visual_gradient = map.visualGradient();
  out.cost = summary.cost;
  out.sigma_bearing = map.sigmaPoint();
  return out;
}

// --- the full problem in Ceres with the scale held ----------------------------------------------

Eigen::Matrix3d turned(const Eigen::Matrix3d& R, const double* w) {
  return R * expSO3(Eigen::Map<const Eigen::Vector3d>(w));
}

struct PointResidual {
  Eigen::Matrix3d R;
  Eigen::Vector3d bearing_b, t_b_c;
  double sigma;
  bool operator()(const double* w, const double* p, const double* X, double* r) const {
    using V = Eigen::Map<const Eigen::Vector3d>;
    const Eigen::Vector3d y = turned(R, w).transpose() * (V(X) - V(p)) - t_b_c;
    Eigen::Map<Eigen::Vector2d> out(r);
    out = tangentBasis(bearing_b).transpose() * y.normalized() / sigma;
    return true;
  }
};

struct PairResidual {
  const Preintegration* pre;
  Eigen::Matrix<double, 9, 9> W;
  Eigen::Matrix3d R_i, R_j;
  double G;
  bool operator()(const double* const* x, double* r) const {
    using V = Eigen::Map<const Eigen::Vector3d>;
    WindowState state;
    state.R_b0_bk = {turned(R_i, x[0]), turned(R_j, x[3])};
    state.p_b0.resize(3, 2);
    state.v_b0.resize(3, 2);
    state.p_b0 << V(x[1]), V(x[4]);
    state.v_b0 << V(x[2]), V(x[5]);
    state.gyro_bias = V(x[6]);
    state.accel_bias = V(x[7]);
    state.gravity_b0 = G * V(x[8]).normalized();
    Eigen::Map<Eigen::Matrix<double, 9, 1>> out(r);
    out = W * inertialResidual(state, 0, *pre).r;
    return true;
  }
};

struct PriorResidual {
  double sigma;
  bool operator()(const double* x, double* r) const {
    for (int i = 0; i < 3; ++i) r[i] = x[i] / sigma;
    return true;
  }
};

// Only the direction of gravity counts: the length is arbitrary and held at one.
struct LengthResidual {
  bool operator()(const double* x, double* r) const {
    r[0] = 1e3 * (Eigen::Map<const Eigen::Vector3d>(x).norm() - 1.0);
    return true;
  }
};

// Holds the projection of the camera centres on those of the minimum at `ratio` times its value.
struct ScaleHold {
  const WindowState* state;
  Eigen::Vector3d t_b_c;
  double ratio;
  bool operator()(const double* const* x, double* r) const {
    double along = 0.0, all = 0.0;
    for (int k = 1; k < state->size(); ++k) {
      const Eigen::Vector3d q = cameraCentre(*state, k, t_b_c) - t_b_c;
      const Eigen::Vector3d now = Eigen::Map<const Eigen::Vector3d>(x[2 * (k - 1) + 1]) +
                                  turned(state->R_b0_bk[k], x[2 * (k - 1)]) * t_b_c - t_b_c;
      along += q.dot(now);
      all += q.squaredNorm();
    }
    r[0] = 1e6 * (along / all - ratio);
    return true;
  }
};

double costWithScaleHeld(const Minimum& at, double log_ratio) {
  const InitWindow& window = *at.exact.window;
  const Calibration& calibration = window.calibration();
  const WindowState& state = at.refined.state;
  const int n = state.size();
  const double ratio = std::exp(log_ratio);
  std::vector<Eigen::Vector3d> w(n, Eigen::Vector3d::Zero()), p(n), v(n);
  for (int k = 0; k < n; ++k) {
    p[k] = ratio * state.p_b0.col(k);
    v[k] = ratio * state.v_b0.col(k);
  }
  Eigen::Vector3d bg = state.gyro_bias, ba = state.accel_bias, g = state.gravity_b0.normalized();
  ceres::Problem problem;
  for (int k = 0; k + 1 < n; ++k) {
    auto* functor = new PairResidual{
        &at.pre[k], {}, state.R_b0_bk[k], state.R_b0_bk[k + 1], calibration.gravity_magnitude};
    EXPECT_TRUE(inertialWhitening(at.pre[k], &functor->W));
    auto* factor = new ceres::DynamicNumericDiffCostFunction<PairResidual, ceres::CENTRAL>(functor);
    for (int i = 0; i < 9; ++i) factor->AddParameterBlock(3);
    factor->SetNumResiduals(9);
    problem.AddResidualBlock(
        factor, nullptr,
        std::vector<double*>{w[k].data(), p[k].data(), v[k].data(), w[k + 1].data(),
                             p[k + 1].data(), v[k + 1].data(), bg.data(), ba.data(), g.data()});
  }
  using Prior = ceres::NumericDiffCostFunction<PriorResidual, ceres::CENTRAL, 3, 3>;
  problem.AddResidualBlock(new Prior(new PriorResidual{at.inertial.accel_bias_prior}), nullptr,
                           ba.data());
  problem.AddResidualBlock(new Prior(new PriorResidual{at.inertial.gyro_bias_prior}), nullptr,
                           bg.data());
  problem.AddResidualBlock(
      new ceres::NumericDiffCostFunction<LengthResidual, ceres::CENTRAL, 1, 3>(new LengthResidual),
      nullptr, g.data());
  auto* hold = new ceres::DynamicNumericDiffCostFunction<ScaleHold, ceres::CENTRAL>(
      new ScaleHold{&state, calibration.t_b_c, ratio});
  std::vector<double*> poses;
  for (int k = 1; k < n; ++k) {
    poses.push_back(w[k].data());
    poses.push_back(p[k].data());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) hold->AddParameterBlock(3);
  hold->SetNumResiduals(1);
  problem.AddResidualBlock(hold, nullptr, poses);

  // Points where the views of the minimum meet, carried to the other scale about the first camera.
  std::vector<Eigen::Vector3d> X(window.pointTracks().size());
  for (std::size_t t = 0; t < X.size(); ++t) {
    const Track& track = window.pointTracks()[t];
    const std::vector<PointView> views = testing_support::pointViews(window, track);
    const PointParameters start =
        triangulate(views.data(), static_cast<int>(views.size()), state, calibration.t_b_c);
    X[t] = start.origin + start.direction / std::max(start.inverse_depth, 1e-2);
    X[t] = calibration.t_b_c + ratio * (X[t] - calibration.t_b_c);
    for (const PointView& view : views) {
      const int k = view.keyframe;
      problem.AddResidualBlock(
          new ceres::NumericDiffCostFunction<PointResidual, ceres::CENTRAL, 2, 3, 3, 3>(
              new PointResidual{state.R_b0_bk[k], view.bearing_b, calibration.t_b_c,
                                at.sigma_bearing}),
          nullptr, w[k].data(), p[k].data(), X[t].data());
    }
  }
  problem.SetParameterBlockConstant(w[0].data());
  problem.SetParameterBlockConstant(p[0].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return 2.0 * summary.final_cost;
}

// Short windows, whose profile is not the parabola of their curvature.
TEST(ScaleProfile, CostIsThatOfTheFullProblemWithTheScaleHeld) {
  for (const int keyframes : {5, 8}) {
    const Minimum at = minimumOf(Motion::kExcited, keyframes, 3, widenedNoise());
    const ScaleCost cost = at.scaleCost();
    ASSERT_TRUE(cost.valid());
    const double here = cost(0.0);
    EXPECT_NEAR(costWithScaleHeld(at, 0.0), at.cost, 1e-4 * at.cost) << keyframes;
    for (const double log_ratio : {-1.0, -0.5, -0.2, 0.2, 0.5, 1.0}) {
      const double rise = costWithScaleHeld(at, log_ratio) - at.cost;
      // The visual cost is a quadratic here, and rotations are linear.
      EXPECT_NEAR(cost(log_ratio) - here, rise, 0.03 * rise + 0.05)
          << keyframes << " keyframes, log ratio " << log_ratio;
    }
  }
}

TEST(ScaleProfile, IsLowestAtTheMinimumAndAsWideAsThePosteriorInGoodWindows) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Minimum at = minimumOf(Motion::kExcited, 10, seed, dataSheetNoise());
    const ScaleProfile profile = profileScale(at.scaleCost());
    ASSERT_TRUE(profile.valid);
    const Posterior posterior = posteriorOf(at.refined.state, at.refined.information);
    EXPECT_LT(std::abs(profile.log_ratio), 0.1 * posterior.scale_sigma) << seed;
    EXPECT_NEAR(profile.sigma(), posterior.scale_sigma, 0.15 * posterior.scale_sigma) << seed;
    EXPECT_LE(profile.cost, profile.cost_here);
    EXPECT_LT(profile.low, 0.0);
    EXPECT_GT(profile.high, 0.0);
    EXPECT_GT(profile.other_rise, 100.0) << seed;
  }
}

TEST(ScaleProfile, ConstantVelocityFitsEveryLargeScale) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Minimum at = minimumOf(Motion::kConstantVelocity, 8, seed, widenedNoise());
    const ScaleProfile profile = profileScale(at.scaleCost());
    ASSERT_TRUE(profile.valid);
    EXPECT_GT(profile.sigma(), 0.5) << seed;
  }
}

// The same images and another size: as a minimum that is too small, camera centres about the first.
void resize(double log_size, Minimum* at) {
  const double size = std::exp(log_size);
  const Eigen::Vector3d& t = at->exact.calibration.t_b_c;
  WindowState& state = at->refined.state;
  for (int k = 0; k < state.size(); ++k) {
    const Eigen::Vector3d arm = state.R_b0_bk[k] * t - t;
    state.p_b0.col(k) = size * (state.p_b0.col(k) + arm) - arm;
    // Positions in other units. That attitudes move the camera by its arm is of no weight here.
    at->refined.visual_information.middleRows<3>(6 * k + 3) /= size;
    at->refined.visual_information.middleCols<3>(6 * k + 3) /= size;
    at->refined.visual_gradient.segment<3>(6 * k + 3) /= size;
  }
}

TEST(ScaleProfile, FindsTheScaleFromAStateOfAnotherSize) {
  Minimum at = minimumOf(Motion::kExcited, 10, 2, widenedNoise());
  const ScaleProfile right = profileScale(at.scaleCost());
  resize(-1.5, &at);
  const ScaleProfile profile = profileScale(at.scaleCost());
  ASSERT_TRUE(profile.valid);
  EXPECT_NEAR(profile.log_ratio, right.log_ratio + 1.5, 0.02);
  // The better one is the other one, and the interval reaches it.
  EXPECT_NEAR(profile.other_log_ratio, profile.log_ratio, 1e-12);
  EXPECT_LT(profile.other_rise, -100.0);
  EXPECT_GT(profile.sigma(), 0.7);
}

TEST(OtherScale, AWindowWithoutAScaleIsRefusedWithAWideSigma) {
  InitializerOptions options;
  options.gates.min_excitation = 0.0;  // not the gate that is asked here
  const std::unique_ptr<WindowSolver> solver = makeSlimSolver(options);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ExactWindow exact = noisyWindow(Motion::kConstantVelocity, 8, seed);
    const InitResult result = solver->solve(*exact.window);
    EXPECT_FALSE(result.success()) << seed;
    EXPECT_TRUE(!result.hasEstimate() || result.scale_sigma > 0.3) << seed;
    bool asked = false;
    for (const GateValue& gate : result.gates) asked = asked || gate.name == GateName::kOtherScale;
    EXPECT_EQ(asked, result.hasEstimate());
  }
}

TEST(ScaleProfile, WithoutVisualInformationThereIsNone) {
  Minimum at = minimumOf(Motion::kExcited, 5, 1, widenedNoise());
  at.refined.visual_information.setZero();
  EXPECT_FALSE(profileScale(at.scaleCost()).valid);
  at.refined.visual_information.resize(0, 0);
  EXPECT_FALSE(profileScale(at.scaleCost()).valid);
}

TEST(VisualInformation, DoesNotKnowTheScale) {
  const Minimum at = minimumOf(Motion::kExcited, 8, 4, widenedNoise());
  const WindowState& state = at.refined.state;
  const Eigen::Vector3d& t = at.exact.calibration.t_b_c;
  Eigen::VectorXd grow = Eigen::VectorXd::Zero(6 * state.size());
  for (int k = 0; k < state.size(); ++k) {
    grow.segment<3>(6 * k + 3) = cameraCentre(state, k, t) - t;
  }
  const double information = grow.dot(at.refined.visual_information * grow);
  // Any other displacement of that size is seen: here of one camera.
  Eigen::VectorXd other = Eigen::VectorXd::Zero(6 * state.size());
  other.segment<3>(6 * 3 + 3) = grow.norm() * Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
  EXPECT_LT(information, 1e-4 * other.dot(at.refined.visual_information * other));
  EXPECT_LT(std::abs(at.refined.visual_gradient.dot(grow)), 1e-2);
}

}  // namespace
}  // namespace slim_init
