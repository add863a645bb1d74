// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Minimum of a function of one variable.
#pragma once

namespace slim_init {

/// A point of a function.
struct FunctionPoint {
  double at, value;
};

/// The minimum of `function` between `low` and `high`, where it has one, to `tolerance`: golden
/// section search. Values may be infinite.
template <typename Function>
FunctionPoint goldenSection(const Function& function, double low, double high, double tolerance) {
  constexpr double kGolden = 0.6180339887498949;  // (sqrt(5) - 1) / 2
  const auto evaluate = [&function](double at) { return FunctionPoint{at, function(at)}; };
  FunctionPoint a = evaluate(high - kGolden * (high - low));
  FunctionPoint b = evaluate(low + kGolden * (high - low));
  while (high - low > tolerance) {
    if (a.value < b.value) {
      high = b.at;
      b = a;
      a = evaluate(high - kGolden * (high - low));
    } else {
      low = a.at;
      a = b;
      b = evaluate(low + kGolden * (high - low));
    }
  }
  return a.value < b.value ? a : b;
}

}  // namespace slim_init
