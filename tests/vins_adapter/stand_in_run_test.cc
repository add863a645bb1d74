// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The inserted lines, compiled as C++11 into a stand-in for the host and run there: what lands in
// which member, and when. Built once per host.
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/Bool.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <sstream>
#include <thread>

#include "evaluation/scratch_folder.h"
#include "geometry/so3.h"
#include "node.h"
#include "slim_init/vins_adapter/feature_message.h"
#include "slim_init/vins_adapter/host_convention.h"
#include "slim_init/vins_adapter/host_file.h"
#include "support/exact_window.h"
#include "support/text_parts.h"
#include "vins_adapter/host_streams.h"
#include "vins_adapter/oracle.h"

namespace slim_init::vins_adapter {
namespace {

const int kNewest = WINDOW_SIZE;
const char kNoLines[] = "warn: slim_init: no line features received";

template <typename Header>
void setStamp(double t, Header* header) {
  if constexpr (std::is_same_v<Header, double>) {
    *header = t;
  } else {
    header->stamp.seconds = t;
  }
}

// The node is one per process, as in the host; each test runs in a process of its own (CTest).
class StandInRun : public ::testing::Test {
 protected:
  // The host's file with our keys, in it and in its section slim_init:, and the node's start.
  void start(const std::string& keys, const std::string& section = "") {
    const std::string path = folder_.file("host.yaml");
    std::ifstream in(std::string(SLIM_INIT_SOURCE_DIR) + "/config/euroc.yaml");
    std::ofstream out(path);
    for (std::string line; std::getline(in, line);) {
      if (line.find("initializer:") == 0 || line.find("reinit:") == 0) continue;
      if (line.find("output_path:") == 0) line = "output_path: \"" + folder_.path() + "\"";
      // Lock step: every frame gets the estimate of its own window.
      if (line.find("slim_init:") == 0) out << keys << (keys.empty() ? "" : "max_wait_ms: -1\n");
      out << line << "\n";
      if (line.find("slim_init:") == 0) out << section;
    }
    out.close();
    ros::parameters()["config_file"] = path;
    ros::parameters()["vins_config_file"] = path;  // LVI-SAM's name for it
    startNode();
    host_.f_manager.feature.resize(5);
  }

  void frame(int k, bool with_lines = true) {
    std::vector<sensor_msgs::ImuConstPtr> imu;
    const double t = exact_.truth[k].t;
    // The sample after the frame comes again with the next one, as the host has it.
    if (next_ > 0) --next_;
    while (next_ == 0 || (next_ < exact_.imu.size() && exact_.imu[next_ - 1].t < t)) {
      imu.push_back(messageOf(exact_.imu[next_++]));
    }
    const auto& callbacks = ros::callbacks<sensor_msgs::PointCloudConstPtr>();
    if (with_lines && callbacks.count("/feature_tracker_lines/lines") > 0) {
      sensor_msgs::PointCloud cloud;
      cloud.header.stamp.seconds = exact_.keyframes[k].t;
      ASSERT_TRUE(writeLineMessage(exact_.keyframes[k], &cloud, nullptr));
      callbacks.at("/feature_tracker_lines/lines")(
          std::make_shared<const sensor_msgs::PointCloud>(cloud));
    }
    ImageFeatures image;
    for (const PointObservation& point : exact_.keyframes[k].points) {
      FeatureVector values = FeatureVector::Zero();
      values.head<3>() = point.bearing / point.bearing.z();
      values.segment<2>(3) = point.pixel;
      image[static_cast<int>(point.id)].emplace_back(0, values);
    }
    process(imu, image, exact_.keyframes[k].t);
  }
  // What the host's optimization would make of its newest frame.
  void track(int k) {
    // The whole window in the frame of the truth: the start had one of its own.
    for (int i = 0; i < kNewest; ++i) {
      const double stamp = glue_detail::stampOf(host_.Headers[i]);
      for (std::size_t f = 0; f < exact_.keyframes.size(); ++f) {
        if (std::abs(exact_.keyframes[f].t - stamp) < 1e-6) setState(exact_.truth[f], i);
      }
    }
    setState(exact_.truth[k], kNewest);
  }
  // A frame of a host that has tracked so far.
  void trackedFrame(int k) {
    track(k);
    frame(k);
  }
  double positionError(int k) { return (host_.Ps[kNewest] - exact_.truth[k].p_w_b).norm(); }
  double velocityError(int k) { return (host_.Vs[kNewest] - exact_.truth[k].v_w_b).norm(); }
  double attitudeError(int k) {
    return logSO3(host_.Rs[kNewest].transpose() * exact_.truth[k].R_w_b).norm();
  }
  void setState(const NavState& truth, int i) {
    host_.Ps[i] = truth.p_w_b;
    host_.Rs[i] = truth.R_w_b;
    host_.Vs[i] = truth.v_w_b;
    host_.Bgs[i] = truth.gyro_bias;
    host_.Bas[i] = truth.accel_bias;
  }
  // An interval whose damaged data have been replaced, with the covariance of what is not known.
  static void expectReplaced(const IntegrationBase& interval) {
    EXPECT_NEAR(interval.sum_dt, 0.1, 1e-9);
    for (const Vector3d& accel : interval.accel) EXPECT_LT(accel.norm(), 60.0);
    EXPECT_GT(interval.covariance(6, 6), 0.0);
  }
  // So many frames from the start on, which has to come; the host tracks once it is started.
  // Returns the next one.
  int fly(int frames) {
    for (int k = 0; k < frames; ++k) {
      frame(k);
      if (host_.solver_flag == Estimator::NON_LINEAR) track(k + 1);
    }
    EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR) << logText();
    return frames;
  }
  int startAndFly(int frames) {
    start("initializer: slim\nreinit: 1\n");
    return fly(frames);
  }
  // Frames from `k` until the host is started, which has to come before `end`. Returns the next
  // one.
  int frameUntilStarted(int k = 0, int end = 30) {
    while (k < end && host_.solver_flag == Estimator::INITIAL) frame(k++);
    EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR) << logText();
    return k;
  }
  // After a restart the host sees nothing until frame `seen`, and then starts. Returns where it was
  // before, newest_ is the frame of the start.
  Vector3d longTimeWithoutAStart(int seen) {
    exact_ = makeExactWindow(atTenHertz(seen + 30));
    int k = startAndFly(30);
    const Vector3d last = host_.Ps[kNewest];
    restart(samplesUntil(k + 1));
    for (; k < seen; ++k) {
      exact_.keyframes[k].points.clear();
      exact_.keyframes[k].lines.clear();
      frame(k);
    }
    EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
    newest_ = frameUntilStarted(k, seen + 29) - 1;
    EXPECT_EQ(timesLogged("the odometry frame is continued"), 1) << logText();
    EXPECT_EQ(timesLogged("IMU data do not cover"), 0) << logText();
    EXPECT_LT(attitudeError(newest_), 0.1);
    return last;
  }
  // The samples that come before frame `k` and after those handed over.
  std::vector<sensor_msgs::ImuConstPtr> samplesUntil(int k) {
    std::vector<sensor_msgs::ImuConstPtr> samples;
    for (; next_ < exact_.imu.size() && exact_.imu[next_].t < exact_.truth[k].t; ++next_) {
      samples.push_back(messageOf(exact_.imu[next_]));
    }
    return samples;
  }
  // The same data, 1000 s earlier, after a reset.
  void playAgain() {
    next_ = 0;
    for (ImuSample& sample : exact_.imu) sample.t -= 1000.0;
    for (FrameObservation& observed : exact_.keyframes) observed.t -= 1000.0;
    for (NavState& state : exact_.truth) state.t -= 1000.0;
    host_.clearState();
    host_.setParameter();
  }
  // What the topic of the odometry frame said last: stamp, since when, sigmas.
  static std::vector<double> frameRow() {
    std::istringstream row(ros::published()["slim_init/frame"].back());
    std::vector<double> values;
    for (std::string cell; std::getline(row, cell, ',');) values.push_back(std::stod(cell));
    EXPECT_EQ(values.size(), 4u) << row.str();
    return values;
  }
  void stick(double from, double until, const Eigen::Vector3d& accel) {
    for (ImuSample& sample : exact_.imu) {
      if (sample.t > from && sample.t < until) sample.accel = accel;
    }
  }
  static sensor_msgs::ImuConstPtr messageOf(const ImuSample& sample) {
    sensor_msgs::Imu msg;
    msg.header.stamp.seconds = sample.t;
    msg.linear_acceleration = {sample.accel.x(), sample.accel.y(), sample.accel.z()};
    msg.angular_velocity = {sample.gyro.x(), sample.gyro.y(), sample.gyro.z()};
    return std::make_shared<const sensor_msgs::Imu>(msg);
  }
  void request(bool reset) {
    std_msgs::Bool message;
    message.data = reset;
    ros::callbacks<std_msgs::BoolConstPtr>().at("slim_init/recover")(
        std::make_shared<const std_msgs::Bool>(message));
  }
  std::string logText() const {
    std::string text;
    for (const std::string& line : ros::logged()) text += line + "\n";
    return text;
  }
  long timesLogged(const std::string& text) const {
    const std::vector<std::string>& lines = ros::logged();
    return std::count_if(lines.begin(), lines.end(),
                         [&text](const std::string& line) { return contains(line, text); });
  }
  std::vector<std::string> csv() const {
    std::ifstream in(folder_.file("slim_init_starts.csv"));
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }

  static CalibrationEstimate foundAs(const Calibration& right) {
    CalibrationEstimate found;
    found.R_b_c = right.R_b_c;
    found.t_b_c = right.t_b_c;
    found.td = right.td;
    const double rotation = 0.2 / 57.3, translation = 0.02, td = 0.001;
    found.covariance.diagonal() << Eigen::Vector3d::Constant(rotation * rotation),
        Eigen::Vector3d::Constant(translation * translation), td * td, 0.0;
    return found;
  }
  // A host with another calibration than the right one, which is found; the switches are those of
  // its file and of its globals. The stamps are `td` early. Returns the frame of the start.
  int startWithFinder(double td, double turn, bool estimate_td, int estimate_extrinsic,
                      bool reinit = false) {
    start("initializer: slim\n");
    for (FrameObservation& frame : exact_.keyframes) frame.t -= td;
    Calibration right = exact_.calibration, wrong = exact_.calibration;
    right.td = td;
    wrong.R_b_c = wrong.R_b_c * expSO3(Eigen::Vector3d(0.0, turn, 0.0));
    ESTIMATE_TD = estimate_td;
    ESTIMATE_EXTRINSIC = estimate_extrinsic;
    HostFile file;
    file.mode = HostMode::kSlim;
    file.rig.calibration = wrong;
    file.rig.has_rotation = estimate_extrinsic != 2;
    file.keep_heading = true;
    file.reinit = file.watchdog = reinit;
    HostOptions options;
    options.reinit = options.watchdog = reinit;
    options.estimate_td = estimate_td;
    options.estimate_extrinsic = estimate_extrinsic != 0;
    options.max_wait_ms = max_wait_ms_;
    auto finder = std::make_unique<Oracle>(exact_);
    finder_ = finder.get();
    finder->calibration = wrong;
    finder->then = [right](const Priors& priors, InitResult* result) {
      if (!priors.healthy.empty() && refuses_) {
        while (waits_) std::this_thread::yield();
        *result = InitResult();
        return;
      }
      result->calibration = foundAs(right);
      result->warnings = {"the right calibration was found"};
    };
    RIC[0] = wrong.R_b_c;
    TIC[0] = wrong.t_b_c;
    host_.setParameter();
    host_.slim_init_glue.open(adapterOf(std::move(finder), options), file);
    wrong_ = wrong.R_b_c;
    return frameUntilStarted() - 1;
  }

  const ScratchFolder folder_;
  ExactWindow exact_ = makeExactWindow(atTenHertz(60));
  Estimator& host_ = hostEstimator();
  Eigen::Matrix3d wrong_;
  double max_wait_ms_ = -1.0;
  static inline std::atomic<bool> refuses_{false}, waits_{false};  // solves of a recovery
  Oracle* finder_ = nullptr;
  std::size_t next_ = 0;
  int newest_ = 0;
};

