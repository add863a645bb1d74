// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/imu_screen.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "slim_init/host_health/imu_propagation.h"

namespace slim_init::host_health {

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

// Between neighbours, or in this time if they are further apart: rates that get beyond the step by
// smaller jumps are a motion; beside an accelerometer that is wrong, more says that the gyroscope
// is too.
constexpr double kMaxGyroJump = 2.0;  // [rad/s]
constexpr double kJumpTime = 0.005;   // [s]
constexpr std::size_t kJudged = 20;   // samples
// A motion that stays different is a motion: after this time the samples are believed again [s].
constexpr double kLongestStep = 0.5;
// Noise of one axis of a sample; EuRoC's rotors make 0.4 to 1.9 m/s^2 and 0.04 to 0.08 rad/s. A
// sensor at rest becomes a vibrating one without being broken.
constexpr double kUsualAccelNoise = 1.5;  // [m/s^2]
constexpr double kUsualGyroNoise = 0.1;   // [rad/s]
// Once in each kNoiseStretch, 5 s in all: a vibration that begins is usual after 2.5 s.
constexpr std::size_t kBlocks = 50;
constexpr std::size_t kLeastBlocks = 5;
constexpr double kNoNoise = 1e-3;  // [m/s^2], half of that of the quietest sensors
// Noise above the usual by these factors widens, and is not for the initializer.
constexpr double kWidens = 3.0;
constexpr double kBreaks = 5.0;
// Noise from one stretch of this length to the next is independent [s].
constexpr double kNoiseStretch = 0.1;
// Variance of third differences of white noise, and the median of chi-square with three degrees of
// freedom.
constexpr double kThirdDifference = 20.0;
constexpr double kMedianOfThree = 2.366;
// Values in a row that equal the one before, of an axis that is stuck or at the end of its range.
// Drivers repeat single samples, and axes with coarse steps their values: at the rate of some 1000
// samples before, the repeats of a sensor's axes happen by chance once in 10^9. EuRoC's axes repeat
// 0.2 to 2 % of the values, four in a row at most.
constexpr int kStuckRepeats = 4;
constexpr double kStuckByChance = -9.0;  // logarithm to the base 10
constexpr double kRepeatMemory = 1e-3;   // weight of the newest value, and the least rate
// An axis that repeats alone came to rest or turned if it moved by fewer steps in so many samples
// before, as behind a low-pass filter, or is at rest after this time [s].
constexpr double kFewSteps = 5.0;
constexpr double kLongestStuck = 1.0;
// A vehicle may have felt what changes its velocity by no more: a hard landing [m/s].
constexpr double kHardestShock = 1.5;
// Samples that are missing for longer are damage [s].
constexpr double kMaxGap = 0.05;
// Of an IMU: a driver that has waited sends many samples at once, with the stamps of that [s].
constexpr double kShortestPeriod = 5e-4;
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

// Noise of samples from their third differences, which motion hardly enters; robust against
// glitches.
double noiseOf(const std::deque<ImuSample>& samples, Eigen::Vector3d ImuSample::*field) {
  std::vector<double> squares;
  for (std::size_t i = 3; i < samples.size(); ++i) {
    squares.push_back((samples[i].*field - 3.0 * (samples[i - 1].*field) +
                       3.0 * (samples[i - 2].*field) - samples[i - 3].*field)
                          .squaredNorm());
  }
  return std::sqrt(middle(std::move(squares)) / (kThirdDifference * kMedianOfThree));
}

}  // namespace

void ImuScreen::reset() {
  samples_.clear();
  recent_.clear();
  damage_.clear();
  left_out_.clear();
  noise_.clear();
  for (Repeats& axis : repeats_) axis.in_row = 0;  // the rates are the sensor's
  returned_ = -1e300;
  noise_end_ = believed_since_ = block_end_ = -1e300;
}

