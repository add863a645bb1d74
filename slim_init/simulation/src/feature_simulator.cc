// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/feature_simulator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "random.h"

namespace slim_init::simulation {
namespace {

constexpr double kMinPointDepth = 0.2;  // [m] in front of the camera
constexpr double kMinLineDepth = 0.3;   // [m] near plane that segments are cut at
constexpr double kPointBorder = 5.0;    // [px] into which no patch of a tracker fits
constexpr double kMinNewLine =
    50.0;  // [px]; a detector reports shorter ones too, but too many of them
constexpr int kOcclusionSamples = 9;  // along a segment
// Detection confidence 1 - exp(-length / scale): 0.57 at 50 px, 0.96 at 200 px.
constexpr double kConfidenceLength = 60.0;  // [px]
constexpr double kConfidenceNoise = 0.03;
constexpr double kMatchSpread = 0.1;  // of a match quality 1 - |n| spread

// Rolling shutter: a row time is found when a further step moves it by less [s]; the map shrinks
// steps by the share of the image that the point crosses during the readout.
constexpr double kRowTimeTolerance = 1e-13;
constexpr int kMaxRowTimeSteps = 100;
// Halvings with which the end of a segment that lies outside the image is brought to its edge.
constexpr int kEndHalvings = 40;

struct CameraPose {
  Eigen::Matrix3d R_c_w;
  Eigen::Vector3d p_w_c;

