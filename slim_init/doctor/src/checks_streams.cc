// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "checks.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {
namespace {

/// A longer step is a pause of the recording; no message was lost in it [s].
constexpr double kPause = 1.0;

/// Steps of a stream that should be regular.
struct Steps {
  double period = kNotComputed;  ///< median [s]
  double lost = 0.0;             ///< share of the messages that should have been there
  double largest = 0.0;          ///< [s]
  double largest_at = 0.0;       ///< where it begins [s]
  double jitter = 0.0;           ///< robust scatter of the steps over the period
};

Steps stepsOf(const std::vector<double>& times) {
  Steps steps;
  if (times.size() < 2) return steps;
  std::vector<double> sizes;
  for (std::size_t k = 1; k < times.size(); ++k) {
    sizes.push_back(times[k] - times[k - 1]);
    if (sizes.back() > steps.largest) {
      steps.largest = sizes.back();
      steps.largest_at = times[k - 1];
    }
  }
  steps.period = median(sizes);
  if (!(steps.period > 0.0)) return steps;
  double missing = 0.0, slots = 1.0;
  std::vector<double> scatter;
  for (const double size : sizes) {
    slots += size > kPause ? 1.0 : size / steps.period;
    if (size > kPause) continue;
    // A step that is too long stands for the messages that would have fitted into it.
    const double held = std::round(size / steps.period);
    missing += std::max(held - 1.0, 0.0);
    scatter.push_back(std::abs(size / steps.period - std::max(held, 1.0)));
  }
  // Jitter that lengthens one step shortens the next: no more is missing than fits into the whole
  // time.
  const double present = static_cast<double>(times.size());
  missing = std::max(std::min(missing, slots - present), 0.0);
  steps.lost = missing / (present + missing);
  steps.jitter = quantile(scatter, 0.9);
  return steps;
}

int countOf(const Disorder& disorder) {
  return disorder.repeated + disorder.out_of_order + disorder.unreadable;
}

Finding orderOf(const char* check, std::size_t kept, const Disorder& disorder,
                const DoctorOptions& options) {
  const double bad = countOf(disorder);
  const double share = bad / std::max(1.0, bad + static_cast<double>(kept));
  return atMost(check, share, options.disorder, "%", 100.0);
}

/// "31 images, all in order"; `kept`: those that can be used.
std::string orderText(std::size_t kept, const char* what, const Disorder& disorder) {
  if (countOf(disorder) == 0) return text(kept, ' ', what, ", all in order");
  return text(kept, ' ', what, "; in addition, ", disorder.repeated, " repeat a stamp, ",
              disorder.out_of_order, " are out of order, ", disorder.unreadable, " cannot be read");
}

std::string rateText(const char* stream, double rate) {
  const std::string known = number(rate) + " Hz";
  return text("The ", stream, " rate is ", std::isnan(rate) ? "not known: one stamp" : known);
}

}  // namespace

void checkImuStream(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  const std::size_t in_order = data.imu.size() + data.imu_beyond_limit;
  add(findings, orderOf("imu_order", in_order, data.imu_disorder, options),
      orderText(in_order, "IMU samples", data.imu_disorder),
      "Publish every sample once and in order, from one thread, with the time it was taken.");
  std::vector<double> times;
  for (const ImuSample& sample : data.imu) times.push_back(sample.t);
  const Steps steps = stepsOf(times);
  const double rate = 1.0 / steps.period;
  add(findings, atLeast("imu_rate", rate, options.imu_rate, "Hz"), rateText("IMU", rate),
      "Set the driver to 100 Hz or more, better 200 Hz, and check that the topic is the raw one "
      "and "
      "not a throttled copy.");
  add(findings, atMost("imu_lost", steps.lost, options.imu_lost, "%", 100.0),
      percent(steps.lost) + " of the IMU samples are missing",
      "Lost between sensor and recording: larger queues, tcp_nodelay, a faster disk, no USB hub "
      "shared with the camera.");
  // At too low a rate every step is too long, which imu_rate reports.
  const double max_gap = std::max(options.max_imu_gap_s, 3.0 * steps.period);
  Finding& gap =
      add(findings, atMost("imu_gap", steps.largest, warningAt(max_gap), "ms", 1e3),
          "The longest step between IMU samples is " + number(1e3 * steps.largest) + " ms",
          "No initialization window is cut across it. Find out what delayed the driver then.");
  if (gap.severity != Severity::kOk) {
    gap.message += ", " + number(steps.largest_at, 4) + " s after the start";
  }
  add(findings, atMost("imu_jitter", steps.jitter, warningAt(options.max_imu_jitter), "%", 100.0),
      "Nine of ten steps between IMU samples deviate from the period by at most " +
          percent(steps.jitter),
      "The stamps are arrival times, not measurement times: use the sensor's own clock.");
}

void checkImageStream(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  Disorder disorder = data.image_disorder;
  std::size_t readable = data.images_beyond_limit;
  std::vector<double> times;
  for (const ImageFacts& image : data.images) {
    times.push_back(image.t);
    if (std::isfinite(image.p99)) {
      ++readable;
    } else {
      ++disorder.unreadable;
    }
  }
  add(findings, orderOf("image_order", readable, disorder, options),
      orderText(readable, "images", disorder),
      "Publish every image once and in order, with the time of the middle of its exposure.");
  const Steps steps = stepsOf(times);
  const double rate = 1.0 / steps.period;
  add(findings, atLeast("image_rate", rate, options.image_rate, "Hz"), rateText("image", rate),
      "Set the camera to 20 Hz or more; tracks are lost between images that are further apart.");
  add(findings, atMost("images_lost", steps.lost, options.images_lost, "%", 100.0),
      percent(steps.lost) + " of the images are missing, the longest step is " +
          number(1e3 * steps.largest) + " ms",
      "Lost between camera and recording: larger queues, less resolution or rate, a faster disk or "
      "link.");
  const auto outside = std::count_if(times.begin(), times.end(), [&data](double t) {
    const double t_imu = t + data.calibration.td;
    return data.imu.empty() || t_imu < data.imu.front().t || t_imu > data.imu.back().t;
  });
  const double share =
      times.empty() ? 0.0 : static_cast<double>(outside) / static_cast<double>(times.size());
  Finding& clocks =
      add(findings, atMost("clocks", share, options.images_outside_imu, "%", 100.0),
          text(outside, " of ", times.size(), " images lie outside the time of the IMU data"));
  if (clocks.severity == Severity::kOk || data.imu.empty()) return;
  clocks.message += text(": images from ", number(times.front(), 6), " s to ",
                         number(times.back(), 6), " s, IMU from ", number(data.imu.front().t, 6),
                         " s to ", number(data.imu.back().t, 6), " s");
  clocks.advice = "Both need stamps from one clock; one of them may count from its own start-up.";
}

}  // namespace slim_init::evaluation
