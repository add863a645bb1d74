// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>

#include "slim_init/types.h"

namespace slim_init::evaluation {

/// CPU time of the calling thread since its beginning [ms], which other programs on the machine do
/// not lengthen; NaN where the system has no such clock.
inline double threadCpuMs() {
  timespec time = {};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) != 0) return kNotComputed;
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace slim_init::evaluation
