// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/pair_rotation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/median.h"
#include "geometry/robust_weight.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix32d = Eigen::Matrix<double, 3, 2>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

constexpr int kMinPoints = 8;
constexpr double kMinSigma = 1e-4;         // a twentieth of a pixel; no tracker is better
constexpr double kMadToSigma = 1.4826;     // of a Gaussian
constexpr double kMedianToSigma = 0.8493;  // of the length of a plane Gaussian vector: 1/1.1774

/// R that minimises sum w |f_i - R f_j|^2 (Wahba's problem).
Matrix3d wahba(const std::vector<BearingPair>& points, const std::vector<double>& weights) {
  Matrix3d B = Matrix3d::Zero();
  for (std::size_t k = 0; k < points.size(); ++k) {
    B += weights[k] * points[k].f_i * points[k].f_j.transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs = Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

/// The rotation that comes nearest to explaining the points without travel.
Matrix3d rotationAlone(const std::vector<BearingPair>& points) {
  std::vector<double> weights(points.size(), 1.0);
  std::vector<double> distances(points.size());
  Matrix3d R;
  for (int iteration = 0; iteration < 5; ++iteration) {
    R = wahba(points, weights);
    for (std::size_t k = 0; k < points.size(); ++k) {
      distances[k] = (points[k].f_i - R * points[k].f_j).norm();
    }
    const double spread = std::max(kMedianToSigma * median(distances), kMinSigma);
    for (std::size_t k = 0; k < points.size(); ++k) {
      weights[k] = gemanMcClure(std::pow(distances[k] / spread, 2));
    }
  }
  return R;
}

Matrix32d tangentOf(const Vector3d& e) {
  Matrix32d T;
  T.col(0) = e.unitOrthogonal();
  T.col(1) = e.cross(T.col(0));
  return T;
}

/// Search over rotation and direction of travel.
class EpipolarSearch {
 public:
  EpipolarSearch(const std::vector<BearingPair>& points, double sigma)
      : points_(points), residuals_(points.size()), sigma_(sigma) {}

  Matrix3d R = Matrix3d::Identity();
  Vector3d e = Vector3d::UnitZ();

  /// The direction at right angles to most epipolar plane normals.
  void directionFromRotation() {
    Matrix3d M = Matrix3d::Zero();
    for (const BearingPair& p : points_) {
      const Vector3d m = p.f_i.cross(R * p.f_j);
      M += m * m.transpose() / (m.squaredNorm() + sigma_ * sigma_);
    }
    e = Eigen::SelfAdjointEigenSolver<Matrix3d>(M).eigenvectors().col(0);
  }

  /// Robust cost at R, e: mean of min(z^2, c^2).
  double cost() {
    evaluate();
    double sum = 0.0;
    for (const double r : residuals_) {
      sum += std::min(r * r / (sigma_ * sigma_), kGemanMcClureSigmas * kGemanMcClureSigmas);
    }
    return sum / static_cast<double>(points_.size());
  }

  /// Gauss-Newton steps. `scale` [rad] is that of the robust weights.
  void iterate(int steps, double scale) {
    for (int step = 0; step < steps; ++step) {
      Matrix5d H;
      Vector5d gradient;
      build(scale, &H, &gradient);
      // Without parallax nothing holds the direction of travel; one radian of it is prior enough.
      H(3, 3) += 1.0;
      H(4, 4) += 1.0;
      const Vector5d x = H.ldlt().solve(-gradient);
      if (!x.allFinite()) return;
      // A step of more than this leaves the region where the linearisation means anything.
      constexpr double kMaxTurn = 0.2;
      const double shrink = std::min(1.0, kMaxTurn / std::max(x.head<3>().norm(), 1e-12));
      const Vector3d e_next = e + shrink * (tangentOf(e) * x.tail<2>());
      R *= expSO3(shrink * x.head<3>());
      e = e_next.normalized();
      if (x.norm() < 1e-9) return;
    }
  }

  /// Robust standard deviation of the residuals at R, e.
  double spread() {
    evaluate();
    std::vector<double> sizes(residuals_.size());
    std::transform(residuals_.begin(), residuals_.end(), sizes.begin(),
                   [](double r) { return std::abs(r); });
    return std::max(kMadToSigma * median(sizes), kMinSigma);
  }

  /// Of R Exp(delta), direction eliminated, for bearings of noise `scale`.
  Matrix3d information(double scale) {
    Matrix5d H;
    Vector5d gradient;
    build(scale, &H, &gradient);
    const Eigen::Matrix2d travel = H.bottomRightCorner<2, 2>() + Eigen::Matrix2d::Identity();
    return H.topLeftCorner<3, 3>() -
           H.topRightCorner<3, 2>() * travel.inverse() * H.bottomLeftCorner<2, 3>();
  }

 private:
  void evaluate() {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Vector3d& f_i = points_[k].f_i;
      const Vector3d& f_j = points_[k].f_j;
      const double n = e.cross(f_i).squaredNorm() + (R.transpose() * e).cross(f_j).squaredNorm();
      residuals_[k] = e.dot(f_i.cross(R * f_j)) / std::sqrt(std::max(n, 1e-12));
    }
  }

  void build(double scale, Matrix5d* H, Vector5d* gradient) {
    H->setZero();
    gradient->setZero();
    const Matrix32d T = tangentOf(e);
    const Vector3d e_j = R.transpose() * e;
    for (const BearingPair& p : points_) {
      const Vector3d a = e.cross(p.f_i);
      const double n = std::max(a.squaredNorm() + e_j.cross(p.f_j).squaredNorm(), 1e-12);
      const double inverse = 1.0 / (scale * std::sqrt(n));
      const Vector3d m = p.f_i.cross(R * p.f_j);
      const double z = e.dot(m) * inverse;
      Vector5d J;
      J.head<3>() = p.f_j.cross(R.transpose() * a) * inverse;
      J.tail<2>() = T.transpose() * m * inverse;
      // n changes too. Held fixed, it would pull the direction to where n is large: a bias, and not
      // a small one where parallax is not much more than noise.
      const double along_i = e.dot(p.f_i), along_j = e_j.dot(p.f_j);
      Vector5d half_dn;
      half_dn.head<3>() = -along_j * p.f_j.cross(e_j);
      half_dn.tail<2>() = -T.transpose() * (along_i * p.f_i + along_j * (R * p.f_j));
      J -= z / n * half_dn;
      const double w = gemanMcClure(z * z);
      *H += w * J * J.transpose();
      *gradient += w * z * J;
    }
  }

  const std::vector<BearingPair>& points_;
  std::vector<double> residuals_;
  double sigma_;
};

/// Sideways travel and a turn look alike in a narrow view: besides R also rotations that trade some
/// of one for the other, about the image's axes.
std::vector<Matrix3d> startsNear(const Matrix3d& R, double flow) {
  std::vector<Matrix3d> starts = {R};
  // Share of the flow that a rotation may explain, and its largest angle [rad].
  constexpr double kShareOfFlow = 0.7, kMaxAngle = 0.15;
  const double angle = std::min(kShareOfFlow * flow, kMaxAngle);
  for (const double sign : {-1.0, 1.0}) {
    starts.push_back(R * expSO3(Vector3d(sign * angle, 0.0, 0.0)));
    starts.push_back(R * expSO3(Vector3d(0.0, sign * angle, 0.0)));
  }
  return starts;
}

}  // namespace

