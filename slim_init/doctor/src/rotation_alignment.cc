// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/doctor/rotation_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "geometry/robust_weight.h"
#include "reference_so3.h"
#include "rotation/free_rotations.h"
#include "slim_init/evaluation/inertial_steps.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::evaluation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix38d = Eigen::Matrix<double, 3, 8>;

constexpr double kMedianChi2 = 2.366;  // of three degrees of freedom
// Errors that are not in the bearings: jitter of the stamps, noise of the gyro over a pair [rad].
constexpr double kModelSigma = 5e-4;
// Standard deviation of a rate beyond the noise of its own pair [rad/s].
constexpr double kRateSigma = 0.02;
// Weight of the configured rotation: enough to decide what the data leave open, too little to move
// what they determine.
constexpr double kTieBreak = 1e-3;

struct Pair {
  std::size_t i = 0, j = 0;  ///< of the frames
  double t_i = 0.0, t_j = 0.0;
  RelativeRotation seen;
  double dt() const { return t_j - t_i; }
  Vector3d rate() const { return reference::logSo3(seen.R_ci_cj) / dt(); }
  /// Standard deviation of a component of rate().
  double rateSigma() const {
    const Matrix3d covariance = (seen.information + 1e-6 * Matrix3d::Identity()).inverse();
    return std::sqrt(covariance.trace() / 3.0) / dt();
  }
};

