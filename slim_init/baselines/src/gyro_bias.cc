// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "gyro_bias.h"

#include <algorithm>
#include <cmath>

#include "epipolar_pair.h"
#include "geometry/minimize.h"
#include "geometry/so3.h"
#include "geometry/units.h"

namespace slim_init::baselines {
namespace {

// A step below this changes no keyframe rotation by more than rounding [rad/s].
constexpr double kStepTolerance = 1e-12;
// Relative decrease of the cost, twice that expected of a step, below which rounding decides.
constexpr double kCostTolerance = 1e-12;
// Above this change of the bias [rad/s] the gyro is integrated anew. Below, the first-order
// correction over a keyframe interval dt is wrong by about (change * dt)^2 / 2 < 1e-11 rad.
constexpr double kRelinearizeTolerance = 1e-5;
// Integrations of the gyroscope at a new bias, and Levenberg-Marquardt iterations of each.
constexpr int kMaxRelinearizations = 4, kMaxIterations = 30;
// Cauchy scale of the eigenvalue of a pair [rad^2], of DRT's release.
constexpr double kCauchyScale = 1e-5;
// Marquardt damping, relative to the diagonal: the start trusts the model, at the end a step is so
// short that another try is pointless.
constexpr double kInitialDamping = 1e-4;
constexpr double kMaxDamping = 1e8;

struct Cauchy {
  double value;   // rho(s)
  double weight;  // rho'(s)
};

// rho(s) = c^2 log(1 + s / c^2) of a squared residual s.
Cauchy cauchy(double s, double scale) {
  const double c2 = scale * scale;
  return {c2 * std::log1p(s / c2), 1.0 / (1.0 + s / c2)};
}

struct Quadratic : QuadraticModel<3> {
  double rounding = 0.0;  // error of `cost` from rounding in the pre-summed matrices
};

// Marquardt's scaling, with a floor for directions that the data do not see.
Eigen::Matrix3d dampDiagonal(const Quadratic& at, double damping) {
  Eigen::Matrix3d H = at.hessian;
  H.diagonal() += damping * (at.hessian.diagonal().array() + 1e-12 * at.hessian.trace()).matrix();
  return H;
}

// Where rounding hides the cost, the gradient tells better from worse.
bool isBetter(const Quadratic& there, const Quadratic& at) {
  const bool hidden = std::abs(there.cost - at.cost) <= at.rounding + there.rounding;
  return hidden ? there.gradient.norm() < at.gradient.norm() : there.cost < at.cost;
}

// The sums of eq. (1) that do not depend on the bias.
class Objective {
 public:
  Objective(const InitWindow& window, const GyroBiasProblem& problem)
      : window_(window), problem_(problem), pairs_(window.size() - 1) {
    const std::vector<WindowPoint>& observations = window.pointObservations();
    for (const Track& track : window.pointTracks()) {
      for (int a = track.begin; a + 1 < track.end; ++a) {
        if (observations[a + 1].keyframe == observations[a].keyframe + 1) {
          pairs_[observations[a].keyframe].add(observations[a].bearing,
                                               observations[a + 1].bearing);
        }
      }
    }
    int points = 0;
    for (const EpipolarPair& pair : pairs_) {
      if (pair.count() < kMinPointsOfPair) continue;
      ++point_pairs_;
      points += pair.count();
    }
    vp_active_.resize(pairs_.size(), false);
    if (problem.vanishing_points != nullptr) {
      int vp_pairs = 0;
      const std::vector<VanishingPoint>& vps = *problem.vanishing_points;
      for (std::size_t i = 0; i < pairs_.size(); ++i) {
        vp_active_[i] = isReliablePair(vps[i], vps[i + 1],
                                       {consistencyOf(vps[i], window.linesOfKeyframe(i)),
                                        consistencyOf(vps[i + 1], window.linesOfKeyframe(i + 1))},
                                       problem.vp_options);
        vp_pairs += vp_active_[i] ? 1 : 0;
      }
      // lambda_vp of eq. (1): point to VP residual count ratio within the window.
      if (vp_pairs > 0) lambda_vp_ = problem.vp_options.vp_weight * points / vp_pairs;
    }
  }

  int pointPairs() const { return point_pairs_; }

  // Cost and derivatives, with the rotations at first order around the preintegrations `pre`.
  Quadratic evaluate(const std::vector<Preintegration>& pre,
                     const Eigen::Vector3d& gyro_bias) const {
    const Eigen::Matrix3d& R_b_c = window_.calibration().R_b_c;
    Quadratic sum;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const Eigen::Vector3d phi = pre[i].dR_dbg * (gyro_bias - pre[i].gyro_bias);
      const Eigen::Matrix3d R_bi_bj = pre[i].dR * expSO3(phi);
      // d(bias) -> right perturbation of R_bi_bj.
      const Eigen::Matrix3d J = rightJacobian(phi) * pre[i].dR_dbg;
      if (pairs_[i].count() >= kMinPointsOfPair) {
        addPoints(pairs_[i], R_b_c.transpose() * R_bi_bj * R_b_c, R_b_c.transpose() * J, sum);
      }
      if (vp_active_[i]) addVp(static_cast<int>(i), R_bi_bj, J, sum);
    }
    return sum;
  }

