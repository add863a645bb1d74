// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/sensor_yaml.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <exception>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>
#include <vector>

#include "datasets/csv_table.h"
#include "slim_init/feature_tracker_lines/yaml_document.h"

namespace slim_init::evaluation {
namespace {

using feature_tracker_lines::Camera;
using feature_tracker_lines::CameraModel;
using feature_tracker_lines::CameraParameters;

// Twelve printed digits are a rotation to 1e-12, a few digits to 1e-3.
constexpr double kMaxRotationError = 1e-2;
constexpr double kMaxBodyImuDifference = 1e-6;

// Our own additions to EuRoC's keys, named as in VINS-Mono's files; without them: the defaults.
constexpr const char* kReadoutKey = "rolling_shutter_tr";
constexpr const char* kTdKey = "td";
constexpr const char* kGravityKey = "g_norm";

/// A sensor.yaml file. It is plain YAML without the "%YAML:1.0" that OpenCV's parser insists on.
class SensorFile {
 public:
  explicit SensorFile(const std::string& path) : path_(path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream content;
    if (file && file.peek() != std::ifstream::traits_type::eof()) content << file.rdbuf();
    if (!file.is_open() || file.bad()) fail(path, " cannot be read");
    std::string text = content.str();
    if (const std::string why = feature_tracker_lines::whyNotOneDocument(text); !why.empty()) {
      fail(path, ": ", why);
    }
    if (text.compare(0, 5, "%YAML") != 0) text.insert(0, "%YAML:1.0\n");
    try {
      storage_.open(text,
                    cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
    } catch (const std::exception&) {
      fail(path, " is not YAML that OpenCV can read");
    }
    if (!storage_.isOpened()) fail(path, " is not YAML that OpenCV can read");
  }

  std::string text(const char* key) const {
    const cv::FileNode node = required(storage_.root(), key);
    if (!node.isString()) fail(path_, ": ", key, " must be a word");
    return static_cast<std::string>(node);
  }

  double number(const char* key) const {
    const cv::FileNode node = required(storage_.root(), key);
    if (!node.isInt() && !node.isReal()) fail(path_, ": ", key, " must be a number");
    return static_cast<double>(node);
  }

  bool has(const char* key) const {
    return storage_.root().isMap() && !storage_.root()[key].empty();
  }

  /// Of any count for `count` zero.
  std::vector<double> numbers(const char* key, std::size_t count) const {
    return numbersOf(required(storage_.root(), key), key, count);
  }

  /// T_BS: sensor to body.
  Eigen::Matrix4d transform() const {
    const cv::FileNode node = required(storage_.root(), "T_BS");
    if (!node.isMap()) fail(path_, ": T_BS must have rows, cols and data");
    const std::vector<double> data = numbersOf(required(node, "data"), "T_BS.data", 16);
    return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data.data());
  }

  const std::string& path() const { return path_; }

 private:
  cv::FileNode required(const cv::FileNode& parent, const char* key) const {
    const cv::FileNode node = parent.isMap() ? parent[key] : cv::FileNode();
    if (node.empty()) fail(path_, ": ", key, " is missing");
    return node;
  }

  std::vector<double> numbersOf(const cv::FileNode& node, const char* key,
                                std::size_t count) const {
    if (!node.isSeq()) fail(path_, ": ", key, " must be a list of numbers");
    if (count > 0 && node.size() != count) {
      fail(path_, ": ", key, " has ", node.size(), " numbers, must have ", count);
    }
    std::vector<double> values;
    for (const cv::FileNode& item : node) {
      if (!item.isInt() && !item.isReal()) fail(path_, ": ", key, " must be a list of numbers");
      values.push_back(static_cast<double>(item));
      if (!std::isfinite(values.back())) fail(path_, ": ", key, " has a value that is not finite");
    }
    return values;
  }

  std::string path_;
  cv::FileStorage storage_;
};

CameraParameters readCameraModel(const SensorFile& file) {
  CameraParameters camera;
  const std::vector<double> resolution = file.numbers("resolution", 2);
  for (const double side : resolution) {
    if (!(side >= 1.0 && side <= 100000.0) || side != std::floor(side)) {
      fail(file.path(), ": resolution has ", side, ", must be whole numbers from 1 to 100000");
    }
  }
  camera.width = static_cast<int>(resolution[0]);
  camera.height = static_cast<int>(resolution[1]);

  const std::string lens = file.text("camera_model");
  const bool omni = lens == "omni";
  if (!omni && lens != "pinhole") {
    fail(file.path(), ": camera_model is \"", lens, "\", must be pinhole or omni");
  }
  std::vector<double> intrinsics = file.numbers("intrinsics", omni ? 5 : 4);  // xi,fu,fv,cu,cv
  if (omni) {
    camera.model = CameraModel::kMei;
    camera.xi = intrinsics.front();
    intrinsics.erase(intrinsics.begin());
  }
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];

