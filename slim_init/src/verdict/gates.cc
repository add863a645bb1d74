// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "verdict/gates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "geometry/robust.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "scale/scale_profile.h"
#include "slim_init/consistency_check.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// Keyframes of a track for which GateOptions::min_parallax_px is meant; so many bearings are three
// times as good as one. Fewer need more.
constexpr double kTrackLength = 9.0;
// Passes of leastMotionPx(): each leaves a fifth of the rate.
constexpr int kRatePasses = 3;
// Of a motion, its largest over its rms value: sqrt(3) if it is steady, sqrt(2) if it sways.
constexpr double kLargestOverRms = 1.5;
// Relative standard deviation of the scale of images and IMU below which the motion shows the
// scale: at constant velocity it stays above (0.37 to none in the first half second).
constexpr double kShownScaleSigma = 0.35;
// And largest relative change of a velocity that counts as constant, 0.15 there: a change that the
// wheel sees is one that the IMU measures, half a second later at the latest.
constexpr double kSteadyVelocityChange = 0.2;

// First to last keyframe [s].
double spanOf(const InitWindow& window) { return window.times().back() - window.times().front(); }

// A part of the calibration found, against the one handed in: in words, error with its standard
// deviation, and that before any data, infinite where nothing was known.
struct CalibrationError {
  const char *what, *unit, *key;
  double error, sigma, prior;
};

std::array<CalibrationError, 4> errorsOf(const Calibration& handed_in,
                                         const CalibrationEstimate& found) {
  const CalibrationSigmas& known = handed_in.sigmas;
  const bool unknown = known.rotation_deg >= CalibrationSigmas::kUnknownRotationDeg;
  const double translation_sigma = std::sqrt(found.covariance.diagonal().segment<3>(3).maxCoeff());
  return {{{"extrinsic rotation", "deg", "extrinsicRotation",
            logSO3(handed_in.R_b_c.transpose() * found.R_b_c).norm() * kDegPerRad,
            found.rotationSigmaDeg(), unknown ? HUGE_VAL : known.rotation_deg},
           {"extrinsic translation", "mm", "extrinsicTranslation",
            kMmPerM * (found.t_b_c - handed_in.t_b_c).norm(), kMmPerM * translation_sigma,
            kMmPerM * known.translation_m},
           {"camera-IMU time offset", "ms", "td", kMsPerS * (found.td - handed_in.td),
            kMsPerS * found.tdSigma(), kMsPerS * known.td_s},
           {"readout time", "ms", "rolling_shutter and rolling_shutter_tr",
            kMsPerS * (found.readout_s - handed_in.readout_s), kMsPerS * found.readoutSigma(),
            kMsPerS * known.readout_s}}};
}

std::string explainOtherScale(const PosteriorMeasures& measures) {
  std::string baselines;
  if (std::isfinite(measures.other_scale)) {
    baselines = roundedText(3, " (mean baseline ", measures.other_scale, " m instead of ",
                            measures.scale, " m)");
  }
  return "another scale" + baselines + " fits nearly as well: cost difference";
}

std::string explainChi2(const PosteriorMeasures& measures) {
  const std::string what = "visual chi-square per degree of freedom";
  if (!std::isfinite(measures.sigma_px)) return what;
  return what + roundedText(2, " at a track noise of ", measures.sigma_px, " px:");
}

// Rms angle between the bearings of a keyframe's points and their mean direction, the median over
// the keyframes with points [deg]. Points in one spot are one point, however many. NaN without any.
double pointSpreadDeg(const InitWindow& window) {
  std::vector<Eigen::Vector3d> sum(window.size(), Eigen::Vector3d::Zero());
  std::vector<int> count(window.size(), 0);
  for (const WindowPoint& observation : window.pointObservations()) {
    sum[observation.keyframe] += observation.bearing;
    ++count[observation.keyframe];
  }
  std::vector<double> spreads;
  for (int k = 0; k < window.size(); ++k) {
    if (count[k] == 0) continue;
    // Of unit vectors with mean m, the mean squared chord to m / |m| is 2 (1 - |m|).
    const double chord2 = 2.0 * (1.0 - sum[k].norm() / count[k]);
    spreads.push_back(std::sqrt(std::max(chord2, 0.0)) * kDegPerRad);
  }
  if (spreads.empty()) return kNotComputed;
  return median(std::move(spreads));
}

}  // namespace

