// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/keyframe_pairs.h"

#include <algorithm>

#include "data/with_observations.h"
#include "geometry/so3.h"
#include "rotation/constants.h"

namespace slim_init {

KeyframePairs::KeyframePairs(const InitWindow& window, int max_gap)
    : keyframes_(window.size()), sigma_(window.calibration().sigmaBearing()) {
  addPoints(window, layOut(max_gap));
  for (KeyframePair& pair : pairs_) {
    pair.use_points = pair.points.count() >= rotation_constants::kMinPointsPerPair;
  }
}

std::vector<int> KeyframePairs::layOut(int max_gap) {
  std::vector<int> index(keyframes_ * keyframes_, -1);
  for (const int gap : rotation_constants::kGaps) {
    if (gap >= keyframes_ || gap > max_gap) continue;
    for (int i = 0; i + gap < keyframes_; ++i) {
      index[i * keyframes_ + i + gap] = static_cast<int>(pairs_.size());
      pairs_.emplace_back();
      pairs_.back().i = i;
      pairs_.back().j = i + gap;
    }
  }
  return index;
}

void KeyframePairs::addPoints(const InitWindow& window, const std::vector<int>& index) {
  const std::vector<WindowPoint>& s = window.pointObservations();
  for (std::size_t t = 0; t < window.pointTracks().size(); ++t) {
    const Track& track = window.pointTracks()[t];
    for (int a = track.begin; a < track.end; ++a) {
      for (int b = a + 1; b < track.end; ++b) {
        const int p = index[s[a].keyframe * keyframes_ + s[b].keyframe];
        if (p < 0) continue;
        pairs_[p].points.add(s[a].bearing, s[b].bearing);
        pairs_[p].observation_i.push_back(a);
        pairs_[p].observation_j.push_back(b);
        pairs_[p].track.push_back(static_cast<int>(t));
      }
    }
  }
}

int KeyframePairs::pointPairs() const {
  return static_cast<int>(std::count_if(pairs_.begin(), pairs_.end(),
                                        [](const KeyframePair& pair) { return pair.use_points; }));
}

GyroRotations::GyroRotations(const InitWindow& window)
    : window_(window),
      pre_(preintegrateWindow(window, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                              PreintegrationParts::kRotation)) {}

void GyroRotations::linearizeNear(const Eigen::Vector3d& gyro_bias, double tolerance) {
  if ((gyro_bias - pre_.front().gyro_bias).norm() <= tolerance) return;
  pre_ = preintegrateWindow(window_, gyro_bias, Eigen::Vector3d::Zero(),
                            PreintegrationParts::kRotation);
}

PairRotations GyroRotations::at(const Eigen::Vector3d& gyro_bias, const KeyframePairs& pairs,
                                int max_gap) const {
  const Eigen::Matrix3d R_c_b = window_.calibration().R_b_c.transpose();
  // R_c0_ck, and in c0 the rotation vector by which the bias moves it (docs/derivation.md, 1.2).
  std::vector<Eigen::Matrix3d> attitude(pre_.size() + 1), derivative(pre_.size() + 1);
  attitude[0].setIdentity();
  derivative[0].setZero();
  for (std::size_t k = 0; k < pre_.size(); ++k) {
    const Eigen::Vector3d phi = pre_[k].dR_dbg * (gyro_bias - pre_[k].gyro_bias);
    attitude[k + 1] = attitude[k] * (R_c_b * (pre_[k].dR * expSO3(phi)) * R_c_b.transpose());
    derivative[k + 1] =
        derivative[k] + attitude[k + 1] * (R_c_b * (rightJacobian(phi) * pre_[k].dR_dbg));
  }
  PairRotations out(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    if (pair.gap() > max_gap) continue;
    const Eigen::Matrix3d Rt = attitude[pair.j].transpose();
    out[p].R_ci_cj = attitude[pair.i].transpose() * attitude[pair.j];
    out[p].dR_dbg = Rt * (derivative[pair.j] - derivative[pair.i]);
  }
  return out;
}

Baselines unknownBaselines(const KeyframePairs& pairs) {
  return Baselines(pairs.size(), Eigen::Vector3d::Zero());
}

BaselineConsensus findBaselines(const KeyframePairs& pairs, const PairRotations& rotations,
                                int max_gap, const ConsensusOptions& options, Baselines known) {
  BaselineConsensus out;
  out.baselines = std::move(known);
  int points = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!pairs[p].use_points || pairs[p].gap() > max_gap) continue;
    const ConsensusBaseline found = pairs[p].points.consensusBaseline(
        rotations[p].R_ci_cj, pairs.sigma(), options, static_cast<unsigned>(p), out.baselines[p]);
    out.baselines[p] = found.direction;
    out.cost += found.cost;
    points += pairs[p].points.count();
  }
  out.cost /= std::max(points, 1);
  return out;
}

PointMasks masksOf(const KeyframePairs& pairs, const std::vector<char>& keep) {
  PointMasks masks(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    masks[p].setOnes(pairs[p].points.count());
    for (int k = 0; k < pairs[p].points.count(); ++k) {
      if (keep[pairs[p].observation_i[k]] == kDropObservation ||
          keep[pairs[p].observation_j[k]] == kDropObservation) {
        masks[p][k] = 0.0;
      }
    }
  }
  return masks;
}

}  // namespace slim_init
