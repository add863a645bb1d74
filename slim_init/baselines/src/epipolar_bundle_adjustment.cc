// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "epipolar_bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/inertial_factor.h"

namespace slim_init::baselines {
namespace {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

constexpr double kFirstDamping = 1e-4;
constexpr double kLargestDamping = 1e10;
// Standard deviation of b_a about zero [m/s^2]. Seconds of flight hardly tell b_a from a tilt of
// gravity: without a prior gravity turns by 10 deg rms on recorded windows (docs/baselines.md). 0.1
// is the size of a MEMS accelerometer's turn-on bias, and what OpenVINS' release and our refinement
// (InertialOptions::accel_bias_prior) take; it allows a tilt of 0.6 deg.
constexpr double kAccelBiasPrior = 0.1;
constexpr double kShortestBaseline = 1e-8;  // [m] of which no direction can be had

// Common points of keyframes i < j as bearings in their bodies.
struct KeyframePair {
  int i = 0, j = 0;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> bearings;
};

// Normal equations of the whole error vector; H is the lower triangle.
struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double cost = 0.0;
};

// What an evaluation needs of two poses; the rest is the same for all their points.
struct Baseline {
  Baseline(const WindowState& state, int i, int j, const Eigen::Vector3d& lever)
      : R_i(state.R_b0_bk[i]), R_j(state.R_b0_bk[j]), t_b_c(lever) {
    const Eigen::Vector3d t = state.p_b0.col(i) + R_i * t_b_c - state.p_b0.col(j) - R_j * t_b_c;
    length = t.norm();
    C = t / length;
  }
  bool valid() const { return length > kShortestBaseline; }

  // Coplanarity of a point's rays in keyframes i and j with the baseline, without depth, and its
  // derivatives by [theta_i, p_i, theta_j, p_j].
  //   r = (R_j f_j) . (C x R_i f_i),  C = (c_i - c_j) / |c_i - c_j|,  c = p + R t_b_c,
  double residual(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j,
                  Eigen::Matrix<double, 1, 12>* J) const {
    const Eigen::Vector3d B = R_i * f_i;
    const Eigen::Vector3d A = R_j * f_j;
    const Eigen::Vector3d m = B.cross(A);
    const double r = C.dot(m);
    // d r / d t, with which both centres move.
    const Eigen::Vector3d n = (m - r * C) / length;
    const Eigen::Vector3d n_i = R_i.transpose() * n, n_j = R_j.transpose() * n;
    J->segment<3>(0) = f_i.cross(R_i.transpose() * A.cross(C)) + t_b_c.cross(n_i);
    J->segment<3>(3) = n;
    J->segment<3>(6) = f_j.cross(R_j.transpose() * C.cross(B)) - t_b_c.cross(n_j);
    J->segment<3>(9) = -n;
    return r;
  }

  Eigen::Matrix3d R_i, R_j;
  Eigen::Vector3d t_b_c, C;
  double length;
};

class EpipolarProblem {
 public:
  EpipolarProblem(const InitWindow& window, const std::vector<Preintegration>& pre,
                  const DrtViBaOptions& options)
      : pre_(pre), layout_(window.size()), t_b_c_(window.calibration().t_b_c) {
    sqrt_information_ = window.calibration().focal_px / options.sigma_px;
    huber_ = options.huber_sigmas;
    const int n = window.size();
    pairs_.resize(n * n);
    const Eigen::Matrix3d& R_b_c = window.calibration().R_b_c;
    const std::vector<WindowPoint>& observations = window.pointObservations();
    for (const Track& track : window.pointTracks()) {
      for (int a = track.begin; a < track.end; ++a) {
        for (int b = a + 1; b < track.end; ++b) {
          KeyframePair& pair = pairs_[observations[a].keyframe * n + observations[b].keyframe];
          pair.i = observations[a].keyframe;
          pair.j = observations[b].keyframe;
          pair.bearings.emplace_back(R_b_c * observations[a].bearing,
                                     R_b_c * observations[b].bearing);
          ++residuals_;
        }
      }
    }
    whitening_.resize(pre.size());
    for (std::size_t i = 0; i < pre.size(); ++i) {
      valid_ = inertialWhitening(pre[i], &whitening_[i]) && valid_;
    }
  }

  bool valid() const { return valid_; }
  int residuals() const { return residuals_; }

  NormalEquations linearize(const WindowState& state) const {
    NormalEquations out;
    out.H = Eigen::MatrixXd::Zero(layout_.size(), layout_.size());
    out.g = Eigen::VectorXd::Zero(layout_.size());
    for (std::size_t i = 0; i < pre_.size(); ++i) addInertial(state, static_cast<int>(i), &out);
    for (const KeyframePair& pair : pairs_) addPair(state, pair, &out);
    constexpr double kInformation = 1.0 / (kAccelBiasPrior * kAccelBiasPrior);
    out.cost += kInformation * state.accel_bias.squaredNorm();
    out.g.segment<3>(layout_.accelBias()) += kInformation * state.accel_bias;
    out.H.diagonal().segment<3>(layout_.accelBias()).array() += kInformation;
    return out;
  }