void ImuScreen::insertDamage(const ImuDamage& damage) {
  auto at = damage_.end();
  while (at != damage_.begin() && (std::prev(at)->open || std::prev(at)->last > damage.last)) --at;
  damage_.insert(at, damage);
}

void ImuScreen::addDamage(double first, double last, double accel_sigma, double gyro_sigma) {
  if (!(first < last) || !(accel_sigma >= 0.0) || !(gyro_sigma >= 0.0) ||
      !std::isfinite(last - first + accel_sigma + gyro_sigma)) {
    return;
  }
  for (ImuDamage& known : damage_) {
    if (!known.measured || known.first != first || known.last != last) continue;
    known.accel_sigma = std::max(known.accel_sigma, accel_sigma);
    known.gyro_sigma = std::max(known.gyro_sigma, gyro_sigma);
    return;
  }
  ImuDamage damage;
  damage.first = first;
  damage.last = last;
  damage.measured = true;
  damage.accel_sigma = accel_sigma;
  damage.gyro_sigma = gyro_sigma;
  insertDamage(damage);
}

ImuSampleNoise ImuScreen::usualNoise() const {
  std::vector<double> accel, gyro;
  for (const ImuSampleNoise& block : noise_) {
    accel.push_back(block.accel);
    gyro.push_back(block.gyro);
  }
  return {middle(std::move(accel)), middle(std::move(gyro))};
}

// White noise of the samples grows with the root of the time: stretches of damage, each with the
// constant error that has the same effect on the velocity.
void ImuScreen::widenByNoise(double begin, double end, const ImuSampleNoise& excess) {
  auto stretch = std::find_if(damage_.rbegin(), damage_.rend(), [this](const ImuDamage& damage) {
    return damage.measured && damage.last == noise_end_;
  });
  ImuDamage damage;
  damage.measured = true;
  damage.first = begin;
  ImuSampleNoise of_samples = excess;
  if (stretch != damage_.rend() && stretch->first > end - kNoiseStretch) {
    damage = *stretch;
    damage_.erase(std::prev(stretch.base()));
    const double root = std::sqrt((damage.last - damage.first) / period_);
    of_samples.accel = std::max(excess.accel, root * damage.accel_sigma);
    of_samples.gyro = std::max(excess.gyro, root * damage.gyro_sigma);
  } else if (stretch != damage_.rend()) {
    damage.first = std::max(begin, noise_end_);
  }
  damage.last = noise_end_ = end;
  if (!(damage.first < damage.last)) return;
  const double share = std::sqrt(std::min(1.0, period_ / (damage.last - damage.first)));
  damage.accel_sigma = share * of_samples.accel;
  damage.gyro_sigma = share * of_samples.gyro;
  insertDamage(damage);
}

bool ImuScreen::isNoisy() {
  if (recent_.size() < kJudged || isFrozen()) return false;
  const ImuSampleNoise noise = {noiseOf(recent_, &ImuSample::accel),
                                noiseOf(recent_, &ImuSample::gyro)};
  if (recent_.back().t >= block_end_) {
    block_end_ = recent_.back().t + kNoiseStretch;
    noise_.push_back(noise);
    if (noise_.size() > kBlocks) noise_.pop_front();
  }
  if (noise_.size() < kLeastBlocks) return false;
  ImuSampleNoise usual = usualNoise();
  usual = {std::max(kUsualAccelNoise, usual.accel), std::max(kUsualGyroNoise, usual.gyro)};
  const auto excess = [](double measured, double bound) {
    return std::sqrt(std::max(0.0, measured * measured - bound * bound));
  };
  const ImuSampleNoise above = {excess(noise.accel, kWidens * usual.accel),
                                excess(noise.gyro, kWidens * usual.gyro)};
  if (above.accel > 0.0 || above.gyro > 0.0) {
    // It took half of them to notice.
    widenByNoise(recent_[kJudged / 2].t, recent_.back().t, above);
  }
  return noise.accel > kBreaks * usual.accel || noise.gyro > kBreaks * usual.gyro;
}

