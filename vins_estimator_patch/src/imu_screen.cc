// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "imu_screen.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace slim_init::vins_adapter {

double middle(std::vector<double> values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  return *half;
}

namespace {

// Of the newest sample from the median of the usable ones before it.
constexpr double kMaxAccelStep = 80.0;  // [m/s^2]
constexpr double kMaxGyroStep = 8.0;    // [rad/s]

// A file that allows a larger range than the default allows so much more of a step.
double stepAllowed(double step, double limit, double default_limit) {
  return step + std::max(0.0, limit - default_limit);
}

// Between neighbours; beside an accelerometer that is wrong, more says that the gyroscope is too.
constexpr double kMaxGyroJump = 2.0;  // [rad/s]
// Median distance between neighbours.
constexpr double kMaxAccelScatter = 25.0;  // [m/s^2]
constexpr double kMaxGyroScatter = 1.5;    // [rad/s]
constexpr std::size_t kJudged = 20;        // samples
// A motion that stays different is a motion, and neighbours that stay different are those of a
// frame that vibrates: after these times the samples are believed again [s]. The second is three
// times the longest damage that was tried in a host: what is taken for vibration too early is flown
// into.
constexpr double kLongestStep = 0.5;
constexpr double kLongestScatter = 3.0;
// Calm time takes so much of that back: a vibration about the bound passes it now and then.
constexpr double kCalmShare = 0.2;
// Samples that are missing for longer are damage [s].
constexpr double kMaxGap = 0.05;
// Share of that between samples on a bridge.
constexpr double kBridgeStep = 0.9;

template <typename Iterator>
Eigen::Vector3d medianOf(Iterator first, Iterator last, Eigen::Vector3d ImuSample::*field) {
  Eigen::Vector3d result;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (Iterator it = first; it != last; ++it) values.push_back(((*it).*field)[axis]);
    result[axis] = middle(values);
  }
  return result;
}

double scatterOf(const std::deque<ImuSample>& samples, Eigen::Vector3d ImuSample::*field) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    steps.push_back((samples[i].*field - samples[i - 1].*field).norm());
  }
  return middle(steps);
}

}  // namespace

void ImuScreen::reset() {
  samples_.clear();
  recent_.clear();
  damage_.clear();
  left_out_.clear();
  believed_since_ = -1e300;
  scattered_ = 0.0;
}

bool ImuScreen::isUsable(const ImuSample& sample, bool* gyro_usable) {
  *gyro_usable = false;
  recent_.push_back(sample);
  if (recent_.size() > kJudged) recent_.pop_front();
  const bool within = !limits_.exceededBy(sample);
  const bool scatters =
      recent_.size() == kJudged && (scatterOf(recent_, &ImuSample::accel) > kMaxAccelScatter ||
                                    scatterOf(recent_, &ImuSample::gyro) > kMaxGyroScatter);
  scattered_ = std::clamp(scattered_ + (scatters ? period_ : -kCalmShare * period_), 0.0,
                          2.0 * kLongestScatter);
  if (scatters && scattered_ <= kLongestScatter) {
    // It took half of them to notice.
    const double noticed = sample.t - 0.5 * static_cast<double>(kJudged) * period_;
    while (samples_.size() > 1 && samples_.back().t > noticed) samples_.pop_back();
    return false;
  }
  if (!within && samples_.empty()) return false;
  if (within && !samples_.empty() && sample.t - samples_.back().t > kLongestStep) {
    believed_since_ = sample.t;
  }
  auto first = samples_.size() < kJudged ? samples_.begin() : std::prev(samples_.end(), kJudged);
  while (first != samples_.end() && first->t < believed_since_) ++first;
  const auto last = samples_.end();
  if (last - first < static_cast<std::ptrdiff_t>(kJudged / 2)) return within;
  const bool gyro_near = (sample.gyro - medianOf(first, last, &ImuSample::gyro)).norm() <=
                         stepAllowed(kMaxGyroStep, limits_.max_gyro, ImuLimits().max_gyro);
  const bool jumps =
      recent_.size() > 1 && (sample.gyro - recent_[recent_.size() - 2].gyro).norm() > kMaxGyroJump;
  *gyro_usable = gyro_near && !jumps;
  return within && gyro_near &&
         (sample.accel - medianOf(first, last, &ImuSample::accel)).norm() <=
             stepAllowed(kMaxAccelStep, limits_.max_accel, ImuLimits().max_accel);
}

