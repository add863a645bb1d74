// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "prior.h"

#include <algorithm>
#include <cmath>

#include "geometry/dense.h"
#include "geometry/so3.h"

namespace slim_init::backend {
namespace {

// Eigenvalues at unit diagonal below this are rounding: such a direction carries no information.
constexpr double kNoInformation = 1e-10;

BlockPoint presentPoint(BlockKind kind, const Frame& frame) {
  BlockPoint point;
  if (kind == BlockKind::kPose) {
    point.R = frame.rotation();
    point.x = Eigen::VectorXd::Zero(kPoseSize);
    point.x.head<3>() = frame.position();
  } else {
    point.x = frame.motionVector();
  }
  return point;
}

BlockPoint presentPoint(const BlockKey& key, const Frames& frames) {
  return presentPoint(key.kind, *findFrame(frames, key.frame));
}

// The block's parameters at a point, theta counted from the frame's reference.
Eigen::VectorXd parametersAt(const BlockKey& key, const BlockPoint& point, const Frames& frames) {
  Eigen::VectorXd x = point.x;
  if (key.kind == BlockKind::kPose) {
    x.tail<3>() = logSO3(findFrame(frames, key.frame)->R_ref.transpose() * point.R);
  }
  return x;
}

// A = D V S V^T D with unit diagonal inside, the small part of S cut.
struct ScaledEigen {
  explicit ScaledEigen(const Eigen::MatrixXd& A) {
    const Eigen::ArrayXd root = A.diagonal().cwiseMax(0.0).cwiseSqrt();
    scale = (root > 0.0).select(root, 1.0);
    const Eigen::VectorXd inverse = scale.cwiseInverse();
    const Eigen::MatrixXd unit = inverse.asDiagonal() * A * inverse.asDiagonal();
    const SymmetricEigen eigen = symmetricEigen(0.5 * (unit + unit.transpose()));
    values = eigen.values;
    vectors = eigen.vectors;
    floor = kNoInformation * std::max(1.0, values.size() > 0 ? values.maxCoeff() : 1.0);
  }
  // Pseudo-inverse of A.
  Eigen::MatrixXd inverse() const {
    const Eigen::VectorXd s = (values.array() > floor).select(values.cwiseInverse(), 0.0);
    const Eigen::MatrixXd W = scale.cwiseInverse().asDiagonal() * vectors;
    return product(W * s.asDiagonal(), W.transpose());
  }
  Eigen::VectorXd scale, values;
  Eigen::MatrixXd vectors;
  double floor = 0.0;
};

}  // namespace

double* blockData(const BlockKey& key, const Frames& frames) {
  Frame& frame = *findFrame(frames, key.frame);
  return key.kind == BlockKind::kPose ? frame.pose.data() : frame.motion.data();
}

Prior anchorAt(const Frame& frame) {
  // What holds the free position and heading of the window [m], [rad], and the trust in the biases
  // of the seed [rad/s], [m/s^2]: standard deviations.
  constexpr double kPosition = 1e-3, kYaw = 1e-3, kGyroBias = 0.02, kAccelBias = 0.2;
  Prior prior;
  for (const BlockKind kind : {BlockKind::kPose, BlockKind::kMotion}) {
    prior.blocks.push_back({frame.id, kind});
    prior.first.push_back(presentPoint(kind, frame));
  }
  prior.J = Eigen::MatrixXd::Zero(10, kPoseSize + kMotionSize);
  prior.J.topLeftCorner<3, 3>().diagonal().setConstant(1.0 / kPosition);
  // The vertical part, in the world, of a turn in the body.
  prior.J.block<1, 3>(3, 3) = frame.rotation().row(2) / kYaw;
  prior.J.block<3, 3>(4, kPoseSize + 3).diagonal().setConstant(1.0 / kGyroBias);
  prior.J.bottomRightCorner<3, 3>().diagonal().setConstant(1.0 / kAccelBias);
  prior.r0 = Eigen::VectorXd::Zero(10);
  return prior;
}

// ---- the factor
// ----------------------------------------------------------------------------------

PriorCost::PriorCost(const Prior& prior, const Frames& frames) : prior_(prior) {
  for (const BlockKey& key : prior.blocks) {
    block_frames_.push_back(findFrame(frames, key.frame));
    mutable_parameter_block_sizes()->push_back(key.size());
  }
  set_num_residuals(static_cast<int>(prior.r0.size()));
}

bool PriorCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  Eigen::VectorXd dx(prior_.J.cols());
  int column = 0;
  for (std::size_t k = 0; k < prior_.blocks.size(); ++k) {
    const BlockKey& key = prior_.blocks[k];
    const BlockPoint& first = prior_.first[k];
    const Eigen::Map<const Eigen::VectorXd> x(parameters[k], key.size());
    dx.segment(column, key.size()) = x - first.x;
    const bool has_jacobian = jacobians != nullptr && jacobians[k] != nullptr;
    Eigen::MatrixXd J;
    if (has_jacobian) J = prior_.J.middleCols(column, key.size());
    if (key.kind == BlockKind::kPose) {
      const Eigen::Vector3d theta = x.tail<3>();
      const Eigen::Vector3d turn =
          logSO3(first.R.transpose() * block_frames_[k]->R_ref * expSO3(theta));
      dx.segment<3>(column + 3) = turn;
      if (has_jacobian) {
        J.rightCols<3>() = J.rightCols<3>() * (rightJacobianInverse(turn) * rightJacobian(theta));
      }
    }
    if (has_jacobian) {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      Eigen::Map<RowMajor>(jacobians[k], J.rows(), J.cols()) = J;
    }
    column += key.size();
  }
  Eigen::Map<Eigen::VectorXd>(residuals, prior_.r0.size()) = prior_.r0 + prior_.J * dx;
  return true;
}

