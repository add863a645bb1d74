// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Vote and refine for one keyframe (paper IV-B-1).
#include "lines/vanishing_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "lines/constants.h"

namespace slim_init {
namespace {

using namespace lines_constants;  // NOLINT: the constants of this module

// ------------------------------------------------------------------------------------------------
// Voting. Finds exactly the direction that a full vote over the icosphere finds, by branch and
// bound: directions lie in compact blocks, a vote with a threshold widened by the block's radius
// bounds what any direction of the block can get, and blocks that cannot win are not opened.

// Directions per block. A constant, so that the inner loop becomes four SSE (two AVX) operations.
constexpr int kLanes = 16;

// Up to kLanes directions, one array per coordinate. Lanes left over repeat the last direction.
struct alignas(64) DirectionBlock {
  float x[kLanes];
  float y[kLanes];
  float z[kLanes];
};

struct VoteTable {
  std::vector<DirectionBlock> blocks;
  std::vector<std::array<int, kLanes>> indices;  // per block and lane: into icosphereHemisphere()
  // Per block, kLanes blocks at a time: centre, and sine and cosine of the largest angle from the
  // centre to a direction of the block.
  std::vector<DirectionBlock> centers;
  std::vector<float> sin_radius;
  std::vector<float> cos_radius;
};

void setLane(DirectionBlock& block, int lane, const Eigen::Vector3d& direction) {
  block.x[lane] = static_cast<float>(direction.x());
  block.y[lane] = static_cast<float>(direction.y());
  block.z[lane] = static_cast<float>(direction.z());
}

// Halves [begin, end) across its widest coordinate until a block is left.
void addBlocks(const std::vector<Eigen::Vector3d>& directions, std::vector<int>::iterator begin,
               std::vector<int>::iterator end, VoteTable& table) {
  const int count = static_cast<int>(end - begin);
  if (count > kLanes) {
    Eigen::Array3d lower = directions[*begin].array();
    Eigen::Array3d upper = lower;
    for (auto it = begin; it != end; ++it) {
      lower = lower.min(directions[*it].array());
      upper = upper.max(directions[*it].array());
    }
    int axis = 0;
    (upper - lower).maxCoeff(&axis);
    // A multiple of kLanes on the left keeps all blocks but one full.
    const auto middle = begin + std::max(1, count / (2 * kLanes)) * kLanes;
    std::nth_element(begin, middle, end, [&](int a, int b) {
      const double coordinate_a = directions[a][axis];
      const double coordinate_b = directions[b][axis];
      return coordinate_a != coordinate_b ? coordinate_a < coordinate_b : a < b;
    });
    addBlocks(directions, begin, middle, table);
    addBlocks(directions, middle, end, table);
    return;
  }

  std::sort(begin, end);
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (auto it = begin; it != end; ++it) center += directions[*it];
  center.normalize();
  double cos_radius = 1.0;
  DirectionBlock block;
  std::array<int, kLanes> indices;
  for (int lane = 0; lane < kLanes; ++lane) {
    indices[lane] = begin[std::min(lane, count - 1)];
    setLane(block, lane, directions[indices[lane]]);
    cos_radius = std::min(cos_radius, center.dot(directions[indices[lane]]));
  }

  const int block_index = static_cast<int>(table.blocks.size());
  if (block_index % kLanes == 0) table.centers.emplace_back();
  // Later blocks overwrite the lanes behind; at the end those repeat the last centre.
  for (int lane = block_index % kLanes; lane < kLanes; ++lane) {
    setLane(table.centers.back(), lane, center);
  }
  table.blocks.push_back(block);
  table.indices.push_back(indices);
  table.cos_radius.push_back(static_cast<float>(cos_radius));
  table.sin_radius.push_back(
      static_cast<float>(std::sqrt(std::max(0.0, 1.0 - cos_radius * cos_radius))));
}

VoteTable makeVoteTable(int subdivisions) {
  const std::vector<Eigen::Vector3d>& directions = icosphereHemisphere(subdivisions);
  std::vector<int> order(directions.size());
  std::iota(order.begin(), order.end(), 0);
  VoteTable table;
  addBlocks(directions, order.begin(), order.end(), table);
  return table;
}

template <int kSubdivisions>
const VoteTable& voteTableOfLevel() {
  static const VoteTable table = makeVoteTable(kSubdivisions);
  return table;
}

const VoteTable& voteTable(int subdivisions) {
  switch (std::clamp(subdivisions, 0, 6)) {
    case 0: return voteTableOfLevel<0>();
    case 1: return voteTableOfLevel<1>();
    case 2: return voteTableOfLevel<2>();
    case 3: return voteTableOfLevel<3>();
    case 4: return voteTableOfLevel<4>();
    case 5: return voteTableOfLevel<5>();
    default: return voteTableOfLevel<6>();
  }
}

// A line as the vote sees it.
struct VotingLine {
  float x, y, z;  // interpretation plane normal, unit, in c
  float weight;   // a whole number, see votingLines()
};

// Weights are lengths in steps small enough to matter to no one and whole, with a sum below 2^24:
// such sums are exact in float, so votes, and with them ties, do not depend on the order of lines.
std::vector<VotingLine> votingLines(const std::vector<WindowLine>& lines) {
  double max_length_px = 0.0;
  for (const WindowLine& line : lines) max_length_px = std::max(max_length_px, line.length_px);
  std::vector<VotingLine> voting;
  if (!(max_length_px > 0.0)) return voting;
  voting.reserve(lines.size());
  const double steps = std::floor(16777215.0 / static_cast<double>(lines.size()));
  for (const WindowLine& line : lines) {
    if (!(line.length_px > 0.0)) continue;
    const Eigen::Vector3f normal = line.normal.cast<float>();
    const double weight = std::floor(steps * (line.length_px / max_length_px));
    voting.push_back({normal.x(), normal.y(), normal.z(), static_cast<float>(weight)});
  }
  return voting;
}

// votes[k] = sum of the weights of the lines with |n . d_k| < threshold[k].
void vote(const DirectionBlock& block, const float* threshold, const std::vector<VotingLine>& lines,
          float* votes) {
  float sum[kLanes] = {};
  for (const VotingLine& line : lines) {
    const auto [x, y, z, weight] = line;
    for (int k = 0; k < kLanes; ++k) {
      const float error = std::fabs(x * block.x[k] + y * block.y[k] + z * block.z[k]);
      sum[k] += error < threshold[k] ? weight : 0.0F;
    }
  }
  std::copy(sum, sum + kLanes, votes);
}

// Index into icosphereHemisphere() of the direction with the most votes, the lowest one of equals.
// Requires at least one line.
int mostVotedDirection(const VoteTable& table, const std::vector<VotingLine>& lines,
                       double threshold_rad) {
  const auto sin_threshold = static_cast<float>(std::sin(threshold_rad));
  const auto cos_threshold = static_cast<float>(std::cos(threshold_rad));
  const int block_count = static_cast<int>(table.blocks.size());

  // A plane within the threshold of a direction is within threshold + radius of the block's centre.
  std::vector<float> bounds(table.centers.size() * kLanes);
  float threshold[kLanes];
  for (std::size_t group = 0; group < table.centers.size(); ++group) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int block = std::min(static_cast<int>(group) * kLanes + lane, block_count - 1);
      const float sin_radius = table.sin_radius[block];
      const float cos_radius = table.cos_radius[block];
      const bool is_below_90_deg = cos_threshold * cos_radius - sin_threshold * sin_radius > 0.0F;
      threshold[lane] =
          is_below_90_deg ? sin_threshold * cos_radius + cos_threshold * sin_radius + kRoundingSlack
                          : 2.0F;
    }
    vote(table.centers[group], threshold, lines, &bounds[group * kLanes]);
  }

