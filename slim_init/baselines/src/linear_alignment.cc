// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "linear_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/dense.h"
#include "geometry/so3.h"
#include "scale/gravity_constrained.h"

namespace slim_init::baselines {
namespace {

// Rows over the unknowns of one pair [v_i, v_j, s, g].
constexpr int kVi = 0, kVj = 3, kScale = 6, kGravity = 7, kLocal = 10;

// Position residual r^p of a pair in b0 as 3 rows: J x_local - y.
//   s (c_j - c_i) - v_i dt - g dt^2/2 = R_i dp + (R_j - R_i) t_b_c
struct PositionRows {
  Eigen::Matrix<double, 3, kLocal> J = Eigen::Matrix<double, 3, kLocal>::Zero();
  Eigen::Vector3d y;
};

PositionRows positionRows(const AlignmentProblem& problem, int i) {
  const Preintegration& pre = problem.pre[i];
  PositionRows rows;
  rows.J.block<3, 3>(0, kVi).diagonal().setConstant(-pre.dt);
  rows.J.col(kScale) = problem.centres_b0.col(i + 1) - problem.centres_b0.col(i);
  rows.J.block<3, 3>(0, kGravity).diagonal().setConstant(-0.5 * pre.dt * pre.dt);
  rows.y = problem.R_b0_bk[i] * pre.dp +
           (problem.R_b0_bk[i + 1] - problem.R_b0_bk[i]) * problem.window.calibration().t_b_c;
  return rows;
}

// Adds weight * |J x - y|^2 of one pair to the system.
template <int kRows>
void addRows(const Eigen::Matrix<double, kRows, kLocal>& J,
             const Eigen::Matrix<double, kRows, 1>& y, double weight, int i, int keyframes,
             AlignmentSystem& system) {
  const Eigen::Matrix<double, kLocal, kLocal> H = weight * J.transpose() * J;
  const Eigen::Matrix<double, kLocal, 1> b = weight * J.transpose() * y;
  const int v = 3 * i;
  const int s = 3 * keyframes;
  system.H.block<6, 6>(v, v) += H.topLeftCorner<6, 6>();
  system.H.block<4, 6>(s, v) += H.bottomLeftCorner<4, 6>();
  system.H.block<4, 4>(s, s) += H.bottomRightCorner<4, 4>();
  system.b.segment<6>(v) += b.head<6>();
  system.b.segment<4>(s) += b.tail<4>();
  system.c += weight * y.squaredNorm();
}

}  // namespace

double lineEpipolarResidual(const Eigen::Vector3d& n_i, const Eigen::Vector3d& n_j,
                            const Eigen::Matrix3d& R_ci_cj, const Eigen::Vector3d& t_ci_cj) {
  return n_i.dot(t_ci_cj.cross(R_ci_cj * n_j));
}

AlignmentSystem buildBaseRows(const AlignmentProblem& problem) {
  const int n = problem.window.size();
  AlignmentSystem system;
  system.H = Eigen::MatrixXd::Zero(3 * n + 4, 3 * n + 4);
  system.b = Eigen::VectorXd::Zero(3 * n + 4);
  for (int i = 0; i + 1 < n; ++i) {
    const PositionRows position = positionRows(problem, i);
    addRows<3>(position.J, position.y, 1.0, i, n, system);
    // Velocity rows: v_j - v_i - g dt = R_i dv.
    Eigen::Matrix<double, 3, kLocal> J = Eigen::Matrix<double, 3, kLocal>::Zero();
    J.block<3, 3>(0, kVi).diagonal().setConstant(-1.0);
    J.block<3, 3>(0, kVj).diagonal().setConstant(1.0);
    J.block<3, 3>(0, kGravity).diagonal().setConstant(-problem.pre[i].dt);
    addRows<3>(J, problem.R_b0_bk[i] * problem.pre[i].dv, 1.0, i, n, system);
  }
  return system;
}

void addLineRows(const AlignmentProblem& problem, AlignmentSystem* system) {
  const LineTerms& terms = problem.line_terms;
  if (terms.lines == nullptr) return;
  const int n = problem.window.size();
  const Eigen::Matrix3d& R_b_c = problem.window.calibration().R_b_c;
  const std::vector<WindowLine>& lines = problem.window.lineObservations();
  for (int i = 0; i + 1 < n; ++i) {
    const PairLines& pair = (*terms.lines)[i];
    if (terms.use_epipolar) {
      // Eq. (11) with t = s R_ci_b0 (c_j - c_i): the scale is its only unknown.
      const Eigen::Matrix3d R_ci_b0 = (problem.R_b0_bk[i] * R_b_c).transpose();
      const Eigen::Matrix3d R_ci_cj = R_ci_b0 * problem.R_b0_bk[i + 1] * R_b_c;
      const Eigen::Vector3d t_ci_cj =
          R_ci_b0 * (problem.centres_b0.col(i + 1) - problem.centres_b0.col(i));
      for (const WeightedLine& line : pair.epipolar) {
        const double a = lineEpipolarResidual(lines[line.observation_i].normal,
                                              lines[line.observation_j].normal, R_ci_cj, t_ci_cj);
        system->H(3 * n, 3 * n) += terms.epipolar_weight * line.weight * a * a;
      }
    }
    if (terms.use_normal) {
      // Eq. (12): the normal in the body frame is R_b_c n, r^p in b_i is R_i^T r^p.
      const PositionRows position = positionRows(problem, i);
      for (const WeightedLine& line : pair.normal) {
        const Eigen::RowVector3d n_b0 =
            (problem.R_b0_bk[i] * R_b_c * lines[line.observation_i].normal).transpose();
        addRows<1>(n_b0 * position.J, Eigen::Matrix<double, 1, 1>(n_b0 * position.y),
                   terms.normal_weight * line.weight, i, n, *system);
      }
    }
  }
}

AlignmentEstimate alignLinear(const AlignmentProblem& problem) {
  const int n = problem.window.size();
  AlignmentEstimate estimate;
  const AlignmentSystem base = buildBaseRows(problem);
  AlignmentSystem system = base;
  addLineRows(problem, &system);
  Eigen::VectorXd x;
  const double G = problem.window.calibration().gravity_magnitude;
  if (!solveGravityConstrained(system.H, system.b, G, &x)) return estimate;

  estimate.scale = x[3 * n];
  estimate.gravity_b0 = x.tail<3>();
  estimate.velocities_b0 = Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, n);
  estimate.positions_b0.resize(3, n);
  const Eigen::Vector3d& t_b_c = problem.window.calibration().t_b_c;
  for (int k = 0; k < n; ++k) {
    estimate.positions_b0.col(k) =
        estimate.scale * problem.centres_b0.col(k) - problem.R_b0_bk[k] * t_b_c;
  }
  const Eigen::Vector3d origin = estimate.positions_b0.col(0);
  estimate.positions_b0.colwise() -= origin;