// ---- making it
// -----------------------------------------------------------------------------------

Marginalization::Marginalization(const Frames& frames, const Prior& prior) : frames_(frames) {
  H_ = product(prior.J.transpose(), prior.J);
  g_ = prior.J.transpose() * prior.r0;
  int column = 0;
  for (std::size_t k = 0; k < prior.blocks.size(); ++k) {
    columns_[prior.blocks[k]] = column;
    first_[prior.blocks[k]] = prior.first[k];
    column += prior.blocks[k].size();
  }
}

int Marginalization::columnsOf(const BlockKey& key) {
  const auto found = columns_.find(key);
  if (found != columns_.end()) return found->second;
  const int column = static_cast<int>(g_.size());
  columns_[key] = column;
  const Eigen::Index size = column + key.size();
  H_.conservativeResize(size, size);
  H_.rightCols(key.size()).setZero();
  H_.bottomRows(key.size()).setZero();
  g_.conservativeResize(size);
  g_.tail(key.size()).setZero();
  return column;
}

Marginalization::Linearized Marginalization::linearize(const ceres::CostFunction& cost,
                                                       const std::vector<BlockKey>& blocks,
                                                       const double* lambda) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int rows = cost.num_residuals();
  std::vector<Eigen::VectorXd> present, at_first;
  std::vector<RowMajor> J;
  for (const BlockKey& key : blocks) {
    const auto found = first_.find(key);
    present.emplace_back(Eigen::Map<const Eigen::VectorXd>(blockData(key, frames_), key.size()));
    at_first.push_back(found == first_.end() ? present.back()
                                             : parametersAt(key, found->second, frames_));
    J.emplace_back(rows, key.size());
  }
  std::vector<const double*> present_data, first_data;
  std::vector<double*> J_data;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    present_data.push_back(present[k].data());
    first_data.push_back(at_first[k].data());
    J_data.push_back(J[k].data());
  }
  Linearized out;
  out.J_lambda.setZero(rows);
  if (lambda != nullptr) {
    present_data.push_back(lambda);
    first_data.push_back(lambda);
    J_data.push_back(out.J_lambda.data());
  }
  out.r_present.resize(rows);
  Eigen::VectorXd r_first(rows);
  if (!cost.Evaluate(present_data.data(), out.r_present.data(), nullptr) ||
      !cost.Evaluate(first_data.data(), r_first.data(), J_data.data())) {
    out.r_present.setZero();  // no residual
    out.r = out.r_present;
    for (const BlockKey& key : blocks) out.J.push_back(Eigen::MatrixXd::Zero(rows, key.size()));
    out.J_lambda.setZero();
    return out;
  }
  out.r = out.r_present;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    Eigen::MatrixXd J_k = J[k];
    if (blocks[k].kind == BlockKind::kPose) {
      const Eigen::Vector3d theta = at_first[k].tail<3>();
      J_k.rightCols<3>() = J_k.rightCols<3>() * rightJacobianInverse(theta);
    }
    // With theta at zero the change from the first attitude is minus its theta.
    out.r -= J_k * (present[k] - at_first[k]);
    out.J.push_back(std::move(J_k));
  }
  return out;
}

