// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_adapter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "first_state_prior.h"
#include "sensor_memory.h"
#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/host_health/innovation.h"
#include "slim_init/host_health/watchdog.h"
#include "slim_init/text.h"
#include "slim_init/types.h"
#include "solve_worker.h"

namespace slim_init::vins_adapter {

using namespace host_health;  // NOLINT: the vocabulary of this file
namespace {

// Gaps in the images and the td of frames are forgotten after kStampsKept, frames after kFramesKept
// [s]; but those of the host's window never: at rest it keeps frames of any age.
constexpr double kStampsKept = 20.0;
constexpr double kFramesKept = 5.0;
// The lost state follows the newest sample so far behind, in steps [s]: before a window and what it
// reaches back (max_reach_s), and young enough for the samples that are kept.
constexpr double kLostBehind = 6.0;
constexpr double kLostStep = 1.0;
// A host that seems healthy is compared with a solved window so often [s].
constexpr double kCheckEvery = 1.0;
// One that has to be confirmed [s].
constexpr double kEvidenceEvery = 0.3;
constexpr double kMostlyDamaged = 0.5;  // share of a solved window
// A propagated velocity that is less certain does not replace the host's own [m/s].
constexpr double kWorstBridge = 2.0;
// Between two frames over which tracks are followed [s]: as VINS-Mono's tracker has it.
constexpr double kLongestTracked = 1.0;
// No image in so long [s], and in so many times between two frames of a slower host: nothing has
// judged the IMU data that it has used.
constexpr double kLongestUnjudged = 0.25;
constexpr double kFramesUnjudged = 2.5;
// What it costs the odometry frame that only one of IMU and images carries the host, as measured in
// VINS-Mono: random walk of position [m/sqrt(s)] and heading [deg/sqrt(s)].
constexpr double kBridgedPosition = 0.1;
constexpr double kBridgedYaw = 1.0;
// With fewer tracks from the frame before the IMU alone carries a host.
constexpr int kLeastTracks = 8;
// Up to this fraction of the tracks may move without a doubt about the host: most agree with its
// IMU, and a host's tracker loses as many in a dark hall (0.32 to 0.42).
constexpr double kMovingShare = 0.5;
// Velocities that agree [m/s], besides two standard deviations of the scale.
constexpr double kCloseVelocity = 0.25;
// The answer to an earlier frame is used up to this age, besides what its solve took [s].
constexpr double kFreshSolve = 0.5;
// Frames in a row that have to speak against a host where the initializer has no answer.
constexpr int kSuspectFrames = 3;
constexpr double kRadToDeg = 57.29577951308232;
// Damage that begins later after a healthy state [s] has not ended it: something before it has.
constexpr double kDamageFollows = 1.0;
// Healthy states handed to the initializer, and the time between them [s].
constexpr std::size_t kMostPriors = 6;
constexpr double kBetweenPriors = 0.25;
// Stamps of one frame differ by no more [s]; it has been added to td and back.
constexpr double kSameFrame = 1e-6;
// Rows of an image [px]; beyond is a mistake.
constexpr double kMaxImageHeight = 100000;

constexpr double kNever = -std::numeric_limits<double>::infinity();

constexpr std::pair<const char*, HostMode> kModes[] = {
    {"stock", HostMode::kStock}, {"slim", HostMode::kSlim}, {"shadow", HostMode::kShadow}};

// A problem with the requested stamps, or "".
std::string checkStamps(const std::vector<double>& stamps) {
  if (stamps.empty()) return "the host's window is empty";
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (!std::isfinite(stamps[i])) {
      return text("stamp ", i, " of the host's window is not finite");
    }
    if (i > 0 && !(stamps[i] > stamps[i - 1])) {
      return text("stamp ", i, " of the host's window is ", stamps[i] - stamps[i - 1],
                  " s after the one before, must be after it");
    }
  }
  return "";
}

// So near that the states can be called right: a velocity that an estimator recovers from by
// itself, and a tilt within the bound.
bool isClose(const NavState& host, const NavState& solved, double scale_sigma) {
  const Eigen::Vector3d v = solved.R_w_b.transpose() * solved.v_w_b;
  const double sigma = std::isnan(scale_sigma) ? 0.0 : scale_sigma;
  return (host.R_w_b.transpose() * host.v_w_b - v).norm() <=
             kCloseVelocity + 2.0 * sigma * v.norm() &&
         compareStates(host, solved, scale_sigma).empty();
}

std::string propagationMessage(double seconds, const HostPropagation& propagated) {
  return roundedText(3, "propagated over ", std::max(seconds, 0.0),
                     " s by the IMU, standard deviation ", propagated.position_sigma, " m and ",
                     propagated.yaw_sigma_deg, " deg of yaw");
}

// Time in [first, last] that is damaged and not bridged [s].
double damagedTime(const std::deque<ImuDamage>& damage, double first, double last) {
  std::vector<std::pair<double, double>> spans;
  for (const ImuDamage& one : damage) {
    if (!one.bridged) spans.emplace_back(one.first, std::min(one.last, last));
  }
  std::sort(spans.begin(), spans.end());
  double sum = 0.0;
  for (const auto& [begin, end] : spans) {
    sum += std::max(0.0, end - std::max(begin, first));
    first = std::max(first, end);
  }
  return sum;
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
  const std::tuple<const char*, double, double, double> fields[] = {
      {"max_reach_s", max_reach_s, 0.0, 60.0},
      {"max_wait_ms", max_wait_ms, -1.0, 1000.0},
      {"image_height", image_height, 0.0, kMaxImageHeight}};
  for (const auto& [name, value, least, most] : fields) {
    if (value >= least && value <= most) continue;
    return roundedText(9, name, " is ", value, ", must be in [", least, ", ", most, "]");
  }
  return "";
}

struct HostAdapter::State {
  using Lock = std::unique_lock<std::mutex>;

