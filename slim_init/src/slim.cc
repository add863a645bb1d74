// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "data/derived_window.h"
#include "estimation/posterior.h"
#include "imu/preintegration.h"
#include "pipeline/answers.h"
#include "pipeline/minimum_search.h"
#include "pipeline/rotation_stage.h"
#include "pipeline/solver_support.h"
#include "scale/scale_profile.h"
#include "scale/starting_states.h"
#include "shape/ligt.h"
#include "slim_init/text.h"
#include "slim_init/window_solver.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

// No gate has refused, and yet there is no answer.
void failWithoutAnswer(const TranslationEstimate& translation, InitResult* result) {
  if (translation.valid) {
    fail(InitStatus::kNumericalFailure,
         "the refinement found no minimum with a positive definite information", result);
    return;
  }
  fail(InitStatus::kTooFewTracks,
       text(translation.tracks, " tracks over ", kMinTrackLength,
            " or more keyframes with parallax (minimum ", kMinTracks, ")"),
       result);
}

// Sections 3 to 5 of docs/derivation.md.
struct MetricEstimate {
  std::optional<WindowState> start;
  RefinedWindow refined;
  std::optional<ScaleProfile> profile;
  Posterior posterior;

  const ScaleProfile* profileOrNull() const { return profile ? &*profile : nullptr; }
};

// About the biases of the estimate: chained over the window, first order is not exact enough.
// Between the exposures, td as estimated.
ScaleProfile profileOf(const RefinementInput& input, const RefinedWindow& refined) {
  const InitWindow& window = input.tracks;
  const WindowState& state = refined.state;
  std::vector<Preintegration> pre =
      preintegrateWindow(window, {state.gyro_bias, state.accel_bias}, ImuNoise(),
                         coveredShift(window, state.rig.dtd), PreintegrationParts::kMean);
  // The covariance depends on the biases by a hundredth of itself.
  for (std::size_t k = 0; k < pre.size(); ++k) pre[k].covariance = input.pre[k].covariance;
  return profileScale(ScaleCost(refined, pre, window.calibration(), input.inertial));
}

// Searches of other minima are for answers that can be accepted: `cannot_pass` ones go without.
MetricEstimate estimateMetric(const RefinementInput& input, const TranslationEstimate& translation,
                              const InitializerOptions& options, bool cannot_pass,
                              StageClock* clock) {
  MetricEstimate out;
  if (!translation.valid) return out;
  // [3.2] Reverse alignment.
  out.start = startingState(input.tracks, input.pre, translation, options.inertial);
  // [4.8] Line tracks that agree with it.
  std::vector<Track> lines;
  if (out.start) lines = believedLines(input.tracks, *out.start, options);
  clock->lap("alignment");

  // [4, 3.3, 5] Minimum of the robust cost over states, biases, gravity and rig, tracks eliminated;
  // covariance in the world frame and of the scale.
  if (options.slim.refine && out.start) {
    out.refined = searchMinimum(input, lines, *out.start, !cannot_pass);
    if (out.refined.valid) out.posterior = posteriorOf(input.tracks, out.refined);
  }
  clock->lap("refinement");

  // [5.1] The cost over the scale: is another one as good?
  if (out.posterior.valid && !cannot_pass) out.profile = profileOf(input, out.refined);
  clock->lap("other_scale");
  return out;
}

// Sets scale_sigma as well, which may rest on measured velocities.
std::vector<GateValue> gatesOf(const MetricEstimate& metric, const InitWindow& seen,
                               const InitWindow& tracks, const MotionMeasures& motion,
                               const InitializerOptions& options, InitResult* result) {
  const GateOptions bounds = gatesInForce(options.gates, seen, options.window);
  PosteriorMeasures measures = measurePosterior(seen, tracks, metric.refined, metric.posterior,
                                                metric.profileOrNull(), result->scale);
  // The noise of the tracks makes short paths longer, and the scale of speeds would be about those.
  const bool full = isFull(seen, options.window) && motion.parallax_px >= bounds.min_parallax_px;
  measures.scale_sigma = result->scale_sigma =
      scaleSigma(measures, metric.posterior.scale_sigma, full, bounds.max_scale_sigma);
  return posteriorGates(measures, motion, bounds);
}

// The scale cannot be accepted, whatever the estimate is.
bool lacksExcitation(GateMode mode, const InitResult& result) {
  return mode != GateMode::kOff &&
         std::any_of(result.gates.begin(), result.gates.end(), [](const GateValue& gate) {
           return gate.name == GateName::kExcitation && !gate.passed && gate.exception.empty();
         });
}

// Where not even the least parallax is there, no answer can be accepted, and none is handed out of
// a window at rest or in pure rotation: the verdict is known before anything metric is estimated.
bool endsWithoutTranslation(GateMode mode, InitResult* result) {
  if (mode == GateMode::kOff) return false;
  const bool moves = std::any_of(result->gates.begin(), result->gates.end(), [](const auto& gate) {
    const bool without_states = gate.status_if_failed == InitStatus::kStationary ||
                                gate.status_if_failed == InitStatus::kPureRotation;
    return gate.name == GateName::kLeastParallax && (gate.passed || !without_states);
  });
  if (moves) return false;
  enforceGates(mode, result);
  decide(false, result);
  return true;
}

