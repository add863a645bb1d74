// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/conversions.h"

#include <geometry_msgs/Point.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "slim_init/host_health/imu_propagation.h"

namespace slim_init::node {
namespace {

#define SLIM_INIT_SAME_STATUS(enumerator, constant)                                              \
  static_assert(                                                                                 \
      static_cast<int>(InitStatus::enumerator) == static_cast<int>(InitStatusMessage::constant), \
      "InitStatus.msg and result.h disagree")
SLIM_INIT_SAME_STATUS(kSuccess, SUCCESS);
SLIM_INIT_SAME_STATUS(kTooFewKeyframes, TOO_FEW_KEYFRAMES);
SLIM_INIT_SAME_STATUS(kTooFewTracks, TOO_FEW_TRACKS);
SLIM_INIT_SAME_STATUS(kStationary, STATIONARY);
SLIM_INIT_SAME_STATUS(kTooLittleExcitation, TOO_LITTLE_EXCITATION);
SLIM_INIT_SAME_STATUS(kPureRotation, PURE_ROTATION);
SLIM_INIT_SAME_STATUS(kDegenerateAlignment, DEGENERATE_ALIGNMENT);
SLIM_INIT_SAME_STATUS(kInconsistentResiduals, INCONSISTENT_RESIDUALS);
SLIM_INIT_SAME_STATUS(kScaleTooUncertain, SCALE_TOO_UNCERTAIN);
SLIM_INIT_SAME_STATUS(kInvalidInput, INVALID_INPUT);
SLIM_INIT_SAME_STATUS(kNumericalFailure, NUMERICAL_FAILURE);
SLIM_INIT_SAME_STATUS(kProvisional, PROVISIONAL);
SLIM_INIT_SAME_STATUS(kTimeLimit, TIME_LIMIT);
#undef SLIM_INIT_SAME_STATUS

template <typename Vector>
Vector vectorMessage(const Eigen::Vector3d& v) {
  Vector message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

geometry_msgs::Vector3 vector3(const Eigen::Vector3d& v) {
  return vectorMessage<geometry_msgs::Vector3>(v);
}

geometry_msgs::Quaternion quaternion(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  geometry_msgs::Quaternion message;
  message.w = q.w();
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  return message;
}

geometry_msgs::Pose poseMessage(const NavState& state) {
  geometry_msgs::Pose message;
  message.position = vectorMessage<geometry_msgs::Point>(state.p_w_b);
  message.orientation = quaternion(state.R_w_b);
  return message;
}

// The time offset of the answer: found, or that of the configuration.
double tdOf(const InitResult& result, const ResultContext& context) {
  return result.calibration ? result.calibration->td : context.calibration.td;
}

// Stamp of the image of one of the answer's states.
ros::Time stampOf(const NavState& state, const InitResult& result, const ResultContext& context) {
  return rosTime(context.clock.stampNs(state.t - tdOf(result, context)));
}

template <typename Array>
void fill(const Eigen::Matrix<double, 6, 6>& covariance, Array* message) {
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message->data()) = covariance;
}

}  // namespace

std::int64_t stampNs(const ros::Time& stamp) { return static_cast<std::int64_t>(stamp.toNSec()); }

ros::Time rosTime(std::int64_t stamp_ns) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(std::max<std::int64_t>(0, stamp_ns)));
}

std::string readImu(const sensor_msgs::Imu& message, ImuSample* sample) {
  const geometry_msgs::Vector3& gyro = message.angular_velocity;
  const geometry_msgs::Vector3& accel = message.linear_acceleration;
  sample->gyro = Eigen::Vector3d(gyro.x, gyro.y, gyro.z);
  sample->accel = Eigen::Vector3d(accel.x, accel.y, accel.z);
  const bool finite = sample->gyro.allFinite() && sample->accel.allFinite();
  return finite ? "" : "a value is not finite";
}

InitStatusMessage statusMessage(const Attempt& attempt, const ResultContext& context) {
  const InitResult& result = attempt.result;
  InitStatusMessage message;
  if (std::isfinite(attempt.t)) message.header.stamp = rosTime(context.clock.stampNs(attempt.t));
  message.header.frame_id = context.body_frame;
  message.attempt = static_cast<std::uint32_t>(attempt.number);
  message.method = context.method;
  message.status = static_cast<std::uint8_t>(result.status);
  message.status_name = toString(result.status);
  message.message = result.message;
  message.requested = attempt.requested;
  message.keyframes = result.counts.keyframes;
  if (result.hasEstimate()) message.window_s = result.states.back().t - result.states.front().t;
  message.point_tracks = result.counts.point_tracks;
  message.line_tracks = result.counts.line_tracks;
  message.scale_sigma = result.scale_sigma;
  for (const GateValue& gate : result.gates) {
    InitGate out;
    out.name = toString(gate.name);
    out.explanation = gate.explanation;
    out.unit = gate.unit;
    out.value = gate.value;
    out.threshold = gate.threshold;
    out.upper_bound = gate.upper_bound;
    out.passed = gate.passed;
    out.enforced = gate.enforced;
    out.exception = gate.exception;
    message.gates.push_back(out);
  }
  for (const StageTime& stage : result.stages) {
    InitStage out;
    out.name = stage.name;
    out.ms = stage.ms;
    message.stages.push_back(out);
  }
  message.total_ms = attempt.total_ms;
  return message;
}

