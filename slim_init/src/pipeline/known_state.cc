// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/known_state.h"

#include <algorithm>
#include <cmath>

#include "data/derived_window.h"
#include "geometry/dense.h"
#include "geometry/so3.h"
#include "pipeline/solver_support.h"
#include "scale/linear_motion.h"

namespace slim_init {

std::shared_ptr<const InitWindow> windowOfState(const InitWindow& window, const StatePrior& prior,
                                                InitResult* result) {
  std::shared_ptr<const InitWindow> through = unowned(window);
  std::string problem;
  if (const std::string invalid = prior.validate(); !invalid.empty()) {
    problem = invalid;
  } else if (!isPositiveDefinite(stateFactor(prior).covariance)) {
    problem =
        "the covariance of the last healthy state is not positive definite in velocity, tilt and "
        "biases";
  } else if (!(std::abs(prior.state.t - window.times().front()) < kStampRounding)) {
    problem = "the last healthy state is not that of the first keyframe";
  } else if (prior.calibration.has_value()) {
    CalibrationEstimate extrinsics = *prior.calibration;
    if (!prior.at_rest) extrinsics.covariance(6, 6) = 0.0;  // its time is with the host's td
    through = withCalibration(window, withFound(window.calibration(), extrinsics));
    if (through == nullptr) problem = "the calibration of the last healthy state is not valid";
  }
  if (problem.empty()) return through;
  fail(InitStatus::kInvalidInput, problem, result);
  return nullptr;
}

WindowState deadReckoned(const StateFactor& known, const std::vector<Preintegration>& pre,
                         double gravity_magnitude) {
  Eigen::Matrix<double, 9, 1> x;
  x << known.velocity_b, Eigen::Vector3d::Zero(), gravity_magnitude * known.down_b;
  return linearMotion(pre, chainRotations(pre), Eigen::Vector3d::Zero()).at(x);
}

std::string dropContradicted(const InitWindow& tracks, const RefinedWindow& refined,
                             const std::vector<std::string>& dropped, StateFactor* known,
                             StateVector* residual) {
  const WindowState& state = refined.state;
  const std::vector<ImuInstant> instants =
      imuInstants(tracks, coveredShift(tracks, state.rig.dtd), state.gyro_bias, state.accel_bias);
  const StateResidual rows = stateResidual(state, *known, tracks.calibration(), instants.front());
  *residual = rows.r;
  // Errors of the rows by those of the estimate, for their covariance there.
  const StateLayout at(state.size(), true);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(at.size() - StateLayout::kGauge, kStateRows);
  J.middleRows<3>(at.velocity(0) - StateLayout::kGauge) = rows.J.leftCols<3>().transpose();
  J.middleRows<kStateColumns - 3>(at.gyroBias() - StateLayout::kGauge) =
      rows.J.rightCols<kStateColumns - 3>().transpose();
  Eigen::MatrixXd posterior;
  if (!inverseSeenBy(refined.information, J, &posterior)) return "";
  const StateTest test = testState(rows.r, known->covariance, posterior);
  if (!test.contradicts()) return "";
  const StatePart part = worstPart(test);
  const std::string name = toString(part);
  if (std::count(dropped.begin(), dropped.end(), name) > 0) return "";
  known->covariance = without(known->covariance, part);
  return name;
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

}  // namespace slim_init
