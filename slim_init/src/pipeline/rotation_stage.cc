// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/rotation_stage.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "data/derived_window.h"
#include "geometry/robust.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "imu/row_compensation.h"
#include "pipeline/solver_support.h"
#include "rotation/extrinsic_rotation.h"
#include "rotation/track_pruning.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// With a calibration this near, in standard deviations of what the rotations say of it, they need
// not be solved again, nor where it is nearer than these: the estimation is linear there.
constexpr double kNear = 2.0;
constexpr double kNearRotation = 0.5 / kDegPerRad;  // [rad]
constexpr double kNearTd = 1.5e-3;                  // [s]
// From an error of ten degrees or 50 ms two corrections are exact to kNear*; one more to see it.
constexpr int kMaxRounds = 4;
// The same of a readout time [s], or of its share.
constexpr double kNearReadout = 2e-3;
constexpr double kNearReadoutShare = 0.25;
// Share of the cameras whose readout time is not the one given.
constexpr double kWrongReadout = 0.1;
// Up to this probability it is taken as given: to estimate it costs a column of the equations.
constexpr double kHardlyWrong = 0.03;
// A noise of the tracks within this factor of the one assumed changes hardly a weight. Beyond, what
// a window is granted at most is exceeded, or sigma_px of the file: the tracks are called noisy.
constexpr double kNoisyTracks = 1.3;
// Most noise that a window may be granted [px]: above, tracks are bad whatever their statistics
// are. Below Calibration::kTypicalSigmaPx what rotations and IMU get wrong counts for as much.
constexpr double kMostSigmaPx = 2.5;
// Factor on the covariance of a vanishing direction: clutter among the inliers is not in it
// (kappa_v).
constexpr double kVpInflation = 4.0;
// Rounds of re-weighting of the prior: its weight has settled by then.
constexpr int kPriorRounds = 8;
// Without the steps that follow there is no estimate at all: they have the rest.
constexpr double kShareOfRotations = 0.5;

// What is known about [rotation, td] of the calibration before the data, against `seen`.
struct PriorOfCheck {
  Eigen::Vector4d mean;
  Eigen::Matrix4d covariance;
};

PriorOfCheck priorOfCheck(const Calibration& handed_in, const Calibration& seen) {
  PriorOfCheck prior;
  prior.mean.head<3>() = logSO3(seen.R_b_c.transpose() * handed_in.R_b_c);
  prior.mean[3] = handed_in.td - seen.td;
  const double rotation = handed_in.sigmas.rotation_deg / kDegPerRad;
  Eigen::Vector4d sigma(rotation, rotation, rotation, handed_in.sigmas.td_s);
  prior.covariance = sigma.cwiseAbs2().asDiagonal();
  return prior;
}

// The most probable [rotation, td] from check and prior, which may be wrong.
Eigen::Vector4d correctionOf(const CalibrationCheck& check, const PriorOfCheck& prior) {
  Eigen::Vector4d measured;
  measured << check.extrinsic_error, check.td_error_s;
  const Eigen::Vector4d off = measured - prior.mean;
  // From the prior: where the check knows little, it stays there.
  Eigen::Vector4d step = Eigen::Vector4d::Zero();
  double weight = 1.0;
  for (int round = 0; round < kPriorRounds; ++round) {
    const Eigen::Matrix4d wide = prior.covariance / weight;
    step = wide * Eigen::Matrix4d(wide + check.covariance).ldlt().solve(off);
    double z2 = 0.0;
    for (int i = 0; i < 4; ++i) {
      if (prior.covariance(i, i) > 0.0) z2 += step[i] * step[i] / prior.covariance(i, i);
    }
    weight = gemanMcClure(z2);
  }
  return prior.mean + step;
}

// Whether the correction is no more than what the check does not know, or what hardly counts.
bool isNear(const Eigen::Vector4d& correction, const Eigen::Matrix4d& covariance) {
  const Eigen::Vector4d hardly(kNearRotation, kNearRotation, kNearRotation, kNearTd);
  const Eigen::Matrix4d wide = covariance + Eigen::Matrix4d(hardly.cwiseAbs2().asDiagonal());
  return correction.dot(wide.ldlt().solve(correction)) < kNear * kNear;
}

// What is known of the readout time before the estimate of the window: most are as given, the
// others anything up to kLargestReadout (docs/derivation.md, 6.1). What the pairs have measured
// says which, and nothing more: the estimate has the same tracks.
struct ReadoutBelief {
  double wrong = 0.0;     // probability that the time given is wrong
  double measured = 0.0;  // [s]
  double sigma = 0.0;     // standard deviation about the time given [s]
};

