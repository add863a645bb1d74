// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <exception>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "datasets/csv_file.h"
#include "datasets/sensor_yaml.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/evaluation/write_file.h"

namespace slim_init::evaluation {
namespace {

namespace fs = std::filesystem;

// Rendered images with noise hardly shrink; the fastest level writes three times faster.
constexpr int kPngCompression = 1;

class AslWriter : public SequenceWriter {
 public:
  std::string open(const std::string& directory, const WriterRig& rig) {
    const fs::path root = fs::path(directory) / "mav0";
    image_folder_ = root / "cam0" / "data";
    speed_folder_ = root / "speed0";
    std::error_code code;
    for (const fs::path& folder :
         {image_folder_, root / "imu0", root / "state_groundtruth_estimate0"}) {
      fs::create_directories(folder, code);
      if (!fs::is_directory(folder, code)) return folder.string() + " cannot be made";
    }
    if (!fs::is_empty(image_folder_, code) || code) {
      return image_folder_.string() + " holds files already, must be empty";
    }
    const auto file = [&](const char* name) { return (root / name).string(); };
    return firstOf(
        {writeFile(file("cam0/sensor.yaml"), cameraSensorYaml(rig)),
         writeFile(file("imu0/sensor.yaml"), imuSensorYaml(rig)),
         images_.open(file("cam0/data.csv"), "#timestamp [ns],filename"),
         imu_.open(file("imu0/data.csv"),
                   "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],"
                   "a_y [m s^-2],a_z [m s^-2]"),
         openTruth(file("state_groundtruth_estimate0/data.csv"), &truth_)});
  }

  std::string addImu(std::int64_t stamp_ns, const ImuSample& sample) override {
    Eigen::Matrix<double, 6, 1> row;
    row << sample.gyro, sample.accel;
    return imu_.add(stamp_ns, row);
  }

  std::string addSpeed(std::int64_t stamp_ns, const SpeedSample& sample) override {
    std::string problem;
    if (!has_speeds_) {
      std::error_code code;
      fs::create_directories(speed_folder_, code);
      problem = speeds_.open((speed_folder_ / "data.csv").string(),
                             "#timestamp [ns],v_x [m s^-1],sigma_x [m s^-1]");
      has_speeds_ = true;
    }
    const Eigen::Vector2d row(sample.velocity.x(), std::sqrt(sample.covariance(0, 0)));
    return problem.empty() ? speeds_.add(stamp_ns, row) : problem;
  }

  std::string addImage(std::int64_t stamp_ns, const cv::Mat& image) override {
    const std::string name = std::to_string(stamp_ns) + ".png";
    if (std::string problem = images_.addText(stamp_ns, name); !problem.empty()) return problem;
    const std::string path = (image_folder_ / name).string();
    try {
      if (cv::imwrite(path, image, {cv::IMWRITE_PNG_COMPRESSION, kPngCompression})) return "";
    } catch (const std::exception&) {
    }
    return path + " cannot be written";
  }

  std::string addTruth(std::int64_t stamp_ns, const NavState& state) override {
    return writeTruth(stamp_ns, state, &truth_);
  }

  std::string finish() override {
    return firstOf({images_.finish(), imu_.finish(), truth_.finish(),
                    has_speeds_ ? speeds_.finish() : std::string()});
  }

 private:
  /// The first problem of several, or none.
  static std::string firstOf(const std::vector<std::string>& problems) {
    for (const std::string& problem : problems) {
      if (!problem.empty()) return problem;
    }
    return "";
  }

  fs::path image_folder_;
  CsvFile images_;
  CsvFile imu_;
  fs::path speed_folder_;
  CsvFile speeds_;  // made with the first one
  bool has_speeds_ = false;
  CsvFile truth_;
};

}  // namespace

std::unique_ptr<SequenceWriter> makeAslWriter(const std::string& directory, const WriterRig& rig,
                                              std::string* error) {
  auto writer = std::make_unique<AslWriter>();
  *error = writer->open(directory, rig);
  if (!error->empty()) return nullptr;
  return writer;
}

std::string groundtruthFileOf(const std::string& bag_file) { return bag_file + ".groundtruth.csv"; }

}  // namespace slim_init::evaluation
