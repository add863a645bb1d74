// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Real images of a vehicle that stands still. Skipped where the recording is not at hand.
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "slim_init/config/config.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"

namespace slim_init::feature_tracker_lines {
namespace {

const std::string kSnippet = SLIM_INIT_SNIPPET;

struct Recording {
  std::vector<std::pair<double, cv::Mat>> images;
  std::vector<ImuSample> imu;
};

bool readSnippet(Recording* recording) {
  std::ifstream images(kSnippet + "/mav0/cam0/data.csv"), imu(kSnippet + "/mav0/imu0/data.csv");
  if (!images.is_open() || !imu.is_open()) return false;
  std::string line;
  long long t0 = -1;
  while (std::getline(images, line)) {
    if (line.empty() || line[0] == '#') continue;
    const long long t = std::stoll(line);
    if (t0 < 0) t0 = t;
    std::string name = line.substr(line.find(',') + 1);
    while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back()))) name.pop_back();
    recording->images.emplace_back(
        static_cast<double>(t - t0) * 1e-9,
        cv::imread(kSnippet + "/mav0/cam0/data/" + name, cv::IMREAD_GRAYSCALE));
  }
  while (std::getline(imu, line)) {
    if (line.empty() || line[0] == '#') continue;
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream in(line);
    long long t = 0;
    ImuSample sample;
    in >> t >> sample.gyro.x() >> sample.gyro.y() >> sample.gyro.z() >> sample.accel.x() >>
        sample.accel.y() >> sample.accel.z();
    sample.t = static_cast<double>(t - t0) * 1e-9;
    recording->imu.push_back(sample);
  }
  return !recording->images.empty() && !recording->imu.empty();
}

class Snippet : public ::testing::TestWithParam<TrackerProfile> {};

TEST_P(Snippet, TracksPersist) {
  Recording recording;
  // The EuRoC recordings are not part of the repository (their licence is not ours).
  if (!readSnippet(&recording)) GTEST_SKIP() << "no recording in " << kSnippet;
  Config config;
  std::string error;
  ASSERT_TRUE(loadConfig(SLIM_INIT_SOURCE_DIR "/config/euroc.yaml", &config, &error)) << error;
  config.front_end.profile = GetParam();
  const bool as_vins = GetParam() == TrackerProfile::kVins;

  ImageFrontEnd front_end(config.camera, config.calibration, config.front_end);
  FrameObservation frame, before;
  std::size_t next_imu = 0;
  for (std::size_t k = 0; k < recording.images.size(); ++k) {
    const auto& [t, image] = recording.images[k];
    while (next_imu < recording.imu.size() && recording.imu[next_imu].t <= t) {
      front_end.addImu(recording.imu[next_imu++]);
    }
    before = frame;
    ASSERT_EQ(front_end.addImage(t, image, &frame), ImageStatus::kTracked);
    if (k == 0) continue;
    std::set<FeatureId> points, lines;
    for (const PointObservation& point : before.points) points.insert(point.id);
    for (const LineObservation& line : before.lines) lines.insert(line.id);
    std::size_t points_persist = 0, lines_persist = 0;
    for (const PointObservation& point : frame.points) points_persist += points.count(point.id);
    for (const LineObservation& line : frame.lines) lines_persist += lines.count(line.id);
    EXPECT_GE(points_persist, as_vins ? 80U : 100U) << "image " << k;
    if (!as_vins) {
      EXPECT_GE(lines_persist, 40U) << "image " << k;
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