ReadoutBelief readoutBelief(const ReadoutCheck& check, const Calibration& handed_in,
                            const Calibration& seen) {
  ReadoutBelief out;
  // A global shutter is one, a readout time has an error.
  out.sigma = handed_in.readout_s > 0.0 ? handed_in.sigmas.readout_s : 0.0;
  if (!check.valid || handed_in.sigmas.readout_s == 0.0) return out;
  out.measured = std::clamp(seen.readout_s + check.error_s, 0.0,
                            std::max(kLargestReadout, handed_in.readout_s));
  const double variance = std::pow(check.sigma_s, 2) + std::pow(out.sigma, 2);
  const double off2 = std::pow(out.measured - handed_in.readout_s, 2);
  const double as_given =
      (1.0 - kWrongReadout) * std::exp(-0.5 * off2 / variance) / std::sqrt(2.0 * M_PI * variance);
  const double other = kWrongReadout / kLargestReadout;
  out.wrong = other / (as_given + other);
  if (out.wrong > kHardlyWrong) {
    out.sigma = std::hypot(out.sigma, std::sqrt(out.wrong / 3.0) * kLargestReadout);
  }
  return out;
}

// Standard deviation of a point that is to be assumed [px].
double assumedSigmaPx(const RobustBias& bias, const Calibration& handed_in) {
  const double measured = bias.track_sigma * handed_in.focal_px;
  if (handed_in.sigma_px > 0.0) return handed_in.sigma_px;
  if (!std::isfinite(measured)) return Calibration::kTypicalSigmaPx;
  return std::clamp(measured, Calibration::kTypicalSigmaPx, kMostSigmaPx);
}

// What the rotations say of the calibration: a better one, and whether that of the window is near.
struct BetterCalibration {
  Calibration value;
  bool is_near = true;
  ReadoutBelief readout;
};

BetterCalibration betterCalibration(const RotationStage& stage, const Calibration& handed_in,
                                    GivenCalibration given) {
  const Calibration& seen = stage.window->calibration();
  BetterCalibration out;
  out.value = seen;
  out.value.sigma_px = assumedSigmaPx(stage.bias, handed_in);
  const double ratio = out.value.sigma_px / seen.pointSigmaPx();
  out.is_near = std::max(ratio, 1.0 / ratio) < kNoisyTracks;
  const bool kept = given == GivenCalibration::kKept;
  out.readout = readoutBelief(kept ? ReadoutCheck() : stage.bias.readout, handed_in, seen);
  if (kept || stage.bias.status == InitStatus::kTooFewTracks) return out;
  // Rows that are exposed one after the other cost six times the work.
  out.value.readout_s = out.readout.wrong > 0.5 ? out.readout.measured : handed_in.readout_s;
  const double off = std::abs(out.value.readout_s - seen.readout_s);
  if (off < std::max(kNearReadout, kNearReadoutShare * seen.readout_s)) {
    out.value.readout_s = seen.readout_s;
  } else {
    out.is_near = false;
  }
  const CalibrationCheck check =
      checkCalibration(*stage.window, stage.bias.gyro_bias, stage.bias.rotations);
  if (!check.valid) return out;
  const Eigen::Vector4d correction = correctionOf(check, priorOfCheck(handed_in, seen));
  if (isNear(correction, check.covariance)) return out;
  out.is_near = false;
  out.value.R_b_c = seen.R_b_c * expSO3(correction.head<3>());
  out.value.td += correction[3];
  return out;
}

// Vanishing points and bias of `raw`, and the calibration that follows. With a rolling shutter its
// rows are turned to the middle row by the gyroscope at a bias of zero, and again by the bias
// found.
BetterCalibration estimateBias(const std::shared_ptr<const InitWindow>& raw,
                               const Calibration& handed_in, GivenCalibration given,
                               const InitializerOptions& options, WorkBudget* budget,
                               RotationStage* stage) {
  stage->window = raw;
  const auto compensate = [&](const Eigen::Vector3d& gyro_bias) {
    if (const auto turned = withRowsCompensated(*raw, gyro_bias)) stage->window = turned;
  };
  compensate(Eigen::Vector3d::Zero());
  // The estimator looks at it until the end.
  const std::shared_ptr<const InitWindow> window = stage->window;
  std::vector<VanishingPoint> vanishing_points;
  if (options.slim.vanishing_points) {
    vanishing_points = trackVanishingPoints(*window, options.vanishing_point);
    for (VanishingPoint& vp : vanishing_points) vp.covariance *= kVpInflation;
  }
  RobustBiasEstimator estimator(*window,
                                options.slim.vanishing_points ? &vanishing_points : nullptr,
                                options.inertial, budget);
  const auto adopt = [&](const RobustBias& bias) {
    stage->bias = bias;
    if (bias.valid()) compensate(bias.gyro_bias);
    return betterCalibration(*stage, handed_in, given);
  };
  const BetterCalibration better = adopt(estimator.quick());
  // A wrong calibration looks like wrong tracks: the search for those waits for a better one.
  const bool last = stage->rounds + 1 >= kMaxRounds;
  return stage->bias.clean || !(better.is_near || last) ? better : adopt(estimator.thorough());
}

