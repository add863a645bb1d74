// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/image_front_end.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "image_pyramid.h"
#include "imu/preintegration.h"
#include "imu/row_compensation.h"
#include "line_tracker.h"
#include "point_tracker.h"
#include "rotation/robust_bias.h"
#include "row_camera.h"
#include "slim_init/types.h"
#include "vins_constants.h"

namespace slim_init::feature_tracker_lines {
namespace {

// A longer gap between images ends all tracks; VINS-Mono resets its tracker then as well.
constexpr double kMaxImageGapS = 1.0;
// IMU and frames kept: the bias window below (about one second) with a margin for slow cameras.
constexpr double kImuBufferS = 3.0;

// Window of the front end's own gyro bias estimate: short, for an early answer. Rotations over one
// second give the bias to about 1e-3 rad/s, and the outlier check tolerates 2e-2 rad/s.
constexpr int kBiasKeyframes = 8;
constexpr int kBiasLeastKeyframes = 4;
constexpr double kBiasKeyframeIntervalS = 0.12;
// The first estimates follow each other quickly, while each is much better than the last one.
constexpr int kEarlyEstimates = 4;
constexpr double kEarlyEstimateIntervalS = 0.25;
constexpr double kLateEstimateIntervalS = 1.0;
// Images in a row whose known rotation was overruled, after which the bias is discarded.
constexpr int kOverruledToForget = 3;

WindowOptions biasWindow(const WindowOptions& gaps) {
  WindowOptions options = gaps;
  options.keyframes = kBiasKeyframes;
  options.min_keyframes = kBiasLeastKeyframes;
  options.min_interval_s = kBiasKeyframeIntervalS;
  options.buffer_s = kImuBufferS;
  return options;
}

/// Angular rate at a time from the first sample on, linear between the samples and constant beyond
/// the last one [rad/s].
Eigen::Vector3d gyroAt(const std::vector<ImuSample>& samples, double t) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), t,
                                      [](double time, const ImuSample& s) { return time < s.t; });
  if (after == samples.end()) return samples.back().gyro;
  const ImuSample& before = *std::prev(after);
  const double share = (t - before.t) / (after->t - before.t);
  return (1.0 - share) * before.gyro + share * after->gyro;
}

StreamOptions limitedTo(const ImuLimits& limits) {
  StreamOptions options;
  options.imu = limits;
  return options;
}

// Distance of points in a halved image [px], at least: closer ones share most of their patches.
constexpr double kLeastDistancePx = 10.0;

// A dark image is tracked with its grey levels multiplied by 2, 4 or 8: all its contrast lies in a
// few levels, and the fixed-point arithmetic of detection and tracking rounds most of it away. What
// counts is the level that one pixel in a hundred exceeds. The factor is kept while that level
// stays between these two, since a change costs a pyramid.
constexpr int kMaxGain = 8;
constexpr int kDarkLevel = 60, kBrightLevel = 240;
constexpr int kWantedLevel = 160;  // after a change at most

// Grey level that one of a hundred pixels exceeds; every fourth row and column counts.
int brightLevel(const cv::Mat& grey) {
  std::array<int, 256> histogram{};
  int count = 0;
  for (int y = 0; y < grey.rows; y += 4) {
    const uchar* row = grey.ptr<uchar>(y);
    for (int x = 0; x < grey.cols; x += 4, ++count) ++histogram[row[x]];
  }
  int level = 255;
  for (int above = histogram[255]; level > 0 && 100 * above <= count;) {
    above += histogram[--level];
  }
  return level;
}

int gainFor(const cv::Mat& grey, int present) {
  const int level = brightLevel(grey);
  const int seen = level * present;
  // As it came until it is dark, and brightened until it is bright.
  if (present == 1 ? seen >= kDarkLevel : seen >= kDarkLevel && seen <= kBrightLevel) {
    return present;
  }
  int gain = 1;
  while (gain < kMaxGain && 2 * gain * level <= kWantedLevel) gain *= 2;
  return gain;
}

// VINS-Mono works on the image as it is.
int halvingsOf(const CameraParameters& camera, TrackerProfile profile) {
  return profile == TrackerProfile::kVins ? 0 : halvingsFor({camera.width, camera.height});
}

