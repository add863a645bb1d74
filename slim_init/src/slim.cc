// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim.h"

#include <memory>
#include <sstream>
#include <utility>
#include <vector>

#include "alignment/starting_states.h"
#include "data/with_sightings.h"
#include "estimation/posterior.h"
#include "estimation/refine_window.h"
#include "imu/preintegration.h"
#include "lines/line_agreement.h"
#include "lines/vanishing_point.h"
#include "rotation/robust_bias.h"
#include "solver_support.h"
#include "translation/ligt.h"
#include "verdict/gates.h"

namespace slim_init {
namespace {

// Share of the line sightings cut off above which the line tracks are doubtful. Clean tracks lose
// up to a tenth to the error of the start.
constexpr double kDoubtfulLines = 0.2;
// 99.9 % point of a chi-square with nine degrees of freedom: start velocity, gravity, both biases
// and scale are what lines and points can disagree about.
constexpr double kLineConflict = 28.0;

std::vector<VanishingPoint> findVanishingPoints(const InitWindow& window,
                                                const VanishingPointOptions& options) {
  // The gyro as it is: over one keyframe gap its bias turns less than the matching threshold.
  const std::vector<Preintegration> predicted = preintegrateWindow(
      window, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), PreintegrationParts::kRotation);
  return trackVanishingPoints(
      window, cameraRotations(chainRotations(predicted), window.calibration().R_b_c), options);
}

bool accept(const RobustBias& bias, const RobustBiasOptions& options, InitResult* result) {
  result->counts.gyro_bias_iterations = bias.iterations;
  result->counts.vp_pairs = bias.vp_pairs;
  std::ostringstream message;
  switch (bias.status) {
    case RobustBiasStatus::kOk: result->gyro_bias = bias.gyro_bias; return true;
    case RobustBiasStatus::kTooFewPoints:
      message << "0 keyframe pairs have at least " << options.refinement.min_points_per_pair
              << " common points, needs 1";
      fail(InitStatus::kTooFewTracks, message.str(), result);
      return false;
    case RobustBiasStatus::kNoConsensus:
      message << "a share of " << bias.inlierFraction()
              << " of the point tracks agrees with one gyroscope bias, must be at least "
              << options.min_inlier_fraction
              << " (a wrong extrinsic rotation or time offset does this: try slim_init doctor)";
      fail(InitStatus::kInconsistentResiduals, message.str(), result);
      return false;
    case RobustBiasStatus::kOutOfRange: break;
  }
  message << "gyroscope bias of " << bias.gyro_bias.norm() << " rad/s, must be at most "
          << options.refinement.max_bias;
  fail(InitStatus::kNumericalFailure, message.str(), result);
  return false;
}

// A wrong minimum shows in its chi-square; with few tracks one bad one among them does not.
bool isSuspicious(const RefinedWindow& refined, const InitializerOptions& options) {
  return !refined.valid || refined.chi2 > options.refinement.suspicious_chi2 ||
         refined.point_tracks < options.slim.few_tracks;
}

// The line tracks that agree with the start that more of them agree with.
AgreeingLines agreeingLines(const InitWindow& tracks, const std::vector<WindowState>& starts,
                            const InitializerOptions& options) {
  if (!options.slim.prune_lines || !options.refinement.use_lines) {
    AgreeingLines all;
    all.tracks = tracks.lineTracks();
    return all;
  }
  const Calibration& calibration = tracks.calibration();
  const double bound =
      options.refinement.line_agreement_sigmas * calibration.sigma_line_px / calibration.focal_px;
  AgreeingLines best;
  for (const WindowState& start : starts) {
    AgreeingLines lines =
        agreeingLineTracks(tracks, start, bound, options.refinement.min_line_views);
    if (lines.sightings > best.sightings) best = std::move(lines);
  }
  return best;
}

// Many cut tracks are the mark of a line tracker that confuses lines, and what is left of them need
// not be right. Then the points have the last word: lines that cost them more than a measurement of
// the same motion would are left out.
void checkAgainstPoints(const InitWindow& tracks, const AgreeingLines& lines,
                        const std::vector<Preintegration>& pre,
                        const std::vector<VanishingPoint>* vps, std::vector<WindowState> starts,
                        const InitializerOptions& options, RefinedWindow* refined) {
  if (lines.dropped <= kDoubtfulLines * (lines.dropped + lines.sightings)) return;
  if (refined->valid) starts.insert(starts.begin(), refined->state);
  const RefinedWindow points =
      refineWindow(tracks, {}, pre, vps, starts, StartMode::kFine, options.refinement);
  if (!points.valid) return;
  const bool conflict =
      !refined->valid || refined->cost - refined->line_cost > points.cost + kLineConflict;
  if (conflict) *refined = points;
}

// Starts from the tracks that agree with one inertial trajectory; and where that does not help,
// from all of them coarse to fine. The lowest cost over all tracks wins.
void searchAgain(const InitWindow& tracks, const std::vector<Track>& lines,
                 const std::vector<Preintegration>& pre,
                 const std::vector<Eigen::Matrix3d>& R_c0_ck,
                 const std::vector<VanishingPoint>* vps, const std::vector<WindowState>& starts,
                 const InitializerOptions& options, RefinedWindow* refined) {
  const auto keepLower = [refined](const RefinedWindow& other) {
    if (other.valid && (!refined->valid || other.cost < refined->cost)) *refined = other;
  };
  const std::vector<WindowState> agreeing = consistentStartingStates(
      tracks, pre, R_c0_ck, options.slim, options.alignment, options.reverse_alignment);
  if (!agreeing.empty()) {
    keepLower(
        refineWindow(tracks, lines, pre, vps, agreeing, StartMode::kFine, options.refinement));
  }
  if (refined->valid && refined->chi2 <= options.refinement.suspicious_chi2) return;
  keepLower(refineWindow(tracks, lines, pre, vps, agreeing.empty() ? starts : agreeing,
                         StartMode::kCoarseToFine, options.refinement));
}

// All gates decide, but for one exception: where everything else passes, parallax refuses only what
// is next to the noise of the tracks. The posterior knows better than a bound whether three pixels
// are enough; a window without translation, though, has a small and definite shape made of noise.
void enforceGates(GateMode mode, InitResult* result) {
  if (mode == GateMode::kOff) return;
  bool others_passed = result->hasEstimate();
  for (GateValue& gate : result->gates) {
    gate.enforced = true;
    if (gate.name != "parallax") others_passed = others_passed && gate.passed;
  }
  for (GateValue& gate : result->gates) {
    if (gate.name != "parallax" || !others_passed) continue;
    gate.enforced = !(gate.value >= 0.5 * gate.threshold);
  }
}

}  // namespace

