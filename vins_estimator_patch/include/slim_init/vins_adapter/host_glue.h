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
#include <string>
#include <type_traits>
#include <vector>

#include "slim_init/vins_adapter/host_depth.h"
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
};

/// One tracked point of camera 0.
struct GluePoint {
  long long id = -1;
  double x = 0.0, y = 0.0, z = 1.0;  ///< undistorted normalised
  double u = 0.0, v = 0.0;           ///< [px]
};

/// A sensor_msgs::PointCloud without ROS.
struct GlueCloud {
  /// Time stamp of a message, as ros::Time has it.
  struct Stamp {
    double seconds = 0.0;
    double toSec() const { return seconds; }
  };
  /// Header of a message.
  struct Header {
    Stamp stamp;
  };
  /// A point in the plane z = 1.
  struct Point {
    float x = 0.0f, y = 0.0f, z = 0.0f;
  };
  /// Named values, one per point.
  struct Channel {
    std::string name;
    std::vector<float> values;
  };
  Header header;
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
    forgetLidarDepth(feature, 0);
    forgetWeight(feature, 0);
  }
  forgetLines(e.f_manager, 0);
  const bool anchored = anchorAgain(e, 0);
  // The old prior is about the old states.
  if (e.last_marginalization_info != nullptr) delete e.last_marginalization_info;
  e.last_marginalization_info = nullptr;
  e.last_marginalization_parameter_blocks.clear();
  setPrior(e, window.prior, anchored, 0);
  // Its failure detection compares to these.
  e.last_R = e.Rs[newest];
  e.last_P = e.Ps[newest];
  e.last_R0 = e.Rs[0];
  e.last_P0 = e.Ps[0];
  e.failure_occur = false;
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

/// The rotation about z that brings `from` closest to `to`: the twist about z of their difference.
/// Unlike a difference of Euler yaws it is well defined for every mounting. False, and `turn` as it
/// was, where the difference tilts by 180 deg.
inline bool turnAboutVertical(const Eigen::Matrix3d& to, const Eigen::Matrix3d& from,
                              Eigen::Matrix3d* turn) {
  const Eigen::Matrix3d difference = to * from.transpose();
  const double sine = difference(1, 0) - difference(0, 1);
  const double cosine = difference(0, 0) + difference(1, 1);
  const double norm = std::hypot(sine, cosine);
  if (!(norm > 1e-3)) return false;
  *turn << cosine / norm, -sine / norm, 0.0, sine / norm, cosine / norm, 0.0, 0.0, 0.0, 1.0;
  return true;
}

/// Moves the whole window so that its first frame has the position and the yaw of `anchor`.
template <typename Estimator>
void moveWindow(const HostState& anchor, Estimator& e) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  turnAboutVertical(anchor.R, e.Rs[0], &R);
  const Eigen::Vector3d origin = e.Ps[0];
  for (int i = 0; i < windowFrames<Estimator>(); ++i) {
    e.Ps[i] = anchor.P + R * (e.Ps[i] - origin);
    e.Rs[i] = R * e.Rs[i];
    e.Vs[i] = R * e.Vs[i];
  }
}

}  // namespace glue_detail