  // ----------------------------------------------------------------------------- streams and times

  Calibration calibration() const { return initializer->info().calibration; }
  // With the host's present extrinsic.
  Calibration calibrationWith(const Eigen::Matrix3d& ric, const Eigen::Vector3d& tic) const {
    Calibration result = calibration();
    result.R_b_c = ric;
    result.t_b_c = tic;
    return result;
  }
  // What the host has estimated in flight, or an answer has found.
  OptionalCalibration knownCalibration() const {
    return flown ? flown : memory.learned().known.calibration;
  }
  // A restart makes it forget the streams; `status` is what became of the message.
  AddStatus noteRestart(AddStatus status) {
    if (status == AddStatus::kRestarted) {
      forget();
      memory.restart();
    }
    return status;
  }

  void forget() {
    first_stamp = kNotComputed;
    td_of.clear();
    frames.clear();
    gaps.clear();
    newest_image = kNotComputed;
    screen.reset();
    last_check = kNever;
    endFlight();
    last_agreed = kNotComputed;
    lost.reset();
    flown = OptionalCalibration();
  }

  void endFlight() {
    worker.discard();
    in_window.clear();
    moving.clear();
    check_refused = false;
    expectOtherStates();
  }
  // What the tests have remembered of the host's states is not of those that it has now.
  void expectOtherStates() {
    contradictions = suspect_frames = 0;
    steady_biases = SteadyBiases();
    innovations.reset();
    alone.reset();
  }
  // With the td that the host had when it paired the frame of that stamp with its IMU data [s].
  double hostTime(double stamp) const {
    const auto it = td_of.find(stamp);
    return stamp + (it == td_of.end() ? calibration().td : it->second);
  }

  // The host drops images while it has no IMU data, but its tracker has them.
  void noteImage(double stamp) {
    // A stamp that is from the future, or of the time before a restart, has made no gap.
    for (; !gaps.empty() && gaps.rbegin()->second > stamp; gaps.erase(std::prev(gaps.end()))) {
      newest_image = gaps.rbegin()->first;
    }
    if (stamp - newest_image > kLongestUnjudged) gaps[newest_image] = stamp;
    newest_image = stamp;
  }

  void forgetOld(double stamp) {
    for (auto td = td_of.begin(); td != td_of.end() && td->first < stamp - kStampsKept;) {
      const bool used = std::binary_search(in_window.begin(), in_window.end(), td->first);
      td = used ? std::next(td) : td_of.erase(td);
    }
    const double oldest = in_window.empty() ? stamp : in_window.front();
    while (!gaps.empty() && gaps.begin()->second < std::min(oldest, stamp - kStampsKept)) {
      gaps.erase(gaps.begin());
    }
    const auto isUsed = [this](const FrameObservation& frame) {
      return std::any_of(in_window.begin(), in_window.end(), [&](double one) {
        return std::abs(hostTime(one) - frame.t) <= kSameFrame;
      });
    };
    const auto young = std::find_if(frames.begin(), frames.end(), [this](const auto& frame) {
      return frame.t >= frames.back().t - kFramesKept;
    });
    frames.erase(std::remove_if(frames.begin(), young, [&](const auto& f) { return !isUsed(f); }),
                 young);
  }

  // Between two frames of the host [s]; shorter gaps than kLongestUnjudged are not in it.
  double longestWithoutImage(double first, double last) const {
    double longest = std::max(0.0, last - std::max(first, newest_image));
    for (const auto& [begin, end] : gaps) {
      longest = std::max(longest, std::min(end, last) - std::max(begin, first));
    }
    return longest;
  }

  // Watchdog and innovation test know no rows: bearings are turned from the exposure of their row
  // to the stamp by the present rate, as withRowsCompensated() of the core turns those of a window.
  void compensateRows(const Calibration& calibration, FrameObservation* frame) const {
    const std::vector<ImuSample> samples =
        samplesBetween(screen.heldUntil(frame->t), frame->t - calibration.readout_s, frame->t);
    if (samples.empty()) return;
    const OptionalCalibration known = knownCalibration();
    const Eigen::Matrix3d& R_b_c = known ? known->R_b_c : calibration.R_b_c;
    // The samples of the later rows are yet to come; the mean of those before has less noise.
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : samples) rate += sample.gyro / samples.size();
    const Eigen::Vector3d turn = calibration.readout_s * R_b_c.transpose() * (rate - gyro_bias);
    for (PointObservation& point : frame->points) {
      point.bearing = expOf(point.row * turn) * point.bearing;
    }
  }

  void removeMoving(FrameObservation* frame) const {
    const auto moves = [this](const PointObservation& point) { return moving.count(point.id) > 0; };
    std::vector<PointObservation>& points = frame->points;
    points.erase(std::remove_if(points.begin(), points.end(), moves), points.end());
  }

  // ---------------------------------------------------------------------------------------- states

