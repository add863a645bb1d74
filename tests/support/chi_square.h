// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>

namespace slim_init {

/// Whether `sum`, of squared errors over their reported variances, is one of a chi-square variable
/// with `dof` degrees of freedom (at least 100): within 4 standard deviations of its mean, which
/// are sqrt(2 / dof) each after division by dof. A reported standard deviation that is wrong by a
/// factor of 1.8, either way, moves the mean to 0.31 or 3.2 and is seen.
inline ::testing::AssertionResult isChiSquare(double sum, int dof) {
  if (dof < 100) return ::testing::AssertionFailure() << dof << " degrees of freedom are too few";
  const double mean = sum / dof, sigma = std::sqrt(2.0 / dof);
  if (std::abs(mean - 1.0) <= 4.0 * sigma) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << "mean of the squared errors over their variances is " << mean << ", not 1 +- "
         << 4.0 * sigma << " (" << dof << " degrees of freedom)";
}

}  // namespace slim_init
