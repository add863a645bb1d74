// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "host_keys.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "yaml_value.h"

namespace slim_init::config {

using namespace feature_tracker_lines;  // cameras and front-end options

namespace {

// Errors assumed of the values of a file that its switches declare to be initial guesses (standard
// deviations before any data). Our section calibration_sigmas wins.

// estimate_td: 1. Camera and IMU are not synchronised: drivers stamp an image up to an exposure and
// a transfer late, some tens of milliseconds [s].
constexpr double kEstimatedTdSigma = 0.03;
// estimate_extrinsic: 1, "an initial guess": axes read from a drawing or adjusted by eye [deg]...
constexpr double kGuessedRotationSigma = 5.0;
// ...and a distance measured with a ruler, on a housing that hides both sensors [m].
constexpr double kGuessedTranslationSigma = 0.05;
// estimate_extrinsic: 2, nothing is known: any rotation [deg]...
constexpr double kUnknownRotationSigma = 180.0;
// ...and where no translation is given, the size of a hand-held rig [m].
constexpr double kUnknownTranslationSigma = 0.1;
static_assert(kUnknownRotationSigma >= CalibrationSigmas::kUnknownRotationDeg,
              "has to be taken as unknown");

void checkRange(const OptionField& option) {
  const auto check = [&option](auto value) {
    if (value >= option.range.min && value <= option.range.max) return;
    fail(option.key, " is ", value, ", must be in [", option.range.min, ", ", option.range.max,
         "]");
  };
  if (const auto* whole = std::get_if<int*>(&option.value)) check(**whole);
  if (const auto* real = std::get_if<double*>(&option.value)) check(**real);
}

// The keys of `table` that the file has.
void readTable(const cv::FileNode& root, const OptionTable& table) {
  for (const OptionField& option : table) {
    const cv::FileNode node = valueOf(root, option.key);
    if (node.empty()) continue;
    read(option.key, node, option);
    checkRange(option);
  }
}

// A text that takes one of `words`.
OptionWord wordOption(std::string* text, const std::vector<std::string>& words) {
  OptionWord option;
  option.words = words;
  option.get = [text] { return *text; };
  option.set = [text](const std::string& word) { *text = word; };
  option.address = text;
  option.size = sizeof(*text);
  return option;
}

// Names of the intrinsics of each model, in the order of CameraParameters.
struct IntrinsicNames {
  CameraModel model;
  const char* projection[4];  // fx, fy, cx, cy
  const char* distortion_section;
  const char* distortion[4];
};
constexpr IntrinsicNames kIntrinsics[] = {
    {CameraModel::kPinhole,
     {"fx", "fy", "cx", "cy"},
     "distortion_parameters",
     {"k1", "k2", "p1", "p2"}},
    {CameraModel::kKannalaBrandt,
     {"mu", "mv", "u0", "v0"},
     "projection_parameters",
     {"k2", "k3", "k4", "k5"}},
    {CameraModel::kMei,
     {"gamma1", "gamma2", "u0", "v0"},
     "distortion_parameters",
     {"k1", "k2", "p1", "p2"}},
};

CameraParameters readCamera(const cv::FileNode& root, std::vector<std::string>* notes) {
  constexpr char kPurpose[] = "the camera model";
  std::string type;
  readRequired(root, "", "model_type", kPurpose, &type);
  const IntrinsicNames* names = nullptr;
  for (const IntrinsicNames& candidate : kIntrinsics) {
    if (lower(type) == lower(toString(candidate.model))) names = &candidate;
  }
  if (names == nullptr) {
    fail("model_type is \"", type, "\", must be PINHOLE, KANNALA_BRANDT or MEI");
  }

  CameraParameters camera;
  camera.model = names->model;
  readRequired(root, "", "image_width", kPurpose, &camera.width);
  readRequired(root, "", "image_height", kPurpose, &camera.height);
  const cv::FileNode projection = requiredSection(root, "projection_parameters");
  double* const intrinsics[4] = {&camera.fx, &camera.fy, &camera.cx, &camera.cy};
  for (int i = 0; i < 4; ++i) {
    readRequired(projection, "projection_parameters.", names->projection[i], kPurpose,
                 intrinsics[i]);
  }
  const cv::FileNode distortion = requiredSection(root, names->distortion_section);
  for (int i = 0; i < 4; ++i) {
    readRequired(distortion, std::string(names->distortion_section) + ".", names->distortion[i],
                 kPurpose, &camera.distortion[i]);
  }
  // Of lens models with more coefficients; the host's own tracker does not read them either.
  for (const char* key : {"k3", "k4", "k5", "k6"}) {
    double value = 0.0;
    if (camera.model != CameraModel::kKannalaBrandt) readOptional(distortion, key, &value);
    if (value != 0.0) {
      notes->push_back(text(names->distortion_section, ".", key, " is ", value,
                            " and not used, as by VINS-Mono: ", toString(camera.model),
                            " has k1, k2, p1 and p2; the lens may need another model"));
    }
  }
  if (camera.model == CameraModel::kMei) {
    readRequired(requiredSection(root, "mirror_parameters"), "mirror_parameters.", "xi", kPurpose,
                 &camera.xi);
  }

  const std::string message = camera.validate();
  if (message.empty()) return camera;
  // The message names our field; the user knows the key.
  const auto rename = [&message](const std::string& field, const std::string& key) {
    if (message.compare(0, field.size() + 1, field + " ") == 0) {
      fail(key, message.substr(field.size()));
    }
  };
  const char* const fields[4] = {"fx", "fy", "cx", "cy"};
  for (int i = 0; i < 4; ++i) {
    rename(fields[i], std::string("projection_parameters.") + names->projection[i]);
    rename("distortion[" + std::to_string(i) + "]",
           std::string(names->distortion_section) + "." + names->distortion[i]);
  }
  rename("width", "image_width");
  rename("height", "image_height");
  rename("xi", "mirror_parameters.xi");
  fail(message);
}

// A matrix written as !!opencv-matrix, of rows x cols; a vector may also stand as a row.
Eigen::MatrixXd readMatrix(const cv::FileNode& root, const char* key, int rows, int cols) {
  const cv::FileNode node = valueOf(root, key);
  if (node.empty()) {
    fail(key, " is missing; it is needed unless estimate_extrinsic is 2");
  }
  // Before the library reserves memory for a matrix of that size.
  if (!node.isMap() || !node["rows"].isInt() || !node["cols"].isInt()) {
    fail(key, " cannot be read as !!opencv-matrix");
  }
  const int rows_there = node["rows"], cols_there = node["cols"];
  const bool transposed = cols == 1 && rows_there == 1 && cols_there == rows;
  if (!transposed && (rows_there != rows || cols_there != cols)) {
    fail(key, " is ", rows_there, " x ", cols_there, ", must be an !!opencv-matrix of ", rows,
         " x ", cols);
  }
  cv::Mat matrix;
  try {
    node >> matrix;
  } catch (const std::exception&) {
    fail(key, " cannot be read as !!opencv-matrix: data has ", node["data"].size(),
         " numbers, must have ", rows * cols, ", and dt must be d");
  }
  if (matrix.depth() < CV_32F) fail(key, " has dt of whole numbers, must be d");
  if (matrix.channels() != 1) fail(key, " has ", matrix.channels(), " channels, must have one");
  if (transposed) matrix = matrix.t();
  Eigen::MatrixXd result;
  cv::cv2eigen(matrix, result);
  return result;
}

// VINS-Fusion has the camera in a file of its own, reads image0_topic, and both parts of the
// extrinsic from one matrix.
bool isOfFusion(const cv::FileNode& root) { return !valueOf(root, "cam0_calib").empty(); }

void noteIgnored(const cv::FileNode& root, Config* config) {
  if (!isOfFusion(root)) return;
  for (const char* const key : {"extrinsicRotation", "extrinsicTranslation", "image_topic"}) {
    if (valueOf(root, key).empty()) continue;
    config->notes.push_back(std::string(key) +
                            " is ignored: a host with cam0_calib reads body_T_cam0, image0_topic");
  }
}

void readExtrinsic(const cv::FileNode& root, Config* config) {
  HostKeys& host = config->host;
  host.extrinsic_in_one_matrix = isOfFusion(root) || (valueOf(root, "extrinsicRotation").empty() &&
                                                      !valueOf(root, "body_T_cam0").empty());
  const bool may_be_absent = host.estimate_extrinsic == 2;
  const char* const R_key = host.extrinsic_in_one_matrix ? "body_T_cam0" : "extrinsicRotation";
  const char* const t_key = host.extrinsic_in_one_matrix ? "body_T_cam0" : "extrinsicTranslation";
  host.has_rotation = !(may_be_absent && valueOf(root, R_key).empty());
  host.has_translation = !(may_be_absent && valueOf(root, t_key).empty());
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  if (host.extrinsic_in_one_matrix && host.has_rotation) {
    const Eigen::Matrix4d T = readMatrix(root, R_key, 4, 4);
    R = T.topLeftCorner<3, 3>();
    t = T.topRightCorner<3, 1>();
  } else if (!host.extrinsic_in_one_matrix) {
    if (host.has_rotation) R = readMatrix(root, R_key, 3, 3);
    if (host.has_translation) t = readMatrix(root, t_key, 3, 1);
  }
  config->calibration.R_b_c = nearestRotation(R_key, R);
  if (!t.allFinite()) fail(t_key, " has a value that is not a number");
  config->calibration.t_b_c = t;
}

void readSpeedSensor(const cv::FileNode& root, Config* config) {
  SpeedSensor& sensor = config->calibration.speed_sensor;
  const bool has_rotation = !valueOf(root, "speed_rotation").empty();
  const bool has_translation = !valueOf(root, "speed_translation").empty();
  if (config->speed_topic.empty() && !has_rotation && !has_translation) return;
  if (!has_rotation) fail("speed_rotation is missing; it is needed for the velocity sensor");
  if (!has_translation) fail("speed_translation is missing; it is needed for the velocity sensor");
  sensor.R_b_s = nearestRotation("speed_rotation", readMatrix(root, "speed_rotation", 3, 3));
  sensor.t_b_s = readMatrix(root, "speed_translation", 3, 1);
  if (!sensor.t_b_s.allFinite()) fail("speed_translation has a value that is not a number");
  sensor.calibrated = true;
}

void raise(double to, double* sigma) { *sigma = std::max(*sigma, to); }

// What the host estimates itself is a starting value.
void readSigmas(Config* config) {
  CalibrationSigmas& sigmas = config->calibration.sigmas;
  const HostKeys& host = config->host;
  if (config->estimate_td) raise(kEstimatedTdSigma, &sigmas.td_s);
  if (host.estimate_extrinsic == 0) return;
  raise(host.estimate_extrinsic == 2 ? kUnknownRotationSigma : kGuessedRotationSigma,
        &sigmas.rotation_deg);
  raise(host.has_translation ? kGuessedTranslationSigma : kUnknownTranslationSigma,
        &sigmas.translation_m);
  if (host.estimate_extrinsic != 2) return;
  config->notes.push_back(
      "estimate_extrinsic is 2: the rotation between camera and IMU is estimated from the motion; "
      "turn the rig about at least two axes");
}

void applyRollingShutter(Config* config) {
  const HostKeys& host = config->host;
  if (!host.rolling_shutter) return;
  config->calibration.readout_s = host.rolling_shutter_tr;
  if (host.rolling_shutter_tr != 0.0) return;
  config->notes.push_back(
      "rolling_shutter is 1 and rolling_shutter_tr is not set: images are processed as global "
      "shutter");
}

// The host's folder for results. GVINS calls it output_dir and puts $HOME in place of a ~ in front.
void readOutputFolder(const cv::FileNode& root, std::string* folder) {
  readOptional(root, "output_path", folder);
  if (!valueOf(root, "output_path").empty()) return;
  readOptional(root, "output_dir", folder);
  const char* home = std::getenv("HOME");
  if (!folder->empty() && folder->front() == '~' && home != nullptr) folder->replace(0, 1, home);
}

bool exists(const std::string& path) { return std::ifstream(path, std::ios::binary).is_open(); }

// As a path in the file `path` is meant. With a slash in front some hosts mean one in the folder of
// the file or in their package, one folder up.
std::string besideFile(const std::string& path, const std::string& name) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  if (name.front() != '/') return folder + name;
  if (exists(name)) return name;
  for (const char* const start : {"", ".."}) {
    const std::string inside = folder + start + name;
    if (exists(inside)) return inside;
  }
  return name;
}

// VINS-Fusion keeps the camera in a file beside its own.
CameraParameters readHostCamera(const cv::FileNode& root, const std::string& path,
                                std::vector<std::string>* notes) {
  std::string name;
  readOptional(root, "cam0_calib", &name);
  if (name.empty()) return readCamera(root, notes);
  const std::string file = besideFile(path, name);
  try {
    return readCamera(openFile(file)->root(), notes);
  } catch (const Problem& problem) {
    fail("cam0_calib, ", file, ": ", problem.message);
  }
}

// VINS-Mono's name of the mask of a fisheye, in its folder `config`.
constexpr char kHostMask[] = "fisheye_mask.jpg";

cv::Mat readGrey(const char* key, const std::string& file) {
  // Tried first, because OpenCV prints to the console about a file it cannot open.
  if (!exists(file)) fail(key, ": ", file, " cannot be opened");
  cv::Mat grey;
  try {
    grey = cv::imread(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
  }
  if (grey.empty()) fail(key, ": ", file, " cannot be read as an image");
  return grey;
}

bool hasSize(const cv::Mat& image, const feature_tracker_lines::CameraParameters& camera) {
  return image.cols == camera.width && image.rows == camera.height;
}

// Takes what the mask leaves out off the area that is used so far.
void apply(const char* key, const std::string& file, const cv::Mat& grey, cv::Mat* used) {
  double largest = 0.0;
  cv::minMaxLoc(grey, nullptr, &largest);
  if (largest == 0.0) fail(key, ": ", file, " is 0 everywhere: no pixel would be used");
  // Half of the largest level: JPEG leaves grey beside an edge, and some masks hold 0 and 1.
  const cv::Mat of_mask = grey >= 0.5 * largest;
  if (used->empty()) {
    *used = of_mask;
  } else {
    cv::bitwise_and(*used, of_mask, *used);
  }
}

void readImage(const char* key, const std::string& file, Config* config) {
  const cv::Mat grey = readGrey(key, file);
  if (!hasSize(grey, config->camera)) {
    fail(key, ": ", file, " is ", grey.cols, " x ", grey.rows, ", must be ", config->camera.width,
         " x ", config->camera.height, " as image_width and image_height");
  }
  apply(key, file, grey, &config->front_end.mask);
}

// The file of a VINS-Mono folder, which no key names: without it, or for another camera, the image
// circle is used, by the tracker where there is no mask.
void readHostMask(const std::string& path, Config* config) {
  for (const std::string& name : {std::string(kHostMask), std::string("../") + kHostMask}) {
    const std::string file = besideFile(path, name);
    if (!exists(file)) continue;
    const cv::Mat grey = readGrey("fisheye", file);
    if (hasSize(grey, config->camera)) {
      apply("fisheye", file, grey, &config->front_end.mask);
      return;
    }
    config->notes.push_back(
        text("fisheye: ", file, " is ", grey.cols, " x ", grey.rows, ", the camera ",
             config->camera.width, " x ", config->camera.height,
             ": not used, the image circle is; name a mask with the key fisheye_mask"));
    break;
  }
  cv::Mat& mask = config->front_end.mask;
  if (!mask.empty()) apply("fisheye", "the image circle", imageCircle(config->camera), &mask);
}

}  // namespace

Eigen::Matrix3d nearestRotation(const char* key, const Eigen::Matrix3d& R) {
  if (!R.allFinite()) fail(key, " has a value that is not a number");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  constexpr double kLargest = 1e-2;
  if (nearest.determinant() < 0.0) {
    fail(key, " has determinant ", R.determinant(),
         ", must be a rotation (+1): one axis is mirrored");
  }
  if ((R - nearest).norm() > kLargest) {
    fail(key, " is ", (R - nearest).norm(), " away from the nearest rotation (limit ", kLargest,
         ")");
  }
  return nearest;
}

OptionTable switchTable(HostKeys* o) {
  return {
      userKey("initializer", wordOption(&o->initializer, {"stock", "slim", "shadow"}),
              "slim: slim_init initializes; shadow: it only solves and reports; stock: off, unless "
              "reinit or watchdog is 1"),
      userKey("reinit", &o->reinit, "1: recovery after a failure and on request"),
      userKey("watchdog", &o->watchdog,
              "1: monitor the estimator for failures that it does not detect"),
      userKey("keep_heading", &o->keep_heading,
              "1: after each optimization keep the heading of the oldest frame, in place of its "
              "Euler yaw"),
      userKey("max_wait_ms", &o->max_wait_ms, {-1.0, 1000.0}, "ms",
              "maximum time that an image waits for a solve; negative: until it ends"),
  };
}

OptionTable rigTable(Config* c) {
  return {
      userKey("estimate_extrinsic", &c->host.estimate_extrinsic, {0, 2}, "",
              "0: extrinsicRotation and extrinsicTranslation are measured; 1: an initial guess "
              "(5 deg, 5 cm), refined by the estimator; 2: unknown, both may be absent"),
      userKey("estimate_td", &c->estimate_td,
              "1: td is an initial guess (standard deviation 30 ms): each start passes its "
              "estimate to the estimator; 0: measured (1 ms)"),
      userKey("rolling_shutter", &c->host.rolling_shutter,
              "1: rows are exposed one after the other; image stamps are of the middle row"),
      userKey("rolling_shutter_tr", &c->host.rolling_shutter_tr, {0.0, 0.2}, "s",
              "readout time from the first row to the last; read if rolling_shutter is 1"),
      userKey("imu_topic", &c->imu_topic, "topic of the IMU: ROS nodes and bags"),
      userKey("image_topic", &c->image_topic, "topic of the camera"),
      userKey("speed_topic", &c->speed_topic,
              "topic of a velocity sensor, geometry_msgs/TwistWithCovarianceStamped or "
              "nav_msgs/Odometry; needs speed_rotation and speed_translation"),
      userKey("speed_forward_only", &c->speed_forward_only,
              "1: a wheel, only the forward speed is measured"),
      userKey("speed_scale_sigma", &c->calibration.speed_sensor.scale_sigma, {1e-4, 0.5}, "",
              "relative error that all speeds have in common: radius of the wheel"),
      userKey("speed_lateral_sigma", &c->calibration.speed_sensor.lateral_sigma, {0.0, 10.0}, "m/s",
              "a wheel does not move sideways or upwards faster than this; 0: no constraint"),
      userKey("td", &c->calibration.td, {-1.0, 1.0}, "s", "time offset, t_imu = t_image + td"),
      userKey("g_norm", &c->calibration.gravity_magnitude, {9.7, 9.9}, "m/s^2", "local gravity"),
      userKey(
          "mask", &c->host.mask,
          "8-bit image of the camera's size: points and ends of lines in its dark areas (0) are "
          "not used, for parts of the vehicle in view. Relative to this file; empty: none"),
      userKey("fisheye_mask", &c->host.fisheye_mask,
              "the same, read if fisheye is 1; empty: fisheye_mask.jpg beside this file or one "
              "folder up, otherwise the image circle"),
  };
}

void readHostKeys(const cv::FileNode& root, HostKeys* host) {
  readTable(root, switchTable(host));
  readOptional(root, "num_of_cam", &host->num_of_cam);
  readOptional(root, "imu", &host->imu);
  if (valueOf(root, "watchdog").empty()) host->watchdog = host->reinit;
  if (valueOf(root, "keep_heading").empty()) host->keep_heading = host->reinit;
  readOutputFolder(root, &host->output_path);
}

void readHost(const cv::FileNode& root, const std::string& path, Config* config) {
  config->camera = readHostCamera(root, path, &config->notes);
  config->calibration.focal_px = Camera(config->camera).focalPx();
  readHostKeys(root, &config->host);
  readTable(root, rigTable(config));
  if (isOfFusion(root) || valueOf(root, "image_topic").empty()) {
    readOptional(root, "image0_topic", &config->image_topic);
  }
  noteIgnored(root, config);
  readExtrinsic(root, config);
  readSpeedSensor(root, config);
  readSigmas(config);
  applyRollingShutter(config);
  readTable(root, optionTable(&config->front_end.host));
  readMask(path, config);
}

void checkExtrinsic(const Config& config) {
  if (config.host.has_rotation) return;
  if (config.method != "slim") {
    fail("extrinsicRotation is missing; the method ", config.method,
         " needs it, only slim estimates it (estimate_extrinsic: 2)");
  }
  const double sigma = config.calibration.sigmas.rotation_deg;
  if (sigma >= CalibrationSigmas::kUnknownRotationDeg) return;
  fail(
      "extrinsicRotation is missing; it is needed if slim_init.calibration_sigmas.rotation_deg is "
      "below ",
      CalibrationSigmas::kUnknownRotationDeg, " (it is ", sigma, ")");
}

void readMask(const std::string& path, Config* config) {
  const HostKeys& host = config->host;
  if (!host.mask.empty()) readImage("mask", besideFile(path, host.mask), config);
  if (!config->front_end.host.fisheye) return;
  if (!host.fisheye_mask.empty()) {
    readImage("fisheye_mask", besideFile(path, host.fisheye_mask), config);
  } else {
    readHostMask(path, config);
  }
}

}  // namespace slim_init::config
