// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/free_rotations.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/minimize.h"
#include "geometry/robust.h"
#include "geometry/so3.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {
namespace {

// Where the rotation is near.
const CutoffSchedule kNear = {3.0};
// Share of its variance that a Gaussian has within kOutlierSigmas.
constexpr double kVarianceWithinCutoff = 0.9733;
// From the median on the standard deviation has settled to a percent after so many rounds.
constexpr int kNoiseRounds = 10;
// Median of the square of a Gaussian.
constexpr double kMedianOfSquare = 0.45494;

// Minimum over R near that of `at`, weights fixed.
void minimizeRotation(const NormalizedEpipolarPair& weighted, double baseline_prior,
                      RelativeRotation* at) {
  const Eigen::Matrix3d R = at->R_ci_cj;
  const auto evaluate = [&](const Eigen::Vector3d& phi) {
    const NormalizedEvaluation there =
        weighted.evaluate(R * expSO3(phi), baseline_prior, at->baseline);
    const Eigen::Matrix3d J = rightJacobian(phi);
    return QuadraticModel<3>{there.lambda, J.transpose() * there.gradient,
                             J.transpose() * there.hessian * J};
  };
  // In all directions alike: a wrong rotation of a pair with little parallax leaves some without
  // curvature, along which Newton's step has no bound.
  const auto damp = [](const QuadraticModel<3>& model, double damping) -> Eigen::Matrix3d {
    return model.hessian + damping * model.hessian.trace() * Eigen::Matrix3d::Identity();
  };
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();
  QuadraticModel<3> model = evaluate(phi);
  minimizeLevenbergMarquardt({}, evaluate, damp, &phi, &model);
  at->R_ci_cj = R * expSO3(phi);
}

// From `at` on; false where the points do not determine the rotation. `seed` of the baselines that
// are drawn.
bool freeRotation(const PairPoints& points, double sigma, const CutoffSchedule& schedule,
                  unsigned seed, RelativeRotation* at) {
  const double baseline_prior = kBaselinePriorSigmas2 * sigma * sigma;
  NormalizedEpipolarPair weighted;
  for (const double cutoff : schedule) {
    // With a wide one the known baseline is not trusted.
    if (at->baseline.squaredNorm() == 0.0 || cutoff > kOutlierSigmas) {
      at->baseline =
          points.consensusBaseline(at->R_ci_cj, sigma, {cutoff}, seed, at->baseline).direction;
    }
    weighted.weigh(points, {}, at->R_ci_cj, at->baseline, sigma, cutoff);
    if (!(weighted.robustCount() > kPairUnknowns)) return false;
    minimizeRotation(weighted, baseline_prior, at);
    const NormalizedEvaluation minimum =
        weighted.evaluate(at->R_ci_cj, baseline_prior, at->baseline);
    at->baseline = minimum.baseline;
    // Half the Hessian of a chi-square is an information.
    at->information = 0.5 * weighted.robustCount() / (sigma * sigma) * minimum.hessian;
  }
  return at->R_ci_cj.allFinite() && at->information.allFinite();
}

// Where a search from nothing begins: the rotation that comes nearest to explaining the points
// without travel (Wahba's problem), and, since sideways travel and a turn look alike in a narrow
// view, rotations that trade some of one for the other, about the image's axes.
std::vector<Eigen::Matrix3d> startsFor(const PairPoints& points, double flow) {
  // Share of the flow that a rotation may explain, and its largest angle [rad].
  constexpr double kShareOfFlow = 0.7, kMaxAngle = 0.15;
  const Eigen::Matrix3d R =
      nearestRotation(points.bearingsI().matrix().transpose() * points.bearingsJ().matrix());
  const double angle = std::min(kShareOfFlow * flow, kMaxAngle);
  std::vector<Eigen::Matrix3d> starts = {R};
  for (const double turn : {-angle, angle}) {
    starts.push_back(R * expSO3(Eigen::Vector3d(turn, 0.0, 0.0)));
    starts.push_back(R * expSO3(Eigen::Vector3d(0.0, turn, 0.0)));
  }
  return starts;
}

// Robust standard deviation of a bearing across its epipolar plane [rad].
double spread(const PairPoints& points, const RelativeRotation& at) {
  const Eigen::ArrayXd z2 = points.residuals(at.R_ci_cj, at.baseline, 1.0).z2;
  return std::max(std::sqrt(noiseVariance({z2.begin(), z2.end()})), kSmallestAngle);
}

}  // namespace

std::vector<RelativeRotation> freeRotations(const KeyframePairs& pairs,
                                            const PairRotations& rotations,
                                            const Baselines& baselines, int gap) {
  std::vector<RelativeRotation> out;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!pairs[p].use_points || pairs[p].gap() != gap) continue;
    RelativeRotation at;
    at.R_ci_cj = rotations[p].R_ci_cj;
    at.baseline = baselines[p];
    at.pair = p;
    if (freeRotation(pairs[p].points, pairs.sigma(), kNear, static_cast<unsigned>(p), &at)) {
      out.push_back(at);
    }
  }
  return out;
}

bool relativeRotation(const PairPoints& points, double sigma, RelativeRotation* result) {
  // Five unknowns, and three points more to tell a gross error.
  constexpr int kMinPoints = 8, kSpreadRounds = 3;
  if (points.count() < kMinPoints) return false;
  const Eigen::ArrayXd flows =
      (points.bearingsI() - points.bearingsJ()).topRows(points.count()).matrix().rowwise().norm();
  const double flow = median({flows.begin(), flows.end()});
  RelativeRotation best;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& R : startsFor(points, flow)) {
    RelativeRotation at;
    at.R_ci_cj = R;
    if (!freeRotation(points, sigma, kWideStart, 0, &at)) continue;
    const double cost =
        points.consensusBaseline(at.R_ci_cj, sigma, {kOutlierSigmas, 0}, 0, at.baseline).cost;
    if (!(cost < lowest)) continue;
    lowest = cost;
    best = at;
  }
  if (!std::isfinite(lowest)) return false;
  // The noise may be another than the one given; that of the points depends on their weights.
  for (int round = 0; round < kSpreadRounds; ++round) {
    if (!freeRotation(points, spread(points, best), kNear, 0, &best)) return false;
  }
  best.residual = spread(points, best);
  best.flow = flow;
  *result = best;
  return true;
}

double noiseVariance(const std::vector<double>& squares) {
  double variance = median(squares) / kMedianOfSquare;
  for (int round = 0; round < kNoiseRounds; ++round) {
    const double limit = kOutlierSigmas * kOutlierSigmas * variance;
    double sum = 0.0, within = 0.0, beyond = 0.0;
    for (const double z2 : squares) {
      if (z2 <= limit) {
        sum += z2;
        within += 1.0;
      } else if (z2 <= 4.0 * limit) {
        beyond += 1.0;
      }
    }
    // Gross errors are spread evenly: as many lie within the cutoff as in the range of the same
    // width beyond it, each with a third of the cutoff's square.
    const double good = sum - beyond * limit / 3.0;
    if (!(within > beyond) || !(good > 0.0)) break;
    variance = good / (within - beyond) / kVarianceWithinCutoff;
  }
  return variance;
}

}  // namespace slim_init
