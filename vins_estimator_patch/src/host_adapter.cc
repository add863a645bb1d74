// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_adapter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <sstream>
#include <utility>

#include "first_state_prior.h"
#include "imu_carry.h"
#include "imu_screen.h"
#include "sensor_memory.h"
#include "slim_init/row_times.h"
#include "watchdog.h"

namespace slim_init::vins_adapter {
namespace {

// The td of older frames is forgotten [s]; more than the reach of any window of a host.
constexpr double kTdKept = 20.0;
// Frames kept for the watchdog [s].
constexpr double kFramesKept = 5.0;
// The initializer is asked about a host that seems sane [s].
constexpr double kAskEvery = 1.0;
// Frames in a row that have to speak against a host where the initializer has no answer.
constexpr int kSuspectFrames = 3;
constexpr double kRadToDeg = 57.29577951308232;
// Healthy states handed to the initializer, and the time between them [s].
constexpr std::size_t kMostPriors = 6;
constexpr double kBetweenPriors = 0.25;
// Stamps of one frame differ by no more [s]; it has been added to td and back.
constexpr double kSameFrame = 1e-6;
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
                                                   {"max_join_s", max_join_s},
                                                   {"max_join_sigma_m", max_join_sigma_m},
                                                   {"max_join_sigma_deg", max_join_sigma_deg}};
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
  // A restart makes it forget the streams; `status` is what became of the message.
  AddStatus noteRestart(AddStatus status) {
    if (status == AddStatus::kRestarted) {
      forget();
      memory.restore(memory.learned());  // its stamps are of another run
    }
    return status;
  }
  void forget() {
    first_stamp = kNotComputed;
    td_of.clear();
    frames.clear();
    screen.reset();
    last_asked = -std::numeric_limits<double>::infinity();
    contradictions = suspect_frames = 0;
    steady_biases = SteadyBiases();
    flown = OptionalCalibration();
  }
  HostHealth judge(const std::vector<HostState>& window, const Calibration& calibration);
  std::string ask(const NavState& newest, bool* answered);
  // With the td that the host had when it paired the frame of that stamp with its IMU data [s].
  double hostTime(double stamp) const {
    const auto it = td_of.find(stamp);
    return stamp + (it == td_of.end() ? initializer->calibration().td : it->second);
  }

  HostAnswer solve(const std::vector<double>& stamps, const std::vector<HostState>* healthy);
  std::vector<StatePrior> priorsOf(const std::vector<HostState>& healthy) const;
  std::vector<NavState> keptStates(const std::vector<double>& stamps, double begin,
                                   const std::vector<HostState>* healthy) const;
  bool fillWindow(const std::vector<double>& stamps, const std::vector<HostState>* healthy,
                  HostAnswer* answer, InitStatus* status, std::string* problem) const;

  mutable std::mutex mutex;
  std::unique_ptr<IInitializer> initializer;
  HostOptions options;
  double first_stamp = kNotComputed;
  std::map<double, double> td_of;  // by stamp [s]
  ImuScreen screen{ImuLimits()};
  double last_imu = kNotComputed;
  std::int64_t suspects = 0;            // samples within the limits that were left out
  std::deque<FrameObservation> frames;  // on the IMU clock, for the watchdog
  double last_asked = -std::numeric_limits<double>::infinity();
  int contradictions = 0;  // answers in a row that speak against the host
  int suspect_frames = 0;
  SteadyBiases steady_biases;
  SensorMemory memory{Calibration()};
  OptionalCalibration flown;  // extrinsics that the host has estimated in flight
};

// Compares with an answer of the initializer; a reason, or "".
std::string HostAdapter::State::ask(const NavState& newest, bool* answered) {
  *answered = false;
  // Of the host's own biases it would not be independent.
  initializer->setKnownSensors(KnownSensors());
  const InitResult answer = initializer->initialize();
  last_asked = newest.t;
  if (!answer.success()) return "";
  std::vector<NavState> at;
  if (!initializer->statesAt(answer, {newest.t}, options.max_reach_s, &at, nullptr)) return "";
  *answered = at.size() == 1;
  return *answered ? compareStates(newest, at.front(), answer.scale_sigma) : "";
}

