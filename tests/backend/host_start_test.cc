// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The test host from a cold start: how long until the first state, and what becomes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include "backend/host_run.h"

namespace slim_init::backend {
namespace {

// Bounds of the project for excited motion.
constexpr double kTimeToFirstState = 2.5;  // [s] of data
constexpr double kScaleError = 0.25;       // more is a wrong scale
// ATE over the three seconds after the first state, [m]: median, and the worst of fifty.
constexpr double kMedianAte = 0.04;
constexpr double kWorstAte = 0.15;
constexpr double kSecondsAfterStart = 3.0;

struct Start {
  double first_state_s = kNotComputed;
  double ate = kNotComputed;
  double scale_error = kNotComputed;
  bool failed = false;
};

Start startAt(const evaluation::Sequence& sequence, std::size_t first_frame) {
  HostRun run(sequence, first_frame);
  Start start;
  std::vector<Eigen::Vector3d> estimated, truth;
  while (const HostStep* step = run.next()) {
    const double elapsed = run.stamp() - sequence.frames[first_frame].t;
    if (step->seeded && std::isnan(start.first_state_s)) start.first_state_s = elapsed;
    start.failed = start.failed || step->failed;
    if (step->tracking) {
      estimated.push_back(step->state.p_w_b);
      truth.push_back(run.truth().p_w_b);
    }
    if (elapsed > start.first_state_s + kSecondsAfterStart || elapsed > 6.0) break;
  }
  if (estimated.empty()) return start;
  const evaluation::HeadingAlignment alignment = evaluation::alignHeading(estimated, truth);
  double sum = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    sum += (alignment.apply(estimated[k]) - truth[k]).squaredNorm();
  }
  start.ate = std::sqrt(sum / static_cast<double>(truth.size()));
  start.scale_error = run.scaleError();
  return start;
}

TEST(TestHostStart, FiftyStartsInExcitedMotion) {
  std::vector<double> times, ates;
  for (const char* motion : {"figure-eight", "circle"}) {
    const evaluation::Sequence sequence = makeSimulatedSequence({motion, 26.0});
    for (std::size_t k = 0; k < 25; ++k) {
      const Start start = startAt(sequence, 5 + 8 * k);
      ASSERT_FALSE(std::isnan(start.first_state_s)) << motion << ", start " << k;
      EXPECT_LE(start.first_state_s, kTimeToFirstState) << motion << ", start " << k;
      EXPECT_LT(start.scale_error, kScaleError) << motion << ", start " << k;
      EXPECT_LT(start.ate, kWorstAte) << motion << ", start " << k;
      EXPECT_FALSE(start.failed) << motion << ", start " << k;
      times.push_back(start.first_state_s);
      ates.push_back(start.ate);
    }
  }
  std::sort(times.begin(), times.end());
  std::sort(ates.begin(), ates.end());
  EXPECT_LT(ates[25], kMedianAte);
  std::cout << "time to first state: median " << times[25] << " s, longest " << times.back()
            << " s; ATE over " << kSecondsAfterStart << " s: median " << ates[25] << " m, largest "
            << ates.back() << " m\n";
}

}  // namespace
}  // namespace slim_init::backend
