// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/image_front_end.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "feature_tracker.h"
#include "imu/preintegration.h"
#include "rotation/multi_gap_bias.h"
#include "rotation_prior.h"
#include "stopwatch.h"

namespace slim_init::feature_tracker_lines {
namespace {

// Longer gaps between images end all tracks; the host resets its tracker then as well.
constexpr double kMaxImageGap = 1.0;  // [s]
constexpr double kMaxImuGap = 0.05;   // [s]
constexpr double kImuBuffer = 3.0;    // [s]

// The window of the own bias estimate: short, for an early answer. Even so rotations of a second
// tell the bias to some 1e-3 rad/s, and 2e-2 rad/s is what the outlier check can bear.
constexpr int kBiasKeyframes = 8, kBiasLeastKeyframes = 4;
constexpr double kBiasKeyframeInterval = 0.12;  // [s]
constexpr double kFirstEstimates = 4, kEstimateInterval = 0.25, kLateEstimateInterval = 1.0;
// The information of the estimate knows nothing of wrong tracks.
constexpr double kSigmaFactor = 2.0, kLeastSigma = 1e-3;  // -, [rad/s]
constexpr int kDoubtsToForget = 3;  // images in a row in which the known rotation was overruled

WindowOptions biasWindow() {
  WindowOptions options;
  options.keyframes = kBiasKeyframes;
  options.min_keyframes = kBiasLeastKeyframes;
  options.min_interval_s = kBiasKeyframeInterval;
  options.buffer_s = kImuBuffer;
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
        focal_px_(Camera(camera).focalPx()),
        tracker_(camera, options, calibration.sigma_line_px / calibration.focal_px),
        window_(calibration, biasWindow()) {
    reset();
  }

  AddStatus addImu(const ImuSample& sample) {
    const AddStatus status = window_.addImu(sample);
    switch (status) {
      case AddStatus::kAdded: ++report_.imu_added; break;
      case AddStatus::kNotFinite: ++report_.imu_not_finite; break;
      case AddStatus::kOutOfOrder: ++report_.imu_out_of_order; break;
    }
    return status;
  }

  ImageStatus addImage(double t, const cv::Mat& image, FrameObservation* frame);
  void setGyroBias(const Eigen::Vector3d& gyro_bias, double sigma);
  const FrontEndReport& report() const { return report_; }
  cv::Mat debugImage() const { return tracker_.debugImage(); }

  void reset() {
    tracker_.reset();
    window_.reset();
    report_ = FrontEndReport();
    if (options_.lines.enabled) report_.line_detector = tracker_.lineDetectorName();
    t_last_ = kNotComputed;
    t_next_estimate_ = kNotComputed;
    estimates_ = 0;
    doubts_ = 0;
    bias_.reset();
  }

 private:
  struct Bias {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    double sigma = 0.0;
  };

  RotationPrior rotationPrior(double t_before, double t_now) const;
  void estimateBias(double t_imu);

  CameraParameters camera_;
  Calibration calibration_;
  FrontEndOptions options_;
  double focal_px_;
  FeatureTracker tracker_;
  KeyframeWindow window_;
  FrontEndReport report_;
  cv::Mat grey_;
  double t_last_ = kNotComputed;           // camera clock
  double t_next_estimate_ = kNotComputed;  // IMU clock
  int estimates_ = 0;
  int doubts_ = 0;
  std::optional<Bias> bias_;
};

// Rotation of the camera between two images, IMU clock.
RotationPrior ImageFrontEnd::Impl::rotationPrior(double t_before, double t_now) const {
  RotationPrior prior;
  const std::deque<ImuSample>& imu = window_.imu();
  if (!std::isfinite(t_before) || imu.empty()) return prior;
  const auto after = std::upper_bound(imu.begin(), imu.end(), t_before,
                                      [](double t, const ImuSample& s) { return t < s.t; });
  if (after == imu.begin()) return prior;
  std::vector<ImuSample> samples(std::prev(after), imu.end());
  // The newest sample is a little older than the image: its rate holds on.
  if (samples.back().t < t_now) {
    samples.push_back(samples.back());
    samples.back().t = t_now;
  }
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].t - samples[i - 1].t > kMaxImuGap && samples[i - 1].t < t_now) return prior;
  }
  const Eigen::Vector3d bias = bias_ ? bias_->value : Eigen::Vector3d::Zero();
  const Preintegration pre = preintegrate(samples, t_before, t_now, bias, Eigen::Vector3d::Zero(),
                                          calibration_.imu_noise, PreintegrationParts::kRotation);
  const Eigen::Matrix3d& R_b_c = calibration_.R_b_c;
  prior.measured = true;
  prior.R_now_before = R_b_c.transpose() * pre.dR.transpose() * R_b_c;
  if (bias_) prior.sigma_px = bias_->sigma * pre.dt * focal_px_;
  return prior;
}

void ImageFrontEnd::Impl::setGyroBias(const Eigen::Vector3d& gyro_bias, double sigma) {
  if (!gyro_bias.allFinite() || !std::isfinite(sigma) || sigma < 0.0) return;
  if (bias_ && bias_->sigma < sigma) return;
  bias_ = Bias{gyro_bias, std::max(sigma, kLeastSigma)};
}

