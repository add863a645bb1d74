// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

#include "slim_init/result.h"

namespace slim_init {

/// Equal to the last bit, wall-clock times excepted.
inline bool sameBytes(const InitResult& a, const InitResult& b) {
  if (a.status != b.status || a.message != b.message || a.states.size() != b.states.size()) {
    return false;
  }
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.size() == 0 || std::memcmp(x.data(), y.data(), sizeof(double) * x.size()) == 0);
  };
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    const NavState &s = a.states[k], &t = b.states[k];
    if (!same(s.R_w_b, t.R_w_b) || !same(s.p_w_b, t.p_w_b) || !same(s.v_w_b, t.v_w_b)) return false;
    if (!same(s.gyro_bias, t.gyro_bias) || !same(s.accel_bias, t.accel_bias)) return false;
  }
  return same(a.gyro_bias, b.gyro_bias) && same(a.accel_bias, b.accel_bias) &&
         same(a.gravity_b0, b.gravity_b0) && std::memcmp(&a.scale, &b.scale, sizeof(double)) == 0 &&
         std::memcmp(&a.scale_sigma, &b.scale_sigma, sizeof(double)) == 0 &&
         same(a.covariance, b.covariance);
}

}  // namespace slim_init
