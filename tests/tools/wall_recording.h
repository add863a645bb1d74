// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>

#include "slim_init/evaluation/sequence_writer.h"
#include "support/text_parts.h"

namespace slim_init {

/// A camera that moves sideways before a wall full of squares, swinging at 0.8 Hz, for `kSeconds`.
struct Wall {
  static constexpr double kSeconds = 4.0;
  static constexpr double kFocal = 220.0;
  static constexpr std::int64_t kT0Ns = 1500000000000000000;

  static evaluation::WriterRig rig() {
    evaluation::WriterRig rig;
    // Camera axes: x to the right = -y of the body, y down = -z, z ahead = x.
    rig.calibration.R_b_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    rig.camera.width = 320;
    rig.camera.height = 240;
    rig.camera.fx = rig.camera.fy = kFocal;
    rig.camera.cx = 160.0;
    rig.camera.cy = 120.0;
    return rig;
  }

  static NavState truth(double t) {
    const double w = 2.0 * 3.14159265358979 * 0.8;
    NavState state;
    state.p_w_b = Eigen::Vector3d(0.0, 0.25 * std::sin(w * t), 0.15 * std::sin(0.7 * w * t));
    state.v_w_b =
        Eigen::Vector3d(0.0, 0.25 * w * std::cos(w * t), 0.105 * w * std::cos(0.7 * w * t));
    state.gyro_bias = Eigen::Vector3d(0.01, -0.02, 0.03);
    return state;
  }

  static ImuSample imu(double t) {
    const double w = 2.0 * 3.14159265358979 * 0.8;
    ImuSample sample;
    sample.gyro = truth(t).gyro_bias;
    sample.accel = Eigen::Vector3d(0.0, -0.25 * w * w * std::sin(w * t),
                                   9.81007 - 0.15 * 0.49 * w * w * std::sin(0.7 * w * t));
    return sample;
  }

  /// Squares at depths from 2 to 5 m, the far ones first.
  static cv::Mat image(double t) {
    const Eigen::Vector3d p = truth(t).p_w_b;
    cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(90));
    for (int i = 0; i < 60; ++i) {
      const double depth = 5.0 - 0.05 * i;
      const double y = 2.4 * std::sin(12.9898 * i) - p.y();
      const double z = 1.8 * std::sin(78.233 * i) - p.z();
      constexpr int kShift = 8;  // of sub-pixel corners
      const auto fixed = [](double value) { return static_cast<int>(std::lround(256.0 * value)); };
      const double u = 160.0 - kFocal * y / depth;
      const double v = 120.0 - kFocal * z / depth;
      const double half = kFocal * 0.11 / depth;
      const cv::Point corners[] = {{fixed(u - half), fixed(v - half)},
                                   {fixed(u + half), fixed(v - half)},
                                   {fixed(u + half), fixed(v + half)},
                                   {fixed(u - half), fixed(v + half)}};
      cv::fillConvexPoly(picture, corners, 4, cv::Scalar(20 + (i * 53) % 220), cv::LINE_AA, kShift);
    }
    return picture;
  }

  static void writeAsl(const std::string& directory) {
    evaluation::RecordedMotion recording;
    recording.t0_ns = kT0Ns;
    for (int k = 0; k <= static_cast<int>(200 * kSeconds); ++k) {
      const double t = k / 200.0;
      recording.imu.push_back(imu(t));
      recording.imu.back().t = t;
      if (k % 2 == 0) {
        recording.truth.push_back(truth(t));
        recording.truth.back().t = t;
      }
      if (k % 10 == 0) recording.image_times.push_back(t);
    }
    ASSERT_EQ(evaluation::writeAslFolder(directory, rig(), recording), "");
    for (const double t : recording.image_times) {
      ASSERT_EQ(evaluation::writeAslImage(directory, recording.stampNs(t), image(t)), "");
    }
  }

  static void writeBag(const std::string& file) {
    writeAsl(file + ".asl");
    ASSERT_EQ(evaluation::writeBag(file + ".asl", {"/wall/imu", "/wall/image", "", true}, file),
              "");
  }

  /// The host's configuration file for this rig.
  static std::string config() {
    return "%YAML:1.0\nimu_topic: \"/wall/imu\"\nimage_topic: \"/wall/image\"\n"
           "model_type: PINHOLE\ncamera_name: camera\nimage_width: 320\nimage_height: 240\n"
           "distortion_parameters: {k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0}\n"
           "projection_parameters: {fx: 220.0, fy: 220.0, cx: 160.0, cy: 120.0}\n" +
           matrixKey("extrinsicRotation", 3, 3, "0., 0., 1., -1., 0., 0., 0., -1., 0.") +
           matrixKey("extrinsicTranslation", 3, 1, "0., 0., 0.") +
           "g_norm: 9.81007\ntd: 0.0\n"
           "slim_init:\n  noise: {gyro_density: 1.7e-4, accel_density: 2.0e-3}\n";
  }
};

}  // namespace slim_init
