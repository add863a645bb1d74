// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/solver_support.h"

#include <algorithm>
#include <cmath>

#include "estimation/refine_window.h"
#include "estimation/speed_factor.h"
#include "estimation/state_factor.h"
#include "geometry/dense.h"
#include "geometry/so3.h"
#include "geometry/units.h"
#include "slim_init/text.h"

namespace slim_init {

namespace {

// Speeds that have to be there before the scale may rest on them: one that slips among fewer does
// not show.
constexpr int kFewestSpeeds = 3;
/// An estimated td moves the instants of the same image by less than this [s].
constexpr double kSameInstant = 0.01;

// The state of one keyframe and its covariance.
StateFactor stateOf(const InitResult& result, std::size_t k) {
  StatePrior state;
  state.state = result.states[k];
  state.covariance = result.stateCovariance(k);
  return stateFactor(state);
}

}  // namespace

bool startResult(const InitWindow& window, InitResult* result) {
  result->counts = {window.size(), static_cast<int>(window.pointTracks().size()),
                    static_cast<int>(window.lineTracks().size()),
                    static_cast<int>(window.lineObservations().size())};
  if (window.size() >= kMinKeyframes) return true;
  fail(InitStatus::kTooFewKeyframes,
       text("window holds ", window.size(), " keyframes (minimum ", kMinKeyframes, ")"), result);
  return false;
}

void fail(InitStatus status, const std::string& message, InitResult* result) {
  result->status = status;
  result->message = message;
}

void failAtLimit(WorkBudget* budget, InitResult* result) {
  const std::string left_out = budget->takeLeftOut();
  const bool waits = isWait(result->status) && !result->provisional();
  if (left_out.empty() || waits || result->status == InitStatus::kInvalidInput) return;
  const bool had_reason = !result->success() && !result->provisional();
  fail(InitStatus::kTimeLimit, had_reason ? left_out + "; " + result->message : left_out, result);
}

void appendGates(const std::vector<GateValue>& gates, InitResult* result) {
  result->gates.insert(result->gates.end(), gates.begin(), gates.end());
}

MotionMeasures measureMotion(const InitWindow& window, const std::vector<Preintegration>& pre,
                             const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  MotionMeasures motion;
  measureTracks(window, cameraRotations(R_b0_bk, window.calibration().R_b_c), &motion);
  motion.rotation_deg = maxRotationDeg(R_b0_bk);
  measureForce(pre, R_b0_bk, &motion);
  motion.has_speeds = static_cast<int>(speedFactors(window, 0.0).size()) >= kFewestSpeeds;
  return motion;
}

IntegratedWindow integrateWindow(const InitWindow& window, const ImuBiases& biases,
                                 const InertialOptions& inertial) {
  IntegratedWindow out;
  out.pre = preintegrateInflated(window, biases.gyro, biases.accel, inertial);
  out.R_b0_bk = chainRotations(out.pre);
  out.R_c0_ck = cameraRotations(out.R_b0_bk, window.calibration().R_b_c);
  out.motion = measureMotion(window, out.pre, out.R_b0_bk);
  out.motion.least_motion_px = leastMotionPx(window, biases.gyro_sigma, out.R_c0_ck);
  return out;
}

double meanBaseline(const std::vector<NavState>& states, const Eigen::Vector3d& t_b_c) {
  if (states.size() < 2) return kNotComputed;
  double sum = 0.0;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const NavState &a = states[k - 1], &b = states[k];
    sum += (b.p_w_b + b.R_w_b * t_b_c - a.p_w_b - a.R_w_b * t_b_c).norm();
  }
  return sum / static_cast<double>(states.size() - 1);
}

