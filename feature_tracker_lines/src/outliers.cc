// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <utility>

namespace slim_init::feature_tracker_lines {
namespace {

// Nine draws find two inliers among 75 % with probability 0.999; noise and nearly parallel planes
// spoil many more.
constexpr int kHypotheses = 120;
constexpr int kPolishRounds = 4;
// Norm of a hypothesis below which its two planes differ by rounding alone.
constexpr double kLeastNorm = 1e-16;
// Polishing: Cauchy scale and cut-off of the weights, as shares of the threshold.
constexpr double kPolishScale = 0.5, kPolishCut = 2.0;
constexpr double kLeastForward = 0.26;  // cos(75 deg): rays further off the axis are not checked
// cv::findFundamentalMat: pairs that it takes, and its confidence.
constexpr std::size_t kLeastPairs = 8;
constexpr double kConfidence = 0.99;
// Three views: parallax of a point that can be judged [px], how many of them it takes, and the
// deviation that makes a track an outlier, in standard deviations.
constexpr double kLeastParallaxPx = 2.0;
constexpr std::size_t kLeastTelling = 8;
constexpr double kOutlierSigmas = 3.0;
constexpr double kSigmaOfMedian = 1.4826;  // Gaussian: standard deviation over median magnitude
// Near the epipole the parallax is known no better than to rounding.
constexpr double kLeastUnit = 1e-9, kLeastLever = 1e-6;

using Rays = std::vector<Eigen::Vector3d>;

// Sampson distances of all pairs to the epipolar planes through e [rad].
struct Pairs {
  Pairs(const Rays& rotated_before, const Rays& now) {
    const auto n = static_cast<Eigen::Index>(now.size());
    a.resize(3, n);
    b.resize(3, n);
    m.resize(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      a.col(i) = rotated_before[k];
      b.col(i) = now[k];
      m.col(i) = rotated_before[k].cross(now[k]);
    }
  }

  Eigen::Matrix3Xd a, b, m;  // rays before (rotated) and now, a x b

  void distances(const Eigen::Vector3d& e, Eigen::ArrayXd* out) const {
    // |e x a|^2 = 1 - (e.a)^2 for unit vectors.
    const Eigen::ArrayXd ea = (e.transpose() * a).transpose().array();
    const Eigen::ArrayXd eb = (e.transpose() * b).transpose().array();
    const Eigen::ArrayXd em = (e.transpose() * m).transpose().array();
    *out = em.abs() / (2.0 - ea.square() - eb.square() + 1e-18).sqrt();
  }
};

// Pseudo-random numbers from a fixed seed: equal inputs give equal answers.
class Draw {
 public:
  int below(int n) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<int>(((state_ >> 32) * static_cast<std::uint32_t>(n)) >> 32);
  }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15ULL;
};

// A direction of translation, with the distance of each pair and their truncated sum.
struct Hypothesis {
  Eigen::Vector3d e = Eigen::Vector3d::Zero();
  Eigen::ArrayXd distance;  // [rad]
  double cost = std::numeric_limits<double>::infinity();
};

// Takes `e` over if it is better than the best so far; false otherwise.
bool takeBetter(const Pairs& pairs, const Eigen::Vector3d& e, double threshold, Hypothesis* best) {
  Eigen::ArrayXd distance(pairs.m.cols());
  pairs.distances(e, &distance);
  const double cost = distance.min(threshold).sum();
  if (!(cost < best->cost)) return false;
  best->cost = cost;
  best->e = e;
  best->distance = std::move(distance);
  return true;
}

// The best of kHypotheses draws of two pairs. Its cost is infinite where no two planes differ.
Hypothesis sampleEpipole(const Pairs& pairs, double threshold) {
  Draw draw;
  Hypothesis best;
  const int n = static_cast<int>(pairs.m.cols());
  for (int h = 0; h < kHypotheses; ++h) {
    const int i = draw.below(n);
    const int j = draw.below(n);
    const Eigen::Vector3d e = pairs.m.col(i).cross(pairs.m.col(j));
    const double norm = e.norm();
    if (norm > kLeastNorm) takeBetter(pairs, e / norm, threshold, &best);  // not for i == j
  }
  return best;
}

// Re-weighted least squares while it lowers the cost.
void polish(const Pairs& pairs, double focal_px, double threshold_px, Hypothesis* best) {
  const double threshold = threshold_px / focal_px;
  const double inverse_scale = focal_px / (kPolishScale * threshold_px);
  for (int round = 0; round < kPolishRounds; ++round) {
    Eigen::ArrayXd weight = 1.0 / (1.0 + (best->distance * inverse_scale).square());
    weight = (best->distance < kPolishCut * threshold).select(weight, 0.0);
    const Eigen::Matrix3d M = pairs.m * weight.matrix().asDiagonal() * pairs.m.transpose();
    const Eigen::Vector3d e =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(M).eigenvectors().col(0);
    if (!takeBetter(pairs, e, threshold, best)) break;
  }
}

}  // namespace

