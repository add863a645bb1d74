// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/multi_gap_bias.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/so3.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {
namespace {

constexpr double kStepTolerance = 1e-10;        // [rad/s]
constexpr double kRelinearizeTolerance = 1e-4;  // [rad/s]; error of the correction below 1e-9 rad
constexpr double kCostTolerance = 1e-6;         // relative; the cost is a chi-square of thousands
constexpr double kBaselinePriorSigmas2 = 0.5;   // regularisation of the baseline, in sigma^2

// Relative rotation b_i <- b_j over consecutive preintegrations, with its bias derivative
// (right perturbation).
struct RelativeRotation {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
};

struct PairData {
  int i = 0, j = 0;
  NormalizedEpipolarPair points;
  bool use_points = false;
  bool use_vp = false;
};

struct Quadratic {
  double cost = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

class Objective {
 public:
  Objective(const InitWindow& window, const std::vector<VanishingPoint>* vps,
            const MultiGapBiasOptions& options)
      : window_(window), vps_(vps), options_(options), sigma_(window.calibration().sigmaBearing()) {
    const int n = window.size();
    std::vector<int> index(n * n, -1);
    for (int gap : {1, 2, 4, 8}) {
      if (gap >= n || gap > options.max_gap) continue;
      ++gaps_;
      for (int i = 0; i + gap < n; ++i) {
        index[i * n + i + gap] = static_cast<int>(pairs_.size());
        pairs_.emplace_back();
        pairs_.back().i = i;
        pairs_.back().j = i + gap;
      }
    }
    const std::vector<PointSighting>& s = window.pointSightings();
    for (const Track& track : window.pointTracks()) {
      for (int a = track.begin; a < track.end; ++a) {
        for (int b = a + 1; b < track.end; ++b) {
          const int pair = index[s[a].keyframe * n + s[b].keyframe];
          if (pair >= 0) pairs_[pair].points.add(s[a].bearing, s[b].bearing);
        }
      }
    }
    for (PairData& pair : pairs_) {
      pair.use_points = pair.points.count() >= options.min_points_per_pair;
      pair.use_vp = vps != nullptr && (*vps)[pair.i].found && (*vps)[pair.j].found &&
                    (*vps)[pair.i].track_id == (*vps)[pair.j].track_id;
      point_pairs_ += pair.use_points ? 1 : 0;
      vp_pairs_ += pair.use_vp ? 1 : 0;
    }
  }

  int pointPairs() const { return point_pairs_; }
  int vpPairs() const { return vp_pairs_; }

  void resetWeights() {
    for (PairData& pair : pairs_) {
      if (pair.use_points) pair.points.resetWeights();
    }
  }

  void updateWeights(const std::vector<RelativeRotation>& relative) {
    const Eigen::Matrix3d& R_b_c = window_.calibration().R_b_c;
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      if (!pairs_[p].use_points) continue;
      pairs_[p].points.updateWeights(R_b_c.transpose() * relative[p].R * R_b_c, sigma_,
                                     options_.cauchy_sigmas);
    }
  }

  // Relative rotations of all pairs at a bias, first order around `pre`.
  std::vector<RelativeRotation> rotations(const std::vector<Preintegration>& pre,
                                          const Eigen::Vector3d& gyro_bias) const {
    std::vector<RelativeRotation> step(pre.size());
    for (std::size_t k = 0; k < pre.size(); ++k) {
      const Eigen::Vector3d phi = pre[k].dR_dbg * (gyro_bias - pre[k].gyro_bias);
      step[k].R = pre[k].dR * expSO3(phi);
      step[k].J = rightJacobian(phi) * pre[k].dR_dbg;
    }
    std::vector<RelativeRotation> out(pairs_.size());
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      for (int k = pairs_[p].i; k < pairs_[p].j; ++k) {
        out[p].J = step[k].R.transpose() * out[p].J + step[k].J;
        out[p].R = out[p].R * step[k].R;
      }
    }
    return out;
  }