  // On the IMU clock, as the host has paired its frames with its samples.
  NavState stateOf(const HostState& host) const {
    NavState state = fromHostState(host, 0.0);
    state.t = hostTime(host.stamp);
    return state;
  }
  std::vector<NavState> statesOf(const std::vector<HostState>& window) const {
    std::vector<NavState> states;
    for (const HostState& state : window) states.push_back(stateOf(state));
    return states;
  }
  void noteWindow(const std::vector<HostState>& window) {
    in_window = stampsOf(window);
    if (!window.empty() && window.back().Bg.allFinite()) gyro_bias = window.back().Bg;
  }
  PropagatedState healthyStateOf(const HostState& state) const {
    if (lost && state.stamp == lost_stamp && !reaches(hostTime(state.stamp))) return *lost;
    PropagatedState healthy;
    healthy.state = stateOf(state);
    healthy.covariance = healthyCovariance();
    return healthy;
  }
  bool reaches(double t) const {
    return !screen.samples().empty() && screen.samples().front().t <= t;
  }
  // By the IMU. False, and a reason, where the data do not reach.
  bool carry(const PropagatedState& from, double t, const std::deque<ImuSample>& samples,
             PropagatedState* to, std::string* problem) const {
    const Calibration rig = calibration();
    return propagateState(from, t, samples, screen.damage(),
                          Eigen::Vector3d(0.0, 0.0, -rig.gravity_magnitude), rig.imu_noise, to,
                          problem);
  }

  // Stops in front of damage, whose error is constant, as long as the data are there.
  void carryLost(double until) {
    if (!lost) return;
    for (const ImuDamage& one : screen.damage()) {
      const bool within = lost->state.t <= one.first && one.first < until && until < one.last;
      if (within && reaches(lost->state.t - kLostStep)) until = one.first;
    }
    std::string problem;
    if (until - lost->state.t > kLostStep) {
      carry(*lost, until, screen.samples(), &*lost, &problem);
    }
  }

  HostPropagation propagate(const HostState& from, double stamp) const {
    HostPropagation result;
    PropagatedState propagated = healthyStateOf(from);
    const double t = hostTime(stamp);
    result.ok = carry(propagated, t, screen.heldUntil(t), &propagated, &result.message);
    if (!result.ok) return result;
    result.state = toHostState(propagated.state, calibration().td);
    result.state.stamp = std::max(stamp, from.stamp);
    result.position_sigma = propagated.positionSigma();
    result.yaw_sigma_deg = kRadToDeg * propagated.yawSigma();
    result.message = propagationMessage(stamp - from.stamp, result);
    return result;
  }

  // The solution at another time, where it reaches there.
  std::optional<NavState> stateAt(const InitResult& result, double t) const {
    std::vector<NavState> at;
    const bool reached = initializer->statesAt(result, {t}, options.max_reach_s, &at, nullptr);
    return reached && at.size() == 1 ? std::optional<NavState>(at.front()) : std::nullopt;
  }

  std::vector<HostImuInterval> intervals(const std::vector<double>& stamps) const {
    std::vector<HostImuInterval> result;
    if (stamps.empty()) return result;
    const std::deque<ImuSample> samples = screen.heldUntil(hostTime(stamps.back()));
    for (std::size_t i = 1; i < stamps.size(); ++i) {
      const double t_i = hostTime(stamps[i - 1]), t_j = hostTime(stamps[i]);
      HostImuInterval interval;
      double last = t_i;
      for (const ImuSample& sample : samplesBetween(samples, t_i, t_j)) {
        interval.dt.push_back(sample.t - last);
        interval.accel.push_back(sample.accel);
        interval.gyro.push_back(sample.gyro);
        last = sample.t;
      }
      const ImuWidening widening = wideningOf(screen.damage(), t_i, t_j);
      interval.damaged = widening.damaged;
      interval.sigma_theta = widening.sigma_theta;
      interval.sigma_v = widening.sigma_v;
      interval.sigma_p = widening.sigma_p;
      result.push_back(std::move(interval));
    }
    return result;
  }

  // The frame's samples have arrived, and the screen has not let all of them pass to the
  // initializer.
  bool isHeldBack(double stamp) const {
    const double t = hostTime(stamp);
    return screen.newest() >= t && initializer->info().imu.last < t;
  }

  // ------------------------------------------------------------------------------ a host in flight

  // Tracks of the frame at `end` that the frame at `begin`, or one before it, has too [s, IMU
  // clock]; `tracks`: all of that frame.
  std::vector<long long> tracksOverGap(double begin, double end, int* tracks) const {
    std::set<FeatureId> before;
    std::vector<long long> over;
    *tracks = 0;
    for (const FrameObservation& frame : frames) {
      if (frame.t <= begin + kSameFrame) {
        for (const PointObservation& point : frame.points) before.insert(point.id);
      } else if (std::abs(frame.t - end) <= kSameFrame) {
        *tracks = static_cast<int>(frame.points.size());
        for (const PointObservation& point : frame.points) {
          if (before.count(point.id) > 0) over.push_back(point.id);
        }
      }
    }
    return over;
  }

