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
#include <set>
#include <utility>

#include "calibration_advice.h"
#include "slim_init/host_health/flight_monitor.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/result.h"
#include "slim_init/text.h"
#include "slim_init/vins_adapter/feature_message.h"
#include "slim_init/vins_adapter/host_convention.h"
#include "slim_init/vins_adapter/host_file.h"
#include "start_record.h"

namespace slim_init::vins_adapter {

using namespace host_health;  // NOLINT: the vocabulary of this file
namespace {

using Clock = std::chrono::steady_clock;

// States of the host from the last moments before it noticed a failure are not trusted [s].
constexpr double kSuspect = 0.5;
// Healthy states kept [s], besides those of the host's window: in slow motion it reaches far back,
// and what is not in ours is filled from them.
constexpr double kHealthyKept = 30.0;
// Damage of the IMU that began so long ago has not made the host fail [s].
constexpr double kOldDamage = 5.0;
// A gap in the images after which the tracker begins anew, and one that the IMU alone bridges well
// enough for the optimization that follows [s].
constexpr double kShortestGap = 0.9;
constexpr double kLongestGap = 3.0;
// States that are wrong for so long, without a recovery: the host starts anew [s].
constexpr double kLongestAlarm = 3.0;
// The health of a healthy host, and how well its odometry frame is known, are published so often
// [s]. A refused recovery is reported no more often either.
constexpr double kHealthEvery = 1.0;
// Odometry that is further behind the newest image than this is reported [s], and so often.
constexpr double kLongestDelay = 0.3;
// After a refused recovery the next one is tried after this time, twice as long after the next
// refusal, and at most kLongestPause [s].
constexpr double kFirstPause = 0.1;
constexpr double kLongestPause = 0.4;
// An unchanged status is reported again after this time [s].
constexpr double kRepeatReport = 5.0;
// A td handed over may lie so much of the time between two frames below the host's.
constexpr double kMostTdStep = 0.9;
// A heading that is less certain has not been measured, and the position neither [deg].
constexpr double kMostTurned = 30.0;
// So much more uncertainty of the odometry frame is a warning [m].
constexpr double kUncertainFrame = 1.0;
// Without IMU data: standard deviations of the speed [m/s], at least, and of the turning [deg/s].
constexpr double kUnknownSpeed = 1.0;
constexpr double kUnknownTurn = 57.3;

constexpr double kNever = -std::numeric_limits<double>::infinity();

// A report about one thing, no more often than wanted.
class Repeated {
 public:
  // Whether the last one is `every` [s] ago; then `stamp` [s] is that of the last one.
  bool isDue(double stamp, double every) {
    if (std::abs(stamp - last_) < every) return false;
    last_ = stamp;
    return true;
  }

 private:
  double last_ = kNever;
};

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// The shortest time between two frames [s].
double shortestInterval(const std::vector<HostState>& states) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < states.size(); ++i) {
    shortest = std::min(shortest, states[i].stamp - states[i - 1].stamp);
  }
  return shortest;
}

std::string whyDropped(AddStatus status) {
  switch (status) {
    case AddStatus::kNotFinite: return "a value is not finite";
    case AddStatus::kGlitch: return text("it is faster than ", StreamCheck::kMaxSpeed, " m/s");
    case AddStatus::kNoCovariance: return "its covariance is not positive definite";
    case AddStatus::kNotCalibrated: return "speed_rotation and speed_translation are missing";
    case AddStatus::kStray:
      return text("its stamp is more than ", StreamCheck::kJump, " s from IMU and images");
    case AddStatus::kNotSupported: return "the method does not use velocities";
    default: return "its stamp is not after that of the velocity before it";
  }
}

}  // namespace

struct HostGlue::State {
  std::unique_ptr<HostAdapter> adapter;
  HostFile file;  // its keep_heading also in a host that initializes by itself
  std::atomic<bool> active{false};

  std::atomic<double> last_imu{kNotComputed};  // stamp [s]
  std::atomic<bool> time_went_back{false};

