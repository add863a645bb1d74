// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/rotation_stage.h"

#include <algorithm>
#include <cmath>

#include "data/derived_window.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "imu/row_compensation.h"
#include "pipeline/solver_support.h"
#include "rotation/extrinsic_rotation.h"
#include "rotation/track_pruning.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// Noise and readout time that are off are as good as right after one more round; one to see it.
constexpr int kMaxRounds = 3;
// A readout time need not be solved again where it is nearer than this [s].
constexpr double kNearReadout = 2e-3;
// Nearer than this [rad], and kRelinearizeTolerance of td, the refinement is linear and the
// calibration stays. With a rolling shutter one further off has turned the rows.
constexpr double kNearRotation = 0.5 / kDegPerRad;
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
// Without the steps that follow there is no estimate at all: they have the rest.
constexpr double kShareOfRotations = 0.5;

// What is known of the calibration handed in, against another one.
RigPrior priorOf(const Calibration& handed_in, const Calibration& other) {
  RigPrior prior;
  prior.mean.dR = other.R_b_c.transpose() * handed_in.R_b_c;
  prior.mean.dtd = handed_in.td - other.td;
  prior.mean.dreadout = handed_in.readout_s - other.readout_s;
  prior.sigmas = handed_in.sigmas;
  return prior;
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

// The calibration that the rotations have found, and whether it is near the one that noise and rows
// of the window rest on.
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
  const RigError& rig = stage.bias.rig;
  const bool is_linear =
      logSO3(rig.dR).norm() < kNearRotation && std::abs(rig.dtd) < kRelinearizeTolerance;
  if (!is_linear) {
    out.value.R_b_c = seen.R_b_c * rig.dR;
    out.value.td += rig.dtd;
  }
  out.value.sigma_px = assumedSigmaPx(stage.bias, handed_in);
  const double ratio = out.value.sigma_px / seen.pointSigmaPx();
  out.is_near = std::max(ratio, 1.0 / ratio) < kNoisyTracks && (is_linear || seen.readout_s == 0.0);
  const bool kept = given == GivenCalibration::kKept;
  out.readout = readoutBelief(kept ? ReadoutCheck() : stage.bias.readout, handed_in, seen);
  if (kept || stage.bias.status == InitStatus::kTooFewTracks) return out;
  // Rows that are exposed one after the other cost six times the work.
  out.value.readout_s = out.readout.wrong > 0.5 ? out.readout.measured : handed_in.readout_s;
  const double off = std::abs(out.value.readout_s - seen.readout_s);
  if (off < kNearReadout) {
    out.value.readout_s = seen.readout_s;
  } else {
    out.is_near = false;
  }
  return out;
}

// The window under a calibration, unless that leaves too little of it.
std::shared_ptr<const InitWindow> seenThrough(const Calibration& calibration,
                                              const std::shared_ptr<const InitWindow>& window) {
  const auto seen = withCalibration(*window, calibration);
  return seen != nullptr && seen->size() >= kMinKeyframes ? seen : window;
}

// With a rolling shutter: rows turned to the middle row.
std::shared_ptr<const InitWindow> compensated(const std::shared_ptr<const InitWindow>& window,
                                              const Eigen::Vector3d& gyro_bias) {
  const auto turned = withRowsCompensated(*window, gyro_bias);
  return turned != nullptr ? turned : window;
}

// Vanishing points, bias and calibration of `raw`, rows compensated at a bias of zero.
BetterCalibration estimateBias(const std::shared_ptr<const InitWindow>& raw,
                               const Calibration& handed_in, GivenCalibration given,
                               const InitializerOptions& options, WorkBudget* budget,
                               RotationStage* stage) {
  stage->window = raw;
  // The estimator looks at it until the end.
  const std::shared_ptr<const InitWindow> window = compensated(raw, Eigen::Vector3d::Zero());
  std::vector<VanishingPoint> vanishing_points;
  if (options.slim.vanishing_points) {
    vanishing_points = trackVanishingPoints(*window, options.vanishing_point);
    for (VanishingPoint& vp : vanishing_points) vp.covariance *= kVpInflation;
  }
  RigPrior rig = priorOf(handed_in, raw->calibration());
  if (given == GivenCalibration::kKept) rig.sigmas.rotation_deg = rig.sigmas.td_s = 0.0;
  RobustBiasEstimator estimator(*window,
                                options.slim.vanishing_points ? &vanishing_points : nullptr,
                                options.inertial, rig, budget);
  const auto adopt = [&](const RobustBias& bias) {
    stage->bias = bias;
    return betterCalibration(*stage, handed_in, given);
  };
  const BetterCalibration better = adopt(estimator.quick());
  // A wrong camera looks like wrong tracks: the search for those waits for a better one.
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

// InitResult::track_noise, with a warning where the measured noise is above what may be assumed.
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

}  // namespace

RotationStage estimateRotations(const InitWindow& window, const InitializerOptions& options,
                                WorkBudget* budget, GivenCalibration given) {
  const WorkBudget::Share share(kShareOfRotations, budget);
  const Calibration& handed_in = window.calibration();
  RotationStage stage;
  std::shared_ptr<const InitWindow> raw = unowned(window);
  stage.window = stage.tracks = raw;
  if (given == GivenCalibration::kReplaced &&
      handed_in.sigmas.rotation_deg >= CalibrationSigmas::kUnknownRotationDeg) {
    const ExtrinsicRotation found = estimateExtrinsicRotation(window);
    stage.message = found.message;
    if (!found.message.empty()) return stage;
    Calibration better = handed_in;
    better.R_b_c = found.R_b_c;
    raw = withCalibration(window, better);
  }
  BetterCalibration better = solveRotations(raw, handed_in, given, options, budget, &stage);
  while (!better.is_near && stage.rounds < kMaxRounds &&
         budget->allows("a better calibration of the rotations")) {
    const auto seen = seenThrough(better.value, raw);
    if (seen == raw) break;
    raw = seen;
    better = solveRotations(raw, handed_in, given, options, budget, &stage);
  }
  const Eigen::Vector3d gyro_bias =
      stage.bias.valid() ? stage.bias.gyro_bias : Eigen::Vector3d::Zero();
  const auto finished = [&](const std::shared_ptr<const InitWindow>& cut) {
    return compensated(seenThrough(better.value, cut), gyro_bias);
  };
  raw = stage.window;
  stage.tracks = stage.window = finished(raw);
  stage.prior = priorOf(handed_in, stage.window->calibration());
  stage.prior.sigmas.readout_s = better.readout.sigma;
  if (!stage.bias.valid() || !options.slim.prune_tracks) return stage;
  if (auto pruned = withObservations(*raw, stage.bias.pruning.keep))
    stage.tracks = finished(pruned);
  return stage;
}

bool acceptRotations(const RotationStage& stage, bool bias_is_known, InitResult* result) {
  if (!stage.message.empty()) {
    fail(InitStatus::kTooLittleExcitation, stage.message, result);
    return false;
  }
  const RobustBias& bias = stage.bias;
  setTrackNoise(stage, result);
  if (bias_is_known) return true;
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
