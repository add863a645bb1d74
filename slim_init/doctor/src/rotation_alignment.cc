// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "geometry/robust.h"
#include "reference_so3.h"
#include "rotation/free_rotations.h"
#include "slim_init/doctor/doctor.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/evaluation/truth.h"

namespace slim_init::evaluation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using namespace rotation_alignment;  // NOLINT: the bounds of this module

// From one image of a pair to the other, long enough to turn and short enough for tracks, and from
// the start of a pair to that of the next [s].
constexpr double kPairInterval = 0.2, kPairSpacing = 0.1;
// Images further apart make no pair; one over a longer step between samples is discarded [s].
constexpr double kMaxFrameGap = 0.35, kMaxImuGap = 0.06;
// Grid of the search for the offset, finer than any rotation changes [s].
constexpr double kOffsetStep = 0.005;
// Standard deviation of a rate beyond the noise of its own pair [rad/s].
constexpr double kRateSigma = 0.02;
// Weight of the configured rotation: enough to decide what the data leave open, too little to move
// what they determine.
constexpr double kTieBreak = 1e-3;

/// Two images, and how the camera turned from one to the other.
struct Pair {
  Pair(double begin, double end, const RelativeRotation& seen)
      : t_i(begin), t_j(end), dt(end - begin), residual(seen.residual), flow(seen.flow) {
    rate = reference::logSo3(seen.R_ci_cj) / dt;
    const Matrix3d covariance = (seen.information + 1e-6 * Matrix3d::Identity()).inverse();
    sigma = std::sqrt(covariance.trace() / 3.0) / dt;
    weight = 1.0 / (sigma * sigma + kRateSigma * kRateSigma);
  }
  double t_i, t_j, dt;
  double residual, flow;  // as RelativeRotation
  Vector3d rate;
  double sigma;   // of a component of `rate`
  double weight;  // without a robust one
};

/// Mean rate of the gyro, as if rotations were vectors; NaN without samples throughout.
Vector3d meanRate(const std::vector<ImuSample>& imu, double t0, double t1) {
  std::vector<InertialStep> steps;
  if (!inertialSteps(imu, t0, t1, kMaxImuGap, &steps)) return Vector3d::Constant(kNotComputed);
  Vector3d angle = Vector3d::Zero();
  for (const InertialStep& step : steps) angle += step.dt * step.gyro;
  return angle / (t1 - t0);
}

PairPoints commonPoints(const FrameObservation& i, const FrameObservation& j) {
  std::unordered_map<FeatureId, const PointObservation*> in_i;
  for (const PointObservation& p : i.points) {
    if (p.bearing.allFinite()) in_i.emplace(p.id, &p);
  }
  PairPoints common;
  for (const PointObservation& p : j.points) {
    const auto found = in_i.find(p.id);
    if (found == in_i.end() || !p.bearing.allFinite()) continue;
    common.add(found->second->bearing, p.bearing);
  }
  return common;
}

/// Pairs of about the interval asked for, shorter where tracks end sooner.
std::vector<Pair> measurePairs(const std::vector<FrameObservation>& frames, double sigma) {
  std::vector<Pair> pairs;
  constexpr double kSlack = 1e-3;  // stamps jitter
  double next_start = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    if (frames[i].t < next_start - kSlack) continue;
    std::size_t j = i + 1;
    while (j + 1 < frames.size() && frames[j + 1].t - frames[i].t <= kPairInterval + kSlack) {
      ++j;
    }
    PairPoints common;
    for (; j > i; --j) {
      common = commonPoints(frames[i], frames[j]);
      if (common.count() >= kMinPoints) break;
    }
    if (j == i || frames[j].t - frames[i].t > kMaxFrameGap) continue;
    RelativeRotation seen;
    if (!relativeRotation(common, sigma, &seen)) continue;
    pairs.emplace_back(frames[i].t, frames[j].t, seen);
    next_start = frames[i].t + kPairSpacing;
  }
  return pairs;
}

/// Rates of camera and gyro, one column per pair, about their weighted means.
struct Rates {
  Eigen::Matrix3Xd camera, gyro;
  Vector3d camera_mean, gyro_mean;
};

double weightedSquares(const Eigen::Matrix3Xd& columns, const VectorXd& weights) {
  return weights.dot(columns.colwise().squaredNorm());
}

struct Procrustes {
  Matrix3d R_b_c = Matrix3d::Identity();
  double correlation = -1.0;
  double mirrored = -1.0;
  double scale = 1.0;
};

