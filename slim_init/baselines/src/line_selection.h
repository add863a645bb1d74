// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which lines enter the alignment, and how strongly (paper IV-C-4, eq. (13)).
#pragma once

#include <vector>

#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"

namespace slim_init::baselines {

/// A line selected for a keyframe pair (i, i+1): observations and weight factor of eq. (13).
struct WeightedLine {
  int observation_i = -1;  ///< index into InitWindow::lineObservations()
  int observation_j = -1;
  double weight = 0.0;  ///< 0.5 + 0.5 clamp(q, 0, 1), in [0.5, 1]
};

/// The two sets of eq. (7) for one consecutive keyframe pair, best score first.
struct PairLines {
  std::vector<WeightedLine> epipolar;  ///< S^e, scored by q^e
  std::vector<WeightedLine> normal;    ///< S^n, scored by q^n
};

/// q^e of track reliability in [0, 1]: mean of persistence (keyframes seen / keyframes in the
/// window), match quality over the pair (that of the later observation, `observation_j`, an index
/// into InitWindow::lineObservations()), and valid-match ratio (keyframes seen / keyframes from
/// first to last observation). The paper names the three parts and leaves the mix open.
double trackReliability(const InitWindow& window, const Track& track, int observation_j);

/// q^n of saliency in [0, 1]: mean of length / full_length_px (clamped) and detection confidence of
/// observation i, whose normal eq. (12) uses.
double geometricSaliency(const InitWindow& window, int observation_i,
                         const LineSelectionOptions& options);

/// Selects lines for every consecutive pair; entry i is the pair (i, i+1). A candidate is seen in
/// both keyframes and in at least min_keyframes in all; of each kind the best max_lines_per_pair
/// enter. Ties go to the lower track id, so that the result does not depend on the order of
/// observations.
std::vector<PairLines> selectLines(const InitWindow& window, const LineSelectionOptions& options);

}  // namespace slim_init::baselines