#ifndef STAND_IN_PL_VINS  // has no td
// Where the host estimates its calibration, what was found is its starting value.
TEST_F(StandInRun, AFoundCalibrationGoesIntoTheHost) {
  const double td = 0.02;
  const int newest = startWithFinder(td, 0.05, true, 1);
  EXPECT_EQ(host_.td, td);
  EXPECT_LT((host_.ric[0] - exact_.calibration.R_b_c).norm(), 1e-12);
  EXPECT_EQ(host_.f_manager.ric, host_.ric[0]);
  // Also after a reset.
  host_.clearState();
  host_.setParameter();
  EXPECT_EQ(host_.td, td);
  EXPECT_EQ(host_.ric[0], exact_.calibration.R_b_c);
  EXPECT_EQ(ESTIMATE_EXTRINSIC, 1);

  EXPECT_EQ(timesLogged("warn: slim_init: the right calibration was found"), 1) << logText();
  EXPECT_EQ(timesLogged("extrinsicRotation: "), 0) << "one window is not enough for advice";
  EXPECT_EQ(timesLogged("keep_heading: 1"), 1) << "also with an adapter of the caller's own";
  EXPECT_GT(newest, 0);
}

// The frames of the window were paired with the IMU at the old td: their states are of that time.
TEST_F(StandInRun, StatesFitTheHostsPreintegrations) {
  const double td = 0.02;
  const int newest = startWithFinder(td, 0.0, true, 0);
  // The stand-in has slid once: frame i + 1 of the seed stands at i. Gravity in the body tells the
  // two instants apart: the exposure, and the stamp alone, td before it.
  double at_stamp = 0.0, at_exposure = 0.0;
  for (int i = 0; i < kNewest; ++i) {
    const int k = newest - kNewest + 1 + i;
    const Eigen::Matrix3d exposure = exact_.truth[k].R_w_b;
    const Eigen::Vector3d turn = logSO3(exact_.truth[k - 1].R_w_b.transpose() * exposure);
    const Eigen::Matrix3d stamp = exposure * expSO3(-turn * (td / 0.1));
    at_exposure += (host_.Rs[i].row(2) - exposure.row(2)).norm();
    at_stamp += (host_.Rs[i].row(2) - stamp.row(2)).norm();
  }
  EXPECT_LT(at_stamp, 0.3 * at_exposure);
}

TEST_F(StandInRun, AHostThatDoesNotEstimateItKeepsItsCalibration) {
  startWithFinder(0.02, 0.05, false, 0);
  EXPECT_EQ(host_.td, 0.0);
  EXPECT_EQ(TD, 0.0);
  EXPECT_LT((host_.ric[0] - wrong_).norm(), 1e-12);
  EXPECT_LT((RIC[0] - wrong_).norm(), 1e-12);
  EXPECT_EQ(ESTIMATE_EXTRINSIC, 0);
}

#endif  // STAND_IN_PL_VINS

TEST_F(StandInRun, AnUnknownExtrinsicIsKnownAfterTheSeed) {
  startWithFinder(0.0, 1.5, false, 2);
  EXPECT_EQ(ESTIMATE_EXTRINSIC, 1);
  EXPECT_LT((RIC[0] - exact_.calibration.R_b_c).norm(), 1e-12);
  EXPECT_LT((TIC[0] - exact_.calibration.t_b_c).norm(), 1e-12);
}

#if defined(STAND_IN_VINS_FUSION) || defined(STAND_IN_DYNAVINS)
// These hosts would triangulate a feature from its first two images.
TEST_F(StandInRun, DepthsComeFromAllViewsAtTheSeed) {
  start("initializer: slim\n");
  Feature& seen = host_.f_manager.feature.front();
  seen.feature_per_frame.resize(WINDOW_SIZE + 1);
  for (FeaturePerFrame& view : seen.feature_per_frame) view.point = Vector3d(0.1, 0.0, 1.0);
  frameUntilStarted();
  EXPECT_GT(seen.estimated_depth, 0.0);
  // Not seen in two images.
  EXPECT_EQ(host_.f_manager.feature.back().estimated_depth, -1.0);
  EXPECT_EQ(host_.f_manager.triangulations, 1);
}
#endif

TEST_F(StandInRun, SeedLandsInTheRightMembers) {
  start("initializer: slim\n");
  auto* prior = new MarginalizationInfo;
  host_.last_marginalization_info = prior;
  host_.last_marginalization_parameter_blocks.assign(3, nullptr);
  int k = frameUntilStarted();
  EXPECT_EQ(host_.stock_tries, 0);
  EXPECT_EQ(host_.optimizations, 1);
  EXPECT_LE(k, 14) << "1.3 s of excited data";
  // The stand-in has slid once: frame i + 1 of the seed stands at i.
  const int first = k - 1 - kNewest;
  const Eigen::Matrix3d R = expSO3(Eigen::Vector3d(0, 0, -hostYaw(exact_.truth[first].R_w_b)));
  for (int i = 0; i < kNewest; ++i) {
    const NavState& truth = exact_.truth[first + 1 + i];
    EXPECT_LT((host_.Ps[i] - R * (truth.p_w_b - exact_.truth[first].p_w_b)).norm(), 0.02) << i;
    EXPECT_LT((host_.Vs[i] - R * truth.v_w_b).norm(), 0.05) << i;
    EXPECT_LT(logSO3(host_.Rs[i].transpose() * R * truth.R_w_b).norm(), 0.01) << i;
    EXPECT_LT((host_.Bgs[i] - truth.gyro_bias).norm(), 5e-3) << i;
    EXPECT_EQ(host_.pre_integrations[i]->bg, host_.Bgs[i]);
    EXPECT_EQ(host_.pre_integrations[i]->ba, host_.Bas[i]);
  }
  EXPECT_EQ(host_.g, Vector3d(0, 0, 9.81007));
  EXPECT_LT((host_.ric[0] - exact_.calibration.R_b_c).norm(), 1e-6);
  EXPECT_LT((host_.tic[0] - exact_.calibration.t_b_c).norm(), 1e-6);
  EXPECT_EQ(host_.f_manager.ric, host_.ric[0]);
  for (const Feature& feature : host_.f_manager.feature) {
    EXPECT_EQ(feature.estimated_depth, -1.0);
    EXPECT_EQ(feature.solve_flag, 0);
  }
  EXPECT_EQ(host_.last_marginalization_info, nullptr);
  EXPECT_EQ(MarginalizationInfo::deleted(), 1);
  EXPECT_TRUE(host_.last_marginalization_parameter_blocks.empty());
  EXPECT_EQ(host_.last_P, host_.Ps[kNewest]);
  EXPECT_EQ(host_.last_R, host_.Rs[kNewest]);
  EXPECT_EQ(host_.last_P0, Vector3d(Vector3d::Zero()));
#if defined(STAND_IN_VINS_FUSION) || defined(STAND_IN_DYNAVINS)
  EXPECT_EQ(host_.f_manager.triangulations, 1);
#endif
  expectParts(logText(), "info: slim_init: seed done: ");
  EXPECT_EQ(timesLogged(kNoLines), 0);
  EXPECT_TRUE(ros::timers().empty()) << "without speed_topic the master is not asked";
  expectParts(csv().back(), ",slim,seed,success,");
  EXPECT_FALSE(ros::published()["slim_init/status"].empty());
}

