// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/image_times.h"

#include "random.h"

namespace slim_init::simulation {
namespace {

constexpr double kIntervals[] = {0.033, 0.040, 0.060};   // [s]
constexpr double kShortestRun = 0.5, kLongestRun = 2.0;  // [s]
constexpr double kGap = 0.4;                             // [s]
// Chance of a gap at the end of a run: they last 1.25 s on average.
constexpr double kGapChance = 0.2;

}  // namespace

std::vector<double> autoExposureTimes(double first, double last, unsigned seed) {
  Random random(seed, "image times");
  std::vector<double> times;
  double t = first;
  while (t <= last) {
    const double interval = kIntervals[random.index(3)];
    const double end = t + random.uniform(kShortestRun, kLongestRun);
    for (; t < end && t <= last; t += interval) times.push_back(t);
    if (random.uniform() < kGapChance) t += kGap;
  }
  return times;
}

}  // namespace slim_init::simulation
