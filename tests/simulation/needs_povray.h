// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "slim_init/simulation/rendering.h"

/// A test that renders is skipped where POV-Ray is missing: the library and its other tests work
/// without it, and a user may not want it. In continuous integration (CI is set), where the set-up
/// script installs it, its absence is a failure, so that the test cannot be skipped unnoticed.
#define NEEDS_POVRAY()                                                              \
  do {                                                                              \
    std::string povray_problem;                                                     \
    if (::slim_init::simulation::povrayAvailable("povray", &povray_problem)) break; \
    const char* const in_ci = std::getenv("CI");                                    \
    ASSERT_TRUE(in_ci == nullptr || *in_ci == '\0') << povray_problem;              \
    GTEST_SKIP() << "nothing is rendered in this test: " << povray_problem;         \
  } while (false)
