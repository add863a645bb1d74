// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Structure from motion of a window (Qin, Li, Shen 2018, section V-A): a reference pair by the
// five-point method, the other keyframes by PnP, all of it by bundle adjustment.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slim_init/baselines/baselines.h"
#include "slim_init/init_window.h"
#include "slim_init/result.h"

namespace slim_init::baselines {

/// Camera poses up to scale, or why there are none.
struct StructureFromMotion {
  InitStatus status = InitStatus::kNumericalFailure;  ///< kSuccess, or that of the refusal
  std::string message;                                ///< why it was refused
  std::vector<Eigen::Matrix3d> R_c0_ck;               ///< camera k to the first camera
  Eigen::Matrix3Xd centres_c0;                        ///< 3xN camera centres, column 0 zero
  int points = 0;                                     ///< in the bundle adjustment
  double rms_px = kNotComputed;                       ///< of its residuals, per coordinate

  bool valid() const { return status == InitStatus::kSuccess; }
};

/// Reconstructs the window. Deterministic: the consensus searches draw from fixed seeds.
StructureFromMotion reconstruct(const InitWindow& window, const VinsOptions& options);

}  // namespace slim_init::baselines
