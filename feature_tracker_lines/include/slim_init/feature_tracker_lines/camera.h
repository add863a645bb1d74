// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Pixels to rays and back, for the three lens models of VINS-Mono's configuration files.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace slim_init::feature_tracker_lines {

/// `model_type` of a configuration file.
enum class CameraModel {
  kPinhole,        ///< PINHOLE: radial-tangential distortion on the plane z = 1
  kKannalaBrandt,  ///< KANNALA_BRANDT: equidistant, a polynomial of the angle to the axis
  kMei,            ///< MEI: unit sphere seen from `xi` behind its centre, then as kPinhole
};

/// The name in a configuration file: "PINHOLE", "KANNALA_BRANDT", "MEI".
const char* toString(CameraModel model);

/// Intrinsics. With (x, y) the distorted position on the model's plane:
/// u = fx x + cx, v = fy y + cy.
struct CameraParameters {
  CameraModel model = CameraModel::kPinhole;
  int width = 752;    ///< image_width [px]
  int height = 480;   ///< image_height [px]
  double fx = 460.0;  ///< fx | mu | gamma1 [px]
  double fy = 460.0;  ///< fy | mv | gamma2 [px]
  double cx = 376.0;  ///< cx | u0 [px]
  double cy = 240.0;  ///< cy | v0 [px]
  /// kPinhole, kMei: k1, k2, p1, p2 (OpenCV's order and signs); kKannalaBrandt: k2, k3, k4, k5 of
  /// r = theta + k2 theta^3 + k3 theta^5 + k4 theta^7 + k5 theta^9.
  std::array<double, 4> distortion = {0.0, 0.0, 0.0, 0.0};
  double xi = 0.0;  ///< kMei: mirror parameter; 0 is a pinhole

  /// Returns an empty string, or a message naming the field, its value and the violated bound.
  std::string validate() const;
};

/// A calibrated camera. Cheap to copy; const calls may run in parallel.
class Camera {
 public:
  /// Does not check the parameters: call their validate() first.
  explicit Camera(const CameraParameters& parameters = CameraParameters());

  const CameraParameters& parameters() const { return parameters_; }

  /// Unit ray in c through a pixel; project() returns to within 1e-9 px of it. All NaN where the
  /// model has no ray (beyond the edge of a fisheye's image circle, or a pixel that is not finite):
  /// KeyframeWindow drops and counts such observations.
  Eigen::Vector3d bearing(const Eigen::Vector2d& pixel) const;

  /// Projects a direction in c (any length). True and a pixel when the camera sees it: in front of
  /// the lens, where the distortion is still invertible, and inside the image. False otherwise, and
  /// `pixel` is not changed.
  bool project(const Eigen::Vector3d& direction, Eigen::Vector2d* pixel) const;

  /// Pixels per radian at the optical axis (geometric mean of both axes): Calibration::focal_px.
  double focalPx() const;

 private:
  CameraParameters parameters_;
  // Largest undistorted radius (angle for kKannalaBrandt) up to which the radial part of the
  // distortion increases: beyond it two rays share a pixel.
  double max_radius_ = 0.0;
};

}  // namespace slim_init::feature_tracker_lines
