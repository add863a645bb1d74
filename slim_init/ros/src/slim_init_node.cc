// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Features, lines and IMU in; verdicts and, when it is a yes, the seed out (docs/ros.md).
#include <ros/ros.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/Bool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <string>
#include <utility>

#include "slim_init/ros/conversions.h"
#include "slim_init/ros/init_session.h"
#include "slim_init/ros/node_parameters.h"
#include "slim_init/ros/stream_monitor.h"
#include "slim_init/ros/time_guard.h"
#include "slim_init/vins_adapter/feature_message.h"

namespace slim_init::node {
namespace {

class SlimInitNode {
 public:
  /// Returns an empty string, or a sentence why the node cannot run.
  std::string start();

 private:
  enum Stream { kImu, kPoints, kLines, kStreams };

  void onImu(const sensor_msgs::Imu& message);
  void onPoints(const sensor_msgs::PointCloud& message);
  void onLines(const sensor_msgs::PointCloud& message);
  void onRestart(const std_msgs::Bool& message);
  bool onReinitialize(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void onSecond(const ros::WallTimerEvent& event);

  /// Judges a stamp; after a time jump all data is forgotten. False: drop the message.
  bool admit(Stream stream, const ros::Time& stamp);
  void poll();
  void publish(const Attempt& attempt);
  void publishSeed(const Attempt& attempt);
  void publishFrames(const NavState& body);
  void publishMarkers(const NavState& body, const ros::Time& stamp);
  void log(const Attempt& attempt);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_{"~"};
  ResultContext context_;
  Calibration calibration_;
  bool publish_tf_ = true;
  bool expect_lines_ = true;
  std::unique_ptr<InitSession> session_;
  TimeGuard guard_{std::vector<TimeGuard::Stream>(kStreams)};
  StreamMonitor monitors_[kStreams] = {{"imu", true}, {"feature", true}, {"line", false}};
  std::int64_t jumps_seen_ = 0;  // time jumps that a restart message may still tell about
  std::string last_status_;
  double last_attempt_ms_ = kNotComputed;

  ros::Subscriber imu_, points_, lines_, restart_;
  ros::Publisher status_, result_, odometry_, path_, markers_, tf_static_, diagnostics_;
  ros::ServiceServer service_;
  ros::WallTimer timer_;
};

std::string SlimInitNode::start() {
  feature_tracker_lines::Config config;
  InitSessionOptions options;
  NodeParameters parameters(private_handle_);
  parameters.readConfig(&config);
  parameters.read("method", &config.method);
  parameters.read("imu_topic", &config.imu_topic);
  parameters.read("expect_lines", &expect_lines_);
  parameters.read("attempt_interval_s", &options.attempt_interval_s);
  parameters.read("world_frame", &context_.world_frame);
  parameters.read("body_frame", &context_.body_frame);
  parameters.read("publish_tf", &publish_tf_);
  if (std::string sentence = parameters.check(); !sentence.empty()) return sentence;
  if (std::string sentence = options.validate(); !sentence.empty()) return "~" + sentence;
  if (config.imu_topic.empty()) {
    return "imu_topic is neither in the configuration file nor set as ~imu_topic";
  }
  std::string error;
  std::unique_ptr<IInitializer> initializer =
      makeInitializer(config.method, config.calibration, config.options, &error);
  if (initializer == nullptr) return error;
  parameters.log();
  session_ = std::make_unique<InitSession>(std::move(initializer), options);
  calibration_ = config.calibration;
  context_.method = config.method;
  context_.td = config.calibration.td;

  status_ = private_handle_.advertise<InitStatusMessage>("status", 100);
  result_ = private_handle_.advertise<InitResultMessage>("result", 10, true);
  odometry_ = private_handle_.advertise<nav_msgs::Odometry>("odometry", 10);
  path_ = private_handle_.advertise<nav_msgs::Path>("path", 10, true);
  markers_ = private_handle_.advertise<visualization_msgs::MarkerArray>("markers", 10, true);
  diagnostics_ = handle_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  if (publish_tf_) {
    tf_static_ = handle_.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
    publishFrames(NavState());
  }
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  imu_ = handle_.subscribe(config.imu_topic, 2000, &SlimInitNode::onImu, this, hints);
  points_ = handle_.subscribe("feature_tracker/feature", 100, &SlimInitNode::onPoints, this, hints);
  lines_ =
      handle_.subscribe("feature_tracker_lines/lines", 100, &SlimInitNode::onLines, this, hints);
  restart_ = handle_.subscribe("feature_tracker/restart", 10, &SlimInitNode::onRestart, this);
  service_ = private_handle_.advertiseService("reinitialize", &SlimInitNode::onReinitialize, this);
  // Wall clock: simulated time stands still with the bag, and then most of all one wants to know.
  timer_ = handle_.createWallTimer(ros::WallDuration(1.0), &SlimInitNode::onSecond, this);
  return "";
}

bool SlimInitNode::admit(Stream stream, const ros::Time& stamp) {
  switch (guard_.check(stream, stamp.toSec())) {
    case StampVerdict::kUse: return true;
    case StampVerdict::kRestart:
      ROS_WARN_STREAM("time jumped to " << stamp << ": all data is forgotten");
      session_->restart();
      return true;
    default: return false;
  }
}

void SlimInitNode::onImu(const sensor_msgs::Imu& message) {
  monitors_[kImu].received(message.header.seq);
  const ImuSample raw = toSample(message, 0.0);
  if (!raw.gyro.allFinite() || !raw.accel.allFinite()) {
    monitors_[kImu].garbage("a value is not finite");
    return;
  }
  if (!admit(kImu, message.header.stamp)) return;
  session_->addImu(toSample(message, context_.clock.seconds(stampNs(message.header.stamp))));
  poll();
}

void SlimInitNode::onPoints(const sensor_msgs::PointCloud& message) {
  monitors_[kPoints].received(message.header.seq);
  FrameObservation frame;
  std::string error;
  if (!vins_adapter::readPointMessage(message, 1, &frame, &error)) {
    monitors_[kPoints].garbage(error);
    return;
  }
  if (!admit(kPoints, message.header.stamp)) return;
  session_->expectLines(expect_lines_ && lines_.getNumPublishers() > 0);
  frame.t = context_.clock.seconds(stampNs(message.header.stamp));
  session_->addPoints(std::move(frame));
  poll();
}

void SlimInitNode::onLines(const sensor_msgs::PointCloud& message) {
  monitors_[kLines].received(message.header.seq);
  FrameObservation frame;
  std::string error;
  if (!vins_adapter::readLineMessage(message, &frame, &error)) {
    monitors_[kLines].garbage(error);
    return;
  }
  if (!admit(kLines, message.header.stamp)) return;
  session_->addLines(context_.clock.seconds(stampNs(message.header.stamp)), std::move(frame.lines));
  poll();
}

void SlimInitNode::onRestart(const std_msgs::Bool& message) {
  if (!message.data) return;
  // The tracker tells of the same jump that the stamps have told of; it may come after the first
  // data of the new time, which are to stay.
  if (guard_.restarts() > jumps_seen_) {
    jumps_seen_ = guard_.restarts();
    return;
  }
  ROS_WARN("the tracker restarts: all data is forgotten");
  session_->restart();
}

bool SlimInitNode::onReinitialize(std_srvs::Trigger::Request& /*request*/,
                                  std_srvs::Trigger::Response& response) {
  const Attempt attempt = session_->request();
  publish(attempt);
  response.success = attempt.result.success();
  response.message = toString(attempt.result.status) + std::string(": ") + attempt.result.message;
  return true;
}

void SlimInitNode::poll() {
  while (std::optional<Attempt> attempt = session_->poll()) publish(*attempt);
}

void SlimInitNode::publish(const Attempt& attempt) {
  last_attempt_ms_ = attempt.total_ms;
  log(attempt);
  status_.publish(statusMessage(attempt, context_));
  if (attempt.result.success() && attempt.result.hasEstimate()) publishSeed(attempt);
}

void SlimInitNode::log(const Attempt& attempt) {
  const std::string status = toString(attempt.result.status);
  // Once per change: at ten attempts a second the same sentence says nothing new.
  if (status != last_status_ || attempt.requested) {
    ROS_INFO_STREAM("attempt " << attempt.number << ": " << status << ": "
                               << attempt.result.message);
  }
  last_status_ = status;
}

void SlimInitNode::publishSeed(const Attempt& attempt) {
  const NavState& newest = attempt.result.states.back();
  const nav_msgs::Odometry seed = seedMessage(attempt, context_);
  result_.publish(resultMessage(attempt, context_));
  odometry_.publish(seed);
  path_.publish(pathMessage(attempt, context_));
  publishMarkers(newest, seed.header.stamp);
  if (publish_tf_) publishFrames(newest);
}

// World to body (of the newest seed) and body to camera. Latched: the last message is the whole
// tree.
void SlimInitNode::publishFrames(const NavState& body) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(2);
  message.transforms[0].header.frame_id = context_.world_frame;
  message.transforms[0].child_frame_id = context_.body_frame;
  message.transforms[0].transform = transformMessage(body.R_w_b, body.p_w_b);
  message.transforms[1].header.frame_id = context_.body_frame;
  message.transforms[1].child_frame_id = "camera";
  message.transforms[1].transform = transformMessage(calibration_.R_b_c, calibration_.t_b_c);
  for (auto& transform : message.transforms) transform.header.stamp = ros::Time::now();
  tf_static_.publish(message);
}

// Gravity as a metre of arrow at the body, the velocity as an arrow of what a second covers.
void SlimInitNode::publishMarkers(const NavState& body, const ros::Time& stamp) {
  const auto arrow = [&](const char* name, const Eigen::Vector3d& tip, float red, float green) {
    visualization_msgs::Marker marker;
    marker.header.stamp = stamp;
    marker.header.frame_id = context_.world_frame;
    marker.ns = name;
    marker.type = visualization_msgs::Marker::ARROW;
    marker.pose.orientation.w = 1.0;
    marker.scale.x = 0.02;  // shaft, head, head length [m]
    marker.scale.y = 0.05;
    marker.scale.z = 0.1;
    marker.color.r = red;
    marker.color.g = green;
    marker.color.a = 1.0f;
    for (const Eigen::Vector3d& p : {body.p_w_b, Eigen::Vector3d(body.p_w_b + tip)}) {
      marker.points.emplace_back();
      marker.points.back().x = p.x();
      marker.points.back().y = p.y();
      marker.points.back().z = p.z();
    }
    return marker;
  };
  visualization_msgs::MarkerArray message;
  message.markers.push_back(arrow("gravity", -Eigen::Vector3d::UnitZ(), 1.0f, 0.2f));
  message.markers.push_back(arrow("velocity", body.v_w_b, 0.2f, 1.0f));
  markers_.publish(message);
}

void SlimInitNode::onSecond(const ros::WallTimerEvent& /*event*/) {
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  diagnostic_msgs::DiagnosticStatus streams = makeStatus("streams");
  for (int i = 0; i < kStreams; ++i) monitors_[i].report(guard_.counts(i), &streams);
  if (streams.message.empty()) streams.message = "data is coming";

  diagnostic_msgs::DiagnosticStatus state = makeStatus("initialization");
  const InitSessionCounts& counts = session_->counts();
  const WindowCounts& window = session_->initializer().window().counts();
  state.message = session_->initialized() ? "initialized"
                  : last_status_.empty()  ? "waiting for data"
                                          : "waiting: " + last_status_;
  addValue("attempts", counts.attempts, &state);
  addValue("successes", counts.successes, &state);
  addValue("last verdict", last_status_, &state);
  addValue("last attempt [ms]", last_attempt_ms_, &state);
  addValue("frames", counts.frames, &state);
  addValue("line messages", counts.line_messages, &state);
  addValue("line messages without frame", counts.lines_unmatched, &state);
  addValue("frames that no IMU covered", counts.frames_uncovered, &state);
  addValue("time jumps", guard_.restarts(), &state);
  addValue("restarts", counts.restarts, &state);
  // Since the last restart.
  addValue("window: imu out of order", window.imu_out_of_order, &state);
  addValue("window: frames out of order", window.frames_out_of_order, &state);
  addValue("window: observations not finite", window.observations_not_finite, &state);
  addValue("window: observations with the id of another", window.observations_duplicate_id, &state);
  addValue("window: lines without length", window.lines_degenerate, &state);
  message.status = {streams, state};
  diagnostics_.publish(message);
}

}  // namespace
}  // namespace slim_init::node

int main(int argc, char** argv) {
  ros::init(argc, argv, "slim_init");
  slim_init::node::SlimInitNode node;
  if (const std::string sentence = node.start(); !sentence.empty()) {
    ROS_FATAL_STREAM(sentence);
    return 2;
  }
  ros::spin();
  return 0;
}
