// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The node, without its threads: the test calls process() itself.
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud.h>

#include <mutex>
#include <queue>

#include "estimator.h"
#include "node.h"

Estimator estimator;
std::queue<sensor_msgs::ImuConstPtr> imu_buf;
std::mutex m_buf, m_estimator;
double last_imu_t = 0;

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
        double t = imu_msg->header.stamp.toSec();
        double img_t = img_msg->header.stamp.toSec() + estimator.td;
        (void)t;
        (void)img_t;
    }
    estimator.processImage(image, img_msg->header);
}

void imu_callback(const sensor_msgs::ImuConstPtr &imu_msg)
{
    if (imu_msg->header.stamp.toSec() <= last_imu_t)
    {
        ROS_WARN("imu message in disorder!");
        return;
    }
    last_imu_t = imu_msg->header.stamp.toSec();
    imu_buf.push(imu_msg);
}

void restart(const std::vector<sensor_msgs::ImuConstPtr> &waiting)
{
    for (auto &imu_msg : waiting)
        imu_callback(imu_msg);
    ROS_WARN("restart the estimator!");
    imu_buf = std::queue<sensor_msgs::ImuConstPtr>();
    estimator.clearState();
    estimator.setParameter();
    last_imu_t = 0;
}

void registerPub(ros::NodeHandle &)
{
}

void startNode()
{
    ros::NodeHandle n;
    registerPub(n);
}
