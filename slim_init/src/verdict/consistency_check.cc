// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/consistency_check.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "verdict/gates.h"

namespace slim_init {
namespace {

// Instants that both paths have: two displacements, so that not a single one decides.
constexpr int kMinSharedInstants = 3;
// Least standard deviation of the difference, as a share of that of the answer: windows of equal
// length, and sigmas that are only good to a half. Between 0.1 and 1 it makes no difference.
constexpr double kAgreementFloor = 0.5;
// Newer data make an estimate more certain, but not at will: with noise at a constant rate, the
// variance of an acceleration falls with this power of the length of the window. Where it has
// fallen by more, as by chance in a far scene, the earlier estimate does not excuse as large a
// difference.
constexpr double kVariancePower = 5.0;

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
    if (state.t < before.front().t - ConsistencyCheck::kSameInstant ||
        state.t > before.back().t + ConsistencyCheck::kSameInstant) {
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

// Difference of the scale of `now` from that of an earlier estimate with standard deviation
// `sigma_before`, in its standard deviations; NaN where both share too few instants.
double differenceInSigmas(const InitResult& now, const std::vector<NavState>& before,
                          double sigma_before) {
  const double log_ratio = logRatioOfPaths(now.states, before);
  if (!std::isfinite(log_ratio)) return kNotComputed;
  const double first = now.states.front().t, last = now.states.back().t;
  const double shared = before.back().t - std::max(first, before.front().t);
  const double variance = now.scale_sigma * now.scale_sigma;
  const double possible = variance * std::pow((last - first) / shared, kVariancePower);
  const double gained = std::min(sigma_before * sigma_before, possible) - variance;
  return std::abs(log_ratio) /
         std::sqrt(std::max(gained, 0.0) + kAgreementFloor * kAgreementFloor * variance);
}

// NaN: too few earlier solves.
GateValue agreementGate(double disagreement_sigmas, double max_disagreement) {
  const char* what = std::isfinite(disagreement_sigmas)
                         ? "difference of the scale from the earlier solves"
                         : "consistency check not possible yet: too few earlier solves to compare "
                           "the scale with";
  return makeGate(GateName::kAgreement, what, "sigma",
                  atMost(disagreement_sigmas, max_disagreement), InitStatus::kScaleTooUncertain);
}

}  // namespace

void ConsistencyCheck::reset() {
  earlier_.clear();
  refused_before_ = false;
}

void ConsistencyCheck::judge(InitResult* result) {
  const bool refused_before = std::exchange(refused_before_, !result->success());
  if (!(max_disagreement_ > 0.0) || result->states.size() < 2) return;
  const double sigma = result->scale_sigma;
  if (!std::isfinite(sigma) || !(sigma > 0.0)) return;
  const double first = result->states.front().t, newest = result->states.back().t;
  const auto time = [](const Estimate& estimate) { return estimate.states.back().t; };
  if (!earlier_.empty() && newest < time(earlier_.back()) - kSameInstant) reset();
  // Asked again about the same data.
  if (!earlier_.empty() && newest < time(earlier_.back()) + kSameInstant) earlier_.pop_back();
  while (!earlier_.empty() && time(earlier_.front()) < first) earlier_.pop_front();

  // The newest answers that are earlier than this one and than each other: by a keyframe interval.
  const double newer = WindowOptions().min_interval_s;
  std::vector<const Estimate*> before;
  double bound = newest - newer;
  for (auto estimate = earlier_.rbegin(); estimate != earlier_.rend(); ++estimate) {
    if (static_cast<int>(before.size()) == earlier_estimates_) break;
    if (time(*estimate) > bound) continue;
    before.push_back(&*estimate);
    bound = time(*estimate) - newer;
  }
  // A full window that passes after others have not may do so by chance as well.
  const bool needs_all = refused_before || newest - first < kFullFraction * full_span_s_;
  int compared = 0;
  double worst = 0.0;
  for (const Estimate* estimate : before) {
    const double difference = differenceInSigmas(*result, estimate->states, estimate->sigma);
    if (!std::isfinite(difference)) continue;
    worst = std::max(worst, difference);
    ++compared;
  }
  const bool enough = compared > 0 && (!needs_all || compared == earlier_estimates_);
  const double disagreement = enough ? worst : kNotComputed;
  earlier_.push_back({result->states, sigma});
  if (!needs_all && !std::isfinite(disagreement)) return;
  GateValue gate = agreementGate(disagreement, max_disagreement_);
  gate.enforced = std::any_of(result->gates.begin(), result->gates.end(),
                              // A scale that is not positive is refused with gates off as well.
                              [](const GateValue& other) {
                                return other.enforced && other.name != GateName::kScalePositive;
                              });
  if (result->success() && gate.enforced && !gate.passed) {
    result->status = gate.status_if_failed;
    result->message = describe(gate);
    refused_before_ = true;
  }
  result->gates.push_back(std::move(gate));
}

}  // namespace slim_init