HostHealth HostAdapter::State::judge(const std::vector<HostState>& window,
                                     const Calibration& calibration) {
  HostHealth health;
  std::vector<NavState> states;
  for (const HostState& state : window) {
    states.push_back(fromHostState(state, calibration.td));
    states.back().t = hostTime(state.stamp);
    if (states.size() > 1 && !(states.back().t > states[states.size() - 2].t)) return health;
  }
  WatchFinding finding = watchWindow(states, {frames.begin(), frames.end()}, screen.samples(),
                                     screen.damage(), calibration);
  if (finding.sane && !states.empty() && states.back().isFinite()) {
    finding.reason = steady_biases.judge(states.back());
    finding.sane = finding.reason.empty();
  }
  health.reprojection_px = finding.reprojection_px;
  health.velocity_mps = finding.velocity_mps;
  health.rotation_deg = finding.rotation_deg;
  health.reason = finding.reason;
  health.suspect = !finding.sane;
  suspect_frames = finding.sane ? 0 : suspect_frames + 1;
  if (states.empty() || !states.back().isFinite()) {
    health.sane = states.empty();
    return health;
  }
  const double newest = states.back().t;
  if (finding.sane && contradictions == 0 && newest - last_asked < kAskEvery) return health;
  bool answered = false;
  const std::string contradiction = ask(states.back(), &answered);
  if (!contradiction.empty()) {
    ++contradictions;
    health.suspect = true;
    health.reason += (health.reason.empty() ? "" : "; ") + contradiction;
    // One answer may be the wrong one.
    health.sane = finding.sane && contradictions < 2;
  } else if (answered) {
    contradictions = suspect_frames = 0;
    // A bias that has moved has not been thrown off.
    if (!finding.sane) steady_biases = SteadyBiases();
  } else {
    health.sane = suspect_frames < kSuspectFrames;
  }
  return health;
}

// In slow motion the host's frames reach further back than our window: what it knew of those, in
// the odometry frame that is continued, one for each of the first stamps up to `begin` [s]. None
// where one of them is not known.
std::vector<NavState> HostAdapter::State::keptStates(const std::vector<double>& stamps,
                                                     double begin,
                                                     const std::vector<HostState>* healthy) const {
  std::vector<NavState> kept;
  if (healthy == nullptr) return kept;
  const double td = initializer->calibration().td;
  auto candidate = healthy->begin();
  for (const double stamp : stamps) {
    if (hostTime(stamp) >= begin) break;
    while (candidate != healthy->end() && candidate->stamp < stamp - kSameFrame) ++candidate;
    if (candidate == healthy->end() || candidate->stamp > stamp + kSameFrame) return {};
    kept.push_back(fromHostState(*candidate, td));
    kept.back().t = hostTime(stamp);
  }
  return kept;
}

