// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Is another scale as good? The cost of a refined window over its scale, everything else minimised
// (docs/derivation.md, 5.1). A standard deviation is the curvature of this cost at one point; it
// knows neither that the cost is flat on one side nor that there is a second minimum.
#pragma once

#include "scale/scale_cost.h"
#include "slim_init/types.h"

namespace slim_init {

/// The cost over q = log(scale / scale of the refined window); the answer is at q = 0.
struct ScaleProfile {
  bool valid = false;  ///< false where the visual information does not determine the shape
  double log_ratio = kNotComputed;  ///< q of the lowest cost; near 0 where the refinement found it
  double cost = kNotComputed;       ///< there [sigma^2], the images' part above its own minimum
  double cost_here = kNotComputed;  ///< of the answer
  /// The lowest other minimum at least kSameBasin from the answer, ends of the search included: its
  /// q, and its cost above that of the answer; negative where it is the better one. Without one,
  /// NaN and infinity.
  double other_log_ratio = kNotComputed;
  double other_rise = kNotComputed;

  /// Standard deviation of the log scale of the answer: that of the parabola through the lowest
  /// cost and the one kSameBasin beside it on the flatter side, and half of what the answer is off;
  /// at most log(50) / 2, as where the cost does not rise.
  double sigma = kNotComputed;

  /// [log ratio]; the linear dependence of the states on the scale is good up to here.
  static constexpr double kSameBasin = 0.2;
};

/// A point of a ScaleCost.
struct FunctionPoint {
  double at, value;  ///< logarithm of the ratio of scales, cost [sigma^2]
};

/// The lowest minimum of a cost on a logarithmic grid, from 1/50 to 50, refined: log ratio and
/// cost. An infinite cost where there is none.
FunctionPoint lowestMinimum(const ScaleCost& cost);

/// Searches the profile on the same grid about the scale of the answer.
ScaleProfile profileScale(const ScaleCost& cost);

/// Moments of the scale, as its ratio to that of a refined window.
struct ScaleMoments {
  bool valid = false;
  double mean = 1.0;          ///< of the ratio
  double variance = 0.0;      ///< of the ratio
  double log_variance = 0.0;  ///< of its logarithm
  double log_best = 0.0;      ///< logarithm of the most probable ratio
};

/// Integrates the density exp(-cost / 2) over the ratio, from 1/50 to 50.
ScaleMoments integrateScale(const ScaleCost& cost);

}  // namespace slim_init
