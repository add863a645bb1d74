// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A camera with IMU moving about a BoxRoom, and what tracks are worth against the truth.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "box_room.h"
#include "geometry/so3.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "support/euroc_camera.h"

namespace slim_init::feature_tracker_lines {

/// EuRoC's lens at half its resolution.
inline CameraParameters smallCamera() {
  CameraParameters camera = cameraOf(376, 240, 229.3, 228.6, 183.6, 124.2);
  camera.distortion = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  return camera;
}

/// The colour camera of a RealSense, twice EuRoC's focal length.
inline CameraParameters hdCamera() { return cameraOf(1280, 720, 906.0, 906.0, 640.0, 360.0); }

inline Calibration calibrationOf(const CameraParameters& camera) {
  Calibration calibration;
  calibration.R_b_c = expSO3(Eigen::Vector3d(0.3, -0.2, 1.5));
  calibration.t_b_c = Eigen::Vector3d(0.02, -0.05, 0.01);
  calibration.focal_px = Camera(camera).focalPx();
  return calibration;
}

/// Poses of the camera over time; smooth and known exactly.
struct Motion {
  double translation = 1.0;  ///< factor on the path
  double rotation = 1.0;     ///< factor on the turns
  double shake = 0.0;        ///< amplitude of a tremor of 3 Hz about two axes [rad]

  Eigen::Vector3d p_w_c(double t) const {
    return translation * Eigen::Vector3d(0.35 * std::sin(1.2 * t), 0.2 * std::sin(0.9 * t),
                                         0.35 * std::sin(0.7 * t) - 0.3);
  }
  Eigen::Matrix3d R_w_c(double t) const {
    return expSO3(rotation * Eigen::Vector3d(0.15 * std::sin(1.5 * t), 0.3 * std::sin(1.1 * t),
                                             0.2 * std::sin(0.8 * t))) *
           expSO3(shake * Eigen::Vector3d(std::sin(20.0 * t), std::cos(17.0 * t), 0.0)) *
           expSO3(Eigen::Vector3d(0.1, 0.35, 0.0));
  }
};

/// Renders images and makes gyro samples for a front end.
class RoomWalk {
 public:
  static constexpr double kImagePeriod = 0.05, kImuPeriod = 0.005;  // [s]

  RoomWalk(const CameraParameters& camera, const BoxRoom& room, const Motion& motion, int samples)
      : parameters(camera),
        calibration(calibrationOf(camera)),
        room_(room),
        motion_(motion),
        camera_(camera),
        samples_(samples) {}

  CameraParameters parameters;
  Calibration calibration;
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();          ///< [rad/s]
  double gyro_limit = std::numeric_limits<double>::infinity();  ///< where it saturates [rad/s]
  double noise = 0.0;                                           ///< of the images [grey levels]
  double flicker = 0.0;    ///< every fifth image is brighter by so much [grey levels]
  double readout_s = 0.0;  ///< of the camera: rolling shutter [s]

  double time(int k) const { return k * kImagePeriod; }

  cv::Mat image(int k) {
    const auto pose_of = [&](int y) {
      const double t = time(k) + rowTime(y, parameters.height, readout_s);
      return BoxRoom::Pose{motion_.R_w_c(t), motion_.p_w_c(t)};
    };
    cv::Mat image = room_.render(camera_, pose_of, samples_, &rays_);
    // A lens is no pinhole: without it the edges are stair steps.
    cv::GaussianBlur(image, image, cv::Size(), 0.6);
    if (k % 5 == 4) image += flicker;
    if (noise > 0.0) addNoise(noise, static_cast<std::uint64_t>(k) + 1, &image);
    return image;
  }

  ImuSample imu(double t) const {
    constexpr double kStep = 1e-4;
    ImuSample sample;
    sample.t = t;
    const Eigen::Matrix3d R_before = motion_.R_w_c(t - kStep), R_after = motion_.R_w_c(t + kStep);
    sample.gyro =
        calibration.R_b_c * logSO3(R_before.transpose() * R_after) / (2.0 * kStep) + gyro_bias;
    sample.gyro = sample.gyro.cwiseMin(gyro_limit).cwiseMax(-gyro_limit);
    sample.accel = Eigen::Vector3d(0.0, 0.0, 9.81);
    return sample;
  }

  /// Feeds the IMU up to image k and the image.
  ImageStatus feed(int k, const cv::Mat& picture, ImageFrontEnd* front_end,
                   FrameObservation* frame) {
    for (; next_imu_ * kImuPeriod <= time(k) + 1e-9; ++next_imu_) {
      front_end->addImu(imu(next_imu_ * kImuPeriod));
    }
    return front_end->addImage(time(k), picture, frame);
  }

  /// Exposure of an image row (imageRow()) after the stamp as the calibration has it [s].
  double exposureOf(double row) const { return row * calibration.readout_s; }

