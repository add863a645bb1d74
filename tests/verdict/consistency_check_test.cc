// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/consistency_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/fake_solver.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

constexpr int kFull = 10;  // keyframes
constexpr double kFullSpan = 0.1 * (kFull - 1);
constexpr double kBound = 2.0;

// An accepted answer, keyframes 0.1 s apart.
InitResult answer(int first, int count, double scale, double sigma) {
  std::vector<double> times;
  for (int k = first; k < first + count; ++k) times.push_back(0.1 * k);
  return bentPath(times, scale, sigma);
}

InitResult everySecond(InitResult result) {
  std::vector<NavState> states;
  for (std::size_t k = 1; k < result.states.size(); k += 2) states.push_back(result.states[k]);
  result.states = states;
  return result;
}

InitResult judged(ConsistencyCheck* sequence, InitResult result) {
  sequence->judge(&result);
  return result;
}

TEST(ConsistencyCheck, AGrowingWindowNeedsAnAnswerBefore) {
  ConsistencyCheck sequence(kFullSpan, kBound, 1);
  const InitResult first = judged(&sequence, answer(0, 5, 1.0, 0.08));
  EXPECT_EQ(first.status, InitStatus::kScaleTooUncertain);
  EXPECT_EQ(first.gates.back().name, GateName::kAgreement);
  expectParts(first.message, "too few earlier solves");
  // The same keyframes again are no second answer.
  EXPECT_FALSE(judged(&sequence, answer(0, 5, 1.0, 0.08)).success());
  const InitResult second = judged(&sequence, answer(0, 6, 1.01, 0.07));
  EXPECT_TRUE(second.success()) << second.message;
  EXPECT_EQ(second.status, InitStatus::kSuccess);
  // And asked again, it is still the second.
  EXPECT_TRUE(judged(&sequence, answer(0, 6, 1.01, 0.07)).success());
}

TEST(ConsistencyCheck, AsManyEarlierAnswersAsAreAskedForHaveToAgree) {
  for (const double first : {1.0, 1.3}) {
    ConsistencyCheck sequence(kFullSpan, kBound, 2);
    EXPECT_FALSE(judged(&sequence, answer(0, 4, first, 0.09)).success());
    EXPECT_FALSE(judged(&sequence, answer(0, 5, 1.0, 0.05)).success()) << "one is not two";
    const InitResult third = judged(&sequence, answer(0, 6, 1.0, 0.05));
    EXPECT_EQ(third.success(), first == 1.0) << third.message;
  }
}

TEST(ConsistencyCheck, AnswersOfOtherDataAreForgotten) {
  ConsistencyCheck sequence(5.0, kBound, 1);
  judged(&sequence, answer(0, 20, 1.0, 0.09));
  EXPECT_FALSE(judged(&sequence, answer(20, 20, 1.0, 0.08)).success()) << "2 s later";
  EXPECT_TRUE(judged(&sequence, answer(32, 20, 1.0, 0.07)).success()) << "1.2 s later";
}

TEST(ConsistencyCheck, TheDifferenceIsMeasuredInItsStandardDeviations) {
  // sigma_1^2 - sigma_2^2 = 0.08^2 - 0.06^2, and half of sigma_2.
  const double sigma = std::sqrt(0.0028 + 0.0009);
  for (const double share : {0.99, 1.01}) {
    for (const double sign : {-1.0, 1.0}) {
      ConsistencyCheck sequence(kFullSpan, kBound, 1);
      judged(&sequence, answer(0, 5, 1.0, 0.08));
      const double scale = std::exp(sign * share * kBound * sigma);
      const InitResult result = judged(&sequence, answer(0, 6, scale, 0.06));
      EXPECT_EQ(result.success(), share < 1.0) << result.message;
      EXPECT_NEAR(result.gates.back().value, share * kBound, 1e-9);
    }
  }
}

TEST(ConsistencyCheck, AFullWindowNeedsNoneBeforeButMustNotContradictOne) {
  ConsistencyCheck sequence(kFullSpan, kBound, 1);
  const InitResult alone = judged(&sequence, answer(0, kFull, 1.0, 0.05));
  EXPECT_TRUE(alone.success());
  EXPECT_EQ(alone.gates.size(), 1u);
  EXPECT_TRUE(judged(&sequence, answer(1, kFull, 1.01, 0.05)).success());
  EXPECT_FALSE(judged(&sequence, answer(2, kFull, 1.3, 0.05)).success());
}

// A far scene gives a scale by chance, if it is solved often enough.
TEST(ConsistencyCheck, AFullWindowAfterOthersNeedsAsManyAsAGrowingOne) {
  ConsistencyCheck sequence(kFullSpan, kBound, 2);
  InitResult none;
  none.status = InitStatus::kPureRotation;
  judged(&sequence, none);
  EXPECT_EQ(judged(&sequence, answer(1, kFull, 1.0, 0.05)).status, InitStatus::kScaleTooUncertain);
  EXPECT_FALSE(judged(&sequence, answer(2, kFull, 1.0, 0.05)).success());
  EXPECT_TRUE(judged(&sequence, answer(3, kFull, 1.0, 0.05)).success());
  sequence.reset();
  EXPECT_TRUE(judged(&sequence, answer(4, kFull, 1.0, 0.05)).success());
}

