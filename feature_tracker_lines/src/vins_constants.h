// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Constants of VINS-Mono's feature_tracker, for TrackerProfile::kVins. They are fixed numbers in
// the host's source; what its configuration file sets is in HostFrontEnd.
#pragma once

namespace slim_init::feature_tracker_lines::vins {

inline constexpr double kFocalPx = 460.0;     ///< plane on which outliers are looked for [px]
inline constexpr double kBorderPx = 1.0;      ///< points closer to the image edge are dropped [px]
inline constexpr int kWindowPx = 21;          ///< side of the KLT window [px]
inline constexpr int kLevels = 3;             ///< pyramid levels above the image
inline constexpr double kQuality = 0.01;      ///< corners: share of the strongest eigenvalue
inline constexpr double kEveryImageHz = 100;  ///< what HostFrontEnd::freq = 0 stands for [Hz]
inline constexpr double kRateTolerance = 0.01;  ///< of the publishing rate, at which counts restart
inline constexpr double kClaheLimit = 3.0;      ///< contrast limit of the equalization
inline constexpr int kClaheTiles = 8;           ///< tiles of the equalization, across and down

}  // namespace slim_init::feature_tracker_lines::vins
