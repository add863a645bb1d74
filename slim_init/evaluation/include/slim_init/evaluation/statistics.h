// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace slim_init::evaluation {

// All return NaN for an empty list. The lists hold finite values only; the caller who fills them
// decides what a value that is not finite means.

/// Square root of the mean of the squares.
double rootMeanSquare(const std::vector<double>& values);

/// Order statistic with linear interpolation between neighbours, share in [0, 1]; share 0.5 is the
/// median, with the mean of the middle two for an even count.
double quantile(std::vector<double> values, double share);
/// quantile(values, 0.5).
double median(std::vector<double> values);

}  // namespace slim_init::evaluation
