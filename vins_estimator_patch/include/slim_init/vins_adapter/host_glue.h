// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the lines inserted into a checkout of VINS-Mono or a relative call. The templates touch the
// host's estimator, everything else is in the library.
//
// Hosts of that family are compiled as C++11, and so are this header and all that it includes. Only
// vectors of plain numbers and of unaligned Eigen types cross into the library, so that the host's
// optimization flags do not matter.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "slim_init/vins_adapter/host_members.h"
#include "slim_init/vins_adapter/host_state.h"

namespace slim_init {
namespace vins_adapter {

class HostAdapter;
struct HostFile;

/// How important a report is.
enum class ReportLevel {
  kRow,     ///< a row of slim_init_starts.csv, for the topic and not for the console
  kHealth,  ///< health of the host's states, for its topic and not for the console
  kFrame,   ///< how well the odometry frame is known, for its topic and not for the console
  kInfo,    ///< what was decided
  kWarn,    ///< something is missing or was refused
  kError    ///< the adapter is off
};

/// A window to put into the host.
struct GlueWindow : HostWindow {
  Eigen::Matrix3d ric = Eigen::Matrix3d::Identity();  ///< camera to body
  Eigen::Vector3d tic = Eigen::Vector3d::Zero();
  /// t_imu = stamp + td [s]; NaN: the host's stays.
  double td = std::numeric_limits<double>::quiet_NaN();
  std::vector<HostImuInterval> intervals;  ///< as in HostPreparation
};

/// A sensor_msgs::PointCloud without ROS: points in the plane z = 1, named values for each.
struct GlueCloud {
  /// As in the message.
  struct Header {
    /// As in the message.
    struct Stamp {
      double seconds = 0.0;
      double toSec() const { return seconds; }
    } stamp;
  } header;
  /// As in the message.
  struct Point {
    float x, y, z;
  };
  /// As in the message.
  struct Channel {
    std::string name;
    std::vector<float> values;
  };
  std::vector<Point> points;
  std::vector<Channel> channels;
};

namespace glue_detail {

inline double stampOf(double stamp) { return stamp; }
template <typename Header>
double stampOf(const Header& header) {
  return header.stamp.toSec();
}

/// Frames of the host's full window.
template <typename Estimator>
constexpr int windowFrames() {
  return static_cast<int>(std::extent<decltype(Estimator::Ps)>::value);
}

template <typename Estimator>
HostState stateOf(const Estimator& e, int i) {
  HostState state;
  state.stamp = stampOf(e.Headers[i]);
  state.P = e.Ps[i];
  state.R = e.Rs[i];
  state.V = e.Vs[i];
  state.Ba = e.Bas[i];
  state.Bg = e.Bgs[i];
  return state;
}

template <typename Estimator>
std::vector<HostState> windowOf(const Estimator& e) {
  std::vector<HostState> window;
  for (int i = 0; i < windowFrames<Estimator>(); ++i) window.push_back(stateOf(e, i));
  return window;
}

/// The interval of the host before frame `i` measured again: its own samples hold a glitch, which
/// would throw off the optimization that follows, or have a hole.
template <typename Estimator>
void rebuildInterval(const HostImuInterval& interval, int i, Estimator& e) {
  typedef typename std::remove_pointer<
      typename std::remove_reference<decltype(e.pre_integrations[0])>::type>::type Integration;
  if (e.pre_integrations[i] == nullptr || interval.dt.empty()) return;
  Integration* fresh =
      new Integration(interval.accel[0], interval.gyro[0], e.Bas[i - 1], e.Bgs[i - 1]);
  e.dt_buf[i].clear();
  e.linear_acceleration_buf[i].clear();
  e.angular_velocity_buf[i].clear();
  for (std::size_t k = 1; k < interval.dt.size(); ++k) {
    fresh->push_back(interval.dt[k], interval.accel[k], interval.gyro[k]);
    e.dt_buf[i].push_back(interval.dt[k]);
    e.linear_acceleration_buf[i].push_back(interval.accel[k]);
    e.angular_velocity_buf[i].push_back(interval.gyro[k]);
  }
  // The host's order: position, rotation, velocity, biases.
  fresh->covariance.diagonal().template segment<3>(0).array() +=
      interval.sigma_p * interval.sigma_p;
  fresh->covariance.diagonal().template segment<3>(3).array() +=
      interval.sigma_theta * interval.sigma_theta;
  fresh->covariance.diagonal().template segment<3>(6).array() +=
      interval.sigma_v * interval.sigma_v;
  delete e.pre_integrations[i];
  e.pre_integrations[i] = fresh;
  if (i + 1 == windowFrames<Estimator>()) {
    e.acc_0 = interval.accel.back();
    e.gyr_0 = interval.gyro.back();
  }
}

template <typename Estimator>
void rebuildDamaged(const std::vector<HostImuInterval>& intervals, Estimator& e) {
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (intervals[i].damaged) rebuildInterval(intervals[i], static_cast<int>(i) + 1, e);
  }
}

/// Everything that the host's next optimization reads. The window has all frames.
template <typename Estimator>
void writeWindow(const GlueWindow& window, Estimator& e) {
  const int newest = windowFrames<Estimator>() - 1;
  for (int i = 0; i <= newest; ++i) {
    const HostState& state = window.states[i];
    e.Ps[i] = state.P;
    e.Rs[i] = state.R;
    e.Vs[i] = state.V;
    e.Bas[i] = state.Ba;
    e.Bgs[i] = state.Bg;
    if (e.pre_integrations[i] != nullptr) {
      e.pre_integrations[i]->repropagate(state.Ba, state.Bg);
    }
  }
  e.g = window.G;
  // The host triangulates what has a negative depth, from the new poses.
  for (auto& feature : e.f_manager.feature) {
    feature.estimated_depth = -1.0;
    feature.solve_flag = 0;
    forgetLidarDepth(feature);
    forgetWeight(feature);
  }
  forgetLines(e.f_manager);
  const bool anchored = anchorAgain(e);
  // The old prior is about the old states.
  if (e.last_marginalization_info != nullptr) delete e.last_marginalization_info;
  e.last_marginalization_info = nullptr;
  e.last_marginalization_parameter_blocks.clear();
  setPrior(e, window.prior, anchored);
  // Its failure detection compares to these.
  e.last_R = e.Rs[newest];
  e.last_P = e.Ps[newest];
  e.last_R0 = e.Rs[0];
  e.last_P0 = e.Ps[0];
  e.failure_occur = false;
  rebuildDamaged(window.intervals, e);
}

/// Takes features out of the host's window, whole: their views are counted from the first one on.
/// `ids` ascend.
template <typename Estimator>
void forgetTracks(const std::vector<long long>& ids, Estimator& e) {
  if (ids.empty()) return;
  for (auto feature = e.f_manager.feature.begin(); feature != e.f_manager.feature.end();) {
    const long long id = feature->feature_id;
    if (std::binary_search(ids.begin(), ids.end(), id)) {
      feature = e.f_manager.feature.erase(feature);
    } else {
      ++feature;
    }
  }
}

}  // namespace glue_detail

/// A member of the host's estimator. Until open() finds a reason to be active, and always in a host
/// whose file has none of our keys, every call returns at once and changes nothing.
///
/// The host calls it at six events: addImu(), addFrame(), the initialization (decides(), seed(),
/// stockTried()), optimized(), hostCleared(), and ridesThrough() before a restart of its tracker.
/// All calls come from the host's processing thread, except addLines(), addSpeed(), received(),
/// requestRecovery(), imuRefused() and listen(), which may come from any, and ridesThrough(). None
/// of them waits for a solve longer than `max_wait_ms` of the host's file.
class HostGlue {
 public:
  typedef std::function<void(ReportLevel, const std::string&)> Listener;

