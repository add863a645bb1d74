// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/reverse_alignment.h"

#include <cmath>
#include <limits>

#include "geometry/minimize.h"
#include "scale/gravity_constrained.h"

namespace slim_init {
namespace {

// Scales searched [m per unit of the shape], up to this and down to its inverse, and points of the
// logarithmic grid between them.
constexpr double kMaxScale = 50.0;
constexpr int kScaleGrid = 36;
// End of the search [log scale].
constexpr double kStartTolerance = 1e-5;

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector9d = Eigen::Matrix<double, 9, 1>;

// The cost of docs/derivation.md, 3.2: everything that does not depend on u, projected onto the
// nine unknowns.
class ReverseCost {
 public:
  ReverseCost(const LinearMotion& motion, const Eigen::VectorXd& shape,
              const Eigen::MatrixXd& information, double kappa, double accel_bias_prior,
              double gravity_magnitude)
      : kappa_(kappa), gravity_magnitude_(gravity_magnitude) {
    const Eigen::VectorXd c0 = motion.position0 + motion.lever;
    const Eigen::Matrix<double, Eigen::Dynamic, 9> HA = information * motion.position;
    AHA_ = motion.position.transpose() * HA;
    AHc0_ = HA.transpose() * c0;
    c0Hc0_ = c0.dot(information * c0);
    shape_A_ = motion.position.transpose() * shape;
    shape_c0_ = shape.dot(c0);
    prior_ = motion.speed_information;
    prior_.diagonal().segment<3>(3).array() += 1.0 / (accel_bias_prior * accel_bias_prior);
    speed_gradient_ = motion.speed_gradient;
    speed_cost_ = motion.speed_cost;
  }

  // Cost at inverse scale u, minimised over the other unknowns; infinity where that fails.
  double operator()(double u, Vector9d* x) const {
    Matrix9d M = u * u * (AHA_ + kappa_ * shape_A_ * shape_A_.transpose());
    M += prior_;
    const Vector9d b =
        kappa_ * u * shape_A_ - u * u * (AHc0_ + kappa_ * shape_c0_ * shape_A_) + speed_gradient_;
    if (!solveGravityConstrained(M, b, gravity_magnitude_, x)) {
      return std::numeric_limits<double>::infinity();
    }
    const double length = u * (shape_A_.dot(*x) + shape_c0_) - 1.0;
    return u * u * (x->dot(AHA_ * *x) + 2.0 * AHc0_.dot(*x) + c0Hc0_) + kappa_ * length * length +
           x->dot(prior_ * *x) - 2.0 * speed_gradient_.dot(*x) + speed_cost_;
  }

 private:
  double kappa_;
  double gravity_magnitude_;
  Matrix9d AHA_, prior_;
  Vector9d AHc0_, shape_A_, speed_gradient_;
  double c0Hc0_ = 0.0;
  double shape_c0_ = 0.0;
  double speed_cost_ = 0.0;
};

// The cost over log(scale) has one basin per plausible scale: a grid first, golden section search
// about its lowest point. NaN where the cost is finite nowhere on the grid.
double bestLogScale(const ReverseCost& cost) {
  Vector9d x;
  const double lowest = std::log(1.0 / kMaxScale);
  const double step = std::log(kMaxScale * kMaxScale) / (kScaleGrid - 1);
  double best_cost = std::numeric_limits<double>::infinity();
  double best = 0.0;
  for (int k = 0; k < kScaleGrid; ++k) {
    const double log_scale = lowest + k * step;
    const double value = cost(std::exp(-log_scale), &x);
    if (value < best_cost) {
      best_cost = value;
      best = log_scale;
    }
  }
  if (!std::isfinite(best_cost)) return kNotComputed;
  return goldenSection([&](double log_scale) { return cost(std::exp(-log_scale), &x); },
                       best - step, best + step, kStartTolerance)
      .at;
}

}  // namespace

LinearMotion linearMotion(const std::vector<Preintegration>& pre,
                          const std::vector<Eigen::Matrix3d>& R_b0_bk,
                          const Eigen::Vector3d& t_b_c) {
  const int n = static_cast<int>(R_b0_bk.size());
  LinearMotion motion;
  motion.R_b0_bk = R_b0_bk;
  motion.gyro_bias = pre.front().gyro_bias;
  motion.accel_bias = pre.front().accel_bias;
  motion.position.setZero(3 * n, 9);
  motion.velocity.setZero(3 * n, 9);
  motion.position0.setZero(3 * n);
  motion.velocity0.setZero(3 * n);
  motion.lever.resize(3 * n);
  motion.velocity.block<3, 3>(0, 0).setIdentity();
  motion.lever.head<3>() = R_b0_bk[0] * t_b_c;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  for (int k = 0; k + 1 < n; ++k) {
    const Preintegration& p = pre[k];
    const int a = 3 * k, b = 3 * (k + 1);
    motion.position.middleRows<3>(b) =
        motion.position.middleRows<3>(a) + p.dt * motion.velocity.middleRows<3>(a);
    motion.position.block<3, 3>(b, 3) += R_b0_bk[k] * p.dp_dba;
    motion.position.block<3, 3>(b, 6) += 0.5 * p.dt * p.dt * I;
    motion.position0.segment<3>(b) =
        motion.position0.segment<3>(a) + p.dt * motion.velocity0.segment<3>(a) + R_b0_bk[k] * p.dp;
    motion.velocity.middleRows<3>(b) = motion.velocity.middleRows<3>(a);
    motion.velocity.block<3, 3>(b, 3) += R_b0_bk[k] * p.dv_dba;
    motion.velocity.block<3, 3>(b, 6) += p.dt * I;
    motion.velocity0.segment<3>(b) = motion.velocity0.segment<3>(a) + R_b0_bk[k] * p.dv;
    motion.lever.segment<3>(b) = R_b0_bk[k + 1] * t_b_c;
  }
  return motion;
}

WindowState LinearMotion::at(const Eigen::Matrix<double, 9, 1>& x) const {
  const Eigen::VectorXd p = position0 + position * x, v = velocity0 + velocity * x;
  WindowState state;
  state.R_b0_bk = R_b0_bk;
  state.p_b0 = Eigen::Map<const Eigen::Matrix3Xd>(p.data(), 3, state.size());
  state.v_b0 = Eigen::Map<const Eigen::Matrix3Xd>(v.data(), 3, state.size());
  state.gyro_bias = gyro_bias;
  state.accel_bias = accel_bias + x.segment<3>(3);
  state.gravity_b0 = x.tail<3>();
  return state;
}

ReverseEstimate alignReverse(const LinearMotion& motion, const Eigen::Matrix3Xd& shape_b0,
                             const Eigen::MatrixXd& information_b0, double gravity_magnitude,
                             double accel_bias_prior) {
  ReverseEstimate out;
  const Eigen::Index n = shape_b0.cols();
  Eigen::Matrix3Xd centred = shape_b0.colwise() - shape_b0.rowwise().mean();
  centred /= centred.norm();
  const Eigen::VectorXd shape = Eigen::Map<const Eigen::VectorXd>(centred.data(), 3 * n);
  const double kappa = kLengthWeight * information_b0.trace() / static_cast<double>(3 * n);
  const ReverseCost cost(motion, shape, information_b0, kappa, accel_bias_prior, gravity_magnitude);

  const double log_scale = bestLogScale(cost);
  out.scale = std::exp(log_scale);
  out.valid = std::isfinite(cost(1.0 / out.scale, &out.x));
  return out;
}

}  // namespace slim_init