// Comparisons with NaN are false: a value that is not known does not pass.
GateValue atMost(double value, double threshold) {
  GateValue gate;
  gate.value = value;
  gate.threshold = threshold;
  gate.upper_bound = true;
  gate.passed = value <= threshold;
  return gate;
}

GateValue atLeast(double value, double threshold) {
  GateValue gate = atMost(value, threshold);
  gate.upper_bound = false;
  gate.passed = value >= threshold;
  return gate;
}

GateValue makeGate(GateName name, const std::string& explanation, const char* unit, GateValue gate,
                   InitStatus status_if_failed) {
  gate.name = name;
  gate.explanation = explanation;
  gate.unit = unit;
  gate.status_if_failed = status_if_failed;
  return gate;
}

void measureTracks(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck,
                   MotionMeasures* motion) {
  std::vector<double> angles, lengths;
  for (const Track& track : window.pointTracks()) {
    const WindowPoint& first = window.pointObservations()[track.begin];
    const Eigen::Vector3d u_first = R_c0_ck[first.keyframe] * first.bearing;
    double largest = 0.0;
    for (int k = track.begin + 1; k < track.end; ++k) {
      const WindowPoint& other = window.pointObservations()[k];
      const Eigen::Vector3d u = R_c0_ck[other.keyframe] * other.bearing;
      largest = std::max(largest, std::atan2(u_first.cross(u).norm(), u_first.dot(u)));
    }
    angles.push_back(largest);
    lengths.push_back(track.size());
  }
  if (angles.empty()) return;
  motion->parallax_px = median(std::move(angles)) * window.calibration().focal_px;
  motion->track_length = median(std::move(lengths));
}

double leastMotionPx(const InitWindow& window, double rate_sigma,
                     std::vector<Eigen::Matrix3d> R_c0_ck) {
  const std::vector<Track>& tracks = window.pointTracks();
  const std::vector<WindowPoint>& points = window.pointObservations();
  const std::vector<double>& t = window.times();
  if (tracks.empty()) return kNotComputed;
  // Of the first bearing of the track to that of observation `k`, in c0 [rad].
  const auto turn = [&](const Track& track, int k) -> Eigen::Vector3d {
    const WindowPoint &first = points[track.begin], &seen = points[k];
    return (R_c0_ck[first.keyframe] * first.bearing).cross(R_c0_ck[seen.keyframe] * seen.bearing);
  };
  for (int pass = 0; pass < kRatePasses; ++pass) {
    std::array<std::vector<double>, 3> rates;
    for (const Track& track : tracks) {
      const double dt = t[points[track.end - 1].keyframe] - t[points[track.begin].keyframe];
      const Eigen::Vector3d turned = turn(track, track.end - 1);
      for (int i = 0; i < 3; ++i) rates[i].push_back(turned[i] / dt);
    }
    Eigen::Vector3d rate;
    for (int i = 0; i < 3; ++i) rate[i] = std::clamp(median(rates[i]), -rate_sigma, rate_sigma);
    for (std::size_t k = 0; k < t.size(); ++k) {
      R_c0_ck[k] = expSO3(-(t[k] - t[0]) * rate) * R_c0_ck[k];
    }
  }
  std::vector<double> lengths;
  for (const Track& track : tracks) {
    double sum = 0.0;
    for (int k = track.begin + 1; k < track.end; ++k) sum += turn(track, k).squaredNorm();
    lengths.push_back(std::sqrt(sum / (track.size() - 1)));
  }
  return kLargestOverRms * median(std::move(lengths)) * window.calibration().focal_px;
}

double maxRotationDeg(const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  double largest = 0.0;
  for (const Eigen::Matrix3d& R : R_b0_bk) largest = std::max(largest, logSO3(R).norm());
  return largest * kDegPerRad;
}

