// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The lines inserted into OpenVINS, compiled as C++14 into a stand-in for it and run there.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "VioManager.h"
#include "evaluation/scratch_folder.h"
#include "geometry/so3.h"
#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init::vins_adapter {
namespace {

class OpenVinsRun : public ::testing::Test {
 protected:
  OpenVinsRun() { ov_core::printed.clear(); }

  // The host with these keys in its file.
  ov_msckf::VioManager& start(const std::map<std::string, std::string>& keys) {
    auto parser = std::make_shared<ov_core::YamlParser>();
    parser->texts = keys;
    parser->folder = folder_.path() + "/";
    const Calibration& rig = exact_.calibration;
    ov_init::InertialInitializerOptions options;
    options.print_and_load_initializer(parser);
    EXPECT_TRUE(parser->found_all);
    options.sigma_w = rig.imu_noise.gyro_density;
    options.sigma_a = rig.imu_noise.accel_density;
    options.gravity_mag = rig.gravity_magnitude;
    options.calib_camimu_dt = rig.td;
    // q_ItoC in JPL's convention has the numbers of Hamilton's quaternion of its inverse.
    const Eigen::Quaterniond q(rig.R_b_c);
    Eigen::VectorXd extrinsic(7);
    extrinsic << q.x(), q.y(), q.z(), q.w(), -rig.R_b_c.transpose() * rig.t_b_c;
    options.camera_extrinsics[0] = extrinsic;
    options.camera_intrinsics[0] = std::make_shared<ov_core::CamBase>();
    options.camera_intrinsics[0]->value(0) = rig.focal_px;
    manager_ = std::make_unique<ov_msckf::VioManager>(options);
    return *manager_;
  }

  // The IMU samples up to image `k`, and its tracks in the host's database.
  void feed(int k) {
    while (next_ < exact_.imu.size() &&
           (next_ == 0 || exact_.imu[next_ - 1].t < exact_.truth[k].t)) {
      const ImuSample& sample = exact_.imu[next_++];
      manager_->initializer->feed_imu({sample.t, sample.gyro, sample.accel});
    }
    auto& features = manager_->trackFEATS->get_feature_database()->features;
    for (const PointObservation& point : exact_.keyframes[k].points) {
      auto& feature = features[static_cast<std::size_t>(point.id)];
      if (feature == nullptr) {
        feature = std::make_shared<ov_core::Feature>();
        feature->featid = static_cast<std::size_t>(point.id);
      }
      const Eigen::Vector3d ray = point.bearing / point.bearing.z();
      feature->timestamps[0].push_back(exact_.keyframes[k].t);
      feature->uvs_norm[0].push_back(ray.head<2>().cast<float>());
      feature->uvs[0].push_back(point.pixel.cast<float>());
      // What a second camera sees is none of ours.
      feature->timestamps[1].push_back(exact_.keyframes[k].t);
    }
  }
  // The image at which the host starts, or -1.
  int run(int images) {
    for (int k = 0; k < images; ++k) {
      feed(k);
      if (manager_->try_to_initialize()) return k;
    }
    return -1;
  }
  static int timesPrinted(const std::string& text) {
    int times = 0;
    for (const std::string& line : ov_core::printed) times += contains(line, text) ? 1 : 0;
    return times;
  }

