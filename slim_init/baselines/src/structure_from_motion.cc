// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "structure_from_motion.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "geometry/so3.h"
#include "slim_init/text.h"

namespace slim_init::baselines {
namespace {

// The release counts pixels in a virtual camera of this focal length.
constexpr double kFocalPx = 460.0;

struct View {
  int keyframe = 0;
  Eigen::Vector2d uv;  // on the plane z = 1
};

// A track and its point in the frame of the reference camera.
struct Feature {
  std::vector<View> views;  // ascending in keyframe
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  bool known = false;

  const View* in(int keyframe) const {
    for (const View& view : views) {
      if (view.keyframe == keyframe) return &view;
    }
    return nullptr;
  }
};

// From the reference camera into camera k: x_k = R x + t.
struct Pose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

Eigen::Vector2d onPlane(const Eigen::Vector3d& bearing) { return bearing.hnormalized(); }

std::vector<Feature> featuresOf(const InitWindow& window) {
  std::vector<Feature> features;
  for (const Track& track : window.pointTracks()) {
    Feature feature;
    for (int s = track.begin; s < track.end; ++s) {
      const WindowPoint& observation = window.pointObservations()[s];
      if (observation.bearing.z() <= 0.0) continue;  // beyond a pinhole
      feature.views.push_back({observation.keyframe, onPlane(observation.bearing)});
    }
    if (feature.views.size() >= 2) features.push_back(feature);
  }
  return features;
}

// The points that two keyframes share.
struct CommonPoints {
  std::vector<cv::Point2d> l, r;
  double mean_motion = 0.0;  // on the plane z = 1
};

CommonPoints commonPoints(const std::vector<Feature>& features, int l, int r) {
  CommonPoints common;
  for (const Feature& feature : features) {
    const View* in_l = feature.in(l);
    const View* in_r = feature.in(r);
    if (in_l == nullptr || in_r == nullptr) continue;
    common.l.emplace_back(in_l->uv.x(), in_l->uv.y());
    common.r.emplace_back(in_r->uv.x(), in_r->uv.y());
    common.mean_motion += (in_l->uv - in_r->uv).norm();
  }
  if (!common.l.empty()) common.mean_motion /= static_cast<double>(common.l.size());
  return common;
}

// Relative pose by the five-point method in RANSAC, translation of unit length. Returns the number
// of inliers in front of both cameras.
int fivePointPose(const CommonPoints& common, const VinsOptions& options, Pose* pose) {
  const cv::Matx33d K = cv::Matx33d::eye();
  cv::Mat inliers, R, t;
  const cv::Mat E =
      cv::findEssentialMat(common.l, common.r, K, cv::RANSAC, options.ransac_confidence,
                           options.ransac_threshold_px / kFocalPx, inliers);
  if (E.rows != 3 || E.cols != 3) return 0;
  const int count = cv::recoverPose(E, common.l, common.r, K, R, t, inliers);
  cv::cv2eigen(R, pose->R);
  cv::cv2eigen(t, pose->t);
  return count;
}

// Linear triangulation (Hartley and Zisserman 2004, section 12.2); false at infinity.
bool triangulate(const Pose& a, const Eigen::Vector2d& uv_a, const Pose& b,
                 const Eigen::Vector2d& uv_b, Eigen::Vector3d* point) {
  Eigen::Matrix<double, 3, 4> P_a, P_b;
  P_a << a.R, a.t;
  P_b << b.R, b.t;
  Eigen::Matrix4d D;
  D << uv_a.x() * P_a.row(2) - P_a.row(0), uv_a.y() * P_a.row(2) - P_a.row(1),
      uv_b.x() * P_b.row(2) - P_b.row(0), uv_b.y() * P_b.row(2) - P_b.row(1);
  const Eigen::Vector4d X =
      Eigen::JacobiSVD<Eigen::Matrix4d>(D, Eigen::ComputeFullV).matrixV().col(3);
  *point = X.hnormalized();
  return point->allFinite();
}

// Parameter blocks of a pose.
struct PoseBlocks {
  std::array<double, 3> rotation, translation;
};

// Residual of a point in a camera, on the plane z = 1.
struct Reprojection {
  explicit Reprojection(const Eigen::Vector2d& measured) : uv(measured) {}
  template <typename T>
  bool operator()(const T* rotation, const T* translation, const T* point, T* residual) const {
    T x[3];
    ceres::AngleAxisRotatePoint(rotation, point, x);
    for (int i = 0; i < 3; ++i) x[i] += translation[i];
    residual[0] = x[0] / x[2] - T(uv.x());
    residual[1] = x[1] / x[2] - T(uv.y());
    return true;
  }
  Eigen::Vector2d uv;
};

class Reconstruction {
 public:
  Reconstruction(const InitWindow& window, const VinsOptions& options)
      : options_(options),
        features_(featuresOf(window)),
        last_(window.size() - 1),
        poses_(window.size()) {}

