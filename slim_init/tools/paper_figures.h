// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the SLIM-init paper printed, to stand beside what is measured here. Methods go by the names
// of this program; the paper's own method is `slim-paper`. NaN where it printed nothing.
#pragma once

#include <string>
#include <vector>

namespace slim_init::tools {

/// The errors of tables I, III and IV: root mean squares over successful windows.
enum class PaperMetric { kScale, kGravityDeg, kVelocity, kPose };

/// Sequences of table I, in its order: "MH_01" to "V2_03".
const std::vector<std::string>& paperSequences();

double paperAccuracy(PaperMetric metric, const std::string& method,
                     const std::string& sequence);                           ///< table I
double paperAccuracyAverage(PaperMetric metric, const std::string& method);  ///< its last column
double paperSuccess(const std::string& method, const std::string& group);    ///< table II [%]
/// Table III, the average over C_01 to C_03: handheld walks through corridors and a lobby.
double paperDegenerate(PaperMetric metric, const std::string& method);
/// Table IV, the same average; `variant` as in ablation.h, "slim-paper[no-lines]".
double paperAblation(PaperMetric metric, const std::string& variant);
double paperGyroBiasPct(const std::string& variant);  ///< EuRoC's average, section on the ablation
double paperSolveMs(const std::string& method);       ///< EuRoC's mean, text to fig. 6, i9-12900K

}  // namespace slim_init::tools