  double longestUnjudged() const {
    double shortest = frames.size() > 1 ? HUGE_VAL : 0.0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
      shortest = std::min(shortest, frames[i].t - frames[i - 1].t);
    }
    return std::max(kLongestUnjudged, kFramesUnjudged * shortest);
  }

  // What a tracker carries over a gap in the images are other points: drops the states before the
  // last gap. True if that is the newest interval. `uncertain` is set if nothing has judged the IMU
  // data of an interval.
  bool dropBeforeGap(const std::vector<double>& stamps, std::vector<NavState>* optimized,
                     bool* uncertain) const {
    const double unjudged = longestUnjudged();
    for (std::size_t i = optimized->size(); i-- > 0;) {
      const double gap = longestWithoutImage(stamps[i], stamps[i + 1]);
      *uncertain = *uncertain || gap > unjudged;
      if (gap <= kLongestTracked) continue;
      optimized->erase(optimized->begin(), optimized->begin() + static_cast<std::ptrdiff_t>(i) + 1);
      return i + 2 == stamps.size();
    }
    return false;
  }

  // By what the newest interval, up to `t` [s], adds to the errors of the last state that the
  // images have vouched for, `before` in the first frame without them.
  void widenByImuAlone(const HostState& before, double t, HostPreparation* frame) {
    if (!alone) vouched = alone = healthyStateOf(before);
    const double position = alone->positionSigma(), yaw = alone->yawSigma();
    std::string problem;
    // Not in steps while its data are there: the error of damaged data is constant.
    if (!carry(*vouched, t, screen.heldUntil(t), &*alone, &problem)) {
      vouched = alone;
      if (!carry(*vouched, t, screen.heldUntil(t), &*alone, &problem)) return;
    }
    const auto added = [](double sigma, double now, double earlier) {
      return std::max(sigma, std::sqrt(std::max(now * now - earlier * earlier, 0.0)));
    };
    frame->position_sigma = added(frame->position_sigma, alone->positionSigma(), position);
    frame->yaw_sigma_deg =
        added(frame->yaw_sigma_deg, kRadToDeg * alone->yawSigma(), kRadToDeg * yaw);
  }

  // Compares with a window that is solved without the host's states, which would not be independent
  // of them, nor of their biases. If such a window has had no answer, which may be for an extrinsic
  // that its motion does not show, the next one is given the calibration, and finds none of its
  // own.
  void checkAgainstSolve(const NavState& newest, double stamp, bool urgent, bool wants_evidence,
                         Lock* lock, HostHealth* health) {
    Priors priors;
    if (check_refused) priors.sensors.calibration = knownCalibration();
    const SolveWorker::Solve solve = [initializer = initializer.get(), priors] {
      InitResult result = initializer->initialize(priors);
      if (priors.sensors.calibration) result.calibration = OptionalCalibration();
      return result;
    };
    const double every = wants_evidence ? kEvidenceEvery : kCheckEvery;
    const bool due = urgent || contradictions > 0 || !(stamp - last_check < every);
    std::optional<Solved> solved;
    if (options.max_wait_ms < 0.0) {
      if (due) solved = solveNow(stamp, solve);
    } else {
      solved = worker.take(SolvePurpose::kCheck, SolveWorker::Clock::now());
      // A solve that is wanted more is not put off.
      if (due && worker.isIdle()) worker.post(SolvePurpose::kCheck, stamp, solve);
      if (urgent && !solved.has_value()) solved = awaited(SolvePurpose::kCheck, stamp, lock);
    }
    if (!solved.has_value()) return;
    last_check = solved->stamp;
    health->calibration = solved->result.calibration;
    check_refused = !solved->result.success();
    if (!solved->result.success() || solved->result.states.empty()) return;
    const std::optional<NavState> independent = stateAt(solved->result, newest.t);
    if (!independent) return;
    const double scale_sigma = solved->result.scale_sigma;
    // In slow motion a bias of the accelerometer hides the direction of gravity.
    double tilt_sigma_deg = 0.0;
    for (const GateValue& gate : solved->result.gates) {
      const bool known = gate.name == GateName::kTiltSigma && std::isfinite(gate.value);
      if (known) tilt_sigma_deg = gate.value;
    }
    const std::string contradiction =
        compareStates(newest, *independent, scale_sigma, tilt_sigma_deg);
    if (contradiction.empty()) {
      contradictions = suspect_frames = 0;
      last_agreed = solved->stamp;
      if (isClose(newest, *independent, scale_sigma)) health->confirmed_stamp = solved->stamp;
      return;
    }
    // The initializer does not see damage, nor what moves in the images until the host has: a
    // window with a little of it may be wrong with any certainty. Where most of it is damaged the
    // host may be what is wrong with the IMU data.
    const double first = solved->result.states.front().t;
    const double damaged = damagedTime(screen.damage(), first, newest.t);
    if ((damaged > 0.0 && damaged < kMostlyDamaged * (newest.t - first)) ||
        innovations.imagesMoved(first)) {
      contradictions = 0;
      return;
    }
    ++contradictions;
    health->suspect = true;
    health->reason += (health->reason.empty() ? "" : "; ") + contradiction;
  }

  HostHealth judge(const std::vector<HostState>& window, const Calibration& calibration,
                   bool wants_evidence, Lock* lock) {
    const std::vector<NavState> states = statesOf(window);
    for (std::size_t i = 1; i < states.size(); ++i) {
      if (!(states[i].t > states[i - 1].t)) return HostHealth();
    }
    std::vector<FrameObservation> scene(frames.begin(), frames.end());
    for (FrameObservation& frame : scene) removeMoving(&frame);
    HostHealth health = watchWindow(states, scene, screen.samples(), screen.damage(), calibration);
    const bool finite = !states.empty() && states.back().isFinite();
    if (!health.suspect && finite) {
      health.reason = steady_biases.judge(states.back());
      health.suspect = !health.reason.empty();
    }
    const bool suspect = health.suspect;
    suspect_frames = suspect ? suspect_frames + 1 : 0;
    if (!finite) {
      health.healthy = states.empty();
      return health;
    }
    const int contradictions_before = contradictions, suspect_before = suspect_frames;
    checkAgainstSolve(states.back(), window.back().stamp, suspect, wants_evidence, lock, &health);
    if (contradictions > contradictions_before) {
      // One solved window may be the wrong one.
      health.healthy = !suspect && contradictions < 2;
    } else if (suspect_frames < suspect_before) {
      // It agrees: a bias that has moved has not been thrown off.
      steady_biases = SteadyBiases();
    } else {
      health.healthy = suspect_frames < kSuspectFrames;
    }
    return health;
  }

  // ------------------------------------------------------------------------- starts and recoveries

  // Of copies: the streams go on while it runs.
  SolveWorker::Solve solveFor(double stamp, const std::vector<HostState>* healthy) {
    Priors priors;
    priors.sensors = memory.knownAt(stamp);
    if (healthy != nullptr) priors.healthy = priorsOf(*healthy);
    return [solver = initializer.get(), priors] { return solver->initialize(priors); };
  }

  // What the healthy states know, propagated over what the IMU has not measured: the initializer
  // does not see the damage.
  std::vector<StatePrior> priorsOf(const std::vector<HostState>& healthy) const {
    std::vector<StatePrior> priors;
    const auto add = [&](const PropagatedState& state) {
      priors.push_back(toStatePrior(state));
      priors.back().calibration = flown;
    };
    for (auto state = healthy.rbegin(); state != healthy.rend(); ++state) {
      PropagatedState propagated = healthyStateOf(*state);
      // States close to each other know the same.
      if (!priors.empty() && priors.back().state.t - propagated.state.t < kBetweenPriors) continue;
      double until = propagated.state.t;
      for (const ImuDamage& one : screen.damage()) {
        const bool follows = one.first < hostTime(healthy.back().stamp) + kDamageFollows;
        if (!one.bridged && follows && one.last > until) until = one.last;
      }
      std::string problem;
      if (!carry(propagated, until, screen.samples(), &propagated, &problem)) continue;
      add(propagated);
      if (priors.size() == kMostPriors) break;
    }
    // None reaches the end of the damage: the frame of the newest continues inside the window.
    if (priors.empty() && !healthy.empty()) add(healthyStateOf(healthy.back()));
    std::reverse(priors.begin(), priors.end());
    return priors;
  }

  // Waits for a solve of this purpose while the streams go on; the time is one for all calls about
  // a frame.
  std::optional<Solved> awaited(SolvePurpose purpose, double stamp, Lock* lock) {
    if (stamp != waiting_stamp) {
      waiting_stamp = stamp;
      const std::chrono::duration<double, std::milli> wait(options.max_wait_ms);
      wait_until = SolveWorker::Clock::now() +
                   std::chrono::duration_cast<SolveWorker::Clock::duration>(wait);
    }
    lock->unlock();
    std::optional<Solved> solved = worker.take(purpose, wait_until);
    lock->lock();
    return solved;
  }

  // The newest finished solve of this purpose; begins one of the newest window unless one is at
  // work. Nothing: none has finished in time.
  std::optional<Solved> solvedInTime(SolvePurpose purpose, double stamp, SolveWorker::Solve solve,
                                     Lock* lock) {
    if (options.max_wait_ms < 0.0) return solveNow(stamp, solve);
    std::optional<Solved> earlier = worker.take(purpose, SolveWorker::Clock::now());
    const double age = earlier ? stamp - earlier->stamp - 1e-3 * earlier->solve_ms : 0.0;
    if (!(std::abs(age) <= kFreshSolve)) earlier.reset();
    if (earlier.has_value() && earlier->result.success()) return earlier;
    if (!worker.isBusy(purpose) && !worker.post(purpose, stamp, solve)) {
      return solveNow(stamp, solve);
    }
    std::optional<Solved> solved = awaited(purpose, stamp, lock);
    return solved.has_value() ? std::move(solved) : std::move(earlier);
  }

  HostResult answer(const std::vector<double>& stamps, const std::vector<HostState>* healthy,
                    Lock* lock) {
    HostResult answer;
    const auto decline = [&answer](InitStatus status, const std::string& message) {
      answer.result.status = status;
      answer.result.message = message;
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
      return decline(InitStatus::kInvalidInput, "the host has had no healthy state yet");
    }

    std::optional<Solved> solved =
        solvedInTime(healthy == nullptr ? SolvePurpose::kSeed : SolvePurpose::kRecover,
                     stamps.back(), solveFor(answer.stamp, healthy), lock);
    if (!solved.has_value()) {
      answer.pending = true;
      return decline(InitStatus::kTimeLimit, "the solve has not finished");
    }
    answer.result = std::move(solved->result);
    answer.solve_ms = solved->solve_ms;
    answer.message = answer.result.message;
    if (!answer.result.success()) return answer;
    problem = answer.result.validate();
    if (!problem.empty()) {
      return decline(InitStatus::kNumericalFailure,
                     initializer->info().method + " reported " + problem);
    }
    if (healthy != nullptr && !answer.result.frame_continued) {
      answer.no_recovery = true;
      return decline(InitStatus::kTooFewKeyframes, initializer->info().method + " has no recovery");
    }
    InitStatus status = InitStatus::kSuccess;
    if (!fillWindow(stamps, healthy, &answer, &status, &problem)) {
      answer.pending = healthy != nullptr && isHeldBack(stamps.back());
      return decline(status, problem);
    }
    if (healthy != nullptr) answer.frame = continuationOf(healthy->back(), answer.result);
    if (healthy == nullptr) last_agreed = solved->stamp;
    expectOtherStates();
    memory.learn(answer.result.calibration);
    return answer;
  }

  // The host's frames lie between our keyframes, and some outside them. `healthy`: of the odometry
  // frame that is continued; null: a new one.
  bool fillWindow(const std::vector<double>& stamps, const std::vector<HostState>* healthy,
                  HostResult* answer, InitStatus* status, std::string* problem) const {
    const double reach = answer->result.states.front().t - options.max_reach_s;
    std::vector<NavState> window = keptStates(stamps, reach, healthy);
    const std::size_t kept = window.size();
    std::vector<double> times;
    times.reserve(stamps.size());
    // Not at the td that was found: the host's preintegrations reach from frame to frame as it has
    // paired them, and its own model moves what was seen to these times (velocity on the image
    // plane times the change of td).
    for (std::size_t i = kept; i < stamps.size(); ++i) times.push_back(hostTime(stamps[i]));
    std::vector<NavState> states;
    if (!initializer->statesAt(answer->result, times, options.max_reach_s, &states, problem)) {
      *status = InitStatus::kTooFewKeyframes;
      *problem = "the host's window cannot be filled: " + *problem;
      return false;
    }
    if (states.size() != times.size()) {
      *status = InitStatus::kNumericalFailure;
      *problem = text(initializer->info().method, " returned ", states.size(), " states for ",
                      times.size(), " stamps");
      return false;
    }
    window.insert(window.end(), states.begin(), states.end());
    // A start from rest has its origin where the body stood, a recovery that of the host.
    const bool keeps = healthy != nullptr || std::isfinite(answer->result.at_rest_since);
    if (!toWindow(window, stamps, keeps ? HostOrigin::kKeep : HostOrigin::kFirstBody,
                  &answer->window, problem)) {
      *status = InitStatus::kNumericalFailure;
      return false;
    }
    const HostState& first = answer->window.states.front();
    answer->window.prior = kept > 0 ? firstStatePrior({window.front(), healthyCovariance()}, first)
                                    : firstStatePrior(answer->result, window.front(), first);
    return true;
  }

  // In slow motion the host's frames reach further back than our window: what it knew of those, in
  // the odometry frame that is continued, one for each of the first stamps up to `begin` [s]. None
  // where one of them is not known.
  std::vector<NavState> keptStates(const std::vector<double>& stamps, double begin,
                                   const std::vector<HostState>* healthy) const {
    std::vector<NavState> kept;
    if (healthy == nullptr) return kept;
    auto candidate = healthy->begin();
    for (const double stamp : stamps) {
      if (hostTime(stamp) >= begin) break;
      while (candidate != healthy->end() && candidate->stamp < stamp - kSameFrame) ++candidate;
      if (candidate == healthy->end() || candidate->stamp > stamp + kSameFrame) return {};
      kept.push_back(stateOf(*candidate));
      kept.back().t = hostTime(stamp);
    }
    return kept;
  }

  bool toWindow(const std::vector<NavState>& states, const std::vector<double>& stamps,
                HostOrigin origin, HostWindow* window, std::string* problem) const {
    const Calibration rig = calibration();
    if (!toHostWindow(states, rig.gravity_magnitude, rig.td, origin, window, problem)) {
      return false;
    }
    // As requested, to the last bit: the host finds its frames by them.
    for (std::size_t i = 0; i < stamps.size(); ++i) window->states[i].stamp = stamps[i];
    return true;
  }

  // The IMU has propagated the healthy state to where the window begins; from there the window's
  // own scale counts.
  HostPropagation continuationOf(const HostState& healthy, const InitResult& result) const {
    const NavState &first = result.states.front(), &last = result.states.back();
    const double begin = calibration().imageStamp(first.t);
    HostPropagation frame = propagate(healthy, std::max(healthy.stamp, begin));
    const double scale_sigma = std::isnan(result.scale_sigma) ? 0.0 : result.scale_sigma;
    frame.start_sigma = scale_sigma * (last.p_w_b - first.p_w_b).norm();
    // A host whose velocity is wrong may have gone wrong since a solve has last agreed with it.
    const NavState carried = fromHostState(frame.state, calibration().td);
    const std::optional<NavState> solved = frame.ok ? stateAt(result, carried.t) : std::nullopt;
    const double off = solved ? (carried.v_w_b - solved->v_w_b).norm() : 0.0;
    if (off > kCloseVelocity) {
      const double since = std::isnan(last_agreed) ? first_stamp : last_agreed;
      frame.start_sigma = std::hypot(frame.start_sigma, off * std::max(healthy.stamp - since, 0.0));
    }
    frame.position_sigma = std::hypot(frame.position_sigma, frame.start_sigma);
    if (frame.ok) {
      frame.message = propagationMessage(begin - healthy.stamp, frame);
    }
    return frame;
  }

  mutable std::mutex mutex;
  std::unique_ptr<IInitializer> initializer;
  HostOptions options;
  double first_stamp = kNotComputed;
  std::map<double, double> td_of;  // by stamp [s]
  ImuScreen screen{ImuLimits()};
  std::deque<FrameObservation> frames;  // on the IMU clock, for the watchdog
  std::vector<double> in_window;        // stamps of the host's last window, ascending [s]
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();  // of its newest frame [rad/s]
  double newest_image = kNotComputed;  // stamp, of those that the host has received [s]
  std::map<double, double> gaps;       // in these, longer than kLongestUnjudged: begin and end
  double last_check = kNever;          // stamp of the newest state [s]
  double last_agreed = kNotComputed;   // of a solve with the host: its stamp [s]
  int contradictions = 0;              // solved windows in a row that speak against the host
  int suspect_frames = 0;
  bool check_refused = false;  // the last solve that the host was to be compared with
  SteadyBiases steady_biases;
  InnovationMonitor innovations;
  std::set<FeatureId> moving;  // tracks of the newest frame, as prepare() found them
  // While the IMU alone carries the host: the last state that the images have vouched for, and
  // that propagated.
  std::optional<PropagatedState> vouched, alone;
  // The host's last healthy state before a failure, of that stamp [s], carried: the IMU data of its
  // own time are not kept.
  std::optional<PropagatedState> lost;
  double lost_stamp = kNotComputed;
  SensorMemory memory{Calibration()};
  OptionalCalibration flown;            // extrinsics that the host has estimated in flight
  double waiting_stamp = kNotComputed;  // the frame for which the host has begun to wait
  SolveWorker::Clock::time_point wait_until;
  SolveWorker worker;  // last, so that its thread ends first
};