  HostGlue();
  ~HostGlue();
  HostGlue(const HostGlue&) = delete;
  HostGlue& operator=(const HostGlue&) = delete;

  /// Receives all reports; called in the thread in which it happens, outside any lock.
  void listen(const Listener& listener);

  /// Reads the host's file. True when the adapter takes part; on a problem it reports an error and
  /// the host stays stock.
  bool open(const std::string& config_file);

  /// The same with an adapter around an initializer of the caller's own, which is not null, and
  /// what a file would say.
  bool open(std::unique_ptr<HostAdapter> adapter, const HostFile& file);

  /// False: the adapter does not take part, and data need not be passed.
  bool active() const;

  // ------------------------------------------------------------------------------------ streams

  /// As received, `t` on the IMU clock. A sample passed twice is added once.
  void addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro);
  /// The same from a sensor_msgs::Imu.
  template <typename Message>
  void addImu(const Message& message) {
    const auto& a = message.linear_acceleration;
    const auto& w = message.angular_velocity;
    addImu(message.header.stamp.toSec(), Eigen::Vector3d(a.x, a.y, a.z),
           Eigen::Vector3d(w.x, w.y, w.z));
  }

  /// The stamp of an image whose features have arrived and wait to be processed [s]: how far the
  /// odometry is behind it is watched. In the thread that receives it.
  void received(double stamp);

  /// A message of the line tracker (feature_message.h).
  template <typename Cloud>
  void addLines(const Cloud& message) {
    if (!active()) return;
    GlueCloud cloud;
    cloud.header.stamp.seconds = message.header.stamp.toSec();
    for (const auto& point : message.points) cloud.points.push_back({point.x, point.y, point.z});
    for (const auto& one : message.channels) {
      cloud.channels.push_back({one.name, {one.values.begin(), one.values.end()}});
    }
    addLineCloud(cloud);
  }