bool relativeRotation(const std::vector<BearingPair>& points, double sigma, const Matrix3d* start,
                      RelativeRotation* result) {
  if (points.size() < kMinPoints) return false;
  std::vector<double> flows;
  for (const BearingPair& p : points) flows.push_back((p.f_i - p.f_j).norm());
  result->flow = median(flows);

  const Matrix3d R_alone = rotationAlone(points);

  EpipolarSearch search(points, sigma);
  Matrix3d R_best = R_alone;
  Vector3d e_best = Vector3d::UnitZ();
  double best = std::numeric_limits<double>::infinity();
  for (const Matrix3d& R :
       start != nullptr ? std::vector<Matrix3d>{*start} : startsNear(R_alone, result->flow)) {
    search.R = R;
    search.directionFromRotation();
    // Far from the solution every point is an outlier at the scale of the noise.
    for (int round = 0; round < 4; ++round) {
      search.iterate(2, std::max(2.0 * sigma, search.spread()));
    }
    const double cost = search.cost();
    if (!(cost < best)) continue;
    best = cost;
    R_best = search.R;
    e_best = search.e;
  }
  search.R = R_best;
  search.e = e_best;
  for (int round = 0; round < 3; ++round) search.iterate(3, search.spread());
  result->R_ci_cj = search.R;
  result->residual = search.spread();
  result->information = search.information(result->residual);
  return result->R_ci_cj.allFinite() && result->information.allFinite();
}

}  // namespace slim_init
