// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Analytic derivatives of every factor of the refinement against central differences.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "estimation/inertial_factor.h"
#include "estimation/speed_factor.h"
#include "estimation/state_factor.h"
#include "estimation/visual_tracks.h"
#include "geometry/so3.h"
#include "lines/line_track.h"
#include "support/gaussian.h"
#include "support/jacobian_check.h"

namespace slim_init {
namespace {

constexpr double kStep = 1e-6;
constexpr double kTolerance = 1e-7;

class RefinementJacobians : public ::testing::TestWithParam<int> {
 protected:
  RefinementJacobians() : gaussian_(GetParam()) {
    for (int k = 0; k < 3; ++k) {
      state_.R_b0_bk.push_back(k == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                      : expSO3(0.2 * random()));
    }
    state_.p_b0.resize(3, 3);
    state_.v_b0.resize(3, 3);
    for (int k = 0; k < 3; ++k) {
      state_.p_b0.col(k) = 0.5 * k * random();
      state_.v_b0.col(k) = random();
    }
    state_.gyro_bias = 0.02 * random();
    state_.accel_bias = 0.1 * random();
    state_.gravity_b0 = 9.81 * random().normalized();
    t_b_c_ = 0.1 * random();
  }

  Eigen::Vector3d random() { return gaussian_.vector(); }

  Preintegration somePreintegration() {
    Preintegration pre;
    pre.dt = 0.25;
    pre.dR = expSO3(0.1 * random());
    pre.dv = random();
    pre.dp = 0.1 * random();
    pre.dR_dbg = -0.25 * expSO3(0.1 * random());
    pre.dv_dbg.col(0) = 0.1 * random();
    pre.dv_dba = -0.25 * expSO3(0.1 * random());
    pre.dp_dbg.col(1) = 0.1 * random();
    pre.dp_dba = -0.03 * expSO3(0.1 * random());
    pre.gyro_bias = state_.gyro_bias + 0.01 * random();
    pre.accel_bias = 0.1 * random();
    return pre;
  }

  PointParameters somePoint() {
    PointParameters point;
    point.origin = 0.3 * random();
    point.direction = random().normalized();
    point.tangent = tangentBasis(point.direction);
    return point;
  }
  // From keyframe 2.
  PointView viewOf(const PointParameters& point) {
    PointView view;
    view.keyframe = 2;
    view.bearing_b =
        (state_.R_b0_bk[2].transpose() * point.direction + 0.2 * random()).normalized();
    view.tangent_b = tangentBasis(view.bearing_b).transpose();
    return view;
  }
  LineParameters someLine() {
    LineParameters line;
    line.origin = 0.3 * random();
    line.frame = expSO3(random());
    return line;
  }
  LineView someLineView(int keyframe) {
    LineView view;
    view.keyframe = keyframe;
    view.start_b = random().normalized();
    view.end_b = random().normalized();
    return view;
  }

  // Derivatives of f(state) by a step of the state, with a rig where `rig` is set.
  template <typename F>
  Eigen::MatrixXd byState(const F& f, bool rig = true) const {
    return numericJacobian(
        [&](const Eigen::VectorXd& step) -> Eigen::VectorXd { return f(retract(state_, step)); },
        StateLayout(state_.size(), rig).size(), kStep);
  }

  template <int D, typename View, typename Parameters>
  void check(const View& view, const Parameters& parameters, double scale) {
    ViewDerivatives<D> analytic;
    evaluate(view, parameters, state_, t_b_c_, scale, &analytic);
    ASSERT_GT(analytic.r.norm(), 1e-6);
    const auto residual = [&](const WindowState& state,
                              const Parameters& track) -> Eigen::VectorXd {
      ViewDerivatives<D> at;
      evaluate(view, track, state, t_b_c_, scale, &at);
      return at.r;
    };
    const Eigen::MatrixXd all =
        byState([&](const WindowState& state) { return residual(state, parameters); }, false);
    const int pose = StateLayout(state_.size()).pose(view.keyframe);
    EXPECT_TRUE(jacobiansAgree(analytic.J_pose, all.middleCols<6>(pose), kTolerance));
    const Eigen::MatrixXd track = numericJacobian(
        [&](const Eigen::VectorXd& d) {
          const Eigen::Matrix<double, D, 1> fixed = d;
          return residual(state_, parameters.moved(fixed));
        },
        D, kStep);
    EXPECT_TRUE(jacobiansAgree(analytic.J_track, track, kTolerance));
  }

  // Sets one in the state, and returns a calibration.
  Calibration drawRigError() {
    Calibration calibration;
    calibration.R_b_c = expSO3(random());
    calibration.t_b_c = t_b_c_;
    state_.rig.dR = expSO3(0.1 * random());
    state_.rig.dt = 0.05 * random();
    state_.rig.dtd = 0.02;
    return calibration;
  }

