// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Answers to one question asked again and again while a window grows.
#pragma once

#include <deque>
#include <vector>

#include "slim_init/result.h"

namespace slim_init {

/// Judges each answer by those before it.
///
/// Whoever asks at every frame until the answer is a yes gets the first yes, and with it the one
/// whose errors happen to look most certain: the chance of a wrong yes is that of the whole
/// sequence. A right answer, however, changes little as data are added. Where the second answer
/// rests on the data of the first and more, the difference of both has the variance
/// sigma_1^2 - sigma_2^2; wrong minima, and scales that follow the noise, move by more
/// (docs/derivation.md, 6.3). So a window that is still growing needs earlier answers, and they
/// have to agree with it. The gate is GateName::kAgreement.
class AnswerSequence {
 public:
  /// Largest disagreement that is accepted, in standard deviations. Between 1 and 3 the share of
  /// wrong answers changes little; a right one is refused for one more keyframe now and then.
  static constexpr double kMaxDisagreement = 2.0;

  /// Earlier answers that a growing window needs.
  static constexpr int kEarlierAnswers = 2;

  /// Share of `full_span_s` from which a window does not grow any more: keyframes fall on images.
  static constexpr double kFullShare = 0.9;

  /// `full_span_s`: WindowOptions::fullSpan(); windows shorter than kFullShare of it are growing.
  /// `max_disagreement`: bound on the difference of the log scales in standard deviations; zero:
  /// nothing is asked. `earlier_answers`: of a growing window, at least 1.
  AnswerSequence(double full_span_s, double max_disagreement, int earlier_answers = kEarlierAnswers)
      : full_span_s_(full_span_s),
        max_disagreement_(max_disagreement),
        earlier_answers_(earlier_answers) {}

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

  double full_span_s_;
  double max_disagreement_;
  int earlier_answers_;
  std::deque<Answer> earlier_;  // by time
};

}  // namespace slim_init
