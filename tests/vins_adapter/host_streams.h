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

/// An adapter that is fed from a flight; it recovers, and waits for its solves.
class FedAdapter : public ::testing::Test {
 protected:
  FedAdapter() {
    options_.reinit = true;
    options_.max_wait_ms = -1.0;
  }
  /// An adapter with the options as they are now; its streams begin anew.
  void make(std::unique_ptr<IInitializer> initializer) {
    adapter_ = adapterOf(std::move(initializer), options_);
    next_ = 0;
  }
  /// These frames, each after the samples up to the first one after it.
  void feed(int first, int last) {
    const std::vector<ImuSample>& imu = exact_.imu;
    for (int k = first; k <= last; ++k) {
      while (next_ < imu.size() && (next_ == 0 || imu[next_ - 1].t < exact_.truth[k].t)) {
        const ImuSample& sample = imu[next_++];
        adapter_->addImu(sample.t, sample.accel, sample.gyro);
      }
      adapter_->addFrame(exact_.keyframes[k]);
    }
  }
  /// Of the host's window whose newest frame is `last`.
  std::vector<double> stamps(int last, int count = kHostFrames) const {
    std::vector<double> stamps;
    for (int k = std::max(0, last - count + 1); k <= last; ++k) {
      stamps.push_back(exact_.keyframes[k].t);
    }
    return stamps;
  }
  /// The true states from frame `first` to `last`, and of the host's window.
  std::vector<HostState> statesOf(int first, int last) const {
    std::vector<HostState> states;
    for (int k = first; k <= last; ++k) states.push_back(toHostState(exact_.truth[k], 0.0));
    return states;
  }
  std::vector<HostState> window(int newest) const {
    return statesOf(newest - kHostFrames + 1, newest);
  }
  HostHealth watch(const std::vector<HostState>& states, bool wants_evidence = false) {
    const Calibration& rig = exact_.calibration;
    return adapter_->watch(states, rig.R_b_c, rig.t_b_c, wants_evidence);
  }

  ExactWindow exact_ = makeExactWindow(atTenHertz(35));
  HostOptions options_;
  std::unique_ptr<HostAdapter> adapter_;
  std::size_t next_ = 0;  ///< the first sample that the adapter does not have yet
};

}  // namespace slim_init::vins_adapter
