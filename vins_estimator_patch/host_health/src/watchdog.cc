// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/host_health/watchdog.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "slim_init/host_health/imu_screen.h"
#include "slim_init/text.h"
#include "track_place.h"

namespace slim_init::host_health {
namespace {

constexpr double kDeg = 57.29577951308232;
// A state to carry to the newest one is at most so much older [s].
constexpr double kLongest = 1.2;
// Frames at the end of the window that are judged and not used for triangulation.
constexpr std::size_t kJudgedFrames = 2;
constexpr std::size_t kLeastViews = 3;
// Relative standard deviation of a distance that is known well enough.
constexpr double kMostDepthError = 0.1;
// Error of a track whose place is behind the camera, or far outside its view [px].
constexpr double kBehindPx = 1e4;
constexpr double kMaxReprojectionPx = 6.0;  // median over the tracks
constexpr std::size_t kLeastTracks = 10;
// Besides three standard deviations of the IMU.
constexpr double kMaxVelocity = 0.5;  // [m/s]
constexpr double kMaxRotationDeg = 3.0;
constexpr double kMaxGyroBias = 0.5;   // [rad/s]
constexpr double kMaxAccelBias = 2.0;  // [m/s^2]
constexpr double kLongestStep = 0.5;   // between two states that a bias is followed over [s]
// Of the initializer's answer: velocity [m/s] and share of it, tilt.
constexpr double kAnswerVelocity = 0.5;
constexpr double kAnswerShare = 0.3;
constexpr double kAnswerTiltDeg = 5.0;

double angleOf(const Eigen::Matrix3d& R) { return std::abs(Eigen::AngleAxisd(R).angle()); }

// Error of a track [px], scaled from the standard deviation of bearing and place to that of the
// bearing alone.
double errorOf(const PlaceResidual& residual, const TrackPlace& place,
               const Calibration& calibration) {
  const double of_place =
      0.5 * (residual.by_place * place.covariance * residual.by_place.transpose()).trace();
  const double sigma = calibration.sigmaBearing();
  return calibration.focal_px * std::atan(residual.r.norm()) /
         std::sqrt(1.0 + of_place / (sigma * sigma));
}

double reprojection(const std::vector<NavState>& states,
                    const std::vector<FrameObservation>& frames, const Calibration& calibration) {
  std::vector<CameraPose> cameras;
  for (const NavState& state : states) cameras.push_back(cameraOf(state, calibration));
  std::map<FeatureId, std::vector<TrackView>> views;
  const std::size_t judged = states.size() - kJudgedFrames;
  for (std::size_t i = 0; i < judged; ++i) {
    const FrameObservation* frame = frameAt(frames, states[i].t);
    if (frame == nullptr) continue;
    for (const PointObservation& point : frame->points) {
      views[point.id].push_back({&cameras[i], point.bearing.normalized()});
    }
  }
  std::vector<double> errors;
  std::set<FeatureId> tracks;
  for (std::size_t i = judged; i < states.size(); ++i) {
    const FrameObservation* frame = frameAt(frames, states[i].t);
    if (frame == nullptr) continue;
    for (const PointObservation& point : frame->points) {
      const auto track = views.find(point.id);
      TrackPlace place;
      if (track == views.end() || track->second.size() < kLeastViews ||
          !findPlace(track->second, calibration.sigmaBearing(), 0.0, &place) ||
          std::sqrt(place.covariance(2, 2)) > kMostDepthError * place.inverse_depth) {
        continue;
      }
      tracks.insert(point.id);
      const Eigen::Vector3d bearing = point.bearing.normalized();
      PlaceResidual residual;
      const bool seen = residualOf(place, cameras[i], bearing, tangentOf(bearing), &residual);
      errors.push_back(seen ? errorOf(residual, place, calibration) : kBehindPx);
    }
  }
  if (tracks.size() < kLeastTracks) return kNotComputed;
  return middle(std::move(errors));
}

}  // namespace

HostHealth watchWindow(const std::vector<NavState>& states,
                       const std::vector<FrameObservation>& frames,
                       const std::deque<ImuSample>& samples, const std::deque<ImuDamage>& damage,
                       const Calibration& calibration) {
  HostHealth finding;
  const auto wrong = [&finding](const std::string& reason) {
    finding.suspect = true;
    finding.reason += (finding.reason.empty() ? "" : "; ") + reason;
  };
  if (states.size() <= kJudgedFrames) return finding;
  for (const NavState& state : states) {
    if (state.isFinite()) continue;
    wrong("a state is not finite");
    return finding;
  }
  const NavState& newest = states.back();
  if (const double bias = newest.accel_bias.norm(); bias > kMaxAccelBias) {
    wrong(roundedText(3, "accelerometer bias ", bias, " m/s^2 (limit ", kMaxAccelBias, ")"));
  }
  if (const double bias = newest.gyro_bias.norm(); bias > kMaxGyroBias) {
    wrong(roundedText(3, "gyroscope bias ", bias, " rad/s (limit ", kMaxGyroBias, ")"));
  }

  // The IMU alone from the oldest state that it may reach from.
  const Eigen::Vector3d gravity_w(0.0, 0.0, -calibration.gravity_magnitude);
  for (const NavState& state : states) {
    const double age = newest.t - state.t;
    if (age > kLongest || !(age > 0.0)) continue;
    PropagatedState from, propagated;
    from.state = state;
    std::string error;
    if (!propagateState(from, newest.t, samples, damage, gravity_w, calibration.imu_noise,
                        &propagated, &error)) {
      continue;
    }
    finding.velocity_mps = (newest.v_w_b - propagated.state.v_w_b).norm();
    finding.rotation_deg = kDeg * angleOf(propagated.state.R_w_b.transpose() * newest.R_w_b);
    const double may_v = kMaxVelocity + 3.0 * propagated.velocitySigma();
    const double may_r =
        kMaxRotationDeg +
        3.0 * kDeg * std::sqrt(propagated.covariance.diagonal().head<3>().maxCoeff());
    if (finding.velocity_mps > may_v) {
      wrong(roundedText(3, "velocity changed by ", finding.velocity_mps,
                        " m/s more than the IMU measured in ", age, " s (limit ", may_v, ")"));
    }
    if (finding.rotation_deg > may_r) {
      wrong(roundedText(3, "attitude changed by ", finding.rotation_deg,
                        " deg more than the IMU measured in ", age, " s (limit ", may_r, ")"));
    }
    break;
  }

  finding.reprojection_px = reprojection(states, frames, calibration);
  if (finding.reprojection_px > kMaxReprojectionPx) {
    wrong(roundedText(3, "tracks are ", finding.reprojection_px,
                      " px from their predicted places (median, limit ", kMaxReprojectionPx, ")"));
  }
  return finding;
}

std::string SteadyBiases::judge(const NavState& state) {
  if (std::isnan(newest_)) {
    accel_bias_ = state.accel_bias;
    gyro_bias_ = state.gyro_bias;
    newest_ = state.t;
  }
  const Eigen::Vector3d accel = state.accel_bias - accel_bias_, gyro = state.gyro_bias - gyro_bias_;
  if (accel.norm() > kAccelStep) {
    return roundedText(3, "accelerometer bias has moved by ", accel.norm(), " m/s^2 (limit ",
                       kAccelStep, ")");
  }
  if (gyro.norm() > kGyroStep) {
    return roundedText(3, "gyroscope bias has moved by ", gyro.norm(), " rad/s (limit ", kGyroStep,
                       ")");
  }
  // At any rate of the host; after an interruption no more than so much.
  const double share = std::clamp(state.t - newest_, 0.0, kLongestStep) / kMemory;
  accel_bias_ += share * accel;
  gyro_bias_ += share * gyro;
  newest_ = state.t;
  return "";
}

std::string compareStates(const NavState& host, const NavState& answer, double scale_sigma,
                          double tilt_sigma_deg) {
  // In the body: neither frame has to be known.
  const Eigen::Vector3d v_host = host.R_w_b.transpose() * host.v_w_b;
  const Eigen::Vector3d v_answer = answer.R_w_b.transpose() * answer.v_w_b;
  const double off = (v_host - v_answer).norm();
  const double sigma = std::isnan(scale_sigma) ? 0.0 : scale_sigma;
  const double may = kAnswerVelocity + (kAnswerShare + 3.0 * sigma) * v_answer.norm();
  if (off > may) {
    return roundedText(3, "velocity is ", off, " m/s from that of an independent window (limit ",
                       may, ")");
  }
  const Eigen::Vector3d up_host = host.R_w_b.row(2), up = answer.R_w_b.row(2);
  const double tilt = kDeg * std::atan2(up_host.cross(up).norm(), up_host.dot(up));
  const double may_tilt = kAnswerTiltDeg + 3.0 * tilt_sigma_deg;
  if (!(tilt > may_tilt)) return "";
  return roundedText(3, "attitude is ", tilt,
                     " deg from the gravity of an independent window (limit ", may_tilt, ")");
}

}  // namespace slim_init::host_health
