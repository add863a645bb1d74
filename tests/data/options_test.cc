// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/options.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>
#include <string>

#include "slim_init/result.h"
#include "slim_init/types.h"
#include "slim_init/version.h"
#include "support/option_checks.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

TEST(OptionTable, BothSidesOfEveryBound) {
  expectBothSidesOfEveryBound<WindowOptions, InitializerOptions, Calibration, ImuNoise,
                              ImuLimits>();
}

TEST(InertialOptions, NoiseFactorIsMeasuredOrAtLeastTheDataSheet) {
  for (double InertialOptions::*const factor :
       {&InertialOptions::accel_noise_factor, &InertialOptions::gyro_noise_factor}) {
    InitializerOptions options;
    EXPECT_EQ(options.inertial.*factor, 0.0);
    for (const double good : {0.0, 1.0, 3.0, 100.0}) {
      options.inertial.*factor = good;
      EXPECT_EQ(options.validate(), "");
    }
    options.inertial.*factor = 0.999;
    expectParts(options.validate(), "is 0.999, must be 0 (measured) or at least 1");
  }
}

TEST(OptionTable, HasEveryField) {
  expectEveryFieldHasARow<InitializerOptions>();
  expectEveryFieldHasARow<ImuNoise>();
  expectEveryFieldHasARow<ImuLimits>();
}

TEST(OptionTable, HeaderStatesTheSameUnits) {
  const auto units = unitsOfHeader(SLIM_INIT_SOURCE_DIR "/slim_init/include/slim_init/options.h");
  InitializerOptions o;
  expectUnitsAgree(units, "WindowOptions", optionTable(&o.window));
  expectUnitsAgree(units, "InertialOptions", optionTable(&o.inertial));
  expectUnitsAgree(units, "VanishingPointOptions", optionTable(&o.vanishing_point));
  expectUnitsAgree(units, "RefinementOptions", optionTable(&o.refinement));
  expectUnitsAgree(units, "SlimOptions", optionTable(&o.slim));
  expectUnitsAgree(units, "GateOptions", optionTable(&o.gates));
}

TEST(OptionTable, MethodsOfARowAreThoseOfItsSectionUnlessItNamesItsOwn) {
  InitializerOptions options;
  std::map<std::string, OptionField> rows;
  for (const OptionField& row : optionTable(&options)) rows[row.key] = row;
  EXPECT_TRUE(rows["window.keyframes"].isReadBy("any-method"));
  EXPECT_TRUE(rows["refinement.use_lines"].isReadBy("slim"));
  EXPECT_FALSE(rows["refinement.use_lines"].isReadBy("drt-l"));
}

TEST(Options, ThatDependOnEachOther) {
  InitializerOptions options;
  options.window.keyframes = 4;
  EXPECT_EQ(options.validate(), "window.min_keyframes is 5, must not exceed keyframes (4)");
  options = InitializerOptions();
  options.window.min_interval_s = 1.0;
  EXPECT_EQ(
      options.validate(),
      "window.twice the minimum length of a full window is 28, must not exceed buffer_s (10)");
  options.window.buffer_s = 28.0;
  EXPECT_EQ(options.validate(), "");
  options.window.max_span_s = 30.0;
  EXPECT_EQ(options.validate(), "window.max_span_s is 30, must not exceed buffer_s (28)");
}

TEST(Calibration, RefusesWhatCannotBe) {
  const auto message = [](void (*spoil)(Calibration*)) {
    Calibration calibration;
    spoil(&calibration);
    return calibration.validate();
  };
  expectParts(message([](Calibration* c) { c->R_b_c(0, 0) = 1.1; }), "R_b_c");
  // A reflection, and cm/s^2 by mistake.
  expectParts(message([](Calibration* c) { c->R_b_c = Eigen::Vector3d(1, 1, -1).asDiagonal(); }),
              "R_b_c");
  expectParts(message([](Calibration* c) { c->gravity_magnitude = 981.0; }),
              "gravity_magnitude is 981");
  expectParts(message([](Calibration* c) { c->td = kNotComputed; }), "td");
  EXPECT_EQ(message([](Calibration* c) {
              c->imu_noise.gyro_density = 0.0;
            }).find("imu_noise.gyro_density is 0"),
            0u);
}

