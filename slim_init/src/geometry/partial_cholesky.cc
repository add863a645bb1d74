// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "geometry/partial_cholesky.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim_init {
namespace {

// Two numbers of a register; a GCC and Clang extension, on processors without vector registers two
// scalars.
typedef double Pair __attribute__((vector_size(16), may_alias));

inline Pair both(double x) { return Pair{x, x}; }

// C(j.., j) -= P(j.., :) P(j, :)^T for the columns from `from` to n of a lower triangle, rows in
// pairs from the even one at or above the diagonal. Two columns at a time share the loads of P.
template <int kWidth>
void subtractOuterProduct(double* C, int ldc, int from, int n, const double* P, int ldp) {
  int j = from;
  for (; j + 1 < n; j += 2) {
    Pair a[kWidth], b[kWidth];
    for (int w = 0; w < kWidth; ++w) {
      a[w] = both(P[w * ldp + j]);
      b[w] = both(P[w * ldp + j + 1]);
    }
    double* c0 = C + j * ldc;
    double* c1 = c0 + ldc;
    for (int i = j & ~1; i < n; i += 2) {
      Pair sum0 = *reinterpret_cast<const Pair*>(c0 + i);
      Pair sum1 = *reinterpret_cast<const Pair*>(c1 + i);
      for (int w = 0; w < kWidth; ++w) {
        const Pair p = *reinterpret_cast<const Pair*>(P + w * ldp + i);
        sum0 -= p * a[w];
        sum1 -= p * b[w];
      }
      *reinterpret_cast<Pair*>(c0 + i) = sum0;
      *reinterpret_cast<Pair*>(c1 + i) = sum1;
    }
  }
  if (j < n) {
    double sum = C[j * ldc + j];
    for (int w = 0; w < kWidth; ++w) sum -= P[w * ldp + j] * P[w * ldp + j];
    C[j * ldc + j] = sum;
  }
}

// Columns first .. first + width of A become those of L; the columns before have been taken off.
bool factorPanel(double* A, int ld, int n, int first, int width) {
  for (int j = first; j < first + width; ++j) {
    double* column = A + j * ld;
    for (int k = first; k < j; ++k) {
      const double* done = A + k * ld;
      const double factor = done[j];
      for (int i = j; i < n; ++i) column[i] -= done[i] * factor;
    }
    const double pivot = column[j];
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double inverse = 1.0 / std::sqrt(pivot);
    for (int i = j; i < n; ++i) column[i] *= inverse;
  }
  return true;
}

}  // namespace

bool partialCholesky(double* A, int ld, int n, int eliminated) {
  constexpr int kPanel = 4;
  for (int first = 0; first < eliminated; first += kPanel) {
    const int width = std::min(kPanel, eliminated - first);
    if (!factorPanel(A, ld, n, first, width)) return false;
    const double* P = A + first * ld;
    switch (width) {
      case 4: subtractOuterProduct<4>(A, ld, first + width, n, P, ld); break;
      case 3: subtractOuterProduct<3>(A, ld, first + width, n, P, ld); break;
      case 2: subtractOuterProduct<2>(A, ld, first + width, n, P, ld); break;
      default: subtractOuterProduct<1>(A, ld, first + width, n, P, ld); break;
    }
  }
  return true;
}

Eigen::MatrixXd propagatedCovariance(const EvenMatrix& L, const Eigen::MatrixXd& T) {
  const int n = static_cast<int>(T.cols());
  const int rows = static_cast<int>(T.rows());
  const int even_rows = rows + rows % 2;
  // Rows of L and of T, each contiguous; two of T at a time. Beyond their ends there are zeros.
  const int ld = n + n % 2;
  Eigen::MatrixXd by_row(ld, n);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k <= i; ++k) by_row(k, i) = L.column(k)[i];
  }
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(ld, even_rows);
  X.topLeftCorner(n, rows) = T.transpose();
  std::vector<int> first(even_rows / 2, 0);
  for (int r = 0; r < even_rows; r += 2) {
    int& from = first[r / 2];
    while (from < n && X(from, r) == 0.0 && X(from, r + 1) == 0.0) ++from;
    from &= ~1;
    // X <- L^-1 X.
    double *x0 = &X(0, r), *x1 = x0 + ld;
    for (int i = from; i < n; ++i) {
      const double* row = &by_row(0, i);
      Pair sum0 = both(0.0), sum1 = sum0;
      int k = from;
      for (; k + 1 < i; k += 2) {
        const Pair l = *reinterpret_cast<const Pair*>(row + k);
        sum0 += l * *reinterpret_cast<const Pair*>(x0 + k);
        sum1 += l * *reinterpret_cast<const Pair*>(x1 + k);
      }
      double rest0 = x0[i] - sum0[0] - sum0[1], rest1 = x1[i] - sum1[0] - sum1[1];
      if (k < i) {
        rest0 -= row[k] * x0[k];
        rest1 -= row[k] * x1[k];
      }
      x0[i] = rest0 / row[i];
      x1[i] = rest1 / row[i];
    }
  }
  Eigen::MatrixXd out(even_rows, even_rows);
  for (int a = 0; a < even_rows; a += 2) {
    const double *a0 = &X(0, a), *a1 = a0 + ld;
    for (int b = 0; b <= a; b += 2) {
      const double *b0 = &X(0, b), *b1 = b0 + ld;
      Pair s00 = both(0.0), s01 = s00, s10 = s00, s11 = s00;
      for (int k = std::max(first[a / 2], first[b / 2]); k < n; k += 2) {
        const Pair u0 = *reinterpret_cast<const Pair*>(a0 + k);
        const Pair u1 = *reinterpret_cast<const Pair*>(a1 + k);
        const Pair v0 = *reinterpret_cast<const Pair*>(b0 + k);
        const Pair v1 = *reinterpret_cast<const Pair*>(b1 + k);
        s00 += u0 * v0;
        s01 += u0 * v1;
        s10 += u1 * v0;
        s11 += u1 * v1;
      }
      out(a, b) = out(b, a) = s00[0] + s00[1];
      out(a, b + 1) = out(b + 1, a) = s01[0] + s01[1];
      out(a + 1, b) = out(b, a + 1) = s10[0] + s10[1];
      out(a + 1, b + 1) = out(b + 1, a + 1) = s11[0] + s11[1];
    }
  }
  if (even_rows != rows) out.conservativeResize(rows, rows);
  return out;
}

void subtractOuterProduct3(double* C, int ldc, int n, const double* P, int ldp) {
  subtractOuterProduct<3>(C, ldc, 0, n, P, ldp);
}

}  // namespace slim_init
