// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Shi-Tomasi corners followed by pyramidal KLT, in the two profiles of FrontEndOptions.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "corner_detector.h"
#include "image_pyramid.h"
#include "patch_anchor.h"
#include "rotation_prior.h"
#include "slim_init/feature_tracker_lines/camera.h"
#include "slim_init/feature_tracker_lines/image_front_end.h"
#include "slim_init/feature_tracker_lines/options.h"
#include "slim_init/types.h"

namespace slim_init::feature_tracker_lines {

/// A tracked point.
struct PointTrack {
  FeatureId id = -1;
  int age = 1;  ///< images in which it was found under this id
  cv::Point2f pixel;
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();         ///< unit, in c
  Eigen::Vector3d bearing_before = Eigen::Vector3d::UnitZ();  ///< in the previous image
  cv::Point2f pixel_before;
  /// Motion since the previous image beyond what the rotation explains [px].
  cv::Point2f residual_flow;
  /// Rays at the last two marks of PointTracker, turned to the middle row of their image, the older
  /// first; how many of them there are.
  Eigen::Vector3d mark_rays[2] = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()};
  int marks = 0;
  bool has_flow = false;  ///< false in its first image
  /// Distance from where it was predicted in the last image [px].
  float surprise_px = std::numeric_limits<float>::infinity();
  std::shared_ptr<PatchAnchor> anchor;  ///< default profile only
  int anchor_misses = 0;                ///< images in a row without a match of the anchor
  bool recognised = false;              ///< found by its anchor alone in the last image
};

/// Follows points from image to image.
class PointTracker {
 public:
  PointTracker(const CameraParameters& camera, const FrontEndOptions& options);

  /// Tracks from `before` (empty for the first image) to `now`, rejects outliers, then fills up
  /// with new corners. `t` [s] is needed for HostFrontEnd::freq only. Writes the point part of
  /// `report`.
  void track(double t, const ImagePyramid& before, const ImagePyramid& now,
             const RotationPrior& prior, ImageReport* report);

  /// In a dark image with few points weaker ones are taken as well.
  void setDark(bool dark) { dark_ = dark; }

  /// Current points, oldest first.
  const std::vector<PointTrack>& tracks() const { return tracks_; }

  /// Median of residual_flow over the up to five nearest points that have one; zero if there are
  /// none.
  cv::Point2f residualFlowNear(const cv::Point2f& pixel) const;

  /// Whether most of the points that are tracked were where they had been predicted in the last
  /// image. With none: no.
  bool isSteady() const;

  /// Forgets all points. Ids are not reused.
  void reset();

 private:
  // Default profile.
  void trackDefault(const ImagePyramid& before, const ImagePyramid& now, const RotationPrior& prior,
                    ImageReport* report);
  std::vector<PointTrack> follow(const ImagePyramid& before, const ImagePyramid& now,
                                 const RotationPrior& prior) const;
  void deformAnchors(const RotationPrior& prior) const;
  bool recognise(const ImagePyramid& now, PointTrack* track) const;
  void anchorTracks(const ImagePyramid& now, std::vector<PointTrack>* moved);
  std::vector<unsigned char> findInliers(const std::vector<PointTrack>& moved,
                                         const RotationPrior& prior, ImageReport* report) const;
  int checkThreeViews(const RotationPrior& prior, std::vector<PointTrack>* moved);
  std::vector<unsigned char> threeViewFlags(const std::vector<PointTrack>& moved,
                                            const RowExposure& rows) const;
  void setMark(const RowExposure& rows, std::vector<PointTrack>* tracks);
  Eigen::Vector3d atMiddleRow(const RowExposure& rows, const Eigen::Vector3d& bearing,
                              const cv::Point2f& pixel) const;
  void refill(const ImagePyramid& now, ImageReport* report);
  void addCorners(const ImagePyramid& now, int wanted, double corner, double sigma, cv::Mat* mask);

  // Profile `vins`.
  void trackVins(double t, const ImagePyramid& before, const ImagePyramid& now,
                 ImageReport* report);
  std::vector<PointTrack> followVins(const ImagePyramid& before, const ImagePyramid& now) const;
  bool countPublished(double t);
  void rejectVins(std::vector<PointTrack>* moved, ImageReport* report) const;
  void refillVins(const ImagePyramid& now, ImageReport* report);

  /// Keeps the older of two points closer than `min_distance`; returns the mask for new ones.
  cv::Mat thinOut(double min_distance, double mask_distance);
  bool isInside(const cv::Point2f& pixel, double border) const;
  bool addTrack(const cv::Point2f& pixel);
  /// Moves a track to the pixel `to` of this image; under rotation alone it would be at
  /// `without_flow`. False where the camera model has no ray for `to`.
  bool advance(const cv::Point2f& to, const cv::Point2f& without_flow, PointTrack* track) const;

  Camera camera_;
  FrontEndOptions options_;
  double focal_px_ = 0.0;
  bool dark_ = false;
  cv::Mat usable_;  // image circle of a fisheye, or everything
  CornerDetector corners_;
  std::vector<PointTrack> tracks_;
  FeatureId next_id_ = 0;
  // Every few images a mark is made, at which each track remembers its ray.
  int images_since_mark_ = 0;
  Eigen::Matrix3d R_now_mark_ = Eigen::Matrix3d::Identity();    // of the newer mark
  Eigen::Matrix3d R_mark_older_ = Eigen::Matrix3d::Identity();  // from the older to the newer
  // HostFrontEnd::freq
  double t_count_start_ = kNotComputed;
  int published_ = 0;
};

}  // namespace slim_init::feature_tracker_lines
