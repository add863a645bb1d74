// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/normalized_epipolar_pair.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/so3.h"

namespace slim_init {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

// The six products of a symmetric 3x3 matrix, and where (a, b) is among them.
constexpr int kRow[6] = {0, 0, 0, 1, 1, 2};
constexpr int kCol[6] = {0, 1, 2, 1, 2, 2};
constexpr int kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

// Points are stored in groups of this many, filled up with zeros, which add nothing to any sum.
constexpr int kGroup = 2;
// A point nearer than this to the baseline (|e x f|^2 summed over both views) is weighted as if it
// stood there: its residual has second-order noise that the first-order weight does not know.
constexpr double kMinNoise = 1e-2;

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

Quotient minimizeQuotient(const Eigen::Matrix3d& M, const Eigen::Matrix3d& N) {
  // N is at least the smallest eigenvalue of sum w (I - f f^T), far from singular for any image;
  // the small term covers bearings that all coincide.
  const Eigen::Matrix3d L =
      Eigen::Matrix3d(N + 1e-12 * N.trace() * Eigen::Matrix3d::Identity()).llt().matrixL();
  const Eigen::Matrix3d Li = L.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d A = Li * M * Li.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(0.5 * (A + A.transpose()));
  Quotient out;
  out.e = (Li.transpose() * solver.eigenvectors().col(0)).normalized();
  // The closed form is good to about the root of the machine precision; one step of inverse
  // iteration from there, cubic, to all of it.
  for (int k = 0; k < 2; ++k) {
    out.lambda = out.e.dot(M * out.e) / out.e.dot(N * out.e);
    const Eigen::Vector3d next = adjugate(M - out.lambda * N) * (N * out.e);
    const double norm = next.norm();
    if (!(norm > 0.0)) break;
    out.e = next / norm;
  }
  out.lambda = out.e.dot(M * out.e) / out.e.dot(N * out.e);
  return out;
}

// Small fixed sequence of indices; the standard library's distributions differ between libraries.
class Sequence {
 public:
  explicit Sequence(unsigned seed) : state_(0x9e3779b97f4a7c15ULL * (seed + 1ULL)) {}
  int below(int n) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<int>(((state_ >> 33) * static_cast<std::uint64_t>(n)) >> 31);
  }

 private:
  std::uint64_t state_;
};

}  // namespace

void NormalizedEpipolarPair::reserve(int points) {
  const int rows = (points + kGroup - 1) / kGroup * kGroup;
  f_i_ = Points::Zero(rows, 3);
  f_j_ = Points::Zero(rows, 3);
  weights_ = Eigen::ArrayXd::Zero(rows);
  mask_ = Eigen::ArrayXd::Zero(rows);
}

void NormalizedEpipolarPair::add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j) {
  if (count_ == f_i_.rows()) {
    const Eigen::Index rows = std::max<Eigen::Index>(16, 2 * f_i_.rows());
    const Eigen::Index old = f_i_.rows();
    f_i_.conservativeResize(rows, 3);
    f_j_.conservativeResize(rows, 3);
    weights_.conservativeResize(rows);
    mask_.conservativeResize(rows);
    f_i_.bottomRows(rows - old).setZero();
    f_j_.bottomRows(rows - old).setZero();
    weights_.tail(rows - old).setZero();
    mask_.tail(rows - old).setZero();
  }
  f_i_.row(count_) = f_i.transpose().array();
  f_j_.row(count_) = f_j.transpose().array();
  mask_[count_] = 1.0;
  ++count_;
}

void NormalizedEpipolarPair::resetWeights() {
  weights_ = mask_;
  robust_count_ = mask_.sum();
  sum();
}

