// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "tracks.h"

#include <iostream>

#include "exit_code.h"

#ifdef SLIM_INIT_HAS_FEATURE_TRACKER_LINES

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/track_images.h"
#include "slim_init/simulation/scene.h"
#include "slim_init/simulation/track_truth.h"
#include "slim_init/simulation/trajectory.h"

namespace slim_init::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

int fail(ExitCode code, const std::string& sentence) {
  std::cerr << "slim_init: " << sentence << "\n";
  return code;
}

/// Some of the images of another sequence.
class Subsequence : public evaluation::ImageSequence {
 public:
  Subsequence(evaluation::ImageSequence* whole, int stride, int limit) : whole_(whole) {
    name_ = whole->name();
    t0_ns_ = whole->t0Ns();
    imu_ = whole->imu();
    for (std::size_t k = 0; k < whole->images(); k += static_cast<std::size_t>(stride)) {
      if (limit > 0 && index_.size() == static_cast<std::size_t>(limit)) break;
      index_.push_back(k);
      image_stamps_ns_.push_back(whole->imageStampNs(k));
    }
  }
  cv::Mat image(std::size_t k, std::string* error) override {
    return whole_->image(index_[k], error);
  }

 private:
  evaluation::ImageSequence* whole_;
  std::vector<std::size_t> index_;
};

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return kNotComputed;
  const auto at =
      static_cast<std::size_t>(std::min(std::floor(q * static_cast<double>(values.size())),
                                        static_cast<double>(values.size()) - 1.0));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? kNotComputed : static_cast<double>(part) / static_cast<double>(whole);
}

/// Numbers of one kind of feature without any truth.
struct Persistence {
  std::vector<double> per_frame;  ///< features in each image
  std::size_t carried = 0;        ///< features of an image that are in the next one
  std::size_t candidates = 0;     ///< features of all images but the last
  std::map<FeatureId, int> life;  ///< images of every track
};

template <typename Get>
Persistence persistenceOf(const std::vector<FrameObservation>& frames, const Get& get) {
  Persistence p;
  std::set<FeatureId> before;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::set<FeatureId> now;
    for (const auto& feature : get(frames[i])) now.insert(feature.id);
    for (const FeatureId id : now) ++p.life[id];
    for (const FeatureId id : before) p.carried += now.count(id);
    p.candidates += before.size();
    p.per_frame.push_back(static_cast<double>(now.size()));
    before = std::move(now);
  }
  return p;
}

Json json(const Persistence& p) {
  std::vector<double> life;
  for (const auto& track : p.life) life.push_back(track.second);
  return {{"per_image_median", quantile(p.per_frame, 0.5)},
          {"per_image_p10", quantile(p.per_frame, 0.1)},
          {"tracks", p.life.size()},
          {"life_images_median", quantile(life, 0.5)},
          {"life_images_p90", quantile(life, 0.9)},
          {"survival", share(p.carried, p.candidates)}};
}

Json pointErrorsJson(const std::vector<simulation::PointError>& errors, double outlier_px) {
  std::vector<double> values;
  std::size_t occluded = 0;
  std::size_t outliers = 0;
  for (const simulation::PointError& e : errors) {
    if (e.occluded) {
      ++occluded;
      continue;
    }
    values.push_back(e.error_px);
    if (e.error_px > outlier_px) ++outliers;
  }
  return {{"observations", values.size()},
          {"occluded", occluded},
          {"median_px", quantile(values, 0.5)},
          {"p90_px", quantile(values, 0.9)},
          {"outlier_share", share(outliers, values.size())}};
}

Json lineErrorsJson(const std::vector<simulation::LineError>& errors, double same_line_px) {
  std::vector<double> angle, offset;
  std::size_t same = 0;
  for (const simulation::LineError& e : errors) {
    angle.push_back(e.angle_deg);
    offset.push_back(e.offset_px);
    if (e.end_px <= same_line_px) ++same;
  }
  return {
      {"observations", errors.size()},          {"angle_deg_median", quantile(angle, 0.5)},
      {"angle_deg_p90", quantile(angle, 0.9)},  {"offset_px_median", quantile(offset, 0.5)},
      {"offset_px_p90", quantile(offset, 0.9)}, {"same_line_share", share(same, errors.size())}};
}