/// R that minimises sum w |gyro / scale - R camera|^2. `noise2`: weighted sum of the squared noise
/// of the camera's rates, which would make them longer.
Procrustes procrustes(const Rates& rates, const VectorXd& weights, double noise2,
                      const Matrix3d& R_tie) {
  const Matrix3d B = rates.gyro * weights.asDiagonal() * rates.camera.transpose();
  const double camera2 = weightedSquares(rates.camera, weights);
  Procrustes result;
  const double norm = std::sqrt(camera2 * weightedSquares(rates.gyro, weights));
  if (!(norm > 0.0)) return result;
  const Eigen::JacobiSVD<Matrix3d> svd(B + kTieBreak * norm * R_tie,
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs = Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  result.R_b_c = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const Vector3d sigma = svd.singularValues();
  const double aligned = (result.R_b_c.transpose() * B).trace();
  result.correlation = aligned / norm;
  result.mirrored = (sigma.x() + sigma.y() - signs.z() * sigma.z()) / norm;
  result.scale = aligned / std::max(camera2 - noise2, 0.5 * camera2);
  return result;
}

class Aligner {
 public:
  Aligner(const std::vector<FrameObservation>& frames, const std::vector<ImuSample>& imu,
          const Calibration& calibration)
      : frames_(frames), imu_(imu), calibration_(calibration) {}

  RotationAlignment run() {
    // Where gaps or a short recording leave too few pairs, the range is reduced.
    const std::vector<Pair> all = measurePairs(frames_, calibration_.sigmaBearing());
    for (max_offset_ = kMaxOffset; max_offset_ > kLeastRange; max_offset_ *= 0.5) {
      if (covered(all).size() >= kLeastCovered * static_cast<double>(all.size())) break;
    }
    pairs_ = covered(all);
    result_.pairs = static_cast<int>(pairs_.size());
    if (result_.pairs < kMinPairs) return result_;
    describe();
    // A rotation of the camera within its own noise is none.
    const bool turns = result_.camera_rate >= kMinRate;
    if (!turns && result_.gyro_rate < kMinRate) {
      result_.status = AlignmentStatus::kTooLittleTurn;
      return result_;
    }
    result_.status = AlignmentStatus::kSolved;
    search();
    return result_;
  }

 private:
  // Search range of the offset: halved until this share of the pairs has IMU data throughout, but
  // not below kLeastRange [s].
  static constexpr double kLeastCovered = 0.9, kLeastRange = 0.02;
  static constexpr int kSearchRounds = 3;  // with weights from the previous one
  // Floors against division by zero: spread of the rates [rad/s], scale of the gyro.
  static constexpr double kLeastSpread = 1e-6, kLeastScale = 1e-3;

  /// Those with IMU data at every offset of the search.
  std::vector<Pair> covered(const std::vector<Pair>& all) const {
    std::vector<Pair> pairs;
    std::copy_if(all.begin(), all.end(), std::back_inserter(pairs), [&](const Pair& pair) {
      return meanRate(imu_, pair.t_i + calibration_.td - max_offset_,
                      pair.t_j + calibration_.td + max_offset_)
          .allFinite();
    });
    return pairs;
  }

  void describe() {
    std::vector<double> residuals, flows;
    double sum = 0.0, camera2 = 0.0;
    Vector3d gyro_sum = Vector3d::Zero();
    double gyro2 = 0.0;
    for (const Pair& pair : pairs_) {
      residuals.push_back(pair.residual * calibration_.focal_px);
      flows.push_back(pair.flow * calibration_.focal_px / pair.dt);
      sum += pair.weight;
      camera2 += pair.weight * (pair.rate.squaredNorm() - 3.0 * pair.sigma * pair.sigma);
      const Vector3d g = gyroRate(pair, calibration_.td);
      gyro_sum += g;
      gyro2 += g.squaredNorm();
    }
    const double n = static_cast<double>(pairs_.size());
    result_.camera_rate = std::sqrt(std::max(camera2 / sum, 0.0));
    result_.gyro_mean = gyro_sum / n;
    result_.gyro_rate = std::sqrt(std::max(gyro2 / n - result_.gyro_mean.squaredNorm(), 0.0));
    result_.residual_px = median(residuals);
    result_.flow_px_per_s = median(flows);
  }

  Vector3d gyroRate(const Pair& pair, double td) const {
    return meanRate(imu_, pair.t_i + td, pair.t_j + td);
  }

  Rates ratesAt(double td) const {
    Rates rates;
    rates.camera.resize(3, result_.pairs);
    rates.gyro.resize(3, result_.pairs);
    for (int k = 0; k < result_.pairs; ++k) {
      rates.camera.col(k) = pairs_[k].rate;
      rates.gyro.col(k) = gyroRate(pairs_[k], td);
    }
    rates.camera_mean = rates.camera * weights_ / weights_.sum();
    rates.gyro_mean = rates.gyro * weights_ / weights_.sum();
    rates.camera.colwise() -= rates.camera_mean;
    rates.gyro.colwise() -= rates.gyro_mean;
    return rates;
  }

  Procrustes align(const Rates& rates) const {
    double noise2 = 0.0;
    for (int k = 0; k < result_.pairs; ++k) {
      noise2 += 3.0 * weights_[k] * pairs_[k].sigma * pairs_[k].sigma;
    }
    return procrustes(rates, weights_, noise2, calibration_.R_b_c);
  }

  /// The offset of the best correlation: on the grid, then the top of the parabola through the best
  /// and its neighbours.
  double bestOffset() const {
    const int steps = static_cast<int>(max_offset_ / kOffsetStep);
    std::vector<double> correlations;
    for (int step = -steps; step <= steps; ++step) {
      correlations.push_back(align(ratesAt(calibration_.td + step * kOffsetStep)).correlation);
    }
    const auto best = std::max_element(correlations.begin(), correlations.end());
    const auto at = static_cast<int>(best - correlations.begin());
    const double td = calibration_.td + (at - steps) * kOffsetStep;
    if (at == 0 || at == 2 * steps) return td;
    const double curvature = best[-1] - 2.0 * best[0] + best[1];
    return curvature < 0.0 ? td + 0.5 * kOffsetStep * (best[-1] - best[1]) / curvature : td;
  }

  /// Offset and rotation of the best correlation.
  void search() {
    weights_.resize(result_.pairs);
    for (int k = 0; k < result_.pairs; ++k) weights_[k] = pairs_[k].weight;
    Procrustes best;
    for (int round = 0; round < kSearchRounds; ++round) {
      result_.td = bestOffset();
      const Rates rates = ratesAt(result_.td);
      best = align(rates);
      // Pairs that the others contradict count for less in the next round.
      const VectorXd distances =
          (rates.gyro / best.scale - best.R_b_c * rates.camera).colwise().norm();
      const double spread = std::max(
          median(std::vector<double>(distances.data(), distances.data() + distances.size())),
          kLeastSpread);
      for (int k = 0; k < result_.pairs; ++k) {
        weights_[k] = pairs_[k].weight * gemanMcClure(std::pow(distances[k] / spread, 2));
      }
    }
    result_.correlation = best.correlation;
    result_.mirrored_correlation = best.mirrored;
    result_.R_b_c = best.R_b_c;
    result_.gyro_scale = std::max(best.scale, kLeastScale);
    describeAlignment();
  }

  /// Bias and standard deviations of the alignment, each quantity for itself, from the scatter of
  /// the pairs about it.
  void describeAlignment() {
    const Rates rates = ratesAt(result_.td);
    // The bias is what the means differ by.
    result_.gyro_bias = rates.gyro_mean / result_.gyro_scale - result_.R_b_c * rates.camera_mean;
    double count = 0.0, of_td = 0.0;
    for (int k = 0; k < result_.pairs; ++k) {
      const Pair& pair = pairs_[k];
      count += weights_[k] / pair.weight;
      const double begin = pair.t_i + result_.td, end = pair.t_j + result_.td;
      const Vector3d change =
          meanRate(imu_, end - kOffsetStep, end) - meanRate(imu_, begin, begin + kOffsetStep);
      of_td += weights_[k] * (change / pair.dt / result_.gyro_scale).squaredNorm();
    }
    const double of_scale = weightedSquares(rates.camera, weights_);
    const Matrix3d of_rotation = of_scale * Matrix3d::Identity() -
                                 rates.camera * weights_.asDiagonal() * rates.camera.transpose();
    const double chi2 =
        weightedSquares(rates.gyro / result_.gyro_scale - result_.R_b_c * rates.camera, weights_);
    // Pairs that overlap repeat each other.
    const double overlap = std::max(1.0, kPairInterval / kPairSpacing);
    const double variance = overlap * chi2 / (3.0 * count);
    // A prior of 1 rad, too weak to hold what the data determine.
    result_.R_covariance = (of_rotation / variance + Matrix3d::Identity()).inverse();
    result_.td_sigma = std::sqrt(variance / of_td);
    result_.gyro_scale_sigma = result_.gyro_scale * std::sqrt(variance / of_scale);
  }

  const std::vector<FrameObservation>& frames_;
  const std::vector<ImuSample>& imu_;
  const Calibration& calibration_;
  std::vector<Pair> pairs_;
  double max_offset_ = kMaxOffset;  // [s]
  VectorXd weights_;                // of the pairs
  RotationAlignment result_;
};

}  // namespace

RotationAlignment alignRotations(const std::vector<FrameObservation>& frames,
                                 const std::vector<ImuSample>& imu,
                                 const Calibration& calibration) {
  return Aligner(frames, imu, calibration).run();
}

}  // namespace slim_init::evaluation
