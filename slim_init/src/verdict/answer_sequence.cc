// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/answer_sequence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "verdict/constants.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

using namespace verdict_constants;  // NOLINT: the constants of this module

// Logarithm of the lengths of both paths along the keyframes that they share; NaN for fewer than
// kMinSharedKeyframes.
double logRatioOfPaths(const std::vector<NavState>& now, const std::vector<NavState>& before) {
  double length_now = 0.0, length_before = 0.0;
  int shared = 0;
  std::size_t i_last = 0, j_last = 0;
  for (std::size_t i = 0, j = 0; i < now.size() && j < before.size();) {
    const double dt = now[i].t - before[j].t;
    if (dt > kSameKeyframe) {
      ++j;
    } else if (dt < -kSameKeyframe) {
      ++i;
    } else {
      if (shared > 0) {
        length_now += (now[i].p_w_b - now[i_last].p_w_b).norm();
        length_before += (before[j].p_w_b - before[j_last].p_w_b).norm();
      }
      ++shared;
      i_last = i++;
      j_last = j++;
    }
  }
  return shared < kMinSharedKeyframes ? kNotComputed : std::log(length_now / length_before);
}

}  // namespace

void AnswerSequence::reset() {
  earlier_.reset();
  latest_.reset();
}

void AnswerSequence::judge(InitResult* result) {
  if (!(max_disagreement_ > 0.0) || !result->hasEstimate()) return;
  if (!std::isfinite(result->scale_sigma) || !(result->scale_sigma > 0.0)) return;
  const double newest = result->states.back().t;
  if (latest_) {
    const double last = latest_->states.back().t;
    if (newest < last - kSameKeyframe) reset();
    if (newest > last + kSameKeyframe) earlier_ = std::move(latest_);
  }
  latest_.reset();
  if (result->scale_sigma <= kMaxEarlierSigma)
    latest_ = Answer{result->states, result->scale_sigma};

  const double sigma = result->scale_sigma;
  double log_ratio = kNotComputed;
  if (earlier_) log_ratio = logRatioOfPaths(result->states, earlier_->states);
  const bool growing = static_cast<int>(result->states.size()) < full_keyframes_;
  if (!growing && !std::isfinite(log_ratio)) return;
  double disagreement = kNotComputed;
  if (earlier_) {
    const double gained = std::max(earlier_->sigma * earlier_->sigma - sigma * sigma, 0.0);
    disagreement =
        std::abs(log_ratio) / std::sqrt(gained + kAgreementFloor * kAgreementFloor * sigma * sigma);
  }
  GateValue gate = agreementGate(disagreement, max_disagreement_);
  gate.enforced = std::any_of(result->gates.begin(), result->gates.end(),
                              [](const GateValue& other) { return other.enforced; });
  if (result->success() && gate.enforced && !gate.passed) {
    result->status = gate.status_if_failed;
    result->message = describe(gate);
  }
  result->gates.push_back(std::move(gate));
}

}  // namespace slim_init
