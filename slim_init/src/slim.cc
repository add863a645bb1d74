// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "data/derived_window.h"
#include "geometry/dense.h"
#include "pipeline/metric_estimate.h"
#include "pipeline/rotation_stage.h"
#include "pipeline/solver_support.h"
#include "priors/sensor_priors.h"
#include "shape/ligt.h"
#include "slim_init/text.h"
#include "slim_init/window_solver.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

// What an estimator goes on with in flight: standard deviations of the newest velocity, a part that
// a host survives whatever its speed and a share of the speed, and of the newest attitude.
constexpr double kVelocitySigma = 0.2;  // [m/s]
constexpr double kVelocityShare = 0.06;
constexpr double kTiltSigmaDeg = 1.5;

// One solve. What is known beside the data decides what differs: a state at the first keyframe, of
// a body at rest or in flight, or a prior on the motion for a provisional estimate. Numbers in
// brackets are the sections of docs/derivation.md.
class Solve {
 public:
  Solve(const InitWindow& window, const SolveRequest& request, const InitializerOptions& options,
        WorkBudget* budget)
      : given_(window),
        options_(options),
        budget_(*budget),
        state_(request.first_state),
        in_flight_(state_ != nullptr && !state_->at_rest),
        provisional_(request.provisional && state_ == nullptr),
        plain_(state_ == nullptr && !provisional_) {}

  InitResult run();
  /// Whether the data contradict the biases known before (Calibration::imu_biases).
  bool contradictsBiases() const { return contradicts_biases_; }

 private:
  std::shared_ptr<const InitWindow> windowToSolve();
  WindowPriors priorsOf(const RotationStage& rotation) const;
  void setBounds(const InitWindow& seen, const MotionMeasures& motion);
  bool endsWithoutTranslation();
  bool canPass() const;
  void setMetric(const MetricEstimate& metric, const RotationStage& rotation,
                 const MotionMeasures& motion);
  ProvisionalOptions newestBounds(bool full) const;
  void nameSuccess(const MetricEstimate& metric);
  void judgeForces(double mean_force, double behind_fraction);
  void failWithoutEstimate(const TranslationEstimate& translation);

  const InitWindow& given_;
  const InitializerOptions& options_;
  WorkBudget& budget_;
  const StatePrior* const state_;
  const bool in_flight_, provisional_, plain_;
  GateOptions bounds_;
  InitResult result_;
  bool contradicts_biases_ = false, bias_is_large_ = false;
};

InitResult Solve::run() {
  StageClock clock(&result_);
  if (!startResult(given_, &result_)) return result_;
  const std::shared_ptr<const InitWindow> window = windowToSolve();
  if (window == nullptr) return result_;

  // [1, 6.1] Vanishing points with their covariance, gyroscope bias b_g by consensus, under a
  // calibration that the rotations agree with; observations that contradict it are pruned. A host
  // has flown with its calibration.
  const RotationStage rotation =
      estimateRotations(*window, options_, &budget_,
                        in_flight_ ? GivenCalibration::kKept : GivenCalibration::kReplaced);
  if (!acceptRotations(rotation, state_ != nullptr, &result_)) return result_;
  const InitWindow &seen = *rotation.window, &tracks = *rotation.tracks;
  clock.lap("gyro_bias");

  // [4.2] Preintegrations at b_g; they fix the rotations up to section 3. [6] What the motion
  // offers.
  WindowPriors priors = priorsOf(rotation);
  ImuBiases biases = assumedImuBiases(priors.biases, options_.inertial);
  biases.gyro = result_.gyro_bias;
  if (state_) biases = priors.known->biases();
  const auto [pre, R_b0_bk, R_c0_ck, motion] = integrateWindow(tracks, biases, options_.inertial);
  setBounds(seen, motion);
  clock.lap("integration");

  MetricEstimate metric;
  TranslationEstimate translation;
  if (!endsWithoutTranslation()) {
    // [2] Camera centres up to scale.
    if (state_ == nullptr) translation = estimateTranslations(tracks, R_c0_ck);
    clock.lap("translation");

    // [3-5] Metric starts, maximum a posteriori estimate, posterior.
    if (state_ != nullptr) {
      // With less parallax points are directions.
      priors.known->points_at_infinity = !(motion.parallax_px >= options_.gates.min_parallax_px);
    }
    metric = estimateMetric({tracks, pre, options_.refinement, options_.inertial, budget_, priors},
                            translation, options_, canPass(), &clock);
    setMetric(metric, rotation, motion);
  }

  // [6] Verdict. [7] What is left of a window without translation.
  enforceGates(options_.gates.mode, &result_);
  decide(false, &result_);
  nameSuccess(metric);
  if (state_ == nullptr) {
    keepObservable(motion.mean_force, seen.calibration().gravity_magnitude, &result_);
  }
  clock.lap("verdict");
  if (!result_.hasEstimate() && (result_.success() || state_ != nullptr)) {
    failWithoutEstimate(translation);
  }
  if (state_ == nullptr) judgeForces(motion.mean_force.norm(), metric.refined.behind_fraction);
  failAtLimit(&budget_, &result_);
  return result_;
}

