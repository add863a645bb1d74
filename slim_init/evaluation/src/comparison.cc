// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>

#include "method_lists.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::evaluation {
namespace {

// Neighbours share up to a window's length of data. Blocks of one length leave out a quarter of
// what that adds to the variance, blocks of two an eighth.
constexpr double kBlockWindows = 2.0;

// Fewer tell nothing about how much blocks differ.
constexpr double kMinFreedom = 4.0;

/// 97.5 % quantile of Student's t over that of the normal distribution (Abramowitz and Stegun 1964,
/// 26.7.5; 0.3 % at four degrees of freedom).
double studentFactor(double freedom) {
  const double z = 1.959963985, z2 = z * z, n = freedom;
  return 1.0 + (z2 + 1.0) / (4.0 * n) + ((5.0 * z2 + 16.0) * z2 + 3.0) / (96.0 * n * n) +
         (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / (384.0 * n * n * n);
}

/// Draws windows with replacement, in blocks of neighbours.
class BlockDraws {
 public:
  BlockDraws(const std::vector<const ProtocolResult*>& sequences, const BootstrapOptions& options) {
    std::mt19937 engine(options.seed);
    std::vector<int> blocks;
    for (std::size_t s = 0; s < sequences.size(); ++s) {
      blocks.push_back(blockLength(*sequences[s], options.block_s));
      windows_.insert(windows_.end(), sequences[s]->windows.size(), {s, 1.0 / blocks.back()});
    }
    times_.resize(static_cast<std::size_t>(options.replicates));
    for (std::vector<int>& times : times_) {
      for (std::size_t s = 0; s < sequences.size(); ++s) {
        draw(static_cast<int>(sequences[s]->windows.size()), blocks[s], &engine, &times);
      }
    }
  }

  /// Per replicate, how often each window was drawn: windows of the first sequence, then of the
  /// next, and so on.
  const std::vector<std::vector<int>>& times() const { return times_; }
  /// Of a list of windows: the blocks they make, and the sequences they are of.
  double blocksOf(const std::vector<std::size_t>& windows, int* sequences) const {
    double blocks = 0.0;
    std::set<std::size_t> seen;
    for (const std::size_t window : windows) {
      blocks += windows_[window].share;
      seen.insert(windows_[window].sequence);
    }
    *sequences = static_cast<int>(seen.size());
    return blocks;
  }

 private:
  /// In windows: those that begin within one block.
  static int blockLength(const ProtocolResult& sequence, double block_s) {
    std::vector<double> durations, steps;
    for (std::size_t i = 0; i < sequence.windows.size(); ++i) {
      durations.push_back(sequence.windows[i].duration_s);
      if (i > 0) steps.push_back(sequence.windows[i].t_start - sequence.windows[i - 1].t_start);
    }
    if (steps.empty()) return 1;
    if (!(block_s > 0.0)) block_s = kBlockWindows * median(durations);
    const double windows = std::ceil(block_s / median(steps) - 1e-6);
    return static_cast<int>(std::clamp(windows, 1.0, static_cast<double>(durations.size())));
  }

  static void draw(int windows, int block, std::mt19937* engine, std::vector<int>* times) {
    const auto first = static_cast<std::ptrdiff_t>(times->size());
    times->resize(times->size() + static_cast<std::size_t>(windows), 0);
    for (int drawn = 0; drawn < windows;) {
      // By hand, since std::uniform_int_distribution differs between standard libraries.
      const std::uint64_t random = (*engine)();
      const auto start = static_cast<int>((random * static_cast<std::uint64_t>(windows)) >> 32);
      for (int i = 0; i < block && drawn < windows; ++i, ++drawn) {
        ++*(times->begin() + first + (start + i) % windows);
      }
    }
  }

  struct Window {
    std::size_t sequence;
    double share;  ///< of a block
  };

  std::vector<std::vector<int>> times_;
  std::vector<Window> windows_;
};

/// A number per window of the method and one of the reference, and the difference of their means.
struct PairedValues {
  bool root = false;                 ///< of the root means; the values are squares
  std::vector<std::size_t> windows;  ///< into BlockDraws::times()
  std::vector<double> method, reference;

  void add(std::size_t window, double of_method, double of_reference) {
    windows.push_back(window);
    method.push_back(of_method);
    reference.push_back(of_reference);
  }

  /// With a weight per window; NaN where none has any.
  template <typename Weight>
  double difference(const Weight& weight) const {
    double sum = 0.0, method_sum = 0.0, reference_sum = 0.0;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const double w = weight(windows[i]);
      sum += w;
      method_sum += w * method[i];
      reference_sum += w * reference[i];
    }
    if (!(sum > 0.0)) return kNotComputed;
    if (!root) return (method_sum - reference_sum) / sum;
    return std::sqrt(method_sum / sum) - std::sqrt(reference_sum / sum);
  }

  Interval interval(const BlockDraws& draws) const {
    Interval interval;
    interval.value = difference([](std::size_t) { return 1.0; });
    // Every sequence keeps its share, which takes a degree of freedom.
    int sequences = 0;
    const double blocks = draws.blocksOf(windows, &sequences);
    const double freedom = blocks - sequences;
    if (!(freedom >= kMinFreedom)) return interval;
    std::vector<double> differences;
    for (const std::vector<int>& times : draws.times()) {
      const double drawn = difference([&](std::size_t window) { return double(times[window]); });
      if (std::isfinite(drawn)) differences.push_back(drawn);
    }
    // Draws from few blocks vary less than the blocks do.
    const double widening = studentFactor(freedom) * std::sqrt(blocks / freedom);
    interval.low = interval.value + widening * (quantile(differences, 0.025) - interval.value);
    interval.high = interval.value + widening * (quantile(differences, 0.975) - interval.value);
    return interval;
  }
};

bool succeeds(const MethodRecord& record) { return record.attempted && record.metrics.success(); }

/// An error of a window and where its interval goes.
struct ComparedError {
  double WindowMetrics::*error;
  Interval Comparison::*interval;
};

constexpr ComparedError kErrors[] = {
    {&WindowMetrics::scale_error, &Comparison::scale_rmse},
    {&WindowMetrics::gravity_error_deg, &Comparison::gravity_rmse_deg},
    {&WindowMetrics::velocity_rmse, &Comparison::velocity_rmse},
    {&WindowMetrics::pose_rmse, &Comparison::pose_rmse}};

Comparison compare(const std::string& name, const std::string& reference_name,
                   const std::vector<const ProtocolResult*>& sequences, WindowSubset subset,
                   const BlockDraws& draws) {
  Comparison comparison;
  comparison.method = name;
  PairedValues success;
  std::array<PairedValues, std::size(kErrors)> errors;
  std::size_t index = 0;
  for (const ProtocolResult* sequence : sequences) {
    const int of_method = indexOf(*sequence, name),
              of_reference = indexOf(*sequence, reference_name);
    for (const WindowRecord& window : sequence->windows) {
      const std::size_t w = index++;
      if (of_method < 0) continue;
      if (subset == WindowSubset::kExcited && !window.excitation.excited) continue;
      const MethodRecord& method = window.methods[static_cast<std::size_t>(of_method)];
      const MethodRecord& reference = window.methods[static_cast<std::size_t>(of_reference)];
      success.add(w, succeeds(method) ? 1.0 : 0.0, succeeds(reference) ? 1.0 : 0.0);
      if (!succeeds(method) || !succeeds(reference)) continue;
      ++comparison.both_success;
      for (std::size_t e = 0; e < errors.size(); ++e) {
        const double a = method.metrics.*kErrors[e].error, b = reference.metrics.*kErrors[e].error;
        errors[e].add(w, a * a, b * b);
      }
    }
  }
  comparison.windows = static_cast<int>(success.windows.size());
  comparison.success_rate = success.interval(draws);
  for (std::size_t e = 0; e < errors.size(); ++e) {
    errors[e].root = true;
    comparison.*kErrors[e].interval = errors[e].interval(draws);
  }
  return comparison;
}

}  // namespace

std::vector<Comparison> compareWith(const std::string& reference,
                                    const std::vector<const ProtocolResult*>& sequences,
                                    WindowSubset subset, const BootstrapOptions& options) {
  std::vector<const ProtocolResult*> used;
  for (const ProtocolResult* sequence : sequences) {
    if (sequence->has_truth && indexOf(*sequence, reference) >= 0) used.push_back(sequence);
  }
  const BlockDraws draws(used, options);
  std::vector<Comparison> comparisons;
  for (const std::string& name : methodsOf(used)) {
    if (name == reference) continue;
    comparisons.push_back(compare(name, reference, used, subset, draws));
  }
  return comparisons;
}

}  // namespace slim_init::evaluation
