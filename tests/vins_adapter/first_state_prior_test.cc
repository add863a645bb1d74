// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What an answer knows of the host's first state as a factor of the host: rows, free directions,
// covariance, and how it is put into the members of VINS-Mono's marginalisation.
#include "first_state_prior.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <vector>

#include "slim_init/vins_adapter/host_glue.h"

namespace slim_init::vins_adapter {
namespace {

using Root = Eigen::Matrix<double, Eigen::Dynamic, HostWindow::kPriorColumns, Eigen::RowMajor>;

Root rootOf(const std::vector<double>& prior) {
  return Eigen::Map<const Root>(prior.data(),
                                static_cast<Eigen::Index>(prior.size()) / HostWindow::kPriorColumns,
                                HostWindow::kPriorColumns);
}

constexpr double kSigmaVelocity = 0.05, kSigmaTilt = 0.01, kSigmaGyro = 1e-3, kSigmaAccel = 0.03;

// A step along one axis, in standard deviations.
double sigmasOf(const Root& root, int column, double step) {
  return std::abs(step) * root.col(column).norm();
}

// Two keyframes, the second of which nobody asks about.
InitResult answer() {
  InitResult result;
  result.status = InitStatus::kSuccess;
  result.gravity_w = Eigen::Vector3d(0.0, 0.0, -9.81);
  for (int k = 0; k < 2; ++k) {
    NavState state;
    state.t = 10.0 + k;
    state.R_w_b = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).matrix();
    state.v_w_b = Eigen::Vector3d(1.0, -0.5, 0.2);
    result.states.push_back(state);
  }
  Eigen::VectorXd sigma = Eigen::VectorXd::Ones(9 * 2 + 6);
  sigma.segment<3>(0).setConstant(kSigmaTilt);
  sigma.segment<3>(6).setConstant(kSigmaVelocity);
  sigma.segment<3>(18).setConstant(kSigmaGyro);
  sigma.segment<3>(21).setConstant(kSigmaAccel);
  result.covariance = sigma.cwiseAbs2().asDiagonal();
  return result;
}

// The answer's world turned by a yaw and moved.
HostState inHost(const NavState& state) {
  const Eigen::Matrix3d Z = Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()).matrix();
  HostState host;
  host.P = Z * state.p_w_b + Eigen::Vector3d(3, 4, 5);
  host.R = Z * state.R_w_b;
  host.V = Z * state.v_w_b;
  return host;
}

// A turn of the world about the vertical: attitude and velocity follow.
Eigen::Matrix<double, 15, 1> turnOf(const HostState& host) {
  Eigen::Matrix<double, 15, 1> turn = Eigen::Matrix<double, 15, 1>::Zero();
  turn.segment<3>(3) = host.R.transpose() * Eigen::Vector3d::UnitZ();
  turn.segment<3>(6) = Eigen::Vector3d::UnitZ().cross(host.V);
  return turn;
}

// Of the velocity, by itself.
Eigen::Matrix3d velocityCovariance(const Root& root) {
  const Eigen::MatrixXd information = root.transpose() * root;
  return information.block<3, 3>(6, 6).inverse();
}

// An answer in a host.
class FirstStatePrior : public ::testing::Test {
 protected:
  InitResult result_ = answer();
  const HostState state_ = inHost(result_.states.front());
  const std::vector<double> prior_ = firstStatePrior(result_, result_.states.front(), state_);
};

TEST_F(FirstStatePrior, PositionAndHeadingAreFree) {
  const Root root = rootOf(prior_);
  ASSERT_EQ(root.rows(), 11);
  EXPECT_EQ(root.leftCols<3>().norm(), 0.0);
  EXPECT_LT((root * turnOf(state_)).norm(), 1e-9 * root.norm());
}

TEST_F(FirstStatePrior, TheRestHasTheCovarianceOfTheAnswer) {
  const Root root = rootOf(prior_);
  EXPECT_NEAR(sigmasOf(root, 9, kSigmaAccel), 1.0, 1e-9);
  EXPECT_NEAR(sigmasOf(root, 12, kSigmaGyro), 1.0, 1e-9);
  // Velocity and tilt go together, through the velocity in the body.
  const Eigen::Matrix3d of_v = velocityCovariance(root);
  EXPECT_LE(of_v.diagonal().maxCoeff(), 1.1 * kSigmaVelocity * kSigmaVelocity);
  EXPECT_GE(of_v.diagonal().minCoeff(), 0.95 * kSigmaVelocity * kSigmaVelocity);
}

