// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace slim_init::evaluation {
namespace {

MethodRecord answer(double scale_error) {
  MethodRecord record;
  record.status = InitStatus::kSuccess;
  record.attempted = true;
  record.metrics.scale = 1.0 + scale_error;
  record.metrics.scale_error = scale_error;
  record.metrics.gravity_error_deg = 2.0 * scale_error;
  record.metrics.velocity_rmse = 3.0 * scale_error;
  record.metrics.velocity_vec_rmse = 3.0 * scale_error;
  record.metrics.pose_rmse = 4.0 * scale_error;
  record.solve_ms = record.solve_cpu_ms = 1.0;
  return record;
}

/// Windows of 2.25 s, one every half second, with the scale errors of each method by window.
ProtocolResult sequenceOf(const std::vector<std::string>& methods,
                          const std::vector<std::vector<double>>& errors) {
  ProtocolResult result;
  result.methods = methods;
  for (std::size_t i = 0; i < errors.front().size(); ++i) {
    WindowRecord window;
    window.trial = static_cast<int>(i);
    window.t_start = 0.5 * static_cast<double>(i);
    window.duration_s = 2.25;
    window.excitation.excited = true;
    for (const std::vector<double>& of_method : errors)
      window.methods.push_back(answer(of_method[i]));
    result.windows.push_back(window);
  }
  return result;
}

std::vector<Comparison> compareAll(const std::vector<const ProtocolResult*>& sequences,
                                   const BootstrapOptions& options = {}) {
  return compareWith("ref", sequences, WindowSubset::kAll, options);
}

/// |Gaussian| errors that stay below the bound of a success.
class Errors {
 public:
  explicit Errors(unsigned seed) : engine_(seed) {}

  double operator()(double sigma) { return std::min(0.49, std::abs(sigma * normal_(engine_))); }

  std::vector<double> independent(std::size_t n, double sigma) {
    std::vector<double> errors(n);
    for (double& e : errors) e = (*this)(sigma);
    return errors;
  }