  // Touched by the processing thread alone.
  bool glitch_reported = false;
  bool suspect_reported = false;
  bool lines_reported = false;
  std::deque<HostState> healthy;
  std::optional<HostState> lost;  // the last healthy state before a failure without a recovery
  FlightMonitor monitor;
  CalibrationAdvice advice;
  bool rides = false;             // through a gap in the images
  bool pending = false;           // the recovery that was wanted last has not been solved yet
  bool frame_suspect = false;     // the newest frame was, before its optimization
  double pause = 0.0;             // after the last refused recovery [s]
  double next_recovery = kNever;  // stamp [s]
  int unreported_refusals = 0;
  Repeated health_reports, delay_reports, drop_reports, damage_reports, refusal_reports;
  StreamCounts counts_reported;
  std::atomic<double> newest_received{kNotComputed};
  Clock::time_point frame_began;
  double frame_ms = 0.0;  // from the host's frame to its health
  // The odometry frame since the start of the run or the last one that could not be continued.
  double frame_since = kNotComputed;
  double frame_variance = 0.0;      // of its position, worst axis [m^2]
  double frame_yaw_variance = 0.0;  // [deg^2]
  double frame_reported = 0.0;      // its standard deviation at the last warning [m]
  Clock::time_point stock_began;
  InitStatus reported_status = InitStatus::kSuccess;
  double reported_stamp = kNever;
  std::ofstream csv;

  // Request and listener come from other threads.
  std::mutex mutex;
  Listener listener;
  bool requested = false;
  bool reset_if_refused = false;
  bool reset_wanted = false;
  std::set<AddStatus> speeds_reported;  // what became of refused ones

  void report(ReportLevel level, const std::string& text) {
    Listener to;
    {
      const std::lock_guard<std::mutex> lock(mutex);
      to = listener;
    }
    if (to) to(level, text);
  }

  void take(const HostFile& keys) {
    if (keys.keep_heading && !file.keep_heading) {
      report(ReportLevel::kInfo,
             "keep_heading: 1, the host's optimizations keep the heading of its oldest frame");
    }
    file.keep_heading = keys.keep_heading;
  }

  // How far the body may be from where it was [m].
  double heldSigma(double stamp) const {
    return std::max(stamp - lost->stamp, 0.0) * std::max(lost->V.norm(), kUnknownSpeed);
  }
  // Where the IMU says less of the position.
  void holdPosition(double stamp, HostPropagation* propagated) const {
    const double held = std::hypot(heldSigma(stamp), propagated->start_sigma);
    if (!(propagated->position_sigma > held)) return;
    propagated->state.P = lost->P;
    propagated->position_sigma = held;
    propagated->message += roundedText(3, "; the position is held, standard deviation ",
                                       propagated->position_sigma, " m");
  }
  // The state before the failure or reset, in the odometry frame, at a stamp after it. Without IMU
  // data it stays where it was: a new origin would turn the world of whoever uses the odometry.
  HostPropagation continued(double stamp) const {
    HostPropagation propagated = adapter->propagate(*lost, stamp);
    if (propagated.ok && propagated.yaw_sigma_deg <= kMostTurned) {
      holdPosition(stamp, &propagated);
      return propagated;
    }
    propagated.ok = false;
    const double age = std::max(stamp - lost->stamp, 0.0);
    propagated.state = *lost;
    propagated.state.stamp = stamp;
    propagated.position_sigma = heldSigma(stamp);
    propagated.yaw_sigma_deg = std::min(age * kUnknownTurn, 180.0);
    propagated.message = roundedText(
        3, "IMU data do not cover ", age, " s: position and heading are held, standard deviation ",
        propagated.position_sigma, " m and ", propagated.yaw_sigma_deg, " deg of yaw");
    return propagated;
  }
  void lose(const HostState& last) {
    lost = last;
    adapter->lose(last);
  }
  bool continues(double stamp) const { return lost && file.reinit && stamp >= lost->stamp; }

