// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace slim_init {

Eigen::MatrixXd product(const DenseView& A, const DenseView& B) { return A * B; }

Eigen::MatrixXd propagated(const DenseView& J, const DenseView& P) { return J * P * J.transpose(); }

Eigen::MatrixXd solveSymmetric(const DenseView& A, const DenseView& B) { return A.ldlt().solve(B); }

bool isPositiveDefinite(const DenseView& A) {
  return Eigen::LLT<Eigen::MatrixXd>(A).info() == Eigen::Success;
}

bool invertSymmetric(const DenseView& A, Eigen::MatrixXd* inverse) {
  const Eigen::LLT<Eigen::MatrixXd> llt(A);
  *inverse = llt.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  return llt.info() == Eigen::Success;
}

bool inverseSeenBy(const DenseView& A, const DenseView& J, Eigen::MatrixXd* out) {
  const Eigen::LLT<Eigen::MatrixXd> llt(A);
  if (llt.info() != Eigen::Success) return false;
  const Eigen::MatrixXd half = llt.matrixL().solve(J);
  *out = half.transpose() * half;
  return true;
}

SymmetricEigen symmetricEigen(const DenseView& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.info() == Eigen::Success, solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace slim_init
