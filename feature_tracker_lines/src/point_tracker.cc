// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "point_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "geometry/so3.h"
#include "outliers.h"
#include "vins_constants.h"

namespace slim_init::feature_tracker_lines {
namespace {

// Points whose flow predicts that of a new point: the median of five bears two wrong ones.
constexpr int kNeighbours = 5;

// KLT to this image. With a good prediction two levels reach some 20 px; more of them invite a jump
// to the next period of a texture.
constexpr int kPredictedLevels = 1;
// One level will do where the prediction was this good in the previous image [px].
constexpr float kSteadyPx = 1.5F;
const cv::TermCriteria kForward(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.02);

// KLT back to the previous image. The way is known; the question is whether it is the same. From a
// start within this distance of the answer [px] one level is enough, and a smaller window.
constexpr int kBackwardLevels = 1;
constexpr float kNearPx = 4.0F;
constexpr int kBackwardWindowPx = 16;  // as wide as two turns of OpenCV's vector loop
constexpr double kMaxReturnPx = 0.5;   // from where it was
const cv::TermCriteria kBackward(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, 0.02);

// New corners are moved to the vertex where their edges meet: half side of the window [px], and the
// distance [px] beyond which the vertex is that of another corner.
constexpr int kVertexHalfPx = 4;
constexpr double kMaxVertexPx = 4.0;
const cv::TermCriteria kVertexEnd(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, 0.02);

// Anchor of a point, its first image patch: correlation below which it is not recognised, images in
// a row of that over which KLT alone follows the point, and the largest change of size. What looks
// a pixel wide at first turns out to be several pixels as it comes closer, and an error of the
// first localisation grows with it.
constexpr double kLeastCorrelation = 0.8;
constexpr int kMaxAnchorMisses = 2;
constexpr double kMaxScale = 1.3;
// Correlation and distance from the prediction [px] from which on a match is sure without KLT.
constexpr double kSureCorrelation = 0.95;
constexpr double kSurePx = 0.7;

// Points closer to the edge of the image are dropped [px].
constexpr double kBorderPx = 8.0;

// Corners are looked for in this many cells per image (of about 150), which bounds the time, unless
// fewer than this share of the points is left.
constexpr int kCellsPerImage = 30;
constexpr double kRefillAll = 0.5;
// Points that converge, as when flying backwards, are dropped only at this share of the distance
// that new points keep.
constexpr double kLeastDistanceShare = 0.5;

// Predictions are compared on this level of the pyramid, over a square of so many of its pixels,
// which tells one brick from the next. The gyroscope is tested if half of the patches differ by
// more than kDoubtAbove of their own contrast, which in fast motion without damage one image in ten
// does. One prediction is better below kBetterBelow of the other's difference.
constexpr int kPatchLevel = 2;
constexpr int kPatchSidePx = 9;
constexpr double kDoubtAbove = 0.5;
constexpr double kBetterBelow = 0.9;
// Change of the brightness that KLT bears: beyond 5 %, points of low contrast are lost.
constexpr double kSameBrightness = 0.025;
// The change is measured at so many heights, each from so many of the nearest points. A lamp that
// flickers at 100 Hz makes two or three bands during a readout of 20 to 30 ms, of eight heights or
// more each. The median of nine bears four wrong ones.
constexpr int kRatioHeights = 24;
constexpr int kRatioSamples = 9;
// Fraction of the spread between their quartiles that a change must exceed. In noise alone the
// median of nine is off by a quarter of it on average; all of it would reject steep bands, which
// are spread over the nine themselves.
constexpr double kRatioNoise = 0.5;
// Turn of all places together: patches that it compares, its reach and first step [px], how often
// it is refined, and the difference from which on a patch is another one. In the hand even motion
// is off by up to 30 px between images. 60 patches found nothing better, steps of 8 px the next
// brick.
constexpr std::size_t kTurnPatches = 30;
constexpr double kTurnReachPx = 32.0, kTurnStepPx = 4.0;
constexpr int kTurnRounds = 20;
constexpr double kUnlikeGreyLevels = 40.0;

// The known rotation is doubted where it explains less than this share of the points, and overruled
// where a free one explains so many times as many. If the patches contradicted it as well, a small
// gain is enough: a free rotation rarely explains more points than the correct one, but nearly all
// of them if the known one is incorrect.
constexpr double kDoubtBelow = 0.8;
constexpr double kFallbackGain = 1.2, kDoubtedGain = 1.05;

// Check over three views: time from mark to mark, for parallax (the image nearest to it is taken:
// every fifth one at 20 Hz), the share of wrong tracks above which none is dropped, since then the
// rotation is wrong or the scene moves, and the least deviation of a wrong track [px], where most
// tracks agree far better.
constexpr double kMarkS = 0.24;
constexpr double kMostWrong = 0.4;
constexpr double kThreeViewPx = 0.6;

// Where the image has fewer points than this share of the number wanted, corners of the next level
// of the pyramid fill it up to there (of 33, thirty last): a halving leaves a third of the noise.
// On the level after it half of the points went wrong.
constexpr double kCoarseShare = 0.22;
constexpr double kSharpGrowth = 2.0;  // see dropSmooth()

// Places without a ray (beyond the image circle of a fisheye) are looked for at this step [px].
constexpr int kUsableStepPx = 8;

// Sorts the first `count` values; their median.
template <std::size_t N>
double medianOf(std::array<float, N>& values, int count) {
  std::sort(values.begin(), values.begin() + count);
  return count % 2 == 1 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

cv::Mat usableArea(const Camera& camera, const FrontEndOptions& options) {
  const CameraParameters& c = camera.parameters();
  cv::Mat usable(c.height, c.width, CV_8UC1, cv::Scalar(255));
  if (!options.mask.empty()) usable.setTo(0, options.mask == 0);
  const cv::Rect image(0, 0, c.width, c.height);
  for (int y = 0; y < c.height; y += kUsableStepPx) {
    for (int x = 0; x < c.width; x += kUsableStepPx) {
      const Eigen::Vector2d middle(x + 0.5 * kUsableStepPx, y + 0.5 * kUsableStepPx);
      if (camera.bearing(middle).allFinite()) continue;
      usable(cv::Rect(x, y, kUsableStepPx, kUsableStepPx) & image).setTo(0);
    }
  }
  return usable;
}

// Removes the tracks whose flag is zero; returns how many.
int keepFlagged(const std::vector<unsigned char>& flags, std::vector<PointTrack>* tracks) {
  std::vector<PointTrack> kept;
  for (std::size_t k = 0; k < tracks->size(); ++k) {
    if (flags[k] != 0) kept.push_back((*tracks)[k]);
  }
  const auto removed = static_cast<int>(tracks->size() - kept.size());
  *tracks = std::move(kept);
  return removed;
}

// Whether the anchor of a track is where the track was predicted, well enough to leave out KLT
// there and back; then `there` is the place, and the anchor takes over its deformation.
bool isSurelyAt(const PointTrack& track, const ImagePyramid& now, const cv::Point2f& predicted,
                cv::Point2f* there) {
  if (track.anchor == nullptr) return false;
  const PatchAnchor::Match match =
      track.anchor->align(now.level(0), toEigen(predicted), now.noise, kSurePx);
  if (!match.ok || !(match.correlation > kSureCorrelation)) return false;
  *there = toPoint(match.pixel);
  track.anchor->accept();
  return true;
}

// Side of a pixel of a level in those of level 0, where every position is kept. A power of two:
// positions of level 0 stay as they are, bit for bit.
float pixelOf(int level) { return static_cast<float>(1 << level); }

// The patch around a place, on the level for comparisons.
cv::Mat patchAt(const ImagePyramid& image, const cv::Point2f& place) {
  const int level = std::min(kPatchLevel, image.max_level);
  cv::Mat patch;
  cv::getRectSubPix(image.level(level), cv::Size(kPatchSidePx, kPatchSidePx),
                    place / pixelOf(level), patch);
  return patch;
}

// Mean difference of two patches beyond that of their brightness [grey levels].
double differenceOf(const cv::Mat& a, const cv::Mat& b) {
  const double brighter = cv::mean(a)[0] - cv::mean(b)[0];
  double sum = 0.0;
  for (int y = 0; y < a.rows; ++y) {
    const uchar *row_a = a.ptr<uchar>(y), *row_b = b.ptr<uchar>(y);
    for (int x = 0; x < a.cols; ++x) sum += std::abs(row_a[x] - row_b[x] - brighter);
  }
  return sum / static_cast<double>(a.total());
}

// The rotation that the tracks agree with best.
Eigen::Matrix3d commonTurn(const std::vector<PointTrack>& moved) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PointTrack& track : moved) sum += track.bearing * track.bearing_before.transpose();
  return nearestRotation(sum);
}

// Drops the corners that are too strong on the next level. Those of the scene are sharp and have
// the same slopes on both, while the slopes of shading double and their squares grow fourfold.
void dropSmooth(const ImagePyramid& now, std::vector<cv::Point2f>* corners) {
  if (now.max_level < 1) return;
  const auto smooth = [&now](const cv::Point2f& corner) {
    const int x = cvRound(corner.x), y = cvRound(corner.y);
    return cornerEigenvalue(now.derivative(1), x / 2, y / 2) >
           kSharpGrowth * cornerEigenvalue(now.derivative(0), x, y);
  };
  corners->erase(std::remove_if(corners->begin(), corners->end(), smooth), corners->end());
}

// KLT of points from the previous image to this one and back. All positions are those of the level
// 0 of both pyramids.
class FlowSearch {
 public:
  FlowSearch(const ImagePyramid& before, const ImagePyramid& now, int window_px)
      : before_(before), now_(now), window_px_(window_px) {}

