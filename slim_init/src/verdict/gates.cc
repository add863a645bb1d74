// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "verdict/gates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "geometry/so3.h"

namespace slim_init {
namespace {

constexpr double kDegPerRad = 180.0 / M_PI;

GateValue makeGate(const char* name, const char* unit, double value, double threshold,
                   bool upper_bound, InitStatus status_if_failed) {
  GateValue gate;
  gate.name = name;
  gate.unit = unit;
  gate.value = value;
  gate.threshold = threshold;
  gate.upper_bound = upper_bound;
  // Comparisons with NaN are false: a value that is not known does not pass.
  gate.passed = upper_bound ? value <= threshold : value >= threshold;
  gate.status_if_failed = status_if_failed;
  return gate;
}

// What the measured number is, for a reader who does not know the code.
const char* explain(const std::string& name) {
  if (name == "parallax") return "median rotation-compensated track motion";
  if (name == "excitation") return "deviation of the specific force from its mean";
  if (name == "linkage") return "eigenvalue ratio of the translation system";
  if (name == "scale_positive") return "scale";
  if (name == "alignment_residual") return "rms residual of the alignment";
  if (name == "scale_sigma") return "relative standard deviation of the scale";
  return "value";
}

}  // namespace

double medianParallaxPx(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck) {
  std::vector<double> angles;
  angles.reserve(window.pointTracks().size());
  for (const Track& track : window.pointTracks()) {
    const PointSighting& a = window.pointSightings()[track.begin];
    const PointSighting& b = window.pointSightings()[track.end - 1];
    const Eigen::Vector3d u_a = R_c0_ck[a.keyframe] * a.bearing;
    const Eigen::Vector3d u_b = R_c0_ck[b.keyframe] * b.bearing;
    angles.push_back(std::atan2(u_a.cross(u_b).norm(), u_a.dot(u_b)));
  }
  if (angles.empty()) return kNotComputed;
  const auto middle = angles.begin() + angles.size() / 2;
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle * window.calibration().focal_px;
}

double maxRotationDeg(const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  double largest = 0.0;
  for (const Eigen::Matrix3d& R : R_b0_bk) largest = std::max(largest, logSO3(R).norm());
  return largest * kDegPerRad;
}

double forceDeviation(const std::vector<Preintegration>& pre,
                      const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  Eigen::Matrix3Xd force(3, pre.size());
  for (std::size_t i = 0; i < pre.size(); ++i) {
    force.col(i) = R_b0_bk[i] * pre[i].dv / pre[i].dt;
  }
  const Eigen::Vector3d mean = force.rowwise().mean();
  return std::sqrt((force.colwise() - mean).squaredNorm() / static_cast<double>(pre.size()));
}

std::vector<GateValue> motionGates(const MotionMeasures& motion, const GateOptions& options) {
  const bool turns = motion.rotation_deg >= options.min_rotation_deg;
  return {makeGate("parallax", "px", motion.parallax_px, options.min_parallax_px, false,
                   turns ? InitStatus::kPureRotation : InitStatus::kStationary),
          makeGate("excitation", "m/s^2", motion.excitation, options.min_excitation, false,
                   InitStatus::kTooLittleExcitation)};
}

std::vector<GateValue> alignmentGates(double linkage, double scale, double residual_rms,
                                      double scale_sigma, const GateOptions& options) {
  return {makeGate("linkage", "", linkage, options.min_linkage, false,
                   InitStatus::kDegenerateAlignment),
          makeGate("scale_positive", "m", scale, 0.0, false, InitStatus::kDegenerateAlignment),
          makeGate("alignment_residual", "m, m/s", residual_rms, options.max_alignment_residual,
                   true, InitStatus::kInconsistentResiduals),
          makeGate("scale_sigma", "", scale_sigma, options.max_scale_sigma, true,
                   InitStatus::kScaleTooUncertain)};
}

std::string describe(const GateValue& gate) {
  std::ostringstream out;
  out.precision(3);
  out << explain(gate.name) << " is " << gate.value;
  if (!gate.unit.empty()) out << ' ' << gate.unit;
  out << ", must be at " << (gate.upper_bound ? "most " : "least ") << gate.threshold;
  return out.str();
}

void decide(bool enforced, InitResult* result) {
  const GateValue* failed = nullptr;
  for (GateValue& gate : result->gates) {
    gate.enforced = enforced;
    if (!gate.passed && failed == nullptr) failed = &gate;
  }
  result->status = InitStatus::kSuccess;
  if (failed == nullptr) {
    result->message = "all gates passed";
  } else if (enforced) {
    result->status = failed->status_if_failed;
    result->message = describe(*failed);
  } else {
    result->message = "gates not enforced; " + describe(*failed);
  }
}

}  // namespace slim_init
