// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/answer_sequence.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "verdict/constants.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

using namespace verdict_constants;  // NOLINT: the constants of this module

// Position at time t between two states, the cubic that has their positions and velocities.
Eigen::Vector3d between(const NavState& a, const NavState& b, double t) {
  const double dt = b.t - a.t;
  const double u = (t - a.t) / dt;
  const double w = u * u * (3.0 - 2.0 * u);
  return (1.0 - w) * a.p_w_b + w * b.p_w_b +
         dt * u * (1.0 - u) * ((1.0 - u) * a.v_w_b - u * b.v_w_b);
}

// Logarithm of the ratio of both paths, through the keyframes of `now` that lie within `before`;
// NaN for fewer than kMinSharedInstants.
double logRatioOfPaths(const std::vector<NavState>& now, const std::vector<NavState>& before) {
  double length_now = 0.0, length_before = 0.0;
  int shared = 0;
  Eigen::Vector3d p_now = Eigen::Vector3d::Zero(), p_before = Eigen::Vector3d::Zero();
  std::size_t j = 0;
  for (const NavState& state : now) {
    if (state.t < before.front().t - kSameInstant || state.t > before.back().t + kSameInstant) {
      continue;
    }
    while (j + 2 < before.size() && before[j + 1].t < state.t) ++j;
    const Eigen::Vector3d p = between(before[j], before[j + 1], state.t);
    if (shared++ > 0) {
      length_now += (state.p_w_b - p_now).norm();
      length_before += (p - p_before).norm();
    }
    p_now = state.p_w_b;
    p_before = p;
  }
  return shared < kMinSharedInstants ? kNotComputed : std::log(length_now / length_before);
}

}  // namespace

void AnswerSequence::reset() { earlier_.clear(); }

void AnswerSequence::judge(InitResult* result) {
  if (!(max_disagreement_ > 0.0) || result->states.size() < 2) return;
  const double sigma = result->scale_sigma;
  if (!std::isfinite(sigma) || !(sigma > 0.0)) return;
  const double newest = result->states.back().t;
  const auto time = [](const Answer& answer) { return answer.states.back().t; };
  if (!earlier_.empty() && newest < time(earlier_.back()) - kSameInstant) reset();
  // Asked again about the same data.
  if (!earlier_.empty() && newest < time(earlier_.back()) + kSameInstant) earlier_.pop_back();
  while (earlier_.size() > 1 && time(earlier_[1]) <= newest - kMinNewData) earlier_.pop_front();

  double disagreement = kNotComputed;
  if (!earlier_.empty() && time(earlier_.front()) <= newest - kMinNewData) {
    const Answer& before = earlier_.front();
    const double gained = std::max(before.sigma * before.sigma - sigma * sigma, 0.0);
    const double floor = kAgreementFloor * sigma;
    disagreement = std::abs(logRatioOfPaths(result->states, before.states)) /
                   std::sqrt(gained + floor * floor);
  }
  if (sigma <= kMaxEarlierSigma) earlier_.push_back({result->states, sigma});
  const bool growing = static_cast<int>(result->states.size()) < full_keyframes_;
  if (!growing && !std::isfinite(disagreement)) return;
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
