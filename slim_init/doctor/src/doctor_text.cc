// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The doctor's report as a table and as JSON.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "checks.h"

namespace slim_init::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kColumns = 100;

std::string withUnit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : text + " " + unit;
}

std::string boundText(const Finding& f) {
  const bool min = std::isfinite(f.min), max = std::isfinite(f.max);
  if (min && max) return withUnit(number(f.min) + " to " + number(f.max), f.unit);
  if (min) return withUnit("minimum " + number(f.min), f.unit);
  if (max) return withUnit("limit " + number(f.max), f.unit);
  return "";
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

/// Breaks at spaces so that no line is longer than kColumns.
std::string wrapped(const std::string& text, std::size_t indent, const std::string& mark) {
  std::istringstream words(text);
  std::string line = std::string(indent, ' ') + mark;
  const std::size_t hanging = line.size();
  std::string result;
  bool empty = true;
  for (std::string word; words >> word;) {
    if (!empty && line.size() + 1 + word.size() > kColumns) {
      result += line + "\n";
      line = std::string(hanging, ' ');
      empty = true;
    }
    line += (empty ? "" : " ") + word;
    empty = false;
  }
  return result + line + "\n";
}

struct SeverityText {
  const char *name, *label, *color;
};
const SeverityText& textOf(Severity severity) {
  // In the order of Severity.
  static constexpr SeverityText kTexts[] = {{"ok", "ok", "\033[32m"},
                                            {"note", "note", "\033[36m"},
                                            {"not_checked", "not checked", "\033[36m"},
                                            {"warning", "WARNING", "\033[33m"},
                                            {"error", "ERROR", "\033[31m"}};
  return kTexts[static_cast<int>(severity)];
}

std::string countText(const DoctorReport& report, Severity severity, const char* one,
                      const char* many) {
  const auto count = std::count_if(report.findings.begin(), report.findings.end(),
                                   [=](const Finding& f) { return f.severity == severity; });
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// NaN is no JSON.
Json jsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

const char* toString(Severity severity) { return textOf(severity).name; }

std::string doctorText(const DoctorReport& report, bool color) {
  std::string text = report.name + ": " + countText(report, Severity::kError, "error", "errors") +
                     ", " + countText(report, Severity::kWarning, "warning", "warnings") + ", " +
                     countText(report, Severity::kNotChecked, "check", "checks") +
                     " not possible\n";
  constexpr std::size_t kLabel = 13, kCheck = 23, kValue = 25;
  for (const Finding& f : report.findings) {
    const SeverityText& style = textOf(f.severity);
    const std::string label = padded(style.label, kLabel);
    const std::string value = std::isfinite(f.value) ? withUnit(number(f.value), f.unit) : "-";
    std::string line = "  " + (color ? style.color + label + "\033[0m" : label) +
                       padded(f.check, kCheck) + padded(value, kValue) + boundText(f);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
    if (f.severity == Severity::kOk) continue;
    text += wrapped(f.message + ".", 2 + kLabel, "");
    if (!f.advice.empty()) text += wrapped(f.advice, 2 + kLabel, "-> ");
  }
  if (!report.lines.empty())
    text += "Lines for the configuration file, in place of those that it has:\n" + report.lines;
  return text;
}

std::string doctorJson(const DoctorReport& report) {
  Json json = {{"sequence", report.name},
               {"exit_code", report.exitCode()},
               {"worst", toString(report.worst())}};
  json["findings"] = Json::array();
  for (const Finding& f : report.findings) {
    json["findings"].push_back({{"check", f.check},
                                {"severity", toString(f.severity)},
                                {"value", jsonNumber(f.value)},
                                {"min", jsonNumber(f.min)},
                                {"max", jsonNumber(f.max)},
                                {"unit", f.unit},
                                {"message", f.message},
                                {"advice", f.advice}});
  }
  json["lines"] = report.lines;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace slim_init::evaluation
