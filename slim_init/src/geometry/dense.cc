// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace slim_init {

Eigen::MatrixXd product(const DenseView& A, const DenseView& B) { return A * B; }

Eigen::MatrixXd propagated(const DenseView& J, const DenseView& P) { return J * P * J.transpose(); }

Eigen::MatrixXd solveSymmetric(const DenseView& A, const DenseView& B) { return A.ldlt().solve(B); }

bool isPositiveDefinite(const DenseView& A) {
  return Eigen::LLT<Eigen::MatrixXd>(A).info() == Eigen::Success;
}

bool inverseSeenBy(const DenseView& A, const DenseView& J, Eigen::MatrixXd* out) {
  // The Schur complement of A in [A, J^T; J, 0].
  const Eigen::Index n = A.rows(), seen = J.rows();
  Eigen::MatrixXd L(n + seen, n + seen);
  L.topLeftCorner(n, n).triangularView<Eigen::Lower>() = A;
  L.bottomLeftCorner(seen, n) = J;
  L.bottomRightCorner(seen, seen).setZero();
  if (!eliminateFirst(L, static_cast<int>(n))) return false;
  *out = -L.bottomRightCorner(seen, seen);
  out->triangularView<Eigen::StrictlyUpper>() = out->transpose();
  return true;
}

bool eliminateFirst(Eigen::Ref<Eigen::MatrixXd> A, int eliminated) {
  // For up to two hundred unknowns Eigen's blocked factorisation spends as much on packing its
  // operands as on arithmetic.
  constexpr int kPanel = 4;
  const Eigen::Index n = A.rows();
  for (int first = 0; first < eliminated; first += kPanel) {
    const int width = std::min(kPanel, eliminated - first);
    for (int j = first; j < first + width; ++j) {
      auto column = A.col(j).tail(n - j);
      for (int k = first; k < j; ++k) column -= A(j, k) * A.col(k).tail(n - j);
      const double pivot = column[0];
      if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
      column /= std::sqrt(pivot);
    }
    for (Eigen::Index j = first + width; j < n; ++j) {
      auto column = A.col(j).tail(n - j);
      if (width == kPanel) {
        const Eigen::Matrix<double, kPanel, 1> row = A.block<1, kPanel>(j, first).transpose();
        if (row.isZero(0.0)) continue;  // states that are not coupled
        column -= A.block<Eigen::Dynamic, kPanel>(j, first, n - j, kPanel).lazyProduct(row);
      } else {
        for (int k = first; k < first + width; ++k) column -= A(j, k) * A.col(k).tail(n - j);
      }
    }
  }
  return true;
}

bool solveDamped(const DenseView& A, const Eigen::Ref<const Eigen::VectorXd>& b, double damping,
                 Eigen::VectorXd* x) {
  const Eigen::Index n = A.rows();
  Eigen::MatrixXd L(n + 1, n + 1);
  L.topLeftCorner(n, n).triangularView<Eigen::Lower>() = A;
  L.diagonal().head(n) *= 1.0 + damping;
  L.row(n).head(n) = b.transpose();
  L(n, n) = 0.0;
  if (!eliminateFirst(L, static_cast<int>(n))) return false;
  *x = L.row(n).head(n);  // L^-1 b
  L.topLeftCorner(n, n).triangularView<Eigen::Lower>().transpose().solveInPlace(*x);
  return true;
}

SymmetricEigen symmetricEigen(const DenseView& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.info() == Eigen::Success, solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace slim_init
