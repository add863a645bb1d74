// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/config/config.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <fstream>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <sstream>
#include <utility>

#include "slim_init/baselines/baselines.h"

namespace slim_init {

using namespace feature_tracker_lines;  // cameras and front-end options

namespace {

constexpr char kSection[] = "slim_init";

// The first problem of a file, as a sentence that starts with the key. Thrown inside this file
// only.
struct Problem {
  std::string sentence;
};

template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  throw Problem{out.str()};
}

// ------------------------------------------------------------------------------- scalar values

std::string shown(const cv::FileNode& node) {
  std::ostringstream out;
  if (node.isInt()) {
    out << static_cast<int>(node);
  } else if (node.isReal()) {
    out << static_cast<double>(node);
  } else if (node.isString()) {
    out << '"' << static_cast<std::string>(node) << '"';
  } else if (node.isMap()) {
    out << "a section";
  } else if (node.isSeq()) {
    out << "a list";
  } else {
    out << "empty";
  }
  return out.str();
}

[[noreturn]] void wrongKind(const std::string& key, const cv::FileNode& node, const char* wanted) {
  fail(key, " is ", shown(node), ", must be ", wanted);
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

void read(const std::string& key, const cv::FileNode& node, int* value) {
  if (!node.isInt()) wrongKind(key, node, "a whole number");
  *value = static_cast<int>(node);
}

void read(const std::string& key, const cv::FileNode& node, double* value) {
  if (!node.isInt() && !node.isReal()) wrongKind(key, node, "a number");
  const double number = static_cast<double>(node);
  if (!std::isfinite(number)) fail(key, " is ", shown(node), ", must be a finite number");
  *value = number;
}

// OpenCV's YAML has no booleans: 0 and 1 are numbers, the words are strings.
void read(const std::string& key, const cv::FileNode& node, bool* value) {
  if (node.isInt()) {
    const int number = static_cast<int>(node);
    if (number == 0 || number == 1) {
      *value = number == 1;
      return;
    }
  } else if (node.isString()) {
    const std::string word = lower(static_cast<std::string>(node));
    if (word == "true" || word == "false") {
      *value = word == "true";
      return;
    }
  }
  wrongKind(key, node, "0, 1, true or false");
}

void read(const std::string& key, const cv::FileNode& node, std::string* value) {
  if (!node.isString()) wrongKind(key, node, "a text");
  *value = static_cast<std::string>(node);
}

constexpr std::pair<const char*, GateMode> kGateModes[] = {
    {"own", GateMode::kOwn}, {"on", GateMode::kOn}, {"off", GateMode::kOff}};
constexpr std::pair<const char*, TrackerProfile> kProfiles[] = {
    {"default", TrackerProfile::kDefault}, {"vins", TrackerProfile::kVins}};

template <typename T, size_t kSize>
void readWord(const std::string& key, const cv::FileNode& node,
              const std::pair<const char*, T> (&words)[kSize], const char* wanted, T* value) {
  if (node.isString()) {
    for (const auto& [name, meaning] : words) {
      if (static_cast<std::string>(node) == name) {
        *value = meaning;
        return;
      }
    }
  }
  wrongKind(key, node, wanted);
}

void read(const std::string& key, const cv::FileNode& node, GateMode* value) {
  readWord(key, node, kGateModes, "own, on or off", value);
}

void read(const std::string& key, const cv::FileNode& node, TrackerProfile* value) {
  readWord(key, node, kProfiles, "default or vins", value);
}

std::string written(int value) { return std::to_string(value); }
std::string written(bool value) { return value ? "1" : "0"; }
std::string written(const std::string& value) { return value; }
std::string written(double value) {
  std::ostringstream out;
  out.precision(15);
  out << value;
  // OpenCV reads "1" as a whole number; a reader should see that a fraction may stand here.
  if (out.str().find_first_of(".en") == std::string::npos) out << ".0";
  return out.str();
}
std::string written(GateMode value) {
  for (const auto& [name, mode] : kGateModes) {
    if (mode == value) return name;
  }
  return "own";
}
std::string written(TrackerProfile value) { return toString(value); }

// --------------------------------------------------------------------------------- our section

// Number of single-letter edits between two words, for "did you mean".
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

[[noreturn]] void unknownKey(const std::string& key, const std::vector<ConfigKey>& keys) {
  const ConfigKey* nearest = nullptr;
  size_t distance = std::max<size_t>(2, key.size() / 3) + 1;
  for (const ConfigKey& known : keys) {
    const size_t d = editDistance(key, known.key);
    if (d < distance) {
      distance = d;
      nearest = &known;
    }
  }
  if (nearest != nullptr) {
    fail(kSection, ".", key, " is not a known key; did you mean ", nearest->key, "?");
  }
  fail(kSection, ".", key, " is not a known key; config/template.yaml lists all of them");
}

// Where a value came from, to name the right file when it turns out to be out of range.
using Origins = std::map<std::string, std::string>;

void readSection(const cv::FileNode& section, const std::string& prefix, const std::string& file,
                 const std::vector<ConfigKey>& keys, Origins* origins) {
  std::vector<std::string> seen;
  for (cv::FileNodeIterator it = section.begin(); it != section.end(); ++it) {
    const cv::FileNode node = *it;
    const std::string key = prefix + node.name();
    // OpenCV keeps the last of two equal keys and loses the other without a word.
    if (std::count(seen.begin(), seen.end(), key) > 0) fail(kSection, ".", key, " stands twice");
    seen.push_back(key);

    const auto known =
        std::find_if(keys.begin(), keys.end(), [&key](const ConfigKey& k) { return k.key == key; });
    if (known != keys.end()) {
      std::visit([&](auto* field) { read(std::string(kSection) + "." + key, node, field); },
                 known->field);
      (*origins)[std::string(kSection) + "." + key] = file;
      continue;
    }
    const bool is_section = std::any_of(keys.begin(), keys.end(), [&key](const ConfigKey& k) {
      return k.key.compare(0, key.size() + 1, key + ".") == 0;
    });
    if (!is_section) unknownKey(key, keys);
    if (!node.isMap()) wrongKind(std::string(kSection) + "." + key, node, "a section of keys");
    readSection(node, key + ".", file, keys, origins);
  }
}

// ------------------------------------------------------------------------------- the host's keys

template <typename T>
void readRequired(const cv::FileNode& parent, const std::string& prefix, const char* key,
                  const char* purpose, T* value) {
  const cv::FileNode node = parent[key];
  if (node.empty()) fail(prefix, key, " is missing; it is needed for ", purpose);
  read(prefix + key, node, value);
}

template <typename T>
void readOptional(const cv::FileNode& root, const char* key, T* value) {
  const cv::FileNode node = root[key];
  if (!node.empty()) read(key, node, value);
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

cv::FileNode requiredSection(const cv::FileNode& root, const char* key) {
  const cv::FileNode node = root[key];
  if (node.empty()) fail(key, " is missing; it is needed for the camera model");
  if (!node.isMap()) wrongKind(key, node, "a section of keys");
  return node;
}

CameraParameters readCamera(const cv::FileNode& root) {
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
  if (camera.model == CameraModel::kMei) {
    readRequired(requiredSection(root, "mirror_parameters"), "mirror_parameters.", "xi", kPurpose,
                 &camera.xi);
  }

  const std::string sentence = camera.validate();
  if (sentence.empty()) return camera;
  // The sentence names our field; the user knows the key.
  const auto rename = [&sentence](const std::string& field, const std::string& key) {
    if (sentence.compare(0, field.size() + 1, field + " ") == 0) {
      fail(key, sentence.substr(field.size()));
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
  fail(sentence);
}

// A matrix written as !!opencv-matrix, of rows x cols; a vector may also stand as a row.
Eigen::MatrixXd readMatrix(const cv::FileNode& root, const char* key, int rows, int cols) {
  const cv::FileNode node = root[key];
  if (node.empty()) {
    fail(key,
         " is missing; the initializer needs to know how the camera sits on the IMU, also "
         "where the host is told to find out itself (estimate_extrinsic: 2)");
  }
  cv::Mat matrix;
  try {
    node >> matrix;
  } catch (const std::exception&) {
    fail(key, " cannot be read as !!opencv-matrix");
  }
  const bool transposed = cols == 1 && matrix.rows == 1 && matrix.cols == rows;
  if (matrix.channels() != 1 || !(transposed || (matrix.rows == rows && matrix.cols == cols))) {
    fail(key, " is ", matrix.rows, " x ", matrix.cols, ", must be an !!opencv-matrix of ", rows,
         " x ", cols);
  }
  cv::Mat_<double> values;
  matrix.convertTo(values, CV_64F);
  Eigen::MatrixXd result(rows, cols);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) result(r, c) = transposed ? values(c, r) : values(r, c);
  }
  return result;
}

void readExtrinsic(const cv::FileNode& root, Config* config) {
  // VINS-Fusion writes both into one matrix.
  const bool one_matrix = root["extrinsicRotation"].empty() && !root["body_T_cam0"].empty();
  const char* const R_key = one_matrix ? "body_T_cam0" : "extrinsicRotation";
  const char* const t_key = one_matrix ? "body_T_cam0" : "extrinsicTranslation";
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  if (one_matrix) {
    const Eigen::Matrix4d T = readMatrix(root, R_key, 4, 4);
    R = T.topLeftCorner<3, 3>();
    t = T.topRightCorner<3, 1>();
  } else {
    R = readMatrix(root, R_key, 3, 3);
    t = readMatrix(root, t_key, 3, 1);
  }
  if (!R.allFinite()) fail(R_key, " has a value that is not a number");
  if (!t.allFinite()) fail(t_key, " has a value that is not a number");

  // Files carry a few digits: take the nearest rotation, but only if that is what was meant.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  constexpr double kLargest = 1e-2;
  if (nearest.determinant() < 0.0) {
    fail(R_key, " has determinant ", R.determinant(),
         ", must be a rotation (+1): one axis is mirrored");
  }
  if ((R - nearest).norm() > kLargest) {
    fail(R_key, " is ", (R - nearest).norm(), " away from the nearest rotation, may be ", kLargest);
  }
  config->calibration.R_b_c = nearest;
  config->calibration.t_b_c = t;
}

// On the heap: in OpenCV before 4.5.2 nodes point back to the FileStorage object itself, which must
// therefore not move.
std::unique_ptr<cv::FileStorage> openFile(const std::string& path);

// VINS-Fusion keeps the camera in a file beside its own.
CameraParameters readHostCamera(const cv::FileNode& root, const std::string& path) {
  std::string name;
  readOptional(root, "cam0_calib", &name);
  if (name.empty()) return readCamera(root);
  const size_t slash = path.rfind('/');
  const std::string file = slash == std::string::npos ? name : path.substr(0, slash + 1) + name;
  try {
    return readCamera(openFile(file)->root());
  } catch (const Problem& problem) {
    fail("cam0_calib, ", file, ": ", problem.sentence);
  }
}

void readHostKeys(const cv::FileNode& root, HostKeys* host) {
  readOptional(root, "initializer", &host->initializer);
  if (host->initializer != "stock" && host->initializer != "slim" &&
      host->initializer != "shadow") {
    fail("initializer is \"", host->initializer, "\", must be stock, slim or shadow");
  }
  readOptional(root, "reinit", &host->reinit);
  readOptional(root, "output_path", &host->output_path);
  readOptional(root, "estimate_extrinsic", &host->estimate_extrinsic);
}

void readHost(const cv::FileNode& root, const std::string& path, Config* config) {
  config->camera = readHostCamera(root, path);
  config->calibration.focal_px = Camera(config->camera).focalPx();
  readExtrinsic(root, config);

  readOptional(root, "imu_topic", &config->imu_topic);
  readOptional(root, "image0_topic", &config->image_topic);
  readOptional(root, "image_topic", &config->image_topic);
  readHostKeys(root, &config->host);
  readOptional(root, "g_norm", &config->calibration.gravity_magnitude);
  readOptional(root, "td", &config->calibration.td);
  readOptional(root, "estimate_td", &config->estimate_td);

  HostFrontEnd& front_end = config->front_end.host;
  readOptional(root, "max_cnt", &front_end.max_cnt);
  readOptional(root, "min_dist", &front_end.min_dist);
  readOptional(root, "freq", &front_end.freq);
  readOptional(root, "F_threshold", &front_end.F_threshold);
  readOptional(root, "equalize", &front_end.equalize);
  readOptional(root, "fisheye", &front_end.fisheye);
  const auto within = [](const char* key, double value, double min, double max) {
    if (!(value >= min && value <= max)) {
      fail(key, " is ", value, ", must be in [", min, ", ", max, "]");
    }
  };
  within("max_cnt", front_end.max_cnt, 1, 10000);
  within("min_dist", front_end.min_dist, 0, 1000);
  within("freq", front_end.freq, 0, 1000);
  within("F_threshold", front_end.F_threshold, 0.01, 100.0);

  int rolling_shutter = 0;
  readOptional(root, "rolling_shutter", &rolling_shutter);
  const int estimate_extrinsic = config->host.estimate_extrinsic;
  if (rolling_shutter != 0) {
    config->notes.push_back(
        "rolling_shutter is set: the initializer takes every image as exposed at one instant");
  }
  if (estimate_extrinsic != 0) {
    config->notes.push_back("estimate_extrinsic is " + std::to_string(estimate_extrinsic) +
                            ": the initializer takes extrinsicRotation and extrinsicTranslation "
                            "as exact");
  }
}

void noteNoise(const cv::FileNode& root, const Origins& origins, Config* config) {
  const bool has_gyro = origins.count("slim_init.noise.gyro_density") > 0;
  const bool has_accel = origins.count("slim_init.noise.accel_density") > 0;
  const bool host_has = !root["acc_n"].empty() || !root["gyr_n"].empty();
  if (has_gyro && has_accel) return;
  const ImuNoise& noise = config->calibration.imu_noise;
  std::ostringstream out;
  if (host_has) out << "acc_n and gyr_n tune the host and are not noise densities; ";
  out << "used are " << noise.gyro_density << " rad/s/sqrt(Hz)" << (has_gyro ? "" : " (default)")
      << " and " << noise.accel_density << " m/s^2/sqrt(Hz)" << (has_accel ? "" : " (default)")
      << "; set slim_init.noise.gyro_density and slim_init.noise.accel_density to change them";
  config->notes.push_back(out.str());
}

// -------------------------------------------------------------------------------------- files

std::unique_ptr<cv::FileStorage> openFile(const std::string& path) {
  // Asked first, because OpenCV prints to the console about a file it cannot open.
  if (!std::ifstream(path).is_open()) fail("the file cannot be opened");
  try {
    auto storage = std::make_unique<cv::FileStorage>(path, cv::FileStorage::READ);
    if (!storage->isOpened()) fail("the file cannot be read");
    return storage;
  } catch (const cv::Exception& exception) {
    // exception.err is the parser's sentence, exception.func "file(line): what".
    std::string reason = exception.func + " " + exception.err;
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    fail("not a YAML file that OpenCV can read (the first line has to be %YAML:1.0): ", reason);
  }
}

void readOurs(const cv::FileNode& root, const std::string& file, bool required, Config* config,
              Origins* origins) {
  const cv::FileNode section = root[kSection];
  if (section.empty()) {
    if (required) fail("the section ", kSection, ": is missing");
    return;
  }
  if (!section.isMap()) wrongKind(kSection, section, "a section of keys");
  readSection(section, "", file, configKeys(config), origins);
}

// Ranges of everything that came from a file; the sentence starts with the key.
void checkRanges(const Config& config) {
  const std::vector<std::string> methods = baselines::namesOf(baselines::methods());
  if (std::find(methods.begin(), methods.end(), config.method) == methods.end()) {
    std::ostringstream known;
    for (const std::string& name : methods) known << (known.tellp() > 0 ? ", " : "") << name;
    fail(kSection, ".method is \"", config.method, "\", must be one of ", known.str());
  }
  std::string sentence = config.options.validate();
  if (sentence.empty()) sentence = config.baselines.validate();
  if (sentence.empty()) sentence = config.front_end.validate();
  if (!sentence.empty()) fail(kSection, ".", sentence);

  sentence = config.calibration.validate();
  const std::pair<const char*, const char*> renames[] = {
      {"imu_noise.", "slim_init.noise."},
      {"gravity_magnitude", "g_norm"},
      {"focal_px", "the focal length from projection_parameters"},
      {"sigma_px", "slim_init.sigma_px"},
      {"sigma_line_px", "slim_init.sigma_line_px"},
      {"norm of t_b_c", "the length of extrinsicTranslation [m]"},
      {"distance of R_b_c", "the distance of extrinsicRotation"},
  };
  for (const auto& [field, key] : renames) {
    const std::string name(field);
    if (sentence.compare(0, name.size(), name) == 0) fail(key, sentence.substr(name.size()));
  }
  if (!sentence.empty()) fail(sentence);
}

// The file to blame for a sentence: where its key was read, or, where its key has the default and
// clashes with another one of its section, where that one was read.
std::string originOf(const std::string& sentence, const Origins& origins,
                     const std::string& fallback) {
  const std::string key = sentence.substr(0, sentence.find(' '));
  const auto exact = origins.find(key);
  if (exact != origins.end()) return exact->second;
  const std::string section = key.substr(0, key.rfind('.') + 1);
  for (const auto& [other, file] : origins) {
    if (other.compare(0, section.size(), section) == 0 &&
        sentence.find(" " + other.substr(section.size()) + " ") != std::string::npos) {
      return file;
    }
  }
  return fallback;
}

// Runs `work` on a copy and hands it over on success; every problem becomes "file: sentence".
template <typename Work>
bool transact(Config* config, std::string* error, std::string* file, const Work& work) {
  Config result = *config;
  Origins origins;
  std::string sentence;
  try {
    work(&result, &origins);
    result.front_end.vanishing_point = result.options.vanishing_point;
    try {
      checkRanges(result);
    } catch (const Problem& problem) {
      *file = originOf(problem.sentence, origins, *file);
      throw;
    }
    *config = std::move(result);
    return true;
  } catch (const Problem& problem) {
    sentence = problem.sentence;
  } catch (const std::exception& exception) {
    sentence = exception.what();
  }
  if (error != nullptr) *error = *file + ": " + sentence;
  return false;
}

}  // namespace

std::vector<ConfigKey> configKeys(Config* config) {
  Calibration& calibration = config->calibration;
  WindowOptions& window = config->options.window;
  baselines::GyroBiasOptions& gyro = config->baselines.gyro_bias;
  VanishingPointOptions& vp = config->options.vanishing_point;
  baselines::LineSelectionOptions& lines = config->baselines.line_selection;
  AlignmentOptions& alignment = config->options.alignment;
  baselines::SlimPaperOptions& paper = config->baselines.slim_paper;
  baselines::DrtViBaOptions& vi_ba = config->baselines.drt_vi_ba;
  RobustBiasOptions& robust = config->options.robust_bias;
  ReverseAlignmentOptions& reverse = config->options.reverse_alignment;
  RefinementOptions& refinement = config->options.refinement;
  SlimOptions& slim = config->options.slim;
  GateOptions& gates = config->options.gates;
  FrontEndOptions& front_end = config->front_end;
  PointTrackerOptions& points = front_end.points;
  LineTrackerOptions& segments = front_end.lines;
  return {
      {"method", &config->method, "", "the solver: `slim_init ab --help` lists the names"},
      {"sigma_px", &calibration.sigma_px, "px", "standard deviation of a tracked point"},
      {"sigma_line_px", &calibration.sigma_line_px, "px",
       "standard deviation of a segment's end across the segment"},

      {"noise.gyro_density", &calibration.imu_noise.gyro_density, "rad/s/sqrt(Hz)",
       "white noise of the gyroscope, from its data sheet; not the host's gyr_n"},
      {"noise.accel_density", &calibration.imu_noise.accel_density, "m/s^2/sqrt(Hz)",
       "white noise of the accelerometer, from its data sheet; not the host's acc_n"},

      {"imu.max_accel", &config->options.imu.max_accel, "m/s^2",
       "a live sample with more on an axis is a glitch and dropped; 160: just above 16 g"},
      {"imu.max_gyro", &config->options.imu.max_gyro, "rad/s",
       "the same; 35: just above 2000 deg/s"},

      {"window.keyframes", &window.keyframes, "", "keyframes of a full window"},
      {"window.min_keyframes", &window.min_keyframes, "",
       "fewer are answered with too_few_keyframes"},
      {"window.min_interval_s", &window.min_interval_s, "s",
       "between keyframes: shorter ones share too little motion"},
      {"window.max_frame_gap_s", &window.max_frame_gap_s, "s",
       "a longer gap between images ends the window"},
      {"window.max_imu_gap_s", &window.max_imu_gap_s, "s",
       "a longer gap between IMU samples ends the window"},
      {"window.buffer_s", &window.buffer_s, "s", "data kept; bounds the memory"},

      {"gyro_bias.max_iterations", &gyro.max_iterations, "",
       "Levenberg-Marquardt iterations per linearisation"},
      {"gyro_bias.max_relinearizations", &gyro.max_relinearizations, "",
       "integrations of the gyroscope at a new bias"},
      {"gyro_bias.cauchy_scale", &gyro.cauchy_scale, "rad^2",
       "residual of a keyframe pair beyond which it loses weight"},
      {"gyro_bias.min_points_per_pair", &gyro.min_points_per_pair, "",
       "keyframe pairs with fewer common points do not enter"},
      {"gyro_bias.max_bias", &gyro.max_bias, "rad/s", "a larger answer is a numerical failure"},

      {"vanishing_point.icosphere_subdivisions", &vp.icosphere_subdivisions, "",
       "4 are 2562 directions, two degrees apart"},
      {"vanishing_point.vote_threshold_deg", &vp.vote_threshold_deg, "deg",
       "a line votes for directions this close to its plane"},
      {"vanishing_point.inlier_threshold_deg", &vp.inlier_threshold_deg, "deg",
       "a line this close belongs to the vanishing point"},
      {"vanishing_point.min_inliers", &vp.min_inliers, "", "fewer lines make no vanishing point"},
      {"vanishing_point.match_threshold_deg", &vp.match_threshold_deg, "deg",
       "between the predicted and the seen direction, to be the same one"},
      {"vanishing_point.min_track_age", &vp.min_track_age, "keyframes",
       "younger tracks are not used"},
      {"vanishing_point.consistency_threshold_deg", &vp.consistency_threshold_deg, "deg",
       "rms of the inliers above which a vanishing point is not used"},

      {"line_selection.min_keyframes", &lines.min_keyframes, "",
       "a line seen in fewer keyframes is not used"},
      {"line_selection.max_lines_per_pair", &lines.max_lines_per_pair, "",
       "best lines of a keyframe pair that are used"},
      {"line_selection.full_length_px", &lines.full_length_px, "px",
       "length from which a line counts fully"},

      {"alignment.min_track_length", &alignment.min_track_length, "keyframes",
       "shorter tracks say nothing about relative scale"},
      {"alignment.min_tracks", &alignment.min_tracks, "",
       "fewer tracks are answered with too_few_tracks"},
      {"alignment.use_line_rows", &alignment.use_line_rows, "",
       "three-view rows of line tracks beside those of the points"},
      {"alignment.min_parallax_rad", &alignment.min_parallax_rad, "rad",
       "tracks with less parallax are left out"},

      {"robust_bias.candidates", &robust.candidates, "",
       "further starts tried, at most, when the first solution does not look clean"},
      {"robust_bias.clean_inlier_fraction", &robust.clean_inlier_fraction, "",
       "share of sightings in agreement from which a solution is clean"},
      {"robust_bias.clean_cost", &robust.clean_cost, "sigma^2",
       "mean truncated squared residual up to which it is"},
      {"robust_bias.min_inlier_fraction", &robust.min_inlier_fraction, "",
       "less agreement is no consensus"},
      {"robust_bias.gyro_noise_inflation", &robust.gyro_noise_inflation, "",
       "on the gyroscope density in the covariance of the bias"},
      {"robust_bias.refinement.max_gap", &robust.refinement.max_gap, "keyframes",
       "largest gap between the keyframes of a pair"},
      {"robust_bias.refinement.min_points_per_pair", &robust.refinement.min_points_per_pair, "",
       "keyframe pairs with fewer common points do not enter"},
      {"robust_bias.refinement.max_iterations", &robust.refinement.max_iterations, "",
       "Levenberg-Marquardt iterations per round"},
      {"robust_bias.refinement.cauchy_sigmas", &robust.refinement.cauchy_sigmas, "",
       "vanishing-point residual beyond which it loses weight, in standard deviations"},
      {"robust_bias.refinement.vp_inflation", &robust.refinement.vp_inflation, "",
       "on the covariance of a vanishing point"},
      {"robust_bias.refinement.bias_prior", &robust.refinement.bias_prior, "rad/s",
       "standard deviation of the bias before any data"},
      {"robust_bias.refinement.max_bias", &robust.refinement.max_bias, "rad/s",
       "a larger answer is a numerical failure"},
      {"robust_bias.pruning.threshold_sigmas", &robust.pruning.threshold_sigmas, "",
       "a residual above this many standard deviations disagrees"},
      {"robust_bias.pruning.min_points_per_pair", &robust.pruning.min_points_per_pair, "",
       "keyframe pairs with fewer common tracks are not tested"},
      {"robust_bias.pruning.hypotheses", &robust.pruning.hypotheses, "",
       "translation directions tried per pair"},

      {"reverse_alignment.accel_bias_prior", &reverse.accel_bias_prior, "m/s^2",
       "standard deviation of the accelerometer bias before any data"},
      {"reverse_alignment.min_scale", &reverse.min_scale, "m", "smallest scale searched"},
      {"reverse_alignment.max_scale", &reverse.max_scale, "m", "largest scale searched"},
      {"reverse_alignment.grid", &reverse.grid, "", "points of the grid between them"},
      {"reverse_alignment.length_weight", &reverse.length_weight, "",
       "weight of the length, in units of the mean information"},
      {"reverse_alignment.log_scale_tolerance", &reverse.log_scale_tolerance, "",
       "end of the search, in log(scale)"},

      {"refinement.use_lines", &refinement.use_lines, "", "lines in the refinement"},
      {"refinement.use_vanishing_points", &refinement.use_vanishing_points, "",
       "vanishing points in the refinement"},
      {"refinement.estimate_accel_bias", &refinement.estimate_accel_bias, "",
       "0: the accelerometer bias is held at zero"},
      {"refinement.max_iterations", &refinement.max_iterations, "",
       "Levenberg-Marquardt steps of one minimisation"},
      {"refinement.tolerance", &refinement.tolerance, "",
       "squared step in standard deviations of the state that ends it"},
      {"refinement.cauchy_sigmas", &refinement.cauchy_sigmas, "",
       "residual beyond which it loses weight, in standard deviations"},
      {"refinement.accel_bias_prior", &refinement.accel_bias_prior, "m/s^2",
       "standard deviation of the accelerometer bias before any data"},
      {"refinement.gyro_bias_prior", &refinement.gyro_bias_prior, "rad/s",
       "standard deviation of the gyroscope bias before any data"},
      {"refinement.vp_inflation", &refinement.vp_inflation, "",
       "on the covariance of a vanishing point"},
      {"refinement.accel_noise_factor", &refinement.accel_noise_factor, "",
       "on the accelerometer density: sensors in motion are noisier than their data sheet"},
      {"refinement.gyro_noise_factor", &refinement.gyro_noise_factor, "",
       "on the gyroscope density, for the same reason"},
      {"refinement.min_sigma_px", &refinement.min_sigma_px, "px",
       "least estimated noise of a point"},
      {"refinement.reject_sigmas", &refinement.reject_sigmas, "",
       "observations beyond are taken out before the second solve"},
      {"refinement.min_reject_px", &refinement.min_reject_px, "px", "but never those below"},
      {"refinement.line_agreement_sigmas", &refinement.line_agreement_sigmas, "",
       "departure from one line in space at which a line track is cut, in standard deviations"},
      {"refinement.min_line_views", &refinement.min_line_views, "keyframes",
       "a line seen in fewer is not used"},
      {"refinement.suspicious_chi2", &refinement.suspicious_chi2, "",
       "chi-square per degree of freedom above which a minimum is searched for again"},

      {"slim.vanishing_points", &slim.vanishing_points, "",
       "in the gyroscope bias and in the refinement"},
      {"slim.prune_lines", &slim.prune_lines, "",
       "cut line tracks where they contradict the start"},
      {"slim.prune_tracks", &slim.prune_tracks, "",
       "take out tracks that contradict the consensus bias"},
      {"slim.reverse_start", &slim.reverse_start, "", "start from the reverse alignment"},
      {"slim.tight_start", &slim.tight_start, "", "start from the tight closed form"},
      {"slim.refine", &slim.refine, "", "0: the first start is the answer"},
      {"slim.second_search", &slim.second_search, "",
       "search for a lower minimum where the first looks wrong"},
      {"slim.few_tracks", &slim.few_tracks, "", "with fewer it is searched for in any case"},

      {"slim_paper.use_vp", &paper.use_vp, "", "vanishing points in the gyroscope bias, eq. (4)"},
      {"slim_paper.use_line_epipolar", &paper.use_line_epipolar, "",
       "the line residual of eq. (11)"},
      {"slim_paper.use_line_normal", &paper.use_line_normal, "", "the line residual of eq. (12)"},
      {"slim_paper.vp_weight", &paper.vp_weight, "",
       "factor on the weight of the vanishing points"},
      {"slim_paper.vp_cauchy_scale", &paper.vp_cauchy_scale, "rad",
       "vanishing-point residual beyond which it loses weight"},
      {"slim_paper.line_epipolar_weight", &paper.line_epipolar_weight, "",
       "constant of eq. (13) for eq. (11); larger pulls the scale to zero"},
      {"slim_paper.line_normal_weight", &paper.line_normal_weight, "",
       "constant of eq. (13) for eq. (12)"},

      {"drt_vi_ba.sigma_px", &vi_ba.sigma_px, "px", "standard deviation of an epipolar residual"},
      {"drt_vi_ba.huber_sigmas", &vi_ba.huber_sigmas, "",
       "epipolar residual beyond which it loses weight, in standard deviations"},
      {"drt_vi_ba.max_iterations", &vi_ba.max_iterations, "", "Levenberg-Marquardt steps"},
      {"drt_vi_ba.tolerance", &vi_ba.tolerance, "",
       "relative decrease of the cost that ends the minimisation"},

      {"gates.mode", &gates.mode, "",
       "own: as the method was published; on: enforced; off: only reported"},
      {"gates.strict", &gates.strict, "",
       "tighter bounds for slim: fewer windows are accepted, and those are better"},
      {"gates.min_parallax_px", &gates.min_parallax_px, "px",
       "median motion of the tracks without rotation; less is no translation"},
      {"gates.min_rotation_deg", &gates.min_rotation_deg, "deg",
       "tells stationary from pure rotation where there is no translation"},
      {"gates.min_excitation", &gates.min_excitation, "m/s^2",
       "rms change of acceleration; at less the scale is not observable"},
      {"gates.min_linkage", &gates.min_linkage, "",
       "second to first eigenvalue of the translations; less is a split window"},
      {"gates.max_alignment_residual", &gates.max_alignment_residual, "m, m/s",
       "rms of the alignment's rows; more is refused"},
      {"gates.max_scale_sigma", &gates.max_scale_sigma, "",
       "relative standard deviation of the scale; more is refused"},
      {"gates.max_rest_deviation", &gates.max_rest_deviation, "m/s^2",
       "rms change of acceleration without parallax; more is no rest but a far scene"},
      {"gates.max_chi2", &gates.max_chi2, "",
       "visual chi-square per degree of freedom; more is refused"},
      {"gates.min_inlier_fraction", &gates.min_inlier_fraction, "",
       "share of point sightings left after rejection; less is refused"},
      {"gates.min_point_spread_deg", &gates.min_point_spread_deg, "deg",
       "spread of the points of an image; less is refused"},
      {"gates.max_inertial_chi2", &gates.max_inertial_chi2, "",
       "slim: largest inertial chi-square per residual; 1 is what the widened noise predicts"},
      {"gates.max_inertial_chi2_short", &gates.max_inertial_chi2_short, "",
       "slim: the same below eight keyframes, where a trajectory far too small fits the images"},
      {"gates.max_extrinsic_error_deg", &gates.max_extrinsic_error_deg, "deg",
       "slim: largest error of the extrinsic rotation beyond doubt; four degrees cost 5 % of "
       "scale"},
      {"gates.max_td_error_s", &gates.max_td_error_s, "s",
       "slim: largest error of the time offset beyond doubt; 10 ms cost 5 % of scale"},
      {"gates.max_behind_fraction", &gates.max_behind_fraction, "",
       "share of points behind the camera; more is refused"},

      {"front_end.profile", &front_end.profile, "",
       "default, or vins: points as VINS-Mono tracks them, with the host's keys above"},
      {"front_end.use_gyro", &front_end.use_gyro, "", "predict the flow from the gyroscope"},
      {"front_end.estimate_gyro_bias", &front_end.estimate_gyro_bias, "",
       "from the tracks themselves, for the prediction and the outlier check"},
      {"front_end.max_rotation_sigma_px", &front_end.max_rotation_sigma_px, "px",
       "above, the rotation between two images does not count as known"},

      {"points.max_points", &points.max_points, "", "tracked in one image"},
      {"points.min_distance_px", &points.min_distance_px, "px", "between two points"},
      {"points.corner_noise_factor", &points.corner_noise_factor, "",
       "over the strongest corner that image noise alone makes"},
      {"points.window_px", &points.window_px, "px", "side of the tracked patch, odd"},
      {"points.levels", &points.levels, "", "pyramid levels above the image"},
      {"points.forward_backward_px", &points.forward_backward_px, "px",
       "back and forth a point has to come within this of where it was"},
      {"points.epipolar_px", &points.epipolar_px, "px",
       "further from its epipolar line a point is an outlier"},
      {"points.border_px", &points.border_px, "px", "points closer to the edge are dropped"},

      {"lines.enabled", &segments.enabled, "", "0: points only"},
      {"lines.max_lines", &segments.max_lines, "", "tracked in one image, old and long ones first"},
      {"lines.min_length_px", &segments.min_length_px, "px", "shorter segments are left out"},
      {"lines.samples", &segments.samples, "", "points that a line is predicted with"},
      {"lines.max_distance_px", &segments.max_distance_px, "px",
       "predicted to detected line, across"},
      {"lines.max_angle_deg", &segments.max_angle_deg, "deg", "predicted to detected line"},
      {"lines.min_overlap", &segments.min_overlap, "",
       "of predicted and detected segment, part of the shorter one"},
      {"lines.max_missed", &segments.max_missed, "images",
       "without a detection over which a line is carried on by its edge"},
      {"lines.max_refit_rms_px", &segments.max_refit_rms_px, "px",
       "edge samples about the fitted line; more is no line"},
  };
}

std::string documentedDefaults() {
  Config defaults;
  std::ostringstream out;
  out << kSection << ":\n";
  std::string open_section;
  for (const ConfigKey& key : configKeys(&defaults)) {
    const size_t dot = key.key.rfind('.');
    const std::string section = dot == std::string::npos ? "" : key.key.substr(0, dot + 1);
    std::string indent = "  ";
    // Each level of the section that is not open yet.
    for (size_t begin = 0, end = section.find('.'); end != std::string::npos;
         begin = end + 1, end = section.find('.', begin)) {
      if (open_section.compare(0, end + 1, section, 0, end + 1) != 0) {
        out << indent << section.substr(begin, end - begin) << ":\n";
      }
      indent += "  ";
    }
    open_section = section;
    out << indent << "# " << key.reason;
    if (!key.unit.empty()) out << " [" << key.unit << "]";
    out << "\n"
        << indent << (section.empty() ? key.key : key.key.substr(dot + 1)) << ": "
        << std::visit([](auto* field) { return written(*field); }, key.field) << "\n";
  }
  return out.str();
}

namespace {

bool loadWhole(const std::string& path, const std::string& options_path,
               const InitializerOptions& defaults, Config* config, std::string* error) {
  std::string file = path;
  // A configuration is read whole: nothing of an earlier one stays.
  Config fresh;
  fresh.options = defaults;
  const bool loaded = transact(&fresh, error, &file, [&](Config* result, Origins* origins) {
    const std::unique_ptr<cv::FileStorage> storage = openFile(path);
    readHost(storage->root(), path, result);
    readOurs(storage->root(), path, false, result, origins);
    if (!options_path.empty()) {
      file = options_path;
      readOurs(openFile(options_path)->root(), options_path, true, result, origins);
      file = path;
    }
    noteNoise(storage->root(), *origins, result);
  });
  if (loaded) *config = std::move(fresh);
  return loaded;
}

}  // namespace

bool loadConfig(const std::string& path, Config* config, std::string* error) {
  return loadWhole(path, "", InitializerOptions(), config, error);
}

bool loadConfig(const std::string& path, const InitializerOptions& defaults, Config* config,
                std::string* error) {
  return loadWhole(path, "", defaults, config, error);
}

bool loadConfig(const std::string& path, const std::string& options_path, Config* config,
                std::string* error) {
  return loadWhole(path, options_path, InitializerOptions(), config, error);
}

bool loadHostKeys(const std::string& path, HostKeys* keys, std::string* error) {
  Config config;
  std::string file = path;
  const bool loaded = transact(&config, error, &file, [&](Config* result, Origins* /*origins*/) {
    readHostKeys(openFile(path)->root(), &result->host);
  });
  if (loaded) *keys = config.host;
  return loaded;
}

bool loadOptions(const std::string& path, Config* config, std::string* error) {
  std::string file = path;
  return transact(config, error, &file, [&](Config* result, Origins* origins) {
    readOurs(openFile(path)->root(), path, true, result, origins);
  });
}

}  // namespace slim_init
