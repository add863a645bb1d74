// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/gravity_constrained.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/dense.h"

namespace slim_init {
namespace {

// With a unit diagonal a pivot below this is rounding: the unknown is not determined.
constexpr double kMinPivot = 1e-14;
// Steps on the secular equation: Newton needs a few, the bisection that guards it at most sixty.
constexpr int kMaxSecularSteps = 100;

}  // namespace

Eigen::Vector3d minimizeOnSphere(const Eigen::Matrix3d& S, const Eigen::Vector3d& m, double G) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(S);
  const Eigen::Vector3d d = solver.eigenvalues().array() - solver.eigenvalues()[0];
  const Eigen::Vector3d h = solver.eigenvectors().transpose() * m;
  // g(nu) = h / (d + nu) with nu = mu + smallest eigenvalue >= 0; |g| falls monotonically in nu.
  const auto norm = [&](double nu) { return (h.array() / (d.array() + nu)).matrix().norm(); };
  Eigen::Vector3d g;
  const double tiny = 1e-15 * std::max(d[2], h.norm() / G);
  if (norm(tiny) <= G) {
    // Hard case: m has no part along the weakest direction, so the solution is not unique; one of
    // the two mirror images is filled up to the norm.
    g = h.array() / (d.array() + tiny);
    const double rest = G * G - g.tail<2>().squaredNorm();
    g[0] = std::copysign(std::sqrt(std::max(rest, 0.0)), h[0]);
  } else {
    // 1/|g| is concave and nearly linear in nu: Newton from the left does not overshoot; the
    // bracket is a safeguard against rounding.
    double low = tiny;
    double high = h.norm() / G;  // |g(high)| <= |h| / high = G
    double nu = low;
    for (int i = 0; i < kMaxSecularSteps; ++i) {
      const Eigen::Vector3d at = h.array() / (d.array() + nu);
      const double length = at.norm();
      (length > G ? low : high) = nu;
      const double slope = (at.array().square() / (d.array() + nu)).sum() / (length * length);
      double next = nu + (length / G - 1.0) / slope;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (std::abs(next - nu) <= 1e-16 * (nu + next)) break;
      nu = next;
    }
    g = h.array() / (d.array() + nu);
  }
  g *= G / g.norm();
  return solver.eigenvectors() * g;
}

bool solveGravityConstrained(const Eigen::MatrixXd& H, const Eigen::VectorXd& b,
                             double gravity_magnitude, Eigen::VectorXd* x) {
  const Eigen::Index q = H.rows() - 3;
  if (!b.allFinite() || !(H.diagonal().head(q).minCoeff() > 0.0)) return false;
  // Scaled to a unit diagonal, so that positions, velocities and scale weigh alike in the test for
  // definiteness.
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(q + 3);
  scale.head(q) = H.diagonal().head(q).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd A(q + 4, q + 4);
  A.topLeftCorner(q + 3, q + 3) = scale.asDiagonal() * H * scale.asDiagonal();
  A.row(q + 3).head(q + 3) = scale.cwiseProduct(b).transpose();
  // Input that is not finite fails this test as well.
  if (!eliminateFirst(A, static_cast<int>(q))) return false;
  if (!(A.diagonal().head(q).cwiseAbs2().minCoeff() > kMinPivot)) return false;
  const Eigen::Matrix3d S = A.block<3, 3>(q, q).selfadjointView<Eigen::Lower>();
  const Eigen::Vector3d m = A.block<1, 3>(q + 3, q).transpose();
  if (!S.allFinite() || !m.allFinite()) return false;

  const Eigen::Vector3d g = minimizeOnSphere(S, m, gravity_magnitude);
  *x = A.row(q + 3).head(q + 3).transpose();
  x->head(q) -= A.block(q, 0, 3, q).transpose() * g;
  A.topLeftCorner(q, q).triangularView<Eigen::Lower>().transpose().solveInPlace(x->head(q));
  x->tail<3>() = g;
  *x = scale.cwiseProduct(*x);
  return x->allFinite();
}

}  // namespace slim_init