void measureForce(const std::vector<Preintegration>& pre,
                  const std::vector<Eigen::Matrix3d>& R_b0_bk, MotionMeasures* motion) {
  Eigen::Matrix3Xd force(3, pre.size());
  for (std::size_t i = 0; i < pre.size(); ++i) {
    force.col(i) = R_b0_bk[i] * pre[i].dv / pre[i].dt;
  }
  motion->mean_force = force.rowwise().mean();
  motion->excitation = std::sqrt((force.colwise() - motion->mean_force).squaredNorm() /
                                 static_cast<double>(pre.size()));
}

PosteriorMeasures measurePosterior(const InitWindow& window, const InitWindow& tracks,
                                   const RefinedWindow& refined, const Posterior& posterior,
                                   const ScaleProfile* profile, double scale) {
  PosteriorMeasures measures;
  measures.sigma_px = tracks.calibration().pointSigmaPx();
  measures.chi2 = refined.chi2;
  measures.inertial_chi2 = refined.inertial_chi2;
  measures.inlier_fraction = refined.inlier_fraction * tracks.pointObservations().size() /
                             window.pointObservations().size();
  measures.has_speeds = 2 * refined.speeds.contradicted < refined.speeds.keyframes;
  measures.scale_sigma = measures.motion_scale_sigma = scaleSigma(posterior, profile);
  measures.point_spread_deg = pointSpreadDeg(tracks);
  measures.scale = scale;
  const Eigen::Matrix3Xd& v = refined.state.v_b0;
  const Eigen::Vector3d mean = v.rowwise().mean();
  measures.velocity_change = (v.colwise() - mean).colwise().norm().maxCoeff() / mean.norm();
  measures.mean_acceleration = (v.rightCols<1>() - v.leftCols<1>()).norm() / spanOf(window);
  measures.profiled = profile != nullptr;
  if (profile != nullptr) {
    measures.other_scale = scale * std::exp(profile->other_log_ratio);
    measures.other_scale_rise = profile->other_rise;
  }
  return measures;
}

double scaleSigma(const Posterior& posterior, const ScaleProfile* profile) {
  if (profile == nullptr || !profile->valid) return posterior.scale_sigma;
  return std::max(posterior.scale_sigma, profile->sigma);
}

double scaleSigma(const PosteriorMeasures& measures, double posterior_sigma, bool full,
                  double max_scale_sigma) {
  const double alone = measures.motion_scale_sigma;
  const bool steady =
      alone >= kShownScaleSigma && measures.velocity_change <= kSteadyVelocityChange;
  const bool waits = !full && !steady && alone > max_scale_sigma;
  return measures.has_speeds && !waits ? posterior_sigma : alone;
}

GateValue parallaxGate(const MotionMeasures& motion, const GateOptions& options) {
  InitStatus no_motion = InitStatus::kStationary;
  if (motion.rotation_deg >= kMinRotationDeg) no_motion = InitStatus::kPureRotation;
  // Still tracks alone are no rest: a scene far away shows no parallax either.
  if (no_motion == InitStatus::kStationary && motion.excitation > kMaxRestDeviation) {
    no_motion = InitStatus::kTooLittleExcitation;
  }
  // Without tracks nothing is known about the motion.
  if (!std::isfinite(motion.parallax_px)) no_motion = InitStatus::kTooFewTracks;
  const double bound = options.min_parallax_px *
                       std::sqrt(kTrackLength / std::clamp(motion.track_length, 1.0, kTrackLength));
  GateValue gate = atLeast(motion.parallax_px, bound);
  const bool is_rotation = gate.passed && motion.least_motion_px < options.min_parallax_px;
  if (is_rotation) gate = atLeast(motion.least_motion_px, options.min_parallax_px);
  return makeGate(
      GateName::kParallax,
      roundedText(2, "median rotation-compensated motion of the tracks over ", motion.track_length,
                  " keyframes", is_rotation ? " that no gyroscope bias explains" : ""),
      "px", gate, no_motion);
}

