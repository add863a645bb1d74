// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "window_estimates.h"

namespace slim_init::evaluation {

const char* toString(Severity severity) {
  switch (severity) {
    case Severity::kOk: return "ok";
    case Severity::kNote: return "note";
    case Severity::kNotChecked: return "not_checked";
    case Severity::kWarning: return "warning";
    case Severity::kError: return "error";
  }
  return "unknown";
}

Severity severityAbove(double value, const DoctorOptions::Bound& bound) {
  if (value > bound.fail) return Severity::kError;
  return value > bound.warn ? Severity::kWarning : Severity::kOk;
}

Severity severityBelow(double value, const DoctorOptions::Bound& bound) {
  if (value >= bound.warn) return Severity::kOk;
  return value >= bound.fail ? Severity::kWarning : Severity::kError;  // NaN: error
}

std::string number(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*g", digits, value);
  // Messages are easier to read without exponents.
  if (std::string(text).find('e') != std::string::npos) {
    std::snprintf(text, sizeof(text), std::abs(value) < 1.0 ? "%.1g" : "%.0f", value);
  }
  return text;
}

std::string percent(double share) { return number(100.0 * share) + " %"; }

Finding& add(Findings* findings, const char* check, Severity severity, double value,
             const char* unit) {
  Finding finding;
  finding.check = check;
  finding.severity = severity;
  finding.value = value;
  finding.unit = unit;
  findings->push_back(finding);
  return findings->back();
}

void advise(Finding* finding, const std::string& advice) {
  if (finding->severity != Severity::kOk) finding->advice = advice;
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
  checkExcitation(data, report.alignment, options, findings);
  checkEstimates(report.answers, options, findings);
  return report;
}

}  // namespace slim_init::evaluation
