// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/multi_gap_bias.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/so3.h"
#include "rotation/link_table.h"

namespace slim_init {
namespace {

constexpr int kGaps[] = {1, 2, 4, 8};
constexpr double kStepTolerance = 1e-12;  // [rad/s]
// How far [rad/s] the bias may be from where the gyro was integrated: the correction of first order
// is then wrong by less than 1e-6 rad over two seconds, a hundredth of what the points know.
constexpr double kRelinearizeTolerance = 1e-3;
constexpr double kRoughTolerance = 0.02;  // [rad/s]; the same, below 1e-5 rad: for a search
// Expected decrease at which a round ends, relative to the cost, a chi-square of a thousand: a
// thousandth of a standard deviation of the bias at the end, a tenth before.
constexpr double kCostTolerance = 1e-9;
constexpr double kRoundTolerance = 1e-5;
constexpr double kBaselinePriorSigmas2 = 0.5;  // regularisation of the baseline, in sigma^2
constexpr double kMinRobustCount = 5.0;        // below, a pair says nothing about the rotation
// Mean squared residual of good data is one; a baseline that leaves less than this needs no rival.
constexpr double kGoodEnough = 1.3;
constexpr double kCurvatureShare = 0.02;
// The scatter misses what the choice of outliers and of the minimum adds; measured over windows of
// eleven motions the errors are 1.2 times what it says.
constexpr double kScatterInflation = 1.5;
constexpr int kHypotheses = 20;
// Freed rotations: with a wider cutoff than this the baseline at hand is not to be trusted; damping
// where a narrow view hardly tells a rotation from a translation; and the largest answer [rad].
constexpr double kWideCutoff = 5.0;
constexpr int kFreeSteps = 3;
constexpr double kFreeDamping = 1e-3;
constexpr double kLargestCorrection = 0.3;
// Keyframes and points per pair from which consecutive pairs stay out of the minimisation.
constexpr int kMinKeyframesToSkip = 8;
constexpr int kPointsToSkip = 25;

}  // namespace

MultiGapProblem::MultiGapProblem(const InitWindow& window,
                                 const std::vector<VanishingPoint>* vanishing_points,
                                 const MultiGapBiasOptions& options)
    : window_(window),
      vps_(vanishing_points),
      options_(options),
      sigma_(window.calibration().sigmaBearing()) {
  const int n = window.size();
  std::vector<int> index(n * n, -1), count(n * n, 0);
  int pairs = 0;
  for (int gap : kGaps) {
    if (gap >= n || gap > options.max_gap) continue;
    for (int i = 0; i + gap < n; ++i) index[i * n + i + gap] = pairs++;
  }
  const std::vector<PointSighting>& s = window.pointSightings();
  for (const Track& track : window.pointTracks()) {
    for (int a = track.begin; a < track.end; ++a) {
      for (int b = a + 1; b < track.end; ++b) ++count[s[a].keyframe * n + s[b].keyframe];
    }
  }
  pairs_.resize(pairs);
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      if (index[i * n + j] < 0) continue;
      Pair& pair = pairs_[index[i * n + j]];
      pair.i = i;
      pair.j = j;
      const int points = count[i * n + j];
      pair.points.reserve(points);
      pair.sighting_i.reserve(points);
      pair.sighting_j.reserve(points);
      pair.track.reserve(points);
    }
  }
  for (std::size_t t = 0; t < window.pointTracks().size(); ++t) {
    const Track& track = window.pointTracks()[t];
    for (int a = track.begin; a < track.end; ++a) {
      for (int b = a + 1; b < track.end; ++b) {
        const int p = index[s[a].keyframe * n + s[b].keyframe];
        if (p < 0) continue;
        pairs_[p].points.add(s[a].bearing, s[b].bearing);
        pairs_[p].sighting_i.push_back(a);
        pairs_[p].sighting_j.push_back(b);
        pairs_[p].track.push_back(static_cast<int>(t));
      }
    }
  }
  for (Pair& pair : pairs_) {
    pair.use_points = pair.points.count() >= options.min_points_per_pair;
    pair.use_vp = vps_ != nullptr && (*vps_)[pair.i].found && (*vps_)[pair.j].found &&
                  (*vps_)[pair.i].track_id == (*vps_)[pair.j].track_id;
    point_pairs_ += pair.use_points ? 1 : 0;
    vp_pairs_ += pair.use_vp ? 1 : 0;
  }
  if (options.max_gap >= 2 && n >= kMinKeyframesToSkip) {
    bool enough = true;
    for (const Pair& pair : pairs_) {
      enough &= pair.j - pair.i != 2 || pair.points.count() >= kPointsToSkip;
    }
    if (enough) default_min_gap_ = 2;
    min_gap_ = default_min_gap_;
  }
  pre_ = preintegrateWindow(window, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                            PreintegrationParts::kRotation);
  attitude_.resize(n);
  derivative_.resize(n);
}

