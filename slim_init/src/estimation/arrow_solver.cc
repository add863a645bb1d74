// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/arrow_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "geometry/dense.h"

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
  A_.setZero(rows, rows);
  if (dense_velocities_) return;
  velocities_.resize(n);
  // The last velocity has no next one; its poses are those of the last two keyframes.
  for (int k = 0; k < n; ++k) velocities_[k].first_row = 6 * (n - 1 - std::min(k + 1, n - 1));
  panels_.setZero(rows, 3 * n);
}

void ArrowSolver::copyRest(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double damping) {
  const int m = static_cast<int>(rest_.size());
  for (int j = 0; j < m; ++j) {
    const int from = rest_[j];
    for (int i = j; i < m; ++i) A_(i, j) = H(std::max(rest_[i], from), std::min(rest_[i], from));
    A_(j, j) *= 1.0 + damping;
    A_(m, j) = g[from];
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
      auto column = panels_.col(3 * k + c);
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
    const int first = velocity.first_row, left = rows - first;
    auto panel = panels_.block<Eigen::Dynamic, 3>(first, 3 * k, left, 3);
    panel.col(0) /= L(0, 0);
    panel.col(1) = (panel.col(1) - L(1, 0) * panel.col(0)) / L(1, 1);
    panel.col(2) = (panel.col(2) - L(2, 0) * panel.col(0) - L(2, 1) * panel.col(1)) / L(2, 2);
    // Three columns: Eigen's kernel for large matrices would spend more on packing them.
    for (int j = 0; j < left; ++j) {
      A_.col(first + j).tail(left - j) -=
          panel.bottomRows(left - j).lazyProduct(panel.row(j).transpose());
    }
    if (k + 1 == layout_.n) break;
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(velocity.next);
    const Eigen::Matrix3d& X = velocity.next;
    velocities_[k + 1].block.noalias() -= X * X.transpose();
    panels_.block<Eigen::Dynamic, 3>(first, 3 * (k + 1), left, 3) -=
        panel.lazyProduct(X.transpose());
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
  if (!eliminateFirst(A_, m)) return false;
  // The last row is L^-1 of the gradient.
  Eigen::VectorXd x = A_.row(m).head(m);
  A_.topLeftCorner(m, m).triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  step->setZero(layout_.size());
  for (int j = 0; j < m; ++j) (*step)[rest_[j]] = -x[j];
  if (dense_velocities_) return true;
  Eigen::Vector3d next = Eigen::Vector3d::Zero();
  for (int k = layout_.n - 1; k >= 0; --k) {
    const Velocity& velocity = velocities_[k];
    const auto panel = panels_.middleCols<3>(3 * k);
    const int first = velocity.first_row;
    Eigen::Vector3d sum = panel.row(m);
    sum -= panel.middleRows(first, m - first).transpose() * x.tail(m - first);
    if (k + 1 < layout_.n) sum -= velocity.next.transpose() * next;
    velocity.block.triangularView<Eigen::Lower>().transpose().solveInPlace(sum);
    next = sum;
    step->segment<3>(layout_.velocity(k)) = -next;
  }
  return true;
}

}  // namespace slim_init
