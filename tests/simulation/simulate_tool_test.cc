// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// `slim_init simulate` as a user runs it. Without POV-Ray only what needs no picture is tested, and
// the rest skipped with a line that says so.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "simulation/needs_povray.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/recorded.h"
#include "slim_init/options.h"
#include "slim_init/simulation/trajectory.h"
#include "tools/run_program.h"

namespace slim_init {
namespace {

const std::string kSmall = "simulate --scene room --rate 10 --image-scale 0.2 ";
/// A short, small sequence; more arguments and the folder follow.
const std::string kSmallCircle = kSmall + "--builtin circle --duration 0.6 ";

/// What the program has written there.
std::unique_ptr<evaluation::ImageSequence> opened(const std::string& path) {
  evaluation::ReadStatus status;
  auto sequence = evaluation::openAslFolder(path, WindowOptions().max_imu_gap_s, &status);
  if (sequence == nullptr) throw std::runtime_error(status.message);
  return sequence;
}

/// Its camera and calibration.
Config configured(const std::string& path) {
  Config config;
  std::string error;
  EXPECT_TRUE(loadSensorFiles(path, &config, &error)) << error;
  return config;
}

using Simulate = ProgramTest;

TEST_F(Simulate, WritesASequenceThatIsReadBack) {
  NEEDS_POVRAY();
  const ProgramRun run = succeeds(kSmallCircle + "--out @seq");
  EXPECT_EQ(run.err, "");  // no progress bar in a pipe
  expectParts(run.out, "7 images of 150x96");

  const auto sequence = opened(folder.file("seq"));
  ASSERT_EQ(sequence->images(), 7u);
  const Config config = configured(folder.file("seq"));
  const auto& camera = config.camera;
  EXPECT_EQ(camera.width, 150);
  EXPECT_NEAR(camera.fx, 0.2 * 458.654, 1e-9);
  EXPECT_NEAR(camera.distortion[0], -0.28340811, 1e-12);
  // 200 Hz and 0.1 s before and after the images.
  EXPECT_NEAR(static_cast<double>(sequence->imu.size()), 200 * 0.8, 2.0);
  EXPECT_LE(sequence->imu.front().t, sequence->image_times[0]);
  EXPECT_GE(sequence->imu.back().t, sequence->image_times[6]);
  EXPECT_TRUE(sequence->has_velocity_and_bias);
  // The truth is the motion.
  std::string error;
  const auto motion =
      simulation::makeBuiltinTrajectory("circle", 5.0, config.calibration.R_b_c, 1, &error);
  ASSERT_NE(motion, nullptr) << error;
  constexpr std::int64_t kStart = 1400000000000000000;
  for (const NavState& state : sequence->truth) {
    const double t = 1e-9 * static_cast<double>(sequence->t0_ns - kStart) + state.t;
    EXPECT_LT((state.p_w_b - motion->at(t).p_w_b).norm(), 1e-6);
    EXPECT_LT((state.R_w_b - motion->at(t).R_w_b).norm(), 1e-6);
  }
  // Pictures of a room, neither black nor white nor the same.
  cv::Mat before;
  for (std::size_t k = 0; k < sequence->images(); ++k) {
    const cv::Mat image = sequence->image(k, &error);
    ASSERT_EQ(image.type(), CV_8UC1) << error;
    ASSERT_EQ(image.cols, 150);
    cv::Scalar mean, deviation;
    cv::meanStdDev(image, mean, deviation);
    EXPECT_GT(mean[0], 40.0);
    EXPECT_LT(mean[0], 200.0);
    EXPECT_GT(deviation[0], 10.0);
    if (k > 0) {
      EXPECT_GT(cv::norm(image, before, cv::NORM_INF), 0.0);
    }
    before = image;
  }
  // Nothing of the renderer stays.
  const std::filesystem::directory_iterator entries(folder.file("seq"));
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1);
  // The same again gives the same bytes; into a folder that has images it does not write.
  succeeds(kSmallCircle + "--threads 2 --out @again");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.file("seq"))) {
    if (!entry.is_regular_file()) continue;
    const auto name = std::filesystem::relative(entry.path(), folder.file("seq"));
    EXPECT_EQ(readFile(entry.path().string()), readFile((folder.file("again") / name).string()))
        << name;
  }
  expectRefused(kSmallCircle + "--out @seq", "--out");
}