  Eigen::Vector3d toCamera(const Eigen::Vector3d& p_w) const { return R_c_w * (p_w - p_w_c); }
};

Eigen::Vector2d project(const PinholeCamera& camera, const Eigen::Vector3d& p_c) {
  return {camera.fx * p_c.x() / p_c.z() + camera.cx, camera.fy * p_c.y() / p_c.z() + camera.cy};
}

Eigen::Vector3d bearingOf(const PinholeCamera& camera, const Eigen::Vector2d& pixel) {
  return Eigen::Vector3d((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy,
                         1.0)
      .normalized();
}

/// Where a place of the world is in an image, and when it was exposed.
struct Sight {
  CameraPose pose;        ///< at the exposure of its row
  Eigen::Vector3d p_c;    ///< in that camera [m]
  Eigen::Vector2d pixel;  ///< [px]; set where the place lies in front of the camera
  double dt = 0.0;        ///< relative to the middle row [s]
};

/// The exposure of one image: all rows at once, or one after the other.
class Exposure {
 public:
  Exposure(const Trajectory& trajectory, const Calibration& calibration,
           const PinholeCamera& camera, double t_imu)
      : trajectory_(trajectory),
        calibration_(calibration),
        camera_(camera),
        t_imu_(t_imu),
        middle_(poseAt(0.0)) {}

  const CameraPose& middle() const { return middle_; }
  bool rolling() const { return calibration_.readout_s > 0.0; }

  /// Exposure of a row relative to the middle one [s]; zero for a global shutter.
  double rowTimeOf(const Eigen::Vector2d& pixel) const {
    return rolling() ? rowTime(pixel.y(), camera_.height, calibration_.readout_s) : 0.0;
  }

  /// False where a place of the world is not in front of the camera by `min_depth` [m] when its row
  /// is exposed, or is swept by no row. The row that a point is seen in depends on the pose at the
  /// exposure of that very row: a fixed point.
  bool see(const Eigen::Vector3d& p_w, double min_depth, Sight* sight) const {
    sight->pose = middle_;
    sight->dt = 0.0;
    for (int step = 0; step < kMaxRowTimeSteps; ++step) {
      sight->p_c = sight->pose.toCamera(p_w);
      if (!(sight->p_c.z() > min_depth)) return false;
      sight->pixel = project(camera_, sight->p_c);
      const double dt = rowTimeOf(sight->pixel);
      const bool found = std::abs(dt - sight->dt) <= kRowTimeTolerance;
      // A row so far away is outside the image, and its pose would be that of another one.
      if (std::abs(dt) > calibration_.readout_s) return false;
      sight->dt = dt;
      if (found) return true;
      sight->pose = poseAt(dt);
    }
    return false;
  }

 private:
  CameraPose poseAt(double dt) const {
    const Kinematics body = trajectory_.at(t_imu_ + dt);
    CameraPose pose;
    pose.R_c_w = (body.R_w_b * calibration_.R_b_c).transpose();
    pose.p_w_c = body.p_w_b + body.R_w_b * calibration_.t_b_c;
    return pose;
  }

  const Trajectory& trajectory_;
  const Calibration& calibration_;
  const PinholeCamera& camera_;
  double t_imu_;
  CameraPose middle_;
};

bool inImage(const PinholeCamera& camera, const Eigen::Vector2d& pixel, double border) {
  return pixel.x() >= border && pixel.x() <= camera.width - border && pixel.y() >= border &&
         pixel.y() <= camera.height - border;
}

// Number of frames of a track: geometric with the given mean. Geometric lives have no memory, so
// what remains of one at the first frame is distributed as a new one: the stationary state.
class LifeTimes {
 public:
  LifeTimes(unsigned seed, const char* stream, double mean)
      : random_(seed, stream), scale_(-1.0 / std::log1p(-1.0 / mean)) {}

  long long draw() {
    constexpr double kForever = 1e15;  // fits a long long
    return 1 + static_cast<long long>(std::min(kForever, scale_ * random_.exponential()));
  }

 private:
  Random random_;
  double scale_;  // [frames]
};

// Removes and returns a random element, in constant time.
int takeRandom(std::vector<int>* list, Random* random) {
  const int i = random->index(static_cast<int>(list->size()));
  const int element = (*list)[i];
  (*list)[i] = list->back();
  list->pop_back();
  return element;
}

class PointTracker {
 public:
  PointTracker(const World& world, const FeatureSimulationOptions& options,
               FeatureSimulationCounts* counts)
      : world_(world),
        options_(options),
        counts_(counts),
        tracked_(world.points.size(), false),
        in_view_(world.points.size(), false),
        pixels_(world.points.size()),
        centres_(world.points.size()),
        choice_(options.seed, "points/choice"),
        lives_(options.seed, "points/life", options.track_life),
        outlier_(options.seed, "points/outlier"),
        drift_(options.seed, "points/drift"),
        noise_(options.seed, "points/noise") {}

  void observe(const Exposure& exposure, std::vector<PointObservation>* observations) {
    projectAll(exposure);
    keepAlive();
    refill();
    observations->reserve(tracks_.size());
    for (Track& track : tracks_) {
      const Eigen::Vector2d pixel =
          pixels_[track.point] + track.offset + options_.pixel_noise * noise_.gaussian2();
      // As a tracker tells it: by the row in which the point was found.
      observations->push_back({track.id, bearingOf(options_.camera, pixel), pixel,
                               imageRow(pixel.y(), options_.camera.height)});
    }
  }

 private:
  struct Track {
    FeatureId id = -1;
    int point = -1;
    long long frames_left = 0;
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();    // drift and sliding so far [px]
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // of an outlier [px/frame]
  };

  void projectAll(const Exposure& exposure) {
    Sight sight;
    for (std::size_t i = 0; i < world_.points.size(); ++i) {
      in_view_[i] = exposure.see(world_.points[i], kMinPointDepth, &sight);
      if (!in_view_[i]) continue;
      pixels_[i] = sight.pixel;
      centres_[i] = sight.pose.p_w_c;
      in_view_[i] = inImage(options_.camera, pixels_[i], kPointBorder);
    }
  }

  bool unhidden(int point) const { return world_.visible(centres_[point], world_.points[point]); }

  void keepAlive() {
    std::size_t kept = 0;
    for (Track& track : tracks_) {
      track.offset += track.velocity + options_.drift * drift_.gaussian2();
      const bool alive =
          --track.frames_left > 0 && in_view_[track.point] &&
          inImage(options_.camera, pixels_[track.point] + track.offset, kPointBorder) &&
          unhidden(track.point);
      if (alive) {
        tracks_[kept++] = track;
      } else {
        tracked_[track.point] = false;
      }
    }
    tracks_.resize(kept);
  }

  void refill() {
    if (static_cast<int>(tracks_.size()) >= options_.max_points) return;
    candidates_.clear();
    for (int i = 0; i < static_cast<int>(in_view_.size()); ++i) {
      if (in_view_[i] && !tracked_[i]) candidates_.push_back(i);
    }
    while (static_cast<int>(tracks_.size()) < options_.max_points && !candidates_.empty()) {
      const int point = takeRandom(&candidates_, &choice_);
      if (crowded(pixels_[point])) continue;
      if (!unhidden(point)) continue;
      Track track;
      track.id = next_id_++;
      track.point = point;
      track.frames_left = lives_.draw();
      // Drawn for every track, so that the rate does not shift the stream.
      const bool is_outlier = outlier_.uniform() < options_.outlier_rate;
      const Eigen::Vector2d velocity = options_.outlier_speed * outlier_.gaussian2();
      if (is_outlier) track.velocity = velocity;
      tracked_[point] = true;
      tracks_.push_back(track);
      ++counts_->point_tracks;
      if (is_outlier) ++counts_->outlier_tracks;
    }
  }

  bool crowded(const Eigen::Vector2d& pixel) const {
    const double limit = options_.min_point_distance * options_.min_point_distance;
    return std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& track) {
      return (pixels_[track.point] + track.offset - pixel).squaredNorm() < limit;
    });
  }