void NormalizedEpipolarPair::sum() {
  // (f_j (x) f_i)(f_j (x) f_i)^T has 36 different entries, f_i f_i^T times f_j f_j^T. Two points at
  // a time in separate accumulators, so that the compiler may use vector registers without
  // changing the order of additions.
  double ij[6][6][kGroup] = {};
  double ii[6][kGroup] = {};
  double jj[6][kGroup] = {};
  double w_sum[kGroup] = {};
  const double* fi[3] = {f_i_.col(0).data(), f_i_.col(1).data(), f_i_.col(2).data()};
  const double* fj[3] = {f_j_.col(0).data(), f_j_.col(1).data(), f_j_.col(2).data()};
  const double* w = weights_.data();
  for (int k = 0; k < count_; k += kGroup) {
    double a[6][kGroup], b[6][kGroup];
    for (int q = 0; q < 6; ++q) {
      for (int l = 0; l < kGroup; ++l) {
        a[q][l] = w[k + l] * fi[kRow[q]][k + l] * fi[kCol[q]][k + l];
        b[q][l] = fj[kRow[q]][k + l] * fj[kCol[q]][k + l];
      }
    }
    for (int p = 0; p < 6; ++p) {
      for (int q = 0; q < 6; ++q) {
        for (int l = 0; l < kGroup; ++l) ij[p][q][l] += a[p][l] * b[q][l];
      }
      for (int l = 0; l < kGroup; ++l) ii[p][l] += a[p][l];
      for (int l = 0; l < kGroup; ++l) jj[p][l] += w[k + l] * b[p][l];
    }
    for (int l = 0; l < kGroup; ++l) w_sum[l] += w[k + l];
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

NormalizedEpipolarPair::Elimination NormalizedEpipolarPair::eliminate(
    const Eigen::Matrix3d& R_ci_cj, double baseline_prior) const {
  const Eigen::Matrix3d Rt = R_ci_cj.transpose();
  Eigen::Matrix<double, 9, 3> B;
  // Columns vec(R^T [e_a]x): R^T [e_x]x = (0, r_z, -r_y) and so on, r the columns of R^T.
  B.col(0) << Eigen::Vector3d::Zero(), Rt.col(2), -Rt.col(1);
  B.col(1) << -Rt.col(2), Eigen::Vector3d::Zero(), Rt.col(0);
  B.col(2) << Rt.col(1), -Rt.col(0), Eigen::Vector3d::Zero();
  // Written out: for these sizes Eigen would call its kernel for large matrices, four times slower.
  const Eigen::Matrix<double, 9, 3> SB = sums_.lazyProduct(B);
  const Eigen::Matrix3d M = B.transpose() * SB;
  const Eigen::Matrix3d N =
      2.0 * weight_sum_ * Eigen::Matrix3d::Identity() - sum_ii_ - R_ci_cj * sum_jj_ * Rt;
  const Quotient quotient = minimizeQuotient(M, N);
  Elimination out;
  out.e = quotient.e;
  out.lambda = quotient.lambda;
  out.eNe = out.e.dot(N * out.e);

  // Numerator as in EpipolarPair. Denominator: e^T N e = .. - a^T (sum w f_j f_j^T) a with
  // a = R^T e, which Exp(delta) turns into a + a x delta.
  const Eigen::Matrix3d E = Rt * skew(out.e);
  Eigen::Matrix<double, 9, 3> D;
  // Columns vec(-[e_k]x E): -[e_x]x swaps the last two rows with a sign, and so on.
  for (int c = 0; c < 3; ++c) {
    D.block<3, 1>(3 * c, 0) << 0.0, E(2, c), -E(1, c);
    D.block<3, 1>(3 * c, 1) << -E(2, c), 0.0, E(0, c);
    D.block<3, 1>(3 * c, 2) << E(1, c), -E(0, c), 0.0;
  }
  const Eigen::Matrix<double, 9, 3> SD = sums_.lazyProduct(D);
  const Eigen::Vector3d a = Rt * out.e;
  const Eigen::Vector3d dM = 2.0 * (SD.transpose() * vec(E));
  const Eigen::Vector3d dN = 2.0 * a.cross(sum_jj_ * a);
  out.gradient = (dM - out.lambda * dN) / out.eNe;

  out.T = tangentBasis(out.e);
  out.cross = SD.transpose() * (B * out.T);
  out.DSD = D.transpose() * SD;
  Eigen::Matrix2d Hee = out.T.transpose() * (M - out.lambda * N) * out.T;
  // M - lambda N is positive semidefinite at the minimum, up to rounding.
  Hee.diagonal().array() += baseline_prior * out.eNe + 1e-15 * M.trace();
  out.Hee_inverse = Hee.inverse();
  return out;
}

NormalizedEvaluation NormalizedEpipolarPair::evaluate(const Eigen::Matrix3d& R_ci_cj,
                                                      double baseline_prior) const {
  const Elimination at = eliminate(R_ci_cj, baseline_prior);
  NormalizedEvaluation out;
  out.lambda = at.lambda;
  out.baseline = at.e;
  out.noise = at.eNe / std::max(weight_sum_, 1e-300);
  out.gradient = at.gradient;
  out.hessian = 2.0 / at.eNe * (at.DSD - at.cross * at.Hee_inverse * at.cross.transpose());
  // The noise part that was taken off M is missing from D^T S D; far from the minimum that can
  // leave a negative curvature, which is no use to a descent method.
  if (!(out.hessian.llt().info() == Eigen::Success)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(out.hessian);
    out.hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                  eigen.eigenvectors().transpose();
  }
  return out;
}

void NormalizedEpipolarPair::residuals(const Eigen::Matrix3d& R_ci_cj,
                                       const Eigen::Vector3d& baseline, double sigma,
                                       PointResiduals* out) const {
  // e . m = f_j^T A f_i, its variance sigma^2 (|e x f_i|^2 + |R^T e x f_j|^2).
  const Eigen::Matrix3d A = R_ci_cj.transpose() * skew(baseline);
  const Eigen::Vector3d a = R_ci_cj.transpose() * baseline;
  const auto ix = f_i_.col(0).head(count_), iy = f_i_.col(1).head(count_),
             iz = f_i_.col(2).head(count_);
  const auto jx = f_j_.col(0).head(count_), jy = f_j_.col(1).head(count_),
             jz = f_j_.col(2).head(count_);
  out->noise = (2.0 - (baseline.x() * ix + baseline.y() * iy + baseline.z() * iz).square() -
                (a.x() * jx + a.y() * jy + a.z() * jz).square())
                   .max(kMinNoise);
  out->z2 = (jx * (A(0, 0) * ix + A(0, 1) * iy + A(0, 2) * iz) +
             jy * (A(1, 0) * ix + A(1, 1) * iy + A(1, 2) * iz) +
             jz * (A(2, 0) * ix + A(2, 1) * iy + A(2, 2) * iz))
                .square() /
            (sigma * sigma * out->noise);
}

void NormalizedEpipolarPair::updateWeights(const Eigen::Matrix3d& R_ci_cj,
                                           const Eigen::Vector3d& baseline, double sigma,
                                           double cutoff_sigmas, PointResiduals* scratch) {
  residuals(R_ci_cj, baseline, sigma, scratch);
  const double c2 = cutoff_sigmas * cutoff_sigmas;
  weights_.head(count_) = mask_.head(count_) * (1.0 + scratch->z2 / c2).square().inverse();
  robust_count_ = weights_.head(count_).sum();
  weights_.head(count_) /= scratch->noise;
  sum();
}

Eigen::Vector3d NormalizedEpipolarPair::consensusBaseline(
    const Eigen::Matrix3d& R_ci_cj, double sigma, double truncation_sigmas, int hypotheses,
    unsigned seed, const Eigen::Vector3d& first, double good_enough, ConsensusScratch* scratch,
    double* cost) const {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  *cost = truncation_sigmas * truncation_sigmas * count_;
  if (count_ < 2) return best;
  // Single precision: its rounding, a ten millionth of a radian, is far below any noise, and twice
  // as many numbers fit a register.
  if (scratch->f.rows() < count_) {
    scratch->f.resize(2 * count_, 3);
    scratch->m.resize(2 * count_, 3);
    scratch->z2.resize(2 * count_);
  }
  const Eigen::Matrix3d& R = R_ci_cj;
  for (int k = 0; k < count_; ++k) {
    const double x = f_j_(k, 0), y = f_j_(k, 1), z = f_j_(k, 2);
    const double gx = R(0, 0) * x + R(0, 1) * y + R(0, 2) * z;
    const double gy = R(1, 0) * x + R(1, 1) * y + R(1, 2) * z;
    const double gz = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z;
    scratch->m(k, 0) = static_cast<float>(f_i_(k, 1) * gz - f_i_(k, 2) * gy);
    scratch->m(k, 1) = static_cast<float>(f_i_(k, 2) * gx - f_i_(k, 0) * gz);
    scratch->m(k, 2) = static_cast<float>(f_i_(k, 0) * gy - f_i_(k, 1) * gx);
    for (int c = 0; c < 3; ++c) scratch->f(k, c) = static_cast<float>(f_i_(k, c));
  }
  const auto f = scratch->f.topRows(count_);
  const auto m = scratch->m.topRows(count_);
  const float t2 = static_cast<float>(truncation_sigmas * truncation_sigmas);
  const float inverse = static_cast<float>(1.0 / (2.0 * sigma * sigma));
  const float floor = static_cast<float>(0.5 * kMinNoise);
  const float enough = static_cast<float>(good_enough * count_);
  Sequence sequence(seed);
  float best_cost = std::numeric_limits<float>::max();
  for (int h = -1; h < hypotheses; ++h) {
    Eigen::Vector3f e = first.cast<float>();
    if (h >= 0) {
      const int p = sequence.below(count_);
      const int q = sequence.below(count_);
      e = m.row(p).matrix().transpose().cross(m.row(q).matrix().transpose());
    }
    const float norm = e.norm();
    if (!(norm > 1e-20f)) continue;
    e /= norm;
    // Both views' noise by that of the first: they differ by the parallax only.
    scratch->z2.head(count_) =
        (inverse * (e.x() * m.col(0) + e.y() * m.col(1) + e.z() * m.col(2)).square() /
         (1.0f - (e.x() * f.col(0) + e.y() * f.col(1) + e.z() * f.col(2)).square()).max(floor))
            .min(t2);
    const float sum = scratch->z2.head(count_).sum();
    if (sum < best_cost) {
      best_cost = sum;
      best = e.cast<double>();
    }
    if (h < 0 && best_cost < enough) break;
  }
  if (best.squaredNorm() > 0.0) {
    best.normalize();
    *cost = best_cost;
  }
  return best;
}

void NormalizedEpipolarPair::scatterGradients(const Eigen::Matrix3d& R_ci_cj, double baseline_prior,
                                              double scale, const Eigen::Matrix3d& J,
                                              const std::vector<int>& track,
                                              std::vector<Eigen::Vector3d>* gradients) const {
  const Elimination at = eliminate(R_ci_cj, baseline_prior);
  const Eigen::Matrix3d Rt = R_ci_cj.transpose();
  const Eigen::Vector3d& e = at.e;
  const Eigen::Vector3d a = Rt * e;
  const Eigen::Matrix3d E = Rt * skew(e);
  // 3x3: takes the gradient by the baseline to that by the bias.
  const Eigen::Matrix3d K = J.transpose() * at.cross * at.Hee_inverse * at.T.transpose();
  const double s = scale / at.eNe;
  for (int k = 0; k < count_; ++k) {
    if (weights_[k] == 0.0) continue;
    const Eigen::Vector3d f_i = f_i_.row(k).matrix().transpose();
    const Eigen::Vector3d f_j = f_j_.row(k).matrix().transpose();
    const Eigen::Vector3d u = E * f_i;
    const Eigen::Vector3d g = R_ci_cj * f_j;
    const double r = f_j.dot(u), c_i = e.dot(f_i), c_j = a.dot(f_j);
    const Eigen::Vector3d by_rotation =
        2.0 * r * f_j.cross(u) + 2.0 * at.lambda * c_j * f_j.cross(a);
    const Eigen::Vector3d by_baseline =
        2.0 * r * f_i.cross(g) + 2.0 * at.lambda * (c_i * f_i + c_j * g);
    (*gradients)[track[k]] += s * weights_[k] * (J.transpose() * by_rotation - K * by_baseline);
  }
}

}  // namespace slim_init