void setWorldStates(const InitWindow& window, const WindowState& state, InitResult* result) {
  const Eigen::Matrix3d R_w_b0 = gravityAlignedAttitude(state.gravity_b0);
  result->gravity_w = Eigen::Vector3d(0.0, 0.0, -window.calibration().gravity_magnitude);
  result->gravity_b0 = state.gravity_b0;
  result->gyro_bias = state.gyro_bias;
  result->accel_bias = state.accel_bias;
  result->states.clear();
  for (int k = 0; k < state.size(); ++k) {
    NavState out;
    out.t = window.times()[k] + state.rig.dtd;
    out.R_w_b = R_w_b0 * state.R_b0_bk[k];
    out.p_w_b = R_w_b0 * state.p_b0.col(k);
    out.v_w_b = R_w_b0 * state.v_b0.col(k);
    out.gyro_bias = state.gyro_bias;
    out.accel_bias = state.accel_bias;
    result->states.push_back(out);
  }
  result->scale = meanBaseline(result->states, window.calibration().t_b_c + state.rig.dt);
}

namespace {

// The calibration of the window with the estimated error, and its covariance.
CalibrationEstimate calibrationEstimate(const Calibration& calibration, const RigError& rig,
                                        const Posterior& posterior) {
  CalibrationEstimate out;
  out.R_b_c = nearestRotation(calibration.R_b_c * rig.dR);
  out.t_b_c = calibration.t_b_c + rig.dt;
  out.td = calibration.td + rig.dtd;
  out.readout_s = std::max(0.0, calibration.readout_s + rig.dreadout);
  out.covariance = posterior.rig_covariance;
  const CalibrationSigmas& sigmas = calibration.sigmas;
  const auto hold = [&out](int at, int size) {
    out.covariance.middleRows(at, size).setZero();
    out.covariance.middleCols(at, size).setZero();
  };
  if (sigmas.rotation_deg == 0.0) hold(0, 3);
  if (sigmas.translation_m == 0.0) hold(3, 3);
  if (sigmas.td_s == 0.0) hold(6, 1);
  // A readout time that was not estimated was held.
  if (!(out.covariance(7, 7) > 2.0 / kHold)) hold(7, 1);
  return out;
}

// InitResult::speeds, with a warning where some were contradicted and where keyframes had none.
void setSpeeds(const InitWindow& window, const SpeedUse& use, InitResult* result) {
  if (window.speeds().empty()) return;
  result->speeds = use;
  result->speeds.missing = window.size() - use.keyframes;
  if (use.contradicted > 0) {
    result->warnings.push_back(
        std::to_string(use.contradicted) + " of " + std::to_string(use.keyframes) +
        " measured velocities contradict the motion and have little weight: "
        "a slipping wheel, or an incorrect scale or extrinsic of the sensor");
  }
  // The newest keyframe is ahead of the newest velocity.
  const bool without_newest = window.speeds().back().t < window.times().back();
  if (result->speeds.missing == (without_newest ? 1 : 0)) return;
  result->warnings.push_back(text("no measured velocity at ", result->speeds.missing, " of ",
                                  window.size(), " keyframes: none on both sides within ",
                                  InitWindow::kMaxSpeedGap, " s"));
}

// The rotation about z that brings R_b closest to R_a. Unlike the difference of two yaw angles it
// is well defined for every mounting, also with a body axis pointing up (EuRoC's x axis does).
Eigen::Matrix3d yawBetween(const Eigen::Matrix3d& R_a, const Eigen::Matrix3d& R_b) {
  const Eigen::Matrix3d M = R_a * R_b.transpose();
  const double yaw = std::atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1));
  return expSO3(Eigen::Vector3d(0.0, 0.0, yaw));
}

}  // namespace

void setEstimate(const InitWindow& window, const RefinedWindow& refined, const Posterior& posterior,
                 InitResult* result) {
  const Calibration& calibration = window.calibration();
  setWorldStates(window, bodyState(refined.state, calibration.R_b_c, calibration.t_b_c), result);
  result->calibration = calibrationEstimate(calibration, refined.state.rig, posterior);
  setSpeeds(window, refined.speeds, result);
  result->covariance = posterior.covariance;
}