  // Flags of those that are found, at `ends`, from `starts` and over `levels` pyramid levels above
  // the image.
  std::vector<uchar> thereAndBack(const std::vector<cv::Point2f>& sources,
                                  const std::vector<cv::Point2f>& starts, int levels,
                                  std::vector<cv::Point2f>* ends) const {
    const int top = std::min({levels, before_.max_level, now_.max_level});
    std::vector<uchar> ok;
    std::vector<float> unused;
    *ends = starts;
    cv::calcOpticalFlowPyrLK(before_.pyramid, now_.pyramid, sources, *ends, ok, unused,
                             cv::Size(window_px_, window_px_), top, kForward,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    std::vector<std::size_t> near, far;
    for (std::size_t k = 0; k < ok.size(); ++k) {
      if (ok[k] == 0) continue;
      (cv::norm((*ends)[k] - starts[k]) < kNearPx ? near : far).push_back(k);
    }
    checkBackward(sources, starts, *ends, near, 0, &ok);
    checkBackward(sources, starts, *ends, far, std::min(kBackwardLevels, top), &ok);
    return ok;
  }

 private:
  // Sets ok[k] to zero for those of `chosen` that do not come back to their source. The way back
  // starts off by as much as the way here was corrected. Started at the answer it would stay there,
  // also after a jump to the next period of a texture.
  void checkBackward(const std::vector<cv::Point2f>& sources,
                     const std::vector<cv::Point2f>& starts, const std::vector<cv::Point2f>& ends,
                     const std::vector<std::size_t>& chosen, int top,
                     std::vector<uchar>* ok) const {
    if (chosen.empty()) return;
    std::vector<cv::Point2f> from, back;
    for (const std::size_t k : chosen) {
      const cv::Point2f correction = ends[k] - starts[k];
      from.push_back(ends[k]);
      back.push_back(sources[k] + correction);
    }
    const int side = std::min(window_px_, kBackwardWindowPx);
    std::vector<uchar> ok_back;
    std::vector<float> unused;
    cv::calcOpticalFlowPyrLK(now_.pyramid, before_.pyramid, from, back, ok_back, unused,
                             cv::Size(side, side), top, kBackward, cv::OPTFLOW_USE_INITIAL_FLOW);
    for (std::size_t j = 0; j < chosen.size(); ++j) {
      const std::size_t k = chosen[j];
      if (ok_back[j] == 0 || cv::norm(back[j] - sources[k]) > kMaxReturnPx) {
        (*ok)[k] = 0;
      }
    }
  }

  const ImagePyramid &before_, &now_;
  const int window_px_;
};

}  // namespace

PointTracker::PointTracker(const CameraParameters& camera, const FrontEndOptions& options)
    : camera_(camera),
      options_(options),
      focal_px_(camera_.focalPx()),
      usable_(usableArea(camera_, options)) {
  cv::Size size(camera.width, camera.height);
  for (int level = 0; level < kLevels; ++level) {
    corners_.emplace_back(size, options.points.min_distance_px / pixelOf(level), kBorderPx);
    size = cv::Size((size.width + 1) / 2, (size.height + 1) / 2);
  }
}

void PointTracker::reset() {
  tracks_.clear();
  for (CornerDetector& corners : corners_) corners.reset();
  last_prior_ = RotationPrior();
  was_measured_ = source_changed_ = false;
  since_mark_s_ = 0.0;
  R_now_mark_.setIdentity();
  t_count_start_ = kNotComputed;
  published_ = 0;
}

bool PointTracker::isInside(const cv::Point2f& pixel, double border) const {
  const int row = cvRound(pixel.y), column = cvRound(pixel.x);
  return pixel.x >= border && pixel.x < usable_.cols - border && pixel.y >= border &&
         pixel.y < usable_.rows - border && row < usable_.rows && column < usable_.cols &&
         usable_.at<uchar>(row, column) != 0;
}

bool PointTracker::advance(const cv::Point2f& to, PointTrack* track) const {
  const Eigen::Vector3d bearing = camera_.bearing(toEigen(to));
  if (!bearing.allFinite()) return false;
  track->bearing_before = track->bearing;
  track->pixel_before = track->pixel;
  track->pixel = to;
  track->bearing = bearing;
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

cv::Point2f PointMotion::flowNear(const cv::Point2f& pixel) const {
  std::array<std::pair<float, const Flow*>, kNeighbours> nearest;
  int count = 0;
  for (const Flow& flow : flows) {
    const cv::Point2f d = flow.pixel - pixel;
    const float square = d.dot(d);
    if (count == kNeighbours && square >= nearest[kNeighbours - 1].first) continue;
    int at = count < kNeighbours ? count++ : kNeighbours - 1;
    for (; at > 0 && nearest[at - 1].first > square; --at) {
      nearest[at] = nearest[at - 1];
    }
    nearest[at] = {square, &flow};
  }
  if (count == 0) return {0.0F, 0.0F};
  std::array<float, kNeighbours> x{}, y{};
  for (int i = 0; i < count; ++i) {
    x[i] = nearest[i].second->residual.x;
    y[i] = nearest[i].second->residual.y;
  }
  return {static_cast<float>(medianOf(x, count)), static_cast<float>(medianOf(y, count))};
}

cv::Point2f PointTracker::turned(const RotationPrior& prior, const Eigen::Vector3d& bearing,
                                 const cv::Point2f& pixel) const {
  Eigen::Vector2d there;
  const RowCamera lens_before(camera_, prior.rows_before), lens(camera_, prior.rows_now);
  const Eigen::Vector3d now = prior.R_now_before * lens_before.atMiddleRow(bearing, pixel.y);
  return lens.project(now, &there) ? toPoint(there) : pixel;
}

PointMotion PointTracker::motion(const RotationPrior& prior) const {
  PointMotion motion;
  int balance = 0;
  for (const PointTrack& track : tracks_) {
    if (!track.has_flow) continue;
    const cv::Point2f rotated = turned(prior, track.bearing_before, track.pixel_before);
    motion.flows.push_back({track.pixel, track.pixel - rotated});
    balance += track.surprise_px < kSteadyPx ? 1 : -1;
  }
  motion.steady = balance > 0 && !source_changed_;
  return motion;
}

void PointTracker::follow(double t, ImagePyramid* before, const ImagePyramid& now,
                          RotationPrior* prior, ImageReport* report) {
  if (options_.profile == TrackerProfile::kVins) {
    followVins(t, *before, now, report);
  } else {
    followDefault(before, now, prior, report);
  }
  report->points_tracked = static_cast<int>(tracks_.size());
}

void PointTracker::refill(const ImagePyramid& now, ImageReport* report) {
  if (mask_.empty()) return;
  const std::size_t kept = tracks_.size();
  if (options_.profile == TrackerProfile::kVins) {
    refillVins(now);
  } else {
    refillDefault(now);
  }
  report->points_new = static_cast<int>(tracks_.size() - kept);
}

// ------------------------------------------------------------------------------ default profile

// Where a point is expected in this image, and what became of it.
struct PointTracker::Target {
  cv::Point2f rotated;    // where it would be without translation
  cv::Point2f predicted;  // and with the flow of the step before
  cv::Point2f to{};       // where it was found
  bool found = false;
  bool recognised = false;  // found by its anchor alone
};

void PointTracker::followDefault(ImagePyramid* before, const ImagePyramid& now,
                                 RotationPrior* prior, ImageReport* report) {
  std::vector<PointTrack> moved;
  if (!tracks_.empty() && !before->empty()) {
    const Levels levels_now{now, now.from(1)};
    std::vector<Target> targets = expect(last_prior_, *prior);
    last_prior_ = *prior;
    RotationPrior searched = *prior;
    const bool doubted = prior->measured && chooseRotation(*before, now, &searched, &targets);
    matchBrightness(targets, now, before);
    if (doubted && !prior->known) {
      *prior = searched;
      report->rotation_overruled = true;
    }
    deformAnchors(searched);
    moved = search({*before, before->from(1)}, levels_now, searched, std::move(targets));
    anchorTracks(levels_now, &moved);
    const std::vector<unsigned char> inliers = findInliers(moved, *prior, doubted, report);
    if (report->rotation_overruled) *prior = RotationPrior{prior->dt_s, prior->dt_ratio};
    if (!prior->measured) prior->R_now_before = commonTurn(moved);
    source_changed_ = prior->measured != was_measured_;
    was_measured_ = prior->measured;
    report->points_outliers = keepFlagged(inliers, &moved);
    report->points_outliers += checkThreeViews(*prior, &moved);
  }
  tracks_ = std::move(moved);
  thinOut(kLeastDistanceShare * options_.points.min_distance_px, options_.points.min_distance_px);
}

// The rotation deforms each point's anchor by the Jacobian of its map of pixels.
void PointTracker::deformAnchors(const RotationPrior& prior) const {
  const RowCamera lens_before(camera_, prior.rows_before), lens(camera_, prior.rows_now);
  const Eigen::Matrix3d& R = prior.R_now_before;
  for (const PointTrack& track : tracks_) {
    if (track.anchor == nullptr) continue;
    Eigen::Vector2d middle, right, down;
    const Eigen::Vector2d here = toEigen(track.pixel);
    const Eigen::Vector3d f = lens_before.atMiddleRow(track.bearing, track.pixel.y);
    if (lens.project(R * f, &middle) &&
        lens.project(R * lens_before.bearing(here + Eigen::Vector2d::UnitX()), &right) &&
        lens.project(R * lens_before.bearing(here + Eigen::Vector2d::UnitY()), &down)) {
      Eigen::Matrix2d jacobian;
      jacobian << right - middle, down - middle;
      track.anchor->deform(jacobian);
    }
  }
}

// `last`: the rotation in the last image, beyond which each point goes on as it moved.
std::vector<PointTracker::Target> PointTracker::expect(const RotationPrior& last,
                                                       const RotationPrior& prior) const {
  const auto ratio = static_cast<float>(prior.dt_ratio);
  const PointMotion motion_before = motion(last);
  std::size_t next = 0;  // of the flows, which are in the order of the tracks
  std::vector<Target> expected;
  for (const PointTrack& track : tracks_) {
    const cv::Point2f rotated = turned(prior, track.bearing, track.pixel);
    const cv::Point2f flow =
        track.has_flow ? motion_before.flows[next++].residual : motion_before.flowNear(track.pixel);
    expected.push_back({rotated, rotated + ratio * flow});
  }
  return expected;
}

// Turns the predictions together to where the patches of the points fit best: each alone fits on
// the next brick as well, all of them only where they are.
void PointTracker::turnTogether(const ImagePyramid& before, const ImagePyramid& now,
                                std::vector<Target>* targets) const {
  struct Sample {
    cv::Mat patch;
    cv::Point2f place;
    Eigen::Vector3d ray;
  };
  const auto turnedBy = [&](const Eigen::Matrix3d& R, const Eigen::Vector3d& ray,
                            const cv::Point2f& place) {
    Eigen::Vector2d there;
    const bool seen = ray.allFinite() && camera_.project(R * ray, &there);
    return seen && isInside(toPoint(there), 0.0) ? toPoint(there) : place;
  };
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < tracks_.size(); i += tracks_.size() / kTurnPatches + 1) {
    const cv::Point2f& place = (*targets)[i].predicted;
    if (!isInside(place, 0.0)) continue;
    samples.push_back({patchAt(before, tracks_[i].pixel), place, camera_.bearing(toEigen(place))});
  }
  // Rotation vectors times the focal length [px].
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](const Eigen::Vector3d& turn_px) {
    const Eigen::Matrix3d R = expSO3(turn_px / focal_px_);
    double cost = 0.0;
    for (const Sample& sample : samples) {
      const cv::Mat there = patchAt(now, turnedBy(R, sample.ray, sample.place));
      cost += std::min(kUnlikeGreyLevels, differenceOf(sample.patch, there));
    }
    if (!(cost < least)) return false;
    least = cost;
    best = turn_px;
    return true;
  };
  attempt(best);
  for (double x = -kTurnReachPx; x <= kTurnReachPx; x += kTurnStepPx) {
    for (double y = -kTurnReachPx; y <= kTurnReachPx; y += kTurnStepPx) attempt({x, y, 0.0});
  }
  double step = 2.0 * kTurnStepPx;
  for (int round = 0; round < kTurnRounds && step >= 1.0; ++round) {
    bool better = false;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d move = step * Eigen::Vector3d::Unit(axis);
      better = attempt(best + move) || attempt(best - move) || better;
    }
    if (!better) step *= 0.5;
  }
  const Eigen::Matrix3d R = expSO3(best / focal_px_);
  for (Target& target : *targets) {
    cv::Point2f& place = target.predicted;
    place = turnedBy(R, camera_.bearing(toEigen(place)), place);
  }
}