/// Camera, calibration and front end: those of --config, else those beside the data.
std::string configure(const TracksOptions& options, const evaluation::ImageSequence& images,
                      Config* config) {
  std::string error;
  if (!options.config_file.empty()) {
    if (!loadConfig(options.config_file, options.options_file, config, &error)) {
      return "--config: " + error;
    }
    return "";
  }
  if (!images.calibration().has_value()) {
    return options.asl + " has no calibration that can be used (" + images.calibrationProblem() +
           "); give one with --config YAML";
  }
  config->calibration = images.calibration()->calibration;
  config->camera = images.calibration()->camera;
  if (!options.options_file.empty() && !loadOptions(options.options_file, config, &error)) {
    return "--options: " + error;
  }
  return "";
}

/// The scene beside the sequence; false without one, with a sentence when it cannot be read.
bool loadScene(const std::string& directory, simulation::Scene* scene, std::string* error) {
  const fs::path path = fs::path(directory) / "scene.json";
  std::error_code code;
  if (!fs::exists(path, code)) return false;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (simulation::sceneFromJson(text.str(), scene, error)) return true;
  *error = path.string() + ": " + *error;
  return false;
}

/// Errors against the scene; `frames_measured` frames had a true pose.
std::string measure(const TracksOptions& options, const simulation::Scene& scene,
                    const evaluation::ImageSequence& images, const Config& config,
                    const std::vector<FrameObservation>& frames,
                    const simulation::TrackTruthOptions& truth_options,
                    simulation::TrackQuality* quality, std::vector<int>* measured) {
  std::string error;
  const auto trajectory = simulation::makeSampledTrajectory(images.truth(), &error);
  if (trajectory == nullptr) return options.asl + ": ground truth: " + error;
  simulation::TrackTruth truth(scene, config.camera, truth_options);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double t = frames[i].t + config.calibration.td;
    if (!trajectory->covers(t)) continue;
    const simulation::Kinematics body = trajectory->at(t);
    truth.addFrame(frames[i], {body.R_w_b * config.calibration.R_b_c,
                               body.p_w_b + body.R_w_b * config.calibration.t_b_c});
    measured->push_back(static_cast<int>(i));
  }
  *quality = truth.evaluate();
  return "";
}

std::string writeFile(const std::string& folder, const std::string& name, const std::string& text) {
  const fs::path path = fs::path(folder) / name;
  std::ofstream file(path, std::ios::binary);
  file << text;
  return file.flush() ? "" : path.string() + " cannot be written";
}

std::string number(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  return out.str();
}

/// One line of the printed table: "name  value unit".
void print(std::ostream& out, const std::string& name, const Json& value, const char* unit,
           double factor = 1.0) {
  std::string text = "-";  // a NaN has become null
  if (value.is_number() && std::isfinite(value.get<double>())) {
    std::ostringstream digits;
    digits.precision(3);
    digits << factor * value.get<double>();
    text = digits.str();
  }
  std::string label = name;
  label.resize(44, ' ');
  out << "  " << label << text << (unit[0] == '\0' ? "" : " ") << unit << "\n";
}

void printSummary(const Json& summary, std::ostream& out) {
  out << summary.at("sequence").get<std::string>() << ": " << summary.at("images") << " images\n";
  for (const char* kind : {"points", "lines"}) {
    const Json& k = summary.at(kind);
    out << kind << "\n";
    print(out, "per image, median", k.at("per_image_median"), "");
    print(out, "per image, 10 % quantile", k.at("per_image_p10"), "");
    print(out, "track life, median", k.at("life_images_median"), "images");
    print(out, "survival to the next image", k.at("survival"), "%", 100.0);
    if (!k.contains("errors")) continue;
    const bool points = std::string(kind) == "points";
    for (const char* against : {"errors", "keyframe_errors"}) {
      const Json& e = k.at(against);
      const std::string suffix =
          std::string(against) == "errors" ? ", against first" : ", keyframe to keyframe";
      if (points) {
        print(out, "error" + suffix + ", median", e.at("median_px"), "px");
        print(out, "error" + suffix + ", 90 %", e.at("p90_px"), "px");
        print(out, "outliers" + suffix, e.at("outlier_share"), "%", 100.0);
      } else {
        print(out, "angle" + suffix + ", median", e.at("angle_deg_median"), "deg");
        print(out, "offset" + suffix + ", median", e.at("offset_px_median"), "px");
        print(out, "same line" + suffix, e.at("same_line_share"), "%", 100.0);
      }
    }
  }
  out << "time per image, median\n";
  for (const auto& [name, ms] : summary.at("stages_ms_median").items()) print(out, name, ms, "ms");
  print(out, "total", summary.at("total_ms_median"), "ms");
  print(out, "total, 90 %", summary.at("total_ms_p90"), "ms");
}

}  // namespace

