// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/vins_adapter/host_convention.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "slim_init/text.h"

namespace slim_init::vins_adapter {
namespace {

// A rotation matrix that went through a file or many products is off by far less than this.
constexpr double kRotationTolerance = 1e-6;
// Horizontal length of the body's x axis (a unit vector) below which it has no heading.
constexpr double kVertical = 1e-9;

std::string checkStates(const std::vector<NavState>& states, double gravity_magnitude, double td) {
  if (states.empty()) return "there is no state to convert";
  if (!(gravity_magnitude > 0.0) || !std::isfinite(gravity_magnitude)) {
    return text("gravity_magnitude is ", gravity_magnitude, ", must be positive");
  }
  if (!std::isfinite(td)) return "td is not finite";
  for (size_t i = 0; i < states.size(); ++i) {
    const NavState& state = states[i];
    if (!state.isFinite()) {
      return text("state ", i, " has a value that is not finite");
    }
    const double error =
        (state.R_w_b.transpose() * state.R_w_b - Eigen::Matrix3d::Identity()).norm() +
        std::abs(state.R_w_b.determinant() - 1.0);
    if (error > kRotationTolerance) {
      return text("R_w_b of state ", i, " is ", error, " away from a rotation (limit ",
                  kRotationTolerance, ')');
    }
    if (i > 0 && !(state.t > states[i - 1].t)) {
      return roundedText(17, "time of state ", i, " is ", state.t, " s, must be after ",
                         states[i - 1].t);
    }
  }
  return "";
}

}  // namespace

std::vector<double> stampsOf(const std::vector<HostState>& window) {
  std::vector<double> stamps;
  for (const HostState& state : window) stamps.push_back(state.stamp);
  return stamps;
}

double hostYaw(const Eigen::Matrix3d& R_w_b) {
  const Eigen::Vector3d x = R_w_b.col(0);
  return x.head<2>().norm() < kVertical ? 0.0 : std::atan2(x.y(), x.x());
}

bool toHostWindow(const std::vector<NavState>& states, double gravity_magnitude, double td,
                  HostOrigin origin, HostWindow* window, std::string* error) {
  const std::string problem = checkStates(states, gravity_magnitude, td);
  if (!problem.empty()) {
    if (error != nullptr) *error = problem;
    return false;
  }

  // Gravity stays vertical under a turn about z: those four degrees of freedom are free.
  Eigen::Matrix3d R_h_w = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_w_h = Eigen::Vector3d::Zero();
  if (origin == HostOrigin::kFirstBody) {
    R_h_w = Eigen::AngleAxisd(-hostYaw(states.front().R_w_b), Eigen::Vector3d::UnitZ())
                .toRotationMatrix();
    p_w_h = states.front().p_w_b;
  }

  HostWindow result;
  result.G = Eigen::Vector3d(0.0, 0.0, gravity_magnitude);
  result.states.reserve(states.size());
  for (const NavState& state : states) {
    HostState host = toHostState(state, td);
    host.P = R_h_w * (host.P - p_w_h);
    host.R = R_h_w * host.R;
    host.V = R_h_w * host.V;
    result.states.push_back(host);
  }
  *window = std::move(result);
  return true;
}

FrameObservation toFrame(double stamp, const std::vector<double>& points) {
  FrameObservation frame;
  frame.t = stamp;
  for (std::size_t k = 0; k + 6 <= points.size(); k += 6) {
    PointObservation point;
    point.id = static_cast<FeatureId>(points[k]);
    point.bearing = Eigen::Vector3d(points[k + 1], points[k + 2], points[k + 3]);
    point.pixel = Eigen::Vector2d(points[k + 4], points[k + 5]);
    frame.points.push_back(point);
  }
  return frame;
}

HostState toHostState(const NavState& state, double td) {
  HostState host;
  host.stamp = state.t - td;
  host.P = state.p_w_b;
  host.R = state.R_w_b;
  host.V = state.v_w_b;
  host.Ba = state.accel_bias;
  host.Bg = state.gyro_bias;
  return host;
}

NavState fromHostState(const HostState& state, double td) {
  NavState result;
  result.t = state.stamp + td;
  result.R_w_b = state.R;
  result.p_w_b = state.P;
  result.v_w_b = state.V;
  result.gyro_bias = state.Bg;
  result.accel_bias = state.Ba;
  return result;
}

bool turnAboutVertical(const Eigen::Matrix3d& to, const Eigen::Matrix3d& from,
                       Eigen::Matrix3d* turn) {
  const Eigen::Matrix3d difference = to * from.transpose();
  const double sine = difference(1, 0) - difference(0, 1);
  const double cosine = difference(0, 0) + difference(1, 1);
  const double norm = std::hypot(sine, cosine);
  if (!(norm > 1e-3)) return false;
  *turn << cosine / norm, -sine / norm, 0.0, sine / norm, cosine / norm, 0.0, 0.0, 0.0, 1.0;
  return true;
}

void moveWindow(const HostState& anchor, HostWindow* window) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  turnAboutVertical(anchor.R, window->states.front().R, &R);
  const Eigen::Vector3d origin = window->states.front().P;
  for (HostState& state : window->states) {
    state.P = anchor.P + R * (state.P - origin);
    state.R = R * state.R;
    state.V = R * state.V;
  }
  // Of the errors that a row of the prior is about, the velocity is in the world.
  for (std::size_t row = 0; row < window->prior.size(); row += HostWindow::kPriorColumns) {
    Eigen::Map<Eigen::RowVector3d> by_velocity(&window->prior[row + 6]);
    by_velocity = (by_velocity * R.transpose()).eval();
  }
}

}  // namespace slim_init::vins_adapter
