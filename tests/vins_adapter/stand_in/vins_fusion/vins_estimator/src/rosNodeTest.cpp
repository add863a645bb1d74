// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The node, without its threads: the test calls sync_process() itself.
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud.h>

#include "node.h"

Estimator estimator;

Estimator &hostEstimator()
{
    return estimator;
}

void process(const std::vector<sensor_msgs::ImuConstPtr> &imu, const ImageFeatures &image, double stamp)
{
    for (const sensor_msgs::ImuConstPtr &msg : imu)
    {
        const geometry_msgs::Vector3 &a = msg->linear_acceleration, &w = msg->angular_velocity;
        estimator.processIMU(msg->header.stamp.toSec(), 0.0, Vector3d(a.x, a.y, a.z), Vector3d(w.x, w.y, w.z));
    }
    estimator.processImage(image, stamp);
    {
        std::chrono::milliseconds dura(2);
        ros::ignore(dura);
    }
}

void restart(const std::vector<sensor_msgs::ImuConstPtr> &waiting)
{
    for (const sensor_msgs::ImuConstPtr &msg : waiting)
    {
        const geometry_msgs::Vector3 &a = msg->linear_acceleration, &w = msg->angular_velocity;
        estimator.accBuf.push({msg->header.stamp.toSec(), Vector3d(a.x, a.y, a.z)});
        estimator.gyrBuf.push({msg->header.stamp.toSec(), Vector3d(w.x, w.y, w.z)});
    }
    estimator.clearState();
    estimator.setParameter();
}

void registerPub(ros::NodeHandle &)
{
}

void startNode()
{
    ros::NodeHandle n;
    std::string config_file = n.param<std::string>("config_file", "");
    registerPub(n);
}