  const ExactWindow exact_ = makeExactWindow(atTenHertz(40));
  const ScratchFolder folder_;
  std::unique_ptr<ov_msckf::VioManager> manager_;
  std::size_t next_ = 0;
};

TEST_F(OpenVinsRun, SlimSeedsStateAndCovariance) {
  ov_msckf::VioManager& host = start({{"initializer", "slim"}, {"init_dyn_use", "true"}});
  const int k = run(35);
  ASSERT_GE(k, 5);
  const ov_msckf::State& state = *host.state;
  ASSERT_EQ(host.order.size(), 1u);
  EXPECT_EQ(host.order[0], state._imu);
  EXPECT_EQ(state._imu->estimate, state._imu->first_estimate);
  // Keyframes are images; the newest one is at most one behind.
  int at = 0;
  while (at < k && std::abs(exact_.keyframes[at].t - state._timestamp) > 1e-3) ++at;
  EXPECT_GE(at, k - 1);
  const NavState& truth = exact_.truth[at];
  const Eigen::VectorXd x = state._imu->estimate;
  const Eigen::Matrix3d R = Eigen::Quaterniond(x[3], x[0], x[1], x[2]).toRotationMatrix();
  EXPECT_LT((R.row(2) - truth.R_w_b.row(2)).norm(), 5e-3);
  EXPECT_EQ((x.segment<3>(4)), Eigen::Vector3d::Zero());
  EXPECT_LT((R.transpose() * x.segment<3>(7) - truth.R_w_b.transpose() * truth.v_w_b).norm(), 0.03);
  EXPECT_LT((x.segment<3>(10) - truth.gyro_bias).norm(), 2e-3);
  ASSERT_EQ(state._Cov.rows(), 15);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(state._Cov);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(state._Cov.diagonal().segment<3>(6).maxCoeff(), 0.5 * 0.5);
  EXPECT_EQ(host.initializer->dynamic_tries, 0);
  EXPECT_EQ(timesPrinted("[slim_init]: seed done"), 1);
  EXPECT_EQ(timesPrinted("[slim_init]: initializer: slim, method slim"), 1);
}

TEST_F(OpenVinsRun, StockIsNotTouched) {
  for (const bool named : {false, true}) {
    std::map<std::string, std::string> keys = {{"init_dyn_use", "true"}};
    if (named) keys["initializer"] = "stock";
    ov_msckf::VioManager& host = start(keys);
    next_ = 0;
    EXPECT_EQ(run(30), -1);
    EXPECT_EQ(host.initializer->dynamic_tries, 30);
    EXPECT_FALSE(host.initializer->slim_init_glue.active());
    EXPECT_TRUE(ov_core::printed.empty());
  }
}

TEST_F(OpenVinsRun, StaticInitializationIsKept) {
  ov_msckf::VioManager& host = start({{"initializer", "slim"}});
  host.initializer->at_rest = true;
  EXPECT_EQ(run(5), 0);
  EXPECT_EQ(host.initializer->static_tries, 1);
  EXPECT_EQ(timesPrinted("[slim_init]: too_few_keyframes"), 1);
}

TEST_F(OpenVinsRun, ShadowReportsAndLeavesTheHostAlone) {
  ov_msckf::VioManager& host = start({{"initializer", "shadow"}, {"init_dyn_use", "true"}});
  for (int k = 0; k < 30; ++k) {
    feed(k);
    EXPECT_FALSE(host.try_to_initialize());
  }
  EXPECT_TRUE(host.order.empty());
  // The host's own answer: the truth with twice the speed.
  const NavState& truth = exact_.truth[30];
  const Eigen::Quaterniond q(truth.R_w_b);
  Eigen::MatrixXd state(16, 1);
  state << q.x(), q.y(), q.z(), q.w(), 0, 0, 0, 2.0 * truth.v_w_b, truth.gyro_bias,
      truth.accel_bias;
  host.initializer->dynamic_succeeds = true;
  host.initializer->dynamic_state = state;
  host.initializer->dynamic_time = exact_.keyframes[30].t;
  feed(30);
  EXPECT_TRUE(host.try_to_initialize());
  EXPECT_EQ(host.state->_imu->estimate, state);
  EXPECT_EQ(host.state->_Cov, Eigen::MatrixXd(Eigen::MatrixXd::Identity(15, 15)));
  ASSERT_EQ(timesPrinted("shadow: OpenVINS starts after 3.00 s, slim after "), 1);
  std::string line;
  for (const std::string& printed : ov_core::printed) {
    if (contains(printed, "shadow: ")) line = printed;
  }
  double stock = 0.0, slim = 0.0, tilt = 0.0;
  const std::size_t at = line.find("; speed ");
  ASSERT_NE(at, std::string::npos) << line;
  ASSERT_EQ(std::sscanf(line.c_str() + at, "; speed %lf m/s, slim %lf m/s", &stock, &slim), 2);
  EXPECT_NEAR(stock, 2.0 * truth.v_w_b.norm(), 1e-3);
  EXPECT_NEAR(slim, truth.v_w_b.norm(), 0.02 * slim);
  const std::size_t tilt_at = line.find("tilt by ");
  ASSERT_NE(tilt_at, std::string::npos) << line;
  ASSERT_EQ(std::sscanf(line.c_str() + tilt_at, "tilt by %lf", &tilt), 1);
  EXPECT_LT(tilt, 0.3);
}

TEST_F(OpenVinsRun, TheFileOfOptionsLiesBesideTheHosts) {
  folder_.write("mine.yaml", "%YAML:1.0\nslim_init:\n  method: drt-l\n");
  start({{"initializer", "slim"}, {"relative_config_slim_init", "mine.yaml"}});
  EXPECT_EQ(timesPrinted("initializer: slim, method drt-l"), 1);
  // A method without a covariance has nothing that the filter could begin with.
  EXPECT_EQ(run(35), -1);
  EXPECT_GE(timesPrinted("no covariance"), 1);
  // By its whole path.
  start({{"initializer", "slim"}, {"relative_config_slim_init", folder_.file("mine.yaml")}});
  EXPECT_EQ(timesPrinted("initializer: slim, method drt-l"), 2);
}

TEST_F(OpenVinsRun, WhatIsWrongIsNamedAndTheHostGoesOnAlone) {
  for (const auto& keys : std::vector<std::map<std::string, std::string>>{
           {{"initializer", "slimm"}},
           {{"initializer", "slim"}, {"relative_config_slim_init", "absent.yaml"}}}) {
    auto with_dynamic = keys;
    with_dynamic["init_dyn_use"] = "true";
    ov_msckf::VioManager& host = start(with_dynamic);
    next_ = 0;
    EXPECT_EQ(run(2), -1);
    EXPECT_EQ(host.initializer->dynamic_tries, 2);
  }
  EXPECT_EQ(timesPrinted("initializer is \"slimm\", must be stock, slim or shadow"), 1);
  EXPECT_EQ(timesPrinted("absent.yaml"), 1);
  EXPECT_EQ(timesPrinted("the host initializes by itself"), 2);
}

}  // namespace
}  // namespace slim_init::vins_adapter
