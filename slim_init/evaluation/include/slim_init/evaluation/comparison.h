// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Methods against one of them, window by window, with the uncertainty of each difference.
// Definitions: docs/evaluation.md.
#pragma once

#include <string>
#include <vector>

#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/report.h"  // summarize() of several sequences

namespace slim_init::evaluation {

/// A number with its 95 % confidence interval. All NaN where the number does not exist; low and
/// high alone are NaN where there is too little data for an interval.
struct Interval {
  double value = kNotComputed;
  double low = kNotComputed;
  double high = kNotComputed;

  /// Zero is outside the interval; false without one.
  bool significant() const { return low > 0.0 || high < 0.0; }
};

/// One method minus the reference, on the windows that both were handed. Of an error a negative
/// difference is in the method's favour, of the success rate a positive one.
struct Comparison {
  std::string method;
  int windows = 0;        ///< of the sequences with truth that both ran on
  int both_success = 0;   ///< windows in which both succeed (|s - 1| < 0.5)
  Interval success_rate;  ///< over all windows, in [-1, 1]
  Interval scale_rmse;    ///< this and those below: over windows in which both succeed
  Interval gravity_rmse_deg;
  Interval velocity_rmse;  ///< [m/s]
  Interval pose_rmse;      ///< [m]
};

/// The windows that are looked at.
enum class WindowSubset { kAll, kExcited };

/// How intervals are found. The defaults are those of every report.
struct BootstrapOptions {
  int replicates = 2000;
  unsigned seed = 1;     ///< equal seeds give equal intervals, on any machine
  double block_s = 0.0;  ///< data that are drawn together [s]; 0: two windows' length
};

/// Every method but `reference` compared with it, in the order in which `sequences` first name
/// them. Empty where no sequence has the reference. A method that did not run on a sequence is
/// compared on the others; sequences without truth are left out.
///
/// Intervals come from a moving-block bootstrap. Windows overlap and neighbours see the same
/// motion, so consecutive ones are drawn together, in blocks of two windows' length. Every sequence
/// keeps its number of windows, blocks never cross from one into another, and a block that meets
/// the end of its sequence goes on at the beginning, so that every window is drawn as often as any
/// other (Kuensch 1989; Politis and Romano 1992). The percentiles are moved away from the value by
/// Student's factor for the number of blocks. The draws are the same for all methods.
std::vector<Comparison> compareWith(const std::string& reference,
                                    const std::vector<const ProtocolResult*>& sequences,
                                    WindowSubset subset, const BootstrapOptions& options = {});

}  // namespace slim_init::evaluation
