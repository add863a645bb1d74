// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The compared methods that need neither Ceres nor OpenCV.
#pragma once

#include <string>

#include "slim_init/baselines/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// A method with the options of all methods and those that only compared ones have.
class ComparedMethod : public WindowSolver {
 public:
  ComparedMethod(const InitializerOptions& options, const BaselineOptions& baseline_options)
      : options_(options), baseline_options_(baseline_options) {}

 protected:
  InitializerOptions options_;
  BaselineOptions baseline_options_;
};

/// `slim-paper`: SLIM-init as written in section IV of the paper, each term with its switch
/// (SlimPaperOptions). With all switches off it differs from drt-l in the robust cost of step 1
/// only. What its line terms are worth: docs/baselines.md.
class SlimPaper : public ComparedMethod {
 public:
  using ComparedMethod::ComparedMethod;
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;
};

/// `drt-l`: the loosely-coupled variant of "A Rotation-Translation-Decoupled Solution for Robust
/// and Efficient Visual-Inertial Initialization" (He et al., CVPR 2023). Points only.
class DrtL : public ComparedMethod {
 public:
  using ComparedMethod::ComparedMethod;
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;
};

/// `drt-t`: He, Xu, Ouyang, Li, "A Rotation-Translation-Decoupled Solution for Robust and Efficient
/// Visual-Inertial Initialization", CVPR 2023, the tightly-coupled variant with the parameters of
/// the published release. The accelerometer bias is taken as zero; no gates of its own.
class DrtT : public ComparedMethod {
 public:
  using ComparedMethod::ComparedMethod;
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;
};

/// `drt-vi-ba`: DRT-l, refined by the structureless visual-inertial bundle adjustment of Song,
/// Richard, Olivares-Mendez, "Improving Monocular Visual-Inertial Initialization with Structureless
/// Visual-Inertial Bundle Adjustment", 2025 (epipolar_bundle_adjustment.h). No gates of its own.
class DrtViBa : public ComparedMethod {
 public:
  using ComparedMethod::ComparedMethod;
  const std::string& name() const override;
  InitResult solve(const InitWindow& window) const override;
};

}  // namespace slim_init::baselines
