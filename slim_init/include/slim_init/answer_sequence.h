// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Answers to one question asked again and again while a window grows.
#pragma once

#include <deque>
#include <vector>

#include "slim_init/result.h"

namespace slim_init {

/// Judges each answer by the one before it.
///
/// Whoever asks at every frame until the answer is a yes gets the first yes, and with it the one
/// whose errors happen to look most certain: the chance of a wrong yes is that of the whole
/// sequence. A right answer, however, changes little as data are added. Where the second answer
/// rests on the data of the first and more, the difference of both has the variance
/// sigma_1^2 - sigma_2^2; wrong minima, and scales that follow the noise, move by more
/// (docs/derivation.md, 6.3). So a window that is still growing needs an earlier answer, and an
/// earlier answer has to agree. The gate is called "agreement".
class AnswerSequence {
 public:
  /// Largest disagreement that is accepted, in standard deviations. Between 1 and 3 the share of
  /// wrong answers changes little; a right one is refused for one more keyframe now and then.
  static constexpr double kMaxDisagreement = 2.0;

  /// `full_keyframes`: windows with fewer are growing. `max_disagreement`: bound on the difference
  /// of the log scales in standard deviations; zero: nothing is asked.
  AnswerSequence(int full_keyframes, double max_disagreement)
      : full_keyframes_(full_keyframes), max_disagreement_(max_disagreement) {}

  /// Adds the gate to `result`, and refuses a success where it fails and gates are enforced.
  /// Results without states or without a standard deviation of the scale are left alone and not
  /// remembered. Results come in the order of their windows; an earlier one counts as soon as a
  /// tenth of a second of data is newer. Both are compared where they overlap; their keyframes need
  /// not be the same.
  void judge(InitResult* result);

  /// Forgets all answers: the stream has begun anew.
  void reset();

 private:
  struct Answer {
    std::vector<NavState> states;
    double sigma = kNotComputed;
  };

  int full_keyframes_;
  double max_disagreement_;
  std::deque<Answer> earlier_;  // by time; the front is the newest that counts, if any does
};

}  // namespace slim_init
