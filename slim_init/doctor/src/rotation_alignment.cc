// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_map>

#include "geometry/robust.h"
#include "reference_so3.h"
#include "rotation/free_rotations.h"
#include "slim_init/doctor/doctor.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::evaluation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
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

/// The gyro as a function of time.
class Gyro {
 public:
  explicit Gyro(const std::vector<ImuSample>& imu) : imu_(imu) {
    angle_.assign(imu.size(), Vector3d::Zero());
    gaps_.assign(imu.size(), 0);
    for (std::size_t k = 1; k < imu.size(); ++k) {
      const double dt = imu[k].t - imu[k - 1].t;
      angle_[k] = angle_[k - 1] + 0.5 * dt * (imu[k].gyro + imu[k - 1].gyro);
      gaps_[k] = gaps_[k - 1] + (dt > kMaxImuGap ? 1 : 0);
    }
  }

  /// Whether there are samples throughout.
  bool covers(double t0, double t1) const {
    if (imu_.size() < 2 || t0 < imu_.front().t || t1 > imu_.back().t) return false;
    return gaps_[stepOf(t1)] == gaps_[stepOf(t0) - 1];
  }
  /// Mean rate over covered times, as if rotations were vectors.
  Vector3d meanRate(double t0, double t1) const { return (angle(t1) - angle(t0)) / (t1 - t0); }
  Vector3d rate(double t) const {
    const std::size_t k = stepOf(t);
    const double u = (t - imu_[k - 1].t) / (imu_[k].t - imu_[k - 1].t);
    return (1.0 - u) * imu_[k - 1].gyro + u * imu_[k].gyro;
  }

 private:
  /// The step from sample k - 1 to k that holds t.
  std::size_t stepOf(double t) const {
    const auto next = std::upper_bound(imu_.begin() + 1, imu_.end() - 1, t,
                                       [](double at, const ImuSample& s) { return at < s.t; });
    return static_cast<std::size_t>(next - imu_.begin());
  }
  Vector3d angle(double t) const {
    const std::size_t k = stepOf(t);
    const double dt = t - imu_[k - 1].t;
    return angle_[k - 1] + 0.5 * dt * (imu_[k - 1].gyro + rate(t));
  }

  const std::vector<ImuSample>& imu_;
  std::vector<Vector3d> angle_;  // integral of the rate
  std::vector<int> gaps_;        // steps too long up to here
};

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

/// Rates of camera and gyro over the pairs, about their means, with weights.
struct Rates {
  std::vector<Vector3d> camera, gyro;
  std::vector<double> weights;
  std::vector<double> noise2;  // of the camera's, squared

  void center() {
    Vector3d camera_sum = Vector3d::Zero(), gyro_sum = Vector3d::Zero();
    double sum = 0.0;
    for (std::size_t k = 0; k < camera.size(); ++k) {
      camera_sum += weights[k] * camera[k];
      gyro_sum += weights[k] * gyro[k];
      sum += weights[k];
    }
    for (std::size_t k = 0; k < camera.size(); ++k) {
      camera[k] -= camera_sum / sum;
      gyro[k] -= gyro_sum / sum;
    }
  }
};

struct Procrustes {
  Matrix3d R_b_c = Matrix3d::Identity();
  double correlation = -1.0;
  double mirrored = -1.0;
  double scale = 1.0;
};

/// R that minimises sum w |gyro / scale - R camera|^2.
Procrustes procrustes(const Rates& rates, const Matrix3d& R_tie) {
  Matrix3d B = Matrix3d::Zero();
  double camera2 = 0.0, gyro2 = 0.0, noise2 = 0.0;
  for (std::size_t k = 0; k < rates.camera.size(); ++k) {
    noise2 += rates.weights[k] * rates.noise2[k];
    B += rates.weights[k] * rates.gyro[k] * rates.camera[k].transpose();
    camera2 += rates.weights[k] * rates.camera[k].squaredNorm();
    gyro2 += rates.weights[k] * rates.gyro[k].squaredNorm();
  }
  Procrustes result;
  const double norm = std::sqrt(camera2 * gyro2);
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
  // The noise of the camera's rates would make them longer.
  result.scale = aligned / std::max(camera2 - noise2, 0.5 * camera2);
  return result;
}

class Aligner {
 public:
  Aligner(const std::vector<FrameObservation>& frames, const std::vector<ImuSample>& imu,
          const Calibration& calibration)
      : frames_(frames), calibration_(calibration), gyro_(imu) {}

