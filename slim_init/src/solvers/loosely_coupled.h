// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the rotation-translation decoupled methods (drt-l, slim-paper) share after step 1.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "alignment/linear_alignment.h"
#include "imu/preintegration.h"
#include "rotation/gyro_bias.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "translation/ligt.h"

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

/// A result with nothing but the counts of the window filled in.
InitResult startResult(const InitWindow& window);

/// Sets status and message.
void fail(InitStatus status, const std::string& message, InitResult* result);

/// Rotations of the cameras into the first camera from those of the bodies into the first body.
std::vector<Eigen::Matrix3d> cameraRotations(const std::vector<Eigen::Matrix3d>& R_b0_bk,
                                             const Eigen::Matrix3d& R_b_c);

/// False, with status and sentence set, when the window has fewer than kMinKeyframes.
bool hasEnoughKeyframes(const InitWindow& window, InitResult* result);

/// Takes over step 1. False, with status and sentence set, when its estimate cannot be used.
bool acceptGyroBias(const GyroBiasEstimate& bias, const GyroBiasOptions& options,
                    InitResult* result);

/// Step 2 of both methods: re-integration at the solved bias, translations (LiGT), linear alignment
/// with `line_terms`, states, gates. The gates are enforced with GateMode::kOn only: as published,
/// these methods have none. `result` has passed acceptGyroBias().
void solveTranslationAndAlign(const InitWindow& window, const LineTerms& line_terms,
                              const InitializerOptions& options, StageClock* clock,
                              InitResult* result);

}  // namespace slim_init
