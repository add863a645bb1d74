// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "rotation/keyframe_pairs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "data/derived_window.h"
#include "geometry/so3.h"

namespace slim_init {
namespace {

// Floor of the variance of a residual over that of a bearing, |e x f|^2 summed over both views. A
// point nearer to the baseline than this has noise of second order that the weight, of first
// order, does not know.
constexpr double kMinNoise = 1e-2;
// Mean squared residual [sigma^2] below which a baseline needs no rival; that of good data is one.
constexpr double kGoodEnough = 1.3;

// Small fixed sequence of indices; the standard library's distributions differ between libraries.
class Sequence {
 public:
  explicit Sequence(unsigned seed) : state_(0x9e3779b97f4a7c15ULL * (seed + 1ULL)) {}
  int below(int n) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<int>(((state_ >> 33) * static_cast<std::uint64_t>(n)) >> 31);
  }

 private:
  std::uint64_t state_;
};

}  // namespace

void PairPoints::add(const Eigen::Vector3d& f_i, const Eigen::Vector3d& f_j) {
  if (count_ == f_i_.rows()) {
    const Eigen::Index rows = std::max<Eigen::Index>(16, 2 * f_i_.rows());
    const Eigen::Index old = f_i_.rows();
    f_i_.conservativeResize(rows, 3);
    f_j_.conservativeResize(rows, 3);
    f_i_.bottomRows(rows - old).setZero();
    f_j_.bottomRows(rows - old).setZero();
  }
  f_i_.row(count_) = f_i.transpose().array();
  f_j_.row(count_) = f_j.transpose().array();
  ++count_;
}

PointResiduals PairPoints::residuals(const Eigen::Matrix3d& R_ci_cj,
                                     const Eigen::Vector3d& baseline, double sigma) const {
  // e . m = f_j^T A f_i, its variance sigma^2 (|e x f_i|^2 + |R^T e x f_j|^2).
  const Eigen::Matrix3d A = R_ci_cj.transpose() * skew(baseline);
  const Eigen::Vector3d a = R_ci_cj.transpose() * baseline;
  const auto ix = f_i_.col(0).head(count_), iy = f_i_.col(1).head(count_),
             iz = f_i_.col(2).head(count_);
  const auto jx = f_j_.col(0).head(count_), jy = f_j_.col(1).head(count_),
             jz = f_j_.col(2).head(count_);
  PointResiduals out;
  out.noise = (2.0 - (baseline.x() * ix + baseline.y() * iy + baseline.z() * iz).square() -
               (a.x() * jx + a.y() * jy + a.z() * jz).square())
                  .max(kMinNoise);
  out.z2 = (jx * (A(0, 0) * ix + A(0, 1) * iy + A(0, 2) * iz) +
            jy * (A(1, 0) * ix + A(1, 1) * iy + A(1, 2) * iz) +
            jz * (A(2, 0) * ix + A(2, 1) * iy + A(2, 2) * iz))
               .square() /
           (sigma * sigma * out.noise);
  return out;
}

ConsensusBaseline PairPoints::consensusBaseline(const Eigen::Matrix3d& R_ci_cj, double sigma,
                                                const ConsensusOptions& options, unsigned seed,
                                                const Eigen::Vector3d& first) const {
  const double truncation2 = options.truncation_sigmas * options.truncation_sigmas;
  ConsensusBaseline out;
  out.cost = truncation2 * count_;
  if (count_ < 2) return out;
  // f_i and m = f_i x R f_j. Single precision: its rounding, a ten millionth of a radian, is far
  // below any noise, and twice as many numbers fit a register.
  Eigen::Array<float, Eigen::Dynamic, 3> f(count_, 3), m(count_, 3);
  Eigen::Array<float, Eigen::Dynamic, 1> z2(count_);
  for (int k = 0; k < count_; ++k) {
    const Eigen::Vector3d f_i = f_i_.row(k).matrix().transpose();
    const Eigen::Vector3d g = R_ci_cj * f_j_.row(k).matrix().transpose();
    f.row(k) = f_i.cast<float>().transpose().array();
    m.row(k) = f_i.cross(g).cast<float>().transpose().array();
  }
  const float t2 = static_cast<float>(truncation2);
  const float inverse = static_cast<float>(1.0 / (2.0 * sigma * sigma));
  const float floor = static_cast<float>(0.5 * kMinNoise);
  const float enough = static_cast<float>(kGoodEnough * count_);
  Sequence sequence(seed);
  float best_cost = std::numeric_limits<float>::max();
  for (int h = -1; h < options.hypotheses; ++h) {
    Eigen::Vector3f e = first.cast<float>();
    if (h >= 0) {
      const int p = sequence.below(count_);
      const int q = sequence.below(count_);
      e = m.row(p).matrix().transpose().cross(m.row(q).matrix().transpose());
    }
    const float norm = e.norm();
    if (!(norm > 1e-20f)) continue;
    e /= norm;
    // Both views' noise by that of the first: they differ by the parallax only.
    z2 = (inverse * (e.x() * m.col(0) + e.y() * m.col(1) + e.z() * m.col(2)).square() /
          (1.0f - (e.x() * f.col(0) + e.y() * f.col(1) + e.z() * f.col(2)).square()).max(floor))
             .min(t2);
    const float sum = z2.sum();
    if (sum < best_cost) {
      best_cost = sum;
      out.direction = e.cast<double>();
    }
    if (h < 0 && best_cost < enough) break;
  }
  if (out.direction.squaredNorm() > 0.0) {
    out.direction.normalize();
    out.cost = best_cost;
  }
  return out;
}

