// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "patch_anchor.h"

#include <Eigen/LU>
#include <cmath>

#include "image_pyramid.h"

namespace slim_init::feature_tracker_lines {
namespace {

constexpr int kHalf = PatchAnchor::kSide / 2;
constexpr int kIterations = 6;
constexpr double kConvergedPx = 0.03;  // length of a step; what is left after it is far less
// Least area of a step's affine map: a patch that shrinks by more in one step is lost.
constexpr double kLeastDeterminant = 0.2;
// Correlation that counts as converged although the last step was not short.
constexpr double kGoodCorrelation = 0.9;
// Expected size of what deform() does not know of, at the patch's edge as a share of its half side.
constexpr double kDeformationSigma = 0.03;
constexpr double kLeastContrast = 1.0;   // rms of the patch about its mean [grey levels]
constexpr float kLeastVariance = 1e-6F;  // of the image patch, against division by zero
constexpr double kLeastRatio = 0.08;     // weaker to stronger direction; an edge has less

}  // namespace

bool PatchAnchor::sample(const cv::Mat& grey, const Eigen::Vector2d& centre,
                         const Eigen::Matrix2d& affine, Patch* out) const {
  // With all four corners inside, so is everything else: the map is affine.
  const double reach_x = kHalf * (std::abs(affine(0, 0)) + std::abs(affine(0, 1)));
  const double reach_y = kHalf * (std::abs(affine(1, 0)) + std::abs(affine(1, 1)));
  if (!(centre.x() - reach_x >= 0.0 && centre.y() - reach_y >= 0.0 &&
        centre.x() + reach_x < grey.cols - 1 && centre.y() + reach_y < grey.rows - 1)) {
    return false;
  }
  const auto a00 = static_cast<float>(affine(0, 0)), a10 = static_cast<float>(affine(1, 0));
  float* target = out->data();
  for (int v = -kHalf; v <= kHalf; ++v) {
    const auto x0 = static_cast<float>(centre.x() + affine(0, 1) * v);
    const auto y0 = static_cast<float>(centre.y() + affine(1, 1) * v);
    for (int u = -kHalf; u <= kHalf; ++u) {
      *target++ =
          brightnessAt(grey, x0 + a00 * static_cast<float>(u), y0 + a10 * static_cast<float>(u));
    }
  }
  return true;
}

bool PatchAnchor::set(const cv::Mat& grey, const Eigen::Vector2d& pixel, double noise) {
  valid_ = false;
  affine_.setIdentity();
  aligned_affine_.setIdentity();
  const Eigen::Matrix2d unit = Eigen::Matrix2d::Identity();
  Patch left, right, above, below;
  if (!sample(grey, pixel, unit, &patch_) ||
      !sample(grey, pixel - Eigen::Vector2d::UnitX(), unit, &left) ||
      !sample(grey, pixel + Eigen::Vector2d::UnitX(), unit, &right) ||
      !sample(grey, pixel - Eigen::Vector2d::UnitY(), unit, &above) ||
      !sample(grey, pixel + Eigen::Vector2d::UnitY(), unit, &below)) {
    return false;
  }
  patch_ -= patch_.mean();
  deviation_ = std::sqrt(patch_.square().mean());
  const Patch gradient_x = 0.5F * (right - left), gradient_y = 0.5F * (below - above);
  Patch u, v;  // of each pixel, as a share of the half side
  for (int i = 0; i < kCount; ++i) {
    u[i] = static_cast<float>(i % kSide - kHalf) / kHalf;
    v[i] = static_cast<float>(i / kSide - kHalf) / kHalf;
  }
  jacobian_ << gradient_x, gradient_y, gradient_x * u, gradient_x * v, gradient_y * u,
      gradient_y * v;
  hessian_ = (jacobian_.transpose() * jacobian_).cast<double>();
  // Noise itself has slopes: half its variance in a difference over two pixels.
  const double from_noise = 0.5 * noise * noise * kCount;
  const double half_trace = 0.5 * (hessian_(0, 0) + hessian_(1, 1)) - from_noise;
  const double root = std::hypot(0.5 * (hessian_(0, 0) - hessian_(1, 1)), hessian_(0, 1));
  const double weaker = half_trace - root, stronger = half_trace + root;
  valid_ = deviation_ > kLeastContrast && weaker > kLeastRatio * stronger &&
           weaker * kMaxSigmaPx * kMaxSigmaPx > noise * noise;
  return valid_;
}

PatchAnchor::Match PatchAnchor::align(const cv::Mat& grey, const Eigen::Vector2d& start,
                                      double noise, double max_shift_px) {
  Match match;
  match.pixel = start;
  if (!valid_) return match;
  Eigen::Matrix2d affine = affine_;
  Eigen::Vector2d centre = start;
  Matrix6d H = hessian_;
  const double stiffness = std::pow(noise / (kDeformationSigma * kHalf), 2);
  H.diagonal().tail<4>().array() += stiffness;
  const Eigen::LLT<Matrix6d> solver(H);
  if (solver.info() != Eigen::Success) return match;

  Patch now;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (!sample(grey, centre, affine, &now)) return match;
    const Vector6d step = solver.solve(residualGradient(now, &match.correlation));
    Eigen::Matrix2d D;
    D << step[2], step[3], step[4], step[5];
    const Eigen::Matrix2d change = Eigen::Matrix2d::Identity() + D / kHalf;
    if (!(change.determinant() > kLeastDeterminant)) return match;
    affine = affine * change.inverse();
    centre -= affine * step.head<2>();
    if (!((centre - start).norm() < max_shift_px)) return match;
    if (step.head<2>().norm() < kConvergedPx) {
      match.ok = true;
      break;
    }
  }
  // Still moving a little after all steps is good enough if the match is.
  match.ok = match.ok || match.correlation > kGoodCorrelation;
  match.pixel = centre;
  aligned_affine_ = affine;
  return match;
}

// Gradient of half the squared difference of `now`, with brightness and contrast normalised, from
// the patch: by translation and affine deformation. Also their correlation.
PatchAnchor::Vector6d PatchAnchor::residualGradient(const Patch& now, double* correlation) const {
  const float mean = now.mean();
  const float deviation = std::sqrt(std::max(now.square().mean() - mean * mean, kLeastVariance));
  *correlation = (now * patch_).mean() / (deviation * deviation_);
  const Patch residual = (now - mean) * (deviation_ / deviation) - patch_;
  return (jacobian_.transpose() * residual.matrix()).cast<double>();
}

}  // namespace slim_init::feature_tracker_lines
