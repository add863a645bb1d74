// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Asks the library through the adapter's headers, so that compiling and linking prove something.
#include <cstdio>
#include <string>
#include <vector>

#include "slim_init/initializer.h"
#include "slim_init/vins_adapter/host_convention.h"

int main() {
  slim_init::NavState state;
  state.t = 1.0;
  slim_init::vins_adapter::HostWindow window;
  std::string error;
  if (!slim_init::vins_adapter::toHostWindow(
          {state}, 9.81, 0.0, slim_init::vins_adapter::HostOrigin::kFirstBody, &window, &error)) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  const auto initializer =
      slim_init::makeInitializer(slim_init::Calibration(), slim_init::InitializerOptions(), &error);
  std::printf("%s, G = %.2f\n", initializer ? initializer->info().method.c_str() : error.c_str(),
              window.G.z());
  return initializer && window.states.size() == 1 ? 0 : 1;
}
