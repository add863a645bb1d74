// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/backend/downstream.h"

#include <algorithm>
#include <cmath>

#include "slim_init/backend/sliding_window_estimator.h"
#include "slim_init/evaluation/metrics.h"
#include "slim_init/text.h"

namespace slim_init::backend {
namespace {

using evaluation::DownstreamRecord;
using evaluation::Sequence;

constexpr double kFrameInterval = 0.1;  // of the frames that the estimator sees [s]; a host's
constexpr double kMaxError = 1.0;    // a larger position error, once aligned, is a divergence [m]
constexpr double kMinSpread = 0.05;  // a last window that moved less, rms, shows no scale [m]

std::vector<Eigen::Vector3d> positions(const std::vector<NavState>& states) {
  std::vector<Eigen::Vector3d> p;
  for (const NavState& state : states) p.push_back(state.p_w_b);
  return p;
}

/// Index of the frame at time t on the IMU clock, with the td believed in, or -1.
int frameAt(const Sequence& sequence, double td, double t) {
  const auto frame =
      std::lower_bound(sequence.frames.begin(), sequence.frames.end(), t - kStampRounding,
                       [td](const FrameObservation& f, double time) { return f.t + td < time; });
  if (frame == sequence.frames.end() || std::abs(frame->t + td - t) > kStampRounding) return -1;
  return static_cast<int>(frame - sequence.frames.begin());
}

/// Feeds the estimator with one sequence.
class Feed {
 public:
  Feed(const Sequence& sequence, double td, SlidingWindowEstimator* estimator)
      : sequence_(sequence), td_(td), estimator_(estimator) {}

  void start(int frame) {
    const double t = timeOf(frame);
    const auto after =
        std::upper_bound(sequence_.imu.begin(), sequence_.imu.end(), t,
                         [](double time, const ImuSample& sample) { return time < sample.t; });
    next_imu_ = after == sequence_.imu.begin() ? after : std::prev(after);
  }
  FrameReport add(int frame) {
    const double t = timeOf(frame);
    while (next_imu_ != sequence_.imu.end() && !(last_imu_ >= t)) {
      last_imu_ = next_imu_->t;
      estimator_->addImu(*next_imu_++);
    }
    return estimator_->addFrame(sequence_.frames[frame]);
  }
  double timeOf(int frame) const { return sequence_.frames[frame].t + td_; }

