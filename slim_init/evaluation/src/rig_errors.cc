// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/rig_errors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "reference_so3.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/evaluation/truth.h"
#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

constexpr double kDegToRad = 0.017453292519943295;
// Part of a sample interval by which a stamp may be off: less than half, so that order stays.
constexpr double kMaxJitterIntervals = 0.45;
// IMUs run a little slow: the rate asked for may be above that of the data by so much.
constexpr double kRateTolerance = 1.05;

/// What a draw is for: streams are independent of each other.
enum class Stream : std::uint64_t { kTrial = 1, kJitter = 2, kDropout = 3 };

/// Random numbers that are the same on every machine: the distributions of the standard library are
/// not.
class Draws {
 public:
  Draws(unsigned seed, Stream stream, std::int64_t index)
      : engine_(seed + (static_cast<std::uint64_t>(stream) << 32) +
                static_cast<std::uint64_t>(index + 1) * 0x9E3779B97F4A7C15ULL) {}

  /// In [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// Standard normal (Box and Muller 1958).
  double gaussian() {
    constexpr double kTwoPi = 6.283185307179586;
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    return radius * std::cos(kTwoPi * uniform());
  }
  /// Unit vector, all directions alike.
  Eigen::Vector3d direction() {
    Eigen::Vector3d v;
    do {
      v.x() = gaussian();
      v.y() = gaussian();
      v.z() = gaussian();
    } while (!(v.norm() > 1e-6));
    return v.normalized();
  }

 private:
  std::mt19937_64 engine_;
};

double medianInterval(const std::vector<ImuSample>& imu) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < imu.size(); ++i) intervals.push_back(imu[i].t - imu[i - 1].t);
  return median(std::move(intervals));
}

/// The end of the step between two samples in which t lies.
std::vector<ImuSample>::const_iterator sampleAfter(const std::vector<ImuSample>& imu, double t) {
  return std::upper_bound(imu.begin() + 1, imu.end() - 1, t,
                          [](double time, const ImuSample& s) { return time < s.t; });
}

/// The mean over [t - half, t + half] of the samples, linear between them, as a sensor with such an
/// averaging filter gives it at t; their value at t for half = 0. False across a step between them
/// that is longer than `max_step` [s].
bool meanAt(const std::vector<ImuSample>& imu, double t, double half, double max_step,
            ImuSample* sample) {
  if (half == 0.0) {
    const auto after = sampleAfter(imu, t), before = after - 1;
    *sample = host_health::between(*before, *after, t);
    return after->t - before->t <= max_step;
  }
  // Rounding must not lead out of the recording.
  const double begin = std::max(imu.front().t, t - half), end = std::min(imu.back().t, t + half);
  std::vector<InertialStep> steps;
  if (!inertialSteps(imu, begin, end, max_step, &steps)) return false;
  sample->t = t;
  for (const InertialStep& step : steps) {
    sample->gyro += step.dt / (end - begin) * step.gyro;
    sample->accel += step.dt / (end - begin) * step.accel;
  }
  return true;
}

/// At equal intervals, each the mean over an interval around it; across a gap of the recording
/// there are no samples.
std::vector<ImuSample> resampled(const std::vector<ImuSample>& imu, double interval, bool averages,
                                 double max_step) {
  std::vector<ImuSample> samples;
  for (std::int64_t k = 0;; ++k) {
    const double t = imu.front().t + static_cast<double>(k) * interval;
    if (t > imu.back().t) break;
    // Shorter at both ends of the recording, so that it stays centred.
    const double half =
        averages ? std::min({0.5 * interval, t - imu.front().t, imu.back().t - t}) : 0.0;
    ImuSample sample;
    if (meanAt(imu, t, half, max_step, &sample)) {
      samples.push_back(sample);
    } else {  // a gap may be one of decades
      const double next = sampleAfter(imu, t)->t - imu.front().t;
      k = std::max(k, static_cast<std::int64_t>(next / interval) - 1);
    }
  }
  return samples;
}

