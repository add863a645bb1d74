// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/posterior.h"

#include <cmath>

#include "geometry/dense.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

// d alpha / d down, for changes across it: how the attitude A of b0 in the world, A Exp(alpha),
// follows the direction of gravity while the yaw of the first body stays zero.
Eigen::Matrix3d attitudeFromGravity(const Eigen::Vector3d& down, const Eigen::Matrix3d& A) {
  const double level = std::hypot(down.y(), down.z());  // part of the x axis
  // gravityAlignedAttitude() holds the y axis of a body whose x axis is vertical, by the same
  // bound.
  const double turn = level > 1e-6 ? down.x() / level : 0.0;
  return -skew(down) - turn * down * A.row(1);
}

// Sets the first rows of `rows`, zero before: those of the errors [theta, p, v] per keyframe and of
// both biases, in the world, columns as the information has them. `derivatives` turn the error of
// the visual state into that of the body.
void setWorldErrors(const WindowState& visual, const WindowState& body,
                    const std::vector<RigDerivatives>& derivatives, const StateLayout& at,
                    Eigen::MatrixXd* rows) {
  const int gravity = at.gravity() - StateLayout::kGauge;
  const int rig = at.rig() - StateLayout::kGauge;
  constexpr int kRigColumns = StateLayout::kRig - 1;
  const double G = body.gravity_b0.norm();
  const Eigen::Vector3d down = body.gravity_b0 / G;
  const Eigen::Matrix3d A = gravityAlignedAttitude(body.gravity_b0);
  const RigDerivatives& first = derivatives[0];
  // From the frame of the visual part to that of the first body.
  const Eigen::Matrix3d to_first =
      first.by_state.topLeftCorner<3, 3>() * visual.R_b0_bk[0].transpose();
  // How the attitude of the first body in the world follows gravity and rig.
  const Eigen::Matrix3d dalpha = attitudeFromGravity(down, A);
  const Eigen::Matrix<double, 3, 2> by_gravity =
      dalpha * to_first * tangentBasis(visual.gravity_b0 / G);
  const Eigen::Matrix<double, 3, kRigColumns> theta_0 = first.by_rig.topRows<3>();
  const Eigen::Matrix<double, 3, kRigColumns> by_rig = dalpha * skew(down) * theta_0 - theta_0;
  Eigen::MatrixXd& T = *rows;
  for (int k = 0; k < at.n; ++k) {
    const int theta = 9 * k, p = 9 * k + 3, v = 9 * k + 6;
    const int pose = at.pose(k) - StateLayout::kGauge;
    const int velocity = at.velocity(k) - StateLayout::kGauge;
    const Eigen::Matrix3d Rt = body.R_b0_bk[k].transpose();
    const Eigen::Matrix3d AP = A * skew(body.p_b0.col(k)), AV = A * skew(body.v_b0.col(k));
    const Eigen::Matrix3d A_first = A * to_first;
    T.block<3, 2>(theta, gravity) = Rt * by_gravity;
    T.block<3, 2>(p, gravity) = -AP * by_gravity;
    T.block<3, 2>(v, gravity) = -AV * by_gravity;
    T.block<3, 3>(v, velocity) = A_first;
    const RigDerivatives& own = derivatives[k];
    if (k > 0) {
      T.block<3, 3>(p, pose + 3) = A_first;
      T.block<3, 3>(theta, pose) = own.by_state.topLeftCorner<3, 3>();
      T.block<3, 3>(p, pose) = A_first * own.by_state.block<3, 3>(3, 0);
    }
    T.block<3, kRigColumns>(theta, rig) = own.by_rig.topRows<3>() + Rt * by_rig;
    T.block<3, kRigColumns>(p, rig) =
        A_first * (own.by_rig.middleRows<3>(3) - first.by_rig.middleRows<3>(3)) - AP * by_rig;
    T.block<3, kRigColumns>(v, rig) = A_first * own.by_rig.bottomRows<3>() - AV * by_rig;
  }
  T.block<6, 6>(9 * at.n, at.gyroBias() - StateLayout::kGauge).setIdentity();
}

}  // namespace

Posterior posteriorOf(const WindowState& state, const Eigen::MatrixXd& information) {
  const Eigen::Index m = information.rows();
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(m + StateLayout::kRig, m + StateLayout::kRig);
  held.topLeftCorner(m, m) = information;
  held.diagonal().tail<StateLayout::kRig>().setConstant(kHold);
  return posteriorOf(state, held, Calibration(), std::vector<ImuInstant>(state.size()));
}

Posterior posteriorOf(const WindowState& visual, const Eigen::MatrixXd& information,
                      const Calibration& calibration, const std::vector<ImuInstant>& instants) {
  Posterior out;
  const WindowState body = bodyState(visual, calibration.R_b_c, calibration.t_b_c);
  std::vector<RigDerivatives> derivatives(visual.size());
  const BodyOffset offset(visual.rig, calibration);
  WindowState unused = visual;
  for (int k = 0; k < visual.size(); ++k) {
    // An error of td labels the body with another time: the same as seeing it at another one.
    bodyAtNominalTime(visual, k, offset, {0.0, instants[k]}, &unused, &derivatives[k]);
  }
  const StateLayout at(visual.size(), true);
  const int m = at.size() - StateLayout::kGauge;
  const int world = 9 * at.n + 6, rigs = StateLayout::kRig;
  // What the host is told, then scale and rig: a relative change of scale moves every position
  // along its offset from the mean.
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(world + 1 + rigs, m);
  setWorldErrors(visual, body, derivatives, at, &T);
  const Eigen::Matrix3Xd centred = visual.p_b0.colwise() - visual.p_b0.rowwise().mean();
  for (int k = 1; k < at.n; ++k) {
    T.block<1, 3>(world, at.pose(k) + 3 - StateLayout::kGauge) =
        centred.col(k).transpose() / centred.squaredNorm();
  }
  T.block(world + 1, at.rig() - StateLayout::kGauge, rigs, rigs).setIdentity();
  Eigen::MatrixXd covariance;
  if (!inverseSeenBy(information, T, &covariance)) return out;
  out.covariance = covariance.topLeftCorner(world, world);
  out.scale_sigma = std::sqrt(covariance(world, world));
  out.by_scale = covariance.col(world).head(world) / covariance(world, world);
  out.rig_covariance = covariance.bottomRightCorner<StateLayout::kRig, StateLayout::kRig>();
  out.valid = covariance.allFinite();
  return out;
}

}  // namespace slim_init
