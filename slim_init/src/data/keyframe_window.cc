// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/keyframe_window.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "data/clean_frame.h"
#include "slim_init/text.h"

namespace slim_init {
KeyframeWindow::KeyframeWindow(const Calibration& calibration, const WindowOptions& options,
                               const StreamOptions& streams)
    : calibration_(calibration), options_(options), check_(streams) {}

AddStatus KeyframeWindow::addImu(const ImuSample& sample) {
  const AddStatus status = check_.checkImu(sample);
  if (!isAdded(status)) return status;
  if (status == AddStatus::kRestarted) dropData();
  imu_.push_back(sample);
  trim();
  return status;
}

AddStatus KeyframeWindow::addFrame(FrameObservation frame) {
  const AddStatus status = check_.checkFrame(calibration_.imuTime(frame.t));
  if (!isAdded(status)) return status;
  if (status == AddStatus::kRestarted) dropData();
  cleanFrame(frame, check_.counts());
  mergeWaiting(frame.t, &frame);
  frames_.push_back(std::make_shared<const FrameObservation>(std::move(frame)));
  trim();
  return status;
}

AddStatus KeyframeWindow::addSpeed(const SpeedSample& sample) {
  const AddStatus status = check_.checkSpeed(sample, calibration_.speed_sensor);
  if (isAdded(status)) speeds_.push_back(sample);
  trim();
  return status;
}

AddStatus KeyframeWindow::addLines(double stamp, std::vector<LineObservation> lines) {
  MessageCounts& counts = check_.counts().lines;
  if (!std::isfinite(stamp)) return counts.count(AddStatus::kNotFinite);
  if (frames_.empty() || stamp > frames_.back()->t + kSameStamp) {
    waitForFrame(stamp, std::move(lines));
    return AddStatus::kWaiting;
  }
  for (auto frame = frames_.rbegin(); frame != frames_.rend(); ++frame) {
    if (std::abs((*frame)->t - stamp) > kSameStamp) continue;
    FrameObservation with_lines = **frame;
    const AddStatus status = merge(std::move(lines), &with_lines);
    *frame = std::make_shared<const FrameObservation>(std::move(with_lines));
    return status;
  }
  return counts.count(AddStatus::kUnmatched);
}

void KeyframeWindow::setTd(double td) {
  Calibration changed = calibration_;
  changed.td = td;
  if (changed.validate().empty()) calibration_.td = td;
}

AddStatus KeyframeWindow::merge(std::vector<LineObservation> lines, FrameObservation* observation) {
  StreamCounts& counts = check_.counts();
  if (!observation->lines.empty()) return counts.lines.count(AddStatus::kUnmatched);
  observation->lines = std::move(lines);
  cleanLines(observation->lines, counts);
  return counts.lines.count(AddStatus::kAdded);
}

// Lines that were here before their frame. The frame of an older stamp does not come any more, and
// lines so far ahead of the newest frame are of the time before a restart.
void KeyframeWindow::mergeWaiting(double stamp, FrameObservation* observation) {
  StreamCounts& counts = check_.counts();
  while (!waiting_.empty() && waiting_.front().stamp <= stamp + kSameStamp) {
    if (std::abs(waiting_.front().stamp - stamp) <= kSameStamp) {
      merge(std::move(waiting_.front().lines), observation);
    } else {
      ++counts.lines[AddStatus::kUnmatched];
    }
    waiting_.pop_front();
  }
  while (!waiting_.empty() && waiting_.back().stamp > stamp + StreamCheck::kJump) {
    ++counts.lines[AddStatus::kUnmatched];
    waiting_.pop_back();
  }
  counts.lines[AddStatus::kWaiting] = static_cast<std::int64_t>(waiting_.size());
}

void KeyframeWindow::waitForFrame(double stamp, std::vector<LineObservation> lines) {
  StreamCounts& counts = check_.counts();
  const auto place =
      std::upper_bound(waiting_.begin(), waiting_.end(), stamp,
                       [](double t, const WaitingLines& waiting) { return t < waiting.stamp; });
  waiting_.insert(place, {stamp, std::move(lines)});
  if (waiting_.size() > kMaxWaitingLines) {
    waiting_.pop_front();
    ++counts.lines[AddStatus::kUnmatched];
  }
  counts.lines[AddStatus::kWaiting] = static_cast<std::int64_t>(waiting_.size());
}

// Start of the samples without a gap that reach the frame `newest`, which the IMU covers.
double KeyframeWindow::imuStart(int newest) const {
  // The first sample at or after the frame closes the window; it exists.
  auto sample = std::lower_bound(imu_.begin(), imu_.end(), frameTime(newest),
                                 [](const ImuSample& s, double t) { return s.t < t; });
  while (sample != imu_.begin() && sample->t - std::prev(sample)->t <= options_.max_imu_gap_s) {
    --sample;
  }
  return sample->t;
}

// Indices of the keyframes, newest first; `reason` is what ended the choice.
std::vector<int> KeyframeWindow::chooseKeyframes(const WindowOptions& selection,
                                                 const TimeSpan& span, std::string* reason) const {
  std::vector<int> chosen;
  *reason = "the IMU data cover no frame yet";
  int newest = imu_.empty() ? -1 : static_cast<int>(frames_.size()) - 1;
  while (newest >= 0 && frameTime(newest) > std::min(span.last, imu_.back().t)) --newest;
  if (newest < 0) return chosen;
  // Every frame that may be one of a window of max_span_s.
  std::vector<int> usable;
  const double t_imu_start = imuStart(newest);
  const auto time = [this](int i) { return frameTime(i); };
  std::string end;
  const auto inSpan = [&](int i) {
    return time(newest) - time(i) <= selection.max_span_s + kStampRounding;
  };
  for (int i = newest; i >= 0; --i) {
    const bool wanted = static_cast<int>(chosen.size()) < selection.keyframes;
    if (!wanted && !inSpan(i)) break;
    *reason = "more frames are needed";
    if (i < newest && time(i + 1) - time(i) > selection.max_frame_gap_s) {
      end = text("a gap of ", time(i + 1) - time(i), " s between frames (limit ",
                 selection.max_frame_gap_s, " s) restarts the window");
    } else if (time(i) < span.first) {
      end = text("the window begins ", time(newest) - span.first,
                 " s ago, earlier frames are not used");
    } else if (time(i) < t_imu_start && t_imu_start > time(newest)) {
      end = text("the newest frame lies in a gap of the IMU data (limit ", options_.max_imu_gap_s,
                 " s)");
    } else if (time(i) < t_imu_start) {
      end = text("the IMU data begin, or end a gap (limit ", options_.max_imu_gap_s, " s), ",
                 time(newest) - t_imu_start, " s before the newest frame");
    }
    if (!end.empty()) {
      *reason = end;
      break;
    }
    if (inSpan(i)) usable.push_back(i);
    if (wanted && (chosen.empty() ||
                   time(chosen.back()) - time(i) >= selection.min_interval_s - kStampRounding)) {
      chosen.push_back(i);
    }
  }
  const bool longer = !usable.empty() && usable.back() < chosen.back();
  return longer ? spreadKeyframes(selection, usable) : chosen;
}

// As many of these frames (newest first) as a window has, first and last among them, as evenly
// spaced as the frames allow.
std::vector<int> KeyframeWindow::spreadKeyframes(const WindowOptions& selection,
                                                 const std::vector<int>& frames) const {
  const auto time = [this](int i) { return frameTime(i); };
  std::vector<int> chosen = {frames.front()};
  std::size_t next = 1;
  while (next < frames.size() && static_cast<int>(chosen.size()) < selection.keyframes) {
    const double t_last = time(chosen.back());
    // Whatever has been missed is made up for by the rest.
    const int left = selection.keyframes - static_cast<int>(chosen.size());
    const double target = t_last - (t_last - time(frames.back())) / left;
    const auto allowed = [&](std::size_t i) {
      return t_last - time(frames[i]) >= selection.min_interval_s - kStampRounding;
    };
    while (next < frames.size() && !allowed(next)) ++next;
    if (next == frames.size()) break;
    while (next + 1 < frames.size() &&
           std::abs(time(frames[next + 1]) - target) < std::abs(time(frames[next]) - target)) {
      ++next;
    }
    chosen.push_back(frames[next++]);
  }
  return chosen;
}

// From the last sample at or before `t_first` to the first at or after `t_last`, and the margin on
// both sides as far as there are samples without a gap.
std::vector<ImuSample> KeyframeWindow::samplesCovering(double t_first, double t_last) const {
  const auto time_before = [](double t, const ImuSample& s) { return t < s.t; };
  const auto sample_before = [](const ImuSample& s, double t) { return s.t < t; };
  auto first = std::upper_bound(imu_.begin(), imu_.end(), t_first, time_before);
  if (first != imu_.begin()) --first;
  auto last = std::lower_bound(imu_.begin(), imu_.end(), t_last, sample_before);
  if (last != imu_.end()) ++last;
  while (first != imu_.begin() && first->t > t_first - InitWindow::kImuMargin &&
         first->t - std::prev(first)->t <= options_.max_imu_gap_s) {
    --first;
  }
  while (last != imu_.end() && std::prev(last)->t < t_last + InitWindow::kImuMargin &&
         last->t - std::prev(last)->t <= options_.max_imu_gap_s) {
    ++last;
  }
  return std::vector<ImuSample>(first, last);
}

WindowCut KeyframeWindow::cut(const WindowOptions& selection, int leave_out) const {
  std::string reason;
  std::vector<int> chosen = chooseKeyframes(selection, {-HUGE_VAL, HUGE_VAL}, &reason);
  int needed = selection.min_keyframes;
  if (leave_out > 0) {
    chosen.erase(chosen.begin(),
                 chosen.begin() + std::min(leave_out, static_cast<int>(chosen.size())));
    needed = kMinKeyframes;
  }
  return makeWindow(chosen, needed, reason);
}

WindowCut KeyframeWindow::cutWithin(const WindowOptions& selection, const TimeSpan& span) const {
  std::string reason;
  const std::vector<int> chosen = chooseKeyframes(selection, span, &reason);
  return makeWindow(chosen, kMinKeyframes, reason);
}

// `chosen`: newest first.
WindowCut KeyframeWindow::makeWindow(const std::vector<int>& chosen, int needed,
                                     const std::string& reason) const {
  WindowCut result;
  if (static_cast<int>(chosen.size()) < needed) {
    result.message =
        text("window holds ", chosen.size(), " keyframes (minimum ", needed, "): ", reason);
    return result;
  }

  std::vector<const FrameObservation*> keyframes;
  std::vector<double> times;
  for (auto i = chosen.rbegin(); i != chosen.rend(); ++i) {
    keyframes.push_back(frames_[*i].get());
    times.push_back(frameTime(*i));
  }
  const double t_first = times.front(), t_last = times.back();
  std::vector<SpeedSample> speeds;
  const double reach = InitWindow::kImuMargin + InitWindow::kMaxSpeedGap;
  std::copy_if(speeds_.begin(), speeds_.end(), std::back_inserter(speeds),
               [&](const SpeedSample& s) { return s.t > t_first - reach && s.t < t_last + reach; });
  std::string error;
  result.window =
      InitWindow::fromCleanFrames(calibration_, keyframes, std::move(times),
                                  samplesCovering(t_first, t_last), &error, std::move(speeds));
  if (result.window == nullptr) {
    result.status = InitStatus::kInvalidInput;
    result.message = error;
    return result;
  }
  result.status = InitStatus::kSuccess;
  result.message = text("window of ", keyframes.size(), " keyframes over ", t_last - t_first, " s");
  return result;
}

void KeyframeWindow::reset() { *this = KeyframeWindow(calibration_, options_, check_.options()); }

// After a jump in time: nothing of the old time is used again, counts stay.
void KeyframeWindow::dropData() {
  StreamCounts& counts = check_.counts();
  counts.lines[AddStatus::kUnmatched] += static_cast<std::int64_t>(waiting_.size());
  counts.lines[AddStatus::kWaiting] = 0;
  imu_.clear();
  frames_.clear();
  speeds_.clear();
  waiting_.clear();
}

void KeyframeWindow::trim() {
  // Each stream is bounded by itself, so that neither a silent camera nor a silent IMU makes the
  // other grow without limit.
  while (imu_.size() > 2 && imu_[1].t < imu_.back().t - options_.buffer_s) imu_.pop_front();
  while (frames_.size() > 1 && frames_.front()->t < frames_.back()->t - options_.buffer_s) {
    frames_.pop_front();
  }
  while (!speeds_.empty() && speeds_.front().t < speeds_.back().t - options_.buffer_s) {
    speeds_.pop_front();
  }
}

}  // namespace slim_init