/// A true calibration with a readout time, and one left of it: else there is nothing to be wrong.
std::string checkRows(const RigErrors& errors, const Calibration& truth) {
  if (errors.readout_s == 0.0) return "";
  if (!(truth.readout_s > 0.0)) {
    return "the camera has a global shutter (a readout time of 0 s), so that its readout time "
           "cannot be incorrect";
  }
  if (truth.readout_s + errors.readout_s >= 0.0) return "";
  return text("readout_s is ", errors.readout_s, ", must be at least ", -truth.readout_s,
              ", the camera's own readout time with its sign turned");
}

}  // namespace

bool RigErrors::disturbsImu() const {
  return imu_rate_hz > 0.0 || imu_jitter_s > 0.0 || imu_dropout > 0.0;
}

bool RigErrors::any() const {
  return td_s != 0.0 || extrinsic_deg != 0.0 || readout_s != 0.0 || disturbsImu();
}

Calibration assumedCalibration(const Calibration& truth, const RigErrors& errors, int trial) {
  Calibration assumed = truth;
  const bool drawn = errors.random && trial != kAllTrials;
  if (drawn || !errors.random) {
    Draws draws(errors.seed, Stream::kTrial, drawn ? trial : kAllTrials);
    const double td = drawn ? std::abs(errors.td_s) * (2.0 * draws.uniform() - 1.0) : errors.td_s;
    const double deg = errors.extrinsic_deg * (drawn ? draws.uniform() : 1.0);
    assumed.td -= td;
    if (deg > 0.0) {
      assumed.R_b_c = truth.R_b_c * reference::expSo3(kDegToRad * deg * draws.direction());
    }
  }
  assumed.readout_s = truth.readout_s + errors.readout_s;
  return assumed;
}

std::string disturbImu(const RigErrors& errors, std::vector<ImuSample>* imu) {
  if (!errors.disturbsImu() || imu->size() < 2) return "";
  double interval = medianInterval(*imu);
  if (errors.imu_rate_hz > 0.0) {
    if (errors.imu_rate_hz * interval > kRateTolerance) {
      return text("--imu-rate is ", errors.imu_rate_hz, ", must be at most ", 1.0 / interval,
                  ", the rate of the IMU data");
    }
    const double step = 1.0 / errors.imu_rate_hz;
    // A sample or two may be missing in a recording; a longer step is a gap and stays one.
    *imu = resampled(*imu, step, step > kRateTolerance * interval, std::max(3.0 * interval, step));
    interval = step;
  }
  Draws jitter(errors.seed, Stream::kJitter, 0), dropout(errors.seed, Stream::kDropout, 0);
  const double most = kMaxJitterIntervals * interval;
  std::vector<ImuSample> kept;
  for (ImuSample& sample : *imu) {
    const double error = errors.imu_jitter_s * jitter.gaussian();
    sample.t += std::clamp(error, -most, most);
    if (dropout.uniform() < errors.imu_dropout) continue;
    // Where the recorded interval was shorter than the median one.
    if (kept.empty() || sample.t > kept.back().t) kept.push_back(sample);
  }
  *imu = std::move(kept);
  return "";
}

std::string applyRigErrors(const RigErrors& errors, Sequence* sequence) {
  const Calibration truth = sequence->trueCalibration();
  std::string sentence = checkRows(errors, truth);
  if (sentence.empty()) sentence = disturbImu(errors, &sequence->imu);
  if (!sentence.empty()) return sentence;
  const Calibration assumed = assumedCalibration(truth, errors, kAllTrials);
  if (sentence = assumed.validate(); !sentence.empty()) {
    return "the calibration with its errors: " + sentence;
  }
  sequence->true_calibration = truth;
  sequence->calibration = assumed;
  return "";
}

}  // namespace slim_init::evaluation
