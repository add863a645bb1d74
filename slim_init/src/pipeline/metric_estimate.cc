// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/metric_estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/dense.h"
#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "priors/sensor_priors.h"
#include "scale/linear_motion.h"
#include "scale/starting_states.h"

namespace slim_init {
namespace {

// Departure from one line in space, seen from the start, at which a line track is cut, in standard
// deviations of an end point; leaves a margin for the error of the start.
constexpr double kLineAgreementSigmas = 6.0;
// Decrease of the cost to another scale that is worth a refinement: one standard deviation
// [sigma^2].
constexpr double kBetterScale = 1.0;

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
  ImuBiases prior = assumedImuBiases(input.priors.biases, input.inertial);
  if (!input.priors.motion) {
    prior.accel_sigma = accelBiasTerm(input.priors.biases, input.inertial, state.accel_bias).sigma;
  }
  return ScaleCost(refined, pre, window.calibration(), prior, input.priors.motion);
}

// Whether the data contradict the biases known before: the test of a state of which nothing else is
// known.
bool contradictsBiases(const RefinementInput& input, const MetricEstimate& metric) {
  if (!areKnown(input.priors.biases, input.inertial)) return false;
  const ImuBiases prior = assumedImuBiases(input.priors.biases, input.inertial);
  StateVector sigma, moved = StateVector::Zero();
  sigma << Eigen::Vector3d::Constant(kUnknown[0]), Eigen::Vector2d::Constant(kUnknown[1]),
      Eigen::Vector3d::Constant(prior.gyro_sigma), Eigen::Vector3d::Constant(prior.accel_sigma);
  const WindowState& state = metric.refined.state;
  moved.tail<6>() << state.gyro_bias - prior.gyro, state.accel_bias - prior.accel;
  const StateCovariance before = sigma.cwiseAbs2().asDiagonal();
  StateCovariance posterior = before;
  posterior.bottomRightCorner<6, 6>() = metric.posterior.covariance.bottomRightCorner<6, 6>();
  return testState(moved, before, posterior).contradicts();
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

// The motion of a window as the IMU alone continues the known state, at whose biases `pre` is.
WindowState deadReckoned(const StateFactor& known, const std::vector<Preintegration>& pre,
                         double gravity_magnitude) {
  Eigen::Matrix<double, 9, 1> x;
  x << known.velocity_b, Eigen::Vector3d::Zero(), gravity_magnitude * known.down_b;
  return linearMotion(pre, chainRotations(pre), Eigen::Vector3d::Zero()).at(x);
}

// The part of the known state that the data contradict most, or "": none, or one that is not used
// already, so that what is left is not this state's fault. From then on it is as good as unknown.
std::string dropContradicted(const InitWindow& tracks, StateFactor* known, MetricEstimate* out) {
  const WindowState& state = out->refined.state;
  const std::vector<ImuInstant> instants =
      imuInstants(tracks, coveredShift(tracks, state.rig.dtd), state.gyro_bias, state.accel_bias);
  const StateResidual rows = stateResidual(state, *known, tracks.calibration(), instants.front());
  out->known_residual = rows.r;
  // Errors of the rows by those of the estimate, for their covariance there.
  const StateLayout at(state.size(), true);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kStateRows, at.size() - StateLayout::kGauge);
  J.middleCols<3>(at.velocity(0) - StateLayout::kGauge) = rows.J.leftCols<3>();
  J.middleCols<kStateColumns - 3>(at.gyroBias() - StateLayout::kGauge) =
      rows.J.rightCols<kStateColumns - 3>();
  Eigen::MatrixXd posterior;
  out->posterior.valid =
      inverseSeenBy(out->refined.information, J, &posterior) && posterior.allFinite();
  if (!out->posterior.valid) return "";
  const StateTest test = testState(rows.r, known->covariance, posterior);
  if (!test.contradicts()) return "";
  const auto part = static_cast<StatePart>(std::max_element(test.part.begin(), test.part.end()) -
                                           test.part.begin());
  const std::string name = toString(part);
  if (std::count(out->contradicted.begin(), out->contradicted.end(), name) > 0) return "";
  known->covariance = without(known->covariance, part);
  return name;
}

// The minimum, without the parts of a known state that the data contradict.
void refine(RefinementInput* input, const std::vector<Track>& lines, bool again,
            MetricEstimate* out) {
  std::optional<StateFactor>& known = input->priors.known;
  for (WindowState from = *out->start;; from = out->refined.state) {
    adopt(*input, searchMinimum(*input, lines, from, again), out);
    if (!out->posterior.valid) return;
    if (!known) {
      out->contradicts_biases = contradictsBiases(*input, *out);
      return;
    }
    const std::string part = dropContradicted(input->tracks, &*known, out);
    if (part.empty()) return;
    out->contradicted.push_back(part);
  }
}

// Again from another scale; whether the cost is lower there.
bool refineAt(double log_ratio, const RefinementInput& input, const std::vector<Track>& lines,
              MetricEstimate* out) {
  const double ratio = std::exp(log_ratio);
  WindowState other = out->refined.state;
  other.p_b0 *= ratio;
  other.v_b0 *= ratio;
  RefinedWindow again = refineWindow(input, lines, other);
  if (!again.valid || !(again.cost < out->refined.cost)) return false;
  MetricEstimate better = *out;
  adopt(input, std::move(again), &better);
  if (!better.posterior.valid) return false;
  better.contradicts_biases = contradictsBiases(input, better);
  *out = std::move(better);
  return true;
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

  // [5.1, 5.2] The cost over the scale: is another one as good? From one that is better the window
  // is refined again.
  if (out.posterior.valid && over_scales) {
    out.scale = integrateScale(scaleCostOf(input, out.refined));
    if (out.scale.valid && std::abs(out.scale.log_best) > ScaleProfile::kSameBasin &&
        input.budget.allows("the search of the most probable scale") &&
        refineAt(out.scale.log_best, input, lines, &out)) {
      out.scale = integrateScale(scaleCostOf(input, out.refined));
    }
    out.posterior.valid = out.posterior.valid && out.scale.valid;
  } else if (out.posterior.valid && !has_state && can_pass) {
    out.profile = profileScale(scaleCostOf(input, out.refined));
    // Without the work for it the gate on other scales decides.
    if (out.profile->valid && out.profile->cost_here - out.profile->cost > kBetterScale &&
        !input.budget.isUsedUp() && refineAt(out.profile->log_ratio, input, lines, &out)) {
      out.profile = profileScale(scaleCostOf(input, out.refined));
    }
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
