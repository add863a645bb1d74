// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <random>

namespace slim_init {

/// Standard normal numbers, the same ones for a seed.
class Gaussian {
 public:
  explicit Gaussian(unsigned seed) : random_(seed) {}

  double operator()() { return normal_(random_); }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// The last component first: the arguments of a call have no order that all compilers share.
  Eigen::Vector3d vector() {
    const double z = (*this)(), y = (*this)(), x = (*this)();
    return Eigen::Vector3d(x, y, z);
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace slim_init
