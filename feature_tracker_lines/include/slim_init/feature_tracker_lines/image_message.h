// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Image messages to grey images: templates over any type with the members of sensor_msgs::Image and
// sensor_msgs::CompressedImage, so that no ROS header is needed here.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "slim_init/text.h"

namespace slim_init::feature_tracker_lines {

/// An encoding of sensor_msgs/Image that can be turned to grey.
struct ImageEncoding {
  const char* name;
  int channels;
  int to_grey;  ///< code of cv::cvtColor; -1: is grey
};

/// All encodings that are read.
inline constexpr ImageEncoding kImageEncodings[] = {
    {"mono8", 1, -1},
    {"8UC1", 1, -1},
    {"bgr8", 3, cv::COLOR_BGR2GRAY},
    {"8UC3", 3, cv::COLOR_BGR2GRAY},
    {"rgb8", 3, cv::COLOR_RGB2GRAY},
    {"bgra8", 4, cv::COLOR_BGRA2GRAY},
    {"rgba8", 4, cv::COLOR_RGBA2GRAY},
};

/// A name from a message, in quotes and shortened: it may contain anything.
inline std::string shownName(const std::string& name) {
  constexpr std::size_t kMost = 40;
  return "'" + (name.size() > kMost ? name.substr(0, kMost) + "..." : name) + "'";
}

/// Grey image (CV_8UC1, pixels of its own) of a sensor_msgs/Image. Returns an empty string, or the
/// end of a message ("has encoding ..", "claims to be ..") for an encoding not
/// listed above and for sizes that contradict each other. May throw what OpenCV throws.
template <typename Image>
std::string decodeImage(const Image& message, cv::Mat* grey) {
  const auto* encoding =
      std::find_if(std::begin(kImageEncodings), std::end(kImageEncodings),
                   [&](const ImageEncoding& known) { return message.encoding == known.name; });
  if (encoding == std::end(kImageEncodings)) {
    std::string list;
    for (const ImageEncoding& known : kImageEncodings) {
      list += (list.empty() ? "" : ", ") + std::string(known.name);
    }
    return text("has encoding ", shownName(message.encoding), ", must be ", list);
  }
  const std::uint64_t row = std::uint64_t{message.width} * encoding->channels;
  const std::uint64_t needed = std::uint64_t{message.step} * message.height;
  if (message.width == 0 || message.height == 0 || message.step < row ||
      message.data.size() < needed) {
    return text("claims to be ", message.width, " x ", message.height, " in rows of ", message.step,
                " bytes (", encoding->name, "), but holds ", message.data.size(), " bytes");
  }
  const cv::Mat pixels(static_cast<int>(message.height), static_cast<int>(message.width),
                       CV_8UC(encoding->channels), const_cast<std::uint8_t*>(message.data.data()),
                       message.step);
  if (encoding->to_grey < 0) {
    *grey = pixels.clone();
  } else {
    cv::cvtColor(pixels, *grey, encoding->to_grey);
  }
  return "";
}

/// The same of a sensor_msgs/CompressedImage.
template <typename CompressedImage>
std::string decodeCompressedImage(const CompressedImage& message, cv::Mat* grey) {
  *grey = cv::Mat();
  if (!message.data.empty()) {
    *grey = cv::imdecode(message.data, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  }
  if (!grey->empty()) return "";
  return "cannot be decoded: " + std::to_string(message.data.size()) + " bytes of " +
         shownName(message.format);
}

}  // namespace slim_init::feature_tracker_lines
