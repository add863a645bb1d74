// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "sensor_files.h"

#include <cmath>
#include <vector>

#include "host_keys.h"
#include "yaml_value.h"

namespace slim_init::config {

using namespace feature_tracker_lines;  // cameras

namespace {

constexpr char kCamera[] = "the camera model", kImu[] = "the IMU";

/// A list of numbers; any count for `count` zero.
std::vector<double> readList(const cv::FileNode& parent, const char* key, std::size_t count) {
  const cv::FileNode node = valueOf(parent, key);
  if (node.empty()) fail(key, " is missing");
  if (!node.isSeq()) wrongKind(key, node, "a list of numbers");
  if (count > 0 && node.size() != count) {
    fail(key, " has ", node.size(), " numbers, must have ", count);
  }
  std::vector<double> values;
  for (const cv::FileNode& item : node) {
    values.emplace_back();
    read(key, item, &values.back());
  }
  return values;
}

/// T_BS: sensor to body.
Eigen::Matrix4d readTransform(const cv::FileNode& root) {
  const std::vector<double> data = readList(requiredSection(root, "T_BS"), "data", 16);
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data.data());
}

CameraParameters readLens(const cv::FileNode& root) {
  CameraParameters camera;
  const std::vector<double> resolution = readList(root, "resolution", 2);
  for (const double side : resolution) {
    if (!(side >= 1.0 && side <= 100000.0) || side != std::floor(side)) {
      fail("resolution has ", side, ", must be whole numbers from 1 to 100000");
    }
  }
  camera.width = static_cast<int>(resolution[0]);
  camera.height = static_cast<int>(resolution[1]);

  std::string lens, distortion;
  readRequired(root, "", "camera_model", kCamera, &lens);
  const bool omni = lens == "omni";
  if (!omni && lens != "pinhole") {
    fail("camera_model is \"", lens, "\", must be pinhole or omni");
  }
  std::vector<double> intrinsics = readList(root, "intrinsics", omni ? 5 : 4);  // xi,fu,fv,cu,cv
  if (omni) {
    camera.model = CameraModel::kMei;
    camera.xi = intrinsics.front();
    intrinsics.erase(intrinsics.begin());
  }
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];

  readRequired(root, "", "distortion_model", kCamera, &distortion);
  if (distortion == "equidistant" && !omni) {
    camera.model = CameraModel::kKannalaBrandt;
  } else if (distortion != "radial-tangential" && distortion != "radtan" &&
             distortion != "plumb_bob") {
    fail("distortion_model is \"", distortion,
         "\", must be radial-tangential or (with camera_model pinhole) equidistant");
  }
  const std::vector<double> coefficients = readList(root, "distortion_coefficients", 0);
  // A fifth, k3, is written by some tools; zero is no loss.
  const bool zero_k3 = coefficients.size() == 5 && coefficients[4] == 0.0;
  if (coefficients.size() != 4 && !zero_k3) {
    fail("distortion_coefficients has ", coefficients.size(), " numbers, must have 4");
  }
  for (std::size_t i = 0; i < 4; ++i) camera.distortion[i] = coefficients[i];
  if (const std::string message = camera.validate(); !message.empty()) fail(message);
  return camera;
}

}  // namespace

void readCameraFile(const cv::FileNode& root, Config* config) {
  Calibration& calibration = config->calibration;
  config->camera = readLens(root);
  calibration.focal_px = Camera(config->camera).focalPx();
  const Eigen::Matrix4d T_b_c = readTransform(root);
  calibration.R_b_c = nearestRotation("T_BS", T_b_c.topLeftCorner<3, 3>());
  calibration.t_b_c = T_b_c.topRightCorner<3, 1>();
  // Our own additions to EuRoC's keys, named as in VINS-Mono's files; without them: the defaults.
  readOptional(root, "rolling_shutter_tr", &calibration.readout_s);
  readOptional(root, "td", &calibration.td);
}

void readImuFile(const cv::FileNode& root, Config* config) {
  constexpr double kMaxBodyImuDifference = 1e-6;
  const Eigen::Matrix4d T_b_i = readTransform(root);
  if (!((T_b_i - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff() <= kMaxBodyImuDifference)) {
    fail("T_BS is not the identity; the IMU has to be the body frame");
  }
  Calibration& calibration = config->calibration;
  readOptional(root, "g_norm", &calibration.gravity_magnitude);
  readRequired(root, "", "gyroscope_noise_density", kImu, &calibration.imu_noise.gyro_density);
  readRequired(root, "", "accelerometer_noise_density", kImu, &calibration.imu_noise.accel_density);
}

}  // namespace slim_init::config
