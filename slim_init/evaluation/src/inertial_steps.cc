// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/inertial_steps.h"

#include <algorithm>

namespace slim_init::evaluation {
namespace {

ImuSample interpolate(const ImuSample& a, const ImuSample& b, double t) {
  const double u = (t - a.t) / (b.t - a.t);
  ImuSample sample;
  sample.t = t;
  sample.gyro = (1.0 - u) * a.gyro + u * b.gyro;
  sample.accel = (1.0 - u) * a.accel + u * b.accel;
  return sample;
}

}  // namespace

bool inertialSteps(const std::vector<ImuSample>& imu, double t0, double t1, double max_gap_s,
                   std::vector<InertialStep>* steps) {
  steps->clear();
  if (imu.size() < 2 || !(t0 < t1) || t0 < imu.front().t || t1 > imu.back().t) return false;
  // The first sample after t0; there is one before it because imu covers t0.
  auto next = std::upper_bound(imu.begin(), imu.end(), t0,
                               [](double t, const ImuSample& sample) { return t < sample.t; });
  if (next == imu.begin() || next == imu.end()) return false;
  ImuSample from = interpolate(*std::prev(next), *next, t0);
  for (;; ++next) {
    if (next->t - std::prev(next)->t > max_gap_s) return false;
    const bool last = next->t >= t1;
    const ImuSample to = last ? interpolate(*std::prev(next), *next, t1) : *next;
    steps->push_back({to.t - from.t, 0.5 * (from.gyro + to.gyro), 0.5 * (from.accel + to.accel)});
    if (last) return true;
    from = to;
  }
}

}  // namespace slim_init::evaluation
