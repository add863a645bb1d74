// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/normalized_epipolar_pair.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

Vector9d vec(const Eigen::Matrix3d& B) { return Eigen::Map<const Vector9d>(B.data()); }

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
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (A + A.transpose()));
  Quotient out;
  out.e = (Li.transpose() * solver.eigenvectors().col(0)).normalized();
  out.lambda = out.e.dot(M * out.e) / out.e.dot(N * out.e);
  return out;
}

}  // namespace

void NormalizedEpipolarPair::add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j) {
  f_i_.push_back(f_i);
  f_j_.push_back(f_j);
}

void NormalizedEpipolarPair::resetWeights() {
  weights_.assign(f_i_.size(), 1.0);
  sum();
}

void NormalizedEpipolarPair::sum() {
  sums_.setZero();
  sum_ii_.setZero();
  sum_jj_.setZero();
  weight_sum_ = 0.0;
  for (std::size_t k = 0; k < f_i_.size(); ++k) {
    const double w = weights_[k];
    const Eigen::Matrix3d outer = f_j_[k] * f_i_[k].transpose();
    const Vector9d u = vec(outer);
    const Vector9d wu = w * u;
    sums_.noalias() += wu * u.transpose();
    sum_ii_.noalias() += (w * f_i_[k]) * f_i_[k].transpose();
    sum_jj_.noalias() += (w * f_j_[k]) * f_j_[k].transpose();
    weight_sum_ += w;
  }
}

NormalizedEvaluation NormalizedEpipolarPair::evaluate(const Eigen::Matrix3d& R_ci_cj,
                                                      double baseline_prior) const {
  Eigen::Matrix<double, 9, 3> B;
  for (int a = 0; a < 3; ++a) {
    B.col(a) = vec(R_ci_cj.transpose() * skew(Eigen::Vector3d::Unit(a)));
  }
  const Eigen::Matrix<double, 9, 3> SB = sums_ * B;
  const Eigen::Matrix3d M = B.transpose() * SB;
  const Eigen::Matrix3d N = 2.0 * weight_sum_ * Eigen::Matrix3d::Identity() - sum_ii_ -
                            R_ci_cj * sum_jj_ * R_ci_cj.transpose();
  const Quotient quotient = minimizeQuotient(M, N);
  const Eigen::Vector3d& e = quotient.e;
  const double eNe = e.dot(N * e);

  NormalizedEvaluation out;
  out.lambda = quotient.lambda;
  out.baseline = e;
  out.noise = eNe / std::max(weight_sum_, 1e-300);

  // Numerator as in EpipolarPair. Denominator: e^T N e = .. - a^T (sum w f_j f_j^T) a with
  // a = R^T e, which Exp(delta) turns into a + a x delta.
  const Eigen::Matrix3d E = R_ci_cj.transpose() * skew(e);
  Eigen::Matrix<double, 9, 3> D;
  for (int k = 0; k < 3; ++k) D.col(k) = vec(-skew(Eigen::Vector3d::Unit(k)) * E);
  const Eigen::Matrix<double, 9, 3> SD = sums_ * D;
  const Eigen::Vector3d a = R_ci_cj.transpose() * e;
  const Eigen::Vector3d dM = 2.0 * (SD.transpose() * (B * e));
  const Eigen::Vector3d dN = 2.0 * a.cross(sum_jj_ * a);
  out.gradient = (dM - out.lambda * dN) / eNe;

  const Eigen::Matrix<double, 3, 2> T = tangentBasis(e);
  const Eigen::Matrix<double, 3, 2> cross = SD.transpose() * (B * T);
  Eigen::Matrix2d Hee = T.transpose() * (M - out.lambda * N) * T;
  // M - lambda N is positive semidefinite at the minimum, up to rounding.
  Hee.diagonal().array() += baseline_prior * weight_sum_ * out.noise + 1e-15 * M.trace();
  out.hessian = 2.0 / eNe * (D.transpose() * SD - cross * Hee.inverse() * cross.transpose());
  // The noise part that was taken off M is missing from D^T S D; far from the minimum that can
  // leave a negative curvature, which is no use to a descent method.
  if (!(out.hessian.llt().info() == Eigen::Success)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(out.hessian);
    out.hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                  eigen.eigenvectors().transpose();
  }
  return out;
}

void NormalizedEpipolarPair::residualsInto(const Eigen::Matrix3d& R_ci_cj, double sigma,
                                           std::vector<double>* z) const {
  const NormalizedEvaluation at = evaluate(R_ci_cj, 0.0);
  z->resize(f_i_.size());
  const double scale = 1.0 / (sigma * std::sqrt(std::max(at.noise, 1e-300)));
  const Eigen::Matrix3d A = R_ci_cj.transpose() * skew(at.baseline);  // e . m = f_j^T A f_i
  for (std::size_t k = 0; k < f_i_.size(); ++k) (*z)[k] = f_j_[k].dot(A * f_i_[k]) * scale;
}

std::vector<double> NormalizedEpipolarPair::residuals(const Eigen::Matrix3d& R_ci_cj,
                                                      double sigma) const {
  std::vector<double> z;
  residualsInto(R_ci_cj, sigma, &z);
  return z;
}

void NormalizedEpipolarPair::updateWeights(const Eigen::Matrix3d& R_ci_cj, double sigma,
                                           double cauchy_sigmas) {
  std::vector<double> z;
  residualsInto(R_ci_cj, sigma, &z);
  for (std::size_t k = 0; k < z.size(); ++k) {
    const double r = z[k] / cauchy_sigmas;
    weights_[k] = 1.0 / (1.0 + r * r);
  }
  sum();
}

}  // namespace slim_init
