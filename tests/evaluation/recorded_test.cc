// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/recorded.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "evaluation/scratch_folder.h"
#include "slim_init/options.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

constexpr std::int64_t kT0Ns = 1403715523912143104;  // beyond what a double holds to the nanosecond

/// A small, correct recording: 1 s of IMU at 100 Hz, truth at 20 Hz, five images.
struct Files {
  std::vector<std::string> imu = {"#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z"};
  std::vector<std::string> images = {"#timestamp [ns]"};
  std::vector<std::string> truth = {"#timestamp [ns],p_x,p_y,p_z,q_w,q_x,q_y,q_z"};
  std::string line_end = "\n";
  bool last_line_ends = true;

  Files() {
    for (int i = 0; i <= 100; ++i) {
      imu.push_back(std::to_string(kT0Ns + 10000000LL * i) + ",0.1,-0.2,0.3,9.8,0.01,-3e-1");
    }
    for (int i = 0; i <= 20; ++i) {
      truth.push_back(std::to_string(kT0Ns + 50000000LL * i) + ",1,2,3,1,0,0,0");
    }
    for (int i = 0; i < 5; ++i) images.push_back(std::to_string(kT0Ns + 1 + 200000000LL * i));
  }

  std::string text(const std::vector<std::string>& lines) const {
    std::string all;
    for (const std::string& line : lines) all += line + line_end;
    if (!last_line_ends) all.resize(all.size() - line_end.size());
    return all;
  }

  void write(const ScratchFolder& folder) const {
    folder.write("imu0.csv", text(imu));
    folder.write("cam0_timestamps.csv", text(images));
    folder.write("groundtruth.csv", text(truth));
  }
};

ReadStatus readFiles(const Files& files, RecordedMotion* motion) {
  const ScratchFolder folder;
  files.write(folder);
  return readRecordedMotion(folder.path(), WindowOptions().max_imu_gap_s, motion);
}

/// What good files are read as.
RecordedMotion motionOf(const Files& files) {
  RecordedMotion motion;
  const ReadStatus status = readFiles(files, &motion);
  if (!status.ok()) throw std::runtime_error(status.message);
  return motion;
}