  const World& world_;
  const FeatureSimulationOptions& options_;
  FeatureSimulationCounts* counts_;
  std::vector<Track> tracks_;  // ascending in id
  FeatureId next_id_ = 0;
  std::vector<char> tracked_;            // per point of the world
  std::vector<char> in_view_;            // per point of the world, ignoring occlusion
  std::vector<Eigen::Vector2d> pixels_;  // of the points in view
  // Of the camera, when the row of each point in view was exposed.
  std::vector<Eigen::Vector3d> centres_;
  std::vector<int> candidates_;
  Random choice_;
  LifeTimes lives_;
  Random outlier_;
  Random drift_;
  Random noise_;
};

// The visible part of a segment in one image. Its ends are pixel and inverse depth [1/m], which is
// linear along it.
struct LineView {
  bool visible = false;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  Eigen::Vector3d end = Eigen::Vector3d::Zero();

  double length() const { return (end - start).head<2>().norm(); }
  Eigen::Vector3d at(double share) const { return start + share * (end - start); }
};

class LineTracker {
 public:
  LineTracker(const World& world, const FeatureSimulationOptions& options,
              FeatureSimulationCounts* counts)
      : world_(world),
        options_(options),
        counts_(counts),
        tracked_(world.segments.size(), false),
        views_(world.segments.size()),
        choice_(options.seed, "lines/choice"),
        lives_(options.seed, "lines/life", options.track_life),
        slide_(options.seed, "lines/slide"),
        noise_(options.seed, "lines/noise"),
        quality_(options.seed, "lines/quality") {
    // Inward normals of the viewing pyramid in c.
    const PinholeCamera& c = options.camera;
    planes_ = {Eigen::Vector3d(c.fx, 0.0, c.cx), Eigen::Vector3d(-c.fx, 0.0, c.width - c.cx),
               Eigen::Vector3d(0.0, c.fy, c.cy), Eigen::Vector3d(0.0, -c.fy, c.height - c.cy)};
  }

  // Which lines there are, and which part of each is seen, is decided at the middle row; where the
  // two ends of that part lie, each at its own row.
  void observe(const Exposure& exposure, std::vector<LineObservation>* observations) {
    const CameraPose& pose = exposure.middle();
    for (std::size_t i = 0; i < world_.segments.size(); ++i) {
      views_[i] =
          clip(pose.toCamera(world_.segments[i].start), pose.toCamera(world_.segments[i].end));
    }
    keepAlive(pose);
    refill(pose);
    observations->reserve(tracks_.size());
    for (Track& track : tracks_) {
      LineObservation observation;
      if (makeObservation(exposure, track, &observation)) {
        observations->push_back(observation);
      } else {
        track.frames_left = 0;  // it ends here
      }
    }
  }

 private:
  struct Track {
    FeatureId id = -1;
    int segment = -1;
    long long frames_left = 0;
    bool is_new = true;  // no match to the previous image
    LineView view;       // cut at both ends as the detector saw it, without noise
  };

