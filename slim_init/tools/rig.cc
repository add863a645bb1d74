// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rig.h"

#include <Eigen/SVD>

#include "slim_init/config/config.h"

namespace slim_init::tools {

Calibration eurocCalibration() {
  // T_BS of cam0/sensor.yaml, the same in every EuRoC sequence.
  Eigen::Matrix3d R_b_c;
  R_b_c << 0.0148655429818, -0.999880929698, 0.00414029679422,  //
      0.999557249008, 0.0149672133247, 0.025715529948,          //
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  // Twelve printed digits are a rotation to 1e-12 only; the nearest one is exact.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R_b_c, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Calibration calibration;
  calibration.R_b_c = svd.matrixU() * svd.matrixV().transpose();
  calibration.t_b_c = Eigen::Vector3d(-0.0216401454975, -0.064676986768, 0.00981073058949);
  calibration.focal_px = 458.0;  // between fx 458.654 and fy 457.296
  return calibration;
}

Calibration rigOf(const AbOptions& options) {
  if (options.config != nullptr) return options.config->calibration;
  return eurocCalibration();
}

simulation::PinholeCamera cameraOf(const AbOptions& options) {
  simulation::PinholeCamera camera = options.features.camera;
  if (options.config != nullptr) {
    const feature_tracker_lines::CameraParameters& from = options.config->camera;
    camera.width = from.width;
    camera.height = from.height;
    camera.fx = from.fx;
    camera.fy = from.fy;
    camera.cx = from.cx;
    camera.cy = from.cy;
  }
  return camera;
}

}  // namespace slim_init::tools