bool ImuScreen::stands() const {
  const ImuSample& sample = recent_.back();
  return std::abs(sample.accel.norm() - Calibration().gravity_magnitude) < kUsualAccelNoise &&
         sample.gyro.norm() < kUsualGyroNoise;
}

// All axes repeat. So do those of a body at rest in a simulation without noise and under steps that
// hide it; there the last one had come to rest.
bool ImuScreen::isFrozen() const {
  const Repeats& last =
      *std::min_element(repeats_.begin(), repeats_.end(), [](const Repeats& a, const Repeats& b) {
        return a.in_row < b.in_row || (a.in_row == b.in_row && a.moved > b.moved);
      });
  if (last.in_row < kStuckRepeats || !stands()) return last.in_row >= kStuckRepeats;
  return last.moved >= kFewSteps && !noise_.empty() && usualNoise().accel > kNoNoise;
}

// Values in a row that equal the one before, where the axes from `first` on, those of one sensor,
// are stuck; else zero.
int ImuScreen::stuckFor(std::size_t first) const {
  const bool frozen = isFrozen();
  // At rest steps may hide the noise of a sensor.
  const double noise = noise_.empty() ? 0.0 : first == 0 ? usualNoise().accel : usualNoise().gyro;
  const bool hidden = stands() && noise < steps_[first / 3];
  double by_chance = 0.0;
  int longest = 0;
  for (std::size_t axis = first; axis < first + 3; ++axis) {
    const Repeats& repeats = repeats_[axis];
    const bool rests =
        hidden || repeats.moved < kFewSteps || repeats.in_row * period_ > kLongestStuck;
    if (repeats.in_row < kStuckRepeats || (rests && !frozen)) continue;
    by_chance += repeats.in_row * std::log10(std::max(repeats.rate, kRepeatMemory));
    longest = std::max(longest, repeats.in_row);
  }
  return by_chance < kStuckByChance ? longest : 0;
}

// `sample` is not yet among the recent ones.
void ImuScreen::countRepeats(const ImuSample& sample) {
  if (recent_.empty()) return;
  const bool frozen = isFrozen() && stuckFor(0) > 0;
  ++compared_;
  const ImuSample& before = recent_.back();
  const auto compare = [](double change, double* step) {
    if (change > 0.0) *step = std::min(*step, change);
  };
  compare((sample.accel - before.accel).norm(), &steps_[0]);
  compare((sample.gyro - before.gyro).norm(), &steps_[1]);
  for (std::size_t axis = 0; axis < repeats_.size(); ++axis) {
    const auto value = [axis](const ImuSample& of) {
      return axis < 3 ? of.accel[static_cast<Eigen::Index>(axis)]
                      : of.gyro[static_cast<Eigen::Index>(axis) - 3];
    };
    const bool repeats = value(sample) == value(before);
    Repeats& of_axis = repeats_[axis];
    if (repeats && of_axis.in_row == 0) {
      const auto [least, greatest] = std::minmax_element(
          recent_.end() - std::min<std::ptrdiff_t>(kStuckRepeats + 1, recent_.size()),
          recent_.end(),
          [&value](const ImuSample& a, const ImuSample& b) { return value(a) < value(b); });
      of_axis.moved = (value(*greatest) - value(*least)) / steps_[axis / 3];
    }
    of_axis.in_row = repeats ? of_axis.in_row + 1 : 0;
    if (frozen) continue;
    const double gain = std::max(kRepeatMemory, 1.0 / static_cast<double>(compared_));
    of_axis.rate += gain * ((repeats ? 1.0 : 0.0) - of_axis.rate);
  }
}

// Takes back the samples of a run of `repeats` values that equal the one before. The first of them
// was beyond the range as well.
void ImuScreen::takeBack(int repeats) {
  double since = recent_.back().t - (repeats + 0.5) * period_;
  if (!damage_.empty()) since = std::max(since, damage_.back().last);
  while (samples_.size() > 1 && samples_.back().t > since) {
    left_out_.push_front(samples_.back());
    samples_.pop_back();
  }
}