// The host's frames lie between our keyframes, and some outside them. `healthy`: of the odometry
// frame that is continued; null: a new one.
bool HostAdapter::State::fillWindow(const std::vector<double>& stamps,
                                    const std::vector<HostState>* healthy, HostAnswer* answer,
                                    InitStatus* status, std::string* problem) const {
  const Calibration calibration = initializer->calibration();
  const double reach = answer->verdict.states.front().t - options.max_reach_s;
  std::vector<NavState> window = keptStates(stamps, reach, healthy);
  const std::size_t kept = window.size();
  std::vector<double> times;
  times.reserve(stamps.size());
  // Not at the td that was found: the host's preintegrations reach from frame to frame as it has
  // paired them, and its own model moves what was seen to these times (velocity on the image plane
  // times the change of td).
  for (std::size_t i = kept; i < stamps.size(); ++i) times.push_back(hostTime(stamps[i]));
  std::vector<NavState> states;
  if (!initializer->statesAt(answer->verdict, times, options.max_reach_s, &states, problem)) {
    *status = InitStatus::kTooFewKeyframes;
    *problem = "the host's window cannot be filled: " + *problem;
    return false;
  }
  if (states.size() != times.size()) {
    *status = InitStatus::kNumericalFailure;
    *problem = initializer->name() + " returned " + std::to_string(states.size()) + " states for " +
               std::to_string(times.size()) + " stamps";
    return false;
  }
  window.insert(window.end(), states.begin(), states.end());
  const HostOrigin origin = healthy == nullptr ? HostOrigin::kFirstBody : HostOrigin::kKeep;
  if (!toHostWindow(window, calibration.gravity_magnitude, calibration.td, origin, &answer->window,
                    problem)) {
    *status = InitStatus::kNumericalFailure;
    return false;
  }
  // As requested, to the last bit: the host finds its frames by them.
  for (std::size_t i = 0; i < stamps.size(); ++i) answer->window.states[i].stamp = stamps[i];
  const HostState& first = answer->window.states.front();
  answer->window.prior = kept > 0 ? firstStatePrior({window.front(), healthyCovariance()}, first)
                                  : firstStatePrior(answer->verdict, window.front(), first);
  return true;
}

// What the healthy states know, carried over what the IMU has not measured: the initializer does
// not see the damage.
std::vector<StatePrior> HostAdapter::State::priorsOf(const std::vector<HostState>& healthy) const {
  const Calibration calibration = initializer->calibration();
  std::vector<StatePrior> priors;
  for (auto state = healthy.rbegin(); state != healthy.rend(); ++state) {
    CarriedState carried;
    carried.state = fromHostState(*state, calibration.td);
    carried.state.t = hostTime(state->stamp);
    carried.covariance = healthyCovariance();
    // States close to each other know the same.
    if (!priors.empty() && priors.back().state.t - carried.state.t < kBetweenPriors) continue;
    double until = carried.state.t;
    for (const ImuDamage& one : screen.damage()) {
      if (!one.bridged && one.last > until) until = one.last;
    }
    std::string problem;
    if (until > carried.state.t &&
        !carryState(carried, until, screen.samples(), screen.damage(),
                    Eigen::Vector3d(0.0, 0.0, -calibration.gravity_magnitude),
                    calibration.imu_noise, &carried, &problem)) {
      continue;
    }
    priors.push_back(toStatePrior(carried));
    priors.back().calibration = flown;
    if (priors.size() == kMostPriors) break;
  }
  // None reaches the end of the damage: the frame of the newest continues inside the window.
  if (priors.empty() && !healthy.empty()) {
    CarriedState newest;
    newest.state = fromHostState(healthy.back(), calibration.td);
    newest.state.t = hostTime(healthy.back().stamp);
    newest.covariance = healthyCovariance();
    priors.push_back(toStatePrior(newest));
    priors.back().calibration = flown;
  }
  std::reverse(priors.begin(), priors.end());
  return priors;
}

HostAnswer HostAdapter::State::solve(const std::vector<double>& stamps,
                                     const std::vector<HostState>* healthy) {
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
  if (healthy != nullptr && !options.reinit) {
    return decline(InitStatus::kInvalidInput, "recovery is switched off (reinit: 0)");
  }
  if (healthy != nullptr && healthy->empty()) {
    return decline(InitStatus::kInvalidInput, "the host had no healthy state yet");
  }

  initializer->setKnownSensors(memory.knownAt(answer.stamp));
  if (healthy == nullptr) {
    answer.verdict = initializer->initialize();
  } else {
    answer.verdict = initializer->recover(priorsOf(*healthy));
  }
  answer.message = answer.verdict.message;
  if (!answer.verdict.success()) return answer;
  problem = answer.verdict.validate();
  if (!problem.empty()) {
    return decline(InitStatus::kNumericalFailure, initializer->name() + " reported " + problem);
  }
  InitStatus status = InitStatus::kSuccess;
  if (!fillWindow(stamps, healthy, &answer, &status, &problem)) return decline(status, problem);
  answer.joined = healthy != nullptr;
  steady_biases = SteadyBiases();  // the host starts with the answer's
  memory.learn(answer.verdict.calibration);
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
  state->memory = SensorMemory(initializer->calibration());
  state->initializer = std::move(initializer);
  state->options = options;
  state->screen = ImuScreen(options.imu);
  return std::unique_ptr<HostAdapter>(new HostAdapter(std::move(state)));
}