  // The odometry goes on from a propagated state.
  void continueFrame(double stamp, const HostPropagation& propagated) {
    report(ReportLevel::kInfo, "the odometry frame is continued: " + propagated.message);
    widenFrame(propagated.position_sigma, propagated.yaw_sigma_deg);
    publishFrame(stamp);
  }
  void beginFrame(double stamp) {
    frame_since = stamp;
    frame_variance = frame_yaw_variance = frame_reported = 0.0;
    publishFrame(stamp);
  }
  // By standard deviations [m, deg]. The states are healthy again soon, the frame is not: users who
  // do not read its topic are told, too.
  void widenFrame(double position_sigma, double yaw_sigma_deg) {
    frame_variance += position_sigma * position_sigma;
    frame_yaw_variance += yaw_sigma_deg * yaw_sigma_deg;
    const double sigma = std::sqrt(frame_variance);
    if (!(sigma > frame_reported + kUncertainFrame)) return;
    frame_reported = sigma;
    report(ReportLevel::kWarn, roundedText(2, "the odometry frame is uncertain: its position to ",
                                           sigma, " m, its heading to ", yawSigmaDeg(), " deg"));
  }
  double yawSigmaDeg() const { return std::min(std::sqrt(frame_yaw_variance), 180.0); }
  void publishFrame(double stamp) {
    if (std::isnan(frame_since)) frame_since = stamp;
    report(ReportLevel::kFrame, roundedText(4, std::fixed, stamp, ',', frame_since, ',',
                                            std::sqrt(frame_variance), ',', yawSigmaDeg()));
  }
  // Healthy states up to this one.
  std::vector<HostState> healthyUntil(const HostState& last) const {
    std::vector<HostState> states;
    for (const HostState& one : healthy) {
      if (one.stamp < last.stamp) states.push_back(one);
    }
    states.push_back(last);
    return states;
  }
  // The newest healthy state from before the failure.
  HostState healthyBefore(double newest, bool failed) const {
    HostState last = healthy.back();
    if (!failed) return last;
    const double begin = adapter->lastDamage().first;
    for (auto it = healthy.rbegin(); it != healthy.rend(); ++it) {
      last = *it;
      // With the watchdog only states that it trusts are here, but it takes a while to notice.
      if (newest - last.stamp < kSuspect) continue;
      if (last.stamp <= begin || newest - begin > kOldDamage) break;
    }
    return last;
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

  void record(const std::string& action, const HostResult& answer, const StockStart* stock) {
    const std::string row = startRecordRow(file.mode, action, answer, stock);
    if (csv.is_open()) csv << row << std::endl;
    report(ReportLevel::kRow, row);
  }

  // Once, before the first attempt: after it the host may have been seeded already.
  void reportMissingLines() {
    if (std::exchange(lines_reported, true) || adapter->info().counts.lines[AddStatus::kAdded] > 0)
      return;
    report(ReportLevel::kWarn, "no line features received; using points only");
  }

  // Reports an answer; false if there is none yet, or it repeats the one before.
  bool reportAnswer(const std::string& action, const HostResult& answer) {
    if (answer.pending) return false;
    const InitStatus status = answer.result.status;
    const bool recovery = action == "recover";
    const double every = recovery ? kHealthEvery : kRepeatReport;
    const bool same = recovery ? !answer.success() : status == reported_status;
    if (!answer.success() && same && std::abs(answer.stamp - reported_stamp) < every) {
      unreported_refusals += recovery ? 1 : 0;
      return false;
    }
    reported_status = status;
    reported_stamp = answer.success() ? kNever : answer.stamp;
    const int refusals = std::exchange(unreported_refusals, 0);
    report(answer.success() || isWait(status) ? ReportLevel::kInfo : ReportLevel::kWarn,
           roundedText(3, action, " ", answer.success() ? "done" : toString(status), ": ",
                       withRemedy(answer.message, status), " (", std::fixed, answer.data_s,
                       " s of data, ", answer.solve_ms, " ms",
                       refusals > 0 ? roundedText(0, ", after ", refusals, " refusals") : "", ')'));
    return true;
  }

  // Where the host estimates its calibration, the one that was found is its starting value; where
  // it does not, nothing of its own is changed.
  GlueWindow windowOf(const HostResult& answer, const std::vector<double>& stamps) const {
    GlueWindow window;
    static_cast<HostWindow&>(window) = answer.window;
    window.intervals = adapter->imuIntervals(stamps);
    const Calibration host = adapter->info().calibration;
    const HostOptions options = adapter->options();
    const OptionalCalibration& found = answer.result.calibration;
    window.ric = found && options.estimate_extrinsic ? found->R_b_c : host.R_b_c;
    window.tic = found && options.estimate_extrinsic ? found->t_b_c : host.t_b_c;
    if (found && options.estimate_td) {
      // A frame must not begin before the one before it has ended: the host would abort.
      window.td = std::max(found->td, host.td - kMostTdStep * shortestInterval(window.states));
    }
    return window;
  }

  // What the user should know of a start; how the file should read when several windows agree.
  void reportStart(const HostResult& answer) {
    for (const std::string& warning : answer.result.warnings) report(ReportLevel::kWarn, warning);
    addCalibration(answer.stamp, answer.result.calibration);
  }
  void addCalibration(double stamp, const OptionalCalibration& found) {
    const std::string text = advice.add(stamp, found);
    if (!text.empty()) report(ReportLevel::kWarn, text);
  }

  // How far the odometry is behind the newest image that has arrived [s]; NaN: not known.
  double delayOf(double stamp) const { return newest_received - stamp; }
  void reportDelay(double stamp) {
    const double delay = delayOf(stamp);
    if (!(delay > kLongestDelay) || !delay_reports.isDue(stamp, kRepeatReport)) return;
    report(ReportLevel::kWarn,
           roundedText(3, "odometry is ", delay, " s behind the newest image (limit ",
                       kLongestDelay, "): the last frame took the host ", frame_ms, " ms"));
  }
  // Everything that the host has handed over and that is used for nothing.
  void reportDropped(double stamp) {
    const StreamCounts counts = adapter->info().counts;
    const std::string list = droppedSince(counts_reported, counts);
    if (list.empty() || !drop_reports.isDue(stamp, kRepeatReport)) return;
    counts_reported = counts;
    report(ReportLevel::kWarn, "discarded: " + list);
  }
  void publishHealth(double stamp, const HostHealth& health) {
    report(ReportLevel::kHealth,
           roundedText(4, std::fixed, stamp, ',', toString(monitor.status()), ',',
                       health.reprojection_px, ',', health.velocity_mps, ',', health.rotation_deg,
                       ',', delayOf(stamp), ",\"", health.reason, '"'));
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
  // First our own keys alone: in a stock host the rest of the file is not checked.
  if (!readHostFile(config_file, &file, &error)) {
    state.report(ReportLevel::kError, error + "; the host initializes by itself");
    return false;
  }
  state.take(file);
  if (file.mode == HostMode::kStock && !file.reinit && !file.watchdog) return false;
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
  state.take(file);
  state.file = file;
  if (file.mode == HostMode::kShadow) state.file.reinit = state.file.watchdog = false;
  for (const std::string& note : state.file.notes) state.report(ReportLevel::kInfo, note);
  state.report(ReportLevel::kInfo, std::string("initializer: ") + toString(state.file.mode) +
                                       ", reinit: " + (state.file.reinit ? "1" : "0") +
                                       ", watchdog: " + (state.file.watchdog ? "1" : "0") +
                                       ", method " + state.adapter->info().method);
  state.openCsv();
  state.advice = CalibrationAdvice(state.file.rig);
  state.active = true;
  return true;
}

bool HostGlue::active() const { return state_->active; }
bool HostGlue::decides() {
  state_->stock_began = Clock::now();
  return active() && state_->file.mode == HostMode::kSlim;
}
bool HostGlue::reinit() const { return active() && state_->file.reinit; }

void HostGlue::addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro) {
  // The host hands the sample after a frame over again with the next frame.
  if (!active() || t == state_->last_imu) return;
  State& state = *state_;
  // One incorrect stamp among refused samples was no jump.
  if (t > state.last_imu) state.time_went_back = false;
  state.last_imu = t;
  if (state.adapter->addImu(t, accel, gyro) != AddStatus::kGlitch) return;
  ImuSample glitch;
  glitch.accel = accel;
  glitch.gyro = gyro;
  const ImuLimits limits = state.adapter->options().imu;
  const bool beyond = limits.exceededBy(glitch);
  if (std::exchange(beyond ? state.glitch_reported : state.suspect_reported, true)) return;
  const std::string what = "an IMU sample of " + limits.describe(glitch);
  state.report(ReportLevel::kWarn,
               beyond
                   ? what + " is discarded, as all others beyond these limits"
                   : what + " is discarded: frozen, far from those before, or among such samples");
}

void HostGlue::received(double stamp) {
  if (!active()) return;
  state_->newest_received = stamp;
  state_->adapter->received(stamp);
}

void HostGlue::addPoints(double stamp, const std::vector<double>& points, double td) {
  State& state = *state_;
  state.frame_began = Clock::now();
  state.adapter->setTd(td);
  state.adapter->addFrame(toFrame(stamp, points));
  state.reportDropped(stamp);
}

void HostGlue::addLineCloud(const GlueCloud& cloud) {
  FrameObservation frame;
  std::string error;
  if (readLineMessage(cloud, &frame, &error)) {
    state_->adapter->addLines(frame.t, std::move(frame.lines));
  } else {
    state_->report(ReportLevel::kWarn, error + "; the message is discarded");
  }
}

std::string HostGlue::speedTopic() const {
  return active() ? state_->file.speed_topic : std::string();
}

void HostGlue::addSpeed(double t, const Eigen::Vector3d& velocity,
                        const Eigen::Matrix3d& covariance) {
  if (!active()) return;
  State& state = *state_;
  SpeedSample sample;
  sample.t = t;
  sample.velocity = velocity;
  sample.covariance = covariance;
  sample.forward_only = state.file.speed_forward_only;
  const AddStatus status = state.adapter->addSpeed(sample);
  if (isAdded(status)) return;
  {
    const std::lock_guard<std::mutex> lock(state.mutex);
    if (!state.speeds_reported.insert(status).second) return;
  }
  state.report(
      ReportLevel::kWarn,
      text("a measured velocity of ", velocity.transpose(), " m/s at ", std::fixed, t,
           " s is discarded, as all others of which the following holds: ", whyDropped(status)));
}

bool HostGlue::seedWindow(const std::vector<HostState>& frames, GlueWindow* window,
                          bool* drop_oldest) {
  State& state = *state_;
  const std::vector<double> stamps = stampsOf(frames);
  state.reportMissingLines();
  const bool join = state.continues(stamps.front());
  HostPropagation propagated;
  if (join) propagated = state.continued(stamps.front());
  // With the state from before, if the IMU has propagated it; else in its place.
  HostResult answer =
      propagated.ok ? state.adapter->recover(stamps, {*state.lost}) : state.adapter->seed(stamps);
  if (answer.no_recovery) {
    propagated.ok = false;
    answer = state.adapter->seed(stamps);
  }
  const std::string action = join ? "join" : "seed";
  if (state.reportAnswer(action, answer)) state.record(action, answer, nullptr);
  if (!answer.success()) {
    // At rest the host keeps its oldest frames, which no window of ours will ever reach.
    *drop_oldest = stamps.back() - stamps.front() > state.adapter->info().window_span_s;
    return false;
  }
  *window = state.windowOf(answer, stamps);
  state.monitor.reset();
  if (join) {
    if (propagated.ok) {
      propagated = answer.frame;
      propagated.state = window->states.front();
      state.holdPosition(stamps.front(), &propagated);
    }
    moveWindow(propagated.state, window);
    state.monitor.doubt(stamps.back());
  }
  state.reportStart(answer);
  if (join) {
    state.continueFrame(stamps.back(), propagated);
  } else {
    state.beginFrame(stamps.back());
  }
  return true;
}

// Not while the solve runs: the request is then served with the next frame.
bool HostGlue::resetsAfterRefusal() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->requested = state_->requested || state_->pending;
  return state_->reset_if_refused && !state_->pending;
}

