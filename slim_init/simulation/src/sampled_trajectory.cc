// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "reference_so3.h"
#include "slim_init/simulation/trajectory.h"
#include "slim_init/text.h"

namespace slim_init::simulation {
namespace {

// [s] between samples; over a longer time a hand or a drone moves too much for a cubic.
constexpr double kMaxGap = 0.3;
constexpr int kNodes = 4;

// Weights of the cubic through four nodes and of its first two derivatives.
struct CubicWeights {
  std::array<double, kNodes> value, first, second;
};

// Lagrange weights at time t for node times `nodes` [s].
CubicWeights cubicWeights(const std::array<double, kNodes>& nodes, double t) {
  CubicWeights w;
  for (int k = 0; k < kNodes; ++k) {
    std::array<double, kNodes - 1> d;  // t minus the other nodes
    double denominator = 1.0;
    for (int m = 0, j = 0; m < kNodes; ++m) {
      if (m == k) continue;
      d[j++] = t - nodes[m];
      denominator *= nodes[k] - nodes[m];
    }
    w.value[k] = d[0] * d[1] * d[2] / denominator;
    w.first[k] = (d[1] * d[2] + d[0] * d[2] + d[0] * d[1]) / denominator;
    w.second[k] = 2.0 * (d[0] + d[1] + d[2]) / denominator;
  }
  return w;
}

enum class PositionCurve {
  kFourSamples,  // through the four nearest samples
  kSpline,       // twice continuously differentiable
};

class SampledTrajectory : public Trajectory {
 public:
  SampledTrajectory(std::vector<NavState> samples, PositionCurve curve)
      : samples_(std::move(samples)) {
    // Runs of samples without a gap between neighbours.
    const int n = static_cast<int>(samples_.size());
    runs_.resize(n);
    for (int begin = 0; begin < n;) {
      int end = begin + 1;
      while (end < n && samples_[end].t - samples_[end - 1].t <= kMaxGap) ++end;
      for (int i = begin; i < end; ++i) runs_[i] = {begin, end};
      begin = end;
    }
    if (curve == PositionCurve::kSpline) fitSpline();
  }

  double begin() const override { return samples_.front().t; }
  double end() const override { return samples_.back().t; }

  bool covers(double t) const override {
    return t >= begin() && t <= end() && insideRun(intervalOf(t));
  }

  Kinematics at(double t) const override {
    t = std::clamp(t, begin(), end());
    const int interval = intervalOf(t);
    const int first = firstNode(interval);
    const NavState* node = &samples_[first];

    // Times relative to t: epoch stamps have too few digits left for products of differences.
    std::array<double, kNodes> times;
    for (int k = 0; k < kNodes; ++k) times[k] = node[k].t - t;
    const CubicWeights w = cubicWeights(times, 0.0);

    const bool has_velocity =
        std::all_of(node, node + kNodes, [](const NavState& s) { return s.v_w_b.allFinite(); });
    const int reference = std::clamp(interval - first, 0, kNodes - 1);
    const Eigen::Matrix3d& R_w_ref = node[reference].R_w_b;

    Kinematics result;
    Eigen::Vector3d phi = Eigen::Vector3d::Zero();
    Eigen::Vector3d phi_rate = Eigen::Vector3d::Zero();
    for (int k = 0; k < kNodes; ++k) {
      // Differences to the reference node keep small motions exact far from the origin.
      const Eigen::Vector3d p = node[k].p_w_b - node[reference].p_w_b;
      result.p_w_b += w.value[k] * p;
      if (has_velocity) {
        result.v_w_b += w.value[k] * node[k].v_w_b;
        result.a_w_b += w.first[k] * node[k].v_w_b;
      } else {
        result.v_w_b += w.first[k] * p;
        result.a_w_b += w.second[k] * p;
      }
      const Eigen::Vector3d phi_k = reference::logSo3(R_w_ref.transpose() * node[k].R_w_b);
      phi += w.value[k] * phi_k;
      phi_rate += w.first[k] * phi_k;
    }
    result.p_w_b += node[reference].p_w_b;
    result.R_w_b = R_w_ref * reference::expSo3(phi);
    result.omega_b = reference::rightJacobianSo3(phi) * phi_rate;
    if (!curvatures_.empty()) evaluateSpline(interval, t, &result);
    return result;
  }

 private:
  struct Run {
    int begin = 0;
    int end = 0;
    int size() const { return end - begin; }
  };

  // Second derivatives of the natural cubic spline of every run, by elimination in the tridiagonal
  // system h_a M_(i-1) + 2 (h_a + h_b) M_i + h_b M_(i+1) = 6 (slope_b - slope_a).
  void fitSpline() {
    curvatures_.assign(samples_.size(), Eigen::Vector3d::Zero());
    std::vector<double> ratio(samples_.size(), 0.0);  // of M_(i+1) in M_i after elimination
    for (int begin = 0; begin < static_cast<int>(samples_.size()); begin = runs_[begin].end) {
      const int last = runs_[begin].end - 1;
      for (int i = begin + 1; i < last; ++i) {
        const double before = samples_[i].t - samples_[i - 1].t;
        const double after = samples_[i + 1].t - samples_[i].t;
        const Eigen::Vector3d slope_before = (samples_[i].p_w_b - samples_[i - 1].p_w_b) / before;
        const Eigen::Vector3d slope_after = (samples_[i + 1].p_w_b - samples_[i].p_w_b) / after;
        const double pivot = 2.0 * (before + after) - before * ratio[i - 1];
        ratio[i] = after / pivot;
        curvatures_[i] = (6.0 * (slope_after - slope_before) - before * curvatures_[i - 1]) / pivot;
      }
      for (int i = last - 1; i > begin; --i) curvatures_[i] -= ratio[i] * curvatures_[i + 1];
    }
  }