// Brightness of this image over that of the image before, for scaleRows(): KLT compares grey
// levels. Automatic exposure changes all of them alike, lamps that flicker change those of a
// rolling shutter in bands. Measured at the points, each of which is predicted on the same part of
// the scene. Empty if nothing changed or the points disagree.
std::vector<double> PointTracker::brightnessRatios(const std::vector<Target>& targets,
                                                   const ImagePyramid& before,
                                                   const ImagePyramid& now) const {
  std::vector<std::pair<float, float>> samples;  // row before, ratio
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const double was = cv::mean(patchAt(before, tracks_[i].pixel))[0];
    if (!(was > 0.0) || !isInside(targets[i].predicted, 0.0)) continue;
    const double is = cv::mean(patchAt(now, targets[i].predicted))[0];
    samples.emplace_back(tracks_[i].pixel.y, static_cast<float>(is / was));
  }
  const int count = std::min(kRatioSamples, static_cast<int>(samples.size()));
  const int quarter = count / 4;
  if (quarter == 0) return {};
  std::vector<double> ratios;
  double change = 0.0, spread = 0.0;  // between the quartiles; both mean over the heights
  for (int height = 0; height < kRatioHeights; ++height) {
    const float row = (static_cast<float>(height) + 0.5F) *
                      static_cast<float>(before.level(0).rows) / kRatioHeights;
    const auto isNearer = [row](const auto& a, const auto& b) {
      return std::abs(a.first - row) < std::abs(b.first - row);
    };
    std::nth_element(samples.begin(), samples.begin() + (count - 1), samples.end(), isNearer);
    std::array<float, kRatioSamples> nearest{};
    for (int k = 0; k < count; ++k) nearest[k] = samples[k].second;
    ratios.push_back(medianOf(nearest, count));
    change += std::abs(ratios.back() - 1.0) / kRatioHeights;
    spread += (nearest[count - 1 - quarter] - nearest[quarter]) / kRatioHeights;
  }
  if (change <= std::max(kSameBrightness, kRatioNoise * spread)) ratios.clear();
  return ratios;
}