bool ImuScreen::isUsable(const ImuSample& sample, bool* gyro_usable) {
  *gyro_usable = false;
  countRepeats(sample);
  recent_.push_back(sample);
  if (recent_.size() > kJudged) recent_.pop_front();
  const int stuck_gyro = stuckFor(3), stuck = std::max(stuckFor(0), stuck_gyro);
  if (stuck > 0) takeBack(stuck);
  const bool within = !limits_.exceededBy(sample);
  if (!within && samples_.empty()) return false;
  if (within && !samples_.empty() && sample.t - samples_.back().t > kLongestStep) {
    believed_since_ = sample.t;
  }
  auto first = samples_.size() < kJudged ? samples_.begin() : std::prev(samples_.end(), kJudged);
  while (first != samples_.end() && first->t < believed_since_) ++first;
  const auto last = samples_.end();
  if (last - first < static_cast<std::ptrdiff_t>(kJudged / 2)) return within && stuck == 0;
  const ImuSample& before = recent_.size() > 1 ? recent_[recent_.size() - 2] : samples_.back();
  const double apart = std::max({kJumpTime, period_, sample.t - before.t});
  const bool jumps =
      (sample.gyro - before.gyro).norm() > std::min(kMaxGyroJump * apart / kJumpTime, kMaxGyroStep);
  const bool gyro_near = (!jumps && before.t == samples_.back().t) ||
                         (sample.gyro - medianOf(first, last, &ImuSample::gyro)).norm() <=
                             stepAllowed(kMaxGyroStep, limits_.max_gyro, ImuLimits().max_gyro);
  *gyro_usable = gyro_near && !jumps && stuck_gyro == 0 && !isFrozen();
  return within && gyro_near && stuck == 0 &&
         (sample.accel - medianOf(first, last, &ImuSample::accel)).norm() <=
             stepAllowed(kMaxAccelStep, limits_.max_accel, ImuLimits().max_accel);
}

// From the last usable sample before to `last`, both left out.
void ImuScreen::fill(const ImuSample& last, const ImuDamage& damage,
                     std::vector<ImuSample>* filled) const {
  const ImuSample& before = samples_.back();
  if (damage.gyroKnown()) {
    for (const ImuSample& sample : left_out_) {
      filled->push_back(between(before, last, sample.t));
      filled->back().gyro = sample.gyro;
    }
    return;
  }
  const double since = std::max(before.t, last.t - kKept);
  const int steps = static_cast<int>(std::lround((last.t - since) / period_));
  for (int k = 1; k < steps; ++k) {
    filled->push_back(between(before, last, since + (last.t - since) * k / steps));
  }
}

// The initializer knows what missing samples are worth, and would believe interpolated ones: it
// gets no more of these than it takes to be no gap. Over a longer bridge rates that are known are
// worth more.
std::vector<ImuSample> ImuScreen::bridge(const ImuDamage& damage,
                                         std::vector<ImuSample> filled) const {
  const auto steps =
      static_cast<std::size_t>(std::ceil((damage.last - damage.first) / (kBridgeStep * kMaxGap)));
  if ((steps > 1 && damage.gyroKnown()) || filled.size() < steps) return filled;
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
  if (open.gyroKnown() && !left_out_.empty()) last.gyro = left_out_.back().gyro;
  if (!(last.t > samples_.back().t)) return samples;
  std::vector<ImuSample> filled;
  fill(last, open, &filled);
  while (!filled.empty() && filled.back().t >= last.t) filled.pop_back();
  samples.insert(samples.end(), filled.begin(), filled.end());
  samples.push_back(last);
  return samples;
}

