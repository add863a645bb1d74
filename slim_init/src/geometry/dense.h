// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Products and decompositions of dense matrices as plain functions, so that Eigen's templates are
// compiled once. They allocate: for what runs a few times in a solve.
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// A matrix of any size, without a copy where it is stored by columns.
using DenseView = Eigen::Ref<const Eigen::MatrixXd>;

/// A B
Eigen::MatrixXd product(const DenseView& A, const DenseView& B);

/// J P J^T: the covariance of J x, where x has the covariance P.
Eigen::MatrixXd propagated(const DenseView& J, const DenseView& P);

/// A^-1 B of a symmetric A, by LDL^T.
Eigen::MatrixXd solveSymmetric(const DenseView& A, const DenseView& B);

/// Whether the symmetric A has a Cholesky factor.
bool isPositiveDefinite(const DenseView& A);

/// J A^-1 J^T of a symmetric, positive definite A, of which the lower triangle is read: with an
/// information A the covariance of J x. False if it is not positive definite.
bool inverseSeenBy(const DenseView& A, const DenseView& J, Eigen::MatrixXd* out);

/// Eliminates the first `eliminated` unknowns of a symmetric matrix in place; the lower triangle is
/// read. On return the first columns hold those of the Cholesky factor L (all rows of them), and
/// the lower triangle of the rest the Schur complement, in which a row appended as a right-hand
/// side has become that of the reduced problem. False where what is eliminated is not positive
/// definite; A is then half done.
bool eliminateFirst(Eigen::Ref<Eigen::MatrixXd> A, int eliminated);

/// x of (A + damping diag A) x = b; A symmetric, of which the lower triangle is read. False if the
/// damped A is not positive definite; x is then undefined.
bool solveDamped(const DenseView& A, const Eigen::Ref<const Eigen::VectorXd>& b, double damping,
                 Eigen::VectorXd* x);

/// Eigenvalues in rising order, and an eigenvector a column.
struct SymmetricEigen {
  bool valid = false;
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetricEigen(const DenseView& A);

}  // namespace slim_init
