// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>

#include "estimation/state_factor.h"
#include "geometry/dense.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "pipeline/answers.h"
#include "pipeline/minimum_search.h"
#include "pipeline/rotation_stage.h"
#include "pipeline/solver_support.h"
#include "scale/scale_profile.h"
#include "scale/starting_states.h"
#include "shape/ligt.h"
#include "slim_init/text.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

constexpr int kRefinements = 2;  // of the most probable scale
/// Squared difference in standard deviations, three degrees of freedom: seven. Wrong minima are a
/// hundred and more, right ones of so few images not always within three.
constexpr double kMaxDisagreement = 50.0;
/// An estimated td moves the instants of the same image by less than this [s].
constexpr double kSameInstant = 0.01;

// Whether a gate refuses; all are enforced here.
bool refusedByGates(GateMode mode, InitResult* result) {
  decide(mode != GateMode::kOff, result);
  return !result->success();
}

// The newest state and its covariance.
StateFactor newestState(const InitResult& result) {
  StatePrior newest;
  newest.state = result.states.back();
  newest.covariance = result.stateCovariance(result.states.size() - 1);
  return stateFactor(newest);
}

// A window refined with a prior on its motion.
struct ProvisionalEstimate {
  bool valid = false;
  RefinedWindow refined;
  Posterior posterior;
  ScaleMoments scale;
};

// Refines, integrates over the scale, and again from the most probable scale where that is another
// one. Without lines: which of them are believed depends on the start, so that costs do not
// compare.
ProvisionalEstimate estimateProvisional(const RefinementInput& input,
                                        const TranslationEstimate& translation) {
  ProvisionalEstimate out;
  if (!translation.valid) return out;
  const std::optional<WindowState> start =
      startingState(input.tracks, input.pre, translation, input.inertial);
  if (start) out.refined = refineWindow(input, {}, *start);
  for (int round = 0; out.refined.valid; ++round) {
    const WindowState& state = out.refined.state;
    out.posterior = posteriorOf(input.tracks, out.refined);
    if (!out.posterior.valid) break;
    const std::vector<Preintegration> pre =
        preintegrateInflated(input.tracks, state.gyro_bias, state.accel_bias, input.inertial,
                             coveredShift(input.tracks, state.rig.dtd));
    out.scale = integrateScale(ScaleCost(out.refined, pre, input.tracks.calibration(),
                                         input.inertial, input.priors.motion));
    out.valid = out.scale.valid;
    if (!out.valid || round == kRefinements ||
        std::abs(out.scale.log_best) < ScaleProfile::kSameBasin) {
      break;
    }
    if (!input.budget.allows("the search of the most probable scale")) break;
    const double ratio = std::exp(out.scale.log_best);
    WindowState other = state;
    other.p_b0 *= ratio;
    other.v_b0 *= ratio;
    const RefinedWindow again = refineWindow(input, {}, other);
    if (!again.valid || !(again.cost < out.refined.cost)) break;
    out.refined = again;
  }
  out.valid = out.valid && out.posterior.valid;
  return out;
}

// Moves states and covariance of `result`, those of the refined window, to mean and covariance over
// the scale.
void moveToMean(const ScaleMoments& scale, const Posterior& posterior, InitResult* result) {
  const Eigen::VectorXd step = (scale.mean - 1.0) * posterior.by_scale;
  const int n = static_cast<int>(result->states.size());
  const Eigen::Vector3d gyro_bias = step.segment<3>(9 * n), accel_bias = step.tail<3>();
  for (int k = 0; k < n; ++k) {
    NavState& state = result->states[k];
    state.R_w_b = state.R_w_b * expSO3(step.segment<3>(9 * k));
    state.p_w_b += step.segment<3>(9 * k + 3);
    state.v_w_b += step.segment<3>(9 * k + 6);
    state.gyro_bias += gyro_bias;
    state.accel_bias += accel_bias;
  }
  result->gyro_bias += gyro_bias;
  result->accel_bias += accel_bias;
  result->gravity_b0 = result->states.front().R_w_b.transpose() * result->gravity_w;
  result->scale *= scale.mean;
  result->scale_sigma = std::sqrt(scale.log_variance);
  // What is known at a given scale stays; the variance of the scale is another one.
  result->covariance += (scale.variance - posterior.scale_sigma * posterior.scale_sigma) *
                        posterior.by_scale * posterior.by_scale.transpose();
}

}  // namespace

