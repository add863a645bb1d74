// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are one of the files of an ASL folder: a table, a sensor.yaml or an image; the first
// byte says which.
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "fuzz_target.h"
#include "sequence_check.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"

namespace {

struct File {
  const char* name;
  const char* text;
};

constexpr File kFiles[] = {
    {"mav0/imu0/data.csv",
     "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n"
     "1000000000,0,0,0,9.8,0,0\n1005000000,0,0,0.1,9.8,0,0\n1300000000,0,0,0,9.8,0,0.1\n"},
    {"mav0/cam0/data.csv", "#timestamp [ns],filename\n1050000000,a.png\n1100000000,b.pgm\n"},
    {"mav0/state_groundtruth_estimate0/data.csv",
     "#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z\n1000000000,0,0,0,1,0,0,0\n"
     "1100000000,0.1,0,0,1,0,0,0\n1200000000,0.2,0,0,1,0,0,0\n1300000000,0.3,0,0,1,0,0,0\n"},
    {"mav0/imu0/sensor.yaml",
     "sensor_type: imu\nrate_hz: 200\ngyroscope_noise_density: 1.7e-4\n"
     "accelerometer_noise_density: 2.0e-3\n"},
    {"mav0/cam0/sensor.yaml",
     "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
     "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\n"
     "resolution: [4, 2]\ncamera_model: pinhole\nintrinsics: [458, 457, 2, 1]\n"
     "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n"},
    {"mav0/cam0/data/a.png", "P5\n4 2\n255\nabcdefgh"},
    {"mav0/cam0/data/b.pgm", "P5\n4 2\n255\nabcdefgh"},
};

constexpr int kFirstImage = 5;

std::string png() {
  cv::Mat image(16, 32, CV_8UC1);
  for (int i = 0; i < 512; ++i) image.at<unsigned char>(i / 32, i % 32) = (i * 37) % 251;
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes);
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const slim_init::fuzz::Folder folder;
  slim_init::fuzz::Bytes bytes(data, size);
  constexpr int kCount = static_cast<int>(std::size(kFiles));
  const int which = bytes.below(kCount + 1);
  // The last: a PNG with changes; from random bytes no fuzzer makes one with its checksums.
  const std::string content =
      which == kCount ? slim_init::fuzz::edited(png(), &bytes) : bytes.rest();
  for (int i = 0; i < kCount; ++i) {
    folder.write(kFiles[i].name,
                 i == (which == kCount ? kFirstImage : which) ? content : kFiles[i].text);
  }
  slim_init::evaluation::ReadStatus status;
  const auto sequence = slim_init::evaluation::openAslFolder(folder.path(), 0.05, &status);
  slim_init::fuzz::checkSequence(sequence.get(), status);
  slim_init::Config config;
  std::string error;
  const bool loaded = slim_init::loadSensorFiles(folder.path(), &config, &error);
  FUZZ_CHECK(loaded || !error.empty(), "refused without a word");
  return 0;
}
