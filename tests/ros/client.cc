// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Talks to the running nodes as a user's program would: init.test, loop.test.
#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/Bool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <xmlrpcpp/XmlRpc.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "slim_init/evaluation/image_sequence.h"
#include "slim_init/evaluation/metrics.h"
#include "slim_init/evaluation/sequence_writer.h"
#include "slim_init/ros/conversions.h"
#include "slim_init/ros/stream_monitor.h"
#include "support/csv.h"
#include "tools/run_program.h"

namespace slim_init::node {
namespace {

// Bound on the wait for anything; generous, because the machine may be busy.
constexpr double kPatience = 60.0;  // [s]

/// What the nodes have said so far.
class Listener {
 public:
  Listener() {
    subscribe<InitStatusMessage>("/slim_init/status", &statuses);
    subscribe<InitResultMessage>("/slim_init/result", &results);
    subscribe<nav_msgs::Odometry>("/slim_init/odometry", &seeds);
    subscribe<nav_msgs::Path>("/slim_init/path", &paths);
    subscribe<tf2_msgs::TFMessage>("/tf_static", &frames);
    subscribe<std_msgs::Bool>("/feature_tracker/restart", &restarts);
    subscribe<sensor_msgs::PointCloud>("/feature_tracker/feature", &features);
    subscribe<sensor_msgs::PointCloud>("/feature_tracker_lines/lines", &lines);
    diagnostics_ = handle.subscribe<diagnostic_msgs::DiagnosticArray>(
        "/diagnostics", 100, [this](const diagnostic_msgs::DiagnosticArray::ConstPtr& message) {
          for (const auto& status : message->status) {
            for (const auto& value : status.values) {
              values_[status.name + "/" + value.key] = value.value;
            }
            ++reports_;
          }
        });
  }

  /// Until `done`; false when patience ends.
  bool wait(const std::function<bool()>& done, double patience = kPatience) {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(patience);
    while (ros::ok() && ros::WallTime::now() < end) {
      ros::spinOnce();
      if (done()) return true;
      ros::WallDuration(0.01).sleep();
    }
    return false;
  }

  /// A value of the diagnostics, NaN where it has not been said.
  double value(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::numeric_limits<double>::quiet_NaN()
                                  : std::atof(found->second.c_str());
  }
  /// After both nodes have reported anew.
  double fresh(const std::string& name) {
    const int before = reports_;
    EXPECT_TRUE(wait([&] { return reports_ >= before + 8; })) << "no diagnostics";
    return value(name);
  }

  ros::NodeHandle handle;
  std::vector<InitStatusMessage> statuses;
  std::vector<InitResultMessage> results;
  std::vector<nav_msgs::Odometry> seeds;
  std::vector<nav_msgs::Path> paths;
  std::vector<tf2_msgs::TFMessage> frames;
  std::vector<std_msgs::Bool> restarts;
  std::vector<sensor_msgs::PointCloud> features, lines;

 private:
  template <typename Message>
  void subscribe(const std::string& topic, std::vector<Message>* list) {
    subscribers_.push_back(handle.subscribe<Message>(
        topic, 1000,
        [list](const boost::shared_ptr<const Message>& message) { list->push_back(*message); }));
  }

