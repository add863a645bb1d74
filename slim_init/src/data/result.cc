// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/result.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "geometry/units.h"
#include "slim_init/text.h"

namespace slim_init {

namespace {

// For statistics, too: kRefused, an estimate was computed and rejected by a gate.
enum class Kind { kOther, kWait, kRefused };

struct StatusRow {
  const char* name;
  Kind kind;
  const char* remedy;
};

// In the order of InitStatus.
constexpr StatusRow kStatuses[] = {
    {"success", Kind::kOther, ""},
    {"too_few_keyframes", Kind::kWait, ""},
    {"too_few_tracks", Kind::kWait, "more texture or light"},
    {"stationary", Kind::kWait, "move"},
    {"too_little_excitation", Kind::kWait, "accelerate: move back and forth"},
    {"pure_rotation", Kind::kWait, "translate"},
    {"degenerate_alignment", Kind::kRefused, "more texture, in all parts of the image"},
    {"inconsistent_residuals", Kind::kRefused, "check extrinsic and td: slim_init doctor"},
    {"scale_too_uncertain", Kind::kRefused, "move more, with changes of velocity"},
    {"invalid_input", Kind::kOther, ""},
    {"numerical_failure", Kind::kOther, "if repeated, check the extrinsic: slim_init doctor"},
    {"provisional", Kind::kWait, ""},
    {"time_limit", Kind::kWait, "if frequent, raise limits.max_solve_ms"},
    {"unknown", Kind::kOther, ""},  // of a number that is no status
};

// In the order of GateName.
constexpr const char* kGates[] = {
    "parallax",
    "excitation",
    "extrinsic_rotation",
    "extrinsic_sigma",
    "time_offset",
    "linkage",
    "scale_positive",
    "alignment_residual",
    "chi2",
    "inertial_chi2",
    "inlier_fraction",
    "mean_acceleration",
    "point_spread",
    "other_scale",
    "scale_sigma",
    "velocity_sigma",
    "tilt_sigma",
    "agreement",
    "other",
    "unknown",
};

// The row of an enumerator, the last one for other numbers.
template <typename Row, std::size_t N, typename Enum>
const Row& rowOf(const Row (&rows)[N], Enum value) {
  return rows[std::min(static_cast<std::size_t>(value), N - 1)];
}

const StatusRow& rowOf(InitStatus status) {
  static_assert(std::size(kStatuses) == static_cast<std::size_t>(InitStatus::kTimeLimit) + 2);
  return rowOf(kStatuses, status);
}

}  // namespace

const char* toString(InitStatus status) { return rowOf(status).name; }

bool isWait(InitStatus status) { return rowOf(status).kind == Kind::kWait; }

std::string withRemedy(const std::string& message, InitStatus status) {
  const std::string action = rowOf(status).remedy;
  return action.empty() ? message : message + "; " + action;
}

const char* toString(GateName name) {
  static_assert(std::size(kGates) == static_cast<std::size_t>(GateName::kOther) + 2);
  return rowOf(kGates, name);
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
    return text(verdict, " with a covariance of ", covariance.rows(), " x ", covariance.cols(),
                ", must be ", errors, " x ", errors, " or empty");
  }
  for (const GateValue& gate : gates) {
    if (!gate.enforced || gate.passed) continue;
    return text(verdict, " although the enforced gate ", toString(gate.name),
                " failed: ", gate.value, (gate.upper_bound ? " (limit " : " (minimum "),
                gate.threshold, ")");
  }
  return "";
}

}  // namespace slim_init
