// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/doctor/doctor_images.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "slim_init/evaluation/statistics.h"
#include "slim_init/evaluation/track_images.h"

namespace slim_init::evaluation {
namespace {

/// The smallest value that at least `share` of the pixels do not exceed.
template <typename T>
T pixelQuantile(const cv::Mat& image, double share) {
  std::vector<T> values(image.begin<T>(), image.end<T>());
  const double below = std::ceil(share * static_cast<double>(values.size())) - 1.0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::max(below, 0.0));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Sigma of the sharpest edges [px]: a step of height h, blurred by a Gaussian, is steepest with
/// h / (sqrt(2 pi) sigma). NaN where there are no edges.
double edgeSigma(const cv::Mat& image) {
  constexpr double kSmoothing = 1.0;   // [px], against noise
  constexpr int kReach = 15;           // side of the window in which a step is complete [px]
  constexpr double kMinHeight = 25.0;  // [grey levels]
  constexpr double kSteepest = 0.005;  // share of the pixels that count as edges
  constexpr std::size_t kMinPixels = 50;
  cv::Mat smooth, gx, gy, low, high;
  cv::GaussianBlur(image, smooth, cv::Size(), kSmoothing);
  cv::Sobel(smooth, gx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(smooth, gy, CV_32F, 0, 1, 3, 0.125);
  const cv::Mat window = cv::getStructuringElement(cv::MORPH_RECT, cv::Size(kReach, kReach));
  cv::erode(smooth, low, window);
  cv::dilate(smooth, high, window);
  cv::Mat slope;
  cv::magnitude(gx, gy, slope);

  const float steep = std::max(pixelQuantile<float>(slope, 1.0 - kSteepest), 1.0f);

  std::vector<double> sigmas;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float s = slope.at<float>(y, x);
      const double height = high.at<uchar>(y, x) - low.at<uchar>(y, x);
      if (s < steep || height < kMinHeight) continue;
      sigmas.push_back(height / (std::sqrt(2.0 * CV_PI) * s));
    }
  }
  if (sigmas.size() < kMinPixels) return kNotComputed;
  // Other edges in the window add to the height: the lower quarter has the window to itself. The
  // Sobel kernel spreads by another 0.7 px along and across.
  const double sigma = quantile(sigmas, 0.25);
  constexpr double kOurs = kSmoothing * kSmoothing + 0.5;
  return std::sqrt(std::max(sigma * sigma - kOurs, 0.0));
}

/// The first images of another sequence, measured on their way to the tracker.
class InspectedSequence : public ImageSequence {
 public:
  InspectedSequence(ImageSequence* whole, int limit, cv::Size size) : whole_(whole), size_(size) {
    name_ = whole->name();
    t0_ns_ = whole->t0Ns();
    imu_ = whole->imu();
    const std::size_t count =
        limit > 0 ? std::min(whole->images(), static_cast<std::size_t>(limit)) : whole->images();
    for (std::size_t k = 0; k < count; ++k) image_stamps_ns_.push_back(whole->imageStampNs(k));
    if (count < whole->images()) {
      constexpr double kMargin = 1.0;  // for the search for a time offset [s]
      const double begin = imageTime(0) - kMargin, end = imageTime(count - 1) + kMargin;
      imu_.erase(std::remove_if(imu_.begin(), imu_.end(),
                                [=](const ImuSample& s) { return s.t < begin || s.t > end; }),
                 imu_.end());
    }
    facts_.resize(count);
    seen_.assign(count, false);
  }

  cv::Mat image(std::size_t k, std::string* error) override {
    cv::Mat read = whole_->image(k, error);
    facts_[k] = imageFacts(imageTime(k), read, before_, size_);
    seen_[k] = true;
    before_ = read;
    return read;
  }

  /// Facts of all images, also of those that the tracker skips because the IMU does not cover them.
  std::vector<ImageFacts> facts() {
    for (std::size_t k = 0; k < facts_.size(); ++k) {
      if (!seen_[k]) image(k, nullptr);
    }
    return facts_;
  }

 private:
  ImageSequence* whole_;
  cv::Size size_;
  std::vector<ImageFacts> facts_;
  std::vector<bool> seen_;
  cv::Mat before_;
};

}  // namespace

ImageFacts imageFacts(double t, const cv::Mat& image, const cv::Mat& before, cv::Size size) {
  ImageFacts facts;
  facts.t = t;
  if (image.empty()) return facts;
  facts.right_size = image.size() == size;
  facts.p99 = pixelQuantile<uchar>(image, 0.99);
  facts.saturated = cv::countNonZero(image >= 250) / static_cast<double>(image.total());
  facts.repeats = image.size() == before.size() && cv::norm(image, before, cv::NORM_INF) == 0.0;
  facts.blur_px = edgeSigma(image);
  return facts;
}

DoctorData readDoctorData(ImageSequence* images,
                          const feature_tracker_lines::CameraParameters& camera,
                          const Calibration& calibration,
                          const feature_tracker_lines::FrontEndOptions& front_end, int limit,
                          const std::function<void(int done, int total)>& progress) {
  DoctorData data;
  data.name = images->name();
  data.calibration = calibration;
  data.lines_enabled = front_end.lines.enabled;
  data.imu_disorder = images->imuDisorder();
  data.image_disorder = images->imageDisorder();

  InspectedSequence inspected(images, limit, cv::Size(camera.width, camera.height));
  data.imu = inspected.imu();
  data.imu_beyond_limit = images->imu().size() - data.imu.size();
  data.images_beyond_limit = images->images() - inspected.images();
  feature_tracker_lines::FrontEndOptions options = front_end;
  options.use_gyro = false;
  TrackingSummary summary;
  // Its message about images that cannot be tracked is ignored: the findings have more detail.
  trackImages(&inspected, camera, calibration, options, progress, &data.frames, &summary);
  data.images = inspected.facts();
  return data;
}

}  // namespace slim_init::evaluation
