// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "estimation/state_factor.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "geometry/dense.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

// Data whose information is a smaller share of the prior's than this say nothing against it.
constexpr double kLeastInformation = 1e-3;
// On the bounds of the test, squared errors beyond the covariance: those of model errors of tracks
// and IMU, and, for all that a wrong velocity or tilt bends, of the linearisation too.
constexpr double kBiasTestMargin = 1.5;
constexpr double kStateTestMargin = 2.25;

// First row and number of rows.
constexpr int kRowsOf[kStateParts][2] = {{0, 3}, {3, 2}, {5, 3}, {8, 3}};
// What is exceeded by chance once in a thousand, by degrees of freedom.
constexpr double kThousandth[] = {0.0,   10.83, 13.82, 16.27, 18.47, 20.52,
                                  22.46, 24.32, 26.12, 27.88, 29.59, 31.26};

// F, with which P + F F^T is the covariance P with a part as good as unknown.
Eigen::MatrixXd unknownPart(const StateCovariance& P, int part) {
  const auto [at, size] = kRowsOf[part];
  // The error of a velocity moves nothing else. A bias, or a tilt, has been carried into the
  // velocity: what correlates with it is wrong too.
  if (part == static_cast<int>(StatePart::kVelocity)) {
    return kUnknown[part] * StateCovariance::Identity().middleCols(at, size);
  }
  return kUnknown[part] *
         solveSymmetric(P.block(at, at, size, size), P.middleRows(at, size)).transpose();
}

// Of z = W d, d the difference of data and prior with the covariance (W^T W)^-1; `P` of the prior.
StateTest testWhitened(const Eigen::VectorXd& z, const Eigen::MatrixXd& W,
                       const StateCovariance& P) {
  StateTest test;
  test.freedom = static_cast<int>(z.size());
  test.total = z.squaredNorm();
  for (int i = 0; i < kStateParts; ++i) {
    const Eigen::MatrixXd F = product(W, unknownPart(P, i));
    const Eigen::VectorXd u = F.transpose() * z;
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(u.size(), u.size());
    test.part[i] = u.dot(solveSymmetric(one + product(F.transpose(), F), u).col(0));
  }
  return test;
}

}  // namespace

const char* toString(StatePart part) {
  switch (part) {
    case StatePart::kVelocity: return "velocity";
    case StatePart::kGravity: return "gravity";
    case StatePart::kGyroBias: return "gyro_bias";
    case StatePart::kAccelBias: return "accel_bias";
  }
  return "unknown";
}

Eigen::Matrix<double, kStateRows, 15> stateRows(const NavState& state) {
  const Eigen::Matrix3d R_b_w = state.R_w_b.transpose();
  const Eigen::Vector3d down = -R_b_w.col(2);
  Eigen::Matrix<double, kStateRows, 15> Y = Eigen::Matrix<double, kStateRows, 15>::Zero();
  Y.block<3, 3>(0, 0) = skew(R_b_w * state.v_w_b);
  Y.block<3, 3>(0, 6) = R_b_w;
  Y.block<2, 3>(3, 0) = tangentBasis(down).transpose() * skew(down);
  Y.block<6, 6>(5, 9).setIdentity();
  return Y;
}

StateFactor stateFactor(const StatePrior& prior) {
  const NavState& state = prior.state;
  StateFactor factor;
  factor.velocity_b = state.R_w_b.transpose() * state.v_w_b;
  factor.down_b = -state.R_w_b.transpose().col(2);
  factor.gyro_bias = state.gyro_bias;
  factor.accel_bias = state.accel_bias;
  const Eigen::Matrix<double, kStateRows, 15> Y = stateRows(state);
  factor.covariance = propagated(Y, prior.covariance);
  return factor;
}

ImuBiases StateFactor::biases() const {
  const StateVector variance = covariance.diagonal();
  return {gyro_bias, accel_bias, std::sqrt(variance.segment<3>(5).maxCoeff()),
          std::sqrt(variance.segment<3>(8).maxCoeff())};
}

