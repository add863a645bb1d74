// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// As much of roscpp as the inserted lines use. Messages stay in this process: publish() keeps them,
// a subscriber is called by hand.
#pragma once

#include <cstdint>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#define ROS_DEBUG(...) ros::ignore(__VA_ARGS__)
#define ROS_WARN(...) ros::ignore(__VA_ARGS__)
#define ROS_INFO_STREAM(text) ros::log("info", (std::ostringstream() << text))
#define ROS_WARN_STREAM(text) ros::log("warn", (std::ostringstream() << text))
#define ROS_ERROR_STREAM(text) ros::log("error", (std::ostringstream() << text))

namespace ros {

template <typename... Ts>
void ignore(const Ts&...) {}

/// "level: text" of everything that was logged.
inline std::vector<std::string>& logged() {
  static std::vector<std::string> lines;
  return lines;
}
inline void log(const char* level, const std::ostream& text) {
  const std::string what = static_cast<const std::ostringstream&>(text).str();
  logged().push_back(std::string(level) + ": " + what);
}

struct Time {
  double seconds = 0.0;
  double toSec() const { return seconds; }
};

/// Texts by topic.
inline std::map<std::string, std::vector<std::string>>& published() {
  static std::map<std::string, std::vector<std::string>> messages;
  return messages;
}

class Publisher {
 public:
  operator void*() const { return topic_.empty() ? nullptr : const_cast<Publisher*>(this); }
  template <typename Message>
  void publish(const Message& message) const {
    published()[topic_].push_back(message.data);
  }
  std::string topic_;
};

class Subscriber {};

/// The master's list of topics.
namespace master {
struct TopicInfo {
  std::string name, datatype;
};
typedef std::vector<TopicInfo> V_TopicInfo;
inline V_TopicInfo& topics() {
  static V_TopicInfo all;
  return all;
}
inline bool getTopics(V_TopicInfo& all) {
  all = topics();
  return true;
}
}  // namespace master

namespace names {
inline std::string resolve(const std::string& name) { return name; }
}  // namespace names

struct WallDuration {
  explicit WallDuration(double) {}
};
struct WallTimerEvent {};

/// Called by hand, as subscribers are.
inline std::vector<std::function<void()>>& timers() {
  static std::vector<std::function<void()>> all;
  return all;
}
struct WallTimer {
  void stop() const { timers().clear(); }
};

/// What a message on a topic calls.
template <typename Pointer>
std::map<std::string, std::function<void(const Pointer&)>>& callbacks() {
  static std::map<std::string, std::function<void(const Pointer&)>> all;
  return all;
}

inline std::map<std::string, std::string>& parameters() {
  static std::map<std::string, std::string> all;
  return all;
}

class NodeHandle {
 public:
  template <typename Message>
  Publisher advertise(const std::string& topic, std::uint32_t, bool /*latch*/ = false) {
    Publisher publisher;
    publisher.topic_ = topic;
    return publisher;
  }
  template <typename Message, typename Object>
  Subscriber subscribe(const std::string& topic, std::uint32_t,
                       void (Object::*callback)(const Message&), Object* object) {
    callbacks<Message>()[topic] = [object, callback](const Message& message) {
      (object->*callback)(message);
    };
    return Subscriber();
  }
  template <typename Object>
  WallTimer createWallTimer(WallDuration, void (Object::*callback)(const WallTimerEvent&),
                            Object* object) const {
    timers().push_back([object, callback] { (object->*callback)(WallTimerEvent()); });
    return WallTimer();
  }
  template <typename Value>
  Value param(const std::string& name, const Value& otherwise) const {
    return parameters().count(name) == 0 ? otherwise : parameters()[name];
  }
};

}  // namespace ros
