// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The version of the headers and, as CMake reads it from here, of the project.
// Before 1.0 every minor version may change the interface and has a shared-library version
// (SOVERSION 0.<minor>) of its own.
#pragma once

#define SLIM_INIT_VERSION_MAJOR 0
#define SLIM_INIT_VERSION_MINOR 2
#define SLIM_INIT_VERSION_PATCH 0

/// For comparisons: SLIM_INIT_VERSION_CODE >= SLIM_INIT_MAKE_VERSION(0, 2, 0).
#define SLIM_INIT_MAKE_VERSION(major, minor, patch) ((major)*10000 + (minor)*100 + (patch))
#define SLIM_INIT_VERSION_CODE \
  SLIM_INIT_MAKE_VERSION(SLIM_INIT_VERSION_MAJOR, SLIM_INIT_VERSION_MINOR, SLIM_INIT_VERSION_PATCH)

namespace slim_init {

/// "major.minor.patch"
constexpr const char* kVersion = "0.2.0";

}  // namespace slim_init
