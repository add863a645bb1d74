// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The subscription of `speed_topic`, for ROS nodes: a patched host's and that of slim_init. C++11,
// like the hosts. The adapter's library knows no ROS.
#pragma once

#include <geometry_msgs/TwistWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <Eigen/Core>
#include <functional>
#include <string>

namespace slim_init {
namespace vins_ros {

/// Velocities of a vehicle from geometry_msgs/TwistWithCovarianceStamped or nav_msgs/Odometry. The
/// topic has a type as soon as somebody publishes it; until then a timer looks every second.
class SpeedTopic {
 public:
  /// Header, linear velocity [m/s] and its covariance, in the frame of the sensor.
  typedef std::function<void(const std_msgs::Header&, const Eigen::Vector3d&,
                             const Eigen::Matrix3d&)>
      Callback;

  /// Once. Without a topic nothing happens. Another type is an error in the log.
  void open(const ros::NodeHandle& node, const std::string& topic, const Callback& callback) {
    if (topic.empty()) return;
    node_ = node;
    topic_ = ros::names::resolve(topic);
    callback_ = callback;
    find_ = node_.createWallTimer(ros::WallDuration(1.0), &SpeedTopic::find, this);
  }

 private:
  void find(const ros::WallTimerEvent&) {
    ros::master::V_TopicInfo topics;
    if (!ros::master::getTopics(topics)) return;
    for (const ros::master::TopicInfo& topic : topics) {
      if (topic.name != topic_) continue;
      find_.stop();
      if (topic.datatype == "nav_msgs/Odometry") {
        subscription_ =
            node_.subscribe(topic_, 500, &SpeedTopic::receive<nav_msgs::Odometry>, this);
      } else if (topic.datatype == "geometry_msgs/TwistWithCovarianceStamped") {
        subscription_ = node_.subscribe(
            topic_, 500, &SpeedTopic::receive<geometry_msgs::TwistWithCovarianceStamped>, this);
      } else {
        ROS_ERROR_STREAM("speed_topic " << topic_ << " has the type " << topic.datatype
                                        << ", must be geometry_msgs/TwistWithCovarianceStamped or "
                                           "nav_msgs/Odometry");
      }
    }
  }

  template <typename Message>
  void receive(const Message& message) {
    const auto& v = message.twist.twist.linear;
    const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> covariance(
        message.twist.covariance.data());
    callback_(message.header, Eigen::Vector3d(v.x, v.y, v.z), covariance.topLeftCorner<3, 3>());
  }

  ros::NodeHandle node_;
  std::string topic_;
  Callback callback_;
  ros::WallTimer find_;
  ros::Subscriber subscription_;
};

}  // namespace vins_ros
}  // namespace slim_init