void PointTracker::matchBrightness(const std::vector<Target>& targets, const ImagePyramid& now,
                                   ImagePyramid* before) const {
  const std::vector<double> ratios = brightnessRatios(targets, *before, now);
  if (!ratios.empty()) scaleRows(ratios, before);
}

// Replaces the predictions, and the rotation for the search by an unknown one, if the patches of
// most points are not where the gyroscope predicts them and fit better where their flow and a
// common turn do; returns whether. Done before the search, which among bricks finds the next brick.
// That does not show an incorrect gyroscope: a long way past near objects looks the same. A known
// rotation is judged by findInliers(), by the points that were found.
bool PointTracker::chooseRotation(const ImagePyramid& before, const ImagePyramid& now,
                                  RotationPrior* prior, std::vector<Target>* targets) const {
  const std::vector<Target>& expected = *targets;
  std::vector<cv::Mat> patches;
  for (const PointTrack& track : tracks_) patches.push_back(patchAt(before, track.pixel));
  const auto difference = [&](std::size_t i, const cv::Point2f& there) {
    return isInside(there, 0.0) ? differenceOf(patches[i], patchAt(now, there))
                                : std::numeric_limits<double>::infinity();
  };
  const cv::Mat flat = cv::Mat::zeros(kPatchSidePx, kPatchSidePx, CV_8UC1);
  std::size_t unlike = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const double contrast = differenceOf(patches[i], flat);
    unlike += difference(i, expected[i].predicted) > kDoubtAbove * contrast ? 1 : 0;
  }
  if (2 * unlike <= tracks_.size()) return false;
  const RotationPrior unknown{prior->dt_s, prior->dt_ratio};
  std::vector<Target> same_flow = expect(unknown, unknown);
  turnTogether(before, now, &same_flow);
  std::size_t in_view = 0, better = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!isInside(same_flow[i].predicted, 0.0)) continue;
    ++in_view;
    const double bound = kBetterBelow * difference(i, expected[i].predicted);
    better += difference(i, same_flow[i].predicted) < bound ? 1 : 0;
  }
  if (2 * better <= in_view || 2 * in_view <= tracks_.size()) return false;
  *prior = unknown;
  *targets = std::move(same_flow);
  return true;
}

