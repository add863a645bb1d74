// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/downstream.h"

#include <Eigen/Geometry>
#include <cmath>

namespace slim_init::evaluation {

Eigen::Vector3d HeadingAlignment::apply(const Eigen::Vector3d& p) const {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * p + t;
}

HeadingAlignment alignHeading(const std::vector<Eigen::Vector3d>& source,
                              const std::vector<Eigen::Vector3d>& target) {
  const double n = static_cast<double>(source.size());
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero(), target_mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < source.size(); ++k) {
    source_mean += source[k] / n;
    target_mean += target[k] / n;
  }
  double sine = 0.0, cosine = 0.0;
  for (std::size_t k = 0; k < source.size(); ++k) {
    const Eigen::Vector3d a = source[k] - source_mean, b = target[k] - target_mean;
    sine += a.x() * b.y() - a.y() * b.x();
    cosine += a.x() * b.x() + a.y() * b.y();
  }
  HeadingAlignment alignment;
  alignment.yaw = std::atan2(sine, cosine);
  alignment.t = target_mean - alignment.apply(source_mean);
  return alignment;
}

}  // namespace slim_init::evaluation
