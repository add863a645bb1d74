// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <cmath>
#include <exception>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/evaluation/write_file.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;
using feature_tracker_lines::CameraModel;
using feature_tracker_lines::CameraParameters;

// Rendered images with noise hardly shrink; the fastest level writes three times faster.
constexpr int kPngCompression = 1;

/// A table of stamps and numbers; what is written is read back bit for bit.
template <typename Sample, typename RowOf>
std::string tableOf(const char* header, const RecordedMotion& recording,
                    const std::vector<Sample>& samples, const RowOf& rowOf) {
  const Eigen::IOFormat format(17, Eigen::DontAlignCols, ",", ",");
  std::ostringstream out;
  out << header << "\n";
  for (const Sample& sample : samples) {
    out << recording.stampNs(sample.t) << ',' << rowOf(sample).format(format) << "\n";
  }
  return out.str();
}

std::string imageTable(const RecordedMotion& recording) {
  std::string table = "#timestamp [ns],filename\n";
  for (const double t : recording.image_times) {
    table += text(recording.stampNs(t), ',', recording.stampNs(t), ".png\n");
  }
  return table;
}

std::string imuTable(const RecordedMotion& recording) {
  return tableOf(
      "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],a_y [m s^-2],"
      "a_z [m s^-2]",
      recording, recording.imu, [](const ImuSample& sample) {
        return (Eigen::Matrix<double, 6, 1>() << sample.gyro, sample.accel).finished();
      });
}

std::string speedTable(const RecordedMotion& recording) {
  return tableOf("#timestamp [ns],v_x [m s^-1],sigma_x [m s^-1]", recording, recording.speeds,
                 [](const SpeedSample& sample) {
                   return Eigen::Vector2d(sample.velocity.x(), std::sqrt(sample.covariance(0, 0)));
                 });
}

std::string truthTable(const RecordedMotion& recording) {
  return tableOf(
      "#timestamp [ns],p_w_b_x [m],p_w_b_y [m],p_w_b_z [m],q_w_b_w [],q_w_b_x [],q_w_b_y [],"
      "q_w_b_z [],v_w_b_x [m s^-1],v_w_b_y [m s^-1],v_w_b_z [m s^-1],b_g_x [rad s^-1],"
      "b_g_y [rad s^-1],b_g_z [rad s^-1],b_a_x [m s^-2],b_a_y [m s^-2],b_a_z [m s^-2]",
      recording, recording.truth, [](const NavState& state) {
        const Eigen::Quaterniond q(state.R_w_b);
        Eigen::Matrix<double, 16, 1> row;
        row << state.p_w_b, q.w(), q.vec(), state.v_w_b, state.gyro_bias, state.accel_bias;
        return row;
      });
}

std::string transformYaml(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  std::string rows;
  for (int r = 0; r < 3; ++r) {
    rows += roundedText(17, R(r, 0), ", ", R(r, 1), ", ", R(r, 2), ", ", t(r), ",\n         ");
  }
  return "T_BS:\n  cols: 4\n  rows: 4\n  data: [" + rows + "0.0, 0.0, 0.0, 1.0]\n";
}

// Mean rate of `count` rows over `seconds` [Hz], to a thousandth; 0 of fewer than two.
double rateOf(std::size_t count, double seconds) {
  return seconds > 0.0 ? std::round(1e3 * static_cast<double>(count - 1) / seconds) / 1e3 : 0.0;
}

