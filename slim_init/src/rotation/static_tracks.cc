// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/static_tracks.h"

#include <algorithm>
#include <cmath>

#include "data/with_observations.h"
#include "imu/preintegration.h"
#include "rotation/constants.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// No observation of the track is further than `limit` [rad] from their mean.
bool staysInPlace(const InitWindow& window, const Track& track, double limit) {
  const WindowPoint* observations = window.pointObservations().data();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int a = track.begin; a < track.end; ++a) mean += observations[a].bearing;
  mean /= track.size();
  return std::all_of(
      observations + track.begin, observations + track.end,
      [&](const WindowPoint& s) { return (s.bearing - mean).squaredNorm() < limit * limit; });
}

// The rotation moves a far point by more than `limit` [rad] after the first observation.
bool isTurnedAway(const InitWindow& window, const Track& track,
                  const std::vector<Eigen::Matrix3d>& R_c0_ck, double limit) {
  const WindowPoint* observations = window.pointObservations().data();
  const WindowPoint& first = observations[track.begin];
  const Eigen::Vector3d f_c0 = R_c0_ck[first.keyframe] * first.bearing;
  return std::any_of(
      observations + track.begin, observations + track.end, [&](const WindowPoint& s) {
        return (R_c0_ck[s.keyframe].transpose() * f_c0 - first.bearing).norm() > limit;
      });
}

}  // namespace

std::vector<char> staticTracks(const InitWindow& window, const Eigen::Vector3d& gyro_bias) {
  const std::vector<Track>& tracks = window.pointTracks();
  const double sigma = window.calibration().sigmaBearing();
  std::vector<char> static_tracks(tracks.size());
  std::transform(tracks.begin(), tracks.end(), static_tracks.begin(), [&](const Track& track) {
    return staysInPlace(window, track, kOutlierSigmas * sigma);
  });
  // Without a look at the gyroscope: in motion hardly a track stays in its place.
  const auto count = [&] { return std::count(static_tracks.begin(), static_tracks.end(), 1); };
  if (count() == 0) return static_tracks;
  const std::vector<Eigen::Matrix3d> R_c0_ck =
      cameraRotations(chainRotations(preintegrateWindow(window, gyro_bias, Eigen::Vector3d::Zero(),
                                                        PreintegrationParts::kRotation)),
                      window.calibration().R_b_c);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    static_tracks[i] =
        static_tracks[i] && isTurnedAway(window, tracks[i], R_c0_ck, kTurnedSigmas * sigma);
  }
  if (count() > kMaxStaticFraction * tracks.size()) static_tracks.assign(tracks.size(), 0);
  return static_tracks;
}

std::shared_ptr<const InitWindow> withoutStaticTracks(const InitWindow& window,
                                                      const Eigen::Vector3d& gyro_bias,
                                                      int* static_tracks) {
  *static_tracks = 0;
  const std::vector<char> stands = staticTracks(window, gyro_bias);
  const auto count = std::count(stands.begin(), stands.end(), 1);
  if (count == 0 || count < kMinStaticFraction * stands.size()) return nullptr;
  *static_tracks = static_cast<int>(count);
  std::vector<char> keep(window.pointObservations().size(), kKeepObservation);
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const Track& track = window.pointTracks()[i];
    if (stands[i]) std::fill_n(keep.begin() + track.begin, track.size(), kDropObservation);
  }
  return withObservations(window, keep);
}

}  // namespace slim_init
