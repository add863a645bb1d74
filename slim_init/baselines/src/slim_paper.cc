// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include "compared_methods.h"
#include "gyro_bias.h"
#include "line_selection.h"
#include "lines/vanishing_point.h"
#include "loosely_coupled.h"

namespace slim_init::baselines {

InitResult solveSlimPaper(const InitWindow& window, const InitializerOptions& options,
                          const BaselineOptions& baseline_options) {
  const SlimPaperOptions& terms = baseline_options.slim_paper;
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;

  // IV-B-1, IV-B-2: dominant vanishing point of each keyframe, tracked by the gyro, with its gate.
  std::vector<VanishingPoint> vanishing_points;
  if (terms.use_vp) {
    vanishing_points = trackVanishingPoints(window, options.vanishing_point);
  }
  clock.lap("vanishing_points");

  // Step 1, eq. (1): gyroscope bias from point and VP residuals.
  GyroBiasProblem problem;
  problem.pair_loss = PairLoss::kSumOfSquares;
  problem.vanishing_points = terms.use_vp ? &vanishing_points : nullptr;
  problem.vp_options = terms;
  const GyroBiasEstimate bias = estimateGyroBias(window, problem);
  clock.lap("gyro_bias");
  if (!acceptGyroBias(bias, &result)) return result;

  // IV-C-4: line selection and weights, eq. (13).
  std::vector<PairLines> lines;
  LineTerms line_terms;
  if (terms.use_line_epipolar || terms.use_line_normal) {
    lines = selectLines(window, baseline_options.line_selection);
    line_terms.lines = &lines;
    line_terms.use_epipolar = terms.use_line_epipolar;
    line_terms.use_normal = terms.use_line_normal;
    line_terms.epipolar_weight = terms.line_epipolar_weight;
    line_terms.normal_weight = terms.line_normal_weight;
  }
  clock.lap("line_selection");

  // Step 2, eq. (7): alignment on point and line residuals.
  solveTranslationAndAlign(window, line_terms, options, &clock, &result);
  return result;
}

}  // namespace slim_init::baselines