  /// As overlapping windows have them: neighbours share most of their data.
  std::vector<double> overlapping(std::size_t n, double sigma, std::size_t span) {
    std::vector<double> data(n + span);
    for (double& d : data) d = normal_(engine_);
    std::vector<double> errors(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double sum = std::accumulate(data.begin() + static_cast<std::ptrdiff_t>(i),
                                         data.begin() + static_cast<std::ptrdiff_t>(i + span), 0.0);
      errors[i] = std::min(0.49, std::abs(sigma * sum / std::sqrt(static_cast<double>(span))));
    }
    return errors;
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

double width(const Interval& interval) { return interval.high - interval.low; }

bool holdsZero(const Interval& interval) { return interval.low <= 0.0 && interval.high >= 0.0; }

TEST(Comparison, ValuesByHand) {
  // 60 windows: the method fails in three, the reference in two, in one of them both.
  std::vector<double> method(60, 0.2), reference(60, 0.1);
  method[3] = method[4] = method[5] = 0.9;
  reference[5] = reference[6] = 0.6;
  method[10] = 0.4;
  const ProtocolResult sequence = sequenceOf({"ref", "other"}, {reference, method});
  const std::vector<Comparison> comparisons = compareAll({&sequence});
  ASSERT_EQ(comparisons.size(), 1u);
  const Comparison& c = comparisons[0];
  EXPECT_EQ(c.method, "other");
  EXPECT_EQ(c.windows, 60);
  EXPECT_EQ(c.both_success, 56);
  EXPECT_NEAR(c.success_rate.value, 57.0 / 60.0 - 58.0 / 60.0, 1e-12);
  const double difference = std::sqrt((55 * 0.2 * 0.2 + 0.4 * 0.4) / 56.0) - 0.1;
  EXPECT_NEAR(c.scale_rmse.value, difference, 1e-12);
  EXPECT_NEAR(c.gravity_rmse_deg.value, 2.0 * difference, 1e-12);
  EXPECT_NEAR(c.velocity_rmse.value, 3.0 * difference, 1e-12);
  EXPECT_NEAR(c.pose_rmse.value, 4.0 * difference, 1e-12);
  EXPECT_LE(c.scale_rmse.low, difference);
  EXPECT_GE(c.scale_rmse.high, difference);
  EXPECT_TRUE(c.scale_rmse.significant());
  EXPECT_FALSE(c.success_rate.significant());
}

TEST(Comparison, NoDifferenceIsExactlyNone) {
  Errors errors(1);
  const std::vector<double> same = errors.independent(60, 0.2);
  const ProtocolResult sequence = sequenceOf({"ref", "twin"}, {same, same});
  const Comparison c = compareAll({&sequence})[0];
  for (const Interval& i : {c.success_rate, c.scale_rmse, c.pose_rmse}) {
    EXPECT_EQ(i.value, 0.0);
    EXPECT_EQ(i.low, 0.0);
    EXPECT_EQ(i.high, 0.0);
    EXPECT_FALSE(i.significant());
  }
}

/// Share of intervals that hold a true difference of zero, and their mean width.
struct Coverage {
  double rate = 0.0, width = 0.0;
};

Coverage coverage(std::size_t windows, std::size_t span, double block_s) {
  constexpr int kRuns = 300;
  Coverage result;
  for (int run = 0; run < kRuns; ++run) {
    Errors errors(1000 + static_cast<unsigned>(run));
    const ProtocolResult sequence = sequenceOf(
        {"ref", "other"},
        {errors.overlapping(windows, 0.1, span), errors.overlapping(windows, 0.1, span)});
    BootstrapOptions options;
    options.replicates = 400;
    options.block_s = block_s;
    const Interval interval = compareAll({&sequence}, options)[0].scale_rmse;
    result.rate += holdsZero(interval) ? 1.0 / kRuns : 0.0;
    result.width += width(interval) / kRuns;
  }
  return result;
}

TEST(Comparison, IntervalsOfIndependentWindowsHoldTheTruthAsOftenAsTheySay) {
  const Coverage singles = coverage(200, 1, 0.5);
  EXPECT_GT(singles.rate, 0.92);
  EXPECT_LT(singles.rate, 0.98);
}

TEST(Comparison, BlocksKeepIntervalsHonestWhereWindowsOverlap) {
  const Coverage blocks = coverage(200, 5, 0.0), singles = coverage(200, 5, 0.5);
  EXPECT_GT(blocks.rate, 0.90);
  EXPECT_LT(blocks.rate, 0.98);
  // Taken for independent, overlapping windows promise far too much.
  EXPECT_LT(singles.rate, 0.75);
  EXPECT_GT(blocks.width, 1.4 * singles.width);
}

TEST(Comparison, FewBlocksAreNoExcuse) {
  const Coverage few = coverage(60, 5, 0.0);
  EXPECT_GT(few.rate, 0.91);
}

TEST(Comparison, AClearDifferenceIsSeen) {
  Errors errors(7);
  const ProtocolResult sequence =
      sequenceOf({"worse", "ref", "better"},
                 {errors.overlapping(150, 0.16, 5), errors.overlapping(150, 0.1, 5),
                  errors.overlapping(150, 0.05, 5)});
  const std::vector<Comparison> c = compareAll({&sequence});
  ASSERT_EQ(c.size(), 2u);
  EXPECT_EQ(c[0].method, "worse");
  EXPECT_GT(c[0].scale_rmse.low, 0.0);
  EXPECT_EQ(c[1].method, "better");
  EXPECT_LT(c[1].scale_rmse.high, 0.0);
  EXPECT_TRUE(c[0].scale_rmse.significant() && c[1].scale_rmse.significant());
}

TEST(Comparison, PairingRemovesWhatBothMethodsShare) {
  // Hard and easy windows are so for both; only a little differs.
  Errors errors(3);
  const std::vector<double> shared = errors.overlapping(150, 0.1, 5);
  std::vector<double> method = shared;
  for (double& e : method) e = std::min(0.49, 1.1 * e);
  const ProtocolResult sequence = sequenceOf({"ref", "other"}, {shared, method});
  EXPECT_TRUE(compareAll({&sequence})[0].scale_rmse.significant());
}

TEST(Comparison, EverySequenceKeepsItsShare) {
  // The method fails on all of one sequence and on none of the other: no draw can change the rate,
  // unless blocks or windows wander between sequences.
  const ProtocolResult easy =
      sequenceOf({"ref", "other"}, {std::vector<double>(61, 0.1), std::vector<double>(61, 0.1)});
  const ProtocolResult hard =
      sequenceOf({"ref", "other"}, {std::vector<double>(37, 0.1), std::vector<double>(37, 0.9)});
  const Comparison c = compareAll({&easy, &hard})[0];
  EXPECT_EQ(c.windows, 98);
  EXPECT_EQ(c.both_success, 61);
  EXPECT_NEAR(c.success_rate.value, -37.0 / 98.0, 1e-12);
  EXPECT_NEAR(c.success_rate.low, -37.0 / 98.0, 1e-12);
  EXPECT_NEAR(c.success_rate.high, -37.0 / 98.0, 1e-12);
}

TEST(Comparison, TooLittleDataGivesNoInterval) {
  Errors errors(5);
  // Four blocks of nine windows, however many draws are made of them.
  ProtocolResult sequence =
      sequenceOf({"ref", "other"}, {errors.independent(36, 0.1), errors.independent(36, 0.1)});
  Comparison c = compareAll({&sequence})[0];
  EXPECT_TRUE(std::isfinite(c.scale_rmse.value));
  EXPECT_TRUE(std::isnan(c.scale_rmse.low) && std::isnan(c.scale_rmse.high));
  EXPECT_FALSE(c.scale_rmse.significant());
  // Enough windows, but hardly any in which both succeed.
  sequence =
      sequenceOf({"ref", "other"}, {errors.independent(60, 0.1), std::vector<double>(60, 0.9)});
  c = compareAll({&sequence})[0];
  EXPECT_EQ(c.both_success, 0);
  EXPECT_TRUE(std::isnan(c.scale_rmse.value) && std::isnan(c.scale_rmse.low));
  EXPECT_LT(c.success_rate.high, -0.9);
  // Many sequences, none of which is long enough to tell how its blocks differ.
  sequence = sequenceOf({"ref", "other"}, {errors.independent(8, 0.1), errors.independent(8, 0.1)});
  c = compareAll(std::vector<const ProtocolResult*>(20, &sequence))[0];
  EXPECT_EQ(c.windows, 160);
  EXPECT_TRUE(std::isnan(c.scale_rmse.low));
  // A single window, and none.
  sequence = sequenceOf({"ref", "other"}, {{0.1}, {0.2}});
  EXPECT_NEAR(compareAll({&sequence})[0].scale_rmse.value, 0.1, 1e-12);
  sequence.windows.clear();
  EXPECT_TRUE(std::isnan(compareAll({&sequence})[0].success_rate.value));
}

TEST(Comparison, MissingMethodsAndSequencesWithoutTruth) {
  const std::vector<double> good(40, 0.1), bad(40, 0.9);
  const ProtocolResult both = sequenceOf({"ref", "a"}, {good, bad});
  const ProtocolResult more = sequenceOf({"b", "ref"}, {good, good});
  const ProtocolResult without_reference = sequenceOf({"a", "c"}, {good, good});
  ProtocolResult blind = sequenceOf({"ref", "a"}, {good, good});
  blind.has_truth = false;
  const std::vector<Comparison> c = compareAll({&both, &more, &without_reference, &blind});
  ASSERT_EQ(c.size(), 2u);
  EXPECT_EQ(c[0].method, "a");
  EXPECT_EQ(c[0].windows, 40);
  EXPECT_EQ(c[0].success_rate.value, -1.0);
  EXPECT_EQ(c[1].method, "b");
  EXPECT_EQ(c[1].windows, 40);
  EXPECT_EQ(c[1].success_rate.value, 0.0);
  EXPECT_TRUE(compareAll({}).empty());
  EXPECT_TRUE(compareAll({&without_reference}).empty());
}

TEST(Comparison, ExcitedWindowsAlone) {
  ProtocolResult sequence =
      sequenceOf({"ref", "other"}, {std::vector<double>(120, 0.1), std::vector<double>(120, 0.1)});
  for (std::size_t i = 0; i < 120; ++i) {
    sequence.windows[i].excitation.excited = i % 2 == 0;
    if (i % 2 == 1) sequence.windows[i].methods[1] = answer(0.3);
  }
  const Comparison c = compareWith("ref", {&sequence}, WindowSubset::kExcited)[0];
  EXPECT_EQ(c.windows, 60);
  EXPECT_EQ(c.scale_rmse.value, 0.0);
  EXPECT_EQ(c.scale_rmse.high, 0.0);
}

TEST(Comparison, EqualSeedsGiveEqualIntervals) {
  Errors errors(9);
  const ProtocolResult sequence = sequenceOf(
      {"ref", "a", "b"},
      {errors.independent(50, 0.1), errors.independent(50, 0.1), errors.independent(50, 0.1)});
  const Interval first = compareAll({&sequence})[1].scale_rmse;
  const Interval second = compareAll({&sequence})[1].scale_rmse;
  EXPECT_EQ(first.low, second.low);
  EXPECT_EQ(first.high, second.high);
  BootstrapOptions options;
  options.seed = 2;
  EXPECT_NE(compareAll({&sequence}, options)[1].scale_rmse.low, first.low);
}

TEST(SummaryOfSequences, IsThatOfAllWindowsTogether) {
  Errors errors(11);
  const ProtocolResult one =
      sequenceOf({"ref", "a"}, {errors.independent(20, 0.2), errors.independent(20, 0.5)});
  const ProtocolResult two =
      sequenceOf({"a", "ref"}, {errors.independent(15, 0.5), errors.independent(15, 0.2)});
  ProtocolResult together = one;
  for (const WindowRecord& window : two.windows) {
    together.windows.push_back(window);
    std::swap(together.windows.back().methods[0], together.windows.back().methods[1]);
  }
  const RunInfo info;
  EXPECT_EQ(summaryCsv(info, summarize({&one, &two})), summaryCsv(info, summarize(together)));
  // A method that ran on one of them only.
  const ProtocolResult three = sequenceOf({"b"}, {{0.1, 0.2}});
  const std::vector<MethodSummary> summaries = summarize({&one, &three});
  ASSERT_EQ(summaries.size(), 3u);
  EXPECT_EQ(summaries[0].all.windows, 20);
  EXPECT_EQ(summaries[2].name, "b");
  EXPECT_EQ(summaries[2].all.windows, 2);
}

}  // namespace
}  // namespace slim_init::evaluation