  RotationAlignment run() {
    pairs_ = measurePairs(frames_, calibration_.sigmaBearing());
    // The search needs the pairs at every offset; where the recording is too short for that, the
    // range is reduced.
    for (max_offset_ = kMaxOffset; max_offset_ > kLeastRange; max_offset_ *= 0.5) {
      if (static_cast<int>(covered(max_offset_).size()) >=
          kLeastCovered * static_cast<double>(pairs_.size())) {
        break;
      }
    }
    pairs_ = covered(max_offset_);
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

  std::vector<Pair> covered(double offset) const {
    std::vector<Pair> result;
    std::copy_if(pairs_.begin(), pairs_.end(), std::back_inserter(result), [&](const Pair& pair) {
      return gyro_.covers(pair.t_i + calibration_.td - offset, pair.t_j + calibration_.td + offset);
    });
    return result;
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
      const Vector3d g = gyro_.meanRate(pair.t_i + calibration_.td, pair.t_j + calibration_.td);
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

  Rates ratesAt(double td, const std::vector<double>& weights) const {
    Rates rates;
    rates.weights = weights;
    for (const Pair& pair : pairs_) {
      rates.camera.push_back(pair.rate);
      rates.noise2.push_back(3.0 * pair.sigma * pair.sigma);
      rates.gyro.push_back(gyro_.meanRate(pair.t_i + td, pair.t_j + td));
    }
    rates.center();
    return rates;
  }

  /// The offset and rotation of the best correlation.
  void search() {
    std::vector<double> weights;
    for (const Pair& pair : pairs_) weights.push_back(pair.weight);
    Procrustes best;
    double td = calibration_.td;
    for (int round = 0; round < kSearchRounds; ++round) {
      const int steps = static_cast<int>(max_offset_ / kOffsetStep);
      std::vector<double> correlations;
      best = Procrustes();
      int at = 0;
      for (int step = -steps; step <= steps; ++step) {
        const double offset = calibration_.td + step * kOffsetStep;
        const Procrustes p = procrustes(ratesAt(offset, weights), calibration_.R_b_c);
        correlations.push_back(p.correlation);
        if (p.correlation <= best.correlation) continue;
        best = p;
        at = step + steps;
        td = offset;
      }
      // Top of the parabola through the best and its neighbours.
      if (at > 0 && at < 2 * steps) {
        const auto c = [&](int k) { return correlations[at + k]; };
        const double curvature = c(-1) - 2.0 * c(0) + c(1);
        if (curvature < 0.0) td += 0.5 * kOffsetStep * (c(-1) - c(1)) / curvature;
      }
      const Rates rates = ratesAt(td, weights);
      best = procrustes(rates, calibration_.R_b_c);
      // Pairs that the others contradict count for less in the next round.
      std::vector<double> distances;
      for (std::size_t k = 0; k < pairs_.size(); ++k) {
        distances.push_back((rates.gyro[k] / best.scale - best.R_b_c * rates.camera[k]).norm());
      }
      const double spread = std::max(median(distances), kLeastSpread);
      for (std::size_t k = 0; k < pairs_.size(); ++k) {
        weights[k] = pairs_[k].weight * gemanMcClure(std::pow(distances[k] / spread, 2));
      }
    }
    result_.correlation = best.correlation;
    result_.mirrored_correlation = best.mirrored;
    result_.td = td;
    result_.R_b_c = best.R_b_c;
    result_.gyro_scale = std::max(best.scale, kLeastScale);
    describeAlignment(weights);
  }

  /// Bias and standard deviations of the alignment, each quantity for itself, from the scatter of
  /// the pairs about it.
  void describeAlignment(const std::vector<double>& weights) {
    const Rates rates = ratesAt(result_.td, weights);
    Vector3d difference = Vector3d::Zero();
    Matrix3d of_rotation = Matrix3d::Zero();
    double sum = 0.0, count = 0.0, of_td = 0.0, of_scale = 0.0, chi2 = 0.0;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Pair& pair = pairs_[k];
      const double t_i = pair.t_i + result_.td, t_j = pair.t_j + result_.td, w = weights[k];
      const Vector3d& c = rates.camera[k];
      sum += w;
      count += w / pair.weight;
      // The bias is what the means differ by.
      difference += w * (gyro_.meanRate(t_i, t_j) / result_.gyro_scale - result_.R_b_c * pair.rate);
      of_rotation += w * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
      of_scale += w * c.squaredNorm();
      const Vector3d change = (gyro_.rate(t_j) - gyro_.rate(t_i)) / pair.dt / result_.gyro_scale;
      of_td += w * change.squaredNorm();
      chi2 += w * (rates.gyro[k] / result_.gyro_scale - result_.R_b_c * c).squaredNorm();
    }
    result_.gyro_bias = difference / sum;
    // Pairs that overlap repeat each other.
    const double overlap = std::max(1.0, kPairInterval / kPairSpacing);
    const double variance = overlap * chi2 / (3.0 * count);
    // A prior of 1 rad, too weak to hold what the data determine.
    result_.R_covariance = (of_rotation / variance + Matrix3d::Identity()).inverse();
    result_.td_sigma = std::sqrt(variance / of_td);
    result_.gyro_scale_sigma = result_.gyro_scale * std::sqrt(variance / of_scale);
  }

  const std::vector<FrameObservation>& frames_;
  const Calibration& calibration_;
  Gyro gyro_;
  double max_offset_ = 0.0;
  std::vector<Pair> pairs_;
  RotationAlignment result_;
};

}  // namespace

RotationAlignment alignRotations(const std::vector<FrameObservation>& frames,
                                 const std::vector<ImuSample>& imu,
                                 const Calibration& calibration) {
  return Aligner(frames, imu, calibration).run();
}

}  // namespace slim_init::evaluation
