// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The compared methods, as Method::solve has them.
#pragma once

#include "slim_init/baselines/options.h"
#include "slim_init/init_window.h"
#include "slim_init/options.h"
#include "slim_init/result.h"

namespace slim_init::baselines {

/// `slim-paper`: SLIM-init as written in section IV of the paper, each term with its switch
/// (SlimPaperOptions). With all switches off it differs from drt-l in the robust cost of step 1
/// only. What its line terms are worth: docs/baselines.md.
InitResult solveSlimPaper(const InitWindow& window, const InitializerOptions& options,
                          const BaselineOptions& baseline_options);

/// `drt-l`: the loosely-coupled variant of "A Rotation-Translation-Decoupled Solution for Robust
/// and Efficient Visual-Inertial Initialization" (He et al., CVPR 2023). Points only.
InitResult solveDrtL(const InitWindow& window, const InitializerOptions& options,
                     const BaselineOptions& baseline_options);

/// `drt-t`: He, Xu, Ouyang, Li, "A Rotation-Translation-Decoupled Solution for Robust and Efficient
/// Visual-Inertial Initialization", CVPR 2023, the tightly-coupled variant with the parameters of
/// the published release. The accelerometer bias is taken as zero; no gates of its own.
InitResult solveDrtT(const InitWindow& window, const InitializerOptions& options,
                     const BaselineOptions& baseline_options);

/// `drt-vi-ba`: DRT-l, refined by the structureless visual-inertial bundle adjustment of Song,
/// Richard, Olivares-Mendez, "Improving Monocular Visual-Inertial Initialization with Structureless
/// Visual-Inertial Bundle Adjustment", 2025 (epipolar_bundle_adjustment.h). No gates of its own.
InitResult solveDrtViBa(const InitWindow& window, const InitializerOptions& options,
                        const BaselineOptions& baseline_options);

/// `vins`: the loosely-coupled initializer of VINS-Mono (Qin and Shen, "Robust initialization of
/// monocular visual-inertial estimation on aerial robots", IROS 2017; Qin, Li, Shen, "VINS-Mono",
/// T-RO 2018, section V). The accelerometer bias is taken as zero. Refuses as the release does; a
/// refusal comes without an estimate.
InitResult solveVins(const InitWindow& window, const InitializerOptions& options,
                     const BaselineOptions& baseline_options);

/// `openvins`: the dynamic initializer of OpenVINS (Geneva et al. 2020), which is the closed form
/// of Dong-Si and Mourikis, "Estimator initialization in vision-aided inertial navigation with
/// unknown camera-IMU calibration", IROS 2012, and a maximum-likelihood refinement of it. Refuses
/// as the release does; a refusal comes without an estimate.
InitResult solveOpenVins(const InitWindow& window, const InitializerOptions& options,
                         const BaselineOptions& baseline_options);

}  // namespace slim_init::baselines
