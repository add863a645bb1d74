// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>

#include "checks.h"
#include "imu/imu_quality.h"
#include "reference_so3.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/host_health/imu_screen.h"
#include "slim_init/keyframe_window.h"
#include "slim_init/window_solver.h"

namespace slim_init::evaluation {
namespace {

// Rotation, translation, td; the readout time is taken as it is.
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

constexpr int kRounds = 10;
// Cauchy scale, in standard deviations per dimension.
constexpr double kCauchySigmas = 3.0;

// A rig whose own standard deviations are not believed.
constexpr CalibrationSigmas kWide = {10.0, 0.05, 0.05, 0.0};
// An alignment that is less certain than this does not replace the configured rotation [rad].
constexpr double kAligned = 0.1;

Vector7d difference(const CalibrationEstimate& estimate, const Calibration& from) {
  Vector7d x;
  x << reference::logSo3(from.R_b_c.transpose() * estimate.R_b_c), estimate.t_b_c - from.t_b_c,
      estimate.td - from.td;
  return x;
}

Matrix7d priorInformation(const CalibrationSigmas& sigmas) {
  Vector7d sigma;
  sigma << Eigen::Vector3d::Constant(sigmas.rotation_deg / kDegPerRad),
      Eigen::Vector3d::Constant(sigmas.translation_m), sigmas.td_s;
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

// One estimate: what its data say about the difference from the prior.
struct Evidence {
  Vector7d x;
  Matrix7d information;  // prior included
  Matrix7d of_data;      // without it
  double weight = 1.0;
};

bool evidenceOf(const CalibrationEstimate& estimate, const Calibration& prior, Evidence* evidence) {
  const Matrix7d covariance = estimate.covariance.topLeftCorner<7, 7>();
  const Eigen::LDLT<Matrix7d> ldlt(covariance);
  if (!(covariance.diagonal().minCoeff() > 0.0) || !ldlt.isPositive()) return false;
  evidence->x = difference(estimate, prior);
  evidence->information = ldlt.solve(Matrix7d::Identity());
  // Rounding leaves small negative eigenvalues where the data say nothing.
  const Eigen::SelfAdjointEigenSolver<Matrix7d> axes(evidence->information -
                                                     priorInformation(prior.sigmas));
  evidence->of_data = axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).asDiagonal() *
                      axes.eigenvectors().transpose();
  return evidence->x.allFinite() && evidence->of_data.allFinite();
}

std::vector<std::shared_ptr<const InitWindow>> cutWindows(const DoctorData& data,
                                                          const Calibration& calibration,
                                                          const InitializerOptions& options) {
  WindowOptions full = options.window;
  full.min_keyframes = full.keyframes;
  const double span = (full.keyframes - 1) * full.min_interval_s;
  full.buffer_s = std::max(full.buffer_s, 4.0 * span);
  StreamOptions streams;
  streams.imu = options.imu;
  KeyframeWindow buffer(calibration, full, streams);
  host_health::ImuScreen screen(streams.imu);
  std::vector<std::shared_ptr<const InitWindow>> windows;
  std::size_t next_imu = 0;
  double end = -1e300;  // of the window before
  for (const FrameObservation& frame : data.frames) {
    const double t = calibration.imuTime(frame.t);
    while (next_imu < data.imu.size() && data.imu[next_imu].t < t + InitWindow::kImuMargin) {
      screen.pass(data.imu[next_imu++],
                  [&buffer](const ImuSample& sample) { return buffer.addImu(sample); });
    }
    buffer.addFrame(frame);
    if (t < end + span) continue;
    const WindowCut cut = buffer.cut();
    if (cut.window == nullptr || cut.window->times().front() < end) continue;
    windows.push_back(cut.window);
    end = cut.window->times().back();
  }
  return windows;
}

void addVerdict(const InitResult& result, WindowEstimates* answers) {
  ++answers->windows;
  const std::string status = toString(result.status);
  ++answers->statuses[status];
  if (result.success()) {
    ++answers->accepted;
    if (result.warnings.empty()) return;
    ++answers->with_warnings;
    if (answers->warning.empty()) answers->warning = result.warnings.front();
    return;
  }
  // A scale that two seconds leave uncertain wants more motion, like the statuses that wait.
  const bool wants_motion =
      isWait(result.status) || result.status == InitStatus::kScaleTooUncertain;
  if (!wants_motion) ++answers->refused;
  // The first message of each status; which one is the most frequent shows at the end.
  answers->messages.emplace(status, result.message);
}

void measureNoise(const std::vector<std::shared_ptr<const InitWindow>>& windows,
                  const InertialOptions& options, WindowEstimates* answers) {
  std::vector<double> gyro, accel, gyro_assumed, accel_assumed;
  for (const auto& window : windows) {
    const ImuQuality quality = measureImuQuality(window->imu());
    if (quality.measured()) {
      gyro.push_back(quality.noise.gyro_density);
      accel.push_back(quality.noise.accel_density);
    }
    const ImuNoise assumed = assumedImuNoise(*window, options);
    gyro_assumed.push_back(assumed.gyro_density);
    accel_assumed.push_back(assumed.accel_density);
  }
  answers->measured_noise = {median(gyro), median(accel)};
  answers->assumed_noise = {median(gyro_assumed), median(accel_assumed)};
}

bool sameMotion(const RotationAlignment& a, const DoctorOptions& options) {
  return a.status == AlignmentStatus::kSolved && a.correlation >= options.min_correlation &&
         std::abs(a.gyro_scale - 1.0) < options.gyro_scale.fail;
}

// Where the solver starts to look for the calibration: what the whole recording has of it.
Calibration startOf(const DoctorData& data, const RotationAlignment& a) {
  Calibration start = data.calibration;
  const double sigma = std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(a.R_covariance).eigenvalues().maxCoeff());
  if (sigma < kAligned) start.R_b_c = a.R_b_c;
  start.td = a.td;
  start.sigmas = kWide;
  return start;
}

}  // namespace