  const std::string distortion = file.text("distortion_model");
  if (distortion == "equidistant" && !omni) {
    camera.model = CameraModel::kKannalaBrandt;
  } else if (distortion != "radial-tangential" && distortion != "radtan" &&
             distortion != "plumb_bob") {
    fail(file.path(), ": distortion_model is \"", distortion,
         "\", must be radial-tangential or (with camera_model pinhole) equidistant");
  }
  const std::vector<double> coefficients = file.numbers("distortion_coefficients", 0);
  // A fifth, k3, is written by some tools; zero is no loss.
  const bool zero_k3 = coefficients.size() == 5 && coefficients[4] == 0.0;
  if (coefficients.size() != 4 && !zero_k3) {
    fail(file.path(), ": distortion_coefficients has ", coefficients.size(),
         " numbers, must have 4");
  }
  for (std::size_t i = 0; i < 4; ++i) camera.distortion[i] = coefficients[i];
  if (const std::string sentence = camera.validate(); !sentence.empty()) {
    fail(file.path(), ": ", sentence);
  }
  return camera;
}

void readFiles(const std::string& camera_file, const std::string& imu_file,
               SequenceCalibration* result) {
  const SensorFile camera(camera_file);
  const SensorFile imu(imu_file);
  result->camera = readCameraModel(camera);
  Calibration& calibration = result->calibration;
  calibration.focal_px = Camera(result->camera).focalPx();

  const Eigen::Matrix4d T_b_i = imu.transform();
  if (!((T_b_i - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff() <= kMaxBodyImuDifference)) {
    fail(imu.path(), ": T_BS is not the identity; the IMU has to be the body frame");
  }
  const Eigen::Matrix4d T_b_c = camera.transform();
  const Eigen::Matrix3d R = T_b_c.topLeftCorner<3, 3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  if (!((R - nearest).norm() <= kMaxRotationError) || nearest.determinant() < 0.0) {
    fail(camera.path(), ": T_BS does not hold a rotation");
  }
  calibration.R_b_c = nearest;
  calibration.t_b_c = T_b_c.topRightCorner<3, 1>();
  if (camera.has(kReadoutKey)) calibration.readout_s = camera.number(kReadoutKey);
  if (camera.has(kTdKey)) calibration.td = camera.number(kTdKey);
  if (imu.has(kGravityKey)) calibration.gravity_magnitude = imu.number(kGravityKey);
  calibration.imu_noise.gyro_density = imu.number("gyroscope_noise_density");
  calibration.imu_noise.accel_density = imu.number("accelerometer_noise_density");
  if (const std::string sentence = calibration.validate(); !sentence.empty()) {
    fail(camera.path(), " and ", imu.path(), ": ", sentence);
  }
}

std::string transformYaml(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  std::string rows;
  for (int r = 0; r < 3; ++r) {
    rows += roundedText(17, R(r, 0), ", ", R(r, 1), ", ", R(r, 2), ", ", t(r), ",\n         ");
  }
  return "T_BS:\n  cols: 4\n  rows: 4\n  data: [" + rows + "0.0, 0.0, 0.0, 1.0]\n";
}

}  // namespace

std::string readSensorYaml(const std::string& camera_file, const std::string& imu_file,
                           SequenceCalibration* calibration) {
  SequenceCalibration read;
  try {
    readFiles(camera_file, imu_file, &read);
  } catch (const Problem& problem) {
    return problem.sentence;
  } catch (const std::exception& exception) {
    return camera_file + " and " + imu_file + ": " + exception.what();
  }
  *calibration = read;
  return "";
}

std::string cameraSensorYaml(const WriterRig& rig) {
  const CameraParameters& camera = rig.camera;
  const bool omni = camera.model == CameraModel::kMei;
  const auto& k = camera.distortion;
  return roundedText(
      17, "%YAML:1.0\nsensor_type: camera\ncomment: ", rig.comment,
      "\n\n# Camera in the body frame, which is the IMU's.\n",
      transformYaml(rig.calibration.R_b_c, rig.calibration.t_b_c), "\nrate_hz: ", rig.image_rate_hz,
      "\nresolution: [", camera.width, ", ", camera.height,
      "]\ncamera_model: ", omni ? "omni" : "pinhole", "\nintrinsics: [",
      omni ? roundedText(17, camera.xi, ", ") : "", camera.fx, ", ", camera.fy, ", ", camera.cx,
      ", ", camera.cy, "]\ndistortion_model: ",
      camera.model == CameraModel::kKannalaBrandt ? "equidistant" : "radial-tangential",
      "\ndistortion_coefficients: [", k[0], ", ", k[1], ", ", k[2], ", ", k[3], "]\n", kReadoutKey,
      ": ", rig.calibration.readout_s,
      "  # [s] from the first row to the last; the stamp is that of the middle row\n", kTdKey, ": ",
      rig.calibration.td, "  # [s] time of the IMU minus that of the image\n");
}

std::string imuSensorYaml(const WriterRig& rig) {
  return roundedText(17, "%YAML:1.0\nsensor_type: imu\ncomment: ", rig.comment, "\n\n",
                     transformYaml(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()),
                     "rate_hz: ", rig.imu_rate_hz,
                     "\ngyroscope_noise_density: ", rig.calibration.imu_noise.gyro_density,
                     "      # [rad/s/sqrt(Hz)]\naccelerometer_noise_density: ",
                     rig.calibration.imu_noise.accel_density, "  # [m/s^2/sqrt(Hz)]\n", kGravityKey,
                     ": ", rig.calibration.gravity_magnitude, "  # [m/s^2]\n");
}

}  // namespace slim_init::evaluation