void keepObservable(const Eigen::Vector3d& mean_force, double gravity_magnitude,
                    InitResult* result) {
  const InitStatus status = result->status;
  if (status != InitStatus::kStationary && status != InitStatus::kPureRotation) return;
  result->states.clear();
  result->scale = kNotComputed;
  result->scale_sigma = kNotComputed;
  result->gravity_w.setConstant(kNotComputed);
  result->gravity_b0.setConstant(kNotComputed);
  result->accel_bias.setConstant(kNotComputed);
  if (status == InitStatus::kPureRotation) return;
  // At rest the mean specific force is minus gravity.
  result->gravity_b0 = -gravity_magnitude * mean_force.normalized();
  result->gravity_w = Eigen::Vector3d(0.0, 0.0, -gravity_magnitude);
}

void moveToFrame(const NavState& there, const NavState& here, InitResult* result) {
  const Eigen::Matrix3d R = yawBetween(there.R_w_b, here.R_w_b);
  const Eigen::Vector3d t = there.p_w_b - R * here.p_w_b;
  for (NavState& state : result->states) {
    state.R_w_b = R * state.R_w_b;
    state.p_w_b = R * state.p_w_b + t;
    state.v_w_b = R * state.v_w_b;
  }
  // Attitude errors stand on the body side and do not turn; those of p and v do.
  if (result->covariance.size() == 0) return;
  Eigen::MatrixXd T =
      Eigen::MatrixXd::Identity(result->covariance.rows(), result->covariance.cols());
  for (std::size_t k = 0; k < result->states.size(); ++k) {
    T.block<3, 3>(9 * k + 3, 9 * k + 3) = R;
    T.block<3, 3>(9 * k + 6, 9 * k + 6) = R;
  }
  result->covariance = T * result->covariance * T.transpose();
}

// Of the parts that were dropped the state claims too much, and what follows from them follows all
// the same.
void moveToWorldOf(const StatePrior& prior, const StateVector& residual, InitResult* result) {
  const Eigen::Matrix<double, kStateRows, 15> Y = stateRows(prior.state);
  const Eigen::MatrixXd PY = product(prior.covariance, Y.transpose());
  const Eigen::Matrix<double, 15, 1> step = product(PY, solveSymmetric(product(Y, PY), residual));
  NavState there = prior.state;
  there.R_w_b = there.R_w_b * expSO3(step.head<3>());
  // An estimated td has moved the first keyframe.
  there.p_w_b += step.segment<3>(3) + (result->states.front().t - there.t) * there.v_w_b;
  moveToFrame(there, result->states.front(), result);
}

NewestSigmas newestSigmas(const InitResult& result) {
  NewestSigmas out;
  if (result.states.empty()) return out;
  const StateCovariance S = stateOf(result, result.states.size() - 1).covariance;
  if (!S.allFinite()) return out;
  const auto largest = [](const DenseView& A) {
    return std::sqrt(symmetricEigen(A).values.maxCoeff());
  };
  out.velocity = largest(S.topLeftCorner<3, 3>());
  out.tilt_deg = largest(S.block<2, 2>(3, 3)) * kDegPerRad;
  return out;
}

bool agrees(const InitResult& earlier, const InitResult& now) {
  if (earlier.states.empty() || now.states.empty()) return false;
  const double t = earlier.states.back().t;
  const auto nearest = std::min_element(
      now.states.begin(), now.states.end(),
      [t](const NavState& a, const NavState& b) { return std::abs(a.t - t) < std::abs(b.t - t); });
  if (!(std::abs(nearest->t - t) < kSameInstant)) return false;
  const StateTest test = testDifference(stateOf(earlier, earlier.states.size() - 1),
                                        stateOf(now, nearest - now.states.begin()));
  return test.total <= test.bound() && !test.contradicts();
}

}  // namespace slim_init