// The camera of the halved image, whose pixel (x, y) lies at (2 x, 2 y).
CameraParameters halved(CameraParameters camera, int halvings) {
  for (int i = 0; i < halvings; ++i) {
    camera.width = (camera.width + 1) / 2;
    camera.height = (camera.height + 1) / 2;
    for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value *= 0.5;
  }
  return camera;
}

// The options for that image: the distance between points is one in the camera's image.
FrontEndOptions halved(FrontEndOptions options, const CameraParameters& camera, int halvings) {
  if (options.mask.empty() && options.host.fisheye) options.mask = imageCircle(camera);
  if (halvings == 0) return options;
  double& distance_px = options.points.min_distance_px;
  distance_px =
      std::max(std::ldexp(distance_px, -halvings), std::min(distance_px, kLeastDistancePx));
  if (!options.mask.empty()) {
    cv::resize(options.mask, options.mask, cv::Size(camera.width, camera.height), 0.0, 0.0,
               cv::INTER_NEAREST);
  }
  return options;
}

// Sub-pixel drawing: OpenCV takes coordinates with binary places.
constexpr int kShift = 4;
const cv::Scalar kDetected(150, 150, 150), kMatched(255, 120, 0);
constexpr int kOldAge = 40;  // images: 2 s at 20 Hz

cv::Point fixedPoint(double x, double y) {
  return {cvRound(x * (1 << kShift)), cvRound(y * (1 << kShift))};
}

// Blue for new over green to red for old.
cv::Scalar ageColour(int age) {
  const double share = std::min(1.0, (age - 1) / static_cast<double>(kOldAge));
  const auto ramp = [share](double middle) {
    return 255.0 * std::clamp(1.5 - 3.0 * std::abs(share - middle), 0.0, 1.0);
  };
  return {ramp(0.0), ramp(0.5), ramp(1.0)};
}

}  // namespace

cv::Mat imageCircle(const CameraParameters& camera) {
  cv::Mat circle(camera.height, camera.width, CV_8UC1, cv::Scalar(0));
  cv::circle(circle, cv::Point(cvRound(camera.cx), cvRound(camera.cy)),
             std::max(camera.width, camera.height) / 2, cv::Scalar(255), cv::FILLED);
  return circle;
}

const char* toString(ImageStatus status) {
  switch (status) {
    case ImageStatus::kTracked: return "tracked";
    case ImageStatus::kNotFinite: return "not_finite";
    case ImageStatus::kOutOfOrder: return "out_of_order";
    case ImageStatus::kBadImage: return "bad_image";
  }
  return "unknown";
}

class ImageFrontEnd::Impl {
 public:
  Impl(const CameraParameters& camera, const Calibration& calibration,
       const FrontEndOptions& options)
      : camera_(camera),
        calibration_(calibration),
        halvings_(halvingsOf(camera, options.profile)),
        options_(halved(options, halved(camera, halvings_), halvings_)),
        points_(halved(camera, halvings_), options_),
        lines_(halved(camera, halvings_), options_),
        window_(calibration, biasWindow(options.window), limitedTo(options.imu)) {
    reset();
  }

  AddStatus addImu(const ImuSample& sample) { return window_.addImu(sample); }
  ImageStatus addImage(double t, const cv::Mat& image, FrameObservation* frame);
  const ImageReport& report() const { return report_; }
  cv::Mat debugImage() const;

  void reset() {
    forgetTracks();
    window_.reset();
    report_ = ImageReport();
    t_last_ = dt_last_ = kNotComputed;
    forgetBias();
  }

 private:
  bool isUsable(const cv::Mat& image) const;
  const cv::Mat& toGrey(const cv::Mat& image);
  RotationPrior predictRotation(double t, ImageReport* report) const;
  RotationPrior rotationPrior(double t_before, double t_now) const;
  void track(double t, const cv::Mat& image, FrameObservation* frame, ImageReport* report);
  void prepare(const cv::Mat& grey);
  void follow(double t, const RotationPrior& given, ImageReport* report);
  void writeObservations(FrameObservation* frame) const;
  void forgetTracks();
  void forgetBias();
  void updateBias(const FrameObservation& frame);

