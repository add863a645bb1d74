// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_glue.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <sstream>
#include <utility>

#include "slim_init/calibration_lines.h"
#include "slim_init/vins_adapter/feature_message.h"
#include "slim_init/vins_adapter/host_file.h"
#include "start_record.h"

namespace slim_init::vins_adapter {
namespace {

using Clock = std::chrono::steady_clock;

// States of the host from the last moments before it noticed a failure are not trusted [s].
constexpr double kSuspect = 0.5;
// Healthy states kept [s]; has to be more than kSuspect.
constexpr double kHealthyKept = 2.0;
// An unchanged status is reported again after this time [s].
constexpr double kRepeatReport = 5.0;
// A td handed over may lie so much of the time between two frames below the host's.
constexpr double kMostTdStep = 0.9;

// The shortest time between two frames [s].
double shortestInterval(const std::vector<HostState>& states) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < states.size(); ++i) {
    shortest = std::min(shortest, states[i].stamp - states[i - 1].stamp);
  }
  return shortest;
}

// Where the host estimates its calibration, the one that was found is its starting value; where it
// does not, nothing of its own is changed.
GlueWindow toGlueWindow(const HostAnswer& answer, const Calibration& host,
                        const HostOptions& options) {
  GlueWindow result;
  static_cast<HostWindow&>(result) = answer.window;
  result.ric = host.R_b_c;
  result.tic = host.t_b_c;
  const OptionalCalibration& found = answer.verdict.calibration;
  if (!found.has_value()) return result;
  if (options.estimate_extrinsic) {
    result.ric = found->R_b_c;
    result.tic = found->t_b_c;
  }
  if (options.estimate_td) {
    // A frame must not begin before the one before it has ended: the host would abort.
    const double least = host.td - kMostTdStep * shortestInterval(answer.window.states);
    result.td = std::max(found->td, least);
  }
  return result;
}

}  // namespace

struct HostGlue::State {
  std::unique_ptr<HostAdapter> adapter;
  HostFile file;
  std::atomic<bool> active{false};

  // Touched by the processing thread alone.
  double last_imu = std::numeric_limits<double>::quiet_NaN();
  bool glitch_reported = false;
  bool lines_reported = false;
  std::deque<HostState> healthy;
  HostState lost;  // the last healthy state before a failure that was not recovered
  bool is_lost = false;
  Clock::time_point stock_began;
  InitStatus reported_status = InitStatus::kSuccess;
  double reported_stamp = -std::numeric_limits<double>::infinity();
  std::ofstream csv;

  // Request and listener come from other threads.
  std::mutex mutex;
  Listener listener;
  bool requested = false;
  bool reset_if_refused = false;
  bool reset_wanted = false;

  void report(ReportLevel level, const std::string& text) {
    Listener to;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      to = listener;
    }
    if (to) to(level, text);
  }

  void openCsv() {
    if (file.output_path.empty()) return;
    const std::string path = file.output_path + "/slim_init_starts.csv";
    csv.open(path);
    if (csv.is_open()) {
      csv << startRecordHeader() << std::endl;
    } else {
      report(ReportLevel::kWarn,
             path + " cannot be written; the rows are published on the topic only");
    }
  }

  void record(const std::string& action, const HostAnswer& answer, const StockStart* stock) {
    const std::string row = startRecordRow(file.mode, action, answer, stock);
    if (csv.is_open()) csv << row << std::endl;
    report(ReportLevel::kRow, row);
  }

  // Once, before the first attempt: after it the host may have been seeded already.
  void reportMissingLines() {
    if (std::exchange(lines_reported, true) || adapter->counts().lines_merged > 0) return;
    report(ReportLevel::kWarn, "no line message has met a frame: initializing on points alone");
  }

  // Reports an answer unless it repeats the one before.
  void reportAnswer(const std::string& action, const HostAnswer& answer) {
    const InitStatus status = answer.verdict.status;
    const bool repeated = !answer.success() && status == reported_status &&
                          std::abs(answer.stamp - reported_stamp) < kRepeatReport;
    if (repeated && action != "recover") return;
    reported_status = status;
    reported_stamp = answer.stamp;
    std::ostringstream out;
    out.precision(3);
    out << action << " " << (answer.success() ? "done" : toString(status)) << ": " << answer.message
        << " (" << std::fixed << answer.data_s << " s of data, " << answer.total_ms << " ms)";
    report(answer.success() || isWait(status) ? ReportLevel::kInfo : ReportLevel::kWarn, out.str());
  }

  // Once per start: what the user should know, and how the file should read.
  void reportCalibration(const InitResult& verdict) {
    for (const std::string& warning : verdict.warnings) report(ReportLevel::kWarn, warning);
    if (!verdict.calibration.has_value()) return;
    const std::string lines = calibrationLines(file.rig, *verdict.calibration);
    if (lines.empty()) return;
    report(ReportLevel::kWarn,
           "the calibration that was found differs from the file; lines for it:\n" + lines);
  }
};

