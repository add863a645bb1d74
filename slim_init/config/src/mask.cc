// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "host_keys.h"
#include "slim_init/text.h"
#include "yaml_value.h"

namespace slim_init::config {
namespace {

// VINS-Mono's name of the mask of a fisheye, in its folder `config`.
constexpr char kHostMask[] = "fisheye_mask.jpg";

bool exists(const std::string& path) { return std::ifstream(path, std::ios::binary).is_open(); }

// As a path in the file `path` is meant.
std::string besideFile(const std::string& path, const std::string& name) {
  const std::size_t slash = path.rfind('/');
  if (name.front() == '/' || slash == std::string::npos) return name;
  return path.substr(0, slash + 1) + name;
}

cv::Mat readGrey(const char* key, const std::string& file) {
  // Tried first, because OpenCV prints to the console about a file it cannot open.
  if (!exists(file)) fail(key, ": ", file, " cannot be opened");
  cv::Mat grey;
  try {
    grey = cv::imread(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
  }
  if (grey.empty()) fail(key, ": ", file, " cannot be read as an image");
  return grey;
}

bool hasSize(const cv::Mat& image, const feature_tracker_lines::CameraParameters& camera) {
  return image.cols == camera.width && image.rows == camera.height;
}

// Takes what the mask leaves out off the area that is used so far.
void apply(const char* key, const std::string& file, const cv::Mat& grey, cv::Mat* used) {
  double largest = 0.0;
  cv::minMaxLoc(grey, nullptr, &largest);
  if (largest == 0.0) fail(key, ": ", file, " is 0 everywhere: no pixel would be used");
  // Half of the largest level: JPEG leaves grey beside an edge, and some masks hold 0 and 1.
  const cv::Mat of_mask = grey >= 0.5 * largest;
  if (used->empty()) {
    *used = of_mask;
  } else {
    cv::bitwise_and(*used, of_mask, *used);
  }
}

void readImage(const char* key, const std::string& file, Config* config) {
  const cv::Mat grey = readGrey(key, file);
  if (!hasSize(grey, config->camera)) {
    fail(key, ": ", file, " is ", grey.cols, " x ", grey.rows, ", must be ", config->camera.width,
         " x ", config->camera.height, " as image_width and image_height");
  }
  apply(key, file, grey, &config->front_end.mask);
}

// The file of a VINS-Mono folder, which no key names: without it, or for another camera, the image
// circle is used.
void readHostMask(const std::string& path, Config* config) {
  for (const std::string& name : {std::string(kHostMask), std::string("../") + kHostMask}) {
    const std::string file = besideFile(path, name);
    if (!exists(file)) continue;
    const cv::Mat grey = readGrey("fisheye", file);
    if (hasSize(grey, config->camera)) {
      apply("fisheye", file, grey, &config->front_end.mask);
      return;
    }
    config->notes.push_back(
        text("fisheye: ", file, " is ", grey.cols, " x ", grey.rows, ", the camera ",
             config->camera.width, " x ", config->camera.height,
             ": not used, the image circle is; name a mask with the key fisheye_mask"));
    return;
  }
}

}  // namespace

void readMask(const std::string& path, Config* config) {
  const HostKeys& host = config->host;
  if (!host.mask.empty()) readImage("mask", besideFile(path, host.mask), config);
  if (!config->front_end.host.fisheye) return;
  if (!host.fisheye_mask.empty()) {
    readImage("fisheye_mask", besideFile(path, host.fisheye_mask), config);
  } else if (host.mask.empty()) {
    readHostMask(path, config);
  }
}

}  // namespace slim_init::config
