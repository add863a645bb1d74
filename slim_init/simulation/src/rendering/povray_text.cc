// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The scene in POV-Ray's language (version 3.7). Its coordinates are called left-handed, but it
// only adds the vectors that define the camera: with all of them in w, and `up` as the camera's -y,
// nothing is mirrored.
#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "slim_init/simulation/rendering.h"
#include "slim_init/text.h"

namespace slim_init::simulation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::string vec(const Vector3d& v) {
  return roundedText(12, '<', v.x(), ',', v.y(), ',', v.z(), '>');
}

std::string grey(double value) { return text("rgb ", value); }

// A pattern in its own coordinates: x across, y up, z out of the surface.
std::string pigment(const Look& look) {
  const std::string bright = grey(look.bright);
  const std::string dark = grey(look.dark);
  const std::string map = "color_map{[0 " + dark + "][1 " + bright + "]}";
  const double middle = 0.5 * (look.bright + look.dark);
  const double size = look.size_m;
  const std::string scale = text(" scale ", size, "}");
  switch (look.pattern) {
    case Pattern::kPlain: return "pigment{" + bright + "}";
    case Pattern::kPlaster: return "pigment{bozo " + map + scale;
    case Pattern::kGranite: return "pigment{granite " + map + scale;
    case Pattern::kBricks:
      // Bricks differ a little, joints are even. The third size is so large that the surface lies
      // in the middle of one layer.
      return text("pigment{brick pigment{", dark, "} pigment{bozo color_map{[0 ",
                  grey(0.85 * look.bright), "][1 ", grey(std::min(1.0, 1.15 * look.bright)),
                  "]} scale ", 0.3 * size, "} brick_size <", size, ',', 0.3 * size, ",200> mortar ",
                  0.04 * size, " translate 100*z}");
    case Pattern::kTiles:
      return text("pigment{gradient x pigment_map{[0.05 ", dark,
                  "][0.05 gradient y color_map{[0.05 ", dark, "][0.05 ", bright, "]}]}", scale);
    case Pattern::kPlanks:
      return text("pigment{gradient y pigment_map{[0.04 ", dark, "][0.04 bozo color_map{[0.3 ",
                  grey(middle), "][0.7 ", bright,
                  "]} scale <1.5,0.06,1> warp{repeat y*1 offset <7.3,0,3.1>}]}", scale);
    case Pattern::kMosaic: return "pigment{crackle solid " + map + scale;
    case Pattern::kChecker:
      return text("pigment{checker ", dark, " ", bright, " translate 0.5*z scale <", size, ',',
                  size, ",100>}");
    case Pattern::kStripes:
      return text("pigment{gradient x color_map{[0.5 ", dark, "][0.5 ", bright, "]} scale ",
                  2.0 * size, "}");
  }
  return "";
}

// Columns: the pattern's across, up and out in the solid's own axes. Flat solids carry their
// pattern on the large side.
Matrix3d patternAxes(const Solid& solid, double angle_deg) {
  int out = 0;
  solid.half_size.minCoeff(&out);
  if (solid.shape == Shape::kCylinder) out = (solid.axis + 1) % 3;
  Matrix3d axes;
  switch (out) {
    case 0: axes << 0, 0, 1, 1, 0, 0, 0, 1, 0; break;   // y, z, x
    case 1: axes << -1, 0, 0, 0, 0, 1, 0, 1, 0; break;  // -x, z, y
    default: axes << 1, 0, 0, 0, 1, 0, 0, 0, 1; break;  // x, y, z
  }
  return axes * Eigen::AngleAxisd(angle_deg * M_PI / 180.0, Vector3d::UnitZ()).toRotationMatrix();
}

void writeSolid(const Solid& solid, const Look& look, int index, std::ostream& out) {
  const Vector3d& h = solid.half_size;
  if (solid.shape == Shape::kBox) {
    out << "box{" << vec(-h) << ',' << vec(h);
  } else {
    Vector3d end = Vector3d::Zero();
    end[solid.axis] = 1.0;
    out << "cylinder{" << vec(-end) << ',' << vec(end) << ",1 scale " << vec(h);
  }
  out << " texture{T" << solid.look;
  if (look.pattern != Pattern::kPlain) {
    // Solids of one look must not show the same spot of its pattern.
    const Matrix3d axes = patternAxes(solid, look.angle_deg);
    const bool is_regular = look.pattern == Pattern::kBricks || look.pattern == Pattern::kTiles ||
                            look.pattern == Pattern::kChecker ||
                            look.pattern == Pattern::kStripes || look.pattern == Pattern::kPlanks;
    const Vector3d shift = is_regular ? Vector3d::Zero() : Vector3d(3.7 * index, 1.9 * index, 0.0);
    out << " translate " << vec(shift) << " matrix<";
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) out << axes(row, column) << ',';
    }
    out << "0,0,0>";
  }
  out << "}";
  if (solid.yaw_deg != 0.0) {
    const double c = std::cos(solid.yaw_deg * M_PI / 180.0);
    const double s = std::sin(solid.yaw_deg * M_PI / 180.0);
    out << " matrix<" << c << ',' << s << ",0," << -s << ',' << c << ",0,0,0,1,0,0,0>";
  }
  out << " translate " << vec(solid.center) << "}\n";
}

}  // namespace

std::string povrayText(const Scene& scene, const EquidistantView& view,
                       const std::vector<CameraPose>& poses) {
  std::ostringstream out;
  out.precision(12);
  out << "#version 3.7;\n"
      << "global_settings{assumed_gamma 1.0 max_trace_level 1}\n"
      << "background{rgb 0}\n";
  for (std::size_t i = 0; i < scene.looks.size(); ++i) {
    const Look& look = scene.looks[i];
    out << "#declare T" << i << "=texture{" << pigment(look) << " finish{ambient " << scene.ambient
        << " diffuse 1 emission " << (look.glow > 0.0 ? look.glow / std::max(look.bright, 1e-3) : 0)
        << "}}\n";
  }
  for (const Light& light : scene.lights) {
    out << "light_source{" << vec(light.position_w) << ' ' << grey(light.brightness)
        << " fade_distance " << light.reach_m << " fade_power 2 shadowless}\n";
  }
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    const Solid& solid = scene.solids[i];
    writeSolid(solid, scene.looks[solid.look], static_cast<int>(i), out);
  }

  // Four arrays, one element per frame.
  const auto array = [&](const char* name, const auto& value) {
    out << "#declare " << name << "=array[" << poses.size() << "]{";
    for (std::size_t i = 0; i < poses.size(); ++i) out << (i == 0 ? "" : ",\n") << vec(value(i));
    out << "}\n";
  };
  array("Location", [&](std::size_t i) { return poses[i].t_w_c; });
  array("Right", [&](std::size_t i) -> Vector3d { return poses[i].R_w_c.col(0); });
  array("Up", [&](std::size_t i) -> Vector3d { return -poses[i].R_w_c.col(1); });
  array("Forward", [&](std::size_t i) -> Vector3d { return poses[i].R_w_c.col(2); });
  // For a fisheye camera the lengths of `right` and `up` set how much of the circle of `angle` the
  // picture shows.
  const double circle = view.px_per_rad * view.full_angle_rad;
  out << "#declare I=frame_number-1;\n"
      << "camera{fisheye location Location[I] direction Forward[I] right Right[I]*"
      << view.width / circle << " up Up[I]*" << view.height / circle << " angle "
      << view.full_angle_rad * 180.0 / M_PI << "}\n";
  return out.str();
}

}  // namespace slim_init::simulation
