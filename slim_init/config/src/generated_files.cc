// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The shipped YAML files and docs/options.md, from the table of all keys.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "slim_init/config/config.h"
#include "yaml_value.h"

namespace slim_init {

using namespace config;  // the parts of this library

namespace {

constexpr std::size_t kColumns = 100;

bool belongsTo(const OptionField& option, OptionKeys keys) {
  const bool compared = isForComparedMethods(option);
  switch (keys) {
    case OptionKeys::kUser: return !compared && option.audience == Audience::kUser;
    case OptionKeys::kAdvanced: return !compared && option.audience == Audience::kAdvanced;
    case OptionKeys::kCompared: return compared;
    case OptionKeys::kAll: return true;
  }
  return false;
}

OptionTable select(const OptionTable& table, OptionKeys keys) {
  OptionTable selected;
  std::copy_if(table.begin(), table.end(), std::back_inserter(selected),
               [keys](const OptionField& option) { return belongsTo(option, keys); });
  return selected;
}

std::string number(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

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

// ----------------------------------------------------------------------------------- YAML files

constexpr char kTemplateHead[] = R"(%YAML:1.0
# Copy this file and fill in your rig. The upper part has the keys of a VINS-Mono configuration that
# slim_init reads (an existing file of that host can be used as it is); the section slim_init: has
# our keys that depend on rig, motion or application, with their defaults: any of them may be left
# out. All keys are listed in docs/options.md. `slim_init options --update .` writes this file.

# Topics of the ROS nodes and of a bag.
imu_topic: "/imu0"
image_topic: "/cam0/image_raw"

# Camera. PINHOLE: distortion_parameters k1 k2 p1 p2, projection_parameters fx fy cx cy.
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

# Camera in the IMU frame: p_imu = extrinsicRotation * p_cam + extrinsicTranslation. Here the camera
# looks along the IMU's x axis with z up.
# 0: measured, 1: a guess, 2: not known (both matrices may then be absent). The host keeps it,
# improves it, finds it; slim_init takes it as that uncertain (slim_init: calibration_sigmas).
estimate_extrinsic: 0
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

g_norm: 9.81007       # [m/s^2]
td: 0.0               # [s], t_imu = t_image + td
estimate_td: 0        # 1: the host estimates td, the value above is its start
rolling_shutter: 0    # 1: rows are exposed one after the other; stamps are of the middle row
rolling_shutter_tr: 0 # [s], from the first row to the last

# Point tracking of the host. Ours has keys of its own (slim_init: points:) and takes only fisheye
# from here, unless slim_init: front_end: profile: is vins.
)";

constexpr char kAdvancedHead[] = R"(%YAML:1.0
# Keys of `slim` whose defaults were measured; there is rarely a reason to change one. Copy single
# keys into your file, or give a file like this one to the option --options of `slim_init ab`.
# `slim_init options --update .` writes this file.

)";

constexpr char kComparedHead[] = R"(%YAML:1.0
# Keys that only the compared methods read, with the values of their papers and releases. A key that
# the chosen method does not read gives a note. `slim_init options --update .` writes this file.

)";

std::string templateYaml(const OptionTable& table) {
  std::string text = kTemplateHead;
  feature_tracker_lines::HostFrontEnd host;
  for (const OptionField& option : optionTable(&host)) {
    text += comment(option, "") + option.key + ": " + written(option) + "\n";
  }
  return text + "\n" + sectionYaml(select(table, OptionKeys::kUser));
}

// ----------------------------------------------------------------------------------- the page

constexpr char kPageHead[] = R"(# Options

Every key of the section `slim_init:` of a configuration file with default, range and reason. The
format of the files is described in [config/README.md](../config/README.md). `slim_init options`
prints the keys as YAML; `slim_init options --update .` writes this page.

The last column names the methods that read a key. Set for another method it has no effect, and a
note says so. A value outside of the range is refused with a message that names file, key, value and
bound.

A patched host starts from the same defaults ([vins_mono.md](vins_mono.md)); keys in its file win.
)";

constexpr char kUserHead[] = R"(
## Keys for users

They depend on rig, motion or application. The file to copy is
[config/template.yaml](../config/template.yaml).

)";

constexpr char kAdvancedPageHead[] = R"(
## Advanced keys

Parts of the method, with the defaults that were measured; what is marked as ablation is there to be
switched off for comparison. As a file: [config/advanced.yaml](../config/advanced.yaml).

)";

constexpr char kComparedPageHead[] = R"(
## Keys of the compared methods

`slim` reads none of them. As a file:
[config/compared_methods.yaml](../config/compared_methods.yaml). The methods are described in
[baselines.md](baselines.md).

)";

constexpr char kHostPageHead[] = R"(
## The host's keys for its tracker

At the top level of the file, beside camera and extrinsic, as VINS-Mono has them.

)";

constexpr char kRenamedHead[] = R"(
## Renamed keys

The old name is read in this release with a note, and refused in the next.

| old | now |
|---|---|
)";

std::string markdownTable(const OptionTable& table) {
  std::ostringstream out;
  out << "| key | default | range | unit | what it does | methods |\n|---|---|---|---|---|---|\n";
  for (const OptionField& option : table) {
    std::string methods;
    for (const std::string& method : option.methods) {
      methods += (methods.empty() ? "" : ", ") + method;
    }
    out << "| `" << option.key << "` | " << written(option) << " | " << rangeOf(option) << " | "
        << option.unit << " | " << option.reason << " | " << (methods.empty() ? "all" : methods)
        << " |\n";
  }
  return out.str();
}

}  // namespace

std::string optionsPage() {
  Config defaults;
  const OptionTable table = configTable(&defaults);
  std::string text = kPageHead;
  text += kUserHead + markdownTable(select(table, OptionKeys::kUser));
  text += kAdvancedPageHead + markdownTable(select(table, OptionKeys::kAdvanced));
  text += kComparedPageHead + markdownTable(select(table, OptionKeys::kCompared));
  feature_tracker_lines::HostFrontEnd host;
  text += kHostPageHead + markdownTable(optionTable(&host));
  text += kRenamedHead;
  for (const RenamedKey& renamed : renamedKeys()) {
    text += "| `" + renamed.old_key + "` | `" + renamed.key + "` |\n";
  }
  return text;
}

std::string optionsYaml(OptionKeys keys) {
  Config defaults;
  return "%YAML:1.0\n" + sectionYaml(select(configTable(&defaults), keys));
}

std::vector<GeneratedFile> generatedFiles() {
  Config defaults;
  const OptionTable table = configTable(&defaults);
  return {
      {"config/template.yaml", templateYaml(table)},
      {"config/advanced.yaml", kAdvancedHead + sectionYaml(select(table, OptionKeys::kAdvanced))},
      {"config/compared_methods.yaml",
       kComparedHead + sectionYaml(select(table, OptionKeys::kCompared))},
      {"docs/options.md", optionsPage()},
  };
}

}  // namespace slim_init
