// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in for the class of that name: what differs between the two hosts. Its lines beside the
// insertions read as the host's do; everything else is ours.
#pragma once

#include <chrono>
#include <mutex>
#include <queue>

#include "../factor/marginalization_factor.h"

class Estimator : public EstimatorParts<double, 2> {
 public:
  void processIMU(double t, double dt, const Vector3d& linear_acceleration,
                  const Vector3d& angular_velocity);
  void processImage(const ImageFeatures& image, const double header);
  void clearState();
  void double2vector();

  IntegrationBase* tmp_pre_integration;
  std::mutex mProcess;
  std::mutex mBuf;
  std::queue<std::pair<double, Vector3d>> accBuf, gyrBuf;
};
