// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_adapter.h"

#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <sstream>
#include <utility>

#include "slim_init/row_times.h"

namespace slim_init::vins_adapter {
namespace {

// The td of older frames is forgotten [s]; more than the reach of any window of a host.
constexpr double kTdKept = 20.0;
// Rows of an image [px]; beyond is a mistake.
constexpr int kMaxImageHeight = 100000;

constexpr std::pair<const char*, HostMode> kModes[] = {
    {"stock", HostMode::kStock}, {"slim", HostMode::kSlim}, {"shadow", HostMode::kShadow}};

// A problem with the requested stamps, or "".
std::string checkStamps(const std::vector<double>& stamps) {
  if (stamps.empty()) return "the host's window is empty";
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    std::ostringstream out;
    if (!std::isfinite(stamps[i])) {
      out << "stamp " << i << " of the host's window is not finite";
      return out.str();
    }
    if (i > 0 && !(stamps[i] > stamps[i - 1])) {
      out << "stamp " << i << " of the host's window is " << stamps[i] - stamps[i - 1]
          << " s after the one before, must be after it";
      return out.str();
    }
  }
  return "";
}

}  // namespace

const char* toString(HostMode mode) {
  for (const auto& [name, value] : kModes) {
    if (value == mode) return name;
  }
  return "unknown";
}

bool parseHostMode(const std::string& text, HostMode* mode) {
  for (const auto& [name, value] : kModes) {
    if (text != name) continue;
    *mode = value;
    return true;
  }
  return false;
}

std::string HostOptions::validate() const {
  const std::pair<const char*, double> fields[] = {{"max_reach_s", max_reach_s},
                                                   {"max_join_s", max_join_s}};
  for (const auto& [name, value] : fields) {
    if (value >= 0.0 && value <= 60.0) continue;
    std::ostringstream out;
    out << name << " is " << value << ", must be in [0, 60]";
    return out.str();
  }
  if (image_height >= 0 && image_height <= kMaxImageHeight) return "";
  return "image_height is " + std::to_string(image_height) + ", must be in [0, " +
         std::to_string(kMaxImageHeight) + "]";
}

struct HostAdapter::State {
  // Keeps the first stamp since a restart; `status` is what became of the message.
  AddStatus noteRestart(AddStatus status) {
    if (status == AddStatus::kRestarted) forget();
    return status;
  }
  void forget() {
    first_stamp = kNotComputed;
    td_of.clear();
  }
  // With the td that the host had when it paired the frame of that stamp with its IMU data [s].
  double hostTime(double stamp) const {
    const auto it = td_of.find(stamp);
    return stamp + (it == td_of.end() ? initializer->calibration().td : it->second);
  }

  HostAnswer solve(const std::vector<double>& stamps, const HostState* last_healthy);
  bool fillWindow(const std::vector<double>& stamps, HostOrigin origin, HostAnswer* answer,
                  InitStatus* status, std::string* problem) const;

  mutable std::mutex mutex;
  std::unique_ptr<IInitializer> initializer;
  HostOptions options;
  double first_stamp = kNotComputed;
  std::map<double, double> td_of;  // by stamp [s]
};

// The host's frames lie between our keyframes, and some outside them.
bool HostAdapter::State::fillWindow(const std::vector<double>& stamps, HostOrigin origin,
                                    HostAnswer* answer, InitStatus* status,
                                    std::string* problem) const {
  const Calibration calibration = initializer->calibration();
  std::vector<double> times;
  times.reserve(stamps.size());
  // Not at the td that was found: the host's preintegrations reach from frame to frame as it has
  // paired them, and its own model moves what was seen to these times (velocity on the image plane
  // times the change of td).
  for (const double stamp : stamps) times.push_back(hostTime(stamp));
  std::vector<NavState> states;
  if (!initializer->statesAt(answer->verdict, times, options.max_reach_s, &states, problem)) {
    *status = InitStatus::kTooFewKeyframes;
    *problem = "the host's window cannot be filled: " + *problem;
    return false;
  }
  if (states.size() != stamps.size()) {
    *status = InitStatus::kNumericalFailure;
    *problem = initializer->name() + " returned " + std::to_string(states.size()) + " states for " +
               std::to_string(stamps.size()) + " stamps";
    return false;
  }
  if (!toHostWindow(states, calibration.gravity_magnitude, calibration.td, origin, &answer->window,
                    problem)) {
    *status = InitStatus::kNumericalFailure;
    return false;
  }
  // As requested, to the last bit: the host finds its frames by them.
  for (std::size_t i = 0; i < stamps.size(); ++i) answer->window.states[i].stamp = stamps[i];
  return true;
}