  CameraParameters camera_;
  Calibration calibration_;
  int halvings_;  // of the camera's image until the one that is tracked
  FrontEndOptions options_;
  PointTracker points_;
  LineTracker lines_;
  ImagePyramid before_, now_;
  int gain_ = 1;  // default profile: factor on the grey levels
  KeyframeWindow window_;
  ImageReport report_;                     // of the last tracked image
  cv::Mat grey_, changed_;                 // of a colour image; equalized or brightened
  double t_last_ = kNotComputed;           // last image [s], camera clock
  double dt_last_ = kNotComputed;          // between the last two images [s]
  double t_next_estimate_ = kNotComputed;  // of the gyro bias [s], IMU clock
  int estimates_ = 0;                      // of the gyro bias
  int overruled_ = 0;                      // images in a row whose known rotation was overruled
  std::optional<Eigen::Vector3d> bias_;    // of the gyroscope [rad/s]
};

// Points and lines from the image before to this one, and new ones.
void ImageFrontEnd::Impl::follow(double t, const RotationPrior& given, ImageReport* report) {
  // Lines move as the points do that were followed, beyond the rotation that these were found with.
  RotationPrior prior = given;
  points_.follow(t, &before_, now_, &prior, report);
  points_.refill(now_, report);
  if (!options_.lines.enabled) return;
  std::vector<LineSegment> segments = lines_.detect(now_, given);
  lines_.track(before_, now_, prior, std::move(segments), points_.motion(prior), report);
}

void ImageFrontEnd::Impl::forgetTracks() {
  points_.reset();
  lines_.reset();
  before_ = now_ = ImagePyramid();
  gain_ = 1;
}

// Builds the pyramid of the image: equalized as VINS-Mono does it, or brightened where it is dark,
// if the host's `equalize` allows it. Both images of a step have the same factor: KLT compares grey
// levels.
void ImageFrontEnd::Impl::prepare(const cv::Mat& grey) {
  const bool equalize = options_.host.equalize;
  if (options_.profile == TrackerProfile::kVins) {
    const cv::Size tiles(vins::kClaheTiles, vins::kClaheTiles);
    if (equalize) cv::createCLAHE(vins::kClaheLimit, tiles)->apply(grey, changed_);
    buildImagePyramid(equalize ? changed_ : grey, vins::kWindowPx, vins::kLevels, halvings_, &now_);
    return;
  }
  const int gain_before = std::exchange(gain_, equalize ? gainFor(grey, gain_) : 1);
  if (gain_ != gain_before && !before_.empty()) {
    scaleRows({static_cast<double>(gain_) / gain_before}, &before_);
  }
  if (gain_ > 1) grey.convertTo(changed_, CV_8U, gain_);
  buildImagePyramid(gain_ > 1 ? changed_ : grey,
                    std::max(options_.points.window_px, LineTracker::kWindowPx),
                    std::max(options_.points.levels, 1), halvings_, &now_);
}

void ImageFrontEnd::Impl::writeObservations(FrameObservation* frame) const {
  const double scale = std::ldexp(1.0, halvings_);
  for (const PointTrack& track : points_.tracks()) {
    PointObservation point;
    point.id = track.id;
    point.bearing = track.bearing;
    point.pixel = scale * toEigen(track.pixel);
    frame->points.push_back(point);
  }
  const RowCamera& lens = lines_.lens();
  for (const LineTrack& track : lines_.tracks()) {
    LineObservation line;
    line.id = track.id;
    line.start_bearing = lens.atOwnRow(track.edge.start, track.edge.start_pixel.y());
    line.end_bearing = lens.atOwnRow(track.edge.end, track.edge.end_pixel.y());
    line.start_pixel = scale * track.edge.start_pixel;
    line.end_pixel = scale * track.edge.end_pixel;
    line.length_px = scale * track.edge.length_px;
    line.detection_confidence = track.confidence;
    line.match_quality = track.match_quality;
    frame->lines.push_back(line);
  }
}

