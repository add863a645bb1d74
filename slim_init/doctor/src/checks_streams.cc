// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "checks.h"
#include "slim_init/evaluation/statistics.h"

namespace slim_init::evaluation {
namespace {

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
  double missing = 0.0;
  std::vector<double> scatter;
  for (const double size : sizes) {
    // A step that is too long stands for the messages that would have fitted into it.
    const double held = std::round(size / steps.period);
    missing += std::max(held - 1.0, 0.0);
    scatter.push_back(std::abs(size / steps.period - std::max(held, 1.0)));
  }
  // Jitter that lengthens one step shortens the next: no more is missing than fits into the whole
  // time.
  const double slots = (times.back() - times.front()) / steps.period + 1.0;
  const double present = static_cast<double>(times.size());
  missing = std::max(std::min(missing, slots - present), 0.0);
  steps.lost = missing / (present + missing);
  steps.jitter = quantile(scatter, 0.9);
  return steps;
}

void checkOrder(const char* check, const char* what, const StreamCounts& counts, std::size_t kept,
                const DoctorOptions& options, const char* advice, Findings* findings) {
  const int bad = counts.repeated + counts.out_of_order + counts.unreadable;
  const double share = static_cast<double>(bad) /
                       std::max(1.0, static_cast<double>(bad) + static_cast<double>(kept));
  Finding& f = add(findings, check, severityAbove(share, options.disorder), 100.0 * share, "%");
  f.max = 100.0 * options.disorder.warn;
  f.message = std::to_string(kept) + " " + what;
  if (bad == 0) {
    f.message += ", all in order";
    return;
  }
  f.message += "; in addition, " + std::to_string(counts.repeated) + " repeat a stamp, " +
               std::to_string(counts.out_of_order) + " are out of order, " +
               std::to_string(counts.unreadable) + " cannot be read";
  f.advice = advice;
}

}  // namespace

void checkImuStream(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  checkOrder("imu_order", "IMU samples", data.imu_counts, data.imu.size(), options,
             "Publish every sample once and in order, from one thread, with the time it was taken.",
             findings);
  std::vector<double> times;
  for (const ImuSample& sample : data.imu) times.push_back(sample.t);
  const Steps steps = stepsOf(times);
  const double rate = 1.0 / steps.period;

  Finding& r = add(findings, "imu_rate", severityBelow(rate, options.imu_rate), rate, "Hz");
  r.min = options.imu_rate.warn;
  r.message = "The IMU rate is " + number(rate) + " Hz";
  advise(&r,
         "Set the driver to 100 Hz or more, better 200 Hz, and check that the topic is the "
         "raw one and not a throttled copy.");

  Finding& l = add(findings, "imu_lost", severityAbove(steps.lost, options.imu_lost),
                   100.0 * steps.lost, "%");
  l.max = 100.0 * options.imu_lost.warn;
  l.message = percent(steps.lost) + " of the IMU samples are missing";
  advise(&l,
         "Lost between sensor and recording: larger queues, tcp_nodelay, a faster disk, no "
         "USB hub shared with the camera.");

  // At too low a rate every step is too long, which imu_rate reports.
  const double max_gap = std::max(options.max_imu_gap_s, 3.0 * steps.period);
  const Severity gap = steps.largest > max_gap ? Severity::kWarning : Severity::kOk;
  Finding& g = add(findings, "imu_gap", gap, 1e3 * steps.largest, "ms");
  g.max = 1e3 * max_gap;
  g.message = "The longest step between IMU samples is " + number(1e3 * steps.largest) + " ms";
  if (gap != Severity::kOk) {
    g.message += ", " + number(steps.largest_at, 4) + " s after the start";
    g.advice = "No initialization window is cut across it. Find out what delayed the driver then.";
  }

  const Severity jitter =
      steps.jitter > options.max_imu_jitter ? Severity::kWarning : Severity::kOk;
  Finding& j = add(findings, "imu_jitter", jitter, 100.0 * steps.jitter, "%");
  j.max = 100.0 * options.max_imu_jitter;
  j.message = "Nine of ten steps between IMU samples deviate from the period by at most " +
              percent(steps.jitter);
  advise(&j, "The stamps are arrival times, not measurement times: use the sensor's own clock.");
}

void checkImageStream(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  StreamCounts counts = data.image_counts;
  std::size_t readable = 0;
  std::vector<double> times;
  for (const ImageFacts& image : data.images) {
    times.push_back(image.t);
    if (std::isfinite(image.p99)) {
      ++readable;
    } else {
      ++counts.unreadable;
    }
  }
  checkOrder("image_order", "images", counts, readable, options,
             "Publish every image once and in order, with the time of the middle of its exposure.",
             findings);
  const Steps steps = stepsOf(times);
  const double rate = 1.0 / steps.period;
  Finding& r = add(findings, "image_rate", severityBelow(rate, options.image_rate), rate, "Hz");
  r.min = options.image_rate.warn;
  r.message = "The image rate is " + number(rate) + " Hz";
  advise(&r,
         "Set the camera to 20 Hz or more; tracks are lost between images that are further apart.");
  Finding& l = add(findings, "images_lost", severityAbove(steps.lost, options.images_lost),
                   100.0 * steps.lost, "%");
  l.max = 100.0 * options.images_lost.warn;
  l.message = percent(steps.lost) + " of the images are missing, the longest step is " +
              number(1e3 * steps.largest) + " ms";
  advise(&l,
         "Lost between camera and recording: larger queues, less resolution or rate, a "
         "faster disk or link.");

  int outside = 0;
  for (const double t : times) {
    const double t_imu = t + data.calibration.td;
    if (data.imu.empty() || t_imu < data.imu.front().t || t_imu > data.imu.back().t) ++outside;
  }
  const double share = times.empty() ? 0.0 : outside / static_cast<double>(times.size());
  Finding& c =
      add(findings, "clocks", severityAbove(share, options.images_outside_imu), 100.0 * share, "%");
  c.max = 100.0 * options.images_outside_imu.warn;
  c.message = std::to_string(outside) + " of " + std::to_string(times.size()) +
              " images lie outside the time of the IMU data";
  if (c.severity != Severity::kOk && !data.imu.empty()) {
    c.message += ": images from " + number(times.front(), 6) + " s to " + number(times.back(), 6) +
                 " s, IMU from " + number(data.imu.front().t, 6) + " s to " +
                 number(data.imu.back().t, 6) + " s";
    c.advice = "Both need stamps from one clock; one of them may count from its own start-up.";
  }
}

}  // namespace slim_init::evaluation