KeyframePairs::KeyframePairs(const InitWindow& window, int max_gap)
    : keyframes_(window.size()), sigma_(window.calibration().sigmaBearing()) {
  std::vector<int> index(keyframes_ * keyframes_, -1);  // of the pair (i, j)
  for (const int gap : kGaps) {
    if (gap > max_gap) continue;
    for (int i = 0; i + gap < keyframes_; ++i) {
      index[i * keyframes_ + i + gap] = static_cast<int>(pairs_.size());
      pairs_.emplace_back();
      pairs_.back().i = i;
      pairs_.back().j = i + gap;
    }
  }
  const std::vector<WindowPoint>& s = window.pointObservations();
  for (const Track& track : window.pointTracks()) {
    for (int a = track.begin; a < track.end; ++a) {
      for (int b = a + 1; b < track.end; ++b) {
        const int p = index[s[a].keyframe * keyframes_ + s[b].keyframe];
        if (p < 0) continue;
        pairs_[p].points.add(s[a].bearing, s[b].bearing);
        pairs_[p].observation_i.push_back(a);
        pairs_[p].observation_j.push_back(b);
      }
    }
  }
  for (KeyframePair& pair : pairs_) {
    pair.use_points = pair.points.count() >= kMinPointsPerPair;
  }
}

int KeyframePairs::pointPairs() const {
  return static_cast<int>(std::count_if(pairs_.begin(), pairs_.end(),
                                        [](const KeyframePair& pair) { return pair.use_points; }));
}

GyroRotations::GyroRotations(const InitWindow& window) : window_(window) {
  integrate(Eigen::Vector3d::Zero(), 0.0);
}

void GyroRotations::integrate(const Eigen::Vector3d& gyro_bias, double td) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  td_ = coveredShift(window_, td);
  pre_ = preintegrateWindow(window_, {gyro_bias, none}, ImuNoise(), td_,
                            PreintegrationParts::kRotation);
  instants_ = imuInstants(window_, td_, gyro_bias, none);
}

void GyroRotations::linearizeNear(const RotationUnknowns& x) {
  const Eigen::Vector3d gyro_bias = x.head<3>();
  if ((gyro_bias - pre_.front().gyro_bias).norm() > kRelinearizeTolerance ||
      std::abs(coveredShift(window_, x[6]) - td_) > kRelinearizeTolerance) {
    integrate(gyro_bias, x[6]);
  }
}

PairRotations GyroRotations::at(const RotationUnknowns& x, const KeyframePairs& pairs,
                                int max_gap) const {
  const Eigen::Vector3d gyro_bias = x.head<3>(), extrinsic = x.segment<3>(3);
  const Eigen::Matrix3d R_b_c = window_.calibration().R_b_c * expSO3(extrinsic);
  const Eigen::Matrix3d by_extrinsic = rightJacobian(extrinsic);
  // R_b0_ck, and in b0 the rotation vectors by which the unknowns move it
  // (docs/derivation.md, 1.2).
  std::vector<Eigen::Matrix3d> attitude(pre_.size() + 1);
  std::vector<Eigen::Matrix<double, 3, 7>> derivative(pre_.size() + 1);
  Eigen::Matrix3d R_b0_b = Eigen::Matrix3d::Identity(), by_bias = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < attitude.size(); ++k) {
    const Eigen::Vector3d& rate = instants_[k].rate;
    attitude[k] = R_b0_b * expSO3(rate * (x[6] - td_)) * R_b_c;
    derivative[k] << by_bias, attitude[k] * by_extrinsic, R_b0_b * rate;
    if (k == pre_.size()) break;
    const Eigen::Vector3d phi = pre_[k].dR_dbg * (gyro_bias - pre_[k].gyro_bias);
    R_b0_b = R_b0_b * (pre_[k].dR * expSO3(phi));
    by_bias += R_b0_b * (rightJacobian(phi) * pre_[k].dR_dbg);
  }
  PairRotations out(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const KeyframePair& pair = pairs[p];
    if (pair.gap() > max_gap) continue;
    const Eigen::Matrix3d Rt = attitude[pair.j].transpose();
    out[p].R_ci_cj = attitude[pair.i].transpose() * attitude[pair.j];
    out[p].J = Rt * (derivative[pair.j] - derivative[pair.i]);
  }
  return out;
}

double findBaselines(const KeyframePairs& pairs, const PairRotations& rotations, int max_gap,
                     const ConsensusOptions& options, Baselines* baselines) {
  double cost = 0.0;
  int points = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!pairs[p].use_points || pairs[p].gap() > max_gap) continue;
    const ConsensusBaseline found = pairs[p].points.consensusBaseline(
        rotations[p].R_ci_cj, pairs.sigma(), options, static_cast<unsigned>(p), (*baselines)[p]);
    (*baselines)[p] = found.direction;
    cost += found.cost;
    points += pairs[p].points.count();
  }
  return cost / std::max(points, 1);
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
