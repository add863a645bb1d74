// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The table says which methods read a key. A key that a method does not read must not change its
// answer, or the note "without effect" would be wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "slim_init/baselines/baselines.h"
#include "slim_init/config/config.h"
#include "support/exact_window.h"
#include "support/method_name.h"
#include "support/option_checks.h"
#include "support/same_result.h"

namespace slim_init {
namespace {

InitResult solve(const std::string& method, const Config& config, const InitWindow& window) {
  std::string error;
  const auto solver =
      baselines::makeMethod(method, config.options, {}, &error, baselines::allMethods());
  EXPECT_NE(solver, nullptr) << error;
  return solver == nullptr ? InitResult() : solver->solve(window);
}

// Another valid value: the other side of a switch, or a number towards a bound.
bool change(const OptionField& option, double share, const Config& config) {
  if (const auto* flag = std::get_if<bool*>(&option.value)) {
    **flag = !**flag;
  } else if (const auto* whole = std::get_if<int*>(&option.value)) {
    const double old = **whole;
    const double bound = share < 0.0 ? option.range.min : option.range.max;
    setNumber(option, std::abs(bound - old) < 100.0 ? bound : 2.0 * old);
  } else if (const auto* real = std::get_if<double*>(&option.value)) {
    const double factor = share < 0.0 ? 0.5 : 1.5;
    setNumber(option, std::min(std::max(factor * **real, option.range.min), option.range.max));
  } else {
    return false;
  }
  return config.options.validate().empty();
}

bool sameGates(const InitResult& a, const InitResult& b) {
  if (a.gates.size() != b.gates.size()) return false;
  for (std::size_t i = 0; i < a.gates.size(); ++i) {
    // Not a number equals itself here.
    const bool same_value =
        a.gates[i].value == b.gates[i].value ||
        (a.gates[i].value != a.gates[i].value && b.gates[i].value != b.gates[i].value);
    if (!same_value || a.gates[i].threshold != b.gates[i].threshold ||
        a.gates[i].passed != b.gates[i].passed) {
      return false;
    }
  }
  return true;
}

class KeysOfMethod : public ::testing::TestWithParam<std::string> {};

TEST_P(KeysOfMethod, WhatItDoesNotReadDoesNotChangeItsAnswer) {
  const std::string& method = GetParam();
  const ExactWindow exact = noisyWindow();
  const InitResult before = solve(method, Config(), *exact.window);
  Config defaults;
  const std::size_t rows = configTable(&defaults).size();
  int tested = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    for (const double side : {-1.0, 1.0}) {
      Config config;
      const OptionField option = configTable(&config)[i];
      if (option.isReadBy(method) || !change(option, side, config)) continue;
      const InitResult after = solve(method, config, *exact.window);
      EXPECT_TRUE(sameBytes(before, after) && sameGates(before, after)) << option.key;
      ++tested;
    }
  }
  EXPECT_GE(tested, method == "slim" ? 0 : 20);
}

INSTANTIATE_TEST_SUITE_P(Methods, KeysOfMethod,
                         ::testing::ValuesIn(baselines::namesOf(baselines::allMethods())),
                         methodTestName);

// Zero means measured; a factor takes its place.
TEST(KeysOfSlim, NoiseFactorsTakeThePlaceOfTheMeasurement) {
  const ExactWindow exact = noisyWindow();
  const InitResult measured = solve("slim", Config(), *exact.window);
  ASSERT_TRUE(measured.hasEstimate());
  Config accel, gyro;
  accel.options.inertial.accel_noise_factor = 20.0;
  gyro.options.inertial.gyro_noise_factor = 20.0;
  EXPECT_FALSE(sameBytes(measured, solve("slim", accel, *exact.window)));
  EXPECT_FALSE(sameBytes(measured, solve("slim", gyro, *exact.window)));
}

// One key per quantity: each acts in every stage of slim that has the quantity. Without the
// refinement what is left is the bias estimate and the starts.
TEST(KeysOfSlim, SharedQuantitiesChangeTheAnswerAndActBeforeTheRefinement) {
  const ExactWindow exact = noisyWindow();
  for (const bool refine : {true, false}) {
    Config plain;
    plain.options.slim.refine = refine;
    const InitResult before = solve("slim", plain, *exact.window);
    ASSERT_TRUE(before.hasEstimate());
    for (const char* key : {"inertial.accel_bias_prior", "inertial.gyro_bias_prior",
                            "vanishing_point.inlier_threshold_deg"}) {
      Config config = plain;
      for (const OptionField& option : configTable(&config)) {
        if (option.key != key) continue;
        ASSERT_TRUE(change(option, 1.0, config));
      }
      EXPECT_FALSE(sameBytes(before, solve("slim", config, *exact.window))) << refine << key;
    }
  }
}

}  // namespace
}  // namespace slim_init
