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

/// Another sequence, whose images are measured on their way to the tracker: each once, in order,
/// and those too that the tracker skips because the IMU does not cover them.
class InspectedSequence : public ImageSequence {
 public:
  InspectedSequence(ImageSequence* inner, cv::Size size, std::vector<ImageFacts>* facts)
      : inner_(inner), size_(size), facts_(facts) {
    static_cast<RecordedMotion&>(*this) = *inner;
  }

  cv::Mat image(std::size_t k, std::string* error) override {
    inspectUntil(k);
    return inspect(error);
  }
  void inspectUntil(std::size_t k) {
    while (facts_->size() < k) inspect(nullptr);
  }

 private:
  cv::Mat inspect(std::string* error) {
    const std::size_t k = facts_->size();
    const cv::Mat image = inner_->image(k, error);
    facts_->push_back(imageFacts(image_times[k], image, before_, size_));
    before_ = image;
    return image;
  }

  ImageSequence* inner_;
  cv::Size size_;
  std::vector<ImageFacts>* facts_;
  cv::Mat before_;
};

/// Keeps the first images, with the IMU data of their time.
void keepFirst(std::size_t count, ImageSequence* images) {
  if (count >= images->images()) return;
  images->image_times.resize(count);
  constexpr double kMargin = 1.0;  // for the search for a time offset [s]
  const double begin = images->image_times.front() - kMargin;
  const double end = images->image_times.back() + kMargin;
  std::vector<ImuSample>& imu = images->imu;
  imu.erase(std::remove_if(imu.begin(), imu.end(),
                           [=](const ImuSample& s) { return s.t < begin || s.t > end; }),
            imu.end());
}

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
  data.name = images->name;
  data.calibration = calibration;
  data.lines_enabled = front_end.lines.enabled;
  data.imu_disorder = images->imu_disorder;
  data.image_disorder = images->image_disorder;

  const std::size_t all_images = images->images(), all_imu = images->imu.size();
  if (limit > 0) keepFirst(static_cast<std::size_t>(limit), images);
  data.imu = images->imu;
  data.imu_beyond_limit = all_imu - data.imu.size();
  data.images_beyond_limit = all_images - images->images();
  InspectedSequence inspected(images, cv::Size(camera.width, camera.height), &data.images);
  feature_tracker_lines::FrontEndOptions options = front_end;
  options.use_gyro = false;
  TrackingSummary summary;
  // Its message about images that cannot be tracked is ignored: the findings have more detail.
  trackImages(&inspected, camera, calibration, options, progress, &data.frames, &summary);
  inspected.inspectUntil(inspected.images());
  return data;
}

}  // namespace slim_init::evaluation
