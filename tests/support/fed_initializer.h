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

/// A method that has nothing but a status: what the base class says of the rest.
class PlainMethod : public WindowSolver {
 public:
  explicit PlainMethod(InitStatus status = InitResult().status) { result_.status = status; }
  const std::string& name() const override { return name_; }
  InitResult solveWindow(const InitWindow& /*window*/, const SolveRequest& /*request*/,
                         WorkBudget* /*budget*/) const override {
    return result_;
  }

 private:
  std::string name_ = "other";
  InitResult result_;
};

}  // namespace slim_init
