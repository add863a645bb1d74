// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Pictures of a scene: POV-Ray draws them, the lens and the sensor are ours.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/simulation/scene.h"

namespace slim_init::simulation {

/// Where a camera stands.
struct CameraPose {
  Eigen::Matrix3d R_w_c = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_w_c = Eigen::Vector3d::Zero();  ///< [m]
};

/// How POV-Ray draws.
struct RenderOptions {
  int threads = 1;
  std::string program = "povray";
  /// Folder for the scene file and for pictures between POV-Ray and us; made when it is missing. A
  /// folder of its own is made in it, and removed at the end.
  std::string work_directory = ".";
};

/// The picture that POV-Ray draws: equidistant (pixels per angle from the axis are constant), so
/// that any lens up to 175 deg from corner to corner is drawn with few unused pixels. The lens is
/// applied afterwards by resampling.
struct EquidistantView {
  int width = 0;            ///< [px]
  int height = 0;           ///< [px]
  double px_per_rad = 0.0;  ///< from the optical axis
  double full_angle_rad = 0.0;

  /// Position of a direction in c, pixel centres at whole numbers.
  Eigen::Vector2d project(const Eigen::Vector3d& direction) const;
};

/// The smallest view in which every pixel of the camera lies, with a margin of two pixels. False
/// and a message when a pixel has no ray or one beyond 87.5 deg from the axis.
bool makeEquidistantView(const feature_tracker_lines::Camera& camera, EquidistantView* view,
                         std::string* error);

/// The scene and the camera at every pose as POV-Ray text, one frame of the animation per pose.
std::string povrayText(const Scene& scene, const EquidistantView& view,
                       const std::vector<CameraPose>& poses);

/// Whether the program can be started; if not, `error` says what to install.
bool povrayAvailable(const std::string& program, std::string* error);

/// One animation run of POV-Ray as a child process, and its pictures one by one as they are done.
class Renderer {
 public:
  /// Starts the run. Null and a message in `error` when options, scene or camera are refused or
  /// the program cannot be started.
  static std::unique_ptr<Renderer> start(const Scene& scene,
                                         const feature_tracker_lines::CameraParameters& camera,
                                         const std::vector<CameraPose>& poses,
                                         const RenderOptions& options, std::string* error);
  /// Ends the child process if it still runs, and removes its files.
  virtual ~Renderer() = default;

  /// Waits for the picture at the next pose: radiance on the sensor behind the lens, CV_32FC1, 1 is
  /// a white wall in full light. Empty and a message with POV-Ray's last lines when
  /// it failed, or when all poses are done.
  virtual cv::Mat next(std::string* error) = 0;
};

/// The image of a rolling shutter from pictures (all CV_32FC1 of one size) at equal steps of time:
/// picture i of N is what the middle row of the i-th of N equal bands of rows sees. Rows between
/// two of these are blended linearly, so that an edge is not broken where bands meet; above the
/// first and below the last there is one picture alone. One picture is the image.
cv::Mat mergeBands(const std::vector<cv::Mat>& pictures);

/// The sensor. The defaults resemble EuRoC's MT9M034 indoors.
struct SensorOptions {
  double blur_px = 0.5;            ///< standard deviation of the lens's point spread [px]
  double vignetting = 0.25;        ///< fraction of the light lost in the corners
  double exposure_swing = 0.1;     ///< largest relative change of the exposure
  double exposure_period_s = 7.0;  ///< of that change, a sine [s]
  double read_noise = 1.5;         ///< standard deviation in the dark [grey levels]
  double shot_noise = 0.04;        ///< variance per grey level of signal [grey levels]
  unsigned seed = 1;
};

/// Image that the sensor makes of a radiance picture (CV_32FC1) at time t [s]: CV_8UC1. Noise
/// depends on the seed and on `index`, the number of the image.
cv::Mat expose(const cv::Mat& radiance, std::int64_t index, double t, const SensorOptions& options);

}  // namespace slim_init::simulation
