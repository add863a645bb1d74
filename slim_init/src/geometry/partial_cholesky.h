// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Elimination of the first unknowns of dense normal equations of ten to two hundred unknowns. For
// these sizes the blocked factorisation of Eigen spends more on packing its operands than on
// arithmetic.
#pragma once

#include <Eigen/Core>

namespace slim_init {

/// A square matrix laid out as partialCholesky() wants it: columns of even length.
class EvenMatrix {
 public:
  explicit EvenMatrix(int size = 0) : data_(size + size % 2, size) {}
  double* data() { return data_.data(); }
  int stride() const { return static_cast<int>(data_.rows()); }
  Eigen::MatrixXd::ColXpr column(int j) { return data_.col(j); }
  Eigen::MatrixXd::ConstColXpr column(int j) const { return data_.col(j); }

 private:
  Eigen::MatrixXd data_;
};

/// Eliminates the first `eliminated` of the `n` unknowns of a symmetric matrix, in place. `A` is
/// column-major with leading dimension `ld` (even, at least n); it starts at a multiple of 16
/// bytes. Only the lower triangle is read. On return the first columns hold those of the Cholesky
/// factor L (all n rows of them), and the lower triangle of the rest the Schur complement, in which
/// a row appended as a right-hand side has become that of the reduced problem. Above the diagonal
/// is scratch. False where a pivot is not positive or not finite; A is then half done.
bool partialCholesky(double* A, int ld, int n, int eliminated);

/// Lower triangle of C (n x n, leading dimension ldc) minus P P^T; P: n x 3 with leading dimension
/// ldp. Both start at a multiple of 16 bytes, leading dimensions even. Above the diagonal of C is
/// scratch.
void subtractOuterProduct3(double* C, int ldc, int n, const double* P, int ldp);

/// T (L L^T)^-1 T^T, symmetric: the covariance of T x where L L^T is the information of x. `L`:
/// what partialCholesky() with all unknowns eliminated left, size T.cols(). Zeros at the beginning
/// of a row of T are not computed with.
Eigen::MatrixXd propagatedCovariance(const EvenMatrix& L, const Eigen::MatrixXd& T);

}  // namespace slim_init
