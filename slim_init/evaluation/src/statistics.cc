// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slim_init/types.h"

namespace slim_init::evaluation {

double rootMeanSquare(const std::vector<double>& values) {
  if (values.empty()) return kNotComputed;
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return kNotComputed;
  std::sort(values.begin(), values.end());
  const double position = share * static_cast<double>(values.size() - 1);
  const std::size_t below = static_cast<std::size_t>(std::floor(position));
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double fraction = position - static_cast<double>(below);
  return (1.0 - fraction) * values[below] + fraction * values[above];
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

}  // namespace slim_init::evaluation