// With a known state through the extrinsics that it brings, and its td if the body has stood; null
// where they cannot be solved together.
std::shared_ptr<const InitWindow> Solve::windowToSolve() {
  // The integral over the scale knows no speeds; with them a success comes as early.
  if (state_ == nullptr) return provisional_ ? withoutSpeeds(given_) : unowned(given_);
  std::shared_ptr<const InitWindow> through = unowned(given_);
  std::string problem;
  if (const std::string invalid = state_->validate(); !invalid.empty()) {
    problem = invalid;
  } else if (!isPositiveDefinite(stateFactor(*state_).covariance)) {
    problem =
        "the covariance of the last healthy state is not positive definite in velocity, tilt and "
        "biases";
  } else if (!(std::abs(state_->state.t - given_.times().front()) < kStampRounding)) {
    problem = "the last healthy state is not that of the first keyframe";
  } else if (state_->calibration.has_value()) {
    CalibrationEstimate extrinsics = *state_->calibration;
    if (!state_->at_rest) extrinsics.covariance(6, 6) = 0.0;  // its time is with the host's td
    through = withCalibration(given_, withFound(given_.calibration(), extrinsics));
    if (through == nullptr) problem = "the calibration of the last healthy state is not valid";
  }
  if (problem.empty()) return through;
  fail(InitStatus::kInvalidInput, problem, &result_);
  return nullptr;
}

WindowPriors Solve::priorsOf(const RotationStage& rotation) const {
  WindowPriors priors = {rotation.prior};
  if (state_ != nullptr) priors.known = stateFactor(*state_);
  if (state_ == nullptr) priors.biases = given_.calibration().imu_biases;
  if (provisional_) priors.motion = MotionPrior{options_.provisional.speed_prior};
  return priors;
}

// And the gates on the motion. A state in flight vouches for the scale without any.
void Solve::setBounds(const InitWindow& seen, const MotionMeasures& motion) {
  bounds_ = gatesInForce(options_.gates, seen, options_.window);
  if (in_flight_) return;
  appendGates(plain_ ? motionGates(motion, bounds_) : std::vector{parallaxGate(motion, bounds_)},
              &result_);
}

// Without parallax no estimate can be accepted, and none is returned of a window at rest or in pure
// rotation, or before its scale is known: the status is known before anything metric is estimated.
bool Solve::endsWithoutTranslation() {
  if (options_.gates.mode == GateMode::kOff || state_ != nullptr) return false;
  return std::any_of(result_.gates.begin(), result_.gates.end(), [this](const GateValue& gate) {
    return gate.name == GateName::kParallax && !gate.passed &&
           (provisional_ || gate.status_if_failed == InitStatus::kStationary ||
            gate.status_if_failed == InitStatus::kPureRotation);
  });
}

