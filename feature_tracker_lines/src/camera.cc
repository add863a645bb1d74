// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/feature_tracker_lines/camera.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "data/range_check.h"
#include "slim_init/text.h"

namespace slim_init::feature_tracker_lines {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Residual on the model's plane: 1e-13 of a focal length is 1e-10 px.
constexpr double kPlaneTolerance = 1e-13;
constexpr int kMaxIterations = 50;

Eigen::Vector3d noRay() {
  return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

// Radial-tangential distortion of a point on the plane, and its Jacobian where asked for.
Eigen::Vector2d distort(const std::array<double, 4>& d, const Eigen::Vector2d& p,
                        Eigen::Matrix2d* jacobian) {
  const auto [k1, k2, p1, p2] = d;
  const double x = p.x(), y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * k2);
  if (jacobian != nullptr) {
    const double slope = 2.0 * (k1 + 2.0 * k2 * r2);  // d radial / d r2, times 2
    (*jacobian)(0, 0) = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
    (*jacobian)(0, 1) = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    (*jacobian)(1, 0) = (*jacobian)(0, 1);
    (*jacobian)(1, 1) = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y)};
}

// Radius at which r (1 + k1 r^2 + k2 r^4) stops increasing; infinity where it never does.
double radialTangentialLimit(double k1, double k2) {
  // 1 + 3 k1 q + 5 k2 q^2 = 0 for the smallest positive q = r^2: of 1 / q the larger root, which is
  // computed without cancellation, or the other one if that is negative.
  const double discriminant = 9.0 * k1 * k1 - 20.0 * k2;
  if (discriminant < 0.0) return kInfinity;
  const double s = -0.5 * (3.0 * k1 + std::copysign(std::sqrt(discriminant), k1));
  const double inverse = std::max({s, s == 0.0 ? 0.0 : 5.0 * k2 / s, 0.0});
  return inverse > 0.0 ? std::sqrt(1.0 / inverse) : kInfinity;
}

// Newton on distort(p) = target from `start`. False where it does not converge to a point inside
// the invertible region.
bool newtonUndistort(const std::array<double, 4>& d, const Eigen::Vector2d& target,
                     double max_radius, const Eigen::Vector2d& start, Eigen::Vector2d* point) {
  Eigen::Vector2d p = start;
  Eigen::Matrix2d jacobian;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d residual = distort(d, p, &jacobian) - target;
    if (residual.norm() <= kPlaneTolerance * (1.0 + target.norm())) {
      *point = p;
      return p.norm() <= max_radius && jacobian.determinant() > 0.0;
    }
    Eigen::Vector2d step = jacobian.inverse() * residual;
    if (!step.allFinite()) return false;
    // Near the edge of the invertible region a full step overshoots it.
    const double limit = 0.5 * std::min(1.0 + p.norm(), max_radius);
    if (step.norm() > limit) step *= limit / step.norm();
    p -= step;
  }
  return false;
}

// Inverse of distort(). The pixel itself is nearly always a good start, and the centre where it is
// not. Not OpenCV's, which stops after five iterations and does not report failure.
bool undistort(const std::array<double, 4>& d, const Eigen::Vector2d& target, double max_radius,
               Eigen::Vector2d* point) {
  const Eigen::Vector2d inside =
      target.norm() > max_radius ? Eigen::Vector2d(target.normalized() * 0.9 * max_radius) : target;
  return newtonUndistort(d, target, max_radius, inside, point) ||
         newtonUndistort(d, target, max_radius, Eigen::Vector2d::Zero(), point);
}

// Distorted radius of the equidistant model and its derivative.
double equidistantRadius(const std::array<double, 4>& k, double theta, double* derivative) {
  const double q = theta * theta;
  if (derivative != nullptr) {
    *derivative = 1.0 + q * (3.0 * k[0] + q * (5.0 * k[1] + q * (7.0 * k[2] + q * 9.0 * k[3])));
  }
  return theta * (1.0 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3]))));
}

// First angle at which the radius stops increasing, at most pi. The polynomial is of degree 8, so
// it is searched on a grid (0.1 deg) and then bisected.
double equidistantLimit(const std::array<double, 4>& k) {
  constexpr int kSteps = 1800;
  double derivative = 0.0;
  for (int i = 1; i <= kSteps; ++i) {
    double high = M_PI * i / kSteps;
    equidistantRadius(k, high, &derivative);
    if (derivative > 0.0) continue;
    double low = M_PI * (i - 1) / kSteps;
    for (int j = 0; j < kMaxIterations; ++j) {
      const double middle = 0.5 * (low + high);
      equidistantRadius(k, middle, &derivative);
      (derivative > 0.0 ? low : high) = middle;
    }
    return low;
  }
  return M_PI;
}

// Newton within a bracket: the radius increases on [0, max_theta], so this cannot fail there.
// Not OpenCV's fisheye, which ends at 90 degrees from the axis.
bool equidistantAngle(const std::array<double, 4>& k, double radius, double max_theta,
                      double* theta) {
  if (!(radius <= equidistantRadius(k, max_theta, nullptr))) return false;
  double low = 0.0, high = max_theta;
  double guess = std::min(radius, max_theta);
  for (int i = 0; i < 2 * kMaxIterations; ++i) {
    double derivative = 0.0;
    const double residual = equidistantRadius(k, guess, &derivative) - radius;
    if (std::abs(residual) <= kPlaneTolerance || high - low < 1e-15) break;
    (residual > 0.0 ? high : low) = guess;
    const double next = guess - residual / derivative;
    guess = next > low && next < high ? next : 0.5 * (low + high);
  }
  *theta = guess;
  return true;
}

}  // namespace

