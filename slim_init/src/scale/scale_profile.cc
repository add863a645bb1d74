// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/scale_profile.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace slim_init {
namespace {

// Scales searched and integrated over: up to this many times larger and smaller. Wrong minima that
// were accepted lay a factor of 2.4 to 30 away.
constexpr double kMaxRatio = 50.0;
// Points of the grid on each side: steps of 0.3 in the log scale, finer than the distance of two
// minima worth telling apart.
constexpr int kHalfGrid = 13;
// End of all searches [log scale]: a tenth of the smallest sigma.
constexpr double kLogScaleTolerance = 2e-3;

// ---- Integral over the scale (integrateScale())

// Passes over as many points as the grid has: each covers what the one before found the density in.
constexpr int kIntegralPasses = 3;
// Less than this below its largest value the logarithm of the density is nothing.
constexpr double kNegligible = 12.0;

// By golden section, then at the vertex of a parabola: about its minimum the cost is one.
FunctionPoint minimumBetween(const ScaleCost& cost, double low, double high) {
  const double h = kLogScaleTolerance;
  const FunctionPoint best = goldenSection(cost, low, high, h);
  const double before = cost(best.at - h), after = cost(best.at + h);
  const double at = best.at + 0.5 * h * (before - after) / (before - 2.0 * best.value + after);
  const FunctionPoint vertex = {at, cost(at)};
  return vertex.value < best.value ? vertex : best;
}

// Every minimum of the grid; its ends count as they are.
std::vector<FunctionPoint> localMinima(const ScaleCost& cost) {
  const double step = std::log(kMaxRatio) / kHalfGrid;
  std::vector<double> values;
  for (int k = -kHalfGrid; k <= kHalfGrid; ++k) values.push_back(cost(k * step));
  std::vector<FunctionPoint> minima;
  const int last = 2 * kHalfGrid;
  for (int k = 0; k <= last; ++k) {
    const double at = (k - kHalfGrid) * step;
    if (k > 0 && !(values[k] < values[k - 1])) continue;
    if (k < last && !(values[k] <= values[k + 1])) continue;
    FunctionPoint minimum = {at, values[k]};
    if (k > 0 && k < last) {
      const FunctionPoint between = minimumBetween(cost, at - step, at + step);
      if (between.value < minimum.value) minimum = between;
    }
    minima.push_back(minimum);
  }
  return minima;
}

FunctionPoint lowest(const std::vector<FunctionPoint>& minima) {
  FunctionPoint best = {kNotComputed, HUGE_VAL};
  for (const FunctionPoint& minimum : minima) {
    if (minimum.value < best.value) best = minimum;
  }
  return best;
}

}  // namespace

FunctionPoint lowestMinimum(const ScaleCost& cost) { return lowest(localMinima(cost)); }

ScaleProfile profileScale(const ScaleCost& cost) {
  ScaleProfile out;
  const std::vector<FunctionPoint> minima = localMinima(cost);
  const FunctionPoint best = lowest(minima);
  if (!std::isfinite(best.value)) return out;
  out.cost_here = cost(0.0);
  out.log_ratio = best.at;
  out.cost = best.value;
  out.other_rise = HUGE_VAL;
  for (const FunctionPoint& minimum : minima) {
    if (std::abs(minimum.at) < ScaleProfile::kSameBasin) continue;
    if (!(minimum.value - out.cost_here < out.other_rise)) continue;
    out.other_rise = minimum.value - out.cost_here;
    out.other_log_ratio = minimum.at;
  }
  const double h = ScaleProfile::kSameBasin;
  const double rise = std::min(cost(best.at - h), cost(best.at + h)) - best.value;
  out.sigma = std::min(0.5 * std::abs(best.at) + (rise > 0.0 ? h / std::sqrt(rise) : HUGE_VAL),
                       0.5 * std::log(kMaxRatio));
  out.valid = true;
  return out;
}

ScaleMoments integrateScale(const ScaleCost& cost) {
  ScaleMoments out;
  const double limit = std::log(kMaxRatio);
  double low = -limit, high = limit;
  for (int pass = 0; pass < kIntegralPasses; ++pass) {
    const double step = (high - low) / (2 * kHalfGrid);
    std::vector<double> values;
    double best = -HUGE_VAL;
    for (int k = 0; k <= 2 * kHalfGrid; ++k) {
      const double q = low + k * step;
      // Of the logarithm: d ratio = ratio d q.
      values.push_back(q - 0.5 * cost(q));
      if (!(values.back() > best)) continue;
      best = values.back();
      out.log_best = q;
    }
    if (!std::isfinite(best)) return out;
    double sum = 0.0, ratio = 0.0, ratio2 = 0.0, log = 0.0, log2 = 0.0;
    double first = HUGE_VAL, last = -HUGE_VAL;
    for (int k = 0; k <= 2 * kHalfGrid; ++k) {
      if (!(values[k] > best - kNegligible)) continue;
      const double q = low + k * step, r = std::exp(q), w = std::exp(values[k] - best);
      sum += w;
      ratio += w * r;
      ratio2 += w * r * r;
      log += w * q;
      log2 += w * q * q;
      first = std::min(first, q);
      last = std::max(last, q);
    }
    out.mean = ratio / sum;
    out.variance = std::max(0.0, ratio2 / sum - out.mean * out.mean);
    out.log_variance = std::max(0.0, log2 / sum - log * log / (sum * sum));
    low = std::max(first - step, -limit);
    high = std::min(last + step, limit);
  }
  out.valid = std::isfinite(out.mean) && std::isfinite(out.variance);
  return out;
}

}  // namespace slim_init
