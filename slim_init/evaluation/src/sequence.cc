// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/sequence.h"

#include <algorithm>
#include <cmath>

#include "reference_so3.h"

namespace slim_init::evaluation {
namespace {

// Times that are the same but for the rounding of sums [s].
constexpr double kSameTime = 1e-9;
// Between frames further apart the motion is not known [s].
constexpr double kMaxStep = 0.3;

NavState between(const NavState& from, const NavState& to, double t) {
  const double h = to.t - from.t;
  const double u = (t - from.t) / h;
  NavState state = u < 0.5 ? from : to;  // biases
  state.t = t;
  const double u2 = u * u, u3 = u2 * u;
  state.p_w_b = (2.0 * u3 - 3.0 * u2 + 1.0) * from.p_w_b + (u3 - 2.0 * u2 + u) * h * from.v_w_b +
                (-2.0 * u3 + 3.0 * u2) * to.p_w_b + (u3 - u2) * h * to.v_w_b;
  state.v_w_b = (1.0 - u) * from.v_w_b + u * to.v_w_b;
  const Eigen::Vector3d turn = reference::logSo3(from.R_w_b.transpose() * to.R_w_b);
  state.R_w_b = from.R_w_b * reference::expSo3(u * turn);
  return state;
}

}  // namespace

NavState truthAt(const Sequence& sequence, double t) {
  if (!sequence.has_truth || sequence.truth.size() != sequence.frames.size() || !std::isfinite(t)) {
    return NavState();
  }
  // By the frames: where there is no truth, its t is NaN and cannot be searched.
  const double td = sequence.trueCalibration().td;
  const auto timeOf = [&](std::size_t i) { return sequence.frames[i].t + td; };
  const auto found = std::lower_bound(
      sequence.frames.begin(), sequence.frames.end(), t - kSameTime,
      [td](const FrameObservation& frame, double time) { return frame.t + td < time; });
  const auto i = static_cast<std::size_t>(found - sequence.frames.begin());
  if (found != sequence.frames.end() && timeOf(i) <= t + kSameTime) return sequence.truth[i];
  if (sequence.truth_between) return sequence.truth_between(t);
  if (i == 0 || found == sequence.frames.end()) return NavState();
  const NavState &from = sequence.truth[i - 1], &to = sequence.truth[i];
  if (!std::isfinite(from.t) || !std::isfinite(to.t) || to.t - from.t > kMaxStep) return NavState();
  return between(from, to, t);
}

}  // namespace slim_init::evaluation
