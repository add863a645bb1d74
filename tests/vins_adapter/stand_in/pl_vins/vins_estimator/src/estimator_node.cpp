// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The node, without its threads: the test calls process() itself.
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud.h>

#include "estimator.h"
#include "node.h"

Estimator estimator;

void send_imu(const sensor_msgs::ImuConstPtr &imu_msg)
{
    double t = imu_msg->header.stamp.toSec();
    ros::ignore(t);
}

Estimator &hostEstimator()
{
    return estimator;
}

void process(const std::vector<sensor_msgs::ImuConstPtr> &imu, const ImageFeatures &image, double stamp)
{
    sensor_msgs::PointCloudConstPtr img_msg;
    {
        sensor_msgs::PointCloud cloud;
        cloud.header.stamp.seconds = stamp;
        img_msg = std::make_shared<const sensor_msgs::PointCloud>(cloud);
    }
    for (auto &imu_msg : imu)
    {
        send_imu(imu_msg);
    }
    estimator.processImage(image, map<int, vector<pair<int, Vector4d>>>(), img_msg->header);
}

// This node has no restart: its samples come one by one.
void restart(const std::vector<sensor_msgs::ImuConstPtr> &waiting)
{
    for (auto &imu_msg : waiting)
        send_imu(imu_msg);
    estimator.clearState();
    estimator.setParameter();
}

void registerPub(ros::NodeHandle &)
{
}

void startNode()
{
    ros::NodeHandle n;
    registerPub(n);
}
