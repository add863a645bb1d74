// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/simulation/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "range_message.h"

namespace slim_init::simulation {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kMinDistance = 1e-6;  // [m]; a ray that starts on a surface does not hit it
constexpr double kFar = std::numeric_limits<double>::infinity();

// Rotation from w to the solid's own axes.
Eigen::Vector3d toOwn(const Solid& solid, const Eigen::Vector3d& v_w) {
  if (solid.yaw_deg == 0.0) return v_w;
  const double c = std::cos(solid.yaw_deg * kPi / 180.0);
  const double s = std::sin(solid.yaw_deg * kPi / 180.0);
  return {c * v_w.x() + s * v_w.y(), -s * v_w.x() + c * v_w.y(), v_w.z()};
}

Eigen::Vector3d toWorld(const Solid& solid, const Eigen::Vector3d& v) {
  if (solid.yaw_deg == 0.0) return v;
  const double c = std::cos(solid.yaw_deg * kPi / 180.0);
  const double s = std::sin(solid.yaw_deg * kPi / 180.0);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
}

// The part of a ray inside a convex solid and the faces where it enters and leaves.
struct Span {
  double enter = -kFar;
  double leave = kFar;
  int enter_face = -1;
  int leave_face = -1;

  bool empty() const { return !(enter <= leave); }
  void cut(double low, double high, int low_face, int high_face) {
    if (low > enter) {
      enter = low;
      enter_face = low_face;
    }
    if (high < leave) {
      leave = high;
      leave_face = high_face;
    }
  }
};

void cutBySlab(const Solid& solid, int axis, const Eigen::Vector3d& o, const Eigen::Vector3d& d,
               Span* span) {
  const double h = solid.half_size[axis];
  if (d[axis] == 0.0) {
    if (std::abs(o[axis]) > h) span->leave = -kFar;
    return;
  }
  const double a = (-h - o[axis]) / d[axis];
  const double b = (h - o[axis]) / d[axis];
  if (a < b) {
    span->cut(a, b, 2 * axis, 2 * axis + 1);
  } else {
    span->cut(b, a, 2 * axis + 1, 2 * axis);
  }
}

void cutByMantle(const Solid& solid, const Eigen::Vector3d& o, const Eigen::Vector3d& d,
                 Span* span) {
  const int i = (solid.axis + 1) % 3;
  const int j = (solid.axis + 2) % 3;
  const Eigen::Vector2d p(o[i] / solid.half_size[i], o[j] / solid.half_size[j]);
  const Eigen::Vector2d v(d[i] / solid.half_size[i], d[j] / solid.half_size[j]);
  const double a = v.squaredNorm();
  const double b = p.dot(v);
  const double c = p.squaredNorm() - 1.0;
  const double discriminant = b * b - a * c;
  if (a == 0.0 ? c > 0.0 : discriminant < 0.0) {
    span->leave = -kFar;
    return;
  }
  if (a == 0.0) return;  // along the axis, inside
  const double root = std::sqrt(discriminant);
  span->cut((-b - root) / a, (-b + root) / a, 6, 6);
}

Span spanOf(const Solid& solid, const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
  Span span;
  if (solid.shape == Shape::kBox) {
    for (int axis = 0; axis < 3 && !span.empty(); ++axis) cutBySlab(solid, axis, o, d, &span);
  } else {
    cutBySlab(solid, solid.axis, o, d, &span);
    if (!span.empty()) cutByMantle(solid, o, d, &span);
  }
  return span;
}

// Outward, in the solid's own axes; `p` is on the surface.
Eigen::Vector3d normalOf(const Solid& solid, int face, const Eigen::Vector3d& p) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  if (face < 6) {
    normal[face / 2] = face % 2 == 1 ? 1.0 : -1.0;
    return normal;
  }
  normal = p.cwiseQuotient(solid.half_size.cwiseAbs2());
  normal[solid.axis] = 0.0;
  return normal.normalized();
}

// Signed distance to a solid; for a cylinder with its smaller radius.
double signedDistance(const Solid& solid, const Eigen::Vector3d& place_w) {
  const Eigen::Vector3d p = toOwn(solid, place_w - solid.center);
  Eigen::Vector3d q = p.cwiseAbs() - solid.half_size;
  if (solid.shape == Shape::kCylinder) {
    const int i = (solid.axis + 1) % 3;
    const int j = (solid.axis + 2) % 3;
    const double scale = std::hypot(p[i] / solid.half_size[i], p[j] / solid.half_size[j]) - 1.0;
    q[i] = scale * std::min(solid.half_size[i], solid.half_size[j]);
    q[j] = -kFar;
  }
  const double inside = std::min(0.0, q.maxCoeff());
  return q.cwiseMax(0.0).norm() + inside;
}

}  // namespace

