// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/scale_profile.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimation/inertial_factor.h"
#include "geometry/dense.h"
#include "geometry/minimize.h"
#include "geometry/so3.h"
#include "scale/gravity_constrained.h"

namespace slim_init {
namespace {

// Scales searched and integrated over: up to this many times larger and smaller. Wrong minima that
// were accepted lay a factor of 2.4 to 30 away.
constexpr double kMaxRatio = 32.0;
// Points of the grid on each side: steps of 0.29 in the log scale, finer than the distance of two
// minima worth telling apart.
constexpr int kHalfGrid = 12;
// First step of the search for the end of the interval [log scale]: half the sigma of a good
// window.
constexpr double kFirstStep = 0.01;
// End of all searches [log scale]: a tenth of the smallest sigma.
constexpr double kLogScaleTolerance = 2e-3;

// ---- Integral over the scale (integrateScale())

// Points of one pass, and passes: each covers what the one before found the density in.
constexpr int kIntegralPoints = 32;
constexpr int kIntegralPasses = 3;
// Less than this below its largest value the logarithm of the density is nothing.
constexpr double kNegligible = 12.0;

// Adds the gyroscope's part of one pair to information and gradient of
// [theta_1 .. theta_{N-1} | q_1 .. q_{N-1} | b_g].
void addGyro(const WindowState& state, int i, const Preintegration& pre, Eigen::MatrixXd* H,
             Eigen::VectorXd* g) {
  const InertialResidual residual = inertialResidual(state, i, pre);
  const Eigen::Matrix3d information = pre.covariance.topLeftCorner<3, 3>().inverse();
  const int bias = static_cast<int>(g->size()) - 3;
  // Columns of the factor: theta_i at 0, theta_j at 6, b_g at 18. The first attitude is the gauge.
  const int from[] = {0, 6, 18};
  const int to[] = {3 * (i - 1), 3 * i, bias};
  for (int a = 0; a < 3; ++a) {
    if (to[a] < 0) continue;
    const Eigen::Matrix3d weighted = residual.J.block<3, 3>(0, from[a]).transpose() * information;
    g->segment<3>(to[a]) += weighted * residual.r.head<3>();
    for (int b = 0; b < 3; ++b) {
      if (to[b] >= 0) H->block<3, 3>(to[a], to[b]) += weighted * residual.J.block<3, 3>(0, from[b]);
    }
  }
}

// Errors of the visual pose k, [theta, p], by attitude of the body and camera centre, [theta, q],
// under the rig as estimated: the body of the images is turned by E against the body, and
// p = q - R t_b_c turns with R Exp(theta).
Eigen::Matrix<double, 6, 6> posesFromCentres(const WindowState& state,
                                             const Calibration& calibration, int k) {
  const Eigen::Matrix3d E =
      calibration.R_b_c * state.rig.dR.transpose() * calibration.R_b_c.transpose();
  Eigen::Matrix<double, 6, 6> T;
  T << E, Eigen::Matrix3d::Zero(), state.R_b0_bk[k] * skew(calibration.t_b_c) * E, E;
  return T;
}

// Covariance of the positions 1 .. N-1 that the IMU predicts from known attitudes: that of its
// noise alone.
Eigen::MatrixXd noiseOfCentres(const WindowState& state, const std::vector<Preintegration>& pre) {
  const int n = state.size();
  Eigen::MatrixXd covariance(3 * (n - 1), 3 * (n - 1));
  Eigen::Matrix<double, 6, 6> noise = Eigen::Matrix<double, 6, 6>::Zero();  // of [v, p]
  for (int i = 0; i + 1 < n; ++i) {
    const Eigen::Matrix3d& R = state.R_b0_bk[i];
    const double dt = pre[i].dt;
    const int k = 3 * i;
    noise.bottomRows<3>() += dt * noise.topRows<3>();
    noise.rightCols<3>() += dt * noise.leftCols<3>();
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        noise.block<3, 3>(3 * a, 3 * b) +=
            R * pre[i].covariance.block<3, 3>(3 + 3 * a, 3 + 3 * b) * R.transpose();
      }
    }
    // A later position p_l has the error p + (t_l - t) v of this one, and noise of its own.
    double later = 0.0;
    for (int l = i; l + 1 < n; ++l) {
      if (l > i) later += pre[l].dt;
      covariance.block<3, 3>(3 * l, k) =
          noise.bottomRightCorner<3, 3>() + later * noise.topRightCorner<3, 3>();
      if (l > i) covariance.block<3, 3>(k, 3 * l) = covariance.block<3, 3>(3 * l, k).transpose();
    }
  }
  return covariance;
}

}  // namespace

