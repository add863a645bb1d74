// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Answers of `slim` beside that of a window alone: of one that is too young to know its scale, of
// one at whose beginning a state is known, and of an IMU whose biases were measured before.
#pragma once

#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "slim_init/state_prior.h"
#include "slim_init/work_budget.h"

namespace slim_init {

/// What a host that starts from the newest state asks.
struct NewestSigmas {
  double velocity = kNotComputed;  ///< in the body frame, along the worst axis [m/s]
  double tilt_deg = kNotComputed;  ///< against gravity, about the worst axis [deg]
};
NewestSigmas newestSigmas(const InitResult& result);

/// Whether the newest state and the gyroscope bias of `earlier` are, to its own covariance, those
/// that `now` has at that instant. A window of a few images can have two motions that explain the
/// rotation of the images; more data change the wrong one by many standard deviations. False where
/// one of them has no covariance or they share no instant.
bool agrees(const InitResult& earlier, const InitResult& now);

/// WindowSolver::solveProvisional() of `slim`: mean and covariance over every scale that data and
/// priors allow, in place of the one that fits best (docs/derivation.md, 5.2).
InitResult provisionalAnswer(const InitWindow& window, const InitializerOptions& options,
                             WorkBudget* budget);

/// WindowSolver::solveWithPrior() of `slim` (docs/derivation.md, 5.3).
InitResult recoveredAnswer(const InitWindow& window, const StatePrior& prior,
                           const InitializerOptions& options, WorkBudget* budget);

/// The answer of `solve` to a window with Calibration::imu_biases (docs/derivation.md, 5.4). A bias
/// adds to the samples, so that a known one is a change of origin: it is taken off the samples,
/// what is left of it has a prior about zero with the standard deviation of the knowledge, and the
/// answer gets it back. `solve` is asked as it is where nothing is known beyond the priors of
/// `options`; and again where the data contradict what is known, or nothing fits it: that answer
/// says so in its warnings.
InitResult answerAboutKnownBiases(const InitWindow& window, const InitializerOptions& options,
                                  WorkBudget* budget,
                                  InitResult (*solve)(const InitWindow&, const InitializerOptions&,
                                                      WorkBudget*));

}  // namespace slim_init
