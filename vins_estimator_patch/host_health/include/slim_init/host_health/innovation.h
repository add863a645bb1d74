// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// One test of a new frame: does the pose that the IMU predicts agree with the pose that the tracks
// want, and if not, which of the two is incorrect?
#pragma once

#include <Eigen/Core>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "slim_init/host_health/imu_propagation.h"
#include "slim_init/types.h"

namespace slim_init::host_health {

/// The damaged input of a frame.
enum class Culprit {
  kNone,
  kImu,       ///< nearly all tracks agree on a pose that the IMU data contradict
  kImages,    ///< a part of the tracks moves, or all; the others agree with the IMU
  kUnclear,   ///< neither; or the host's velocity is incorrect
  kNotJudged  ///< fewer than eight tracks have a known place, or input is missing
};

/// Outcome of the test for one frame.
struct Innovation {
  Culprit culprit = Culprit::kNotJudged;
  int tracks = 0;             ///< of the newest frame with a known place
  int deciding = 0;           ///< of these
  double agree_imu = 0.0;     ///< fraction of the deciding ones that agrees with the IMU's pose
  double agree_images = 0.0;  ///< .. with the best pose of the images
  /// The best pose of the images against the IMU's prediction.
  double position_m = kNotComputed;
  double rotation_deg = kNotComputed;
  double mahalanobis = kNotComputed;  ///< the same in standard deviations, six degrees of freedom
  /// Pose from the tracks; velocity: the prediction, changed by the mean error of the prediction
  /// over the interval; biases as predicted.
  NavState images;
  /// The same with the IMU's prediction, unless that is the culprit: where the host should start.
  NavState best;
  /// Of its errors [theta, p], both in the world, from the noise of tracks and places; the last
  /// optimized pose is exact.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Tracks to keep out of the host's window (kImages): those of the newest frame that do not agree
  /// with the pose that the IMU allows, or whose earlier views contradict the optimized poses.
  std::vector<FeatureId> moving;
  double noise = 1.0;  ///< of the tracks, over sigma_px
  bool blind = false;  ///< less than a quarter of the tracks is left then
  /// Mean errors of rate and acceleration over the interval that explain the innovation, in the
  /// world [rad/s, m/s^2].
  Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();
  /// Size of the error that the IMU data have had since `damaged_since`, for
  /// ImuScreen::addDamage(); zero unless accusesImu().
  double accel_sigma = 0.0;             ///< [m/s^2]
  double gyro_sigma = 0.0;              ///< [rad/s]
  double damaged_since = kNotComputed;  ///< [s]
  /// The frame is not judged, and the one before was damaged: the damage is assumed to go on.
  bool goes_on = false;
  std::string message;  ///< one sentence with values and limits

  /// The IMU data of the interval are not to be believed.
  bool accusesImu() const {
    return culprit == Culprit::kImu || culprit == Culprit::kUnclear || goes_on;
  }
};

/// Host and tracker add to the noise of a track, by no more than this factor.
constexpr double kMostNoise = 3.0;

/// What is known from the frames before.
struct TrackTrust {
  double most_noise = kMostNoise;  ///< their noise is used up to so many `sigma_px`
  /// The optimized poses are less certain: a track that they leave no place does not move.
  bool decide = false;
  /// Nearly all known tracks of the last optimized frame agreed with the IMU, or with one pose if
  /// the IMU was damaged. If most of them lose their place at once, its pose is the cause, and the
  /// poses before it count.
  bool agreed = false;
  /// Most of the view has been replaced at once: its tracks cannot speak against the IMU.
  bool replaced = false;
  /// Innovation::error of the frame before, zero: none; and the logarithm of the odds that it goes
  /// on.
  Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();
  double log_odds = 0.0;
};

/// A new frame of a host.
struct InnovationInput {
  /// The states of the host's window except for the newest, ascending in time.
  const std::vector<NavState>& optimized;
  /// The last of them propagated to the newest frame by propagateState(), from healthyCovariance().
  const PropagatedState& predicted;
  /// With their stamps on the IMU clock; those of other times are skipped.
  const std::vector<FrameObservation>& frames;
  /// Of the rig. Tracks may have more noise than its pointSigmaPx(): it is measured.
  const Calibration& calibration;