double ScaleProfile::sigma() const { return std::max(-low, high) / std::sqrt(kIntervalRise); }

ScaleCost::ScaleCost(const RefinedWindow& refined, const std::vector<Preintegration>& pre,
                     const Calibration& calibration, const InertialOptions& inertial,
                     const std::optional<MotionPrior>& motion)
    : gravity_magnitude_(refined.state.gravity_b0.norm()),
      accel_bias_information_(1.0 / (inertial.accel_bias_prior * inertial.accel_bias_prior)) {
  const int n = refined.state.size();
  if (n < 3 || refined.visual_information.rows() != 6 * n) return;
  const WindowState body = bodyState(refined.state, calibration.R_b_c, calibration.t_b_c);
  const Eigen::Vector3d t_b_c = calibration.t_b_c + body.rig.dt;
  predictCentres(linearMotion(pre, body.R_b0_bk, t_b_c), body, pre, motion);
  shape_.resize(3 * (n - 1));
  for (int k = 1; k < n; ++k) {
    const Eigen::Matrix3d& R = body.R_b0_bk[k];
    shape_.segment<3>(3 * (k - 1)) = cameraCentre(body, k, t_b_c) - t_b_c;
    // The camera is at the end of the lever arm, which turns with the body.
    by_attitudes_.block<3, 3>(3 * (k - 1), 3 * (k - 1)) -= R * skew(t_b_c);
  }
  valid_ = conditionShape(refined, calibration, body, pre, inertial.gyro_bias_prior);
}

// Positions that the accelerometer predicts for the attitudes of the refined window: derivatives by
// x, attitudes and gyroscope bias, and in S0_ the covariance of its noise.
void ScaleCost::predictCentres(const LinearMotion& imu, const WindowState& state,
                               const std::vector<Preintegration>& pre,
                               const std::optional<MotionPrior>& motion) {
  const int n = state.size();
  const int rows = 3 * (n - 1);
  const int columns = rows + 3;
  by_unknowns_ = imu.position.bottomRows(rows);
  // b_a is counted from zero.
  const Eigen::VectorXd p = imu.position0 - imu.position.middleCols<3>(3) * imu.accel_bias;
  const Eigen::VectorXd v = imu.velocity0 - imu.velocity.middleCols<3>(3) * imu.accel_bias;
  offset_ = (p + imu.lever).tail(rows) - imu.lever.head<3>().replicate(n - 1, 1);
  by_attitudes_.setZero(rows, columns);
  S0_ = noiseOfCentres(state, pre);
  // Velocity and position of the keyframe reached.
  Eigen::MatrixXd v_y = Eigen::MatrixXd::Zero(3, columns), p_y = v_y;
  double duration = 0.0;
  for (int i = 0; i + 1 < n; ++i) {
    const Preintegration& pair = pre[i];
    const Eigen::Matrix3d& R = state.R_b0_bk[i];
    const double dt = pair.dt;
    p_y += dt * v_y;
    p_y.rightCols<3>() += R * pair.dp_dbg;
    v_y.rightCols<3>() += R * pair.dv_dbg;
    if (i > 0) {
      p_y.middleCols<3>(3 * (i - 1)) -=
          R * skew(pair.positionAt(state.gyro_bias, state.accel_bias));
      v_y.middleCols<3>(3 * (i - 1)) -=
          R * skew(pair.velocityAt(state.gyro_bias, state.accel_bias));
    }
    by_attitudes_.middleRows<3>(3 * i) = p_y;
    duration += dt;
  }
  if (!motion) return;
  const int middle = 3 * MotionPrior::middle(n);
  motion_by_unknowns_ << imu.velocity.middleRows<3>(middle) / motion->speed_sigma,
      imu.velocity.bottomRows<3>() / (duration * motion->acceleration_sigma);
  motion_by_unknowns_.bottomLeftCorner<3, 3>().setZero();  // the change does not know the first
  motion_offset_ << v.segment<3>(middle) / motion->speed_sigma,
      v.tail<3>() / (duration * motion->acceleration_sigma);
}