  // Cost with the current point weights.
  Quadratic evaluate(const std::vector<RelativeRotation>& relative,
                     const Eigen::Vector3d& gyro_bias) const {
    const Eigen::Matrix3d& R_b_c = window_.calibration().R_b_c;
    const double sigma2 = sigma_ * sigma_;
    Quadratic sum;
    const double prior = 1.0 / (options_.bias_prior * options_.bias_prior);
    sum.cost = prior * gyro_bias.squaredNorm();
    sum.gradient = 2.0 * prior * gyro_bias;
    sum.hessian = 2.0 * prior * Eigen::Matrix3d::Identity();
    // A point enters once per gap; its information counts once.
    const double share = 1.0 / std::max(gaps_, 1);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const RelativeRotation& r = relative[p];
      if (pairs_[p].use_points) {
        const NormalizedEvaluation at = pairs_[p].points.evaluate(R_b_c.transpose() * r.R * R_b_c,
                                                                  kBaselinePriorSigmas2 * sigma2);
        const double scale = share * pairs_[p].points.weightSum() / sigma2;
        const Eigen::Matrix3d J = R_b_c.transpose() * r.J;
        sum.cost += scale * at.lambda;
        sum.gradient += scale * (J.transpose() * at.gradient);
        sum.hessian += scale * (J.transpose() * at.hessian * J);
      }
      if (pairs_[p].use_vp) {
        Eigen::Vector2d z;
        Eigen::Matrix<double, 2, 3> dz;
        whitenedVpResidual((*vps_)[pairs_[p].i], (*vps_)[pairs_[p].j], r.R, R_b_c,
                           options_.vp_inflation, &z, &dz);
        const double c2 = options_.cauchy_sigmas * options_.cauchy_sigmas;
        const double weight = 1.0 / (1.0 + z.squaredNorm() / c2);
        const Eigen::Matrix<double, 2, 3> J = dz * r.J;
        sum.cost += share * c2 * std::log1p(z.squaredNorm() / c2);
        sum.gradient += 2.0 * share * weight * (J.transpose() * z);
        sum.hessian += 2.0 * share * weight * (J.transpose() * J);
      }
    }
    return sum;
  }

  // The robust cost itself, comparable between different weights.
  double robustCost(const std::vector<RelativeRotation>& relative,
                    const Eigen::Vector3d& gyro_bias) const {
    const Eigen::Matrix3d& R_b_c = window_.calibration().R_b_c;
    const double c2 = options_.cauchy_sigmas * options_.cauchy_sigmas;
    const double share = 1.0 / std::max(gaps_, 1);
    double cost = gyro_bias.squaredNorm() / (options_.bias_prior * options_.bias_prior);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      if (pairs_[p].use_points) {
        const std::vector<double> z =
            pairs_[p].points.residuals(R_b_c.transpose() * relative[p].R * R_b_c, sigma_);
        for (double r : z) cost += share * c2 * std::log1p(r * r / c2);
      }
      if (pairs_[p].use_vp) {
        Eigen::Vector2d z;
        whitenedVpResidual((*vps_)[pairs_[p].i], (*vps_)[pairs_[p].j], relative[p].R, R_b_c,
                           options_.vp_inflation, &z, nullptr);
        cost += share * c2 * std::log1p(z.squaredNorm() / c2);
      }
    }
    return cost;
  }

 private:
  const InitWindow& window_;
  const std::vector<VanishingPoint>* vps_;
  const MultiGapBiasOptions& options_;
  const double sigma_;
  std::vector<PairData, Eigen::aligned_allocator<PairData>> pairs_;
  int gaps_ = 0;
  int point_pairs_ = 0;
  int vp_pairs_ = 0;
};