void Marginalization::add(const ceres::CostFunction& cost, const std::vector<BlockKey>& blocks) {
  const Linearized factor = linearize(cost, blocks, nullptr);
  std::vector<int> columns;
  for (const BlockKey& key : blocks) columns.push_back(columnsOf(key));
  for (std::size_t a = 0; a < blocks.size(); ++a) {
    g_.segment(columns[a], blocks[a].size()) += factor.J[a].transpose() * factor.r;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      H_.block(columns[a], columns[b], blocks[a].size(), blocks[b].size()) +=
          factor.J[a].transpose() * factor.J[b];
    }
  }
}

void Marginalization::addPoint(const std::vector<PointView>& views, double inverse_distance,
                               const ceres::LossFunction& loss) {
  for (const PointView& view : views) {
    columnsOf(view.host);
    columnsOf(view.target);
  }
  Eigen::VectorXd h = Eigen::VectorXd::Zero(g_.size());
  double h_point = 0.0, g_point = 0.0;
  for (const PointView& view : views) {
    const BlockKey blocks[] = {view.host, view.target};
    Linearized factor = linearize(*view.cost, {view.host, view.target}, &inverse_distance);
    double rho[3];
    loss.Evaluate(factor.r_present.squaredNorm(), rho);
    const double w = rho[1];
    for (int a = 0; a < 2; ++a) {
      const int column = columns_[blocks[a]];
      g_.segment<kPoseSize>(column) += w * factor.J[a].transpose() * factor.r;
      h.segment<kPoseSize>(column) += w * factor.J[a].transpose() * factor.J_lambda;
      for (int b = 0; b < 2; ++b) {
        H_.block<kPoseSize, kPoseSize>(column, columns_[blocks[b]]) +=
            w * factor.J[a].transpose() * factor.J[b];
      }
    }
    h_point += w * factor.J_lambda.squaredNorm();
    g_point += w * factor.J_lambda.dot(factor.r);
  }
  // A point without any parallax has no information on its distance; eliminating it removes none.
  if (!(h_point > 0.0)) return;
  H_.noalias() -= h * (h.transpose() / h_point);
  g_ -= h * (g_point / h_point);
}

Prior Marginalization::eliminate(const std::set<BlockKey>& gone) const {
  std::vector<int> columns, out_columns;  // those that stay, those that go
  Prior prior;
  for (const auto& [key, column] : columns_) {
    const bool goes = gone.count(key) > 0;
    for (int k = 0; k < key.size(); ++k) (goes ? out_columns : columns).push_back(column + k);
    if (goes) continue;
    prior.blocks.push_back(key);
    const auto found = first_.find(key);
    prior.first.push_back(found != first_.end() ? found->second : presentPoint(key, frames_));
  }
  const auto m = static_cast<Eigen::Index>(out_columns.size());
  const auto n = static_cast<Eigen::Index>(columns.size());
  columns.insert(columns.end(), out_columns.begin(), out_columns.end());
  const Eigen::PermutationMatrix<Eigen::Dynamic> order(
      Eigen::Map<const Eigen::VectorXi>(columns.data(), n + m));
  const Eigen::MatrixXd H = order.transpose() * H_ * order;
  const Eigen::VectorXd g = order.transpose() * g_;
  Eigen::MatrixXd H_nn = H.topLeftCorner(n, n);
  Eigen::VectorXd g_n = g.head(n);
  if (m > 0) {
    const Eigen::MatrixXd H_nm = H.topRightCorner(n, m);
    const Eigen::MatrixXd gain = product(H_nm, ScaledEigen(H.bottomRightCorner(m, m)).inverse());
    H_nn -= product(gain, H_nm.transpose());
    g_n -= gain * g.tail(m);
  }
  if (n == 0) return prior;

  // J^T J = H_nn, J^T r0 = g_n.
  const ScaledEigen eigen(H_nn);
  prior.lowest_eigenvalue = eigen.values.minCoeff() / std::max(eigen.values.maxCoeff(), 1e-300);
  const Eigen::Index rank = (eigen.values.array() > eigen.floor).count();
  prior.J.resize(rank, n);
  prior.r0.resize(rank);
  const Eigen::VectorXd scaled_g = eigen.scale.cwiseInverse().asDiagonal() * g_n;
  // Ascending: those above the floor come last.
  for (Eigen::Index k = 0; k < rank; ++k) {
    const Eigen::Index from = n - rank + k;
    const double root = std::sqrt(eigen.values[from]);
    prior.J.row(k) = root * eigen.vectors.col(from).cwiseProduct(eigen.scale).transpose();
    prior.r0[k] = eigen.vectors.col(from).dot(scaled_g) / root;
  }
  return prior;
}

}  // namespace slim_init::backend
