// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <utility>

namespace slim_init::feature_tracker_lines {
namespace {

// 0.999 of finding two inliers among 75 % takes 9; noise and near-parallel pairs spoil many more.
constexpr int kHypotheses = 120;
constexpr int kPolishRounds = 4;
constexpr double kLeastForward = 0.26;  // cos(75 deg)
constexpr double kLeastParallaxPx = 2.0;
constexpr std::size_t kLeastTelling = 8;

// Sampson distances of all pairs to the epipolar planes through e [rad].
struct Pairs {
  Eigen::Matrix3Xd a, b, m;  // rays before (rotated) and now, a x b

  void distances(const Eigen::Vector3d& e, Eigen::ArrayXd* out) const {
    // |e x a|^2 = 1 - (e.a)^2 for unit vectors.
    const Eigen::ArrayXd ea = (e.transpose() * a).transpose().array();
    const Eigen::ArrayXd eb = (e.transpose() * b).transpose().array();
    const Eigen::ArrayXd em = (e.transpose() * m).transpose().array();
    *out = em.abs() / (2.0 - ea.square() - eb.square() + 1e-18).sqrt();
  }
};

// Fixed start: equal inputs give equal answers.
class Draw {
 public:
  std::uint32_t below(std::uint32_t n) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::uint32_t>(((state_ >> 32) * n) >> 32);
  }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15ULL;
};

}  // namespace

std::vector<unsigned char> knownRotationInliers(const std::vector<Eigen::Vector3d>& rotated_before,
                                                const std::vector<Eigen::Vector3d>& now,
                                                double focal_px, double threshold_px,
                                                Eigen::Vector3d* epipole) {
  const int n = static_cast<int>(now.size());
  std::vector<unsigned char> inlier(now.size(), 1);
  if (epipole != nullptr) *epipole = Eigen::Vector3d::Zero();
  if (n < 3) return inlier;

  Pairs pairs;
  pairs.a.resize(3, n);
  pairs.b.resize(3, n);
  pairs.m.resize(3, n);
  for (int i = 0; i < n; ++i) {
    pairs.a.col(i) = rotated_before[static_cast<std::size_t>(i)];
    pairs.b.col(i) = now[static_cast<std::size_t>(i)];
    pairs.m.col(i) =
        rotated_before[static_cast<std::size_t>(i)].cross(now[static_cast<std::size_t>(i)]);
  }
  const double threshold = threshold_px / focal_px;

  Draw draw;
  Eigen::Vector3d best_e = Eigen::Vector3d::UnitZ();
  Eigen::ArrayXd distance(n), best_distance;
  double best_cost = std::numeric_limits<double>::infinity();
  for (int h = 0; h < kHypotheses; ++h) {
    const int i = static_cast<int>(draw.below(static_cast<std::uint32_t>(n)));
    const int j = static_cast<int>(draw.below(static_cast<std::uint32_t>(n)));
    Eigen::Vector3d e = pairs.m.col(i).cross(pairs.m.col(j));
    const double norm = e.norm();
    // Also where i == j. Below, the two planes differ by rounding alone.
    if (!(norm > 1e-16)) continue;
    e /= norm;
    pairs.distances(e, &distance);
    const double cost = distance.min(threshold).sum();
    if (cost < best_cost) {
      best_cost = cost;
      best_e = e;
      best_distance = distance;
    }
  }
  // Nothing moves: nothing speaks against any pair.
  if (!std::isfinite(best_cost)) return inlier;

  for (int round = 0; round < kPolishRounds; ++round) {
    // Cauchy weights at a pixel's scale; pairs far out have none.
    Eigen::ArrayXd weight =
        1.0 / (1.0 + (best_distance * (2.0 * focal_px / threshold_px)).square());
    weight = (best_distance < 2.0 * threshold).select(weight, 0.0);
    const Eigen::Matrix3d M = pairs.m * weight.matrix().asDiagonal() * pairs.m.transpose();
    const Eigen::Vector3d e =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(M).eigenvectors().col(0);
    pairs.distances(e, &distance);
    const double cost = distance.min(threshold).sum();
    if (!(cost < best_cost)) break;
    best_cost = cost;
    best_e = e;
    best_distance = distance;
  }
  for (int i = 0; i < n; ++i) inlier[static_cast<std::size_t>(i)] = best_distance[i] <= threshold;
  if (epipole != nullptr) *epipole = best_e;
  return inlier;
}