// Of a window as it was cut; a second time without what stands in the image.
BetterCalibration solveRotations(const std::shared_ptr<const InitWindow>& raw,
                                 const Calibration& handed_in, GivenCalibration given,
                                 const InitializerOptions& options, WorkBudget* budget,
                                 RotationStage* stage) {
  BetterCalibration better = estimateBias(raw, handed_in, given, options, budget, stage);
  stage->static_tracks = 0;
  if (options.slim.prune_tracks && stage->bias.gyro_bias.allFinite()) {
    const std::shared_ptr<const InitWindow> scene =
        withoutStaticTracks(*raw, stage->bias.gyro_bias, &stage->static_tracks);
    if (scene != nullptr) better = estimateBias(scene, handed_in, given, options, budget, stage);
  }
  ++stage->rounds;
  return better;
}

// What is known of the calibration given, against the one found.
RigPrior priorOf(const RotationStage& stage, const Calibration& handed_in,
                 const BetterCalibration& better) {
  const Calibration& found = stage.window->calibration();
  RigPrior prior;
  prior.mean.dR = found.R_b_c.transpose() * handed_in.R_b_c;
  prior.mean.dtd = handed_in.td - found.td;
  prior.mean.dreadout = handed_in.readout_s - found.readout_s;
  prior.sigmas = handed_in.sigmas;
  prior.sigmas.readout_s = better.readout.sigma;
  return prior;
}

}  // namespace

RotationStage estimateRotations(const InitWindow& window, const InitializerOptions& options,
                                WorkBudget* budget, GivenCalibration given) {
  const WorkBudget::Share share(kShareOfRotations, budget);
  const Calibration& handed_in = window.calibration();
  RotationStage stage;
  std::shared_ptr<const InitWindow> raw = unowned(window);
  stage.window = raw;
  if (given == GivenCalibration::kReplaced &&
      handed_in.sigmas.rotation_deg >= CalibrationSigmas::kUnknownRotationDeg) {
    const ExtrinsicRotation found = estimateExtrinsicRotation(window);
    stage.message = found.message;
    stage.tracks = raw;
    if (!found.valid) return stage;
    Calibration better = handed_in;
    better.R_b_c = found.R_b_c;
    stage.window = raw = withCalibration(window, better);
  }
  BetterCalibration better = solveRotations(raw, handed_in, given, options, budget, &stage);
  while (!better.is_near && stage.rounds < kMaxRounds &&
         budget->allows("a better calibration of the rotations")) {
    const std::shared_ptr<const InitWindow> seen = withCalibration(*raw, better.value);
    if (seen == nullptr || seen->size() < kMinKeyframes) break;
    raw = seen;
    better = solveRotations(raw, handed_in, given, options, budget, &stage);
  }
  Calibration found = stage.window->calibration();
  if (better.value.sigma_px != found.pointSigmaPx()) {
    found.sigma_px = better.value.sigma_px;
    stage.window = withCalibration(*stage.window, found);
  }
  stage.prior = priorOf(stage, handed_in, better);
  stage.tracks = stage.window;
  if (!stage.bias.valid() || !options.slim.prune_tracks) return stage;
  if (auto pruned = withObservations(*stage.window, stage.bias.pruning.keep)) stage.tracks = pruned;
  return stage;
}

void setTrackNoise(const RotationStage& stage, InitResult* result) {
  const Calibration& calibration = stage.window->calibration();
  const double measured = stage.bias.track_sigma * calibration.focal_px;
  const double assumed = calibration.pointSigmaPx();
  result->track_noise = {measured, assumed};
  if (!(measured > kNoisyTracks * assumed)) return;
  result->warnings.push_back(
      roundedText(2, "point tracks have a noise of ", measured, " px, ", assumed,
                  " px is assumed: blur, dim images, or an incorrect camera model"));
}

bool acceptRotations(const RotationStage& stage, InitResult* result) {
  if (!stage.message.empty()) {
    fail(InitStatus::kTooLittleExcitation, stage.message, result);
    return false;
  }
  const RobustBias& bias = stage.bias;
  setTrackNoise(stage, result);
  if (bias.valid()) {
    result->gyro_bias = bias.gyro_bias;
    if (stage.static_tracks == 0) return true;
    result->warnings.push_back(text(
        stage.static_tracks, " of ", stage.static_tracks + stage.window->pointTracks().size(),
        " point tracks are static in the image while the camera turns and are not used (a part of"
        " the vehicle in view, drops or dirt on the lens): exclude that part of the image with"
        " the key mask, the back end uses these tracks too"));
    return true;
  }
  std::string message =
      text("gyroscope bias ", bias.gyro_bias.norm(), " rad/s (limit ", kMaxBias, ")");
  if (bias.status == InitStatus::kTooFewTracks) {
    message =
        text("0 keyframe pairs with ", kMinPointsPerPair, " or more common points (minimum 1)");
  } else if (bias.status == InitStatus::kInconsistentResiduals) {
    message = text("fraction of the point tracks that agree with one gyroscope bias ",
                   bias.inlierFraction(), " (minimum ", kMinInlierFraction, ")");
  }
  fail(bias.status, message, result);
  return false;
}

}  // namespace slim_init
