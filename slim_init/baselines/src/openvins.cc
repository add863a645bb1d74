// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <vector>

#include "closed_form.h"
#include "compared_methods.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "imu/preintegration.h"
#include "inertial_bundle_adjustment.h"
#include "loosely_coupled.h"
#include "pipeline/solver_support.h"
#include "scale/linear_motion.h"
#include "slim_init/text.h"
#include "verdict/gates.h"

namespace slim_init::baselines {
namespace {

// Summed angle of the gyroscope's steps over the window, as the release measures motion.
double turnedDeg(const InitWindow& window) {
  double angle = 0.0;
  const std::vector<ImuSample>& imu = window.imu();
  for (std::size_t i = 0; i + 1 < imu.size(); ++i) {
    angle += (0.5 * (imu[i].gyro + imu[i + 1].gyro) * (imu[i + 1].t - imu[i].t)).norm();
  }
  return angle * kDegPerRad;
}

// Tracks in front of the pinhole.
std::vector<int> chooseTracks(const InitWindow& window) {
  const std::vector<Track>& tracks = window.pointTracks();
  std::vector<int> chosen;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    const auto begin = window.pointObservations().begin();
    const bool in_front =
        std::all_of(begin + tracks[t].begin, begin + tracks[t].end,
                    [](const WindowPoint& observation) { return observation.bearing.z() > 0.0; });
    if (in_front) chosen.push_back(static_cast<int>(t));
  }
  return chosen;
}

// Enough tracks for the closed form, also against its unknowns.
bool hasEnoughTracks(const InitWindow& window, const std::vector<int>& tracks,
                     const OpenVinsOptions& options, InitResult* result) {
  int equations = 0;
  for (const int t : tracks) equations += 2 * window.pointTracks()[t].size();
  const int unknowns = 3 * static_cast<int>(tracks.size()) + 6;
  std::string message;
  if (tracks.size() < static_cast<std::size_t>(options.min_features)) {
    message = text(tracks.size(), " tracks (minimum ", options.min_features, ')');
  } else if (equations < unknowns) {
    message = text("the tracks give ", equations, " equations (minimum ", unknowns, ')');
  } else {
    return true;
  }
  fail(InitStatus::kTooFewTracks, message, result);
  return false;
}

// The motion of the closed form in the gravity-aligned world, biases zero.
std::vector<NavState> statesOf(const InitWindow& window, const LinearMotion& motion,
                               const std::vector<Eigen::Matrix3d>& R_b0_bk,
                               const ClosedForm& solution) {
  Eigen::Matrix<double, 9, 1> x;
  x << solution.velocity_b0, Eigen::Vector3d::Zero(), solution.gravity_b0;
  const WindowState estimate = motion.at(x);
  const Eigen::Matrix3d R_w_b0 = gravityAlignedAttitude(solution.gravity_b0);
  std::vector<NavState> states;
  for (int k = 0; k < window.size(); ++k) {
    NavState state;
    state.t = window.times()[k];
    state.R_w_b = R_w_b0 * R_b0_bk[k];
    state.p_w_b = R_w_b0 * estimate.p_b0.col(k);
    state.v_w_b = R_w_b0 * estimate.v_b0.col(k);
    states.push_back(state);
  }
  return states;
}

// The points in front of the first camera, in the world.
std::vector<MappedTrack> pointsInFront(const InitWindow& window, const std::vector<int>& tracks,
                                       const ClosedForm& solution) {
  const Calibration& calibration = window.calibration();
  const Eigen::Matrix3d R_w_b0 = gravityAlignedAttitude(solution.gravity_b0);
  std::vector<MappedTrack> points;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const Eigen::Vector3d& point = solution.points_b0[i];
    const double depth = calibration.R_b_c.col(2).dot(point - calibration.t_b_c);
    if (point.allFinite() && depth > 0.0) points.push_back({tracks[i], R_w_b0 * point});
  }
  return points;
}