bool HostGlue::solveRecovery(const std::vector<HostState>& frames, bool failed,
                             GlueWindow* window) {
  State& state = *state_;
  const std::vector<double> stamps = stampsOf(frames);
  state.pending = false;
  state.reportMissingLines();
  if (state.healthy.empty()) {
    if (state.refusal_reports.isDue(stamps.back(), kRepeatReport)) {
      state.report(ReportLevel::kWarn, "recover: the host has had no healthy state yet");
    }
    return false;
  }
  failed = failed || state.monitor.status() == FlightStatus::kWrong;
  const HostState last = state.healthyBefore(stamps.back(), failed);
  if (failed) state.lose(last);
  const std::vector<HostState> healthy = state.healthyUntil(last);
  const HostResult answer = state.adapter->recover(stamps, healthy);
  if (answer.pending) {
    state.pending = true;
    if (!failed) return false;
    const HostResult bridge = state.adapter->bridge(stamps, healthy);
    *window = state.windowOf(bridge, stamps);
    return bridge.success();
  }
  state.record("recover", answer, nullptr);
  state.reportAnswer("recover", answer);
  if (!answer.success()) {
    state.pause = std::min(std::max(2.0 * state.pause, kFirstPause), kLongestPause);
    state.next_recovery = stamps.back() + state.pause;
    return false;
  }
  // What the host has learned about its calibration in flight stays.
  *window = state.windowOf(answer, stamps);
  state.pause = 0.0;
  state.monitor.recovered(stamps.back());
  if (failed) state.continueFrame(stamps.back(), answer.frame);
  return true;
}

