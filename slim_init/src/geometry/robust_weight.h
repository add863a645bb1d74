// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace slim_init {

/// Residuals beyond so many standard deviations count for little.
inline constexpr double kGemanMcClureSigmas = 3.0;

/// Weight of a residual by its square in standard deviations (Geman and McClure): 1 at zero, a
/// quarter at the cutoff.
inline double gemanMcClure(double z2) {
  const double q = 1.0 + z2 / (kGemanMcClureSigmas * kGemanMcClureSigmas);
  return 1.0 / (q * q);
}

/// Degrees of freedom of Student's t: heavy enough tails that a fault counts for little, light
/// enough that noise keeps its weight.
inline constexpr double kStudentFreedom = 4.0;

/// Weight of a residual of `rows` components by its square in standard deviations, Student's t, and
/// its cost, whose derivative the weight is.
inline double studentWeight(double z2, int rows) {
  return (kStudentFreedom + rows) / (kStudentFreedom + z2);
}
inline double studentCost(double z2, int rows) {
  return (kStudentFreedom + rows) * std::log1p(z2 / kStudentFreedom);
}

}  // namespace slim_init
