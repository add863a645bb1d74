// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/image_front_end.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "feature_tracker.h"
#include "imu/preintegration.h"
#include "imu/row_compensation.h"
#include "rotation/robust_bias.h"
#include "rotation_prior.h"
#include "slim_init/types.h"
#include "stopwatch.h"

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

/// Angular rate at time t, linear between the samples and constant beyond them [rad/s].
Eigen::Vector3d gyroAt(const std::vector<ImuSample>& samples, double t) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), t,
                                      [](double time, const ImuSample& s) { return time < s.t; });
  if (after == samples.begin()) return samples.front().gyro;
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

}  // namespace

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
        options_(options),
        tracker_(camera, options),
        window_(calibration, biasWindow(options.window), limitedTo(options.imu)) {
    reset();
  }

  AddStatus addImu(const ImuSample& sample) { return window_.addImu(sample); }
  ImageStatus addImage(double t, const cv::Mat& image, FrameObservation* frame);
  const ImageReport& report() const { return report_; }
  cv::Mat debugImage() const { return tracker_.debugImage(); }

  void reset() {
    tracker_.reset();
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
  void doubtBias(const ImageReport& report);
  void forgetBias();
  void updateBias(const FrameObservation& frame);
  void estimateBias(double t_imu);

  CameraParameters camera_;
  Calibration calibration_;
  FrontEndOptions options_;
  FeatureTracker tracker_;
  KeyframeWindow window_;
  ImageReport report_;  // of the last tracked image
  cv::Mat grey_;
  double t_last_ = kNotComputed;           // last image [s], camera clock
  double dt_last_ = kNotComputed;          // between the last two images [s]
  double t_next_estimate_ = kNotComputed;  // of the gyro bias [s], IMU clock
  int estimates_ = 0;                      // of the gyro bias
  int overruled_ = 0;                      // images in a row whose known rotation was overruled
  std::optional<Eigen::Vector3d> bias_;    // of the gyroscope [rad/s]
};

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

// Estimates the gyro bias from the tracks in the bias window, if it is time to.
void ImageFrontEnd::Impl::estimateBias(double t_imu) {
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
                                inertial);
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

// A known rotation that is overruled again and again comes from a wrong bias.
void ImageFrontEnd::Impl::doubtBias(const ImageReport& report) {
  overruled_ = report.rotation_overruled ? overruled_ + 1 : 0;
  if (overruled_ >= kOverruledToForget) forgetBias();
}

void ImageFrontEnd::Impl::updateBias(const FrameObservation& frame) {
  FrameObservation points;
  points.t = frame.t;
  points.points = frame.points;
  window_.addFrame(points);
  estimateBias(frame.t + calibration_.td);
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
  Stopwatch watch;
  if (t - t_last_ > kMaxImageGapS) tracker_.reset();
  const RotationPrior prior = predictRotation(t, report);
  report->stages.push_back({"predict", watch.lap()});
  tracker_.track(t, toGrey(image), prior, frame, report);
  setRows(camera_.height, frame);
  watch.lap();
  if (options_.use_gyro && options_.profile == TrackerProfile::kDefault) {
    doubtBias(*report);
    updateBias(*frame);
  }
  report->stages.push_back({"gyro_bias", watch.lap()});
  report->gyro_bias_known = bias_.has_value();
  if (bias_) report->gyro_bias = *bias_;
}

ImageStatus ImageFrontEnd::Impl::addImage(double t, const cv::Mat& image, FrameObservation* frame) {
  if (!std::isfinite(t)) return ImageStatus::kNotFinite;
  if (t <= t_last_) return ImageStatus::kOutOfOrder;  // false before the first image
  if (!isUsable(image)) return ImageStatus::kBadImage;
  Stopwatch watch;
  ImageReport report;
  FrameObservation result;
  result.t = t;
  try {
    track(t, image, &result, &report);
  } catch (const cv::Exception&) {
    // OpenCV refused the image: tracking restarts with the next one. Other exceptions (no memory)
    // are errors of the program and go to the caller.
    tracker_.reset();
    t_last_ = t;
    dt_last_ = kNotComputed;
    return ImageStatus::kBadImage;
  }
  report.total_ms = watch.lap();
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