// A success whose scale images and IMU alone do not give: nothing has checked the sensor's.
void nameScaleOfSpeeds(const MetricEstimate& metric, double max_scale_sigma, InitResult* result) {
  if (!result->success() || metric.refined.speeds.keyframes == 0) return;
  const double alone = scaleSigma(metric.posterior, metric.profileOrNull());
  if (alone <= max_scale_sigma) return;
  result->message = roundedText(
      2, "the scale is that of the measured velocities: images and IMU alone give it to ",
      100.0 * alone, " % (limit ", 100.0 * max_scale_sigma,
      " %), an error of the sensor would not show");
  result->warnings.push_back(result->message);
}

// Numbers in brackets are the sections of docs/derivation.md.
InitResult answer(const InitWindow& window, const InitializerOptions& options, WorkBudget* budget) {
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;

  // [1, 6.1] Vanishing points with their covariance, gyroscope bias b_g by consensus, under a
  // calibration that the rotations agree with; observations that contradict it are pruned.
  const RotationStage rotation = estimateRotations(window, options, budget);
  if (!acceptRotations(rotation, &result)) return result;
  const InitWindow &seen = *rotation.window, &tracks = *rotation.tracks;
  const double G = seen.calibration().gravity_magnitude;
  clock.lap("gyro_bias");

  // [4.2] Preintegrations at b_g; they fix the rotations up to section 3. [6] What the motion
  // offers.
  const auto [pre, R_b0_bk, R_c0_ck, motion] =
      integrateWindow(tracks, result.gyro_bias, Eigen::Vector3d::Zero(), options.inertial);
  appendGates(motionGates(motion, options.gates), &result);
  clock.lap("integration");
  if (endsWithoutTranslation(options.gates.mode, &result)) {
    keepObservable(pre, R_b0_bk, G, &result);
    clock.lap("verdict");
    return result;
  }

  // [2] Camera centres up to scale.
  const TranslationEstimate translation = estimateTranslations(tracks, R_c0_ck);
  clock.lap("translation");

  // [3-5] Metric starts, maximum a posteriori estimate, posterior.
  const MetricEstimate metric =
      estimateMetric({tracks, pre, options.refinement, options.inertial, *budget, {rotation.prior}},
                     translation, options, lacksExcitation(options.gates.mode, result), &clock);

  // [6] Verdict. [7] What is left of a window without translation.
  if (metric.posterior.valid) {
    setEstimate(tracks, metric.refined, metric.posterior, &result);
    appendCalibrationWarnings(window.calibration(), *result.calibration, &result);
    appendGates(calibrationGates(window.calibration(), *result.calibration, options.gates),
                &result);
    appendGates(gatesOf(metric, seen, tracks, motion, options, &result), &result);
  } else if (!options.slim.refine && metric.start) {
    setWorldStates(seen, *metric.start, &result);
  }
  enforceGates(options.gates.mode, &result);
  decide(false, &result);
  nameScaleOfSpeeds(metric, gatesInForce(options.gates, seen, options.window).max_scale_sigma,
                    &result);
  keepObservable(pre, R_b0_bk, G, &result);
  clock.lap("verdict");
  if (result.success() && !result.hasEstimate()) failWithoutAnswer(translation, &result);
  failAtLimit(budget, &result);
  return result;
}

// `slim`, the default: points, line segments and vanishing points without any 3D structure as
// state.
class Slim : public WindowSolver {
 public:
  explicit Slim(const InitializerOptions& options) : name_("slim"), options_(options) {}
  const std::string& name() const override { return name_; }
  bool usesPriors() const override { return true; }
  InitResult solve(const InitWindow& window) const override {
    WorkBudget budget(options_.limits);
    return solveWithin(window, &budget);
  }
  InitResult solveWithin(const InitWindow& window, WorkBudget* budget) const override {
    return answerAboutKnownBiases(window, options_, budget, answer);
  }
  InitResult solveProvisional(const InitWindow& window, WorkBudget* budget) const override {
    // The integral over the scale knows no speeds; with them a success comes as early.
    return answerAboutKnownBiases(*withoutSpeeds(window), options_, budget, provisionalAnswer);
  }
  InitResult solveWithPrior(const InitWindow& window, const StatePrior& prior,
                            WorkBudget* budget) const override {
    return recoveredAnswer(window, prior, options_, budget);
  }

 private:
  const std::string name_;
  const InitializerOptions options_;
};

}  // namespace

std::unique_ptr<WindowSolver> makeSlimSolver(const InitializerOptions& options,
                                             std::string* error) {
  const std::string message = options.validate();
  if (message.empty()) return std::make_unique<Slim>(options);
  if (error != nullptr) *error = message;
  return nullptr;
}

}  // namespace slim_init
