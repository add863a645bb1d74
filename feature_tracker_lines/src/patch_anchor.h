// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Image patch of a point when it was first detected. Tracking from image to image adds up small
// errors; comparing with the first patch does not.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <opencv2/core.hpp>

namespace slim_init::feature_tracker_lines {

/// A patch with the affine map from it to the current image. Inverse compositional Lucas-Kanade
/// (Baker and Matthews 2004) over translation and affine deformation, brightness and contrast
/// normalised. Shi and Tomasi (1994) use the affine part to decide whether a track still shows the
/// same thing.
class PatchAnchor {
 public:
  static constexpr int kSide = 15;             ///< [px], odd
  static constexpr double kMaxSigmaPx = 0.07;  ///< largest standard deviation from image noise [px]

  /// Takes the patch around `pixel`. False, and the anchor is invalid, where the patch reaches over
  /// the edge of the image or cannot be localised: image noise of standard deviation `noise` [grey
  /// levels] alone would move it by more than kMaxSigmaPx in its weakest direction, or it is an
  /// edge, whose stair steps on the pixel grid move it.
  bool set(const cv::Mat& grey, const Eigen::Vector2d& pixel, double noise);

  bool valid() const { return valid_; }

  /// Multiplies the affine map by the deformation known since the last image.
  void deform(const Eigen::Matrix2d& jacobian) { affine_ = jacobian * affine_; }

  /// Result of align().
  struct Match {
    bool ok = false;           ///< converged inside the image
    Eigen::Vector2d pixel;     ///< where the patch is
    double correlation = 0.0;  ///< of the patch with what is there now, at most 1
  };

  static constexpr double kMaxShiftPx = 3.0;  ///< from where align() starts [px]

  /// Looks for the patch near `start`, which should be right to about two pixels, and gives up
  /// beyond `max_shift_px` from it. `noise` [grey levels] weighs the image against the expectation
  /// that the deformation is as deform() said. The deformation found is kept only after accept().
  Match align(const cv::Mat& grey, const Eigen::Vector2d& start, double noise,
              double max_shift_px = kMaxShiftPx);

  /// Keeps the deformation of the last align().
  void accept() { affine_ = aligned_affine_; }

  /// Change of size since the first patch (square root of the area's change); 1 at first.
  double scale() const { return std::sqrt(std::abs(affine_.determinant())); }

 private:
  static constexpr int kCount = kSide * kSide;
  using Patch = Eigen::Array<float, kCount, 1>;
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  using Matrix6d = Eigen::Matrix<double, 6, 6>;

  bool sample(const cv::Mat& grey, const Eigen::Vector2d& centre, const Eigen::Matrix2d& affine,
              Patch* out) const;
  Vector6d residualGradient(const Patch& now, double* correlation) const;

  bool valid_ = false;
  Patch patch_ = Patch::Zero();  // mean zero
  float deviation_ = 0.0F;       // root of its mean square
  // Of the patch by translation and affine deformation.
  Eigen::Matrix<float, kCount, 6> jacobian_ = Eigen::Matrix<float, kCount, 6>::Zero();
  Matrix6d hessian_ = Matrix6d::Zero();
  Eigen::Matrix2d affine_ = Eigen::Matrix2d::Identity();
  Eigen::Matrix2d aligned_affine_ = Eigen::Matrix2d::Identity();
};

}  // namespace slim_init::feature_tracker_lines
