// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "point_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "outliers.h"

namespace slim_init::feature_tracker_lines {
namespace {

constexpr int kNeighbours = 5;
// With a good prediction two levels reach some 20 px; more of them invite a jump to the next period
// of a texture.
constexpr int kPredictedLevels = 1;
// Where the prediction was as good as this in the image before, one level will do.
constexpr float kSteadyPx = 1.5F;
// Backwards the way is known; what is asked is whether it is the same. From a start within this
// distance of the answer one level is enough.
constexpr int kBackwardLevels = 1;
constexpr float kNearPx = 4.0F;
constexpr int kBackwardWindowPx = 15;
const cv::TermCriteria kForward(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.02);
const cv::TermCriteria kBackward(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, 0.02);
constexpr int kVertexHalfPx = 4;
constexpr double kMaxVertexPx = 4.0;
const cv::TermCriteria kVertexEnd(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, 0.02);
// First sight: correlation below which it is not recognised, images in a row of that which a point
// is followed over by KLT alone, and the largest change of size. What a place a pixel wide is at
// first turns out to be several as it comes closer, and an error of the first sight grows alike.
constexpr double kLeastCorrelation = 0.8;
constexpr int kMaxAnchorMisses = 2;
constexpr double kMaxScale = 1.3;
// Corners are looked for in so many cells of the image at a time (there are about 150), except when
// most points are gone.
constexpr int kCellsPerImage = 30;
constexpr double kRefillAll = 0.5;
// A free rotation has to explain so much more than the known one before that one is doubted.
constexpr double kDoubtBelow = 0.8, kFallbackGain = 1.2;
// Three views: from mark to mark, and the share of tracks above which none is thrown out.
constexpr int kMarkImages = 5;
constexpr double kMostWrong = 0.4;
constexpr double kThreeViewPx = 0.6;  // where most tracks agree far better
// VINS-Mono's constants.
constexpr double kVinsFocalPx = 460.0;
constexpr double kVinsBorderPx = 1.0;
constexpr int kVinsWindowPx = 21, kVinsLevels = 3;
constexpr double kVinsQuality = 0.01;
constexpr double kVinsEveryImageHz = 100.0;

double medianOf(std::array<float, kNeighbours>& values, int count) {
  std::sort(values.begin(), values.begin() + count);
  return count % 2 == 1 ? values[static_cast<std::size_t>(count / 2)]
                        : 0.5 * (values[static_cast<std::size_t>(count / 2 - 1)] +
                                 values[static_cast<std::size_t>(count / 2)]);
}

// Median residual flow of the nearest tracks that have one.
cv::Point2f nearbyFlow(const std::vector<PointTrack>& tracks, const cv::Point2f& pixel) {
  std::array<std::pair<float, const PointTrack*>, kNeighbours> nearest;
  int count = 0;
  for (const PointTrack& track : tracks) {
    if (!track.has_flow) continue;
    const cv::Point2f d = track.pixel - pixel;
    const float square = d.dot(d);
    if (count == kNeighbours && square >= nearest[kNeighbours - 1].first) continue;
    int at = count < kNeighbours ? count++ : kNeighbours - 1;
    for (; at > 0 && nearest[static_cast<std::size_t>(at - 1)].first > square; --at) {
      nearest[static_cast<std::size_t>(at)] = nearest[static_cast<std::size_t>(at - 1)];
    }
    nearest[static_cast<std::size_t>(at)] = {square, &track};
  }
  if (count == 0) return {0.0F, 0.0F};
  std::array<float, kNeighbours> x{}, y{};
  for (int i = 0; i < count; ++i) {
    x[static_cast<std::size_t>(i)] = nearest[static_cast<std::size_t>(i)].second->residual_flow.x;
    y[static_cast<std::size_t>(i)] = nearest[static_cast<std::size_t>(i)].second->residual_flow.y;
  }
  return {static_cast<float>(medianOf(x, count)), static_cast<float>(medianOf(y, count))};
}

cv::Mat usableArea(const Camera& camera, bool fisheye) {
  const CameraParameters& c = camera.parameters();
  cv::Mat usable(c.height, c.width, CV_8UC1, cv::Scalar(255));
  if (fisheye) {
    // The host reads a picture of its own here; what that one leaves out are the corners.
    usable.setTo(0);
    cv::circle(usable, cv::Point(cvRound(c.cx), cvRound(c.cy)), std::max(c.width, c.height) / 2,
               cv::Scalar(255), cv::FILLED);
  }
  // Places without a ray (beyond a fisheye's image circle), looked at every few pixels.
  constexpr int kStep = 8;
  for (int y = 0; y < c.height; y += kStep) {
    for (int x = 0; x < c.width; x += kStep) {
      const Eigen::Vector2d middle(x + 0.5 * kStep, y + 0.5 * kStep);
      if (camera.bearing(middle).allFinite()) continue;
      usable(cv::Rect(x, y, kStep, kStep) & cv::Rect(0, 0, c.width, c.height)).setTo(0);
    }
  }
  return usable;
}

Eigen::Vector2d toEigen(const cv::Point2f& p) { return {p.x, p.y}; }

}  // namespace

PointTracker::PointTracker(const CameraParameters& camera, const FrontEndOptions& options)
    : camera_(camera),
      options_(options),
      focal_px_(camera_.focalPx()),
      usable_(usableArea(camera_, options.host.fisheye)),
      corners_(cv::Size(camera.width, camera.height), options.points.min_distance_px,
               options.points.border_px) {}

void PointTracker::reset() {
  tracks_.clear();
  corners_.reset();
  images_since_mark_ = 0;
  R_now_mark_.setIdentity();
  t_count_start_ = kNotComputed;
  published_ = 0;
}

bool PointTracker::isInside(const cv::Point2f& pixel, double border) const {
  return pixel.x >= border && pixel.x < usable_.cols - border && pixel.y >= border &&
         pixel.y < usable_.rows - border &&
         usable_.at<uchar>(cvRound(pixel.y), cvRound(pixel.x)) != 0;
}

bool PointTracker::advance(const cv::Point2f& to, const cv::Point2f& without_flow,
                           PointTrack* track) const {
  const Eigen::Vector3d bearing = camera_.bearing(toEigen(to));
  if (!bearing.allFinite()) return false;
  track->bearing_before = track->bearing;
  track->pixel_before = track->pixel;
  track->pixel = to;
  track->bearing = bearing;
  track->residual_flow = to - without_flow;
  track->has_flow = true;
  ++track->age;
  return true;
}

bool PointTracker::addTrack(const cv::Point2f& pixel) {
  PointTrack track;
  track.bearing = camera_.bearing(toEigen(pixel));
  if (!track.bearing.allFinite()) return false;
  track.id = next_id_++;
  track.pixel = pixel;
  tracks_.push_back(track);
  return true;
}

cv::Point2f PointTracker::residualFlowNear(const cv::Point2f& pixel) const {
  return nearbyFlow(tracks_, pixel);
}

void PointTracker::track(double t, const ImagePyramid& before, const ImagePyramid& now,
                         const RotationPrior& prior, FrontEndReport* report) {
  report->points_before = static_cast<int>(tracks_.size());
  if (options_.profile == TrackerProfile::kVins) {
    trackVins(t, before, now, report);
  } else {
    trackDefault(before, now, prior, report);
  }
}

// ------------------------------------------------------------------------------ default profile

void PointTracker::trackDefault(const ImagePyramid& before, const ImagePyramid& now,
                                const RotationPrior& prior, FrontEndReport* report) {
  const PointTrackerOptions& o = options_.points;
  const std::size_t n = tracks_.size();
  std::vector<PointTrack> moved;
  std::vector<std::size_t> origin;
  if (n > 0 && !before.empty()) {
    // Where each point would be seen without translation, and with the translation of before.
    std::vector<cv::Point2f> from(n), rotated(n), predicted(n);
    for (std::size_t i = 0; i < n; ++i) {
      const PointTrack& track = tracks_[i];
      from[i] = track.pixel;
      rotated[i] = track.pixel;
      Eigen::Vector2d pixel;
      if (prior.measured && camera_.project(prior.R_now_before * track.bearing, &pixel)) {
        rotated[i] = cv::Point2f(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
      }
      predicted[i] =
          rotated[i] + (track.has_flow ? track.residual_flow : nearbyFlow(tracks_, track.pixel));
    }

    const cv::Size window(o.window_px, o.window_px);
    const int back_side = std::min(o.window_px, kBackwardWindowPx);
    const cv::Size back_window(back_side, back_side);
    const auto flow = [&](const std::vector<cv::Point2f>& starts, int levels,
                          std::vector<cv::Point2f>* found) {
      std::vector<uchar> ok, ok_back;
      std::vector<float> unused;
      std::vector<cv::Point2f> sources;
      for (const std::size_t i : origin) sources.push_back(from[i]);
      *found = starts;
      const int top = std::min({levels, before.max_level, now.max_level});
      cv::calcOpticalFlowPyrLK(before.pyramid, now.pyramid, sources, *found, ok, unused, window,
                               top, kForward, cv::OPTFLOW_USE_INITIAL_FLOW);
      // The way back starts off by as much as the way here was corrected. Started at the answer it
      // would stay there, also after a jump to the next period of a texture.
      for (const bool near : {true, false}) {
        std::vector<std::size_t> chosen;
        std::vector<cv::Point2f> ends, back;
        for (std::size_t k = 0; k < ok.size(); ++k) {
          const cv::Point2f correction = (*found)[k] - starts[k];
          if (ok[k] == 0 || (cv::norm(correction) < kNearPx) != near) continue;
          chosen.push_back(k);
          ends.push_back((*found)[k]);
          back.push_back(sources[k] + correction);
        }
        if (chosen.empty()) continue;
        cv::calcOpticalFlowPyrLK(now.pyramid, before.pyramid, ends, back, ok_back, unused,
                                 back_window, near ? 0 : std::min(kBackwardLevels, top), kBackward,
                                 cv::OPTFLOW_USE_INITIAL_FLOW);
        for (std::size_t j = 0; j < chosen.size(); ++j) {
          const std::size_t k = chosen[j];
          if (ok_back[j] == 0 || cv::norm(back[j] - sources[k]) > o.forward_backward_px) ok[k] = 0;
        }
      }
      return ok;
    };

    std::vector<unsigned char> found(n, 0);
    std::vector<cv::Point2f> to(n);
    const auto round = [&](const std::vector<cv::Point2f>& starts_of_all, int levels,
                           const auto& concerns) {
      origin.clear();
      std::vector<cv::Point2f> starts, ends;
      for (std::size_t i = 0; i < n; ++i) {
        if (found[i] != 0 || !concerns(tracks_[i])) continue;
        origin.push_back(i);
        starts.push_back(starts_of_all[i]);
      }
      if (origin.empty()) return;
      const std::vector<uchar> ok = flow(starts, levels, &ends);
      for (std::size_t k = 0; k < ok.size(); ++k) {
        if (ok[k] == 0) continue;
        found[origin[k]] = 1;
        to[origin[k]] = ends[k];
      }
    };
    const auto all = [](const PointTrack&) { return true; };
    if (prior.measured) {
      const auto steady = [](const PointTrack& track) { return track.surprise_px < kSteadyPx; };
      round(predicted, 0, steady);
      round(predicted, kPredictedLevels, all);
    } else {
      round(predicted, o.levels, all);
    }
    round(rotated, o.levels, all);

    for (std::size_t i = 0; i < n; ++i) {
      if (found[i] == 0 || !isInside(to[i], o.border_px)) continue;
      PointTrack track = tracks_[i];
      if (!advance(to[i], rotated[i], &track)) continue;
      track.surprise_px = static_cast<float>(cv::norm(to[i] - predicted[i]));
      moved.push_back(track);
    }
    report->points_flow = static_cast<int>(moved.size());
    anchorTracks(now, prior, &moved);
    const std::vector<unsigned char> inlier = findOutliers(moved, prior, report);
    std::vector<PointTrack> kept;
    for (std::size_t k = 0; k < moved.size(); ++k) {
      if (inlier[k] != 0) kept.push_back(moved[k]);
    }
    report->points_outliers = static_cast<int>(moved.size() - kept.size());
    moved = std::move(kept);
    report->points_outliers += checkThreeViews(prior, &moved);
  }
  tracks_ = std::move(moved);
  refill(now, report);
}

// Puts each point where its first sight says, and gives it up or a new id where that is not seen
// any more. KLT from image to image drifts, by half a pixel in a second where the camera turns or
// the scene comes closer.
void PointTracker::anchorTracks(const ImagePyramid& now, const RotationPrior& prior,
                                std::vector<PointTrack>* moved) {
  for (PointTrack& track : *moved) {
    if (track.anchor == nullptr) continue;
    const Eigen::Vector2d pixel = toEigen(track.pixel);
    // The rotation deforms the patch by the derivative of where it takes a pixel.
    const Eigen::Vector3d& f = track.bearing_before;
    Eigen::Vector2d middle, right, down;
    const Eigen::Vector2d before = toEigen(track.pixel_before);
    const Eigen::Matrix3d& R = prior.R_now_before;
    if (camera_.project(R * f, &middle) &&
        camera_.project(R * camera_.bearing(before + Eigen::Vector2d::UnitX()), &right) &&
        camera_.project(R * camera_.bearing(before + Eigen::Vector2d::UnitY()), &down)) {
      Eigen::Matrix2d jacobian;
      jacobian << right - middle, down - middle;
      track.anchor->deform(jacobian);
    }
    const PatchAnchor::Match match = track.anchor->align(now.level(0), pixel, now.noise);
    if (match.ok && match.correlation > kLeastCorrelation) {
      const Eigen::Vector3d bearing = camera_.bearing(match.pixel);
      if (!bearing.allFinite()) continue;
      track.anchor->accept();
      track.anchor_misses = 0;
      const cv::Point2f there(static_cast<float>(match.pixel.x()),
                              static_cast<float>(match.pixel.y()));
      track.residual_flow += there - track.pixel;
      track.pixel = there;
      track.bearing = bearing;
      const double scale = track.anchor->scale();
      if (scale <= kMaxScale && scale >= 1.0 / kMaxScale) continue;
    } else if (++track.anchor_misses <= kMaxAnchorMisses) {
      continue;
    }
    // Too different by now from what was seen first for the same point to be claimed: what goes on
    // is a new track, or none where there is no corner any more.
    track.anchor = std::make_shared<PatchAnchor>();
    track.anchor->set(now.level(0), toEigen(track.pixel), now.noise);
    track.anchor_misses = 0;
    track.id = next_id_++;
    track.age = 1;
    track.marks = 0;
  }
  moved->erase(std::remove_if(moved->begin(), moved->end(),
                              [](const PointTrack& track) {
                                return track.anchor != nullptr && !track.anchor->valid();
                              }),
               moved->end());
}

std::vector<unsigned char> PointTracker::findOutliers(const std::vector<PointTrack>& moved,
                                                      const RotationPrior& prior,
                                                      FrontEndReport* report) {
  std::vector<Eigen::Vector3d> rotated, before, now;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    before.push_back(moved[k].bearing_before);
    rotated.push_back(prior.R_now_before * before.back());
    now.push_back(moved[k].bearing);
  }
  const double threshold = options_.points.epipolar_px;
  const auto count = [](const std::vector<unsigned char>& flags) {
    return std::count(flags.begin(), flags.end(), 1);
  };
  if (prior.measured && prior.sigma_px <= options_.max_rotation_sigma_px) {
    report->outlier_check = OutlierCheck::kKnownRotation;
    std::vector<unsigned char> known =
        knownRotationInliers(rotated, now, focal_px_, threshold, nullptr);
    const auto inliers = static_cast<double>(count(known));
    if (inliers >= kDoubtBelow * static_cast<double>(moved.size())) return known;
    // Much is amiss. A wrong bias must not kill the tracks.
    std::vector<unsigned char> free = fundamentalInliers(before, now, focal_px_, threshold);
    if (static_cast<double>(count(free)) <= kFallbackGain * inliers) return known;
    ++report->fallbacks;
    report->outlier_check = OutlierCheck::kFundamental;
    return free;
  }
  if (moved.size() >= 8) report->outlier_check = OutlierCheck::kFundamental;
  return fundamentalInliers(before, now, focal_px_, threshold);
}

// Takes out what three views a few images apart disagree with; returns how many. Needs rotations
// known over that time.
int PointTracker::checkThreeViews(const RotationPrior& prior, std::vector<PointTrack>* moved) {
  const bool known = prior.measured && prior.sigma_px * std::sqrt(2.0 * kMarkImages) <=
                                           options_.max_rotation_sigma_px;
  if (!known) {
    for (PointTrack& track : *moved) track.marks = 0;
    images_since_mark_ = 0;
    R_now_mark_.setIdentity();
    return 0;
  }
  R_now_mark_ = prior.R_now_before * R_now_mark_;
  if (++images_since_mark_ < kMarkImages) return 0;

  std::vector<std::size_t> chosen;
  std::vector<Eigen::Vector3d> older, newer, now;
  const Eigen::Matrix3d R_now_older = R_now_mark_ * R_mark_older_;
  for (std::size_t k = 0; k < moved->size(); ++k) {
    const PointTrack& track = (*moved)[k];
    if (track.marks < 2) continue;
    chosen.push_back(k);
    older.push_back(R_now_older * track.mark_rays[0]);
    newer.push_back(R_now_mark_ * track.mark_rays[1]);
    now.push_back(track.bearing);
  }
  const std::vector<unsigned char> inlier =
      threeViewInliers(older, newer, now, focal_px_, options_.points.epipolar_px, kThreeViewPx);
  const auto wrong = static_cast<std::size_t>(std::count(inlier.begin(), inlier.end(), 0));
  int removed = 0;
  // Where many are wrong it is the rotation or the scene that moves.
  if (wrong > 0 && static_cast<double>(wrong) <= kMostWrong * static_cast<double>(chosen.size())) {
    std::vector<unsigned char> keep(moved->size(), 1);
    for (std::size_t j = 0; j < chosen.size(); ++j) keep[chosen[j]] = inlier[j];
    std::vector<PointTrack> kept;
    for (std::size_t k = 0; k < moved->size(); ++k) {
      if (keep[k] != 0) kept.push_back((*moved)[k]);
    }
    removed = static_cast<int>(moved->size() - kept.size());
    *moved = std::move(kept);
  }
  for (PointTrack& track : *moved) {
    track.mark_rays[0] = track.mark_rays[1];
    track.mark_rays[1] = track.bearing;
    track.marks = std::min(track.marks + 1, 2);
  }
  R_mark_older_ = R_now_mark_;
  R_now_mark_.setIdentity();
  images_since_mark_ = 0;
  return removed;
}

cv::Mat PointTracker::thinOut(double min_distance, double mask_distance) {
  std::stable_sort(tracks_.begin(), tracks_.end(),
                   [](const PointTrack& a, const PointTrack& b) { return a.age > b.age; });
  cv::Mat mask = usable_.clone();
  std::vector<PointTrack> kept;
  const auto paint = [&](double radius, const PointTrack& track) {
    cv::circle(mask, cv::Point(cvRound(track.pixel.x), cvRound(track.pixel.y)),
               static_cast<int>(radius), cv::Scalar(0), cv::FILLED);
  };
  for (const PointTrack& track : tracks_) {
    if (mask.at<uchar>(cvRound(track.pixel.y), cvRound(track.pixel.x)) == 0) continue;
    paint(min_distance, track);
    kept.push_back(track);
  }
  if (mask_distance > min_distance) {
    for (const PointTrack& track : kept) paint(mask_distance, track);
  }
  tracks_ = std::move(kept);
  return mask;
}

void PointTracker::refill(const ImagePyramid& now, FrontEndReport* report) {
  const PointTrackerOptions& o = options_.points;
  // Points that converge, as when flying backwards, are let go only when they nearly meet.
  cv::Mat mask = thinOut(0.5 * o.min_distance_px, o.min_distance_px);
  const int kept = static_cast<int>(tracks_.size());
  report->points_tracked = kept;
  const int wanted = o.max_points - kept;
  if (wanted <= 0) return;
  std::vector<cv::Point2f> found;
  corners_.detect(
      now.derivative(), o.corner_noise_factor * kNoiseEigenvalue * now.noise * now.noise, wanted,
      kept < kRefillAll * o.max_points ? corners_.cells() : kCellsPerImage, &mask, &found);
  if (found.empty()) return;
  // The place where the edges meet is one and the same from near and far; the strongest pixel lies
  // a pixel or two inside, which becomes an error as the scene comes closer.
  const std::vector<cv::Point2f> strongest = found;
  cv::cornerSubPix(now.level(0), found, cv::Size(kVertexHalfPx, kVertexHalfPx), cv::Size(-1, -1),
                   kVertexEnd);
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!(cv::norm(found[k] - strongest[k]) < kMaxVertexPx)) found[k] = strongest[k];
  }
  for (const cv::Point2f& corner : found) {
    auto anchor = std::make_shared<PatchAnchor>();
    if (!anchor->set(now.level(0), toEigen(corner), now.noise)) continue;
    if (addTrack(corner)) tracks_.back().anchor = std::move(anchor);
  }
  report->points_new = static_cast<int>(tracks_.size()) - kept;
}

