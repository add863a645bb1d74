// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Input of the doctor from a recording with images.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "slim_init/doctor/doctor.h"
#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/options.h"

namespace slim_init::evaluation {

/// Light, sharpness and size of an image (CV_8UC1; empty: unreadable). `before`: the image before,
/// may be empty; `size`: that of the configuration.
ImageFacts imageFacts(double t, const cv::Mat& image, const cv::Mat& before, cv::Size size);

/// Reads and tracks the images. The tracker does not use the gyro, so that an incorrect extrinsic,
/// unit or offset cannot spoil the tracks that it is measured with. `limit`: only so many images
/// from the start, with the IMU data of their time, are left in `images`; 0: all. Images that
/// cannot be read or tracked are counted in the data: nothing here is an error.
DoctorData readDoctorData(ImageSequence* images,
                          const feature_tracker_lines::CameraParameters& camera,
                          const Calibration& calibration,
                          const feature_tracker_lines::FrontEndOptions& front_end, int limit,
                          const std::function<void(int done, int total)>& progress);

}  // namespace slim_init::evaluation
