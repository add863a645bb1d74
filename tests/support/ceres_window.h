// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The refinement of a window in Ceres, as a reference: landmarks are parameters there, and
// eliminated in ours. Ceres minimises half of the cost.
#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "estimation/inertial_factor.h"
#include "estimation/visual_tracks.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "slim_init/options.h"

namespace slim_init {

/// Rotations by a rotation vector on the right of the start, so that no manifold is needed; Ceres
/// 1.14 and 2.1 name it differently.
struct RotationStart {
  Eigen::Matrix3d R;
  template <typename T>
  Eigen::Matrix<T, 3, 3> at(const T* w) const {
    Eigen::Matrix<T, 3, 3> E;
    ceres::AngleAxisToRotationMatrix(w, E.data());  // column-major, as Eigen
    return R.cast<T>() * E;
  }
};

/// Residual of a view of a point by rotation vector, position and point.
struct CeresPoint {
  PointView view;
  RotationStart start;
  Eigen::Vector3d t_b_c;
  double sqrt_information;
  template <typename T>
  bool operator()(const T* w, const T* p, const T* X, T* r) const {
    using V = Eigen::Matrix<T, 3, 1>;
    const V y =
        start.at(w).transpose() * (V(X[0], X[1], X[2]) - V(p[0], p[1], p[2])) - t_b_c.cast<T>();
    const V u = y / y.norm();
    Eigen::Map<Eigen::Matrix<T, 2, 1>> out(r);
    out = T(sqrt_information) * (view.tangent_b.cast<T>() * u);
    return true;
  }
};

/// Whitened inertial residual of two keyframes.
struct CeresInertial {
  const Preintegration* pre;
  Eigen::Matrix<double, 9, 9> W;
  RotationStart start_i, start_j;
  double G;
  bool operator()(const double* const* x, double* r) const {
    using V = Eigen::Map<const Eigen::Vector3d>;
    WindowState state;
    state.R_b0_bk = {start_i.at(x[0]), start_j.at(x[3])};
    state.p_b0.resize(3, 2);
    state.v_b0.resize(3, 2);
    state.p_b0 << V(x[1]), V(x[4]);
    state.v_b0 << V(x[2]), V(x[5]);
    state.gyro_bias = V(x[6]);
    state.accel_bias = V(x[7]);
    // Only the direction counts; the length is kept by a residual of its own.
    state.gravity_b0 = G * V(x[8]).normalized();
    Eigen::Map<Eigen::Matrix<double, 9, 1>> out(r);
    out = W * inertialResidual(state, 0, *pre).r;
    return true;
  }
};

/// A prior about zero.
struct CeresPrior {
  double sigma;
  template <typename T>
  bool operator()(const T* x, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = x[i] / T(sigma);
    return true;
  }
};

/// Keeps the length of a direction at one.
struct CeresUnitLength {
  template <typename T>
  bool operator()(const T* x, T* r) const {
    r[0] = T(1e3) * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - T(1.0));
    return true;
  }
};

/// Parameters and inertial side of a window; the first pose is held.
struct CeresWindow {
  /// `pre` outlives it.
  CeresWindow(const WindowState& start, const std::vector<Preintegration>& pre,
              double gravity_magnitude, const InertialOptions& inertial, bool gaussian = false)
      : w(start.size(), Eigen::Vector3d::Zero()),
        bg(start.gyro_bias),
        ba(start.accel_bias),
        g(start.gravity_b0.normalized()) {
    for (int k = 0; k < start.size(); ++k) {
      starts.push_back({start.R_b0_bk[k]});
      p.push_back(start.p_b0.col(k));
      v.push_back(start.v_b0.col(k));
    }
    for (int k = 0; k + 1 < start.size(); ++k) {
      auto* functor = new CeresInertial{&pre[k], {}, starts[k], starts[k + 1], gravity_magnitude};
      EXPECT_TRUE(inertialWhitening(pre[k], &functor->W));
      addNumeric(functor, 9,
                 {w[k].data(), p[k].data(), v[k].data(), w[k + 1].data(), p[k + 1].data(),
                  v[k + 1].data(), bg.data(), ba.data(), g.data()});
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<CeresUnitLength, 1, 3>(new CeresUnitLength), nullptr,
        g.data());
    const auto addPrior = [this](double sigma, ceres::LossFunction* loss, double* bias) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CeresPrior, 3, 3>(new CeresPrior{sigma}), loss, bias);
    };
    // Student's t with two degrees of freedom and three components.
    ceres::LossFunction* const tail = gaussian ? nullptr : new ceres::CauchyLoss(std::sqrt(5.0));
    addPrior(inertial.accel_bias_prior, tail, ba.data());
    addPrior(inertial.gyro_bias_prior, nullptr, bg.data());
  }

  /// `rows` residuals of blocks of three parameters, differentiated numerically.
  template <typename Functor>
  void addNumeric(Functor* functor, int rows, const std::vector<double*>& blocks) {
    auto* factor = new ceres::DynamicNumericDiffCostFunction<Functor, ceres::CENTRAL>(functor);
    for (std::size_t i = 0; i < blocks.size(); ++i) factor->AddParameterBlock(3);
    factor->SetNumResiduals(rows);
    problem.AddResidualBlock(factor, nullptr, blocks);
  }

  /// Where the views meet at `state`, as a start.
  static Eigen::Vector3d placeOf(const std::vector<PointView>& views, const WindowState& state,
                                 const Eigen::Vector3d& t_b_c) {
    const PointParameters start =
        triangulate(views.data(), static_cast<int>(views.size()), state, t_b_c);
    return start.origin + start.direction / std::max(start.inverse_depth, 1e-2);
  }

  /// `X` stays where it is; one loss for both rows of a view, as ours.
  void addPoint(const std::vector<PointView>& views, const Eigen::Vector3d& t_b_c, double sigma,
                double cauchy_sigmas, Eigen::Vector3d* X) {
    for (const PointView& view : views) {
      const int k = view.keyframe;
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresPoint, 2, 3, 3, 3>(
                                   new CeresPoint{view, starts[k], t_b_c, 1.0 / sigma}),
                               new ceres::CauchyLoss(cauchy_sigmas), w[k].data(), p[k].data(),
                               X->data());
    }
  }

  /// Minimises; returns the cost in our terms.
  double solve(int max_iterations, double tolerance) {
    problem.SetParameterBlockConstant(w[0].data());
    problem.SetParameterBlockConstant(p[0].data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = max_iterations;
    options.function_tolerance = options.parameter_tolerance = tolerance;
    options.gradient_tolerance = 0.1 * tolerance;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return 2.0 * summary.final_cost;
  }

  std::vector<RotationStart> starts;
  std::vector<Eigen::Vector3d> w, p, v;  ///< rotation vectors, positions, velocities in b0
  Eigen::Vector3d bg, ba, g;             ///< biases, and the direction of gravity in b0
  ceres::Problem problem;
};

}  // namespace slim_init
