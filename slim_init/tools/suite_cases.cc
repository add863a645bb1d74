// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "suite_cases.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <set>
#include <sstream>

#include "ablation.h"
#include "methods.h"
#include "paper_figures.h"
#include "shell_line.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;

// Of --quick, where --limit was not typed.
constexpr int kQuickWindows = 5;
constexpr double kQuickDuration_s = 10.0;

// Simulated features as they are tracked, not as they are drawn: docs/benchmark.md.
constexpr double kOutlierRate = 0.03;
constexpr double kDriftPx = 0.04;

/// A built-in motion of the suite.
struct Motion {
  const char* name;
  const char* group;
  const char* motion;
  const char* world;
  int points;
  bool ablation;
};

constexpr char kDegenerate[] = "Degenerate";
constexpr char kNoParallax[] = "Without parallax";
constexpr char kExcited[] = "Excited";

constexpr Motion kMotions[] = {
    {"corridor-walk", kDegenerate, "corridor-walk", "corridor", 12, true},
    {"constant-velocity-12", kDegenerate, "constant-velocity", "hall", 12, true},
    {"constant-velocity", kDegenerate, "constant-velocity", "hall", 100, false},
    {"pure-rotation", kNoParallax, "pure-rotation", "room", 100, false},
    {"hover", kNoParallax, "hover", "room", 100, false},
    {"circle", kExcited, "circle", "room", 100, false},
    {"figure-eight", kExcited, "figure-eight", "room", 100, false},
};

// As EuRoC's files are named; the first five letters are the paper's name.
constexpr const char* kEurocNames[] = {"MH_01_easy",      "MH_02_easy",      "MH_03_medium",
                                       "MH_04_difficult", "MH_05_difficult", "V1_01_easy",
                                       "V1_02_medium",    "V1_03_difficult", "V2_01_easy",
                                       "V2_02_medium",    "V2_03_difficult"};
constexpr std::size_t kPaperNameLength = 5;

// What may be typed beside --suite; the rest belongs to the cases.
const std::set<std::string>& suiteOptionNames() {
  static const std::set<std::string> kNames = {
      "suite",  "recorded", "euroc",  "quick", "threads", "downstream", "downstream-every",
      "out",    "methods",  "stride", "limit", "plots",   "quiet",      "seed",
      "config", "options",  "gates"};
  return kNames;
}

/// The paper's name of a sequence, "" for one that it has not.
std::string paperColumn(const std::string& name) {
  const std::string head = name.substr(0, kPaperNameLength);
  const auto& known = paperSequences();
  return std::find(known.begin(), known.end(), head) == known.end() ? "" : head;
}

std::string groupOf(const std::string& name) {
  if (name.rfind("MH_", 0) == 0) return "Machine Hall";
  if (name.rfind("V1_", 0) == 0) return "Vicon Room 1";
  if (name.rfind("V2_", 0) == 0) return "Vicon Room 2";
  return "Other";
}

/// What the user said for all cases.
AbOptions commonOptions(const AbOptions& suite) {
  AbOptions o;
  o.methods = suite.methods;
  o.stride = suite.stride;
  o.limit = suite.quick && suite.given.count("limit") == 0 ? kQuickWindows : suite.limit;
  o.seed = suite.seed;
  o.downstream_s = suite.downstream_s;
  o.downstream_every = suite.downstream_every;
  o.threads = suite.threads;
  o.options_file = suite.options_file;
  o.gates = suite.gates;
  o.plots = suite.plots;
  o.quiet = suite.quiet;
  // The protocol is the paper's, whatever a file says about windows.
  o.given = {"keyframes", "interval"};
  if (suite.given.count("gates") > 0) o.given.insert("gates");
  return o;
}

AbOptions simulatedOptions(const AbOptions& suite) {
  AbOptions o = commonOptions(suite);
  o.features.outlier_rate = kOutlierRate;
  o.features.drift = kDriftPx;
  return o;
}

/// The methods of the run that have variants; empty: none.
std::string methodsWithVariants(const AbOptions& suite) {
  std::set<std::string> with_variants;
  for (const AblationVariant& variant : ablationVariants()) with_variants.insert(variant.method);
  std::string list;
  std::istringstream typed(suite.methods);
  std::vector<std::string> names = methodNames();
  if (!suite.methods.empty()) {
    names.clear();
    for (std::string name; std::getline(typed, name, ',');) names.push_back(name);
  }
  for (const std::string& name : names) {
    if (with_variants.count(name) > 0) list += (list.empty() ? "" : ",") + name;
  }
  return list;
}

