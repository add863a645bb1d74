// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/normalized_epipolar_pair.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "geometry/so3.h"

namespace slim_init {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

// The six products of a symmetric 3x3 matrix, and where (a, b) is among them.
constexpr int kEntry[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

Vector9d vec(const Eigen::Matrix3d& B) { return Eigen::Map<const Vector9d>(B.data()); }

Eigen::Matrix3d adjugate(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d out;
  out.row(0) = A.col(1).cross(A.col(2));
  out.row(1) = A.col(2).cross(A.col(0));
  out.row(2) = A.col(0).cross(A.col(1));
  return out;
}

// Minimiser of e^T M e / e^T N e for symmetric M and positive definite N.
struct Quotient {
  Eigen::Vector3d e;
  double lambda;
};

// Inverse iteration with the quotient as the shift, cubic, from `e` on. False where that has not
// settled after a few steps.
bool polish(const Eigen::Matrix3d& M, const Eigen::Matrix3d& N, Quotient* at) {
  constexpr int kMaxSteps = 4;
  constexpr double kSettled = 1e-6;  // the step after this one is below rounding
  bool settled = false;
  for (int k = 0; k < kMaxSteps && !settled; ++k) {
    const Eigen::Vector3d Ne = N * at->e;
    at->lambda = at->e.dot(M * at->e) / at->e.dot(Ne);
    const Eigen::Vector3d next = adjugate(M - at->lambda * N) * Ne;
    const double norm = next.norm();
    if (!(norm > 0.0)) break;
    const Eigen::Vector3d before = at->e;
    at->e = next / norm;
    settled = at->e.cross(before).squaredNorm() < kSettled * kSettled;
  }
  at->lambda = at->e.dot(M * at->e) / at->e.dot(N * at->e);
  return settled;
}

// No other direction has a lower quotient: M - lambda N is zero along e, and here positive definite
// across it.
bool isLowest(const Eigen::Matrix3d& M, const Eigen::Matrix3d& N, const Quotient& at) {
  constexpr double kMargin = 1e-6;
  const Eigen::Matrix<double, 3, 2> T = tangentBasis(at.e);
  const Eigen::Matrix2d across = T.transpose() * (M - at.lambda * N) * T;
  const double trace = across.trace();
  return trace > 0.0 && across.determinant() > kMargin * trace * trace;
}

Quotient minimizeQuotient(const Eigen::Matrix3d& M, const Eigen::Matrix3d& N,
                          const Eigen::Vector3d& near) {
  Quotient out;
  if (near.squaredNorm() > 0.0) {
    out.e = near;
    if (polish(M, N, &out) && isLowest(M, N, out)) return out;
  }
  // N is at least the smallest eigenvalue of sum w (I - f f^T), far from singular for any image;
  // the small term covers bearings that all coincide.
  const Eigen::Matrix3d L =
      Eigen::Matrix3d(N + 1e-12 * N.trace() * Eigen::Matrix3d::Identity()).llt().matrixL();
  const Eigen::Matrix3d Li = L.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d A = Li * M * Li.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(0.5 * (A + A.transpose()));
  out.e = (Li.transpose() * solver.eigenvectors().col(0)).normalized();
  // The closed form is good to about the root of the machine precision.
  polish(M, N, &out);
  return out;
}

}  // namespace

void NormalizedEpipolarPair::sum(const PairPoints& points) {
  const PairPoints::Bearings& f_i = points.bearingsI();
  const PairPoints::Bearings& f_j = points.bearingsJ();
  // (f_j (x) f_i)(f_j (x) f_i)^T has 36 different entries, f_i f_i^T times f_j f_j^T. Two points at
  // a time in separate accumulators, so that the compiler may use vector registers without
  // changing the order of additions.
  double ij[6][6][PairPoints::kGroup] = {};
  double ii[6][PairPoints::kGroup] = {};
  double jj[6][PairPoints::kGroup] = {};
  double w_sum[PairPoints::kGroup] = {};
  const double* fi[3] = {f_i.col(0).data(), f_i.col(1).data(), f_i.col(2).data()};
  const double* fj[3] = {f_j.col(0).data(), f_j.col(1).data(), f_j.col(2).data()};
  const double* w = weights_.data();
  for (int k = 0; k < points.count(); k += PairPoints::kGroup) {
    double a[6][PairPoints::kGroup], b[6][PairPoints::kGroup];
    for (int q = 0; q < 6; ++q) {
      for (int l = 0; l < PairPoints::kGroup; ++l) {
        a[q][l] = w[k + l] * fi[kEntry[q][0]][k + l] * fi[kEntry[q][1]][k + l];
        b[q][l] = fj[kEntry[q][0]][k + l] * fj[kEntry[q][1]][k + l];
      }
    }
    for (int p = 0; p < 6; ++p) {
      for (int q = 0; q < 6; ++q) {
        for (int l = 0; l < PairPoints::kGroup; ++l) ij[p][q][l] += a[p][l] * b[q][l];
      }
      for (int l = 0; l < PairPoints::kGroup; ++l) ii[p][l] += a[p][l];
      for (int l = 0; l < PairPoints::kGroup; ++l) jj[p][l] += w[k + l] * b[p][l];
    }
    for (int l = 0; l < PairPoints::kGroup; ++l) w_sum[l] += w[k + l];
  }
  const auto total = [](const double* lanes) { return lanes[0] + lanes[1]; };
  weight_sum_ = total(w_sum);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      sum_ii_(a, b) = total(ii[kPacked[a][b]]);
      sum_jj_(a, b) = total(jj[kPacked[a][b]]);
      // vec(f_j f_i^T): the index of f_j runs first.
      for (int c = 0; c < 3; ++c) {
        for (int d = 0; d < 3; ++d) {
          sums_(3 * a + c, 3 * b + d) = total(ij[kPacked[a][b]][kPacked[c][d]]);
        }
      }
    }
  }
}

