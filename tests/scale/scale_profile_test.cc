// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The profile of the cost over the scale: against the minimum of the full problem with the scale
// held, against the posterior, and in windows where another scale is as good.
#include "scale/scale_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "estimation/posterior.h"
#include "estimation/visual_inertial_problem.h"
#include "geometry/so3.h"
#include "priors/sensor_priors.h"
#include "slim_init/window_solver.h"
#include "support/ceres_window.h"
#include "support/data_sheet_options.h"
#include "support/exact_window.h"
#include "support/track_views.h"
#include "support/true_state.h"

namespace slim_init {
namespace {

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

  ScaleCost scaleCost() const {
    return ScaleCost(refined, pre, exact.calibration, assumedImuBiases({}, inertial));
  }
};

Minimum minimumOf(Motion motion, int keyframes, unsigned seed, const InertialOptions& inertial) {
  Minimum out;
  out.exact = noisyWindow(motion, keyframes, seed);
  out.inertial = inertial;
  WindowState state = trueState(out.exact);
  out.pre = preintegrateInflated(*out.exact.window, state.gyro_bias, state.accel_bias, inertial);
  VisualInertialProblem map(*out.exact.window, {}, out.pre, leastSquares(), inertial);
  const MapSummary summary =
      map.minimize(leastSquares().max_iterations, leastSquares().tolerance, &state);
  EXPECT_TRUE(summary.valid);
  out.refined.valid = summary.valid;
  out.refined.state = state;
  out.refined.information = map.information();
  out.refined.visual_information = map.visualInformation();
  out.refined.visual_gradient = map.visualGradient();
  // The profile has the prior of the accelerometer bias as wide as it is at the minimum.
  const AccelBiasTerm accel = accelBiasTerm({}, inertial, state.accel_bias);
  out.inertial.accel_bias_prior = accel.sigma;
  out.cost = summary.cost - accel.cost + state.accel_bias.squaredNorm() / std::pow(accel.sigma, 2);
  out.sigma_bearing = map.sigmaPoint();
  return out;
}

// --- the full problem in Ceres with the scale held ----------------------------------------------

// Holds the projection of the camera centres on those of the minimum at `ratio` times its value.
struct ScaleHold {
  const WindowState* state;
  Eigen::Vector3d t_b_c;
  double ratio;
  bool operator()(const double* const* x, double* r) const {
    double along = 0.0, all = 0.0;
    for (int k = 1; k < state->size(); ++k) {
      const Eigen::Vector3d q = cameraCentre(*state, k, t_b_c) - t_b_c;
      const RotationStart start = {state->R_b0_bk[k]};
      const Eigen::Vector3d now = Eigen::Map<const Eigen::Vector3d>(x[2 * (k - 1) + 1]) +
                                  start.at(x[2 * (k - 1)]) * t_b_c - t_b_c;
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
  const double ratio = std::exp(log_ratio);
  WindowState start = state;
  start.p_b0 *= ratio;
  start.v_b0 *= ratio;
  CeresWindow ceres_window(start, at.pre, calibration.gravity_magnitude, at.inertial, true);
  std::vector<double*> poses;
  for (int k = 1; k < state.size(); ++k) {
    poses.push_back(ceres_window.w[k].data());
    poses.push_back(ceres_window.p[k].data());
  }
  ceres_window.addNumeric(new ScaleHold{&state, calibration.t_b_c, ratio}, 1, poses);
  // Points where the views of the minimum meet, carried to the other scale about the first camera.
  std::vector<Eigen::Vector3d> X(window.pointTracks().size());
  for (std::size_t t = 0; t < X.size(); ++t) {
    const std::vector<PointView> views = pointViews(window, window.pointTracks()[t]);
    const Eigen::Vector3d place = CeresWindow::placeOf(views, state, calibration.t_b_c);
    X[t] = calibration.t_b_c + ratio * (place - calibration.t_b_c);
    ceres_window.addPoint(views, calibration.t_b_c, at.sigma_bearing, leastSquares().cauchy_sigmas,
                          &X[t]);
  }
  return ceres_window.solve(200, 1e-10);
}

// Short windows, whose profile is not the parabola of their curvature.
TEST(ScaleProfile, CostIsThatOfTheFullProblemWithTheScaleHeld) {
  for (const int keyframes : {5, 8}) {
    const Minimum at = minimumOf(Motion::kExcited, keyframes, 3, widenedNoise());
    const ScaleCost cost = at.scaleCost();
    ASSERT_TRUE(std::isfinite(cost(0.0)));
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
    const Posterior posterior = posteriorOf(at.refined.state, withoutRig(at.refined.information));
    EXPECT_LT(std::abs(profile.log_ratio), 0.1 * posterior.scale_sigma) << seed;
    EXPECT_NEAR(profile.sigma, posterior.scale_sigma, 0.15 * posterior.scale_sigma) << seed;
    EXPECT_LE(profile.cost, profile.cost_here);
    EXPECT_GT(profile.other_rise, 100.0) << seed;
  }
}

TEST(ScaleProfile, ConstantVelocityFitsEveryLargeScale) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Minimum at = minimumOf(Motion::kConstantVelocity, 8, seed, widenedNoise());
    const ScaleProfile profile = profileScale(at.scaleCost());
    ASSERT_TRUE(profile.valid);
    EXPECT_GT(profile.sigma, 0.5) << seed;
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
  // The better one is the other one, and the standard deviation covers it.
  EXPECT_NEAR(profile.other_log_ratio, profile.log_ratio, 1e-12);
  EXPECT_LT(profile.other_rise, -100.0);
  EXPECT_GT(profile.sigma, 0.7);
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
  for (int k = 0; k < state.size(); ++k) grow.segment<3>(6 * k + 3) = cameraCentre(state, k, t) - t;
  const double information = grow.dot(at.refined.visual_information * grow);
  // Any other displacement of that size is seen: here of one camera.
  Eigen::VectorXd other = Eigen::VectorXd::Zero(6 * state.size());
  other.segment<3>(6 * 3 + 3) = grow.norm() * Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
  EXPECT_LT(information, 1e-4 * other.dot(at.refined.visual_information * other));
  EXPECT_LT(std::abs(at.refined.visual_gradient.dot(grow)), 1e-2);
}

}  // namespace
}  // namespace slim_init
