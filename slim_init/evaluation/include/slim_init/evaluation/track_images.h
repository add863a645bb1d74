// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From a recording with pixels to what a solver sees.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/sequence.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "slim_init/types.h"

namespace slim_init::evaluation {

/// Runs one ImageFrontEnd over all images that the IMU data cover, in order, the IMU fed up to each
/// of them: tracks run through the whole recording, as in flight. An image that cannot be read or
/// that the front end refuses is counted and discarded. `frames` gets one observation per tracked
/// image. `progress` (may be empty) is called after every image with the number done and in all.
/// Returns an empty string, or a sentence when fewer than two images could be tracked.
std::string trackImages(ImageSequence* images,
                        const feature_tracker_lines::CameraParameters& camera,
                        const Calibration& calibration,
                        const feature_tracker_lines::FrontEndOptions& options,
                        const std::function<void(int done, int total)>& progress,
                        std::vector<FrameObservation>* frames, TrackingSummary* summary);

}  // namespace slim_init::evaluation