  double interval() const { return predicted.state.t - optimized.back().t; }  ///< [s]
};

/// Compares the tracks of the newest frame to the pose that the IMU predicts for it. Fewer than
/// three optimized states, a value that is not finite, a missing newest frame: kNotJudged.
///
/// Tracks of the newest frame are triangulated between the optimized poses, each with its own
/// covariance. Those with four views decide, all if fewer than eight have them: what is new all
/// over the image may agree with itself. A robust fit (Geman-McClure, graduated) finds the pose
/// that the IMU allows and the pose that most of them want; a track agrees with a pose if its
/// chi-square, with the covariance of pixel, place and, of a new one, pose, is below 13.8 (0.1 %).
/// A track whose views in the window leave it no place (the same bound) has moved before the newest
/// interval: many of them cannot speak against the IMU, and a texture that fills the view, all of
/// whose tracks are new, is distinguished from damage by them.
Innovation innovationOf(const InnovationInput& frame, const TrackTrust& trust = {});

/// innovationOf() for each frame of a host in flight, in order, and the same test with the velocity
/// of the host's last two poses, which does not depend on what the host has made of its IMU data.
/// That finds damage too small for the other test, tells a host with an incorrect velocity
/// (kUnclear) from damage, and finds damage that goes on in each frame: after a damaged interval
/// the velocity of the poses alone is used, and it goes on if that is likelier than that it has
/// ended; where no frame can be judged, for as long as it has lasted. If all of the image moves for
/// more than 5 s the frame is kUnclear: the host's poses may as well be incorrect. Not thread-safe.
class InnovationMonitor {
 public:
  /// As innovationOf(); the prediction is without widening of its velocity. `uncertain`: the IMU
  /// data between the optimized states are known to be damaged, or there were no images to judge
  /// them.
  Innovation judge(const InnovationInput& frame, bool uncertain = false);
  /// Whether a part of the image has moved in a frame since `first` [s], and not for more than 5 s,
  /// interruptions of less included: a window from there on may have taken it for the scene.
  bool imagesMoved(double first) const;
  /// The streams or the host have restarted.
  void reset();

 private:
  // What the IMU measured between two frames, besides the velocity at the first.
  struct Step {
    double first = kNotComputed, last = kNotComputed;    // [s]
    Eigen::Vector3d start = Eigen::Vector3d::Zero();     // position at the first [m]
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // [m]
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // [m/s]
    double variance = 0.0;  // of the difference of its poses, from their tracks [m^2]
  };
  Innovation judgeFrame(const InnovationInput& frame, const TrackTrust& trust);
  bool blindEnds(const InnovationInput& frame) const;
  bool isReplaced(const InnovationInput& frame) const;
  bool velocityOfPoses(const std::vector<NavState>& optimized, Eigen::Vector3d* velocity) const;
  PropagatedState withVelocity(const Eigen::Vector3d& velocity, const InnovationInput& frame) const;
  void keep(const InnovationInput& frame, const Innovation& result);

  Step before_;
  bool suspicious_ = false, damaged_ = false, agreed_ = false;
  Eigen::Matrix<double, 6, 1> error_ = Eigen::Matrix<double, 6, 1>::Zero();  // Innovation::error
  // A part of the image did, from and to [s]; interruptions of less than kLongestBlind count.
  double moves_since_ = kNotComputed, moved_ = kNotComputed;
  double blind_since_ = kNotComputed;    // [s]
  double judged_ = kNotComputed;         // the last frame that was [s]
  double damaged_since_ = kNotComputed;  // begin of the damage that goes on in that frame [s]
  double noise_ = kNotComputed;          // of healthy frames
  std::set<FeatureId> moving_;           // of the newest frame, if that was blind
  double trusted_since_ = -std::numeric_limits<double>::infinity();  // [s]
  double replaced_ = -std::numeric_limits<double>::infinity();       // most of the view [s]
};

}  // namespace slim_init::host_health
