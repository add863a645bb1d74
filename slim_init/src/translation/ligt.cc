// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "translation/ligt.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// Base views of a track: the two sightings with the largest rotation-compensated parallax.
struct BaseViews {
  int l = 0, r = 0;         // offsets into the track, l < r
  double parallax2 = -1.0;  // |u_l x u_r|^2
};

BaseViews chooseBaseViews(const std::vector<Eigen::Vector3d>& u) {
  BaseViews best;
  for (std::size_t a = 0; a < u.size(); ++a) {
    for (std::size_t b = a + 1; b < u.size(); ++b) {
      const double parallax2 = u[a].cross(u[b]).squaredNorm();
      if (parallax2 > best.parallax2) {
        best = {static_cast<int>(a), static_cast<int>(b), parallax2};
      }
    }
  }
  return best;
}

}  // namespace

LigtRow ligtRow(const Eigen::Vector3d& u_l, const Eigen::Vector3d& u_r,
                const Eigen::Vector3d& u_i) {
  const Eigen::Vector3d theta = u_l.cross(u_r);
  const double theta2 = theta.squaredNorm();
  LigtRow row;
  // theta . (b x u_r) = (u_r x theta) . b
  row.block_r = u_i.cross(u_l) * u_r.cross(theta).transpose();
  row.block_i = -theta2 * skew(u_i);
  row.block_l = -(row.block_r + row.block_i);
  return row;
}

TranslationEstimate estimateTranslations(const InitWindow& window,
                                         const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                         const AlignmentOptions& options) {
  TranslationEstimate estimate;
  const int n = window.size();
  const std::vector<PointSighting>& sightings = window.pointSightings();

  // Normal matrix over all centres, lower triangle. The gauge (centre 0 at zero) is fixed by
  // leaving out its rows and columns at the end.
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  // Depth in the left base view, up to a positive factor, is votes_row . (c_r - c_l).
  struct Vote {
    int l, r;
    Eigen::Vector3d row;
  };
  std::vector<Vote> votes;
  votes.reserve(window.pointTracks().size());
  std::vector<Eigen::Vector3d> u;
  for (const Track& track : window.pointTracks()) {
    if (track.size() < options.min_track_length) continue;
    u.clear();
    for (int s = track.begin; s < track.end; ++s) {
      u.push_back(R_c0_ck[sightings[s].keyframe] * sightings[s].bearing);
    }
    const BaseViews base = chooseBaseViews(u);
    if (base.parallax2 <= options.min_parallax_rad * options.min_parallax_rad) continue;
    const int l = sightings[track.begin + base.l].keyframe;
    const int r = sightings[track.begin + base.r].keyframe;
    for (int a = 0; a < track.size(); ++a) {
      if (a == base.l) continue;
      const int i = sightings[track.begin + a].keyframe;
      LigtRow row = ligtRow(u[base.l], u[base.r], u[a]);
      const int k[3] = {l, r, i};
      const Eigen::Matrix3d* block[3] = {&row.block_l, &row.block_r, &row.block_i};
      // In the right base view itself r and i are the same centre.
      const int blocks = i == r ? 2 : 3;
      if (i == r) row.block_r += row.block_i;
      for (int p = 0; p < blocks; ++p) {
        for (int q = 0; q < blocks; ++q) {
          if (k[p] >= k[q]) {
            H.block<3, 3>(3 * k[p], 3 * k[q]).noalias() += block[p]->transpose() * *block[q];
          }
        }
      }
      estimate.rows += 3;
    }
    votes.push_back({l, r, u[base.r].cross(u[base.l].cross(u[base.r]))});
    ++estimate.tracks;
  }
  if (estimate.tracks < options.min_tracks) return estimate;

  const int m = 3 * (n - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(H.bottomRightCorner(m, m));
  if (solver.info() != Eigen::Success) return estimate;
  estimate.lambda_1 = std::max(solver.eigenvalues()[0], 0.0);
  estimate.lambda_2 = solver.eigenvalues()[1];
  estimate.lambda_max = solver.eigenvalues()[m - 1];

  Eigen::Matrix3Xd centres = Eigen::Matrix3Xd::Zero(3, n);
  for (int k = 1; k < n; ++k) centres.col(k) = solver.eigenvectors().col(0).segment<3>(3 * (k - 1));
  const double spread = (centres.colwise() - centres.rowwise().mean()).norm();
  if (!std::isfinite(spread) || spread <= 0.0) return estimate;
  centres /= spread;

  for (const Vote& vote : votes) {
    const double depth = vote.row.dot(centres.col(vote.r) - centres.col(vote.l));
    ++(depth > 0.0 ? estimate.positive_votes : estimate.negative_votes);
  }
  if (estimate.positive_votes < estimate.negative_votes) {
    centres = -centres;
    std::swap(estimate.positive_votes, estimate.negative_votes);
  }
  estimate.centres_c0 = centres;
  estimate.normal_matrix = H.selfadjointView<Eigen::Lower>();
  estimate.valid = true;
  return estimate;
}

}  // namespace slim_init