// Members that only this host has: what they hold of the old states goes with them, after a start
// and after a recovery.
TEST_F(StandInRun, WhatOnlyThisHostHasStartsAnew) {
  start("initializer: slim\nreinit: 1\n");
  const auto age = [this] {
    host_.f_manager.feature.assign(5, Feature());  // whose values are those of an old one
#ifdef STAND_IN_PL_VINS
    host_.f_manager.linefeature.assign(3, FeatureManager::Line());
#endif
#ifdef STAND_IN_GVINS
    host_.first_optimization = false;
#endif
  };
  const auto is_new = [this] {
    for (const Feature& feature : host_.f_manager.feature) {
      EXPECT_EQ(feature.estimated_depth, -1.0);
#ifdef STAND_IN_DYNAVINS
      EXPECT_EQ(feature.weight, 1.0);
      EXPECT_EQ(feature.weightNum, 1);
#endif
#ifdef STAND_IN_LVI_SAM
      EXPECT_FALSE(feature.lidar_depth_flag);
#endif
    }
#ifdef STAND_IN_PL_VINS
    EXPECT_EQ(host_.f_manager.linefeature.size(), 3u);
    for (const FeatureManager::Line& line : host_.f_manager.linefeature) {
      EXPECT_FALSE(line.is_triangulation);
    }
#endif
#ifdef STAND_IN_GVINS
    EXPECT_TRUE(host_.first_optimization);
#endif
  };
  age();
  int k = fly(40);
  is_new();
  age();
  request(false);
  frame(k);
  expectParts(logText(), "recover done");
  is_new();
}

// Biases of a flight are there for the next start.
TEST_F(StandInRun, AStartAfterAResetKnowsTheSensors) {
  const int newest = startWithFinder(0.0, 0.0, false, 0, true);
  host_.Bas[kNewest] = Eigen::Vector3d(0.1, -0.2, 0.3);
  for (int i = 1; i <= 46; ++i) {  // 23 s
    setStamp(exact_.keyframes[newest].t + 0.5 * i, &host_.Headers[kNewest]);
    host_.slim_init_glue.optimized(
        host_, [] { return false; }, [] {});
  }
  EXPECT_FALSE(std::isfinite(finder_->known_sensors.biases.accel_sigma));
  host_.clearState();
  host_.setParameter();
  for (int k = newest + 1; k <= newest + 1 + kNewest; ++k) frame(k);
  EXPECT_EQ(finder_->known_sensors.biases.accel, Eigen::Vector3d(0.1, -0.2, 0.3));
}

#ifndef STAND_IN_GVINS  // keeps no yaw
// A body whose x axis points up has no Euler yaw to speak of. The host turned its window by
// whatever came out; keep_heading takes the turn that keeps the heading, also in a stock host.
TEST_F(StandInRun, KeepHeadingTurnsAboutTheVerticalOnly) {
  for (const bool asked : {false, true}) {
    start(asked ? "keep_heading: 1\n" : "");
    const Eigen::Matrix3d before = expSO3(Eigen::Vector3d(0, 0, 0.7)) *
                                   expSO3(Eigen::Vector3d(0, -88.0 / 57.3, 0)) *
                                   expSO3(Eigen::Vector3d(0.3, 0, 0));
    // An optimization tilts the window by half a degree and drifts by 5 deg in heading.
    const Eigen::Matrix3d tilt = expSO3(Eigen::Vector3d(0.006, -0.006, 0));
    const Eigen::Quaterniond optimized(expSO3(Eigen::Vector3d(0, 0, 0.09)) * tilt * before);
    host_.Rs[0] = before;
    for (auto& pose : host_.para_Pose) {
      pose[3] = optimized.x();
      pose[4] = optimized.y();
      pose[5] = optimized.z();
      pose[6] = optimized.w();
    }
    host_.host_turn = expSO3(Eigen::Vector3d(0, 0, 0.25));
    const auto is_kept = [&](const char* by) {
      const Eigen::Vector3d left = logSO3(before * host_.Rs[0].transpose());
      if (asked) {
        EXPECT_LT((host_.Rs[0] - tilt * before).norm(), 1e-4) << by;
        EXPECT_LT(std::abs(left.z()), 1e-4) << by;
        EXPECT_NEAR(left.norm(), 0.0085, 1e-4) << by;  // the tilt that was found stays
      } else {
        EXPECT_GT(std::abs(left.z()), 0.3) << by;
      }
    };
    host_.double2vector();
    is_kept("double2vector()");
#ifdef STAND_IN_PL_VINS  // its optimization with lines, which is the one in flight
    host_.Rs[0] = before;
    host_.double2vector2();
    is_kept("double2vector2()");
#endif
    EXPECT_EQ(timesLogged("keep_heading: 1"), asked ? 1 : 0);
    EXPECT_FALSE(host_.slim_init_glue.active());
  }
}
#endif