  std::fill(threshold, threshold + kLanes, sin_threshold);
  float most_votes = -1.0F;
  int best_index = 0;
  const auto open = [&](int block) {
    float votes[kLanes];
    vote(table.blocks[block], threshold, lines, votes);
    for (int lane = 0; lane < kLanes; ++lane) {
      const int index = table.indices[block][lane];
      if (votes[lane] > most_votes || (votes[lane] == most_votes && index < best_index)) {
        most_votes = votes[lane];
        best_index = index;
      }
    }
  };
  // The most promising block first: what it holds excludes most of the others.
  const int first = static_cast<int>(
      std::max_element(bounds.begin(), bounds.begin() + block_count) - bounds.begin());
  open(first);
  for (int block = 0; block < block_count; ++block) {
    if (block != first && bounds[block] >= most_votes) open(block);
  }
  return best_index;
}

// ------------------------------------------------------------------------------------------------
// Refinement.

// Variance of n . d over the square of the end point noise, for noise of both end points across the
// line. The normal n keeps s and e, so with d = a s + b e in the plane n . d errs by a times the
// noise of s and b times that of e, hence a^2 + b^2: 1/2 in the middle of the segment, large for a
// short segment far from d. Of a d off the plane it takes the projection.
double errorAmplification(const WindowLine& line, const Eigen::Vector3d& d) {
  const double cosine = line.start_bearing.dot(line.end_bearing);
  const double d_s = d.dot(line.start_bearing);
  const double d_e = d.dot(line.end_bearing);
  const double a_numerator = d_s - cosine * d_e;
  const double b_numerator = d_e - cosine * d_s;
  const double squared_sine = std::max((1.0 - cosine) * (1.0 + cosine), kMinSquaredSine);
  return (a_numerator * a_numerator + b_numerator * b_numerator) / (squared_sine * squared_sine);
}

void selectInliers(const std::vector<WindowLine>& lines, const Eigen::Vector3d& direction,
                   double sin_threshold, std::vector<int>& inliers) {
  inliers.clear();
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (lines[l].length_px > 0.0 && std::abs(lines[l].normal.dot(direction)) < sin_threshold) {
      inliers.push_back(static_cast<int>(l));
    }
  }
}

