// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The table of the core's options: key, field, bounds, unit, and what it does and why the default
// is what it is.
#include "slim_init/options.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "data/range_check.h"
#include "slim_init/option_table.h"
#include "slim_init/text.h"

namespace slim_init {

bool OptionField::isReadBy(const std::string& method) const {
  return methods.empty() || std::find(methods.begin(), methods.end(), method) != methods.end();
}

OptionField userKey(const char* key, OptionValue value, OptionRange range, const char* unit,
                    const char* reason) {
  return {key, std::move(value), range, unit, reason, Audience::kUser};
}

OptionField userKey(const char* key, OptionValue value, const char* reason) {
  return userKey(key, std::move(value), {}, "", reason);
}

OptionField advancedKey(const char* key, OptionValue value, OptionRange range, const char* unit,
                        const char* reason) {
  return {key, std::move(value), range, unit, reason, Audience::kAdvanced};
}

OptionField advancedKey(const char* key, OptionValue value, const char* reason) {
  return advancedKey(key, std::move(value), {}, "", reason);
}

void appendSection(const std::string& prefix, OptionTable section,
                   const std::vector<std::string>& methods, OptionTable* table) {
  for (OptionField& option : section) {
    if (!prefix.empty()) option.key = prefix + "." + option.key;
    if (option.methods.empty()) option.methods = methods;
    table->push_back(std::move(option));
  }
}

namespace {

const std::vector<std::string> kSlim = {"slim"};
// Methods with a standard deviation of the scale.
const std::vector<std::string> kWithScaleSigma = {"slim",  "slim-paper", "drt-l",
                                                  "drt-t", "drt-vi-ba",  "vins"};

}  // namespace

const char* toString(GateMode mode) {
  switch (mode) {
    case GateMode::kOwn: return "own";
    case GateMode::kOn: return "on";
    case GateMode::kOff: return "off";
  }
  return "unknown";
}

OptionTable optionTable(WindowOptions* o) {
  return {
      userKey("keyframes", &o->keyframes, {kMinKeyframes, 50}, "",
              "maximum number of keyframes in a window"),
      advancedKey("min_keyframes", &o->min_keyframes, {kMinKeyframes, 50}, "",
                  "a window with fewer has the status too_few_keyframes"),
      userKey("min_interval_s", &o->min_interval_s, {0.01, 5.0}, "s",
              "minimum time between keyframes: every image at 10 Hz, every second one at 20 Hz"),
      userKey("max_span_s", &o->max_span_s, {0.0, 60.0}, "s",
              "maximum length of a window: beyond `keyframes` times min_interval_s the keyframes "
              "are spread over it; 0: no expansion"),
      userKey("max_frame_gap_s", &o->max_frame_gap_s, {0.05, 10.0}, "s",
              "a longer gap between images ends the window (blackout)"),
      userKey("max_imu_gap_s", &o->max_imu_gap_s, {0.001, 1.0}, "s",
              "a longer gap between IMU samples ends the window"),
      advancedKey("buffer_s", &o->buffer_s, {0.5, 600.0}, "s", "data kept; bounds the memory"),
  };
}

OptionTable optionTable(InertialOptions* o) {
  return {
      advancedKey(
          "accel_noise_factor", &o->accel_noise_factor, {0.0, 100.0}, "",
          "factor on noise.accel_density; 0: measured from the samples of the window (vibration) "
          "and its motion, at least 1. Recorded EuRoC flights have 9 to 12 (medians), hand-held "
          "recordings and simulated IMUs 2 to 4"),
      advancedKey("gyro_noise_factor", &o->gyro_noise_factor, {0.0, 100.0}, "",
                  "factor on noise.gyro_density; 0: measured, at least 1. Recorded EuRoC flights "
                  "have 2 to 3 (medians), simulated IMUs 1 to 1.5"),
      userKey("accel_bias_prior", &o->accel_bias_prior, {1e-6, 10.0}, "m/s^2",
              "standard deviation of the accelerometer bias before any data; 0.1 is the turn-on "
              "bias of a MEMS sensor"),
      userKey("gyro_bias_prior", &o->gyro_bias_prior, {1e-6, 10.0}, "rad/s",
              "standard deviation of the gyroscope bias before any data"),
  };
}

OptionTable optionTable(VanishingPointOptions* o) {
  return {
      advancedKey("vote_threshold_deg", &o->vote_threshold_deg, {0.1, 20.0}, "deg",
                  "a line votes for directions this close to its plane"),
      advancedKey(
          "inlier_threshold_deg", &o->inlier_threshold_deg, {0.1, 20.0}, "deg",
          "a line this close belongs to the vanishing point (t_in of the paper). At 2 deg a "
          "quarter of clutter among the lines doubles the squared error, at 1 deg it adds a fifth"),
      advancedKey("min_inliers", &o->min_inliers, {2, 1000}, "",
                  "fewer lines make no vanishing point. Among 25 lines without a common direction "
                  "four meet by chance nine times in ten, eight once in thirty"),
      advancedKey("match_threshold_deg", &o->match_threshold_deg, {0.1, 45.0}, "deg",
                  "maximum angle between the direction predicted by the gyroscope and the observed "
                  "one of the same vanishing point"),
  };
}

OptionTable optionTable(RefinementOptions* o) {
  return {
      advancedKey("use_lines", &o->use_lines, "line residuals (ablation)"),
      advancedKey("estimate_accel_bias", &o->estimate_accel_bias,
                  "0: the accelerometer bias is held at what is known of it, or zero (ablation)"),
      advancedKey("max_iterations", &o->max_iterations, {0, 1000}, "",
                  "Levenberg-Marquardt steps of one minimisation, refused ones included"),
      advancedKey("tolerance", &o->tolerance, {1e-30, 100.0}, "sigma^2",
                  "squared length of a step, in standard deviations of the state, that ends the "
                  "minimisation"),
      advancedKey("cauchy_sigmas", &o->cauchy_sigmas, {0.5, 1e6}, "sigma",
                  "residual beyond which it loses weight"),
      advancedKey("min_sigma_px", &o->min_sigma_px, {0.01, 10.0}, "px",
                  "minimum of the estimated noise of a point: tracks drift together, which their "
                  "scatter does not show. Those of the front end have errors of 0.13 to 0.22 px "
                  "between keyframes"),
      advancedKey("reject_sigmas", &o->reject_sigmas, {1.0, 100.0}, "sigma",
                  "observations beyond are removed before the second solve"),
      advancedKey("suspicious_chi2", &o->suspicious_chi2, {0.0, 1e6}, "",
                  "visual chi-square per degree of freedom above which other minima are searched. "
                  "Correct ones have 0.6 to 1.1"),
  };
}

OptionTable optionTable(SlimOptions* o) {
  return {
      advancedKey("vanishing_points", &o->vanishing_points,
                  "vanishing points in the gyroscope bias (ablation)"),
      advancedKey("prune_tracks", &o->prune_tracks,
                  "remove tracks that contradict the consensus bias or are static in the image of "
                  "a turning "
                  "camera (ablation)"),
      advancedKey("prune_lines", &o->prune_lines,
                  "cut line tracks that contradict the start (ablation)"),
      advancedKey("refine", &o->refine, "0: the start is the estimate (ablation)"),
      advancedKey("start_from_rest", &o->start_from_rest,
                  "after at least 1 s at rest the first motion is solved with zero velocity, "
                  "gravity and gyroscope bias of that rest as a prior; off: from the motion alone"),
  };
}

namespace {

// Gates on the motion, whatever the method made of it.
OptionTable motionGateTable(GateOptions* o) {
  return {
      userKey("min_parallax_px", &o->min_parallax_px, {0.0, 1e3}, "px",
              "minimum of the median track motion after the rotation is removed: translation. "
              "Tracks over fewer than nine keyframes average less noise and need more"),
      userKey("min_excitation", &o->min_excitation, {0.0, 100.0}, "m/s^2",
              "minimum rms deviation of the specific force from its mean over the window; at "
              "constant velocity the scale is not observable"),
  };
}

// Gates on the estimate and the calibration that `slim` has.
OptionTable slimGateTable(GateOptions* o) {
  return {
      advancedKey(
          "max_chi2", &o->max_chi2, {0.1, 1e6}, "",
          "maximum visual chi-square per degree of freedom at the noise of the tracks, before "
          "rejection. Incorrect minima have 1.5 to 30"),
      advancedKey(
          "max_inertial_chi2", &o->max_inertial_chi2, {0.0, 1e6}, "",
          "maximum cost of IMU factors and bias priors per residual row; the assumed noise "
          "predicts 1. Correct windows of ten keyframes have 0.16 on recorded EuRoC flights "
          "(median; 99 % below 0.66) and 0.38 on hand-held images (0.64), shorter ones up to 0.8 "
          "with a td error of 20 ms"),
      advancedKey("min_inlier_fraction", &o->min_inlier_fraction, {0.0, 1.0}, "",
                  "minimum fraction of the point observations left after pruning and rejection"),
      userKey("max_extrinsic_error_deg", &o->max_extrinsic_error_deg, {0.0, 180.0}, "deg",
              "maximum estimated error of the extrinsic rotation, less 2.5 standard deviations; "
              "errors up to 10 deg are estimated reliably"),
      userKey("max_td_error_s", &o->max_td_error_s, {0.0, 1.0}, "s",
              "the same of the time offset between camera and IMU; errors up to 50 ms are "
              "estimated reliably"),
      advancedKey("max_extrinsic_sigma_deg", &o->max_extrinsic_sigma_deg, {0.01, 180.0}, "deg",
                  "maximum standard deviation of an extrinsic rotation that was unknown; above it "
                  "the status is too_little_excitation. With 2, one estimate in four has an error "
                  "above 1 deg; with 0.5, one in twenty"),
  };
}

}  // namespace

OptionTable optionTable(GateOptions* o) {
  const OptionWord mode =
      wordOption<GateMode>(&o->mode, {GateMode::kOwn, GateMode::kOn, GateMode::kOff});
  OptionTable table = {
      advancedKey(
          "mode", mode,
          "own: as the method was published, on for slim and off for methods without gates; "
          "on: enforced for every method; off: only reported"),
  };
  appendSection("", motionGateTable(o), {}, &table);
  const OptionTable of_scale = {
      userKey("max_scale_sigma", &o->max_scale_sigma, {0.0, 10.0}, "",
              "maximum relative standard deviation of the scale in a full window (0.9 of "
              "window.max_span_s or longer): an error of 25 % is beyond three of them"),
      userKey("max_scale_sigma_expanding", &o->max_scale_sigma_expanding, {0.0, 10.0}, "",
              "the same in a window that is not full yet; lower, because solving at every image "
              "accepts the first estimate under the bound"),
      advancedKey(
          "max_scale_sigma_fixed_size", &o->max_scale_sigma_fixed_size, {0.0, 10.0}, "",
          "as max_scale_sigma if window.min_keyframes equals window.keyframes: such windows "
          "are solved once, when they are full"),
  };
  appendSection("", of_scale, kWithScaleSigma, &table);
  appendSection("", slimGateTable(o), kSlim, &table);
  return table;
}

OptionTable optionTable(ProvisionalOptions* o) {
  return {
      userKey("enabled", &o->enabled,
              "1: also return provisional states with a covariance before the scale is known, from "
              "0.2 s on (status provisional), for estimators that take a prior"),
      advancedKey("max_velocity_sigma", &o->max_velocity_sigma, {0.0, 100.0}, "m/s",
                  "maximum standard deviation of the newest velocity along its worst axis. An "
                  "estimator recovers from initial velocity errors below 1 m/s"),
      advancedKey("max_tilt_sigma_deg", &o->max_tilt_sigma_deg, {0.0, 90.0}, "deg",
                  "the same of the newest attitude against gravity"),
      advancedKey(
          "max_scale_sigma", &o->max_scale_sigma, {0.0, 10.0}, "",
          "maximum standard deviation of the logarithm of the scale; beyond, the priors dominate "
          "and draw the mean to zero"),
      advancedKey("speed_prior", &o->speed_prior, {0.01, 1e3}, "m/s",
                  "standard deviation of a velocity before any data, per axis; raise it for fast "
                  "vehicles"),
  };
}

OptionTable optionTable(WorkLimits* o) {
  return {
      userKey("max_solve_ms", &o->max_solve_ms, {0.0, 1e6}, "ms",
              "processor time of one solve, all of its searches together; at the limit it returns "
              "what is certain by then, else the status time_limit. 0: no limit"),
      advancedKey(
          "work_per_ms", &o->work_per_ms, {-1.0, 1e9}, "",
          "units of work that the processor does in a millisecond; 0: 1000, as a desktop does, so "
          "that equal data give equal results; negative: measured once per process, which patched "
          "hosts and nodes do in place of 0"),
  };
}

OptionTable optionTable(InitializerOptions* o) {
  OptionTable table;
  appendSection("imu", optionTable(&o->imu), {}, &table);
  appendSection("window", optionTable(&o->window), {}, &table);
  appendSection("inertial", optionTable(&o->inertial), kSlim, &table);
  appendSection("gates", optionTable(&o->gates), {}, &table);
  appendSection("vanishing_point", optionTable(&o->vanishing_point), {"slim", "slim-paper"},
                &table);
  appendSection("refinement", optionTable(&o->refinement), kSlim, &table);
  appendSection("slim", optionTable(&o->slim), kSlim, &table);
  appendSection("provisional", optionTable(&o->provisional), kSlim, &table);
  appendSection("limits", optionTable(&o->limits), kSlim, &table);
  return table;
}

OptionTable optionTable(Calibration* c) {
  return {
      userKey("sigma_px", &c->sigma_px, {0.0, 20.0}, "px",
              "standard deviation of a tracked point; 0: measured in every window"),
      userKey("sigma_line_px", &c->sigma_line_px, {0.0, 20.0}, "px",
              "standard deviation of the end of a line segment, across the segment; 0: 7/6 of that "
              "of a point"),
  };
}

OptionTable optionTable(CalibrationSigmas* s) {
  return {
      userKey("rotation_deg", &s->rotation_deg, {0.0, 180.0}, "deg",
              "standard deviation of extrinsicRotation, per axis; 90 or more: unknown. "
              "estimate_extrinsic 1 and 2 set it to 5 and 180; a value here replaces theirs"),
      userKey("translation_m", &s->translation_m, {0.0, 1.0}, "m",
              "the same of extrinsicTranslation; estimate_extrinsic sets it to 0.05"),
      userKey("td_s", &s->td_s, {0.0, 0.5}, "s", "the same of td; estimate_td sets it to 0.03"),
      userKey(
          "readout_s", &s->readout_s, {0.0, 0.1}, "s",
          "the same of rolling_shutter_tr; a readout that the images contradict is replaced by the "
          "measured one, a global shutter too; 0: exact"),
  };
}

OptionTable optionTable(ImuNoise* n) {
  return {
      userKey("gyro_density", &n->gyro_density, {1e-8, 1.0}, "rad/s/sqrt(Hz)",
              "white noise of the gyroscope from its data sheet, not gyr_n; the default is EuRoC's "
              "ADIS16448"),
      userKey(
          "accel_density", &n->accel_density, {1e-7, 10.0}, "m/s^2/sqrt(Hz)",
          "white noise of the accelerometer from its data sheet, not acc_n; the default likewise"),
  };
}

OptionTable optionTable(ImuLimits* l) {
  return {
      userKey("max_accel", &l->max_accel, {19.6, HUGE_VAL}, "m/s^2",
              "samples with more on an axis are discarded and counted; 160 is just above 16 g. "
              "Values below 2 g are refused: such a limit was given in g"),
      userKey("max_gyro", &l->max_gyro, {2.1, HUGE_VAL}, "rad/s",
              "the same; 35 is just above 2000 deg/s"),
  };
}

double WindowOptions::fullSpan() const {
  return std::max(max_span_s, (keyframes - 1) * min_interval_s);
}

std::string WindowOptions::validate() const {
  return RangeCheck::of(*this)
      .ordered("min_keyframes", min_keyframes, "keyframes", keyframes)
      .ordered("max_span_s", max_span_s, "buffer_s", buffer_s)
      // Frames come at their own pace, so that keyframes lie up to twice as far apart.
      .ordered("twice the minimum length of a full window", 2.0 * (keyframes - 1) * min_interval_s,
               "buffer_s", buffer_s)
      .message();
}

std::string InitializerOptions::validate() const {
  RangeCheck check = RangeCheck::of(*this);
  check.nested("window", window.validate());
  // No sensor in motion is better than its data sheet.
  for (const auto& [name, factor] :
       {std::make_pair("accel_noise_factor", inertial.accel_noise_factor),
        std::make_pair("gyro_noise_factor", inertial.gyro_noise_factor)}) {
    if (factor <= 0.0 || factor >= 1.0) continue;
    check.nested("inertial", text(name, " is ", factor, ", must be 0 (measured) or at least 1"));
  }
  return check.message();
}

}  // namespace slim_init