HostAdapter::HostAdapter(std::unique_ptr<State> state) : state_(std::move(state)) {}
HostAdapter::~HostAdapter() = default;

std::unique_ptr<HostAdapter> HostAdapter::create(std::unique_ptr<IInitializer> initializer,
                                                 const HostOptions& options, std::string* error) {
  const std::string problem =
      initializer == nullptr ? "the initializer is null" : options.validate();
  if (!problem.empty()) {
    if (error != nullptr) *error = problem;
    return nullptr;
  }
  auto state = std::make_unique<State>();
  state->memory = SensorMemory(initializer->info().calibration);
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
  state.carryLost(t - kLostBehind);
  return state.screen.pass(sample, [&state](const ImuSample& one) {
    return state.noteRestart(state.initializer->addImu(one));
  });
}

AddStatus HostAdapter::addFrame(FrameObservation frame) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const double stamp = frame.t;
  const Calibration calibration = state_->calibration();
  FrameObservation copy;
  copy.t = calibration.imuTime(stamp);
  const bool keeps = state_->options.watchdog || state_->options.reinit;
  if (state_->options.image_height > 0) setRows(state_->options.image_height, &frame);
  if (keeps) copy.points = frame.points;
  if (keeps && calibration.readout_s > 0.0) state_->compensateRows(calibration, &copy);
  // As found at the frame before: a solve would follow it.
  state_->removeMoving(&frame);
  state_->moving.clear();
  const AddStatus status = state_->noteRestart(state_->initializer->addFrame(std::move(frame)));
  if (!isAdded(status)) return status;
  if (std::isnan(state_->first_stamp)) state_->first_stamp = stamp;
  state_->td_of[stamp] = calibration.td;
  // Not every host tells of the images that it receives.
  if (!(stamp <= state_->newest_image)) state_->noteImage(stamp);
  if (keeps) state_->frames.push_back(std::move(copy));
  state_->forgetOld(stamp);
  return status;
}