#ifdef STAND_IN_LVI_SAM
// Where lidar odometry covers the window the host starts from it, as always.
TEST_F(StandInRun, LidarOdometryComesFirst) {
  start("initializer: slim\n");
  lidar_reset_id = 3;
  int k = 0;
  for (; k < 20; ++k) frame(k);
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
  EXPECT_GT(host_.stock_tries, 0);
  EXPECT_EQ(timesLogged("seed"), 0) << logText();
  // One reset of the lidar odometry within the window, and it does not cover it.
  const int tries = host_.stock_tries;
  lidar_reset_id = 4;
  frame(k);
  EXPECT_EQ(host_.stock_tries, tries);
  EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR) << logText();
}
#endif

// Those that cannot be used are named once each.
TEST_F(StandInRun, SpeedsOfTheHostsFileReachTheInitializer) {
  start("initializer: slim\nspeed_topic: \"/wheel\"\nspeed_forward_only: 0\n" +
        matrixKey("speed_rotation", 3, 3, "1, 0, 0, 0, 1, 0, 0, 0, 1") +
        matrixKey("speed_translation", 3, 1, "0, 0, 0"));
  ASSERT_EQ(ros::timers().size(), 1u) << logText();
  const std::function<void()> look = ros::timers().front();
  look();  // nobody publishes yet
  ros::master::topics() = {{"/other", "std_msgs/Bool"}, {"/wheel", "nav_msgs/Odometry"}};
  look();
  EXPECT_TRUE(ros::timers().empty());
  const auto wheel = ros::callbacks<nav_msgs::Odometry>().at("/wheel");
  for (int k = 0; k < 30 && host_.solver_flag == Estimator::INITIAL; ++k) {
    const Eigen::Vector3d v = exact_.truth[k].R_w_b.transpose() * exact_.truth[k].v_w_b;
    nav_msgs::Odometry message;
    message.header.stamp.seconds = exact_.truth[k].t;
    message.twist.twist.linear = {v.x(), v.y(), v.z()};
    for (int i = 0; i < 3; ++i) message.twist.covariance[7 * i] = 1e-4;
    wheel(message);
    if (k == 3) {
      wheel(message);  // once more
      message.header.stamp.seconds += 0.01;
      message.twist.covariance.fill(0.0);
      wheel(message);
      wheel(message);
    }
    frame(k);
  }
  EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR) << logText();
  EXPECT_EQ(timesLogged("a measured velocity of"), 2) << logText();
  EXPECT_EQ(timesLogged("velocities (late)"), 1) << logText();
  EXPECT_EQ(timesLogged("its stamp is not after that of the velocity before it"), 1) << logText();
  EXPECT_EQ(timesLogged("its covariance is not positive definite"), 1) << logText();
}

// A glitch of the IMU during the first second costs nothing and is reported once, with the bounds
// of the file.
TEST_F(StandInRun, ImuGlitchesAreDropped) {
  start("initializer: slim\n", "  imu: {max_accel: 300.0, max_gyro: 2.5}\n");
  for (const double t : {0.52, 0.71}) {
    for (ImuSample& sample : exact_.imu) {
      if (std::abs(sample.t - exact_.imu[0].t - t) < 0.008) sample.accel.y() += 400.0;
    }
  }
  const int k = frameUntilStarted();
  EXPECT_LE(k, 14) << "1.3 s of excited data";
  EXPECT_EQ(timesLogged("warn: slim_init: an IMU sample of 4"), 1) << logText();
  EXPECT_EQ(timesLogged("on an axis (limits 300 m/s^2, 2.5 rad/s) is discarded"), 1) << logText();
  EXPECT_EQ(timesLogged("warn: slim_init: discarded: 3 IMU samples (glitch)"), 1) << logText();
}

TEST_F(StandInRun, StockIsUntouched) {
  start("");
  for (int k = 0; k < 20; ++k) frame(k);
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
  EXPECT_GT(host_.stock_tries, 0);
  EXPECT_TRUE(ros::callbacks<sensor_msgs::PointCloudConstPtr>().empty());
  EXPECT_TRUE(ros::callbacks<std_msgs::BoolConstPtr>().empty());
  EXPECT_EQ(logText(), "");
  EXPECT_TRUE(csv().empty());
  EXPECT_FALSE(host_.slim_init_glue.active());
}

TEST_F(StandInRun, ShadowOnlyWatches) {
  start("initializer: shadow\nreinit: 1\n");
  for (int k = 0; k < 25; ++k) {
    host_.stock_succeeds = k == 24;
    frame(k, false);
    EXPECT_EQ(timesLogged(kNoLines), k < kNewest ? 0 : 1) << k;
    EXPECT_EQ(host_.Ps[0], Vector3d(Vector3d::Zero()));
  }
  EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR);
  EXPECT_EQ(host_.Bgs[3], Vector3d(Vector3d::Zero()));
  const std::vector<std::string> rows = csv();
  ASSERT_EQ(rows.size(), 1u + 25 - kNewest);  // from the first full window on
  EXPECT_EQ(rows[0].find("stamp_s,data_s,mode,action,slim_status"), 0u);
  expectParts(rows.back(), ",shadow,seed,success,");
  const std::vector<std::string>& topic = ros::published()["slim_init/status"];
  EXPECT_EQ(std::count(topic.begin(), topic.end(), rows.back()), 1);
  expectParts(logText(), "no effect with initializer: shadow");
}

TEST_F(StandInRun, FailureIsRecoveredInTheOldFrame) {
  int k = startAndFly(40);
  const int resets = host_.resets;
  host_.f_manager.feature.front().estimated_depth = 3.0;
  // As if refined in flight.
  const Matrix3d refined = host_.ric[0] * Eigen::AngleAxisd(1e-4, Vector3d::UnitX()).matrix();
  host_.ric[0] = refined;
  host_.fails = 1;
  frame(k);
  EXPECT_EQ(host_.resets, resets);
  EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR);
  EXPECT_LT(positionError(k), 0.05);
  EXPECT_LT(velocityError(k), 0.05);
  EXPECT_LT(attitudeError(k), 0.01);
  EXPECT_EQ(host_.f_manager.feature.front().estimated_depth, -1.0) << logText();
  EXPECT_EQ(host_.ric[0], refined);
  expectParts(logText(), "recover done");
  // Still failing after it: the host's own reset, and the next start joins the old frame.
  host_.fails = 2;
  trackedFrame(++k);
  EXPECT_EQ(host_.resets, resets + 1);
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
  k = frameUntilStarted(k + 1, 59);
  EXPECT_LT(positionError(k - 1), 0.05);
  expectParts(logText(), "join done");
}