// Tilt and accelerometer bias over half a second widen the velocity.
TEST_F(FirstStatePrior, BeforeTheKeyframeItIsLessCertain) {
  // At rest the free heading does not move the velocity.
  for (NavState& state : result_.states) state.v_w_b.setZero();
  const auto variance = [this](double before) {
    NavState at = result_.states.front();
    at.t -= before;
    const Root root = rootOf(firstStatePrior(result_, at, inHost(at)));
    const Eigen::MatrixXd information =
        root.transpose() * root + 1e-6 * Eigen::MatrixXd::Identity(15, 15);
    return information.inverse().diagonal().segment<3>(6).sum();
  };
  const double here = variance(0.0);
  EXPECT_NEAR(here, 3.0 * kSigmaVelocity * kSigmaVelocity, 0.01 * here);
  const double by_tilt = 2.0 * std::pow(9.81 * 0.5 * kSigmaTilt, 2);
  const double by_bias = 3.0 * std::pow(0.5 * kSigmaAccel, 2);
  EXPECT_NEAR(variance(0.5), here + by_tilt + by_bias, 0.01 * here);
}

// A body that stood: however long ago, it is the same state.
TEST_F(FirstStatePrior, AtRestItIsAsCertainAsAtTheKeyframe) {
  for (NavState& state : result_.states) state.v_w_b.setZero();
  NavState at = result_.states.front();
  const std::vector<double> here = firstStatePrior(result_, at, inHost(at));
  at.t -= 30.0;
  EXPECT_NE(firstStatePrior(result_, at, inHost(at)), here);
  result_.at_rest_since = at.t;
  EXPECT_EQ(firstStatePrior(result_, at, inHost(at)), here);
  at.t -= 0.1;
  EXPECT_NE(firstStatePrior(result_, at, inHost(at)), here);
}

// A state that the host has had: once, and with the covariance of a state in flight.
TEST_F(FirstStatePrior, OfAHealthyState) {
  host_health::PropagatedState healthy;
  healthy.state = result_.states.front();
  healthy.covariance = host_health::healthyCovariance();
  const Root root = rootOf(firstStatePrior(healthy, state_));
  ASSERT_EQ(root.rows(), 11);
  EXPECT_EQ(root.leftCols<3>().norm(), 0.0);
  EXPECT_NEAR(sigmasOf(root, 9, std::sqrt(healthy.covariance(12, 12))), 1.0, 1e-9);
  EXPECT_NEAR(sigmasOf(root, 12, std::sqrt(healthy.covariance(9, 9))), 1.0, 1e-9);
  EXPECT_NEAR(velocityCovariance(root).diagonal().maxCoeff(), healthy.covariance(3, 3),
              0.1 * healthy.covariance(3, 3));
  healthy.covariance.setZero();
  EXPECT_TRUE(firstStatePrior(healthy, state_).empty());
}

TEST_F(FirstStatePrior, WithoutACovarianceThereIsNone) {
  result_.covariance.setZero();
  EXPECT_TRUE(firstStatePrior(result_, result_.states.front(), state_).empty());
  result_.covariance.resize(0, 0);
  EXPECT_TRUE(firstStatePrior(result_, result_.states.front(), state_).empty());
  EXPECT_TRUE(firstStatePrior(InitResult(), NavState(), state_).empty());
}

// The members that VINS-Mono's estimator has.
struct Info {
  ~Info() {
    for (auto& data : parameter_block_data) delete[] data.second;
  }
  int m = -1, n = -1;
  std::map<long, double*> parameter_block_data;
  std::vector<int> keep_block_size, keep_block_idx;
  std::vector<double*> keep_block_data;
  Eigen::MatrixXd linearized_jacobians;
  Eigen::VectorXd linearized_residuals;
};

