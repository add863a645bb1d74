// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Analytic derivatives of every factor of the back end against central differences.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "geometry/so3.h"
#include "inertial_cost.h"
#include "prior.h"
#include "reprojection_cost.h"
#include "support/exact_window.h"
#include "support/gaussian.h"
#include "support/jacobian_check.h"

namespace slim_init::backend {
namespace {

constexpr double kStep = 1e-6;
constexpr double kTolerance = 1e-6;

class BackendFactors : public ::testing::TestWithParam<int> {
 protected:
  BackendFactors() : gaussian_(GetParam()), calibration_(eurocCalibration()) {
    for (int k = 0; k < 2; ++k) {
      auto frame = std::make_unique<Frame>();
      frame->id = k;
      frame->t = 0.25 * k;
      NavState state;
      state.R_w_b = expSO3(random());
      state.p_w_b = random();
      state.v_w_b = random();
      state.gyro_bias = 0.02 * random();
      state.accel_bias = 0.1 * random();
      frame->set(state);
      // Away from theta = 0, where the right Jacobian is not the identity.
      for (int i = 3; i < 6; ++i) frame->pose[i] = 0.3 * gaussian_();
      frames_.push_back(std::move(frame));
    }
  }

  Eigen::Vector3d random() { return gaussian_.vector(); }

  // All Jacobians of a cost at the present values of its blocks.
  void check(const ceres::CostFunction& cost, const std::vector<double*>& blocks) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const std::vector<int>& sizes = cost.parameter_block_sizes();
    ASSERT_EQ(sizes.size(), blocks.size());
    Eigen::VectorXd r(cost.num_residuals());
    std::vector<RowMajor> J;
    for (const int size : sizes) J.emplace_back(cost.num_residuals(), size);
    std::vector<double*> J_data;
    for (RowMajor& block : J) J_data.push_back(block.data());
    ASSERT_TRUE(cost.Evaluate(blocks.data(), r.data(), J_data.data()));
    ASSERT_GT(r.norm(), 1e-6);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const auto moved = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
        Eigen::VectorXd x = Eigen::Map<Eigen::VectorXd>(blocks[b], sizes[b]) + d;
        std::vector<const double*> at(blocks.begin(), blocks.end());
        at[b] = x.data();
        Eigen::VectorXd value(cost.num_residuals());
        EXPECT_TRUE(cost.Evaluate(at.data(), value.data(), nullptr));
        return value;
      };
      EXPECT_TRUE(jacobiansAgree(J[b], numericJacobian(moved, sizes[b], kStep), kTolerance))
          << "block " << b;
    }
  }

  Gaussian gaussian_;
  Calibration calibration_;
  Frames frames_;
};

TEST_P(BackendFactors, Inertial) {
  std::vector<ImuSample> imu;
  for (int k = 0; k <= 50; ++k) {
    ImuSample sample;
    sample.t = 0.005 * k;
    sample.gyro = 0.5 * random();
    sample.accel = Eigen::Vector3d(0, 0, 9.8) + random();
    imu.push_back(sample);
  }
  const Preintegration pre =
      preintegrate(imu, 0.0, 0.25, {0.02 * random(), 0.1 * random()}, calibration_.imu_noise,
                   PreintegrationParts::kWithCovariance);
  const auto cost = InertialCost::create(pre, frames_[0]->R_ref, frames_[1]->R_ref,
                                         Eigen::Vector3d(0, 0, -9.81), 2e-5, 3e-3);
  ASSERT_NE(cost, nullptr);
  check(*cost, {frames_[0]->pose.data(), frames_[0]->motion.data(), frames_[1]->pose.data(),
                frames_[1]->motion.data()});
}

TEST_P(BackendFactors, Reprojection) {
  for (double lambda : {0.0, 0.1, 0.6}) {
    const Eigen::Vector3d bearing = (Eigen::Vector3d::UnitZ() + 0.3 * random()).normalized();
    const Eigen::Vector3d seen =
        (transferPoint(frames_[0]->rotation(), frames_[0]->position(), frames_[1]->rotation(),
                       frames_[1]->position(), calibration_, bearing, lambda)
             .q.normalized() +
         0.02 * random())
            .normalized();
    const ReprojectionCost cost(*frames_[0], *frames_[1], calibration_, bearing, seen, 2e-3);
    check(cost, {frames_[0]->pose.data(), frames_[1]->pose.data(), &lambda});
  }
}

// A point at a finite distance falls where the cameras say.
TEST_P(BackendFactors, ReprojectionOfATruePointIsZero) {
  const Eigen::Matrix3d R_w_c = frames_[0]->rotation() * calibration_.R_b_c;
  const Eigen::Vector3d centre =
      frames_[0]->position() + frames_[0]->rotation() * calibration_.t_b_c;
  const Eigen::Vector3d bearing = (Eigen::Vector3d::UnitZ() + 0.3 * random()).normalized();
  const Eigen::Vector3d point = centre + R_w_c * (4.0 * bearing);
  const Eigen::Vector3d in_b =
      frames_[1]->rotation().transpose() * (point - frames_[1]->position());
  const Eigen::Vector3d seen =
      (calibration_.R_b_c.transpose() * (in_b - calibration_.t_b_c)).normalized();
  const ReprojectionCost cost(*frames_[0], *frames_[1], calibration_, bearing, seen, 1.0);
  const double lambda = 0.25;
  const double* blocks[] = {frames_[0]->pose.data(), frames_[1]->pose.data(), &lambda};
  Eigen::Vector2d r;
  ASSERT_TRUE(cost.Evaluate(blocks, r.data(), nullptr));
  EXPECT_LT(r.norm(), 1e-12);
}

TEST_P(BackendFactors, Anchor) {
  const Prior anchor = anchorAt(*frames_[0]);
  frames_[0]->R_ref = expSO3(0.4 * random()) * frames_[0]->R_ref;
  for (int i = 0; i < 3; ++i) frames_[0]->pose[i] += gaussian_();
  const PriorCost cost(anchor, frames_);
  check(cost, {frames_[0]->pose.data(), frames_[0]->motion.data()});
}

TEST_P(BackendFactors, Prior) {
  Prior prior;
  prior.blocks = {{0, BlockKind::kPose}, {0, BlockKind::kMotion}, {1, BlockKind::kPose}};
  for (const BlockKey& key : prior.blocks) {
    BlockPoint first;
    first.x = Eigen::VectorXd::Zero(key.size());
    for (double& value : first.x) value = gaussian_();
    if (key.kind == BlockKind::kPose) {
      first.x.tail<3>().setZero();
      first.R = frames_[static_cast<std::size_t>(key.frame)]->rotation() * expSO3(0.2 * random());
    }
    prior.first.push_back(first);
  }
  prior.J.resize(12, 21);
  for (Eigen::Index k = 0; k < prior.J.size(); ++k) prior.J.data()[k] = gaussian_();
  prior.r0 = Eigen::VectorXd::Ones(12);
  const PriorCost cost(prior, frames_);
  check(cost, {frames_[0]->pose.data(), frames_[0]->motion.data(), frames_[1]->pose.data()});
}

INSTANTIATE_TEST_SUITE_P(Seeds, BackendFactors, ::testing::Range(1, 6));

}  // namespace
}  // namespace slim_init::backend
