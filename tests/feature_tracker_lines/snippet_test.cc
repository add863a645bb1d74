// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Real images of a vehicle that stands still. Skipped where the recording is not at hand.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "support/frames.h"

namespace slim_init::feature_tracker_lines {
namespace {

const std::string kSnippet = SLIM_INIT_SNIPPET;

class Snippet : public ::testing::TestWithParam<TrackerProfile> {};

TEST_P(Snippet, TracksPersist) {
  // The EuRoC recordings are not part of the repository (their licence is not ours).
  if (!std::filesystem::exists(kSnippet)) GTEST_SKIP() << "no recording in " << kSnippet;
  evaluation::ReadStatus status;
  const auto recording = evaluation::openAslFolder(kSnippet, 0.05, &status);
  ASSERT_NE(recording, nullptr) << status.message;
  Config config;
  std::string error;
  ASSERT_TRUE(loadConfig(SLIM_INIT_SOURCE_DIR "/config/euroc.yaml", &config, &error)) << error;
  config.front_end.profile = GetParam();
  const bool as_vins = GetParam() == TrackerProfile::kVins;

  ImageFrontEnd front_end(config.camera, config.calibration, config.front_end);
  FrameObservation frame, before;
  std::size_t next_imu = 0;
  for (std::size_t k = 0; k < recording->images(); ++k) {
    const double t = recording->image_times[k];
    while (next_imu < recording->imu.size() && recording->imu[next_imu].t <= t) {
      front_end.addImu(recording->imu[next_imu++]);
    }
    before = frame;
    ASSERT_EQ(front_end.addImage(t, recording->image(k, nullptr), &frame), ImageStatus::kTracked);
    if (k == 0) continue;
    const int points_persist = countIn(idSet(before.points), frame.points);
    const int lines_persist = countIn(idSet(before.lines), frame.lines);
    EXPECT_GE(points_persist, as_vins ? 80 : 100) << "image " << k;
    if (!as_vins) {
      EXPECT_GE(lines_persist, 40) << "image " << k;
    }
  }
  if (as_vins) return;
  // Bias of the dataset's ground truth at that time.
  ASSERT_TRUE(front_end.report().gyro_bias_known);
  EXPECT_LT((front_end.report().gyro_bias - Eigen::Vector3d(-0.0023, 0.0207, 0.0768)).norm(), 0.005)
      << front_end.report().gyro_bias.transpose();
}

INSTANTIATE_TEST_SUITE_P(Profiles, Snippet,
                         ::testing::Values(TrackerProfile::kDefault, TrackerProfile::kVins),
                         [](const auto& profile) { return std::string(toString(profile.param)); });

}  // namespace
}  // namespace slim_init::feature_tracker_lines