void MultiGapProblem::linearizeNear(const Eigen::Vector3d& gyro_bias, double tolerance) {
  if ((gyro_bias - pre_.front().gyro_bias).norm() <= tolerance) return;
  pre_ = preintegrateWindow(window_, gyro_bias, Eigen::Vector3d::Zero(),
                            PreintegrationParts::kRotation);
}

void MultiGapProblem::rotateTo(const Eigen::Vector3d& gyro_bias, int max_gap) {
  const Eigen::Matrix3d R_c_b = window_.calibration().R_b_c.transpose();
  // R_c0_ck, and in c0 the rotation vector by which the bias moves it.
  attitude_[0].setIdentity();
  derivative_[0].setZero();
  for (std::size_t k = 0; k < pre_.size(); ++k) {
    const Eigen::Vector3d phi = pre_[k].dR_dbg * (gyro_bias - pre_[k].gyro_bias);
    attitude_[k + 1] = attitude_[k] * (R_c_b * (pre_[k].dR * expSO3(phi)) * R_c_b.transpose());
    derivative_[k + 1] =
        derivative_[k] + attitude_[k + 1] * (R_c_b * (rightJacobian(phi) * pre_[k].dR_dbg));
  }
  for (Pair& pair : pairs_) {
    if (pair.j - pair.i > max_gap) continue;
    const Eigen::Matrix3d Rt = attitude_[pair.j].transpose();
    pair.R = attitude_[pair.i].transpose() * attitude_[pair.j];
    pair.dR_dbg = Rt * (derivative_[pair.j] - derivative_[pair.i]);
  }
}

void MultiGapProblem::clearBaselines() {
  for (Pair& pair : pairs_) pair.baseline.setZero();
}

double MultiGapProblem::findBaselines(const Eigen::Vector3d& gyro_bias, int max_gap,
                                      double truncation_sigmas, int hypotheses, bool reuse) {
  linearizeNear(gyro_bias, kRoughTolerance);
  rotateTo(gyro_bias, max_gap);
  double sum = 0.0;
  int points = 0;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    Pair& pair = pairs_[p];
    if (!pair.use_points || pair.j - pair.i > max_gap) continue;
    double cost = 0.0;
    pair.baseline = pair.points.consensusBaseline(pair.R, sigma_, truncation_sigmas, hypotheses,
                                                  static_cast<unsigned>(p), pair.baseline,
                                                  reuse ? kGoodEnough : 0.0, &consensus_, &cost);
    sum += cost;
    points += pair.points.count();
  }
  return sum / std::max(points, 1);
}

double MultiGapProblem::share(int max_gap) const {
  int gaps = 0;
  for (int gap : kGaps) gaps += gap >= min_gap_ && gap <= max_gap && gap < window_.size() ? 1 : 0;
  return 1.0 / std::max(gaps, 1);
}

MultiGapProblem::Quadratic MultiGapProblem::evaluate(const Eigen::Vector3d& gyro_bias,
                                                     int max_gap) {
  rotateTo(gyro_bias, max_gap);
  const Eigen::Matrix3d& R_b_c = window_.calibration().R_b_c;
  const double sigma2 = sigma_ * sigma_;
  const double c2 = options_.cauchy_sigmas * options_.cauchy_sigmas;
  // A point enters once per gap; its information counts about once.
  const double share = this->share(max_gap);
  const double prior = 1.0 / (options_.bias_prior * options_.bias_prior);
  Quadratic sum;
  sum.cost = prior * gyro_bias.squaredNorm();
  sum.gradient = 2.0 * prior * gyro_bias;
  sum.hessian = 2.0 * prior * Eigen::Matrix3d::Identity();
  for (Pair& pair : pairs_) {
    if (!enters(pair, max_gap)) continue;
    if (pair.use_points && pair.points.robustCount() > kMinRobustCount) {
      const NormalizedEvaluation at = pair.points.evaluate(pair.R, kBaselinePriorSigmas2 * sigma2);
      const double scale = share * pair.points.robustCount() / sigma2;
      sum.cost += scale * at.lambda;
      sum.gradient += scale * (pair.dR_dbg.transpose() * at.gradient);
      sum.hessian += scale * (pair.dR_dbg.transpose() * at.hessian * pair.dR_dbg);
      pair.baseline = at.baseline;
    }
    if (pair.use_vp) {
      Eigen::Vector2d z;
      Eigen::Matrix<double, 2, 3> dz;
      whitenedVpResidual((*vps_)[pair.i], (*vps_)[pair.j], R_b_c * pair.R * R_b_c.transpose(),
                         R_b_c, options_.vp_inflation, &z, &dz);
      const double weight = 1.0 / (1.0 + z.squaredNorm() / c2);
      const Eigen::Matrix<double, 2, 3> J = dz * R_b_c * pair.dR_dbg;
      sum.cost += share * c2 * std::log1p(z.squaredNorm() / c2);
      sum.gradient += 2.0 * share * weight * (J.transpose() * z);
      sum.hessian += 2.0 * share * weight * (J.transpose() * J);
    }
  }
  return sum;
}

