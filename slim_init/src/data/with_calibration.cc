// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "data/with_calibration.h"

#include <algorithm>
#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// The keyframes [first, last) of the old window.
struct Selection {
  int first = 0, last = 0;

  bool holds(int keyframe) const { return first <= keyframe && keyframe < last; }
};

template <typename Observation>
void select(const std::vector<Track>& tracks, const std::vector<Observation>& observations,
            const Selection& selection, std::vector<Track>* out_tracks,
            std::vector<Observation>* out_observations) {
  out_tracks->reserve(tracks.size());
  out_observations->reserve(observations.size());
  for (const Track& track : tracks) {
    Track kept;
    kept.id = track.id;
    kept.begin = static_cast<int>(out_observations->size());
    for (int s = track.begin; s < track.end; ++s) {
      if (!selection.holds(observations[s].keyframe)) continue;
      Observation moved = observations[s];
      moved.keyframe -= selection.first;
      out_observations->push_back(moved);
    }
    kept.end = static_cast<int>(out_observations->size());
    if (kept.size() >= 2) {
      out_tracks->push_back(kept);
    } else {
      out_observations->resize(kept.begin);
    }
  }
}

// Least standard deviations of a calibration that was found [deg], [m], [s].
constexpr double kLeastRotationDeg = 0.05;
constexpr double kLeastTranslation = 0.001;
constexpr double kLeastTd = 1e-4;

void narrow(double found, double least, double* sigma) {
  *sigma = std::min(*sigma, std::max(found, least));
}

}  // namespace

Calibration withFound(const Calibration& calibration, const CalibrationEstimate& found) {
  Calibration result = calibration;
  result.R_b_c = nearestRotation(found.R_b_c);
  result.t_b_c = found.t_b_c;
  CalibrationSigmas& sigmas = result.sigmas;
  narrow(found.rotationSigmaDeg(), kLeastRotationDeg, &sigmas.rotation_deg);
  narrow(std::sqrt(found.covariance.block<3, 3>(3, 3).diagonal().maxCoeff()), kLeastTranslation,
         &sigmas.translation_m);
  if (found.covariance(6, 6) > 0.0) {
    result.td = found.td;
    narrow(found.tdSigma(), kLeastTd, &sigmas.td_s);
  }
  return result;
}

std::shared_ptr<const InitWindow> unowned(const InitWindow& window) {
  return std::shared_ptr<const InitWindow>(std::shared_ptr<const InitWindow>(), &window);
}

std::shared_ptr<const InitWindow> withCalibration(const InitWindow& window,
                                                  const Calibration& calibration) {
  if (!calibration.validate().empty()) return nullptr;
  const InitWindow::Common& old = *window.common_;
  const double shift = calibration.td - old.calibration.td;
  Selection selection;
  const int n = window.size();
  while (selection.first < n && old.times[selection.first] + shift < old.imu.front().t) {
    ++selection.first;
  }
  selection.last = n;
  while (selection.last > selection.first &&
         old.times[selection.last - 1] + shift > old.imu.back().t) {
    --selection.last;
  }
  if (selection.last - selection.first < 2) return nullptr;

  const auto common = std::make_shared<InitWindow::Common>();
  common->calibration = calibration;
  common->imu = old.imu;
  common->speeds = old.speeds;
  for (int k = selection.first; k < selection.last; ++k) {
    common->times.push_back(old.times[k] + shift);
    common->keyframe_lines.push_back(old.keyframe_lines[k]);
    for (WindowLine& line : common->keyframe_lines.back()) line.keyframe -= selection.first;
  }
  select(old.line_tracks, old.line_observations, selection, &common->line_tracks,
         &common->line_observations);
  const std::shared_ptr<InitWindow> out(new InitWindow());
  out->common_ = common;
  select(window.point_tracks_, window.point_observations_, selection, &out->point_tracks_,
         &out->point_observations_);
  return out;
}

std::shared_ptr<const InitWindow> withoutBiases(const InitWindow& window, const ImuBiases& biases) {
  const auto common = std::make_shared<InitWindow::Common>(*window.common_);
  common->calibration.imu_biases = ImuBiases();
  for (ImuSample& sample : common->imu) {
    sample.gyro -= biases.gyro;
    sample.accel -= biases.accel;
  }
  const std::shared_ptr<InitWindow> out(new InitWindow(window));
  out->common_ = common;
  return out;
}

std::shared_ptr<const InitWindow> withoutSpeeds(const InitWindow& window) {
  if (window.speeds().empty()) return unowned(window);
  const auto common = std::make_shared<InitWindow::Common>(*window.common_);
  common->speeds.clear();
  const std::shared_ptr<InitWindow> out(new InitWindow(window));
  out->common_ = common;
  return out;
}

}  // namespace slim_init