  // The first keyframe with enough common points with the newest, enough parallax to it and a
  // five-point pose.
  bool chooseReference(StructureFromMotion* out) {
    std::size_t most = 0;
    double largest_px = 0.0;
    int inliers = -1;
    for (int l = 0; l < last_; ++l) {
      const CommonPoints common = commonPoints(features_, l, last_);
      most = std::max(most, common.l.size());
      if (common.l.size() <= static_cast<std::size_t>(options_.min_common_points)) continue;
      const double motion_px = kFocalPx * common.mean_motion;
      largest_px = std::max(largest_px, motion_px);
      if (motion_px <= options_.min_parallax_px) continue;
      const int count = fivePointPose(common, options_, &poses_[last_]);
      inliers = std::max(inliers, count);
      if (count <= options_.min_pose_inliers) continue;
      reference_ = l;
      return true;
    }
    if (inliers >= 0) {
      return refuse(InitStatus::kTooFewTracks,
                    text("the five-point pose has at most ", inliers, " inliers (minimum ",
                         options_.min_pose_inliers + 1, ')'),
                    out);
    }
    if (most <= static_cast<std::size_t>(options_.min_common_points)) {
      return refuse(InitStatus::kTooFewTracks,
                    text("keyframes share at most ", most, " points with the newest (minimum ",
                         options_.min_common_points + 1, ')'),
                    out);
    }
    return refuse(InitStatus::kTooLittleExcitation,
                  text("mean motion of the tracks to the newest keyframe is at most ", largest_px,
                       " px (minimum ", options_.min_parallax_px, ')'),
                  out);
  }

  // Triangulation and PnP in turn, outwards from the reference.
  bool registerKeyframes(StructureFromMotion* out) {
    triangulateBetween(reference_, last_);
    for (int k = reference_ + 1; k < last_; ++k) {
      if (!registerKeyframe(k, poses_[k - 1], out)) return false;
      triangulateBetween(k, last_);
    }
    for (int k = reference_ + 1; k < last_; ++k) triangulateBetween(reference_, k);
    for (int k = reference_ - 1; k >= 0; --k) {
      if (!registerKeyframe(k, poses_[k + 1], out)) return false;
      triangulateBetween(k, reference_);
    }
    for (Feature& feature : features_) {
      if (!feature.known) triangulateFeature(&feature, feature.views.front(), feature.views.back());
    }
    return true;
  }

