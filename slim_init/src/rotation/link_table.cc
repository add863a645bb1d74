// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/link_table.h"

#include <algorithm>

namespace slim_init {

using rotation_constants::kMaxLinkGap;

LinkTable::LinkTable(const InitWindow& window)
    : window_(window), links_(window.pointObservations().size()) {
  for (auto& row : links_) row.fill(kUntested);
}

LinkTable::Link LinkTable::link(int a, int b) const {
  const int gap = window_.pointObservations()[b].keyframe - window_.pointObservations()[a].keyframe;
  return gap <= kMaxLinkGap ? links_[a][gap] : kUntested;
}

// A piece of track, [begin, end) without the dropped ones, is complete. Dropped as a whole when it
// is a single observation, or when most of its longest links disagree: such a point slides slowly.
void LinkTable::closePiece(int begin, int end, TrackPruning* out) const {
  const std::vector<WindowPoint>& s = window_.pointObservations();
  int kept = 0, agree = 0, disagree = 0;
  for (int a = begin; a < end; ++a) {
    if (out->keep[a] == kDropObservation) continue;
    ++kept;
    for (int b = a + 1; b < end && s[b].keyframe - s[a].keyframe <= kMaxLinkGap; ++b) {
      if (out->keep[b] == kDropObservation || s[b].keyframe - s[a].keyframe != kMaxLinkGap)
        continue;
      agree += link(a, b) == kAgrees ? 1 : 0;
      disagree += link(a, b) == kDisagrees ? 1 : 0;
    }
  }
  if (kept < 2 || disagree > agree) {
    std::fill(out->keep.begin() + begin, out->keep.begin() + end, kDropObservation);
  }
}

void LinkTable::pruneTrack(const Track& track, TrackPruning* out) const {
  int begin = track.begin;  // of the present piece
  int last = track.begin;   // its last observation
  int pending = -1;         // an observation after `last` that does not agree with it
  for (int b = track.begin + 1; b < track.end; ++b) {
    const Link step = link(b - 1, b);
    if (step != kUntested) {
      ++out->checked;
      out->inconsistent += step == kDisagrees ? 1 : 0;
    }
    const Link with_last = link(last, b);
    if (with_last == kAgrees || (with_last == kUntested && last == b - 1)) {
      if (pending >= 0) out->keep[pending] = kDropObservation;
      pending = -1;
      last = b;
    } else if (pending == b - 1 && step != kDisagrees) {
      // Two in a row agree with each other and not with what was before: a jump.
      closePiece(begin, pending, out);
      out->keep[pending] = kStartTrack;
      begin = pending;
      last = b;
      pending = -1;
    } else {
      if (pending >= 0) out->keep[pending] = kDropObservation;
      pending = b;
    }
  }
  if (pending >= 0) out->keep[pending] = kDropObservation;
  closePiece(begin, track.end, out);
  // No observation is kept before the first piece that is: it needs no cut.
  const auto first = std::find_if(out->keep.begin() + track.begin, out->keep.begin() + track.end,
                                  [](char keep) { return keep != kDropObservation; });
  if (first != out->keep.begin() + track.end) *first = kKeepObservation;
}

TrackPruning LinkTable::prune() const {
  TrackPruning out;
  out.keep.assign(window_.pointObservations().size(), kKeepObservation);
  for (const Track& track : window_.pointTracks()) pruneTrack(track, &out);
  out.dropped = static_cast<int>(std::count(out.keep.begin(), out.keep.end(), kDropObservation));
  out.cuts = static_cast<int>(std::count(out.keep.begin(), out.keep.end(), kStartTrack));
  return out;
}

}  // namespace slim_init
