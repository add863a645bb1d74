// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "epipolar_pair.h"

#include <Eigen/Eigenvalues>

#include "geometry/so3.h"

namespace slim_init::baselines {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

// Column-major stacking; f_j^T B f_i = vec(f_j f_i^T) . vec(B).
Vector9d vec(const Eigen::Matrix3d& B) { return Eigen::Map<const Vector9d>(B.data()); }

// Columns vec(R^T [e_a]x) for the three unit vectors e_a.
Eigen::Matrix<double, 9, 3> baselineBasis(const Eigen::Matrix3d& R_ci_cj) {
  Eigen::Matrix<double, 9, 3> B;
  for (int a = 0; a < 3; ++a) {
    B.col(a) = vec(R_ci_cj.transpose() * skew(Eigen::Vector3d::Unit(a)));
  }
  return B;
}

}  // namespace

void EpipolarPair::add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j) {
  const Eigen::Matrix3d outer = f_j * f_i.transpose();
  const Vector9d u = vec(outer);
  // Both triangles: a full 9x9 product is faster than a symmetric one at this size.
  sums_.noalias() += u * u.transpose();
  ++count_;
}

EpipolarEvaluation EpipolarPair::evaluate(const Eigen::Matrix3d& R_ci_cj) const {
  const Eigen::Matrix<double, 9, 3> B = baselineBasis(R_ci_cj);
  const Eigen::Matrix<double, 9, 3> SB = sums_ * B;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(Eigen::Matrix3d(B.transpose() * SB));
  EpipolarEvaluation out;
  out.lambda = solver.eigenvalues()[0];
  const Eigen::Vector3d e = solver.eigenvectors().col(0);
  out.baseline = e;

  // R Exp(delta): d(R^T [e]x)/d delta_k = -[e_k]x R^T [e]x. Residuals r = e . m, Jacobian over
  // delta; r^T r = lambda, J^T r = D^T S b, J^T J = D^T S D with b = vec(R^T [e]x).
  const Eigen::Matrix3d E = R_ci_cj.transpose() * skew(e);
  Eigen::Matrix<double, 9, 3> D;
  for (int k = 0; k < 3; ++k) D.col(k) = vec(-skew(Eigen::Vector3d::Unit(k)) * E);
  const Eigen::Matrix<double, 9, 3> SD = sums_ * D;
  out.gradient = 2.0 * (SD.transpose() * (B * e));

  // Elimination of the baseline: its tangent is spanned by the other two eigenvectors v, along
  // which the Gauss-Newton Hessian of e^T M e is 2 lambda_v.
  out.hessian = 2.0 * (D.transpose() * SD);
  const Eigen::Matrix3d SDtB = SD.transpose() * B;  // D^T S B, S is symmetric
  for (int a = 1; a < 3; ++a) {
    const Eigen::Vector3d v = solver.eigenvectors().col(a);
    // Without any parallax the baseline is free along v: nothing to eliminate.
    if (solver.eigenvalues()[a] < 1e-12 * solver.eigenvalues()[2]) continue;
    // Derivative of e^T M v: (D_k e)^T S (B v) + (B e)^T S (D_k v); the second part vanishes with
    // the residual and is left out as in Gauss-Newton.
    const Eigen::Vector3d cross = SDtB * v;
    out.hessian -= 2.0 * cross * cross.transpose() / solver.eigenvalues()[a];
  }
  return out;
}

}  // namespace slim_init::baselines
