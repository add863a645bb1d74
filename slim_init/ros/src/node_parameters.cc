// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/ros/node_parameters.h"

#include <ros/console.h>

#include <algorithm>

#include "slim_init/text.h"

namespace slim_init::node {
namespace {

const char* kindOf(const std::string&) { return "a text"; }
const char* kindOf(bool) { return "true or false"; }
const char* kindOf(int) { return "a whole number"; }
const char* kindOf(double) { return "a number"; }

}  // namespace

void NodeParameters::problem(const std::string& message) {
  if (problem_.empty()) problem_ = message;
}

template <typename T>
void NodeParameters::read(const std::string& name, T* value) {
  known_.push_back(name);
  if (handle_.hasParam(name) && !handle_.getParam(name, *value)) {
    problem("~" + name + " must be " + kindOf(*value));
  }
  lines_.push_back(text(std::boolalpha, "~", name, ": ", *value));
}

template void NodeParameters::read(const std::string&, std::string*);
template void NodeParameters::read(const std::string&, bool*);
template void NodeParameters::read(const std::string&, int*);
template void NodeParameters::read(const std::string&, double*);

void NodeParameters::acceptUnused(const std::string& name) {
  known_.push_back(name);
  if (handle_.hasParam(name)) lines_.push_back("~" + name + ": accepted, not used");
}

void NodeParameters::readTopic(const std::string& name, std::string* topic) {
  read(name, topic);
  if (topic->empty()) {
    problem(name + " is neither in the configuration file nor set as ~" + name);
  }
}

void NodeParameters::readConfig(Config* config) {
  std::string file, options_file, error;
  read("config_file", &file);
  read("options_file", &options_file);
  if (file.empty()) {
    problem(
        "~config_file is not set: it names the configuration file of the rig (config/README.md)");
  } else if (!loadConfig(file, options_file, config, &error)) {
    problem(error);
  }
  notes_ = config->notes;
}

std::string NodeParameters::check() {
  std::vector<std::string> names;
  handle_.getParamNames(names);
  const std::string prefix = handle_.getNamespace() + "/";
  for (const std::string& name : names) {
    if (name.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string key = name.substr(prefix.size());
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string message = "~" + key + " is not a parameter of this node; it has";
    for (const std::string& known : known_) message += " ~" + known;
    problem(message);
  }
  return problem_;
}

void NodeParameters::log() const {
  for (const std::string& line : lines_) ROS_INFO_STREAM(line);
  for (const std::string& note : notes_) ROS_INFO_STREAM("note: " << note);
}

}  // namespace slim_init::node