  // Residual and covariance come from the position and velocity rows alone, so that they mean the
  // same with and without line terms (eq. (12) repeats rows, it does not measure anew). On the
  // constraint surface gravity moves in its tangent plane only.
  const Eigen::MatrixXd H = base.H.selfadjointView<Eigen::Lower>();
  const double cost = std::max(x.dot(H * x) - 2.0 * base.b.dot(x) + base.c, 0.0);
  const int rows = 6 * (n - 1);
  const int unknowns = 3 * n + 3;
  estimate.residual_rms = std::sqrt(cost / rows);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(3 * n + 4, unknowns);
  T.topLeftCorner(3 * n + 1, 3 * n + 1).setIdentity();
  T.bottomRightCorner<3, 2>() = G * tangentBasis(estimate.gravity_b0.normalized());
  const Eigen::LDLT<Eigen::MatrixXd> information(propagated(T.transpose(), H));
  if (rows > unknowns && information.info() == Eigen::Success) {
    const double variance =
        cost / (rows - unknowns) * information.solve(Eigen::VectorXd::Unit(unknowns, 3 * n))[3 * n];
    estimate.scale_sigma = std::sqrt(std::max(variance, 0.0)) / std::abs(estimate.scale);
  }
  estimate.valid = true;
  return estimate;
}

}  // namespace slim_init::baselines
