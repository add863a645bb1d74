// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/metric_estimate.h"

#include <cmath>
#include <utility>

#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "pipeline/known_state.h"
#include "scale/starting_states.h"

namespace slim_init {
namespace {

// Departure from one line in space, seen from the start, at which a line track is cut, in standard
// deviations of an end point; leaves a margin for the error of the start.
constexpr double kLineAgreementSigmas = 6.0;

// About the biases of the estimate: chained over the window, first order is not exact enough.
// Between the exposures, td as estimated.
ScaleCost scaleCostOf(const RefinementInput& input, const RefinedWindow& refined) {
  const InitWindow& window = input.tracks;
  const WindowState& state = refined.state;
  std::vector<Preintegration> pre =
      preintegrateWindow(window, {state.gyro_bias, state.accel_bias}, ImuNoise(),
                         coveredShift(window, state.rig.dtd), PreintegrationParts::kMean);
  // The covariance depends on the biases by a hundredth of itself.
  for (std::size_t k = 0; k < pre.size(); ++k) pre[k].covariance = input.pre[k].covariance;
  return ScaleCost(refined, pre, window.calibration(), input.inertial, input.priors.motion);
}

void adopt(const RefinementInput& input, RefinedWindow refined, MetricEstimate* out) {
  out->refined = std::move(refined);
  out->posterior = Posterior();
  if (!out->refined.valid) return;
  const WindowState& state = out->refined.state;
  out->posterior =
      posteriorOf(state, out->refined.information, input.tracks.calibration(),
                  imuInstants(input.tracks, state.rig.dtd, state.gyro_bias, state.accel_bias));
}

// The minimum, without the parts of a known state that the data contradict.
void refine(RefinementInput* input, const std::vector<Track>& lines, bool again,
            MetricEstimate* out) {
  std::optional<StateFactor>& known = input->priors.known;
  for (WindowState from = *out->start;; from = out->refined.state) {
    adopt(*input, searchMinimum(*input, lines, from, again), out);
    if (!out->posterior.valid || !known) return;
    const std::string part = dropContradicted(input->tracks, out->refined, out->contradicted,
                                              &*known, &out->known_residual);
    if (part.empty()) return;
    out->contradicted.push_back(part);
  }
}

// Integrates over the scale; again from the most probable one, where that is another one with a
// lower cost.
void integrateOverScale(const RefinementInput& input, MetricEstimate* out) {
  out->scale = integrateScale(scaleCostOf(input, out->refined));
  if (!out->scale.valid || std::abs(out->scale.log_best) < ScaleProfile::kSameBasin) return;
  if (!input.budget.allows("the search of the most probable scale")) return;
  const double ratio = std::exp(out->scale.log_best);
  WindowState other = out->refined.state;
  other.p_b0 *= ratio;
  other.v_b0 *= ratio;
  RefinedWindow again = refineWindow(input, {}, other);
  if (!again.valid || !(again.cost < out->refined.cost)) return;
  adopt(input, std::move(again), out);
  if (out->posterior.valid) out->scale = integrateScale(scaleCostOf(input, out->refined));
}

}  // namespace

std::vector<Track> believedLines(const InitWindow& tracks, const WindowState& start,
                                 const InitializerOptions& options) {
  if (!options.slim.prune_lines || !options.refinement.use_lines) {
    return tracks.lineTracks();
  }
  const double bound = kLineAgreementSigmas * tracks.calibration().sigmaLine();
  return agreeingLineTracks(tracks, start, bound, kMinLineViews);
}

RefinedWindow searchMinimum(const RefinementInput& input, const std::vector<Track>& lines,
                            const WindowState& start, bool again) {
  if (!again) return refineWindow(input, lines, start);
  // The shape may have been none, or the known state may have led astray.
  const auto other = [&]() -> std::optional<WindowState> {
    if (!input.budget.allows("the search of another minimum")) return std::nullopt;
    return inertialStartingState(input.tracks, input.pre, input.inertial);
  };
  return refineWindow(input, lines, start, other);
}

MetricEstimate estimateMetric(RefinementInput input, const TranslationEstimate& translation,
                              const InitializerOptions& options, bool can_pass, StageClock* clock) {
  MetricEstimate out;
  const bool has_state = input.priors.known.has_value();
  const bool over_scales = input.priors.motion.has_value();
  if (has_state) {
    out.start =
        deadReckoned(*input.priors.known, input.pre, input.tracks.calibration().gravity_magnitude);
  } else if (translation.valid) {
    // [3.2] Reverse alignment.
    out.start = startingState(input.tracks, input.pre, translation, input.inertial);
  }
  if (!out.start) return out;
  // [4.8] Line tracks that agree with the start; costs from several starts would not compare.
  std::vector<Track> lines;
  if (!has_state && !over_scales) lines = believedLines(input.tracks, *out.start, options);
  clock->lap("alignment");

  // [4, 3.3, 5] Minimum of the robust cost over states, biases, gravity and rig, tracks eliminated;
  // covariance in the world frame and of the scale.
  if (options.slim.refine || has_state || over_scales) {
    refine(&input, lines, has_state || (can_pass && !over_scales), &out);
  }
  clock->lap("refinement");

  // [5.1, 5.2] The cost over the scale: is another one as good?
  if (out.posterior.valid && over_scales) {
    integrateOverScale(input, &out);
    out.posterior.valid = out.posterior.valid && out.scale.valid;
  } else if (out.posterior.valid && !has_state && can_pass) {
    out.profile = profileScale(scaleCostOf(input, out.refined));
  }
  clock->lap("other_scale");
  return out;
}

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

}  // namespace slim_init