/// The gyro as a function of time.
class Gyro {
 public:
  Gyro(const std::vector<ImuSample>& imu, double max_gap_s) : imu_(imu), max_gap_s_(max_gap_s) {
    angle_.assign(imu.size(), Vector3d::Zero());
    gaps_.assign(imu.size(), 0);
    for (std::size_t k = 1; k < imu.size(); ++k) {
      const double dt = imu[k].t - imu[k - 1].t;
      angle_[k] = angle_[k - 1] + 0.5 * dt * (imu[k].gyro + imu[k - 1].gyro);
      gaps_[k] = gaps_[k - 1] + (dt > max_gap_s ? 1 : 0);
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
  /// R_bi_bj of the rate gyro / scale - bias.
  Matrix3d rotation(double t0, double t1, double scale, const Vector3d& bias) {
    Matrix3d R = Matrix3d::Identity();
    if (!inertialSteps(imu_, t0, t1, max_gap_s_, &steps_)) return R;
    for (const InertialStep& step : steps_) {
      R *= reference::expSo3((step.gyro / scale - bias) * step.dt);
    }
    return R;
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
  double max_gap_s_;
  std::vector<Vector3d> angle_;  // integral of the rate
  std::vector<int> gaps_;        // steps too long up to here
  std::vector<InertialStep> steps_;
};

/// Parameters that align camera and gyro.
struct Alignment {
  double td = 0.0;
  Matrix3d R_b_c = Matrix3d::Identity();
  double scale = 1.0;
  Vector3d bias = Vector3d::Zero();
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
std::vector<Pair> measurePairs(const std::vector<FrameObservation>& frames, double sigma,
                               const RotationAlignmentOptions& options) {
  std::vector<Pair> pairs;
  constexpr double kSlack = 1e-3;  // stamps jitter
  double next_start = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    if (frames[i].t < next_start - kSlack) continue;
    std::size_t j = i + 1;
    while (j + 1 < frames.size() &&
           frames[j + 1].t - frames[i].t <= options.pair_interval_s + kSlack) {
      ++j;
    }
    PairPoints common;
    for (; j > i; --j) {
      common = commonPoints(frames[i], frames[j]);
      if (common.count() >= options.min_points) break;
    }
    if (j == i || frames[j].t - frames[i].t > options.max_frame_gap_s) continue;
    Pair pair;
    pair.i = i;
    pair.j = j;
    pair.t_i = frames[i].t;
    pair.t_j = frames[j].t;
    if (!relativeRotation(common, sigma, nullptr, &pair.seen)) continue;
    pairs.push_back(pair);
    next_start = frames[i].t + options.pair_spacing_s;
  }
  return pairs;
}

/// Rates of camera and gyro over the pairs, about their means, with weights.
struct Rates {
  std::vector<Vector3d> camera, gyro;
  std::vector<double> weights;

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
  double camera2 = 0.0, gyro2 = 0.0;
  for (std::size_t k = 0; k < rates.camera.size(); ++k) {
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
  result.scale = aligned / camera2;
  return result;
}

class Aligner {
 public:
  Aligner(const std::vector<FrameObservation>& frames, const std::vector<ImuSample>& imu,
          const Calibration& calibration, const RotationAlignmentOptions& options)
      : frames_(frames),
        calibration_(calibration),
        options_(options),
        gyro_(imu, options.max_imu_gap_s) {}

  RotationAlignment run() {
    pairs_ = measurePairs(frames_, calibration_.sigmaBearing(), options_);
    // The search needs the pairs at every offset; where the recording is too short for that, the
    // range is reduced.
    for (max_offset_ = options_.max_offset_s; max_offset_ > kLeastRange; max_offset_ *= 0.5) {
      if (static_cast<int>(covered(max_offset_).size()) >=
          kLeastCovered * static_cast<double>(pairs_.size())) {
        break;
      }
    }
    pairs_ = covered(max_offset_);
    result_.pairs = static_cast<int>(pairs_.size());
    if (result_.pairs < options_.min_pairs) return result_;
    describe();
    // A rotation of the camera within its own noise is none.
    const bool turns = result_.camera_rate >= options_.min_rate;
    if (!turns && result_.gyro_rate < options_.min_rate) {
      result_.status = AlignmentStatus::kTooLittleTurn;
      return result_;
    }
    result_.status = AlignmentStatus::kSolved;
    Alignment alignment = search();
    refine(&alignment);
    if (result_.correlation > kRemeasureCorrelation) {
      measureAgain(alignment);
      refine(&alignment);
    }
    return result_;
  }

 private:
  // Search range of the offset: halved until this share of the pairs has IMU data throughout, but
  // not below kLeastRange [s].
  static constexpr double kLeastCovered = 0.9, kLeastRange = 0.02;
  static constexpr int kSearchRounds = 3;  // with weights from the previous one
  // Correlation from which on the gyro's prediction is good enough to measure the pairs again.
  static constexpr double kRemeasureCorrelation = 0.6;
  // Stretches of the recording whose scatter enters the covariance, and pairs in each.
  static constexpr std::size_t kMaxBlocks = 12, kMinPairsOfBlock = 8;
  // Floors against division by zero: spread of the rates [rad/s], scale of the gyro.
  static constexpr double kLeastSpread = 1e-6, kLeastScale = 1e-3;

  std::vector<Pair> covered(double offset) const {
    std::vector<Pair> result;
    for (const Pair& pair : pairs_) {
      if (gyro_.covers(pair.t_i + calibration_.td - offset, pair.t_j + calibration_.td + offset)) {
        result.push_back(pair);
      }
    }
    return result;
  }

  void describe() {
    std::vector<double> residuals, flows;
    double sum = 0.0, camera2 = 0.0;
    Vector3d gyro_sum = Vector3d::Zero();
    double gyro2 = 0.0;
    for (const Pair& pair : pairs_) {
      residuals.push_back(pair.seen.residual * calibration_.focal_px);
      flows.push_back(pair.seen.flow * calibration_.focal_px / pair.dt());
      const double sigma = pair.rateSigma();
      const double w = 1.0 / (sigma * sigma + kRateSigma * kRateSigma);
      sum += w;
      camera2 += w * (pair.rate().squaredNorm() - 3.0 * sigma * sigma);
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
      rates.camera.push_back(pair.rate());
      rates.gyro.push_back(gyro_.meanRate(pair.t_i + td, pair.t_j + td));
    }
    rates.center();
    return rates;
  }

  /// The offset and rotation of the best correlation.
  Alignment search() {
    std::vector<double> quality;
    for (const Pair& pair : pairs_) {
      const double sigma = pair.rateSigma();
      quality.push_back(1.0 / (sigma * sigma + kRateSigma * kRateSigma));
    }
    std::vector<double> weights = quality;
    Procrustes best;
    double td = calibration_.td;
    for (int round = 0; round < kSearchRounds; ++round) {
      const int steps = static_cast<int>(max_offset_ / options_.offset_step_s);
      std::vector<double> correlations;
      best = Procrustes();
      int at = 0;
      for (int step = -steps; step <= steps; ++step) {
        const double offset = calibration_.td + step * options_.offset_step_s;
        const Procrustes p = procrustes(ratesAt(offset, weights), calibration_.R_b_c);
        correlations.push_back(p.correlation);
        if (p.correlation <= best.correlation) continue;
        best = p;
        at = step + steps;
        td = offset;
      }
      // Top of the parabola through the best and its neighbours.
      if (at > 0 && at < 2 * steps) {
        const auto c = [&](int k) { return correlations[static_cast<std::size_t>(at + k)]; };
        const double curvature = c(-1) - 2.0 * c(0) + c(1);
        if (curvature < 0.0) td += 0.5 * options_.offset_step_s * (c(-1) - c(1)) / curvature;
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
        weights[k] = quality[k] * gemanMcClure(std::pow(distances[k] / spread, 2));
      }
    }
    result_.correlation = best.correlation;
    result_.mirrored_correlation = best.mirrored;
    Alignment alignment;
    alignment.td = td;
    alignment.R_b_c = best.R_b_c;
    alignment.scale = std::max(best.scale, kLeastScale);
    // The bias is what the means differ by.
    Vector3d difference = Vector3d::Zero();
    double sum = 0.0;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Pair& pair = pairs_[k];
      difference += weights[k] * (gyro_.meanRate(pair.t_i + td, pair.t_j + td) / alignment.scale -
                                  alignment.R_b_c * pair.rate());
      sum += weights[k];
    }
    alignment.bias = difference / sum;
    return alignment;
  }

  /// Rotation of the camera predicted from the gyro.
  Matrix3d predicted(const Pair& pair, const Alignment& a) {
    const Matrix3d R_bi_bj = gyro_.rotation(pair.t_i + a.td, pair.t_j + a.td, a.scale, a.bias);
    return a.R_b_c.transpose() * R_bi_bj * a.R_b_c;
  }

  /// Measures the pairs again, starting from the gyro's prediction: that separates rotation from
  /// sideways travel where the points alone may confuse them.
  void measureAgain(const Alignment& alignment) {
    for (Pair& pair : pairs_) {
      const Matrix3d start = predicted(pair, alignment);
      RelativeRotation seen;
      if (relativeRotation(commonPoints(frames_[pair.i], frames_[pair.j]),
                           calibration_.sigmaBearing(), &start, &seen)) {
        pair.seen = seen;
      }
    }
  }

  /// Normal equations of all pairs at `a`, with robust weights.
  struct System {
    Matrix8d H = Matrix8d::Zero();
    Vector8d gradient = Vector8d::Zero();
    std::vector<Vector8d> block_gradients;  ///< of stretches of the recording
    double scale2 = 1.0;                    ///< of the chi-square of a pair
  };
  System build(const Alignment& a) {
    System system;
    std::vector<Vector3d> residuals;
    std::vector<Matrix38d> jacobians;
    std::vector<Matrix3d> information;
    std::vector<double> chi2;
    for (const Pair& pair : pairs_) {
      const Matrix3d covariance = (pair.seen.information + Matrix3d::Identity()).inverse();
      information.push_back(
          (covariance + kModelSigma * kModelSigma * Matrix3d::Identity()).inverse());
      jacobians.emplace_back();
      residuals.push_back(linearize(pair, a, &jacobians.back()));
      chi2.push_back(residuals.back().dot(information.back() * residuals.back()));
    }
    system.scale2 = std::max(median(chi2) / kMedianChi2, 1e-3);
    const std::size_t blocks =
        std::clamp<std::size_t>(pairs_.size() / kMinPairsOfBlock, 2, kMaxBlocks);
    system.block_gradients.assign(blocks, Vector8d::Zero());
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const double w = gemanMcClure(chi2[k] / (3.0 * system.scale2));
      const Eigen::Matrix<double, 8, 3> JtI = w * jacobians[k].transpose() * information[k];
      const Vector8d gradient = JtI * residuals[k];
      system.H += JtI * jacobians[k];
      system.gradient += gradient;
      system.block_gradients[k * blocks / pairs_.size()] += gradient;
    }
    // Prior of 1 rad, 1 s, 1 rad/s and 1 in log scale: too weak to hold what the data determine.
    system.H += system.scale2 * Matrix8d::Identity();
    return system;
  }

  /// Covariance of the parameters: from the scatter of single pairs, and from that of whole
  /// stretches, whose errors (a scene that misleads the tracker, a lens model) last longer than a
  /// pair.
  Matrix8d covarianceOf(const System& system) const {
    const Matrix8d inverse = system.H.ldlt().solve(Matrix8d::Identity());
    const double overlap = std::max(1.0, options_.pair_interval_s / options_.pair_spacing_s);
    const double blocks = static_cast<double>(system.block_gradients.size());
    Matrix8d scatter = Matrix8d::Zero();
    for (const Vector8d& gradient : system.block_gradients) {
      scatter += blocks / (blocks - 1.0) * gradient * gradient.transpose();
    }
    return overlap * system.scale2 * inverse + inverse * scatter * inverse;
  }

  /// Gauss-Newton over R_b_c, td, bias and the logarithm of the scale, in this order.
  void refine(Alignment* alignment) {
    constexpr int kIterations = 12;
    System system = build(*alignment);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Vector8d x = system.H.ldlt().solve(-system.gradient);
      if (!x.allFinite()) break;
      constexpr double kMaxStep = 0.1;
      const double largest = x.cwiseAbs().maxCoeff();
      if (largest > kMaxStep) x *= kMaxStep / largest;
      Alignment next = *alignment;
      next.R_b_c *= reference::expSo3(x.head<3>());
      next.td += x(3);
      next.bias += x.segment<3>(4);
      next.scale *= std::exp(x(7));
      if (std::abs(next.td - calibration_.td) > max_offset_) break;  // left the data
      *alignment = next;
      system = build(*alignment);
      if (x.norm() < 1e-8) break;
    }
    const Matrix8d covariance = covarianceOf(system);
    result_.R_b_c = alignment->R_b_c;
    result_.R_covariance = covariance.topLeftCorner<3, 3>();
    result_.td = alignment->td;
    result_.td_sigma = std::sqrt(covariance(3, 3));
    result_.gyro_bias = alignment->bias;
    result_.gyro_scale = alignment->scale;
    result_.gyro_scale_sigma = alignment->scale * std::sqrt(covariance(7, 7));
  }

  /// r = Log(R_ci_cj^T C), C what the gyro predicts, and its derivative.
  Vector3d linearize(const Pair& pair, const Alignment& a, Matrix38d* J) {
    const double t0 = pair.t_i + a.td, t1 = pair.t_j + a.td;
    const Matrix3d G = gyro_.rotation(t0, t1, a.scale, a.bias);
    const Matrix3d C = a.R_b_c.transpose() * G * a.R_b_c;
    const Matrix3d R_c_b = a.R_b_c.transpose();
    const Vector3d start = gyro_.rate(t0) / a.scale - a.bias;
    const Vector3d end = gyro_.rate(t1) / a.scale - a.bias;
    J->leftCols<3>() = Matrix3d::Identity() - C.transpose();
    J->col(3) = R_c_b * (end - G.transpose() * start);
    J->middleCols<3>(4) = -pair.dt() * R_c_b;
    J->col(7) = -pair.dt() / a.scale * (R_c_b * gyro_.meanRate(t0, t1));
    return reference::logSo3(pair.seen.R_ci_cj.transpose() * C);
  }

  const std::vector<FrameObservation>& frames_;
  const Calibration& calibration_;
  const RotationAlignmentOptions& options_;
  Gyro gyro_;
  double max_offset_ = 0.0;
  std::vector<Pair> pairs_;
  RotationAlignment result_;
};

}  // namespace

RotationAlignment alignRotations(const std::vector<FrameObservation>& frames,
                                 const std::vector<ImuSample>& imu, const Calibration& calibration,
                                 const RotationAlignmentOptions& options) {
  return Aligner(frames, imu, calibration, options).run();
}

}  // namespace slim_init::evaluation