 private:
  const Sequence& sequence_;
  double td_;
  SlidingWindowEstimator* estimator_;
  std::vector<ImuSample>::const_iterator next_imu_;
  double last_imu_ = -1e300;
};

/// What the estimator is run with: what the method found, as a host that takes it over would.
Calibration calibrationOf(Calibration calibration, const InitResult& answer) {
  if (answer.calibration.has_value()) {
    calibration.R_b_c = answer.calibration->R_b_c;
    calibration.t_b_c = answer.calibration->t_b_c;
    calibration.td = answer.calibration->td;
    calibration.readout_s = answer.calibration->readout_s;
  }
  return calibration;
}

void diverge(const std::string& message, DownstreamRecord* record) {
  record->diverged = true;
  record->message = message;
}

/// ATE, final scale and, from them, divergence.
void compare(const Sequence& sequence, const std::vector<NavState>& path,
             const std::vector<NavState>& window, DownstreamRecord* record) {
  if (sequence.truth == nullptr) return;
  const auto truthOf = [&](const std::vector<NavState>& states, std::vector<NavState>* known) {
    std::vector<NavState> truth;
    for (const NavState& state : states) {
      const NavState there = evaluation::truthAt(sequence, state.t);
      if (!std::isfinite(there.t)) continue;
      truth.push_back(there);
      known->push_back(state);
    }
    return truth;
  };
  std::vector<NavState> known, known_window;
  const std::vector<NavState> truth = truthOf(path, &known);
  const std::vector<NavState> window_truth = truthOf(window, &known_window);
  record->scale_error = windowScaleError(known_window, window_truth);
  if (known.empty()) return;
  const auto estimated_p = positions(known), true_p = positions(truth);
  const evaluation::HeadingAlignment alignment = evaluation::alignHeading(estimated_p, true_p);
  double sum = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < true_p.size(); ++k) {
    const double error = (alignment.apply(estimated_p[k]) - true_p[k]).norm();
    sum += error * error;
    largest = std::max(largest, error);
  }
  record->ate = std::sqrt(sum / static_cast<double>(true_p.size()));
  if (!record->diverged && !(largest <= kMaxError)) {
    diverge(text("position error ", largest, " m (limit ", kMaxError, ")"), record);
  }
}

/// Feeds the frames after `frame`, which the estimator was seeded at, and compares with the truth.
void follow(const Sequence& sequence, double seconds, int frame, Feed* feed,
            SlidingWindowEstimator* estimator, DownstreamRecord* record) {
  const double t_seed = feed->timeOf(frame);
  std::vector<NavState> path(1, estimator->newest());
  double t_last = t_seed;
  const int frames = static_cast<int>(sequence.frames.size());
  for (int next = frame + 1; next < frames && !record->diverged; ++next) {
    const double t = feed->timeOf(next);
    if (t > t_seed + seconds + kStampRounding) break;
    if (t < t_last + kFrameInterval - kStampRounding) continue;
    t_last = t;
    const FrameReport report = feed->add(next);
    if (!report.ok() && !estimator->seeded()) {
      diverge(report.problem, record);
    } else if (report.ok()) {
      const NavState newest = estimator->newest();
      if (const std::string failure = detectFailure(path.back(), newest, report);
          !failure.empty()) {
        diverge(failure, record);
      }
      path.push_back(newest);
    }
    // A frame that the IMU data do not cover is skipped, for every method alike.
  }
  record->seconds = path.back().t - t_seed;
  compare(sequence, path, estimator->states(), record);
}

/// False, with a message, where less than half of the seconds are there.
bool dataReach(const Sequence& sequence, double td, double t_seed, double seconds,
               DownstreamRecord* record) {
  const double t_end = sequence.frames.empty() ? t_seed : sequence.frames.back().t + td;
  if (t_end - t_seed >= 0.5 * seconds) return true;
  record->message = "the data end too soon after the window";
  return false;
}

}  // namespace

double windowScaleError(const std::vector<NavState>& states, const std::vector<NavState>& truth) {
  const auto true_p = positions(truth);
  if (true_p.empty()) return kNotComputed;
  const Eigen::Map<const Eigen::Matrix3Xd> p(true_p.front().data(), 3,
                                             static_cast<Eigen::Index>(true_p.size()));
  const double spread = (p.colwise() - p.rowwise().mean()).colwise().squaredNorm().mean();
  if (!(std::sqrt(spread) >= kMinSpread)) return kNotComputed;
  evaluation::Similarity similarity;
  if (!evaluation::alignSimilarity(positions(states), true_p, &similarity).empty()) {
    return kNotComputed;
  }
  return std::abs(similarity.s - 1.0);
}

DownstreamRecord runDownstream(const Sequence& sequence, const Calibration& given,
                               const InitResult& answer, double seconds) {
  DownstreamRecord record;
  if (!answer.hasEstimate()) {
    record.message = "no states to start from";
    return record;
  }
  const auto most = static_cast<std::size_t>(SlidingWindowEstimator::kWindowFrames - 1);
  const auto skipped = answer.states.size() > most ? answer.states.size() - most : 0;
  const std::vector<NavState> seed(answer.states.begin() + static_cast<std::ptrdiff_t>(skipped),
                                   answer.states.end());

  const Calibration calibration = calibrationOf(given, answer);
  const auto estimator = SlidingWindowEstimator::make(calibration);
  Feed feed(sequence, calibration.td, estimator.get());
  int frame = -1;
  for (const NavState& state : seed) {
    frame = frameAt(sequence, calibration.td, state.t);
    if (frame < 0) {
      record.message = "a state of the estimate belongs to no frame of the sequence";
      return record;
    }
    if (&state == &seed.front()) feed.start(frame);
    if (const FrameReport report = feed.add(frame); !report.ok()) {
      record.message = report.problem;
      return record;
    }
  }
  if (!dataReach(sequence, calibration.td, feed.timeOf(frame), seconds, &record)) return record;

  record.ran = true;
  if (const FrameReport report = estimator->seed(seed); !report.ok()) {
    diverge(report.problem, &record);
    return record;
  }
  follow(sequence, seconds, frame, &feed, estimator.get(), &record);
  return record;
}

}  // namespace slim_init::backend
