// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Compared systems that need more than Eigen: `vins` and `openvins`, written from their papers with
// the parameters of their releases (docs/baselines.md). For comparisons only: nothing of the
// initializer depends on them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slim_init/options.h"
#include "slim_init/window_solver.h"

namespace slim_init::baselines {

/// Parameters of `vins`; the values of VINS-Mono's release. Its pixels are those of a virtual
/// camera of 460 px focal length.
struct VinsOptions {
  /// Fundamental matrix between consecutive keyframes [px]; a track that disagrees starts anew. 0
  /// leaves it out: the release has it, at 1 px, in its tracker, from image to image, and the
  /// tracks of a window have been through a front end (docs/baselines.md measures it).
  double tracking_threshold_px = 0.0;
  int min_common_points = 20;        ///< the reference keyframe shares more with the newest
  double min_parallax_px = 30.0;     ///< .. and their mean motion, rotation included, is above
  double ransac_threshold_px = 0.3;  ///< of the five-point pose
  double ransac_confidence = 0.99;   ///< of both consensus searches
  int min_pose_inliers = 12;         ///< the five-point pose needs more in front of both cameras
  int min_pnp_points = 10;           ///< known points that a keyframe needs to be registered
  int max_iterations = 50;           ///< of the bundle adjustment; the release ends it by time
  double max_final_cost = 5e-3;      ///< not converged, it may still end at this cost (z = 1 plane)
  double max_gravity_residual = 1.0;  ///< unconstrained |g| against its true value [m/s^2]

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

/// Parameters of `openvins`; the values of OpenVINS' release for EuRoC.
struct OpenVinsOptions {
  /// Longest tracks used; 0 uses all. The release tracks 50 points an image to save time.
  int max_features = 0;
  int min_features = 8;            ///< tracks in front of the camera
  double min_rotation_deg = 10.0;  ///< summed rotation of the gyroscope, bias included; less waits
  double sigma_px = 1.0;           ///< standard deviation of an observation
  double cauchy_sigmas = 1.0;      ///< Cauchy scale of an observation, in standard deviations
  double gyro_bias_prior = 0.05;   ///< standard deviation about zero [rad/s]
  double accel_bias_prior = 0.10;  ///< standard deviation about zero [m/s^2]
  double gyro_walk = 1.9393e-5;    ///< random walk of the bias [rad/s^2/sqrt(Hz)]
  double accel_walk = 3.0e-3;      ///< random walk of the bias [m/s^3/sqrt(Hz)]
  int max_iterations = 50;  ///< of the refinement; 0 leaves it out, the release also at 0.05 s
  /// Further refinements with the IMU integrated anew at the refined biases; the release has none.
  int relinearizations = 1;
  double function_tolerance = 1e-5;  ///< relative decrease of the cost that ends it

  /// Returns an empty string, or a sentence naming the field, its value and the violated bound.
  std::string validate() const;
};

struct BaselineOptions {
  VinsOptions vins;
  OpenVinsOptions openvins;

  /// Returns an empty string, or the first sentence of a nested validate(), prefixed with the
  /// section.
  std::string validate() const;
};

/// Names accepted by makeBaseline(), in the order in which reports list them.
const std::vector<std::string>& baselineNames();

/// Makes a compared system by name. `initializer`: gates. Unknown name or invalid options: null,
/// and a sentence in `error`.
std::unique_ptr<WindowSolver> makeBaseline(const std::string& name,
                                           const InitializerOptions& initializer,
                                           const BaselineOptions& options = BaselineOptions(),
                                           std::string* error = nullptr);

}  // namespace slim_init::baselines