MultiGapBiasEstimate minimizeFrom(const InitWindow& window, const Eigen::Vector3d& start,
                                  const MultiGapBiasOptions& options, Objective* objective) {
  MultiGapBiasEstimate out;
  out.gyro_bias = start;
  out.point_pairs = objective->pointPairs();
  out.vp_pairs = objective->vpPairs();
  std::vector<Preintegration> pre =
      preintegrateWindow(window, start, Eigen::Vector3d::Zero(), PreintegrationParts::kRotation);
  objective->resetWeights();
  Quadratic at;
  for (int round = 0; round < options.reweightings; ++round) {
    if ((out.gyro_bias - pre.front().gyro_bias).norm() > kRelinearizeTolerance) {
      pre = preintegrateWindow(window, out.gyro_bias, Eigen::Vector3d::Zero(),
                               PreintegrationParts::kRotation);
    }
    std::vector<RelativeRotation> relative = objective->rotations(pre, out.gyro_bias);
    objective->updateWeights(relative);
    at = objective->evaluate(relative, out.gyro_bias);
    double damping = 1e-4;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      Eigen::Matrix3d H = at.hessian;
      H.diagonal() *= 1.0 + damping;
      const Eigen::Vector3d step = -H.ldlt().solve(at.gradient);
      if (!step.allFinite() || -at.gradient.dot(step) <= kCostTolerance * at.cost) break;
      const Eigen::Vector3d candidate = out.gyro_bias + step;
      const Quadratic there = objective->evaluate(objective->rotations(pre, candidate), candidate);
      if (there.cost < at.cost) {
        out.gyro_bias = candidate;
        at = there;
        ++out.iterations;
        damping = std::max(0.1 * damping, 1e-12);
      } else {
        damping *= 10.0;
      }
      if (step.norm() < kStepTolerance || damping > 1e6) break;
    }
  }
  out.information = 0.5 * at.hessian;
  out.cost = objective->robustCost(objective->rotations(pre, out.gyro_bias), out.gyro_bias);
  out.valid = out.gyro_bias.allFinite() && std::isfinite(out.cost) &&
              out.gyro_bias.norm() <= options.max_bias;
  return out;
}

}  // namespace

void whitenedVpResidual(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                        const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                        double inflation, Eigen::Vector2d* residual,
                        Eigen::Matrix<double, 2, 3>* jacobian) {
  const Eigen::Matrix3d R_cj_ci = R_b_c.transpose() * R_bi_bj.transpose() * R_b_c;
  Eigen::Vector3d u_b = R_bi_bj.transpose() * (R_b_c * vp_i.direction);
  Eigen::Vector3d u_c = R_b_c.transpose() * u_b;
  if (u_c.dot(vp_j.direction) < 0.0) {
    u_b = -u_b;
    u_c = -u_c;
  }
  const Eigen::Matrix<double, 3, 2> B = tangentBasis(vp_j.direction);
  Eigen::Matrix2d covariance = inflation * B.transpose() *
                               (vp_j.covariance + R_cj_ci * vp_i.covariance * R_cj_ci.transpose()) *
                               B;
  // A milliradian of model error: buildings are not built to better than that.
  covariance.diagonal().array() += 1e-6;
  const Eigen::Matrix2d L = covariance.llt().matrixL();
  const Eigen::Matrix2d W = L.triangularView<Eigen::Lower>().solve(Eigen::Matrix2d::Identity());
  *residual = W * (B.transpose() * u_c);
  // R^T Exp(-phi): d(R^T u) = [R^T u]x phi.
  if (jacobian != nullptr) *jacobian = W * B.transpose() * R_b_c.transpose() * skew(u_b);
}

MultiGapBiasEstimate estimateMultiGapBias(const InitWindow& window,
                                          const std::vector<Eigen::Vector3d>& starts,
                                          const std::vector<VanishingPoint>* vanishing_points,
                                          const MultiGapBiasOptions& options) {
  Objective objective(window, vanishing_points, options);
  MultiGapBiasEstimate best;
  best.point_pairs = objective.pointPairs();
  best.vp_pairs = objective.vpPairs();
  if (best.point_pairs + best.vp_pairs == 0) return best;
  for (const Eigen::Vector3d& start : starts) {
    const MultiGapBiasEstimate estimate = minimizeFrom(window, start, options, &objective);
    if (estimate.valid && (!best.valid || estimate.cost < best.cost)) {
      const int iterations = best.iterations;
      best = estimate;
      best.iterations += iterations;
    }
  }
  return best;
}

}  // namespace slim_init
