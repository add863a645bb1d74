// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A room filmed by hand, for tests that run the program on recordings with pixels.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "doctor/handheld.h"
#include "feature_tracker_lines/room_walk.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/simulation/motion_sensors.h"
#include "support/folder.h"
#include "support/text_parts.h"

namespace slim_init {

constexpr std::int64_t kRoomT0Ns = 1500000000000000000;

inline evaluation::WriterRig roomRig() {
  evaluation::WriterRig rig;
  rig.camera = feature_tracker_lines::smallCamera();
  rig.calibration.R_b_c = handheldExtrinsic();
  rig.calibration.t_b_c = Eigen::Vector3d(0.05, -0.02, 0.01);
  return rig;
}

/// Writes an ASL folder: IMU and ground truth over 5 s, 88 images from 0.2 s on at 20 Hz.
inline void film(const std::string& directory) {
  Handheld motion;
  motion.duration_s = 5.0;
  const simulation::ImuSimulationOptions imu;
  evaluation::RecordedMotion recording;
  recording.t0_ns = kRoomT0Ns;
  recording.imu = simulation::simulateImu(motion, imu);
  for (int k = 0; k <= 500; ++k) {
    recording.truth.push_back(simulation::stateAt(motion, 0.01 * k));
    recording.truth.back().gyro_bias = imu.gyro_bias;
    recording.truth.back().accel_bias = imu.accel_bias;
  }
  for (int k = 4; k < 92; ++k) recording.image_times.push_back(0.05 * k);
  ASSERT_EQ(evaluation::writeAslFolder(directory, roomRig(), recording), "");
  const feature_tracker_lines::BoxRoom room(Eigen::Vector3d(3.0, 3.0, 2.0),
                                            feature_tracker_lines::textures::rich);
  const feature_tracker_lines::Camera camera(roomRig().camera);
  std::vector<Eigen::Vector3f> rays;
  for (int k = 4; k < 92; ++k) {
    const simulation::Kinematics body = motion.at(0.05 * k);
    cv::Mat image = room.render(camera, body.R_w_b * roomRig().calibration.R_b_c,
                                body.p_w_b + body.R_w_b * roomRig().calibration.t_b_c, 1, &rays);
    cv::GaussianBlur(image, image, cv::Size(), 0.6);
    feature_tracker_lines::addNoise(1.5, static_cast<std::uint64_t>(k), &image);
    ASSERT_EQ(evaluation::writeAslImage(directory, kRoomT0Ns + 50000000LL * k, image), "");
  }
}

/// The recording, filmed once for all tests of a program, which change copies of it.
inline std::string filmedRoom() {
  static const Folder filmed("slim_init_room_" + std::to_string(getpid()));
  const std::string directory = filmed.file("room");
  if (!std::filesystem::exists(directory)) film(directory);
  return directory;
}

inline void copyRoom(const std::string& directory) {
  std::filesystem::copy(filmedRoom(), directory, std::filesystem::copy_options::recursive);
}

inline evaluation::BagTopics roomTopics() { return {"/hand/imu", "/hand/image", "", true}; }

/// The host's configuration file for the rig.
inline std::string roomConfiguration(const Eigen::Matrix3d& R_b_c = roomRig().calibration.R_b_c) {
  std::ostringstream rotation;
  rotation << R_b_c.format(Eigen::IOFormat(12, Eigen::DontAlignCols, ", ", ", "));
  return "%YAML:1.0\nimu_topic: \"/hand/imu\"\nimage_topic: \"/hand/image\"\n"
         "model_type: PINHOLE\ncamera_name: camera\nimage_width: 376\nimage_height: 240\n"
         "distortion_parameters: {k1: -0.28340811, k2: 0.07395907, p1: 0.00019359, p2: "
         "1.76187114e-05}\n"
         "projection_parameters: {fx: 229.3, fy: 228.6, cx: 183.6, cy: 124.2}\n" +
         matrixKey("extrinsicRotation", 3, 3, rotation.str()) +
         matrixKey("extrinsicTranslation", 3, 1, "0.05, -0.02, 0.01") +
         "g_norm: 9.81007\ntd: 0.0\n";
}

}  // namespace slim_init