 private:
  void addPoints(const EpipolarPair& pair, const Eigen::Matrix3d& R_ci_cj, const Eigen::Matrix3d& J,
                 Quadratic& sum) const {
    const EpipolarEvaluation at = pair.evaluate(R_ci_cj);
    // The entries of the pre-summed matrix are of the order of the count, and so is the rounding of
    // the eigenvalue; the floor keeps the gradient, which is more exact, in force without noise.
    const double lambda_rounding = 1e-15 * pair.count();
    const double lambda = std::max(at.lambda, lambda_rounding);
    double weight = 0.0;  // d cost / d lambda
    if (problem_.pair_loss == PairLoss::kEigenvalue) {
      const Cauchy rho = cauchy(lambda * lambda, kCauchyScale);
      sum.cost += rho.value;
      weight = 2.0 * lambda * rho.weight;
    } else {
      // Every point adds at most 2 sigma^2 to lambda; three of those sigmas are still an inlier.
      const double sigma = window_.calibration().sigmaBearing();
      const Cauchy rho = cauchy(lambda, 3.0 * sigma * std::sqrt(2.0 * pair.count()));
      sum.cost += rho.value;
      weight = rho.weight;
    }
    sum.rounding += weight * lambda_rounding;
    sum.gradient += weight * (J.transpose() * at.gradient);
    sum.hessian += weight * (J.transpose() * at.hessian * J);
  }

  void addVp(int i, const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& J,
             Quadratic& sum) const {
    Eigen::Vector3d r;
    Eigen::Matrix3d dr;
    vpResidual((*problem_.vanishing_points)[i].direction,
               (*problem_.vanishing_points)[i + 1].direction, R_bi_bj, window_.calibration().R_b_c,
               &r, &dr);
    const Cauchy rho = cauchy(r.squaredNorm(), problem_.vp_options.vp_cauchy_scale);
    sum.cost += lambda_vp_ * rho.value;
    dr *= J;
    sum.gradient += 2.0 * lambda_vp_ * rho.weight * (dr.transpose() * r);
    sum.hessian += 2.0 * lambda_vp_ * rho.weight * (dr.transpose() * dr);
  }

  const InitWindow& window_;
  const GyroBiasProblem& problem_;
  std::vector<EpipolarPair> pairs_;  // consecutive keyframes (i, i + 1)
  std::vector<bool> vp_active_;      // indicator of IV-B-2
  double lambda_vp_ = 0.0;
  int point_pairs_ = 0;
};

}  // namespace

void vpResidual(const Eigen::Vector3d& d_i, const Eigen::Vector3d& d_j,
                const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                Eigen::Vector3d* residual, Eigen::Matrix3d* jacobian) {
  Eigen::Vector3d u_b = R_bi_bj.transpose() * (R_b_c * d_i);  // d_i seen from b_j
  Eigen::Vector3d u_c = R_b_c.transpose() * u_b;
  if (u_c.dot(d_j) < 0.0) {
    // A vanishing direction has no sign.
    u_b = -u_b;
    u_c = -u_c;
  }
  *residual = d_j.cross(u_c);
  // (R Exp(phi))^T u = R^T u - phi x R^T u = R^T u + [R^T u]x phi.
  if (jacobian != nullptr) *jacobian = skew(d_j) * R_b_c.transpose() * skew(u_b);
}

bool isReliablePair(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                    const std::array<double, 2>& consistency_rad, const SlimPaperOptions& options) {
  const double max_consistency_rad = options.consistency_threshold_deg / kDegPerRad;
  return vp_i.found && vp_j.found && vp_i.track_id >= 0 && vp_i.track_id == vp_j.track_id &&
         vp_j.age >= options.min_track_age && consistency_rad[0] <= max_consistency_rad &&
         consistency_rad[1] <= max_consistency_rad;
}

double consistencyOf(const VanishingPoint& vp, const std::vector<WindowLine>& lines) {
  double sum = 0.0;
  for (const int l : vp.inliers) {
    const double error = lines[l].normal.dot(vp.direction);
    sum += error * error;
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(vp.inliers.size(), 1)));
}

GyroBiasEstimate estimateGyroBias(const InitWindow& window, const GyroBiasProblem& problem) {
  const Objective objective(window, problem);
  GyroBiasEstimate estimate;
  estimate.point_pairs = objective.pointPairs();
  if (estimate.point_pairs == 0) return estimate;

  for (int round = 0; round < kMaxRelinearizations; ++round) {
    const Eigen::Vector3d start = estimate.gyro_bias;
    const std::vector<Preintegration> pre =
        preintegrateWindow(window, start, Eigen::Vector3d::Zero(), PreintegrationParts::kRotation);
    const auto evaluate = [&](const Eigen::Vector3d& gyro_bias) {
      return objective.evaluate(pre, gyro_bias);
    };
    LevenbergMarquardtOptions steps;
    steps.max_iterations = kMaxIterations;
    steps.first_damping = kInitialDamping;
    steps.largest_damping = kMaxDamping;
    steps.relative_decrease = 0.5 * kCostTolerance;
    steps.shortest_step = kStepTolerance;
    Quadratic at = evaluate(estimate.gyro_bias);
    minimizeLevenbergMarquardt(steps, evaluate, dampDiagonal, &estimate.gyro_bias, &at, isBetter);
    if ((estimate.gyro_bias - start).norm() < kRelinearizeTolerance) break;
  }
  estimate.valid = estimate.gyro_bias.allFinite() && estimate.gyro_bias.norm() <= kMaxGyroBias;
  return estimate;
}

}  // namespace slim_init::baselines