  /// Topic of measured velocities in the host's file; empty: none, or the host stays stock.
  std::string speedTopic() const;

  /// One of them in the frame of the sensor [m/s], `t` on the IMU clock. The first one of each kind
  /// that cannot be used is reported.
  void addSpeed(double t, const Eigen::Vector3d& velocity, const Eigen::Matrix3d& covariance);

  /// Requests a recovery with the next frame in flight, without a failure. If it is refused, the
  /// host goes on, or resets itself when `reset_if_refused`.
  void requestRecovery(bool reset_if_refused);

  // ------------------------------------------------------------------------------------ events

  /// Once per frame, when the host's window has it and before it is used: the host's `image` map,
  /// its header or stamp, and its present `td`. In flight, if the tracks of the frame contradict
  /// the IMU data, or these are missing, the data are replaced in the host's window, with the
  /// covariance of what is not known, and so is the prediction of its newest state: the images
  /// carry the host. If a part of the tracks moves against the scene, it is taken out of the
  /// window. With the first frame after a gap that it rides through, the host's failure detection
  /// is to compare to that prediction: the frame before the gap is far away. A recovery that was
  /// requested is made here. True: it was refused, and the host is to reset itself.
  template <typename Estimator, typename Header, typename Image>
  bool addFrame(Estimator& e, const Header& header, const Image& image, double td) {
    if (!active()) return false;
    std::vector<double> points;
    for (const auto& feature : image) {
      for (const auto& view : feature.second) {
        if (view.first != 0) continue;
        points.push_back(feature.first);
        for (int i = 0; i < 5; ++i) points.push_back(view.second(i));  // x, y, z, u, v
      }
    }
    addPoints(glue_detail::stampOf(header), points, td);
    if (!reinit() || e.solver_flag != Estimator::NON_LINEAR || !isFull(e)) return false;
    const int newest = e.frame_count;
    const HostPreparation frame = prepareFrame(glue_detail::windowOf(e), e.ric[0], e.tic[0]);
    glue_detail::rebuildDamaged(frame.intervals, e);
    if (frame.replaces_newest) {
      e.Ps[newest] = frame.newest.P;
      e.Rs[newest] = frame.newest.R;
      e.Vs[newest] = frame.newest.V;
    }
    glue_detail::forgetTracks(frame.moving, e);
    if (endsRide()) {
      e.last_P = e.Ps[newest];
      e.last_R = e.Rs[newest];
    }
    if (!takeRequest()) return false;
    // Also if the last healthy states fill the window while the solve runs.
    const bool filled = recoverWindow(e, false);
    return resetsAfterRefusal() && !filled;
  }

  /// The adapter seeds the host, in place of the host's own initialization. If not, the host's own
  /// attempt begins, whose time is taken in shadow mode.
  bool decides();

  /// Fills the host's full window and returns true, or declines. If the host estimates its
  /// calibration, the one that was found goes into the host and into its parameters, which a reset
  /// returns to. When it declines, it may have the host drop its oldest frame, so that frames from
  /// before a standstill do not stay in it.
  template <typename Estimator>
  bool seed(Estimator& e, int& estimate_extrinsic, Eigen::Matrix3d& ric, Eigen::Vector3d& tic) {
    if (!decides() || !isFull(e)) return false;
    bool drop_oldest = false;
    GlueWindow window;
    if (!seedWindow(glue_detail::windowOf(e), &window, &drop_oldest)) {
      if (drop_oldest) e.marginalization_flag = Estimator::MARGIN_OLD;
      return false;
    }
    glue_detail::writeWindow(window, e);
    // In flight the host may know them better by now.
    e.ric[0] = window.ric;
    e.tic[0] = window.tic;
    e.f_manager.setRic(e.ric);
    if (!std::isnan(window.td)) glue_detail::setTd(e, window.td);
    if (estimate_extrinsic != 0) {
      estimate_extrinsic = 1;
      ric = window.ric;
      tic = window.tic;
    }
    return true;
  }

  /// After the host's own attempt, with its `result`. Shadow mode solves the same window and
  /// records both estimates; the host is not touched. After a stock start that follows a reset, the
  /// window continues the odometry frame from before it.
  template <typename Estimator>
  void stockTried(Estimator& e, bool result) {
    if (!active() || !isFull(e)) return;
    HostWindow window;
    window.states = glue_detail::windowOf(e);
    const bool tried = result || e.initial_timestamp == window.states.back().stamp;
    if (!takeStock(tried, result, &window)) return;
    for (std::size_t i = 0; i < window.states.size(); ++i) {
      e.Ps[i] = window.states[i].P;
      e.Rs[i] = window.states[i].R;
      e.Vs[i] = window.states[i].V;
    }
  }

