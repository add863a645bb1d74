// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Images with an exact truth: the inside of a box, ray by ray, through any camera model.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "slim_init/feature_tracker_lines/camera.h"

namespace slim_init::feature_tracker_lines {

/// Brightness [0, 255] of a place on wall `wall` (0 to 5: -x, +x, -y, +y, -z, +z) at (u, v) [m].
using WallTexture = std::function<double(int wall, double u, double v)>;

/// A box room, axis-aligned, centred at the origin of the world.
class BoxRoom {
 public:
  BoxRoom(const Eigen::Vector3d& half_size, WallTexture texture)
      : half_size_(half_size), texture_(std::move(texture)) {}

  /// Where the ray from `origin` (inside) along `direction` meets a wall.
  Eigen::Vector3d hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                      int* wall = nullptr) const {
    double nearest = 1e300;
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] == 0.0) continue;
      const double t =
          (std::copysign(half_size_[axis], direction[axis]) - origin[axis]) / direction[axis];
      if (t < nearest) {
        nearest = t;
        if (wall != nullptr) *wall = 2 * axis + (direction[axis] > 0.0 ? 1 : 0);
      }
    }
    return origin + nearest * direction;
  }

  double brightnessAt(const Eigen::Vector3d& point, int wall) const {
    const int axis = wall / 2;
    return texture_(wall, point[(axis + 1) % 3], point[(axis + 2) % 3]);
  }

  /// Where the camera is when row `y` is exposed.
  struct Pose {
    Eigen::Matrix3d R_w_c;
    Eigen::Vector3d p_w_c;
  };

  /// Image with `samples` x `samples` rays a pixel. The rays of the pixels are made once and kept
  /// in `rays`.
  cv::Mat render(const Camera& camera, const std::function<Pose(int y)>& pose_of, int samples,
                 std::vector<Eigen::Vector3f>* rays) const {
    const int width = camera.parameters().width, height = camera.parameters().height;
    if (rays->empty()) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          for (int s = 0; s < samples * samples; ++s) {
            const Eigen::Vector2d pixel(x + (s % samples + 0.5) / samples - 0.5,
                                        y + (s / samples + 0.5) / samples - 0.5);
            rays->push_back(camera.bearing(pixel).cast<float>());
          }
        }
      }
    }
    cv::Mat image(height, width, CV_8UC1);
    std::size_t ray = 0;
    for (int y = 0; y < height; ++y) {
      const Pose pose = pose_of(y);
      for (int x = 0; x < width; ++x) {
        double sum = 0.0;
        for (int s = 0; s < samples * samples; ++s, ++ray) {
          const Eigen::Vector3d f = (*rays)[ray].cast<double>();
          if (!f.allFinite()) continue;  // outside a fisheye's circle: black
          int wall = 0;
          const Eigen::Vector3d point = hit(pose.p_w_c, pose.R_w_c * f, &wall);
          sum += brightnessAt(point, wall);
        }
        image.at<uchar>(y, x) = cv::saturate_cast<uchar>(sum / (samples * samples));
      }
    }
    return image;
  }

  /// The same of a camera with a global shutter.
  cv::Mat render(const Camera& camera, const Eigen::Matrix3d& R_w_c, const Eigen::Vector3d& p_w_c,
                 int samples, std::vector<Eigen::Vector3f>* rays) const {
    return render(
        camera,
        [&](int) {
          return Pose{R_w_c, p_w_c};
        },
        samples, rays);
  }

 private:
  Eigen::Vector3d half_size_;
  WallTexture texture_;
};

namespace textures {

/// Reproducible random number in [0, 1) of a grid place.
inline double hashed(int wall, int i, int j) {
  std::uint64_t h = static_cast<std::uint64_t>(wall + 1) * 0x9e3779b97f4a7c15ULL ^
                    static_cast<std::uint64_t>(i + 100000) * 0xbf58476d1ce4e5b9ULL ^
                    static_cast<std::uint64_t>(j + 100000) * 0x94d049bb133111ebULL;
  h ^= h >> 31;
  h *= 0xff51afd7ed558ccdULL;
  h ^= h >> 33;
  return static_cast<double>(h >> 11) / 9007199254740992.0;
}

/// Smooth random brightness with features of `size` [m].
inline double cloud(int wall, double u, double v, double size) {
  const double x = u / size, y = v / size;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double a = x - i, b = y - j;
  const double sa = a * a * (3.0 - 2.0 * a), sb = b * b * (3.0 - 2.0 * b);
  const double low = hashed(wall, i, j) * (1.0 - sa) + hashed(wall, i + 1, j) * sa;
  const double high = hashed(wall, i, j + 1) * (1.0 - sa) + hashed(wall, i + 1, j + 1) * sa;
  return low * (1.0 - sb) + high * sb;
}

/// Rich random texture at several sizes.
inline double rich(int wall, double u, double v) {
  return 40.0 + 90.0 * cloud(wall, u, v, 0.30) + 60.0 * cloud(wall + 6, u, v, 0.11) +
         40.0 * cloud(wall + 12, u, v, 0.05);
}

/// A wall of equal bricks in mortar; they differ from one another by little.
inline double bricks(int wall, double u, double v) {
  constexpr double kLength = 0.24, kHeight = 0.08, kJoint = 0.012;
  const int row = static_cast<int>(std::floor(v / kHeight));
  const double shifted = u / kLength + 0.5 * (row & 1);
  const int column = static_cast<int>(std::floor(shifted));
  const double x = (shifted - column) * kLength, y = v - row * kHeight;
  if (x < kJoint || y < kJoint) return 190.0;
  return 90.0 + 25.0 * hashed(wall, column, row) + 12.0 * cloud(wall, u, v, 0.02);
}

/// One brightness for each wall, the floor darkest.
inline double blank(int wall) {
  constexpr double kWalls[6] = {120.0, 150.0, 180.0, 105.0, 70.0, 200.0};
  return kWalls[wall];
}

/// Panels with straight borders on blank walls: lines along the three axes and few corners.
inline double panels(int wall, double u, double v) {
  constexpr double kPanel = 0.9, kFrame = 0.07;
  const double x = u / kPanel - std::floor(u / kPanel), y = v / kPanel - std::floor(v / kPanel);
  const bool frame = x < kFrame / kPanel || y < kFrame / kPanel;
  const int i = static_cast<int>(std::floor(u / kPanel)),
            j = static_cast<int>(std::floor(v / kPanel));
  return frame ? 225.0 : 60.0 + 100.0 * hashed(wall, i, j);
}

}  // namespace textures

/// Adds Gaussian noise [grey levels], reproducible for a seed.
inline void addNoise(double sigma, std::uint64_t seed, cv::Mat* image) {
  cv::RNG random(seed);
  cv::Mat noise(image->size(), CV_32F);
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat sum;
  image->convertTo(sum, CV_32F);
  sum += noise;
  sum.convertTo(*image, CV_8U);
}

}  // namespace slim_init::feature_tracker_lines
