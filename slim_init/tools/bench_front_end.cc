// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Times of the image front end on a recording, image by image.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench_commands.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"

namespace slim_init::tools {
namespace {

namespace ftl = feature_tracker_lines;

struct Recording {
  ftl::CameraParameters camera;
  Calibration calibration;
  std::vector<ImuSample> imu;
  std::vector<std::pair<double, cv::Mat>> images;
};

// Reading is not what is measured: everything is held in memory.
std::string load(const std::string& folder, Recording* recording) {
  evaluation::ReadStatus status;
  const auto sequence =
      evaluation::openAslFolder(folder, evaluation::ImageSequenceOptions(), &status);
  if (sequence == nullptr) return status.message;
  if (!sequence->calibration().has_value()) return folder + ": " + sequence->calibrationProblem();
  recording->camera = sequence->calibration()->camera;
  recording->calibration = sequence->calibration()->calibration;
  recording->imu = sequence->imu();
  constexpr std::size_t kMostImages = 400;  // 140 MB
  for (std::size_t k = 0; k < std::min(sequence->images(), kMostImages); ++k) {
    std::string error;
    cv::Mat image = sequence->image(k, &error);
    if (!error.empty()) return error;
    recording->images.emplace_back(sequence->imageTime(k), std::move(image));
  }
  return recording->images.empty() ? folder + " has no images" : "";
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// An iteration is an image; after the last one the front end starts anew. The counters are medians
// over the images of each stage's own time, the first image of a pass left out.
void run(benchmark::State& state, const Recording& recording, const ftl::FrontEndOptions& options) {
  cv::setNumThreads(1);
  ftl::ImageFrontEnd front_end(recording.camera, recording.calibration, options);
  std::map<std::string, std::vector<double>> stages;
  std::vector<double> total, points, lines;
  std::size_t image = 0, sample = 0;
  FrameObservation frame;
  for (auto _ : state) {
    const auto& [t, picture] = recording.images[image];
    while (sample < recording.imu.size() && recording.imu[sample].t <= t) {
      front_end.addImu(recording.imu[sample++]);
    }
    if (front_end.addImage(t, picture, &frame) != ftl::ImageStatus::kTracked) {
      state.SkipWithError("an image was refused");
      break;
    }
    const ftl::ImageReport& report = front_end.report();
    if (image > 0) {
      for (const StageTime& stage : report.stages) stages[stage.name].push_back(stage.ms);
      total.push_back(report.total_ms);
      points.push_back(static_cast<double>(frame.points.size()));
      lines.push_back(static_cast<double>(frame.lines.size()));
    }
    if (++image == recording.images.size()) {
      image = 0;
      sample = 0;
      front_end.reset();
    }
  }
  cv::setNumThreads(-1);
  for (const auto& [name, ms] : stages) state.counters[name + "_ms"] = median(ms);
  state.counters["total_ms"] = median(total);
  state.counters["points"] = median(points);
  state.counters["lines"] = median(lines);
}

}  // namespace

bool registerFrontEndBenchmarks(const char* folder) {
  if (folder == nullptr || folder[0] == '\0') {
    std::cerr << "slim_init_bench: the image front end is omitted: set SLIM_INIT_BENCH_SEQUENCE "
                 "to a folder in ASL layout\n";
    return true;
  }
  const auto recording = std::make_shared<Recording>();
  if (const std::string error = load(folder, recording.get()); !error.empty()) {
    std::cerr << "slim_init_bench: SLIM_INIT_BENCH_SEQUENCE: " << error << "\n";
    return false;
  }
  const auto add = [&recording](const char* name, const ftl::FrontEndOptions& options) {
    benchmark::RegisterBenchmark(
        name, [recording, options](benchmark::State& state) { run(state, *recording, options); })
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime();
  };
  ftl::FrontEndOptions options;
  add("front_end/default", options);
  options.threads = 2;
  add("front_end/two_threads", options);
  options.threads = 1;
  options.profile = ftl::TrackerProfile::kVins;
  add("front_end/vins", options);
  return true;
}

}  // namespace slim_init::tools