  // All poses and points; the reference camera is the origin, the newest one fixes the scale.
  bool adjust(StructureFromMotion* out) {
    // In one vector: Ceres orders blocks by their address, and equal input has to give equal bytes.
    std::vector<PoseBlocks> blocks(poses_.size());
    ceres::Problem problem;
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      Eigen::Map<Eigen::Vector3d>(blocks[k].rotation.data()) = logSO3(poses_[k].R);
      Eigen::Map<Eigen::Vector3d>(blocks[k].translation.data()) = poses_[k].t;
      problem.AddParameterBlock(blocks[k].rotation.data(), 3);
      problem.AddParameterBlock(blocks[k].translation.data(), 3);
      ordering->AddElementToGroup(blocks[k].rotation.data(), 1);
      ordering->AddElementToGroup(blocks[k].translation.data(), 1);
    }
    problem.SetParameterBlockConstant(blocks[reference_].rotation.data());
    problem.SetParameterBlockConstant(blocks[reference_].translation.data());
    problem.SetParameterBlockConstant(blocks[last_].translation.data());
    for (Feature& feature : features_) {
      if (!feature.known) continue;
      ++out->points;
      for (const View& view : feature.views) {
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Reprojection, 2, 3, 3, 3>(new Reprojection(view.uv)),
            nullptr, blocks[view.keyframe].rotation.data(),
            blocks[view.keyframe].translation.data(), feature.point.data());
      }
      ordering->AddElementToGroup(feature.point.data(), 0);
    }
    ceres::Solver::Options options;
    options.linear_solver_ordering.reset(ordering);
    options.linear_solver_type =
        ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::SUITE_SPARSE) ? ceres::SPARSE_SCHUR
                                                                              : ceres::DENSE_SCHUR;
    options.max_num_iterations = options_.max_iterations;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (summary.termination_type != ceres::CONVERGENCE &&
        !(summary.final_cost < options_.max_final_cost)) {
      return refuse(InitStatus::kNumericalFailure,
                    text("the bundle adjustment has not converged after ", options_.max_iterations,
                         " iterations and ends at a cost of ", summary.final_cost, " (limit ",
                         options_.max_final_cost, ')'),
                    out);
    }
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      poses_[k].R = expSO3(Eigen::Map<const Eigen::Vector3d>(blocks[k].rotation.data()));
      poses_[k].t = Eigen::Map<const Eigen::Vector3d>(blocks[k].translation.data());
    }
    out->rms_px = kFocalPx * std::sqrt(2.0 * summary.final_cost / summary.num_residuals);
    return true;
  }

  // Poses in the frame of the first camera.
  void handOver(StructureFromMotion* out) const {
    const Pose& first = poses_.front();
    out->centres_c0.resize(3, static_cast<Eigen::Index>(poses_.size()));
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Eigen::Matrix3d R_ref_ck = poses_[k].R.transpose();
      out->R_c0_ck.push_back(first.R * R_ref_ck);
      out->centres_c0.col(k) = first.R * (-R_ref_ck * poses_[k].t) + first.t;
    }
    out->status = InitStatus::kSuccess;
  }

 private:
  static bool refuse(InitStatus status, const std::string& message, StructureFromMotion* out) {
    out->status = status;
    out->message = message;
    return false;
  }

  void triangulateFeature(Feature* feature, const View& a, const View& b) const {
    feature->known =
        triangulate(poses_[a.keyframe], a.uv, poses_[b.keyframe], b.uv, &feature->point);
  }

  void triangulateBetween(int a, int b) {
    for (Feature& feature : features_) {
      if (feature.known) continue;
      const View* in_a = feature.in(a);
      const View* in_b = feature.in(b);
      if (in_a != nullptr && in_b != nullptr) triangulateFeature(&feature, *in_a, *in_b);
    }
  }

  // Pose of a keyframe from its known points, starting at that of its neighbour.
  bool registerKeyframe(int k, const Pose& neighbour, StructureFromMotion* out) {
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> images;
    for (const Feature& feature : features_) {
      const View* view = feature.known ? feature.in(k) : nullptr;
      if (view == nullptr) continue;
      points.emplace_back(feature.point.x(), feature.point.y(), feature.point.z());
      images.emplace_back(view->uv.x(), view->uv.y());
    }
    if (points.size() < static_cast<std::size_t>(options_.min_pnp_points)) {
      return refuse(InitStatus::kTooFewTracks,
                    text("keyframe ", k, " sees ", points.size(), " reconstructed points (minimum ",
                         options_.min_pnp_points, ')'),
                    out);
    }
    Eigen::Vector3d theta = logSO3(neighbour.R);
    cv::Mat rotation, translation;
    cv::eigen2cv(theta, rotation);
    cv::eigen2cv(neighbour.t, translation);
    const bool solved = cv::solvePnP(points, images, cv::Matx33d::eye(), cv::noArray(), rotation,
                                     translation, true, cv::SOLVEPNP_ITERATIVE);
    cv::cv2eigen(rotation, theta);
    cv::cv2eigen(translation, poses_[k].t);
    poses_[k].R = expSO3(theta);
    if (solved && poses_[k].R.allFinite() && poses_[k].t.allFinite()) return true;
    return refuse(InitStatus::kNumericalFailure,
                  text("PnP of keyframe ", k, " with ", points.size(), " points has no solution"),
                  out);
  }

  const VinsOptions& options_;
  std::vector<Feature> features_;
  int last_;
  int reference_ = 0;
  std::vector<Pose> poses_;
};

}  // namespace

StructureFromMotion reconstruct(const InitWindow& window, const VinsOptions& options) {
  StructureFromMotion out;
  Reconstruction reconstruction(window, options);
  try {
    if (reconstruction.chooseReference(&out) && reconstruction.registerKeyframes(&out) &&
        reconstruction.adjust(&out)) {
      reconstruction.handOver(&out);
    }
  } catch (const cv::Exception& exception) {
    out.status = InitStatus::kNumericalFailure;
    out.message = "OpenCV: " + exception.err;
  }
  return out;
}

}  // namespace slim_init::baselines