  /// The place in the world that a ray of image k meets, in a row exposed `dt` [s] after its stamp.
  Eigen::Vector3d place(int k, const Eigen::Vector3d& bearing, double dt = 0.0) const {
    return room_.hit(motion_.p_w_c(time(k) + dt), motion_.R_w_c(time(k) + dt) * bearing);
  }
  /// Ray of image k to a place in the world, not unit, in such a row.
  Eigen::Vector3d ray(int k, const Eigen::Vector3d& place, double dt = 0.0) const {
    return motion_.R_w_c(time(k) + dt).transpose() * (place - motion_.p_w_c(time(k) + dt));
  }
  /// A ray seen in such a row, in the orientation of the camera at the stamp.
  Eigen::Vector3d atStamp(int k, const Eigen::Vector3d& bearing, double dt) const {
    return motion_.R_w_c(time(k)).transpose() * (motion_.R_w_c(time(k) + dt) * bearing);
  }
  const Camera& camera() const { return camera_; }

 private:
  BoxRoom room_;
  Motion motion_;
  Camera camera_;
  int samples_;
  std::vector<Eigen::Vector3f> rays_;
  int next_imu_ = -2;
};

/// Errors of tracks against where they were first seen.
struct TrackErrors {
  std::vector<double> point_px, line_angle_deg, line_offset_px;
  int line_pairs = 0, line_pairs_right = 0;  ///< the same id five images apart

  static double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 1e9;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }
  double pointsBeyond(double px) const {
    return static_cast<double>(
               std::count_if(point_px.begin(), point_px.end(), [px](double e) { return e > px; })) /
           std::max<double>(1.0, static_cast<double>(point_px.size()));
  }

  void add(const RoomWalk& walk, int k, const FrameObservation& frame) {
    for (const PointObservation& point : frame.points) {
      const auto first =
          points_.try_emplace(point.id, walk.place(k, point.bearing, walk.exposureOf(point.row)));
      if (first.second) continue;
      Eigen::Vector2d pixel(-1e6, -1e6);
      walk.camera().project(walk.ray(k, first.first->second, walk.exposureOf(point.row)), &pixel);
      point_px.push_back((pixel - point.pixel).norm());
    }
    for (const LineObservation& line : frame.lines) {
      const auto first = lines_.try_emplace(line.id, endsOf(walk, k, line));
      if (first.second) continue;
      double angle = 0.0, offset = 0.0;
      compare(walk, k, first.first->second, line, &angle, &offset);
      line_angle_deg.push_back(angle);
      line_offset_px.push_back(offset);
    }
    if (k % 5 != 0) return;
    for (const LineObservation& line : frame.lines) {
      const auto before = keyframe_.find(line.id);
      if (before == keyframe_.end()) continue;
      double angle = 0.0, offset = 0.0;
      compare(walk, k, before->second, line, &angle, &offset);
      ++line_pairs;
      line_pairs_right += angle < 2.0 && offset < 3.0 ? 1 : 0;
    }
    keyframe_.clear();
    for (const LineObservation& line : frame.lines) keyframe_[line.id] = endsOf(walk, k, line);
  }

 private:
  struct Ends {
    Eigen::Vector3d start, end;
  };
  static Ends endsOf(const RoomWalk& walk, int k, const LineObservation& line) {
    return {walk.place(k, line.start_bearing, walk.exposureOf(line.start_row)),
            walk.place(k, line.end_bearing, walk.exposureOf(line.end_row))};
  }
  // In the orientation of the middle row; with rows of their own the ends see the true line from
  // two places, a centimetre apart, which is left out.
  static void compare(const RoomWalk& walk, int k, const Ends& truth, const LineObservation& line,
                      double* angle_deg, double* offset_px) {
    const Eigen::Vector3d expected =
        walk.ray(k, truth.start).cross(walk.ray(k, truth.end)).normalized();
    const Eigen::Vector3d start =
        walk.atStamp(k, line.start_bearing, walk.exposureOf(line.start_row));
    const Eigen::Vector3d end = walk.atStamp(k, line.end_bearing, walk.exposureOf(line.end_row));
    const Eigen::Vector3d seen = start.cross(end).normalized();
    const Eigen::Vector3d middle = (start + end).normalized();
    const Eigen::Vector3d a = expected.cross(middle).normalized(),
                          b = seen.cross(middle).normalized();
    *angle_deg = std::asin(std::min(1.0, a.cross(b).norm())) * 180.0 / M_PI;
    *offset_px = std::abs(expected.dot(middle)) * walk.camera().focalPx();
  }
  std::map<FeatureId, Eigen::Vector3d> points_;
  std::map<FeatureId, Ends> lines_, keyframe_;
};

}  // namespace slim_init::feature_tracker_lines