std::vector<fs::path> subfolders(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) found.push_back(it->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::string checkFolder(const std::string& option, const std::string& folder) {
  std::error_code code;
  return fs::is_directory(folder, code) ? "" : option + ": there is no folder " + folder;
}

void addBuiltin(const AbOptions& suite, Suite* list) {
  for (const Motion& motion : kMotions) {
    SuiteCase entry;
    entry.name = motion.name;
    entry.group = motion.group;
    entry.options = simulatedOptions(suite);
    entry.options.builtin = motion.motion;
    entry.options.world = motion.world;
    entry.options.features.max_points = motion.points;
    if (suite.quick) entry.options.duration_s = kQuickDuration_s;
    list->cases.push_back(entry);
  }
}

std::string addRecorded(const AbOptions& suite, Suite* list) {
  if (std::string sentence = checkFolder("--recorded", suite.recorded); !sentence.empty()) {
    return sentence;
  }
  std::error_code code;
  const auto isRecording = [&code](const fs::path& folder) {
    return fs::exists(folder / "imu0.csv", code);
  };
  int found = 0;
  for (const fs::path& folder : subfolders(suite.recorded)) {
    const std::string name = folder.filename().string();
    if (!isRecording(folder)) {
      list->notes.push_back("--recorded: " + name + " has no imu0.csv and was passed over");
      continue;
    }
    ++found;
    SuiteCase entry;
    entry.name = name;
    entry.kind = CaseKind::kRecorded;
    entry.group = groupOf(name);
    entry.paper_column = paperColumn(name);
    entry.options = simulatedOptions(suite);
    entry.options.recorded = folder.string();
    entry.options.world = entry.group == "Machine Hall" ? "hall" : "room";
    list->cases.push_back(entry);
  }
  if (found > 0) return "";
  return isRecording(suite.recorded)
             ? "--recorded: " + suite.recorded +
                   " is one recording; with --suite name the folder that holds it and others"
             : "--recorded: no folder in " + suite.recorded + " holds a recording (imu0.csv)";
}

/// The folder `name` in ASL layout or the bag `name`.bag in `folder`; empty where neither is.
fs::path findSequence(const fs::path& folder, const std::string& name) {
  std::error_code code;
  for (const char* inside : {"mav0", "imu0"}) {
    if (fs::is_directory(folder / name / inside, code)) return folder / name;
  }
  const fs::path bag = folder / (name + ".bag");
  return fs::is_regular_file(bag, code) ? bag : fs::path();
}

std::string addEuroc(const AbOptions& suite, Suite* list) {
  if (std::string sentence = checkFolder("--euroc", suite.euroc); !sentence.empty()) {
    return sentence;
  }
  // EuRoC's archives unpack into a folder per hall and, as bags, one more per sequence.
  std::vector<fs::path> places = {suite.euroc};
  for (const fs::path& folder : subfolders(suite.euroc)) {
    places.push_back(folder);
    const std::vector<fs::path> below = subfolders(folder);
    places.insert(places.end(), below.begin(), below.end());
  }
  std::string missing;
  int found = 0;
  for (const char* name : kEurocNames) {
    fs::path path;
    for (std::size_t i = 0; i < places.size() && path.empty(); ++i) {
      path = findSequence(places[i], name);
    }
    if (path.empty()) {
      missing += (missing.empty() ? "" : ", ") + std::string(name);
      continue;
    }
    ++found;
    SuiteCase entry;
    entry.name = paperColumn(name);
    entry.kind = CaseKind::kImages;
    entry.group = groupOf(name);
    entry.paper_column = entry.name;
    entry.options = commonOptions(suite);
    if (path.extension() == ".bag") {
      if (suite.config_file.empty()) {
        return "--euroc: " + path.string() +
               " is a bag and needs --config YAML, which holds the calibration and names the "
               "topics";
      }
      entry.options.bag = path.string();
      entry.options.config_file = suite.config_file;
    } else {
      entry.options.asl = path.string();
    }
    list->cases.push_back(entry);
  }
  if (found == 0) {
    return "--euroc: none of EuRoC's sequences is in " + suite.euroc + " (looked for " +
           kEurocNames[0] + "/mav0, " + kEurocNames[0] +
           ".bag and so on, there and two folders deep)";
  }
  if (!missing.empty()) list->notes.push_back("--euroc: not found: " + missing);
  return "";
}

/// The ablation of those cases that have one.
void addAblations(const AbOptions& suite, Suite* list) {
  const std::string methods = methodsWithVariants(suite);
  if (methods.empty()) {
    list->notes.emplace_back("no ablation: none of the methods has variants");
    return;
  }
  std::vector<SuiteCase> ablations;
  for (const SuiteCase& entry : list->cases) {
    const auto* motion = std::find_if(
        std::begin(kMotions), std::end(kMotions),
        [&](const Motion& m) { return entry.kind == CaseKind::kBuiltin && entry.name == m.name; });
    if (motion != std::end(kMotions) && !motion->ablation) continue;
    SuiteCase ablation = entry;
    ablation.ablation = true;
    ablation.options.ablation = true;
    ablation.options.methods = methods;
    // Of a variant it is the answer that counts.
    ablation.options.downstream_s = 0.0;
    ablation.options.downstream_every = 1;
    ablation.options.plots = "off";
    ablations.push_back(ablation);
  }
  list->cases.insert(list->cases.end(), ablations.begin(), ablations.end());
}

}  // namespace

