// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the lines inserted into a checkout of OpenVINS call. The templates touch the host's types,
// everything else is in the library. C++11 as host_glue.h, and for the same reason only plain
// numbers and unaligned Eigen types cross into the library.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/vins_adapter/msckf_state.h"

namespace slim_init {
namespace vins_adapter {

/// What OpenVINS' files say about the rig, in our terms.
struct OpenVinsRig {
  Eigen::Matrix3d R_b_c = Eigen::Matrix3d::Identity();  ///< camera 0 to body
  Eigen::Vector3d t_b_c = Eigen::Vector3d::Zero();      ///< centre of camera 0 in the body [m]
  double td = 0.0;                                      ///< t_imu = stamp + td [s]
  double focal_px = 0.0;                                ///< of camera 0
  double gravity = 9.81;                                ///< [m/s^2]
  double gyro_density = 0.0;                            ///< [rad/s/sqrt(Hz)]
  double accel_density = 0.0;                           ///< [m/s^2/sqrt(Hz)]
};

namespace openvins_detail {

/// Of the host's options; its extrinsic is q_ItoC (JPL: x, y, z, w) and p_IinC.
template <typename Options>
OpenVinsRig rigOf(const Options& options) {
  OpenVinsRig rig;
  const auto extrinsic = options.camera_extrinsics.at(0);
  // JPL's numbers are those of the Hamilton quaternion the other way round.
  rig.R_b_c = Eigen::Quaterniond(extrinsic(3), extrinsic(0), extrinsic(1), extrinsic(2)).matrix();
  rig.t_b_c = -rig.R_b_c * Eigen::Vector3d(extrinsic(4), extrinsic(5), extrinsic(6));
  rig.td = options.calib_camimu_dt;
  rig.focal_px = options.camera_intrinsics.at(0)->get_value()(0);
  rig.gravity = options.gravity_mag;
  rig.gyro_density = options.sigma_w;
  rig.accel_density = options.sigma_a;
  return rig;
}

}  // namespace openvins_detail

/// A member of the host's InertialInitializer. With `initializer: stock`, and without that key,
/// every call returns at once and changes nothing.
///
/// addImu() and addFrames() may be called from other threads than seed() and recordStock(), which
/// the host calls from one thread at a time. They do not wait for a solve.
class OpenVinsGlue {
 public:
  typedef std::function<void(const std::string&)> Listener;

  OpenVinsGlue();
  ~OpenVinsGlue();
  OpenVinsGlue(const OpenVinsGlue&) = delete;
  OpenVinsGlue& operator=(const OpenVinsGlue&) = delete;

  /// Receives all reports, in the thread in which they arise. To be called before open().
  void listen(const Listener& listener);

  /// With the keys of the host's options: mode (stock, slim, shadow), and a file with a section
  /// `slim_init:` or "". True when the adapter takes part; on a problem it reports it, and the host
  /// initializes by itself.
  template <typename Options>
  bool open(const Options& options) {
    if (options.slim_init_mode == "stock") return false;
    return open(options.slim_init_mode, options.slim_init_file, openvins_detail::rigOf(options));
  }
  bool open(const std::string& mode, const std::string& file, const OpenVinsRig& rig);

  /// The adapter takes part, and data are wanted.
  bool active() const;
  /// The adapter seeds the host, in place of its dynamic initialization.
  bool decides() const;

  /// As received, `t` [s] on the IMU clock.
  void addImu(double t, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro);

  /// What the database of tracks has of camera 0 that is newer than what it had before. To be
  /// called when an image has been tracked, and before the next one is.
  template <typename Database>
  void addFrames(Database& database) {
    if (!active()) return;
    const double before = newestFrame();
    std::map<double, std::vector<double>> frames;
    for (const auto& entry : database.get_internal_data()) {
      const auto& feature = *entry.second;
      const auto times = feature.timestamps.find(0);
      if (times == feature.timestamps.end()) continue;
      const auto& rays = feature.uvs_norm.at(0);
      const auto& pixels = feature.uvs.at(0);
      for (std::size_t i = times->second.size(); i > 0 && times->second[i - 1] > before; --i) {
        std::vector<double>& points = frames[times->second[i - 1]];
        const auto &ray = rays[i - 1], &pixel = pixels[i - 1];
        points.insert(points.end(), {double(feature.featid), double(ray(0)), double(ray(1)), 1.0,
                                     double(pixel(0)), double(pixel(1))});
      }
    }
    for (const auto& frame : frames) addPoints(frame.first, frame.second);
  }

  /// Fills the host's IMU state, its covariance and their order and returns true; or declines.
  /// `imu` is the host's shared pointer to its IMU state, `order` its list of such pointers.
  template <typename ImuPointer, typename Order>
  bool seed(const ImuPointer& imu, double* timestamp, Eigen::MatrixXd* covariance, Order* order) {
    if (!decides()) return false;
    const MsckfState state = solve();
    if (state.empty()) return false;
    const Eigen::MatrixXd value = Eigen::Map<const Eigen::MatrixXd>(state.value.data(), 16, 1);
    imu->set_value(value);
    imu->set_fej(value);
    order->clear();
    order->push_back(imu);
    *covariance = Eigen::Map<const Eigen::MatrixXd>(state.covariance.data(), 15, 15);
    *timestamp = state.timestamp;
    return true;
  }

  /// Shadow mode, after each attempt of the host: `success` is its result, and then `timestamp` and
  /// `imu` are its state. Solves the same data and reports both; the host is not touched.
  template <typename ImuPointer>
  void recordStock(bool success, double timestamp, const ImuPointer& imu) {
    if (!active() || decides()) return;
    std::vector<double> value;
    if (success) {
      const Eigen::MatrixXd stock = imu->value();
      value.assign(stock.data(), stock.data() + stock.size());
    }
    compare(success, timestamp, value);
  }

 private:
  double newestFrame() const;
  void addPoints(double stamp, const std::vector<double>& points);
  MsckfState solve();
  void compare(bool success, double timestamp, const std::vector<double>& stock);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vins_adapter
}  // namespace slim_init
