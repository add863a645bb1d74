// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Levenberg-Marquardt for a few unknowns in a vector space (Madsen, Nielsen and Tingleff, "Methods
// for Non-linear Least Squares Problems", 2004, section 3.2, with damping by factors of ten).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

namespace slim_init {

/// Second-order model of a cost at x: cost(x + d) = cost + gradient . d + d . hessian d / 2.
template <int N>
struct QuadraticModel {
  double cost = 0.0;
  Eigen::Matrix<double, N, 1> gradient = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> hessian = Eigen::Matrix<double, N, N>::Zero();
};

/// When the minimisation ends.
struct LevenbergMarquardtOptions {
  int max_iterations = 10;
  double first_damping = 1e-4;
  double largest_damping = 1e6;  ///< another step would be too short to matter
  /// Expected decrease over the cost that is not worth a step: of a chi-square of a thousand, a
  /// hundredth of a standard deviation of the unknowns.
  double relative_decrease = 1e-7;
  double shortest_step = 0.0;  ///< in units of x
};

/// Whether a step is accepted.
struct LowerCost {
  template <typename Model>
  bool operator()(const Model& there, const Model& at) const {
    return there.cost < at.cost;
  }
};

/// Minimises from `x` on and returns the number of accepted steps. `evaluate(x)` returns a model
/// (QuadraticModel<N> or derived from it), `damp(model, damping)` the matrix to solve with.
/// `at`: the model at `x`, in and out.
template <int N, typename Model, typename Evaluate, typename Damp, typename Better = LowerCost>
int minimizeLevenbergMarquardt(const LevenbergMarquardtOptions& options, const Evaluate& evaluate,
                               const Damp& damp, Eigen::Matrix<double, N, 1>* x, Model* at,
                               const Better& better = {}) {
  constexpr double kSmallestDamping = 1e-12;
  int accepted = 0;
  double damping = options.first_damping;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const Eigen::Matrix<double, N, N> H = damp(*at, damping);
    const Eigen::Matrix<double, N, 1> step = -H.ldlt().solve(at->gradient);
    const double decrease = -0.5 * at->gradient.dot(step);
    if (!step.allFinite() || decrease <= options.relative_decrease * at->cost) break;
    const Eigen::Matrix<double, N, 1> candidate = *x + step;
    const Model there = evaluate(candidate);
    if (better(there, *at)) {
      *x = candidate;
      *at = there;
      ++accepted;
      damping = std::max(0.1 * damping, kSmallestDamping);
    } else {
      damping *= 10.0;
    }
    if (step.norm() < options.shortest_step || damping > options.largest_damping) break;
  }
  return accepted;
}

}  // namespace slim_init