// From the last usable sample before to `last`, both left out.
void ImuScreen::fill(const ImuSample& last, const ImuDamage& damage,
                     std::vector<ImuSample>* filled) const {
  const ImuSample& before = samples_.back();
  const auto at = [&](double t) {
    const double weight = (t - before.t) / (last.t - before.t);
    ImuSample between;
    between.t = t;
    between.accel = before.accel + weight * (last.accel - before.accel);
    between.gyro = before.gyro + weight * (last.gyro - before.gyro);
    return between;
  };
  if (damage.gyro_known) {
    for (const ImuSample& sample : left_out_) {
      filled->push_back(at(sample.t));
      filled->back().gyro = sample.gyro;
    }
    return;
  }
  const int steps = static_cast<int>(std::lround((last.t - before.t) / period_));
  for (int k = 1; k < steps; ++k) {
    filled->push_back(at(before.t + (last.t - before.t) * k / steps));
  }
}

// The initializer knows what missing samples are worth, and would believe interpolated ones: it
// gets no more of these than it takes to be no gap. Over a longer bridge rates that are known are
// worth more.
std::vector<ImuSample> ImuScreen::bridge(const ImuDamage& damage,
                                         std::vector<ImuSample> filled) const {
  const auto steps =
      static_cast<std::size_t>(std::ceil((damage.last - damage.first) / (kBridgeStep * kMaxGap)));
  if ((steps > 1 && damage.gyro_known) || filled.size() < steps) return filled;
  std::vector<ImuSample> few;
  for (std::size_t k = 1; k < steps; ++k) few.push_back(filled[k * filled.size() / steps]);
  return few;
}

std::deque<ImuSample> ImuScreen::heldUntil(double t) const {
  std::deque<ImuSample> samples = samples_;
  if (damage_.empty() || !damage_.back().open || samples_.empty()) return samples;
  const ImuDamage& open = damage_.back();
  ImuSample last = samples_.back();
  last.t = std::max(t, open.last);
  if (open.gyro_known && !left_out_.empty()) last.gyro = left_out_.back().gyro;
  if (!(last.t > samples_.back().t)) return samples;
  std::vector<ImuSample> filled;
  fill(last, open, &filled);
  while (!filled.empty() && filled.back().t >= last.t) filled.pop_back();
  samples.insert(samples.end(), filled.begin(), filled.end());
  samples.push_back(last);
  return samples;
}

std::vector<ImuSample> ImuScreen::add(const ImuSample& sample) {
  if (!recent_.empty()) {
    const double step = sample.t - recent_.back().t;
    if (step > 0.0 && step < kMaxGap) period_ += 0.1 * (step - period_);
  }
  bool gyro_usable = false;
  const bool usable = isUsable(sample, &gyro_usable);
  if (samples_.empty()) {
    if (usable) samples_.push_back(sample);
    return usable ? std::vector<ImuSample>{sample} : std::vector<ImuSample>{};
  }
  ImuDamage* open = !damage_.empty() && damage_.back().open ? &damage_.back() : nullptr;
  if (!usable || sample.t - samples_.back().t > kMaxGap) {
    if (open == nullptr) {
      damage_.push_back({});
      open = &damage_.back();
      open->open = true;
      // Where samples are missing nothing is known.
      open->gyro_known = sample.t - samples_.back().t <= kMaxGap;
      left_out_.clear();
    }
    open->first = std::min(samples_.back().t, sample.t);
    open->last = sample.t;
    open->gyro_known = open->gyro_known && (usable || gyro_usable);
    if (!usable) left_out_.push_back(sample);
  }
  if (!usable) return {};

  std::vector<ImuSample> ready;
  if (open != nullptr) {
    open->open = false;
    open->last = sample.t;
    open->bridged = open->last - open->first <= kBridge;
    std::vector<ImuSample> filled;
    fill(sample, *open, &filled);
    left_out_.clear();
    samples_.insert(samples_.end(), filled.begin(), filled.end());
    if (open->bridged) ready = bridge(*open, std::move(filled));
  }
  ready.push_back(sample);
  samples_.push_back(sample);
  while (samples_.front().t < sample.t - kKept) samples_.pop_front();
  while (!damage_.empty() && damage_.front().last < sample.t - kKept) damage_.pop_front();
  return ready;
}

}  // namespace slim_init::vins_adapter
