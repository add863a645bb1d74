// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "slim_init/result.h"
#include "slim_init/types.h"

namespace slim_init {
namespace {

TEST(Options, DefaultsAreValid) {
  EXPECT_EQ(InitializerOptions().validate(), "");
  EXPECT_EQ(Calibration().validate(), "");
}

TEST(Options, EveryFieldRefusesAValueBelowItsRange) {
  using Change = std::function<void(InitializerOptions&)>;
  const std::vector<std::pair<std::string, Change>> changes = {
      {"window.keyframes", [](auto& o) { o.window.keyframes = 3; }},
      {"window.min_keyframes", [](auto& o) { o.window.min_keyframes = 3; }},
      {"window.min_interval_s", [](auto& o) { o.window.min_interval_s = 0.0; }},
      {"window.max_frame_gap_s", [](auto& o) { o.window.max_frame_gap_s = 0.0; }},
      {"window.max_imu_gap_s", [](auto& o) { o.window.max_imu_gap_s = 0.0; }},
      {"window.buffer_s", [](auto& o) { o.window.buffer_s = 0.0; }},
      {"vanishing_point.icosphere_subdivisions",
       [](auto& o) { o.vanishing_point.icosphere_subdivisions = 0; }},
      {"vanishing_point.vote_threshold_deg",
       [](auto& o) { o.vanishing_point.vote_threshold_deg = 0.0; }},
      {"vanishing_point.inlier_threshold_deg",
       [](auto& o) { o.vanishing_point.inlier_threshold_deg = 0.0; }},
      {"vanishing_point.min_inliers", [](auto& o) { o.vanishing_point.min_inliers = 1; }},
      {"vanishing_point.match_threshold_deg",
       [](auto& o) { o.vanishing_point.match_threshold_deg = 0.0; }},
      {"vanishing_point.min_track_age", [](auto& o) { o.vanishing_point.min_track_age = 0; }},
      {"vanishing_point.consistency_threshold_deg",
       [](auto& o) { o.vanishing_point.consistency_threshold_deg = 0.0; }},
      {"alignment.min_track_length", [](auto& o) { o.alignment.min_track_length = 2; }},
      {"alignment.min_tracks", [](auto& o) { o.alignment.min_tracks = 0; }},
      {"alignment.min_parallax_rad", [](auto& o) { o.alignment.min_parallax_rad = -1.0; }},
      {"gates.min_parallax_px", [](auto& o) { o.gates.min_parallax_px = -1.0; }},
      {"gates.min_rotation_deg", [](auto& o) { o.gates.min_rotation_deg = -1.0; }},
      {"gates.min_excitation", [](auto& o) { o.gates.min_excitation = -1.0; }},
      {"gates.min_linkage", [](auto& o) { o.gates.min_linkage = 0.0; }},
      {"gates.max_alignment_residual", [](auto& o) { o.gates.max_alignment_residual = -1.0; }},
      {"gates.max_scale_sigma", [](auto& o) { o.gates.max_scale_sigma = -1.0; }},
  };
  for (const auto& [field, change] : changes) {
    InitializerOptions options;
    change(options);
    const std::string sentence = options.validate();
    EXPECT_EQ(sentence.find(field + " is "), 0u) << field << ": \"" << sentence << "\"";
    EXPECT_NE(sentence.find("must"), std::string::npos) << sentence;
  }
}

TEST(Options, RoomsOfSlimRefuseWhatIsOutOfRange) {
  EXPECT_EQ(MultiGapBiasOptions().validate(), "");
  EXPECT_EQ(ReverseAlignmentOptions().validate(), "");
  MultiGapBiasOptions bias;
  bias.max_gap = 9;
  EXPECT_EQ(bias.validate(), "max_gap is 9, must be in [1, 8]");
  ReverseAlignmentOptions reverse;
  reverse.min_scale = 60.0;
  EXPECT_EQ(reverse.validate(), "min_scale is 60, must not exceed max_scale (50)");
}

TEST(Options, NotANumberIsOutOfEveryRange) {
  InitializerOptions options;
  options.gates.max_scale_sigma = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(options.validate(), "");
}

TEST(Options, MoreMinimumThanFullKeyframesIsRefused) {
  InitializerOptions options;
  options.window.keyframes = 8;
  EXPECT_EQ(options.validate(), "window.min_keyframes is 10, must not exceed keyframes (8)");
}

TEST(Options, BufferHasToHoldAFullWindow) {
  InitializerOptions options;
  options.window.min_interval_s = 1.0;
  EXPECT_EQ(options.validate(),
            "window.twice the least length of a full window is 18, must not exceed buffer_s (10)");
  options.window.buffer_s = 18.0;
  EXPECT_EQ(options.validate(), "");
}

TEST(Options, VpConsistencyThresholdMustBeAbleToFail) {
  InitializerOptions options;
  options.vanishing_point.consistency_threshold_deg =
      options.vanishing_point.inlier_threshold_deg * 1.01;
  EXPECT_EQ(options.validate().find("vanishing_point.consistency_threshold_deg"), 0u);
}

TEST(Options, SentenceNamesValueAndBound) {
  InitializerOptions options;
  options.window.keyframes = 51;
  EXPECT_EQ(options.validate(), "window.keyframes is 51, must be in [4, 50]");
}

TEST(Calibration, RefusesWhatCannotBe) {
  Calibration calibration;
  calibration.R_b_c(0, 0) = 1.1;
  EXPECT_NE(calibration.validate().find("R_b_c"), std::string::npos);
  calibration = Calibration();
  calibration.R_b_c = Eigen::Vector3d(1, 1, -1).asDiagonal();  // a reflection
  EXPECT_NE(calibration.validate().find("R_b_c"), std::string::npos);
  calibration = Calibration();
  calibration.imu_noise.gyro_density = 0.0;
  EXPECT_EQ(calibration.validate().find("imu_noise.gyro_density is 0"), 0u);
  calibration = Calibration();
  calibration.gravity_magnitude = 981.0;  // cm/s^2 by mistake
  EXPECT_NE(calibration.validate().find("gravity_magnitude is 981"), std::string::npos);
  calibration = Calibration();
  calibration.td = kNotComputed;
  EXPECT_NE(calibration.validate().find("td"), std::string::npos);
}

TEST(Status, NamesAreDistinctAndClassesDisjoint) {
  std::vector<std::string> names;
  for (int s = 0; s <= static_cast<int>(InitStatus::kNumericalFailure); ++s) {
    const InitStatus status = static_cast<InitStatus>(s);
    names.push_back(toString(status));
    EXPECT_FALSE(isWait(status) && isRefused(status));
    EXPECT_NE(names.back(), "unknown");
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
  EXPECT_FALSE(isWait(InitStatus::kSuccess));
  EXPECT_TRUE(isWait(InitStatus::kStationary));
  EXPECT_TRUE(isRefused(InitStatus::kScaleTooUncertain));
}

}  // namespace
}  // namespace slim_init
