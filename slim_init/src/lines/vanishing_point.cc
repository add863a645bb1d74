// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Vote and refine for one keyframe (paper IV-B-1).
#include "lines/vanishing_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "data/clean_frame.h"
#include "geometry/robust.h"
#include "geometry/units.h"
#include "imu/preintegration.h"

namespace slim_init {
namespace {

// The longest lines of a keyframe, of which every two give a direction to vote for. Of a direction
// that a fifth of the lines share eight are among them.
constexpr int kIntersectedLines = 40;
// Rounds of selecting inliers and fitting. Two suffice as a rule, the set then repeats itself.
constexpr int kMaxRounds = 4;
// The direction d is held, across the sphere, by how far the planes differ: least along the second
// eigenvector v of the mean of w n n^T, whose eigenvalue l2 is the mean square of n . v. Against
// it stand the mean square error of n . d and of n . v, as expected from the noise of the end
// points, and l1, the mean square of what the fit leaves of n . d. At ten times each of them
// - the standard deviation of d along v, about sqrt(var(n . d) / (m l2)) for m lines, is below
//   0.32 / sqrt(m) rad, small enough for the first order on which the
//   covariance rests, and
// - at most a tenth of l2 is noise that poses as conditioning. Below, the planes are one bundle of
// near-parallel image lines and d lies anywhere along v.
constexpr double kMinDetermination = 10.0;
// The same for noise-free input: planes that differ by less differ by nothing an image can show.
constexpr double kMinPlaneSpread = kSmallestAngle * kSmallestAngle;  // [rad^2]

// ------------------------------------------------------------------------------------------------
// Voting.

// The lines that take part, the longest first; of equals in an order that the lines alone decide,
// so that votes, sums of float, and ties do not depend on the order in which they are handed in.
std::vector<WindowLine> longestFirst(const std::vector<WindowLine>& lines) {
  std::vector<WindowLine> voting;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(voting),
               [](const WindowLine& line) { return line.length_px > 0.0; });
  const auto key = [](const WindowLine& line) {
    return std::make_tuple(-line.length_px, line.normal.x(), line.normal.y(), line.normal.z());
  };
  std::sort(voting.begin(), voting.end(),
            [&](const WindowLine& a, const WindowLine& b) { return key(a) < key(b); });
  return voting;
}

// The direction with the most votes among those in which two of the longest lines meet, the first
// of equals; zero where no two differ.
Eigen::Vector3d mostVotedDirection(const std::vector<WindowLine>& lines, double threshold_rad) {
  const int rivals = std::min(static_cast<int>(lines.size()), kIntersectedLines);
  std::vector<float> x, y, z;
  for (int a = 0; a < rivals; ++a) {
    for (int b = 0; b < a; ++b) {
      const Eigen::Vector3d meeting = lines[a].normal.cross(lines[b].normal);
      if (!(meeting.squaredNorm() > kMinPlaneSpread)) continue;
      const Eigen::Vector3f direction = meeting.normalized().cast<float>();
      x.push_back(direction.x());
      y.push_back(direction.y());
      z.push_back(direction.z());
    }
  }
  if (x.empty()) return Eigen::Vector3d::Zero();
  const auto sin_threshold = static_cast<float>(std::sin(threshold_rad));
  std::vector<float> votes(x.size(), 0.0F);
  for (const WindowLine& line : lines) {
    const Eigen::Vector3f normal = line.normal.cast<float>();
    const auto weight = static_cast<float>(line.length_px);
    for (std::size_t k = 0; k < votes.size(); ++k) {
      const float error = std::fabs(normal.x() * x[k] + normal.y() * y[k] + normal.z() * z[k]);
      votes[k] += error < sin_threshold ? weight : 0.0F;
    }
  }
  const auto best = std::max_element(votes.begin(), votes.end()) - votes.begin();
  return {x[best], y[best], z[best]};
}

// ------------------------------------------------------------------------------------------------
// Refinement.

// Variance of n . d over the square of the end point noise, for noise of both end points across the
// line. The normal n keeps s and e, so with d = a s + b e in the plane n . d errs by a times the
// noise of s and b times that of e, hence a^2 + b^2: 1/2 in the middle of the segment, large for a
// short segment far from d. Of a d off the plane it takes the projection.
double errorAmplification(const WindowLine& line, const Eigen::Vector3d& d) {
  const double cosine = line.start_bearing.dot(line.end_bearing);
  const double d_s = d.dot(line.start_bearing);
  const double d_e = d.dot(line.end_bearing);
  const double a_numerator = d_s - cosine * d_e;
  const double b_numerator = d_e - cosine * d_s;
  const double squared_sine =
      std::max((1.0 - cosine) * (1.0 + cosine), kMinLineAngle * kMinLineAngle);
  return (a_numerator * a_numerator + b_numerator * b_numerator) / (squared_sine * squared_sine);
}

void selectInliers(const std::vector<WindowLine>& lines, const Eigen::Vector3d& direction,
                   double sin_threshold, std::vector<int>& inliers) {
  inliers.clear();
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (lines[l].length_px > 0.0 && std::abs(lines[l].normal.dot(direction)) < sin_threshold) {
      inliers.push_back(static_cast<int>(l));
    }
  }
}

