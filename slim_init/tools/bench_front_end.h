// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slim_init::tools {

/// Registers the benchmarks of the image front end on the recording in `folder` (ASL layout with
/// its calibration). Null or empty: prints that they are left out. False, with a message on
/// standard error, when the folder cannot be read.
bool registerFrontEndBenchmarks(const char* folder);

}  // namespace slim_init::tools
