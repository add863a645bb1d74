// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/config/sensors_file.h"

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <system_error>

#include "yaml_value.h"

namespace slim_init {
namespace {

using namespace config;  // NOLINT: values of YAML

// Digits of a file [rad, m, s].
constexpr double kSameRig = 1e-9;

// Row by row.
template <typename Matrix>
void put(cv::FileStorage* out, const std::string& key, const Matrix& values) {
  *out << key << "[:";
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) *out << values(i, j);
  }
  *out << "]";
}

cv::FileNode required(const cv::FileNode& root, const std::string& key) {
  const cv::FileNode node = root[key];
  if (node.empty()) fail(key, " is missing");
  return node;
}

void get(const cv::FileNode& root, const std::string& key, double* value) {
  read(key, required(root, key), value);
}

template <int kRows, int kCols>
void get(const cv::FileNode& root, const std::string& key, Eigen::Matrix<double, kRows, kCols>* m) {
  const cv::FileNode node = required(root, key);
  if (!node.isSeq() || node.size() != kRows * kCols) {
    wrongKind(key, node, "a list of " + std::to_string(kRows * kCols) + " numbers");
  }
  for (int i = 0; i < kRows * kCols; ++i) {
    read(key + "[" + std::to_string(i) + "]", node[i], &(*m)(i / kCols, i % kCols));
  }
}

using Diagonal = Eigen::Matrix<double, 8, 1>;

void putCalibration(cv::FileStorage* out, const Calibration& configured,
                    const CalibrationEstimate& found) {
  put(out, "R_b_c", found.R_b_c);
  put(out, "t_b_c", found.t_b_c);
  *out << "td" << found.td;
  // [rad, m, s, s]
  put(out, "calibration_sigmas", Diagonal(found.covariance.diagonal().cwiseSqrt()));
  put(out, "configured_R_b_c", configured.R_b_c);
  put(out, "configured_t_b_c", configured.t_b_c);
  *out << "configured_td" << configured.td;
}

bool belongsTo(const cv::FileNode& root, const Calibration& configured) {
  Calibration then;
  get(root, "configured_R_b_c", &then.R_b_c);
  get(root, "configured_t_b_c", &then.t_b_c);
  get(root, "configured_td", &then.td);
  return (then.R_b_c - configured.R_b_c).norm() < kSameRig &&
         (then.t_b_c - configured.t_b_c).norm() < kSameRig &&
         std::abs(then.td - configured.td) < kSameRig;
}

KnownSensors readSensors(const cv::FileNode& root, const Calibration& configured, double* stamp) {
  KnownSensors known;
  get(root, "stamp", stamp);
  get(root, "gyro_bias", &known.biases.gyro);
  get(root, "gyro_bias_sigma", &known.biases.gyro_sigma);
  get(root, "accel_bias", &known.biases.accel);
  get(root, "accel_bias_sigma", &known.biases.accel_sigma);
  if (!root["R_b_c"].empty() && belongsTo(root, configured)) {
    CalibrationEstimate& found = known.calibration.emplace();
    get(root, "R_b_c", &found.R_b_c);
    get(root, "t_b_c", &found.t_b_c);
    get(root, "td", &found.td);
    Diagonal sigmas;
    get(root, "calibration_sigmas", &sigmas);
    found.covariance = sigmas.cwiseAbs2().asDiagonal();
  }
  if (const std::string message = known.validate(); !message.empty()) fail(message);
  return known;
}

}  // namespace

bool saveSensorsFile(const std::string& path, const Calibration& configured, double stamp,
                     const KnownSensors& known, std::string* error) {
  cv::FileStorage out(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  out.writeComment("What slim_init has learned of the sensors, for the next run (sensors_file).");
  out << "stamp" << stamp;
  put(&out, "gyro_bias", known.biases.gyro);  // [rad/s]
  out << "gyro_bias_sigma" << known.biases.gyro_sigma;
  put(&out, "accel_bias", known.biases.accel);  // [m/s^2]
  out << "accel_bias_sigma" << known.biases.accel_sigma;
  if (known.calibration) putCalibration(&out, configured, *known.calibration);
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file << out.releaseAndGetString();
  file.close();
  std::error_code problem;
  bool good = file.good();
  if (good) std::filesystem::rename(part, path, problem);
  good = good && !problem;
  if (!good) std::filesystem::remove(part, problem);
  if (!good && error != nullptr) *error = path + " cannot be written";
  return good;
}

bool loadSensorsFile(const std::string& path, const Calibration& configured, double* stamp,
                     KnownSensors* known, std::string* error) {
  std::string message;
  try {
    const std::unique_ptr<cv::FileStorage> file = openFile(path);
    double read_stamp = 0.0;
    *known = readSensors(file->root(), configured, &read_stamp);
    *stamp = read_stamp;
    return true;
  } catch (const Problem& problem) {
    message = problem.message;
  } catch (const std::exception& exception) {
    message = exception.what();
  }
  if (error != nullptr) *error = path + ": " + message;
  return false;
}

}  // namespace slim_init