// Without parallax or excitation the scale cannot be accepted, whatever the estimate is.
bool Solve::canPass() const {
  return options_.gates.mode == GateMode::kOff ||
         std::all_of(result_.gates.begin(), result_.gates.end(),
                     [](const GateValue& gate) { return gate.passed || !gate.exception.empty(); });
}

// States, covariance, and the gates on them. A start answers for its calibration.
void Solve::setMetric(const MetricEstimate& metric, const RotationStage& rotation,
                      const MotionMeasures& motion) {
  const InitWindow &seen = *rotation.window, &tracks = *rotation.tracks;
  if (!metric.posterior.valid) {
    if (plain_ && !options_.slim.refine && metric.start) {
      setWorldStates(seen, *metric.start, &result_);
    }
    return;
  }
  setEstimate(tracks, metric.refined, metric.posterior, &result_);
  if (provisional_) moveToMean(metric.scale, metric.posterior, &result_);
  const Calibration& given = given_.calibration();
  const CalibrationEstimate& found = *result_.calibration;
  const bool full = isFull(seen, options_.window);
  if (!in_flight_ && !provisional_) {
    // A calibration can be made to fit what moves in the images: more data tell.
    if (appendCalibrationWarnings(given, found, &result_) && !full) {
      bounds_.min_inlier_fraction = std::max(bounds_.min_inlier_fraction, kMostInliers);
    }
  }
  if (state_ == nullptr && !(given.imu_biases.accel_sigma < options_.inertial.accel_bias_prior)) {
    bias_is_large_ = appendBiasWarning(options_.inertial, &result_);
  }
  if (!in_flight_) appendGates(calibrationGates(given, found, bounds_), &result_);

  PosteriorMeasures measures = measurePosterior(seen, tracks, metric.refined, metric.posterior,
                                                metric.profileOrNull(), result_.scale);
  if (!provisional_) {
    result_.scale_sigma =
        scaleSigma(measures, metric.posterior.scale_sigma, full, bounds_.max_scale_sigma);
  }
  measures.scale_sigma = result_.scale_sigma;
  measures.newest = newestSigmas(result_);
  appendGates(in_flight_ || provisional_
                  ? provisionalGates(measures, motion, bounds_, newestBounds(full))
                  : posteriorGates(measures, motion, bounds_, newestBounds(full)),
              &result_);
  result_.prior_dropped = metric.contradicted;
  contradicts_biases_ = metric.contradicts_biases;
  if (state_ != nullptr) moveToWorldOf(*state_, metric.known_residual, &result_);
}

// What a host goes on with; in flight the velocity contains how the scale is known. A full window
// has no better attitude to wait for, and may be twice as uncertain.
ProvisionalOptions Solve::newestBounds(bool full) const {
  ProvisionalOptions bounds = options_.provisional;
  if (provisional_) return bounds;
  // A bias that may be larger tilts gravity by as much.
  const double known_worse =
      options_.inertial.accel_bias_prior / InertialOptions().accel_bias_prior;
  bounds.max_tilt_sigma_deg =
      (full && !in_flight_ ? 2.0 : 1.0) * kTiltSigmaDeg * std::max(1.0, known_worse);
  bounds.max_velocity_sigma = kVelocitySigma + kVelocityShare * result_.states.back().v_w_b.norm();
  bounds.max_scale_sigma = HUGE_VAL;
  return bounds;
}