// Looks for the points of one level; `before` and `now` begin with it.
void PointTracker::searchLevel(int level, const ImagePyramid& before, const ImagePyramid& now,
                               const RotationPrior& prior, std::vector<Target>* targets) const {
  if (before.empty() || now.empty()) return;
  const float pixel = pixelOf(level);
  const auto ratio = static_cast<float>(prior.dt_ratio);
  const auto steady = [&](std::size_t i) { return ratio * tracks_[i].surprise_px < kSteadyPx; };
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (tracks_[i].level == level) members.push_back(i);
  }
  for (const std::size_t i : members) {
    Target& target = (*targets)[i];
    cv::Point2f there;
    if (!prior.measured || !steady(i) ||
        !isSurelyAt(tracks_[i], now, target.predicted / pixel, &there)) {
      continue;
    }
    target.to = pixel * there;
    target.found = target.recognised = true;
  }

  const FlowSearch flow(before, now, options_.points.window_px);
  // Looks for those that no earlier round has found.
  const auto round = [&](cv::Point2f Target::*start, int levels, bool steady_only) {
    std::vector<std::size_t> index;
    std::vector<cv::Point2f> sources, starts, ends;
    for (const std::size_t i : members) {
      if ((*targets)[i].found || (steady_only && !steady(i))) continue;
      index.push_back(i);
      sources.push_back(tracks_[i].pixel / pixel);
      starts.push_back((*targets)[i].*start / pixel);
    }
    if (index.empty()) return;
    const std::vector<uchar> ok = flow.thereAndBack(sources, starts, levels, &ends);
    for (std::size_t k = 0; k < ok.size(); ++k) {
      if (ok[k] == 0) continue;
      (*targets)[index[k]].to = pixel * ends[k];
      (*targets)[index[k]].found = true;
    }
  };
  if (prior.measured) {
    round(&Target::predicted, 0, true);
    round(&Target::predicted, kPredictedLevels, false);
  } else {
    round(&Target::predicted, options_.points.levels, false);
  }
  round(&Target::rotated, options_.points.levels, false);
}