// What images and gyroscope say of the attitudes and the shape: its covariance and mean, carried to
// the difference of IMU and images.
bool ScaleCost::conditionShape(const RefinedWindow& refined, const Calibration& calibration,
                               const WindowState& body, const std::vector<Preintegration>& pre,
                               double gyro_bias_prior) {
  const int m = body.size() - 1;
  const int rows = 3 * m;
  const int size = 2 * rows + 3;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
  std::vector<Eigen::Matrix<double, 6, 6>> T;
  for (int k = 1; k <= m; ++k) T.push_back(posesFromCentres(refined.state, calibration, k));
  for (int a = 0; a < m; ++a) {
    const Eigen::Matrix<double, 6, 1> g_a =
        T[a].transpose() * refined.visual_gradient.segment<6>(6 * (a + 1));
    g.segment<3>(3 * a) = g_a.head<3>();
    g.segment<3>(rows + 3 * a) = g_a.tail<3>();
    for (int b = 0; b < m; ++b) {
      const Eigen::Matrix<double, 6, 6> VT =
          refined.visual_information.block<6, 6>(6 * (a + 1), 6 * (b + 1)) * T[b];
      const Eigen::Matrix<double, 6, 6> V = T[a].transpose() * VT;
      H.block<3, 3>(3 * a, 3 * b) = V.topLeftCorner<3, 3>();
      H.block<3, 3>(rows + 3 * a, 3 * b) = V.bottomLeftCorner<3, 3>();
      H.block<3, 3>(3 * a, rows + 3 * b) = V.topRightCorner<3, 3>();
      H.block<3, 3>(rows + 3 * a, rows + 3 * b) = V.bottomRightCorner<3, 3>();
    }
  }
  for (int i = 0; i < m; ++i) addGyro(body, i, pre[i], &H, &g);
  const double bias_information = 1.0 / (gyro_bias_prior * gyro_bias_prior);
  H.diagonal().tail<3>().array() += bias_information;
  g.tail<3>() += bias_information * body.gyro_bias;
  // The scale is the profile's variable: the shape is held along itself.
  const double length2 = shape_.squaredNorm();
  if (!(length2 > 0.0) || !H.allFinite()) return false;
  const double hold = kLengthWeight * H.block(rows, rows, rows, rows).trace() / rows;
  H.block(rows, rows, rows, rows).noalias() += (hold / length2) * shape_ * shape_.transpose();

  // Rows of the difference by attitudes, biases (first) and by the shape at ratio one, and the
  // gradient: what the elimination leaves of them is minus their products over H^-1.
  const int last = size + 2 * rows;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(last + 1, last + 1);
  A.topLeftCorner(size, size) = H;
  A.row(last).head(size) = g.transpose();
  A.block(size, 0, rows, rows) = by_attitudes_.leftCols(rows);
  A.block<Eigen::Dynamic, 3>(size, 2 * rows, rows, 3) = by_attitudes_.rightCols<3>();
  A.block(size + rows, rows, rows, rows).setIdentity();
  if (!eliminateFirst(A, size)) return false;
  const auto by_shape = A.block(size + rows, size, rows, rows);
  S0_ -= A.block(size, size, rows, rows);
  S1_ = -by_shape - by_shape.transpose();
  S2_ = -A.block(size + rows, size + rows, rows, rows);
  offset_ += A.row(last).segment(size, rows).transpose();
  shape_ += A.row(last).segment(size + rows, rows).transpose();
  return S0_.allFinite() && S2_.allFinite();
}

double ScaleCost::operator()(double log_ratio) const {
  if (!valid_) return HUGE_VAL;
  const double ratio = std::exp(log_ratio);
  const int rows = static_cast<int>(offset_.size());
  // Below the covariance what is weighted with its inverse: columns by the unknowns, constant part.
  work_.resize(rows + kUnknowns + 1, rows + kUnknowns + 1);
  work_.bottomRightCorner<kUnknowns + 1, kUnknowns + 1>().setZero();
  work_.topLeftCorner(rows, rows).triangularView<Eigen::Lower>() =
      S0_ - ratio * S1_ + (ratio * ratio) * S2_;
  work_.block(rows, 0, kUnknowns, rows) = by_unknowns_.transpose();
  work_.row(rows + kUnknowns).head(rows) = (ratio * shape_ - offset_).transpose();
  if (!eliminateFirst(work_, rows)) return HUGE_VAL;
  Eigen::Matrix<double, kUnknowns, kUnknowns> M = -work_.block<kUnknowns, kUnknowns>(rows, rows);
  M.triangularView<Eigen::StrictlyUpper>() = M.transpose();
  Eigen::Matrix<double, kUnknowns, 1> x,
      b = -work_.block<1, kUnknowns>(rows + kUnknowns, rows).transpose();
  const double constant = -work_(rows + kUnknowns, rows + kUnknowns);
  M.diagonal().segment<3>(3).array() += accel_bias_information_;
  M += motion_by_unknowns_.transpose() * motion_by_unknowns_;  // zero without a prior
  b -= motion_by_unknowns_.transpose() * motion_offset_;
  if (!solveGravityConstrained(M, b, gravity_magnitude_, &x)) return HUGE_VAL;
  return x.dot(M * x) - 2.0 * b.dot(x) + constant + motion_offset_.squaredNorm();
}

