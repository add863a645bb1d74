// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// IMU data as they were measured, judged sample by sample: what may be integrated, and over which
// intervals nobody knows what the body did.
#pragma once

#include <deque>
#include <vector>

#include "slim_init/imu_limits.h"
#include "slim_init/types.h"

namespace slim_init::vins_adapter {

/// An interval without a usable sample.
struct ImuDamage {
  double first = 0.0;    ///< the last usable sample before [s]
  double last = 0.0;     ///< the first usable one after; the newest sample while it goes on [s]
  bool open = false;     ///< it still goes on
  bool bridged = false;  ///< short enough to be used all the same
  /// Only the accelerometer was wrong: the rates in it are as measured.
  bool gyro_known = false;
};

/// The median of one value or more; of an even number the larger of the two in the middle.
double middle(std::vector<double> values);

/// Leaves out samples that the body cannot have felt: beyond the limits of the sensor, far from the
/// samples before them, or in a stretch where neighbouring samples differ as no vibration makes
/// them. What is left out is replaced by interpolation, in samples(). Where that took at most
/// kBridge it is bridged for use as well, with interpolated samples 0.045 s apart, or all of them
/// where rates are known for longer. Missing samples are treated alike. What goes on for longer,
/// 0.5 s of a step or 3 s of such a stretch, is how this body moves and vibrates. Not thread-safe.
///
/// The bounds are twice what 470 s of EuRoC flight show: 38 m/s^2 and 3.4 rad/s from the median of
/// the 0.1 s before, and a median step of 12 m/s^2 and 0.6 rad/s between neighbours.
class ImuScreen {
 public:
  static constexpr double kBridge = 0.1;  ///< [s]
  static constexpr double kKept = 10.0;   ///< [s] of samples and damage

  explicit ImuScreen(const ImuLimits& limits) : limits_(limits) {}

  /// Returns the samples to be used, oldest first: none, or `sample` with what bridges the interval
  /// before it. `sample` is finite and after the one before it.
  std::vector<ImuSample> add(const ImuSample& sample);

  /// Usable samples, and interpolated ones over the damage that has ended.
  const std::deque<ImuSample>& samples() const { return samples_; }
  /// samples(), and while damage goes on the last usable sample held up to `t` [s].
  std::deque<ImuSample> heldUntil(double t) const;
  /// Oldest first.
  const std::deque<ImuDamage>& damage() const { return damage_; }

  void reset();

 private:
  bool isUsable(const ImuSample& sample, bool* gyro_usable);
  void fill(const ImuSample& last, const ImuDamage& damage, std::vector<ImuSample>* filled) const;
  std::vector<ImuSample> bridge(const ImuDamage& damage, std::vector<ImuSample> filled) const;

  ImuLimits limits_;
  std::deque<ImuSample> samples_;
  std::deque<ImuSample> recent_;  // as measured, good or bad
  std::deque<ImuDamage> damage_;
  std::vector<ImuSample> left_out_;  // of the open damage
  double believed_since_ = -1e300;   // samples from before are of another motion [s]
  double scattered_ = 0.0;           // neighbours have differed by too much for so long [s]
  double period_ = 0.005;            // between samples [s]
};

}  // namespace slim_init::vins_adapter
