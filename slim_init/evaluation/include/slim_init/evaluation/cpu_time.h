// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slim_init::evaluation {

/// CPU time of the calling thread since its beginning [ms], which other programs on the machine do
/// not lengthen; NaN where the system has no such clock.
double threadCpuMs();

}  // namespace slim_init::evaluation