NewestSigmas newestSigmas(const InitResult& result) {
  NewestSigmas out;
  if (result.states.empty()) return out;
  const StateCovariance S = newestState(result).covariance;
  if (!S.allFinite()) return out;
  const auto largest = [](const DenseView& A) {
    return std::sqrt(symmetricEigen(A).values.maxCoeff());
  };
  out.velocity = largest(S.topLeftCorner<3, 3>());
  out.tilt_deg = largest(S.block<2, 2>(3, 3)) * kDegPerRad;
  return out;
}

bool agrees(const InitResult& earlier, const InitResult& now) {
  if (earlier.states.empty() || now.states.empty()) return false;
  const double t = earlier.states.back().t;
  const auto nearest = std::min_element(
      now.states.begin(), now.states.end(),
      [t](const NavState& a, const NavState& b) { return std::abs(a.t - t) < std::abs(b.t - t); });
  if (!(std::abs(nearest->t - t) < kSameInstant)) return false;
  const StateFactor before = newestState(earlier);
  const auto within = [](const Eigen::Vector3d& difference, const Eigen::Matrix3d& covariance) {
    return difference.dot(solveSymmetric(covariance, difference).col(0)) < kMaxDisagreement;
  };
  return within(nearest->R_w_b.transpose() * nearest->v_w_b - before.velocity_b,
                before.covariance.topLeftCorner<3, 3>()) &&
         within(now.gyro_bias - earlier.gyro_bias, before.covariance.block<3, 3>(5, 5));
}

// The stages of Slim::solve() up to the starts.
InitResult provisionalAnswer(const InitWindow& window, const InitializerOptions& options,
                             WorkBudget* budget) {
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;
  const RotationStage rotation = estimateRotations(window, options, budget);
  if (!acceptRotations(rotation, &result)) return result;
  const InitWindow &seen = *rotation.window, &tracks = *rotation.tracks;
  const double G = seen.calibration().gravity_magnitude;
  clock.lap("gyro_bias");

  const auto [pre, R_b0_bk, R_c0_ck, motion] =
      integrateWindow(tracks, result.gyro_bias, Eigen::Vector3d::Zero(), options.inertial);
  appendGates(parallaxGates(motion, options.gates), &result);
  if (refusedByGates(options.gates.mode, &result)) {
    keepObservable(pre, R_b0_bk, G, &result);
    clock.lap("verdict");
    return result;
  }
  const TranslationEstimate translation = estimateTranslations(tracks, R_c0_ck);
  clock.lap("translation");

  WindowPriors priors = {rotation.prior, MotionPrior()};
  priors.motion->speed_sigma = options.provisional.speed_prior;
  const ProvisionalEstimate estimate = estimateProvisional(
      {tracks, pre, options.refinement, options.inertial, *budget, priors}, translation);
  clock.lap("refinement");

  NewestSigmas newest;
  if (estimate.valid) {
    setEstimate(tracks, estimate.refined, estimate.posterior, &result);
    moveToMean(estimate.scale, estimate.posterior, &result);
    newest = newestSigmas(result);
    appendGates(calibrationGates(window.calibration(), *result.calibration, options.gates),
                &result);
    PosteriorMeasures measures =
        measurePosterior(seen, tracks, estimate.refined, estimate.posterior, nullptr, result.scale);
    measures.scale_sigma = result.scale_sigma;
    appendGates(provisionalGates(measures, newest.velocity, newest.tilt_deg, options.gates,
                                 options.provisional),
                &result);
  }
  if (!refusedByGates(options.gates.mode, &result) && !estimate.valid) {
    fail(InitStatus::kTooFewTracks, "the tracks give no estimate", &result);
  } else if (result.success()) {
    fail(InitStatus::kProvisional,
         roundedText(2, "standard deviations: velocity ", newest.velocity, " m/s, tilt ",
                     newest.tilt_deg, " deg, scale ", 100.0 * result.scale_sigma, " %"),
         &result);
  }
  failAtLimit(budget, &result);
  keepObservable(pre, R_b0_bk, G, &result);
  clock.lap("verdict");
  return result;
}

}  // namespace slim_init