HostGlue::HostGlue() : state_(new State) {}
HostGlue::~HostGlue() = default;

void HostGlue::listen(const Listener& listener) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->listener = listener;
}

bool HostGlue::open(const std::string& config_file) {
  State& state = *state_;
  std::string error;
  HostFile file;
  // First our three keys alone: in a stock host the rest of the file is not checked.
  if (!readHostFile(config_file, &file, &error)) {
    state.report(ReportLevel::kError, error + "; the host initializes by itself");
    return false;
  }
  if (file.mode == HostMode::kStock && !file.reinit) return false;
  std::unique_ptr<HostAdapter> adapter = openHostFile(config_file, &file, &error);
  if (adapter == nullptr) {
    state.report(ReportLevel::kError, error + "; the host initializes by itself");
    return false;
  }
  return open(std::move(adapter), file);
}

bool HostGlue::open(std::unique_ptr<HostAdapter> adapter, const HostFile& file) {
  State& state = *state_;
  state.adapter = std::move(adapter);
  state.file = file;
  if (state.file.mode == HostMode::kShadow && state.file.reinit) {
    state.file.reinit = false;
    state.file.notes.push_back("reinit is set and has no effect with initializer: shadow");
  }
  for (const std::string& note : state.file.notes) state.report(ReportLevel::kInfo, note);
  state.report(ReportLevel::kInfo, std::string("initializer: ") + toString(state.file.mode) +
                                       ", reinit: " + (state.file.reinit ? "1" : "0") +
                                       ", method " + state.adapter->method());
  state.openCsv();
  state.active = true;
  return true;
}

bool HostGlue::active() const { return state_->active; }
bool HostGlue::decides() const { return active() && state_->file.mode == HostMode::kSlim; }
bool HostGlue::shadows() const { return active() && state_->file.mode == HostMode::kShadow; }
bool HostGlue::reinit() const { return active() && state_->file.reinit; }

void HostGlue::addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro) {
  // The host hands the sample after a frame over again with the next frame.
  if (!active() || t == state_->last_imu) return;
  State& state = *state_;
  state.last_imu = t;
  if (state.adapter->addImu(t, accel, gyro) != AddStatus::kGlitch) return;
  if (std::exchange(state.glitch_reported, true)) return;
  ImuSample glitch;
  glitch.accel = accel;
  glitch.gyro = gyro;
  state.report(ReportLevel::kWarn, "an IMU sample of " + state.file.imu_limits.describe(glitch) +
                                       " is dropped, and so are all others beyond these bounds");
}

void HostGlue::addPoints(double stamp, const std::vector<GluePoint>& points, double td) {
  State& state = *state_;
  FrameObservation frame;
  frame.t = stamp;
  frame.points.reserve(points.size());
  for (const GluePoint& point : points) {
    PointObservation observation;
    observation.id = point.id;
    observation.bearing = Eigen::Vector3d(point.x, point.y, point.z);
    observation.pixel = Eigen::Vector2d(point.u, point.v);
    frame.points.push_back(observation);
  }
  state.adapter->setTd(td);
  state.adapter->addFrame(std::move(frame));
}

void HostGlue::addLineCloud(const GlueCloud& cloud) {
  FrameObservation frame;
  std::string error;
  if (readLineMessage(cloud, &frame, &error)) {
    state_->adapter->addLines(frame.t, std::move(frame.lines));
  } else {
    state_->report(ReportLevel::kWarn, error + "; the message is dropped");
  }
}

