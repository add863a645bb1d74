// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Plain data that goes into an initializer. Frames: b body = IMU, c camera, w world (z up).
// Full notation: docs/notation.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace slim_init {

/// Marks "not computed" or "not known" in every real-valued field of this library.
inline constexpr double kNotComputed = std::numeric_limits<double>::quiet_NaN();

/// Times that differ by less are equal [s]: a stamp in seconds since 1970 has 0.2 us of rounding.
inline constexpr double kStampRounding = 1e-6;

/// One inertial measurement.
struct ImuSample {
  double t = 0.0;                                   ///< [s], IMU clock
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< angular rate of b in b [rad/s], biased
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< specific force in b [m/s^2], biased
};

/// Track identity: equal ids in two frames mean the same physical point (or line).
using FeatureId = std::int64_t;

/// One tracked point in one image.
struct PointObservation {
  FeatureId id = -1;
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();  ///< unit ray in c, undistorted
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();     ///< raw image position [px], for display
  double row = 0.0;  ///< imageRow() of it; its exposure follows the stamp by row * readout_s
};

/// One tracked line segment in one image. The end points of a segment move along the line from
/// image to image; only the infinite line is the same.
struct LineObservation {
  FeatureId id = -1;
  Eigen::Vector3d start_bearing = Eigen::Vector3d::UnitZ();  ///< unit ray in c, undistorted
  Eigen::Vector3d end_bearing = Eigen::Vector3d::UnitZ();    ///< unit ray in c, undistorted
  Eigen::Vector2d start_pixel = Eigen::Vector2d::Zero();     ///< [px]
  Eigen::Vector2d end_pixel = Eigen::Vector2d::Zero();       ///< [px]
  double length_px = 0.0;                                    ///< segment length [px]
  double detection_confidence = 1.0;                         ///< in [0, 1], from the detector
  double match_quality = 1.0;  ///< in [0, 1], match to the previous image; 1 for a new line
  double start_row = 0.0;      ///< imageRow() of the start point
  double end_row = 0.0;        ///< the same of the end point
};

/// Everything seen in one image.
struct FrameObservation {
  double t = 0.0;  ///< image stamp [s], camera clock; see Calibration::imuTime()
  std::vector<PointObservation> points;
  std::vector<LineObservation> lines;
};

/// Continuous-time white-noise densities. These are densities, not the per-sample sigmas that
/// VINS-Mono's `acc_n`, `gyr_n` hold (docs/notation.md, "IMU noise").
struct ImuNoise {
  double gyro_density = 1.7e-4;   ///< [rad/s/sqrt(Hz)], EuRoC's ADIS16448 data sheet
  double accel_density = 2.0e-3;  ///< [m/s^2/sqrt(Hz)], EuRoC's ADIS16448 data sheet

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// How far a calibration may be off: standard deviations before any data. Zero: exact.
struct CalibrationSigmas {
  double rotation_deg = 0.25;    ///< of R_b_c, per axis [deg]; kUnknownRotationDeg or more: unknown
  double translation_m = 0.003;  ///< of t_b_c, per axis [m]
  double td_s = 0.001;           ///< of td [s]
  /// Of readout_s [s]. Zero: exact, a global shutter is one.
  double readout_s = 0.001;

  bool operator==(const CalibrationSigmas& other) const {
    return rotation_deg == other.rotation_deg && translation_m == other.translation_m &&
           td_s == other.td_s && readout_s == other.readout_s;
  }

  /// From this standard deviation on nothing is known about the extrinsic rotation [deg].
  static constexpr double kUnknownRotationDeg = 90.0;

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// What is known of the IMU's biases before the data of a window (KnownSensors).
struct ImuBiases {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< in b [rad/s]
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< in b [m/s^2]
  /// Standard deviations per axis. Above those of InertialOptions nothing is known, and they hold,
  /// about zero.
  double gyro_sigma = std::numeric_limits<double>::infinity();   ///< [rad/s]
  double accel_sigma = std::numeric_limits<double>::infinity();  ///< [m/s^2]

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// A velocity sensor on the vehicle: wheel odometry, airspeed, optical flow. Its frame s has its
/// origin in the point whose velocity is measured (the centre of the driven axle) and x forward.
struct SpeedSensor {
  bool calibrated = false;  ///< false: R_b_s and t_b_s are not known, its measurements are refused
  Eigen::Matrix3d R_b_s = Eigen::Matrix3d::Identity();  ///< sensor to body rotation
  Eigen::Vector3d t_b_s = Eigen::Vector3d::Zero();      ///< origin of s in b [m]
  /// Standard deviation of the relative error that all measurements have in common: wheel radius,
  /// wind. However many there are, they do not know the scale better than this.
  double scale_sigma = 0.02;
  /// Non-holonomic constraint for forward speeds: velocity along y and z of s is zero with this
  /// standard deviation [m/s]. Zero: no constraint.
  double lateral_sigma = 0.0;

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// One measurement of a SpeedSensor.
struct SpeedSample {
  double t = 0.0;                                      ///< [s], IMU clock
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the origin of s, in s [m/s]
  /// Of `velocity` [m^2/s^2], positive definite.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Only the x component is measured: y and z of `velocity` and their covariance are not used.
  bool forward_only = false;