const char* toString(CameraModel model) {
  switch (model) {
    case CameraModel::kPinhole: return "PINHOLE";
    case CameraModel::kKannalaBrandt: return "KANNALA_BRANDT";
    case CameraModel::kMei: return "MEI";
  }
  return "unknown";
}

std::string CameraParameters::validate() const {
  RangeCheck check;
  check.within("width", width, 16, 20000).within("height", height, 16, 20000);
  check.within("fx", fx, 1.0, 1e5).within("fy", fy, 1.0, 1e5);
  // A centre outside the image is a mix-up of width and height, or of pixels and fractions.
  check.within("cx", cx, 0.0, 1.0 * width).within("cy", cy, 0.0, 1.0 * height);
  // One far off the middle is of another resolution.
  check.within("cx / width", cx / width, 0.3, 0.7).within("cy / height", cy / height, 0.3, 0.7);
  for (std::size_t i = 0; i < distortion.size(); ++i) {
    check.within(text("distortion[", i, "]"), distortion[i], -100.0, 100.0);
  }
  return check.within("xi", xi, 0.0, 10.0).message();
}

Camera::Camera(const CameraParameters& parameters) : parameters_(parameters) {
  const std::array<double, 4>& d = parameters_.distortion;
  max_radius_ = parameters_.model == CameraModel::kKannalaBrandt
                    ? equidistantLimit(d)
                    : radialTangentialLimit(d[0], d[1]);
}

Eigen::Vector3d Camera::bearing(const Eigen::Vector2d& pixel) const {
  const CameraParameters& c = parameters_;
  if (!pixel.allFinite()) return noRay();
  const Eigen::Vector2d distorted((pixel.x() - c.cx) / c.fx, (pixel.y() - c.cy) / c.fy);

  if (c.model == CameraModel::kKannalaBrandt) {
    const double radius = distorted.norm();
    double theta = 0.0;
    if (!equidistantAngle(c.distortion, radius, max_radius_, &theta)) return noRay();
    // sin(theta) / radius is 1 in the limit; a ray on the axis has no direction in the plane.
    const double side = radius > 0.0 ? std::sin(theta) / radius : 1.0;
    return Eigen::Vector3d(side * distorted.x(), side * distorted.y(), std::cos(theta))
        .normalized();
  }

  Eigen::Vector2d p;
  if (!undistort(c.distortion, distorted, max_radius_, &p)) return noRay();
  if (c.model == CameraModel::kPinhole) return Eigen::Vector3d(p.x(), p.y(), 1.0).normalized();

  // MEI: where the line from the shifted centre (0, 0, -xi) through (p, 1) pierces the sphere.
  const double q = p.squaredNorm();
  const double root = 1.0 + (1.0 - c.xi * c.xi) * q;
  if (root < 0.0) return noRay();
  const double factor = (c.xi + std::sqrt(root)) / (1.0 + q);
  return Eigen::Vector3d(factor * p.x(), factor * p.y(), factor - c.xi).normalized();
}

bool Camera::project(const Eigen::Vector3d& direction, Eigen::Vector2d* pixel) const {
  const CameraParameters& c = parameters_;
  const double norm = direction.norm();
  if (!std::isfinite(norm) || norm == 0.0) return false;
  const Eigen::Vector3d ray = direction / norm;

  Eigen::Vector2d distorted;
  if (c.model == CameraModel::kKannalaBrandt) {
    const double side = ray.head<2>().norm();
    const double theta = std::atan2(side, ray.z());
    if (theta > max_radius_) return false;
    const double radius = equidistantRadius(c.distortion, theta, nullptr);
    distorted = side > 0.0 ? Eigen::Vector2d(radius / side * ray.head<2>())
                           : Eigen::Vector2d(Eigen::Vector2d::Zero());
    if (side == 0.0 && ray.z() < 0.0) return false;  // straight back: no single pixel
  } else {
    const double xi = c.model == CameraModel::kMei ? c.xi : 0.0;
    const double depth = ray.z() + xi;
    // For xi > 1 rays beyond acos(-1/xi) meet the plane a second time.
    if (depth <= 0.0 || (xi > 1.0 && ray.z() * xi < -1.0)) return false;
    const Eigen::Vector2d p = ray.head<2>() / depth;
    if (p.norm() > max_radius_) return false;
    Eigen::Matrix2d jacobian;
    distorted = distort(c.distortion, p, &jacobian);
    if (jacobian.determinant() <= 0.0) return false;
  }

  const Eigen::Vector2d result(c.fx * distorted.x() + c.cx, c.fy * distorted.y() + c.cy);
  // Pixel centres are at whole numbers: the image reaches half a pixel beyond the outermost ones.
  if (!(result.x() >= -0.5 && result.x() <= c.width - 0.5 && result.y() >= -0.5 &&
        result.y() <= c.height - 0.5)) {
    return false;
  }
  *pixel = result;
  return true;
}

double Camera::focalPx() const {
  const double focal = std::sqrt(parameters_.fx * parameters_.fy);
  return parameters_.model == CameraModel::kMei ? focal / (1.0 + parameters_.xi) : focal;
}

}  // namespace slim_init::feature_tracker_lines
