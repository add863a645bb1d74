// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// IMU data judged sample by sample, before the next image: which samples may be integrated, and
// over which intervals the motion of the body is not known.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "slim_init/stream_check.h"
#include "slim_init/types.h"

namespace slim_init::host_health {

/// Motion of a body while the IMU says nothing, standard deviations.
constexpr double kUnknownAccel = 3.0;  ///< [m/s^2]
constexpr double kUnknownGyro = 1.0;   ///< [rad/s]

/// An interval without a usable sample, or with samples that are worth less than others.
struct ImuDamage {
  double first = 0.0;    ///< the last good sample before [s]
  double last = 0.0;     ///< the first good one after; the newest sample while it goes on [s]
  bool open = false;     ///< it still goes on
  bool bridged = false;  ///< short enough to be used all the same
  /// The samples are used as measured: the innovation test or their noise speaks against them.
  bool measured = false;
  /// Error of the samples in use, constant over the interval, standard deviation per axis.
  double accel_sigma = kUnknownAccel;  ///< [m/s^2]
  double gyro_sigma = kUnknownGyro;    ///< [rad/s]

  /// Only the accelerometer was damaged: the rates in it are as measured.
  bool gyroKnown() const { return gyro_sigma == 0.0; }
};

/// Standard deviation of one axis of one sample.
struct ImuSampleNoise {
  double accel = 0.0;  ///< [m/s^2]
  double gyro = 0.0;   ///< [rad/s]
};

/// The median of one value or more; of an even number the larger of the two in the middle.
double middle(std::vector<double> values);

/// Discards samples that the body cannot have felt: beyond the limits of the sensor or far from the
/// samples before them, and samples with an axis that repeats its value after others that did not:
/// the sensor is frozen or at the end of its range, which the first four repeats do not show. At
/// rest this does not hold for a sensor whose steps hide its noise.
/// Discarded samples are replaced by interpolation, in samples(). If that took at most kBridge it
/// is bridged for use as well, with interpolated samples 0.045 s apart, or all of them if rates are
/// known for longer. Discarded samples that a landing explains widen the interval by their own
/// size, others and missing ones by kUnknownAccel and kUnknownGyro. A step that goes on for longer
/// than 0.5 s is a motion. Errors that single samples do not show are left to the innovation test
/// (innovation.h), which reports them to addDamage().
///
/// Noise above three times the median noise of the last 5 s is damage with the size of that noise;
/// the samples stay in samples(), and above five times it they are not returned for use.
/// Not thread-safe.
///
/// The bounds of a step are twice those of 470 s of EuRoC flight, 38 m/s^2 and 3.4 rad/s from the
/// median of the 0.1 s before.
class ImuScreen {
 public:
  static constexpr double kBridge = 0.1;  ///< [s]
  static constexpr double kKept = 10.0;   ///< [s] of samples and damage

  explicit ImuScreen(const ImuLimits& limits) : limits_(limits) {}

  /// Returns the samples to be used, oldest first: none, or `sample` after those that bridge the
  /// interval before it. `sample` is finite and after the one before it.
  std::vector<ImuSample> add(const ImuSample& sample);

  /// IInitializer::addImu() or KeyframeWindow::addImu().
  using Receiver = std::function<AddStatus(const ImuSample&)>;
  /// add() in front of an initializer or a keyframe window, the same for all of their users: any
  /// sample, whose stamp and limits the receiver judges. What may be used of it is passed on.
  /// Returns the receiver's status of `sample`, kGlitch if the screen has discarded it. When the
  /// receiver restarts for another reason the caller calls reset().
  AddStatus pass(const ImuSample& sample, const Receiver& receiver);
  /// Samples that pass() has discarded, besides the glitches of the receiver's StreamCounts::imu;
  /// kept by reset().
  std::int64_t discarded() const { return discarded_; }
  /// Stamp of the newest sample that pass() has received [s]; NaN: none.
  double newest() const { return newest_; }

  /// Usable samples, and interpolated ones over the damage that has ended.
  const std::deque<ImuSample>& samples() const { return samples_; }
  /// samples(), and while damage goes on the last usable sample held up to `t` [s].
  std::deque<ImuSample> heldUntil(double t) const;
  /// Ascending by their ends; damage that goes on is the last.
  const std::deque<ImuDamage>& damage() const { return damage_; }
  /// Records damage from outside: samples from `first` to `last` [s] have errors of these sizes
  /// (standard deviation per axis, constant over the interval) [m/s^2, rad/s]; zero: none. The same
  /// interval again: the larger sizes hold. Nothing is recorded for an empty interval or a size
  /// that is negative or not finite.
  void addDamage(double first, double last, double accel_sigma, double gyro_sigma);

  void reset();

 private:
  bool isUsable(const ImuSample& sample, bool* gyro_usable);
  void countRepeats(const ImuSample& sample);
  int stuckFor(std::size_t first) const;
  void takeBack(int repeats);
  bool stands() const;
  bool isFrozen() const;
  bool isNoisy();
  ImuSampleNoise usualNoise() const;
  void widenByNoise(double begin, double end, const ImuSampleNoise& excess);
  void insertDamage(const ImuDamage& damage);
  void forgetOld(double t);
  void widenByShock(ImuDamage* open) const;
  void fill(const ImuSample& last, const ImuDamage& damage, std::vector<ImuSample>* filled) const;
  std::vector<ImuSample> bridge(const ImuDamage& damage, std::vector<ImuSample> filled) const;

  ImuLimits limits_;
  std::deque<ImuSample> samples_;
  std::deque<ImuSample> recent_;  // as measured, good or bad
  std::deque<ImuDamage> damage_;
  std::deque<ImuSample> left_out_;  // of the open damage, whose rates are known
  // Of the open damage: what its discarded samples are beyond the last usable one, integrated.
  Eigen::Vector3d discarded_accel_ = Eigen::Vector3d::Zero();  // [m/s]
  Eigen::Vector3d discarded_gyro_ = Eigen::Vector3d::Zero();   // [rad]
  std::deque<ImuSampleNoise> noise_;                           // of blocks of samples
  // Of an axis, accelerometer first: values in a row that equal the one before, their share, and by
  // how many steps of its sensor it moved in the samples before the run.
  struct Repeats {
    int in_row = 0;
    double rate = 0.0;
    double moved = 0.0;
  };
  std::array<Repeats, 6> repeats_{};
  // The smallest change of each sensor, over all axes: these may be turned against its own.
  std::array<double, 2> steps_ = {HUGE_VAL, HUGE_VAL};
  std::int64_t compared_ = 0;       // samples with the one before
  double returned_ = -1e300;        // stamp of the last sample for use [s]
  double noise_end_ = -1e300;       // of the damage by noise that may go on [s]
  double block_end_ = -1e300;       // stamp from which a block of noise_ is due [s]
  double believed_since_ = -1e300;  // samples from before are of another motion [s]
  double period_ = 0.005;           // between samples [s]
  double newest_ = kNotComputed;    // stamp, of pass() [s]
  std::int64_t discarded_ = 0;
};

}  // namespace slim_init::host_health
