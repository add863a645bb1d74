// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

namespace slim_init {

/// Standard deviations beyond which a residual is a gross error, of whatever kind it is, and counts
/// for little.
inline constexpr double kOutlierSigmas = 3.0;

/// Weight of a residual by its square in standard deviations (Geman and McClure): 1 at zero, a
/// quarter at the cutoff.
inline double gemanMcClure(double z2) {
  const double q = 1.0 + z2 / (kOutlierSigmas * kOutlierSigmas);
  return 1.0 / (q * q);
}

/// The cost of which it is the weight, in the squares of least squares: it ends at the square of
/// the cutoff, so that what is far off costs the same wherever it is.
inline double gemanMcClureCost(double z2) {
  return z2 / (1.0 + z2 / (kOutlierSigmas * kOutlierSigmas));
}

/// A twentieth of a pixel [rad]: no image shows less, and no tracker is better.
inline constexpr double kSmallestAngle = 1e-4;

/// With fewer residuals their spread is known to worse than a tenth.
inline constexpr int kFewestForSpread = 20;

/// The upper median; `values` must not be empty.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace slim_init