void MultiGapProblem::refreshWeights(const Eigen::Vector3d& gyro_bias, int max_gap,
                                     double cutoff_sigmas) {
  linearizeNear(gyro_bias, kRelinearizeTolerance);
  rotateTo(gyro_bias, max_gap);
  for (Pair& pair : pairs_) {
    if (!pair.use_points || !enters(pair, max_gap)) continue;
    if (pair.baseline.squaredNorm() == 0.0) {
      pair.points.resetWeights();
      pair.baseline = pair.points.evaluate(pair.R, 0.0).baseline;
    }
    pair.points.updateWeights(pair.R, pair.baseline, sigma_, cutoff_sigmas, &residuals_);
  }
}

Eigen::Vector3d MultiGapProblem::minimize(const Eigen::Vector3d& start, int max_gap,
                                          std::initializer_list<double> cutoff_sigmas,
                                          int* iterations) {
  Eigen::Vector3d bias = start;
  for (const double& cutoff : cutoff_sigmas) {
    const bool last = &cutoff == cutoff_sigmas.end() - 1;
    if (!bias.allFinite()) break;
    refreshWeights(bias, max_gap, cutoff);
    Quadratic at = evaluate(bias, max_gap);
    double damping = 1e-4;
    // The weights of the next round move the minimum anyway.
    const double tolerance = last ? kCostTolerance : kRoundTolerance;
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      Eigen::Matrix3d H = at.hessian;
      H.diagonal() *= 1.0 + damping;
      const Eigen::Vector3d step = -H.ldlt().solve(at.gradient);
      const double decrease = -0.5 * at.gradient.dot(step);
      if (!step.allFinite() || decrease <= tolerance * at.cost) break;
      const Quadratic there = evaluate(bias + step, max_gap);
      if (there.cost < at.cost) {
        bias += step;
        at = there;
        ++*iterations;
        damping = std::max(0.1 * damping, 1e-12);
      } else {
        damping *= 10.0;
      }
      if (step.norm() < kStepTolerance || damping > 1e6) break;
    }
  }
  return bias;
}

TrackPruning MultiGapProblem::prune(const Eigen::Vector3d& gyro_bias, double threshold_sigmas,
                                    int hypotheses, bool reuse) {
  LinkTable links(window_);
  findBaselines(gyro_bias, kMaxLinkGap, threshold_sigmas, hypotheses, reuse);
  int pairs = 0;
  for (Pair& pair : pairs_) {
    const int gap = pair.j - pair.i;
    if (!pair.use_points || gap > kMaxLinkGap || pair.baseline.squaredNorm() == 0.0) continue;
    ++pairs;
    pair.points.clearMask();
    // The winner of the draw went exactly through two noisy points.
    pair.points.updateWeights(pair.R, pair.baseline, sigma_, threshold_sigmas, &residuals_);
    pair.baseline = pair.points.evaluate(pair.R, 0.0).baseline;
    pair.points.residuals(pair.R, pair.baseline, sigma_, &residuals_);
    // Over a longer gap the rotation is less certain and the track has drifted.
    const double limit = threshold_sigmas * threshold_sigmas * (gap > 2 ? 2.0 : 1.0);
    for (int k = 0; k < pair.points.count(); ++k) {
      links.set(pair.sighting_i[k], gap, !(residuals_.z2[k] > limit));
    }
  }
  TrackPruning out = links.prune();
  out.pairs = pairs;
  return out;
}

void MultiGapProblem::keepOnly(const std::vector<char>& keep) {
  for (Pair& pair : pairs_) pair.points.clearMask();
  if (keep.empty()) return;
  // Number of the piece of track that a sighting belongs to.
  std::vector<int> piece(keep.size(), -1);
  int id = 0;
  for (const Track& track : window_.pointTracks()) {
    ++id;
    for (int a = track.begin; a < track.end; ++a) {
      if (keep[a] == kStartTrack) ++id;
      if (keep[a] != kDropSighting) piece[a] = id;
    }
  }
  for (Pair& pair : pairs_) {
    for (int k = 0; k < pair.points.count(); ++k) {
      const int a = piece[pair.sighting_i[k]];
      if (a < 0 || a != piece[pair.sighting_j[k]]) pair.points.mask(k);
    }
  }
}

