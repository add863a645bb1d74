// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "random.h"
#include "slim_init/simulation/rendering.h"

namespace slim_init::simulation {

cv::Mat mergeBands(const std::vector<cv::Mat>& pictures) {
  if (pictures.size() < 2) return pictures.empty() ? cv::Mat() : pictures.front();
  const double bands = static_cast<double>(pictures.size());
  cv::Mat image(pictures.front().size(), CV_32FC1);
  for (int v = 0; v < image.rows; ++v) {
    // As rowTime() has it: row v is exposed at the share v / rows of the readout.
    const double place = std::clamp(bands * v / image.rows - 0.5, 0.0, bands - 1.0);
    const auto above = std::min(static_cast<std::size_t>(place), pictures.size() - 2);
    const auto share = static_cast<float>(place - static_cast<double>(above));
    const float *a = pictures[above].ptr<float>(v), *b = pictures[above + 1].ptr<float>(v);
    float* out = image.ptr<float>(v);
    for (int u = 0; u < image.cols; ++u) out[u] = (1.0F - share) * a[u] + share * b[u];
  }
  return image;
}

cv::Mat expose(const cv::Mat& radiance, std::int64_t index, double t,
               const SensorOptions& options) {
  constexpr double kTwoPi = 6.283185307179586;
  constexpr double kGain = 255.0;  // grey level of radiance 1
  cv::Mat light = radiance;
  if (options.blur_px > 0.0) {
    cv::GaussianBlur(radiance, light, cv::Size(), options.blur_px, options.blur_px,
                     cv::BORDER_REFLECT_101);
  }
  const double exposure =
      1.0 + options.exposure_swing * std::sin(kTwoPi * t / options.exposure_period_s);
  const double cx = 0.5 * (light.cols - 1);
  const double cy = 0.5 * (light.rows - 1);
  const double corner2 = std::max(1.0, cx * cx + cy * cy);
  const double read2 = options.read_noise * options.read_noise;
  Random random(options.seed, ("sensor/" + std::to_string(index)).c_str());
  cv::Mat image(light.size(), CV_8UC1);
  for (int v = 0; v < light.rows; ++v) {
    const float* in = light.ptr<float>(v);
    std::uint8_t* out = image.ptr<std::uint8_t>(v);
    for (int u = 0; u < light.cols; ++u) {
      const double r2 = ((u - cx) * (u - cx) + (v - cy) * (v - cy)) / corner2;
      const double grey = kGain * exposure * (1.0 - options.vignetting * r2) * in[u];
      const double sigma = std::sqrt(read2 + options.shot_noise * std::max(0.0, grey));
      const double noisy = grey + (sigma > 0.0 ? sigma * random.gaussian() : 0.0);
      out[u] = static_cast<std::uint8_t>(std::clamp(std::floor(noisy + 0.5), 0.0, 255.0));
    }
  }
  return image;
}

}  // namespace slim_init::simulation