AddStatus HostAdapter::addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  State& state = *state_;
  ImuSample sample;
  sample.t = t;
  sample.accel = accel;
  sample.gyro = gyro;
  const double last = state.last_imu;
  // Whether a stamp is to be believed is the initializer's to say.
  const bool regular = t > last && t - last <= StreamCheck::kJump;
  const bool finite = std::isfinite(t) && accel.allFinite() && gyro.allFinite();
  if (!regular || !finite || state.options.imu.exceededBy(sample)) {
    const AddStatus status = state.noteRestart(state.initializer->addImu(sample));
    if (isAdded(status) || (status == AddStatus::kGlitch && regular)) {
      state.screen.add(sample);
      state.last_imu = t;
    }
    return status;
  }
  state.last_imu = t;
  const std::vector<ImuSample> usable = state.screen.add(sample);
  if (usable.empty()) ++state.suspects;
  AddStatus status = AddStatus::kGlitch;
  for (const ImuSample& one : usable) status = state.initializer->addImu(one);
  return state.noteRestart(status);
}

AddStatus HostAdapter::addFrame(FrameObservation frame) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const double stamp = frame.t;
  const Calibration calibration = state_->initializer->calibration();
  FrameObservation copy;
  copy.t = calibration.imuTime(stamp);
  if (state_->options.watchdog) copy.points = frame.points;
  if (state_->options.image_height > 0) {
    setRowTimes(state_->options.image_height, calibration.readout_s, &frame);
  }
  const AddStatus status = state_->noteRestart(state_->initializer->addFrame(std::move(frame)));
  if (!isAdded(status)) return status;
  if (std::isnan(state_->first_stamp)) state_->first_stamp = stamp;
  state_->td_of[stamp] = calibration.td;
  state_->td_of.erase(state_->td_of.begin(), state_->td_of.lower_bound(stamp - kTdKept));
  if (state_->options.watchdog) {
    state_->frames.push_back(std::move(copy));
    while (state_->frames.front().t < state_->frames.back().t - kFramesKept) {
      state_->frames.pop_front();
    }
  }
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
  return recover(stamps, std::vector<HostState>{last_healthy});
}

HostAnswer HostAdapter::recover(const std::vector<double>& stamps,
                                const std::vector<HostState>& healthy) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const auto start = std::chrono::steady_clock::now();
  HostAnswer answer = state_->solve(stamps, &healthy);
  answer.total_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return answer;
}

void HostAdapter::learn(const HostState& healthy) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  State& state = *state_;
  OptionalCalibration calibration =
      state.flown ? state.flown : state.memory.learned().known.calibration;
  if (calibration && state.options.estimate_td) {
    calibration->td = state.initializer->calibration().td;
    calibration->covariance(6, 6) = std::pow(CalibrationSigmas().td_s, 2);
  }
  state.memory.learn(healthy, calibration);
}

LearnedSensors HostAdapter::learned() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->memory.learned();
}

void HostAdapter::restore(const LearnedSensors& learned) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->memory.restore(learned);
}

