// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "tracks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "exit_code.h"
#include "load_images.h"
#include "progress_bar.h"
#include "slim_init/config/config.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/track_images.h"
#include "slim_init/evaluation/write_file.h"
#include "slim_init/simulation/scene.h"
#include "slim_init/simulation/track_truth.h"
#include "slim_init/simulation/trajectory.h"

namespace slim_init::tools {

std::vector<AbOption> tracksOptionTable(TracksOptions* options) {
  TracksOptions& o = *options;
  return {
      {"asl", &o.asl, "DIR",
       "Sequence in ASL layout; with DIR/scene.json and ground truth errors are measured", ""},
      {"config", &o.config_file, "FILE",
       "YAML file with camera, extrinsic, td and section slim_init: (default: the sensor.yaml "
       "files beside the data)",
       ""},
      {"options", &o.options_file, "FILE",
       "YAML file whose section slim_init: takes precedence over --config's", ""},
      {"stride", &o.stride, "N", "Take every N-th image", "", 1, 1000},
      {"limit", &o.limit, "N", "Stop after this many images (0: no limit)", "", 0, 1000000000},
      {"interval", &o.interval_s, "X", "Time between keyframes [s]", "", 0.01, 100.0},
      {"out", &o.out, "DIR",
       "Folder for tracks.json, frames.csv, points.csv and lines.csv (default: nothing is written)",
       ""},
      {"quiet", &o.quiet, "", "No progress bar and no table", ""},
  };
}

namespace {

/// Conditions over several options: an empty string, or a message.
std::string checkOptions(const TracksOptions& o) {
  if (o.asl.empty()) return "--asl DIR is needed";
  return "";
}

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

int fail(ExitCode code, const std::string& message) {
  std::cerr << "slim_init: " << message << "\n";
  return code;
}

/// Every `stride`-th image of another sequence, `limit` of them at most (0: all).
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

/// How long the features of one kind are tracked; needs no ground truth.
struct Persistence {
  std::vector<double> per_frame;  ///< features in each image
  std::size_t carried = 0;        ///< features of an image that are in the next one too
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

/// Camera, calibration and front end: those of --config, otherwise those beside the data.
std::string configure(const TracksOptions& options, const evaluation::ImageSequence& images,
                      Config* config) {
  if (options.config_file.empty()) {
    return configureFromData(options.asl, options.options_file, images, config);
  }
  std::string error;
  if (loadConfig(options.config_file, options.options_file, config, &error)) return "";
  return "--config: " + error;
}

/// The scene beside the sequence; none where there is no file. `error` says why it cannot be read.
std::optional<simulation::Scene> loadScene(const std::string& directory, std::string* error) {
  const fs::path path = fs::path(directory) / "scene.json";
  std::error_code code;
  if (!fs::exists(path, code)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  simulation::Scene scene;
  if (simulation::sceneFromJson(text.str(), &scene, error)) return scene;
  *error = path.string() + ": " + *error;
  return std::nullopt;
}

/// What the command works on.
struct Input {
  std::unique_ptr<evaluation::ImageSequence> images;  ///< all of them
  Config config;
  std::optional<simulation::Scene> scene;

  bool hasTruth() const { return scene.has_value() && !images->truth().empty(); }
};

/// Opens the sequence and prints its notes. Returns an empty string or a message.
std::string openInput(const TracksOptions& options, Input* input) {
  evaluation::ReadStatus status;
  input->images =
      evaluation::openAslFolder(options.asl, evaluation::ImageSequenceOptions(), &status);
  if (input->images == nullptr) return status.message;
  std::string error = configure(options, *input->images, &input->config);
  if (!error.empty()) return error;
  for (const std::string& note : input->images->notes()) {
    std::cerr << "slim_init: note: " << note << "\n";
  }
  input->scene = loadScene(options.asl, &error);
  return error;
}

std::string number(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  return out.str();
}

/// The front end's output over the images.
struct TrackedImages {
  std::vector<FrameObservation> frames;
  evaluation::TrackingSummary summary;
  std::string csv;  ///< frames.csv
};

/// Tracks all images of `images` in one thread, whose times are measured. Returns an empty string
/// or a message.
std::string track(const TracksOptions& options, const Config& config, Subsequence* images,
                  TrackedImages* tracked) {
  std::ostringstream csv;
  csv << "stamp_ns,points,points_new,points_outliers,lines,lines_new,vp_found,gyro_bias_known"
         ",total_ms\n";
  ProgressBar bar(images->name(), !options.quiet);
  evaluation::TrackingHooks hooks;
  hooks.progress = [&bar](int done, int total) { bar.update(done, total); };
  hooks.tracked = [&csv](std::int64_t stamp_ns,
                         const feature_tracker_lines::ImageFrontEnd& front_end) {
    const feature_tracker_lines::ImageReport& r = front_end.report();
    csv << stamp_ns << ',' << r.points_tracked + r.points_new << ',' << r.points_new << ','
        << r.points_outliers << ',' << r.lines_matched + r.lines_carried + r.lines_new << ','
        << r.lines_new << ',' << r.vp_found << ',' << r.gyro_bias_known << ',' << number(r.total_ms)
        << '\n';
    return std::string();
  };
  cv::setNumThreads(1);
  const std::string error =
      evaluation::trackImages(images, config.camera, config.calibration, config.front_end, hooks,
                              &tracked->frames, &tracked->summary);
  tracked->csv = csv.str();
  return error.empty() ? "" : options.asl + ": " + error;
}

/// Errors of the tracks against the scene; `stamps_ns` of the frames that have a true pose.
struct MeasuredTracks {
  simulation::TrackQuality quality;
  std::vector<std::int64_t> stamps_ns;
};

/// Measures the tracks in all frames that the ground truth covers, with every observation at the
/// time of its row. Returns an empty string or a message.
std::string measure(const TracksOptions& options, const Input& input,
                    const std::vector<FrameObservation>& frames,
                    const simulation::TrackTruthOptions& truth_options, MeasuredTracks* measured) {
  std::string error;
  const auto trajectory = simulation::makeSampledTrajectory(input.images->truth(), &error);
  if (trajectory == nullptr) return options.asl + ": ground truth: " + error;
  const Calibration& calibration = input.config.calibration;
  simulation::TrackTruth truth(*input.scene, input.config.camera, truth_options);
  const double reach = 0.5 * calibration.readout_s;  // of the first and the last row
  for (const FrameObservation& frame : frames) {
    const double t = calibration.imuTime(frame.t);
    if (!trajectory->covers(t - reach) || !trajectory->covers(t + reach)) continue;
    truth.addFrame(frame, [&](double row) {
      const simulation::Kinematics body = trajectory->at(t + row * calibration.readout_s);
      return simulation::CameraPose{body.R_w_b * calibration.R_b_c,
                                    body.p_w_b + body.R_w_b * calibration.t_b_c};
    });
    measured->stamps_ns.push_back(input.images->t0Ns() +
                                  static_cast<std::int64_t>(std::llround(1e9 * frame.t)));
  }
  measured->quality = truth.evaluate();
  return "";
}

Json summaryJson(const TracksOptions& options, const std::string& name,
                 const std::vector<FrameObservation>& frames) {
  const auto points = [](const FrameObservation& f) -> const auto& { return f.points; };
  const auto lines = [](const FrameObservation& f) -> const auto& { return f.lines; };
  return {{"sequence", name},
          {"images", frames.size()},
          {"stride", options.stride},
          {"keyframe_interval_s", options.interval_s},
          {"points", json(persistenceOf(frames, points))},
          {"lines", json(persistenceOf(frames, lines))}};
}

void addErrors(const simulation::TrackQuality& quality,
               const simulation::TrackTruthOptions& truth_options, Json* summary) {
  Json& p = (*summary)["points"];
  p["errors"] = pointErrorsJson(quality.points, truth_options.outlier_px);
  p["keyframe_errors"] = pointErrorsJson(quality.keyframe_points, truth_options.outlier_px);
  p["tracks_without_truth"] = quality.point_tracks_without_truth;
  Json& l = (*summary)["lines"];
  l["errors"] = lineErrorsJson(quality.lines, truth_options.same_line_px);
  l["keyframe_errors"] = lineErrorsJson(quality.keyframe_lines, truth_options.same_line_px);
  l["tracks_measured"] = quality.line_tracks - quality.line_tracks_without_truth;
  l["tracks_without_truth"] = quality.line_tracks_without_truth;
}

void addTimes(const evaluation::TrackingSummary& tracking, Json* summary) {
  Json& s = *summary;
  s["line_detector"] = tracking.line_detector;
  s["stages_ms_median"] = Json::object();
  for (const StageTime& stage : tracking.stages_ms_median) {
    s["stages_ms_median"][stage.name] = stage.ms;
  }
  s["total_ms_median"] = tracking.total_ms_median;
  s["total_ms_p90"] = tracking.total_ms_p90;
}

/// Name and number of a solid. Commas separate columns, and names come from the user's scenes.
std::string surfaceName(const simulation::Scene& scene, int solid) {
  std::string name = scene.solids[static_cast<std::size_t>(solid)].name;
  std::replace(name.begin(), name.end(), ',', ' ');
  return name + " " + std::to_string(solid);
}

/// points.csv or lines.csv: `columns` behind those that both have, which `write` fills in.
template <typename Error, typename Write>
std::string errorsCsv(const MeasuredTracks& measured, const Input& input, const char* columns,
                      std::vector<Error> simulation::TrackQuality::*first,
                      std::vector<Error> simulation::TrackQuality::*keyframe, const Write& write) {
  std::ostringstream out;
  out << "against,id,stamp_ns,age_images,surface," << columns << "\n";
  for (const auto& [against, errors] :
       {std::pair("first", first), std::pair("keyframe", keyframe)}) {
    for (const Error& e : measured.quality.*errors) {
      out << against << ',' << e.id << ',' << measured.stamps_ns[static_cast<std::size_t>(e.frame)]
          << ',' << e.age << ',' << surfaceName(*input.scene, e.solid) << ',' << write(e) << '\n';
    }
  }
  return out.str();
}

std::string pointsCsv(const MeasuredTracks& measured, const Input& input) {
  using simulation::TrackQuality;
  return errorsCsv(measured, input, "error_px,occluded", &TrackQuality::points,
                   &TrackQuality::keyframe_points, [](const simulation::PointError& e) {
                     return number(e.error_px) + (e.occluded ? ",1" : ",0");
                   });
}

std::string linesCsv(const MeasuredTracks& measured, const Input& input) {
  using simulation::TrackQuality;
  return errorsCsv(measured, input, "angle_deg,offset_px,end_px", &TrackQuality::lines,
                   &TrackQuality::keyframe_lines, [](const simulation::LineError& e) {
                     return number(e.angle_deg) + "," + number(e.offset_px) + "," +
                            number(e.end_px);
                   });
}

/// Name and text of every file of --out.
using Files = std::vector<std::pair<std::string, std::string>>;

constexpr double kPercent = 100.0;  // of a share

/// One line of the printed table: "name  value unit". `factor` converts to the unit.
void print(std::ostream& out, const std::string& name, const Json& value, const char* unit,
           double factor = 1.0) {
  std::string text = "-";  // JSON has null for NaN
  if (value.is_number() && std::isfinite(value.get<double>())) {
    std::ostringstream digits;
    digits.precision(3);
    digits << factor * value.get<double>();
    text = digits.str();
  }
  std::string label = name;
  constexpr std::size_t kLabelColumns = 44;
  label.resize(kLabelColumns, ' ');
  out << "  " << label << text << (unit[0] == '\0' ? "" : " ") << unit << "\n";
}

/// Errors of points or lines against one reference; `suffix` names it.
void printErrors(const Json& errors, bool points, const std::string& suffix, std::ostream& out) {
  if (points) {
    print(out, "error" + suffix + ", median", errors.at("median_px"), "px");
    print(out, "error" + suffix + ", 90 %", errors.at("p90_px"), "px");
    print(out, "outliers" + suffix, errors.at("outlier_share"), "%", kPercent);
  } else {
    print(out, "angle" + suffix + ", median", errors.at("angle_deg_median"), "deg");
    print(out, "offset" + suffix + ", median", errors.at("offset_px_median"), "px");
    print(out, "same line" + suffix, errors.at("same_line_share"), "%", kPercent);
  }
}

void printSummary(const Json& summary, std::ostream& out) {
  out << summary.at("sequence").get<std::string>() << ": " << summary.at("images") << " images\n";
  for (const std::string kind : {"points", "lines"}) {
    const Json& k = summary.at(kind);
    out << kind << "\n";
    print(out, "per image, median", k.at("per_image_median"), "");
    print(out, "per image, 10 % quantile", k.at("per_image_p10"), "");
    print(out, "track life, median", k.at("life_images_median"), "images");
    print(out, "survival to the next image", k.at("survival"), "%", kPercent);
    if (!k.contains("errors")) continue;
    printErrors(k.at("errors"), kind == "points", ", against first", out);
    printErrors(k.at("keyframe_errors"), kind == "points", ", keyframe to keyframe", out);
  }
  out << "time per image, median\n";
  for (const auto& [name, ms] : summary.at("stages_ms_median").items()) print(out, name, ms, "ms");
  print(out, "total", summary.at("total_ms_median"), "ms");
  print(out, "total, 90 %", summary.at("total_ms_p90"), "ms");
}

}  // namespace

int runTracks(const TracksOptions& options) {
  std::string error = checkOptions(options);
  if (!error.empty()) return fail(kExitBadInput, error);
  Input input;
  if (error = openInput(options, &input); !error.empty()) return fail(kExitBadInput, error);
  if (error = makeFolder("--out", options.out); !error.empty()) return fail(kExitBadInput, error);

  Subsequence images(input.images.get(), options.stride, options.limit);
  TrackedImages tracked;
  if (error = track(options, input.config, &images, &tracked); !error.empty()) {
    return fail(kExitBadInput, error);
  }

  Json summary = summaryJson(options, images.name(), tracked.frames);
  MeasuredTracks measured;
  if (input.hasTruth()) {
    simulation::TrackTruthOptions truth_options;
    truth_options.keyframe_interval_s = options.interval_s;
    if (error = measure(options, input, tracked.frames, truth_options, &measured); !error.empty()) {
      return fail(kExitBadInput, error);
    }
    addErrors(measured.quality, truth_options, &summary);
  } else {
    std::cerr << "slim_init: note: " << options.asl << " has no "
              << (input.scene.has_value() ? "ground truth" : "scene.json")
              << ": no errors are measured\n";
  }
  addTimes(tracked.summary, &summary);

  const Files files = {{"tracks.json", summary.dump(2) + "\n"},
                       {"frames.csv", tracked.csv},
                       {"points.csv", pointsCsv(measured, input)},
                       {"lines.csv", linesCsv(measured, input)}};
  for (const auto& [name, text] : files) {
    if (options.out.empty()) break;
    if (error = evaluation::writeFile((fs::path(options.out) / name).string(), text);
        !error.empty()) {
      return fail(kExitInternal, "--out: " + error);
    }
  }
  if (!options.quiet) printSummary(summary, std::cout);
  return kExitOk;
}

}  // namespace slim_init::tools