AddStatus HostAdapter::addLines(double stamp, std::vector<LineObservation> lines) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  FrameObservation frame;
  frame.lines = std::move(lines);
  if (state_->options.image_height > 0) setRows(state_->options.image_height, &frame);
  return state_->initializer->addLines(stamp, std::move(frame.lines));
}

AddStatus HostAdapter::addSpeed(const SpeedSample& sample) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->initializer->addSpeed(sample);
}

void HostAdapter::received(double stamp) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (std::isfinite(stamp)) state_->noteImage(stamp);
}

void HostAdapter::setTd(double td) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->initializer->setTd(td);
}

HostResult HostAdapter::seed(const std::vector<double>& stamps) {
  State::Lock lock(state_->mutex);
  return state_->answer(stamps, nullptr, &lock);
}

HostResult HostAdapter::recover(const std::vector<double>& stamps,
                                const std::vector<HostState>& healthy) {
  State::Lock lock(state_->mutex);
  return state_->answer(stamps, &healthy, &lock);
}

// The last healthy state is at least as old as the newest damage that it could know of, so what is
// propagated may drift; the host's tracks correct it.
HostResult HostAdapter::bridge(const std::vector<double>& stamps,
                               const std::vector<HostState>& healthy) const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const State& state = *state_;
  HostResult answer;
  answer.result.status = InitStatus::kInvalidInput;
  answer.message = checkStamps(stamps);
  if (!answer.message.empty() || healthy.empty()) return answer;
  answer.stamp = stamps.back();
  const std::deque<ImuSample> samples = state.screen.heldUntil(state.hostTime(stamps.back()));
  std::vector<NavState> window;
  PropagatedState first, propagated;
  auto next = healthy.begin();
  for (const double stamp : stamps) {
    for (; next != healthy.end() && next->stamp <= stamp + kSameFrame; ++next) {
      propagated = state.healthyStateOf(*next);
    }
    if (next == healthy.begin()) {
      answer.message = "a frame of the host's window is older than its healthy states";
      return answer;
    }
    const double t = state.hostTime(stamp);
    if (propagated.state.t > t + kSameFrame) {
      answer.message = "a frame of the host's window is older than its propagated state";
      return answer;
    }
    if (!state.carry(propagated, t, samples, &propagated, &answer.message)) return answer;
    if (window.empty()) first = propagated;
    window.push_back(propagated.state);
    window.back().t = t;
  }
  if (const double sigma = propagated.velocitySigma(); sigma > kWorstBridge) {
    answer.message = text("the IMU data leave a standard deviation of the velocity of ", sigma,
                          " m/s (limit ", kWorstBridge, ')');
    return answer;
  }
  if (!state.toWindow(window, stamps, HostOrigin::kKeep, &answer.window, &answer.message)) {
    return answer;
  }
  answer.window.prior = firstStatePrior(first, answer.window.states.front());
  answer.result.status = InitStatus::kTimeLimit;
  answer.message = "the last healthy states, propagated by the IMU, until the solve has finished";
  return answer;
}