NormalizedEpipolarPair::Forms NormalizedEpipolarPair::formsAt(
    const Eigen::Matrix3d& R_ci_cj) const {
  const Eigen::Matrix3d Rt = R_ci_cj.transpose();
  Forms at;
  // Columns vec(R^T [e_a]x): R^T [e_x]x = (0, r_z, -r_y) and so on, r the columns of R^T.
  at.B.col(0) << Eigen::Vector3d::Zero(), Rt.col(2), -Rt.col(1);
  at.B.col(1) << -Rt.col(2), Eigen::Vector3d::Zero(), Rt.col(0);
  at.B.col(2) << Rt.col(1), -Rt.col(0), Eigen::Vector3d::Zero();
  // Written out: for these sizes Eigen would call its kernel for large matrices, four times slower.
  const Eigen::Matrix<double, 9, 3> SB = sums_.lazyProduct(at.B);
  at.M = at.B.transpose() * SB;
  at.N = 2.0 * weight_sum_ * Eigen::Matrix3d::Identity() - sum_ii_ - R_ci_cj * sum_jj_ * Rt;
  return at;
}

Eigen::Vector3d NormalizedEpipolarPair::baseline(const Eigen::Matrix3d& R_ci_cj,
                                                 const Eigen::Vector3d& near) const {
  const Forms at = formsAt(R_ci_cj);
  return minimizeQuotient(at.M, at.N, near).e;
}

NormalizedEvaluation NormalizedEpipolarPair::evaluate(const Eigen::Matrix3d& R_ci_cj,
                                                      double baseline_prior,
                                                      const Eigen::Vector3d& near) const {
  const Eigen::Matrix3d Rt = R_ci_cj.transpose();
  const Forms forms = formsAt(R_ci_cj);
  const Eigen::Matrix3d &M = forms.M, &N = forms.N;
  const Quotient quotient = minimizeQuotient(M, N, near);
  const Eigen::Vector3d& e = quotient.e;
  const double eNe = e.dot(N * e);
  NormalizedEvaluation out;
  out.lambda = quotient.lambda;
  out.baseline = e;

  // Numerator as in EpipolarPair. Denominator: e^T N e = .. - a^T (sum w f_j f_j^T) a with
  // a = R^T e, which Exp(delta) turns into a + a x delta.
  const Eigen::Matrix3d E = Rt * skew(e);
  Eigen::Matrix<double, 9, 3> D;
  // Columns vec(-[e_k]x E): -[e_x]x swaps the last two rows with a sign, and so on.
  for (int c = 0; c < 3; ++c) {
    D.block<3, 1>(3 * c, 0) << 0.0, E(2, c), -E(1, c);
    D.block<3, 1>(3 * c, 1) << -E(2, c), 0.0, E(0, c);
    D.block<3, 1>(3 * c, 2) << E(1, c), -E(0, c), 0.0;
  }
  const Eigen::Matrix<double, 9, 3> SD = sums_.lazyProduct(D);
  const Eigen::Vector3d a = Rt * e;
  const Eigen::Vector3d dM = 2.0 * (SD.transpose() * vec(E));
  const Eigen::Vector3d dN = 2.0 * a.cross(sum_jj_ * a);
  out.gradient = (dM - out.lambda * dN) / eNe;

  const Eigen::Matrix<double, 3, 2> T = tangentBasis(e);
  const Eigen::Matrix<double, 3, 2> cross = SD.transpose() * (forms.B * T);
  Eigen::Matrix2d Hee = T.transpose() * (M - out.lambda * N) * T;
  // M - lambda N is positive semidefinite at the minimum, up to rounding.
  Hee.diagonal().array() += baseline_prior * eNe + 1e-15 * M.trace();
  const Eigen::Matrix3d DSD = D.transpose() * SD;
  out.hessian = 2.0 / eNe * (DSD - cross * Hee.inverse() * cross.transpose());
  // The noise part that was taken off M is missing from D^T S D; far from the minimum that can
  // leave a negative curvature, which is no use to a descent method.
  if (!(out.hessian.llt().info() == Eigen::Success)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(out.hessian);
    out.hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                  eigen.eigenvectors().transpose();
  }
  return out;
}

void NormalizedEpipolarPair::weigh(const PairPoints& points, const Eigen::ArrayXd& mask,
                                   const Eigen::Matrix3d& R_ci_cj, const Eigen::Vector3d& baseline,
                                   double sigma, double cutoff_sigmas) {
  const int count = points.count();
  const PointResiduals residuals = points.residuals(R_ci_cj, baseline, sigma);
  const double c2 = cutoff_sigmas * cutoff_sigmas;
  weights_.resize(points.bearingsI().rows());
  weights_.tail(weights_.size() - count).setZero();
  weights_.head(count) = (1.0 + residuals.z2 / c2).square().inverse();
  if (mask.size() != 0) weights_.head(count) *= mask.head(count);
  robust_count_ = weights_.head(count).sum();
  weights_.head(count) /= residuals.noise;
  sum(points);
}

}  // namespace slim_init
