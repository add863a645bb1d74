// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// From and to messages. Feature messages: slim_init/vins_adapter/feature_message.h.
#pragma once

#include <geometry_msgs/Transform.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <visualization_msgs/Marker.h>

#include <cstdint>
#include <string>

#include "slim_init/ros/init_session.h"
#include "slim_init/ros/stamp_clock.h"
#include "slim_init/types.h"

// ROS puts messages into the namespace of their package, where the library has an InitStatus and an
// InitResult of its own: here the messages are called InitStatusMessage and InitResultMessage. The
// types are the same; only the short names differ.
#define InitStatus InitStatusMessage
#define InitResult InitResultMessage
#include <slim_init/InitGate.h>
#include <slim_init/InitResult.h>
#include <slim_init/InitStage.h>
#include <slim_init/InitStatus.h>
#undef InitStatus
#undef InitResult

namespace slim_init::node {

std::int64_t stampNs(const ros::Time& stamp);

/// Negative times, which ros::Time cannot hold, become zero.
ros::Time rosTime(std::int64_t stamp_ns);

/// Angular rate and specific force into `sample`, whose time the caller sets. Returns an empty
/// string, or why the message cannot be used: a value is not finite.
std::string readImu(const sensor_msgs::Imu& message, ImuSample* sample);

/// What the messages need besides the result.
struct ResultContext {
  StampClock clock;  ///< of the times in the result
  std::string method;
  std::string world_frame = "world";
  std::string body_frame = "body";
  /// Of the configuration, for methods that do not estimate it: extrinsic and td.
  Calibration calibration;
};

InitStatusMessage statusMessage(const Attempt& attempt, const ResultContext& context);

/// `attempt` succeeded and has states.
InitResultMessage resultMessage(const Attempt& attempt, const ResultContext& context);

/// The newest keyframe's state: pose in the world, velocity in the body frame as nav_msgs defines
/// it. Covariances (row-major 6 x 6) where the method has them, else zero. The angular velocity is
/// not estimated and left zero.
nav_msgs::Odometry seedMessage(const Attempt& attempt, const ResultContext& context);

/// The poses of all keyframes.
nav_msgs::Path pathMessage(const Attempt& attempt, const ResultContext& context);

/// Camera to body: estimated with the states, or that of the configuration.
geometry_msgs::Transform extrinsicMessage(const InitResult& result, const ResultContext& context);

geometry_msgs::Transform transformMessage(const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

/// An arrow, opaque; `red` and `green` in [0, 1]. Its size suits lengths of about a metre.
visualization_msgs::Marker arrowMarker(const std_msgs::Header& header, const std::string& name,
                                       const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                       float red, float green);

}  // namespace slim_init::node
