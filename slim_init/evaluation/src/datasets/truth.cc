// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/truth.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "reference_so3.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

constexpr int kIterations = 4;  // the problem is close to linear: two are enough, see the test
constexpr int kMinSpans = 2;
// Spans over which gyro and orientation are compared; one whose ends are off that length by more is
// discarded, and so is one with a longer step between samples [s].
constexpr double kSpan = 1.0, kMaxSpanError = 0.5, kMaxImuGap = 0.05;
// Spans whose residual is above this many medians are excluded from the second pass: single
// glitches of a motion capture system must not move the mean.
constexpr double kOutlierMedians = 5.0;

// Reach of deriveVelocities() to either side [s]: six steps of a truth at 100 Hz.
constexpr double kVelocityReach = 0.03;
// As the interpolation of the truth (simulation/trajectory.h).
constexpr double kMaxStep = 0.3;

/// Gyro between two truth samples and the true rotation over it.
struct Span {
  std::vector<InertialStep> steps;
  Eigen::Matrix3d R_b0_b1 = Eigen::Matrix3d::Identity();
  double residual = 0.0;  ///< [rad], at the newest bias
  bool used = true;
};

/// Rotation integrated from the gyro at `bias`, with J such that
/// dR(bias + d) = dR(bias) Exp(J d) to first order.
void integrateRotation(const Span& span, const Eigen::Vector3d& bias, Eigen::Matrix3d* dR,
                       Eigen::Matrix3d* J) {
  dR->setIdentity();
  J->setZero();
  for (const InertialStep& step : span.steps) {
    const Eigen::Vector3d phi = (step.gyro - bias) * step.dt;
    const Eigen::Matrix3d step_R = reference::expSo3(phi);
    *J = step_R.transpose() * *J - reference::rightJacobianSo3(phi) * step.dt;
    *dR = *dR * step_R;
  }
}

std::vector<Span> makeSpans(const std::vector<ImuSample>& imu, const std::vector<NavState>& truth) {
  std::vector<Span> spans;
  std::size_t begin = 0;
  while (begin < truth.size()) {
    std::size_t end = begin + 1;
    while (end < truth.size() && truth[end].t - truth[begin].t < kSpan) ++end;
    if (end >= truth.size()) break;
    const double length = truth[end].t - truth[begin].t;
    Span span;
    if (length <= kSpan + kMaxSpanError &&
        inertialSteps(imu, truth[begin].t, truth[end].t, kMaxImuGap, &span.steps)) {
      span.R_b0_b1 = truth[begin].R_w_b.transpose() * truth[end].R_w_b;
      spans.push_back(std::move(span));
    }
    begin = end;
  }
  return spans;
}

/// Gauss-Newton on the used spans; updates their residuals. False when the system is singular.
bool fit(std::vector<Span>& spans, Eigen::Vector3d* bias) {
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (Span& span : spans) {
      Eigen::Matrix3d dR;
      Eigen::Matrix3d J;
      integrateRotation(span, *bias, &dR, &J);
      const Eigen::Vector3d r = reference::logSo3(dR.transpose() * span.R_b0_b1);
      span.residual = r.norm();
      if (!span.used) continue;
      H += J.transpose() * J;
      gradient += J.transpose() * r;
    }
    if (iteration == kIterations) break;  // the last round only brings the residuals up to date
    *bias += H.ldlt().solve(gradient);
    if (!bias->allFinite()) return false;
  }
  return true;
}

/// Velocity from sample i - 1 to sample i; false for a gap.
bool stepVelocity(const std::vector<NavState>& truth, int i, Eigen::Vector3d* velocity) {
  if (i < 1 || i >= static_cast<int>(truth.size())) return false;
  const double dt = truth[i].t - truth[i - 1].t;
  if (!(dt > 0.0 && dt <= kMaxStep)) return false;
  *velocity = (truth[i].p_w_b - truth[i - 1].p_w_b) / dt;
  return true;
}