namespace {

// Where the cost passes `bound` between `inside`, below it, and `outside`.
double crossing(const ScaleCost& cost, double inside, double outside, double bound) {
  while (std::abs(outside - inside) > kLogScaleTolerance) {
    const double middle = 0.5 * (inside + outside);
    (cost(middle) < bound ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

// End of the interval about `best` on the side `direction`, +1 or -1: where the cost exceeds
// `bound`, or the end of the search. Steps double, from one that a narrow minimum does not miss.
double endOfInterval(const ScaleCost& cost, double best, int direction, double bound) {
  const double limit = std::log(kMaxRatio);
  double inside = best;
  for (double step = kFirstStep;; step *= 2.0) {
    const double outside = inside + direction * step;
    if (std::abs(outside) > limit) return direction * limit;
    if (!(cost(outside) < bound)) return crossing(cost, inside, outside, bound);
    inside = outside;
  }
}

}  // namespace

ScaleProfile profileScale(const ScaleCost& cost) {
  ScaleProfile out;
  const double limit = std::log(kMaxRatio);
  const double step = limit / kHalfGrid;
  std::vector<double> values;
  for (int k = -kHalfGrid; k <= kHalfGrid; ++k) values.push_back(cost(k * step));
  out.cost_here = values[kHalfGrid];
  // Every minimum of the grid; its ends count as they are.
  std::vector<FunctionPoint> minima;
  const int last = static_cast<int>(values.size()) - 1;
  for (int k = 0; k <= last; ++k) {
    const double at = (k - kHalfGrid) * step;
    const bool below_left = k == 0 || values[k] < values[k - 1];
    const bool below_right = k == last || values[k] <= values[k + 1];
    if (!below_left || !below_right) continue;
    FunctionPoint point = {at, values[k]};
    if (k > 0 && k < last) {
      const FunctionPoint lowest = goldenSection(cost, at - step, at + step, kLogScaleTolerance);
      if (lowest.value < point.value) point = lowest;
    }
    minima.push_back(point);
  }
  FunctionPoint best = {kNotComputed, HUGE_VAL};
  for (const FunctionPoint& minimum : minima) {
    if (minimum.value < best.value) best = minimum;
  }
  if (!std::isfinite(best.value)) return out;
  out.log_ratio = best.at;
  out.cost = best.value;
  out.other_rise = HUGE_VAL;
  for (const FunctionPoint& minimum : minima) {
    if (std::abs(minimum.at) < ScaleProfile::kSameBasin) continue;
    if (!(minimum.value - out.cost_here < out.other_rise)) continue;
    out.other_rise = minimum.value - out.cost_here;
    out.other_log_ratio = minimum.at;
  }
  const double bound = best.value + ScaleProfile::kIntervalRise;
  out.low = endOfInterval(cost, best.at, -1, bound);
  out.high = endOfInterval(cost, best.at, 1, bound);
  out.valid = true;
  return out;
}

ScaleMoments integrateScale(const ScaleCost& cost) {
  ScaleMoments out;
  const double limit = std::log(kMaxRatio);
  double low = -limit, high = limit;
  for (int pass = 0; pass < kIntegralPasses; ++pass) {
    const double step = (high - low) / kIntegralPoints;
    std::vector<double> values;
    double best = -HUGE_VAL;
    for (int k = 0; k <= kIntegralPoints; ++k) {
      const double q = low + k * step;
      // Of the logarithm: d ratio = ratio d q.
      values.push_back(q - 0.5 * cost(q));
      if (!(values.back() > best)) continue;
      best = values.back();
      out.log_best = q;
    }
    if (!std::isfinite(best)) return out;
    double sum = 0.0, ratio = 0.0, ratio2 = 0.0, log = 0.0, log2 = 0.0;
    double first = HUGE_VAL, last = -HUGE_VAL;
    for (int k = 0; k <= kIntegralPoints; ++k) {
      if (!(values[k] > best - kNegligible)) continue;
      const double q = low + k * step, r = std::exp(q), w = std::exp(values[k] - best);
      sum += w;
      ratio += w * r;
      ratio2 += w * r * r;
      log += w * q;
      log2 += w * q * q;
      first = std::min(first, q);
      last = std::max(last, q);
    }
    out.mean = ratio / sum;
    out.variance = std::max(0.0, ratio2 / sum - out.mean * out.mean);
    out.log_variance = std::max(0.0, log2 / sum - log * log / (sum * sum));
    low = std::max(first - step, -limit);
    high = std::min(last + step, limit);
  }
  out.valid = std::isfinite(out.mean) && std::isfinite(out.variance);
  return out;
}

}  // namespace slim_init
