// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/arrow_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "geometry/partial_cholesky.h"

namespace slim_init {

ArrowSolver::ArrowSolver(const StateLayout& layout, bool dense_velocities)
    : layout_(layout), dense_velocities_(dense_velocities) {
  const int n = layout_.n;
  for (int k = n - 1; k >= 1; --k) {
    for (int i = 0; i < 6; ++i) rest_.push_back(layout_.pose(k) + i);
  }
  const int after_poses = dense_velocities_ ? layout_.velocity(0) : layout_.gyroBias();
  for (int i = after_poses; i < layout_.size(); ++i) rest_.push_back(i);
  const int rows = static_cast<int>(rest_.size()) + 1;
  ld_ = rows + rows % 2;
  A_.setZero(ld_, rows);
  x_.setZero(rows);
  if (dense_velocities_) return;
  velocities_.resize(n);
  // The last velocity has no next one; its poses are those of the last two keyframes.
  for (int k = 0; k < n; ++k) velocities_[k].first_row = 6 * (n - 1 - std::min(k + 1, n - 1));
  panels_.setZero(static_cast<Eigen::Index>(3) * n * ld_);
}

void ArrowSolver::copyRest(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double damping) {
  const int m = static_cast<int>(rest_.size());
  for (int j = 0; j < m; ++j) {
    const int from = rest_[j];
    double* column = &A_(0, j);
    for (int i = j; i < m; ++i) column[i] = H(std::max(rest_[i], from), std::min(rest_[i], from));
    column[j] *= 1.0 + damping;
    column[m] = g[from];
  }
  A_(m, m) = 0.0;
}

void ArrowSolver::copyVelocities(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                                 double damping) {
  const int m = static_cast<int>(rest_.size());
  for (int k = 0; k < layout_.n; ++k) {
    Velocity& velocity = velocities_[k];
    const int v = layout_.velocity(k);
    velocity.block = H.block<3, 3>(v, v).selfadjointView<Eigen::Lower>();
    velocity.block.diagonal() *= 1.0 + damping;
    if (k + 1 < layout_.n) velocity.next = H.block<3, 3>(layout_.velocity(k + 1), v);
    for (int c = 0; c < 3; ++c) {
      double* column = panel(k) + c * ld_;
      for (int i = 0; i < m; ++i) {
        column[i] = H(std::max(rest_[i], v + c), std::min(rest_[i], v + c));
      }
      column[m] = g[v + c];
    }
  }
}

bool ArrowSolver::eliminateVelocities() {
  const int rows = static_cast<int>(rest_.size()) + 1;
  for (int k = 0; k < layout_.n; ++k) {
    Velocity& velocity = velocities_[k];
    const Eigen::LLT<Eigen::Matrix3d> llt(velocity.block);
    if (llt.info() != Eigen::Success) return false;
    velocity.block = llt.matrixL();
    const Eigen::Matrix3d& L = velocity.block;
    const int first = velocity.first_row;
    double *u0 = panel(k), *u1 = u0 + ld_, *u2 = u1 + ld_;
    const double i0 = 1.0 / L(0, 0), i1 = 1.0 / L(1, 1), i2 = 1.0 / L(2, 2);
    for (int i = first; i < rows; ++i) {
      u0[i] *= i0;
      u1[i] = (u1[i] - L(1, 0) * u0[i]) * i1;
      u2[i] = (u2[i] - L(2, 0) * u0[i] - L(2, 1) * u1[i]) * i2;
    }
    // `first` is a multiple of six: the alignment of the pairs is kept.
    subtractOuterProduct3(&A_(first, first), ld_, rows - first, u0 + first, ld_);
    if (k + 1 == layout_.n) break;
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(velocity.next);
    const Eigen::Matrix3d& X = velocity.next;
    Velocity& next = velocities_[k + 1];
    next.block.noalias() -= X * X.transpose();
    for (int c = 0; c < 3; ++c) {
      double* column = panel(k + 1) + c * ld_;
      for (int i = first; i < rows; ++i) {
        column[i] -= u0[i] * X(c, 0) + u1[i] * X(c, 1) + u2[i] * X(c, 2);
      }
    }
  }
  return true;
}

bool ArrowSolver::solve(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double damping,
                        Eigen::VectorXd* step) {
  const int m = static_cast<int>(rest_.size());
  copyRest(H, g, damping);
  if (!dense_velocities_) {
    copyVelocities(H, g, damping);
    if (!eliminateVelocities()) return false;
  }
  if (!partialCholesky(A_.data(), ld_, m + 1, m)) return false;
  // The last row is L^-1 of the gradient.
  for (int j = m - 1; j >= 0; --j) {
    const double* column = &A_(0, j);
    double sum = column[m];
    for (int i = j + 1; i < m; ++i) sum -= column[i] * x_[i];
    x_[j] = sum / column[j];
  }
  step->setZero(layout_.size());
  for (int j = 0; j < m; ++j) (*step)[rest_[j]] = -x_[j];
  if (dense_velocities_) return true;
  Eigen::Vector3d next = Eigen::Vector3d::Zero();
  for (int k = layout_.n - 1; k >= 0; --k) {
    const Velocity& velocity = velocities_[k];
    Eigen::Vector3d sum;
    for (int c = 0; c < 3; ++c) {
      const double* column = panel(k) + c * ld_;
      sum[c] = column[m];
      for (int i = velocity.first_row; i < m; ++i) sum[c] -= column[i] * x_[i];
    }
    if (k + 1 < layout_.n) sum -= velocity.next.transpose() * next;
    velocity.block.triangularView<Eigen::Lower>().transpose().solveInPlace(sum);
    next = sum;
    step->segment<3>(layout_.velocity(k)) = -next;
  }
  return true;
}

}  // namespace slim_init