  /// In flight, once per frame, after the host's optimization and before its own failure detection.
  /// If the watchdog finds the states inconsistent, or the host finds a failure, the window is
  /// filled again so that position and yaw continue; while the solve runs, with the last healthy
  /// states, propagated by the IMU. The host then optimizes it: `solve()`. `failed()` is its
  /// failure detection. A state without a finding may be needed later and is kept, and with the
  /// first one those before it.
  template <typename Estimator, typename Failed, typename Solve>
  void optimized(Estimator& e, Failed failed, Solve solve) {
    if (!active() || !isFull(e)) return;
    if (judgeWindow(glue_detail::windowOf(e), e.ric[0], e.tic[0]) && recoverWindow(e, true)) {
      solve();
    }
    if (!reinit()) return;
    if (!failed()) {
      addHealthy(glue_detail::windowOf(e));
    } else if (recoverWindow(e, true)) {
      solve();
    }
  }

  /// The host forgets its states, for whatever reason: the next start continues its odometry frame.
  void hostCleared();
  /// The same for a host whose reset empties its queues of (stamp, vector), which are given with
  /// their mutex.
  template <typename Mutex, typename Samples>
  void hostCleared(Mutex& buffer, const Samples& accel_waiting, const Samples& gyro_waiting) {
    std::unique_lock<Mutex> lock(buffer);
    Samples accel = accel_waiting, gyro = gyro_waiting;
    lock.unlock();
    for (; !accel.empty() && !gyro.empty(); accel.pop(), gyro.pop()) {
      addImu(accel.front().first, accel.front().second, gyro.front().second);
    }
    hostCleared();
  }

  /// The host does not take this sample because its newest one is younger: time may have gone back.
  /// From any thread.
  void imuRefused(double t);

  /// The tracker was restarted after a gap in the images and requests a restart of the host: true
  /// if that is not needed, because time has not gone back, the state before the gap was healthy
  /// and the IMU data since, with the samples in the queue, are whole. Otherwise these samples,
  /// which the restart empties, are added. Takes the mutexes of the host's estimator and of its
  /// queue.
  template <typename Mutex, typename Queue>
  bool ridesThrough(Mutex& estimator, Mutex& buffer, const Queue& samples) {
    if (!active()) return false;
    const std::lock_guard<Mutex> estimator_lock(estimator);
    const std::lock_guard<Mutex> buffer_lock(buffer);
    std::vector<double> stamps;
    for (Queue waiting = samples; !waiting.empty(); waiting.pop()) {
      stamps.push_back(waiting.front()->header.stamp.toSec());
    }
    if (bridgesGap(stamps)) return true;
    for (Queue waiting = samples; !waiting.empty(); waiting.pop()) addImu(*waiting.front());
    return false;
  }

  /// A repair of the host: after each optimization it turns its window about the vertical (z) to
  /// the former yaw of its oldest frame, an Euler angle, which near a pitch of 90 deg changes with
  /// the slightest tilt. With keep_heading: 1 in the file this puts the turn that keeps the heading
  /// into `turn`. `before`, `optimized`: the oldest frame, body to world.
  void keepHeading(const Eigen::Matrix3d& before, const Eigen::Matrix3d& optimized,
                   Eigen::Matrix3d* turn) const;

  /// For a host that cannot reset itself in addFrame(): true once after each requestReset().
  bool takeReset();
  void requestReset();

 private:
  template <typename Estimator>
  static bool isFull(const Estimator& e) {
    return e.frame_count + 1 == glue_detail::windowFrames<Estimator>();
  }

  template <typename Estimator>
  bool recoverWindow(Estimator& e, bool failed) {
    GlueWindow window;
    if (!solveRecovery(glue_detail::windowOf(e), failed, &window)) return false;
    glue_detail::writeWindow(window, e);
    return true;
  }

  bool reinit() const;
  bool judgeWindow(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                   const Eigen::Vector3d& tic);
  HostPreparation prepareFrame(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                               const Eigen::Vector3d& tic);
  bool bridgesGap(const std::vector<double>& waiting);
  bool endsRide();
  void addPoints(double stamp, const std::vector<double>& points, double td);
  void addLineCloud(const GlueCloud& cloud);
  bool seedWindow(const std::vector<HostState>& frames, GlueWindow* window, bool* drop_oldest);
  bool solveRecovery(const std::vector<HostState>& frames, bool failed, GlueWindow* window);
  bool takeStock(bool tried, bool result, HostWindow* window);
  void addHealthy(const std::vector<HostState>& window);
  bool takeRequest();
  bool resetsAfterRefusal();

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vins_adapter
}  // namespace slim_init