  template <int D, typename View, typename Parameters>
  void checkRows(const View& view, const Parameters& parameters, double readout_s) {
    const ImuInstant imu = {random(), 9.81 * random().normalized()};
    ViewDerivatives<D> analytic, moved;
    RowJacobian by_row, unused;
    const auto evaluateAt = [&](const WindowState& state, ViewDerivatives<D>* at, RowJacobian* by) {
      evaluateAtRow(view, parameters, {state, t_b_c_, readout_s, imu}, 300.0, at, by);
    };
    evaluateAt(state_, &analytic, &by_row);
    const StateLayout at(state_.size(), true);
    const Eigen::MatrixXd all = byState([&](const WindowState& state) {
      evaluateAt(state, &moved, &unused);
      return moved.r;
    });
    EXPECT_TRUE(
        jacobiansAgree(analytic.J_pose, all.middleCols<6>(at.pose(view.keyframe)), kTolerance));
    // A row time of 10 ms makes the derivative a hundredth of that by the position, and the
    // rounding of the differences as much larger.
    EXPECT_TRUE(jacobiansAgree(by_row.leftCols<3>(), all.middleCols<3>(at.velocity(view.keyframe)),
                               30.0 * kTolerance));
    EXPECT_TRUE(jacobiansAgree(by_row.col(3), all.col(at.readout()), kTolerance));
  }

