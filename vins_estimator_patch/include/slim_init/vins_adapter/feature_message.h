// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The two feature messages and their fields: templates over any type with the members of
// sensor_msgs::PointCloud, so that no ROS header is needed here.
//
//   points  /feature_tracker/feature      VINS-Mono with one camera: points (x, y, 1); channels id,
//                                         u, v, velocity x, velocity y
//   lines   /feature_tracker_lines/lines  points (x, y, 1) of the start; channels kLineChannels
//
// x, y are undistorted normalised image coordinates, u, v pixels. header.stamp is the image's.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slim_init/text.h"
#include "slim_init/types.h"

namespace slim_init::vins_adapter {

/// Channels of the line message, in this order.
inline constexpr const char* kLineChannels[] = {"id",           "end_x",     "end_y",
                                                "start_u",      "start_v",   "end_u",
                                                "end_v",        "length_px", "detection_confidence",
                                                "match_quality"};

/// Channels of the point message in VINS-Mono's order. That host reads them by position and its
/// own tracker leaves the names empty; ours are for people.
inline constexpr const char* kPointChannels[] = {"id_of_point", "u_of_point", "v_of_point",
                                                 "velocity_x_of_point", "velocity_y_of_point"};

/// Channels hold 32-bit floats: larger whole numbers are no longer exact.
inline constexpr FeatureId kMaxMessageId = (FeatureId{1} << 24) - 1;

namespace message_detail {

inline constexpr std::size_t kLineChannelCount = sizeof(kLineChannels) / sizeof(char*);
inline constexpr std::size_t kPointChannelCount = sizeof(kPointChannels) / sizeof(char*);

template <typename... Parts>
bool refuse(std::string* error, const Parts&... parts) {
  if (error != nullptr) *error = text(parts...);
  return false;
}

// Every channel has one value per point; all values and points are finite; z is 1; the stamp is a
// number.
template <typename Cloud>
bool checkCloud(const Cloud& cloud, std::size_t channels, const char* const* names,
                const char* what, std::string* error) {
  if (!std::isfinite(cloud.header.stamp.toSec())) {
    return refuse(error, what, " message: the stamp is not finite");
  }
  if (cloud.channels.size() < channels) {
    return refuse(error, what, " message has ", cloud.channels.size(), " channels, must have ",
                  channels);
  }
  for (std::size_t c = 0; c < channels; ++c) {
    if (cloud.channels[c].values.size() != cloud.points.size()) {
      return refuse(error, what, " message: channel ", c, " (", names[c], ") has ",
                    cloud.channels[c].values.size(), " values for ", cloud.points.size(),
                    " points");
    }
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      if (!std::isfinite(cloud.channels[c].values[i])) {
        return refuse(error, what, " message: channel ", c, " (", names[c], ") of point ", i,
                      " is not finite");
      }
    }
  }
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto& point = cloud.points[i];
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) {
      return refuse(error, what, " message: point ", i, " is not finite");
    }
    if (point.z != 1.0f) {
      return refuse(error, what, " message: z of point ", i, " is ", point.z, ", must be 1");
    }
  }
  return true;
}

// A whole number in [0, kMaxMessageId].
inline bool readId(float value, const char* what, std::size_t i, FeatureId* id,
                   std::string* error) {
  const double rounded = std::floor(static_cast<double>(value) + 0.5);
  if (!(rounded >= 0.0 && rounded <= static_cast<double>(kMaxMessageId)) ||
      std::abs(rounded - static_cast<double>(value)) > 1e-3) {
    return refuse(error, what, " message: id of point ", i, " is ", value,
                  ", must be a whole number in [0, ", kMaxMessageId, "]");
  }
  *id = static_cast<FeatureId>(rounded);
  return true;
}

inline Eigen::Vector3d ray(double x, double y) { return Eigen::Vector3d(x, y, 1.0).normalized(); }

}  // namespace message_detail

/// Reads the point message into t and points of `frame`; its lines stay. Garbage (too few channels,
/// channels of another size than the points, a value that is not finite, z that is not 1, an id
/// that is not a whole number in [0, kMaxMessageId]) is refused: false, `frame` as it was and a
/// message in `error` (may be null).
template <typename Cloud>
bool readPointMessage(const Cloud& cloud, FrameObservation* frame, std::string* error) {
  namespace detail = message_detail;
  constexpr char kWhat[] = "feature";
  if (!detail::checkCloud(cloud, detail::kPointChannelCount, kPointChannels, kWhat, error)) {
    return false;
  }
  std::vector<PointObservation> points;
  points.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    PointObservation point;
    if (!detail::readId(cloud.channels[0].values[i], kWhat, i, &point.id, error)) return false;
    point.bearing = detail::ray(cloud.points[i].x, cloud.points[i].y);
    point.pixel = Eigen::Vector2d(cloud.channels[1].values[i], cloud.channels[2].values[i]);
    points.push_back(point);
  }
  frame->t = cloud.header.stamp.toSec();
  frame->points = std::move(points);
  return true;
}

