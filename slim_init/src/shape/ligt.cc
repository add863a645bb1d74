// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "shape/ligt.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/dense.h"
#include "geometry/robust.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

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
  std::vector<Vote> votes;  // one per track used
};

// Adds L^T L of one row to the lower triangle of H, times `weight`; l, r and i are keyframes.
void addLigtRow(LigtRow row, int l, int r, int i, double weight, Eigen::MatrixXd* H) {
  const int k[3] = {l, r, i};
  const Eigen::Matrix3d* block[3] = {&row.block_l, &row.block_r, &row.block_i};
  // In the right base view itself r and i are the same centre.
  const int blocks = i == r ? 2 : 3;
  if (i == r) row.block_r += row.block_i;
  for (int p = 0; p < blocks; ++p) {
    for (int q = 0; q < blocks; ++q) {
      if (k[p] < k[q]) continue;
      H->block<3, 3>(3 * k[p], 3 * k[q]).noalias() += (weight * block[p]->transpose()) * *block[q];
    }
  }
}

// Mean of the squares of a track's rows at `centres` (stacked), each row of l, r and i.
double meanSquare(const std::vector<LigtRow>& rows,
                  const std::vector<std::array<int, 3>>& keyframes,
                  const Eigen::VectorXd& centres) {
  double sum = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const auto [l, r, i] = keyframes[a];
    sum +=
        (rows[a].block_l * centres.segment<3>(3 * l) + rows[a].block_r * centres.segment<3>(3 * r) +
         rows[a].block_i * centres.segment<3>(3 * i))
            .squaredNorm();
  }
  return sum / static_cast<double>(rows.size());
}

// `lengths`: of the rows divided by |theta|^2, and of their weights; null: of the rows themselves.
PointRows sumPointRows(const InitWindow& window, const std::vector<Eigen::Matrix3d>& R_c0_ck,
                       const LengthWeights* lengths) {
  const std::vector<WindowPoint>& observations = window.pointObservations();
  PointRows out;
  out.H = Eigen::MatrixXd::Zero(3 * window.size(), 3 * window.size());
  out.votes.reserve(window.pointTracks().size());
  std::vector<Eigen::Vector3d> u;
  std::vector<LigtRow> rows;
  std::vector<std::array<int, 3>> keyframes;
  for (const Track& track : window.pointTracks()) {
    if (track.size() < kMinTrackLength) continue;
    u.clear();
    for (int s = track.begin; s < track.end; ++s) {
      u.push_back(R_c0_ck[observations[s].keyframe] * observations[s].bearing);
    }
    const BaseViews base = chooseBaseViews(u);
    if (base.parallax2 <= kSmallestAngle * kSmallestAngle) continue;
    const int l = observations[track.begin + base.l].keyframe;
    const int r = observations[track.begin + base.r].keyframe;
    rows.clear();
    keyframes.clear();
    for (int a = 0; a < track.size(); ++a) {
      if (a == base.l) continue;
      rows.push_back(ligtRow(u[base.l], u[base.r], u[a]));
      keyframes.push_back({l, r, observations[track.begin + a].keyframe});
    }
    double weight = 1.0;
    if (lengths != nullptr) {
      const double to_length2 = 1.0 / (base.parallax2 * base.parallax2);
      weight = to_length2;
      if (lengths->centres.size() > 0) {
        const double misfit2 = to_length2 * meanSquare(rows, keyframes, lengths->centres);
        weight *= gemanMcClure(misfit2 / (lengths->sigma * lengths->sigma));
      }
    }
    for (std::size_t a = 0; a < rows.size(); ++a) {
      addLigtRow(rows[a], l, r, keyframes[a][2], weight, &out.H);
    }
    out.rows += 3 * static_cast<int>(rows.size());
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

Eigen::MatrixXd lengthNormalMatrix(const InitWindow& window,
                                   const std::vector<Eigen::Matrix3d>& R_c0_ck,
                                   const LengthWeights& weights) {
  return sumPointRows(window, R_c0_ck, &weights).H.selfadjointView<Eigen::Lower>();
}

TranslationEstimate estimateTranslations(const InitWindow& window,
                                         const std::vector<Eigen::Matrix3d>& R_c0_ck) {
  TranslationEstimate estimate;
  const int n = window.size();
  PointRows points = sumPointRows(window, R_c0_ck, nullptr);
  Eigen::MatrixXd& H = points.H;
  estimate.rows = points.rows;
  estimate.tracks = static_cast<int>(points.votes.size());
  if (estimate.tracks < kMinTracks) return estimate;

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
  int for_it = 0;  // votes for this sign less those against it
  for (const Vote& vote : points.votes) {
    const double depth = vote.row.dot(centres.col(vote.r) - centres.col(vote.l));
    for_it += depth > 0.0 ? 1 : -1;
  }
  if (for_it < 0) centres = -centres;
  estimate.centres_c0 = centres;
  estimate.normal_matrix = H.selfadjointView<Eigen::Lower>();
  estimate.valid = true;
  return estimate;
}

}  // namespace slim_init
