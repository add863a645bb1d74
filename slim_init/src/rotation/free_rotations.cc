// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/free_rotations.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "geometry/so3.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// Downhill where Newton's step is far beyond what the function looks like here: a wrong rotation of
// a pair with little parallax leaves directions without curvature.
Eigen::Vector3d boundedStep(const Eigen::Matrix3d& hessian, const Eigen::Vector3d& gradient) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(hessian);
  const Eigen::Vector3d& curvature = axes.eigenvalues();  // none below zero, see evaluate()
  const Eigen::Vector3d floored = curvature.cwiseMax(kCurvatureFloor * curvature.maxCoeff());
  const Eigen::Vector3d step =
      -(axes.eigenvectors() * (axes.eigenvectors().transpose() * gradient).cwiseQuotient(floored));
  return step.norm() > kBoundedStep ? Eigen::Vector3d(kBoundedStep / step.norm() * step) : step;
}

// Newton on R with the weights fixed; false where it runs away.
bool minimizeRotation(const NormalizedEpipolarPair& weighted, double baseline_prior,
                      Eigen::Vector3d baseline, Eigen::Matrix3d* R, NormalizedEvaluation* at) {
  for (int step = 0; step < kFreeSteps; ++step) {
    *at = weighted.evaluate(*R, baseline_prior, baseline);
    baseline = at->baseline;
    Eigen::Matrix3d H = at->hessian;
    H.diagonal() *= 1.0 + kFreeDamping;
    Eigen::Vector3d delta = -H.ldlt().solve(at->gradient);
    if (!(delta.norm() < kLargestCorrection)) delta = boundedStep(at->hessian, at->gradient);
    if (!delta.allFinite()) return false;
    *R = *R * expSO3(delta);
  }
  return true;
}

// False where the points do not determine the rotation of the pair with index `p`.
bool freeRotation(const KeyframePairs& pairs, std::size_t p, const PairRotation& rotation,
                  Eigen::Vector3d baseline, const CutoffSchedule& schedule,
                  RotationCorrection* out) {
  const KeyframePair& pair = pairs[p];
  const double sigma = pairs.sigma();
  const Eigen::ArrayXd all_points;
  Eigen::Matrix3d R = rotation.R_ci_cj;
  NormalizedEpipolarPair weighted;
  NormalizedEvaluation at;
  for (const double cutoff : schedule) {
    if (baseline.squaredNorm() == 0.0 || cutoff > kWideCutoff) {
      baseline =
          pair.points.consensusBaseline(R, sigma, {cutoff}, static_cast<unsigned>(p), baseline)
              .direction;
    }
    weighted.weigh(pair.points, all_points, R, baseline, sigma, cutoff);
    if (!(weighted.robustCount() > kMinRobustCount)) return false;
    if (!minimizeRotation(weighted, kBaselinePriorSigmas2 * sigma * sigma, baseline, &R, &at)) {
      return false;
    }
    baseline = at.baseline;
  }
  const Eigen::Vector3d phi = logSO3(rotation.R_ci_cj.transpose() * R);
  if (!(phi.norm() < kLargestCorrection)) return false;
  // Half the Hessian of a chi-square is an information.
  const Eigen::Matrix3d information = 0.5 * weighted.robustCount() / (sigma * sigma) * at.hessian;
  *out = {p, pair.i, pair.j, rotation.R_ci_cj, rotation.dR_dbg, phi, information, at.baseline};
  return true;
}

}  // namespace

std::vector<RotationCorrection> freeRotations(const KeyframePairs& pairs,
                                              const PairRotations& rotations,
                                              const Baselines& baselines, int gap,
                                              const CutoffSchedule& schedule) {
  std::vector<RotationCorrection> out;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!pairs[p].use_points || pairs[p].gap() != gap) continue;
    RotationCorrection correction;
    if (freeRotation(pairs, p, rotations[p], baselines[p], schedule, &correction)) {
      out.push_back(correction);
    }
  }
  return out;
}

}  // namespace slim_init
