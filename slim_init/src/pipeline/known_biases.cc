// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/known_biases.h"

#include <Eigen/Core>
#include <limits>

#include "data/with_calibration.h"
#include "estimation/constants.h"
#include "estimation/state_factor.h"
#include "pipeline/solver_support.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

// What is known beyond the priors: the rest of it is zero.
ImuBiases usefulBiases(ImuBiases known, const InertialOptions& priors) {
  if (!(known.gyro_sigma < priors.gyro_bias_prior)) {
    known.gyro.setZero();
    known.gyro_sigma = kNothing;
  }
  if (!(known.accel_sigma < priors.accel_bias_prior)) {
    known.accel.setZero();
    known.accel_sigma = kNothing;
  }
  return known;
}

bool isEmpty(const ImuBiases& known) {
  return known.gyro_sigma == kNothing && known.accel_sigma == kNothing;
}

InitializerOptions withPriors(InitializerOptions options, const ImuBiases& known) {
  InertialOptions& inertial = options.inertial;
  if (known.gyro_sigma != kNothing) inertial.gyro_bias_prior = known.gyro_sigma;
  if (known.accel_sigma != kNothing) inertial.accel_bias_prior = known.accel_sigma;
  return options;
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
  using namespace estimation_constants;  // NOLINT: of the test of a known state
  constexpr int kGyro = 5, kAccel = 8;   // rows of StateVector
  StateVector sigma;
  sigma << Eigen::Vector3d::Constant(kUnknown[0]), Eigen::Vector2d::Constant(kUnknown[1]),
      Eigen::Vector3d::Constant(priors.gyro_bias_prior),
      Eigen::Vector3d::Constant(priors.accel_bias_prior);
  const StateCovariance prior = sigma.cwiseAbs2().asDiagonal();
  StateCovariance posterior = prior;
  posterior.bottomRightCorner<6, 6>() = result.covariance.bottomRightCorner<6, 6>();
  StateVector moved = StateVector::Zero();
  moved.segment<3>(kGyro) = result.gyro_bias;
  moved.segment<3>(kAccel) = result.accel_bias;
  return testState(moved, prior, posterior).contradicts();
}

}  // namespace

InitResult answerAboutKnownBiases(const InitWindow& window, const InitializerOptions& options,
                                  WorkBudget* budget,
                                  InitResult (*solve)(const InitWindow&, const InitializerOptions&,
                                                      WorkBudget*)) {
  const ImuBiases known = usefulBiases(window.calibration().imu_biases, options.inertial);
  if (isEmpty(known)) return solve(window, options, budget);
  const InitializerOptions with_priors = withPriors(options, known);
  InitResult result = solve(*withoutBiases(window, known), with_priors, budget);
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
  result = solve(window, options, budget);
  if (!contradicted && !result.success()) return result;
  result.warnings.push_back(roundedText(3, "the prior biases, gyroscope (", known.gyro.transpose(),
                                        ") rad/s and accelerometer (", known.accel.transpose(),
                                        ") m/s^2, contradict the data and are not used"));
  return result;
}

}  // namespace slim_init
