// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/state_at.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/so3.h"
#include "imu/preintegration.h"
#include "slim_init/text.h"

namespace slim_init {
namespace {

// The inverse of propagate(): the state that the preintegration carries to `from`.
NavState backward(const NavState& from, double t, const Eigen::Vector3d& gravity_w,
                  const std::vector<ImuSample>& imu) {
  if (!(t < from.t)) return from;
  const Preintegration pre = preintegrate(imu, t, from.t, {from.gyro_bias, from.accel_bias},
                                          ImuNoise(), PreintegrationParts::kMean);
  NavState state = from;
  state.t = t;
  state.R_w_b = from.R_w_b * pre.dR.transpose();
  state.v_w_b = from.v_w_b - gravity_w * pre.dt - state.R_w_b * pre.dv;
  state.p_w_b =
      from.p_w_b - state.v_w_b * pre.dt - 0.5 * gravity_w * pre.dt * pre.dt - state.R_w_b * pre.dp;
  return state;
}

NavState blend(const NavState& a, const NavState& b, double weight_b) {
  NavState state = a;
  state.R_w_b = a.R_w_b * expSO3(weight_b * logSO3(a.R_w_b.transpose() * b.R_w_b));
  state.p_w_b += weight_b * (b.p_w_b - a.p_w_b);
  state.v_w_b += weight_b * (b.v_w_b - a.v_w_b);
  state.gyro_bias += weight_b * (b.gyro_bias - a.gyro_bias);
  state.accel_bias += weight_b * (b.accel_bias - a.accel_bias);
  return state;
}

// A problem with the samples that carry the state over [t_from, t_to], or "".
std::string checkCover(const std::vector<ImuSample>& imu, double t_from, double t_to,
                       double max_gap_s) {
  if (imu.empty() || t_from < imu.front().t || t_to > imu.back().t) {
    return text("the IMU data do not cover the ", t_to - t_from, " s up to ", std::fixed, t_to,
                " s");
  }
  // From the last sample at or before t_from to the first at or after t_to.
  auto sample = std::upper_bound(imu.begin(), imu.end(), t_from,
                                 [](double t, const ImuSample& s) { return t < s.t; });
  for (; sample != imu.end() && std::prev(sample)->t < t_to; ++sample) {
    const double gap = sample->t - std::prev(sample)->t;
    if (gap > max_gap_s) {
      return text("gap in the IMU data ", gap, " s (limit ", max_gap_s, " s)");
    }
  }
  return "";
}

}  // namespace

bool statesAt(const InitResult& result, const std::vector<ImuSample>& imu,
              const std::vector<double>& times, const StateAtOptions& options,
              std::vector<NavState>* states, std::string* error) {
  const auto refuse = [error](const std::string& message) {
    if (error != nullptr) *error = message;
    return false;
  };
  const std::vector<NavState>& keyframes = result.states;
  const Eigen::Vector3d& gravity_w = result.gravity_w;
  if (keyframes.empty()) return refuse("there is no keyframe to start from");
  std::vector<NavState> found;
  found.reserve(times.size());
  for (const double t : times) {
    if (!std::isfinite(t)) return refuse("a requested time is not finite");
    const auto right = std::lower_bound(keyframes.begin(), keyframes.end(), t,
                                        [](const NavState& s, double time) { return s.t < time; });
    const bool before = right == keyframes.begin();
    if (before && t >= result.at_rest_since) {
      found.push_back(*right);
      found.back().t = t;
      found.back().v_w_b.setZero();
      continue;
    }
    // The newest keyframe lies where the estimate of td has put it, which may be after the last
    // sample: then the one before it has to do.
    const bool uncovered = right != keyframes.end() && !imu.empty() && right->t > imu.back().t;
    const bool after = right == keyframes.end() || (uncovered && !before);
    const NavState& a = before ? *right : *std::prev(right);
    const NavState& b = after ? a : *right;
    const double reach = before ? b.t - t : after ? t - a.t : 0.0;
    if (reach > options.max_reach_s) {
      return refuse(text("the requested time is ", reach, " s ", (before ? "before" : "after"),
                         " the window (limit ", options.max_reach_s, " s)"));
    }
    const std::string problem =
        checkCover(imu, std::min(a.t, t), std::max(b.t, t), options.max_imu_gap_s);
    if (!problem.empty()) return refuse(problem);
    if (before) {
      found.push_back(backward(b, t, gravity_w, imu));
    } else if (after) {
      found.push_back(propagateTo(a, t, imu, gravity_w));
    } else {
      found.push_back(blend(propagateTo(a, t, imu, gravity_w), backward(b, t, gravity_w, imu),
                            (t - a.t) / (b.t - a.t)));
    }
  }
  *states = std::move(found);
  return true;
}

}  // namespace slim_init