bool HostGlue::judgeWindow(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                           const Eigen::Vector3d& tic) {
  State& state = *state_;
  if (!state.file.watchdog) return false;
  const double stamp = window.back().stamp;
  const FlightStatus before = state.monitor.status();
  const HostHealth health =
      state.adapter->watch(window, ric, tic, state.monitor.wantsEvidence(stamp));
  const std::string finding = state.monitor.update(stamp, health);
  const FlightStatus status = state.monitor.status();
  if (!finding.empty()) {
    state.report(status == FlightStatus::kWrong ? ReportLevel::kWarn : ReportLevel::kInfo,
                 "watchdog: " + finding);
  }
  state.addCalibration(stamp, health.calibration);
  state.frame_ms = millisecondsSince(state.frame_began);
  state.reportDelay(stamp);
  const bool is_news = status != FlightStatus::kGood || status != before;
  if (state.health_reports.isDue(stamp, is_news ? 0.0 : kHealthEvery)) {
    state.publishHealth(stamp, health);
    state.publishFrame(stamp);
  }
  if (status != FlightStatus::kWrong || !state.file.reinit) return false;
  if (stamp - state.monitor.alarmStamp() > kLongestAlarm) {
    state.monitor.restartAlarm(stamp);
    state.report(ReportLevel::kWarn, "watchdog: recovery failed for 3 s; restarting the estimator");
    requestRecovery(true);
  }
  return stamp >= state.next_recovery;
}

