// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The state that a filter begins with: its convention, and its covariance in a world of its own.
#include "slim_init/vins_adapter/msckf_state.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "geometry/so3.h"
#include "slim_init/result.h"
#include "support/gaussian.h"

namespace slim_init::vins_adapter {
namespace {

using Matrix15d = Eigen::Matrix<double, 15, 15>;
using Rows = Eigen::Matrix<double, 3, 15>;

constexpr double kTd = 0.02;

// Two keyframes with a covariance that correlates everything.
InitResult anAnswer() {
  InitResult result;
  result.status = InitStatus::kSuccess;
  for (int k = 0; k < 2; ++k) {
    NavState state;
    state.t = 5.0 + 0.1 * k;
    state.R_w_b = expSO3(Eigen::Vector3d(0.4, -1.1 - 0.1 * k, 2.0));
    state.p_w_b = Eigen::Vector3d(1.0, 2.0, 3.0 + k);
    state.v_w_b = Eigen::Vector3d(0.7, -1.2, 0.3 + k);
    state.gyro_bias = Eigen::Vector3d(0.01, -0.02, 0.03);
    state.accel_bias = Eigen::Vector3d(0.1, 0.2, -0.3);
    result.states.push_back(state);
  }
  Gaussian normal(3);
  const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(24, 24, [&] { return 0.1 * normal(); });
  result.covariance = root * root.transpose();
  return result;
}

Matrix15d newest(const InitResult& result) {
  Eigen::MatrixXd pick = Eigen::MatrixXd::Zero(15, 24);
  pick.rightCols<15>().setIdentity();
  return pick * result.covariance * pick.transpose();
}

Matrix15d matrixOf(const MsckfState& state) {
  return Eigen::Map<const Matrix15d>(state.covariance.data());
}

TEST(MsckfState, ValuesAreInTheHostsOrderAndConvention) {
  const InitResult answer = anAnswer();
  const NavState& last = answer.states.back();
  MsckfState state;
  ASSERT_TRUE(toMsckfState(answer, kTd, &state, nullptr));
  ASSERT_EQ(state.value.size(), 16u);
  EXPECT_DOUBLE_EQ(state.timestamp, last.t - kTd);
  const Eigen::Map<const Eigen::VectorXd> x(state.value.data(), 16);
  // JPL: R(q) = I - 2 w [q]x + 2 [q]x^2 is the rotation from the global frame to the body.
  const Eigen::Vector3d q = x.head<3>();
  const Eigen::Matrix3d R_G_I =
      Eigen::Matrix3d::Identity() - 2.0 * x[3] * skew(q) + 2.0 * skew(q) * skew(q);
  EXPECT_LT((R_G_I - last.R_w_b.transpose()).norm(), 1e-12);
  EXPECT_GE(x[3], 0.0);
  EXPECT_EQ((x.segment<3>(4)), Eigen::Vector3d::Zero());
  EXPECT_EQ((x.segment<3>(7)), last.v_w_b);
  EXPECT_EQ((x.segment<3>(10)), last.gyro_bias);
  EXPECT_EQ((x.segment<3>(13)), last.accel_bias);
}

// Whatever does not depend on where the world lies and how it is turned is as uncertain as before.
TEST(MsckfState, WhatTheWorldDoesNotTouchKeepsItsCovariance) {
  const InitResult answer = anAnswer();
  const NavState& last = answer.states.back();
  MsckfState state;
  ASSERT_TRUE(toMsckfState(answer, kTd, &state, nullptr));
  const Matrix15d before = newest(answer), after = matrixOf(state);
  EXPECT_LT((after - after.transpose()).norm(), 1e-15);
  EXPECT_EQ(Eigen::LLT<Matrix15d>(after).info(), Eigen::Success);
  const Eigen::Vector3d up_b = last.R_w_b.transpose() * Eigen::Vector3d::UnitZ();
  Eigen::Matrix<double, 12, 15> J = Eigen::Matrix<double, 12, 15>::Zero();
  // Velocity in the body, the vertical in the body, both biases; errors [theta, p, v, b_g, b_a].
  J.block<3, 3>(0, 0) = skew(last.R_w_b.transpose() * last.v_w_b);
  J.block<3, 3>(0, 6) = last.R_w_b.transpose();
  J.block<3, 3>(3, 0) = skew(up_b);
  J.block<6, 6>(6, 9).setIdentity();
  EXPECT_LT((J * after * J.transpose() - J * before * J.transpose()).norm(), 1e-12 * before.norm());
}

TEST(MsckfState, PositionAndHeadingAreWhatTheWorldIsDefinedBy) {
  const InitResult answer = anAnswer();
  const Eigen::Vector3d up_b = answer.states.back().R_w_b.transpose() * Eigen::Vector3d::UnitZ();
  MsckfState state;
  ASSERT_TRUE(toMsckfState(answer, kTd, &state, nullptr));
  const Matrix15d P = matrixOf(state);
  const double heading = up_b.dot(P.topLeftCorner<3, 3>() * up_b);
  EXPECT_NEAR(heading, kHeldHeading * kHeldHeading, 1e-12);
  EXPECT_GT(up_b.dot(newest(answer).topLeftCorner<3, 3>() * up_b), 1e-2);
  Rows position = P.middleRows<3>(3);
  EXPECT_LT(
      (position.middleCols<3>(3) - kHeldPosition * kHeldPosition * Eigen::Matrix3d::Identity())
          .norm(),
      1e-15);
  position.middleCols<3>(3).setZero();
  EXPECT_EQ(position.norm(), 0.0);
}

TEST(MsckfState, AnswersThatCannotBeHandedOverAreRefusedWithAReason) {
  const auto refusal = [](const InitResult& answer, double td) {
    MsckfState state;
    std::string error;
    EXPECT_FALSE(toMsckfState(answer, td, &state, &error));
    EXPECT_TRUE(state.empty());
    EXPECT_FALSE(toMsckfState(answer, td, &state, nullptr));
    return error;
  };
  InitResult answer = anAnswer();
  answer.covariance.resize(0, 0);
  EXPECT_NE(refusal(answer, kTd).find("no covariance"), std::string::npos);
  answer.states.clear();
  EXPECT_NE(refusal(answer, kTd).find("no states"), std::string::npos);
  EXPECT_NE(refusal(anAnswer(), kNotComputed).find("td"), std::string::npos);
  answer = anAnswer();
  answer.states.back().v_w_b.x() = kNotComputed;
  EXPECT_NE(refusal(answer, kTd).find("not finite"), std::string::npos);
  answer = anAnswer();
  answer.covariance(23, 23) = kNotComputed;
  EXPECT_NE(refusal(answer, kTd).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace slim_init::vins_adapter