// The middle row sees what a global shutter sees, the first and the last one do not; the folder
// says so, and what reads it knows.
TEST_F(Simulate, ARollingShutterIsDrawnRowByRow) {
  NEEDS_POVRAY();
  const auto simulate = [&](const std::string& name, const std::string& more) {
    succeeds(kSmall + "--read-noise 0 --shot-noise 0 --duration 0.2 --builtin figure-eight " +
             more + " --out @" + name);
    return opened(folder.file(name));
  };
  const auto global = simulate("global", "");
  const auto rolling = simulate("rolling", "--readout 0.08");
  EXPECT_EQ(configured(folder.file("global")).calibration.readout_s, 0.0);
  EXPECT_EQ(configured(folder.file("rolling")).calibration.readout_s, 0.08);
  ASSERT_EQ(global->images(), rolling->images());
  std::string error;
  const cv::Mat at_once = global->image(1, &error), by_rows = rolling->image(1, &error);
  ASSERT_EQ(at_once.size(), by_rows.size());
  const auto difference = [&](int from, int to) {
    return cv::norm(at_once.rowRange(from, to), by_rows.rowRange(from, to), cv::NORM_L1) /
           ((to - from) * at_once.cols);
  };
  const int rows = at_once.rows;
  EXPECT_LT(difference(rows / 2 - 3, rows / 2 + 3), 0.5 * difference(0, 6));
  EXPECT_LT(difference(rows / 2 - 3, rows / 2 + 3), 0.5 * difference(rows - 6, rows));
  EXPECT_EQ(cv::norm(global->image(0, &error), simulate("again", "")->image(0, &error)), 0.0);
}

TEST_F(Simulate, MotionBlurAveragesOverTheExposure) {
  NEEDS_POVRAY();
  const std::string clean = kSmallCircle + "--read-noise 0 --shot-noise 0 --out @";
  succeeds(clean + "sharp");
  succeeds(clean + "blurred --motion-blur 50");
  const auto energy = [this](const char* name) {
    const auto sequence = opened(folder.file(name));
    double sum = 0.0;
    for (std::size_t k = 0; k < sequence->images(); ++k) {
      cv::Mat image;
      sequence->image(k, nullptr).convertTo(image, CV_32F);
      sum += cv::norm(image.colRange(1, image.cols), image.colRange(0, image.cols - 1),
                      cv::NORM_L2SQR);
    }
    return sum;
  };
  EXPECT_LT(energy("blurred"), 0.9 * energy("sharp"));
}

TEST_F(Simulate, RecordingKeepsItsImuAndImageTimes) {
  NEEDS_POVRAY();
  const std::string data = SLIM_INIT_SHARED_DATA;
  // The EuRoC recordings are not part of the repository (their licence is not ours).
  if (!std::filesystem::is_directory(data)) GTEST_SKIP() << "no recordings at " << data;
  const ProgramRun run = succeeds("simulate --scene hall --start 30 --duration 0.3 --out @seq " +
                                  ("--image-scale 0.15 --recorded " + data) + "/MH_04");
  expectParts(run.err, "slim_init: note: ");
  evaluation::RecordedMotion recorded;
  ASSERT_TRUE(
      evaluation::readRecordedMotion(data + "/MH_04", WindowOptions().max_imu_gap_s, &recorded)
          .ok());
  const auto sequence = opened(folder.file("seq"));
  EXPECT_GE(sequence->images(), 6u);
  const double shift = 1e-9 * static_cast<double>(sequence->t0_ns - recorded.t0_ns);
  for (std::size_t k = 0; k < sequence->images(); ++k) {
    const double t = sequence->image_times[k] + shift;
    EXPECT_TRUE(std::any_of(recorded.image_times.begin(), recorded.image_times.end(),
                            [t](double r) { return std::abs(r - t) < 1e-8; }))
        << t;
  }
  const auto first = std::find_if(recorded.imu.begin(), recorded.imu.end(),
                                  [&](const auto& s) { return std::abs(s.t - shift) < 1e-8; });
  ASSERT_NE(first, recorded.imu.end());
  for (std::size_t i = 0; i < sequence->imu.size(); ++i) {
    EXPECT_EQ(sequence->imu[i].gyro, (first + static_cast<std::ptrdiff_t>(i))->gyro);
    EXPECT_EQ(sequence->imu[i].accel, (first + static_cast<std::ptrdiff_t>(i))->accel);
  }
}