struct Host {
  ~Host() { delete last_marginalization_info; }
  double para_Pose[11][7] = {};
  double para_SpeedBias[11][9] = {};
  Eigen::Vector3d Ps[11], Vs[11], Bas[11], Bgs[11];
  Eigen::Matrix3d Rs[11];
  Info* last_marginalization_info = nullptr;
  std::vector<double*> last_marginalization_parameter_blocks;
};

TEST_F(FirstStatePrior, IsPutWhereTheHostKeepsItsOwn) {
  Host host;
  host.Ps[0] = state_.P;
  host.Rs[0] = state_.R;
  host.Vs[0] = state_.V;
  host.Bas[0] = Eigen::Vector3d(0.1, 0.2, 0.3);
  host.Bgs[0] = Eigen::Vector3d(0.01, 0.02, 0.03);
  glue_detail::setPrior(host, std::vector<double>(), false);
  EXPECT_EQ(host.last_marginalization_info, nullptr);
  for (int again = 0; again < 2; ++again) {
    glue_detail::setPrior(host, prior_, false);
    const Info* info = host.last_marginalization_info;
    ASSERT_NE(info, nullptr);
    EXPECT_EQ(info->m, 0);
    EXPECT_EQ(info->n, 15);
    EXPECT_EQ(info->keep_block_size, (std::vector<int>{7, 9}));
    EXPECT_EQ(info->keep_block_idx, (std::vector<int>{0, 6}));
    EXPECT_EQ(host.last_marginalization_parameter_blocks,
              (std::vector<double*>{host.para_Pose[0], host.para_SpeedBias[0]}));
    EXPECT_EQ(info->linearized_residuals.norm(), 0.0);
    EXPECT_EQ(info->linearized_jacobians.topRows(11), rootOf(prior_));
    EXPECT_EQ(info->linearized_jacobians.bottomRows(4).norm(), 0.0);
    const Eigen::Map<const Eigen::Quaterniond> q(info->keep_block_data[0] + 3);
    EXPECT_LT((q.toRotationMatrix() - state_.R).norm(), 1e-12);
    EXPECT_EQ(info->keep_block_data[0][1], state_.P.y());
    EXPECT_EQ(info->keep_block_data[1][0], state_.V.x());
    EXPECT_EQ(info->keep_block_data[1][4], 0.2);
    EXPECT_EQ(info->keep_block_data[1][8], 0.03);
  }
}

// GVINS: it has a factor on the first pose, which it takes into its next prior only where it has no
// prior, and it does not turn its window back: position and heading would be free for good.
struct AnchoredHost : Host {
  bool first_optimization = false;
};

TEST_F(FirstStatePrior, AnAnchoredHostHoldsPositionAndHeadingToo) {
  AnchoredHost host;
  host.Rs[0] = state_.R;
  Host other;
  EXPECT_FALSE(glue_detail::anchorAgain(other));
  ASSERT_TRUE(glue_detail::anchorAgain(host));
  EXPECT_TRUE(host.first_optimization);
  glue_detail::setPrior(host, prior_, true);
  const Eigen::MatrixXd& root = host.last_marginalization_info->linearized_jacobians;
  EXPECT_EQ(root.topRows(11), rootOf(prior_));
  EXPECT_EQ(Eigen::FullPivLU<Eigen::MatrixXd>(root).rank(), 15);
  // A metre and a radian about the vertical cost what they cost in the host's factor; what else is
  // known keeps its covariance.
  EXPECT_NEAR((root * turnOf(state_)).norm(), 120.0, 1e-6);
  EXPECT_NEAR(root.col(1).norm(), 120.0, 1e-9);
  EXPECT_EQ(root.bottomRows(4).rightCols(9).norm(), 0.0);
  // A tilt is not held by the four rows.
  Eigen::Matrix<double, 15, 1> tilt = Eigen::Matrix<double, 15, 1>::Zero();
  tilt.segment<3>(3) = state_.R.transpose() * Eigen::Vector3d::UnitX();
  EXPECT_LT((root.bottomRows(4) * tilt).norm(), 1e-9);
}

// A host without them stays as it is.
TEST_F(FirstStatePrior, AHostWithoutTheMembersCompiles) {
  int host = 7;
  glue_detail::setPrior(host, std::vector<double>(165, 1.0), true);
  EXPECT_EQ(host, 7);
}

}  // namespace
}  // namespace slim_init::vins_adapter