  void evaluateSpline(int interval, double t, Kinematics* result) const {
    const NavState& from = samples_[interval];
    const NavState& to = samples_[interval + 1];
    const Eigen::Vector3d& M0 = curvatures_[interval];
    const Eigen::Vector3d& M1 = curvatures_[interval + 1];
    const double h = to.t - from.t;
    const double b = (t - from.t) / h;
    const double a = 1.0 - b;
    result->p_w_b = a * from.p_w_b + b * to.p_w_b +
                    ((a * a * a - a) * M0 + (b * b * b - b) * M1) * (h * h / 6.0);
    result->v_w_b = (to.p_w_b - from.p_w_b) / h +
                    ((1.0 - 3.0 * a * a) * M0 + (3.0 * b * b - 1.0) * M1) * (h / 6.0);
    result->a_w_b = a * M0 + b * M1;
  }

  // Index i of the interval [i, i+1] that holds t, for t in [begin(), end()].
  int intervalOf(double t) const {
    const auto after = std::upper_bound(samples_.begin(), samples_.end(), t,
                                        [](double time, const NavState& s) { return time < s.t; });
    const int n = static_cast<int>(samples_.size());
    int i = std::clamp(static_cast<int>(after - samples_.begin()) - 1, 0, n - 2);
    // The last sample before a gap belongs to the data before it.
    if (i > 0 && t == samples_[i].t && isGap(i) && !isGap(i - 1)) --i;
    return i;
  }

  bool isGap(int interval) const { return runs_[interval].end == interval + 1; }

  bool insideRun(int interval) const {
    return !isGap(interval) && runs_[interval].size() >= kNodes;
  }

  // First of the four nodes for an interval: centred on it, but not reaching across a gap where the
  // samples on this side suffice.
  int firstNode(int interval) const {
    const Run run =
        insideRun(interval) ? runs_[interval] : Run{0, static_cast<int>(samples_.size())};
    return std::clamp(interval - 1, run.begin, run.end - kNodes);
  }

  std::vector<NavState> samples_;
  std::vector<Run> runs_;                    // per sample, the run it is in
  std::vector<Eigen::Vector3d> curvatures_;  // of the spline at the samples [m/s^2], or empty
};

std::unique_ptr<Trajectory> makeTrajectory(std::vector<NavState> samples, PositionCurve curve,
                                           std::string* error) {
  std::string problem;
  if (samples.size() < kNodes) {
    problem = text("number of samples is ", samples.size(), ", must be at least ", kNodes);
  }
  constexpr double kMaxNotRotation = 1e-3;  // recorded quaternions carry 6 digits or more
  for (std::size_t i = 0; i < samples.size() && problem.empty(); ++i) {
    NavState& s = samples[i];
    if (!std::isfinite(s.t) || !s.p_w_b.allFinite() || !s.R_w_b.allFinite()) {
      problem = text("sample ", i, " has a time or pose that is not finite");
    } else if (i > 0 && !(s.t > samples[i - 1].t)) {
      problem =
          roundedText(17, "time of sample ", i, " is ", s.t, ", must be after ", samples[i - 1].t);
    } else {
      const double not_rotation =
          (s.R_w_b.transpose() * s.R_w_b - Eigen::Matrix3d::Identity()).norm() +
          std::abs(s.R_w_b.determinant() - 1.0);
      if (not_rotation > kMaxNotRotation) {
        problem = text("distance of R_w_b from a rotation is ", not_rotation, " in sample ", i,
                       ", must be at most ", kMaxNotRotation);
      }
      s.R_w_b = Eigen::Quaterniond(s.R_w_b).normalized().toRotationMatrix();
    }
  }
  if (!problem.empty()) {
    if (error != nullptr) *error = problem;
    return nullptr;
  }
  return std::make_unique<SampledTrajectory>(std::move(samples), curve);
}

}  // namespace

NavState stateAt(const Trajectory& trajectory, double t) {
  const Kinematics motion = trajectory.at(t);
  NavState state;
  state.t = t;
  state.R_w_b = motion.R_w_b;
  state.p_w_b = motion.p_w_b;
  state.v_w_b = motion.v_w_b;
  return state;
}

std::unique_ptr<Trajectory> makeSampledTrajectory(std::vector<NavState> samples,
                                                  std::string* error) {
  return makeTrajectory(std::move(samples), PositionCurve::kFourSamples, error);
}

std::unique_ptr<Trajectory> makeSmoothTrajectory(const std::vector<NavState>& samples,
                                                 double max_rate_hz, std::string* error) {
  if (!(max_rate_hz > 0.0)) {
    if (error != nullptr) *error = text("max_rate_hz is ", max_rate_hz, ", must be positive");
    return nullptr;
  }
  constexpr double kJitter = 0.95;  // keeps samples at exactly this rate whose stamps jitter
  std::vector<NavState> thinned;
  for (const NavState& sample : samples) {
    // A stamp out of order is kept, for the check to name it.
    const double step = thinned.empty() ? 0.0 : sample.t - thinned.back().t;
    if (step > 0.0 && step < kJitter / max_rate_hz) continue;
    thinned.push_back(sample);
  }
  return makeTrajectory(std::move(thinned), PositionCurve::kSpline, error);
}

}  // namespace slim_init::simulation
