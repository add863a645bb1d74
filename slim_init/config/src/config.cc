// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/config/config.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include "host_keys.h"
#include "sensor_files.h"
#include "slim_init/baselines/baselines.h"
#include "slim_init/work_budget.h"
#include "yaml_value.h"

namespace slim_init {

using namespace config;  // the parts of this library

namespace {

// Name of our section.
constexpr char kSection[] = "slim_init";

// What was read from the files so far: the file that a key came from, by its full name
// ("slim_init.window.keyframes").
using SectionLog = std::map<std::string, std::string>;

class SectionReader {
 public:
  SectionReader(const std::string& file, Config* config, SectionLog* log)
      : file_(file), table_(configTable(config)), log_(log) {}

  // The keys of `section`, whose path is `prefix` ("window.").
  void read(const cv::FileNode& section, const std::string& prefix) {
    for (cv::FileNodeIterator it = section.begin(); it != section.end(); ++it) {
      const std::string name = (*it).name(), key = prefix + name;
      const OptionField* const option = find(key);
      if (option == nullptr && !isSection(key)) unknown(key);
      const cv::FileNode node = valueOf(section, name, fullName(prefix));
      if (node.empty()) continue;
      if (option != nullptr) {
        config::read(fullName(key), node, *option);
        (*log_)[fullName(key)] = file_;
      } else {
        if (!node.isMap()) wrongKind(fullName(key), node, "a section of keys");
        read(node, key + ".");
      }
    }
  }

 private:
  static std::string fullName(const std::string& key) { return std::string(kSection) + "." + key; }

  const OptionField* find(const std::string& key) const {
    for (const OptionField& option : table_) {
      if (option.key == key) return &option;
    }
    return nullptr;
  }

  bool isSection(const std::string& key) const {
    return std::any_of(table_.begin(), table_.end(), [&key](const OptionField& option) {
      return option.key.compare(0, key.size() + 1, key + ".") == 0;
    });
  }

  [[noreturn]] void unknown(const std::string& key) const {
    fail(fullName(key), " is not a known key; `slim_init options --keys all` lists them");
  }

  const std::string file_;
  const OptionTable table_;
  SectionLog* const log_;
};

// Reads the section below `root` onto `config`; without one throws if it is `required`. Throws a
// Problem (yaml_value.h) on unknown keys, wrong kinds, and a key that is given twice.
void readSection(const cv::FileNode& root, const std::string& file, bool required, Config* config,
                 SectionLog* log) {
  const cv::FileNode section = valueOf(root, kSection);
  if (section.empty()) {
    if (required) fail("the section ", kSection, ": is missing");
    return;
  }
  if (!section.isMap()) wrongKind(kSection, section, "a section of keys");
  SectionReader(file, config, log).read(section, "");
}

void noteNoise(const cv::FileNode& root, const SectionLog& log, Config* config) {
  const bool has_gyro = log.count("slim_init.noise.gyro_density") > 0;
  const bool has_accel = log.count("slim_init.noise.accel_density") > 0;
  const bool host_has = !root["acc_n"].empty() || !root["gyr_n"].empty();
  if (has_gyro && has_accel) return;
  const ImuNoise& noise = config->calibration.imu_noise;
  config->notes.push_back(
      text(host_has ? "acc_n and gyr_n tune the host and are not noise densities; " : "",
           "used are ", noise.gyro_density, " rad/s/sqrt(Hz)", has_gyro ? "" : " (default)",
           " and ", noise.accel_density, " m/s^2/sqrt(Hz)", has_accel ? "" : " (default)",
           "; set slim_init.noise.gyro_density and slim_init.noise.accel_density to change them"));
}

// What the reader should know about the use of keys.
void noteKeys(Config* config) {
  const std::string note = noteUnreadKeys(*config, {config->method});
  // A second file on the same configuration says it again.
  const bool is_new = std::count(config->notes.begin(), config->notes.end(), note) == 0;
  if (!note.empty() && is_new) config->notes.push_back(note);
}

// Ranges of everything that came from a file; the message starts with the key.
void checkRanges(const Config& config) {
  const std::vector<std::string> methods = baselines::namesOf(baselines::methods());
  if (std::find(methods.begin(), methods.end(), config.method) == methods.end()) {
    std::string known;
    for (const std::string& name : methods) known += (known.empty() ? "" : ", ") + name;
    fail(kSection, ".method is \"", config.method, "\", must be one of ", known);
  }
  std::string message = config.options.validate();
  if (message.empty()) message = config.front_end.validate();
  if (!message.empty()) fail(kSection, ".", message);

  message = config.calibration.validate();
  const std::pair<const char*, const char*> renames[] = {
      {"imu_noise.", "slim_init.noise."},
      {"sigmas.", "slim_init.calibration_sigmas."},
      {"readout_s", "rolling_shutter_tr"},
      {"gravity_magnitude", "g_norm"},
      {"focal_px", "the focal length from projection_parameters"},
      {"sigma_px", "slim_init.sigma_px"},
      {"sigma_line_px", "slim_init.sigma_line_px"},
      {"norm of t_b_c", "the length of extrinsicTranslation [m]"},
      {"distance of R_b_c", "the distance of extrinsicRotation"},
      {"speed_sensor.norm of t_b_s", "the length of speed_translation [m]"},
  };
  for (const auto& [field, key] : renames) {
    const std::string name(field);
    if (message.compare(0, name.size(), name) == 0) fail(key, message.substr(name.size()));
  }
  if (!message.empty()) fail(message);
}

// The file that a message is about: where its key was read, or, where its key has the default and
// clashes with another one of its section, where that one was read.
std::string originOf(const std::string& message, const SectionLog& log,
                     const std::string& fallback) {
  const std::string key = message.substr(0, message.find(' '));
  const auto exact = log.find(key);
  if (exact != log.end()) return exact->second;
  const std::string section = key.substr(0, key.rfind('.') + 1);
  for (const auto& [other, file] : log) {
    if (other.compare(0, section.size(), section) == 0 &&
        message.find(" " + other.substr(section.size()) + " ") != std::string::npos) {
      return file;
    }
  }
  return fallback;
}

// Runs `work` on a copy and hands it over on success; every problem becomes "file: message".
template <typename Work>
bool transact(Config* config, std::string* error, std::string* file, const Work& work) {
  Config result = *config;
  SectionLog log;
  std::string message;
  try {
    work(&result, &log);
    result.front_end.window = result.options.window;
    result.front_end.imu = result.options.imu;
    // The flow cannot be predicted from the gyroscope without the rotation between the two sensors.
    if (result.calibration.sigmas.rotation_deg >= CalibrationSigmas::kUnknownRotationDeg) {
      result.front_end.use_gyro = false;
    }
    try {
      checkRanges(result);
    } catch (const Problem& problem) {
      *file = originOf(problem.message, log, *file);
      throw;
    }
    noteKeys(&result);
    *config = std::move(result);
    return true;
  } catch (const Problem& problem) {
    message = problem.message;
  } catch (const std::exception& exception) {
    message = exception.what();
  }
  if (error != nullptr) *error = *file + ": " + message;
  return false;
}

}  // namespace

std::unique_ptr<IInitializer> makeLiveInitializer(const Config& config, std::string* error) {
  InitializerOptions options = config.options;
  options.limits = liveLimits(options.limits);
  return baselines::makeInitializer(config.method, config.calibration, options, error);
}

OptionTable configTable(Config* config) {
  OptionTable table = {
      userKey("method", &config->method,
              "the solver: slim, or a compared method; `slim_init methods` lists the names"),
  };
  appendSection("", optionTable(&config->calibration), {}, &table);
  appendSection("calibration_sigmas", optionTable(&config->calibration.sigmas), {"slim"}, &table);
  appendSection("noise", optionTable(&config->calibration.imu_noise), {}, &table);
  appendSection("", optionTable(&config->options), {}, &table);
  appendSection("", optionTable(&config->front_end), {}, &table);
  return table;
}

std::string noteUnreadKeys(const Config& config, const std::vector<std::string>& methods) {
  Config copy = config, defaults;
  const OptionTable given = configTable(&copy), fresh = configTable(&defaults);
  std::string keys;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const bool is_read =
        std::any_of(methods.begin(), methods.end(),
                    [&](const std::string& method) { return given[i].isReadBy(method); });
    if (is_read || written(given[i]) == written(fresh[i])) continue;
    keys += (keys.empty() ? "" : ", ") + std::string(kSection) + "." + given[i].key;
  }
  if (keys.empty()) return "";
  return "without effect on " + listed(methods) + ": " + keys;
}