 private:
  void addInertial(const WindowState& state, int i, NormalEquations* out) const {
    InertialResidual factor = inertialResidual(state, i, pre_[i]);
    factor.r = whitening_[i] * factor.r;
    factor.J = whitening_[i] * factor.J;
    out->cost += factor.r.squaredNorm();
    // Columns of the factor in the error vector: {first column, where it goes, how many}.
    const int blocks[][3] = {{0, layout_.pose(i), 12},
                             {12, layout_.velocity(i), 6},
                             {18, layout_.gyroBias(), 3},
                             {21, layout_.accelBias(), 3},
                             {24, layout_.gravity(), 2}};
    for (const auto& row : blocks) {
      const auto J_row = factor.J.middleCols(row[0], row[2]);
      out->g.segment(row[1], row[2]) += J_row.transpose() * factor.r;
      for (const auto& column : blocks) {
        if (column[1] > row[1]) continue;
        out->H.block(row[1], column[1], row[2], column[2]) +=
            J_row.transpose() * factor.J.middleCols(column[0], column[2]);
      }
    }
  }

  void addPair(const WindowState& state, const KeyframePair& pair, NormalEquations* out) const {
    if (pair.bearings.empty()) return;
    const Baseline baseline(state, pair.i, pair.j, t_b_c_);
    if (!baseline.valid()) return;
    Matrix12d H = Matrix12d::Zero();
    Vector12d g = Vector12d::Zero();
    for (const auto& [f_i, f_j] : pair.bearings) {
      Eigen::Matrix<double, 1, 12> J;
      const double r = sqrt_information_ * baseline.residual(f_i, f_j, &J);
      J *= sqrt_information_;
      const double weight = std::abs(r) <= huber_ ? 1.0 : huber_ / std::abs(r);
      out->cost += std::abs(r) <= huber_ ? r * r : huber_ * (2.0 * std::abs(r) - huber_);
      H.noalias() += weight * J.transpose() * J;
      g.noalias() += weight * r * J.transpose();
    }
    const int i = layout_.pose(pair.i), j = layout_.pose(pair.j);
    out->H.block<6, 6>(i, i) += H.topLeftCorner<6, 6>();
    out->H.block<6, 6>(j, i) += H.bottomLeftCorner<6, 6>();
    out->H.block<6, 6>(j, j) += H.bottomRightCorner<6, 6>();
    out->g.segment<6>(i) += g.head<6>();
    out->g.segment<6>(j) += g.tail<6>();
  }

  const std::vector<Preintegration>& pre_;
  StateLayout layout_;
  Eigen::Vector3d t_b_c_;
  double sqrt_information_ = 1.0;  // [1/rad]
  double huber_ = 1.0;
  std::vector<KeyframePair> pairs_;
  std::vector<Eigen::Matrix<double, 9, 9>> whitening_;
  int residuals_ = 0;
  bool valid_ = true;
};

}  // namespace

EpipolarAdjustment adjustEpipolar(const InitWindow& window, const std::vector<Preintegration>& pre,
                                  const DrtViBaOptions& options, WindowState* state) {
  EpipolarAdjustment out;
  const EpipolarProblem problem(window, pre, options);
  out.residuals = problem.residuals();
  if (!problem.valid()) return out;

  const int size = StateLayout(window.size()).size();
  const int m = size - StateLayout::kGauge;
  NormalEquations at = problem.linearize(*state);
  out.first_cost = at.cost;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(size);
  // Not minimizeLevenbergMarquardt(): states on a manifold, a gauge left out, and an end by the
  // decrease that a step brought, not by the one expected of the next.
  double damping = kFirstDamping;
  while (out.iterations < options.max_iterations && !out.converged && damping < kLargestDamping) {
    Eigen::MatrixXd A = at.H.bottomRightCorner(m, m);
    A.diagonal() *= 1.0 + damping;
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(A);
    if (llt.info() != Eigen::Success) {
      damping *= 10.0;
      continue;
    }
    step.tail(m) = -llt.solve(at.g.tail(m));
    const WindowState candidate = retract(*state, step);
    NormalEquations there = problem.linearize(candidate);
    if (std::isfinite(there.cost) && there.cost <= at.cost) {
      out.converged = at.cost - there.cost <= options.tolerance * at.cost;
      *state = candidate;
      std::swap(at, there);
      damping = std::max(0.1 * damping, 1e-12);
      ++out.iterations;
    } else {
      damping *= 10.0;
    }
  }
  out.cost = at.cost;
  out.information = at.H.bottomRightCorner(m, m).selfadjointView<Eigen::Lower>();
  out.valid = std::isfinite(out.cost) && out.information.allFinite();
  return out;
}

}  // namespace slim_init::baselines
