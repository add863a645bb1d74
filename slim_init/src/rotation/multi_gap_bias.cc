// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/multi_gap_bias.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "geometry/robust.h"
#include "geometry/so3.h"

namespace slim_init {

namespace {

// Keyframes, and points in every pair two keyframes apart, from which consecutive pairs stay out
// of the minimisation: they add a third to the time and then little to the bias.
constexpr int kMinKeyframesToSkip = 8;
constexpr int kPointsToSkip = 25;
// Standard deviation of a rotation of the gyroscope itself, by vibration and scale error [rad]: no
// pair is more exact, however many points it has.
constexpr double kGyroError = 1e-3;

// The shortest gap that enters a minimisation.
int shortestGap(const KeyframePairs& pairs) {
  if (pairs.keyframes() < kMinKeyframesToSkip) return 1;
  const bool longer_suffice = std::all_of(pairs.begin(), pairs.end(), [](const KeyframePair& pair) {
    return pair.gap() != 2 || pair.points.count() >= kPointsToSkip;
  });
  return longer_suffice ? 2 : 1;
}

Eigen::Matrix<double, 7, 7> dampDiagonal(const QuadraticModel<7>& at, double damping) {
  Eigen::Matrix<double, 7, 7> H = at.hessian;
  H.diagonal() *= 1.0 + damping;
  return H;
}

}  // namespace

MultiGapProblem::MultiGapProblem(const InitWindow& window,
                                 const std::vector<VanishingPoint>* vanishing_points,
                                 const InertialOptions& inertial, const RigPrior& rig)
    : window_(window),
      vps_(vanishing_points),
      known_bias_(assumedImuBiases(window.calibration().imu_biases, inertial).gyro),
      gyro_bias_prior_(inertial.gyro_bias_prior),
      rig_(rig),
      pairs_(window, kLongestGap),
      shortest_gap_(shortestGap(pairs_)),
      gyro_(window) {}

RotationUnknowns MultiGapProblem::priorMean() const {
  RotationUnknowns x = RotationUnknowns::Zero();
  x.head<3>() = known_bias_;
  return x;
}

bool MultiGapProblem::enters(const KeyframePair& pair, int max_gap) const {
  return pair.gap() >= shortest_gap_ && pair.gap() <= max_gap;
}

double MultiGapProblem::shareOf(int max_gap) const {
  const auto count = std::count_if(std::begin(kGaps), std::end(kGaps), [&](int gap) {
    return gap >= shortest_gap_ && gap <= max_gap && gap < pairs_.keyframes();
  });
  return 1.0 / static_cast<double>(std::max<std::ptrdiff_t>(count, 1));
}

bool MultiGapProblem::sameVanishingPoint(const KeyframePair& pair) const {
  if (vps_ == nullptr) return false;
  const VanishingPoint& vp_i = (*vps_)[pair.i];
  const VanishingPoint& vp_j = (*vps_)[pair.j];
  return vp_i.found && vp_j.found && vp_i.track_id == vp_j.track_id;
}

PairRotations MultiGapProblem::rotationsAt(const RotationUnknowns& x, int max_gap) {
  gyro_.linearizeNear(x);
  return gyro_.at(x, pairs_, max_gap);
}

void MultiGapProblem::addPoints(std::size_t p, const PairRotation& rotation, double share,
                                const NormalizedEpipolarPair& weighted, Eigen::Vector3d* baseline,
                                QuadraticModel<7>* sum) const {
  if (!pairs_[p].use_points || !(weighted.robustCount() > kPairUnknowns)) return;
  const double sigma2 = pairs_.sigma() * pairs_.sigma();
  const NormalizedEvaluation at =
      weighted.evaluate(rotation.R_ci_cj, kBaselinePriorSigmas2 * sigma2, *baseline);
  const double n = weighted.robustCount();
  const double scale = share * n / (sigma2 + n / kPairUnknowns * kGyroError * kGyroError);
  sum->cost += scale * at.lambda;
  sum->gradient += scale * (rotation.J.transpose() * at.gradient);
  sum->hessian += scale * (rotation.J.transpose() * at.hessian * rotation.J);
  *baseline = at.baseline;
}

void MultiGapProblem::addVanishingPoints(std::size_t p, const PairRotation& rotation, double share,
                                         QuadraticModel<7>* sum) const {
  if (!sameVanishingPoint(pairs_[p])) return;
  const Eigen::Matrix3d& R_b_c = window_.calibration().R_b_c;
  const double c2 = kOutlierSigmas * kOutlierSigmas;
  Eigen::Vector2d z;
  Eigen::Matrix<double, 2, 3> dz;
  whitenedVpResidual((*vps_)[pairs_[p].i], (*vps_)[pairs_[p].j],
                     R_b_c * rotation.R_ci_cj * R_b_c.transpose(), R_b_c, &z, &dz);
  const double weight = 1.0 / (1.0 + z.squaredNorm() / c2);
  const Eigen::Matrix<double, 2, 7> J = dz * R_b_c * rotation.J;
  sum->cost += share * c2 * std::log1p(z.squaredNorm() / c2);
  sum->gradient += 2.0 * share * weight * (J.transpose() * z);
  sum->hessian += 2.0 * share * weight * (J.transpose() * J);
}

void MultiGapProblem::addPriors(const RotationUnknowns& x, QuadraticModel<7>* sum) const {
  // What was known of a sensor may be wrong: here it is no more than a start.
  const Eigen::Vector3d off = x.head<3>() - known_bias_;
  const double information = 1.0 / (gyro_bias_prior_ * gyro_bias_prior_);
  sum->cost += information * off.squaredNorm();
  sum->gradient.head<3>() += 2.0 * information * off;
  sum->hessian.diagonal().head<3>().array() += 2.0 * information;
  RigError rig = rig_.mean;  // with nothing known of the rest
  rig.dR = expSO3(x.segment<3>(3));
  rig.dtd = x[6];
  const RigPriorTerm term = rigPriorTerm(rig_, rig);
  const Eigen::Matrix3d J = rightJacobian(x.segment<3>(3));
  const int td = 6;  // in both
  sum->cost += term.cost;
  sum->gradient.segment<3>(3) += 2.0 * (J.transpose() * term.g.head<3>());
  sum->gradient[td] += 2.0 * term.g[td];
  sum->hessian.block<3, 3>(3, 3) += 2.0 * (J.transpose() * term.H.topLeftCorner<3, 3>() * J);
  sum->hessian(td, td) += 2.0 * term.H(td, td);
}

QuadraticModel<7> MultiGapProblem::evaluate(const RotationUnknowns& x, int max_gap,
                                            const WeightedPairs& weighted,
                                            Baselines* baselines) const {
  const PairRotations rotations = gyro_.at(x, pairs_, max_gap);
  const double share = shareOf(max_gap);
  QuadraticModel<7> sum;
  addPriors(x, &sum);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    if (!enters(pairs_[p], max_gap)) continue;
    addPoints(p, rotations[p], share, weighted[p], &(*baselines)[p], &sum);
    addVanishingPoints(p, rotations[p], share, &sum);
  }
  return sum;
}