// The tracks that are found in this image, moved there.
std::vector<PointTrack> PointTracker::search(const Levels& before, const Levels& now,
                                             const RotationPrior& prior,
                                             std::vector<Target> targets) const {
  for (int level = 0; level < kLevels; ++level) {
    searchLevel(level, before[level], now[level], prior, &targets);
  }
  std::vector<PointTrack> moved;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Target& target = targets[i];
    PointTrack track = tracks_[i];
    if (!target.found || !isInside(target.to, kBorderPx) || !advance(target.to, &track)) continue;
    track.surprise_px =
        static_cast<float>(cv::norm(target.to - target.predicted)) / pixelOf(track.level);
    track.recognised = target.recognised;
    moved.push_back(track);
  }
  return moved;
}

// Moves a point that KLT has followed to where its anchor is; `now` begins with its level. False
// where it is not recognised.
bool PointTracker::recognise(const ImagePyramid& now, PointTrack* track) const {
  const float pixel = pixelOf(track->level);
  const PatchAnchor::Match match =
      track->anchor->align(now.level(0), toEigen(track->pixel / pixel), now.noise);
  const Eigen::Vector2d place = static_cast<double>(pixel) * match.pixel;
  const Eigen::Vector3d bearing = camera_.bearing(place);
  if (!match.ok || !(match.correlation > kLeastCorrelation) || !bearing.allFinite()) return false;
  track->anchor->accept();
  const cv::Point2f there = toPoint(place);
  track->pixel = there;
  track->bearing = bearing;
  return true;
}