// A camera that was silent for a second: the tracker restarts the host, from frame `k` to `last`.
// The samples since the last image are in the node's queue, which the restart empties.
TEST_F(StandInRun, ARestartOfTheTrackerIsJoined) {
  int k = startAndFly(30);
  // Less than a second: not a gap that the host's tracker restarts after.
  restart(samplesUntil(k + 4));
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
  k = frameUntilStarted(k + 5, 59);
  EXPECT_LT(positionError(k - 1), 0.1);
  EXPECT_LT(attitudeError(k - 1), 0.02);
  EXPECT_EQ(timesLogged("the odometry frame is continued"), 1) << logText();
  EXPECT_EQ(timesLogged("by the IMU, standard deviation"), 1);
  // Since the first start, with what the gap has cost.
  EXPECT_LT(frameRow().at(1), exact_.keyframes[30].t);
  EXPECT_GT(frameRow().at(2), 0.01);
  EXPECT_LT(frameRow().at(2), 1.0);
  EXPECT_EQ(timesLogged("the odometry frame is uncertain"), 0) << logText();
}

// VINS-Fusion and DynaVINS track their images themselves.
#if !defined(STAND_IN_VINS_FUSION) && !defined(STAND_IN_DYNAVINS)
TEST_F(StandInRun, FeaturesThatWaitAreADelayOfTheOdometry) {
  const int k = startAndFly(30);
  EXPECT_EQ(timesLogged("behind the newest image"), 0) << logText();
  sensor_msgs::PointCloud features;
  features.header.stamp.seconds = exact_.keyframes[k].t + 0.5;
  for (const auto& [topic, callback] : ros::callbacks<sensor_msgs::PointCloudConstPtr>()) {
    if (topic.find("lines") != std::string::npos) continue;
    callback(std::make_shared<const sensor_msgs::PointCloud>(features));
  }
  frame(k);
  EXPECT_EQ(timesLogged("odometry is 0.5 s behind the newest image (limit 0.3)"), 1) << logText();
}
#endif

// Hosts without a restart of the tracker have no insertion there.
#if !defined(STAND_IN_VINS_FUSION) && !defined(STAND_IN_DYNAVINS) && !defined(STAND_IN_PL_VINS)
// A gap of a second and more with all its IMU samples is no reason to start anew.
TEST_F(StandInRun, AGapInTheImagesIsRiddenThrough) {
  int k = startAndFly(29);
  host_.slim_init_glue.imuRefused(exact_.imu.front().t);  // one incorrect stamp
  frame(k);
  track(++k);
  const std::vector<sensor_msgs::ImuConstPtr> gap = samplesUntil(k + 11);
  const int resets = host_.resets;
  restart(gap);
  EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR) << logText();
  EXPECT_EQ(host_.resets, resets);
  EXPECT_EQ(timesLogged("continues by its IMU"), 1) << logText();
  // A second and more of flight is no jump. The samples have waited for the frame.
  next_ -= gap.size();
  track(k + 11);
  const Vector3d before_gap = host_.last_P, after_gap = host_.Ps[kNewest];
  frame(k + 11);
  EXPECT_EQ(host_.compared_to, after_gap);
  EXPECT_NE(host_.compared_to, before_gap);
  trackedFrame(k + 12);
  EXPECT_EQ(host_.compared_to, after_gap) << "one frame later it looks again";
}

// The other sides: the IMU was silent as well, or time has gone back, which shows in the samples
// that the host refuses and not in those that wait.
TEST_F(StandInRun, AGapWithoutImuIsNotRiddenThrough) {
  std::vector<sensor_msgs::ImuConstPtr> gap = samplesUntil(startAndFly(30) + 11);
  const auto middle = gap.begin() + static_cast<std::ptrdiff_t>(gap.size() / 2);
  gap.erase(middle, middle + static_cast<std::ptrdiff_t>(gap.size() / 4));
  restart(gap);
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL) << logText();
}

TEST_F(StandInRun, ABagThatStartsAgainIsNoGap) {
  std::vector<sensor_msgs::ImuConstPtr> gap = samplesUntil(startAndFly(30) + 11);
  sensor_msgs::Imu first = *gap.front();
  first.header.stamp.seconds -= 2.0;
  gap.push_back(std::make_shared<const sensor_msgs::Imu>(first));
  restart(gap);
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL) << logText();
}
#endif

// The IMU is whole: the heading is known for longer than its samples are kept. The position is held
// when the body may have gone no further than the IMU is incorrect.
TEST_F(StandInRun, ALongTimeWithoutAStartKeepsTheHeading) {
  longTimeWithoutAStart(150);
  EXPECT_EQ(timesLogged("the position is held"), 0) << logText();
  EXPECT_LT(positionError(newest_), 5.0);
}
TEST_F(StandInRun, AVeryLongTimeHoldsThePosition) {
  const Vector3d last = longTimeWithoutAStart(400);
  EXPECT_EQ(timesLogged("the position is held"), 1) << logText();
  EXPECT_LT((host_.Ps[0] - last).norm(), 3.0);
}

// The other side: without the samples of that second nobody knows where the body went. The world
// does not turn all the same.
TEST_F(StandInRun, WithoutImuDataPoseAndHeadingStay) {
  int k = startAndFly(30);
  const Vector3d last = host_.last_P;
  samplesUntil(k + 9);
  restart({});
  k = frameUntilStarted(k + 10, 59);
  EXPECT_EQ(timesLogged("the odometry frame is continued"), 1) << logText();
  EXPECT_EQ(timesLogged("the odometry frame is uncertain"), 1) << logText();
  EXPECT_LT((host_.Ps[0] - last).norm(), 3.0);
  const Matrix3d turn = host_.Rs[0] * exact_.truth[k - 1 - kNewest].R_w_b.transpose();
  EXPECT_LT(logSO3(turn).norm(), 1.2) << "what the body has turned in that second";
}

