// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/scale_profile.h"

#include <algorithm>
#include <cmath>
#include <utility>
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

// From three points of which the middle one is the lowest, to the vertices of the parabolas through
// them: about its minimum the cost is one. A step shorter than the tolerance is one of that length
// into the wider side, so that both ends come near; the vertex after that is the last one.
FunctionPoint minimumBetween(const ScaleCost& cost, FunctionPoint low, FunctionPoint best,
                             FunctionPoint high) {
  for (bool last = false; !last;) {
    const double left = best.at - low.at, right = high.at - best.at;
    last = std::max(left, right) < 1.5 * kLogScaleTolerance;
    const double fall = (low.value - best.value) / left, rise = (high.value - best.value) / right;
    double step = 0.5 * (fall * right - rise * left) / (fall + rise);
    // Or no number, with an infinite cost.
    if (!last && !(std::abs(step) > kLogScaleTolerance)) {
      step = std::copysign(kLogScaleTolerance, right - left);
    }
    FunctionPoint next = {best.at + step, cost(best.at + step)};
    FunctionPoint &ahead = step > 0.0 ? high : low, &behind = step > 0.0 ? low : high;
    if (next.value < best.value) {
      behind = std::exchange(best, next);
    } else {
      ahead = next;
    }
  }
  return best;
}

// Every minimum of the grid; its ends count as they are.
std::vector<FunctionPoint> localMinima(const ScaleCost& cost) {
  const double step = std::log(kMaxRatio) / kHalfGrid;
  std::vector<FunctionPoint> grid, minima;
  for (int k = -kHalfGrid; k <= kHalfGrid; ++k) grid.push_back({k * step, cost(k * step)});
  const int last = 2 * kHalfGrid;
  for (int k = 0; k <= last; ++k) {
    if (k > 0 && !(grid[k].value < grid[k - 1].value)) continue;
    if (k < last && !(grid[k].value <= grid[k + 1].value)) continue;
    const bool is_end = k == 0 || k == last;
    minima.push_back(is_end ? grid[k] : minimumBetween(cost, grid[k - 1], grid[k], grid[k + 1]));
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
