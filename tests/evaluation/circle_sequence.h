// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/sequence.h"
#include "support/fake_solver.h"

namespace slim_init::evaluation {

/// A body on a circle, x along the velocity, on a closed form that needs no simulation library.
struct Circle {
  double radius_m = 2.0;
  double rate = 0.8;  ///< [rad/s]
  double g = Calibration().gravity_magnitude;
  Eigen::Vector3d gyro_bias = Eigen::Vector3d(0.01, -0.02, 0.03);

  NavState state(double t) const {
    const double angle = rate * t;
    NavState state;
    state.t = t;
    state.p_w_b = radius_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    state.v_w_b = radius_m * rate * Eigen::Vector3d(-std::sin(angle), std::cos(angle), 0.0);
    state.R_w_b = Eigen::AngleAxisd(angle + 0.5 * 3.14159265358979, Eigen::Vector3d::UnitZ())
                      .toRotationMatrix();
    state.gyro_bias = gyro_bias;
    return state;
  }

  ImuSample imu(double t) const {
    ImuSample sample;
    sample.t = t;
    sample.gyro = Eigen::Vector3d(0.0, 0.0, rate) + gyro_bias;
    // Towards the centre, which is the body's y axis, and against gravity.
    sample.accel = Eigen::Vector3d(0.0, radius_m * rate * rate, g);
    return sample;
  }
};

/// 200 Hz IMU and 20 Hz frames with three points each over [0, duration_s].
inline Sequence makeCircleSequence(double duration_s, const Circle& circle = Circle()) {
  Sequence sequence;
  sequence.name = "circle";
  sequence.t0_ns = 1000000000000000007;
  const int samples = static_cast<int>(std::lround(200.0 * duration_s));
  for (int k = 0; k <= samples; ++k) sequence.imu.push_back(circle.imu(k / 200.0));
  for (int k = 0; k <= samples; k += 10) {
    FrameObservation frame;
    frame.t = k / 200.0;
    for (int id = 0; id < 3; ++id) {
      PointObservation point;
      point.id = id;
      point.bearing = Eigen::Vector3d(0.1 * id, 0.001 * k, 1.0).normalized();
      frame.points.push_back(point);
    }
    sequence.frames.push_back(frame);
  }
  sequence.truth = [circle, duration_s](double t) {
    return t >= 0.0 && t <= duration_s ? circle.state(t) : NavState();
  };
  return sequence;
}

/// Takes the truth at one time [s] away.
inline void hideTruth(double t, Sequence* sequence) {
  sequence->truth = [t, truth = sequence->truth](double at) {
    return std::abs(at - t) < 1e-9 ? NavState() : truth(at);
  };
}

/// The truth as an answer.
inline InitResult perfectResult(const std::vector<NavState>& truth, double g) {
  InitResult result;
  result.status = InitStatus::kSuccess;
  result.message = "success";
  result.states = truth;
  result.gravity_w = Eigen::Vector3d(0.0, 0.0, -g);
  result.gravity_b0 = truth.front().R_w_b.transpose() * result.gravity_w;
  result.gyro_bias = truth.front().gyro_bias;
  return result;
}

/// The same at the keyframes of a window, or `shift` [s] after them.
inline InitResult perfectResult(const InitWindow& window, const Circle& circle = Circle(),
                                double shift = 0.0) {
  std::vector<NavState> states;
  for (const double t : window.times()) states.push_back(circle.state(t + shift));
  return perfectResult(states, circle.g);
}

/// A FakeSolver that knows the circle.
inline FakeSolver makePerfectSolver(const std::string& name, const Circle& circle = Circle()) {
  return FakeSolver(name,
                    [circle](const InitWindow& window) { return perfectResult(window, circle); });
}

}  // namespace slim_init::evaluation
