// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Features, lines and IMU in; verdicts and, after a success, the initial states out (docs/ros.md).
#include <ros/ros.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/Bool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <memory>
#include <string>
#include <utility>

#include "slim_init/result.h"
#include "slim_init/ros/conversions.h"
#include "slim_init/ros/init_session.h"
#include "slim_init/ros/node_parameters.h"
#include "slim_init/ros/stream_monitor.h"
#include "slim_init/vins_adapter/feature_message.h"
#include "slim_init/vins_ros/speed_topic.h"

namespace slim_init::node {
namespace {

class SlimInitNode {
 public:
  /// Returns an empty string, or a message why the node cannot run.
  std::string start();

 private:
  enum Stream { kImu, kPoints, kLines, kSpeed };

  void onImu(const sensor_msgs::Imu& message);
  void onPoints(const sensor_msgs::PointCloud& message);
  void onLines(const sensor_msgs::PointCloud& message);
  void onSpeed(const std_msgs::Header& header, const Eigen::Vector3d& velocity,
               const Eigen::Matrix3d& covariance);
  void onRestart(const std_msgs::Bool& message);
  bool onInitialize(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  void use(AddStatus status);
  void publish(const Attempt& attempt);
  void publishSeed(const Attempt& attempt);
  void publishFrames(const NavState& body, const InitResult& result);
  void publishMarkers(const NavState& body, const ros::Time& stamp);
  void log(const Attempt& attempt);
  Diagnostics::Statuses diagnostics();

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_{"~"};
  ResultContext context_;
  ImuLimits imu_limits_;
  bool publish_tf_ = true;
  bool expect_lines_ = true;
  std::unique_ptr<InitSession> session_;
  NodeStreams streams_{{{"imu", &StreamCounts::imu, true},
                        {"feature", &StreamCounts::frames, true},
                        {"line", &StreamCounts::lines, false},
                        {"speed", &StreamCounts::speeds, false}}};
  std::int64_t jumps_seen_ = 0;  // jumps in time that a restart message has announced
  std::string last_status_;
  double last_attempt_ms_ = kNotComputed;

  bool speed_forward_only_ = true;
  vins_ros::SpeedTopic speed_;
  ros::Subscriber imu_, points_, lines_, restart_;
  ros::Publisher status_, result_, odometry_, path_, markers_, tf_static_;
  ros::ServiceServer service_;
  Diagnostics diagnostics_;
};

std::string SlimInitNode::start() {
  Config config;
  InitSessionOptions options;
  NodeParameters parameters(private_handle_);
  parameters.readConfig(&config);
  parameters.read("method", &config.method);
  parameters.readTopic("imu_topic", &config.imu_topic);
  parameters.read("expect_lines", &expect_lines_);
  parameters.read("attempt_interval_s", &options.attempt_interval_s);
  parameters.read("world_frame", &context_.world_frame);
  parameters.read("body_frame", &context_.body_frame);
  parameters.read("publish_tf", &publish_tf_);
  if (std::string problem = parameters.check(); !problem.empty()) return problem;
  if (std::string problem = options.validate(); !problem.empty()) return "~" + problem;
  options.image_height = config.camera.height;
  options.imu = config.options.imu;
  std::string error;
  std::unique_ptr<IInitializer> initializer = makeLiveInitializer(config, &error);
  if (initializer == nullptr) return error;
  parameters.log();
  session_ = std::make_unique<InitSession>(std::move(initializer), options);
  imu_limits_ = config.options.imu;
  speed_forward_only_ = config.speed_forward_only;
  speed_.open(handle_, config.speed_topic,
              [this](const std_msgs::Header& header, const Eigen::Vector3d& velocity,
                     const Eigen::Matrix3d& covariance) { onSpeed(header, velocity, covariance); });
  context_.method = config.method;
  context_.calibration = config.calibration;

  status_ = private_handle_.advertise<InitStatusMessage>("status", 100);
  result_ = private_handle_.advertise<InitResultMessage>("result", 10, true);
  odometry_ = private_handle_.advertise<nav_msgs::Odometry>("odometry", 10);
  path_ = private_handle_.advertise<nav_msgs::Path>("path", 10, true);
  markers_ = private_handle_.advertise<visualization_msgs::MarkerArray>("markers", 10, true);
  if (publish_tf_) {
    tf_static_ = handle_.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
    publishFrames(NavState(), InitResult());
  }
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  imu_ = handle_.subscribe(config.imu_topic, 2000, &SlimInitNode::onImu, this, hints);
  points_ = handle_.subscribe("feature_tracker/feature", 100, &SlimInitNode::onPoints, this, hints);
  lines_ =
      handle_.subscribe("feature_tracker_lines/lines", 100, &SlimInitNode::onLines, this, hints);
  restart_ = handle_.subscribe("feature_tracker/restart", 10, &SlimInitNode::onRestart, this);
  service_ = private_handle_.advertiseService("initialize", &SlimInitNode::onInitialize, this);
  diagnostics_.start([this] { return diagnostics(); });
  return "";
}

void SlimInitNode::onImu(const sensor_msgs::Imu& message) {
  ImuSample sample;
  const std::string problem = readImu(message, &sample);
  if (!streams_.accept(kImu, message.header, problem, &sample.t)) return;
  const AddStatus status = session_->addImu(sample);
  if (status == AddStatus::kGlitch) {
    streams_.explain(kImu, imu_limits_.describe(sample) +
                               (imu_limits_.exceededBy(sample)
                                    ? ""
                                    : ": frozen, far from those before, or among such samples"));
  }
  use(status);
}

void SlimInitNode::onPoints(const sensor_msgs::PointCloud& message) {
  FrameObservation frame;
  std::string problem;
  vins_adapter::readPointMessage(message, &frame, &problem);
  if (!streams_.accept(kPoints, message.header, problem, &frame.t)) return;
  session_->expectLines(expect_lines_ && lines_.getNumPublishers() > 0);
  use(session_->addPoints(std::move(frame)));
}

void SlimInitNode::onLines(const sensor_msgs::PointCloud& message) {
  FrameObservation frame;
  std::string problem;
  vins_adapter::readLineMessage(message, &frame, &problem);
  if (!streams_.accept(kLines, message.header, problem, &frame.t)) return;
  use(session_->addLines(frame.t, std::move(frame.lines)));
}

void SlimInitNode::onSpeed(const std_msgs::Header& header, const Eigen::Vector3d& velocity,
                           const Eigen::Matrix3d& covariance) {
  SpeedSample sample;
  sample.velocity = velocity;
  sample.covariance = covariance;
  sample.forward_only = speed_forward_only_;
  if (streams_.accept(kSpeed, header, "", &sample.t)) session_->addSpeed(sample);
}

void SlimInitNode::onRestart(const std_msgs::Bool& message) {
  if (!message.data) return;
  // The tracker announces a jump that the stamps have shown already; its message may come after the
  // first data of the new time, which must stay.
  const std::int64_t jumps = session_->streamCounts().restarts();
  if (jumps > jumps_seen_) {
    jumps_seen_ = jumps;
    return;
  }
  ROS_WARN("the tracker has restarted: all data are discarded");
  session_->restart();
}

bool SlimInitNode::onInitialize(std_srvs::Trigger::Request& /*request*/,
                                std_srvs::Trigger::Response& response) {
  const Attempt attempt = session_->initialize();
  publish(attempt);
  response.success = attempt.result.success();
  response.message = toString(attempt.result.status) + std::string(": ") + attempt.result.message;
  return true;
}

// After every message: `status` is what became of it.
void SlimInitNode::use(AddStatus status) {
  if (status == AddStatus::kRestarted) {
    ROS_WARN("time has jumped: all data before it are discarded");
  }
  while (std::optional<Attempt> attempt = session_->poll()) publish(*attempt);
}

void SlimInitNode::publish(const Attempt& attempt) {
  last_attempt_ms_ = attempt.total_ms;
  context_.clock = streams_.clock();
  log(attempt);
  status_.publish(statusMessage(attempt, context_));
  if (attempt.result.success()) publishSeed(attempt);
}

void SlimInitNode::log(const Attempt& attempt) {
  const std::string status = toString(attempt.result.status);
  // Once per change: there may be ten attempts a second.
  if (status != last_status_ || attempt.requested) {
    ROS_INFO_STREAM("attempt " << attempt.number << ": " << status << ": "
                               << withRemedy(attempt.result.message, attempt.result.status));
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
  if (publish_tf_) publishFrames(newest, attempt.result);
}

// World to body (of the newest seed) and body to camera (of the newest result, before the first of
// the configuration). Latched: the last message is the whole tree.
void SlimInitNode::publishFrames(const NavState& body, const InitResult& result) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(2);
  message.transforms[0].header.frame_id = context_.world_frame;
  message.transforms[0].child_frame_id = context_.body_frame;
  message.transforms[0].transform = transformMessage(body.R_w_b, body.p_w_b);
  message.transforms[1].header.frame_id = context_.body_frame;
  message.transforms[1].child_frame_id = "camera";
  message.transforms[1].transform = extrinsicMessage(result, context_);
  for (auto& transform : message.transforms) transform.header.stamp = ros::Time::now();
  tf_static_.publish(message);
}

// Gravity as a metre of arrow at the body, the velocity as an arrow of what a second covers.
void SlimInitNode::publishMarkers(const NavState& body, const ros::Time& stamp) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = context_.world_frame;
  const Eigen::Vector3d& p = body.p_w_b;
  visualization_msgs::MarkerArray message;
  message.markers = {
      arrowMarker(header, "gravity", p, p - Eigen::Vector3d::UnitZ(), 1.0f, 0.2f),
      arrowMarker(header, "velocity", p, p + body.v_w_b, 0.2f, 1.0f),
  };
  markers_.publish(message);
}

Diagnostics::Statuses SlimInitNode::diagnostics() {
  const InitSessionCounts& counts = session_->counts();
  const StreamCounts streams = session_->streamCounts();
  diagnostic_msgs::DiagnosticStatus state =
      makeStatus("initialization", session_->initialized() ? "initialized"
                                   : last_status_.empty()  ? "waiting for data"
                                                           : "waiting: " + last_status_);
  addValue("attempts", counts.attempts, &state);
  addValue("successes", counts.successes, &state);
  addValue("last status", last_status_, &state);
  addValue("last attempt [ms]", last_attempt_ms_, &state);
  addValue("frames", streams.frames.added(), &state);
  addValue("frames that no IMU covered", counts.frames_uncovered, &state);
  addValue("time jumps", streams.restarts(), &state);
  addValue("restarts", counts.restarts, &state);
  addValue("observations not finite", streams.observations_not_finite, &state);
  addValue("observations with the id of another", streams.observations_duplicate_id, &state);
  addValue("lines without length", streams.lines_degenerate, &state);
  return {streams_.report(streams), state};
}

}  // namespace
}  // namespace slim_init::node

int main(int argc, char** argv) {
  return slim_init::node::runNode<slim_init::node::SlimInitNode>(argc, argv, "slim_init");
}