// The errors of the open damage are those of leaving out what the body may have felt.
void ImuScreen::widenByShock(ImuDamage* open) const {
  const double length = std::max(period_, open->last - open->first);
  const double accel = discarded_accel_.norm() / length, gyro = discarded_gyro_.norm() / length;
  const bool felt = accel * length < kHardestShock && gyro < limits_.max_gyro;
  open->accel_sigma = felt ? std::max(kUnknownAccel, accel) : kUnknownAccel;
  if (!open->gyroKnown()) open->gyro_sigma = felt ? std::max(kUnknownGyro, gyro) : kUnknownGyro;
}

std::vector<ImuSample> ImuScreen::add(const ImuSample& sample) {
  // Without the newest step, which may be over missing samples; those count once they are over.
  if (recent_.size() > 1) {
    const double step = recent_.back().t - recent_[recent_.size() - 2].t;
    period_ = std::max(kShortestPeriod, period_ + 0.1 * (std::min(step, kMaxGap) - period_));
  }
  bool gyro_usable = false;
  const bool usable = isUsable(sample, &gyro_usable);
  const bool noisy = isNoisy();
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
      discarded_accel_ = discarded_gyro_ = Eigen::Vector3d::Zero();
      // Where samples are missing nothing is known.
      if (sample.t - recent_[recent_.size() - 2].t <= kMaxGap) open->gyro_sigma = 0.0;
    }
    open->first = std::min(samples_.back().t, sample.t);
    open->last = sample.t;
    if (!usable && !gyro_usable) open->gyro_sigma = kUnknownGyro;
    if (!usable) {
      left_out_.push_back(sample);
      discarded_accel_ += period_ * (sample.accel - samples_.back().accel);
      discarded_gyro_ += period_ * (sample.gyro - samples_.back().gyro);
    }
    if (!open->gyroKnown()) left_out_.clear();
    widenByShock(open);
  }
  if (!usable) {
    forgetOld(sample.t);
    return {};
  }

  std::vector<ImuSample> ready;
  if (open != nullptr) {
    open->open = false;
    open->last = sample.t;
    widenByShock(open);
    open->bridged = open->last - open->first <= kBridge;
    std::vector<ImuSample> filled;
    fill(sample, *open, &filled);
    left_out_.clear();
    samples_.insert(samples_.end(), filled.begin(), filled.end());
    if (open->bridged) ready = bridge(*open, std::move(filled));
    // What was taken back had been returned.
    ready.erase(std::remove_if(ready.begin(), ready.end(),
                               [this](const ImuSample& one) { return one.t <= returned_; }),
                ready.end());
  }
  ready.push_back(sample);
  samples_.push_back(sample);
  if (noisy) ready.clear();
  if (!ready.empty()) returned_ = sample.t;
  forgetOld(sample.t);
  return ready;
}

// A sensor that gives one value for hours is damage all the time.
void ImuScreen::forgetOld(double t) {
  while (samples_.size() > kJudged && samples_.front().t < t - kKept) samples_.pop_front();
  while (!left_out_.empty() && left_out_.front().t < t - kKept) left_out_.pop_front();
  while (!damage_.empty() && damage_.front().last < t - kKept) damage_.pop_front();
}

AddStatus ImuScreen::pass(const ImuSample& sample, const Receiver& receiver) {
  // Whether a stamp is to be believed is the receiver's to say.
  const bool regular = sample.t > newest_ && sample.t - newest_ <= StreamCheck::kJump;
  const bool finite =
      std::isfinite(sample.t) && sample.accel.allFinite() && sample.gyro.allFinite();
  if (!regular || !finite || limits_.exceededBy(sample)) {
    const AddStatus status = receiver(sample);
    if (status == AddStatus::kRestarted) reset();
    if (isAdded(status) || (status == AddStatus::kGlitch && regular)) {
      add(sample);
      newest_ = sample.t;
    }
    return status;
  }
  newest_ = sample.t;
  const std::vector<ImuSample> usable = add(sample);
  if (usable.empty()) ++discarded_;
  AddStatus status = AddStatus::kGlitch;
  for (const ImuSample& one : usable) status = receiver(one);
  return status;
}

}  // namespace slim_init::host_health