TEST_F(Simulate, PosesFromAFile) {
  NEEDS_POVRAY();
  std::ostringstream csv;
  csv << "#timestamp [ns],p_x,p_y,p_z,q_w,q_x,q_y,q_z\n";
  for (int k = 0; k <= 40; ++k) {
    // Camera ahead along x for EuRoC's extrinsic (upright body: x up).
    csv << 1500000000000000000 + 50000000LL * k << "," << 0.1 * k
        << ",0,1.5,0,0.70710678,0,0.70710678\n";
  }
  folder.write("poses.csv", csv.str());
  std::string rig = readFile(SLIM_INIT_SOURCE_DIR "/config/euroc.yaml");
  rig.replace(rig.find("\ntd: 0.0"), 8, "\ntd: 0.03");
  rig.replace(rig.find("9.81007"), 7, "9.79000");
  folder.write("rig.yaml", rig + matrixKey("\nspeed_rotation", 3, 3, "1, 0, 0, 0, 1, 0, 0, 0, 1") +
                               matrixKey("speed_translation", 3, 1, "0, 0, 0"));
  succeeds(
      "simulate --csv @poses.csv --scene corridor --duration 0.2 --image-scale 0.1 "
      "--config @rig.yaml --speed 0 --out @seq");
  const auto sequence = opened(folder.file("seq"));
  EXPECT_EQ(sequence->images(), 5u);
  for (const ImuSample& sample : sequence->imu) {
    EXPECT_LT(sample.gyro.norm(), 0.15);  // EuRoC's biases and noise
    EXPECT_NEAR(sample.accel.norm(), 9.79, 0.3);
  }
  // The folder has the rig.
  const Calibration calibration = configured(folder.file("seq")).calibration;
  EXPECT_EQ(calibration.td, 0.03);
  EXPECT_EQ(calibration.gravity_magnitude, 9.79);
  // The velocities are those of its sensor, whose x axis is the body's, up; at the images' time.
  EXPECT_NEAR(static_cast<double>(sequence->speeds.size()), 21.0, 1.0);
  for (const SpeedSample& sample : sequence->speeds) {
    EXPECT_LT(std::abs(sample.velocity.x()), 0.1);
  }
}

TEST_F(Simulate, BadInputIsASentence) {
  folder.write("bad.csv", "#t\n1500000000000000000,0,0,1.5,1,0,0\n");
  folder.write("word.csv", "1500000000000000000,0,0,one,1,0,0,0\n");
  folder.write("norm.csv", "1500000000000000000,0,0,1,2,0,0,0\n");
  const std::pair<const char*, const char*> commands[] = {
      // and what is said
      {"", "one of --csv FILE, --builtin NAME and --recorded DIR"},
      {"--builtin circle --csv x", "exclude each other"},
      {"--builtin moonwalk", "--builtin is 'moonwalk'|corridor-walk"},
      {"--builtin circle --scene moon", "--scene is 'moon'|brick-room"},
      {"--builtin circle --image-scale 9", "--image-scale: '9'|[0.05, 4]"},
      {"--builtin circle --sceen room", "--sceen"},
      {"--builtin circle --rate 2 --duration 0.3 --povray sh", "--duration 0.3 and --rate leave 1"},
      {"--builtin circle --povray no-such-renderer", "'no-such-renderer'|package povray"},
      {"--recorded @none --povray sh", "none is not a directory"},
      {"--builtin circle --config @none.yaml --povray sh", "--config: |none.yaml"},
      {"--csv @bad.csv --povray sh", "bad.csv line 2|7 columns"},
      {"--csv @word.csv --povray sh", "word.csv line 1|column 4 (p_z): 'one'"},
      {"--csv @norm.csv --povray sh", "norm is 2"},
  };
  for (const auto& [line, said] : commands) {
    expectRefused(std::string("simulate --out @out ") + line, said);
    EXPECT_FALSE(std::filesystem::exists(folder.file("out"))) << line;
  }
}

TEST_F(Simulate, FailingRendererIsReportedWithItsLastLines) {
  folder.write("broken", "#!/bin/sh\necho Fatal error in parser\nexit 9\n");
  std::filesystem::permissions(folder.file("broken"), std::filesystem::perms::owner_all);
  const std::string line = kSmallCircle + "--povray @broken --out @";
  const ProgramRun run = typed(line + "out");
  EXPECT_EQ(run.exit_code, 1);
  expectParts(run.err, "exit code 9 at frame 1 of 7|Fatal error in parser");
  // One that draws does not outlive the program.
  folder.write("broken", "#!/bin/sh\necho $$ > " + folder.file("pid") + "\nexec sleep 20\n");
  auto arguments = words(folder, line + "none");
  arguments.insert(arguments.begin(), {"-s", "KILL", "2", SLIM_INIT_PROGRAM});
  runProgram(folder, arguments, "timeout");
  usleep(500000);
  const int pid = std::stoi(readFile(folder.file("pid")));
  EXPECT_EQ(readFile("/proc/" + std::to_string(pid) + "/cmdline"), "");
}

}  // namespace
}  // namespace slim_init