// What a success rests on.
void Solve::nameSuccess(const MetricEstimate& metric) {
  if (!result_.success() || !result_.hasEstimate()) return;
  if (plain_) {
    if (metric.refined.speeds.keyframes == 0) return;
    const double alone = scaleSigma(metric.posterior, metric.profileOrNull());
    if (alone <= bounds_.max_scale_sigma) return;
    // Nothing has checked the sensor's.
    result_.message = roundedText(
        2, "the scale is that of the measured velocities: images and IMU alone give it to ",
        100.0 * alone, " % (limit ", 100.0 * bounds_.max_scale_sigma,
        " %), an error of the sensor would not show");
    result_.warnings.push_back(result_.message);
    return;
  }
  const NewestSigmas newest = newestSigmas(result_);
  const std::string sigmas = roundedText(2, "standard deviations of velocity ", newest.velocity,
                                         " m/s, tilt ", newest.tilt_deg, " deg");
  if (provisional_) {
    fail(InitStatus::kProvisional,
         sigmas + roundedText(2, ", scale ", 100.0 * result_.scale_sigma, " %"), &result_);
    return;
  }
  // Without the velocity nothing vouches for the scale, and a state with two incorrect parts for
  // nothing.
  std::string dropped;
  for (const std::string& part : result_.prior_dropped) {
    dropped += (dropped.empty() ? "" : ", ") + part;
  }
  if (result_.prior_dropped.size() > 1 || dropped == toString(StatePart::kVelocity)) {
    fail(InitStatus::kScaleTooUncertain, "the data contradict the last healthy state: " + dropped,
         &result_);
    return;
  }
  result_.message = "from a known state: " + sigmas;
  if (!dropped.empty()) result_.message += "; the data contradict its " + dropped;
}

// The commonest errors of a rig of one's own, which show as residuals of images that are correct,
// or as a bias in place of gravity. In free fall the bias is none.
void Solve::judgeForces(double mean_force, double behind_fraction) {
  const double gravity = given_.calibration().gravity_magnitude;
  const bool has_estimate = result_.success() || result_.provisional();
  std::string question;
  const bool enforced = options_.gates.mode != GateMode::kOff;
  if (mean_force < 0.5 * gravity && (!has_estimate || (bias_is_large_ && enforced))) {
    question = roundedText(2, "the mean specific force is ", mean_force, " m/s^2, gravity ",
                           gravity, ": is the accelerometer in g, or without gravity?");
  } else if ((!has_estimate || enforced) && behind_fraction > 0.5) {
    question = "most points are behind the camera: is the sign of the accelerometer inverted?";
  }
  if (question.empty()) return;
  if (has_estimate) {
    fail(InitStatus::kInconsistentResiduals, question, &result_);
  } else {
    result_.message += "; " + question;
  }
}

// No gate has refused.
void Solve::failWithoutEstimate(const TranslationEstimate& translation) {
  if (state_ != nullptr || translation.valid) {
    fail(InitStatus::kNumericalFailure,
         "the refinement found no minimum with a positive definite information", &result_);
    return;
  }
  fail(InitStatus::kTooFewTracks,
       text(translation.tracks, " tracks over ", kMinTrackLength,
            " or more keyframes with parallax (minimum ", kMinTracks, ")"),
       &result_);
}

// `slim`, the default: points, line segments and vanishing points without any 3D structure as
// state.
class Slim : public WindowSolver {
 public:
  explicit Slim(const InitializerOptions& options) : name_("slim"), options_(options) {}
  const std::string& name() const override { return name_; }
  bool usesPriors() const override { return true; }

 protected:
  InitResult solveWindow(const InitWindow& window, const SolveRequest& request,
                         WorkBudget* budget) const override {
    WorkBudget own(options_.limits);
    WorkBudget* const shared = budget == nullptr ? &own : budget;
    Solve solve(window, request, options_, shared);
    InitResult result = solve.run();
    Calibration calibration = window.calibration();
    const ImuBiases known = std::exchange(calibration.imu_biases, ImuBiases());
    if (request.first_state != nullptr || !areKnown(known, options_.inertial) ||
        (result.status != InitStatus::kInconsistentResiduals && !solve.contradictsBiases())) {
      return result;
    }
    if (!shared->allows("the solve without the biases known from before")) {
      failAtLimit(shared, &result);
      return result;
    }
    // As if they were not known: the data contradict them, or nothing has fitted them.
    result = Solve(*withCalibration(window, calibration), request, options_, shared).run();
    if (solve.contradictsBiases() || result.success()) {
      result.warnings.push_back(roundedText(
          3, "the prior biases, gyroscope (", known.gyro.transpose(), ") rad/s and accelerometer (",
          known.accel.transpose(), ") m/s^2, contradict the data and are not used"));
    }
    return result;
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