// Eigenvalues ascending and eigenvectors of sum w n n^T / sum w, w = length.
using NormalScatter = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>;

NormalScatter scatterOfNormals(const std::vector<WindowLine>& lines,
                               const std::vector<int>& inliers) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double weight_sum = 0.0;
  for (const int l : inliers) {
    scatter += (lines[l].length_px * lines[l].normal) * lines[l].normal.transpose();
    weight_sum += lines[l].length_px;
  }
  return NormalScatter(scatter / weight_sum);
}

bool isDetermined(const std::vector<WindowLine>& lines, const std::vector<int>& inliers,
                  const NormalScatter& scatter, double sigma_line_rad) {
  double noise_direction = 0.0;
  double noise_weakest = 0.0;
  double weight_sum = 0.0;
  for (const int l : inliers) {
    const double weight = lines[l].length_px;
    noise_direction += weight * errorAmplification(lines[l], scatter.eigenvectors().col(0));
    noise_weakest += weight * errorAmplification(lines[l], scatter.eigenvectors().col(1));
    weight_sum += weight;
  }
  const double expected =
      sigma_line_rad * sigma_line_rad / weight_sum * std::max(noise_direction, noise_weakest);
  const double error = std::max(expected, scatter.eigenvalues()[0]);
  return scatter.eigenvalues()[1] >= std::max(kMinDetermination * error, kMinPlaneSpread);
}

// Sandwich A^+ B A^+ of the length-weighted fit: A = sum w n n^T over the tangent plane (less its
// smallest eigenvalue, the curvature of the sphere), B = sum w^2 var(n . d) n n^T.
Eigen::Matrix3d covarianceOfDirection(const std::vector<WindowLine>& lines,
                                      const std::vector<int>& inliers, const NormalScatter& scatter,
                                      double sigma_line_rad) {
  const Eigen::Vector3d direction = scatter.eigenvectors().col(0);
  const Eigen::Matrix<double, 3, 2> tangent = scatter.eigenvectors().rightCols<2>();
  Eigen::Matrix2d b = Eigen::Matrix2d::Zero();
  double weight_sum = 0.0;
  for (const int l : inliers) {
    const Eigen::Vector2d normal = tangent.transpose() * lines[l].normal;
    const double weight = lines[l].length_px;
    b += (weight * weight * errorAmplification(lines[l], direction)) * normal * normal.transpose();
    weight_sum += weight;
  }
  b *= (sigma_line_rad / weight_sum) * (sigma_line_rad / weight_sum);
  const Eigen::Vector2d curvature =
      (scatter.eigenvalues().tail<2>().array() - scatter.eigenvalues()[0]).matrix();
  const Eigen::Matrix<double, 3, 2> gain = tangent * curvature.cwiseInverse().asDiagonal();
  return gain * b * gain.transpose();
}

