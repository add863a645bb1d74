// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <unordered_set>

#include "checks.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/text.h"

namespace slim_init::evaluation {

void checkImages(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  int read = 0, wrong_size = 0, black = 0, saturated = 0, with_edges = 0, blurred = 0, repeats = 0;
  std::vector<double> widths;
  for (const ImageFacts& image : data.images) {
    if (!image.right_size) ++wrong_size;
    if (!std::isfinite(image.p99)) continue;
    ++read;
    if (image.p99 <= options.black_level) ++black;
    if (image.saturated > 0.5) ++saturated;
    if (image.repeats) ++repeats;
    if (!std::isfinite(image.blur_px)) continue;
    ++with_edges;
    widths.push_back(image.blur_px);
    if (image.blur_px > options.blur_px) ++blurred;
  }

  const auto check = [&](const char* name, int count, int total, const DoctorOptions::Bound& bound,
                         const std::string& what, const char* advice) {
    const double share = total == 0 ? 0.0 : static_cast<double>(count) / total;
    add(findings, atMost(name, share, bound, "%", 100.0),
        text(count, " of ", total, " images ", what), advice);
  };
  const int total = static_cast<int>(data.images.size());
  check("image_size", wrong_size, total, {0.0, 0.0}, "do not have the configured size",
        "image_width and image_height belong to another camera or another binning; the "
        "intrinsics are then incorrect as well.");
  check("image_black", black, read, options.black,
        "are black (99 % of the pixels at grey level " + number(options.black_level) + " or less)",
        "Check lens cap, exposure, trigger and light; a recording may also have lost the pixels.");
  check("image_white", saturated, read, options.saturated,
        "are white in more than half of their pixels", "Shorten the exposure or lower the gain.");
  check("image_blur", blurred, with_edges, options.blurred,
        "have no edge sharper than " + number(options.blur_px) + " px (median " +
            (widths.empty() ? std::string("-") : number(median(widths), 2)) + " px)",
        "Focus the lens; if it blurs only in motion, shorten the exposure and add light.");
  check("image_repeated", repeats, read, options.repeated_images,
        "equal the previous image in every pixel",
        "The driver publishes old buffers: check its queue and trigger.");
}

void checkTracks(const DoctorData& data, const DoctorOptions& options, Findings* findings) {
  std::vector<double> points, survival, lines;
  std::unordered_set<FeatureId> before;
  for (const FrameObservation& frame : data.frames) {
    std::unordered_set<FeatureId> now;
    int found = 0;
    for (const PointObservation& point : frame.points) {
      now.insert(point.id);
      if (before.count(point.id) > 0) ++found;
    }
    if (!before.empty()) survival.push_back(found / static_cast<double>(before.size()));
    points.push_back(static_cast<double>(frame.points.size()));
    lines.push_back(static_cast<double>(frame.lines.size()));
    before = std::move(now);
  }
  const double count = points.empty() ? 0.0 : median(points);
  add(findings, atLeast("points", count, options.points, ""),
      points.empty() ? "No image could be tracked"
                     : "An image has " + number(count) + " points (median)",
      "Too little texture: check light, focus, exposure and blank walls, and whether a mask or an "
      "incorrect image size hides most of the image.");

  const double share = median(survival);
  add(findings, atLeast("point_survival", share, options.survival, "%", 100.0),
      survival.empty() ? "Survival of points not checked: there are none"
                       : percent(share) + " of the points are found in the next image (median)",
      survival.empty() ? ""
                       : "Images are too far apart, too blurred or too noisy to track: use more "
                         "images per second, a shorter exposure, slower motion.");

  if (!data.lines_enabled) return;
  const double line_count = lines.empty() ? 0.0 : median(lines);
  constexpr double kFewLines = 5.0;  // fewer hardly constrain the rotation
  const bool few = line_count < kFewLines;
  add(findings,
      {"lines", few ? Severity::kNote : Severity::kOk, line_count, kFewLines, kNotComputed, ""},
      "An image has " + number(line_count) + " lines (median)" +
          (few ? ": only points are used" : ""));
}

}  // namespace slim_init::evaluation
