// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rolling shutter: the image rows of what was observed, from which its exposure follows.
#pragma once

#include "slim_init/types.h"

namespace slim_init {

/// Sets PointObservation::row of all points and LineObservation::start_row, end_row of all lines of
/// `frame` from their raw pixels (imageRow()), for an image of `height` rows [px].
inline void setRows(int height, FrameObservation* frame) {
  for (PointObservation& point : frame->points) point.row = imageRow(point.pixel.y(), height);
  for (LineObservation& line : frame->lines) {
    line.start_row = imageRow(line.start_pixel.y(), height);
    line.end_row = imageRow(line.end_pixel.y(), height);
  }
}

}  // namespace slim_init