HostAnswer HostAdapter::State::solve(const std::vector<double>& stamps,
                                     const HostState* last_healthy) {
  HostAnswer answer;
  const auto decline = [&answer](InitStatus status, const std::string& message) {
    answer.verdict.status = status;
    answer.verdict.message = message;
    answer.message = message;
    return answer;
  };
  std::string problem = checkStamps(stamps);
  if (!problem.empty()) return decline(InitStatus::kInvalidInput, problem);
  answer.stamp = stamps.back();
  answer.data_s = answer.stamp - first_stamp;
  if (last_healthy != nullptr && !options.reinit) {
    return decline(InitStatus::kInvalidInput, "recovery is switched off (reinit: 0)");
  }

  answer.verdict =
      last_healthy == nullptr
          ? initializer->initialize()
          : initializer->recover(fromHostState(*last_healthy, initializer->calibration().td));
  answer.message = answer.verdict.message;
  if (!answer.verdict.success()) return answer;
  problem = answer.verdict.validate();
  if (!problem.empty()) {
    return decline(InitStatus::kNumericalFailure, initializer->name() + " reported " + problem);
  }
  InitStatus status = InitStatus::kSuccess;
  const HostOrigin origin = last_healthy == nullptr ? HostOrigin::kFirstBody : HostOrigin::kKeep;
  if (!fillWindow(stamps, origin, &answer, &status, &problem)) return decline(status, problem);
  answer.joined = last_healthy != nullptr;
  return answer;
}

HostAdapter::HostAdapter(std::unique_ptr<State> state) : state_(std::move(state)) {}
HostAdapter::~HostAdapter() = default;

InitializerOptions HostAdapter::hostDefaults() { return InitializerOptions(); }

std::unique_ptr<HostAdapter> HostAdapter::create(std::unique_ptr<IInitializer> initializer,
                                                 const HostOptions& options, std::string* error) {
  const std::string problem =
      initializer == nullptr ? "the initializer is null" : options.validate();
  if (!problem.empty()) {
    if (error != nullptr) *error = problem;
    return nullptr;
  }
  auto state = std::make_unique<State>();
  state->initializer = std::move(initializer);
  state->options = options;
  return std::unique_ptr<HostAdapter>(new HostAdapter(std::move(state)));
}

AddStatus HostAdapter::addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  ImuSample sample;
  sample.t = t;
  sample.accel = accel;
  sample.gyro = gyro;
  return state_->noteRestart(state_->initializer->addImu(sample));
}

AddStatus HostAdapter::addFrame(FrameObservation frame) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const double stamp = frame.t;
  const Calibration calibration = state_->initializer->calibration();
  if (state_->options.image_height > 0) {
    setRowTimes(state_->options.image_height, calibration.readout_s, &frame);
  }
  const AddStatus status = state_->noteRestart(state_->initializer->addFrame(std::move(frame)));
  if (!isAdded(status)) return status;
  if (std::isnan(state_->first_stamp)) state_->first_stamp = stamp;
  state_->td_of[stamp] = calibration.td;
  state_->td_of.erase(state_->td_of.begin(), state_->td_of.lower_bound(stamp - kTdKept));
  return status;
}

AddStatus HostAdapter::addLines(double stamp, std::vector<LineObservation> lines) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  FrameObservation frame;
  frame.lines = std::move(lines);
  if (state_->options.image_height > 0) {
    setRowTimes(state_->options.image_height, state_->initializer->calibration().readout_s, &frame);
  }
  return state_->initializer->addLines(stamp, std::move(frame.lines));
}

void HostAdapter::setTd(double td) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->initializer->setTd(td);
}

HostAnswer HostAdapter::seed(const std::vector<double>& stamps) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const auto start = std::chrono::steady_clock::now();
  HostAnswer answer = state_->solve(stamps, nullptr);
  answer.total_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return answer;
}

HostAnswer HostAdapter::recover(const std::vector<double>& stamps, const HostState& last_healthy) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const auto start = std::chrono::steady_clock::now();
  HostAnswer answer = state_->solve(stamps, &last_healthy);
  answer.total_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return answer;
}

void HostAdapter::reset() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->initializer->reset();
  state_->forget();
}

HostOptions HostAdapter::options() const { return state_->options; }

StreamCounts HostAdapter::counts() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->initializer->counts();
}

Calibration HostAdapter::calibration() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->initializer->calibration();
}

std::string HostAdapter::method() const { return state_->initializer->name(); }

double HostAdapter::maxWindowSpan() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->initializer->maxWindowSpan();
}

}  // namespace slim_init::vins_adapter
