// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in for the class of that name: what differs between the two hosts. Its lines beside the
// insertions read as the host's do; everything else is ours.
#pragma once

#include <std_msgs/Header.h>

#include "factor/marginalization_factor.h"

class Estimator : public EstimatorParts<std_msgs::Header, 1> {
 public:
  void processImage(const ImageFeatures& image, const std_msgs::Header& header);
  void solveOdometry();
  void clearState();
  void double2vector();

  IntegrationBase* tmp_pre_integration;
};