WeightedPairs MultiGapProblem::weigh(const RotationUnknowns& x, int max_gap, double cutoff_sigmas,
                                     const PointMasks& masks, Baselines* baselines) {
  const PairRotations rotations = rotationsAt(x, max_gap);
  const Eigen::ArrayXd all_points;
  WeightedPairs weighted(pairs_.size());
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const KeyframePair& pair = pairs_[p];
    if (!pair.use_points || !enters(pair, max_gap)) continue;
    const Eigen::ArrayXd& mask = masks.empty() ? all_points : masks[p];
    const Eigen::Matrix3d& R = rotations[p].R_ci_cj;
    Eigen::Vector3d& baseline = (*baselines)[p];
    const bool known = baseline.squaredNorm() > 0.0;
    weighted[p].weigh(pair.points, mask, R, baseline, pairs_.sigma(), cutoff_sigmas);
    if (known) continue;
    baseline = weighted[p].baseline(R, baseline);
    weighted[p].weigh(pair.points, mask, R, baseline, pairs_.sigma(), cutoff_sigmas);
  }
  return weighted;
}

RotationMinimum MultiGapProblem::minimize(const RotationUnknowns& start, int max_gap,
                                          const CutoffSchedule& schedule, const PointMasks& masks,
                                          Baselines baselines) {
  RotationMinimum out;
  out.x = start;
  out.baselines = std::move(baselines);
  for (const double cutoff : schedule) {
    if (!out.x.allFinite()) break;
    out.weighted = weigh(out.x, max_gap, cutoff, masks, &out.baselines);
    const auto evaluateAt = [&](const RotationUnknowns& x) {
      return evaluate(x, max_gap, out.weighted, &out.baselines);
    };
    QuadraticModel<7> at = evaluateAt(out.x);
    out.iterations += minimizeLevenbergMarquardt({}, evaluateAt, dampDiagonal, &out.x, &at);
  }
  return out;
}

Baselines MultiGapProblem::baselinesAt(const RotationMinimum& minimum, int max_gap) const {
  Baselines baselines = minimum.baselines;
  evaluate(minimum.x, max_gap, minimum.weighted, &baselines);
  return baselines;
}

void whitenedVpResidual(const VanishingPoint& vp_i, const VanishingPoint& vp_j,
                        const Eigen::Matrix3d& R_bi_bj, const Eigen::Matrix3d& R_b_c,
                        Eigen::Vector2d* residual, Eigen::Matrix<double, 2, 3>* jacobian) {
  const Eigen::Matrix3d R_cj_ci = R_b_c.transpose() * R_bi_bj.transpose() * R_b_c;
  Eigen::Vector3d u_b = R_bi_bj.transpose() * (R_b_c * vp_i.direction);
  Eigen::Vector3d u_c = R_b_c.transpose() * u_b;
  if (u_c.dot(vp_j.direction) < 0.0) {
    u_b = -u_b;
    u_c = -u_c;
  }
  const Eigen::Matrix<double, 3, 2> B = tangentBasis(vp_j.direction);
  const Eigen::Matrix2d covariance =
      B.transpose() * (vp_j.covariance + R_cj_ci * vp_i.covariance * R_cj_ci.transpose()) * B;
  const Eigen::Matrix2d L = covariance.llt().matrixL();
  const Eigen::Matrix2d W = L.triangularView<Eigen::Lower>().solve(Eigen::Matrix2d::Identity());
  *residual = W * (B.transpose() * u_c);
  // R^T Exp(-phi): d(R^T u) = [R^T u]x phi.
  if (jacobian != nullptr) *jacobian = W * B.transpose() * R_b_c.transpose() * skew(u_b);
}

}  // namespace slim_init