bool loadConfig(const std::string& path, Config* config, std::string* error) {
  return loadConfig(path, "", config, error);
}

bool loadConfig(const std::string& path, const std::string& options_path, Config* config,
                std::string* error) {
  std::string file = path;
  // A configuration is read whole: nothing of an earlier one stays.
  Config fresh;
  const bool loaded = transact(&fresh, error, &file, [&](Config* result, SectionLog* log) {
    const std::unique_ptr<cv::FileStorage> storage = openFile(path);
    readHost(storage->root(), path, result);
    readSection(storage->root(), path, false, result, log);
    if (!options_path.empty()) {
      file = options_path;
      readSection(openFile(options_path)->root(), options_path, true, result, log);
      file = path;
    }
    checkExtrinsic(*result);
    noteNoise(storage->root(), *log, result);
  });
  if (loaded) *config = std::move(fresh);
  return loaded;
}

bool loadHostKeys(const std::string& path, HostKeys* keys, std::string* error) {
  Config config;
  std::string file = path;
  const bool loaded = transact(&config, error, &file, [&](Config* result, SectionLog* /*log*/) {
    readHostKeys(openFile(path)->root(), &result->host);
  });
  if (loaded) *keys = config.host;
  return loaded;
}

bool loadSensorFiles(const std::string& folder, Config* config, std::string* error) {
  const std::string inside = folder + "/mav0";
  std::error_code code;
  const std::string root = std::filesystem::is_directory(inside + "/cam0", code) ? inside : folder;
  const std::string camera = root + "/cam0/sensor.yaml", imu = root + "/imu0/sensor.yaml";
  std::string file = camera;
  return transact(config, error, &file, [&](Config* result, SectionLog* /*log*/) {
    readCameraFile(openFile(camera, Directive::kOptional)->root(), result);
    file = imu;
    readImuFile(openFile(imu, Directive::kOptional)->root(), result);
    file = camera + " and " + imu;
  });
}

bool loadOptions(const std::string& path, Config* config, std::string* error) {
  std::string file = path;
  return transact(config, error, &file, [&](Config* result, SectionLog* log) {
    readSection(openFile(path)->root(), path, true, result, log);
  });
}

}  // namespace slim_init