  // Cuts a segment, end points in c, to the viewing pyramid.
  LineView clip(const Eigen::Vector3d& start_c, const Eigen::Vector3d& end_c) const {
    const Eigen::Vector3d step = end_c - start_c;
    double from = 0.0;
    double to = 1.0;
    const auto cut = [&](double at_start, double change) {
      if (change == 0.0) {
        if (at_start < 0.0) to = -1.0;
      } else if (change > 0.0) {
        from = std::max(from, -at_start / change);
      } else {
        to = std::min(to, -at_start / change);
      }
    };
    cut(start_c.z() - kMinLineDepth, step.z());
    for (const Eigen::Vector3d& plane : planes_) {
      if (from >= to) break;
      cut(plane.dot(start_c), plane.dot(step));
    }
    LineView view;
    if (from >= to) return view;
    const auto end = [this](const Eigen::Vector3d& p_c) {
      const Eigen::Vector2d pixel = project(options_.camera, p_c);
      return Eigen::Vector3d(pixel.x(), pixel.y(), 1.0 / p_c.z());
    };
    view.visible = true;
    view.start = end(start_c + from * step);
    view.end = end(start_c + to * step);
    return view;
  }

  // Cuts a view to the longest run of samples that nothing hides.
  LineView withoutHidden(const CameraPose& pose, const LineView& view) const {
    if (!view.visible || world_.obstacles.empty()) return view;
    int run = 0, best_run = 0, best_end = 0;
    for (int k = 0; k < kOcclusionSamples; ++k) {
      const Eigen::Vector3d p_c = placeAt(view, static_cast<double>(k) / (kOcclusionSamples - 1));
      run = world_.visible(pose.p_w_c, pose.R_c_w.transpose() * p_c + pose.p_w_c) ? run + 1 : 0;
      if (run > best_run) {
        best_run = run;
        best_end = k;
      }
    }
    if (best_run < 2) return LineView();
    return part(view, static_cast<double>(best_end - best_run + 1) / (kOcclusionSamples - 1),
                static_cast<double>(best_end) / (kOcclusionSamples - 1));
  }

  // The place in c.
  Eigen::Vector3d placeAt(const LineView& view, double share) const {
    const Eigen::Vector3d at = view.at(share);
    const PinholeCamera& c = options_.camera;
    return Eigen::Vector3d((at.x() - c.cx) / c.fx, (at.y() - c.cy) / c.fy, 1.0) / at.z();
  }

  static LineView part(const LineView& view, double from, double to) {
    return {view.visible, view.at(from), view.at(to)};
  }

  // What the detector finds of a segment in this image.
  LineView detect(const CameraPose& pose, int segment) {
    const double cut_start = options_.line_slide * slide_.uniform();
    const double cut_end = options_.line_slide * slide_.uniform();
    const LineView view = withoutHidden(pose, views_[segment]);
    return view.visible ? part(view, cut_start, 1.0 - cut_end) : view;
  }

  bool longEnough(const LineView& view) const {
    return view.visible && view.length() >= options_.min_line_length_px;
  }

  void keepAlive(const CameraPose& pose) {
    std::size_t kept = 0;
    for (Track& track : tracks_) {
      track.is_new = false;
      track.view = detect(pose, track.segment);
      if (--track.frames_left <= 0 || !longEnough(track.view)) {
        tracked_[track.segment] = false;
        continue;
      }
      tracks_[kept++] = track;
    }
    tracks_.resize(kept);
  }

  void refill(const CameraPose& pose) {
    if (static_cast<int>(tracks_.size()) >= options_.max_lines) return;
    std::vector<int> candidates;
    for (int i = 0; i < static_cast<int>(views_.size()); ++i) {
      if (!tracked_[i] && views_[i].visible && views_[i].length() >= kMinNewLine) {
        candidates.push_back(i);
      }
    }
    while (static_cast<int>(tracks_.size()) < options_.max_lines && !candidates.empty()) {
      const int segment = takeRandom(&candidates, &choice_);
      if (withoutHidden(pose, views_[segment]).length() < kMinNewLine) continue;
      const LineView view = detect(pose, segment);
      if (longEnough(view)) start(segment, view);
    }
  }

  void start(int segment, const LineView& view) {
    Track track;
    track.id = next_id_++;
    track.segment = segment;
    track.frames_left = lives_.draw();
    track.view = view;
    tracked_[segment] = true;
    tracks_.push_back(track);
    ++counts_->line_tracks;
  }

