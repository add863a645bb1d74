// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in for the class of that name: what differs between the two hosts. Its lines beside the
// insertions read as the host's do; everything else is ours.
#pragma once

#include <std_msgs/Header.h>

#include "factor/marginalization_factor.h"

using Eigen::Vector4d;
using std::map;
using std::pair;
using std::vector;

class Estimator : public EstimatorParts<std_msgs::Header, 1, NoTimeOffset> {
 public:
  void processImage(const map<int, vector<pair<int, Eigen::Matrix<double, 5, 1>>>>& image,
                    const map<int, vector<pair<int, Vector4d>>>& lines,
                    const std_msgs::Header& header);
  void processImage(const map<int, vector<pair<int, Vector3d>>>& image,
                    const std_msgs::Header& header);
  void solveOdometry();
  void clearState();

  IntegrationBase* tmp_pre_integration;
};
