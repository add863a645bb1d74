// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Which IMU data may be used, what a carried state is worth, whether a host's states are right.
// Every judgement from both sides.
#include "slim_init/host_health/watchdog.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host_health/flight.h"
#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/host_health/imu_screen.h"
#include "support/exact_window.h"
#include "support/gaussian.h"
#include "support/text_parts.h"

namespace slim_init::host_health {
namespace {

struct Screened {
  std::vector<ImuSample> used;
  ImuScreen screen{ImuLimits()};
};

Screened screened(const std::vector<ImuSample>& samples) {
  Screened result;
  for (const ImuSample& sample : samples) {
    for (const ImuSample& one : result.screen.add(sample)) result.used.push_back(one);
  }
  return result;
}

void hold(const ImuSample& values, ImuSample* sample) {
  sample->accel = values.accel;
  sample->gyro = values.gyro;
}

Screened screenedHit(const ExactWindow& exact, double first, double last,
                     const Eigen::Vector3d& accel,
                     const Eigen::Vector3d& gyro = Eigen::Vector3d::Zero()) {
  return screened(disturbed(exact.imu, first, last, accel, gyro));
}

ImuDamage onlyDamage(const Screened& data) {
  EXPECT_EQ(data.screen.damage().size(), 1u);
  return data.screen.damage().at(0);
}

void expectRatesAsMeasured(const std::vector<ImuSample>& measured,
                           const std::deque<ImuSample>& samples) {
  ASSERT_EQ(samples.size(), measured.size());
  for (std::size_t i = 0; i < measured.size(); ++i) EXPECT_EQ(samples[i].gyro, measured[i].gyro);
}

void expectAscending(const std::vector<ImuSample>& samples) {
  for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_GT(samples[i].t, samples[i - 1].t);
}

class ScreenedFlight : public ::testing::Test {
 protected:
  const ExactWindow exact_ = flightOf(Motion::kExcited, 0.0),
                    noisy_ = flightOf(Motion::kExcited, kNoisePx);
};
using ImuPropagation = ScreenedFlight;

TEST_F(ScreenedFlight, GoodDataStayAsTheyAre) {
  const Screened result = screened(noisy_.imu);
  ASSERT_EQ(result.used.size(), noisy_.imu.size());
  for (std::size_t i = 0; i < noisy_.imu.size(); ++i) {
    EXPECT_EQ(result.used[i].t, noisy_.imu[i].t);
    EXPECT_EQ(result.used[i].accel, noisy_.imu[i].accel);
    EXPECT_EQ(result.used[i].gyro, noisy_.imu[i].gyro);
  }
  EXPECT_TRUE(result.screen.damage().empty());
}

TEST_F(ScreenedFlight, AGlitchIsBridgedAndAShockIsNot) {
  // Within the limits of the sensor, for 25 ms.
  const Screened glitch = screenedHit(exact_, 2.0, 2.025, {100, 0, 0});
  const ImuDamage damage = onlyDamage(glitch);
  EXPECT_NEAR(damage.first, 2.0, 0.0051);
  EXPECT_NEAR(damage.last, 2.025, 0.0051);
  EXPECT_TRUE(damage.bridged);
  EXPECT_FALSE(damage.open);
  // Five samples are missing, none is made up; a host's own frames get interpolated ones.
  ASSERT_EQ(glitch.used.size(), exact_.imu.size() - 5);
  for (std::size_t i = 0, k = 0; i < exact_.imu.size(); ++i) {
    if (exact_.imu[i].t >= 2.0 && exact_.imu[i].t < 2.025) continue;
    EXPECT_EQ(glitch.used[k].t, exact_.imu[i].t);
    EXPECT_EQ(glitch.used[k++].accel, exact_.imu[i].accel);
  }
  const auto& filled = glitch.screen.samples();
  ASSERT_EQ(filled.size(), exact_.imu.size());
  for (std::size_t i = 0; i < exact_.imu.size(); ++i) {
    EXPECT_NEAR(filled[i].t, exact_.imu[i].t, 1e-9);
    EXPECT_LT((filled[i].accel - exact_.imu[i].accel).norm(), 1.0);
  }
  // What EuRoC's vehicles feel when they touch the ground.
  const Screened shock = screenedHit(exact_, 2.0, 2.025, {35, 0, 0});
  EXPECT_TRUE(shock.screen.damage().empty());
  EXPECT_EQ(shock.used.size(), exact_.imu.size());
}

// Rates that jump beside a glitch of the accelerometer are not believed, small as they are.
TEST_F(ScreenedFlight, AGlitchOfBothSensors) {
  const Screened result = screenedHit(exact_, 2.0, 2.04, {380, -190, 270}, {1.5, 4.0, -2.0});
  EXPECT_FALSE(onlyDamage(result).gyroKnown());
  EXPECT_EQ(result.used.size(), exact_.imu.size() - 8);
  const auto& filled = result.screen.samples();
  ASSERT_EQ(filled.size(), exact_.imu.size());
  for (std::size_t i = 0; i < exact_.imu.size(); ++i) {
    EXPECT_LT((filled[i].gyro - exact_.imu[i].gyro).norm(), 0.3);
  }
}

TEST_F(ScreenedFlight, LongDamageStaysEmpty) {
  const Screened result = screenedHit(exact_, 2.0, 2.3, {120, 0, 0});
  const ImuDamage damage = onlyDamage(result);
  EXPECT_FALSE(damage.bridged);
  EXPECT_TRUE(damage.gyroKnown());
  EXPECT_NEAR(damage.last - damage.first, 0.305, 0.011);
  for (const ImuSample& sample : result.used) {
    EXPECT_FALSE(sample.t > damage.first + 1e-9 && sample.t < damage.last - 1e-9);
  }
  // To carry a state over it.
  expectRatesAsMeasured(exact_.imu, result.screen.samples());
  for (const ImuSample& sample : result.screen.samples()) EXPECT_LT(sample.accel.norm(), 40.0);
}

// A host that wants a frame while the damage goes on: up to there the body goes on as before it.
TEST_F(ScreenedFlight, WhileDamageGoesOnTheLastSampleIsHeld) {
  std::vector<ImuSample> samples = disturbed(exact_.imu, 2.0, 2.3, {120, 0, 0});
  samples.resize(static_cast<std::size_t>(2.2 * 200.0));
  const Screened result = screened(samples);
  const double until = samples.back().t;
  ASSERT_TRUE(result.screen.damage().back().open);
  ASSERT_LT(result.screen.samples().back().t, 2.0);
  const std::deque<ImuSample> held = result.screen.heldUntil(until - 0.05);
  ASSERT_EQ(held.size(), samples.size());
  for (std::size_t i = 0; i < held.size(); ++i) {
    EXPECT_NEAR(held[i].t, samples[i].t, 1e-9);
    // Only the accelerometer is off.
    EXPECT_EQ(held[i].gyro, samples[i].gyro);
    if (held[i].t <= 2.0) continue;
    EXPECT_LT((held[i].accel - exact_.imu[399].accel).norm(), 1.0);
  }
  // Where nothing is wrong nothing is held.
  EXPECT_EQ(screened(exact_.imu).screen.heldUntil(1e3).size(), exact_.imu.size());
  const Screened both = screened(disturbed(samples, 2.0, 9.0, {0, 0, 0}, {0, 10, 0}));
  ASSERT_FALSE(both.screen.damage().back().gyroKnown());
  const ImuSample last = both.screen.samples().back();
  for (const ImuSample& sample : both.screen.heldUntil(until)) {
    if (sample.t <= last.t) continue;
    EXPECT_LT((sample.gyro - last.gyro).norm(), 1e-12);
    EXPECT_LT((sample.accel - last.accel).norm(), 1e-12);
  }
  EXPECT_EQ(both.screen.heldUntil(until).back().t, until);
}

// Noise of `accel` and `gyro` from 1.5 to 2.5 s.
Screened noisy(const ExactWindow& exact, double accel, double gyro) {
  Gaussian normal(3);
  std::vector<ImuSample> samples = exact.imu;
  for (ImuSample& sample : samples) {
    if (sample.t < 1.5 || sample.t >= 2.5) continue;
    for (int axis = 0; axis < 3; ++axis) {
      sample.accel[axis] += accel * normal();
      sample.gyro[axis] += gyro * normal();
    }
  }
  return screened(samples);
}

// The host keeps the samples, with the size of their noise; the initializer does not get them.
TEST_F(ScreenedFlight, NoiseOfABrokenSensorIsDamageAndVibrationIsNot) {
  for (const auto& [accel, gyro] : {std::pair(20.0, 3.0), std::pair(8.0, 0.5)}) {
    const Screened broken = noisy(exact_, accel, gyro);
    double hole = 0.0, accel_size = 0.0, gyro_size = 0.0;
    for (const ImuDamage& damage : broken.screen.damage()) {
      if (!damage.measured) continue;
      EXPECT_GT(damage.first, 1.45);
      EXPECT_LT(damage.last, 2.57);
      hole += damage.last - damage.first;
      accel_size = std::hypot(accel_size, damage.accel_sigma * (damage.last - damage.first));
      gyro_size = std::hypot(gyro_size, damage.gyro_sigma * (damage.last - damage.first));
    }
    EXPECT_NEAR(hole, 1.0, 0.15) << accel;
    // White noise of 5 ms over a second.
    EXPECT_NEAR(accel_size / (accel * std::sqrt(0.005)), 1.0, 0.3) << accel;
    EXPECT_NEAR(gyro_size / (gyro * std::sqrt(0.005)), 1.0, 0.3) << accel;
    EXPECT_LT(broken.used.size(), exact_.imu.size() - 50) << accel;
    EXPECT_EQ(broken.screen.samples().size(), exact_.imu.size()) << accel;
  }
  const Screened vibration = noisy(exact_, 5.0, 0.3);
  EXPECT_EQ(vibration.used.size(), exact_.imu.size());
  const ImuWidening widening = wideningOf(vibration.screen.damage(), 2.0, 2.1);
  EXPECT_LT(widening.sigma_v, 0.15);
  EXPECT_LT(widening.sigma_theta, 0.01);
  EXPECT_FALSE(wideningOf(noisy(exact_, 3.0, 0.2).screen.damage(), 2.0, 2.1).damaged);
}

TEST_F(ScreenedFlight, AFrozenSensorIsMissing) {
  std::vector<ImuSample> samples = noisy_.imu;
  const ImuSample held = samples[400];
  for (std::size_t i = 401; i < 500; ++i) hold(held, &samples[i]);
  const Screened frozen = screened(samples);
  const ImuDamage damage = onlyDamage(frozen);
  EXPECT_NEAR(damage.first, held.t, 0.0051);
  EXPECT_NEAR(damage.last, noisy_.imu[500].t, 1e-9);
  EXPECT_FALSE(damage.gyroKnown() || damage.bridged || damage.open);
  EXPECT_EQ(damage.gyro_sigma, kUnknownGyro);
  // What is kept of a sensor that stays frozen for a minute is bounded.
  ImuScreen screen = frozen.screen;
  ImuSample again = samples.back();
  for (int k = 0; k < 12000; ++k) {
    again.t += 0.005;
    screen.add(again);
  }
  EXPECT_LT(screen.heldUntil(again.t).size(), 4200u);
  EXPECT_LT(screen.damage().size(), 3u);
  // So it is after a jump of its clock to the time of day.
  again = noisy_.imu[505];
  again.t += 1.7e9;
  screen.add(again);
  EXPECT_LT(screen.heldUntil(again.t).size(), 4200u);
  // A driver that sends each sample twice is not frozen, nor is a simulation without noise at rest.
  samples = noisy_.imu;
  for (std::size_t i = 1; i < samples.size(); i += 2) hold(samples[i - 1], &samples[i]);
  EXPECT_TRUE(screened(samples).screen.damage().empty());
  for (ImuSample& sample : samples) hold(held, &sample);
  EXPECT_TRUE(screened(samples).screen.damage().empty());
}

// A simulation without noise that lands: its values are used, and those of an IMU that freezes in
// flight are not, nor those of a real one that hovers.
TEST_F(ScreenedFlight, AtRestWithoutNoise) {
  const auto used = [](double noise, double force, double rotation) {
    Gaussian normal(3);
    ImuScreen screen{ImuLimits()};
    ImuSample sample;
    int count = 0;
    for (int i = 0; i < 2000; ++i) {
      sample.t = 0.01 * i;
      for (int axis = 0; axis < 3 && i < 1500; ++axis) {
        sample.accel[axis] = std::sin((1.0 + axis) * sample.t) + noise * normal();
        sample.gyro[axis] = 0.3 * std::cos((1.0 + axis) * sample.t) + 0.1 * noise * normal();
      }
      if (i < 1500) sample.accel.z() += 9.81;
      if (i >= 1500) sample.accel = Eigen::Vector3d(0, 0, force);
      if (i >= 1500) sample.gyro = Eigen::Vector3d(rotation, 0, 0);
      count += i >= 1500 && !screen.add(sample).empty() ? 1 : 0;
      if (i < 1500) screen.add(sample);
    }
    return count;
  };
  EXPECT_GT(used(0.0, 9.9, 0.01), 490);
  EXPECT_LT(used(0.0, 15.0, 0.01), 10);
  EXPECT_LT(used(0.0, 9.9, 0.5), 10);
  EXPECT_LT(used(0.02, 9.9, 0.01), 10);
}

// At the end of its range an axis repeats its value, and the other axes do not.
TEST_F(ScreenedFlight, ASaturatedAxisIsDamage) {
  const auto stuck_from = [this](std::size_t last, Eigen::Vector3d ImuSample::*sensor) {
    std::vector<ImuSample> samples = noisy_.imu;
    for (std::size_t i = 401; i < last; ++i) (samples[i].*sensor).z() = (samples[401].*sensor).z();
    return screened(samples);
  };
  const Screened accel = stuck_from(500, &ImuSample::accel);
  const ImuDamage damage = onlyDamage(accel);
  EXPECT_NEAR(damage.first, noisy_.imu[400].t, 1e-9);
  EXPECT_NEAR(damage.last, noisy_.imu[500].t, 1e-9);
  EXPECT_TRUE(damage.gyroKnown());
  expectRatesAsMeasured(noisy_.imu, accel.screen.samples());
  EXPECT_FALSE(onlyDamage(stuck_from(500, &ImuSample::gyro)).gyroKnown());
  EXPECT_TRUE(stuck_from(405, &ImuSample::accel).screen.damage().empty());  // may be chance
  // What stays for longer than a second is how the axis is at rest.
  EXPECT_NEAR(onlyDamage(stuck_from(700, &ImuSample::gyro)).last, noisy_.imu[401].t + 1.0, 0.01);
}

// Steps as coarse as the noise or coarser, which a sensor may filter and turn to the axes of the
// body: values repeat all the time, and more often at rest. A stream that restarts is of the same
// sensor.
TEST_F(ScreenedFlight, CoarseStepsAreNotSaturation) {
  for (const auto& [rate, steps, memory, accel_step, turn] :
       {std::tuple(100.0, 2.0, 0.0, 0.0, 0.0), std::tuple(200.0, 2.0, 0.0, 0.0, 0.0),
        std::tuple(400.0, 4.0, 0.0, 0.0, 0.0), std::tuple(100.0, 4.0, 0.5, 0.0, 0.0),
        std::tuple(200.0, 1.0, 0.8, 0.0, 0.0), std::tuple(100.0, 10.0, 0.0, 0.0, 0.0),
        std::tuple(200.0, 5.0, 0.8, 0.05, 0.0), std::tuple(200.0, 5.0, 0.8, 0.0, 0.003),
        std::tuple(100.0, 5.0, 0.0, 0.05, 0.7)}) {
    SCOPED_TRACE(testing::Message() << rate << " Hz, " << steps << " sigma, " << accel_step
                                    << " m/s^2, turned by " << turn);
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(turn, Eigen::Vector3d(0.5, 0.7, -0.4).normalized()).toRotationMatrix();
    Gaussian normal(4);
    ImuScreen screen{ImuLimits()};
    Eigen::Vector3d noise = Eigen::Vector3d::Zero();
    double discarded = 0.0;  // [s]
    for (int i = 0; i < 40.0 * rate; ++i) {
      ImuSample sample;
      sample.t = i / rate;
      if (i == 30 * static_cast<int>(rate)) screen.reset();
      for (int axis = 0; axis < 3; ++axis) {
        noise[axis] = memory * noise[axis] + std::sqrt(1.0 - memory * memory) * 1e-3 * normal();
        const double motion = sample.t < 20.0 ? 0.3 * std::sin(4.0 * sample.t + axis) : 0.0;
        sample.gyro[axis] = 1e-3 * steps * std::round(1e3 * (motion + noise[axis]) / steps);
        sample.accel[axis] = (axis == 2 ? 9.81 : 0.0) + 0.02 * normal();
        if (accel_step > 0.0) {
          sample.accel[axis] = accel_step * std::round(sample.accel[axis] / accel_step);
        }
      }
      sample.accel = R * sample.accel;
      sample.gyro = R * sample.gyro;
      discarded += screen.add(sample).empty() ? 1.0 / rate : 0.0;
    }
    EXPECT_LT(discarded, 0.5);
  }
}

// A quiet gyroscope behind a filter repeats its values where a smooth motion turns and where the
// body stops. An axis that is stuck while the body moves is found all the same.
TEST_F(ScreenedFlight, TheTurnOfASmoothMotionIsNotSaturation) {
  constexpr double kStep = 0.00106;  // [rad/s], 16 bit of +-2000 deg/s
  for (const auto& [rate, gain, moves] :
       {std::tuple(200.0, 0.47, 10.0), std::tuple(500.0, 0.22, 10.0), std::tuple(200.0, 0.15, 9.0),
        std::tuple(200.0, 0.27, 9.0), std::tuple(400.0, 0.08, 9.0)}) {
    SCOPED_TRACE(testing::Message() << rate << " Hz, " << gain);
    Gaussian normal(4);
    ImuScreen screen{ImuLimits()};
    Eigen::Vector3d filtered = Eigen::Vector3d::Zero();  // [rad/s]
    double discarded = 0.0, held = 0.0, stuck_at = 0.0;  // [s], [s], [rad/s]
    for (int i = 0; i < 100.0 * rate; ++i) {
      ImuSample sample;
      sample.t = i / rate;
      for (int axis = 0; axis < 3; ++axis) {
        const bool rests = std::fmod(sample.t + 5.0, 10.0) > moves;
        const double rate_of_axis = rests ? 0.0 : 0.3 * std::sin((2.3 - 0.5 * axis) * sample.t);
        const double measured = rate_of_axis + 4.9e-5 * std::sqrt(0.5 * rate) * normal();
        filtered[axis] += gain * (measured - filtered[axis]);
        sample.gyro[axis] = kStep * std::round(filtered[axis] / kStep);
        sample.accel[axis] = (axis == 2 ? 9.81 : 0.0) + 0.03 * normal();
      }
      const bool stuck = sample.t > 90.15 && sample.t < 90.35;
      if (!stuck) stuck_at = sample.gyro.x();
      sample.gyro.x() = stuck_at;
      (sample.t < 90.0 ? discarded : held) += screen.add(sample).empty() ? 1.0 / rate : 0.0;
    }
    EXPECT_LT(discarded, 0.1);
    EXPECT_GT(held, 0.1);
  }
}

// Beside a stuck accelerometer a gyroscope is judged as always, and nothing is returned twice.
TEST_F(ScreenedFlight, BesideAStuckAccelerometer) {
  std::vector<ImuSample> samples = noisy_.imu;
  for (std::size_t i = 401; i < 416; ++i) samples[i].accel.z() = samples[401].accel.z();
  const Screened stuck = screened(samples);
  EXPECT_TRUE(onlyDamage(stuck).bridged && onlyDamage(stuck).gyroKnown());
  expectAscending(stuck.used);
  samples[412].gyro.x() = 500.0;
  const Screened glitch = screened(samples);
  EXPECT_FALSE(onlyDamage(glitch).gyroKnown());
  for (const ImuSample& sample : glitch.screen.samples()) EXPECT_LT(sample.gyro.norm(), 10.0);
}

TEST_F(ScreenedFlight, DamageFromOutside) {
  Screened data = screened(exact_.imu);
  data.screen.addDamage(2.0, 2.1, 15.0, 0.0);
  data.screen.addDamage(1.0, 1.1, 4.0, 2.0);
  data.screen.addDamage(2.0, 2.1, 10.0, 0.5);
  data.screen.addDamage(2.1, 2.1, 10.0, 0.5);
  data.screen.addDamage(2.1, 2.2, -1.0, 0.5);
  data.screen.addDamage(2.1, 2.2, 1.0, std::numeric_limits<double>::quiet_NaN());
  ASSERT_EQ(data.screen.damage().size(), 2u);
  EXPECT_EQ(data.screen.damage().front().first, 1.0);
  const ImuDamage damage = data.screen.damage().back();
  EXPECT_TRUE(damage.measured && !damage.open && !damage.bridged && !damage.gyroKnown());
  EXPECT_EQ(damage.accel_sigma, 15.0);
  EXPECT_EQ(damage.gyro_sigma, 0.5);
  EXPECT_EQ(data.screen.samples().size(), exact_.imu.size());
  const ImuWidening widening = wideningOf(data.screen.damage(), 2.05, 2.15);
  EXPECT_TRUE(widening.damaged);
  EXPECT_NEAR(widening.sigma_v, 15.0 * 0.05, 1e-9);
  EXPECT_NEAR(widening.sigma_theta, 0.5 * 0.05, 1e-9);
  EXPECT_NEAR(widening.sigma_p, 0.5 * 15.0 * 0.05 * 0.1, 1e-9);
  EXPECT_FALSE(wideningOf(data.screen.damage(), 2.1, 2.2).damaged);
  // Beside damage that goes on, which stays the last.
  std::vector<ImuSample> samples = disturbed(exact_.imu, 2.0, 9.0, {120, 0, 0});
  samples.resize(420);
  Screened open = screened(samples);
  ASSERT_TRUE(open.screen.damage().back().open);
  open.screen.addDamage(1.9, 2.09, 1.0, 0.0);
  EXPECT_TRUE(open.screen.damage().back().open);
  EXPECT_EQ(open.screen.damage().size(), 2u);
}

// A frame that vibrates by so much, or by about so much, all the time: the samples are all there
// is. The usual noise is that of 5 s at any rate.
TEST_F(ScreenedFlight, WhatGoesOnIsAVibration) {
  Gaussian normal(3);
  for (const auto& [rate, sigma] : {std::pair(200.0, 20.0), std::pair(200.0, 11.5),
                                    std::pair(100.0, 10.0), std::pair(1000.0, 10.0)}) {
    SCOPED_TRACE(testing::Message() << rate << " Hz, " << sigma << " m/s^2");
    ImuScreen screen{ImuLimits()};
    double discarded = 0.0, discarded_late = 0.0;  // [s]
    for (int i = 0; i < 20.0 * rate; ++i) {
      ImuSample sample;
      sample.t = i / rate;
      const double noise = sample.t > 6.0 ? sigma : 0.1;
      sample.accel = Eigen::Vector3d(0, 0, 9.81) + noise * normal.vector();
      if (!screen.add(sample).empty()) continue;
      (sample.t < 15.0 ? discarded : discarded_late) += 1.0 / rate;
    }
    EXPECT_LT(discarded_late, 0.1);
    EXPECT_NEAR(discarded, 2.4, 0.25);
  }
}

// A body that begins to turn in 0.05 s, and stops, at any rate of the IMU; a sensor jumps.
TEST_F(ScreenedFlight, AFastTurnIsAMotionAndAJumpIsNot) {
  Gaussian normal(3);
  const auto lost = [&](double rate, double ramp, double speed) {
    ImuScreen screen{ImuLimits()};
    double discarded = 0.0;  // [s]
    for (int i = 0; i < 5.0 * rate; ++i) {
      ImuSample sample;
      sample.t = i / rate;
      sample.accel = Eigen::Vector3d(0, 0, 9.81) + 0.1 * normal.vector();
      sample.gyro = 0.003 * normal.vector();
      const double on = std::clamp((sample.t - 2.0) / ramp, 0.0, 1.0);
      const double off = std::clamp((sample.t - 3.5) / ramp, 0.0, 1.0);
      sample.gyro.z() += speed * (on - off);
      discarded += screen.add(sample).empty() ? 1.0 / rate : 0.0;
    }
    return discarded;
  };
  for (const double rate : {50.0, 100.0, 200.0, 400.0, 1000.0}) {
    SCOPED_TRACE(rate);
    EXPECT_EQ(lost(rate, 0.1, 10.0), 0.0);
    EXPECT_EQ(lost(rate, 0.1, 15.0), 0.0);
    EXPECT_EQ(lost(rate, 0.05, 15.0), 0.0);
    EXPECT_NEAR(lost(rate, 1e-6, 10.0), 1.0, 0.05);
  }
}

TEST_F(ScreenedFlight, WhatStaysIsAMotion) {
  const Screened result = screenedHit(exact_, 2.0, 10.0, {100, 0, 0});
  ASSERT_FALSE(result.screen.damage().empty());
  EXPECT_FALSE(result.screen.damage().back().open);
  EXPECT_EQ(result.used.back().t, exact_.imu.back().t);
}

// A driver that sends 60 ms of samples at once, with stamps of their arrival: not many more of them
// are kept over the gaps than there were.
TEST_F(ScreenedFlight, SamplesThatArriveTogether) {
  for (const int at_once : {6, 12, 60}) {
    SCOPED_TRACE(at_once);
    ImuScreen screen{ImuLimits()};
    std::size_t used = 0;
    for (int i = 0; i < 100 * at_once; ++i) {
      ImuSample sample = noisy_.imu[static_cast<std::size_t>(i) % 700];
      sample.t = 0.06 * (i / at_once) + 2e-5 * (i % at_once);
      used += screen.add(sample).empty() ? 0 : 1;
    }
    EXPECT_EQ(used, 100u * static_cast<std::size_t>(at_once));
    EXPECT_LT(screen.samples().size(), 400u * static_cast<std::size_t>(at_once));
  }
}

TEST_F(ScreenedFlight, MissingSamples) {
  // An incorrect rate behind them is none of the motion over them.
  for (const std::size_t missing : {6u, 20u}) {
    std::vector<ImuSample> samples = noisy_.imu;
    samples.erase(samples.begin() + 400, samples.begin() + 400 + missing);
    samples[400].gyro.z() += 12.0;
    for (const ImuSample& sample : screened(samples).used) EXPECT_LT(sample.gyro.norm(), 6.0);
  }
  const auto without = [this](double length) {
    std::vector<ImuSample> samples;
    for (const ImuSample& sample : exact_.imu) {
      if (sample.t < 2.001 || sample.t > 2.001 + length) samples.push_back(sample);
    }
    return screened(samples);
  };
  EXPECT_TRUE(without(0.03).screen.damage().empty());
  const Screened bridged = without(0.07);
  EXPECT_TRUE(onlyDamage(bridged).bridged);
  EXPECT_EQ(bridged.screen.samples().size(), exact_.imu.size());
  // One sample in the middle, so that nowhere is a gap.
  EXPECT_EQ(bridged.used.size(), exact_.imu.size() - 14 + 1);
  expectAscending(bridged.used);
  for (std::size_t i = 1; i < bridged.used.size(); ++i) {
    EXPECT_LE(bridged.used[i].t - bridged.used[i - 1].t, 0.045);
  }
  // The accelerometer alone.
  const Screened known = screenedHit(exact_, 2.0, 2.07, {100, 0, 0});
  ASSERT_TRUE(known.screen.damage().front().bridged);
  expectRatesAsMeasured(exact_.imu, {known.used.begin(), known.used.end()});
  const ImuDamage hole = onlyDamage(without(0.5));
  EXPECT_FALSE(hole.bridged);
  EXPECT_FALSE(hole.gyroKnown());
}

struct Carry {
  bool ok = false;
  PropagatedState state;
  std::string error;
};

Carry carried(const ExactWindow& exact, const PropagatedState& from, int to, const Screened& data) {
  Carry result;
  result.ok = propagateState(from, exact.truth[to].t, data.screen.samples(), data.screen.damage(),
                             Eigen::Vector3d(0, 0, -exact.calibration.gravity_magnitude),
                             exact.calibration.imu_noise, &result.state, &result.error);
  return result;
}

// Squared error over its covariance, per degree of freedom: attitude, velocity, position.
Eigen::Array3d squaredErrors(const PropagatedState& carried, const NavState& truth) {
  const Eigen::AngleAxisd turn(carried.state.R_w_b * truth.R_w_b.transpose());
  const Eigen::Vector3d errors[] = {turn.angle() * turn.axis(), carried.state.v_w_b - truth.v_w_b,
                                    carried.state.p_w_b - truth.p_w_b};
  Eigen::Array3d squares;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Matrix3d C = carried.covariance.block<3, 3>(3 * i, 3 * i);
    squares[i] = errors[i].dot(C.ldlt().solve(errors[i])) / 3.0;
  }
  return squares;
}

TEST_F(ImuPropagation, FollowsTheTruth) {
  PropagatedState from;
  from.state = exact_.truth[5];
  const Carry end = carried(exact_, from, 25, screened(exact_.imu));
  ASSERT_TRUE(end.ok) << end.error;
  EXPECT_LT((end.state.state.p_w_b - exact_.truth[25].p_w_b).norm(), 0.01);
  EXPECT_LT((end.state.state.v_w_b - exact_.truth[25].v_w_b).norm(), 0.01);
  EXPECT_LT((end.state.state.R_w_b - exact_.truth[25].R_w_b).norm(), 0.002);
  from.state.t = -5.0;
  EXPECT_FALSE(carried(exact_, from, 25, screened(exact_.imu)).ok);
}

// Drawn from what healthyCovariance() says, the error has the reported covariance.
TEST_F(ImuPropagation, CovarianceFits) {
  const Screened data = screened(exact_.imu);
  Gaussian normal(5);
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  const int draws = 200;
  for (int k = 0; k < draws; ++k) {
    PropagatedState from;
    from.covariance = healthyCovariance();
    from.state = exact_.truth[5];
    const auto draw = [&](int row) -> Eigen::Vector3d {
      return from.covariance.diagonal().segment<3>(row).cwiseSqrt().cwiseProduct(normal.vector());
    };
    const Eigen::Vector3d turn = draw(0);
    from.state.R_w_b = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * from.state.R_w_b;
    from.state.v_w_b += draw(3);
    from.state.gyro_bias += draw(9);
    from.state.accel_bias += draw(12);
    const Carry end = carried(exact_, from, 25, data);
    ASSERT_TRUE(end.ok);
    squares += squaredErrors(end.state, exact_.truth[25]) / draws;
  }
  // 600 values: their mean has a standard deviation of 0.06.
  EXPECT_NEAR(squares[1], 1.0, 0.25) << "velocity";
  EXPECT_NEAR(squares[2], 1.0, 0.25) << "position";
}

// Errors of the sizes that addDamage() is given have the covariance that propagateState() reports.
TEST_F(ImuPropagation, DamageFromOutsideIsHonest) {
  Gaussian normal(7);
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  const int draws = 200;
  for (int k = 0; k < draws; ++k) {
    const Eigen::Vector3d accel = 10.0 * normal.vector(), gyro = 0.5 * normal.vector();
    Screened data = screened(disturbed(exact_.imu, 2.0, 2.2, accel, gyro));
    data.screen.addDamage(2.0, 2.2, 10.0, 0.5);
    PropagatedState from;
    from.state = exact_.truth[18];
    const Carry end = carried(exact_, from, 23, data);
    ASSERT_TRUE(end.ok);
    squares += squaredErrors(end.state, exact_.truth[23]) / draws;
  }
  EXPECT_GT(squares.sqrt().minCoeff(), 0.7) << squares.transpose();
  EXPECT_LT(squares.sqrt().maxCoeff(), 1.5) << squares.transpose();
}

// A body that lands within 10 ms feels more than is believed, and what is left out of it is in the
// covariance; a sensor that invents as much as no landing has costs no more than a missing sample.
TEST_F(ImuPropagation, ADiscardedShockWidens) {
  constexpr double kTime = 5.0, kLength = 0.01;  // [s]
  Gaussian normal(3);
  const auto after = [&](double rate, double peak, double rotation) {
    std::vector<ImuSample> samples;
    for (int i = 0; i < 5.2 * rate; ++i) {
      ImuSample sample;
      sample.t = i / rate;
      sample.accel = 0.05 * normal.vector();
      sample.gyro = 0.005 * normal.vector();
      const double phase = (sample.t - kTime) / kLength;
      const bool in_shock = phase > 0.0 && phase < 1.0;
      sample.accel.z() += 9.81 + (in_shock ? peak * std::sin(M_PI * phase) : 0.0);
      if (in_shock) sample.gyro.x() += rotation;
      samples.push_back(sample);
    }
    const Screened data = screened(samples);
    EXPECT_FALSE(data.screen.damage().empty());
    PropagatedState from, to;
    from.state.t = kTime - 0.05;
    from.state.v_w_b = Eigen::Vector3d(0, 0, -1.0);
    std::string error;
    EXPECT_TRUE(propagateState(from, kTime + 0.1, data.screen.samples(), data.screen.damage(),
                               Eigen::Vector3d(0, 0, -9.81), ImuNoise(), &to, &error))
        << error;
    return to;
  };
  for (const double rate : {200.0, 400.0, 1000.0}) {
    SCOPED_TRACE(rate);
    // The true velocity is zero afterwards.
    const PropagatedState landed = after(rate, 0.5 * M_PI / kLength, 0.0);
    EXPECT_LT(std::abs(landed.state.v_w_b.z()), 2.0 * std::sqrt(landed.covariance(5, 5)));
    EXPECT_LT(landed.velocitySigma(), 1.2);
    EXPECT_LT(after(rate, 2000.0, 0.0).velocitySigma(), 0.1);
    const PropagatedState turned = after(rate, 0.0, 12.0);
    EXPECT_GT(std::sqrt(turned.covariance(0, 0)), 0.5 * 12.0 * kLength);
    EXPECT_LT(std::sqrt(turned.covariance(0, 0)), 2.0 * 12.0 * kLength);
    EXPECT_LT(std::sqrt(after(rate, 0.0, 500.0).covariance(0, 0)), 0.05);
  }
}

TEST_F(ImuPropagation, DamageWidens) {
  PropagatedState from;
  from.covariance = healthyCovariance();
  from.state = exact_.truth[15];
  const auto hit = [&](double last, double accel) {
    return carried(exact_, from, 30, screenedHit(exact_, 2.0, last, {accel, 0, 0}));
  };
  const Carry whole = carried(exact_, from, 30, screened(exact_.imu));
  const Carry glitch = hit(2.025, 100), hole = hit(2.3, 120);
  ASSERT_TRUE(whole.ok && glitch.ok && hole.ok);
  EXPECT_LT(whole.state.velocitySigma(), 0.25);
  EXPECT_GT(glitch.state.velocitySigma(), whole.state.velocitySigma());
  EXPECT_LT(glitch.state.positionSigma(), 0.5);
  EXPECT_GT(hole.state.velocitySigma(), 0.85);  // 3 m/s^2 over 0.3 s
  EXPECT_GT(hole.state.positionSigma(), 0.63);  // that velocity for the 0.7 s after it
  EXPECT_LT(hole.state.yawSigma(), 0.02);       // the gyroscope was right
  std::vector<ImuSample> missing;
  for (const ImuSample& sample : exact_.imu) {
    if (sample.t < 2.0 || sample.t >= 2.3) missing.push_back(sample);
  }
  const Carry nothing = carried(exact_, from, 30, screened(missing));
  ASSERT_TRUE(nothing.ok);
  EXPECT_GT(nothing.state.yawSigma(), 0.25);
  // 40 m/s^2 for 25 ms are not left out: they are noise of the data as measured.
  EXPECT_GT(hit(2.025, 40).state.velocitySigma(), whole.state.velocitySigma() + 0.01);
}

class Watch : public ::testing::Test {
 protected:
  HostHealth find(const std::vector<NavState>& states) const {
    std::vector<FrameObservation> frames = exact_.keyframes;
    for (std::size_t k = 0; k < frames.size(); ++k) frames[k].t = exact_.truth[k].t;
    return watchWindow(states, frames, data_.screen.samples(), data_.screen.damage(),
                       exact_.calibration);
  }
  std::vector<NavState> window(int newest) const {
    return {exact_.truth.begin() + newest - kHostFrames + 1, exact_.truth.begin() + newest + 1};
  }
  ExactWindow exact_ = flightOf(Motion::kExcited, kNoisePx);
  Screened data_ = screened(exact_.imu);
};

TEST_F(Watch, RightStates) {
  for (int newest = kHostFrames; newest < kFrames - 1; ++newest) {
    const HostHealth finding = find(window(newest));
    EXPECT_FALSE(finding.suspect) << finding.reason;
    EXPECT_LT(finding.reprojection_px, 3.0);
    EXPECT_LT(finding.velocity_mps, 0.1);
    EXPECT_LT(finding.rotation_deg, 0.5);
  }
}

// The error of a place from three views is not one of the states: the median stays that of the
// tracks' noise, 0.7 px.
TEST_F(Watch, PlacesFromFewViewsAreNotErrorsOfTheStates) {
  const std::vector<FrameObservation> all = exact_.keyframes;
  std::vector<double> errors;
  for (int newest = kHostFrames; newest < kFrames - 1; ++newest) {
    exact_.keyframes = all;
    for (int k = 0; k < newest - 4; ++k) exact_.keyframes[k].points.clear();
    const double error = find(window(newest)).reprojection_px;
    if (std::isfinite(error)) errors.push_back(error);
  }
  ASSERT_GE(errors.size(), 20u);
  EXPECT_LT(middle(errors), 0.85);
  EXPECT_GT(middle(errors), 0.5);
}

// Five tracks seen twice are not ten.
TEST_F(Watch, FewTracksAreNotJudged) {
  const int newest = 30;
  std::vector<FeatureId> ids;
  for (const PointObservation& point : exact_.keyframes[newest - kHostFrames + 1].points) {
    const auto seen_at = [&](int k) {
      const auto& points = exact_.keyframes[k].points;
      return std::any_of(points.begin(), points.end(),
                         [&](const PointObservation& other) { return other.id == point.id; });
    };
    int k = newest - kHostFrames + 2;
    while (k <= newest && seen_at(k)) ++k;
    if (k > newest) ids.push_back(point.id);
  }
  ASSERT_GE(ids.size(), 10u);
  for (const std::size_t kept : {9u, 10u}) {
    for (FrameObservation& frame : exact_.keyframes) {
      const auto is_other = [&](const PointObservation& point) {
        return std::find(ids.begin(), ids.begin() + kept, point.id) == ids.begin() + kept;
      };
      frame.points.erase(std::remove_if(frame.points.begin(), frame.points.end(), is_other),
                         frame.points.end());
    }
    EXPECT_EQ(std::isnan(find(window(newest)).reprojection_px), kept == 9u) << kept;
    exact_ = flightOf(Motion::kExcited, kNoisePx);
  }
}

// Every judgement from both sides; in a window that is being optimized states move a little.
TEST_F(Watch, EachFindingHasTwoSides) {
  using States = std::vector<NavState>;
  struct Case {
    const char* reason;
    double good, bad;
    void (*spoil)(double by, States* states);
  };
  const Case cases[] = {
      {"velocity changed by 2", 0.3, 2.0,
       [](double by, States* states) { states->back().v_w_b.x() += by; }},
      {"attitude", 0.017, 0.26,
       [](double by, States* states) {
         Eigen::Matrix3d& R = states->back().R_w_b;
         R = Eigen::AngleAxisd(by, Eigen::Vector3d::UnitX()) * R;
       }},
      {"tracks", 0.01, 1.0,
       [](double by, States* states) {
         for (std::size_t i = states->size() - 2; i < states->size(); ++i) {
           (*states)[i].p_w_b += Eigen::Vector3d(by, by, 0);
         }
       }},
      {"accelerometer bias", 1.9, 2.1,
       [](double by, States* states) {
         states->back().accel_bias = {by, 0, 0};
       }},
      {"gyroscope bias", 0.4, 0.6,
       [](double by, States* states) {
         states->back().gyro_bias = {0, by, 0};
       }},
      {"not finite", 0.0, std::numeric_limits<double>::quiet_NaN(),
       [](double by, States* states) { states->front().p_w_b.x() += by; }},
  };
  for (const Case& one : cases) {
    States good = window(30), bad = window(30);
    one.spoil(one.good, &good);
    one.spoil(one.bad, &bad);
    EXPECT_FALSE(find(good).suspect) << find(good).reason;
    EXPECT_TRUE(find(bad).suspect) << one.reason;
    EXPECT_NE(find(bad).reason.find(one.reason), std::string::npos) << find(bad).reason;
  }
  EXPECT_FALSE(find({}).suspect);
}

// Of a host with few frames at a high rate.
TEST_F(Watch, AWindowOfTwoTenthsOfASecondIsComparedToTheImu) {
  for (const double by : {0.3, 2.0}) {
    std::vector<NavState> states = window(30);
    states.erase(states.begin(), states.end() - 3);
    EXPECT_FALSE(find(states).suspect) << find(states).reason;
    states.back().v_w_b.x() += by;
    EXPECT_NEAR(find(states).velocity_mps, by, 0.05);
    EXPECT_EQ(find(states).suspect, by > 1.0) << find(states).reason;
  }
}

TEST(CompareStates, VelocityAndTilt) {
  const NavState truth = flightOf(Motion::kExcited, 0.0).truth[20];
  EXPECT_EQ(compareStates(truth, truth, 0.03), "");
  NavState other = truth;
  // Position and heading of the two frames are of no account.
  const Eigen::Matrix3d yaw = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  other.p_w_b += Eigen::Vector3d(3, 4, 5);
  other.R_w_b = yaw * other.R_w_b;
  other.v_w_b = yaw * other.v_w_b;
  EXPECT_EQ(compareStates(other, truth, 0.03), "");
  other.v_w_b *= 3.0;
  other.v_w_b += Eigen::Vector3d(1, 0, 0);
  EXPECT_NE(compareStates(other, truth, 0.03).find("velocity"), std::string::npos);
  other = truth;
  other.R_w_b = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()) * other.R_w_b;
  other.v_w_b = other.R_w_b * (truth.R_w_b.transpose() * truth.v_w_b);
  EXPECT_NE(compareStates(other, truth, 0.03).find("attitude"), std::string::npos);
  // A window in slow motion knows the tilt no better than that.
  EXPECT_EQ(compareStates(other, truth, 0.03, 3.0), "");
  expectParts(compareStates(other, truth, 0.03, 1.0), "attitude is 11.5 deg|(limit 8)");
}

