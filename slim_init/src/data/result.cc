// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/result.h"

namespace slim_init {

const char* toString(InitStatus status) {
  switch (status) {
    case InitStatus::kSuccess: return "success";
    case InitStatus::kTooFewKeyframes: return "too_few_keyframes";
    case InitStatus::kTooFewTracks: return "too_few_tracks";
    case InitStatus::kStationary: return "stationary";
    case InitStatus::kTooLittleExcitation: return "too_little_excitation";
    case InitStatus::kPureRotation: return "pure_rotation";
    case InitStatus::kDegenerateAlignment: return "degenerate_alignment";
    case InitStatus::kInconsistentResiduals: return "inconsistent_residuals";
    case InitStatus::kScaleTooUncertain: return "scale_too_uncertain";
    case InitStatus::kInvalidInput: return "invalid_input";
    case InitStatus::kNumericalFailure: return "numerical_failure";
  }
  return "unknown";
}

bool isWait(InitStatus status) {
  switch (status) {
    case InitStatus::kTooFewKeyframes:
    case InitStatus::kTooFewTracks:
    case InitStatus::kStationary:
    case InitStatus::kTooLittleExcitation:
    case InitStatus::kPureRotation: return true;
    default: return false;
  }
}

bool isRefused(InitStatus status) {
  switch (status) {
    case InitStatus::kDegenerateAlignment:
    case InitStatus::kInconsistentResiduals:
    case InitStatus::kScaleTooUncertain: return true;
    default: return false;
  }
}

double InitResult::totalMs() const {
  double sum = 0.0;
  for (const StageTime& stage : stages) sum += stage.ms;
  return sum;
}

}  // namespace slim_init
