// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Shi-Tomasi corners followed by pyramidal KLT, in the two profiles of FrontEndOptions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "corner_detector.h"
#include "image_pyramid.h"
#include "patch_anchor.h"
#include "row_camera.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "slim_init/feature_tracker_lines/options.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

inline Eigen::Vector2d toEigen(const cv::Point2f& p) { return {p.x, p.y}; }
inline cv::Point2f toPoint(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

/// A tracked point.
struct PointTrack {
  FeatureId id = -1;
  int age = 1;    ///< images in which it was found under this id
  int level = 0;  ///< of the pyramid on which it is followed; above 0 the image is too noisy
  cv::Point2f pixel;
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();         ///< unit, in c
  Eigen::Vector3d bearing_before = Eigen::Vector3d::UnitZ();  ///< in the previous image
  cv::Point2f pixel_before;
  /// Rays at the last two marks of PointTracker, turned to the middle row of their image, the older
  /// first; how many of them there are.
  Eigen::Vector3d mark_rays[2] = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()};
  int marks = 0;
  bool has_flow = false;  ///< false in its first image
  /// Distance from where it was predicted in the last image [px of its level].
  float surprise_px = std::numeric_limits<float>::infinity();
  std::shared_ptr<PatchAnchor> anchor;  ///< default profile only
  int anchor_misses = 0;                ///< images in a row without a match of the anchor
  bool recognised = false;              ///< found by its anchor alone in the last image
};

/// How the tracked points moved in the last image, for what moves beside them.
struct PointMotion {
  struct Flow {
    cv::Point2f pixel;     ///< in the last image
    cv::Point2f residual;  ///< motion since the image before, beyond what the rotation makes [px]
  };
  std::vector<Flow> flows;  ///< of the points that have one
  /// Whether most of these points were where they had been predicted, by a rotation of the same
  /// source as in the image before. With none: no.
  bool steady = false;

  /// Median of the residual flows of the up to five nearest points; zero if there are none.
  cv::Point2f flowNear(const cv::Point2f& pixel) const;
};

/// Follows points from image to image: follow() and then refill(), once for each image.
class PointTracker {
 public:
  PointTracker(const CameraParameters& camera, const FrontEndOptions& options);

  /// Tracks from `before` (empty for the first image) to `now` and rejects outliers and points too
  /// close to others. `before` gets the brightness of `now` (default profile), `prior` becomes the
  /// rotation that the points were found with. `t` [s] is needed for HostFrontEnd::freq only.
  /// Writes the point part of `report`, except for the new points.
  void follow(double t, ImagePyramid* before, const ImagePyramid& now, RotationPrior* prior,
              ImageReport* report);

  /// Fills up with new corners of the image that was followed to, and counts them in `report`.
  void refill(const ImagePyramid& now, ImageReport* report);

  /// Current points, oldest first.
  const std::vector<PointTrack>& tracks() const { return tracks_; }

  /// Motion of the points followed to the last image, beyond what the rotation `prior` makes.
  PointMotion motion(const RotationPrior& prior) const;

  /// Forgets all points. Ids are not reused.
  void reset();

 private:
  static constexpr int kLevels = 2;  // of the pyramid, on which points are followed
  using Levels = std::array<ImagePyramid, kLevels>;
  struct Target;

  // Default profile.
  void followDefault(ImagePyramid* before, const ImagePyramid& now, RotationPrior* prior,
                     ImageReport* report);
  std::vector<Target> expect(const RotationPrior& last, const RotationPrior& prior) const;
  std::vector<double> brightnessRatios(const std::vector<Target>& targets,
                                       const ImagePyramid& before, const ImagePyramid& now) const;
  void matchBrightness(const std::vector<Target>& targets, const ImagePyramid& now,
                       ImagePyramid* before) const;
  bool chooseRotation(const ImagePyramid& before, const ImagePyramid& now, RotationPrior* prior,
                      std::vector<Target>* targets) const;
  void turnTogether(const ImagePyramid& before, const ImagePyramid& now,
                    std::vector<Target>* targets) const;
  void searchLevel(int level, const ImagePyramid& before, const ImagePyramid& now,
                   const RotationPrior& prior, std::vector<Target>* targets) const;
  std::vector<PointTrack> search(const Levels& before, const Levels& now,
                                 const RotationPrior& prior, std::vector<Target> targets) const;
  void deformAnchors(const RotationPrior& prior) const;
  bool recognise(const ImagePyramid& now, PointTrack* track) const;
  void anchorTracks(const Levels& now, std::vector<PointTrack>* moved);
  std::vector<unsigned char> findInliers(const std::vector<PointTrack>& moved,
                                         const RotationPrior& prior, bool doubted,
                                         ImageReport* report) const;
  int checkThreeViews(const RotationPrior& prior, std::vector<PointTrack>* moved);
  std::vector<unsigned char> threeViewFlags(const std::vector<PointTrack>& moved,
                                            const RowCamera& lens) const;
  void setMark(const RowCamera& lens, std::vector<PointTrack>* tracks);
  void refillDefault(const ImagePyramid& now);
  void addCorners(const ImagePyramid& now, int level, int wanted);

  // Profile `vins`.
  void followVins(double t, const ImagePyramid& before, const ImagePyramid& now,
                  ImageReport* report);
  std::vector<PointTrack> searchVins(const ImagePyramid& before, const ImagePyramid& now) const;
  bool countPublished(double t);
  void rejectVins(std::vector<PointTrack>* moved, ImageReport* report) const;
  void refillVins(const ImagePyramid& now);

  /// Keeps the older of two points closer than `min_distance`, and masks the places that are closer
  /// than `mask_distance` to those kept.
  void thinOut(double min_distance, double mask_distance);
  bool isInside(const cv::Point2f& pixel, double border) const;
  bool addTrack(const cv::Point2f& pixel);
  /// Moves a track to the pixel `to` of this image. False where the camera model has no ray for it.
  bool advance(const cv::Point2f& to, PointTrack* track) const;
  /// Where what was seen at `pixel` before would be under the rotation alone.
  cv::Point2f turned(const RotationPrior& prior, const Eigen::Vector3d& bearing,
                     const cv::Point2f& pixel) const;

  Camera camera_;
  FrontEndOptions options_;
  double focal_px_ = 0.0;
  cv::Mat usable_;  // what the mask leaves, the image circle of a fisheye, or everything
  std::vector<CornerDetector> corners_;  // of each level
  std::vector<PointTrack> tracks_;
  cv::Mat mask_;  // where new points may be; empty: nowhere in this image
  FeatureId next_id_ = 0;
  RotationPrior last_prior_;  // of the last image, as the gyroscope gave it
  // Whether the rotation that the points were found with in the last image came from the gyroscope,
  // and whether that of the image before came from elsewhere: flows beyond them cannot be compared.
  bool was_measured_ = false, source_changed_ = false;
  // Now and then a mark is made, at which each track remembers its ray.
  double since_mark_s_ = 0.0;
  Eigen::Matrix3d R_now_mark_ = Eigen::Matrix3d::Identity();    // of the newer mark
  Eigen::Matrix3d R_mark_older_ = Eigen::Matrix3d::Identity();  // from the older to the newer
  // HostFrontEnd::freq
  double t_count_start_ = kNotComputed;
  int published_ = 0;
};

}  // namespace slim_init::feature_tracker_lines
