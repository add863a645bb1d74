// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Successive estimates of an expanding window.
#pragma once

#include <deque>
#include <vector>

#include "slim_init/result.h"

namespace slim_init {

/// Compares each estimate with those before it (consistency check).
///
/// Solving at every frame until an estimate is accepted gives the first one under the bound, the
/// one whose errors happen to look most certain: the probability of an incorrect one is that of the
/// whole sequence. A correct estimate, however, changes little as data are added. If the second
/// estimate rests on the data of the first and more, the difference of both has the variance
/// sigma_1^2 - sigma_2^2; incorrect minima, and scales that follow the noise, move by more
/// (docs/derivation.md, 6.3). So an expanding window needs earlier estimates, as a full
/// one does after a refusal, and they have to agree with it. The gate is GateName::kAgreement.
class ConsistencyCheck {
 public:
  /// Largest disagreement that is accepted, in standard deviations. Between 1 and 3 the fraction of
  /// incorrect estimates changes little; a correct one is sometimes refused for one more keyframe.
  static constexpr double kMaxDisagreement = 2.0;

  /// Earlier estimates that an expanding window needs, and a full one after a refusal.
  static constexpr int kEarlierEstimates = 2;

  /// Fraction of `full_span_s` from which a window is full: keyframes fall on images.
  static constexpr double kFullFraction = 0.9;

  /// Two timestamps are the same when they are this close [s]: nearer than two images.
  static constexpr double kSameInstant = 1e-3;

  /// `full_span_s`: WindowOptions::fullSpan(); windows shorter than kFullFraction of it are
  /// expanding. `max_disagreement`: bound on the difference of the log scales in standard
  /// deviations; zero: no check. `earlier_estimates`: see kEarlierEstimates, at least 1.
  ConsistencyCheck(double full_span_s, double max_disagreement,
                   int earlier_estimates = kEarlierEstimates)
      : full_span_s_(full_span_s),
        max_disagreement_(max_disagreement),
        earlier_estimates_(earlier_estimates) {}

  /// Adds the gate to `result`, and refuses a success where it fails and gates are enforced.
  /// Results without states or without a standard deviation of the scale are left alone; of them
  /// only a refusal is remembered. Results come in the order of their windows; an earlier one
  /// counts as soon as a tenth of a second of data is newer. Both are compared where they overlap;
  /// their keyframes need not be the same.
  void judge(InitResult* result);

  /// Forgets all estimates: the stream was restarted.
  void reset();

  /// Whether the newest result was not a success.
  bool refusedBefore() const { return refused_before_; }

 private:
  struct Estimate {
    std::vector<NavState> states;
    double sigma = kNotComputed;
  };

  double full_span_s_;
  double max_disagreement_;
  int earlier_estimates_;
  std::deque<Estimate> earlier_;  // by time
  bool refused_before_ = false;
};

}  // namespace slim_init