/// Reads the line message into t and lines of `frame`; its points stay. Refuses garbage as
/// readPointMessage() does, and a channel under another name than kLineChannels has there.
template <typename Cloud>
bool readLineMessage(const Cloud& cloud, FrameObservation* frame, std::string* error) {
  namespace detail = message_detail;
  constexpr char kWhat[] = "line";
  if (!detail::checkCloud(cloud, detail::kLineChannelCount, kLineChannels, kWhat, error)) {
    return false;
  }
  for (std::size_t c = 0; c < detail::kLineChannelCount; ++c) {
    if (cloud.channels[c].name != kLineChannels[c]) {
      return detail::refuse(error, kWhat, " message: channel ", c, " is \"", cloud.channels[c].name,
                            "\", must be \"", kLineChannels[c], "\"");
    }
  }
  std::vector<LineObservation> lines;
  lines.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto value = [&cloud, i](int channel) -> double {
      return cloud.channels[channel].values[i];
    };
    LineObservation line;
    if (!detail::readId(cloud.channels[0].values[i], kWhat, i, &line.id, error)) return false;
    line.start_bearing = detail::ray(cloud.points[i].x, cloud.points[i].y);
    line.end_bearing = detail::ray(value(1), value(2));
    line.start_pixel = Eigen::Vector2d(value(3), value(4));
    line.end_pixel = Eigen::Vector2d(value(5), value(6));
    line.length_px = value(7);
    line.detection_confidence = value(8);
    line.match_quality = value(9);
    lines.push_back(line);
  }
  frame->t = cloud.header.stamp.toSec();
  frame->lines = std::move(lines);
  return true;
}

/// Writes the points of `frame` for a host with one camera; the header is the caller's. A point's
/// velocity on the image plane [1/s] is the difference to `previous` (null, or a point new in
/// `frame`: zero), as that host's own tracker has it. Ids are those of `frame` modulo
/// kMaxMessageId + 1. A bearing that does not point forward cannot be written: false, `cloud` as it
/// was, a message in `error` (may be null).
template <typename Cloud>
bool writePointMessage(const FrameObservation& frame, const FrameObservation* previous,
                       Cloud* cloud, std::string* error);

/// Writes the lines of `frame`; the header is the caller's. Refuses as writePointMessage().
template <typename Cloud>
bool writeLineMessage(const FrameObservation& frame, Cloud* cloud, std::string* error);

namespace message_detail {

// x, y of a bearing that points forward.
inline bool project(const Eigen::Vector3d& bearing, const char* what, FeatureId id,
                    Eigen::Vector2d* xy, std::string* error) {
  if (!bearing.allFinite() || !(bearing.z() > 1e-3 * bearing.norm())) {
    return refuse(error, "bearing of ", what, " ", id, " does not point forward");
  }
  *xy = bearing.head<2>() / bearing.z();
  return true;
}

// Ids begin with 0 again where they no longer fit a float: tracks of so many ids ago have ended.
inline double messageId(FeatureId id) { return static_cast<double>(id & kMaxMessageId); }

// An empty cloud with its channels named.
template <typename Cloud, std::size_t kCount>
void prepare(const char* const (&names)[kCount], std::size_t size, Cloud* cloud) {
  cloud->points.clear();
  cloud->points.reserve(size);
  cloud->channels.clear();
  cloud->channels.resize(kCount);
  for (std::size_t c = 0; c < kCount; ++c) {
    cloud->channels[c].name = names[c];
    cloud->channels[c].values.reserve(size);
  }
}

template <typename Cloud, std::size_t kCount>
void append(const Eigen::Vector2d& xy, const double (&values)[kCount], Cloud* cloud) {
  cloud->points.emplace_back();
  auto& point = cloud->points.back();
  point.x = static_cast<float>(xy.x());
  point.y = static_cast<float>(xy.y());
  point.z = 1.0f;
  for (std::size_t c = 0; c < kCount; ++c) {
    cloud->channels[c].values.push_back(static_cast<float>(values[c]));
  }
}

}  // namespace message_detail

template <typename Cloud>
bool writePointMessage(const FrameObservation& frame, const FrameObservation* previous,
                       Cloud* cloud, std::string* error) {
  namespace detail = message_detail;
  std::unordered_map<FeatureId, Eigen::Vector3d> before;
  double dt = 0.0;
  if (previous != nullptr) {
    dt = frame.t - previous->t;
    for (const PointObservation& point : previous->points) before[point.id] = point.bearing;
  }
  Cloud result = *cloud;
  detail::prepare(kPointChannels, frame.points.size(), &result);
  for (const PointObservation& point : frame.points) {
    Eigen::Vector2d xy;
    if (!detail::project(point.bearing, "point", point.id, &xy, error)) return false;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
    const auto old = before.find(point.id);
    Eigen::Vector2d xy_old;
    if (dt > 0.0 && old != before.end() &&
        detail::project(old->second, "point", point.id, &xy_old, nullptr)) {
      velocity = (xy - xy_old) / dt;
    }
    const double values[] = {detail::messageId(point.id), point.pixel.x(), point.pixel.y(),
                             velocity.x(), velocity.y()};
    detail::append(xy, values, &result);
  }
  *cloud = std::move(result);
  return true;
}

template <typename Cloud>
bool writeLineMessage(const FrameObservation& frame, Cloud* cloud, std::string* error) {
  namespace detail = message_detail;
  Cloud result = *cloud;
  detail::prepare(kLineChannels, frame.lines.size(), &result);
  for (const LineObservation& line : frame.lines) {
    Eigen::Vector2d start, end;
    if (!detail::project(line.start_bearing, "line", line.id, &start, error) ||
        !detail::project(line.end_bearing, "line", line.id, &end, error)) {
      return false;
    }
    const double values[] = {detail::messageId(line.id),
                             end.x(),
                             end.y(),
                             line.start_pixel.x(),
                             line.start_pixel.y(),
                             line.end_pixel.x(),
                             line.end_pixel.y(),
                             line.length_px,
                             line.detection_confidence,
                             line.match_quality};
    detail::append(start, values, &result);
  }
  *cloud = std::move(result);
  return true;
}

}  // namespace slim_init::vins_adapter