void HostGlue::imuRefused(double t) {
  if (state_->last_imu - t > StreamCheck::kJump) state_->time_went_back = true;
}

bool HostGlue::bridgesGap(const std::vector<double>& waiting) {
  State& state = *state_;
  if (!reinit() || state.time_went_back) return false;
  if (state.healthy.empty() || state.monitor.suspectsFrame() ||
      state.monitor.status() == FlightStatus::kWrong) {
    return false;
  }
  const double healthy = state.healthy.back().stamp;
  double newest = state.last_imu;
  for (const double stamp : waiting) {
    if (stamp - newest > host_health::ImuScreen::kBridge) return false;
    newest = stamp;
  }
  const double gap = newest - healthy;
  // Less, and there are no samples of the gap.
  if (!(gap >= kShortestGap && gap <= kLongestGap)) return false;
  if (state.adapter->lastDamage().second > healthy) return false;
  state.report(ReportLevel::kInfo, roundedText(3, "the tracker was restarted after ", gap,
                                               " s without images; the host continues by its IMU"));
  state.rides = true;
  return true;
}

bool HostGlue::endsRide() { return std::exchange(state_->rides, false); }

void HostGlue::hostCleared() {
  State& state = *state_;
  const bool suspect = state.monitor.status() != FlightStatus::kGood;
  state.monitor.reset();
  state.time_went_back = false;
  if (active()) state.adapter->flightEnded();
  state.pause = 0.0;
  state.next_recovery = kNever;
  if (!reinit()) return;
  takeRequest();  // of the flight that has ended
  state.rides = false;
  if (!state.lost && !state.healthy.empty()) {
    // A tracker's restart finds the host in good health; after a refused request nobody knows.
    state.lose(state.healthyBefore(state.healthy.back().stamp, suspect));
  }
  state.healthy.clear();
}

