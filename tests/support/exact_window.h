// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Windows whose inertial side is exact: the truth is what the preintegrator makes of the samples,
// so that a noise-free solver has to recover it to rounding.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

#include "slim_init/init_window.h"
#include "slim_init/types.h"

namespace slim_init {

/// kFromRest stands still for ExactWindowOptions::rest_s and is then excited.
enum class Motion { kExcited, kHover, kPureRotation, kConstantVelocity, kFromRest };

inline constexpr CalibrationSigmas kExactCalibration = {0.0, 0.0, 0.0, 0.0};

struct ExactWindowOptions {
  Motion motion = Motion::kExcited;
  double rest_s = 1.5;  ///< of kFromRest [s]
  /// In b at time t [rad/s], in place of that of the motion.
  std::function<Eigen::Vector3d(double t)> angular_rate;
  int keyframes = 10;
  double interval_s = 0.25;
  /// Keyframes lie this long after an IMU sample: 0 hits samples, 0.0017 falls between two.
  double keyframe_offset_s = 0.0017;
  double imu_rate_hz = 200.0;
  int points = 100;
  int lines = 25;
  /// All lines vertical: the vanishing point is then exact. Else a fifth each is horizontal and
  /// without direction, and some of those pass near enough to the vertical VP to bend it.
  bool parallel_lines_only = false;
  Eigen::Vector3d gyro_bias = Eigen::Vector3d(-0.0022, 0.0208, 0.0765);  ///< [rad/s]
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();                  ///< [m/s^2]
  double pixel_noise = 0.0;  ///< on points and line end points [px]
  /// The noise as an angle, of equal size for every bearing, as the estimators model it. Else in
  /// the image plane, where a pixel off the axis is a smaller angle.
  bool angular_noise = false;
  bool imu_noise = false;  ///< white noise at the calibration's densities
  double yaw_rad = 0.4;    ///< of the first body
  Eigen::Vector3d origin = Eigen::Vector3d(1.0, -2.0, 0.5);  ///< of the first body [m]
  /// The calibration handed in is off by a draw with these standard deviations.
  CalibrationSigmas calibration_error = kExactCalibration;
  CalibrationSigmas calibration_sigmas;  ///< handed in with it
  /// Rolling shutter: the row of a point decides when it is seen; row times and calibration say so.
  double readout_s = 0.0;
  unsigned seed = 1;
};

inline ExactWindowOptions seeded(unsigned seed, double pixel_noise = 0.0) {
  ExactWindowOptions options;
  options.seed = seed;
  options.pixel_noise = pixel_noise;
  return options;
}

/// Keyframes as a host has them.
inline ExactWindowOptions atTenHertz(int keyframes) {
  ExactWindowOptions options;
  options.keyframes = keyframes;
  options.interval_s = 0.1;
  return options;
}

struct ExactWindow {
  Calibration calibration;       ///< handed in
  Calibration true_calibration;  ///< td included: the exposures are at stamp + td
  std::vector<ImuSample> imu;
  std::vector<FrameObservation> keyframes;
  std::vector<NavState> truth;  ///< one per keyframe, world z up
  std::shared_ptr<const InitWindow> window;
};

/// EuRoC's cam0 extrinsics, orthonormalised.
Calibration eurocCalibration();

/// Options of a window that is a draw from what the estimators assume: 0.6 px as an angle, IMU
/// noise at the calibration's densities, an accelerometer bias with standard deviation
/// `accel_bias_sigma` [m/s^2] per axis. Over many seeds, errors have the reported covariance.
ExactWindowOptions drawnFromTheModel(unsigned seed, double accel_bias_sigma);

/// drawnFromTheModel() with a calibration off by what its standard deviations say.
ExactWindowOptions drawnWithCalibration(unsigned seed, double accel_bias_sigma);

/// drawnFromTheModel() with a calibration that is known to be exact.
ExactWindowOptions drawnWithExactCalibration(unsigned seed, double accel_bias_sigma);

/// The same with an accelerometer bias of 0.05 m/s^2 and keyframes at 10 Hz, as from a stream.
ExactWindowOptions drawnStream(unsigned seed, Motion motion, int keyframes);

/// Makes a window; never fails for sensible options.
ExactWindow makeExactWindow(const ExactWindowOptions& options);

/// The same with noise: 0.6 px, IMU noise at the calibration's densities.
ExactWindow noisyWindow(ExactWindowOptions options = ExactWindowOptions());
ExactWindow noisyWindow(Motion motion, unsigned seed);

/// InitWindow::create(); throws if there is no window.
std::shared_ptr<const InitWindow> madeWindow(const Calibration& calibration,
                                             const std::vector<FrameObservation>& keyframes,
                                             const std::vector<ImuSample>& imu,
                                             const std::vector<SpeedSample>& speeds = {});
/// The same of a window that was changed, and of other keyframes with its calibration and IMU data.
std::shared_ptr<const InitWindow> windowOf(const ExactWindow& exact);
std::shared_ptr<const InitWindow> windowOf(const ExactWindow& exact,
                                           const std::vector<FrameObservation>& keyframes);

/// The window as a user with a wrong calibration hands it in: the true extrinsic is
/// R_b_c Exp(turn), the true time offset `td` [s] more than the one assumed. Where the IMU data do
/// not reach that far, the outermost samples are held.
std::shared_ptr<const InitWindow> miscalibrated(const ExactWindow& exact,
                                                const Eigen::Vector3d& turn, double td,
                                                const CalibrationSigmas& sigmas);

/// Samples or frames without those between two times [s].
template <typename Timed>
std::vector<Timed> withGap(std::vector<Timed> all, double from, double to) {
  const auto inside = [=](const Timed& one) { return one.t > from && one.t < to; };
  all.erase(std::remove_if(all.begin(), all.end(), inside), all.end());
  return all;
}

/// The first points slide through the image, 8 px a keyframe, each its own way.
ExactWindow withSlidingPoints(ExactWindow exact, int points);

/// Moves an observation in the image plane.
void shift(double dx_px, double dy_px, double focal_px, PointObservation* point);

/// Spread of the estimated positions over the spread of the true ones, minus 1.
double scaleError(const std::vector<NavState>& estimate, const std::vector<NavState>& truth);

/// Angle between estimated and true gravity in the first body frame [rad].
double gravityErrorRad(const Eigen::Vector3d& gravity_b0, const NavState& first_truth);

}  // namespace slim_init