/// A member of the host's estimator. Until open() finds a reason to be active, and always in a host
/// whose file has none of our keys, every call returns at once and changes nothing.
///
/// All calls come from the host's processing thread, except addLines(), addSpeed(), received(),
/// requestRecovery() and listen(), which may come from any. None of them waits for a solve longer
/// than `max_wait_ms` of the host's file.
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

  /// The stamp of an image whose features have arrived and wait to be processed [s]: how far the
  /// odometry is behind it is watched. In the thread that receives it.
  void received(double stamp);

  /// The host's `image` map, its header or stamp, and its present `td`.
  template <typename Header, typename Image>
  void addFrame(const Header& header, const Image& image, double td) {
    if (!active()) return;
    std::vector<GluePoint> points;
    points.reserve(image.size());
    for (const auto& feature : image) {
      for (const auto& view : feature.second) {
        if (view.first != 0) continue;
        GluePoint point;
        point.id = feature.first;
        point.x = view.second(0);
        point.y = view.second(1);
        point.z = view.second(2);
        point.u = view.second(3);
        point.v = view.second(4);
        points.push_back(point);
      }
    }
    addPoints(glue_detail::stampOf(header), points, td);
  }

  /// A message of the line tracker (feature_message.h).
  template <typename Cloud>
  void addLines(const Cloud& message) {
    if (!active()) return;
    GlueCloud cloud;
    cloud.header.stamp.seconds = message.header.stamp.toSec();
    cloud.points.resize(message.points.size());
    for (std::size_t i = 0; i < message.points.size(); ++i) {
      cloud.points[i].x = message.points[i].x;
      cloud.points[i].y = message.points[i].y;
      cloud.points[i].z = message.points[i].z;
    }
    cloud.channels.resize(message.channels.size());
    for (std::size_t c = 0; c < message.channels.size(); ++c) {
      cloud.channels[c].name = message.channels[c].name;
      cloud.channels[c].values.assign(message.channels[c].values.begin(),
                                      message.channels[c].values.end());
    }
    addLineCloud(cloud);
  }

  /// Topic of measured velocities in the host's file; empty: none, or the host stays stock.
  std::string speedTopic() const;

  /// One of them in the frame of the sensor [m/s], `t` on the IMU clock. The first one of each kind
  /// that cannot be used is reported.
  void addSpeed(double t, const Eigen::Vector3d& velocity, const Eigen::Matrix3d& covariance);

  // ------------------------------------------------------------------------------------- seed

  /// The adapter seeds the host, in place of the host's own initialization.
  bool decides() const;

  /// Fills the host's full window, and the calibration that was found where the host estimates it,
  /// and returns true; or declines. When it declines, it may have the
  /// host drop its oldest frame, so that frames from before a standstill do not stay in it.
  template <typename Estimator>
  bool seed(Estimator& e) {
    if (!decides() || e.frame_count + 1 != glue_detail::windowFrames<Estimator>()) return false;
    bool drop_oldest = false;
    GlueWindow window;
    const std::vector<double> frames = stamps(e);
    if (seedWindow(frames, &window, &drop_oldest)) {
      glue_detail::writeWindow(window, e);
      rebuildDamaged(imuIntervals(frames), e);
      // In flight the host may know them better by now.
      e.ric[0] = window.ric;
      e.tic[0] = window.tic;
      e.f_manager.setRic(e.ric);
      if (!std::isnan(window.td)) glue_detail::setTd(e, window.td, 0);
      return true;
    }
    if (drop_oldest) e.marginalization_flag = Estimator::MARGIN_OLD;
    return false;
  }

  /// Shadow mode: before the host's own attempt, and after it with its `result`. The second call
  /// solves the same window and records both estimates; the host is not touched.
  void timeStock();
  template <typename Estimator>
  void recordStock(const Estimator& e, bool result) {
    if (!shadows() || e.frame_count + 1 != glue_detail::windowFrames<Estimator>()) return;
    const bool tried =
        result || e.initial_timestamp == glue_detail::stampOf(e.Headers[e.frame_count]);
    recordShadow(glue_detail::windowOf(e), tried, result);
  }

  /// After a start by the host's own initialization: its window continues the odometry frame from
  /// before a reset.
  template <typename Estimator>
  void continueFrameOfStock(Estimator& e) {
    if (!continuesFrameOfStock() || e.frame_count + 1 != glue_detail::windowFrames<Estimator>())
      return;
    HostState anchor;
    if (continuedAt(glue_detail::stampOf(e.Headers[0]), &anchor)) {
      glue_detail::moveWindow(anchor, e);
    }
  }

  // ---------------------------------------------------------------------------------- recover

  /// In flight, once per frame and before the window slides: judges the host's states. When they
  /// are inconsistent, it fills the window again, and returns true when it did: the host is to
  /// optimize it.
  template <typename Estimator>
  bool watch(Estimator& e) {
    if (!watches() || e.frame_count + 1 != glue_detail::windowFrames<Estimator>()) return false;
    const Eigen::Matrix3d ric = e.ric[0];
    const Eigen::Vector3d tic = e.tic[0];
    return judgeWindow(glue_detail::windowOf(e), ric, tic) && recoverWindow(e, true);
  }

  /// In flight, once per frame and before the host's optimization. Where the tracks of the frame
  /// contradict the IMU data, or these are missing, the data are replaced in the host's window,
  /// with the covariance of what is not known, and so is the prediction of its newest state: the
  /// images carry the host. Where a part of the tracks moves against the scene, that part is taken
  /// out of the window. With the first frame after a gap that it rides through, the host's failure
  /// detection is to compare to that prediction: the frame before the gap is far away.
  template <typename Estimator>
  void prepare(Estimator& e) {
    if (!reinit() || e.frame_count + 1 != glue_detail::windowFrames<Estimator>()) return;
    const int newest = e.frame_count;
    const Eigen::Matrix3d ric = e.ric[0];
    const Eigen::Vector3d tic = e.tic[0];
    const HostPreparation frame = prepareFrame(glue_detail::windowOf(e), ric, tic);
    rebuildDamaged(frame.intervals, e);
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
  }

  /// The tracker was restarted after a gap in the images and requests a restart of the host: true
  /// where that is not needed, because the state before the gap was healthy and the IMU data since
  /// are whole. `newest_sample`: stamp of the last IMU sample that waits to be processed [s];
  /// negative: none.
  bool ridesThrough(double newest_sample);

  /// The host forgets its states, for whatever reason: the next start continues its odometry frame.
  void hostCleared();

  /// After every frame that went well: the newest state may be needed, and of the first such frame
  /// those before it. What the watchdog suspects is not kept.
  template <typename Estimator>
  void rememberHealthy(const Estimator& e) {
    if (reinit()) addHealthy(glue_detail::windowOf(e));
  }

  /// After a failure: fills the window so that position and yaw continue, or declines. While the
  /// solve runs it fills it with the last healthy states, propagated by the IMU.
  template <typename Estimator>
  bool recover(Estimator& e) {
    return recoverWindow(e, true);
  }

  /// Requests a recovery with the next frame, without a failure. If it is refused, the host goes
  /// on, or resets itself when `reset_if_refused`.
  void requestRecovery(bool reset_if_refused);

  /// Recovers where it was requested. True: that was refused, and the host is to reset itself.
  template <typename Estimator>
  bool serveRequest(Estimator& e) {
    bool reset_if_refused = false;
    if (!takeRequest(&reset_if_refused)) return false;
    return !recoverWindow(e, false) && !isPending() && reset_if_refused;
  }

  /// After each optimization the host turns its window about the vertical (z), so that its oldest
  /// frame has the yaw from before; it takes that from Euler angles, which near a pitch of 90 deg
  /// change with the slightest tilt. Where the file says keep_heading: 1 this puts the turn that
  /// keeps the heading into `turn`. `before`, `optimized`: the oldest frame, body to world.
  void keepHeading(const Eigen::Matrix3d& before, const Eigen::Matrix3d& optimized,
                   Eigen::Matrix3d* turn) const;

  /// For a host that cannot reset itself where the request is served: takeReset() is true once
  /// after each requestReset().
  void requestReset();
  bool takeReset();

 private:
  template <typename Estimator>
  static std::vector<double> stamps(const Estimator& e) {
    std::vector<double> result;
    for (int i = 0; i <= e.frame_count; ++i) {
      result.push_back(glue_detail::stampOf(e.Headers[i]));
    }
    return result;
  }

  template <typename Estimator>
  static void rebuildDamaged(const std::vector<HostImuInterval>& intervals, Estimator& e) {
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      if (intervals[i].damaged) {
        glue_detail::rebuildInterval(intervals[i], static_cast<int>(i) + 1, e);
      }
    }
  }

  template <typename Estimator>
  bool recoverWindow(Estimator& e, bool failed) {
    if (!reinit() || e.frame_count + 1 != glue_detail::windowFrames<Estimator>()) return false;
    GlueWindow window;
    const std::vector<double> frames = stamps(e);
    if (!solveRecovery(frames, failed, &window)) return false;
    glue_detail::writeWindow(window, e);
    rebuildDamaged(imuIntervals(frames), e);
    return true;
  }

  bool shadows() const;
  bool reinit() const;
  bool watches() const;
  bool continuesFrameOfStock() const;
  bool judgeWindow(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                   const Eigen::Vector3d& tic);
  bool continuedAt(double stamp, HostState* state);
  std::vector<HostImuInterval> imuIntervals(const std::vector<double>& stamps) const;
  HostPreparation prepareFrame(const std::vector<HostState>& window, const Eigen::Matrix3d& ric,
                               const Eigen::Vector3d& tic);
  bool endsRide();
  void addPoints(double stamp, const std::vector<GluePoint>& points, double td);
  void addLineCloud(const GlueCloud& cloud);
  bool seedWindow(const std::vector<double>& stamps, GlueWindow* window, bool* drop_oldest);
  bool solveRecovery(const std::vector<double>& stamps, bool failed, GlueWindow* window);
  void recordShadow(const std::vector<HostState>& window, bool tried, bool result);
  void addHealthy(const std::vector<HostState>& window);
  bool takeRequest(bool* reset_if_refused);
  bool isPending();

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vins_adapter
}  // namespace slim_init
