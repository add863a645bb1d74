// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the header of a patched host's estimator includes: the glue, and its topics for the host's
// node. C++11, like the hosts.
#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud.h>
#include <std_msgs/Bool.h>
#include <std_msgs/String.h>

#include <string>

#include "slim_init/vins_adapter/host_glue.h"
#include "slim_init/vins_ros/speed_topic.h"

namespace slim_init {
namespace vins_ros {

/// The topics of a HostGlue in the node of its host. Both outlive the host's threads.
class HostNode {
 public:
  /// Reads the host's file. If the adapter takes part, its reports are published, and lines,
  /// requests and velocities received. `features`: topic of the host's points, for its delay, or
  /// "".
  void open(ros::NodeHandle& node, vins_adapter::HostGlue& glue, const std::string& config_file,
            const std::string& features) {
    glue_ = &glue;
    glue.listen(
        [this](vins_adapter::ReportLevel level, const std::string& text) { report(level, text); });
    if (!glue.open(config_file)) return;
    status_ = node.advertise<std_msgs::String>("slim_init/status", 1000);
    health_ = node.advertise<std_msgs::String>("slim_init/health", 1000);
    frame_ = node.advertise<std_msgs::String>("slim_init/frame", 10, true);
    lines_ = node.subscribe("/feature_tracker_lines/lines", 2000, &HostNode::onLines, this);
    recover_ = node.subscribe("slim_init/recover", 10, &HostNode::onRecover, this);
    if (!features.empty()) features_ = node.subscribe(features, 2000, &HostNode::onFeatures, this);
    speed_.open(node, glue.speedTopic(),
                [&glue](const std_msgs::Header& header, const Eigen::Vector3d& velocity,
                        const Eigen::Matrix3d& covariance) {
                  glue.addSpeed(header.stamp.toSec(), velocity, covariance);
                });
  }

 private:
  void report(vins_adapter::ReportLevel level, const std::string& text) const {
    using vins_adapter::ReportLevel;
    if (level == ReportLevel::kError) ROS_ERROR_STREAM("slim_init: " << text);
    if (level == ReportLevel::kWarn) ROS_WARN_STREAM("slim_init: " << text);
    if (level == ReportLevel::kInfo) ROS_INFO_STREAM("slim_init: " << text);
    const ros::Publisher& topic = level == ReportLevel::kHealth  ? health_
                                  : level == ReportLevel::kFrame ? frame_
                                                                 : status_;
    std_msgs::String message;
    message.data = text;
    if (topic) topic.publish(message);
  }
  void onLines(const sensor_msgs::PointCloudConstPtr& lines) { glue_->addLines(*lines); }
  void onRecover(const std_msgs::BoolConstPtr& reset_if_refused) {
    glue_->requestRecovery(reset_if_refused->data);
  }
  void onFeatures(const sensor_msgs::PointCloudConstPtr& features) {
    glue_->received(features->header.stamp.toSec());
  }

  vins_adapter::HostGlue* glue_ = nullptr;
  ros::Publisher status_, health_, frame_;
  ros::Subscriber lines_, recover_, features_;
  SpeedTopic speed_;
};

}  // namespace vins_ros
}  // namespace slim_init