  std::vector<ros::Subscriber> subscribers_;
  ros::Subscriber diagnostics_;
  std::map<std::string, std::string> values_;
  int reports_ = 0;
};

std::string parameter(const std::string& name) {
  std::string value;
  EXPECT_TRUE(ros::param::get("~" + name, value)) << name;
  return value;
}

/// s of truth = s R estimate + t over the keyframes of a result.
double scaleOf(const InitResultMessage& result, const std::string& bag) {
  evaluation::ReadStatus status;
  const auto sequence = evaluation::openRosbag(bag, evaluation::BagTopics(),
                                               evaluation::groundtruthFileOf(bag), 0.05, &status);
  if (sequence == nullptr) {
    ADD_FAILURE() << status.message;
    return kNotComputed;
  }
  std::vector<Eigen::Vector3d> estimate, truth;
  for (std::size_t k = 0; k < result.stamps.size(); ++k) {
    const double t = 1e-9 * static_cast<double>(stampNs(result.stamps[k]) - sequence->t0_ns);
    const auto& p = result.poses[k].position;
    for (const NavState& state : sequence->truth) {
      if (std::abs(state.t - t) > 1e-6) continue;
      estimate.emplace_back(p.x, p.y, p.z);
      truth.push_back(state.p_w_b);
    }
  }
  EXPECT_EQ(estimate.size(), result.stamps.size()) << "keyframes without truth";
  evaluation::Similarity similarity;
  EXPECT_EQ(evaluation::alignSimilarity(estimate, truth, &similarity), "");
  return similarity.s;
}

/// Waits until both nodes listen to the sensors, then plays the bag once.
void play(Listener* listener, const std::string& bag) {
  ros::Publisher imu = listener->handle.advertise<sensor_msgs::Imu>("/imu0", 1);
  ros::Publisher image = listener->handle.advertise<sensor_msgs::Image>("/cam0/image_raw", 1);
  ASSERT_TRUE(listener->wait([&] {
    return imu.getNumSubscribers() >= 2 && image.getNumSubscribers() >= 1;
  })) << "the nodes do not listen";
  imu.shutdown();
  image.shutdown();
  const std::string command =
      "rosbag play --clock --hz=100 --quiet --wait-for-subscribers --delay=1 '" + bag + "' &";
  ASSERT_EQ(std::system(command.c_str()), 0);
}

class Init : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    listener_ = new Listener;
    bag_ = new std::string(parameter("bag"));
    play(listener_, *bag_);
    listener_->wait([] { return !listener_->results.empty(); });
    listener_->wait([] { return listener_->features.size() >= 70; }, 10.0);
  }
  static void TearDownTestSuite() {
    delete listener_;
    delete bag_;
  }
  void SetUp() override {
    ASSERT_FALSE(listener_->results.empty())
        << "no result after " << listener_->features.size() << " images with points, "
        << listener_->statuses.size() << " attempts";
  }

  static Listener* listener_;
  static std::string* bag_;
};
Listener* Init::listener_ = nullptr;
std::string* Init::bag_ = nullptr;

TEST_F(Init, ComesWithinThreeSecondsWithTheRightScale) {
  ASSERT_EQ(listener_->results.size(), 1u);
  const InitResultMessage& result = listener_->results.front();
  ASSERT_EQ(result.stamps.size(), 10u);
  ASSERT_FALSE(listener_->features.empty());
  // The motion is excited from its first image on.
  EXPECT_LE((result.header.stamp - listener_->features.front().header.stamp).toSec(), 3.0);
  EXPECT_NEAR(scaleOf(result, *bag_), 1.0, 0.1);
  EXPECT_NEAR(result.gravity.z, -9.81007, 1e-9);
  EXPECT_EQ(result.covariance.size(), 96u * 96u);
  EXPECT_EQ(result.header.frame_id, "world");
}

