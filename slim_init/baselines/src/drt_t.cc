// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "compared_methods.h"
#include "geometry/so3.h"
#include "gyro_bias.h"
#include "imu/preintegration.h"
#include "loosely_coupled.h"
#include "scale/gravity_constrained.h"
#include "scale/linear_motion.h"
#include "shape/ligt.h"
#include "verdict/gates.h"

namespace slim_init::baselines {
namespace {

// Solution of the tight alignment, in b0.
struct TightEstimate {
  bool valid = false;
  Eigen::Matrix<double, 9, 1> x;      // [v_0, b_a = 0, g]
  double scale_sigma = kNotComputed;  // relative, from the residual and the normal matrix
};

// The vectors of a stacked matrix turned from b0 into the frame of the first camera.
Eigen::MatrixXd inFirstCamera(Eigen::MatrixXd stacked, const Eigen::Matrix3d& R_b_c) {
  for (Eigen::Index row = 0; row < stacked.rows(); row += 3) {
    stacked.middleRows<3>(row) = R_b_c.transpose() * stacked.middleRows<3>(row).eval();
  }
  return stacked;
}

// The IMU's camera centres C(x) = A x + c0, x = [v_0, g], in the visual equations L C = 0:
//   min |L (A x + c0)|^2,  |g| fixed.
TightEstimate alignTightly(const LinearMotion& motion, const TranslationEstimate& visual,
                           const Calibration& calibration) {
  Eigen::MatrixXd A(motion.position.rows(), 6);
  A << motion.position.leftCols<3>(), motion.position.rightCols<3>();
  A = inFirstCamera(A, calibration.R_b_c);
  const Eigen::VectorXd c0 = inFirstCamera(motion.position0 + motion.lever, calibration.R_b_c);
  const Eigen::MatrixXd HA = visual.normal_matrix * A;
  const Eigen::MatrixXd AHA = A.transpose() * HA;

  TightEstimate estimate;
  Eigen::VectorXd x;
  if (!solveGravityConstrained(AHA, -HA.transpose() * c0, calibration.gravity_magnitude, &x)) {
    return estimate;
  }
  estimate.x << x.head<3>(), Eigen::Vector3d::Zero(), x.tail<3>();
  estimate.valid = true;

  // Covariance on the constraint surface, where gravity moves in its tangent plane only. Of the
  // three rows of an observation two are independent.
  const Eigen::VectorXd c = A * x + c0;
  const double dof = 2.0 / 3.0 * visual.rows - 5.0;
  Eigen::Matrix<double, 6, 5> T = Eigen::Matrix<double, 6, 5>::Zero();
  T.topLeftCorner<3, 3>().setIdentity();
  T.bottomRightCorner<3, 2>() =
      calibration.gravity_magnitude * tangentBasis(x.tail<3>().normalized());
  const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> information(T.transpose() * AHA * T);
  Eigen::Matrix3Xd centred = Eigen::Map<const Eigen::Matrix3Xd>(c.data(), 3, c.size() / 3);
  centred.colwise() -= centred.rowwise().mean().eval();
  const Eigen::Map<const Eigen::VectorXd> along(centred.data(), centred.size());
  const Eigen::Matrix<double, 5, 1> J =
      (A * T).transpose() * along / std::max(along.squaredNorm(), 1e-300);
  if (dof > 0.0 && information.info() == Eigen::Success) {
    const double variance =
        std::max(c.dot(visual.normal_matrix * c), 0.0) / dof * J.dot(information.solve(J));
    estimate.scale_sigma = std::sqrt(std::max(variance, 0.0));
  }
  return estimate;
}

}  // namespace

InitResult solveDrtT(const InitWindow& window, const InitializerOptions& options,
                     const BaselineOptions& /*baseline_options*/) {
  const Calibration& calibration = window.calibration();
  InitResult result;
  StageClock clock(&result);
  if (!startResult(window, &result)) return result;

  // Gyroscope bias from the epipolar planes of consecutive keyframes (section 4.1).
  const GyroBiasEstimate bias = estimateGyroBias(window, GyroBiasProblem());
  clock.lap("gyro_bias");
  if (!acceptGyroBias(bias, &result)) return result;

  // Rotations and the motion that the IMU predicts at this bias.
  const std::vector<Preintegration> pre = preintegrateWindow(
      window, result.gyro_bias, Eigen::Vector3d::Zero(), PreintegrationParts::kMean);
  const std::vector<Eigen::Matrix3d> R_b0_bk = chainRotations(pre);
  const LinearMotion motion = linearMotion(pre, R_b0_bk, calibration.t_b_c);
  clock.lap("integration");

  // Linear equations of the tracks over the camera centres (LiGT).
  const TranslationEstimate visual =
      estimateTranslations(window, cameraRotations(R_b0_bk, calibration.R_b_c));
  clock.lap("translation");

  // First velocity and gravity from both (section 4.2, tightly coupled).
  const MotionMeasures measured = measureMotion(window, pre, R_b0_bk);
  result.gates = motionGates(measured, options.gates);
  TightEstimate alignment;
  if (visual.valid) alignment = alignTightly(motion, visual, calibration);
  clock.lap("alignment");

  if (alignment.valid) {
    const WindowState state = motion.at(alignment.x);
    setWorldStates(window, state, &result);
    result.scale_sigma = alignment.scale_sigma;
    // The motion is the IMU's own: its position and velocity rows have no residual.
    appendGates(
        alignmentGates({visual.linkage(), cameraSpread(window, state), 0.0, alignment.scale_sigma},
                       gatesInForce(options.gates, window, options.window).max_scale_sigma),
        &result);
  }
  decideAlignment(window, measured, visual, alignment.valid, options, &result);
  clock.lap("verdict");
  return result;
}

}  // namespace slim_init::baselines