OptionalCalibration combinedCalibration(const std::vector<CalibrationEstimate>& estimates,
                                        const Calibration& prior) {
  if (static_cast<int>(estimates.size()) < kMinEstimates) return {};
  std::vector<Evidence> all(estimates.size());
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (!evidenceOf(estimates[i], prior, &all[i])) return {};
  }
  Vector7d x = Vector7d::Zero();
  Matrix7d covariance = Matrix7d::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Matrix7d information = priorInformation(prior.sigmas);
    Vector7d sum = Vector7d::Zero();
    for (const Evidence& e : all) {
      information += e.weight * e.of_data;
      sum += e.weight * (e.information * e.x);  // the prior's share is about zero
    }
    const Eigen::LDLT<Matrix7d> ldlt(information);
    x = ldlt.solve(sum);
    covariance = ldlt.solve(Matrix7d::Identity());
    double chi2 = 0.0, weights = 0.0;
    for (Evidence& e : all) {
      const double z2 = (e.x - x).dot(e.information * (e.x - x)) / 7.0;
      chi2 += e.weight * z2;
      weights += e.weight;
      e.weight = 1.0 / (1.0 + z2 / (kCauchySigmas * kCauchySigmas));
    }
    covariance *= std::max(1.0, chi2 / std::max(weights - 1.0, 0.5 * weights));
  }
  if (!x.allFinite() || !covariance.allFinite()) return {};
  CalibrationEstimate out;
  out.R_b_c = prior.R_b_c * reference::expSo3(x.head<3>());
  out.t_b_c = prior.t_b_c + x.segment<3>(3);
  out.td = prior.td + x[6];
  out.readout_s = prior.readout_s;
  out.covariance.topLeftCorner<7, 7>() = covariance;
  return out;
}

WindowEstimates solveWindows(const DoctorData& data, const RotationAlignment& alignment,
                             const DoctorOptions& options) {
  WindowEstimates answers;
  InitializerOptions unlimited = options.initializer;
  unlimited.limits.max_solve_ms = 0.0;  // a cause is looked for, and nobody flies
  const std::unique_ptr<WindowSolver> solver = makeSlimSolver(unlimited);
  if (solver == nullptr || !data.calibration.validate().empty()) return answers;
  const auto configured = cutWindows(data, data.calibration, options.initializer);
  measureNoise(configured, options.initializer.inertial, &answers);
  std::vector<double> measured_px, assumed_px, excitations;
  for (const auto& window : configured) {
    const InitResult result = solver->solve(*window);
    addVerdict(result, &answers);
    for (const GateValue& gate : result.gates) {
      const bool counts = gate.name == GateName::kExcitation && std::isfinite(gate.value);
      if (counts) excitations.push_back(gate.value);
    }
    if (!std::isfinite(result.track_noise.measured_px)) continue;
    measured_px.push_back(result.track_noise.measured_px);
    assumed_px.push_back(result.track_noise.assumed_px);
  }
  answers.track_noise = {median(measured_px), median(assumed_px)};
  answers.excitation = median(excitations);

  if (!sameMotion(alignment, options)) return answers;
  const Calibration start = startOf(data, alignment);
  std::vector<CalibrationEstimate> found;
  for (const auto& window : cutWindows(data, start, options.initializer)) {
    const InitResult result = solver->solve(*window);
    // Too little is known about the scale of a slow window; its calibration says how sure it is.
    const bool sound = result.success() || result.status == InitStatus::kScaleTooUncertain;
    if (sound && result.calibration.has_value()) found.push_back(*result.calibration);
  }
  answers.calibration = combinedCalibration(found, start);
  return answers;
}

}  // namespace slim_init::evaluation
