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
  int type;     ///< of cv::Mat
  int to_grey;  ///< code of cv::cvtColor; -1: is grey
};

/// All encodings that are read.
inline constexpr ImageEncoding kImageEncodings[] = {
    {"mono8", CV_8UC1, -1},
    {"8UC1", CV_8UC1, -1},
    {"mono16", CV_16UC1, -1},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
    // OpenCV names a pattern by its second row.
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
};

/// A name from a message, in quotes and shortened: it may contain anything.
inline std::string shownName(const std::string& name) {
  constexpr std::size_t kMost = 40;
  return "'" + (name.size() > kMost ? name.substr(0, kMost) + "..." : name) + "'";
}

/// Grey pixels of 16 bits to 8. As 16 bits, as cv_bridge takes them, the images of cameras of 10 or
/// 12 bits are dark: `largest` of the values of this stream so far decides their scale.
inline void toBytes(cv::Mat* pixels, double* largest) {
  if (pixels->type() != CV_16UC1) return;
  double here = 0.0;
  cv::minMaxLoc(*pixels, nullptr, &here);
  *largest = std::max(*largest, here);
  pixels->convertTo(*pixels, CV_8U, 255.0 / (*largest > 4095.0 ? 65535.0 : 4095.0));
}

/// Grey image (CV_8UC1, pixels of its own) of a sensor_msgs/Image. Returns an empty string, or the
/// end of a message ("has encoding ..", "claims to be ..") for an encoding not
/// listed above and for sizes that contradict each other. May throw what OpenCV throws.
/// `largest`: as in toBytes(), 0 at the begin of the stream.
template <typename Image>
std::string decodeImage(const Image& message, cv::Mat* grey, double* largest) {
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
  const bool wide = CV_MAT_DEPTH(encoding->type) == CV_16U;
  if (wide && message.is_bigendian != 0) return "has 16-bit pixels, most significant byte first";
  const std::uint64_t row = std::uint64_t{message.width} * CV_ELEM_SIZE(encoding->type);
  const std::uint64_t needed = std::uint64_t{message.step} * message.height;
  if (message.width == 0 || message.height == 0 || message.step < row ||
      message.data.size() < needed) {
    return text("claims to be ", message.width, " x ", message.height, " in rows of ", message.step,
                " bytes (", encoding->name, "), but holds ", message.data.size(), " bytes");
  }
  const cv::Mat pixels(static_cast<int>(message.height), static_cast<int>(message.width),
                       encoding->type, const_cast<std::uint8_t*>(message.data.data()),
                       message.step);
  if (encoding->to_grey < 0) {
    *grey = pixels.clone();
    toBytes(grey, largest);
  } else {
    *grey = cv::Mat();
    cv::cvtColor(pixels, *grey, encoding->to_grey);
  }
  return "";
}

/// The encoding whose Bayer pattern starts the `format` of a sensor_msgs/CompressedImage
/// ("bayer_rggb8; jpeg compressed "), or null; also if it was converted to grey before ("compressed
/// mono8"). 8 and 16 bits have the same patterns.
inline const ImageEncoding* bayerPatternOf(const std::string& format) {
  constexpr std::size_t kLength = 10;  // of "bayer_rggb"
  if (format.find("compressed mono") != std::string::npos) return nullptr;
  for (const ImageEncoding& known : kImageEncodings) {
    const std::string name = known.name;
    if (name.compare(0, 6, "bayer_") != 0) continue;
    if (format.compare(0, kLength, name, 0, kLength) == 0) return &known;
  }
  return nullptr;
}

/// The same of a sensor_msgs/CompressedImage.
template <typename CompressedImage>
std::string decodeCompressedImage(const CompressedImage& message, cv::Mat* grey, double* largest) {
  *grey = cv::Mat();
  const ImageEncoding* const bayer = bayerPatternOf(message.format);
  if (bayer != nullptr && !message.data.empty()) {
    cv::Mat mosaic = cv::imdecode(message.data, cv::IMREAD_UNCHANGED);
    // image_transport compresses the mosaic as one channel; other senders may convert it first.
    toBytes(&mosaic, largest);
    if (!mosaic.empty() && mosaic.type() == CV_8UC1) {
      cv::cvtColor(mosaic, *grey, bayer->to_grey);
      return "";
    }
  }
  if (!message.data.empty()) {
    constexpr int kGrey = cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH;
    *grey = cv::imdecode(message.data, kGrey | cv::IMREAD_IGNORE_ORIENTATION);
    toBytes(grey, largest);
  }
  if (!grey->empty() && grey->type() == CV_8UC1) return "";
  return "cannot be decoded: " + std::to_string(message.data.size()) + " bytes of " +
         shownName(message.format);
}

}  // namespace slim_init::feature_tracker_lines