std::vector<RotationCorrection> MultiGapProblem::freeRotations(
    const Eigen::Vector3d& gyro_bias, int gap, std::initializer_list<double> cutoff_sigmas) {
  std::vector<RotationCorrection> out;
  const double prior = kBaselinePriorSigmas2 * sigma_ * sigma_;
  linearizeNear(gyro_bias, kRelinearizeTolerance);
  rotateTo(gyro_bias, gap);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    Pair& pair = pairs_[p];
    if (!pair.use_points || pair.j - pair.i != gap) continue;
    pair.points.clearMask();
    Eigen::Matrix3d R = pair.R;
    Eigen::Vector3d baseline = pair.baseline;
    NormalizedEvaluation at;
    bool determined = true;
    for (const double cutoff : cutoff_sigmas) {
      if (baseline.squaredNorm() == 0.0 || cutoff > kWideCutoff) {
        double cost = 0.0;
        baseline =
            pair.points.consensusBaseline(R, sigma_, cutoff, kHypotheses, static_cast<unsigned>(p),
                                          baseline, 0.0, &consensus_, &cost);
      }
      pair.points.updateWeights(R, baseline, sigma_, cutoff, &residuals_);
      determined = determined && pair.points.robustCount() > kMinRobustCount;
      for (int step = 0; step < kFreeSteps && determined; ++step) {
        at = pair.points.evaluate(R, prior);
        Eigen::Matrix3d H = at.hessian;
        H.diagonal() *= 1.0 + kFreeDamping;
        const Eigen::Vector3d delta = -H.ldlt().solve(at.gradient);
        determined = delta.allFinite() && delta.norm() < kLargestCorrection;
        if (determined) R = R * expSO3(delta);
      }
      baseline = at.baseline;
    }
    const Eigen::Vector3d phi = logSO3(pair.R.transpose() * R);
    if (!determined || !(phi.norm() < kLargestCorrection)) continue;
    // Half the Hessian of a chi-square is an information.
    const Eigen::Matrix3d information =
        0.5 * pair.points.robustCount() / (sigma_ * sigma_) * at.hessian;
    out.push_back({pair.i, pair.j, pair.R, pair.dR_dbg, phi, information});
  }
  return out;
}

Eigen::Matrix3d MultiGapProblem::information(const Eigen::Vector3d& gyro_bias,
                                             double gyro_noise_inflation) {
  const int max_gap = options_.max_gap;
  const double share = this->share(max_gap);
  const double sigma2 = sigma_ * sigma_;
  const Eigen::Matrix3d H_inverse = evaluate(gyro_bias, max_gap).hessian.inverse();
  std::vector<Eigen::Vector3d> gradients(window_.pointTracks().size(), Eigen::Vector3d::Zero());
  for (const Pair& pair : pairs_) {
    if (!enters(pair, max_gap)) continue;
    if (!pair.use_points || pair.points.robustCount() <= kMinRobustCount) continue;
    pair.points.scatterGradients(pair.R, kBaselinePriorSigmas2 * sigma2,
                                 share * pair.points.robustCount() / sigma2, pair.dR_dbg,
                                 pair.track, &gradients);
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& g : gradients) scatter += g * g.transpose();
  // Curvature of chi-square: the classical covariance is twice its inverse. It stands for the VP
  // and prior terms, has its share where there is nothing to scatter, and bounds the result away
  // from zero without noise.
  const Eigen::Matrix3d covariance =
      kScatterInflation * (H_inverse * scatter * H_inverse) + kCurvatureShare * 2.0 * H_inverse;
  const double duration = window_.times().back() - window_.times().front();
  const double gyro = gyro_noise_inflation * window_.calibration().imu_noise.gyro_density;
  return (covariance + gyro * gyro / duration * Eigen::Matrix3d::Identity()).inverse();
}

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
  MultiGapProblem problem(window, vanishing_points, options);
  MultiGapBiasEstimate best;
  best.point_pairs = problem.pointPairs();
  best.vp_pairs = problem.vpPairs();
  if (best.point_pairs + best.vp_pairs == 0) return best;
  for (const Eigen::Vector3d& start : starts) {
    problem.clearBaselines();
    problem.findBaselines(start, options.max_gap, 10.0, kHypotheses, false);
    const Eigen::Vector3d bias =
        problem.minimize(start, options.max_gap, {10.0, 5.0, 3.0, 3.0}, &best.iterations);
    if (!bias.allFinite() || bias.norm() > options.max_bias) continue;
    const double cost = problem.findBaselines(bias, options.max_gap, 3.0, 0, false);
    if (best.valid && cost >= best.cost) continue;
    best.valid = true;
    best.gyro_bias = bias;
    best.cost = cost;
    best.information = problem.information(bias, 1.0);
  }
  return best;
}

}  // namespace slim_init
