// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "inertial_bundle_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>

#include "geometry/so3.h"
#include "inertial_cost.h"

namespace slim_init::baselines {
namespace {

// Parameter blocks of a keyframe: pose [p, theta] with R_w_b = R_start Exp(theta), and
// motion [v, b_g, b_a]. All keyframes lie in one vector: Ceres orders blocks by their address, and
// equal input has to give equal bytes.
struct KeyframeBlocks {
  std::array<double, 6> pose;
  std::array<double, 9> motion;
};

template <int Rows, int Columns>
using RowMajor = Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>;
using ConstMap3 = Eigen::Map<const Eigen::Vector3d>;

// An observation of a point, in pixels over sigma.
class ReprojectionFactor : public ceres::SizedCostFunction<2, 6, 3> {
 public:
  ReprojectionFactor(const Eigen::Vector2d& uv, const Calibration& calibration,
                     const Eigen::Matrix3d& R_start, double sqrt_information)
      : uv_(uv),
        R_c_b_(calibration.R_b_c.transpose()),
        t_b_c_(calibration.t_b_c),
        R_start_(R_start),
        sqrt_information_(sqrt_information) {}

  bool Evaluate(double const* const* parameters, double* residual,
                double** jacobians) const override {
    const ConstMap3 p(parameters[0]), theta(parameters[0] + 3), point(parameters[1]);
    const Eigen::Matrix3d R_b_w = (R_start_ * expSO3(theta)).transpose();
    const Eigen::Vector3d x_b = R_b_w * (point - p);
    const Eigen::Vector3d x_c = R_c_b_ * (x_b - t_b_c_);
    Eigen::Map<Eigen::Vector2d> r(residual);
    r = sqrt_information_ * (x_c.hnormalized() - uv_);
    if (jacobians == nullptr) return true;

    Eigen::Matrix<double, 2, 3> J_x;
    J_x << 1.0, 0.0, -x_c.x() / x_c.z(), 0.0, 1.0, -x_c.y() / x_c.z();
    J_x *= sqrt_information_ / x_c.z();
    J_x *= R_c_b_;
    if (jacobians[0] != nullptr) {
      Eigen::Map<RowMajor<2, 6>> J(jacobians[0]);
      J.leftCols<3>() = -J_x * R_b_w;
      J.rightCols<3>() = J_x * skew(x_b) * rightJacobian(theta);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<RowMajor<2, 3>> J(jacobians[1]);
      J = J_x * R_b_w;
    }
    return true;
  }

 private:
  Eigen::Vector2d uv_;
  Eigen::Matrix3d R_c_b_;
  Eigen::Vector3d t_b_c_;
  Eigen::Matrix3d R_start_;
  double sqrt_information_;
};

// Holds yaw and position of the first keyframe, which nothing observes, and its biases about zero.
void addFirstPrior(const NavState& start, const OpenVinsOptions& options, KeyframeBlocks* first,
                   ceres::Problem* problem) {
  // The release's standard deviation of what only fixes the gauge [rad], [m].
  constexpr double kGauge = 1.0 / 1e-5;
  ceres::Matrix of_pose = ceres::Matrix::Zero(4, 6);
  of_pose.topLeftCorner<3, 3>().diagonal().setConstant(kGauge);
  of_pose.bottomRightCorner<1, 3>() = kGauge * start.R_w_b.row(2);
  ceres::Vector pose(6);
  pose << start.p_w_b, Eigen::Vector3d::Zero();
  problem->AddResidualBlock(new ceres::NormalPrior(of_pose, pose), nullptr, first->pose.data());
  ceres::Matrix of_motion = ceres::Matrix::Zero(6, 9);
  of_motion.block<3, 3>(0, 3).diagonal().setConstant(1.0 / options.gyro_bias_prior);
  of_motion.block<3, 3>(3, 6).diagonal().setConstant(1.0 / options.accel_bias_prior);
  problem->AddResidualBlock(new ceres::NormalPrior(of_motion, ceres::Vector::Zero(9)), nullptr,
                            first->motion.data());
}

}  // namespace

InertialAdjustment adjustInertial(const InitWindow& window, const std::vector<Preintegration>& pre,
                                  const OpenVinsOptions& options, std::vector<NavState>* states,
                                  std::vector<MappedTrack>* points) {
  InertialAdjustment out;
  const Calibration& calibration = window.calibration();
  const Eigen::Vector3d gravity_w(0.0, 0.0, -calibration.gravity_magnitude);
  const std::size_t n = states->size();
  std::vector<KeyframeBlocks> blocks(n);
  ceres::Problem problem;
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (std::size_t k = 0; k < n; ++k) {
    const NavState& state = (*states)[k];
    Eigen::Map<Eigen::Matrix<double, 6, 1>>(blocks[k].pose.data()) << state.p_w_b,
        Eigen::Vector3d::Zero();
    Eigen::Map<Eigen::Matrix<double, 9, 1>>(blocks[k].motion.data()) << state.v_w_b,
        state.gyro_bias, state.accel_bias;
    ordering->AddElementToGroup(blocks[k].pose.data(), 1);
    ordering->AddElementToGroup(blocks[k].motion.data(), 1);
  }
  addFirstPrior(states->front(), options, &blocks[0], &problem);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    std::unique_ptr<InertialCost> cost =
        InertialCost::create(pre[i], (*states)[i].R_w_b, (*states)[i + 1].R_w_b, gravity_w,
                             options.gyro_walk, options.accel_walk);
    if (cost == nullptr) {
      delete ordering;
      return out;
    }
    problem.AddResidualBlock(cost.release(), nullptr, blocks[i].pose.data(),
                             blocks[i].motion.data(), blocks[i + 1].pose.data(),
                             blocks[i + 1].motion.data());
  }
  const double sqrt_information = calibration.focal_px / options.sigma_px;
  for (MappedTrack& mapped : *points) {
    const Track& track = window.pointTracks()[mapped.track];
    for (int s = track.begin; s < track.end; ++s) {
      const WindowPoint& observation = window.pointObservations()[s];
      const int k = observation.keyframe;
      problem.AddResidualBlock(
          new ReprojectionFactor(observation.bearing.hnormalized(), calibration, (*states)[k].R_w_b,
                                 sqrt_information),
          new ceres::CauchyLoss(options.cauchy_sigmas), blocks[k].pose.data(),
          mapped.point_w.data());
    }
    ordering->AddElementToGroup(mapped.point_w.data(), 0);
  }

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering.reset(ordering);
  solver.trust_region_strategy_type = ceres::DOGLEG;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-4 * options.function_tolerance;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  out.first_cost = summary.initial_cost;
  out.cost = summary.final_cost;

  for (std::size_t k = 0; k < n; ++k) {
    NavState& state = (*states)[k];
    state.R_w_b *= expSO3(ConstMap3(blocks[k].pose.data() + 3));
    state.p_w_b = ConstMap3(blocks[k].pose.data());
    state.v_w_b = ConstMap3(blocks[k].motion.data());
    state.gyro_bias = ConstMap3(blocks[k].motion.data() + 3);
    state.accel_bias = ConstMap3(blocks[k].motion.data() + 6);
  }
  return out;
}

}  // namespace slim_init::baselines
