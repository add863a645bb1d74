// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Core>

#include "data/derived_window.h"
#include "estimation/state_factor.h"
#include "pipeline/answers.h"
#include "pipeline/solver_support.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// Whether a bias is known beyond its prior, which is then that of the knowledge; else it is zero.
bool takesPlaceOf(double* prior, double sigma, Eigen::Vector3d* bias) {
  if (sigma < *prior) {
    *prior = sigma;
    return true;
  }
  bias->setZero();
  return false;
}

// Parts that were not computed stay so: NaN.
void addBiases(const ImuBiases& known, InitResult* result) {
  for (NavState& state : result->states) {
    state.gyro_bias += known.gyro;
    state.accel_bias += known.accel;
  }
  result->gyro_bias += known.gyro;
  result->accel_bias += known.accel;
}

// `result`: of the biases that are left, about zero; with a covariance.
bool contradicts(const InitResult& result, const InertialOptions& priors) {
  StateVector sigma;
  sigma << Eigen::Vector3d::Constant(kUnknown[0]), Eigen::Vector2d::Constant(kUnknown[1]),
      Eigen::Vector3d::Constant(priors.gyro_bias_prior),
      Eigen::Vector3d::Constant(priors.accel_bias_prior);
  const StateCovariance prior = sigma.cwiseAbs2().asDiagonal();
  StateCovariance posterior = prior;
  posterior.bottomRightCorner<6, 6>() = result.covariance.bottomRightCorner<6, 6>();
  StateVector moved = StateVector::Zero();
  moved.tail<6>() << result.gyro_bias, result.accel_bias;
  return testState(moved, prior, posterior).contradicts();
}

}  // namespace

InitResult answerAboutKnownBiases(const InitWindow& window, const SolveRequest& request,
                                  const InitializerOptions& options, WorkBudget* budget,
                                  InitResult (*solve)(const InitWindow&, const SolveRequest&,
                                                      const InitializerOptions&, WorkBudget*)) {
  ImuBiases known = window.calibration().imu_biases;
  InitializerOptions with_priors = options;
  InertialOptions& priors = with_priors.inertial;
  const bool gyro = takesPlaceOf(&priors.gyro_bias_prior, known.gyro_sigma, &known.gyro);
  const bool accel = takesPlaceOf(&priors.accel_bias_prior, known.accel_sigma, &known.accel);
  if (!gyro && !accel) return solve(window, request, options, budget);
  InitResult result = solve(*withoutBiases(window, known), request, with_priors, budget);
  const bool contradicted = result.hasEstimate() && result.covariance.size() > 0 &&
                            contradicts(result, with_priors.inertial);
  if (!contradicted && result.status != InitStatus::kInconsistentResiduals) {
    addBiases(known, &result);
    return result;
  }
  if (!budget->allows(
          "the solve without the biases known from before, which the data contradict")) {
    addBiases(known, &result);
    failAtLimit(budget, &result);
    return result;
  }
  result = solve(window, request, options, budget);
  if (!contradicted && !result.success()) return result;
  result.warnings.push_back(roundedText(3, "the prior biases, gyroscope (", known.gyro.transpose(),
                                        ") rad/s and accelerometer (", known.accel.transpose(),
                                        ") m/s^2, contradict the data and are not used"));
  return result;
}

}  // namespace slim_init
