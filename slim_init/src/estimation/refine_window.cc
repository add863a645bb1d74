// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/refine_window.h"

#include <algorithm>
#include <cmath>

#include "estimation/visual_inertial_problem.h"
#include "geometry/robust.h"
#include "imu/imu_quality.h"
#include "rotation/keyframe_pairs.h"

namespace slim_init {
namespace {

// Tolerance of the first minimisation, as a factor on that of the second, which follows from there:
// of the first only the residuals count.
constexpr double kRoughness = 10.0;
// Median of the length of a 2-vector of independent unit Gaussians, sqrt(2 ln 2).
constexpr double kRayleighMedian = 1.17741;
// Median of the larger of two independent unit |Gaussians|.
constexpr double kMaxOfTwoMedian = 1.05;
// First-order biases are exact enough below this [rad/s].
constexpr double kRelinearizeGyro = 5e-3;
// Largest factor on the density of the gyroscope: with 10 the same of 96 starts with errors of its
// scale, axes and stamps are accepted. What is worse is left to the gates.
constexpr double kMostGyroNoise = 3.0;

// The end of a descent.
struct Descent {
  RefinedWindow reached;  // valid if the descent was
  MapResiduals residuals;
  bool fits = false;  // a minimum, and it can be the correct one
};

Descent descend(const WindowState& start, const RefinementOptions& options,
                VisualInertialProblem* map) {
  Descent out;
  RefinedWindow& reached = out.reached;
  reached.state = start;
  const MapSummary summary =
      map->minimize(options.max_iterations, kRoughness * options.tolerance, &reached.state);
  reached.valid = summary.valid;
  if (!reached.valid) return out;
  out.residuals = map->residuals();
  reached.cost = summary.cost;
  reached.chi2 = summary.visual_cost / std::max(map->visualDof(), 1);
  out.fits = summary.converged && reached.chi2 <= options.suspicious_chi2;
  return out;
}

// Of the gyroscope, as a factor on what is assumed; the bias takes one of the rotations.
double gyroNoise(const MapCost& cost, int keyframes) {
  const double rotations = std::max(keyframes - 2.0, 1.0);
  return std::clamp(std::sqrt(cost.rotation_cost / (3.0 * rotations)), 1.0, kMostGyroNoise);
}

// `map` is left there.
Descent lowerMinimum(const WindowState& start, const OtherStart& otherStart,
                     const RefinementInput& input, VisualInertialProblem* map) {
  const double before = input.budget.used();
  Descent first = descend(start, input.options, map);
  if (first.fits || !otherStart) return first;
  // The second solve is left as much work as the first one.
  const WorkBudget::Share share(1.0, &input.budget, input.budget.used() - before);
  const std::optional<WindowState> other = otherStart();
  if (!other) return first;
  Descent second = descend(*other, input.options, map);
  const bool lower =
      second.reached.valid && (!first.reached.valid || second.reached.cost < first.reached.cost);
  return lower ? second : descend(first.reached.state, input.options, map);
}

// Standard deviation by the lengths of residuals [rad], of which unit Gaussians have this median
// (docs/derivation.md, 4.9); `before` where they are few.
double noiseOf(const std::vector<double>& residuals, double unit_median, double fitted,
               double before) {
  if (static_cast<int>(residuals.size()) < kFewestForSpread) return before;
  // Fitted unknowns shrink them; half the rows are left at the least.
  const double rows = 2.0 * residuals.size();
  return median(residuals) / unit_median * std::sqrt(rows / std::max(rows - fitted, 0.5 * rows));
}

}  // namespace

std::vector<Preintegration> preintegrateInflated(const InitWindow& window,
                                                 const Eigen::Vector3d& gyro_bias,
                                                 const Eigen::Vector3d& accel_bias,
                                                 const InertialOptions& inertial, double td_shift,
                                                 double gyro_noise) {
  ImuNoise noise = assumedImuNoise(window, inertial);
  noise.gyro_density *= gyro_noise;
  return preintegrateWindow(window, {gyro_bias, accel_bias}, noise, td_shift,
                            PreintegrationParts::kWithCovariance);
}

RefinedWindow refineWindow(const RefinementInput& input, const std::vector<Track>& lines,
                           const WindowState& start, const OtherStart& other) {
  const InitWindow& window = input.tracks;
  const RefinementOptions& options = input.options;
  std::vector<Preintegration> pre = input.pre;
  const double focal = window.calibration().focal_px;
  VisualInertialProblem map(window, lines, pre, options, input.inertial, input.priors);
  map.setBudget(&input.budget);
  const int handed_in = map.pointViews();

  const Descent first = lowerMinimum(start, other, input, &map);
  RefinedWindow out = first.reached;
  if (!out.valid) return out;
  out.valid = false;

  // Noise from the residuals, then without what is beyond it.
  const MapResiduals& residuals = first.residuals;
  const double floor = options.min_sigma_px / focal;
  const double sigma_point = std::max(noiseOf(residuals.points, kRayleighMedian,
                                              3.0 * residuals.point_tracks + 6.0, map.sigmaPoint()),
                                      floor);
  const double sigma_line = std::max(
      noiseOf(residuals.lines, kMaxOfTwoMedian, 4.0 * residuals.line_tracks, map.sigmaLine()),
      floor);
  const int behind = map.reject(residuals, options.reject_sigmas * sigma_point,
                                options.reject_sigmas * sigma_line);
  out.behind_fraction = static_cast<double>(behind) / std::max(handed_in, 1);
  map.setNoise(sigma_point, sigma_line);
  const double td_shift = coveredShift(window, out.state.rig.dtd);
  const auto integrate = [&](double gyro_noise) {
    pre = preintegrateInflated(window, out.state.gyro_bias, out.state.accel_bias, input.inertial,
                               td_shift, gyro_noise);
    map.setPreintegrated(td_shift);
  };
  if (std::abs(td_shift) > kRelinearizeTolerance ||
      (out.state.gyro_bias - pre.front().gyro_bias).norm() > kRelinearizeGyro) {
    integrate(1.0);
  }
  MapSummary summary = map.resume(options.max_iterations, options.tolerance, &out.state);
  // At a noise of the images that is too large they would follow whatever the gyroscope says.
  const double gyro_noise = gyroNoise(summary, window.size());
  if (summary.valid && gyro_noise > 1.0) {
    integrate(gyro_noise);
    summary = map.resume(options.max_iterations, options.tolerance, &out.state);
  }
  if (!summary.valid) return out;

  out.inlier_fraction = static_cast<double>(map.pointViews()) / std::max(handed_in, 1);
  out.inertial_chi2 = summary.inertial_cost / (9.0 * (window.size() - 1));
  out.sigma_px = sigma_point * focal;
  out.sigma_line_px = sigma_line * focal;
  out.speeds = map.speedUse();
  out.information = map.information();
  out.visual_information = map.visualInformation();
  out.visual_gradient = map.visualGradient();
  out.valid = true;
  return out;
}

}  // namespace slim_init
