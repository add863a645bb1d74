// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The registry of all methods, and refusals of `vins` and `openvins` where their papers refuse.
#include "slim_init/baselines/baselines.h"

#include <gtest/gtest.h>

#include <tuple>

#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init::baselines {
namespace {

// The refusals of the methods themselves.
TEST(BaselineRefusals, VinsAtHoverAndOpenVinsWithoutRotation) {
  ExactWindowOptions hover, straight;
  hover.motion = Motion::kHover;
  hover.pixel_noise = 0.6;
  straight.motion = Motion::kConstantVelocity;
  straight.gyro_bias.setZero();
  const std::tuple<const char*, ExactWindowOptions, const char*> cases[] = {
      {"vins", hover, "(minimum 30)"}, {"openvins", straight, "(minimum 10)"}};
  for (const auto& [method, options, bound] : cases) {
    const InitResult result = makeMethod(method, InitializerOptions(), {}, nullptr, allMethods())
                                  ->solve(*makeExactWindow(options).window);
    EXPECT_EQ(result.status, InitStatus::kTooLittleExcitation) << result.message;
    expectParts(result.message, bound);
    EXPECT_FALSE(result.hasEstimate());
  }
}

TEST(MakeBaseline, RefusesUnknownNamesAndBadOptions) {
  std::string error;
  EXPECT_EQ(makeMethod("sfm", InitializerOptions(), {}, &error, allMethods()), nullptr);
  EXPECT_EQ(error,
            "unknown method \"sfm\", must be one of: slim slim-paper drt-l drt-t drt-vi-ba vins "
            "openvins");
  // Without Ceres.
  EXPECT_EQ(makeMethod("vins", InitializerOptions(), {}, &error), nullptr);
  EXPECT_EQ(error,
            "unknown method \"vins\", must be one of: slim slim-paper drt-l drt-t drt-vi-ba");
  InitializerOptions bad;
  bad.gates.min_excitation = -1.0;
  EXPECT_EQ(makeMethod("vins", bad, {}, &error, allMethods()), nullptr);
  expectParts(error, "gates.min_excitation");
  for (const std::string& name : namesOf(allMethods())) {
    EXPECT_EQ(makeMethod(name, InitializerOptions(), {}, nullptr, allMethods())->name(), name);
  }
}

}  // namespace
}  // namespace slim_init::baselines