// A bias may settle, at any value, and may not jump to it nor run to it, at any rate of the host.
TEST(SteadyBiases, SettleAndDoNotJump) {
  for (const double rate : {5.0, 10.0, 30.0}) {
    SCOPED_TRACE(rate);
    NavState state;
    state.t = 0.0;
    SteadyBiases biases;
    state.accel_bias = Eigen::Vector3d(1.0, 0, 0);  // of a poor sensor
    EXPECT_EQ(biases.judge(state), "");
    const auto drift = [&](double accel, double gyro) {  // in a second
      state.t += 1.0 / rate;
      state.accel_bias.x() -= accel / rate;
      state.gyro_bias.y() += gyro / rate;
      return biases.judge(state);
    };
    for (int frame = 0; frame < 10 * rate; ++frame) EXPECT_EQ(drift(0.08, 0.015), "") << frame;
    NavState jumped = state;
    jumped.accel_bias.z() += 0.55;
    expectParts(biases.judge(jumped), "accelerometer bias has moved by 0.");
    expectParts(biases.judge(jumped), "(limit 0.5)");  // what was refused does not count
    jumped = state;
    jumped.gyro_bias.x() += 0.12;
    EXPECT_NE(biases.judge(jumped).find("gyroscope bias has moved by"), std::string::npos);
    EXPECT_EQ(biases.judge(state), "");
    std::string said;
    for (int frame = 0; frame < 3 * rate && said.empty(); ++frame) said = drift(0.2, 0.0);
    expectParts(said, "accelerometer bias has moved by 0.5");
  }
}

}  // namespace
}  // namespace slim_init::host_health