RayHit Scene::castRay(const Eigen::Vector3d& origin_w, const Eigen::Vector3d& direction_w) const {
  RayHit best;
  const Eigen::Vector3d direction = direction_w.normalized();
  if (!direction.allFinite() || !origin_w.allFinite()) return best;
  best.distance = kFar;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Solid& solid = solids[i];
    const Eigen::Vector3d o = toOwn(solid, origin_w - solid.center);
    const Eigen::Vector3d d = toOwn(solid, direction);
    const Span span = spanOf(solid, o, d);
    if (span.empty()) continue;
    const bool from_outside = span.enter > kMinDistance;
    const double distance = from_outside ? span.enter : span.leave;
    if (!(distance > kMinDistance) || !(distance < best.distance)) continue;
    best.distance = distance;
    best.solid = static_cast<int>(i);
    best.face = from_outside ? span.enter_face : span.leave_face;
    best.normal_w = toWorld(solid, normalOf(solid, best.face, o + distance * d));
  }
  if (!best.hit()) {
    best.distance = 0.0;
    return best;
  }
  best.point_w = origin_w + best.distance * direction;
  return best;
}

bool Scene::visible(const Eigen::Vector3d& from_w, const Eigen::Vector3d& to_w,
                    double tolerance_m) const {
  const RayHit first = castRay(from_w, to_w - from_w);
  return !first.hit() || first.distance >= (to_w - from_w).norm() - tolerance_m;
}

std::vector<SceneEdge> Scene::edges() const {
  // An end on the surface of a neighbouring solid is not inside it.
  constexpr double kInside = -1e-4;  // [m]
  const auto buried = [this](std::size_t self, const Eigen::Vector3d& place_w) {
    for (std::size_t i = 0; i < solids.size(); ++i) {
      if (i != self && signedDistance(solids[i], place_w) < kInside) return true;
    }
    return false;
  };
  std::vector<SceneEdge> list;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Solid& solid = solids[i];
    if (solid.shape != Shape::kBox) continue;
    for (int axis = 0; axis < 3; ++axis) {
      for (int corner = 0; corner < 4; ++corner) {
        Eigen::Vector3d start = solid.half_size;
        start[(axis + 1) % 3] *= corner % 2 == 0 ? -1.0 : 1.0;
        start[(axis + 2) % 3] *= corner / 2 == 0 ? -1.0 : 1.0;
        Eigen::Vector3d end = start;
        start[axis] *= -1.0;
        SceneEdge edge;
        edge.solid = static_cast<int>(i);
        edge.start_w = solid.center + toWorld(solid, start);
        edge.end_w = solid.center + toWorld(solid, end);
        if (buried(i, edge.start_w) && buried(i, edge.end_w)) continue;
        list.push_back(edge);
      }
    }
  }
  return list;
}

double Scene::clearance(const Eigen::Vector3d& place_w) const {
  double nearest = kFar;
  for (const Solid& solid : solids) nearest = std::min(nearest, signedDistance(solid, place_w));
  return nearest;
}

std::string Scene::validate() const {
  constexpr double kMaxLength = 1e4;  // [m]
  std::string message;
  if (solids.empty()) return "solids is empty, must have at least one element";
  requireWithin("ambient", ambient, 0.0, 10.0, &message);
  for (std::size_t i = 0; i < looks.size() && message.empty(); ++i) {
    const std::string name = "looks[" + std::to_string(i) + "].";
    requireWithin((name + "bright").c_str(), looks[i].bright, 0.0, 1.0, &message);
    requireWithin((name + "dark").c_str(), looks[i].dark, 0.0, 1.0, &message);
    requireWithin((name + "size_m").c_str(), looks[i].size_m, 1e-4, 1e3, &message);
    requireWithin((name + "angle_deg").c_str(), looks[i].angle_deg, -360.0, 360.0, &message);
    requireWithin((name + "glow").c_str(), looks[i].glow, 0.0, 10.0, &message);
  }
  for (std::size_t i = 0; i < lights.size() && message.empty(); ++i) {
    const std::string name = "lights[" + std::to_string(i) + "].";
    for (int axis = 0; axis < 3; ++axis) {
      requireWithin((name + "position_w").c_str(), lights[i].position_w[axis], -kMaxLength,
                    kMaxLength, &message);
    }
    requireWithin((name + "brightness").c_str(), lights[i].brightness, 0.0, 100.0, &message);
    requireWithin((name + "reach_m").c_str(), lights[i].reach_m, 1e-3, kMaxLength, &message);
  }
  for (std::size_t i = 0; i < solids.size() && message.empty(); ++i) {
    const std::string name = "solids[" + std::to_string(i) + "].";
    for (int axis = 0; axis < 3; ++axis) {
      requireWithin((name + "center").c_str(), solids[i].center[axis], -kMaxLength, kMaxLength,
                    &message);
      requireWithin((name + "half_size").c_str(), solids[i].half_size[axis], 1e-6, kMaxLength,
                    &message);
    }
    requireWithin((name + "yaw_deg").c_str(), solids[i].yaw_deg, -360.0, 360.0, &message);
    requireWithin((name + "axis").c_str(), solids[i].axis, 0, 2, &message);
    requireWithin((name + "look").c_str(), solids[i].look, 0, static_cast<int>(looks.size()) - 1,
                  &message);
  }
  return message;
}

}  // namespace slim_init::simulation