  /// Forward speed [m/s] with its standard deviation [m/s].
  static SpeedSample forward(double t, double speed, double sigma);
};

/// What has to be known about the rig: extrinsics, time offset, noise.
struct Calibration {
  Eigen::Matrix3d R_b_c = Eigen::Matrix3d::Identity();  ///< camera to body rotation
  Eigen::Vector3d t_b_c = Eigen::Vector3d::Zero();      ///< camera centre in b [m]
  ImuNoise imu_noise;
  double gravity_magnitude = 9.81007;  ///< |g_w| [m/s^2]
  double focal_px = 460.0;  ///< pixels per radian at the image centre; turns pixels to angles
  /// Standard deviation of a point observation [px]; 0: measured in every window by methods that do
  /// (slim), kTypicalSigmaPx for the others.
  double sigma_px = 0.0;
  /// The same of a line end point across the line [px]; 0: kLinePerPoint times that of a point. Two
  /// views of a line always agree, so that nothing measures it before there is a trajectory.
  double sigma_line_px = 0.0;
  double td = 0.0;  ///< camera-IMU time offset: t_imu = stamp + td [s]
  /// Rolling shutter: time from the first row to the last [s]; the stamp is that of the middle row.
  /// Zero for a global shutter.
  double readout_s = 0.0;
  CalibrationSigmas sigmas;  ///< standard deviations of R_b_c, t_b_c, td and readout_s
  ImuBiases imu_biases;      ///< nothing is known of them unless somebody has measured them before
  SpeedSensor speed_sensor;  ///< of IInitializer::addSpeed()

  /// From the camera clock to the IMU clock and back [s]. Streams and messages carry image stamps;
  /// buffers, windows and states are on the IMU clock.
  double imuTime(double stamp) const { return stamp + td; }
  double imageStamp(double t_imu) const { return t_imu - td; }

  static constexpr double kTypicalSigmaPx = 0.6;  ///< of a tracker at EuRoC's camera [px]
  static constexpr double kLinePerPoint = 7.0 / 6.0;

  /// Standard deviations that hold [px], and as angles of a bearing and of a line end [rad].
  double pointSigmaPx() const { return sigma_px > 0.0 ? sigma_px : kTypicalSigmaPx; }
  double lineSigmaPx() const {
    return sigma_line_px > 0.0 ? sigma_line_px : kLinePerPoint * pointSigmaPx();
  }
  double sigmaBearing() const { return pointSigmaPx() / focal_px; }
  double sigmaLine() const { return lineSigmaPx() / focal_px; }

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Place of image row `v` in an image of `height` rows: -1/2 at the top, 1/2 at the bottom. Zero
/// where the height is not known.
inline double imageRow(double v, int height) { return height > 0 ? v / height - 0.5 : 0.0; }

/// Exposure of image row `v` relative to the middle row [s], for an image of `height` rows read out
/// in `readout_s` from top to bottom. Zero for a global shutter.
inline double rowTime(double v, int height, double readout_s) {
  return imageRow(v, height) * readout_s;
}

/// Navigation state of the body at one time, in a gravity-aligned world (z up).
struct NavState {
  double t = kNotComputed;                               ///< [s], IMU clock
  Eigen::Matrix3d R_w_b = Eigen::Matrix3d::Identity();   ///< body to world
  Eigen::Vector3d p_w_b = Eigen::Vector3d::Zero();       ///< body position in w [m]
  Eigen::Vector3d v_w_b = Eigen::Vector3d::Zero();       ///< body velocity in w [m/s]
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   ///< in b [rad/s]
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  ///< in b [m/s^2]

  /// True where time and every value are finite.
  bool isFinite() const;
};

/// A closed interval of time; NaN: empty.
struct TimeSpan {
  double first = kNotComputed;  ///< [s]
  double last = kNotComputed;   ///< [s]
};

/// A sample with an axis beyond these is a glitch of the driver or the bus and not motion: MEMS
/// IMUs of such rigs measure up to 16 g and 2000 deg/s. One such sample makes every attempt fail
/// (inertial chi-square) for as long as it is in the window; StreamCheck drops and counts it.
/// Infinity: no limit.
struct ImuLimits {
  double max_accel = 160.0;  ///< [m/s^2]
  double max_gyro = 35.0;    ///< [rad/s]

  /// False for a sample with a value that is not finite: that is another defect.
  bool exceededBy(const ImuSample& sample) const;

  /// The largest values of a sample and the limits, for a message.
  std::string describe(const ImuSample& sample) const;

  /// Returns an empty string, or a message naming the field, its value and the violated bound: no
  /// range of a MEMS sensor ends below 2 g or 125 deg/s, so that a limit given in g is refused.
  std::string validate() const;
};

/// Sets PointObservation::row of all points and LineObservation::start_row, end_row of all lines of
/// `frame` from their raw pixels (imageRow()), for an image of `height` rows [px].
inline void setRows(int height, FrameObservation* frame) {
  for (PointObservation& point : frame->points) point.row = imageRow(point.pixel.y(), height);
  for (LineObservation& line : frame->lines) {
    line.start_row = imageRow(line.start_pixel.y(), height);
    line.end_row = imageRow(line.end_pixel.y(), height);
  }
}

}  // namespace slim_init