// Eigenvalues ascending and eigenvectors of sum w n n^T / sum w, w = length.
using NormalScatter = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>;

NormalScatter scatterOfNormals(const std::vector<WindowLine>& lines,
                               const std::vector<int>& inliers) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double weight_sum = 0.0;
  for (const int l : inliers) {
    scatter += (lines[l].length_px * lines[l].normal) * lines[l].normal.transpose();
    weight_sum += lines[l].length_px;
  }
  return NormalScatter(scatter / weight_sum);
}

bool isDetermined(const std::vector<WindowLine>& lines, const std::vector<int>& inliers,
                  const NormalScatter& scatter, double sigma_line_rad) {
  double noise_direction = 0.0;
  double noise_weakest = 0.0;
  double weight_sum = 0.0;
  for (const int l : inliers) {
    const double weight = lines[l].length_px;
    noise_direction += weight * errorAmplification(lines[l], scatter.eigenvectors().col(0));
    noise_weakest += weight * errorAmplification(lines[l], scatter.eigenvectors().col(1));
    weight_sum += weight;
  }
  const double expected =
      sigma_line_rad * sigma_line_rad / weight_sum * std::max(noise_direction, noise_weakest);
  const double error = std::max(expected, scatter.eigenvalues()[0]);
  return scatter.eigenvalues()[1] >= std::max(kMinDetermination * error, kMinPlaneSpread);
}

// Sandwich A^+ B A^+ of the length-weighted fit: A = sum w n n^T over the tangent plane (less its
// smallest eigenvalue, the curvature of the sphere), B = sum w^2 var(n . d) n n^T.
Eigen::Matrix3d covarianceOfDirection(const std::vector<WindowLine>& lines,
                                      const std::vector<int>& inliers, const NormalScatter& scatter,
                                      double sigma_line_rad) {
  const Eigen::Vector3d direction = scatter.eigenvectors().col(0);
  const Eigen::Matrix<double, 3, 2> tangent = scatter.eigenvectors().rightCols<2>();
  Eigen::Matrix2d b = Eigen::Matrix2d::Zero();
  double weight_sum = 0.0;
  for (const int l : inliers) {
    const Eigen::Vector2d normal = tangent.transpose() * lines[l].normal;
    const double weight = lines[l].length_px;
    b += (weight * weight * errorAmplification(lines[l], direction)) * normal * normal.transpose();
    weight_sum += weight;
  }
  b *= (sigma_line_rad / weight_sum) * (sigma_line_rad / weight_sum);
  const Eigen::Vector2d curvature =
      (scatter.eigenvalues().tail<2>().array() - scatter.eigenvalues()[0]).matrix();
  const Eigen::Matrix<double, 3, 2> gain = tangent * curvature.cwiseInverse().asDiagonal();
  return gain * b * gain.transpose();
}

}  // namespace

VanishingPoint estimateVanishingPoint(const std::vector<WindowLine>& lines, double sigma_line_rad,
                                      const VanishingPointOptions& options) {
  VanishingPoint vp;
  const std::size_t min_inliers = static_cast<std::size_t>(std::max(2, options.min_inliers));
  const std::vector<VotingLine> voting = votingLines(lines);
  if (voting.size() < min_inliers) return vp;

  const double vote_threshold_rad = options.vote_threshold_deg * kRadPerDeg;
  const int winner =
      mostVotedDirection(voteTable(options.icosphere_subdivisions), voting, vote_threshold_rad);
  Eigen::Vector3d direction = icosphereHemisphere(options.icosphere_subdivisions)[winner];

  // The first fit takes the lines that voted: the direction of the grid may be as far from the
  // vanishing point as t_in. Later ones take the inliers of the fit before.
  const double sin_inlier = std::sin(options.inlier_threshold_deg * kRadPerDeg);
  std::vector<int> inliers;
  selectInliers(lines, direction, std::sin(vote_threshold_rad), inliers);
  if (inliers.size() < min_inliers) return vp;
  NormalScatter scatter = scatterOfNormals(lines, inliers);
  std::vector<int> selected;
  for (int round = 0; round < kMaxRounds; ++round) {
    direction = scatter.eigenvectors().col(0);
    selectInliers(lines, direction, sin_inlier, selected);
    if (selected.size() < min_inliers) return vp;
    if (selected == inliers) break;
    inliers.swap(selected);
    scatter = scatterOfNormals(lines, inliers);
  }
  direction = scatter.eigenvectors().col(0);
  if (!isDetermined(lines, inliers, scatter, sigma_line_rad)) return vp;

  double squared_sum = 0.0;
  for (const int l : inliers) {
    const double error = lines[l].normal.dot(direction);
    squared_sum += error * error;
  }
  vp.found = true;
  vp.direction = direction.z() < 0.0 ? Eigen::Vector3d(-direction) : direction;
  vp.covariance = covarianceOfDirection(lines, inliers, scatter, sigma_line_rad);
  vp.consistency_rad = std::sqrt(squared_sum / static_cast<double>(inliers.size()));
  vp.inliers = std::move(inliers);
  return vp;
}

}  // namespace slim_init
