// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "data/derived_window.h"
#include "estimation/refine_window.h"
#include "estimation/state_factor.h"
#include "geometry/dense.h"
#include "geometry/so3.h"
#include "pipeline/answers.h"
#include "pipeline/minimum_search.h"
#include "pipeline/rotation_stage.h"
#include "pipeline/solver_support.h"
#include "scale/linear_motion.h"
#include "scale/starting_states.h"
#include "slim_init/text.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

/// What an estimator goes on with: standard deviations of the newest velocity, a part that a host
/// survives whatever its speed and a share of the speed, and of the newest attitude.
constexpr double kVelocitySigma = 0.2;  // [m/s]
constexpr double kVelocityShare = 0.06;
constexpr double kTiltSigmaDeg = 1.5;
/// End of the minimisation, as RefinementOptions: the test of the known state takes the gradient as
/// zero.
constexpr double kTolerance = 1e-4;
constexpr int kMaxIterations = 30;

// Errors of the rows of the known state by those of the estimate, and their covariance there.
struct KnownState {
  StateResidual residual;
  StateCovariance posterior = StateCovariance::Zero();
};

bool knownStateOf(const InitWindow& tracks, const RefinedWindow& refined, const StateFactor& factor,
                  KnownState* out) {
  const WindowState& state = refined.state;
  const std::vector<ImuInstant> instants =
      imuInstants(tracks, coveredShift(tracks, state.rig.dtd), state.gyro_bias, state.accel_bias);
  out->residual = stateResidual(state, factor, tracks.calibration(), instants.front());
  const StateLayout at(state.size(), true);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(at.size() - StateLayout::kGauge, kStateRows);
  J.middleRows<3>(at.velocity(0) - StateLayout::kGauge) = out->residual.J.leftCols<3>().transpose();
  J.middleRows<kStateColumns - 3>(at.gyroBias() - StateLayout::kGauge) =
      out->residual.J.rightCols<kStateColumns - 3>().transpose();
  Eigen::MatrixXd posterior;
  if (!inverseSeenBy(refined.information, J, &posterior)) return false;
  out->posterior = posterior;
  return out->posterior.allFinite();
}

// The prior's pose moved by what the window says about velocity, tilt and biases: the part of its
// error that correlates with theirs. Of the parts that were dropped the prior claims too much, and
// what follows from them follows all the same.
NavState corrected(const StatePrior& prior, const StateVector& r) {
  const Eigen::Matrix<double, kStateRows, 15> Y = stateRows(prior.state);
  const Eigen::MatrixXd PY = product(prior.covariance, Y.transpose());
  const Eigen::Matrix<double, 15, 1> step = product(PY, solveSymmetric(product(Y, PY), r));
  NavState state = prior.state;
  state.R_w_b = state.R_w_b * expSO3(step.head<3>());
  state.p_w_b += step.segment<3>(3);
  return state;
}

// The motion of a window as the IMU alone continues the known state, at whose biases `pre` is.
WindowState deadReckoned(const StateFactor& known, const std::vector<Preintegration>& pre,
                         double gravity_magnitude) {
  Eigen::Matrix<double, 9, 1> x;
  x << known.velocity_b, Eigen::Vector3d::Zero(), gravity_magnitude * known.down_b;
  return linearMotion(pre, chainRotations(pre), Eigen::Vector3d::Zero()).at(x);
}

// The refinement with a known state, without the parts of it that the data contradict.
struct Recovery {
  RefinedWindow refined;
  KnownState known;
  bool valid = false;
};

Recovery refineWithPrior(RefinementInput input, InitResult* result) {
  Recovery out;
  StateFactor& known = *input.priors.known;
  WindowState start = deadReckoned(known, input.pre, input.tracks.calibration().gravity_magnitude);
  // The window's own, the same however many parts of the state are dropped.
  std::optional<WindowState> own;
  bool has_own = false;
  // The known state may have led astray.
  const auto other = [&]() -> std::optional<WindowState> {
    if (!input.budget.allows("a start of the window's own")) return std::nullopt;
    if (!has_own) own = inertialStartingState(input.tracks, input.pre, input.inertial);
    has_own = true;
    return own;
  };
  for (;;) {
    out.refined = refineWindow(input, {}, start, other);
    if (!out.refined.valid || !knownStateOf(input.tracks, out.refined, known, &out.known)) {
      return out;
    }
    if (result->prior_dropped.size() == kStateParts) break;
    const StateTest test = testState(out.known.residual.r, known.covariance, out.known.posterior);
    if (!test.contradicts()) break;
    const StatePart part = worstPart(test);
    const std::string name = toString(part);
    // Dropped already: what is left is not this state's fault.
    if (std::count(result->prior_dropped.begin(), result->prior_dropped.end(), name) > 0) break;
    result->prior_dropped.push_back(name);
    known.covariance = without(known.covariance, part);
    start = out.refined.state;
  }
  out.valid = true;
  return out;
}

