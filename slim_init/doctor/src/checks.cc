// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slim_init::evaluation {

Severity severityAbove(double value, const DoctorOptions::Bound& bound) {
  if (value > bound.fail) return Severity::kError;
  return value > bound.warn ? Severity::kWarning : Severity::kOk;
}

Finding atMost(const char* check, double value, const DoctorOptions::Bound& bound, const char* unit,
               double factor) {
  return {check,        severityAbove(value, bound), factor * value,
          kNotComputed, factor * bound.warn,         unit};
}

Finding atLeast(const char* check, double value, const DoctorOptions::Bound& bound,
                const char* unit, double factor) {
  const Severity known = value >= bound.fail ? Severity::kWarning : Severity::kError;
  const Severity below = std::isnan(value) ? Severity::kNotChecked : known;
  return {check,          value >= bound.warn ? Severity::kOk : below,
          factor * value, factor * bound.warn,
          kNotComputed,   unit};
}

Finding notChecked(const char* check, const char* unit) {
  return {check, Severity::kNotChecked, kNotComputed, kNotComputed, kNotComputed, unit};
}

std::string number(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*g", digits, value);
  // Messages are easier to read without exponents.
  if (std::string(text).find('e') != std::string::npos) {
    const double order = std::floor(std::log10(std::abs(value)));
    std::snprintf(text, sizeof(text), "%.*f", std::max(0, 1 - static_cast<int>(order)), value);
  }
  return text;
}

std::string percent(double share) { return number(100.0 * share) + " %"; }

Finding& add(Findings* findings, Finding finding, const std::string& message,
             const std::string& advice) {
  finding.message = message;
  if (finding.severity != Severity::kOk) finding.advice = advice;
  findings->push_back(std::move(finding));
  return findings->back();
}

Severity DoctorReport::worst() const {
  Severity worst = Severity::kOk;
  for (const Finding& finding : findings) worst = std::max(worst, finding.severity);
  return worst;
}

int DoctorReport::exitCode() const {
  switch (worst()) {
    case Severity::kWarning: return 1;
    case Severity::kError: return 2;
    default: return 0;
  }
}

DoctorReport examine(const DoctorData& data, const DoctorOptions& options) {
  DoctorReport report;
  report.name = data.name;
  report.alignment = alignRotations(data.frames, data.imu, data.calibration);
  report.answers = solveWindows(data, report.alignment, options);
  Findings* findings = &report.findings;
  checkImuStream(data, options, findings);
  checkImageStream(data, options, findings);
  checkImages(data, options, findings);
  checkTracks(data, options, findings);
  checkImuValues(data, report.alignment, options, findings);
  checkImuNoise(data, report.answers, options, findings);
  report.lines = checkRotation(data, report.alignment, report.answers, options, findings);
  checkExcitation(data, report.alignment, report.answers, options, findings);
  checkEstimates(report.answers, options, findings);
  return report;
}

}  // namespace slim_init::evaluation
