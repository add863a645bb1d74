// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What every solver does around its mathematics: stage times, counts, refusals, partial answers.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <string>
#include <vector>

#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "estimation/state_factor.h"
#include "imu/preintegration.h"
#include "imu/window_state.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/types.h"
#include "slim_init/work_budget.h"
#include "verdict/gates.h"

namespace slim_init {

/// Times the stages of a solve: lap("name") closes the stage that ran since the last lap.
class StageClock {
 public:
  explicit StageClock(InitResult* result) : result_(result), last_(Clock::now()) {}
  void lap(const char* name) {
    const Clock::time_point now = Clock::now();
    result_->stages.push_back(
        {name, std::chrono::duration<double, std::milli>(now - last_).count()});
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  InitResult* result_;
  Clock::time_point last_;
};

/// Sets the counts of the window. False, with status and message set, when it has fewer than
/// kMinKeyframes.
bool startResult(const InitWindow& window, InitResult* result);

/// Sets status and message.
void fail(InitStatus status, const std::string& message, InitResult* result);

/// A success, a provisional estimate or a refusal that a search might have changed which the budget
/// has left out becomes kTimeLimit, with both reasons. The budget forgets it.
void failAtLimit(WorkBudget* budget, InitResult* result);

/// Adds `gates` to those of the result.
void appendGates(const std::vector<GateValue>& gates, InitResult* result);

/// The motion as the tracks and `pre` show it, for motionGates().
MotionMeasures measureMotion(const InitWindow& window, const std::vector<Preintegration>& pre,
                             const std::vector<Eigen::Matrix3d>& R_b0_bk);

/// A window at known biases: they fix its attitudes until the refinement.
struct IntegratedWindow {
  std::vector<Preintegration> pre;       ///< with derivatives and covariance, a pair each
  std::vector<Eigen::Matrix3d> R_b0_bk;  ///< attitudes of the body
  std::vector<Eigen::Matrix3d> R_c0_ck;  ///< of the camera
  MotionMeasures motion;
};

/// By preintegrateInflated(); the standard deviation of the gyroscope bias is for leastMotionPx().
IntegratedWindow integrateWindow(const InitWindow& window, const ImuBiases& biases,
                                 const InertialOptions& inertial);

/// InitResult::scale: mean distance between consecutive camera centres [m]; NaN for fewer than two
/// states. `t_b_c`: camera centre in the body [m].
double meanBaseline(const std::vector<NavState>& states, const Eigen::Vector3d& t_b_c);

/// Turns a motion in b0 (bodyState(), where the rig is estimated) into the states, gravity, biases
/// and scale of `result`, in its gravity-aligned world. Keyframe times move with the error of td.
void setWorldStates(const InitWindow& window, const WindowState& state, InitResult* result);

/// Sets states, covariance, the calibration found and what became of measured velocities. `window`:
/// as it was refined.
void setEstimate(const InitWindow& window, const RefinedWindow& refined, const Posterior& posterior,
                 InitResult* result);

/// A window without translation holds no scale: where the status says so, removes what is not
/// observable and keeps the rest. Stationary: gravity from the mean specific force (at rest it is
/// minus gravity, plus a bias that cannot be told apart), and the gyroscope bias. Pure rotation:
/// the gyroscope bias.
void keepObservable(const Eigen::Vector3d& mean_force, double gravity_magnitude,
                    InitResult* result);

/// Moves `result` so that `here`, the body in its world, agrees with `there`, the body at the same
/// instant in another gravity-aligned world, in position and in heading. Roll and pitch stay: they
/// come from gravity.
void moveToFrame(const NavState& there, const NavState& here, InitResult* result);

/// Moves the result into the world of the state, whose pose the window corrects as far as its error
/// correlates with those of velocity, tilt and biases. `residual`: estimate minus state.
void moveToWorldOf(const StatePrior& prior, const StateVector& residual, InitResult* result);

/// Of the newest state; NaN without a covariance.
NewestSigmas newestSigmas(const InitResult& result);

/// Whether the newest state of `earlier` is the one that `now` has at that instant, by
/// testDifference(): lenient, as both share data. A window of a few images can have two motions
/// that explain the rotation of the images; more data change the wrong one by many standard
/// deviations. False where one of them has no covariance or they share no instant.
bool agrees(const InitResult& earlier, const InitResult& now);

}  // namespace slim_init
