// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The shipped YAML files, from the table of all keys.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "host_keys.h"
#include "slim_init/config/config.h"
#include "slim_init/text.h"
#include "yaml_value.h"

namespace slim_init {

using namespace config;  // the parts of this library

namespace {

constexpr std::size_t kColumns = 100;

bool belongsTo(const OptionField& option, OptionKeys keys) {
  const Audience audience = keys == OptionKeys::kUser ? Audience::kUser : Audience::kAdvanced;
  return keys == OptionKeys::kAll || option.audience == audience;
}

template <typename Wanted>
OptionTable select(const OptionTable& table, const Wanted& wanted) {
  OptionTable selected;
  std::copy_if(table.begin(), table.end(), std::back_inserter(selected), wanted);
  return selected;
}

OptionTable select(const OptionTable& table, OptionKeys keys) {
  return select(table, [keys](const OptionField& option) { return belongsTo(option, keys); });
}

// The first screen of template.yaml: the beginning of switchTable() and rigTable() and, of our
// section, the noise of the IMU.
constexpr std::ptrdiff_t kFirstSwitches = 2, kFirstOfRig = 4;

bool isNoise(const OptionField& option) { return option.key.compare(0, 6, "noise.") == 0; }

std::string number(double value) { return text(value); }

// "0.01 to 5", "from 19.6", "own, on or off", "0 or 1"; empty for a text.
std::string rangeOf(const OptionField& option) {
  if (const auto* word = std::get_if<OptionWord>(&option.value)) return listed(word->words);
  if (std::holds_alternative<bool*>(option.value)) return "0 or 1";
  if (std::holds_alternative<std::string*>(option.value)) return "";
  if (std::isinf(option.range.max)) return "from " + number(option.range.min);
  return number(option.range.min) + " to " + number(option.range.max);
}

// A comment of YAML: reason, and in brackets unit and range, in lines of kColumns.
std::string comment(const OptionField& option, const std::string& indent) {
  std::string brackets = option.unit;
  const std::string range = rangeOf(option);
  if (!range.empty()) brackets += (brackets.empty() ? "" : ", ") + range;
  std::vector<std::string> words;
  std::istringstream reason(option.reason);
  for (std::string word; reason >> word;) words.push_back(word);
  if (!brackets.empty()) words.push_back("[" + brackets + "]");  // never broken

  std::string text, line = indent + "#";
  for (const std::string& word : words) {
    if (line.size() + 1 + word.size() > kColumns) {
      text += line + "\n";
      line = indent + "#";
    }
    line += " " + word;
  }
  return text + line + "\n";
}

// The section `slim_init:` with the keys of `table` and their values.
std::string sectionYaml(const OptionTable& table) {
  std::ostringstream out;
  out << "slim_init:\n";
  std::string open_section;
  for (const OptionField& option : table) {
    const std::size_t dot = option.key.rfind('.');
    const std::string section = dot == std::string::npos ? "" : option.key.substr(0, dot + 1);
    std::string indent = "  ";
    // Each level of the section that is not open yet.
    for (std::size_t begin = 0, end = section.find('.'); end != std::string::npos;
         begin = end + 1, end = section.find('.', begin)) {
      if (open_section.compare(0, end + 1, section, 0, end + 1) != 0) {
        out << indent << section.substr(begin, end - begin) << ":\n";
      }
      indent += "  ";
    }
    open_section = section;
    out << comment(option, indent) << indent << option.key.substr(section.size()) << ": "
        << written(option) << "\n";
  }
  return out.str();
}

constexpr char kTemplateHead[] = R"(%YAML:1.0
# Copy this file and fill in your rig: a configuration of VINS-Mono with slim_init switched on. Each
# key has its range and reason. `slim_init options --update .` writes this file.

# ---- The keys that matter

)";

constexpr char kTemplateSection[] = R"(# Further keys of this section: config/user.yaml.
)";

constexpr char kTemplateCamera[] = R"(
# ---- Camera
# PINHOLE: distortion_parameters k1 k2 p1 p2, projection_parameters fx fy cx cy.
# MEI: mirror_parameters xi, distortion_parameters k1 k2 p1 p2, projection_parameters gamma1 gamma2
# u0 v0. KANNALA_BRANDT: projection_parameters k2 k3 k4 k5 mu mv u0 v0.
model_type: PINHOLE
image_width: 640      # [px]
image_height: 480     # [px]
distortion_parameters:
   k1: 0.0
   k2: 0.0
   p1: 0.0
   p2: 0.0
projection_parameters:
   fx: 460.0          # [px]
   fy: 460.0
   cx: 320.0
   cy: 240.0

# ---- Camera in the IMU frame
# p_imu = extrinsicRotation * p_cam + extrinsicTranslation. Here the camera looks along the IMU's x
# axis with z up.
extrinsicRotation: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.0,  0.0, 1.0,
          -1.0,  0.0, 0.0,
           0.0, -1.0, 0.0 ]