cv::Mat ImageFrontEnd::Impl::debugImage() const {
  if (now_.empty()) return {};
  cv::Mat image;
  cv::cvtColor(now_.level(0), image, cv::COLOR_GRAY2BGR);
  for (const cv::Vec4f& s : lines_.detected()) {
    cv::line(image, fixedPoint(s[0], s[1]), fixedPoint(s[2], s[3]), kDetected, 1, cv::LINE_AA,
             kShift);
  }
  for (const LineTrack& line : lines_.tracks()) {
    // New lines have been drawn as detections.
    if (line.age < 2) continue;
    const Edge& edge = line.edge;
    cv::line(image, fixedPoint(edge.start_pixel.x(), edge.start_pixel.y()),
             fixedPoint(edge.end_pixel.x(), edge.end_pixel.y()), kMatched, 2, cv::LINE_AA, kShift);
  }
  for (const PointTrack& point : points_.tracks()) {
    cv::circle(image, fixedPoint(point.pixel.x, point.pixel.y), 3 << kShift, ageColour(point.age),
               cv::FILLED, cv::LINE_AA, kShift);
  }
  return image;
}

// Rotation of the camera between two times on the IMU clock.
RotationPrior ImageFrontEnd::Impl::rotationPrior(double t_before, double t_now) const {
  RotationPrior prior;
  const std::deque<ImuSample>& imu = window_.imu();
  if (!std::isfinite(t_before) || imu.empty()) return prior;
  const auto after = std::upper_bound(imu.begin(), imu.end(), t_before,
                                      [](double t, const ImuSample& s) { return t < s.t; });
  if (after == imu.begin()) return prior;
  std::vector<ImuSample> samples(std::prev(after), imu.end());
  // The newest sample is slightly older than the image: its rate is extrapolated.
  if (samples.back().t < t_now) {
    samples.push_back(samples.back());
    samples.back().t = t_now;
  }
  // A camera in the hand changes its rate within a few hundredths of a second: across a longer gap
  // the rotation is unknown.
  const double max_gap = window_.options().max_imu_gap_s;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].t - samples[i - 1].t > max_gap && samples[i - 1].t < t_now) return prior;
  }
  const Eigen::Vector3d bias = bias_.value_or(Eigen::Vector3d::Zero());
  const Preintegration pre = preintegrate(samples, t_before, t_now, {bias, Eigen::Vector3d::Zero()},
                                          calibration_.imu_noise, PreintegrationParts::kRotation);
  const Eigen::Matrix3d& R_b_c = calibration_.R_b_c;
  prior.measured = true;
  prior.R_now_before = R_b_c.transpose() * pre.dR.transpose() * R_b_c;
  prior.known = bias_.has_value();
  prior.rows_before.readout_s = prior.rows_now.readout_s = calibration_.readout_s;
  prior.rows_before.rate_c = R_b_c.transpose() * (gyroAt(samples, t_before) - bias);
  prior.rows_now.rate_c = R_b_c.transpose() * (gyroAt(samples, t_now) - bias);
  return prior;
}

// Adds the points of a frame to the bias window, and estimates the gyro bias if it is time to.
void ImageFrontEnd::Impl::updateBias(const FrameObservation& frame) {
  FrameObservation points;
  points.t = frame.t;
  points.points = frame.points;
  window_.addFrame(points);
  const double t_imu = frame.t + calibration_.td;
  if (std::isfinite(t_next_estimate_) && t_imu < t_next_estimate_) return;
  const WindowCut cut = window_.cut();
  if (cut.window == nullptr) return;
  t_next_estimate_ =
      t_imu + (estimates_ < kEarlyEstimates ? kEarlyEstimateIntervalS : kLateEstimateIntervalS);
  // Null for a global shutter, where the window is right as it is.
  const auto compensated =
      withRowsCompensated(*cut.window, bias_.value_or(Eigen::Vector3d::Zero()));
  const InertialOptions inertial;
  RobustBiasEstimator estimator(compensated != nullptr ? *compensated : *cut.window, nullptr,
                                inertial, {RigError(), {0.0, 0.0, 0.0, 0.0}});
  const RobustBias estimate = estimator.quick();
  // One that is not clean is better than none, but not than the last one.
  if (!estimate.valid() || (bias_ && !estimate.clean)) return;
  ++estimates_;
  bias_ = estimate.gyro_bias;
}

void ImageFrontEnd::Impl::forgetBias() {
  bias_.reset();
  overruled_ = 0;
  estimates_ = 0;
  t_next_estimate_ = kNotComputed;
}