  // Where the end of a view at share `from` is seen when its row is exposed; brought towards the
  // share `to` where it lies outside the image by then. False where nothing of the line is inside.
  bool seeEnd(const Exposure& exposure, const LineView& view, double from, double to,
              Eigen::Vector2d* pixel) const {
    *pixel = (from < 0.5 ? view.start : view.end).head<2>();
    if (!exposure.rolling()) return true;
    const CameraPose& pose = exposure.middle();
    Sight sight;
    const auto seen = [&](double share) {
      const Eigen::Vector3d p_w = pose.R_c_w.transpose() * placeAt(view, share) + pose.p_w_c;
      return exposure.see(p_w, 0.5 * kMinLineDepth, &sight) &&
             inImage(options_.camera, sight.pixel, 0.0);
    };
    int inner = 0;
    const auto shareOf = [&](int k) { return from + (to - from) * k / (kOcclusionSamples - 1); };
    while (inner < kOcclusionSamples && !seen(shareOf(inner))) ++inner;
    if (inner == kOcclusionSamples) return false;
    if (inner > 0) {
      double outside = shareOf(inner - 1), inside = shareOf(inner);
      for (int k = 0; k < kEndHalvings; ++k) {
        const double share = 0.5 * (outside + inside);
        (seen(share) ? inside : outside) = share;
      }
      seen(inside);
    }
    *pixel = sight.pixel;
    return true;
  }

  // False where the rows of a rolling shutter miss the line.
  bool makeObservation(const Exposure& exposure, const Track& track, LineObservation* observation) {
    LineObservation& o = *observation;
    o.id = track.id;
    if (!seeEnd(exposure, track.view, 0.0, 1.0, &o.start_pixel) ||
        !seeEnd(exposure, track.view, 1.0, 0.0, &o.end_pixel)) {
      return false;
    }
    if (exposure.rolling() && (o.end_pixel - o.start_pixel).norm() < options_.min_line_length_px) {
      return false;
    }
    o.start_pixel += options_.line_noise * noise_.gaussian2();
    o.end_pixel += options_.line_noise * noise_.gaussian2();
    o.start_row = imageRow(o.start_pixel.y(), options_.camera.height);
    o.end_row = imageRow(o.end_pixel.y(), options_.camera.height);
    o.start_bearing = bearingOf(options_.camera, o.start_pixel);
    o.end_bearing = bearingOf(options_.camera, o.end_pixel);
    o.length_px = (o.end_pixel - o.start_pixel).norm();
    const double confidence =
        1.0 - std::exp(-o.length_px / kConfidenceLength) + kConfidenceNoise * quality_.gaussian();
    o.detection_confidence = std::clamp(confidence, 0.0, 1.0);
    const double mismatch = std::abs(quality_.gaussian()) * kMatchSpread;
    o.match_quality = track.is_new ? 1.0 : std::clamp(1.0 - mismatch, 0.0, 1.0);
    return true;
  }

  const World& world_;
  const FeatureSimulationOptions& options_;
  FeatureSimulationCounts* counts_;
  std::array<Eigen::Vector3d, 4> planes_;
  std::vector<Track> tracks_;  // ascending in id
  FeatureId next_id_ = 0;
  std::vector<char> tracked_;    // per segment of the world
  std::vector<LineView> views_;  // per segment of the world, ignoring occlusion
  Random choice_;
  LifeTimes lives_;
  Random slide_;
  Random noise_;
  Random quality_;
};

}  // namespace

std::vector<FrameObservation> simulateFeatures(const Trajectory& trajectory, const World& world,
                                               const Calibration& calibration,
                                               const std::vector<double>& image_times,
                                               const FeatureSimulationOptions& options,
                                               FeatureSimulationCounts* counts) {
  FeatureSimulationCounts local_counts;
  std::vector<FrameObservation> frames;
  PointTracker points(world, options, &local_counts);
  LineTracker lines(world, options, &local_counts);
  frames.reserve(image_times.size());
  for (const double t : image_times) {
    const Exposure exposure(trajectory, calibration, options.camera, t + calibration.td);
    FrameObservation frame;
    frame.t = t;
    points.observe(exposure, &frame.points);
    lines.observe(exposure, &frame.lines);
    frames.push_back(std::move(frame));
  }
  if (counts != nullptr) *counts = local_counts;
  return frames;
}

}  // namespace slim_init::simulation
