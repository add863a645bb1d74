// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slim_init {

/// Residuals beyond so many standard deviations count for little.
inline constexpr double kGemanMcClureSigmas = 3.0;

/// Weight of a residual by its square in standard deviations (Geman and McClure): 1 at zero, a
/// quarter at the cutoff.
inline double gemanMcClure(double z2) {
  const double q = 1.0 + z2 / (kGemanMcClureSigmas * kGemanMcClureSigmas);
  return 1.0 / (q * q);
}

/// The cost of which it is the weight, in the squares of least squares: it ends at the square of
/// the cutoff, so that what is far off costs the same wherever it is.
inline double gemanMcClureCost(double z2) {
  return z2 / (1.0 + z2 / (kGemanMcClureSigmas * kGemanMcClureSigmas));
}

}  // namespace slim_init
