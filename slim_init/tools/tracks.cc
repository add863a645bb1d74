// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "tracks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "exit_code.h"
#include "load_images.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/evaluation/track_images.h"
#include "slim_init/options.h"
#include "slim_init/simulation/scene.h"
#include "slim_init/simulation/track_truth.h"
#include "slim_init/simulation/trajectory.h"

namespace slim_init::tools {
namespace {

/// The first images of another sequence.
class FirstImages : public evaluation::ImageSequence {
 public:
  FirstImages(evaluation::ImageSequence* whole, int limit) : whole_(whole) {
    name_ = whole->name();
    t0_ns_ = whole->t0Ns();
    imu_ = whole->imu();
    const std::size_t all = whole->images();
    const std::size_t count = limit > 0 ? std::min<std::size_t>(limit, all) : all;
    for (std::size_t k = 0; k < count; ++k) image_stamps_ns_.push_back(whole->imageStampNs(k));
  }
  cv::Mat image(std::size_t k, std::string* error) override { return whole_->image(k, error); }

 private:
  evaluation::ImageSequence* whole_;
};

/// A line of the table: "name  value unit".
void print(const std::string& name, double value, const char* unit) {
  std::printf("  %-44s", name.c_str());
  std::printf(std::isfinite(value) ? "%.3g %s\n" : "-\n", value, unit);
}

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? kNotComputed : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

/// How many features of one kind there are, and how long they are tracked; needs no ground truth.
template <typename Feature>
void printPersistence(const std::vector<FrameObservation>& frames,
                      std::vector<Feature> FrameObservation::*features) {
  std::vector<double> per_image, life;
  std::map<FeatureId, int> images_of;
  std::set<FeatureId> before;
  std::size_t carried = 0, candidates = 0;
  for (const FrameObservation& frame : frames) {
    std::set<FeatureId> now;
    for (const Feature& feature : frame.*features) now.insert(feature.id);
    for (const FeatureId id : now) ++images_of[id];
    for (const FeatureId id : before) carried += now.count(id);
    candidates += before.size();  // the last image has no next one
    per_image.push_back(static_cast<double>(now.size()));
    before = std::move(now);
  }
  for (const auto& track : images_of) life.push_back(track.second);
  print("per image, median", evaluation::median(per_image), "");
  print("per image, 10 % quantile", evaluation::quantile(per_image, 0.1), "");
  print("track life, median", evaluation::median(life), "images");
  print("survival to the next image", percent(carried, candidates), "%");
}

void printErrors(const std::vector<simulation::PointError>& errors, const std::string& against) {
  std::vector<double> values;
  std::size_t outliers = 0;
  for (const simulation::PointError& e : errors) {
    if (e.occluded) continue;
    values.push_back(e.error_px);
    if (e.error_px > simulation::kTrackOutlierPx) ++outliers;
  }
  print("observations" + against, static_cast<double>(values.size()), "");
  print("occluded" + against, static_cast<double>(errors.size() - values.size()), "");
  print("error" + against + ", median", evaluation::median(values), "px");
  print("error" + against + ", 90 %", evaluation::quantile(values, 0.9), "px");
  print("outliers" + against, percent(outliers, values.size()), "%");
}

void printErrors(const std::vector<simulation::LineError>& errors, const std::string& against) {
  std::vector<double> angle, offset;
  std::size_t same = 0;
  for (const simulation::LineError& e : errors) {
    angle.push_back(e.angle_deg);
    offset.push_back(e.offset_px);
    if (e.end_px <= simulation::kSameLinePx) ++same;
  }
  print("observations" + against, static_cast<double>(errors.size()), "");
  print("angle" + against + ", median", evaluation::median(angle), "deg");
  print("offset" + against + ", median", evaluation::median(offset), "px");
  print("same line" + against, percent(same, errors.size()), "%");
}

/// What the command works on.
struct Input {
  std::unique_ptr<evaluation::ImageSequence> images;
  Config config;
  std::optional<simulation::Scene> scene;  // none where there is no file
};

/// Returns an empty string or a message.
std::string openInput(const TracksCommand& command, Input* input) {
  evaluation::ReadStatus status;
  input->images = evaluation::openAslFolder(command.asl, WindowOptions().max_imu_gap_s, &status);
  if (input->images == nullptr) return status.message;
  std::string error;
  if (command.config_file.empty()) {
    error = configureFromData(command.asl, command.options_file, *input->images, &input->config);
  } else {
    loadConfig(command.config_file, command.options_file, &input->config, &error);
  }
  if (!error.empty()) return error;
  const std::filesystem::path path = std::filesystem::path(command.asl) / "scene.json";
  if (!std::filesystem::exists(path)) return "";
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  if (simulation::sceneFromJson(text.str(), &input->scene.emplace(), &error)) return "";
  return path.string() + ": " + error;
}

/// Measures the tracks in all frames that the ground truth covers, with every observation at the
/// time of its row. Returns an empty string or a message.
std::string measure(const Input& input, const std::vector<FrameObservation>& frames,
                    simulation::TrackQuality* quality) {
  std::string error;
  const auto trajectory = simulation::makeSampledTrajectory(input.images->truth(), &error);
  if (trajectory == nullptr) return "ground truth: " + error;
  const Calibration& calibration = input.config.calibration;
  simulation::TrackTruth truth(*input.scene, input.config.camera);
  const double reach = 0.5 * calibration.readout_s;  // of the first and the last row
  for (const FrameObservation& frame : frames) {
    const double t = calibration.imuTime(frame.t);
    if (!trajectory->covers(t - reach) || !trajectory->covers(t + reach)) continue;
    truth.addFrame(frame, [&](double row) {
      const simulation::Kinematics body = trajectory->at(t + row * calibration.readout_s);
      return simulation::CameraPose{body.R_w_b * calibration.R_b_c,
                                    body.p_w_b + body.R_w_b * calibration.t_b_c};
    });
  }
  *quality = truth.evaluate();
  return "";
}

/// Returns an empty string or a message.
std::string run(const TracksCommand& command) {
  Input input;
  if (std::string error = openInput(command, &input); !error.empty()) return error;
  FirstImages images(input.images.get(), command.limit);
  std::vector<FrameObservation> frames;
  evaluation::TrackingSummary summary;
  cv::setNumThreads(1);  // its times are measured
  const Config& config = input.config;
  if (std::string error =
          evaluation::trackImages(&images, config.camera, config.calibration, config.front_end,
                                  evaluation::TrackingHooks(), &frames, &summary);
      !error.empty()) {
    return error;
  }
  std::optional<simulation::TrackQuality> quality;
  if (input.scene.has_value() && !input.images->truth().empty()) {
    if (std::string error = measure(input, frames, &quality.emplace()); !error.empty()) {
      return error;
    }
  } else {
    std::cerr << "slim_init: note: no scene.json or no ground truth: no errors are measured\n";
  }
  std::printf("%s: %zu images\npoints\n", images.name().c_str(), frames.size());
  printPersistence(frames, &FrameObservation::points);
  if (quality.has_value()) {
    printErrors(quality->points, ", against first");
    printErrors(quality->keyframe_points, ", keyframe to keyframe");
    print("tracks without ground truth", quality->point_tracks_without_truth, "");
  }
  std::printf("lines\n");
  printPersistence(frames, &FrameObservation::lines);
  if (quality.has_value()) {
    printErrors(quality->lines, ", against first");
    printErrors(quality->keyframe_lines, ", keyframe to keyframe");
    print("tracks without ground truth", quality->line_tracks_without_truth, "");
  }
  std::printf("time per image, median\n");
  for (const StageTime& stage : summary.stages_ms_median) print(stage.name, stage.ms, "ms");
  print("total", summary.total_ms_median, "ms");
  print("total, 90 %", summary.total_ms_p90, "ms");
  return "";
}

}  // namespace

std::vector<AbOption> tracksOptionTable(TracksCommand* command) {
  TracksCommand& c = *command;
  return {
      {"asl", &c.asl, "DIR",
       "Sequence in ASL layout; with DIR/scene.json and ground truth errors are measured", ""},
      {"config", &c.config_file, "FILE",
       "YAML file with camera, extrinsic, td and section slim_init: (default: the sensor.yaml "
       "files beside the data)",
       ""},
      {"options", &c.options_file, "FILE",
       "YAML file whose section slim_init: takes precedence over --config's", ""},
      {"limit", &c.limit, "N", "Stop after this many images (0: no limit)", "", 0, 1000000000},
  };
}

int runTracks(const TracksCommand& command) {
  const std::string error = command.asl.empty() ? "give --asl DIR" : run(command);
  if (error.empty()) return kExitOk;
  std::cerr << "slim_init: tracks: " << error << "\n";
  return kExitBadInput;
}

}  // namespace slim_init::tools
