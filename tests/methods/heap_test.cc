// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The heap after many windows is the heap after a few. SLIM_INIT_HEAP_WINDOWS=100000 runs the long
// form of it (eight minutes).
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "slim_init/baselines/baselines.h"
#include "support/exact_window.h"

// GCC says it with a macro, Clang with a feature.
#if defined(__SANITIZE_ADDRESS__)
#define SLIM_INIT_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SLIM_INIT_ADDRESS_SANITIZER 1
#endif
#endif
#ifndef SLIM_INIT_ADDRESS_SANITIZER
#define SLIM_INIT_ADDRESS_SANITIZER 0
#endif

namespace slim_init {
namespace {

// Bytes that the program holds, whatever the allocator keeps for later.
std::size_t bytesInUse() {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
  const auto info = mallinfo2();
#else
  const auto info = mallinfo();
#endif
  return static_cast<std::size_t>(info.uordblks) + static_cast<std::size_t>(info.hblkhd);
}

TEST(Heap, DoesNotGrowWithTheNumberOfWindows) {
#if SLIM_INIT_ADDRESS_SANITIZER
  // Its own heap is invisible to mallinfo, so that the comparison would pass whatever happens.
  GTEST_SKIP() << "the address sanitizer replaces the allocator, and finds leaks itself";
#endif
  int windows = 1000;
  if (const char* asked = std::getenv("SLIM_INIT_HEAP_WINDOWS")) windows = std::atoi(asked);
  ASSERT_GE(windows, 100);
  std::vector<ExactWindow> inputs;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    ExactWindowOptions options = seeded(seed);
    // Refusals take other ways through the program.
    if (seed == 7) options.motion = Motion::kHover;
    if (seed == 8) options.points = 5;
    inputs.push_back(noisyWindow(options));
  }
  for (const std::string& name : baselines::namesOf(baselines::methods())) {
    const auto solver = baselines::makeMethod(name, InitializerOptions());
    for (const ExactWindow& exact : inputs) solver->solve(*exact.window);
    const std::size_t before = bytesInUse();
    for (int k = 0; k < windows; ++k) solver->solve(*inputs[k % inputs.size()].window);
    // The smallest leak, 32 bytes a window, is thirty times as much; the allocator's own books move
    // by some hundred.
    EXPECT_LT(bytesInUse(), before + 1024)
        << name << " after " << windows
        << " windows (by hand: with the environment that tests/methods/CMakeLists.txt sets)";
  }
}

}  // namespace
}  // namespace slim_init