TEST_F(StandInRun, TheHostsOwnStartJoinsToo) {
  start("initializer: stock\nreinit: 1\nwatchdog: 1\n");
  host_.stock_succeeds = true;
  int k = fly(30);
  EXPECT_EQ(timesLogged("the odometry frame"), 0);
  restart(samplesUntil(k + 4));
  for (k += 5; k < 59 && host_.solver_flag == Estimator::INITIAL; ++k) {
    track(k);
    for (Vector3d& position : host_.Ps) position.x() += 20.0;  // its own world
    exact_.keyframes[k].points.clear();                        // the watchdog finds nothing
    frame(k);
  }
  EXPECT_LT((host_.Ps[0] - exact_.truth[k - 1 - kNewest].p_w_b).norm(), 0.2) << logText();
  EXPECT_EQ(timesLogged("the odometry frame is continued"), 1) << logText();
  host_.slim_init_glue.optimized(
      host_, [] { return false; }, [] {});
  expectParts(ros::published()["slim_init/health"].back(), ",suspect,|,\"\"");
}

TEST_F(StandInRun, TheWatchdogRecoversAHostThatDoesNotNotice) {
  int k = startAndFly(45);
  // No false alarm so far, and a report once a second.
  EXPECT_EQ(timesLogged("watchdog: the host"), 0) << logText();
  EXPECT_GE(ros::published()["slim_init/health"].size(), 3u);
  const int resets = host_.resets;
  host_.Vs[kNewest] += Vector3d(3, 0, 0);
  frame(k);
  EXPECT_EQ(host_.resets, resets);
  EXPECT_EQ(timesLogged("watchdog: the host's states are inconsistent: velocity"), 1) << logText();
  EXPECT_LT(velocityError(k), 0.05);
  EXPECT_LT(positionError(k), 0.05);
}

// Its interval of a damaged IMU, its states and its reset are its own.
TEST_F(StandInRun, WithoutReinitTheHostIsOnlyWatched) {
  start("initializer: stock\nreinit: 0\nwatchdog: 1\n");
  host_.stock_succeeds = true;
  stick(exact_.truth[30].t + 0.03, exact_.truth[31].t, {120, 0, 0});
  int k = fly(30);
  const Vector3d wrong = host_.Vs[kNewest] += Vector3d(3, 0, 0);
  frame(k);
  EXPECT_EQ(timesLogged("watchdog: the host's states are inconsistent: velocity"), 1) << logText();
  EXPECT_EQ(host_.Vs[kNewest], wrong);
  track(++k);
  IntegrationBase* const own = host_.pre_integrations[kNewest];
  const Vector3d predicted = host_.Vs[kNewest] += Vector3d(12, 0, 0);
  const int resets = host_.resets;
  frame(k);
  EXPECT_EQ(host_.Vs[kNewest], predicted);
  EXPECT_EQ(host_.pre_integrations[kNewest], own);
  EXPECT_EQ(host_.resets, resets);
  host_.fails = 1;
  frame(++k);
  EXPECT_EQ(host_.resets, resets + 1);
  k = frameUntilStarted(k + 1, 59);
  trackedFrame(k);
  const std::string& health = ros::published()["slim_init/health"].back();
  EXPECT_FALSE(contains(health, ",wrong,")) << "that was before the reset: " << health;
  request(true);
  expectParts(logText(), "set reinit: 1");
}

TEST_F(StandInRun, WithoutWatchdogNobodyLooks) {
  exact_ = makeExactWindow(atTenHertz(75));
  start("initializer: slim\nreinit: 1\nwatchdog: 0\n");
  int k = fly(45);
  const Vector3d wrong = host_.Vs[kNewest] += Vector3d(3, 0, 0);
  frame(k);
  EXPECT_EQ(timesLogged("watchdog: the host"), 0) << logText();
  EXPECT_EQ(host_.Vs[kNewest], wrong);
  EXPECT_EQ(ros::published().count("slim_init/health"), 0u);
  // Not at what no start could continue either.
  while (++k < 50) {
    for (Vector3d& velocity : host_.Vs) velocity.setConstant(kNotComputed);
    frame(k);
  }
  host_.clearState();
  host_.setParameter();
  frameUntilStarted(k, 75);
}

TEST_F(StandInRun, AFailureBeforeTheFirstHealthyStateIsReportedOnce) {
  start("initializer: slim\nreinit: 1\n");
  const int first = frameUntilStarted();
  for (int k = first; k < first + 10; ++k) {
    track(k);
    host_.Vs[kNewest] += Vector3d(3, 0, 0);
    frame(k);
  }
  EXPECT_EQ(timesLogged("recover: the host has had no healthy state yet"), 1) << logText();
}

// An accelerometer that is stuck at its end: the host integrates it and would believe it.
TEST_F(StandInRun, ImuDamageDoesNotReachTheHost) {
  start("initializer: slim\nreinit: 1\n");
  stick(exact_.truth[41].t + 0.03, exact_.truth[41].t + 0.43, {120, 0, 0});
  const int first = fly(42);
  ASSERT_EQ(timesLogged("relying on vision"), 0) << logText();
  for (int k = first; k < first + 4; ++k) {
    host_.Vs[kNewest] += Vector3d(12, 0, 0);  // what the host makes of it
    frame(k);
    EXPECT_LT(velocityError(k), 0.5) << k << logText();
    EXPECT_LT(positionError(k), 0.1) << k;
    expectReplaced(*host_.pre_integrations[kNewest]);
    track(k + 1);
  }
  EXPECT_EQ(timesLogged("relying on vision"), 1) << logText();
  EXPECT_EQ(timesLogged("recover"), 0) << logText();
}

// A host that hovers keeps its first window for long: a recovery finds what was known of it.
TEST_F(StandInRun, TheFirstWindowIsRemembered) {
  start("initializer: slim\nreinit: 1\n");
  host_.next_flag = Estimator::MARGIN_OLD;
  int k = frameUntilStarted();
  trackedFrame(k);
  // From here on only the newest frame is exchanged.
  host_.next_flag = Estimator::MARGIN_SECOND_NEW;
  const double oldest = glue_detail::stampOf(host_.Headers[0]);
  const Vector3d P = host_.Ps[0];
  for (++k; k < 59; ++k) trackedFrame(k);
  ASSERT_EQ(glue_detail::stampOf(host_.Headers[0]), oldest);
  for (int i = 0; i <= kNewest; ++i) host_.Ps[i] += Vector3d(30, 0, 0);
  host_.fails = 1;
  trackedFrame(k);
  ASSERT_EQ(timesLogged("recover done"), 1) << logText();
  EXPECT_EQ(host_.Ps[0], P);
}

