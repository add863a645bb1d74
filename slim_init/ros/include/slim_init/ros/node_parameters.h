// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Private parameters of a node: every one is named, typed, logged once; unknown ones are refused.
// And its main().
#pragma once

#include <ros/ros.h>

#include <string>
#include <vector>

#include "slim_init/config/config.h"

namespace slim_init::node {

/// Private parameters of a node: read and logged once, unknown ones refused.
class NodeParameters {
 public:
  explicit NodeParameters(const ros::NodeHandle& private_handle) : handle_(private_handle) {}

  /// Reads ~name where it is set, else leaves `value` as its default. A value of another type is
  /// the problem that check() returns. Of a text, a switch or a number.
  template <typename T>
  void read(const std::string& name, T* value);

  /// A parameter that launch files of another node pass, in whose place this one can stand: not
  /// refused and of no effect.
  void acceptUnused(const std::string& name);

  /// A topic that the configuration names or ~name; neither is a problem.
  void readTopic(const std::string& name, std::string* topic);

  /// Reads ~config_file (required) and ~options_file into `config`.
  void readConfig(Config* config);

  /// After the last read(): an empty string, or a message about the first problem: an incorrect
  /// type, a file that cannot be used, a private parameter that was not read.
  std::string check();

  /// Logs all values, one line each, and the notes of the configuration.
  void log() const;

 private:
  void problem(const std::string& message);

  ros::NodeHandle handle_;
  std::vector<std::string> known_;
  std::vector<std::string> lines_;
  std::vector<std::string> notes_;
  std::string problem_;
};

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