TEST_F(Init, IsWhatTheProgramComputesForThatWindow) {
  ASSERT_FALSE(listener_->results.empty());
  const InitResultMessage& result = listener_->results.front();
  const ScratchFolder folder;
  const ProgramRun run =
      runProgram(folder, {"ab", "--bag", *bag_, "--config", parameter("config"), "--methods",
                          "slim", "--stride", "1", "--quiet", "--out", folder.file("ab")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::map<std::string, std::string> window;  // the one of the result
  for (const auto& row : csvRows(readFile(folder.file("ab/windows.csv")))) {
    if (row.at("t_start_ns") == std::to_string(stampNs(result.stamps.front()))) window = row;
  }
  EXPECT_EQ(window["status"], "success");
  EXPECT_EQ(window["keyframes"], "10");
  const double scale = std::atof(window["scale"].c_str());
  // The features went through messages of 32-bit floats.
  EXPECT_NEAR(scaleOf(result, *bag_), scale, 1e-3);
  EXPECT_NEAR(result.scale_sigma, std::atof(window["scale_sigma"].c_str()), 1e-4);
  EXPECT_EQ(std::to_string(result.status.point_tracks), window["point_tracks"]);
  EXPECT_EQ(std::to_string(result.status.line_tracks), window["line_tracks"]);
}

TEST_F(Init, EveryAttemptHasAStatusAndTheSeedAgrees) {
  ASSERT_FALSE(listener_->results.empty());
  const InitResultMessage& result = listener_->results.front();
  ASSERT_FALSE(listener_->statuses.empty());
  for (std::size_t i = 0; i < listener_->statuses.size(); ++i) {
    const InitStatusMessage& status = listener_->statuses[i];
    EXPECT_EQ(status.attempt, i + 1);
    EXPECT_FALSE(status.message.empty());
    EXPECT_EQ(status.status_name, toString(static_cast<slim_init::InitStatus>(status.status)));
  }
  EXPECT_EQ(listener_->statuses.back().status, InitStatusMessage::SUCCESS);
  EXPECT_EQ(result.status.attempt, listener_->statuses.back().attempt);
  EXPECT_FALSE(result.status.gates.empty());
  EXPECT_FALSE(result.status.stages.empty());

  ASSERT_EQ(listener_->seeds.size(), 1u);
  EXPECT_EQ(listener_->seeds[0].header.stamp, result.stamps.back());
  EXPECT_EQ(listener_->seeds[0].pose.pose.position.x, result.poses.back().position.x);
  EXPECT_GT(listener_->seeds[0].pose.covariance[0], 0.0);
  ASSERT_EQ(listener_->paths.size(), 1u);
  EXPECT_EQ(listener_->paths[0].poses.size(), 10u);

  // The camera is where the states were estimated with it, close to the configuration's.
  ASSERT_TRUE(listener_->wait([&] { return !listener_->frames.empty(); }));
  ASSERT_EQ(listener_->frames.back().transforms.size(), 2u);
  const geometry_msgs::TransformStamped& camera = listener_->frames.back().transforms[1];
  EXPECT_EQ(camera.child_frame_id, "camera");
  EXPECT_EQ(camera.transform.translation.x, result.extrinsic.translation.x);
  EXPECT_EQ(camera.transform.rotation.w, result.extrinsic.rotation.w);
  EXPECT_NE(result.extrinsic.translation.x, -0.0216401454975);
  EXPECT_NEAR(result.extrinsic.translation.x, -0.0216401454975, 0.02);
}

TEST_F(Init, NothingIsLostAndEveryFrameHasItsLines) {
  // 71 images, of which the first is not published.
  EXPECT_EQ(listener_->features.size(), 70u);
  ASSERT_EQ(listener_->lines.size(), listener_->features.size());
  for (std::size_t i = 0; i < listener_->lines.size(); ++i) {
    EXPECT_EQ(listener_->lines[i].header.stamp, listener_->features[i].header.stamp);
  }
  EXPECT_EQ(listener_->fresh("slim_init: streams/imu discarded: malformed"), 0);
  for (const char* name :
       {"slim_init: streams/imu lost", "slim_init: streams/feature lost",
        "slim_init: streams/imu discarded: late",
        "slim_init: streams/line discarded: without frame",
        "feature_tracker_lines: streams/image lost", "feature_tracker_lines: streams/imu lost",
        "feature_tracker_lines: tracking/images discarded: queue full",
        "feature_tracker_lines: tracking/images tracked without IMU",
        "feature_tracker_lines: tracking/time jumps"}) {
    EXPECT_EQ(listener_->value(name), 0) << name;
  }
  EXPECT_EQ(listener_->value("feature_tracker_lines: tracking/images tracked"), 71);
}

TEST_F(Init, TheServiceInitializesAgain) {
  const std::size_t before = listener_->statuses.size();
  std_srvs::Trigger trigger;
  ASSERT_TRUE(ros::service::call("/slim_init/initialize", trigger));
  EXPECT_FALSE(trigger.response.message.empty());
  ASSERT_TRUE(listener_->wait([&] { return listener_->statuses.size() > before; }));
  const InitStatusMessage& status = listener_->statuses.back();
  EXPECT_TRUE(status.requested);
  EXPECT_EQ(trigger.response.success, status.status == InitStatusMessage::SUCCESS);
  EXPECT_EQ(trigger.response.message, status.status_name + ": " + status.message);
  // From the newest window now, not from that of the first answer.
  EXPECT_GT(status.header.stamp, listener_->results.front().header.stamp);
  if (trigger.response.success) {
    ASSERT_TRUE(listener_->wait([&] { return listener_->results.size() == 2; }));
    EXPECT_NEAR(scaleOf(listener_->results.back(), *bag_), 1.0, 0.1);
  }
}

// The node looks for the type of its speed_topic until somebody publishes there.
TEST_F(Init, SpeedsAreReceivedAndTheirFaultsNamed) {
  ASSERT_FALSE(listener_->features.empty());
  ros::Publisher speed =
      listener_->handle.advertise<geometry_msgs::TwistWithCovarianceStamped>("/wheel/speed", 100);
  ASSERT_TRUE(listener_->wait([&] { return speed.getNumSubscribers() >= 1; }));
  geometry_msgs::TwistWithCovarianceStamped message;
  message.header.stamp = listener_->features.back().header.stamp;
  message.twist.twist.linear.x = 1.0;
  message.twist.covariance[0] = 0.01;
  speed.publish(message);
  speed.publish(message);  // once more: late
  message.twist.covariance[0] = 0.0;
  speed.publish(message);
  message.twist.twist.linear.x = std::numeric_limits<double>::quiet_NaN();
  speed.publish(message);
  const std::string discarded = "slim_init: streams/speed discarded: ";
  EXPECT_TRUE(listener_->wait([&] {
    return listener_->value("slim_init: streams/speed received") == 4 &&
           listener_->value(discarded + "late") == 1 &&
           listener_->value(discarded + "covariance not positive definite") == 1 &&
           listener_->value(discarded + "not finite") == 1;
  }));
}

TEST_F(Init, GarbageIsCountedAndTheNodesLiveOn) {
  ros::NodeHandle& handle = listener_->handle;
  ASSERT_FALSE(listener_->features.empty());
  const ros::Time end = listener_->features.back().header.stamp;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  {
    ros::Publisher imu = handle.advertise<sensor_msgs::Imu>("/imu0", 100);
    ros::Publisher image = handle.advertise<sensor_msgs::Image>("/cam0/image_raw", 100);
    ros::Publisher feature =
        handle.advertise<sensor_msgs::PointCloud>("/feature_tracker/feature", 100);
    ros::Publisher line =
        handle.advertise<sensor_msgs::PointCloud>("/feature_tracker_lines/lines", 100);
    ASSERT_TRUE(listener_->wait([&] {
      return imu.getNumSubscribers() >= 2 && image.getNumSubscribers() >= 1 &&
             feature.getNumSubscribers() >= 2 && line.getNumSubscribers() >= 2;
    }));

    sensor_msgs::Imu sample;
    sample.header.stamp = end + ros::Duration(0.2);
    sample.angular_velocity.x = kNan;
    imu.publish(sample);
    sample.angular_velocity.x = 0.0;
    sample.linear_acceleration.z = -5e3;  // a glitch
    imu.publish(sample);
    sample.linear_acceleration.z = 9.81;
    sample.header.stamp = ros::Time();  // no stamp
    imu.publish(sample);
    sample.header.stamp = end + ros::Duration(5000.0);  // stray
    imu.publish(sample);
    for (int k = 0; k < 60; ++k) {  // orderly again; they cover the images below
      sample.header.stamp = end + ros::Duration(0.3 + 0.01 * k);
      imu.publish(sample);
    }

    sensor_msgs::Image picture;
    picture.header.stamp = end + ros::Duration(0.05);
    image.publish(picture);  // empty
    picture.width = picture.height = picture.step = 16;
    picture.data.assign(256, 0);
    picture.encoding = "nonsense";
    image.publish(picture);
    picture.encoding = "mono8";
    picture.data.resize(100);
    image.publish(picture);
    picture.data.assign(256, 0);  // in order, but of another size than the camera
    image.publish(picture);

    sensor_msgs::PointCloud cloud = listener_->features.back();
    cloud.header.stamp = end + ros::Duration(0.1);
    cloud.points[0].x = kNan;
    feature.publish(cloud);
    cloud = listener_->features.back();
    cloud.channels[0].values.pop_back();
    feature.publish(cloud);
    cloud.channels.clear();
    feature.publish(cloud);
    cloud.points.clear();
    feature.publish(cloud);
    feature.publish(listener_->features.back());  // once more: late
    cloud = listener_->lines.back();
    cloud.channels[1].name = "end";
    line.publish(cloud);

    const std::map<std::string, int> counted = {
        {"slim_init: streams/feature discarded: malformed", 4},
        {"slim_init: streams/feature discarded: late", 1},
        {"slim_init: streams/line discarded: malformed", 1},
        {"slim_init: streams/imu discarded: malformed", 2},
        {"slim_init: streams/imu discarded: glitch", 1},
        {"slim_init: streams/imu discarded: stray stamp", 1},
        {"feature_tracker_lines: streams/imu discarded: malformed", 2},
        {"feature_tracker_lines: streams/imu discarded: glitch", 1},
        {"feature_tracker_lines: streams/imu discarded: stray stamp", 1},
        {"feature_tracker_lines: streams/image discarded: malformed", 4}};
    for (const auto& [name, count] : counted) {
      EXPECT_TRUE(listener_->wait([&] { return listener_->value(name) >= count; }, 15.0)) << name;
    }
  }

  // The bag once more: time goes back, both nodes begin anew, and the answer is as good.
  const std::size_t before = listener_->results.size();
  play(listener_, *bag_);
  ASSERT_TRUE(listener_->wait([&] { return listener_->results.size() > before; }));
  EXPECT_NEAR(scaleOf(listener_->results.back(), *bag_), 1.0, 0.1);
  EXPECT_GE(listener_->restarts.size(), 1u);
  EXPECT_TRUE(listener_->restarts.front().data);
  EXPECT_GE(listener_->fresh("slim_init: initialization/time jumps"), 1);
  EXPECT_GE(listener_->value("feature_tracker_lines: tracking/time jumps"), 1);
}

/// Resident memory of a node [MiB]; NaN if it does not run.
double memoryOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, uri, pid;
  request[0] = ros::this_node::getName();
  request[1] = node;
  std::string host;
  uint32_t port = 0;
  if (!ros::master::execute("lookupNode", request, response, uri, false) ||
      !ros::network::splitURI(uri, host, port)) {
    return kNotComputed;
  }
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  if (!client.execute("getPid", request, pid)) return kNotComputed;
  std::ifstream status("/proc/" + std::to_string(static_cast<int>(pid[2])) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmRSS:", 0) == 0) return std::atof(line.c_str() + 6) / 1024.0;
  }
  return kNotComputed;
}

// SLIM_INIT_NODE_ROUNDS=240 is the long form of it.
TEST(Loop, EveryRoundOfTheBagInitializesAnew) {
  constexpr double kGrowth = 4.0;          // [MiB] over the second half of many rounds
  constexpr std::size_t kManyRounds = 40;  // before that the allocator has not seen everything once
  const char* const asked = std::getenv("SLIM_INIT_NODE_ROUNDS");
  const std::size_t rounds = asked == nullptr ? 3 : std::strtoul(asked, nullptr, 10);
  const std::vector<std::string> nodes = {"/feature_tracker_lines", "/slim_init"};
  std::map<std::string, double> halfway;
  Listener listener;
  const std::string bag = parameter("bag");
  for (std::size_t k = 0; k < rounds; ++k) {
    ASSERT_TRUE(listener.wait([&] { return listener.results.size() > k; })) << "round " << k;
    EXPECT_NEAR(scaleOf(listener.results[k], bag), 1.0, 0.1) << "round " << k;
    listener.features.clear();
    listener.lines.clear();
    for (const std::string& node : nodes) {
      const double memory = memoryOf(node);
      ASSERT_FALSE(std::isnan(memory)) << node << " does not run, round " << k;
      if (k == rounds / 2) halfway[node] = memory;
      if (k + 1 < rounds) continue;
      std::cout << node << ": " << halfway[node] << " MiB, at the end " << memory << " MiB\n";
      if (rounds >= kManyRounds) {
        EXPECT_LE(memory, halfway[node] + kGrowth) << node;
      }
    }
  }
  EXPECT_GE(listener.restarts.size(), rounds - 1);
  // The nodes came while the bag was running, and every round has an answer.
  EXPECT_EQ(listener.fresh("slim_init: streams/imu discarded: malformed"), 0);
  const double jumps = listener.value("slim_init: initialization/time jumps");
  EXPECT_GE(jumps, static_cast<double>(rounds) - 1);
  EXPECT_LE(jumps, static_cast<double>(listener.results.size()) + 1);
  EXPECT_NEAR(listener.value("feature_tracker_lines: tracking/time jumps"), jumps, 1);
  EXPECT_EQ(listener.value("feature_tracker_lines: tracking/images discarded: queue full"), 0);
}

}  // namespace
}  // namespace slim_init::node

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "ros_test_client");
  return RUN_ALL_TESTS();
}