// A console says what to do unless waiting is enough, or the message itself says it.
TEST(Status, EveryStatusButThoseWithNothingToDoHasARemedy) {
  const auto has = [](InitStatus status) { return withRemedy("0.1 m", status) != "0.1 m"; };
  for (int s = 0; s <= static_cast<int>(InitStatus::kTimeLimit); ++s) {
    const InitStatus status = static_cast<InitStatus>(s);
    const bool nothing_to_do =
        status == InitStatus::kSuccess || status == InitStatus::kTooFewKeyframes ||
        status == InitStatus::kInvalidInput || status == InitStatus::kProvisional;
    EXPECT_EQ(has(status), !nothing_to_do) << toString(status);
  }
  EXPECT_EQ(withRemedy("no parallax", InitStatus::kPureRotation), "no parallax; translate");
}

TEST(Version, MacrosAndTextAgree) {
  EXPECT_EQ(std::to_string(SLIM_INIT_VERSION_MAJOR) + "." +
                std::to_string(SLIM_INIT_VERSION_MINOR) + "." +
                std::to_string(SLIM_INIT_VERSION_PATCH),
            kVersion);
  EXPECT_GE(SLIM_INIT_VERSION_CODE, SLIM_INIT_MAKE_VERSION(0, 1, 0));
  EXPECT_LT(SLIM_INIT_VERSION_CODE,
            SLIM_INIT_MAKE_VERSION(SLIM_INIT_VERSION_MAJOR, SLIM_INIT_VERSION_MINOR + 1, 0));
}

using Eigen::Vector3d;

ImuSample sampleOf(const Vector3d& accel, const Vector3d& gyro) {
  ImuSample sample;
  sample.accel = accel;
  sample.gyro = gyro;
  return sample;
}

TEST(ImuLimits, CountForEachAxisInEitherDirection) {
  const ImuLimits limits;
  const Vector3d accel(-159.9, 159.9, 9.8), gyro(34.9, 0.0, -34.9);
  EXPECT_FALSE(limits.exceededBy(sampleOf(accel, gyro))) << "their norms are not what counts";
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vector3d beyond = accel;
      beyond[axis] = sign * 160.1;
      EXPECT_TRUE(limits.exceededBy(sampleOf(beyond, gyro))) << axis;
      beyond = gyro;
      beyond[axis] = sign * 35.1;
      EXPECT_TRUE(limits.exceededBy(sampleOf(accel, beyond))) << axis;
    }
  }
}

TEST(ImuLimits, WhatIsNoNumberIsAnotherDefect) {
  const double nan = kNotComputed, infinity = std::numeric_limits<double>::infinity();
  const ImuLimits limits;
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(0, nan, 400), Vector3d(99, 0, 0))));
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(0, 0, 400), Vector3d(0, infinity, 0))));
}

TEST(ImuLimits, AreTheUsers) {
  ImuLimits limits;
  limits.max_accel = 300.0;
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(290, 0, 0), Vector3d::Zero())));
  EXPECT_TRUE(limits.exceededBy(sampleOf(Vector3d(310, 0, 0), Vector3d::Zero())));
  limits.max_accel = limits.max_gyro = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(limits.exceededBy(sampleOf(Vector3d(1e9, 0, 0), Vector3d(0, 1e9, 0))));
  EXPECT_EQ(limits.validate(), "");
}

TEST(ImuLimits, DescribeASampleAndTheLimits) {
  EXPECT_EQ(ImuLimits().describe(sampleOf(Vector3d(1, -412.3, 0), Vector3d(0, 0, -0.25))),
            "412 m/s^2 and 0.25 rad/s on an axis (limits 160 m/s^2, 35 rad/s)");
}

TEST(Status, NamesAreDistinctAndWaitsAreWaits) {
  std::set<std::string> names = {"unknown"};
  for (int s = 0; s <= static_cast<int>(InitStatus::kTimeLimit); ++s) {
    EXPECT_TRUE(names.insert(toString(static_cast<InitStatus>(s))).second) << s;
  }
  EXPECT_FALSE(isWait(InitStatus::kSuccess));
  EXPECT_TRUE(isWait(InitStatus::kStationary));
  EXPECT_TRUE(isWait(InitStatus::kProvisional));
  EXPECT_TRUE(isWait(InitStatus::kTimeLimit));
  EXPECT_FALSE(isWait(InitStatus::kScaleTooUncertain));
}

}  // namespace
}  // namespace slim_init
