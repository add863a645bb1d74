// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/msckf_state.h"

#include <Eigen/Geometry>
#include <cmath>

#include "slim_init/result.h"

namespace slim_init::vins_adapter {
namespace {

using Matrix15d = Eigen::Matrix<double, 15, 15>;

// Into the world that has the newest body as its origin and its heading: an error of the heading
// turns attitude and velocity alike, and is taken out of both.
Matrix15d inOwnWorld(const NavState& newest, const Matrix15d& P) {
  const Eigen::Vector3d up_b = newest.R_w_b.transpose() * Eigen::Vector3d::UnitZ();
  Matrix15d T = Matrix15d::Identity();
  Eigen::Matrix<double, 15, 1> turn = Eigen::Matrix<double, 15, 1>::Zero();
  turn.head<3>() = up_b;
  turn.segment<3>(6) = Eigen::Vector3d::UnitZ().cross(newest.v_w_b);
  T.leftCols<3>() -= turn * up_b.transpose();
  T.block<3, 3>(3, 3).setZero();
  Matrix15d own = T * P * T.transpose() + kHeldHeading * kHeldHeading * turn * turn.transpose();
  own.diagonal().segment<3>(3).array() += kHeldPosition * kHeldPosition;
  return own;
}

}  // namespace

bool toMsckfState(const InitResult& result, double td, MsckfState* state, std::string* error) {
  const auto fail = [error](const std::string& message) {
    if (error != nullptr) *error = message;
    return false;
  };
  if (result.states.empty()) return fail("the estimate has no states");
  const auto size = static_cast<Eigen::Index>(9 * result.states.size() + 6);
  if (result.covariance.rows() != size || result.covariance.cols() != size) {
    return fail("the estimate has no covariance, which the filter needs; use the method slim");
  }
  if (!std::isfinite(td)) return fail("td is not finite");
  const NavState& newest = result.states.back();
  const Matrix15d P = inOwnWorld(newest, result.stateCovariance(result.states.size() - 1));
  if (!newest.isFinite() || !P.allFinite()) return fail("the estimate is not finite");

  const Eigen::Quaterniond q = Eigen::Quaterniond(newest.R_w_b).normalized();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  MsckfState made;
  made.timestamp = newest.t - td;
  made.value = {sign * q.x(), sign * q.y(), sign * q.z(), sign * q.w(), 0.0, 0.0, 0.0};
  for (const Eigen::Vector3d& part : {newest.v_w_b, newest.gyro_bias, newest.accel_bias}) {
    made.value.insert(made.value.end(), part.data(), part.data() + 3);
  }
  made.covariance.assign(P.data(), P.data() + P.size());
  *state = std::move(made);
  return true;
}

}  // namespace slim_init::vins_adapter
