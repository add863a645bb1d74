// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "watchdog.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "imu_screen.h"

namespace slim_init::vins_adapter {
namespace {

constexpr double kDeg = 57.29577951308232;
// A state to carry to the newest one is at least and at most so much older [s].
constexpr double kShortest = 0.3;
constexpr double kLongest = 1.2;
// Frames at the end of the window that are judged and not used for triangulation.
constexpr std::size_t kJudgedFrames = 2;
constexpr std::size_t kLeastViews = 3;
constexpr double kLeastParallaxDeg = 1.5;
// Of the initializer's answer: velocity [m/s] and share of it, tilt.
constexpr double kAnswerVelocity = 0.5;
constexpr double kAnswerShare = 0.3;
constexpr double kAnswerTiltDeg = 5.0;

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  out.precision(3);
  (out << ... << parts);
  return out.str();
}

double angleOf(const Eigen::Matrix3d& R) { return std::abs(Eigen::AngleAxisd(R).angle()); }

struct Ray {
  Eigen::Vector3d origin, direction;  // in w
};

Ray rayOf(const NavState& state, const Eigen::Vector3d& bearing, const Calibration& calibration) {
  return {state.p_w_b + state.R_w_b * calibration.t_b_c,
          (state.R_w_b * (calibration.R_b_c * bearing)).normalized()};
}

// The point closest to all rays; false where they are too parallel.
bool triangulate(const std::vector<Ray>& rays, Eigen::Vector3d* point) {
  double parallax = 0.0;
  for (const Ray& ray : rays) {
    parallax = std::max(parallax,
                        std::acos(std::min(1.0, std::abs(ray.direction.dot(rays[0].direction)))));
  }
  if (parallax * kDeg < kLeastParallaxDeg) return false;
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Ray& ray : rays) {
    const Eigen::Matrix3d P =
        Eigen::Matrix3d::Identity() - ray.direction * ray.direction.transpose();
    A += P;
    b += P * ray.origin;
  }
  *point = A.ldlt().solve(b);
  return point->allFinite();
}

double reprojection(const std::vector<NavState>& states,
                    const std::vector<const FrameObservation*>& frames,
                    const Calibration& calibration, int least_tracks) {
  std::map<FeatureId, std::vector<Ray>> rays;
  const std::size_t judged = states.size() - kJudgedFrames;
  for (std::size_t i = 0; i < judged; ++i) {
    if (frames[i] == nullptr) continue;
    for (const PointObservation& point : frames[i]->points) {
      rays[point.id].push_back(rayOf(states[i], point.bearing, calibration));
    }
  }
  std::vector<double> errors;
  std::set<FeatureId> tracks;
  for (std::size_t i = judged; i < states.size(); ++i) {
    if (frames[i] == nullptr) continue;
    for (const PointObservation& point : frames[i]->points) {
      const auto track = rays.find(point.id);
      Eigen::Vector3d place;
      if (track == rays.end() || track->second.size() < kLeastViews ||
          !triangulate(track->second, &place)) {
        continue;
      }
      tracks.insert(point.id);
      const Ray seen = rayOf(states[i], point.bearing, calibration);
      const Eigen::Vector3d expected = (place - seen.origin).normalized();
      errors.push_back(calibration.focal_px * std::atan2(expected.cross(seen.direction).norm(),
                                                         expected.dot(seen.direction)));
    }
  }
  if (static_cast<int>(tracks.size()) < least_tracks) return kNotComputed;
  return middle(std::move(errors));
}

}  // namespace

