// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The shipped YAML files and docs/options.md, from the table of all keys.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "host_keys.h"
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

template <typename Wanted>
OptionTable select(const OptionTable& table, const Wanted& wanted) {
  OptionTable selected;
  std::copy_if(table.begin(), table.end(), std::back_inserter(selected), wanted);
  return selected;
}

OptionTable select(const OptionTable& table, OptionKeys keys) {
  return select(table, [keys](const OptionField& option) { return belongsTo(option, keys); });
}

// The first screen of template.yaml and of the page: these keys of the host's file and, of our
// section, the noise of the IMU.
constexpr const char* kFirstKeys[] = {"initializer", "reinit",          "estimate_extrinsic",
                                      "estimate_td", "rolling_shutter", "rolling_shutter_tr"};

bool isFirst(const OptionField& option) {
  return std::find(std::begin(kFirstKeys), std::end(kFirstKeys), option.key) !=
         std::end(kFirstKeys);
}

bool isNoise(const OptionField& option) { return option.key.compare(0, 6, "noise.") == 0; }

// In the order of kFirstKeys.
OptionTable firstKeys(const OptionTable& host) {
  OptionTable first;
  for (const char* key : kFirstKeys) {
    for (const OptionField& option : host) {
      if (option.key == key) first.push_back(option);
    }
  }
  return first;
}

OptionTable joined(OptionTable a, const OptionTable& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
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
  if (option.range.min == option.range.max) return "";  // is not checked
  if (std::isinf(option.range.max)) return "from " + number(option.range.min);
  return number(option.range.min) + " to " + number(option.range.max);
}

// "0.01 to 5 s"
std::string rangeWithUnit(const OptionField& option) {
  const std::string range = rangeOf(option);
  return range + (range.empty() || option.unit.empty() ? "" : " ") + option.unit;
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
# Copy this file and fill in your rig: a configuration of VINS-Mono with slim_init switched on. The
# keys are listed in docs/options.md. `slim_init options --update .` writes this file.

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

constexpr char kComparedHead[] = R"(%YAML:1.0
# Keys that only the compared methods read, with the values of their papers and releases. A key that
# the chosen method does not read gives a note. `slim_init options --update .` writes this file.

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
  const auto other = [](const OptionField& option) { return !isFirst(option); };
  VinsMonoKeys vins_mono;
  std::string text = kTemplateHead + hostYaml(firstKeys(joined(switches, rig)));
  text += kTemplateSection + sectionYaml(select(configTable(&config), isNoise));
  text += kTemplateCamera + hostYaml(select(rig, other));
  text += kTemplateSwitches + hostYaml(select(switches, other));
  text += kTemplateTracker + hostYaml(optionTable(&config.front_end.host));
  return text + kTemplateHost + hostYaml(vinsMonoTable(&vins_mono));
}

// Keys of our section for users that are not on the first screen.
OptionTable otherUserKeys(const OptionTable& table) {
  return select(select(table, OptionKeys::kUser),
                [](const OptionField& option) { return !isNoise(option); });
}

std::string userYaml(const OptionTable& table) {
  return kUserFileHead + sectionYaml(otherUserKeys(table));
}

// ----------------------------------------------------------------------------------- the page

constexpr char kPageHead[] = R"(# Options

The keys of a configuration file, the most important first. Format of the files:
[config/README.md](../config/README.md). `slim_init options --update .` writes this page.

## The keys that matter

| key | if absent | range | what it does |
|---|---|---|---|
)";

constexpr char kAfterFirst[] = R"(
The files in `config` set `initializer: slim` and `reinit: 1`. A file to copy:
[config/template.yaml](../config/template.yaml). With a new rig begin with its noise densities, then
see [calibration.md](calibration.md).

A value outside of its range is refused with a message that names file, key, value and range. An
unknown key under `slim_init:` is an error, too.

## Keys at the top level of the file

Beside camera and extrinsic, which are as VINS-Mono has them.
)";

constexpr char kSwitchHead[] = R"(
### Switches of slim_init in the estimator

)";

constexpr char kRigHead[] = R"(
### Rig

)";

constexpr char kTrackerHead[] = R"(
### Tracker of VINS-Mono

The tracker of slim_init reads `fisheye` and `equalize`, and all of them with
`slim_init.front_end.profile: vins`.

)";

constexpr char kVinsMonoHead[] = R"(
### Read by VINS-Mono only

VINS-Mono takes an absent number as 0. [config/template.yaml](../config/template.yaml) explains
these keys and has their values for EuRoC:
)";

constexpr char kUserHead[] = R"(
## Keys of the section `slim_init:` for users

They depend on rig, motion or application. As a file: [config/user.yaml](../config/user.yaml). A key
has no effect on methods that do not read it, and a note says so.
)";

constexpr char kOtherFiles[] = R"(
## Other keys of `slim_init:`

These files list them with default, range and reason, as above:

