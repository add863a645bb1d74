// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "compared_methods.h"
#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "loosely_coupled.h"
#include "pipeline/solver_support.h"
#include "slim_init/text.h"
#include "structure_from_motion.h"
#include "verdict/gates.h"

namespace slim_init::baselines {
namespace {

// T-RO 2018, section V-B-1: the bias that turns the gyroscope's rotations into those of the vision,
// a linear step about the last bias. The release makes one from zero; more only remove its
// linearisation error.
Eigen::Vector3d calibrateGyroBias(const InitWindow& window,
                                  const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  constexpr int kSteps = 3;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  for (int step = 0; step < kSteps; ++step) {
    const std::vector<Preintegration> pre =
        preintegrateWindow(window, bias, Eigen::Vector3d::Zero(), PreintegrationParts::kRotation);
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < pre.size(); ++i) {
      const Eigen::Matrix3d& J = pre[i].dR_dbg;
      H += J.transpose() * J;
      b += J.transpose() * logSO3(pre[i].dR.transpose() * R_b0_bk[i].transpose() * R_b0_bk[i + 1]);
    }
    bias += H.ldlt().solve(b);
  }
  return bias;
}

// The release's own checks, of velocities, gravity and scale without the constraint on |g| (section
// V-B-2).
bool acceptFreeAlignment(const AlignmentProblem& problem, const VinsOptions& options,
                         InitResult* result) {
  const AlignmentSystem system = buildBaseRows(problem);
  const Eigen::MatrixXd H = system.H.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd x = H.ldlt().solve(system.b);
  const double scale = x[x.size() - 4], gravity = x.tail<3>().norm();
  const double expected = problem.window.calibration().gravity_magnitude;
  std::string message;
  if (!(std::abs(gravity - expected) <= options.max_gravity_residual)) {
    message = text("free gravity of the alignment is ", gravity, " m/s^2 (limit ", expected, " +- ",
                   options.max_gravity_residual, ')');
  } else if (!(scale >= 0.0)) {
    message = text("free scale of the alignment is ", scale, " (minimum 0)");
  } else {
    return true;
  }
  fail(InitStatus::kDegenerateAlignment, message, result);
  return false;
}

}  // namespace

InitResult solveVins(const InitWindow& window, const InitializerOptions& options,
                     const BaselineOptions& baseline_options) {
  const VinsOptions& vins = baseline_options.vins;
  const Calibration& calibration = window.calibration();
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;

  // Camera poses up to scale by structure from motion (section V-A).
  const StructureFromMotion sfm = reconstruct(window, vins);
  clock.lap("structure_from_motion");
  if (!sfm.valid()) {
    fail(sfm.status, sfm.message, &result);
    return result;
  }
  std::vector<Eigen::Matrix3d> R_b0_bk;
  for (const Eigen::Matrix3d& R_c0_ck : sfm.R_c0_ck) {
    R_b0_bk.push_back(calibration.R_b_c * R_c0_ck * calibration.R_b_c.transpose());
  }
  const Eigen::Matrix3Xd centres_b0 = calibration.R_b_c * sfm.centres_c0;

  // Gyroscope bias, and the preintegration with it.
  result.gyro_bias = calibrateGyroBias(window, R_b0_bk);
  const std::vector<Preintegration> pre = preintegrateWindow(
      window, result.gyro_bias, Eigen::Vector3d::Zero(), PreintegrationParts::kMean);
  const MotionMeasures motion = measureMotion(window, pre, R_b0_bk);
  result.gates = motionGates(motion, options.gates);
  clock.lap("gyro_bias");

  // Velocities, gravity and scale linearly, then with gravity on its sphere (section V-B-3): the
  // release's four steps in the tangent plane end in the minimum that alignLinear() solves for.
  const AlignmentProblem problem = {window, pre, R_b0_bk, centres_b0, LineTerms()};
  if (!acceptFreeAlignment(problem, vins, &result)) return result;
  const AlignmentEstimate alignment = alignLinear(problem);
  clock.lap("alignment");
  if (!alignment.valid || !(alignment.scale >= 0.0)) {
    fail(InitStatus::kDegenerateAlignment,
         "the alignment with gravity on its sphere is singular or has a negative scale", &result);
    return result;
  }

  const WindowState state = stateOf(R_b0_bk, result.gyro_bias, alignment);
  setWorldStates(window, state, &result);
  result.scale_sigma = alignment.scale_sigma;
  for (const GateValue& gate :
       alignmentGates({kNotComputed, cameraSpread(window, state), alignment.residual_rms,
                       alignment.scale_sigma},
                      gatesInForce(options.gates, window, options.window).max_scale_sigma)) {
    // Of the linear translation system, which this method does not have.
    if (gate.name != GateName::kLinkage) result.gates.push_back(gate);
  }
  decide(options.gates.mode == GateMode::kOn, &result);
  keepObservable(motion.mean_force, calibration.gravity_magnitude, &result);
  clock.lap("verdict");
  return result;
}

}  // namespace slim_init::baselines
