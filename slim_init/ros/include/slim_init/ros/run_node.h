// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <string>

namespace slim_init::node {

/// The main() of a node whose start() returns an empty string, or a message why it cannot run: the
/// program then logs it and exits with code 2.
template <typename Node>
int runNode(int argc, char** argv, const char* name) {
  ros::init(argc, argv, name);
  Node node;
  if (const std::string message = node.start(); !message.empty()) {
    ROS_FATAL_STREAM(message);
    return 2;
  }
  ros::spin();
  return 0;
}

}  // namespace slim_init::node