void ImageFrontEnd::Impl::estimateBias(double t_imu) {
  if (std::isfinite(t_next_estimate_) && t_imu < t_next_estimate_) return;
  const WindowCut cut = window_.cut();
  if (cut.window == nullptr) return;
  t_next_estimate_ =
      t_imu + (estimates_ < kFirstEstimates ? kEstimateInterval : kLateEstimateInterval);
  std::vector<Eigen::Vector3d> starts = {Eigen::Vector3d::Zero()};
  if (bias_) starts.insert(starts.begin(), bias_->value);
  const MultiGapBiasEstimate estimate =
      estimateMultiGapBias(*cut.window, starts, nullptr, MultiGapBiasOptions());
  if (!estimate.valid) return;
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(estimate.information, Eigen::EigenvaluesOnly)
          .eigenvalues()[0];
  if (!(least > 0.0)) return;
  const double sigma = std::max(kLeastSigma, kSigmaFactor / std::sqrt(least));
  ++estimates_;
  // The newest estimate is the best unless it knows far less, as when the tracks are few.
  if (bias_ && sigma > 3.0 * bias_->sigma) return;
  bias_ = Bias{estimate.gyro_bias, sigma};
}

ImageStatus ImageFrontEnd::Impl::addImage(double t, const cv::Mat& image, FrameObservation* frame) {
  if (!std::isfinite(t)) {
    ++report_.images_not_finite;
    return ImageStatus::kNotFinite;
  }
  if (t <= t_last_) {  // false while there was no image
    ++report_.images_out_of_order;
    return ImageStatus::kOutOfOrder;
  }
  if (image.empty() || image.dims != 2 || image.cols != camera_.width ||
      image.rows != camera_.height || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    ++report_.images_bad;
    return ImageStatus::kBadImage;
  }

  Stopwatch total;
  Stopwatch watch;
  FrontEndReport last_image = FrontEndReport();
  // Totals go on.
  last_image.images = report_.images;
  last_image.images_not_finite = report_.images_not_finite;
  last_image.images_out_of_order = report_.images_out_of_order;
  last_image.images_bad = report_.images_bad;
  last_image.imu_added = report_.imu_added;
  last_image.imu_not_finite = report_.imu_not_finite;
  last_image.imu_out_of_order = report_.imu_out_of_order;
  last_image.images_without_imu = report_.images_without_imu;
  last_image.points_outliers_total = report_.points_outliers_total;
  last_image.fallbacks = report_.fallbacks;
  last_image.line_detector = report_.line_detector;
  FrameObservation result;
  result.t = t;
  try {
    if (t - t_last_ > kMaxImageGap) tracker_.reset();
    RotationPrior prior;
    if (options_.use_gyro && std::isfinite(t_last_)) {
      prior = rotationPrior(t_last_ + calibration_.td, t + calibration_.td);
      if (!prior.measured) ++last_image.images_without_imu;
    }
    last_image.rotation_from_gyro = prior.measured;
    const double predict_ms = watch.lap();
    cv::Mat grey = image;
    if (image.type() == CV_8UC3) {
      cv::cvtColor(image, grey_, cv::COLOR_BGR2GRAY);
      grey = grey_;
    }
    tracker_.track(t, grey, prior, &result, &last_image);
    last_image.stages.insert(last_image.stages.begin(), {"predict", predict_ms});
    watch.lap();
    if (options_.use_gyro && options_.profile == TrackerProfile::kDefault) {
      doubts_ = last_image.fallbacks > report_.fallbacks ? doubts_ + 1 : 0;
      if (doubts_ >= kDoubtsToForget) {
        bias_.reset();
        doubts_ = 0;
        estimates_ = 0;
        t_next_estimate_ = kNotComputed;
      }
      if (options_.estimate_gyro_bias) {
        FrameObservation points;
        points.t = t;
        points.points = result.points;
        window_.addFrame(points);
        estimateBias(t + calibration_.td);
      }
    }
    last_image.stages.push_back({"gyro_bias", watch.lap()});
  } catch (const std::exception&) {
    // OpenCV refused something: start anew with the next image.
    tracker_.reset();
    t_last_ = t;
    ++report_.images_bad;
    return ImageStatus::kBadImage;
  }
  last_image.points_outliers_total += last_image.points_outliers;
  last_image.gyro_bias_known = bias_.has_value();
  if (bias_) {
    last_image.gyro_bias = bias_->value;
    last_image.gyro_bias_sigma = bias_->sigma;
  }
  ++last_image.images;
  last_image.total_ms = total.lap();
  report_ = std::move(last_image);
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
void ImageFrontEnd::setGyroBias(const Eigen::Vector3d& gyro_bias, double sigma) {
  impl_->setGyroBias(gyro_bias, sigma);
}
const FrontEndReport& ImageFrontEnd::report() const { return impl_->report(); }
cv::Mat ImageFrontEnd::debugImage() const { return impl_->debugImage(); }
void ImageFrontEnd::reset() { impl_->reset(); }

}  // namespace slim_init::feature_tracker_lines
