// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "geometry/units.h"
#include "slim_init/remedy.h"

namespace slim_init {

const char* toString(InitStatus status) {
  switch (status) {
    case InitStatus::kSuccess: return "success";
    case InitStatus::kTooFewKeyframes: return "too_few_keyframes";
    case InitStatus::kTooFewTracks: return "too_few_tracks";
    case InitStatus::kStationary: return "stationary";
    case InitStatus::kTooLittleExcitation: return "too_little_excitation";
    case InitStatus::kPureRotation: return "pure_rotation";
    case InitStatus::kDegenerateAlignment: return "degenerate_alignment";
    case InitStatus::kInconsistentResiduals: return "inconsistent_residuals";
    case InitStatus::kScaleTooUncertain: return "scale_too_uncertain";
    case InitStatus::kInvalidInput: return "invalid_input";
    case InitStatus::kNumericalFailure: return "numerical_failure";
    case InitStatus::kProvisional: return "provisional";
    case InitStatus::kTimeLimit: return "time_limit";
  }
  return "unknown";
}

namespace {

const char* remedy(InitStatus status) {
  switch (status) {
    case InitStatus::kTooFewTracks: return "more texture or light";
    case InitStatus::kStationary: return "move";
    case InitStatus::kTooLittleExcitation: return "accelerate: move back and forth";
    case InitStatus::kPureRotation: return "translate";
    case InitStatus::kDegenerateAlignment: return "more texture, in all parts of the image";
    case InitStatus::kInconsistentResiduals: return "check extrinsic and td: slim_init doctor";
    case InitStatus::kScaleTooUncertain: return "move more, with changes of velocity";
    case InitStatus::kNumericalFailure: return "if repeated, check the extrinsic: slim_init doctor";
    case InitStatus::kTimeLimit: return "if frequent, raise limits.max_solve_ms";
    case InitStatus::kSuccess:
    case InitStatus::kTooFewKeyframes:
    case InitStatus::kInvalidInput:
    case InitStatus::kProvisional: break;
  }
  return "";
}

}  // namespace

std::string withRemedy(const std::string& message, InitStatus status) {
  const std::string action = remedy(status);
  return action.empty() ? message : message + "; " + action;
}

const char* toString(GateName name) {
  switch (name) {
    case GateName::kParallax: return "parallax";
    case GateName::kLeastParallax: return "least_parallax";
    case GateName::kExcitation: return "excitation";
    case GateName::kExtrinsicRotation: return "extrinsic_rotation";
    case GateName::kExtrinsicSigma: return "extrinsic_sigma";
    case GateName::kTimeOffset: return "time_offset";
    case GateName::kLinkage: return "linkage";
    case GateName::kScalePositive: return "scale_positive";
    case GateName::kAlignmentResidual: return "alignment_residual";
    case GateName::kChi2: return "chi2";
    case GateName::kInertialChi2: return "inertial_chi2";
    case GateName::kInlierFraction: return "inlier_fraction";
    case GateName::kMeanAcceleration: return "mean_acceleration";
    case GateName::kPointSpread: return "point_spread";
    case GateName::kOtherScale: return "other_scale";
    case GateName::kScaleSigma: return "scale_sigma";
    case GateName::kVelocitySigma: return "velocity_sigma";
    case GateName::kTiltSigma: return "tilt_sigma";
    case GateName::kAgreement: return "agreement";
    case GateName::kOther: return "other";
  }
  return "unknown";
}

bool isWait(InitStatus status) {
  switch (status) {
    case InitStatus::kTooFewKeyframes:
    case InitStatus::kTooFewTracks:
    case InitStatus::kStationary:
    case InitStatus::kTooLittleExcitation:
    case InitStatus::kPureRotation:
    case InitStatus::kProvisional:
    case InitStatus::kTimeLimit: return true;
    default: return false;
  }
}

bool isRefused(InitStatus status) {
  switch (status) {
    case InitStatus::kDegenerateAlignment:
    case InitStatus::kInconsistentResiduals:
    case InitStatus::kScaleTooUncertain: return true;
    default: return false;
  }
}

double CalibrationEstimate::rotationSigmaDeg() const {
  const Eigen::Matrix3d rotation = covariance.topLeftCorner<3, 3>();
  const double largest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rotation, Eigen::EigenvaluesOnly)
          .eigenvalues()[2];
  return std::sqrt(std::max(largest, 0.0)) * kDegPerRad;
}
double CalibrationEstimate::tdSigma() const { return std::sqrt(covariance(6, 6)); }
double CalibrationEstimate::readoutSigma() const { return std::sqrt(covariance(7, 7)); }

Eigen::Matrix<double, 15, 15> InitResult::stateCovariance(std::size_t keyframe) const {
  Eigen::Matrix<double, 15, 15> P;
  P.setConstant(kNotComputed);
  const auto bias = static_cast<Eigen::Index>(9 * states.size());
  if (keyframe >= states.size() || covariance.rows() != bias + 6 || covariance.cols() != bias + 6) {
    return P;
  }
  const auto own = static_cast<Eigen::Index>(9 * keyframe);
  P << covariance.block<9, 9>(own, own), covariance.block<9, 6>(own, bias),
      covariance.block<6, 9>(bias, own), covariance.block<6, 6>(bias, bias);
  return 0.5 * (P + P.transpose());
}

std::string InitResult::validate() const {
  if (!success() && !provisional()) return "";
  const std::string verdict = toString(status);
  if (states.empty()) return verdict + " without states";
  if (!gravity_w.allFinite()) return verdict + " without gravity";
  for (const NavState& state : states) {
    if (!state.isFinite()) return verdict + " with a state that is not finite";
  }
  if (provisional() && (covariance.size() == 0 || !covariance.allFinite())) {
    return verdict + " without a finite covariance";
  }
  const Eigen::Index errors = 9 * static_cast<Eigen::Index>(states.size()) + 6;
  if (covariance.size() > 0 && (covariance.rows() != errors || covariance.cols() != errors)) {
    std::ostringstream out;
    out << verdict << " with a covariance of " << covariance.rows() << " x " << covariance.cols()
        << ", must be " << errors << " x " << errors << " or empty";
    return out.str();
  }
  for (const GateValue& gate : gates) {
    if (!gate.enforced || gate.passed) continue;
    std::ostringstream out;
    out << verdict << " although the enforced gate " << toString(gate.name)
        << " failed: " << gate.value << (gate.upper_bound ? " (limit " : " (minimum ")
        << gate.threshold << ")";
    return out.str();
  }
  return "";
}

}  // namespace slim_init