// --------------------------------------------------------------------------------- profile `vins`

void PointTracker::trackVins(double t, const ImagePyramid& before, const ImagePyramid& now,
                             FrontEndReport* report) {
  const HostFrontEnd& host = options_.host;
  std::vector<PointTrack> moved;
  std::vector<std::size_t> origin;
  if (!tracks_.empty() && !before.empty()) {
    std::vector<cv::Point2f> from, to;
    for (const PointTrack& track : tracks_) from.push_back(track.pixel);
    std::vector<uchar> ok;
    std::vector<float> unused;
    cv::calcOpticalFlowPyrLK(before.pyramid, now.pyramid, from, to, ok, unused,
                             cv::Size(kVinsWindowPx, kVinsWindowPx),
                             std::min({kVinsLevels, before.max_level, now.max_level}));
    for (std::size_t i = 0; i < to.size(); ++i) {
      const cv::Point2f rounded(static_cast<float>(cvRound(to[i].x)),
                                static_cast<float>(cvRound(to[i].y)));
      // The host's image border alone; its mask is asked when points are thinned out.
      const bool inside = rounded.x >= kVinsBorderPx && rounded.y >= kVinsBorderPx &&
                          rounded.x < usable_.cols - kVinsBorderPx &&
                          rounded.y < usable_.rows - kVinsBorderPx;
      if (ok[i] == 0 || !inside) continue;
      PointTrack track = tracks_[i];
      if (!advance(to[i], from[i], &track)) continue;
      moved.push_back(track);
    }
    report->points_flow = static_cast<int>(moved.size());
  }

  // The host rejects, thins out and refills only in images that it publishes.
  if (!std::isfinite(t_count_start_)) t_count_start_ = t;
  const double hz = host.freq == 0 ? kVinsEveryImageHz : host.freq;
  const double elapsed = t - t_count_start_;
  const double rate = elapsed > 0.0 ? published_ / elapsed : 0.0;
  const bool publish = std::round(rate) <= hz;
  if (publish) {
    if (elapsed > 0.0 && std::abs(rate - hz) < 0.01 * hz) {
      t_count_start_ = t;
      published_ = 0;
    }
    ++published_;
  }
  if (!publish) {
    tracks_ = std::move(moved);
    report->points_tracked = static_cast<int>(tracks_.size());
    return;
  }

  if (moved.size() >= 8) {
    report->outlier_check = OutlierCheck::kFundamental;
    std::vector<Eigen::Vector3d> rays_before, rays_now;
    for (std::size_t k = 0; k < moved.size(); ++k) {
      rays_before.push_back(moved[k].bearing_before);
      rays_now.push_back(moved[k].bearing);
    }
    const std::vector<unsigned char> inlier =
        fundamentalInliers(rays_before, rays_now, kVinsFocalPx, host.F_threshold);
    std::vector<PointTrack> kept;
    for (std::size_t k = 0; k < moved.size(); ++k) {
      if (inlier[k] != 0) kept.push_back(moved[k]);
    }
    report->points_outliers = static_cast<int>(moved.size() - kept.size());
    moved = std::move(kept);
  }
  tracks_ = std::move(moved);
  const cv::Mat mask = thinOut(host.min_dist, host.min_dist);
  const int kept = static_cast<int>(tracks_.size());
  report->points_tracked = kept;
  if (kept >= host.max_cnt) return;
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(now.level(0), found, host.max_cnt - kept, kVinsQuality, host.min_dist,
                          mask);
  for (const cv::Point2f& corner : found) addTrack(corner);
  report->points_new = static_cast<int>(tracks_.size()) - kept;
}

}  // namespace slim_init::feature_tracker_lines