extrinsicTranslation: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 0.0, 0.0, 0.0 ]  # [m]

# ---- Other keys of the rig
)";

constexpr char kTemplateSwitches[] = R"(
# ---- Other switches of slim_init in the estimator
# watchdog and keep_heading are as reinit if they are absent.
)";

constexpr char kTemplateTracker[] = R"(
# ---- Tracker of VINS-Mono
# The tracker of slim_init has keys of its own (config/user.yaml: points) and reads fisheye and
# equalize here, and all of them with slim_init.front_end.profile: vins.
)";

constexpr char kTemplateHost[] = R"(
# ---- Read by VINS-Mono only
# VINS-Mono takes an absent number as 0. These values are those of its EuRoC configuration.
# accelerometer noise per sample, a tuning value
acc_n: 0.08
# gyroscope noise per sample
gyr_n: 0.004
# random walk of the accelerometer bias
acc_w: 4e-05
# random walk of the gyroscope bias
gyr_w: 2e-06
# limit of one optimization [s]
max_solver_time: 0.04
# limit of one optimization
max_num_iterations: 8
# mean parallax that makes a keyframe [px]
keyframe_parallax: 10.0
# folder for results
output_path: "/tmp"
# name of the camera model
camera_name: "camera"
# 1: publish the image with the tracks [0 or 1]
show_track: 0
# 1: run the pose graph [0 or 1]
loop_closure: 0
# 1: load it from pose_graph_save_path [0 or 1]
load_previous_pose_graph: 0
# 1: relocalize in the estimator [0 or 1]
fast_relocalization: 0
# folder of the pose graph
pose_graph_save_path: "/tmp"
# 1: save images with the pose graph [0 or 1]
save_image: 0
# 1: draw the predicted pose [0 or 1]
visualize_imu_forward: 0
# size of the drawn camera [m]
visualize_camera_size: 0.4
)";

constexpr char kUserFileHead[] = R"(%YAML:1.0
# Keys of the section slim_init: that depend on rig, motion or application, with their defaults.
# Copy single keys into the section of your file. `slim_init options --update .` writes this file.

)";

constexpr char kAdvancedHead[] = R"(%YAML:1.0
# Keys of `slim` whose defaults were measured; there is rarely a reason to change one. Copy single
# keys into your file, or give a file like this one to the option --options of `slim_init ab`.
# `slim_init options --update .` writes this file.

)";

// A text in quotes: OpenCV takes an empty one for no value at all.
std::string writtenForHost(const OptionField& option) {
  const std::string text = written(option);
  return std::holds_alternative<std::string*>(option.value) ? "\"" + text + "\"" : text;
}

std::string hostYaml(const OptionTable& table) {
  std::string text;
  for (const OptionField& option : table) {
    text += comment(option, "") + option.key + ": " + writtenForHost(option) + "\n";
  }
  return text;
}

// Switched on, with a rig whose topics are EuRoC's.
Config templateConfig() {
  Config config;
  config.host.initializer = "slim";
  config.host.reinit = config.host.watchdog = config.host.keep_heading = true;
  config.imu_topic = "/imu0";
  config.image_topic = "/cam0/image_raw";
  return config;
}

std::string templateYaml() {
  Config config = templateConfig();
  const OptionTable switches = switchTable(&config.host), rig = rigTable(&config);
  const auto first_of = [](const OptionTable& table, std::ptrdiff_t count) {
    return hostYaml({table.begin(), table.begin() + count});
  };
  const auto rest_of = [](const OptionTable& table, std::ptrdiff_t count) {
    return hostYaml({table.begin() + count, table.end()});
  };
  std::string text =
      kTemplateHead + first_of(switches, kFirstSwitches) + first_of(rig, kFirstOfRig);
  text += kTemplateSection + sectionYaml(select(configTable(&config), isNoise));
  text += kTemplateCamera + rest_of(rig, kFirstOfRig);
  text += kTemplateSwitches + rest_of(switches, kFirstSwitches);
  text += kTemplateTracker + hostYaml(optionTable(&config.front_end.host));
  return text + kTemplateHost;
}

}  // namespace

std::string optionsYaml(OptionKeys keys) {
  Config defaults;
  return "%YAML:1.0\n" + sectionYaml(select(configTable(&defaults), keys));
}

std::vector<GeneratedFile> generatedFiles() {
  Config defaults;
  const OptionTable table = configTable(&defaults);
  const auto section = [&table](OptionKeys keys) {
    return sectionYaml(select(table, [keys](const OptionField& option) {
      return belongsTo(option, keys) && !isNoise(option);
    }));
  };
  return {
      {"config/template.yaml", templateYaml()},
      {"config/user.yaml", kUserFileHead + section(OptionKeys::kUser)},
      {"config/advanced.yaml", kAdvancedHead + section(OptionKeys::kAdvanced)},
  };
}

}  // namespace slim_init