// Moves each point to where its anchor is found; one whose anchor is no longer recognised becomes a
// new track or is dropped. KLT from image to image drifts, by half a pixel per second where the
// camera turns or the scene comes closer.
void PointTracker::anchorTracks(const Levels& now, std::vector<PointTrack>* moved) {
  for (PointTrack& track : *moved) {
    if (track.anchor == nullptr) continue;
    const ImagePyramid& own = now[track.level];
    if (track.recognised || recognise(own, &track)) {
      track.anchor_misses = 0;
      const double scale = track.anchor->scale();
      if (scale <= kMaxScale && scale >= 1.0 / kMaxScale) continue;
    } else if (++track.anchor_misses <= kMaxAnchorMisses) {
      continue;
    }
    // Too different by now from the first patch to be called the same point: it continues as a new
    // track, or not at all where there is no corner.
    track.anchor = std::make_shared<PatchAnchor>();
    track.anchor->set(own.level(0), toEigen(track.pixel / pixelOf(track.level)), own.noise);
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

// One flag per track, 1 for an inlier: with the known rotation if there is one and it explains the
// tracks, otherwise with a fundamental matrix. `doubted`: chooseRotation() replaced the rotation.
std::vector<unsigned char> PointTracker::findInliers(const std::vector<PointTrack>& moved,
                                                     const RotationPrior& prior, bool doubted,
                                                     ImageReport* report) const {
  const RowCamera lens_before(camera_, prior.rows_before), lens(camera_, prior.rows_now);
  std::vector<Eigen::Vector3d> rotated, before, now;
  for (const PointTrack& track : moved) {
    before.push_back(lens_before.atMiddleRow(track.bearing_before, track.pixel_before.y));
    rotated.push_back(prior.R_now_before * before.back());
    now.push_back(lens.atMiddleRow(track.bearing, track.pixel.y));
  }
  const double threshold = options_.points.epipolar_px;
  const auto count = [](const std::vector<unsigned char>& flags) {
    return std::count(flags.begin(), flags.end(), 1);
  };
  if (prior.known) {
    std::vector<unsigned char> known =
        knownRotationInliers(rotated, now, focal_px_, threshold).flags;
    const auto inliers = static_cast<double>(count(known));
    if (!doubted && inliers >= kDoubtBelow * static_cast<double>(moved.size())) return known;
    // Many points disagree, or they were not where they were predicted. A wrong gyro bias must not
    // end the tracks.
    std::vector<unsigned char> free = fundamentalInliers(before, now, focal_px_, threshold);
    const double gain = doubted ? kDoubtedGain : kFallbackGain;
    if (static_cast<double>(count(free)) <= gain * inliers) return known;
    report->rotation_overruled = true;
    return free;
  }
  return fundamentalInliers(before, now, focal_px_, threshold);
}

// Drops the tracks that contradict the others over three views, some images apart; returns how
// many. Needs rotations known over that time.
int PointTracker::checkThreeViews(const RotationPrior& prior, std::vector<PointTrack>* moved) {
  if (!prior.known) {
    for (PointTrack& track : *moved) track.marks = 0;
    since_mark_s_ = 0.0;
    R_now_mark_.setIdentity();
    return 0;
  }
  R_now_mark_ = prior.R_now_before * R_now_mark_;
  since_mark_s_ += prior.dt_s;
  if (since_mark_s_ + 0.5 * prior.dt_s < kMarkS) return 0;
  const RowCamera lens(camera_, prior.rows_now);
  const int removed = keepFlagged(threeViewFlags(*moved, lens), moved);
  setMark(lens, moved);
  return removed;
}

// One flag per track, 0 for one that disagrees. All are 1 where many disagree: then it is the
// rotation that is wrong, or the scene that moves.
std::vector<unsigned char> PointTracker::threeViewFlags(const std::vector<PointTrack>& moved,
                                                        const RowCamera& lens) const {
  std::vector<std::size_t> chosen;
  std::vector<Eigen::Vector3d> older, newer, now;
  const Eigen::Matrix3d R_now_older = R_now_mark_ * R_mark_older_;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const PointTrack& track = moved[k];
    if (track.marks < 2) continue;
    chosen.push_back(k);
    older.push_back(R_now_older * track.mark_rays[0]);
    newer.push_back(R_now_mark_ * track.mark_rays[1]);
    now.push_back(lens.atMiddleRow(track.bearing, track.pixel.y));
  }
  const std::vector<unsigned char> inliers =
      threeViewInliers(older, newer, now, focal_px_, options_.points.epipolar_px, kThreeViewPx);
  const auto wrong = static_cast<double>(std::count(inliers.begin(), inliers.end(), 0));
  std::vector<unsigned char> flags(moved.size(), 1);
  if (wrong > kMostWrong * static_cast<double>(chosen.size())) return flags;
  for (std::size_t j = 0; j < chosen.size(); ++j) flags[chosen[j]] = inliers[j];
  return flags;
}

// Makes this image the newer mark, at which every track remembers its ray.
void PointTracker::setMark(const RowCamera& lens, std::vector<PointTrack>* tracks) {
  for (PointTrack& track : *tracks) {
    track.mark_rays[0] = track.mark_rays[1];
    track.mark_rays[1] = lens.atMiddleRow(track.bearing, track.pixel.y);
    track.marks = std::min(track.marks + 1, 2);
  }
  R_mark_older_ = R_now_mark_;
  R_now_mark_.setIdentity();
  since_mark_s_ = 0.0;
}

void PointTracker::thinOut(double min_distance, double mask_distance) {
  std::stable_sort(tracks_.begin(), tracks_.end(),
                   [](const PointTrack& a, const PointTrack& b) { return a.age > b.age; });
  mask_ = usable_.clone();
  std::vector<PointTrack> kept;
  const auto paint = [&](double radius, const PointTrack& track) {
    cv::circle(mask_, cv::Point(cvRound(track.pixel.x), cvRound(track.pixel.y)),
               static_cast<int>(radius), cv::Scalar(0), cv::FILLED);
  };
  for (const PointTrack& track : tracks_) {
    if (mask_.at<uchar>(cvRound(track.pixel.y), cvRound(track.pixel.x)) == 0) continue;
    paint(min_distance, track);
    kept.push_back(track);
  }
  if (mask_distance > min_distance) {
    for (const PointTrack& track : kept) paint(mask_distance, track);
  }
  tracks_ = std::move(kept);
}

// New corners up to the number wanted, far enough from the points there are.
void PointTracker::refillDefault(const ImagePyramid& now) {
  const int most = options_.points.max_points;
  for (int level = 0; level < kLevels; ++level) {
    const double share = level == 0 ? 1.0 : kCoarseShare;
    addCorners(now.from(level), level,
               static_cast<int>(share * most) - static_cast<int>(tracks_.size()));
  }
}

// `now` begins with `level`.
void PointTracker::addCorners(const ImagePyramid& now, int level, int wanted) {
  const PointTrackerOptions& o = options_.points;
  if (wanted <= 0 || now.empty()) return;
  const bool everywhere = static_cast<double>(tracks_.size()) < kRefillAll * o.max_points;
  cv::Mat free;  // a corner that is not taken keeps nothing off on the next level
  cv::resize(mask_, free, now.level(0).size(), 0.0, 0.0, cv::INTER_NEAREST);
  std::vector<cv::Point2f> found;
  CornerDetector& corners = corners_[level];
  corners.detect(now.derivative(0),
                 o.corner_noise_factor * kNoiseEigenvalue * now.noise * now.noise, wanted,
                 everywhere ? corners.cells() : kCellsPerImage, &free, &found);
  if (level > 0) dropSmooth(now, &found);
  if (found.empty()) return;
  // The vertex of the edges is the same place from near and far. The strongest response lies a
  // pixel or two inside, which becomes an error as the scene comes closer.
  const std::vector<cv::Point2f> strongest = found;
  cv::cornerSubPix(now.level(0), found, cv::Size(kVertexHalfPx, kVertexHalfPx), cv::Size(-1, -1),
                   kVertexEnd);
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!(cv::norm(found[k] - strongest[k]) < kMaxVertexPx)) found[k] = strongest[k];
  }
  for (const cv::Point2f& corner : found) {
    const cv::Point2f place = pixelOf(level) * corner;
    if (isMasked(options_.mask, place)) continue;  // moved there by cornerSubPix()
    auto anchor = std::make_shared<PatchAnchor>();
    if (!anchor->set(now.level(0), toEigen(corner), now.noise)) continue;
    if (!addTrack(place)) continue;
    tracks_.back().anchor = std::move(anchor);
    tracks_.back().level = level;
    cv::circle(mask_, cv::Point(cvRound(place.x), cvRound(place.y)),
               static_cast<int>(o.min_distance_px), cv::Scalar(0), cv::FILLED);
  }
}

