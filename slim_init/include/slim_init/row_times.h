// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Rolling shutter: the exposure of what was observed, from the image row.
#pragma once

#include "slim_init/types.h"

namespace slim_init {

/// Sets PointObservation::dt of all points and LineObservation::start_dt, end_dt of all lines of
/// `frame` from the rows of their raw pixels (rowTime()), for an image of `height` rows [px] read
/// out in `readout_s` [s]. With a height or readout of zero all become zero (global shutter).
inline void setRowTimes(int height, double readout_s, FrameObservation* frame) {
  if (!(readout_s > 0.0)) height = 0;  // no negative zeros
  for (PointObservation& point : frame->points) {
    point.dt = rowTime(point.pixel.y(), height, readout_s);
  }
  for (LineObservation& line : frame->lines) {
    line.start_dt = rowTime(line.start_pixel.y(), height, readout_s);
    line.end_dt = rowTime(line.end_pixel.y(), height, readout_s);
  }
}

}  // namespace slim_init
