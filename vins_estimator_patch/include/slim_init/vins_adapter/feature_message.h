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
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
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

template <typename... Parts>
bool refuse(std::string* error, const Parts&... parts) {
  if (error != nullptr) *error = text(parts...);
  return false;
}

// Every channel has one value per point; all values and points are finite; z is 1; the stamp is a
// number.
template <typename Cloud, std::size_t kChannels>
bool checkCloud(const Cloud& cloud, const char* const (&names)[kChannels], const char* what,
                std::string* error) {
  if (!std::isfinite(cloud.header.stamp.toSec())) {
    return refuse(error, what, " message: the stamp is not finite");
  }
  if (cloud.channels.size() < kChannels) {
    return refuse(error, what, " message has ", cloud.channels.size(), " channels, must have ",
                  kChannels);
  }
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto& values = cloud.channels[c].values;
    if (values.size() != cloud.points.size()) {
      return refuse(error, what, " message: channel ", c, " (", names[c], ") has ", values.size(),
                    " values for ", cloud.points.size(), " points");
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isfinite(values[i])) continue;
      return refuse(error, what, " message: channel ", c, " (", names[c], ") of point ", i,
                    " is not finite");
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

inline Eigen::Vector3d ray(double x, double y) { return Eigen::Vector3d(x, y, 1.0).normalized(); }

// The observations of a cloud that has been checked, each by `fill(bearing of the point, values of
// its channels, observation)`. Their ids are whole numbers in [0, kMaxMessageId].
template <std::size_t kChannels, typename Cloud, typename Observation, typename Fill>
bool readObservations(const Cloud& cloud, const char* what, const Fill& fill,
                      std::vector<Observation>* observations, std::string* error) {
  std::vector<Observation> result(cloud.points.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::array<double, kChannels> values;
    for (std::size_t c = 0; c < kChannels; ++c) values[c] = cloud.channels[c].values[i];
    const double id = std::floor(values[0] + 0.5);
    if (!(id >= 0.0 && id <= static_cast<double>(kMaxMessageId)) ||
        std::abs(id - values[0]) > 1e-3) {
      return refuse(error, what, " message: id of point ", i, " is ", values[0],
                    ", must be a whole number in [0, ", kMaxMessageId, "]");
    }
    result[i].id = static_cast<FeatureId>(id);
    fill(ray(cloud.points[i].x, cloud.points[i].y), values, &result[i]);
  }
  *observations = std::move(result);
  return true;
}

// x, y of a bearing that points forward.
inline bool project(const Eigen::Vector3d& bearing, const char* what, FeatureId id,
                    Eigen::Vector2d* xy, std::string* error) {
  if (!bearing.allFinite() || !(bearing.z() > 1e-3 * bearing.norm())) {
    return refuse(error, "bearing of ", what, " ", id, " does not point forward");
  }
  *xy = bearing.head<2>() / bearing.z();
  return true;
}

// A cloud of `observations`, each by `fill(observation, x and y of its point, values of its
// channels)`, which may refuse. The value of the first channel is the id: ids begin with 0 again
// where they no longer fit a float, since tracks of so many ids ago have ended.
template <typename Observation, std::size_t kChannels, typename Fill, typename Cloud>
bool writeObservations(const std::vector<Observation>& observations,
                       const char* const (&names)[kChannels], const Fill& fill, Cloud* cloud) {
  Cloud result = *cloud;
  result.points.assign(observations.size(), {});
  result.channels.assign(kChannels, {});
  for (std::size_t c = 0; c < kChannels; ++c) result.channels[c].name = names[c];
  for (std::size_t i = 0; i < observations.size(); ++i) {
    Eigen::Vector2d xy;
    std::array<double, kChannels> values;
    if (!fill(observations[i], &xy, &values)) return false;
    values[0] = static_cast<double>(observations[i].id & kMaxMessageId);
    result.points[i].x = static_cast<float>(xy.x());
    result.points[i].y = static_cast<float>(xy.y());
    result.points[i].z = 1.0f;
    for (std::size_t c = 0; c < kChannels; ++c) {
      result.channels[c].values.push_back(static_cast<float>(values[c]));
    }
  }
  *cloud = std::move(result);
  return true;
}

}  // namespace message_detail

