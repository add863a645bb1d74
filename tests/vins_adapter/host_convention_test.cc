// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_convention.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace slim_init::vins_adapter {
namespace {

constexpr double kG = 9.81007;
constexpr double kTolerance = 1e-12;

Eigen::Matrix3d yawPitchRoll(double yaw, double pitch, double roll) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

// A body in free motion under a constant specific force, so that inertial quantities are known.
const Eigen::Vector3d kAcceleration(0.3, -0.2, 0.5);

std::vector<NavState> makeStates() {
  std::vector<NavState> states;
  const Eigen::Vector3d v0(1.0, -2.0, 0.5);
  for (int i = 0; i < 11; ++i) {
    const double t = 0.1 * i;
    NavState state;
    state.t = 1403636580.5 + t;
    state.R_w_b = yawPitchRoll(0.7 + 0.3 * t, -0.2 + 0.1 * t, 0.4 - 0.2 * t);
    state.p_w_b = Eigen::Vector3d(3.0, -4.0, 1.5) + v0 * t + 0.5 * kAcceleration * t * t;
    state.v_w_b = v0 + kAcceleration * t;
    state.gyro_bias = Eigen::Vector3d(0.01, 0.02, 0.03);
    state.accel_bias = Eigen::Vector3d(0.1, -0.1, 0.05);
    states.push_back(state);
  }
  return states;
}

TEST(HostConvention, FirstStartBeginsAtZeroPositionAndYaw) {
  const std::vector<NavState> states = makeStates();
  HostWindow window;
  std::string error;
  ASSERT_TRUE(toHostWindow(states, kG, 0.0, HostOrigin::kFirstBody, &window, &error)) << error;
  ASSERT_EQ(window.states.size(), states.size());
  EXPECT_EQ(window.states[0].P, Eigen::Vector3d::Zero());
  EXPECT_NEAR(hostYaw(window.states[0].R), 0.0, kTolerance);
  // Roll and pitch are measured against gravity and must not move.
  EXPECT_LT((window.states[0].R - yawPitchRoll(0.0, -0.2, 0.4)).norm(), kTolerance);
}

// The sign of G is the whole conversion: what the host predicts from its states must be what the
// accelerometer reads. In the host's terms: specific force = R^T (dV/dt + G).
TEST(HostConvention, HostPredictsTheSpecificForceOfOurMotion) {
  const std::vector<NavState> states = makeStates();
  HostWindow window;
  ASSERT_TRUE(toHostWindow(states, kG, 0.0, HostOrigin::kFirstBody, &window, nullptr));
  const Eigen::Vector3d gravity_w(0.0, 0.0, -kG);
  for (size_t i = 0; i + 1 < states.size(); ++i) {
    const double dt = states[i + 1].t - states[i].t;
    const Eigen::Vector3d ours =
        states[i].R_w_b.transpose() * ((states[i + 1].v_w_b - states[i].v_w_b) / dt - gravity_w);
    const Eigen::Vector3d theirs = window.states[i].R.transpose() *
                                   ((window.states[i + 1].V - window.states[i].V) / dt + window.G);
    EXPECT_LT((ours - theirs).norm(), 1e-9) << i;
    // And the displacement: R^T (P1 - P0 - V0 dt + G dt^2 / 2) is the host's position increment.
    const Eigen::Vector3d alpha_ours =
        states[i].R_w_b.transpose() *
        (states[i + 1].p_w_b - states[i].p_w_b - states[i].v_w_b * dt - 0.5 * gravity_w * dt * dt);
    const Eigen::Vector3d alpha_theirs =
        window.states[i].R.transpose() * (window.states[i + 1].P - window.states[i].P -
                                          window.states[i].V * dt + 0.5 * window.G * dt * dt);
    EXPECT_LT((alpha_ours - alpha_theirs).norm(), 1e-9) << i;
  }
}

TEST(HostConvention, AMovedWindowKeepsWhatItsPriorKnows) {
  HostWindow window;
  ASSERT_TRUE(toHostWindow(makeStates(), kG, 0.0, HostOrigin::kKeep, &window, nullptr));
  for (int i = 0; i < 2 * HostWindow::kPriorColumns; ++i) window.prior.push_back(std::sin(i));
  const HostWindow before = window;
  HostState anchor;
  anchor.P = Eigen::Vector3d(3.0, -1.0, 2.0);
  anchor.R = yawPitchRoll(2.0, 0.3, -0.2);
  moveWindow(anchor, &window);
  const HostState &was = before.states.back(), &is = window.states.back();
  const Eigen::Matrix3d turn = is.R * was.R.transpose();
  EXPECT_LT((window.states.front().P - anchor.P).norm(), kTolerance);
  EXPECT_LT((turn.col(2) - Eigen::Vector3d::UnitZ()).norm(), kTolerance);
  EXPECT_LT((is.V - turn * was.V).norm(), kTolerance);
  const Eigen::Vector3d error(0.1, 0.2, -0.3);
  for (std::size_t i = 0; i < window.prior.size(); i += 3) {
    const bool of_velocity = i % HostWindow::kPriorColumns == 6;
    const Eigen::Map<const Eigen::RowVector3d> by_was(&before.prior[i]), by_is(&window.prior[i]);
    EXPECT_NEAR(by_is.dot(of_velocity ? Eigen::Vector3d(turn * error) : error), by_was.dot(error),
                kTolerance)
        << i;
  }
}

TEST(HostConvention, RecoveryStaysInTheOldFrameAndComesBack) {
  const std::vector<NavState> states = makeStates();
  const double td = 0.013;
  HostWindow window;
  ASSERT_TRUE(toHostWindow(states, kG, td, HostOrigin::kKeep, &window, nullptr));
  for (size_t i = 0; i < states.size(); ++i) {
    EXPECT_NEAR(window.states[i].stamp, states[i].t - td, 1e-6);
    EXPECT_EQ(window.states[i].P, states[i].p_w_b);
    const NavState back = fromHostState(window.states[i], td);
    EXPECT_NEAR(back.t, states[i].t, 1e-6);
    EXPECT_EQ(back.R_w_b, states[i].R_w_b);
    EXPECT_EQ(back.p_w_b, states[i].p_w_b);
    EXPECT_EQ(back.v_w_b, states[i].v_w_b);
    EXPECT_EQ(back.gyro_bias, states[i].gyro_bias);
    EXPECT_EQ(back.accel_bias, states[i].accel_bias);
  }
}

TEST(HostConvention, VerticalBodyAxisHasNoYaw) {
  const Eigen::Matrix3d up = yawPitchRoll(0.0, -M_PI / 2, 0.0);
  EXPECT_EQ(hostYaw(up), 0.0);
  std::vector<NavState> states = makeStates();
  states[0].R_w_b = up;
  HostWindow window;
  ASSERT_TRUE(toHostWindow(states, kG, 0.0, HostOrigin::kFirstBody, &window, nullptr));
  EXPECT_LT((window.states[0].R - up).norm(), kTolerance);
}

TEST(HostConvention, BadInputIsRefusedAndWritesNothing) {
  using States = std::vector<NavState>;
  const struct {
    const char* words;  // of the message
    void (*spoil)(States*, double* gravity);
  } cases[] = {
      {"no state", [](States* s, double*) { s->clear(); }},
      {"gravity_magnitude is -9.8", [](States*, double* gravity) { *gravity = -9.8; }},
      {"state 4", [](States* s, double*) { (*s)[4].v_w_b.x() = kNotComputed; }},
      {"state 2 is", [](States* s, double*) { (*s)[2].R_w_b *= 1.01; }},
      {"state 1 is", [](States* s, double*) { (*s)[1].R_w_b.col(0) *= -1.0; }},
      {"time of state 5", [](States* s, double*) { (*s)[5].t = (*s)[4].t; }},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.words);
    States states = makeStates();
    double gravity = kG;
    one.spoil(&states, &gravity);
    HostWindow window;
    window.G = Eigen::Vector3d(1.0, 2.0, 3.0);
    std::string error;
    EXPECT_FALSE(toHostWindow(states, gravity, 0.0, HostOrigin::kFirstBody, &window, &error));
    EXPECT_NE(error.find(one.words), std::string::npos) << error;
    EXPECT_EQ(window.G, Eigen::Vector3d(1.0, 2.0, 3.0));
    EXPECT_TRUE(window.states.empty());
    EXPECT_FALSE(toHostWindow(states, gravity, 0.0, HostOrigin::kFirstBody, &window, nullptr));
  }
}

}  // namespace
}  // namespace slim_init::vins_adapter
