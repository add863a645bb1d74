// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Configuration files: VINS-Mono's own OpenCV-YAML file as it is, and our keys under `slim_init:`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/options.h"
#include "slim_init/initializer.h"
#include "slim_init/option_table.h"
#include "slim_init/options.h"
#include "slim_init/types.h"

namespace slim_init {

/// What a patched host finds in its own file beside our section; without these keys it runs as it
/// did unpatched (docs/vins_mono.md). Ranges and reasons: config/template.yaml.
struct HostKeys {
  std::string initializer = "stock";  ///< who initializes: stock, slim or shadow
  bool reinit = false;                ///< reinitialize on a failure and on request
  bool watchdog = false;              ///< monitor the running host; absent: as `reinit`
  /// After each of its optimizations the host keeps the heading of its oldest frame, in place of
  /// that frame's Euler yaw; absent: as `reinit`.
  bool keep_heading = false;
  /// Maximum time that an image waits for a solve [ms]; negative: until it ends.
  double max_wait_ms = 10.0;
  std::string output_path;  ///< the host's folder for results
  int num_of_cam = 1;       ///< of VINS-Fusion, which starts with its second camera
  bool imu = true;          ///< likewise; false: it flies without
  /// 0: the file's extrinsic is exact for the host, 1: a guess that it improves, 2: not known.
  int estimate_extrinsic = 0;
  bool rolling_shutter = false;     ///< rows are exposed one after the other
  double rolling_shutter_tr = 0.0;  ///< from the first row to the last [s]
  /// Image files that leave out parts of the image, as the file has them; empty: none. What they
  /// leave is in FrontEndOptions::mask.
  std::string mask;
  std::string fisheye_mask;              ///< read with fisheye: 1
  bool extrinsic_in_one_matrix = false;  ///< body_T_cam0, as VINS-Fusion has it
  bool has_rotation = true;              ///< may be absent with estimate_extrinsic: 2 only
  bool has_translation = true;           ///< likewise
};

/// Everything a program needs to run an initializer on a rig.
struct Config {
  std::string method = "slim";  ///< one of baselines::methods()
  InitializerOptions options;
  Calibration calibration;
  feature_tracker_lines::CameraParameters camera;
  feature_tracker_lines::FrontEndOptions front_end;  ///< the host's own keys are in front_end.host
  bool estimate_td = false;  ///< the host estimates td itself; ours is its starting value
  std::string imu_topic;
  std::string image_topic;
  std::string speed_topic;         ///< of Calibration::speed_sensor; empty: none
  bool speed_forward_only = true;  ///< SpeedSample::forward_only of its messages
  HostKeys host;
  /// What the reader should know, one message each; nothing here is an error. Keys that
  /// `method` does not read (noteUnreadKeys()) are among them.
  std::vector<std::string> notes;
};

/// The initializer of a running system, whose time is that of liveLimits(). Null and a message in
/// `error` (may be null) where the configuration does not allow one.
std::unique_ptr<IInitializer> makeLiveInitializer(const Config& config, std::string* error);

/// All our keys, bound to the fields of `config`; `key` is the path below `slim_init:`, e.g.
/// "window.keyframes". Made of the tables that stand beside the structs (slim_init/option_table.h).
OptionTable configTable(Config* config);

/// A note that names the keys with another value than the default that none of `methods` reads, or
/// an empty string.
std::string noteUnreadKeys(const Config& config, const std::vector<std::string>& methods);

/// Groups of keys: those for users and the advanced ones.
enum class OptionKeys { kUser, kAdvanced, kAll };

/// A section `slim_init:` with these keys, their defaults, units, ranges and reasons.
std::string optionsYaml(OptionKeys keys);

/// A file of this repository that is written from configTable().
struct GeneratedFile {
  std::string path;  ///< from the top of the repository: "config/template.yaml"
  std::string text;
};

/// config/template.yaml (a rig: the host's keys, our switches and the noise of the IMU), of which
/// the file in `repository` is kept but for these keys and the comments above them;
/// config/user.yaml (our other keys for users), config/advanced.yaml.
std::vector<GeneratedFile> generatedFiles(const std::string& repository);

/// Reads the host's configuration file: camera (model_type, image_width, image_height,
/// projection_parameters, distortion_parameters, mirror_parameters), extrinsicRotation and
/// extrinsicTranslation (camera to IMU), g_norm, td, rolling_shutter_tr, topics, front-end keys,
/// masks, and our section `slim_init:`. estimate_td and estimate_extrinsic raise
/// Calibration::sigmas.
/// `acc_n` and `gyr_n` are per-sample tuning values of the host and never become our noise
/// densities; a note says so. Keys of the host that we do not use are left alone. VINS-Fusion
/// writes some of them otherwise, and both ways are read: cam0_calib names a file beside this one
/// that holds the camera, body_T_cam0 is the extrinsic, image0_topic the topic.
///
/// Everything else is an error: a missing or malformed file, a missing camera or extrinsic key, a
/// value of another type, an unknown key in our section, a value out of range, a key read here
/// that is given twice. Then returns false, leaves `config` as it was and puts a message that names
/// file, key, value and bound into `error` (may be null). Never throws.
bool loadConfig(const std::string& path, Config* config, std::string* error);

/// The same with our section in a file of its own, which wins over the one in the host's file;
/// empty: no such file.
bool loadConfig(const std::string& path, const std::string& options_path, Config* config,
                std::string* error);

/// Reads only our switches and the folder for results (`initializer` to `output_path`), whatever
/// else the file holds. Errors as above.
bool loadHostKeys(const std::string& path, HostKeys* keys, std::string* error);

/// Reads the calibration beside an ASL recording, in DIR/mav0 or DIR: cam0/sensor.yaml (T_BS,
/// resolution, camera_model, intrinsics, distortion_model, distortion_coefficients, and of our own
/// rolling_shutter_tr and td) and imu0/sensor.yaml (T_BS, noise densities, and of our own g_norm).
/// Errors as above.
bool loadSensorFiles(const std::string& folder, Config* config, std::string* error);

/// Reads only the section `slim_init:` of a file onto `config`; it has to be there. Errors as
/// above.
bool loadOptions(const std::string& path, Config* config, std::string* error);

}  // namespace slim_init
