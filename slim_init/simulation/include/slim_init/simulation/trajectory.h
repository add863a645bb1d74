// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Body motion as a function of time.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "slim_init/types.h"

namespace slim_init::simulation {

/// Motion of the body at one time. World w: z up.
struct Kinematics {
  Eigen::Matrix3d R_w_b = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_w_b = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Vector3d v_w_b = Eigen::Vector3d::Zero();    ///< [m/s]
  Eigen::Vector3d a_w_b = Eigen::Vector3d::Zero();    ///< d v_w_b / dt [m/s^2]
  Eigen::Vector3d omega_b = Eigen::Vector3d::Zero();  ///< angular rate in b [rad/s]
};

/// A smooth motion over [begin(), end()]. Thread-safe for const calls.
class Trajectory {
 public:
  virtual ~Trajectory() = default;
  virtual double begin() const = 0;  ///< [s]
  virtual double end() const = 0;    ///< [s]
  /// Motion at time t [s]; t is clamped to [begin(), end()].
  virtual Kinematics at(double t) const = 0;
  /// True where at(t) is to be trusted: inside [begin(), end()] and not inside a gap of a
  /// recording.
  virtual bool covers(double t) const { return t >= begin() && t <= end(); }
};

/// Pose and velocity at time t [s]; the biases are those of a NavState.
NavState stateAt(const Trajectory& trajectory, double t);

/// Names of the built-in analytic motions: "hover", "circle", "figure-eight", "corridor-walk"
/// (forward along x with human sway), "constant-velocity" (nearly constant, little parallax),
/// "pure-rotation".
const std::vector<std::string>& builtinTrajectoryNames();

/// Makes a built-in motion over [0, duration_s], about 1.5 m above the floor z = 0. The camera of
/// `R_b_c` looks along x on average, which for the walks is the direction of travel. All
/// derivatives are exact. `seed` sets the phases. Unknown name: null, and a message in `error`.
std::unique_ptr<Trajectory> makeBuiltinTrajectory(const std::string& name, double duration_s,
                                                  const Eigen::Matrix3d& R_b_c, unsigned seed,
                                                  std::string* error = nullptr);

/// Interpolates recorded poses: a cubic through the four nearest samples, in position and in the
/// tangent space of the rotation. Needs at least four samples with finite poses and ascending
/// times, else null and a message in `error`. Velocity comes from the samples' v_w_b where all
/// four are finite, else from the derivative of the cubic; a_w_b is the derivative of that
/// velocity, omega_b of the rotation. Pose is continuous; its derivatives step slightly at the
/// samples. A gap of more than 0.3 s between samples is interpolated all the same, but covers() is
/// false inside it, as it is where fewer than four samples stand together.
std::unique_ptr<Trajectory> makeSampledTrajectory(std::vector<NavState> samples,
                                                  std::string* error = nullptr);

/// A recorded motion to simulate an IMU from. makeSampledTrajectory() stays closest to the record,
/// but the accelerations it takes from positions do not integrate back to them (5 cm over 2.25 s on
/// TUM-VI's corridor) and amplify the record's noise. Here the position is a cubic spline, natural
/// at both ends, with continuous acceleration, through the samples thinned to `max_rate_hz`;
/// recorded velocities are not used. Rotation, gaps and errors as for makeSampledTrajectory().
std::unique_ptr<Trajectory> makeSmoothTrajectory(const std::vector<NavState>& samples,
                                                 double max_rate_hz = 20.0,
                                                 std::string* error = nullptr);

}  // namespace slim_init::simulation