std::string SuiteCase::folder() const {
  const std::string prefix = ablation ? "ablation/" : "";
  switch (kind) {
    case CaseKind::kImages: return prefix + "images/" + name;
    case CaseKind::kRecorded: return prefix + "recorded/" + name;
    case CaseKind::kBuiltin: break;
  }
  return prefix + "simulated/" + name;
}

bool SuiteCase::degenerate() const { return group == kDegenerate; }

bool SuiteCase::withoutParallax() const { return group == kNoParallax; }

std::string SuiteCase::feature() const {
  if (kind == CaseKind::kImages) return "tracked through its images";
  return options.world + ", " + std::to_string(options.features.max_points) + " points, " +
         std::to_string(options.features.max_lines) + " lines";
}

std::string checkSuiteOptions(const AbOptions& options) {
  if (options.suite != "paper") return "--suite is '" + options.suite + "', must be paper";
  for (const std::string& name : options.given) {
    if (suiteOptionNames().count(name) == 0) {
      return "--" + name + " does not go with --suite, whose cases bring their own";
    }
  }
  const auto typed = [&options](const char* name) { return options.given.count(name) > 0; };
  for (const auto& [name, value] :
       {std::make_pair("recorded", options.recorded), std::make_pair("euroc", options.euroc),
        std::make_pair("out", options.out), std::make_pair("config", options.config_file),
        std::make_pair("options", options.options_file)}) {
    if (typed(name) && value.empty()) return std::string("--") + name + " is empty";
  }
  if (typed("config") && !typed("euroc")) {
    return "--config is, with --suite, for the bags of --euroc only";
  }
  if (typed("downstream-every") && !(options.downstream_s > 0.0)) {
    return "--downstream-every has no effect without --downstream";
  }
  return "";
}

std::string listSuiteCases(const AbOptions& options, Suite* suite) {
  *suite = Suite();
  if (!options.euroc.empty()) {
    if (std::string sentence = addEuroc(options, suite); !sentence.empty()) return sentence;
  }
  if (!options.recorded.empty()) {
    if (std::string sentence = addRecorded(options, suite); !sentence.empty()) return sentence;
  }
  addBuiltin(options, suite);
  addAblations(options, suite);
  for (SuiteCase& entry : suite->cases) {
    entry.options.out = (fs::path(options.out) / entry.folder()).string();
    entry.options.command = caseCommand(entry.options);
  }
  return "";
}

std::string caseCommand(const AbOptions& options) {
  AbOptions copy = options;  // the table binds to fields that can be written
  AbOptions fresh;
  std::vector<std::string> words = {"slim_init", "ab"};
  const std::vector<AbOption> table = abOptionTable(&copy);
  const std::vector<AbOption> defaults = abOptionTable(&fresh);
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (const auto* flag = std::get_if<bool*>(&table[i].field)) {
      if (**flag) words.push_back("--" + table[i].name);
    } else if (valueText(table[i]) != valueText(defaults[i])) {
      words.push_back("--" + table[i].name);
      words.push_back(valueText(table[i]));
    }
  }
  return shellLine(words);
}

}  // namespace slim_init::tools