// Gates on what a host goes on with; how the scale is known is in the velocity.
std::vector<GateValue> recoveryGates(const PosteriorMeasures& measures, const InitResult& result,
                                     const GateOptions& options) {
  const NewestSigmas newest = newestSigmas(result);
  ProvisionalOptions bounds;
  bounds.max_velocity_sigma = kVelocitySigma + kVelocityShare * result.states.back().v_w_b.norm();
  bounds.max_tilt_sigma_deg = kTiltSigmaDeg;
  std::vector<GateValue> gates =
      provisionalGates(measures, newest.velocity, newest.tilt_deg, options, bounds);
  gates.erase(
      std::remove_if(gates.begin(), gates.end(),
                     [](const GateValue& gate) { return gate.name == GateName::kScaleSigma; }),
      gates.end());
  return gates;
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// The message of a success; refuses one for whose scale nothing has vouched.
void setMessage(InitResult* result) {
  const std::vector<std::string>& dropped = result->prior_dropped;
  if (std::count(dropped.begin(), dropped.end(), toString(StatePart::kVelocity)) > 0) {
    fail(InitStatus::kScaleTooUncertain,
         "the data contradict the last healthy state: " + list(dropped), result);
    return;
  }
  const NewestSigmas newest = newestSigmas(*result);
  result->message = roundedText(2, "from a known state: standard deviations of velocity ",
                                newest.velocity, " m/s, tilt ", newest.tilt_deg, " deg");
  if (!dropped.empty()) result->message += "; the data contradict its " + list(dropped);
}

// The window through the extrinsics that the prior brings, and its td if the body has stood; null,
// with status and message set, where they cannot be solved together.
std::shared_ptr<const InitWindow> windowOfPrior(const InitWindow& window, const StatePrior& prior,
                                                const StateFactor& known, InitResult* result) {
  std::shared_ptr<const InitWindow> through = unowned(window);
  std::string problem;
  if (const std::string invalid = prior.validate(); !invalid.empty()) {
    problem = invalid;
  } else if (!isPositiveDefinite(known.covariance)) {
    problem =
        "the covariance of the last healthy state is not positive definite in velocity, tilt and "
        "biases";
  } else if (!(std::abs(prior.state.t - window.times().front()) < kStampRounding)) {
    problem = "the last healthy state is not that of the first keyframe";
  } else if (prior.calibration.has_value()) {
    CalibrationEstimate extrinsics = *prior.calibration;
    if (!prior.at_rest) extrinsics.covariance(6, 6) = 0.0;  // its time is with the host's td
    through = withCalibration(window, withFound(window.calibration(), extrinsics));
    if (through == nullptr) problem = "the calibration of the last healthy state is not valid";
  }
  if (problem.empty()) return through;
  fail(InitStatus::kInvalidInput, problem, result);
  return nullptr;
}

// Gates and status. A start answers for its scale and its calibration, `handed_in` null otherwise;
// and a window without translation has none.
void decideWithPrior(const PosteriorMeasures& measures, const MotionMeasures& motion,
                     const Calibration* handed_in, const GateOptions& options, InitResult* result) {
  if (handed_in != nullptr) {
    if (result->calibration) appendCalibrationWarnings(*handed_in, *result->calibration, result);
    // Hardly moved yet, and no profile checks the speeds: as in a start without the prior.
    GateOptions bounds = options;
    if (motion.has_speeds) bounds.min_least_parallax_px = bounds.min_parallax_px;
    result->gates = parallaxGates(motion, bounds);
    appendGates(calibrationGates(*handed_in, *result->calibration, options), result);
    appendGates(posteriorGates(measures, motion, options), result);
    enforceGates(options.mode, result);
    decide(false, result);
  } else {
    result->gates = recoveryGates(measures, *result, options);
    decide(options.mode != GateMode::kOff, result);
  }
}

}  // namespace

InitResult recoveredAnswer(const InitWindow& window, const StatePrior& prior,
                           const InitializerOptions& options, WorkBudget* budget) {
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;
  StateFactor known = stateFactor(prior);
  const std::shared_ptr<const InitWindow> through = windowOfPrior(window, prior, known, &result);
  if (through == nullptr) return result;

  // Consensus of the tracks about the rotations, under the calibration that the host has flown
  // with; nothing has been flown with at rest.
  const RotationStage rotation =
      estimateRotations(*through, options, budget,
                        prior.at_rest ? GivenCalibration::kReplaced : GivenCalibration::kKept);
  setTrackNoise(rotation, &result);
  if (prior.at_rest && !rotation.message.empty()) {
    fail(InitStatus::kTooLittleExcitation, rotation.message, &result);
    return result;
  }
  const InitWindow &seen = *rotation.window, &tracks = *rotation.tracks;
  clock.lap("gyro_bias");

  const IntegratedWindow integrated =
      integrateWindow(tracks, known.gyro_bias, known.accel_bias, options.inertial);
  RefinementOptions refinement = options.refinement;
  refinement.tolerance = std::min(refinement.tolerance, kTolerance);
  refinement.max_iterations = std::max(refinement.max_iterations, kMaxIterations);
  // With less parallax points are directions.
  known.points_at_infinity =
      !(integrated.motion.parallax_px >=
        (prior.at_rest ? options.gates.min_least_parallax_px : options.gates.min_parallax_px));
  const WindowPriors priors = {rotation.prior, std::nullopt, known};
  const Recovery recovery = refineWithPrior(
      {tracks, integrated.pre, refinement, options.inertial, *budget, priors}, &result);
  clock.lap("refinement");
  const Posterior posterior = recovery.valid ? posteriorOf(tracks, recovery.refined) : Posterior();
  if (!posterior.valid) {
    fail(InitStatus::kNumericalFailure, "no estimate with the last healthy state", &result);
    failAtLimit(budget, &result);
    return result;
  }

  setEstimate(tracks, recovery.refined, posterior, &result);
  result.scale_sigma = posterior.scale_sigma;
  decideWithPrior(
      measurePosterior(seen, tracks, recovery.refined, posterior, nullptr, result.scale),
      integrated.motion, prior.at_rest ? &window.calibration() : nullptr,
      gatesInForce(options.gates, seen, options.window), &result);
  NavState there = corrected(prior, recovery.known.residual.r);
  // An estimated td has moved the first keyframe.
  there.p_w_b += (result.states.front().t - there.t) * there.v_w_b;
  moveToFrame(there, result.states.front(), &result);
  if (result.success()) setMessage(&result);
  failAtLimit(budget, &result);
  clock.lap("verdict");
  return result;
}

}  // namespace slim_init
