// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the rotation-translation decoupled methods (drt-l, slim-paper) share after step 1;
// drt-t takes its refusals from here.
#pragma once

#include "gyro_bias.h"
#include "imu/preintegration.h"
#include "linear_alignment.h"
#include "pipeline/solver_support.h"
#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"
#include "translation/ligt.h"

namespace slim_init::baselines {

/// Takes the result of step 1. False, with status and message set, when its estimate cannot be
/// used.
bool acceptGyroBias(const GyroBiasEstimate& bias, const GyroBiasOptions& options,
                    InitResult* result);

/// Status and message where no gate has refused and yet the alignment has no answer: too few
/// tracks for the translations, or a singular system.
void failAlignment(const TranslationEstimate& translation, const AlignmentOptions& options,
                   InitResult* result);

/// Step 2 of both methods: re-integration at the solved bias, translations (LiGT), linear alignment
/// with `line_terms`, states, gates. The gates are enforced with GateMode::kOn only: as published,
/// these methods have none. `result` has passed acceptGyroBias().
void solveTranslationAndAlign(const InitWindow& window, const LineTerms& line_terms,
                              const InitializerOptions& options, StageClock* clock,
                              InitResult* result);

}  // namespace slim_init::baselines