bool HostGlue::seedWindow(const std::vector<double>& stamps, GlueWindow* window,
                          bool* drop_oldest) {
  State& state = *state_;
  state.reportMissingLines();
  // After a failure the odometry frame continues where the IMU can still carry it.
  const double since_lost = stamps.front() - state.lost.stamp;
  const bool join = state.is_lost && reinit() && since_lost >= 0.0 &&
                    since_lost <= state.adapter->options().max_join_s;
  const HostAnswer answer =
      join ? state.adapter->recover(stamps, state.lost) : state.adapter->seed(stamps);
  const std::string action = join ? "join" : "seed";
  state.record(action, answer, nullptr);
  state.reportAnswer(action, answer);
  if (answer.success()) {
    *window = toGlueWindow(answer, state.adapter->calibration(), state.adapter->options());
    state.reportCalibration(answer.verdict);
    return true;
  }
  // At rest the host keeps its oldest frames, which no window of ours will ever reach.
  *drop_oldest = stamps.back() - stamps.front() > state.adapter->maxWindowSpan();
  return false;
}

bool HostGlue::solveRecovery(const std::vector<double>& stamps, bool failed, GlueWindow* window) {
  State& state = *state_;
  state.reportMissingLines();
  if (state.healthy.empty()) {
    state.report(ReportLevel::kWarn, "recover: the host had no healthy state yet");
    return false;
  }
  HostState last = state.healthy.back();
  if (failed) {
    // Newest first, so that the last one taken is the newest old enough.
    for (auto it = state.healthy.rbegin(); it != state.healthy.rend(); ++it) {
      last = *it;
      if (stamps.back() - last.stamp >= kSuspect) break;
    }
    state.lost = last;
    state.is_lost = true;
  }
  const HostAnswer answer = state.adapter->recover(stamps, last);
  state.record("recover", answer, nullptr);
  state.reportAnswer("recover", answer);
  if (!answer.success()) return false;
  // What the host has learned about its calibration in flight stays.
  static_cast<HostWindow&>(*window) = answer.window;
  return true;
}

void HostGlue::addHealthy(const HostState& newest) {
  State& state = *state_;
  state.is_lost = false;
  state.healthy.push_back(newest);
  while (state.healthy.front().stamp < newest.stamp - kHealthyKept) state.healthy.pop_front();
  // After a stream that started anew the old states are of another time.
  while (state.healthy.front().stamp > newest.stamp) state.healthy.pop_front();
}

void HostGlue::timeStock() {
  if (shadows()) state_->stock_began = Clock::now();
}

void HostGlue::recordShadow(const std::vector<HostState>& window, bool tried, bool result) {
  State& state = *state_;
  state.reportMissingLines();
  StockStart stock;
  stock.tried = tried;
  stock.success = result;
  if (tried) {
    stock.ms = std::chrono::duration<double, std::milli>(Clock::now() - state.stock_began).count();
  }
  if (result) stock.window.states = window;
  std::vector<double> stamps;
  for (const HostState& frame : window) stamps.push_back(frame.stamp);
  const HostAnswer answer = state.adapter->seed(stamps);
  state.record("seed", answer, &stock);
  state.reportAnswer("shadow", answer);
  if (result && answer.success()) state.reportCalibration(answer.verdict);
}

void HostGlue::requestRecovery(bool reset_if_refused) {
  if (!reinit()) {
    state_->report(ReportLevel::kWarn, "a recovery was requested and reinit is 0");
    return;
  }
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->requested = true;
  state_->reset_if_refused = reset_if_refused;
}

bool HostGlue::takeRequest(bool* reset_if_refused) {
  if (!reinit()) return false;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (!state_->requested) return false;
  state_->requested = false;
  *reset_if_refused = state_->reset_if_refused;
  return true;
}

void HostGlue::requestReset() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->reset_wanted = true;
}

bool HostGlue::takeReset() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return std::exchange(state_->reset_wanted, false);
}

}  // namespace slim_init::vins_adapter
