// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "support/euroc_camera.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {

/// Image `k` cannot be had; the sentence about it names its stamp and has `parts`.
inline void expectNoImage(ImageSequence* sequence, std::size_t k, const std::string& parts) {
  std::string error;
  EXPECT_TRUE(sequence->image(k, &error).empty()) << k;
  expectParts(error, std::to_string(sequence->stampNs(sequence->image_times[k])) + "|" + parts);
}

/// A recording of a second, small enough for every test to write its own.
struct TinyRecording {
  static constexpr std::int64_t kT0Ns = 1403715273262142976;
  static constexpr std::int64_t kImuStepNs = 5000000;
  static constexpr std::int64_t kImageStepNs = 50000000;
  static constexpr int kImuSamples = 201;
  static constexpr int kImages = 20;
  static constexpr int kTruthRows = 101;
  static constexpr std::int64_t kSpeedStepNs = 20000000;
  static constexpr int kSpeeds = 50;

  static ImuSample imu(int k) {
    ImuSample sample;
    // Thirds have no short decimal form: what is read back equal was written in full.
    sample.gyro = Eigen::Vector3d(0.1, -0.2, 0.3) * (1.0 + k / 3.0);
    sample.accel = Eigen::Vector3d(1.0 / 3.0, -2.0 / 7.0, 9.81 + 1e-9 * k);
    return sample;
  }

  static SpeedSample speed(int k) {
    return SpeedSample::forward(1e-9 * static_cast<double>(k * kSpeedStepNs), k / 3.0, 0.25);
  }

  static cv::Mat image(int k) {
    cv::Mat image(48, 64, CV_8UC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>((3 * x + 5 * y + 7 * k) % 256);
      }
    }
    return image;
  }

  static NavState truth(int k) {
    const double t = 0.01 * k;
    NavState state;
    state.R_w_b =
        (Eigen::AngleAxisd(t / 3.0, Eigen::Vector3d(1, 2, 3).normalized())).toRotationMatrix();
    state.p_w_b = Eigen::Vector3d(t / 3.0, 1.0 / 7.0, -t);
    state.v_w_b = Eigen::Vector3d(1.0 / 3.0, 0.0, -1.0);
    state.gyro_bias = Eigen::Vector3d(0.01, 0.02, 1.0 / 30.0);
    state.accel_bias = Eigen::Vector3d(0.1, 1.0 / 9.0, -0.1);
    return state;
  }

  static WriterRig rig() {
    WriterRig rig;
    rig.calibration.R_b_c =
        Eigen::AngleAxisd(1.2, Eigen::Vector3d(3, -2, 1).normalized()).toRotationMatrix();
    rig.calibration.t_b_c = Eigen::Vector3d(0.1, -1.0 / 3.0, 0.02);
    rig.calibration.imu_noise.gyro_density = 1.0 / 3e3;
    rig.calibration.imu_noise.accel_density = 1.0 / 3e2;
    rig.camera = cameraOf(64, 48, 60.0 + 1.0 / 3.0, 61.0, 32.5, 23.5);
    rig.camera.distortion = {-0.28, 0.07, 1e-4, 1.0 / 3e4};
    return rig;
  }

  /// All but the pixels, the first sample at `t0_ns`.
  static RecordedMotion recording(std::int64_t t0_ns = kT0Ns) {
    RecordedMotion recording;
    recording.t0_ns = t0_ns;
    for (int k = 0; k < kImuSamples; ++k) {
      recording.imu.push_back(imu(k));
      recording.imu.back().t = 1e-9 * static_cast<double>(k * kImuStepNs);
    }
    for (int k = 0; k < kSpeeds; ++k) recording.speeds.push_back(speed(k));
    for (int k = 0; k < kImages; ++k) {
      recording.image_times.push_back(1e-9 * static_cast<double>(k * kImageStepNs));
    }
    for (int k = 0; k < kTruthRows; ++k) {
      recording.truth.push_back(truth(k));
      recording.truth.back().t = 0.01 * k;
    }
    return recording;
  }

  /// Writes everything into an ASL folder; what fails is a failure of the test.
  static void write(const std::string& directory, const WriterRig& rig,
                    const RecordedMotion& recording = TinyRecording::recording()) {
    ASSERT_EQ(writeAslFolder(directory, rig, recording), "");
    for (int k = 0; k < kImages; ++k) {
      EXPECT_EQ(writeAslImage(directory, recording.t0_ns + k * kImageStepNs, image(k)), "");
    }
  }

  /// Expects `sequence` to be what write() wrote, bit for bit.
  static void expectIn(ImageSequence* sequence) {
    EXPECT_EQ(sequence->t0_ns, kT0Ns);
    ASSERT_EQ(sequence->speeds.size(), static_cast<std::size_t>(kSpeeds));
    for (int k = 0; k < kSpeeds; ++k) {
      const SpeedSample& sample = sequence->speeds[static_cast<std::size_t>(k)];
      EXPECT_EQ(sample.t, speed(k).t);
      EXPECT_EQ(sample.velocity.x(), speed(k).velocity.x());
      EXPECT_EQ(sample.covariance(0, 0), speed(k).covariance(0, 0));
      EXPECT_TRUE(sample.forward_only);
    }
    ASSERT_EQ(sequence->imu.size(), static_cast<std::size_t>(kImuSamples));
    for (int k = 0; k < kImuSamples; ++k) {
      const ImuSample& sample = sequence->imu[static_cast<std::size_t>(k)];
      EXPECT_EQ(sample.t, 1e-9 * static_cast<double>(k * kImuStepNs));
      EXPECT_EQ(sample.gyro, imu(k).gyro) << k;
      EXPECT_EQ(sample.accel, imu(k).accel) << k;
    }
    ASSERT_EQ(sequence->images(), static_cast<std::size_t>(kImages));
    for (int k = 0; k < kImages; ++k) {
      EXPECT_EQ(sequence->stampNs(sequence->image_times[static_cast<std::size_t>(k)]),
                kT0Ns + k * kImageStepNs);
      std::string error;
      const cv::Mat read = sequence->image(static_cast<std::size_t>(k), &error);
      EXPECT_EQ(error, "");
      ASSERT_EQ(read.type(), CV_8UC1);
      ASSERT_EQ(read.size(), image(k).size());
      EXPECT_EQ(cv::norm(read, image(k), cv::NORM_INF), 0.0) << k;
    }
    ASSERT_EQ(sequence->truth.size(), static_cast<std::size_t>(kTruthRows));
    EXPECT_TRUE(sequence->has_velocity_and_bias);
    for (int k = 0; k < kTruthRows; ++k) {
      const NavState& state = sequence->truth[static_cast<std::size_t>(k)];
      EXPECT_EQ(state.p_w_b, truth(k).p_w_b);
      EXPECT_EQ(state.v_w_b, truth(k).v_w_b);
      EXPECT_EQ(state.gyro_bias, truth(k).gyro_bias);
      EXPECT_EQ(state.accel_bias, truth(k).accel_bias);
      // By way of a quaternion.
      EXPECT_LT((state.R_w_b - truth(k).R_w_b).norm(), 1e-15);
    }
  }
};

}  // namespace slim_init::evaluation
