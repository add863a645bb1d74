// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// One row of slim_init_starts.csv: one attempt to seed or recover the host, its verdict and time.
#pragma once

#include <string>

#include "slim_init/vins_adapter/host_adapter.h"

namespace slim_init::vins_adapter {

/// The host's own answer, in shadow mode.
struct StockStart {
  bool tried = false;
  bool success = false;
  double ms = kNotComputed;
  HostWindow window;  ///< where successful
};

/// Header line of the file, without the line break.
std::string startRecordHeader();

/// One row, without the line break. `action` is "seed", "join" (a seed that continues an earlier
/// odometry frame) or "recover"; `stock` is null outside shadow mode. Fields that were not computed
/// are empty.
std::string startRecordRow(HostMode mode, const std::string& action, const HostResult& answer,
                           const StockStart* stock);

}  // namespace slim_init::vins_adapter