// --------------------------------------------------------------------------------- profile `vins`

void PointTracker::followVins(double t, const ImagePyramid& before, const ImagePyramid& now,
                              ImageReport* report) {
  std::vector<PointTrack> moved;
  if (!tracks_.empty() && !before.empty()) moved = searchVins(before, now);
  // The host rejects, thins out and refills only in images that it publishes.
  const bool published = report->publishable = countPublished(t);
  if (published) rejectVins(&moved, report);
  tracks_ = std::move(moved);
  if (published) {
    thinOut(options_.host.min_dist, options_.host.min_dist);
  } else {
    mask_.release();
  }
}

// The tracks that KLT finds inside this image, moved there.
std::vector<PointTrack> PointTracker::searchVins(const ImagePyramid& before,
                                                 const ImagePyramid& now) const {
  std::vector<cv::Point2f> from, to;
  for (const PointTrack& track : tracks_) from.push_back(track.pixel);
  std::vector<uchar> ok;
  std::vector<float> unused;
  cv::calcOpticalFlowPyrLK(before.pyramid, now.pyramid, from, to, ok, unused,
                           cv::Size(vins::kWindowPx, vins::kWindowPx),
                           std::min({vins::kLevels, before.max_level, now.max_level}));
  std::vector<PointTrack> moved;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const cv::Point2f rounded(static_cast<float>(cvRound(to[i].x)),
                              static_cast<float>(cvRound(to[i].y)));
    // The host's image border; its circle is applied when points are thinned out.
    const bool inside = rounded.x >= vins::kBorderPx && rounded.y >= vins::kBorderPx &&
                        rounded.x < usable_.cols - vins::kBorderPx &&
                        rounded.y < usable_.rows - vins::kBorderPx;
    if (ok[i] == 0 || !inside || isMasked(options_.mask, to[i])) continue;
    PointTrack track = tracks_[i];
    if (!advance(to[i], &track)) continue;
    moved.push_back(track);
  }
  return moved;
}

// Whether the host publishes the image at `t`, by its rule for HostFrontEnd::freq; counts it if so.
bool PointTracker::countPublished(double t) {
  if (!std::isfinite(t_count_start_)) t_count_start_ = t;
  const double hz = options_.host.freq == 0 ? vins::kEveryImageHz : options_.host.freq;
  const double elapsed = t - t_count_start_;
  const double rate = elapsed > 0.0 ? published_ / elapsed : 0.0;
  if (std::round(rate) > hz) return false;
  if (elapsed > 0.0 && std::abs(rate - hz) < vins::kRateTolerance * hz) {
    t_count_start_ = t;
    published_ = 0;
  }
  ++published_;
  return true;
}

void PointTracker::rejectVins(std::vector<PointTrack>* moved, ImageReport* report) const {
  std::vector<Eigen::Vector3d> rays_before, rays_now;
  for (const PointTrack& track : *moved) {
    rays_before.push_back(track.bearing_before);
    rays_now.push_back(track.bearing);
  }
  report->points_outliers = keepFlagged(
      fundamentalInliers(rays_before, rays_now, vins::kFocalPx, options_.host.F_threshold), moved);
}

void PointTracker::refillVins(const ImagePyramid& now) {
  const HostFrontEnd& host = options_.host;
  const int wanted = host.max_cnt - static_cast<int>(tracks_.size());
  if (wanted <= 0) return;
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(now.level(0), found, wanted, vins::kQuality, host.min_dist, mask_);
  for (const cv::Point2f& corner : found) addTrack(corner);
}

}  // namespace slim_init::feature_tracker_lines