StateResidual stateResidual(const WindowState& state, const StateFactor& factor,
                            const Calibration& calibration, const ImuInstant& first) {
  WindowState body = state;
  RigDerivatives chain;
  bodyAtNominalTime(state, 0, BodyOffset(state.rig, calibration), {state.rig.dtd, first}, &body,
                    &chain);
  const Eigen::Vector3d down = state.gravity_b0.normalized();
  const Eigen::Matrix3d Rt = body.R_b0_bk[0].transpose();
  const Eigen::Vector3d v_b = Rt * body.v_b0.col(0), down_b = Rt * down;
  const Eigen::Matrix<double, 2, 3> B = tangentBasis(factor.down_b).transpose();
  StateResidual out;
  out.r << v_b - factor.velocity_b, B * down_b, state.gyro_bias - factor.gyro_bias,
      state.accel_bias - factor.accel_bias;
  out.J.setZero();
  out.J.block<6, 6>(5, 3).setIdentity();
  out.J.block<2, 2>(3, 9) = B * Rt * tangentBasis(down);
  Eigen::Matrix<double, 5, 9> by_body = Eigen::Matrix<double, 5, 9>::Zero();
  by_body.block<3, 3>(0, 0) = skew(v_b);
  by_body.block<3, 3>(0, 6) = Rt;
  by_body.block<2, 3>(3, 0) = B * skew(down_b);
  out.J.topLeftCorner<5, 3>() = by_body * chain.by_state.rightCols<3>();
  out.J.block<5, 2>(0, 9) += by_body * chain.by_gravity;
  out.J.topRightCorner<5, StateLayout::kRig - 1>() = by_body * chain.by_rig;
  return out;
}

StateCovariance without(const StateCovariance& covariance, StatePart part) {
  const Eigen::MatrixXd F = unknownPart(covariance, static_cast<int>(part));
  return covariance + product(F, F.transpose());
}

bool StateTest::contradicts() const {
  if (total > bound()) return true;
  for (int i = 0; i < kStateParts; ++i) {
    if (contradicts(static_cast<StatePart>(i))) return true;
  }
  return false;
}

double StateTest::bound() const { return kStateTestMargin * kThousandth[freedom]; }

bool StateTest::contradicts(StatePart which) const {
  const auto i = static_cast<int>(which);
  const double margin = which == StatePart::kGyroBias || which == StatePart::kAccelBias
                            ? kBiasTestMargin
                            : kStateTestMargin;
  return part[i] > margin * kThousandth[std::min(freedom, kRowsOf[i][1])];
}

StateTest testDifference(const StateFactor& prior, const StateFactor& estimate) {
  const Eigen::Matrix<double, 3, 2> B = tangentBasis(prior.down_b);
  StateVector r;
  r << estimate.velocity_b - prior.velocity_b, B.transpose() * estimate.down_b,
      estimate.gyro_bias - prior.gyro_bias, estimate.accel_bias - prior.accel_bias;
  // Both tilts by one basis.
  StateCovariance turn = StateCovariance::Identity();
  turn.block<2, 2>(3, 3) = B.transpose() * tangentBasis(estimate.down_b);
  const Eigen::LLT<StateCovariance> llt(prior.covariance + propagated(turn, estimate.covariance));
  const StateCovariance W = llt.matrixL().solve(StateCovariance::Identity());
  return testWhitened(W * r, W, prior.covariance);
}

// The step r from the prior has the covariance P - S; with the difference d of data and prior, of
// covariance C, it is P C^-1 d. Of P - S = L L^T only the directions are taken in which the data
// say something.
StateTest testState(const StateVector& r, const StateCovariance& covariance,
                    const StateCovariance& posterior) {
  const StateVector scale = covariance.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) return StateTest();
  const StateVector inverse = scale.cwiseInverse();
  const SymmetricEigen eigen =
      symmetricEigen(inverse.asDiagonal() * (covariance - posterior) * inverse.asDiagonal());
  const auto first = std::count_if(eigen.values.data(), eigen.values.data() + kStateRows,
                                   [](double share) { return !(share > kLeastInformation); });
  const Eigen::VectorXd root = eigen.values.tail(kStateRows - first).cwiseSqrt();
  const Eigen::MatrixXd axes = eigen.vectors.rightCols(kStateRows - first);
  const Eigen::MatrixXd L = scale.asDiagonal() * axes * root.asDiagonal();
  return testWhitened(
      root.cwiseInverse().asDiagonal() * (axes.transpose() * (inverse.cwiseProduct(r))),
      solveSymmetric(covariance, L).transpose(), covariance);
}

}  // namespace slim_init