std::vector<unsigned char> threeViewInliers(const std::vector<Eigen::Vector3d>& first,
                                            const std::vector<Eigen::Vector3d>& second,
                                            const std::vector<Eigen::Vector3d>& third,
                                            double focal_px, double threshold_px, double least_px) {
  const std::size_t n = first.size();
  const std::vector<unsigned char> all(n, 1);
  const double least_parallax = kLeastParallaxPx / focal_px;
  std::size_t telling = 0;
  for (std::size_t i = 0; i < n; ++i) {
    telling += first[i].cross(second[i]).norm() > least_parallax &&
                       first[i].cross(third[i]).norm() > least_parallax
                   ? 1
                   : 0;
  }
  if (telling < kLeastTelling) return all;

  Eigen::Vector3d e_second, e_third;
  std::vector<unsigned char> inlier =
      knownRotationInliers(first, second, focal_px, threshold_px, &e_second);
  const std::vector<unsigned char> inlier_third =
      knownRotationInliers(first, third, focal_px, threshold_px, &e_third);
  // The camera moved such that distances are positive: a x b = (e x b) / distance.
  const auto orient = [&first](const std::vector<Eigen::Vector3d>& now, Eigen::Vector3d* e) {
    double votes = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Eigen::Vector3d m = first[i].cross(now[i]);
      votes += m.dot(e->cross(now[i])) > 0.0 ? m.norm() : -m.norm();
    }
    if (votes < 0.0) *e = -*e;
  };
  orient(second, &e_second);
  orient(third, &e_third);

  // Parallax along the epipolar line, and what a point at unit inverse distance would have.
  struct Along {
    double parallax, unit;
  };
  const auto along = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& e) {
    const Eigen::Vector3d side = e.cross(b);
    const double unit = side.norm();
    return Along{unit > 1e-9 ? a.cross(b).dot(side) / unit : 0.0, unit};
  };
  std::vector<std::pair<double, double>> ratios;  // of the translations' lengths, and weight
  double weights = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (inlier[i] == 0 || inlier_third[i] == 0) continue;
    const Along two = along(first[i], second[i], e_second);
    const Along three = along(first[i], third[i], e_third);
    if (!(two.parallax > least_parallax && three.parallax > least_parallax)) continue;
    ratios.emplace_back(three.parallax * two.unit / (three.unit * two.parallax), two.parallax);
    weights += two.parallax;
  }
  if (ratios.size() < kLeastTelling) return all;
  std::sort(ratios.begin(), ratios.end());
  double ratio = ratios.back().first, sum = 0.0;
  for (const auto& [value, weight] : ratios) {
    sum += weight;
    if (sum < 0.5 * weights) continue;
    ratio = value;
    break;
  }
  std::vector<double> difference_px(n), magnitudes;
  for (std::size_t i = 0; i < n; ++i) {
    const Along two = along(first[i], second[i], e_second);
    const Along three = along(first[i], third[i], e_third);
    // Near the epipole both are about nothing.
    const double lever = ratio * three.unit / std::max(two.unit, 1e-6);
    difference_px[i] =
        std::abs(three.parallax - lever * two.parallax) * focal_px / std::sqrt(1.0 + lever * lever);
    inlier[i] = inlier[i] != 0 && inlier_third[i] != 0 ? 1 : 0;
    if (inlier[i] != 0) magnitudes.push_back(difference_px[i]);
  }
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  constexpr double kSigmaOfMedian = 1.4826;
  const double largest_px =
      std::min(threshold_px, std::max(least_px, 3.0 * kSigmaOfMedian * *middle));
  for (std::size_t i = 0; i < n; ++i) {
    if (difference_px[i] > largest_px) inlier[i] = 0;
  }
  return inlier;
}

std::vector<unsigned char> fundamentalInliers(const std::vector<Eigen::Vector3d>& before,
                                              const std::vector<Eigen::Vector3d>& now,
                                              double focal_px, double threshold_px) {
  std::vector<unsigned char> inlier(now.size(), 1);
  std::vector<std::size_t> index;
  std::vector<cv::Point2f> p, q;
  const auto onPlane = [focal_px](const Eigen::Vector3d& f) {
    return cv::Point2f(static_cast<float>(focal_px * f.x() / f.z()),
                       static_cast<float>(focal_px * f.y() / f.z()));
  };
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!(before[i].z() > kLeastForward && now[i].z() > kLeastForward)) continue;
    index.push_back(i);
    p.push_back(onPlane(before[i]));
    q.push_back(onPlane(now[i]));
  }
  if (index.size() < 8) return inlier;
  std::vector<unsigned char> status;
  cv::findFundamentalMat(p, q, cv::FM_RANSAC, threshold_px, 0.99, status);
  // No matrix at all, for example because all points lie on a line.
  if (status.size() != index.size()) return inlier;
  for (std::size_t k = 0; k < index.size(); ++k) inlier[index[k]] = status[k] != 0 ? 1 : 0;
  return inlier;
}

}  // namespace slim_init::feature_tracker_lines