/// Reads the point message into t and points of `frame`; its lines stay. Garbage (too few channels,
/// channels of another size than the points, a value that is not finite, z that is not 1, an id
/// that is not a whole number in [0, kMaxMessageId]) is refused: false, `frame` as it was and a
/// message in `error` (may be null).
template <typename Cloud>
bool readPointMessage(const Cloud& cloud, FrameObservation* frame, std::string* error) {
  namespace detail = message_detail;
  constexpr std::size_t kChannels = std::size(kPointChannels);
  const auto fill = [](const Eigen::Vector3d& bearing, const auto& values, auto* point) {
    point->bearing = bearing;
    point->pixel << values[1], values[2];
  };
  if (!detail::checkCloud(cloud, kPointChannels, "feature", error) ||
      !detail::readObservations<kChannels>(cloud, "feature", fill, &frame->points, error)) {
    return false;
  }
  frame->t = cloud.header.stamp.toSec();
  return true;
}

/// Reads the line message into t and lines of `frame`; its points stay. Refuses garbage as
/// readPointMessage() does, and a channel under another name than kLineChannels has there.
template <typename Cloud>
bool readLineMessage(const Cloud& cloud, FrameObservation* frame, std::string* error) {
  namespace detail = message_detail;
  constexpr std::size_t kChannels = std::size(kLineChannels);
  if (!detail::checkCloud(cloud, kLineChannels, "line", error)) return false;
  for (std::size_t c = 0; c < kChannels; ++c) {
    if (cloud.channels[c].name == kLineChannels[c]) continue;
    return detail::refuse(error, "line message: channel ", c, " is \"", cloud.channels[c].name,
                          "\", must be \"", kLineChannels[c], "\"");
  }
  const auto fill = [](const Eigen::Vector3d& bearing, const auto& values, auto* line) {
    line->start_bearing = bearing;
    line->end_bearing = detail::ray(values[1], values[2]);
    line->start_pixel << values[3], values[4];
    line->end_pixel << values[5], values[6];
    line->length_px = values[7];
    line->detection_confidence = values[8];
    line->match_quality = values[9];
  };
  if (!detail::readObservations<kChannels>(cloud, "line", fill, &frame->lines, error)) return false;
  frame->t = cloud.header.stamp.toSec();
  return true;
}

/// Writes the points of `frame` for a host with one camera; the header is the caller's. A point's
/// velocity on the image plane [1/s] is the difference to `previous` (null, or a point new in
/// `frame`: zero), as that host's own tracker has it. Ids are those of `frame` modulo
/// kMaxMessageId + 1. A bearing that does not point forward cannot be written: false, `cloud` as it
/// was, a message in `error` (may be null).
template <typename Cloud>
bool writePointMessage(const FrameObservation& frame, const FrameObservation* previous,
                       Cloud* cloud, std::string* error) {
  using message_detail::project;
  const double dt = previous == nullptr ? 0.0 : frame.t - previous->t;
  std::unordered_map<FeatureId, Eigen::Vector3d> before;
  if (dt > 0.0) {
    for (const PointObservation& point : previous->points) before[point.id] = point.bearing;
  }
  const auto fill = [&](const PointObservation& point, Eigen::Vector2d* xy, auto* values) {
    if (!project(point.bearing, "point", point.id, xy, error)) return false;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero(), xy_old;
    const auto old = before.find(point.id);
    if (old != before.end() && project(old->second, "point", point.id, &xy_old, nullptr)) {
      velocity = (*xy - xy_old) / dt;
    }
    *values = {0.0, point.pixel.x(), point.pixel.y(), velocity.x(), velocity.y()};
    return true;
  };
  return message_detail::writeObservations(frame.points, kPointChannels, fill, cloud);
}

/// Writes the lines of `frame`; the header is the caller's. Refuses as writePointMessage().
template <typename Cloud>
bool writeLineMessage(const FrameObservation& frame, Cloud* cloud, std::string* error) {
  using message_detail::project;
  const auto fill = [error](const LineObservation& line, Eigen::Vector2d* start, auto* values) {
    Eigen::Vector2d end;
    if (!project(line.start_bearing, "line", line.id, start, error) ||
        !project(line.end_bearing, "line", line.id, &end, error)) {
      return false;
    }
    const Eigen::Vector2d &from = line.start_pixel, &to = line.end_pixel;
    *values = {0.0,
               end.x(),
               end.y(),
               from.x(),
               from.y(),
               to.x(),
               to.y(),
               line.length_px,
               line.detection_confidence,
               line.match_quality};
    return true;
  };
  return message_detail::writeObservations(frame.lines, kLineChannels, fill, cloud);
}

}  // namespace slim_init::vins_adapter