WatchFinding watchWindow(const std::vector<NavState>& states,
                         const std::vector<FrameObservation>& frames,
                         const std::deque<ImuSample>& samples, const std::deque<ImuDamage>& damage,
                         const Calibration& calibration, const WatchBounds& bounds) {
  WatchFinding finding;
  const auto wrong = [&finding](const std::string& reason) {
    finding.sane = false;
    finding.reason += (finding.reason.empty() ? "" : "; ") + reason;
  };
  if (states.size() <= kJudgedFrames) return finding;
  for (const NavState& state : states) {
    if (state.isFinite()) continue;
    wrong("a state is not finite");
    return finding;
  }
  const NavState& newest = states.back();
  if (const double bias = newest.accel_bias.norm(); bias > bounds.accel_bias) {
    wrong(text("accelerometer bias ", bias, " m/s^2, may be ", bounds.accel_bias));
  }
  if (const double bias = newest.gyro_bias.norm(); bias > bounds.gyro_bias) {
    wrong(text("gyroscope bias ", bias, " rad/s, may be ", bounds.gyro_bias));
  }

  // The IMU alone from the oldest state that it may reach from.
  const Eigen::Vector3d gravity_w(0.0, 0.0, -calibration.gravity_magnitude);
  for (const NavState& state : states) {
    const double age = newest.t - state.t;
    if (age > kLongest || age < kShortest) continue;
    CarriedState from, carried;
    from.state = state;
    std::string error;
    if (!carryState(from, newest.t, samples, damage, gravity_w, calibration.imu_noise, &carried,
                    &error)) {
      continue;
    }
    finding.velocity_mps = (newest.v_w_b - carried.state.v_w_b).norm();
    finding.rotation_deg = kDeg * angleOf(carried.state.R_w_b.transpose() * newest.R_w_b);
    const double may_v = bounds.velocity_mps + 3.0 * carried.velocitySigma();
    const double may_r = bounds.rotation_deg +
                         3.0 * kDeg * std::sqrt(carried.covariance.diagonal().head<3>().maxCoeff());
    if (finding.velocity_mps > may_v) {
      wrong(text("velocity changed by ", finding.velocity_mps,
                 " m/s more than the IMU measured in ", age, " s, may be ", may_v));
    }
    if (finding.rotation_deg > may_r) {
      wrong(text("attitude changed by ", finding.rotation_deg,
                 " deg more than the IMU measured in ", age, " s, may be ", may_r));
    }
    break;
  }

  std::vector<const FrameObservation*> at(states.size(), nullptr);
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (const FrameObservation& frame : frames) {
      if (std::abs(frame.t - states[i].t) < 1e-4) at[i] = &frame;
    }
  }
  finding.reprojection_px = reprojection(states, at, calibration, bounds.tracks);
  if (finding.reprojection_px > bounds.reprojection_px) {
    wrong(text("tracks are ", finding.reprojection_px,
               " px off where the poses have them (median), may be ", bounds.reprojection_px));
  }
  return finding;
}

std::string SteadyBiases::judge(const NavState& state) {
  if (!known_) {
    accel_bias_ = state.accel_bias;
    gyro_bias_ = state.gyro_bias;
    known_ = true;
  }
  const Eigen::Vector3d accel = state.accel_bias - accel_bias_, gyro = state.gyro_bias - gyro_bias_;
  if (accel.norm() > kAccelStep) {
    return text("accelerometer bias has moved by ", accel.norm(), " m/s^2, may move by ",
                kAccelStep);
  }
  if (gyro.norm() > kGyroStep) {
    return text("gyroscope bias has moved by ", gyro.norm(), " rad/s, may move by ", kGyroStep);
  }
  accel_bias_ += kShare * accel;
  gyro_bias_ += kShare * gyro;
  return "";
}

std::string compareStates(const NavState& host, const NavState& answer, double scale_sigma) {
  // In the body: neither frame has to be known.
  const Eigen::Vector3d v_host = host.R_w_b.transpose() * host.v_w_b;
  const Eigen::Vector3d v_answer = answer.R_w_b.transpose() * answer.v_w_b;
  const double off = (v_host - v_answer).norm();
  const double sigma = std::isnan(scale_sigma) ? 0.0 : scale_sigma;
  const double may = kAnswerVelocity + (kAnswerShare + 3.0 * sigma) * v_answer.norm();
  if (off > may) {
    return text("velocity is ", off, " m/s off that of a window solved anew, may be ", may);
  }
  const Eigen::Vector3d up_host = host.R_w_b.row(2), up = answer.R_w_b.row(2);
  const double tilt = kDeg * std::atan2(up_host.cross(up).norm(), up_host.dot(up));
  if (tilt > kAnswerTiltDeg) {
    return text("attitude is ", tilt, " deg off the gravity of a window solved anew, may be ",
                kAnswerTiltDeg);
  }
  return "";
}

}  // namespace slim_init::vins_adapter
