// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/time_guard.h"

#include <cmath>

namespace slim_init::node {

TimeGuard::TimeGuard(const std::vector<Stream>& streams) {
  for (const Stream& stream : streams) {
    State state;
    state.restart_on_gap = stream.restart_on_gap;
    states_.push_back(state);
  }
}

StampVerdict TimeGuard::use(State* state, double t) {
  state->last = t;
  state->held = kNone;
  state->following = false;
  state->first_stale = kNone;
  if (!(newest_ >= t)) newest_ = t;
  ++state->counts.used;
  return StampVerdict::kUse;
}

StampVerdict TimeGuard::check(int stream, double t) {
  State& state = states_[stream];
  if (!std::isfinite(t) || t <= 0.0) {
    ++state.counts.no_stamp;
    return StampVerdict::kNoStamp;
  }
  if (state.following && std::abs(t - newest_) > kJump) {
    if (std::isnan(state.first_stale)) state.first_stale = t;
    if (std::abs(t - state.first_stale) <= kPatience) {
      ++state.counts.stale;
      return StampVerdict::kStale;
    }
  }
  if (std::isnan(state.last)) return use(&state, t);

  const double step = t - state.last;
  if (step > 0.0 && step <= kJump) return use(&state, t);
  if (step <= 0.0 && step > -kJump) {
    ++state.counts.late;
    return StampVerdict::kLate;
  }
  // NaN where nothing is held: not confirmed.
  const bool confirmed = t - state.held > 0.0 && t - state.held <= kJump;
  if (!confirmed) {
    state.held = t;
    ++state.counts.held;
    return StampVerdict::kHeld;
  }
  if (step > 0.0 && !state.restart_on_gap) return use(&state, t);

  ++restarts_;
  forget();
  for (State& other : states_) other.following = true;
  use(&state, t);
  return StampVerdict::kRestart;
}

void TimeGuard::forget() {
  for (State& state : states_) {
    state.last = kNone;
    state.held = kNone;
    state.following = false;
    state.first_stale = kNone;
  }
  newest_ = kNone;
}

}  // namespace slim_init::node