const std::string& Slim::name() const {
  static const std::string kName = "slim";
  return kName;
}

InitResult Slim::solve(const InitWindow& window) const {
  const SlimOptions& use = options_.slim;
  InitResult result = startResult(window);
  StageClock clock(&result);
  if (!hasEnoughKeyframes(window, &result)) return result;

  // Vanishing points of the lines, with their covariance.
  std::vector<VanishingPoint> vanishing_points;
  if (use.vanishing_points) {
    vanishing_points = findVanishingPoints(window, options_.vanishing_point);
  }
  const std::vector<VanishingPoint>* vps = use.vanishing_points ? &vanishing_points : nullptr;
  clock.lap("vanishing_points");

  // Gyroscope bias by consensus; tracks that contradict it go.
  const RobustBias bias = estimateRobustGyroBias(window, vps, options_.robust_bias);
  if (!accept(bias, options_.robust_bias, &result)) return result;
  const std::shared_ptr<const InitWindow> pruned =
      use.prune_tracks ? withSightings(window, bias.pruning.keep) : nullptr;
  const InitWindow& tracks = pruned != nullptr ? *pruned : window;
  clock.lap("gyro_bias");

  // Camera positions up to scale.
  std::vector<Preintegration> pre =
      preintegrateInflated(tracks, result.gyro_bias, Eigen::Vector3d::Zero(), options_.refinement);
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const std::vector<Eigen::Matrix3d> R_c0_ck = cameraRotations(R_b0_bk, window.calibration().R_b_c);
  clock.lap("integration");
  const MotionMeasures motion = measureMotion(tracks, pre, R_b0_bk);
  result.gates = motionGates(motion, options_.gates);
  const std::vector<GateValue> calibration =
      calibrationGates(checkCalibration(window, result.gyro_bias, bias.rotations), options_.gates);
  result.gates.insert(result.gates.end(), calibration.begin(), calibration.end());
  const TranslationEstimate translation = estimateTranslations(tracks, R_c0_ck, options_.alignment);
  clock.lap("translation");

  // Metric starts, and from them the maximum a posteriori estimate.
  RefinedWindow refined;
  Posterior posterior;
  if (translation.valid) {
    const std::vector<WindowState> starts =
        startingStates(tracks, pre, translation, use, options_.reverse_alignment);
    const AgreeingLines lines = agreeingLines(tracks, starts, options_);
    clock.lap("alignment");
    if (use.refine && !starts.empty()) {
      refined = refineWindow(tracks, lines.tracks, pre, vps, starts, StartMode::kFine,
                             options_.refinement);
      if (use.second_search && isSuspicious(refined, options_)) {
        searchAgain(tracks, lines.tracks, pre, R_c0_ck, vps, starts, options_, &refined);
      }
      checkAgainstPoints(tracks, lines, pre, vps, starts, options_, &refined);
    }
    clock.lap("refinement");
    if (refined.valid) posterior = posteriorOf(refined.state, refined.information);
    clock.lap("posterior");
    if (!use.refine && !starts.empty()) setWorldStates(window, starts.front(), &result);
  }

  // Verdict.
  if (posterior.valid) {
    setWorldStates(window, refined.state, &result);
    result.scale_sigma = posterior.scale_sigma;
    result.covariance = posterior.covariance;
    PosteriorMeasures measures;
    measures.chi2 = refined.chi2;
    measures.inlier_fraction =
        refined.inlier_fraction * tracks.pointSightings().size() / window.pointSightings().size();
    measures.behind_fraction = refined.behind_fraction;
    measures.keyframes = window.size();
    measures.inertial_chi2 = refined.inertial_chi2;
    measures.scale_sigma = posterior.scale_sigma;
    measures.point_spread_deg = pointSpreadDeg(tracks);
    const std::vector<GateValue> gates =
        posteriorGates(measures, motion, gatesInForce(options_.gates));
    result.gates.insert(result.gates.end(), gates.begin(), gates.end());
  }
  enforceGates(options_.gates.mode, &result);
  decide(false, &result);
  keepObservable(pre, R_b0_bk, window.calibration().gravity_magnitude, &result);
  clock.lap("verdict");
  if (result.hasEstimate() || !result.success()) return result;
  std::ostringstream message;
  if (!translation.valid) {
    message << translation.tracks << " tracks over at least " << options_.alignment.min_track_length
            << " keyframes with parallax, needs " << options_.alignment.min_tracks;
    fail(InitStatus::kTooFewTracks, message.str(), &result);
  } else {
    fail(InitStatus::kNumericalFailure,
         "the refinement found no minimum with a positive definite information", &result);
  }
  return result;
}

std::unique_ptr<WindowSolver> makeSlimSolver(const InitializerOptions& options,
                                             std::string* error) {
  const std::string message = options.validate();
  if (message.empty()) return std::make_unique<Slim>(options);
  if (error != nullptr) *error = message;
  return nullptr;
}

}  // namespace slim_init
