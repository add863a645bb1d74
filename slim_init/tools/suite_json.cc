// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "suite_page.h"

namespace slim_init::tools {
namespace {

using Json = nlohmann::json;

Json toJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json toJson(const evaluation::Interval& interval) {
  return {toJson(interval.value), toJson(interval.low), toJson(interval.high)};
}

Json toJson(const evaluation::Comparison& c) {
  return {{"method", c.method},
          {"windows", c.windows},
          {"both_success", c.both_success},
          {"success_rate", toJson(c.success_rate)},
          {"scale_rmse", toJson(c.scale_rmse)},
          {"gravity_rmse_deg", toJson(c.gravity_rmse_deg)},
          {"velocity_rmse", toJson(c.velocity_rmse)},
          {"pose_rmse", toJson(c.pose_rmse)}};
}

}  // namespace

std::string suiteJson(const SuiteReport& report, const std::string& directory) {
  Json json = {{"command", report.command},     {"program", report.program},
               {"processor", report.processor}, {"methods", report.methods},
               {"notes", report.notes},         {"failed", report.failed}};
  Json& cases = json["cases"] = Json::array();
  for (const SuiteResult& result : report.results) {
    const std::string folder = result.entry.folder();
    std::ifstream file(std::filesystem::path(directory) / folder / "summary.json",
                       std::ios::binary);
    const Json summary = Json::parse(file, nullptr, false);
    cases.push_back({{"name", result.entry.name},
                     {"folder", folder},
                     {"group", result.entry.group},
                     {"paper_column", result.entry.paper_column},
                     {"ablation", result.entry.ablation},
                     {"summary", summary.is_discarded() ? Json(nullptr) : summary}});
  }
  Json& groups = json["groups"] = Json::array();
  for (const SuiteGroup& group : report.groups) {
    Json comparisons = Json::array();
    for (const evaluation::Comparison& c : group.comparisons) comparisons.push_back(toJson(c));
    Json members = Json::array();
    for (const SuiteResult* result : group.results) members.push_back(result->entry.folder());
    groups.push_back({{"title", group.title},
                      {"cases", members},
                      {"reference", kReference},
                      {"comparisons", comparisons}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace slim_init::tools
