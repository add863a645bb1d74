// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/track_pruning.h"

#include <algorithm>
#include <array>

#include "data/derived_window.h"
#include "geometry/robust.h"
#include "imu/preintegration.h"
#include "rotation/normalized_epipolar_pair.h"

namespace slim_init {
namespace {

// Motion of a far point by the rotation alone above which a track that stays in its place stands
// in the image and not in the scene [standard deviations of a bearing]: 12 px.
constexpr double kTurnedSigmas = 20.0;
// Share of the tracks from which on they are taken out. Windows of a rigid scene have less.
constexpr double kMinStaticFraction = 0.05;
// Share above which none stands: the gyroscope has a glitch, or the images do not change.
constexpr double kMaxStaticFraction = 0.5;

enum Link : char { kUntested, kAgrees, kDisagrees };

// Of every observation to those of the same track 0 to kLongGap keyframes later: whether they agree
// with the motion of the camera.
using Links = std::vector<std::array<Link, kLongGap + 1>>;

Link linkBetween(const std::vector<WindowPoint>& points, const Links& links, int a, int b) {
  const int gap = points[b].keyframe - points[a].keyframe;
  return gap <= kLongGap ? links[a][gap] : kUntested;
}

// Most of the longest links between what is kept disagree: such a point slides slowly. Nothing is
// left of a track of a single observation either.
bool slides(const std::vector<WindowPoint>& points, const Links& links, const Track& track,
            const std::vector<char>& keep) {
  int kept = 0, agree = 0, disagree = 0;
  for (int a = track.begin; a < track.end; ++a) {
    if (keep[a] == kDropObservation) continue;
    ++kept;
    for (int b = a + 1; b < track.end; ++b) {
      if (keep[b] == kDropObservation || points[b].keyframe - points[a].keyframe != kLongGap) {
        continue;
      }
      agree += links[a][kLongGap] == kAgrees ? 1 : 0;
      disagree += links[a][kLongGap] == kDisagrees ? 1 : 0;
    }
  }
  return kept < 2 || disagree > agree;
}

// Drops what does not agree with the observations before it.
TrackPruning pruneBy(const Links& links, const InitWindow& window) {
  const std::vector<WindowPoint>& points = window.pointObservations();
  TrackPruning out;
  out.keep.assign(points.size(), kKeepObservation);
  for (const Track& track : window.pointTracks()) {
    int last = track.begin;  // that is kept
    for (int b = track.begin + 1; b < track.end; ++b) {
      const Link step = linkBetween(points, links, b - 1, b);
      out.checked += step == kUntested ? 0 : 1;
      out.inconsistent += step == kDisagrees ? 1 : 0;
      const Link with_last = linkBetween(points, links, last, b);
      if (with_last == kAgrees || (with_last == kUntested && last == b - 1)) {
        last = b;
      } else {
        out.keep[b] = kDropObservation;
      }
    }
    if (!slides(points, links, track, out.keep)) continue;
    std::fill_n(out.keep.begin() + track.begin, track.size(), kDropObservation);
  }
  return out;
}

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

TrackPruning pruneTracks(const InitWindow& window, const KeyframePairs& pairs,
                         const PairRotations& rotations, double threshold, Baselines* baselines) {
  const Eigen::ArrayXd all_points;
  Links links(window.pointObservations().size());
  NormalizedEpipolarPair weighted;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    const Eigen::Matrix3d& R = rotations[p].R_ci_cj;
    Eigen::Vector3d& baseline = (*baselines)[p];
    if (!pair.use_points || pair.gap() > kLongGap || baseline.squaredNorm() == 0.0) continue;
    // The winner of the draw went exactly through two noisy points.
    weighted.weigh(pair.points, all_points, R, baseline, pairs.sigma(), threshold);
    baseline = weighted.baseline(R, baseline);
    const PointResiduals residuals = pair.points.residuals(R, baseline, pairs.sigma());
    for (int k = 0; k < pair.points.count(); ++k) {
      links[pair.observation_i[k]][pair.gap()] =
          residuals.z2[k] > threshold * threshold ? kDisagrees : kAgrees;
    }
  }
  return pruneBy(links, window);
}

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
