// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "first_state_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "slim_init/host_health/imu_propagation.h"

namespace slim_init::vins_adapter {

using namespace host_health;  // NOLINT: the vocabulary of this file
namespace {

constexpr int kRows = 11;
constexpr int kColumns = HostWindow::kPriorColumns;

// Any two directions at right angles to a unit vector, as rows.
Eigen::Matrix<double, 2, 3> acrossOf(const Eigen::Vector3d& u) {
  Eigen::Matrix<double, 2, 3> B;
  B.row(0) = u.unitOrthogonal();
  B.row(1) = u.cross(B.row(0).transpose());
  return B;
}

// Errors [velocity in the body, direction of gravity in the body, b_g, b_a] by those of an answer's
// state, [theta, p, v, b_g, b_a].
Eigen::Matrix<double, 12, 15> bodyErrors(const NavState& state) {
  const Eigen::Matrix3d Rt = state.R_w_b.transpose();
  Eigen::Matrix<double, 12, 15> Y = Eigen::Matrix<double, 12, 15>::Zero();
  Y.block<3, 3>(0, 0) = skewOf(Rt * state.v_w_b);
  Y.block<3, 3>(0, 6) = Rt;
  Y.block<3, 3>(3, 0) = skewOf(-Rt.col(2));
  Y.block<6, 6>(6, 9).setIdentity();
  return Y;
}

// Of bodyErrors(), to the host's errors [p, theta, v, b_a, b_g].
std::vector<double> priorFrom(const Eigen::Matrix<double, 12, 12>& covariance,
                              const HostState& host) {
  const Eigen::Matrix3d Rt = host.R.transpose();
  const Eigen::Vector3d down = -Rt.col(2);
  const Eigen::Matrix<double, 2, 3> B = acrossOf(down);
  // A direction has two degrees of freedom.
  Eigen::Matrix<double, kRows, 12> reduce = Eigen::Matrix<double, kRows, 12>::Zero();
  reduce.block<3, 3>(0, 0).setIdentity();
  reduce.block<2, 3>(3, 3) = B;
  reduce.block<6, 6>(5, 6).setIdentity();
  const Eigen::LLT<Eigen::Matrix<double, kRows, kRows>> llt(reduce * covariance *
                                                            reduce.transpose());
  if (llt.info() != Eigen::Success) return {};

  Eigen::Matrix<double, kRows, kColumns> J = Eigen::Matrix<double, kRows, kColumns>::Zero();
  J.block<3, 3>(0, 3) = skewOf(Rt * host.V);
  J.block<3, 3>(0, 6) = Rt;
  J.block<2, 3>(3, 3) = B * skewOf(down);
  J.block<3, 3>(5, 12).setIdentity();
  J.block<3, 3>(8, 9).setIdentity();
  const Eigen::Matrix<double, kRows, kColumns> root = llt.matrixL().solve(J);
  if (!root.allFinite()) return {};
  std::vector<double> prior(kRows * kColumns);
  Eigen::Map<Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>>(prior.data()) = root;
  return prior;
}

}  // namespace

std::vector<double> firstStatePrior(const InitResult& answer, const NavState& at,
                                    const HostState& host) {
  if (answer.states.empty()) return {};
  const auto nearest = std::min_element(answer.states.begin(), answer.states.end(),
                                        [&at](const NavState& a, const NavState& b) {
                                          return std::abs(a.t - at.t) < std::abs(b.t - at.t);
                                        });
  const NavState& known = *nearest;
  const Eigen::Matrix<double, 15, 15> P =
      answer.stateCovariance(static_cast<std::size_t>(nearest - answer.states.begin()));
  if (!P.allFinite()) return {};
  // Carried by the IMU from the keyframe: u' = dR^T (u + g dt d + dv), d' = dR^T d. A body at rest
  // stays as it is.
  const double dt = at.t >= answer.at_rest_since && at.t < known.t ? 0.0 : at.t - known.t;
  const Eigen::Matrix3d back = at.R_w_b.transpose() * known.R_w_b;
  const Eigen::Matrix<double, 12, 15> Y = bodyErrors(known);
  Eigen::Matrix<double, 12, 15> propagated = Y;
  propagated.topRows<3>() =
      back *
      (Y.topRows<3>() + answer.gravity_w.norm() * dt * Y.middleRows<3>(3) - dt * Y.bottomRows<3>());
  propagated.middleRows<3>(3) = back * Y.middleRows<3>(3);
  // The host's optimization sees the same data again, but at 1.5 px in place of 0.6 and with more
  // noise of the IMU: what is counted twice is a sixth.
  return priorFrom(propagated * P * propagated.transpose(), host);
}

std::vector<double> firstStatePrior(const PropagatedState& healthy, const HostState& host) {
  const Eigen::Matrix<double, 12, 15> Y = bodyErrors(healthy.state);
  return priorFrom(Y * toStatePrior(healthy).covariance * Y.transpose(), host);
}

}  // namespace slim_init::vins_adapter