InitResultMessage resultMessage(const Attempt& attempt, const ResultContext& context) {
  const InitResult& result = attempt.result;
  InitResultMessage message;
  message.header.stamp = stampOf(result.states.back(), result, context);
  message.header.frame_id = context.world_frame;
  message.child_frame_id = context.body_frame;
  message.method = context.method;
  message.td = tdOf(result, context);
  message.extrinsic = extrinsicMessage(result, context);
  for (const NavState& state : result.states) {
    message.stamps.push_back(stampOf(state, result, context));
    message.poses.push_back(poseMessage(state));
    message.velocities.push_back(vector3(state.v_w_b));
  }
  message.gravity = vector3(result.gravity_w);
  message.gyro_bias = vector3(result.gyro_bias);
  message.accel_bias = vector3(result.accel_bias);
  message.scale = result.scale;
  message.scale_sigma = result.scale_sigma;
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> covariance =
      result.covariance;
  message.covariance.assign(covariance.data(), covariance.data() + covariance.size());
  message.status = statusMessage(attempt, context);
  return message;
}

nav_msgs::Odometry seedMessage(const Attempt& attempt, const ResultContext& context) {
  const InitResult& result = attempt.result;
  const NavState& state = result.states.back();
  const Eigen::Matrix3d& R = state.R_w_b;
  const Eigen::Vector3d v_b = R.transpose() * state.v_w_b;
  nav_msgs::Odometry message;
  message.header.stamp = stampOf(state, result, context);
  message.header.frame_id = context.world_frame;
  message.child_frame_id = context.body_frame;
  message.pose.pose = poseMessage(state);
  message.twist.twist.linear = vector3(v_b);
  if (result.covariance.size() == 0) return message;

  // [theta, p, v] of the newest keyframe; theta on the body side.
  const int k = 9 * (static_cast<int>(result.states.size()) - 1);
  const Eigen::Matrix<double, 9, 9> P = result.covariance.block<9, 9>(k, k);
  Eigen::Matrix<double, 6, 9> pose = Eigen::Matrix<double, 6, 9>::Zero();
  pose.block<3, 3>(0, 3).setIdentity();
  pose.block<3, 3>(3, 0) = R;  // about the axes of the world
  fill(pose * P * pose.transpose(), &message.pose.covariance);
  Eigen::Matrix<double, 6, 9> twist = Eigen::Matrix<double, 6, 9>::Zero();
  twist.block<3, 3>(0, 0) = host_health::skewOf(v_b);  // v_b = R' v_w
  twist.block<3, 3>(0, 6) = R.transpose();
  fill(twist * P * twist.transpose(), &message.twist.covariance);
  return message;
}

nav_msgs::Path pathMessage(const Attempt& attempt, const ResultContext& context) {
  nav_msgs::Path message;
  message.header.stamp = stampOf(attempt.result.states.back(), attempt.result, context);
  message.header.frame_id = context.world_frame;
  for (const NavState& state : attempt.result.states) {
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = stampOf(state, attempt.result, context);
    pose.header.frame_id = context.world_frame;
    pose.pose = poseMessage(state);
    message.poses.push_back(pose);
  }
  return message;
}

geometry_msgs::Transform extrinsicMessage(const InitResult& result, const ResultContext& context) {
  const Calibration& given = context.calibration;
  return result.calibration ? transformMessage(result.calibration->R_b_c, result.calibration->t_b_c)
                            : transformMessage(given.R_b_c, given.t_b_c);
}

geometry_msgs::Transform transformMessage(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  geometry_msgs::Transform message;
  message.translation = vector3(t);
  message.rotation = quaternion(R);
  return message;
}

visualization_msgs::Marker arrowMarker(const std_msgs::Header& header, const std::string& name,
                                       const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                       float red, float green) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.ns = name;
  marker.type = visualization_msgs::Marker::ARROW;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = 0.02;  // shaft, head, head length [m]
  marker.scale.y = 0.05;
  marker.scale.z = 0.1;
  marker.color.r = red;
  marker.color.g = green;
  marker.color.a = 1.0f;
  marker.points = {vectorMessage<geometry_msgs::Point>(from),
                   vectorMessage<geometry_msgs::Point>(to)};
  return marker;
}

}  // namespace slim_init::node
