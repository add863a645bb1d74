// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slim_init::tools {

/// The text of slim_init/evaluation/scripts/plot_report.py.
const char* plotScript();

}  // namespace slim_init::tools
