// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/conversions.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/so3.h"
#include "support/jacobian_check.h"

namespace slim_init::node {
namespace {

constexpr std::int64_t kT0Ns = 1403715273262142976;

/// A success with two keyframes, made up.
Attempt someAttempt() {
  Attempt attempt;
  attempt.number = 5;
  attempt.t = 2.25;
  attempt.total_ms = 4.5;
  InitResult& result = attempt.result;
  result.status = InitStatus::kSuccess;
  result.message = "fine";
  for (int k = 0; k < 2; ++k) {
    NavState state;
    state.t = 2.0 + 0.25 * k + 0.01;  // td is 0.01
    state.R_w_b = Eigen::AngleAxisd(0.3 + k, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    state.p_w_b = Eigen::Vector3d(k, 2, 3);
    state.v_w_b = Eigen::Vector3d(0.5, -0.2, 0.1 * k);
    result.states.push_back(state);
  }
  result.gravity_w = Eigen::Vector3d(0, 0, -9.81);
  result.gyro_bias = Eigen::Vector3d(0.01, 0.02, 0.03);
  result.accel_bias = Eigen::Vector3d(0.1, 0.2, 0.3);
  result.scale = 3.5;
  result.scale_sigma = 0.02;
  result.covariance = Eigen::MatrixXd::Identity(24, 24);
  for (int i = 0; i < 24; ++i) result.covariance(i, i) = 1e-4 * (i + 1);
  result.covariance(9, 12) = result.covariance(12, 9) = 5e-5;
  GateValue gate;
  gate.name = GateName::kScaleSigma;
  gate.value = 0.02;
  gate.threshold = 0.1;
  gate.passed = true;
  result.gates.push_back(gate);
  result.stages.push_back({"refinement", 3.0});
  result.counts.keyframes = 2;
  return attempt;
}

ResultContext someContext() {
  ResultContext context;
  context.clock.seconds(kT0Ns);
  context.method = "slim";
  context.calibration.td = 0.01;
  context.calibration.t_b_c = Eigen::Vector3d(0.1, 0.2, 0.3);
  return context;
}

TEST(Conversions, StampsKeepTheirNanoseconds) {
  EXPECT_EQ(stampNs(rosTime(kT0Ns)), kT0Ns);
  EXPECT_EQ(rosTime(-5), ros::Time(0, 0));
}

TEST(Conversions, ImuSamplesThatAreNotFiniteAreGarbage) {
  sensor_msgs::Imu message;
  message.angular_velocity.y = 0.5;
  message.linear_acceleration.z = 9.81;
  ImuSample sample;
  sample.t = 3.0;
  EXPECT_EQ(readImu(message, &sample), "");
  EXPECT_EQ(sample.t, 3.0);
  EXPECT_EQ(sample.gyro, Eigen::Vector3d(0.0, 0.5, 0.0));
  EXPECT_EQ(sample.accel, Eigen::Vector3d(0.0, 0.0, 9.81));
  message.angular_velocity.x = kNotComputed;
  EXPECT_EQ(readImu(message, &sample), "a value is not finite");
}

TEST(Conversions, StatusHasTheEvidence) {
  const InitStatusMessage message = statusMessage(someAttempt(), someContext());
  EXPECT_EQ(message.status, InitStatusMessage::SUCCESS);
  EXPECT_EQ(message.status_name, "success");
  EXPECT_EQ(message.attempt, 5u);
  EXPECT_EQ(stampNs(message.header.stamp), kT0Ns + 2250000000);
  EXPECT_DOUBLE_EQ(message.window_s, 0.25);
  ASSERT_EQ(message.gates.size(), 1u);
  EXPECT_EQ(message.gates[0].threshold, 0.1);
  ASSERT_EQ(message.stages.size(), 1u);
  EXPECT_EQ(message.stages[0].ms, 3.0);

  Attempt empty;
  EXPECT_EQ(statusMessage(empty, someContext()).header.stamp, ros::Time());
}

TEST(Conversions, ResultHasStampsOfImagesAndTheStates) {
  const Attempt attempt = someAttempt();
  const InitResultMessage message = resultMessage(attempt, someContext());
  ASSERT_EQ(message.stamps.size(), 2u);
  EXPECT_EQ(stampNs(message.stamps[0]), kT0Ns + 2000000000);
  EXPECT_EQ(stampNs(message.header.stamp), kT0Ns + 2250000000);
  const auto& q = message.poses[1].orientation;
  EXPECT_LE(
      (Eigen::Quaterniond(q.w, q.x, q.y, q.z).matrix() - attempt.result.states[1].R_w_b).norm(),
      1e-12);
  EXPECT_EQ(message.gravity.z, -9.81);
  EXPECT_EQ(message.velocities[1].z, 0.1);
  ASSERT_EQ(message.covariance.size(), 24u * 24u);
  EXPECT_EQ(message.covariance[24 * 9 + 12], 5e-5);
  EXPECT_EQ(message.status.attempt, 5u);
}

TEST(Conversions, ExtrinsicIsEstimatedOrThatOfTheConfiguration) {
  Attempt attempt = someAttempt();
  InitResultMessage message = resultMessage(attempt, someContext());
  EXPECT_EQ(message.extrinsic.translation.y, 0.2);
  EXPECT_EQ(message.extrinsic.rotation.w, 1.0);
  EXPECT_EQ(message.td, 0.01);

  CalibrationEstimate& estimate = attempt.result.calibration.emplace();
  estimate.R_b_c = Eigen::AngleAxisd(M_PI_2, Eigen::Vector3d::UnitZ()).matrix();
  estimate.t_b_c = Eigen::Vector3d(-0.4, 0.5, 0.6);
  estimate.td = 0.02;
  message = resultMessage(attempt, someContext());
  EXPECT_EQ(message.extrinsic.translation.y, 0.5);
  EXPECT_NEAR(message.extrinsic.rotation.z, std::sqrt(0.5), 1e-12);
  EXPECT_EQ(message.td, 0.02);
}

// Against differences of what the message holds: pose (position; rotation about the world's axes)
// and velocity in the body frame as functions of [theta, p, v], theta on the body side.
TEST(Conversions, SeedCovariancesAreThoseOfTheMessagesQuantities) {
  const Attempt attempt = someAttempt();
  const nav_msgs::Odometry seed = seedMessage(attempt, someContext());
  const NavState& state = attempt.result.states.back();
  const auto quantities = [&](const Eigen::VectorXd& error) -> Eigen::VectorXd {
    const Eigen::Matrix3d R = state.R_w_b * expSO3(error.head<3>());
    Eigen::VectorXd q(12);
    q << state.p_w_b + error.segment<3>(3), logSO3(R * state.R_w_b.transpose()),
        R.transpose() * (state.v_w_b + error.tail<3>()), Eigen::Vector3d::Zero();
    return q;
  };
  const Eigen::MatrixXd J = numericJacobian(quantities, 9, 1e-6);
  const Eigen::MatrixXd P = attempt.result.covariance.block<9, 9>(9, 9);
  const Eigen::MatrixXd expected = J * P * J.transpose();
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      EXPECT_NEAR(seed.pose.covariance[6 * r + c], expected(r, c), 1e-9) << r << c;
      EXPECT_NEAR(seed.twist.covariance[6 * r + c], expected(6 + r, 6 + c), 1e-9) << r << c;
    }
  }
  EXPECT_EQ(seed.child_frame_id, "body");
  const Eigen::Vector3d v_b = state.R_w_b.transpose() * state.v_w_b;
  EXPECT_NEAR(seed.twist.twist.linear.x, v_b.x(), 1e-12);
  EXPECT_EQ(pathMessage(attempt, someContext()).poses.size(), 2u);
}

TEST(Conversions, MethodsWithoutCovarianceLeaveItZero) {
  Attempt attempt = someAttempt();
  attempt.result.covariance.resize(0, 0);
  EXPECT_TRUE(resultMessage(attempt, someContext()).covariance.empty());
  EXPECT_EQ(seedMessage(attempt, someContext()).pose.covariance[0], 0.0);
}

}  // namespace
}  // namespace slim_init::node