HostCarry HostAdapter::carry(const HostState& from, double stamp) const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const Calibration calibration = state_->initializer->calibration();
  HostCarry result;
  CarriedState carried;
  carried.state = fromHostState(from, calibration.td);
  carried.state.t = state_->hostTime(from.stamp);
  carried.covariance = healthyCovariance();
  const double age = stamp - from.stamp;
  const double t = state_->hostTime(stamp);
  if (!carryState(carried, t, state_->screen.heldUntil(t), state_->screen.damage(),
                  Eigen::Vector3d(0.0, 0.0, -calibration.gravity_magnitude), calibration.imu_noise,
                  &carried, &result.message)) {
    return result;
  }
  result.ok = true;
  result.state = toHostState(carried.state, calibration.td);
  result.state.stamp = std::max(stamp, from.stamp);
  result.position_sigma = carried.positionSigma();
  result.yaw_sigma_deg = kRadToDeg * carried.yawSigma();
  std::ostringstream out;
  out.precision(3);
  out << "carried over " << std::max(age, 0.0) << " s by the IMU, standard deviation "
      << result.position_sigma << " m and " << result.yaw_sigma_deg << " deg of yaw";
  result.message = out.str();
  return result;
}

HostHealth HostAdapter::watch(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                              const Eigen::Vector3d& tic) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  Calibration calibration = state_->initializer->calibration();
  calibration.R_b_c = ric;
  calibration.t_b_c = tic;
  HostHealth health = state_->judge(window, calibration);
  if (state_->options.estimate_extrinsic && health.sane && !health.suspect) {
    const CalibrationSigmas sigmas;
    CalibrationEstimate flown;
    flown.R_b_c = ric;
    flown.t_b_c = tic;
    flown.covariance.diagonal().head<3>().setConstant(std::pow(sigmas.rotation_deg / kRadToDeg, 2));
    flown.covariance.diagonal().segment<3>(3).setConstant(std::pow(sigmas.translation_m, 2));
    state_->flown = flown;
  }
  return health;
}

std::vector<HostImuInterval> HostAdapter::imuIntervals(const std::vector<double>& stamps) const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  std::vector<HostImuInterval> result;
  if (stamps.empty()) return result;
  const std::deque<ImuSample> samples = state_->screen.heldUntil(state_->hostTime(stamps.back()));
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double t_i = state_->hostTime(stamps[i - 1]), t_j = state_->hostTime(stamps[i]);
    HostImuInterval interval;
    double last = t_i;
    for (const ImuSample& sample : samplesBetween(samples, t_i, t_j)) {
      interval.dt.push_back(sample.t - last);
      interval.accel.push_back(sample.accel);
      interval.gyro.push_back(sample.gyro);
      last = sample.t;
    }
    for (const ImuDamage& damage : state_->screen.damage()) {
      const double hole = std::min(damage.last, t_j) - std::max(damage.first, t_i);
      if (hole <= 0.0) continue;
      interval.damaged = true;
      if (!damage.gyro_known) interval.sigma_theta += kUnknownGyro * hole;
      interval.sigma_v += kUnknownAccel * hole;
      interval.sigma_p += 0.5 * kUnknownAccel * hole * (t_j - t_i);
    }
    result.push_back(std::move(interval));
  }
  return result;
}

double HostAdapter::lastDamage() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->screen.damage().empty()) return -std::numeric_limits<double>::infinity();
  return state_->initializer->calibration().imageStamp(state_->screen.damage().back().last);
}

double HostAdapter::lastDamageBegin() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->screen.damage().empty()) return -std::numeric_limits<double>::infinity();
  return state_->initializer->calibration().imageStamp(state_->screen.damage().back().first);
}

void HostAdapter::reset() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->initializer->reset();
  state_->forget();
  state_->last_imu = kNotComputed;
  state_->suspects = 0;
}

HostOptions HostAdapter::options() const { return state_->options; }

StreamCounts HostAdapter::counts() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  StreamCounts counts = state_->initializer->counts();
  counts.imu_glitches += state_->suspects;
  return counts;
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
