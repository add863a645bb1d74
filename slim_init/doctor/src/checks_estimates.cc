// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What `slim` itself says about the recording.
#include <cmath>

#include "checks.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

/// "12 success, 3 stationary"
std::string statusText(const WindowEstimates& answers) {
  std::string text;
  for (const auto& [status, count] : answers.statuses) {
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + status;
  }
  return text;
}

/// The message of the most frequent status besides success.
std::string commonMessage(const WindowEstimates& answers) {
  std::string message;
  int most = 0;
  for (const auto& [status, first_message] : answers.messages) {
    if (answers.statuses.at(status) <= most) continue;
    most = answers.statuses.at(status);
    message = status + ": " + first_message;
  }
  return message;
}

void checkDensity(const char* check, const char* sensor, const char* unit, const char* key,
                  double measured, double assumed, double data_sheet, double ratio,
                  Findings* findings) {
  Finding f = {check, Severity::kOk, measured, kNotComputed, kNotComputed, unit};
  if (!std::isfinite(measured)) {
    f.severity = Severity::kNotChecked;
    add(findings, f, text("Noise of the ", sensor, " not measured: no window has enough samples"));
    return;
  }
  f.min = data_sheet / ratio;
  f.max = data_sheet * ratio;
  f.message = text("White noise of the ", sensor, ' ', number(measured), ' ', unit, " (", key, ' ',
                   number(data_sheet), "); with the motion slim assumes ", number(assumed));
  if (measured > f.max) {
    f.severity = Severity::kNote;
    f.message += text(": ", number(measured / data_sheet, 2),
                      " times as much. It vibrates, or slim_init.noise.", key, " is too low");
    f.advice =
        "slim measures this and accounts for it. A softer mount of the IMU makes initialization "
        "earlier; the IMU's low-pass filter has to be below half of its rate.";
  } else if (measured < f.min) {
    f.severity = Severity::kNote;
    f.message += ". The configured density seems to be inflated";
    f.advice = text("Give the data sheet's value for slim_init.noise.", key,
                    ": a larger one delays initialization.");
  }
  findings->push_back(f);
}

}  // namespace

void checkEstimates(const WindowEstimates& answers, const DoctorOptions& options,
                    Findings* findings) {
  Finding f = notChecked("starts", "%");
  if (answers.windows == 0) {
    add(findings, f,
        text("No window of ", options.initializer.window.keyframes,
             " keyframes that slim can solve"),
        "Record 20 s or more; images and IMU have to be there at the same time.");
    return;
  }
  constexpr double kPercent = 100.0;
  constexpr int kAcceptedBesideOne = 3;
  const double refused = static_cast<double>(answers.refused) / answers.windows;
  f.value = kPercent * answers.accepted / answers.windows;
  // Twenty seconds are seven windows: one that is refused among accepted ones is no share yet.
  const bool single = answers.refused == 1 && answers.accepted >= kAcceptedBesideOne;
  f.severity = single ? Severity::kOk : severityAbove(refused, options.refused);
  f.message = text("As configured, slim accepts ", answers.accepted, " of ", answers.windows,
                   " windows (", statusText(answers), ')');
  if (std::isfinite(answers.track_noise.measured_px)) {
    f.message += text("; its tracks have a noise of ", number(answers.track_noise.measured_px),
                      " px, ", number(answers.track_noise.assumed_px), " px is assumed");
  }
  if (f.severity != Severity::kOk) {
    f.message += ", most of the others with " + commonMessage(answers);
    f.advice = "Correct what is found above first.";
  } else if (answers.accepted == 0) {
    f.severity = Severity::kNote;
    f.message += ", since " + commonMessage(answers);
    f.advice = "No fault: move the rig back and forth and turn it while it initializes.";
  } else if (2 * answers.with_warnings > answers.accepted) {
    f.severity = Severity::kNote;
    f.message +=
        text("; ", answers.with_warnings, " of them with a warning, the first: ", answers.warning);
  }
  findings->push_back(f);
}

void checkImuNoise(const DoctorData& data, const WindowEstimates& answers,
                   const DoctorOptions& options, Findings* findings) {
  if (data.imu.empty()) return;
  const ImuNoise& sheet = data.calibration.imu_noise;
  checkDensity("gyro_noise", "gyro", "rad/s/sqrt(Hz)", "gyro_density",
               answers.measured_noise.gyro_density, answers.assumed_noise.gyro_density,
               sheet.gyro_density, options.noise_ratio, findings);
  checkDensity("accel_noise", "accelerometer", "m/s^2/sqrt(Hz)", "accel_density",
               answers.measured_noise.accel_density, answers.assumed_noise.accel_density,
               sheet.accel_density, options.noise_ratio, findings);
}

}  // namespace slim_init::evaluation
