// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "rotation/constants.h"
#include "rotation/track_pruning.h"
#include "slim_init/init_window.h"

namespace slim_init {

/// Which pairs of observations of a track agree with the motion of the camera, and what follows
/// from it for the observations.
class LinkTable {
 public:
  explicit LinkTable(const InitWindow& window);

  /// Verdict on the link from observation `a` to that of the same track `gap` keyframes later,
  /// 1 <= gap <= rotation_constants::kMaxLinkGap.
  void set(int a, int gap, bool agrees) { links_[a][gap] = agrees ? kAgrees : kDisagrees; }

  /// Cuts tracks where they jump and drops what fits nowhere; `pairs` is left at zero.
  TrackPruning prune() const;

 private:
  enum Link : char { kUntested, kAgrees, kDisagrees };

  Link link(int a, int b) const;
  void pruneTrack(const Track& track, TrackPruning* out) const;
  void closePiece(int begin, int end, TrackPruning* out) const;

  const InitWindow& window_;
  // By observation and gap.
  std::vector<std::array<Link, rotation_constants::kMaxLinkGap + 1>> links_;
};

}  // namespace slim_init
