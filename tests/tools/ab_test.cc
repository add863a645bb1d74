// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init ab` as a user runs it: the real program, its exit code and what it says.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "tools/ab_runs.h"

namespace slim_init {
namespace {

// What is typed after `slim_init` (two quotes: an empty word), and the parts of the sentence that
// it gets for it, with | between them.
struct BadCommand {
  const char* name;
  const char* typed;
  const char* said;
};

const BadCommand kBadCommands[] = {
    {"NoSubcommand", "", "a subcommand is needed"},
    {"UnknownSubcommand", "fly", "fly"},
    {"NoSource", "ab", "one of --asl DIR, --bag FILE, --recorded DIR and --builtin NAME is needed"},
    {"TwoSources", "ab --builtin circle --recorded x", "exclude each other"},
    {"UnknownMotion", "ab --builtin moonwalk", "--builtin is 'moonwalk'|circle"},
    {"UnknownWorld", "ab --builtin circle --world moon", "--world is 'moon'|room, hall, corridor"},
    {"UnknownMethod", "ab --builtin circle --methods drt-l,magic", "'magic'|must be one of|drt-l"},
    {"EmptyMethod", "ab --builtin circle --methods drt-l,", "--methods names ''"},
    {"MethodTwice", "ab --builtin circle --methods drt-l,drt-l", "twice"},
    {"UnknownGates", "ab --builtin circle --gates ajar", "--gates is 'ajar'|own, on, off"},
    {"UnknownOption", "ab --builtin circle --fast", "--fast"},
    {"Abbreviated", "ab --builtin circle --str 5", "'--str'|--help"},
    {"UnknownLetter", "ab --builtin circle -x", "'-x'"},
    {"UnknownProgramOption", "--verbose ab", "'--verbose'|--help"},
    {"Repeated", "ab --builtin circle --seed 1 --seed=2", "'--seed'|more than once"},
    {"RepeatedSwitch", "ab --builtin circle --quiet --quiet", "'--quiet'|more than once"},
    {"SwitchWithValue", "ab --builtin circle --quiet=no", "'--quiet'|does not take"},
    {"ExtraPositional", "ab --builtin circle more", "more"},
    {"ExtraAfterDashes", "ab --builtin circle -- more", "'more'"},
    {"ExtraForMethods", "methods more", "'more'|slim_init methods"},
    {"ExtraAfterVersion", "--version more", "'more'"},
    {"MissingValue", "ab --builtin", "--builtin"},
    {"MissingValueAfterEquals", "ab --builtin circle --stride=", "'--stride'"},
    {"OptionWhereAValueBelongs", "ab --world --builtin circle",
     "--world needs a value|'--builtin'"},
    {"EmptyNumber", "ab --builtin circle --stride ''", "--stride|''"},
    {"EmptyOptions", "ab --builtin circle --options ''", "--options is empty, must be FILE"},
    {"StrideZero", "ab --builtin circle --stride 0", "--stride|'0'|[1, "},
    {"StrideText", "ab --builtin circle --stride abc", "--stride|'abc'"},
    {"StrideFraction", "ab --builtin circle --stride 1.5", "--stride|'1.5'"},
    {"ThreadsZero", "ab --builtin circle --threads 0", "--threads|'0'|[1, 256]"},
    {"KeyframesLow", "ab --builtin circle --keyframes 3", "'3'|[4, 15]"},
    {"KeyframesHigh", "ab --builtin circle --keyframes 16", "'16'|[4, 15]"},
    {"PointsHigh", "ab --builtin circle --points 2001", "[0, 2000]"},
    {"LinesNegative", "ab --builtin circle --lines -1", "'-1'|[0, 500]"},
    {"NoiseNan", "ab --builtin circle --pixel-noise nan", "--pixel-noise|'nan'|[0, 10]"},
    {"SeedNegative", "ab --builtin circle --seed -1", "--seed|'-1'"},
    {"SeedOverflow", "ab --builtin circle --seed 99999999999999999999", "--seed"},
    {"DurationShort", "ab --builtin circle --duration 2.9", "[3, 3600]"},
    {"DurationInfinite", "ab --builtin circle --duration inf", "--duration"},
    {"OutliersAboveOne", "ab --builtin circle --outliers 1.01", "[0, 1]"},
    {"TdErrorHigh", "ab --builtin circle --td-error 0.6",
     "--td-error: '0.6' is not a number in [-0.5, 0.5]"},
    {"ExtrinsicErrorNegative", "ab --builtin circle --extrinsic-error -1",
     "--extrinsic-error: '-1' is not a number in [0, 180]"},
    {"RandomRigOfNothing", "ab --builtin circle --random-rig",
     "--random-rig has no effect without --td-error or --extrinsic-error"},
    {"ReadoutHigh", "ab --builtin circle --readout 0.2",
     "--readout: '0.2' is not a number in [0, 0.1]"},
    {"ReadoutErrorOfAGlobalShutter", "ab --builtin circle --readout-error 0.005",
     "circle: the camera has a global shutter|cannot be incorrect"},
    {"ReadoutErrorTooLarge", "ab --builtin circle --readout 0.01 --readout-error -0.02",
     "readout_s is -0.02, must be at least -0.01"},
    {"ImuRateOfGaps", "ab --builtin circle --imu-rate 20",
     "--imu-rate: '20' is not a number in [25, 10000]"},
    {"ImuRateAboveTheData", "ab --builtin circle --imu-rate 400",
     "--imu-rate is 400, must be at most 200"},
    {"ImuJitterHigh", "ab --builtin circle --imu-jitter 0.1",
     "--imu-jitter: '0.1' is not a number in [0, 0.05]"},
    {"ImuDropoutHigh", "ab --builtin circle --imu-dropout 1",
     "--imu-dropout: '1' is not a number in [0, 0.9]"},
    {"ReportMode", "ab --builtin circle --report 3d", "--report is '3d'"},
    {"KeyframesShrink", "ab --builtin circle --keyframes 9..4", "'9..4' must expand"},
    {"KeyframesHalf", "ab --builtin circle --keyframes 4..", "''|[4, 15]"},
    {"GrowingWithoutGates", "ab --builtin circle --keyframes 4..9 --gates off",
     "--gates off: no method would wait"},
    {"SimulationOfImages", "ab --asl x --world room", "--world has no effect with --asl"},
    {"DurationOfARecording", "ab --recorded x --duration 5",
     "--duration has no effect with --recorded"},
    {"SeedOfImages", "ab --bag x --seed 2", "--seed has no effect with --bag"},
    {"BagWithoutConfig", "ab --bag x.bag", "--bag needs --config"},
    {"EmptyConfig", "ab --builtin circle --config ''", "--config is empty, must be YAML"},
    {"NoFolder", "ab --recorded no/such/folder", "no/such/folder is not a directory"},
    {"NoWindow", "ab --builtin circle --duration 3 --keyframes 15 --quiet",
     "holds no window of 15 keyframes"},
};

class AbBadInput : public ProgramTest, public ::testing::WithParamInterface<BadCommand> {};

TEST_P(AbBadInput, ExitsWithTwoAndASentence) {
  std::string line = GetParam().typed;
  // Should the input be taken for good, it must not write into the working directory.
  if (words(folder, line).size() > 2) line.insert(line.find(' '), " --out @out");
  expectRefused(line, GetParam().said);
}

INSTANTIATE_TEST_SUITE_P(All, AbBadInput, ::testing::ValuesIn(kBadCommands),
                         [](const auto& instance) { return std::string(instance.param.name); });

using Program = ProgramTest;

TEST_F(Program, HelpVersionAndMethodsExitWithZero) {
  const auto answers = [this](const char* line, const char* said) {
    const ProgramRun run = succeeds(line);
    expectParts(run.out, said);
    return run;
  };
  answers("--help", "ab");
  answers("ab --help",
          "--recorded DIR|--builtin NAME|--duration X (=60)|[s]; 3 to 3600|--world NAME (=room)|"
          "--methods LIST|--options FILE|--gates MODE|--seed N (=1)|--stride N (=10)|"
          "--keyframes N|--asl DIR|--bag FILE|--config YAML|"
          "--ablation|--report MODE (=auto)|--limit N (=0)|"
          "--points N (=100)|--lines N (=25)|--pixel-noise X (=0.6)|"
          "[px]; 0 to 10|--drift X (=0)|--outliers X (=0)|"
          "--td-error S (=0)|"
          "--extrinsic-error DEG (=0)|--random-rig|--readout S (=0)|--readout-error S (=0)|"
          "--imu-rate HZ|--imu-jitter S (=0)|--imu-dropout X (=0)|--out DIR (=out/ab)|--quiet");
  // Asked for help, we do not argue about the rest.
  answers("ab --nonsense --help", "--td-error");
  EXPECT_EQ(answers("--version", "slim_init ").out.rfind("slim_init ", 0), 0u);
  EXPECT_EQ(answers("methods", "drt-l").err, "");
  expectRefused("options --keys user --update @none", "--keys has no effect with --update");
}

using Ab = AbRuns;

TEST_F(Ab, BuiltinRunWritesItsData) {
  const std::string out = folder.file("out");
  const ProgramRun run =
      ran("--builtin figure-eight --duration 8 --seed 3 --methods drt-l --outliers 0.01");
  EXPECT_EQ(run.err, "");  // no progress bar in a pipe
  EXPECT_FALSE(contains(run.out, "\r"));
  expectParts(run.out, "drt-l");
  expectParts(run.out, "Data: " + out + "/summary.json");

  const auto json = summaryOf();
  EXPECT_EQ(json["dataset"], "figure-eight");
  EXPECT_EQ(json["gyro_bias_truth"], "simulated");
  EXPECT_EQ(json["options"]["seed"], 3);
  EXPECT_GT(json["simulated"]["outlier_tracks"].get<int>(), 0);
  EXPECT_GT(json["simulated"]["point_tracks"].get<int>(), 100);
  expectParts(typed("--version").out, json["version"]);
  EXPECT_TRUE(json.contains("commit"));
  EXPECT_TRUE(contains(json["command"].get<std::string>(), "--builtin figure-eight"));
  const auto& all = json["methods"]["drt-l"]["all"];
  // 8 s at 20 Hz: frames 0 to 160, windows of 45 frame intervals start at 0, 10, .. 110.
  EXPECT_EQ(all["windows"], 12);
  EXPECT_GE(all["success_rate"].get<double>(), 0.5);
  EXPECT_FALSE(std::filesystem::exists(out + "/report.md"));  // --report off
}

TEST_F(Ab, EqualSeedsGiveEqualWindows) {
  const auto windows = [this](const std::string& seed_and_threads) {
    const ProgramRun run =
        ran("--builtin circle --duration 6 --outliers 0.05 --quiet " + seed_and_threads);
    EXPECT_EQ(run.out, "");
    return withoutTimes(readFile(folder.file("out/windows.csv")));
  };
  const std::string first = windows("--seed 5");
  EXPECT_GT(first.size(), 1000u);
  EXPECT_EQ(first, windows("--seed 5"));
  EXPECT_NE(first, windows("--seed 6"));
  // Every method of the program, at the same time as itself and as every other.
  EXPECT_EQ(first, windows("--seed 5 --threads 8"));
}

// What is measured without a choice is what a host runs.
TEST_F(Ab, WindowsGrowByDefaultAndEveryMethodHasGates) {
  // A file without a key for the window changes nothing.
  std::ofstream(folder.file("o.yaml")) << "%YAML:1.0\nslim_init:\n  gates: {min_excitation: 0.1}\n";
  const ProgramRun run =
      ran("--builtin figure-eight --duration 5 --methods drt-l --options @o.yaml");
  expectParts(run.out, "First estimates, solved at every image");
  const auto json = summaryOf();
  EXPECT_EQ(json["options"]["keyframes"], "5..15");
  EXPECT_EQ(json["options"]["interval_s"], 0.09);
  EXPECT_EQ(json["options"]["span_s"], 3.0);
  EXPECT_EQ(json["options"]["gates"], "on");
}

TEST_F(Ab, GrowingWindowsTellTheTimeToAccept) {
  const auto json = summary(
      "--builtin figure-eight --duration 8 --methods drt-l --gates on --keyframes 4..10 --quiet");
  EXPECT_EQ(json["options"]["keyframes"], "4..10");
  EXPECT_EQ(json["first_keyframes"], 4);
  const auto& all = json["methods"]["drt-l"]["all"];
  EXPECT_EQ(json["options"]["span_s"], 3.0);
  EXPECT_EQ(all["windows"], 11);  // of 3 s
  ASSERT_GT(all["accepted"].get<int>(), 0);
  EXPECT_GE(all["accept_s_median"].get<double>(), 0.3);
  EXPECT_LT(all["accept_s_median"].get<double>(), 3.0);
  EXPECT_GE(all["accept_s_p90"].get<double>(), all["accept_s_median"].get<double>());
}

// The errors of a rig reach the methods, the report says so, and the first errors are those typed.
TEST_F(Ab, RigErrorsReachTheMethods) {
  const auto run = [this](const std::string& name, const std::string& errors) {
    return summary("--builtin circle --duration 6 --methods drt-l,slim --gates off " + errors,
                   name);
  };
  const auto clean = run("clean", "");
  EXPECT_FALSE(clean["options"].contains("td_error_s"));
  const auto biasOf = [](const nlohmann::json& json, const char* method) {
    return json["methods"][method]["all"]["gyro_bias_err_pct"].get<double>();
  };
  const auto turned = run("turned", "--extrinsic-error 6");
  EXPECT_EQ(turned["options"]["extrinsic_error_deg"], 6.0);
  EXPECT_GT(biasOf(turned, "drt-l"), 2.0 * biasOf(clean, "drt-l"));
  const auto late = run("late", "--td-error 0.03");
  EXPECT_NE(biasOf(late, "drt-l"), biasOf(clean, "drt-l"));
  EXPECT_TRUE(contains(readFile(folder.file("late/windows.csv")), ",-30,0,0,drt-l,"));
  const auto random = run("random", "--td-error 0.03 --random-rig");
  EXPECT_EQ(random["options"]["random_rig"], 1);
  EXPECT_FALSE(contains(readFile(folder.file("random/windows.csv")), ",-30,0,0,drt-l,"));
  const auto slow = run("slow", "--imu-rate 100 --imu-jitter 0.002 --imu-dropout 0.01");
  EXPECT_NE(biasOf(slow, "drt-l"), biasOf(clean, "drt-l"));
  EXPECT_GE(slow["methods"]["slim"]["all"]["success_rate"].get<double>(), 0.9);
}

TEST_F(Ab, AblationRunsVariantsBesideTheirMethod) {
  const auto json =
      summary("--builtin circle --duration 4 --methods slim-paper --ablation --quiet");
  for (const char* name : {"slim-paper", "slim-paper[no-vp]", "slim-paper[no-line-epipolar]",
                           "slim-paper[no-line-normal]", "slim-paper[points-only]"}) {
    ASSERT_TRUE(json["methods"].contains(name)) << name;
    EXPECT_EQ(json["methods"][name]["all"]["windows"], 4) << name;
  }
  EXPECT_NE(json["methods"]["slim-paper"]["all"]["scale_rmse"],
            json["methods"]["slim-paper[points-only]"]["all"]["scale_rmse"]);
  EXPECT_TRUE(contains(json["method_notes"]["slim-paper[no-vp]"].get<std::string>(), "without"));
  EXPECT_FALSE(json["method_notes"].contains("slim-paper"));
}

TEST_F(Ab, AblationOfSlimChangesOneThingAtATime) {
  const auto methods =
      summary("--builtin circle --duration 4 --methods slim --ablation --quiet")["methods"];
  for (const char* name : {"points-only", "no-lines", "no-vp", "no-accel-bias", "no-refinement"}) {
    const std::string variant = std::string("slim[") + name + "]";
    ASSERT_TRUE(methods.contains(variant)) << variant;
    EXPECT_GT(methods[variant]["all"]["attempted"].get<int>(), 0) << variant;
    EXPECT_NE(methods[variant]["all"]["gyro_bias_err_pct"],
              methods["slim"]["all"]["gyro_bias_err_pct"])
        << variant;
  }
}

/// With a folder in which the first python3 of the path is this script.
ProgramRun runWithPython(const ScratchFolder& folder, const std::string& script,
                         const std::vector<std::string>& arguments) {
  std::filesystem::create_directories(folder.file("bin"));
  folder.write("bin/python3", script);
  std::filesystem::permissions(folder.file("bin/python3"), std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (folder.file("bin") + ":" + path).c_str(), 1);
  const ProgramRun run = runProgram(folder, arguments);
  setenv("PATH", path.c_str(), 1);
  return run;
}

/// Notes its arguments in called.txt and exits with `code`; asked for its modules with 0.
std::string pythonThatExits(const ScratchFolder& folder, int code) {
  return "#!/bin/sh\necho \"$PYTHONSAFEPATH $PYTHONPATH $*\" >> \"" + folder.file("called.txt") +
         "\"\ncase \"$2\" in -c) exit 0;; esac\necho a report; exit " + std::to_string(code) + "\n";
}

// A short run whose report is in `mode`, with a python3 that exits with `code`.
ProgramRun runWithReport(const ScratchFolder& folder, const std::string& mode, int code) {
  return runWithPython(folder, pythonThatExits(folder, code),
                       {"ab", "--builtin", "circle", "--duration", "4", "--methods", "drt-l",
                        "--out", folder.file("out"), "--report", mode});
}

using AbReport = Ab;

TEST_F(AbReport, IsWrittenByThePythonPackageBesideTheProgram) {
  const ProgramRun run = runWithReport(folder, "auto", 0);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_TRUE(contains(run.out, "\nReport: " + folder.file("out/report.md"))) << run.out;
  EXPECT_FALSE(contains(run.out, "a report")) << run.out;
  expectParts(readFile(folder.file("called.txt")),
              "1 |share/slim_init/python|-m slim_init_report -- " + folder.file("out") + "\n");
}

TEST_F(AbReport, OneThatFailsExitsWithOneAndKeepsTheData) {
  const ProgramRun run = runWithReport(folder, "auto", 1);
  EXPECT_EQ(run.exit_code, 1);
  expectParts(run.err, "the report in " + folder.file("out") + " could not be written");
  EXPECT_TRUE(std::filesystem::exists(folder.file("out/windows.csv")));
}

TEST_F(AbReport, TheSubcommandHandsOnItsArgumentsAndTheExitCode) {
  const ProgramRun run =
      runWithPython(folder, pythonThatExits(folder, 2), {"report", "--suite", "a b", "--out", "c"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.out, "a report\n");
  const std::string called = readFile(folder.file("called.txt"));
  expectParts(called, "-m slim_init_report --suite a b --out c\n");
}

TEST_F(Ab, LeadingZerosAreDecimal) {
  const auto json = summary("--builtin circle --duration 5 --stride 020 --quiet", "deep/er");
  EXPECT_EQ(json["options"]["stride"], 20);
}

TEST_F(Ab, UnwritableReportExitsWithOne) {
  folder.write("file", "in the way");
  const ProgramRun run = typed("ab --builtin circle --duration 5 --out @file");
  EXPECT_EQ(run.exit_code, 1);
  expectParts(run.err, "--out: directory");
}

/// Short runs on the circle.
class AbOptionsFile : public Ab {
 protected:
  ProgramRun onCircle(const std::string& out, const std::string& line) const {
    return ran("--builtin circle --duration 6 --methods drt-l,slim-paper --quiet " + line, out);
  }
  /// The rows of one method in windows.csv, without times.
  std::string rowsOf(const std::string& out, const std::string& method) const {
    std::istringstream lines(withoutTimes(readFile(folder.file(out) + "/windows.csv")));
    std::string rows;
    for (std::string line; std::getline(lines, line);) {
      if (contains(line, "," + method + ",")) rows += line + "\n";
    }
    return rows;
  }
};

TEST_F(AbOptionsFile, AKeyChangesTheMethodsThatReadItOnly) {
  folder.write("none.yaml",
               "%YAML:1.0\nslim_init:\n  vanishing_point: {inlier_threshold_deg: 1.0}\n");
  folder.write("narrow.yaml",
               "%YAML:1.0\nslim_init:\n  vanishing_point: {inlier_threshold_deg: 0.2}\n");
  for (const auto& [out, options] :
       {std::pair("plain", ""), std::pair("none", "--options @none.yaml"),
        std::pair("narrow", "--options @narrow.yaml")}) {
    EXPECT_EQ(onCircle(out, std::string("--keyframes 10 ") + options).err, "");
  }
  EXPECT_GT(rowsOf("plain", "slim-paper").size(), 500u);
  // The defaults, written down, change nothing.
  EXPECT_EQ(rowsOf("plain", "slim-paper"), rowsOf("none", "slim-paper"));
  EXPECT_NE(rowsOf("plain", "slim-paper"), rowsOf("narrow", "slim-paper"));
  EXPECT_EQ(rowsOf("plain", "drt-l"), rowsOf("narrow", "drt-l"));

  EXPECT_EQ(summaryOf("plain")["options"].count("options"), 0u);
  const auto options = summaryOf("narrow")["options"];
  EXPECT_EQ(options["options"], folder.file("narrow.yaml"));
  EXPECT_EQ(options["slim_init.vanishing_point.inlier_threshold_deg"], 0.2);
  EXPECT_EQ(options["keyframes"], 10);
}

TEST_F(AbOptionsFile, TheCommandLineWins) {
  folder.write("file.yaml",
               "%YAML:1.0\nslim_init:\n  window: {keyframes: 8, min_keyframes: 6, max_span_s: 2}\n"
               "  gates: {mode: on}\n");
  onCircle("file", "--options @file.yaml");
  auto options = summaryOf("file")["options"];
  EXPECT_EQ(options["keyframes"], "6..8");
  EXPECT_EQ(options["span_s"], 2.0);
  EXPECT_EQ(options["gates"], "on");
  EXPECT_TRUE(contains(rowsOf("file", "drt-l"), ",8,"));
  // Also with the value that would be the default, and below the file's min_keyframes.
  onCircle("typed", "--options @file.yaml --keyframes 10 --gates own");
  onCircle("plain", "--keyframes 10");
  options = summaryOf("typed")["options"];
  EXPECT_EQ(options["keyframes"], 10);
  EXPECT_EQ(options["gates"], "own");
  EXPECT_EQ(rowsOf("typed", "drt-l"), rowsOf("plain", "drt-l"));
  onCircle("short", "--options @file.yaml --keyframes 5");
  EXPECT_EQ(summaryOf("short")["options"]["keyframes"], 5);
}

TEST_F(AbOptionsFile, AConfigurationBringsTheRig) {
  const std::string config = SLIM_INIT_SOURCE_DIR "/config/euroc.yaml";
  onCircle("config", "--keyframes 10 --config " + config);
  EXPECT_EQ(summaryOf("config")["options"]["config"], config);
  EXPECT_GT(rowsOf("config", "drt-l").size(), 500u);
  // A camera turned about its axis by a right angle sees other things.
  std::string text = readFile(config);
  const std::string rotation = "data: [ 0.0148655429818, -0.999880929698,   0.00414029679422,";
  ASSERT_TRUE(contains(text, rotation));
  text.replace(text.find(rotation), text.find(']', text.find(rotation)) - text.find(rotation),
               "data: [ 0., 0., 1., -1., 0., 0., 0., -1., 0.");
  folder.write("turned.yaml", text);
  onCircle("turned", "--keyframes 10 --config @turned.yaml");
  EXPECT_NE(rowsOf("config", "drt-l"), rowsOf("turned", "drt-l"));
  // In the middle of its image a MEI camera is a pinhole of half the length, if xi is one.
  const auto write = [&](const char* name, std::vector<std::pair<const char*, const char*>> swaps) {
    for (const auto& [from, to] : swaps) text.replace(text.find(from), std::strlen(from), to);
    folder.write("lens.yaml", text);
    onCircle(name, "--keyframes 10 --config @lens.yaml");
  };
  text = readFile(config) + "mirror_parameters: {xi: 1.0}\n";
  write("pinhole", {{"fx: 458.654", "fx: 450"}, {"fy: 457.296", "fy: 450"}});
  write("mei", {{"PINHOLE", "MEI"},
                {"fx: 450", "gamma1: 900"},
                {"fy: 450", "gamma2: 900"},
                {"cx: ", "u0: "},
                {"cy: ", "v0: "}});
  EXPECT_EQ(rowsOf("pinhole", "drt-l"), rowsOf("mei", "drt-l"));
  expectRefused("ab --builtin circle --config @no.yaml --out @out",
                "slim_init: " + folder.file("no.yaml"));
}

TEST_F(AbOptionsFile, KeysWithoutEffectAreNoted) {
  folder.write("file.yaml", "%YAML:1.0\nslim_init:\n  noise: {gyro_density: 0.001}\n");
  const ProgramRun run = onCircle("out", "--keyframes 10 --options @file.yaml");
  expectParts(run.err, "slim_init: note: |not used here: slim_init.noise.gyro_density (");
  const std::string notes = summaryOf("out")["notes"].dump();
  expectParts(notes, "slim_init.noise.gyro_density");
}

TEST_F(AbOptionsFile, BadFilesExitWithTwoAndASentence) {
  const auto refused = [&](const std::string& text, const std::string& parts) {
    if (!text.empty()) folder.write("file.yaml", text);
    expectRefused("ab --builtin circle --options @file.yaml --out @out",
                  "slim_init: --options: " + folder.file("file.yaml") + "|" + parts);
    EXPECT_FALSE(std::filesystem::exists(folder.file("out")));
  };
  refused("", "cannot be opened");
  refused("%YAML:1.0\nslim_init:\n  refinement: {use_linez: 0}\n",
          "slim_init.refinement.use_linez is not a known key|`slim_init options --keys all` lists "
          "them");
  // Good for an estimator, too long for the windows of this program.
  refused("%YAML:1.0\nslim_init:\n  window: {keyframes: 16}\n",
          "slim_init.window.keyframes is 16|[4, 15]");
  folder.write("off.yaml", "%YAML:1.0\nslim_init:\n  gates: {mode: off}\n");
  expectRefused("ab --builtin circle --options @off.yaml --out @out",
                "off.yaml: slim_init.gates.mode off: no method would wait");
}

/// A recording of a body that swings about, written with `gap_s` seconds of IMU left out at 2 s.
void writeRecording(const ScratchFolder& folder, double duration_s, double gap_s) {
  std::ostringstream imu;
  std::ostringstream images;
  std::ostringstream truth;
  for (std::ostringstream* file : {&imu, &images, &truth}) {
    *file << "#timestamp [ns]\n";
    file->precision(12);
  }
  const std::int64_t t0 = 1400000000000000000;
  for (int k = 0; k <= static_cast<int>(200.0 * duration_s); ++k) {
    const double t = k / 200.0;
    const std::int64_t stamp = t0 + 5000000LL * k;
    const double w = 2.0;
    // p = (1 - cos wt, 0, 0.5 (1 - cos wt)), no rotation.
    const double p = 1.0 - std::cos(w * t);
    const double a = w * w * std::cos(w * t);
    if (t < 2.0 || t >= 2.0 + gap_s) {
      imu << stamp << ",0.01,0.02,-0.03," << a << ",0," << 0.5 * a + 9.81007 << "\n";
    }
    if (k % 10 == 0) images << stamp << "\n";
    if (k % 4 == 0) truth << stamp << "," << p << ",0," << 0.5 * p << ",1,0,0,0\n";
  }
  folder.write("imu0.csv", imu.str());
  folder.write("cam0_timestamps.csv", images.str());
  folder.write("groundtruth.csv", truth.str());
}

TEST_F(Ab, RecordingWithPosesOnlyGetsAFittedBias) {
  writeRecording(folder, 8.0, 0.0);
  const ProgramRun run = ran("--recorded @ --methods drt-l");
  expectParts(run.err, "slim_init: note: |[0.01, 0.02, -0.03] rad/s");
  const auto json = summaryOf();
  EXPECT_EQ(json["gyro_bias_truth"], "fitted");
  EXPECT_GT(json["methods"]["drt-l"]["all"]["windows"].get<int>(), 5);
}

TEST_F(Ab, ImuGapIsNotedAndFatalOnlyWhenNoWindowIsLeft) {
  writeRecording(folder, 8.0, 0.3);
  const ProgramRun run = ran("--recorded @ --methods drt-l");
  expectParts(run.err, "imu0.csv has 1 IMU gap longer than 0.05 s");
  EXPECT_TRUE(contains(readFile(folder.file("out/summary.json")), "1 IMU gap longer"));

  writeRecording(folder, 4.2, 0.3);  // 2 s before the gap and 1.9 s after it: no window fits
  expectRefused(
      "ab --recorded @ --out @refused",
      "holds no window of 10 keyframes|1 IMU gap longer than 0.05 s, the longest 0.305 s");
  EXPECT_FALSE(std::filesystem::exists(folder.file("refused")));
}

TEST_F(Ab, ImagesOutsideImuDataAndGroundTruthAreDiscarded) {
  writeRecording(folder, 8.0, 0.0);
  const std::string truth = readFile(folder.file("groundtruth.csv"));
  folder.write("groundtruth.csv", truth.substr(truth.find("1400000001000000000")));  // from 1 s on
  expectParts(ran("--recorded @ --methods drt-l").err, "20 of 161 images lie outside");
  folder.write("groundtruth.csv", truth);
  folder.write("cam0_timestamps.csv",
               readFile(folder.file("cam0_timestamps.csv")) + "1500000000000000000\n");
  expectParts(ran("--recorded @ --methods drt-l").err,
              "1 of 162 images lie outside the IMU data or the ground truth");
  folder.write("cam0_timestamps.csv", "1500000000000000000\n1500000000000000001\n");
  expectRefused("ab --recorded @ --out @out",
                "none of 2 images lies within IMU data and ground truth");
}

class AbOfRecordings : public Ab {
 protected:
  void SetUp() override {
    // The EuRoC recordings are not part of the repository (their licence is not ours); CI has them.
    if (!std::filesystem::is_directory(data)) GTEST_SKIP() << "no recordings at " << data;
  }
  const std::string data = SLIM_INIT_SHARED_DATA;
};

TEST_F(AbOfRecordings, OneRuns) {
  const ProgramRun run = ran("--recorded " + data + "/MH_04 --world hall --limit 20");
  expectParts(run.err, "57 of 2033 images");
  const auto json = summaryOf();
  EXPECT_EQ(json["dataset"], "MH_04");
  EXPECT_EQ(json["gyro_bias_truth"], "recorded");
  EXPECT_EQ(json["methods"]["drt-l"]["all"]["windows"], 20);
}

}  // namespace
}  // namespace slim_init
