// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/standing_tracks.h"

#include <algorithm>
#include <cmath>

#include "data/with_sightings.h"
#include "imu/preintegration.h"
#include "rotation/constants.h"

namespace slim_init {
namespace {

using namespace rotation_constants;  // NOLINT: the constants of this module

// No sighting of the track is further than `limit` [rad] from their mean.
bool staysInPlace(const InitWindow& window, const Track& track, double limit) {
  const PointSighting* sightings = window.pointSightings().data();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int a = track.begin; a < track.end; ++a) mean += sightings[a].bearing;
  mean /= track.size();
  return std::all_of(sightings + track.begin, sightings + track.end, [&](const PointSighting& s) {
    return (s.bearing - mean).squaredNorm() < limit * limit;
  });
}

// The rotation moves a far point by more than `limit` [rad] after the first sighting.
bool isTurnedAway(const InitWindow& window, const Track& track,
                  const std::vector<Eigen::Matrix3d>& R_c0_ck, double limit) {
  const PointSighting* sightings = window.pointSightings().data();
  const PointSighting& first = sightings[track.begin];
  const Eigen::Vector3d f_c0 = R_c0_ck[first.keyframe] * first.bearing;
  return std::any_of(sightings + track.begin, sightings + track.end, [&](const PointSighting& s) {
    return (R_c0_ck[s.keyframe].transpose() * f_c0 - first.bearing).norm() > limit;
  });
}

}  // namespace

std::vector<char> standingTracks(const InitWindow& window, const Eigen::Vector3d& gyro_bias) {
  const std::vector<Track>& tracks = window.pointTracks();
  const double sigma = window.calibration().sigmaBearing();
  std::vector<char> standing(tracks.size());
  std::transform(tracks.begin(), tracks.end(), standing.begin(), [&](const Track& track) {
    return staysInPlace(window, track, kStandingSigmas * sigma);
  });
  // Without a look at the gyroscope: in motion hardly a track stays in its place.
  const auto count = [&] { return std::count(standing.begin(), standing.end(), 1); };
  if (count() == 0) return standing;
  const std::vector<Eigen::Matrix3d> R_c0_ck =
      cameraRotations(chainRotations(preintegrateWindow(window, gyro_bias, Eigen::Vector3d::Zero(),
                                                        PreintegrationParts::kRotation)),
                      window.calibration().R_b_c);
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    standing[i] = standing[i] && isTurnedAway(window, tracks[i], R_c0_ck, kTurnedSigmas * sigma);
  }
  if (count() > kMostStanding * tracks.size()) standing.assign(tracks.size(), 0);
  return standing;
}

std::shared_ptr<const InitWindow> withoutStandingTracks(const InitWindow& window,
                                                        const Eigen::Vector3d& gyro_bias,
                                                        int* standing) {
  *standing = 0;
  const std::vector<char> stands = standingTracks(window, gyro_bias);
  const auto count = std::count(stands.begin(), stands.end(), 1);
  if (count == 0 || count < kFewStanding * stands.size()) return nullptr;
  *standing = static_cast<int>(count);
  std::vector<char> keep(window.pointSightings().size(), kKeepSighting);
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const Track& track = window.pointTracks()[i];
    if (stands[i]) std::fill_n(keep.begin() + track.begin, track.size(), kDropSighting);
  }
  return withSightings(window, keep);
}

}  // namespace slim_init