// A tenth of new data in a window makes its scale hardly more certain: one that seems to be does
// not agree with everything before it.
TEST(ConsistencyCheck, NewDataExcuseAsMuchAsTheyCanHaveTold) {
  const double possible = std::pow(9.0 / 8.0, 5.0);
  for (const double share : {0.9, 1.1}) {
    ConsistencyCheck sequence(kFullSpan, kBound, 1);
    judged(&sequence, answer(0, kFull, 1.0, 0.4));
    const double scale = std::exp(share * kBound * 0.05 * std::sqrt(possible - 0.75));
    EXPECT_EQ(judged(&sequence, answer(1, kFull, scale, 0.05)).success(), share < 1.0);
  }
}

// A host's keyframes are counted back from its newest image: those of two answers lie between each
// other.
TEST(ConsistencyCheck, KeyframesNeedNotBeTheSame) {
  for (const double scale : {1.0, 1.2}) {
    ConsistencyCheck sequence(kFullSpan, kBound, 1);
    judged(&sequence, everySecond(answer(0, 10, 1.0, 0.08)));
    const InitResult result = judged(&sequence, everySecond(answer(1, 10, scale, 0.07)));
    EXPECT_EQ(result.success(), scale == 1.0);
    EXPECT_NEAR(result.gates.back().value,
                std::log(scale) / std::sqrt(0.08 * 0.08 - 0.75 * 0.07 * 0.07), 1e-9);
  }
}

TEST(ConsistencyCheck, AnAnswerCountsWhenATenthOfASecondIsNewer) {
  const auto later = [](double dt) {
    InitResult result = answer(0, 6, 1.0, 0.08);
    for (NavState& state : result.states) state.t += dt;
    return result;
  };
  ConsistencyCheck sequence(kFullSpan, kBound, 1);
  EXPECT_FALSE(judged(&sequence, later(0.0)).success());
  EXPECT_FALSE(judged(&sequence, later(0.033)).success());
  EXPECT_FALSE(judged(&sequence, later(0.067)).success());
  EXPECT_TRUE(std::isfinite(judged(&sequence, later(0.1)).gates.back().value));
}

TEST(ConsistencyCheck, AnUncertainAnswerIsNotExcusedFromAgreeing) {
  for (const double scale : {1.0, 1.5}) {
    ConsistencyCheck sequence(kFullSpan, kBound, 1);
    judged(&sequence, answer(0, 5, scale, 2.0));
    EXPECT_EQ(judged(&sequence, answer(0, 6, 1.0, 0.08)).success(), scale == 1.0);
  }
}

TEST(ConsistencyCheck, AnswersWithoutStatesDoNotCount) {
  ConsistencyCheck sequence(kFullSpan, kBound, 1);
  EXPECT_FALSE(judged(&sequence, answer(0, 6, 1.0, 0.08)).success());
  EXPECT_TRUE(judged(&sequence, answer(0, 7, 1.0, 0.08)).success());
  InitResult none;
  none.status = InitStatus::kStationary;
  EXPECT_TRUE(judged(&sequence, none).gates.empty());
  EXPECT_TRUE(judged(&sequence, answer(0, 5, 1.0, kNotComputed)).success());
  // Refused by another gate: its scale counts all the same, and its status stays.
  InitResult refused = answer(0, 8, 1.0, 0.15);
  refused.status = InitStatus::kInconsistentResiduals;
  EXPECT_EQ(judged(&sequence, refused).status, InitStatus::kInconsistentResiduals);
  EXPECT_TRUE(judged(&sequence, answer(0, 9, 1.0, 0.08)).success());
}

TEST(ConsistencyCheck, ForgetsWhenTimeGoesBackAndOnReset) {
  ConsistencyCheck sequence(kFullSpan, kBound, 1);
  judged(&sequence, answer(20, 5, 1.0, 0.08));
  EXPECT_FALSE(judged(&sequence, answer(0, 6, 1.0, 0.08)).success());
  sequence.reset();
  EXPECT_FALSE(judged(&sequence, answer(0, 7, 1.0, 0.08)).success());
  EXPECT_TRUE(judged(&sequence, answer(0, 8, 1.0, 0.08)).success());
  // Nothing in common with the one before.
  EXPECT_FALSE(judged(&sequence, answer(30, 8, 1.0, 0.08)).success());
}

TEST(ConsistencyCheck, IsNotAskedWithABoundOfZeroAndRefusesNothingWithGatesOff) {
  ConsistencyCheck off(kFullSpan, 0.0);
  EXPECT_TRUE(judged(&off, answer(0, 5, 1.0, 0.08)).success());
  EXPECT_EQ(judged(&off, answer(0, 6, 2.0, 0.08)).gates.size(), 1u);
  ConsistencyCheck sequence(kFullSpan, kBound, 1);
  InitResult reported = answer(0, 5, 1.0, 0.08);
  reported.gates[0].enforced = false;
  reported = judged(&sequence, reported);
  EXPECT_TRUE(reported.success());
  EXPECT_FALSE(reported.gates.back().passed);
  EXPECT_FALSE(reported.gates.back().enforced);
  // A scale that is not positive is refused by every method, whether it has gates or not.
  reported = answer(0, 7, 1.5, 0.08);
  reported.gates[0].name = GateName::kScalePositive;
  EXPECT_TRUE(judged(&sequence, reported).success());
}

}  // namespace
}  // namespace slim_init