int runTracks(const TracksOptions& options) {
  if (const std::string error = checkTracksOptions(options); !error.empty()) {
    return fail(kExitBadInput, error);
  }
  evaluation::ReadStatus status;
  const auto whole =
      evaluation::openAslFolder(options.asl, evaluation::ImageSequenceOptions(), &status);
  if (whole == nullptr) return fail(kExitBadInput, status.message);
  Config config;
  if (const std::string error = configure(options, *whole, &config); !error.empty()) {
    return fail(kExitBadInput, error);
  }
  for (const std::string& note : whole->notes()) std::cerr << "slim_init: note: " << note << "\n";
  simulation::Scene scene;
  std::string scene_error;
  const bool has_scene = loadScene(options.asl, &scene, &scene_error);
  if (!scene_error.empty()) return fail(kExitBadInput, scene_error);
  if (!options.out.empty()) {
    std::error_code code;
    fs::create_directories(options.out, code);
    if (!fs::is_directory(options.out, code)) {
      return fail(kExitBadInput, "--out: folder " + options.out + " cannot be made");
    }
  }

  Subsequence images(whole.get(), options.stride, options.limit);
  std::vector<FrameObservation> frames;
  evaluation::TrackingSummary tracking;
  std::ostringstream frames_csv;
  frames_csv
      << "stamp_ns,points,points_new,points_outliers,lines,lines_new,vp_found,gyro_bias_known"
         ",total_ms\n";
  {
    ProgressBar bar(images.name(), !options.quiet);
    evaluation::TrackingHooks hooks;
    hooks.progress = [&bar](int done, int total) { bar.update(done, total); };
    hooks.tracked = [&frames_csv](std::int64_t stamp_ns,
                                  const feature_tracker_lines::ImageFrontEnd& front_end) {
      const feature_tracker_lines::ImageReport& r = front_end.report();
      frames_csv << stamp_ns << ',' << r.points_tracked + r.points_new << ',' << r.points_new << ','
                 << r.points_outliers << ',' << r.lines_matched + r.lines_carried + r.lines_new
                 << ',' << r.lines_new << ',' << r.vp_found << ',' << r.gyro_bias_known << ','
                 << number(r.total_ms) << '\n';
      return std::string();
    };
    cv::setNumThreads(1);  // the times are those of one thread
    if (const std::string error =
            evaluation::trackImages(&images, config.camera, config.calibration, config.front_end,
                                    hooks, &frames, &tracking);
        !error.empty()) {
      return fail(kExitBadInput, options.asl + ": " + error);
    }
  }

  Json summary = {{"sequence", images.name()},
                  {"images", frames.size()},
                  {"stride", options.stride},
                  {"keyframe_interval_s", options.interval_s}};
  const auto points = [](const FrameObservation& f) -> const auto& { return f.points; };
  const auto lines = [](const FrameObservation& f) -> const auto& { return f.lines; };
  summary["points"] = json(persistenceOf(frames, points));
  summary["lines"] = json(persistenceOf(frames, lines));

  std::ostringstream points_csv;
  std::ostringstream lines_csv;
  points_csv << "against,id,stamp_ns,age_images,surface,error_px,occluded\n";
  lines_csv << "against,id,stamp_ns,age_images,surface,angle_deg,offset_px,end_px\n";
  if (has_scene && !whole->truth().empty()) {
    simulation::TrackTruthOptions truth_options;
    truth_options.keyframe_interval_s = options.interval_s;
    simulation::TrackQuality quality;
    std::vector<int> measured;
    if (const std::string error =
            measure(options, scene, *whole, config, frames, truth_options, &quality, &measured);
        !error.empty()) {
      return fail(kExitBadInput, error);
    }
    Json& p = summary["points"];
    p["errors"] = pointErrorsJson(quality.points, truth_options.outlier_px);
    p["keyframe_errors"] = pointErrorsJson(quality.keyframe_points, truth_options.outlier_px);
    p["tracks_without_truth"] = quality.point_tracks_without_truth;
    Json& l = summary["lines"];
    l["errors"] = lineErrorsJson(quality.lines, truth_options.same_line_px);
    l["keyframe_errors"] = lineErrorsJson(quality.keyframe_lines, truth_options.same_line_px);
    l["tracks_measured"] = quality.line_tracks - quality.line_tracks_without_truth;
    l["tracks_without_truth"] = quality.line_tracks_without_truth;
    const auto stamp = [&](int frame) {
      return images.t0Ns() +
             static_cast<std::int64_t>(std::llround(
                 1e9 *
                 frames[static_cast<std::size_t>(measured[static_cast<std::size_t>(frame)])].t));
    };
    const auto surface = [&scene](int solid) {
      std::string name = scene.solids[static_cast<std::size_t>(solid)].name;
      std::replace(name.begin(), name.end(), ',', ' ');  // names are the user's in his own scenes
      return name + " " + std::to_string(solid);
    };
    for (const auto& [name, list] : {std::make_pair("first", &quality.points),
                                     std::make_pair("keyframe", &quality.keyframe_points)}) {
      for (const simulation::PointError& e : *list) {
        points_csv << name << ',' << e.id << ',' << stamp(e.frame) << ',' << e.age << ','
                   << surface(e.solid) << ',' << number(e.error_px) << ',' << e.occluded << '\n';
      }
    }
    for (const auto& [name, list] : {std::make_pair("first", &quality.lines),
                                     std::make_pair("keyframe", &quality.keyframe_lines)}) {
      for (const simulation::LineError& e : *list) {
        lines_csv << name << ',' << e.id << ',' << stamp(e.frame) << ',' << e.age << ','
                  << surface(e.solid) << ',' << number(e.angle_deg) << ',' << number(e.offset_px)
                  << ',' << number(e.end_px) << '\n';
      }
    }
  } else {
    std::cerr << "slim_init: note: " << options.asl << " has no "
              << (has_scene ? "ground truth" : "scene.json") << ": no errors are measured\n";
  }
  summary["line_detector"] = tracking.line_detector;
  summary["stages_ms_median"] = Json::object();
  for (const StageTime& stage : tracking.stages_ms_median) {
    summary["stages_ms_median"][stage.name] = stage.ms;
  }
  summary["total_ms_median"] = tracking.total_ms_median;
  summary["total_ms_p90"] = tracking.total_ms_p90;

  if (!options.out.empty()) {
    for (const auto& [name, text] : {std::make_pair("tracks.json", summary.dump(2) + "\n"),
                                     std::make_pair("frames.csv", frames_csv.str()),
                                     std::make_pair("points.csv", points_csv.str()),
                                     std::make_pair("lines.csv", lines_csv.str())}) {
      if (const std::string error = writeFile(options.out, name, text); !error.empty()) {
        return fail(kExitInternal, "--out: " + error);
      }
    }
  }
  if (!options.quiet) printSummary(summary, std::cout);
  return kExitOk;
}

}  // namespace slim_init::tools

#else  // SLIM_INIT_HAS_FEATURE_TRACKER_LINES

namespace slim_init::tools {

int runTracks(const TracksOptions&) {
  std::cerr << "slim_init: tracks is not part of this program: it was built without "
               "feature_tracker_lines (SLIM_INIT_BUILD_FEATURE_TRACKER_LINES=OFF)\n";
  return kExitBadInput;
}

}  // namespace slim_init::tools

#endif  // SLIM_INIT_HAS_FEATURE_TRACKER_LINES
