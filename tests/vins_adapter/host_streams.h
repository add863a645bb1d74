// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A generated flight as a host hands it over.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host_health/flight.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "slim_init/vins_adapter/host_convention.h"
#include "support/exact_window.h"

namespace slim_init::vins_adapter {

using host_health::kHostFrames;

inline std::unique_ptr<HostAdapter> adapterOf(std::unique_ptr<IInitializer> initializer,
                                              const HostOptions& options) {
  std::string error;
  auto adapter = HostAdapter::create(std::move(initializer), options, &error);
  EXPECT_NE(adapter, nullptr) << error;
  return adapter;
}

/// The frames from `first` to `last`, each after the samples of `imu` up to the first one after it.
/// `next`: the first sample that the adapter does not have yet.
inline void feed(const ExactWindow& exact, const std::vector<ImuSample>& imu, int first, int last,
                 std::size_t* next, HostAdapter* adapter) {
  for (int k = first; k <= last; ++k) {
    while (*next < imu.size() && (*next == 0 || imu[*next - 1].t < exact.truth[k].t)) {
      const ImuSample& sample = imu[(*next)++];
      adapter->addImu(sample.t, sample.accel, sample.gyro);
    }
    adapter->addFrame(exact.keyframes[k]);
  }
}

/// Stamps of the host's window whose newest frame is `last`.
inline std::vector<double> stampsOf(const ExactWindow& exact, int last, int count = kHostFrames) {
  std::vector<double> stamps;
  for (int k = std::max(0, last - count + 1); k <= last; ++k) {
    stamps.push_back(exact.keyframes[k].t);
  }
  return stamps;
}

/// The true states from frame `first` to `last`.
inline std::vector<HostState> statesOf(const ExactWindow& exact, int first, int last) {
  std::vector<HostState> states;
  for (int k = first; k <= last; ++k) states.push_back(toHostState(exact.truth[k], 0.0));
  return states;
}

}  // namespace slim_init::vins_adapter