| file | keys |
|---|---|
| [config/advanced.yaml](../config/advanced.yaml) | parts of `slim` with measured defaults; those marked as ablation are for comparisons only |
| [config/compared_methods.yaml](../config/compared_methods.yaml) | parameters of the compared methods ([baselines.md](baselines.md)) |

Renamed keys are read under the old name in this release, with a note that has the new one.
)";

// What the host does without the key.
std::string ifAbsent(const OptionField& option) {
  if (followsReinit(option.key)) return "as `reinit`";
  const std::string text = written(option);
  return text.empty() ? "none" : text;
}

std::string firstTable(const OptionTable& host, const OptionTable& ours) {
  std::string text;
  for (OptionField& option : joined(firstKeys(host), select(ours, isNoise))) {
    if (isNoise(option)) option.key = "slim_init." + option.key;
    text += "| `" + option.key + "` | " + ifAbsent(option) + " | " + rangeWithUnit(option) + " | " +
            option.reason + " |\n";
  }
  return text;
}

// The keys of the host's file but those of the first screen.
std::string hostTable(const OptionTable& table) {
  std::string text = "| key | if absent | range | what it does |\n|---|---|---|---|\n";
  for (const OptionField& option : table) {
    if (isFirst(option)) continue;
    text += "| `" + option.key + "` | " + ifAbsent(option) + " | " + rangeWithUnit(option) + " | " +
            option.reason + " |\n";
  }
  return text;
}

// The keys of a table as a sentence, in lines of kColumns.
std::string keyList(const OptionTable& table) {
  std::string text, line;
  for (const OptionField& option : table) {
    const bool last = &option == &table.back();
    const std::string word = "`" + option.key + (last ? "`." : "`,");
    if (line.size() + 1 + word.size() > kColumns) {
      text += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return text + line + "\n";
}

// Rows of one section. A column names the methods unless they are those of all rows.
std::string sectionTable(const OptionTable& rows) {
  const bool mixed = std::any_of(rows.begin(), rows.end(), [&](const OptionField& option) {
    return option.methods != rows.front().methods;
  });
  const auto methods = [](const OptionField& option) {
    return option.methods.empty() ? std::string("all") : listed(option.methods, " and ");
  };
  std::string text;
  if (!mixed && !rows.front().methods.empty()) text += "Read by " + methods(rows.front()) + ".\n\n";
  text += std::string("| key | default | range | what it does |") +
          (mixed ? " methods |\n|---|---|---|---|---|\n" : "\n|---|---|---|---|\n");
  for (const OptionField& option : rows) {
    text += "| `" + option.key + "` | " + written(option) + " | " + rangeWithUnit(option) + " | " +
            option.reason + (mixed ? " | " + methods(option) : "") + " |\n";
  }
  return text;
}

// A table for each section of keys, below a heading.
std::string sectionTables(const OptionTable& table) {
  const auto sectionOf = [](const OptionField& option) {
    const std::size_t dot = option.key.find('.');
    return dot == std::string::npos ? std::string() : option.key.substr(0, dot);
  };
  std::vector<std::string> sections;
  for (const OptionField& option : table) {
    const std::string section = sectionOf(option);
    if (std::find(sections.begin(), sections.end(), section) == sections.end()) {
      sections.push_back(section);
    }
  }
  std::string text;
  for (const std::string& section : sections) {
    text += "\n### " + (section.empty() ? "General" : "`" + section + "`") + "\n\n";
    text += sectionTable(
        select(table, [&](const OptionField& option) { return sectionOf(option) == section; }));
  }
  return text;
}

}  // namespace

std::string optionsPage() {
  Config defaults;
  const OptionTable table = configTable(&defaults);
  const OptionTable switches = switchTable(&defaults.host), rig = rigTable(&defaults);
  VinsMonoKeys vins_mono;
  std::string text = kPageHead + firstTable(joined(switches, rig), table) + kAfterFirst;
  text += kSwitchHead + hostTable(switches);
  text += kRigHead + hostTable(rig);
  text += kTrackerHead + hostTable(optionTable(&defaults.front_end.host));
  text += kVinsMonoHead + keyList(vinsMonoTable(&vins_mono));
  text += kUserHead + sectionTables(otherUserKeys(table));
  return text + kOtherFiles;
}

std::string optionsYaml(OptionKeys keys) {
  Config defaults;
  return "%YAML:1.0\n" + sectionYaml(select(configTable(&defaults), keys));
}

std::vector<GeneratedFile> generatedFiles() {
  Config defaults;
  const OptionTable table = configTable(&defaults);
  return {
      {"config/template.yaml", templateYaml()},
      {"config/user.yaml", userYaml(table)},
      {"config/advanced.yaml", kAdvancedHead + sectionYaml(select(table, OptionKeys::kAdvanced))},
      {"config/compared_methods.yaml",
       kComparedHead + sectionYaml(select(table, OptionKeys::kCompared))},
      {"docs/options.md", optionsPage()},
  };
}

}  // namespace slim_init