  Gaussian gaussian_;
  WindowState state_;
  Eigen::Vector3d t_b_c_;
};

TEST_P(RefinementJacobians, Point) {
  PointParameters point = somePoint();
  for (double inverse_depth : {0.4, 0.0, -0.05}) {
    point.inverse_depth = inverse_depth;
    check<3>(viewOf(point), point, 300.0);
  }
}

TEST_P(RefinementJacobians, Line) {
  LineParameters line = someLine();
  for (double inverse_distance : {0.3, 0.0, -0.1}) {
    line.inverse_distance = inverse_distance;
    check<4>(someLineView(1), line, 300.0);
  }
}

TEST_P(RefinementJacobians, Inertial) {
  const Preintegration pre = somePreintegration();

  const InertialResidual analytic = inertialResidual(state_, 1, pre);
  const StateLayout at(state_.size());
  const Eigen::MatrixXd all =
      byState([&](const WindowState& state) { return inertialResidual(state, 1, pre).r; }, false);
  Eigen::MatrixXd numeric(9, kInertialColumns);
  numeric << all.middleCols<12>(at.pose(1)), all.middleCols<6>(at.velocity(1)),
      all.middleCols<8>(at.gyroBias());
  EXPECT_TRUE(jacobiansAgree(analytic.J, numeric, kTolerance));
}

// Exposures of their own: against the pose and the velocity of the keyframe and the readout time.
TEST_P(RefinementJacobians, PointAndLineInARollingShutter) {
  PointParameters point = somePoint();
  point.inverse_depth = 0.4;
  PointView seen = viewOf(point);
  seen.row = 0.4;
  LineParameters line = someLine();
  line.inverse_distance = 0.3;
  LineView segment = someLineView(2);
  segment.start_row = -0.5;
  segment.end_row = 0.3;
  for (const double readout_s : {0.0, 0.03}) {  // zero: a rolling shutter that is not known yet
    checkRows<3>(seen, point, readout_s);
    checkRows<4>(segment, line, readout_s);
  }
}

// The residual of one pair under a rig error, by every state that enters and by the error itself.
TEST_P(RefinementJacobians, InertialUnderARigError) {
  const Preintegration pre = somePreintegration();
  const Calibration calibration = drawRigError();
  constexpr double kTdShift = 0.005;
  std::vector<ImuInstant> instants(3);
  for (ImuInstant& instant : instants) instant = {random(), 9.81 * random().normalized()};
  std::vector<RigDerivatives> chain(3);
  const auto residual = [&](const WindowState& state, std::vector<RigDerivatives>* derivatives) {
    WindowState nominal = state;
    const BodyOffset offset(state.rig, calibration);
    for (int k = 0; k < 3; ++k) {
      bodyAtNominalTime(state, k, offset, {state.rig.dtd - kTdShift, instants[k]}, &nominal,
                        derivatives == nullptr ? nullptr : &(*derivatives)[k]);
    }
    return inertialResidual(nominal, 1, pre);
  };
  const InertialResidual factor = residual(state_, &chain);
  const Eigen::Matrix<double, 9, kRigInertialColumns> analytic =
      chainRig(factor.J, chain[1], chain[2]);
  const StateLayout at(3, true);
  const Eigen::MatrixXd all =
      byState([&](const WindowState& state) { return residual(state, nullptr).r; });
  Eigen::MatrixXd numeric(9, kRigInertialColumns);
  numeric << all.middleCols(at.pose(1), 12), all.middleCols(at.velocity(1), 6),
      all.middleCols(at.gyroBias(), 8 + StateLayout::kRig - 1);
  EXPECT_TRUE(jacobiansAgree(analytic, numeric, kTolerance));
  EXPECT_LT(all.col(at.readout()).norm(), 1e-12) << "the readout time has no part in the IMU";
  // Each part of the rig by itself: the largest must not hide the others.
  for (const auto& [from, size] : {std::pair{26, 3}, {29, 3}, {32, 1}}) {
    EXPECT_TRUE(jacobiansAgree(analytic.middleCols(from, size), numeric.middleCols(from, size),
                               kTolerance));
  }
}

TEST_P(RefinementJacobians, KnownState) {
  StateFactor factor;
  factor.velocity_b = state_.v_b0.col(0) + 0.3 * random();
  factor.down_b = (state_.gravity_b0.normalized() + 0.2 * random()).normalized();
  factor.gyro_bias = 0.02 * random();
  factor.accel_bias = 0.1 * random();
  const ImuInstant instant = {random(), 9.81 * random().normalized()};
  const StateResidual exact = stateResidual(state_, factor, Calibration(), instant);
  // Estimate minus prior.
  EXPECT_LT((exact.r.head<3>() - state_.v_b0.col(0) + factor.velocity_b).norm(), 1e-12);
  EXPECT_LT((exact.r.segment<3>(5) - state_.gyro_bias + factor.gyro_bias).norm(), 1e-12);
  EXPECT_LT((exact.r.tail<3>() - state_.accel_bias + factor.accel_bias).norm(), 1e-12);

  const StateLayout at(3, true);
  const auto check = [&](const Calibration& calibration) {
    const StateResidual analytic = stateResidual(state_, factor, calibration, instant);
    const Eigen::MatrixXd all = byState([&](WindowState moved) {
      // The pose is the gauge.
      moved.R_b0_bk[0] = state_.R_b0_bk[0];
      return stateResidual(moved, factor, calibration, instant).r;
    });
    Eigen::MatrixXd numeric(kStateRows, kStateColumns);
    numeric << all.middleCols(at.velocity(0), 3), all.middleCols(at.gyroBias(), kStateColumns - 3);
    for (const auto& [from, size] : {std::pair{0, 11}, {11, 3}, {14, 3}, {17, 1}}) {
      EXPECT_TRUE(jacobiansAgree(analytic.J.middleCols(from, size), numeric.middleCols(from, size),
                                 kTolerance))
          << from;
    }
  };
  check(Calibration());
  check(drawRigError());
}

TEST_P(RefinementJacobians, MeasuredVelocity) {
  Calibration calibration = drawRigError();
  calibration.speed_sensor.R_b_s = expSO3(random());
  calibration.speed_sensor.t_b_s = random();
  SpeedFactor factor;
  factor.keyframe = 2;
  factor.velocity = random();
  factor.W << 3.0, 0.0, 0.0, 0.4, 2.0, 0.0, -0.3, 0.5, 1.5;
  const Eigen::Vector3d biased_rate = random();
  const auto residual = [&](const WindowState& state) {
    return speedResidual(state, factor, calibration, biased_rate - state.gyro_bias);
  };
  const SpeedResidual analytic = residual(state_);
  const StateLayout at(3, true);
  const Eigen::MatrixXd all = byState([&](const WindowState& state) { return residual(state).r; });
  Eigen::MatrixXd numeric(3, kSpeedColumns);
  numeric << all.middleCols<3>(at.pose(2)), all.middleCols<3>(at.velocity(2)),
      all.middleCols<3>(at.gyroBias()), all.middleCols<3>(at.rig());
  EXPECT_TRUE(jacobiansAgree(analytic.J, numeric, kTolerance));
  EXPECT_NEAR(numeric.norm(), all.norm(), 1e-6) << "nothing else has a part in it";
  // By the common error of the measurements: that of a sensor which reads more.
  factor.velocity = 1.1 * factor.W.inverse() * analytic.by_scale;
  EXPECT_LT((residual(state_).r + 0.1 * analytic.by_scale).norm(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RefinementJacobians, ::testing::Range(1, 9));

TEST(InertialWhitening, IsTheInverseSquareRoot) {
  Preintegration pre;
  const Eigen::Matrix<double, 9, 9> A = Eigen::Matrix<double, 9, 9>::Random();
  pre.covariance = A * A.transpose() + 0.1 * Eigen::Matrix<double, 9, 9>::Identity();
  Eigen::Matrix<double, 9, 9> W;
  ASSERT_TRUE(inertialWhitening(pre, &W));
  EXPECT_LT((W * pre.covariance * W.transpose() - Eigen::Matrix<double, 9, 9>::Identity()).norm(),
            1e-10);
  pre.covariance(0, 0) = -1.0;
  EXPECT_FALSE(inertialWhitening(pre, &W));
}

}  // namespace
}  // namespace slim_init
