// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "scale/scale_cost.h"

#include <cmath>

#include "estimation/inertial_factor.h"
#include "geometry/dense.h"
#include "geometry/so3.h"
#include "scale/gravity_constrained.h"

namespace slim_init {
namespace {

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

void UnknownsPrior::add(const Eigen::Matrix<double, 3, 9>& J, const Eigen::Vector3d& r) {
  H += J.transpose() * J;
  b -= J.transpose() * r;
  constant += r.squaredNorm();
}

void UnknownsPrior::addAccelBias(const Eigen::Vector3d& mean, double sigma) {
  H.diagonal().segment<3>(3).array() += 1.0 / (sigma * sigma);
  b.segment<3>(3) += mean / (sigma * sigma);
  constant += mean.squaredNorm() / (sigma * sigma);
}

ScaleCost::ScaleCost(const LinearMotion& motion, const Eigen::VectorXd& shape,
                     const Eigen::MatrixXd& information, const UnknownsPrior& prior,
                     double gravity_magnitude)
    : valid_(true), gravity_magnitude_(gravity_magnitude), prior_(prior), of_shape_(true) {
  Eigen::Matrix<double, Eigen::Dynamic, 11> columns(shape.size(), 11);
  columns << motion.position, motion.position0 + motion.lever, shape;
  of_columns_ = columns.transpose() * (information * columns);
}

ScaleCost::ScaleCost(const RefinedWindow& refined, const std::vector<Preintegration>& pre,
                     const Calibration& calibration, const ImuBiases& prior,
                     const std::optional<MotionPrior>& motion)
    : gravity_magnitude_(refined.state.gravity_b0.norm()) {
  prior_.addAccelBias(prior.accel, prior.accel_sigma);
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
  valid_ = conditionShape(refined, calibration, body, pre, prior);
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
  prior_.add(imu.velocity.middleRows<3>(middle) / motion->speed_sigma,
             v.segment<3>(middle) / motion->speed_sigma);
  Eigen::Matrix<double, 3, 9> change = imu.velocity.bottomRows<3>();
  change.leftCols<3>().setZero();  // the change does not know the first
  const double change_sigma = duration * motion->acceleration_sigma;
  prior_.add(change / change_sigma, v.tail<3>() / change_sigma);
}

// What images and gyroscope say of the attitudes and the shape: its covariance and mean, carried to
// the difference of IMU and images.
bool ScaleCost::conditionShape(const RefinedWindow& refined, const Calibration& calibration,
                               const WindowState& body, const std::vector<Preintegration>& pre,
                               const ImuBiases& prior) {
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
  const double bias_information = 1.0 / (prior.gyro_sigma * prior.gyro_sigma);
  H.diagonal().tail<3>().array() += bias_information;
  g.tail<3>() += bias_information * (body.gyro_bias - prior.gyro);
  // The scale is the profile's variable: the shape is held along itself.
  const double length2 = shape_.squaredNorm();
  if (!(length2 > 0.0) || !H.allFinite()) return false;
  const double hold = kLengthWeight * H.block(rows, rows, rows, rows).trace() / rows;
  H.block(rows, rows, rows, rows).noalias() += (hold / length2) * shape_ * shape_.transpose();

  // Rows of the difference by attitudes, biases (first) and by the shape at ratio one, and the
  // gradient: their products over H^-1.
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2 * rows + 1, size), seen;
  J.topLeftCorner(rows, rows) = by_attitudes_.leftCols(rows);
  J.topRightCorner<Eigen::Dynamic, 3>(rows, 3) = by_attitudes_.rightCols<3>();
  J.block(rows, rows, rows, rows).setIdentity();
  J.bottomRows<1>() = g.transpose();
  if (!inverseSeenBy(H, J, &seen)) return false;
  const auto by_shape = seen.block(rows, 0, rows, rows);
  S0_ += seen.topLeftCorner(rows, rows);
  S1_ = by_shape + by_shape.transpose();
  S2_ = seen.block(rows, rows, rows, rows);
  offset_ -= seen.row(2 * rows).head(rows).transpose();
  shape_ -= seen.row(2 * rows).segment(rows, rows).transpose();
  return S0_.allFinite() && S2_.allFinite();
}

bool ScaleCost::weighted(double ratio, Products* products) const {
  if (of_shape_) {
    // [A, c0 - ratio shape] = [A, c0, shape] T
    Eigen::Matrix<double, 11, 10> T = Eigen::Matrix<double, 11, 10>::Identity();
    T(10, 9) = -ratio;
    const Eigen::Matrix<double, 11, 10> half = of_columns_.lazyProduct(T / (ratio * ratio));
    *products = T.transpose().lazyProduct(half);
    return true;
  }
  const int rows = static_cast<int>(offset_.size());
  const Eigen::MatrixXd covariance = S0_ - ratio * S1_ + (ratio * ratio) * S2_;
  Eigen::MatrixXd columns(10, rows), seen;
  columns << by_unknowns_.transpose(), (offset_ - ratio * shape_).transpose();
  if (!inverseSeenBy(covariance, columns, &seen)) return false;
  *products = seen;
  return true;
}

double ScaleCost::operator()(double log_ratio, Eigen::Matrix<double, 9, 1>* x) const {
  Products P;
  if (!valid_ || !weighted(std::exp(log_ratio), &P)) return HUGE_VAL;
  const Eigen::MatrixXd M = P.topLeftCorner<9, 9>() + prior_.H;
  const Eigen::VectorXd b = prior_.b - P.topRightCorner<9, 1>();
  Eigen::VectorXd at;
  if (!solveGravityConstrained(M, b, gravity_magnitude_, &at)) return HUGE_VAL;
  if (x != nullptr) *x = at;
  return at.dot(M * at) - 2.0 * b.dot(at) + P(9, 9) + prior_.constant;
}

}  // namespace slim_init
