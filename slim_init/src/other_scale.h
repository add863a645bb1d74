// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The search of another scale that explains a window as well (docs/derivation.md, 5.1).
#pragma once

#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "lines/line_agreement.h"
#include "minimum_search.h"
#include "slim_init/options.h"
#include "verdict/scale_profile.h"

namespace slim_init {

/// Profile of a refined window over its scale. Where another scale has the lower cost, the window
/// is refined again from there; `refined` and `posterior` become that answer, and the profile that
/// of it, where its cost really is the lower one. `refined` and `posterior` valid; `lines` as
/// searchMinimum() has them.
ScaleProfile searchOtherScale(const RefinementInput& input, const AgreeingLines& lines,
                              const InitializerOptions& options, RefinedWindow* refined,
                              Posterior* posterior);

}  // namespace slim_init