EpipoleFit knownRotationInliers(const Rays& rotated_before, const Rays& now, double focal_px,
                                double threshold_px) {
  EpipoleFit fit;
  fit.flags.assign(now.size(), 1);
  if (now.size() < 3) return fit;
  const Pairs pairs(rotated_before, now);
  const double threshold = threshold_px / focal_px;  // [rad]
  Hypothesis best = sampleEpipole(pairs, threshold);
  // Nothing moves: no pair is contradicted.
  if (!std::isfinite(best.cost)) return fit;
  polish(pairs, focal_px, threshold_px, &best);
  for (std::size_t i = 0; i < now.size(); ++i) {
    fit.flags[i] = best.distance[static_cast<Eigen::Index>(i)] <= threshold ? 1 : 0;
  }
  fit.epipole = best.e;
  return fit;
}

namespace {

// The sign of the epipole for which distances are positive: a x b = (e x b) / distance.
Eigen::Vector3d oriented(const Eigen::Vector3d& e, const Rays& before, const Rays& now) {
  double votes = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Eigen::Vector3d m = before[i].cross(now[i]);
    votes += m.dot(e.cross(now[i])) > 0.0 ? m.norm() : -m.norm();
  }
  return votes < 0.0 ? Eigen::Vector3d(-e) : e;
}

// Parallax along the epipolar line [rad], and that of a point at unit inverse distance.
struct Along {
  double parallax = 0.0, unit = 0.0;
};
Along alongOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& e) {
  const Eigen::Vector3d side = e.cross(b);
  const double unit = side.norm();
  return {unit > kLeastUnit ? a.cross(b).dot(side) / unit : 0.0, unit};
}

// Parallax of all points in one pair of views.
struct View {
  View(const Rays& first, const Rays& now, double focal_px, double threshold_px) {
    EpipoleFit fit = knownRotationInliers(first, now, focal_px, threshold_px);
    const Eigen::Vector3d e = oriented(fit.epipole, first, now);
    for (std::size_t i = 0; i < now.size(); ++i) along.push_back(alongOf(first[i], now[i], e));
    flags = std::move(fit.flags);
  }
  std::vector<unsigned char> flags;
  std::vector<Along> along;
};

// Points that moved far enough in both pairs of views to be judged.
std::size_t countTelling(const Rays& first, const Rays& second, const Rays& third,
                         double least_parallax) {
  std::size_t telling = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const bool tells = first[i].cross(second[i]).norm() > least_parallax &&
                       first[i].cross(third[i]).norm() > least_parallax;
    telling += tells ? 1 : 0;
  }
  return telling;
}

// Ratio of the translations' lengths, third view over second: median over the points, weighted by
// their parallax. NaN where too few points tell.
double translationRatio(const View& second, const View& third, double least_parallax) {
  std::vector<std::pair<double, double>> ratios;  // and weight
  double weights = 0.0;
  for (std::size_t i = 0; i < second.along.size(); ++i) {
    if (second.flags[i] == 0 || third.flags[i] == 0) continue;
    const Along& two = second.along[i];
    const Along& three = third.along[i];
    if (!(two.parallax > least_parallax && three.parallax > least_parallax)) continue;
    ratios.emplace_back(three.parallax * two.unit / (three.unit * two.parallax), two.parallax);
    weights += two.parallax;
  }
  if (ratios.size() < kLeastTelling) return std::numeric_limits<double>::quiet_NaN();
  std::sort(ratios.begin(), ratios.end());
  double sum = 0.0;
  for (const auto& [value, weight] : ratios) {
    sum += weight;
    if (!(sum < 0.5 * weights)) return value;
  }
  return ratios.back().first;
}

}  // namespace

std::vector<unsigned char> threeViewInliers(const Rays& first, const Rays& second,
                                            const Rays& third, double focal_px, double threshold_px,
                                            double least_px) {
  const std::size_t n = first.size();
  const double least_parallax = kLeastParallaxPx / focal_px;
  std::vector<unsigned char> inlier(n, 1);
  if (countTelling(first, second, third, least_parallax) < kLeastTelling) return inlier;
  const View two(first, second, focal_px, threshold_px);
  const View three(first, third, focal_px, threshold_px);
  const double ratio = translationRatio(two, three, least_parallax);
  if (!std::isfinite(ratio)) return inlier;

  std::vector<double> difference_px(n), magnitudes;
  for (std::size_t i = 0; i < n; ++i) {
    const double lever = ratio * three.along[i].unit / std::max(two.along[i].unit, kLeastLever);
    difference_px[i] = std::abs(three.along[i].parallax - lever * two.along[i].parallax) *
                       focal_px / std::sqrt(1.0 + lever * lever);
    inlier[i] = two.flags[i] != 0 && three.flags[i] != 0 ? 1 : 0;
    if (inlier[i] != 0) magnitudes.push_back(difference_px[i]);
  }
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  const double largest_px =
      std::min(threshold_px, std::max(least_px, kOutlierSigmas * kSigmaOfMedian * *middle));
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
  if (index.size() < kLeastPairs) return inlier;
  std::vector<unsigned char> status;
  cv::findFundamentalMat(p, q, cv::FM_RANSAC, threshold_px, kConfidence, status);
  // No matrix at all, for example because all points lie on a line.
  if (status.size() != index.size()) return inlier;
  for (std::size_t k = 0; k < index.size(); ++k) inlier[index[k]] = status[k] != 0 ? 1 : 0;
  return inlier;
}

}  // namespace slim_init::feature_tracker_lines