// The axis nearest to `direction`, up to sign, that is within the threshold; -1 if none is.
int nearestAxis(const std::vector<Eigen::Vector3d>& axes_c0, const Eigen::Vector3d& direction_c0,
                double cos_threshold) {
  int nearest = -1;
  double largest_cosine = cos_threshold;
  for (std::size_t axis = 0; axis < axes_c0.size(); ++axis) {
    const double cosine = std::abs(axes_c0[axis].dot(direction_c0));
    if (cosine >= largest_cosine && (nearest < 0 || cosine > largest_cosine)) {
      nearest = static_cast<int>(axis);
      largest_cosine = cosine;
    }
  }
  return nearest;
}

}  // namespace

VanishingPoint estimateVanishingPoint(const std::vector<WindowLine>& lines, double sigma_line_rad,
                                      const VanishingPointOptions& options) {
  VanishingPoint vp;
  const auto min_inliers = static_cast<std::size_t>(options.min_inliers);
  const std::vector<WindowLine> voting = longestFirst(lines);
  if (voting.size() < min_inliers) return vp;

  const double vote_threshold_rad = options.vote_threshold_deg / kDegPerRad;
  Eigen::Vector3d direction = mostVotedDirection(voting, vote_threshold_rad);
  if (direction.isZero()) return vp;

  // The first fit takes the lines that voted: two lines may meet as far from the vanishing point as
  // t_in. Later ones take the inliers of the fit before.
  const double sin_inlier = std::sin(options.inlier_threshold_deg / kDegPerRad);
  std::vector<int> inliers;
  selectInliers(lines, direction, std::sin(vote_threshold_rad), inliers);
  if (inliers.size() < min_inliers) return vp;
  NormalScatter scatter = scatterOfNormals(lines, inliers);
  std::vector<int> selected;
  for (int round = 0; round < kMaxRounds; ++round) {
    direction = scatter.eigenvectors().col(0);
    selectInliers(lines, direction, sin_inlier, selected);
    if (selected.size() < min_inliers) return vp;
    if (selected == inliers) break;
    inliers.swap(selected);
    scatter = scatterOfNormals(lines, inliers);
  }
  direction = scatter.eigenvectors().col(0);
  if (!isDetermined(lines, inliers, scatter, sigma_line_rad)) return vp;

  vp.found = true;
  vp.direction = direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
  vp.covariance = covarianceOfDirection(lines, inliers, scatter, sigma_line_rad);
  vp.inliers = std::move(inliers);
  return vp;
}

std::vector<VanishingPoint> trackVanishingPoints(const InitWindow& window,
                                                 const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                                 const VanishingPointOptions& options) {
  std::vector<VanishingPoint> vps(static_cast<std::size_t>(window.size()));
  if (R_c0_ck.size() != vps.size()) return vps;
  const double sigma_line_rad = window.calibration().sigmaLine();
  const double cos_threshold = std::cos(options.match_threshold_deg / kDegPerRad);

  std::vector<Eigen::Vector3d> axes_c0;  // last observation of each id, the index being the id
  for (int k = 0; k < window.size(); ++k) {
    VanishingPoint& vp = vps[k];
    vp = estimateVanishingPoint(window.linesOfKeyframe(k), sigma_line_rad, options);
    if (!vp.found) continue;
    const Eigen::Vector3d direction_c0 = R_c0_ck[k] * vp.direction;

    vp.track_id = nearestAxis(axes_c0, direction_c0, cos_threshold);
    if (vp.track_id < 0) {
      vp.track_id = static_cast<int>(axes_c0.size());
      axes_c0.emplace_back();
    }
    axes_c0[vp.track_id] = direction_c0;
    vp.age = k > 0 && vps[k - 1].track_id == vp.track_id ? vps[k - 1].age + 1 : 1;
  }
  return vps;
}

std::vector<VanishingPoint> trackVanishingPoints(const InitWindow& window,
                                                 const VanishingPointOptions& options) {
  const std::vector<Preintegration> predicted = preintegrateWindow(
      window, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), PreintegrationParts::kRotation);
  return trackVanishingPoints(
      window, cameraRotations(chainRotations(predicted), window.calibration().R_b_c), options);
}

}  // namespace slim_init