TEST(RecordedMotion, ReadsPosesAndKeepsNanoseconds) {
  const RecordedMotion motion = motionOf(Files());
  EXPECT_EQ(motion.t0_ns, kT0Ns);
  ASSERT_EQ(motion.imu.size(), 101u);
  EXPECT_EQ(motion.imu.front().t, 0.0);
  EXPECT_DOUBLE_EQ(motion.imu[1].t, 0.01);
  EXPECT_EQ(motion.imu[7].gyro, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(motion.imu[7].accel, Eigen::Vector3d(9.8, 0.01, -0.3));
  ASSERT_EQ(motion.image_times.size(), 5u);
  // One nanosecond would vanish in a double of the absolute stamp.
  EXPECT_DOUBLE_EQ(motion.image_times[0], 1e-9);
  ASSERT_EQ(motion.truth.size(), 21u);
  EXPECT_EQ(motion.truth[3].p_w_b, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(motion.has_velocity_and_bias);
  EXPECT_EQ(motion.truth[0].v_w_b, Eigen::Vector3d::Zero());  // the positions stand still
  EXPECT_TRUE(std::isnan(motion.truth[0].gyro_bias.x()));
  ASSERT_EQ(motion.notes.size(), 1u);
  expectParts(motion.notes[0], "ground truth has no velocities");
}

TEST(RecordedMotion, ReadsVelocityAndBiases) {
  Files files;
  for (std::size_t i = 1; i < files.truth.size(); ++i) {
    files.truth[i] += ",0.5,0.6,0.7,-0.002,0.02,0.07,-0.01,0.1,0.09";
  }
  const RecordedMotion motion = motionOf(files);
  EXPECT_TRUE(motion.has_velocity_and_bias);
  EXPECT_EQ(motion.truth[2].v_w_b, Eigen::Vector3d(0.5, 0.6, 0.7));
  EXPECT_EQ(motion.truth[2].gyro_bias, Eigen::Vector3d(-0.002, 0.02, 0.07));
  EXPECT_EQ(motion.truth[2].accel_bias, Eigen::Vector3d(-0.01, 0.1, 0.09));
}

TEST(RecordedMotion, QuaternionIsScalarFirstAndNormalised) {
  Files files;
  // Quarter turn about z, norm off by 0.5 %.
  for (std::size_t i = 1; i < files.truth.size(); ++i) {
    files.truth[i] = std::to_string(kT0Ns + 50000000LL * static_cast<int>(i - 1)) +
                     ",0,0,0,0.710642,0,0,0.710642";
  }
  const Eigen::Vector3d x = motionOf(files).truth[0].R_w_b * Eigen::Vector3d::UnitX();
  EXPECT_NEAR((x - Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-12);
}

TEST(RecordedMotion, AcceptsForeignLineEndsBlankLinesAndALastLineWithoutEnd) {
  Files files;
  files.line_end = "\r\n";
  files.imu.insert(files.imu.end(), {"", "   ", ""});
  files.truth.insert(files.truth.begin() + 5, "");
  files.images[1] = "  " + files.images[1] + " \t";
  files.imu.front() = "\xEF\xBB\xBF" + files.imu.front();
  EXPECT_EQ(motionOf(files).imu.size(), 101u);
  files = Files();
  files.last_line_ends = false;
  EXPECT_EQ(motionOf(files).imu.size(), 101u);
}

TEST(RecordedMotion, MissingFolderAndFilesAreNamed) {
  const ScratchFolder folder;
  RecordedMotion motion;
  ReadStatus status =
      readRecordedMotion(folder.file("nowhere"), WindowOptions().max_imu_gap_s, &motion);
  expectParts(status.message, "nowhere is not a directory");
  for (const char* name : {"imu0.csv", "cam0_timestamps.csv", "groundtruth.csv"}) {
    Files().write(folder);
    std::filesystem::remove(folder.file(name));
    status = readRecordedMotion(folder.path(), WindowOptions().max_imu_gap_s, &motion);
    EXPECT_TRUE(contains(status.message, std::string(name) + " does not exist")) << status.message;
    std::filesystem::create_directory(folder.file(name));
    status = readRecordedMotion(folder.path(), WindowOptions().max_imu_gap_s, &motion);
    expectParts(status.message, "not a regular file");
    std::filesystem::remove(folder.file(name));
  }
}

struct BadFile {
  const char* name;
  std::function<void(Files&)> damage;
  const char* said;  ///< parts of the sentence, with | between them
};

/// Another row, behind a + one that goes on; @MS is a stamp.
std::function<void(Files&)> row(std::vector<std::string> Files::*file, std::size_t index,
                                std::string text) {
  if (const std::size_t at = text.find('@'); at != std::string::npos) {
    const std::size_t comma = text.find(',');
    const long long ms = std::stoll(text.substr(at + 1, comma - at - 1));
    text = std::to_string(kT0Ns + 1000000LL * ms) + text.substr(comma);
  }
  return [=](Files& f) {
    std::string& line = (f.*file)[index];
    line = text[0] == '+' ? line + text.substr(1) : text;
  };
}

// Line 1 is the header, so data row i stands in line i + 1.
const BadFile kBadFiles[] = {
    {"ImuColumnMissing", row(&Files::imu, 5, "1403715523912143104,1,2,3,4,5"),
     "imu0.csv line 6|6 columns, must have 7"},
    {"FirstTruthRowHasNoKnownLayout", row(&Files::truth, 1, "+,1,2"),
     "groundtruth.csv line 2|10 columns, must have 8 or 17"},
    {"TruthLayoutChanges", row(&Files::truth, 4, "+,1,1,1,1,1,1,1,1,1"),
     "groundtruth.csv line 5|17 columns, must have 8"},
    {"ImageRowHasTwoColumns", row(&Files::images, 2, "+,file.png"),
     "cam0_timestamps.csv line 3|2 columns, must have 1"},
    {"NotANumber", row(&Files::imu, 17, "@160,0,abc,0,0,0,0"),
     "imu0.csv line 18|column 3 (w_y)|'abc' is not a number"},
    {"NumberWithTail", row(&Files::imu, 17, "@160,0,0,0,0,0,1.5x"),
     "imu0.csv line 18|column 7 (a_z)|'1.5x'"},
    {"EmptyFieldDoesNotBorrowFromTheNext", row(&Files::imu, 17, "@160,0,,0,0,0,0"),
     "imu0.csv line 18|column 3 (w_y)|''"},
    {"EmptyLastFieldDoesNotBorrowFromTheNextLine", row(&Files::imu, 17, "@160,0,0,0,0,0,"),
     "imu0.csv line 18|column 7 (a_z)|''"},
    {"StampIsNoInteger", row(&Files::images, 3, "1.4037155241e18"),
     "cam0_timestamps.csv line 4|(timestamp)|'1.4037155241e18'|whole number"},
    {"StampIsNegative", row(&Files::images, 3, "-5"), "cam0_timestamps.csv line 4|'-5'"},
    {"StampOverflows", row(&Files::images, 3, "99999999999999999999"),
     "cam0_timestamps.csv line 4|'99999999999999999999'"},
    {"QuaternionIsNoRotation", row(&Files::truth, 6, "@250,0,0,0,0.9,0,0,0"),
     "groundtruth.csv line 7|(q_w, q_x, q_y, q_z)|0.9|0.01 of 1"},
    {"QuaternionIsZero", row(&Files::truth, 6, "@250,0,0,0,0,0,0,0"),
     "groundtruth.csv line 7|norm is 0"},
    {"OnlyAHeader", [](Files& f) { f.imu.resize(1); }, "imu0.csv has 0 rows|(minimum 2)"},
    {"EmptyFile", [](Files& f) { f.images.clear(); }, "cam0_timestamps.csv has 0 rows"},
    {"TooFewTruthRows", [](Files& f) { f.truth.resize(4); },
     "groundtruth.csv has 3 rows|(minimum 4)"},
    {"HeaderWithoutHash", row(&Files::imu, 0, "timestamp,wx,wy,wz,ax,ay,az"),
     "imu0.csv line 1|'timestamp' is not a whole number"},
    {"BinaryRubbish", [](Files& f) { f.imu[2] = std::string("\x01\x00\xff,", 4); },
     "imu0.csv line 3|'???,'"},
};

class RecordedMotionBadFile : public ::testing::TestWithParam<BadFile> {};

TEST_P(RecordedMotionBadFile, IsAStatusWithAPlace) {
  Files files;
  GetParam().damage(files);
  RecordedMotion motion;
  motion.name = "untouched";
  const ReadStatus status = readFiles(files, &motion);
  expectParts(status.message, GetParam().said);
  EXPECT_EQ(motion.name, "untouched");
}

INSTANTIATE_TEST_SUITE_P(All, RecordedMotionBadFile, ::testing::ValuesIn(kBadFiles),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(RecordedMotion, ImuGapsAreCountedAndNoted) {
  Files files;
  files.imu.erase(files.imu.begin() + 41, files.imu.begin() + 61);  // 0.40 s .. 0.59 s
  files.imu.erase(files.imu.begin() + 61, files.imu.begin() + 66);  // a smaller one later on
  const RecordedMotion motion = motionOf(files);
  ASSERT_FALSE(motion.notes.empty());
  expectParts(motion.notes[0], "imu0.csv has 2 IMU gaps|0.05 s|0.21 s|line 42|0.39 s");
}

// As in an ASL folder, whose test has all of it.
TEST(RecordedMotion, RowsAreSortedAndThoseOfNoUseDropped) {
  Files files;
  std::swap(files.imu[20], files.imu[21]);
  for (const char* value : {"nan", "-inf", "1e999"}) {
    files.imu.push_back(std::to_string(kT0Ns + 1) + ",0,0,0," + value + ",0,0");
  }
  files.images[3] = files.images[2];
  files.truth[3] = files.truth[2];
  const RecordedMotion motion = motionOf(files);
  EXPECT_EQ(motion.imu.size(), 101u);
  EXPECT_DOUBLE_EQ(motion.imu[19].t, 0.19);
  EXPECT_EQ(motion.image_times.size(), 4u);
  EXPECT_EQ(motion.truth.size(), 20u);
  ASSERT_EQ(motion.notes.size(), 4u);
  expectParts(motion.notes[0],
              "imu0.csv: 1 IMU samples out of order|3 IMU samples that cannot be read or are not");
  expectParts(motion.notes[1], "cam0_timestamps.csv: 1 images with the stamp of another one");
  expectParts(motion.notes[2], "groundtruth.csv: 1 rows with the stamp of another one");
}

TEST(RecordedMotion, NameIsTheLastFolder) {
  const ScratchFolder folder;
  Files().write(folder);
  const std::string path = folder.path();
  for (const char* end : {"", "/", "/."}) {
    RecordedMotion motion;
    ASSERT_TRUE(readRecordedMotion(path + end, WindowOptions().max_imu_gap_s, &motion).ok());
    EXPECT_EQ("/" + motion.name, path.substr(path.rfind('/'))) << end;
  }
}

TEST(RecordedMotion, ReadsRealRecordings) {
  const std::string data = SLIM_INIT_SHARED_DATA;
  // The EuRoC recordings are not part of the repository (their licence is not ours).
  if (!std::filesystem::is_directory(data)) GTEST_SKIP() << "no recordings at " << data;
  RecordedMotion motion;
  ReadStatus status = readRecordedMotion(data + "/V1_02", WindowOptions().max_imu_gap_s, &motion);
  ASSERT_TRUE(status.ok()) << status.message;
  EXPECT_EQ(motion.name, "V1_02");
  EXPECT_EQ(motion.t0_ns, 1403715523912143104);
  EXPECT_EQ(motion.imu.size(), 17100u);
  EXPECT_EQ(motion.truth.size(), 8351u);
  EXPECT_TRUE(motion.has_velocity_and_bias);
  EXPECT_EQ(motion.image_times.size(), 1710u);
  EXPECT_EQ(std::count_if(motion.image_times.begin(), motion.image_times.end(),
                          [&motion](double t) {
                            return t >= motion.truth.front().t && t <= motion.truth.back().t;
                          }),
            1670);
  for (const std::string& note : motion.notes) EXPECT_EQ(note.find("gap"), std::string::npos);
  // MH_03 has no velocities.
  status = readRecordedMotion(data + "/MH_03", WindowOptions().max_imu_gap_s, &motion);
  ASSERT_TRUE(status.ok()) << status.message;
  EXPECT_FALSE(motion.has_velocity_and_bias);
  // Its positions jump by up to 8 cm, which made velocities of 9 m/s.
  double fastest = 0.0;
  for (const NavState& state : motion.truth) fastest = std::max(fastest, state.v_w_b.norm());
  EXPECT_GT(fastest, 2.5);
  EXPECT_LT(fastest, 3.5);
}

}  // namespace
}  // namespace slim_init::evaluation
