// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "slim_init/initializer.h"
#include "slim_init/window_solver.h"
#include "support/exact_window.h"

namespace slim_init {

/// All IMU samples of a window, then all its keyframes.
inline void feed(IInitializer& initializer, const ExactWindow& exact) {
  for (const ImuSample& sample : exact.imu) initializer.addImu(sample);
  for (const FrameObservation& frame : exact.keyframes) initializer.addFrame(frame);
}

/// What a host knows of its own state.
inline StatePrior healthyPrior(const NavState& state) {
  StatePrior prior;
  prior.state = state;
  Eigen::Matrix<double, 15, 1> sigma;
  sigma << Eigen::Vector3d::Constant(0.01), Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.1),
      Eigen::Vector3d::Constant(2e-3), Eigen::Vector3d::Constant(0.05);
  prior.covariance = sigma.cwiseAbs2().asDiagonal();
  return prior;
}

/// `slim`, with options that are valid.
inline std::unique_ptr<WindowSolver> slimSolver(const InitializerOptions& options) {
  std::string error;
  auto solver = makeSlimSolver(options, &error);
  EXPECT_NE(solver, nullptr) << error;
  return solver;
}

/// `slim` with the data of a window.
inline std::unique_ptr<IInitializer> makeFed(const ExactWindow& exact,
                                             const InitializerOptions& options) {
  std::string error;
  auto initializer = makeInitializer(exact.calibration, options, &error);
  EXPECT_NE(initializer, nullptr) << error;
  feed(*initializer, exact);
  return initializer;
}

}  // namespace slim_init