void HostAdapter::learn(const HostState& healthy) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  State& state = *state_;
  OptionalCalibration calibration = state.knownCalibration();
  if (calibration && state.options.estimate_td) {
    calibration->td = state.calibration().td;
    calibration->covariance(6, 6) = std::pow(CalibrationSigmas().td_s, 2);
  }
  state.memory.learn(healthy, calibration);
  state.lost.reset();
}

void HostAdapter::lose(const HostState& healthy) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->lost && state_->lost_stamp == healthy.stamp) return;
  state_->lost = state_->healthyStateOf(healthy);
  state_->lost_stamp = healthy.stamp;
}

void HostAdapter::flightEnded() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->endFlight();
}

HostPropagation HostAdapter::propagate(const HostState& from, double stamp) const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->propagate(from, stamp);
}

// Over the newest interval, with what the images say about it.
HostPreparation HostAdapter::prepare(const std::vector<HostState>& window,
                                     const Eigen::Matrix3d& ric, const Eigen::Vector3d& tic) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  State& state = *state_;
  const Calibration calibration = state.calibrationWith(ric, tic);
  HostPreparation out;
  state.noteWindow(window);
  const std::vector<double>& stamps = state.in_window;
  if (window.size() < 2 || !checkStamps(stamps).empty()) return out;
  out.newest = window.back();
  const double t_i = state.hostTime(stamps[stamps.size() - 2]);
  const double t_j = state.hostTime(stamps.back());
  PropagatedState predicted;
  std::string problem;
  if (!(t_j > t_i) || !state.carry(state.healthyStateOf(window[window.size() - 2]), t_j,
                                   state.screen.heldUntil(t_j), &predicted, &problem)) {
    return out;
  }
  std::vector<NavState> optimized = state.statesOf(window);
  optimized.pop_back();
  int tracks = 0;
  const std::vector<long long> known = state.tracksOverGap(t_i, t_j, &tracks);
  bool uncertain = wideningOf(state.screen.damage(), state.hostTime(stamps.front()), t_j).damaged;
  if (state.dropBeforeGap(stamps, &optimized, &uncertain)) out.moving = known;
  const bool blind = static_cast<int>(known.size()) < kLeastTracks;
  const std::vector<FrameObservation> frames(state.frames.begin(), state.frames.end());
  const Innovation innovation =
      state.innovations.judge({optimized, predicted, frames, calibration}, uncertain);
  if (innovation.accusesImu()) {
    state.screen.addDamage(innovation.damaged_since, t_j, innovation.accel_sigma,
                           innovation.gyro_sigma);
  }
  // A host that the IMU alone carries has no state that the images vouch for.
  out.suspect = innovation.culprit == Culprit::kUnclear || innovation.blind;
  out.moving.insert(out.moving.end(), innovation.moving.begin(), innovation.moving.end());
  state.moving = {innovation.moving.begin(), innovation.moving.end()};
  const bool moves = static_cast<double>(innovation.moving.size()) > kMovingShare * tracks;
  if (innovation.accusesImu() || moves) out.message = innovation.message;
  out.intervals = state.intervals(stamps);
  const bool damaged = !out.intervals.empty() && out.intervals.back().damaged;
  if (damaged || moves || blind || t_j - t_i > state.longestUnjudged()) {
    out.position_sigma = kBridgedPosition * std::sqrt(t_j - t_i);
    out.yaw_sigma_deg = kBridgedYaw * std::sqrt(t_j - t_i);
  }
  if (innovation.blind) {
    state.widenByImuAlone(window[window.size() - 2], t_j, &out);
  } else {
    state.alone.reset();
  }
  if (!damaged) return out;
  if (innovation.culprit == Culprit::kNotJudged) {
    // Too few tracks say where the damage has led.
    out.position_sigma = std::hypot(out.position_sigma, predicted.positionSigma());
    out.yaw_sigma_deg = std::hypot(out.yaw_sigma_deg, kRadToDeg * predicted.yawSigma());
  }
  // The host has predicted through what is not to be believed.
  out.replaces_newest = true;
  out.newest = toHostState(innovation.best, calibration.td);
  out.newest.stamp = window.back().stamp;
  return out;
}

HostHealth HostAdapter::watch(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                              const Eigen::Vector3d& tic, bool wants_evidence) {
  State::Lock lock(state_->mutex);
  state_->noteWindow(window);
  HostHealth health =
      state_->judge(window, state_->calibrationWith(ric, tic), wants_evidence, &lock);
  if (state_->options.estimate_extrinsic && health.healthy && !health.suspect) {
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
  return state_->intervals(stamps);
}

std::pair<double, double> HostAdapter::lastDamage() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->screen.damage().empty()) return {kNever, kNever};
  const Calibration calibration = state_->calibration();
  const ImuDamage& damage = state_->screen.damage().back();
  return {calibration.imageStamp(damage.first), calibration.imageStamp(damage.last)};
}

HostOptions HostAdapter::options() const { return state_->options; }

InitializerInfo HostAdapter::info() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  InitializerInfo info = state_->initializer->info();
  info.counts.imu[AddStatus::kGlitch] += state_->screen.discarded();
  return info;
}

}  // namespace slim_init::vins_adapter
