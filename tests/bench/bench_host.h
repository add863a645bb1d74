// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A host around the adapter and what it receives, for `slim_init_bench faults` and `soak`.
#pragma once

#include <functional>
#include <map>
#include <memory>

#include "slim_init/evaluation/sequence.h"
#include "slim_init/vins_adapter/host_adapter.h"
#include "stream_faults.h"

namespace slim_init::tools {

/// From `start` on [s, IMU clock of the sequence]: `seconds` of IMU data, and every second image of
/// a camera of 20 Hz.
Streams streamsFrom(const evaluation::Sequence& sequence, double start, double seconds);

/// Applies the fault, to all of the streams or to a part near their beginning, and sorts them by
/// arrival. `start` and `seconds` as they were given to streamsFrom(); neither stream may be empty.
void applyFault(const StreamFault& fault, double start, double seconds, std::mt19937_64* random,
                Streams* streams);

/// A host that keeps the newest eleven frames and asks about them.
class BenchHost {
 public:
  /// `sequence`, which has the truth, has to outlive the host. `calibration` is what the host is
  /// told.
  BenchHost(const evaluation::Sequence& sequence, const Calibration& calibration);

  bool isMade() const { return adapter_ != nullptr; }

  /// All data are forgotten.
  void restart();
  /// The calibration's td from now on [s].
  void setTd(double td) {
    calibration_.td = td;
    adapter_->setTd(td);
  }
  /// Feeds the streams in the order of their arrival. `seen` is called at every frame that the
  /// adapter takes, as there is something new to ask about then, and ends it by returning false.
  void feed(Streams streams, const std::function<bool(double arrival)>& seen);

  /// True where that was answered.
  bool seed();
  /// The same after a failure, where the oldest frame of the window was the last healthy one: its
  /// state is the true one, with the biases of the start; no recording has the accelerometer's.
  bool recover();

  const vins_adapter::HostResult& answer() const { return answer_; }

  /// Of the answer: spread of its positions over that of the true ones, minus one; NaN without
  /// truth.
  double scaleError() const;

 private:
  bool add(const Delivered<FrameObservation>& frame);
  std::vector<double> stamps() const;

  const evaluation::Sequence& sequence_;
  Calibration calibration_;
  std::unique_ptr<vins_adapter::HostAdapter> adapter_;
  std::map<double, double> window_;  // stamp and true time
  vins_adapter::HostResult answer_;
  vins_adapter::HostState started_;  // the newest state of the last start
};

/// Relative errors of the scale that count as right, and as wrong.
inline constexpr double kRightScale = 0.1, kWrongScale = 0.25;

}  // namespace slim_init::tools
