// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Random numbers with equal bytes on every standard library.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace slim_init::simulation {

/// One named random stream of a seed. Streams of different names are independent: the numbers of
/// one do not change when more are drawn from another.
///
/// The distributions of <random> are not used because the standard leaves their algorithms, and so
/// their bytes, to the library; the engine itself is fixed by the standard.
class Random {
 public:
  Random(std::uint64_t seed, const char* stream);

  /// In [0, 1), all 53 bits random.
  double uniform();
  /// In [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In [0, count); 0 for a count below 1.
  int index(int count);
  /// Normal with zero mean and unit variance.
  double gaussian();
  Eigen::Vector2d gaussian2();
  Eigen::Vector3d gaussian3();
  /// Exponential with unit mean.
  double exponential();

 private:
  std::mt19937_64 engine_;
  bool has_spare_ = false;  // Box-Muller makes two numbers at a time
  double spare_ = 0.0;
};

}  // namespace slim_init::simulation
