// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in's node as the test drives it. Comes after the flavour's Estimator.
#pragma once

#include <sensor_msgs/Imu.h>

Estimator& hostEstimator();
void startNode();
void process(const std::vector<sensor_msgs::ImuConstPtr>& imu, const ImageFeatures& image,
             double stamp);
/// The tracker has found a gap in its images; `waiting` were received after the last image.
void restart(const std::vector<sensor_msgs::ImuConstPtr>& waiting);