// A glitch in the host's window would throw off the optimization that follows a recovery.
TEST_F(StandInRun, TheHostGetsCleanDataWithARecovery) {
  start("initializer: slim\nreinit: 1\n");
  for (ImuSample& sample : exact_.imu) {
    const double since = sample.t - exact_.truth[36].t;
    if (since > 0.03 && since < 0.055) sample.accel.x() += 100.0;
  }
  int k = fly(40);
  IntegrationBase* const untouched = host_.pre_integrations[2];
  host_.fails = 1;
  frame(k);
  ASSERT_EQ(timesLogged("recover done"), 1) << logText();
  // The window slides after it, the integrations of the stand-in do not: frame 37 is number 7.
  const IntegrationBase& clean = *host_.pre_integrations[7];
  ASSERT_GT(clean.accel.size(), 10u);
  expectReplaced(clean);
  EXPECT_EQ(host_.dt_buf[7].size() + 1, clean.accel.size());
  EXPECT_EQ(host_.linear_acceleration_buf[7].size(), host_.dt_buf[7].size());
  EXPECT_EQ(host_.angular_velocity_buf[7].size(), host_.dt_buf[7].size());
  EXPECT_EQ(host_.pre_integrations[2], untouched);
  EXPECT_TRUE(untouched->accel.empty());
}

TEST_F(StandInRun, RequestsAreServedWithTheNextFrame) {
  int k = startAndFly(40);
  const int resets = host_.resets;
  request(false);
  host_.Ps[kNewest] += Vector3d(100, 0, 0);  // a wrong state
  frame(k);
  EXPECT_LT(positionError(k), 0.05) << logText();
  EXPECT_EQ(host_.resets, resets);
  // Twenty frames later without a point: refused. The host goes on or resets, as requested.
  for (FrameObservation& observed : exact_.keyframes) {
    observed.points.clear();
    observed.lines.clear();
  }
  for (++k; k < 58; ++k) {
    frame(k);
    track(k + 1);
  }
  request(false);
  frame(k++);
  EXPECT_EQ(host_.resets, resets);
  EXPECT_EQ(host_.solver_flag, Estimator::NON_LINEAR);
  request(true);
  frame(k);
  EXPECT_EQ(host_.resets, resets + 1) << logText();
}

// An initializer may ignore what was known before the reset: the host starts all the same, in the
// frame of before.
TEST_F(StandInRun, AStartWithoutARecoveryContinuesTheFrame) {
  int k = startWithFinder(0.0, 0.0, false, 0, true) + 1;
  for (const int end = k + 12; k < end; ++k) trackedFrame(k);
  finder_->recovers = false;
  restart(samplesUntil(k + 2));
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
  k = frameUntilStarted(k + 3, 59);
  EXPECT_LT(positionError(k - 1), 0.2) << logText();
  EXPECT_LT(attitudeError(k - 1), 0.05);
  EXPECT_EQ(timesLogged("the odometry frame is continued"), 1) << logText();
}

// The last healthy states fill the window while the solve runs: a request is not served by that.
TEST_F(StandInRun, ARequestOutlastsASolveThatRuns) {
  max_wait_ms_ = 300.0;
  int k = startWithFinder(0.0, 0.0, false, 0, true) + 1;
  const auto fail = [&] {
    track(k);
    host_.Vs[kNewest] += Vector3d(3, 0, 0);
    frame(k++);
    return host_.resets;
  };
  for (const int end = k + 20; k < end; ++k) trackedFrame(k);
  const int resets = host_.resets;
  refuses_ = waits_ = true;
  EXPECT_EQ(fail(), resets);
  EXPECT_EQ(timesLogged("watchdog: the host's states are inconsistent"), 1) << logText();
  request(true);
  EXPECT_EQ(fail(), resets) << logText();
  waits_ = false;
  EXPECT_EQ(fail(), resets + 1) << logText();
}

// Nothing of the flight before speaks of the next one: times, a request, how well the frame is
// known.
TEST_F(StandInRun, ABagPlayedAgainIsAFlightOfItsOwn) {
  startAndFly(40);
  request(true);
  playAgain();
  const int resets = host_.resets;
  const std::size_t reports = ros::published()["slim_init/health"].size();
  fly(50);
  EXPECT_EQ(host_.resets, resets) << logText();
  EXPECT_GE(ros::published()["slim_init/health"].size(), reports + 3);
  EXPECT_LT(frameRow().at(1), exact_.truth[20].t);
}

TEST_F(StandInRun, AStockStartBeginsAFrameToo) {
  start("initializer: stock\nreinit: 0\nwatchdog: 1\n");
  host_.stock_succeeds = true;
  fly(30);
  playAgain();
  host_.initial_timestamp = exact_.keyframes.front().t;
  fly(30);
  EXPECT_LT(frameRow().at(1), exact_.truth[20].t);
}

TEST_F(StandInRun, AtRestTheOldestFramesGo) {
  start("initializer: slim\n");
  // The host sees no parallax and keeps its oldest frames; the adapter declines.
  for (FrameObservation& observed : exact_.keyframes) observed.points.clear();
  host_.next_flag = Estimator::MARGIN_SECOND_NEW;
  for (int k = 0; k < 59; ++k) frame(k, false);
  EXPECT_EQ(host_.solver_flag, Estimator::INITIAL);
  const double oldest = exact_.keyframes[58].t - glue_detail::stampOf(host_.Headers[0]);
  EXPECT_LT(oldest, 3.2) << "the span of a full window and a frame";
  EXPECT_EQ(timesLogged(kNoLines), 1);
}

TEST_F(StandInRun, ABrokenFileLeavesTheHostStock) {
  start("initializer: fast\n");
  EXPECT_FALSE(host_.slim_init_glue.active());
  expectParts(logText(),
              "error: slim_init: |initializer is \"fast\", must be stock, slim or shadow; the host "
              "initializes by itself");
  for (int k = 0; k < 15; ++k) frame(k);
  EXPECT_GT(host_.stock_tries, 0);
}

}  // namespace
}  // namespace slim_init::vins_adapter