std::vector<GateValue> motionGates(const MotionMeasures& motion, const GateOptions& options) {
  std::vector<GateValue> gates = {parallaxGate(motion, options)};
  gates.push_back(makeGate(GateName::kExcitation, "deviation of the specific force from its mean",
                           "m/s^2", atLeast(motion.excitation, options.min_excitation),
                           InitStatus::kTooLittleExcitation));
  if (motion.has_speeds) gates.back().exception = "measured velocities: scale_sigma decides";
  return gates;
}

std::vector<GateValue> calibrationGates(const Calibration& handed_in,
                                        const CalibrationEstimate& found,
                                        const GateOptions& options) {
  const auto certain = [](GateName name, const std::string& what, const CalibrationError& of,
                          double threshold) {
    return makeGate(
        name,
        roundedText(2, what, " error about ", of.error, ' ', of.unit, " (sigma ", of.sigma, ' ',
                    of.unit, "), less ", kCertainSigmas, " sigma:"),
        of.unit, atMost(std::max(std::abs(of.error) - kCertainSigmas * of.sigma, 0.0), threshold),
        InitStatus::kInconsistentResiduals);
  };
  const auto [rotation, translation, td, readout] = errorsOf(handed_in, found);
  const GateValue of_rotation =
      std::isfinite(rotation.prior)
          ? certain(GateName::kExtrinsicRotation, rotation.what, rotation,
                    options.max_extrinsic_error_deg)
          : makeGate(GateName::kExtrinsicSigma,
                     "standard deviation of the unknown extrinsic rotation (also rotate about "
                     "another axis)",
                     rotation.unit, atMost(rotation.sigma, options.max_extrinsic_sigma_deg),
                     InitStatus::kTooLittleExcitation);
  return {of_rotation, certain(GateName::kTimeOffset, td.what + std::string(" td"), td,
                               kMsPerS * options.max_td_error_s)};
}

bool appendCalibrationWarnings(const Calibration& handed_in, const CalibrationEstimate& found,
                               InitResult* result) {
  const std::size_t before = result->warnings.size();
  for (const CalibrationError& of : errorsOf(handed_in, found)) {
    if (of.prior == 0.0) continue;  // held: its error is one of rounding
    const double error = std::abs(of.error);
    if (!(error > kCertainSigmas * std::hypot(of.sigma, of.prior))) continue;
    result->warnings.push_back(
        roundedText(3, of.what, " is off by ", error, ' ', of.unit, " (sigma ", of.sigma, ' ',
                    of.unit, "), more than its standard deviation of ", of.prior, ' ', of.unit,
                    " allows: if several windows agree, correct ", of.key));
  }
  return result->warnings.size() > before;
}

bool appendBiasWarning(const InertialOptions& inertial, InitResult* result) {
  const double bias = result->accel_bias.norm(), prior = inertial.accel_bias_prior;
  const double sigma =
      std::sqrt(result->covariance.bottomRightCorner<3, 3>().diagonal().maxCoeff());
  if (!(bias > kCertainSigmas * std::hypot(sigma, prior))) return false;
  result->warnings.push_back(
      roundedText(3, "the accelerometer bias of ", bias, " m/s^2 (sigma ", sigma,
                  ") is more than inertial.accel_bias_prior of ", prior,
                  " allows, gravity and scale may be off: calibrate it, or raise the key"));
  return true;
}

bool isFull(const InitWindow& window, const WindowOptions& options) {
  return spanOf(window) >= ConsistencyCheck::kFullFraction * options.fullSpan();
}

GateOptions gatesInForce(const GateOptions& options, const InitWindow& window,
                         const WindowOptions& window_options) {
  GateOptions gates = options;
  if (!isFull(window, window_options)) {
    gates.max_scale_sigma = options.max_scale_sigma_expanding;
  } else if (window_options.min_keyframes == window_options.keyframes) {
    gates.max_scale_sigma = options.max_scale_sigma_fixed_size;
  }
  return gates;
}