bool ImageFrontEnd::Impl::isUsable(const cv::Mat& image) const {
  return !image.empty() && image.dims == 2 && image.cols == camera_.width &&
         image.rows == camera_.height && (image.type() == CV_8UC1 || image.type() == CV_8UC3);
}

const cv::Mat& ImageFrontEnd::Impl::toGrey(const cv::Mat& image) {
  if (image.type() == CV_8UC1) return image;
  cv::cvtColor(image, grey_, cv::COLOR_BGR2GRAY);
  return grey_;
}

// Rotation since the last image, for an image at `t` on the camera clock.
RotationPrior ImageFrontEnd::Impl::predictRotation(double t, ImageReport* report) const {
  RotationPrior prior;
  if (!std::isfinite(t_last_)) return prior;
  if (options_.use_gyro) {
    prior = rotationPrior(t_last_ + calibration_.td, t + calibration_.td);
    report->rotation_from_gyro = prior.measured;
    report->rotation_missing = !prior.measured;
  }
  prior.dt_s = t - t_last_;
  if (std::isfinite(dt_last_)) prior.dt_ratio = prior.dt_s / dt_last_;
  return prior;
}

// Rotation from the gyro, tracking, gyro bias from the tracks. Throws what OpenCV throws.
void ImageFrontEnd::Impl::track(double t, const cv::Mat& image, FrameObservation* frame,
                                ImageReport* report) {
  if (t - t_last_ > kMaxImageGapS) forgetTracks();
  const RotationPrior prior = predictRotation(t, report);
  std::swap(before_, now_);
  prepare(toGrey(image));
  report->image_noise = now_.noise;
  follow(t, prior, report);
  writeObservations(frame);
  setRows(camera_.height, frame);
  if (options_.use_gyro && options_.profile == TrackerProfile::kDefault) {
    // A known rotation that is overruled again and again comes from a wrong bias.
    overruled_ = report->rotation_overruled ? overruled_ + 1 : 0;
    if (overruled_ >= kOverruledToForget) forgetBias();
    updateBias(*frame);
  }
  report->gyro_bias_known = bias_.has_value();
  if (bias_) report->gyro_bias = *bias_;
}

ImageStatus ImageFrontEnd::Impl::addImage(double t, const cv::Mat& image, FrameObservation* frame) {
  if (!std::isfinite(t)) return ImageStatus::kNotFinite;
  if (t <= t_last_) return ImageStatus::kOutOfOrder;  // false before the first image
  if (!isUsable(image)) return ImageStatus::kBadImage;
  const auto begin = std::chrono::steady_clock::now();
  ImageReport report;
  FrameObservation result;
  result.t = t;
  try {
    track(t, image, &result, &report);
  } catch (const cv::Exception&) {
    // OpenCV refused the image: tracking restarts with the next one. Other exceptions (no memory)
    // are errors of the program and go to the caller.
    forgetTracks();
    t_last_ = t;
    dt_last_ = kNotComputed;
    return ImageStatus::kBadImage;
  }
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
  report.total_ms = taken.count();
  report_ = std::move(report);
  dt_last_ = t - t_last_;  // NaN at the first image
  t_last_ = t;
  *frame = std::move(result);
  return ImageStatus::kTracked;
}

ImageFrontEnd::ImageFrontEnd(const CameraParameters& camera, const Calibration& calibration,
                             const FrontEndOptions& options)
    : impl_(std::make_unique<Impl>(camera, calibration, options)) {}
ImageFrontEnd::~ImageFrontEnd() = default;
ImageFrontEnd::ImageFrontEnd(ImageFrontEnd&&) noexcept = default;
ImageFrontEnd& ImageFrontEnd::operator=(ImageFrontEnd&&) noexcept = default;

AddStatus ImageFrontEnd::addImu(const ImuSample& sample) { return impl_->addImu(sample); }
ImageStatus ImageFrontEnd::addImage(double t, const cv::Mat& image, FrameObservation* frame) {
  return impl_->addImage(t, image, frame);
}
const ImageReport& ImageFrontEnd::report() const { return impl_->report(); }
cv::Mat ImageFrontEnd::debugImage() const { return impl_->debugImage(); }
void ImageFrontEnd::reset() { impl_->reset(); }

}  // namespace slim_init::feature_tracker_lines