Eigen::Vector3d medianStepVelocity(const std::vector<NavState>& truth, int i) {
  std::array<std::vector<double>, 3> steps;
  const auto add = [&](int step) {
    Eigen::Vector3d velocity;
    if (!stepVelocity(truth, step, &velocity)) return false;
    for (int axis = 0; axis < 3; ++axis) steps[axis].push_back(velocity[axis]);
    return true;
  };
  const double slack = 1e-6;  // stamps shake
  for (int k = i; add(k) && truth[i].t - truth[k - 1].t < kVelocityReach - slack; --k) {
  }
  for (int k = i + 1; add(k) && truth[k].t - truth[i].t < kVelocityReach - slack; ++k) {
  }
  Eigen::Vector3d velocity;
  for (int axis = 0; axis < 3; ++axis) velocity[axis] = median(steps[axis]);
  return velocity;
}

}  // namespace

bool inertialSteps(const std::vector<ImuSample>& imu, double t0, double t1, double max_gap_s,
                   std::vector<InertialStep>* steps) {
  steps->clear();
  if (imu.size() < 2 || !(t0 < t1) || t0 < imu.front().t || t1 > imu.back().t) return false;
  // The first sample after t0; there is one before it because imu covers t0.
  auto next = std::upper_bound(imu.begin(), imu.end(), t0,
                               [](double t, const ImuSample& sample) { return t < sample.t; });
  if (next == imu.begin() || next == imu.end()) return false;
  ImuSample from = host_health::between(*std::prev(next), *next, t0);
  for (;; ++next) {
    if (next->t - std::prev(next)->t > max_gap_s) return false;
    const bool last = next->t >= t1;
    const ImuSample to = last ? host_health::between(*std::prev(next), *next, t1) : *next;
    steps->push_back({to.t - from.t, 0.5 * (from.gyro + to.gyro), 0.5 * (from.accel + to.accel)});
    if (last) return true;
    from = to;
  }
}

void deriveVelocities(std::vector<NavState>* truth) {
  const int n = static_cast<int>(truth->size());
  for (int i = 0; i < n; ++i) (*truth)[i].v_w_b = medianStepVelocity(*truth, i);
}

GyroBiasFit fitGyroBias(const std::vector<ImuSample>& imu, const std::vector<NavState>& truth) {
  GyroBiasFit result;
  std::vector<Span> spans = makeSpans(imu, truth);
  if (static_cast<int>(spans.size()) < kMinSpans) {
    result.message =
        text("gyro bias cannot be fitted: ", spans.size(), " spans of ", kSpan,
             " s have both gyro and ground-truth orientation (minimum ", kMinSpans, ')');
    return result;
  }
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  bool solved = fit(spans, &bias);
  if (solved) {
    std::vector<double> residuals;
    residuals.reserve(spans.size());
    for (const Span& span : spans) residuals.push_back(span.residual);
    // The floor keeps spans without noise, where the median is rounding error.
    const double bound = std::max(kOutlierMedians * median(residuals), 1e-6);
    for (Span& span : spans) span.used = span.residual <= bound;
    solved = fit(spans, &bias);
  }
  if (!solved) {
    result.message = "gyro bias cannot be fitted: the least squares problem has no finite solution";
    return result;
  }
  double sum = 0.0;
  for (const Span& span : spans) {
    if (!span.used) continue;
    ++result.spans;
    sum += span.residual * span.residual;
  }
  result.spans_rejected = static_cast<int>(spans.size()) - result.spans;
  result.rms_rad = std::sqrt(sum / result.spans);
  result.bias = bias;
  result.ok = true;
  result.message =
      roundedText(4,
                  "ground truth has no gyro bias; one constant was fitted to gyro and ground-truth "
                  "orientation over ",
                  result.spans, " spans of ", kSpan, " s (", result.spans_rejected,
                  " discarded as outliers, residual ", result.rms_rad, " rad rms per span): [",
                  bias.x(), ", ", bias.y(), ", ", bias.z(), "] rad/s");
  return result;
}

int nearestState(const std::vector<NavState>& states, double t) {
  if (states.empty()) return -1;
  const auto after =
      std::lower_bound(states.begin(), states.end(), t,
                       [](const NavState& state, double time) { return state.t < time; });
  if (after == states.begin()) return 0;
  const int index = static_cast<int>(after - states.begin());
  if (after == states.end()) return index - 1;
  return t - std::prev(after)->t <= after->t - t ? index - 1 : index;
}

}  // namespace slim_init::evaluation
