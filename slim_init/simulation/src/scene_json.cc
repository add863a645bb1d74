// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "slim_init/simulation/scene.h"

namespace slim_init::simulation {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "slim_init scene 1";

constexpr std::pair<Pattern, const char*> kPatterns[] = {
    {Pattern::kPlain, "plain"},   {Pattern::kPlaster, "plaster"}, {Pattern::kGranite, "granite"},
    {Pattern::kBricks, "bricks"}, {Pattern::kTiles, "tiles"},     {Pattern::kPlanks, "planks"},
    {Pattern::kMosaic, "mosaic"}, {Pattern::kChecker, "checker"}, {Pattern::kStripes, "stripes"},
};

Json toJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Vector3d vectorFrom(const Json& json) {
  if (!json.is_array() || json.size() != 3) throw std::runtime_error("not an array of 3 numbers");
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

Pattern patternFrom(const std::string& name) {
  for (const auto& [pattern, known] : kPatterns) {
    if (name == known) return pattern;
  }
  throw std::runtime_error("pattern '" + name + "' is not known");
}

Scene sceneFrom(const Json& json, std::string* where) {
  Scene scene;
  *where = "format";
  if (json.at("format") != kFormat) {
    throw std::runtime_error(std::string("must be \"") + kFormat + "\"");
  }
  *where = "kind";
  scene.kind = json.at("kind").get<std::string>();
  *where = "hull";
  scene.hull.min = vectorFrom(json.at("hull").at("min"));
  scene.hull.max = vectorFrom(json.at("hull").at("max"));
  *where = "ambient";
  scene.ambient = json.at("ambient").get<double>();
  const auto each = [&json, where](const char* name, const auto& read) {
    const Json& list = json.at(name);
    for (std::size_t i = 0; i < list.size(); ++i) {
      *where = std::string(name) + "[" + std::to_string(i) + "]";
      read(list.at(i));
    }
  };
  each("looks", [&](const Json& j) {
    Look look;
    look.pattern = patternFrom(j.at("pattern").get<std::string>());
    look.bright = j.at("bright").get<double>();
    look.dark = j.at("dark").get<double>();
    look.size_m = j.at("size_m").get<double>();
    look.angle_deg = j.at("angle_deg").get<double>();
    look.glow = j.at("glow").get<double>();
    scene.looks.push_back(look);
  });
  each("lights", [&](const Json& j) {
    scene.lights.push_back({vectorFrom(j.at("position_w")), j.at("brightness").get<double>(),
                            j.at("reach_m").get<double>()});
  });
  each("solids", [&](const Json& j) {
    Solid solid;
    solid.name = j.at("name").get<std::string>();
    const std::string shape = j.at("shape").get<std::string>();
    if (shape != "box" && shape != "cylinder") {
      throw std::runtime_error("shape '" + shape + "' is not known");
    }
    solid.shape = shape == "box" ? Shape::kBox : Shape::kCylinder;
    solid.center = vectorFrom(j.at("center"));
    solid.half_size = vectorFrom(j.at("half_size"));
    solid.yaw_deg = j.at("yaw_deg").get<double>();
    solid.axis = j.at("axis").get<int>();
    solid.look = j.at("look").get<int>();
    scene.solids.push_back(solid);
  });
  *where = "";
  return scene;
}

}  // namespace

std::string sceneToJson(const Scene& scene) {
  Json json = {{"format", kFormat},
               {"kind", scene.kind},
               {"hull", {{"min", toJson(scene.hull.min)}, {"max", toJson(scene.hull.max)}}},
               {"ambient", scene.ambient},
               {"looks", Json::array()},
               {"lights", Json::array()},
               {"solids", Json::array()}};
  for (const Look& look : scene.looks) {
    const char* pattern = "";
    for (const auto& [known, name] : kPatterns) {
      if (known == look.pattern) pattern = name;
    }
    json["looks"].push_back({{"pattern", pattern},
                             {"bright", look.bright},
                             {"dark", look.dark},
                             {"size_m", look.size_m},
                             {"angle_deg", look.angle_deg},
                             {"glow", look.glow}});
  }
  for (const Light& light : scene.lights) {
    json["lights"].push_back({{"position_w", toJson(light.position_w)},
                              {"brightness", light.brightness},
                              {"reach_m", light.reach_m}});
  }
  for (const Solid& solid : scene.solids) {
    json["solids"].push_back({{"name", solid.name},
                              {"shape", solid.shape == Shape::kBox ? "box" : "cylinder"},
                              {"center", toJson(solid.center)},
                              {"half_size", toJson(solid.half_size)},
                              {"yaw_deg", solid.yaw_deg},
                              {"axis", solid.axis},
                              {"look", solid.look}});
  }
  return json.dump(1) + "\n";
}

bool sceneFromJson(const std::string& text, Scene* scene, std::string* error) {
  std::string where;
  try {
    Scene read = sceneFrom(Json::parse(text), &where);
    if (const std::string message = read.validate(); !message.empty()) {
      if (error != nullptr) *error = message;
      return false;
    }
    *scene = std::move(read);
    return true;
  } catch (const std::exception& problem) {
    if (error != nullptr) {
      *error = (where.empty() ? "not a scene: " : where + ": ") + std::string(problem.what());
    }
    return false;
  }
}

}  // namespace slim_init::simulation
