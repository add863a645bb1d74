// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "data/with_observations.h"

namespace slim_init {

std::shared_ptr<const InitWindow> withObservations(const InitWindow& window,
                                                   const std::vector<char>& keep) {
  if (keep.size() != window.point_observations_.size()) return nullptr;
  const std::shared_ptr<InitWindow> out(new InitWindow());
  out->common_ = window.common_;
  std::vector<WindowPoint>& observations = out->point_observations_;
  observations.reserve(window.point_observations_.size());
  out->point_tracks_.reserve(window.point_tracks_.size());
  for (const Track& track : window.point_tracks_) {
    Track piece;
    piece.id = track.id;
    piece.begin = static_cast<int>(observations.size());
    const auto close = [&]() {
      piece.end = static_cast<int>(observations.size());
      if (piece.size() >= 2) {
        out->point_tracks_.push_back(piece);
      } else {
        observations.resize(piece.begin);
      }
      piece.begin = static_cast<int>(observations.size());
    };
    for (int a = track.begin; a < track.end; ++a) {
      if (keep[a] == kStartTrack) close();
      if (keep[a] != kDropObservation) observations.push_back(window.point_observations_[a]);
    }
    close();
  }
  return out;
}

}  // namespace slim_init
