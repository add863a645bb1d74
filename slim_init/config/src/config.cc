// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/config/config.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <sstream>
#include <utility>

#include "host_keys.h"
#include "section.h"
#include "slim_init/baselines/baselines.h"
#include "yaml_value.h"

namespace slim_init {

using namespace config;  // the parts of this library

namespace {

void noteNoise(const cv::FileNode& root, const SectionLog& log, Config* config) {
  const bool has_gyro = log.count("slim_init.noise.gyro_density") > 0;
  const bool has_accel = log.count("slim_init.noise.accel_density") > 0;
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
    std::ostringstream known;
    for (const std::string& name : methods) known << (known.tellp() > 0 ? ", " : "") << name;
    fail(kSection, ".method is \"", config.method, "\", must be one of ", known.str());
  }
  std::string message = config.options.validate();
  if (message.empty()) message = config.baselines.validate();
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

OptionTable configTable(Config* config) {
  OptionTable table = {
      userKey("method", &config->method,
              "the solver: slim, or a compared method; `slim_init methods` lists the names"),
  };
  appendSection("", optionTable(&config->calibration), {}, &table);
  appendSection("calibration_sigmas", optionTable(&config->calibration.sigmas), {"slim"}, &table);
  appendSection("noise", optionTable(&config->calibration.imu_noise), {}, &table);
  appendSection("", optionTable(&config->options), {}, &table);
  appendSection("", optionTable(&config->baselines), {}, &table);
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

bool loadOptions(const std::string& path, Config* config, std::string* error) {
  std::string file = path;
  return transact(config, error, &file, [&](Config* result, SectionLog* log) {
    readSection(openFile(path)->root(), path, true, result, log);
  });
}

}  // namespace slim_init
