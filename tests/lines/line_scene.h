// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Line segments with a known vanishing point, for the tests of this folder.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "slim_init/init_window.h"
#include "support/exact_window.h"

namespace slim_init::test {

constexpr double kFocalPx = 460.0;
constexpr double kRadPerDeg = 0.017453292519943295;

/// Angle between two directions up to sign [rad], accurate near zero.
inline double axisAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

/// Segment centred on `middle` along `tangent`, both in c, `angle_rad` long.
inline WindowLine segment(const Eigen::Vector3d& middle, const Eigen::Vector3d& tangent,
                          double angle_rad) {
  const Eigen::Vector3d m = middle.normalized();
  const Eigen::Vector3d t = (tangent - tangent.dot(m) * m).normalized();
  WindowLine line;
  line.start_bearing = std::cos(0.5 * angle_rad) * m - std::sin(0.5 * angle_rad) * t;
  line.end_bearing = std::cos(0.5 * angle_rad) * m + std::sin(0.5 * angle_rad) * t;
  line.normal = line.start_bearing.cross(line.end_bearing).normalized();
  line.length_px = kFocalPx * angle_rad;
  return line;
}

/// `line` with both end points moved across it by `sigma_rad` times a standard normal deviate.
inline WindowLine perturbed(const WindowLine& line, double sigma_rad, std::mt19937& random) {
  std::normal_distribution<double> normal;
  WindowLine noisy = line;
  noisy.start_bearing =
      (line.start_bearing + sigma_rad * normal(random) * line.normal).normalized();
  noisy.end_bearing = (line.end_bearing + sigma_rad * normal(random) * line.normal).normalized();
  noisy.normal = noisy.start_bearing.cross(noisy.end_bearing).normalized();
  return noisy;
}

inline std::vector<WindowLine> perturbed(std::vector<WindowLine> lines, double sigma_rad,
                                         std::mt19937& random) {
  for (WindowLine& line : lines) line = perturbed(line, sigma_rad, random);
  return lines;
}

/// A ray of an image of 77 x 62 deg.
inline Eigen::Vector3d imageRay(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double x = 0.8 * uniform(random);
  const double y = 0.6 * uniform(random);
  return Eigen::Vector3d(x, y, 1.0).normalized();
}

/// `count` noise-free segments of 6 to 23 deg all over the image that point at `direction`.
inline std::vector<WindowLine> linesToward(const Eigen::Vector3d& direction, int count,
                                           std::mt19937& random) {
  std::uniform_real_distribution<double> angle_rad(0.1, 0.4);
  std::vector<WindowLine> lines;
  while (static_cast<int>(lines.size()) < count) {
    const Eigen::Vector3d middle = imageRay(random);
    // A segment does not contain its own vanishing point.
    if (axisAngle(middle, direction) < 0.25) continue;
    lines.push_back(segment(middle, direction, angle_rad(random)));
  }
  return lines;
}

/// `count` segments of any direction that miss `direction` by more than `margin_rad`.
inline std::vector<WindowLine> clutter(const Eigen::Vector3d& direction, double margin_rad,
                                       int count, std::mt19937& random) {
  std::uniform_real_distribution<double> angle_rad(0.1, 0.4);
  std::normal_distribution<double> normal;
  std::vector<WindowLine> lines;
  while (static_cast<int>(lines.size()) < count) {
    const Eigen::Vector3d middle = imageRay(random);
    const double x = normal(random);
    const double y = normal(random);
    const WindowLine line = segment(middle, Eigen::Vector3d(x, y, 0.0), angle_rad(random));
    if (std::abs(line.normal.dot(direction)) > std::sin(margin_rad)) lines.push_back(line);
  }
  return lines;
}

/// A frame whose lines have ids first_id, first_id + 1, ...
inline FrameObservation frameOf(double t, const std::vector<WindowLine>& lines,
                                FeatureId first_id = 0) {
  FrameObservation frame;
  frame.t = t;
  for (const WindowLine& line : lines) {
    LineObservation observation;
    observation.id = first_id++;
    observation.start_bearing = line.start_bearing;
    observation.end_bearing = line.end_bearing;
    observation.length_px = line.length_px;
    frame.lines.push_back(observation);
  }
  return frame;
}

/// A window of these keyframes with inertial data without information.
inline std::shared_ptr<const InitWindow> windowOf(const std::vector<FrameObservation>& keyframes) {
  std::vector<ImuSample> imu(2);
  imu[0].t = keyframes.front().t - 0.1;
  imu[1].t = keyframes.back().t + 0.1;
  return madeWindow(Calibration(), keyframes, imu);
}

}  // namespace slim_init::test