// The refinement, and again with the IMU integrated at what it found. `pre` at zero biases.
bool refine(const InitWindow& window, std::vector<Preintegration> pre,
            const OpenVinsOptions& options, std::vector<NavState>* states,
            std::vector<MappedTrack>* points) {
  for (int pass = 0; pass <= options.relinearizations; ++pass) {
    for (std::size_t i = 0; pass > 0 && i < pre.size(); ++i) {
      const NavState& state = (*states)[i];
      pre[i] = preintegrate(window.imu(), state.t, (*states)[i + 1].t,
                            {state.gyro_bias, state.accel_bias}, window.calibration().imu_noise,
                            PreintegrationParts::kWithCovariance);
    }
    if (!adjustInertial(window, pre, options, states, points).converged) return false;
  }
  return true;
}

// States as the result has them: first body at the origin with zero yaw. `in_b0`: the same.
void setResult(const InitWindow& window, const std::vector<NavState>& states,
               const WindowState& in_b0, InitResult* result) {
  // The newest biases are what the release hands on.
  setWorldStates(window, in_b0, result);
  for (std::size_t k = 0; k < states.size(); ++k) {
    result->states[k].gyro_bias = states[k].gyro_bias;
    result->states[k].accel_bias = states[k].accel_bias;
  }
}

}  // namespace

InitResult solveOpenVins(const InitWindow& window, const InitializerOptions& options,
                         const BaselineOptions& baseline_options) {
  const OpenVinsOptions& openvins = baseline_options.openvins;
  const Calibration& calibration = window.calibration();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;

  // Enough motion and enough tracks.
  const std::vector<int> tracks = chooseTracks(window);
  if (!hasEnoughTracks(window, tracks, openvins, &result)) return result;
  const double turned_deg = turnedDeg(window);
  if (turned_deg < openvins.min_rotation_deg) {
    fail(InitStatus::kTooLittleExcitation,
         text("the gyroscope turned by ", turned_deg, " deg (minimum ", openvins.min_rotation_deg,
              ')'),
         &result);
    return result;
  }

  // Rotations and motion as the IMU predicts them; the biases are taken as zero.
  const std::vector<Preintegration> pre =
      preintegrateWindow(window, zero, zero, PreintegrationParts::kWithCovariance);
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const LinearMotion motion = linearMotion(pre, R_b0_bk, calibration.t_b_c);
  clock.lap("integration");

  // Points, first velocity and gravity in closed form (IROS 2012, eq. (14)).
  const ClosedForm solution = solveClosedForm(window, tracks, motion, R_b0_bk);
  clock.lap("closed_form");
  if (!solution.valid) {
    fail(InitStatus::kNumericalFailure, "the closed form is singular", &result);
    return result;
  }
  std::vector<MappedTrack> points = pointsInFront(window, tracks, solution);
  if (points.size() < static_cast<std::size_t>(openvins.min_features)) {
    fail(InitStatus::kNumericalFailure,
         text(points.size(), " points of the closed form lie in front of the camera (minimum ",
              openvins.min_features, ')'),
         &result);
    return result;
  }

  // Maximum likelihood over states, biases and points.
  std::vector<NavState> states = statesOf(window, motion, R_b0_bk, solution);
  const bool converged = refine(window, pre, openvins, &states, &points);
  clock.lap("maximum_likelihood");
  if (!converged) {
    fail(InitStatus::kNumericalFailure,
         text("the refinement has not converged after ", openvins.max_iterations, " iterations"),
         &result);
    return result;
  }
  const WindowState refined = windowStateOf(states, calibration.gravity_magnitude);
  setResult(window, states, refined, &result);
  const MotionMeasures measured = measureMotion(window, pre, refined.R_b0_bk);
  result.gates = motionGates(measured, options.gates);
  decide(options.gates.mode == GateMode::kOn, &result);
  keepObservable(measured.mean_force, calibration.gravity_magnitude, &result);
  clock.lap("verdict");
  return result;
}

}  // namespace slim_init::baselines