HostPreparation HostGlue::prepareFrame(const std::vector<HostState>& window,
                                       const Eigen::Matrix3d& ric, const Eigen::Vector3d& tic) {
  State& state = *state_;
  HostPreparation frame = state.adapter->prepare(window, ric, tic);
  std::sort(frame.moving.begin(), frame.moving.end());
  const double stamp = window.back().stamp;
  const bool damaged = !frame.intervals.empty() && frame.intervals.back().damaged;
  state.frame_suspect = damaged || frame.suspect;
  if (state.frame_suspect || frame.position_sigma > 0.0) state.monitor.doubt(stamp);
  state.widenFrame(frame.position_sigma, frame.yaw_sigma_deg);
  if (frame.message.empty() && damaged) {
    frame.message = "IMU data discarded or missing; relying on vision";
  }
  if (!frame.message.empty() && state.damage_reports.isDue(stamp, kRepeatReport)) {
    state.report(ReportLevel::kWarn, frame.message);
  }
  return frame;
}

void HostGlue::addHealthy(const std::vector<HostState>& window) {
  State& state = *state_;
  const HostState& newest = window.back();
  // Without the watchdog nothing else keeps a state out that no start could continue.
  if (state.monitor.suspectsFrame() || state.monitor.status() == FlightStatus::kWrong ||
      state.frame_suspect || !fromHostState(newest, 0.0).isFinite()) {
    return;
  }
  state.lost.reset();
  state.adapter->learn(newest);
  if (state.healthy.empty()) {
    state.healthy.assign(window.begin(), window.end());
  } else {
    state.healthy.push_back(newest);
  }
  // At rest the window has older ones. After a stream that started anew all are of another time.
  const std::vector<double> in_window = stampsOf(window);
  const auto isOld = [&](const HostState& one) {
    return one.stamp > newest.stamp ||
           (one.stamp < newest.stamp - kHealthyKept &&
            !std::binary_search(in_window.begin(), in_window.end(), one.stamp));
  };
  state.healthy.erase(std::remove_if(state.healthy.begin(), state.healthy.end(), isOld),
                      state.healthy.end());
}

bool HostGlue::takeStock(bool tried, bool result, HostWindow* window) {
  State& state = *state_;
  const double first = window->states.front().stamp, newest = window->states.back().stamp;
  if (state.file.mode == HostMode::kStock && result) {
    if (!state.continues(first)) {
      state.beginFrame(newest);
      return false;
    }
    const HostPropagation propagated = state.continued(first);
    state.monitor.doubt(newest);
    state.continueFrame(first, propagated);
    moveWindow(propagated.state, window);
    return true;
  }
  if (state.file.mode != HostMode::kShadow) return false;
  state.reportMissingLines();
  StockStart stock;
  stock.tried = tried;
  stock.success = result;
  if (tried) stock.ms = millisecondsSince(state.stock_began);
  if (result) stock.window = *window;
  const HostResult answer = state.adapter->seed(stampsOf(window->states));
  state.record("seed", answer, &stock);
  state.reportAnswer("shadow", answer);
  if (result && answer.success()) state.reportStart(answer);
  return false;
}

void HostGlue::requestRecovery(bool reset_if_refused) {
  if (!reinit()) {
    state_->report(ReportLevel::kWarn, "a recovery was requested and is off: set reinit: 1");
    return;
  }
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->requested = true;
  state_->reset_if_refused = reset_if_refused;
}

bool HostGlue::takeRequest() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return std::exchange(state_->requested, false);
}

void HostGlue::keepHeading(const Eigen::Matrix3d& before, const Eigen::Matrix3d& optimized,
                           Eigen::Matrix3d* turn) const {
  if (state_->file.keep_heading) turnAboutVertical(before, optimized, turn);
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
