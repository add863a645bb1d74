// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "translation/ligt.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/dense.h"
#include "geometry/median.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

// Adds the rows of all line tracks to the lower triangle of H.
int addLineRows(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck,
                const AlignmentOptions& options, double weight, Eigen::MatrixXd* H) {
  int rows = 0;
  std::vector<Eigen::Vector3d> N;
  for (const Track& track : window.lineTracks()) {
    if (track.size() < options.min_track_length) continue;
    N.clear();
    for (int s = track.begin; s < track.end; ++s) {
      const WindowLine& line = window.lineObservations()[s];
      N.push_back(R_c0_ck[line.keyframe] * line.normal);
      // The normal of a plane has no sign of its own; end points may have been swapped.
      if (N.back().dot(N.front()) < 0.0) N.back() = -N.back();
    }
    const BaseViews base = chooseBaseViews(N);
    if (base.parallax2 <= options.min_parallax_rad * options.min_parallax_rad) continue;
    for (int a = 0; a < track.size(); ++a) {
      if (a == base.l || a == base.r) continue;
      const LineRow row = lineRow(N[base.l], N[base.r], N[a]);
      const WindowLine* const views = &window.lineObservations()[track.begin];
      const int k[3] = {views[base.l].keyframe, views[base.r].keyframe, views[a].keyframe};
      const Eigen::RowVector3d* block[3] = {&row.block_l, &row.block_r, &row.block_i};
      for (int p = 0; p < 3; ++p) {
        for (int q = 0; q < 3; ++q) {
          if (k[p] < k[q]) continue;
          H->block<3, 3>(3 * k[p], 3 * k[q]).noalias() +=
              weight * weight * block[p]->transpose() * *block[q];
        }
      }
      ++rows;
    }
  }
  return rows;
}

// Depth in the left base view, up to a positive factor, is row . (c_r - c_l).
struct Vote {
  int l, r;
  Eigen::Vector3d row;
};

// What the point tracks say.
struct PointRows {
  // Normal matrix over all centres, lower triangle. The gauge (centre 0 at zero) is fixed by
  // leaving out its rows and columns at the end.
  Eigen::MatrixXd H;
  int rows = 0;
  std::vector<Vote> votes;        // one per track used
  std::vector<double> parallax2;  // |theta|^2 of the same
};

// Adds L^T L of one row to the lower triangle of H; l, r and i are keyframes.
void addLigtRow(LigtRow row, int l, int r, int i, Eigen::MatrixXd* H) {
  const int k[3] = {l, r, i};
  const Eigen::Matrix3d* block[3] = {&row.block_l, &row.block_r, &row.block_i};
  // In the right base view itself r and i are the same centre.
  const int blocks = i == r ? 2 : 3;
  if (i == r) row.block_r += row.block_i;
  for (int p = 0; p < blocks; ++p) {
    for (int q = 0; q < blocks; ++q) {
      if (k[p] < k[q]) continue;
      H->block<3, 3>(3 * k[p], 3 * k[q]).noalias() += block[p]->transpose() * *block[q];
    }
  }
}

PointRows sumPointRows(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck,
                       const AlignmentOptions& options) {
  const std::vector<WindowPoint>& observations = window.pointObservations();
  PointRows out;
  out.H = Eigen::MatrixXd::Zero(3 * window.size(), 3 * window.size());
  out.votes.reserve(window.pointTracks().size());
  std::vector<Eigen::Vector3d> u;
  for (const Track& track : window.pointTracks()) {
    if (track.size() < options.min_track_length) continue;
    u.clear();
    for (int s = track.begin; s < track.end; ++s) {
      u.push_back(R_c0_ck[observations[s].keyframe] * observations[s].bearing);
    }
    const BaseViews base = chooseBaseViews(u);
    if (base.parallax2 <= options.min_parallax_rad * options.min_parallax_rad) continue;
    const int l = observations[track.begin + base.l].keyframe;
    const int r = observations[track.begin + base.r].keyframe;
    for (int a = 0; a < track.size(); ++a) {
      if (a == base.l) continue;
      const int i = observations[track.begin + a].keyframe;
      addLigtRow(ligtRow(u[base.l], u[base.r], u[a]), l, r, i, &out.H);
      out.rows += 3;
    }
    out.parallax2.push_back(base.parallax2);
    out.votes.push_back({l, r, u[base.r].cross(u[base.l].cross(u[base.r]))});
  }
  return out;
}

}  // namespace

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

LineRow lineRow(const Eigen::Vector3d& N_l, const Eigen::Vector3d& N_r,
                const Eigen::Vector3d& N_i) {
  // N_l and N_r span the plane across the line; the foot of N_i in it gives a and b. By cross
  // products: 1 - (N_l . N_r)^2 and its like lose the digits of a small parallax.
  const Eigen::Vector3d along = N_l.cross(N_r);
  const Eigen::Vector3d abc =
      Eigen::Vector3d(N_r.cross(N_i).dot(along), N_i.cross(N_l).dot(along), along.squaredNorm())
          .normalized();
  LineRow row;
  row.block_l = abc[0] * N_l.transpose();
  row.block_r = abc[1] * N_r.transpose();
  row.block_i = -(row.block_l + row.block_r);
  return row;
}

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
  PointRows points = sumPointRows(window, R_c0_ck, options);
  Eigen::MatrixXd& H = points.H;
  estimate.rows = points.rows;
  estimate.tracks = static_cast<int>(points.votes.size());
  if (estimate.tracks < options.min_tracks) return estimate;
  if (options.use_line_rows) {
    // A point row is about |theta|^2 of its track times its distance times the noise, a line row
    // the distance times the noise.
    const Calibration& calibration = window.calibration();
    const double weight =
        median(points.parallax2) * calibration.pointSigmaPx() / calibration.lineSigmaPx();
    estimate.rows += addLineRows(window, R_c0_ck, options, weight, &H);
  }

  const int m = 3 * (n - 1);
  const SymmetricEigen eigen = symmetricEigen(H.bottomRightCorner(m, m));
  if (!eigen.valid) return estimate;
  estimate.lambda_1 = std::max(eigen.values[0], 0.0);
  estimate.lambda_2 = eigen.values[1];
  estimate.lambda_max = eigen.values[m - 1];

  Eigen::Matrix3Xd centres = Eigen::Matrix3Xd::Zero(3, n);
  for (int k = 1; k < n; ++k) centres.col(k) = eigen.vectors.col(0).segment<3>(3 * (k - 1));
  const double spread = (centres.colwise() - centres.rowwise().mean()).norm();
  if (!std::isfinite(spread) || spread <= 0.0) return estimate;
  centres /= spread;
  for (const Vote& vote : points.votes) {
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