std::vector<GateValue> posteriorGates(const PosteriorMeasures& measures,
                                      const MotionMeasures& motion, const GateOptions& options,
                                      const ProvisionalOptions& newest) {
  const InitStatus uncertain = motion.excitation < options.min_excitation
                                   ? InitStatus::kTooLittleExcitation
                                   : InitStatus::kScaleTooUncertain;
  std::vector<GateValue> gates = {
      makeGate(GateName::kChi2, explainChi2(measures), "", atMost(measures.chi2, options.max_chi2),
               InitStatus::kInconsistentResiduals),
      makeGate(GateName::kInertialChi2, "inertial chi-square per residual", "",
               atMost(measures.inertial_chi2, options.max_inertial_chi2),
               InitStatus::kInconsistentResiduals),
      makeGate(GateName::kInlierFraction, "fraction of the point observations kept", "",
               atLeast(measures.inlier_fraction, options.min_inlier_fraction),
               InitStatus::kInconsistentResiduals),
      makeGate(
          GateName::kMeanAcceleration, "mean acceleration over the window", "m/s^2",
          atMost(measures.mean_acceleration, std::max(kMaxMeanAcceleration, motion.excitation)),
          InitStatus::kInconsistentResiduals),
      makeGate(GateName::kPointSpread, "angle over which the points are spread", "deg",
               atLeast(measures.point_spread_deg, kMinPointSpreadDeg), InitStatus::kTooFewTracks)};
  // Measured velocities say which scale it is.
  if (measures.profiled && !measures.has_speeds) {
    gates.push_back(makeGate(GateName::kOtherScale, explainOtherScale(measures), "sigma^2",
                             atLeast(measures.other_scale_rise, kMinOtherScaleRise), uncertain));
  }
  if (std::isfinite(options.max_scale_sigma)) {
    gates.push_back(makeGate(GateName::kScaleSigma, "relative standard deviation of the scale", "",
                             atMost(measures.scale_sigma, options.max_scale_sigma), uncertain));
  }
  gates.push_back(makeGate(GateName::kTiltSigma, "standard deviation of the newest attitude", "deg",
                           atMost(measures.newest.tilt_deg, newest.max_tilt_sigma_deg),
                           InitStatus::kScaleTooUncertain));
  return gates;
}

std::vector<GateValue> provisionalGates(const PosteriorMeasures& measures, MotionMeasures motion,
                                        GateOptions options, const ProvisionalOptions& bounds) {
  options.max_scale_sigma = bounds.max_scale_sigma;
  motion.excitation = std::max(options.min_excitation, motion.excitation);
  std::vector<GateValue> gates = posteriorGates(measures, motion, options, bounds);
  gates.push_back(makeGate(GateName::kVelocitySigma, "standard deviation of the newest velocity",
                           "m/s", atMost(measures.newest.velocity, bounds.max_velocity_sigma),
                           InitStatus::kScaleTooUncertain));
  return gates;
}

std::string describe(const GateValue& gate) {
  std::string value = " not measured";
  if (std::isfinite(gate.value)) {
    value = roundedText(3, ' ', gate.value, gate.unit.empty() ? "" : " ", gate.unit);
  } else if (gate.name == GateName::kAgreement) {
    return gate.explanation;  // says all there is to say
  }
  return gate.explanation + value +
         roundedText(3, gate.upper_bound ? " (limit " : " (minimum ", gate.threshold, ')');
}

void enforceGates(GateMode mode, InitResult* result) {
  if (mode == GateMode::kOff) return;
  for (GateValue& gate : result->gates) gate.enforced = gate.exception.empty();
}

void decide(bool enforce_all, InitResult* result) {
  const GateValue* refusing = nullptr;
  const GateValue* failed = nullptr;
  for (GateValue& gate : result->gates) {
    gate.enforced = gate.enforced || enforce_all;
    if (gate.passed) continue;
    if (failed == nullptr) failed = &gate;
    if (gate.enforced && refusing == nullptr) refusing = &gate;
  }
  if (refusing != nullptr) {
    result->status = refusing->status_if_failed;
    result->message = describe(*refusing);
    return;
  }
  result->status = InitStatus::kSuccess;
  result->message =
      failed == nullptr ? "all gates passed" : "gates not enforced; " + describe(*failed);
}

}  // namespace slim_init