// rolling_shutter_tr, td and g_norm are our own additions to EuRoC's keys, as VINS-Mono names them.
std::string cameraSensorYaml(const WriterRig& rig, const std::vector<double>& times) {
  const CameraParameters& camera = rig.camera;
  const bool omni = camera.model == CameraModel::kMei;
  const auto& k = camera.distortion;
  const double rate = times.empty() ? 0.0 : rateOf(times.size(), times.back() - times.front());
  return roundedText(
      17, "%YAML:1.0\nsensor_type: camera\ncomment: ", rig.comment,
      "\n\n# Camera in the body frame, which is the IMU's.\n",
      transformYaml(rig.calibration.R_b_c, rig.calibration.t_b_c), "\nrate_hz: ", rate,
      "\nresolution: [", camera.width, ", ", camera.height,
      "]\ncamera_model: ", omni ? "omni" : "pinhole", "\nintrinsics: [",
      omni ? roundedText(17, camera.xi, ", ") : "", camera.fx, ", ", camera.fy, ", ", camera.cx,
      ", ", camera.cy, "]\ndistortion_model: ",
      camera.model == CameraModel::kKannalaBrandt ? "equidistant" : "radial-tangential",
      "\ndistortion_coefficients: [", k[0], ", ", k[1], ", ", k[2], ", ", k[3],
      "]\nrolling_shutter_tr: ", rig.calibration.readout_s,
      "  # [s] from the first row to the last; the stamp is that of the middle row\ntd: ",
      rig.calibration.td, "  # [s] time of the IMU minus that of the image\n");
}

std::string imuSensorYaml(const WriterRig& rig, const std::vector<ImuSample>& imu) {
  const double rate = imu.empty() ? 0.0 : rateOf(imu.size(), imu.back().t - imu.front().t);
  return roundedText(
      17, "%YAML:1.0\nsensor_type: imu\ncomment: ", rig.comment, "\n\n",
      transformYaml(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()), "rate_hz: ", rate,
      "\ngyroscope_noise_density: ", rig.calibration.imu_noise.gyro_density,
      "      # [rad/s/sqrt(Hz)]\naccelerometer_noise_density: ",
      rig.calibration.imu_noise.accel_density,
      "  # [m/s^2/sqrt(Hz)]\ng_norm: ", rig.calibration.gravity_magnitude, "  # [m/s^2]\n");
}

}  // namespace

std::string writeAslFolder(const std::string& directory, const WriterRig& rig,
                           const RecordedMotion& recording) {
  const fs::path root = fs::path(directory) / "mav0", images = root / "cam0" / "data";
  std::error_code code;
  std::vector<fs::path> folders = {images, root / "imu0", root / "state_groundtruth_estimate0"};
  if (!recording.speeds.empty()) folders.push_back(root / "speed0");
  for (const fs::path& folder : folders) {
    fs::create_directories(folder, code);
    if (!fs::is_directory(folder, code)) return folder.string() + " cannot be made";
  }
  if (!fs::is_empty(images, code) || code) {
    return images.string() + " holds files already, must be empty";
  }
  if (recording.speeds.empty()) fs::remove(root / "speed0" / "data.csv", code);
  std::string problem;
  const auto write = [&](const char* name, const std::string& text) {
    if (problem.empty()) problem = writeFile((root / name).string(), text);
  };
  write("cam0/sensor.yaml", cameraSensorYaml(rig, recording.image_times));
  write("imu0/sensor.yaml", imuSensorYaml(rig, recording.imu));
  write("cam0/data.csv", imageTable(recording));
  write("imu0/data.csv", imuTable(recording));
  write("state_groundtruth_estimate0/data.csv", truthTable(recording));
  if (!recording.speeds.empty()) write("speed0/data.csv", speedTable(recording));
  return problem;
}

std::string writeAslImage(const std::string& directory, std::int64_t stamp_ns,
                          const cv::Mat& image) {
  const std::string path = directory + "/mav0/cam0/data/" + std::to_string(stamp_ns) + ".png";
  try {
    if (cv::imwrite(path, image, {cv::IMWRITE_PNG_COMPRESSION, kPngCompression})) return "";
  } catch (const std::exception&) {
  }
  return path + " cannot be written";
}

std::string groundtruthFileOf(const std::string& bag_file) { return bag_file + ".groundtruth.csv"; }

}  // namespace slim_init::evaluation
