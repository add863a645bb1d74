// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "data/derived_window.h"

#include <algorithm>
#include <cmath>

#include "geometry/so3.h"

namespace slim_init {
namespace {

// Tracks of what `judge` keeps, given the index of an observation and a copy that it may change.
template <typename Observation, typename Judge>
void select(const std::vector<Track>& tracks, const std::vector<Observation>& observations,
            const Judge& judge, std::vector<Track>* out_tracks,
            std::vector<Observation>* out_observations) {
  out_tracks->reserve(tracks.size());
  out_observations->reserve(observations.size());
  for (const Track& track : tracks) {
    Track piece;
    piece.id = track.id;
    piece.begin = static_cast<int>(out_observations->size());
    for (int a = track.begin; a < track.end; ++a) {
      Observation observation = observations[a];
      if (judge(a, &observation)) out_observations->push_back(observation);
    }
    piece.end = static_cast<int>(out_observations->size());
    if (piece.size() >= 2) {
      out_tracks->push_back(piece);
    } else {
      out_observations->resize(piece.begin);
    }
  }
}

// Least standard deviations of a calibration that was found: rotation [deg], translation [m], td
// [s]; the readout time [s] is not among what is taken over.
constexpr CalibrationSigmas kLeast = {0.05, 0.001, 1e-4, 0.0};

void narrow(double found, double least, double* sigma) {
  *sigma = std::min(*sigma, std::max(found, least));
}

}  // namespace

Calibration withFound(const Calibration& calibration, const CalibrationEstimate& found) {
  Calibration result = calibration;
  result.R_b_c = nearestRotation(found.R_b_c);
  result.t_b_c = found.t_b_c;
  CalibrationSigmas& sigmas = result.sigmas;
  narrow(found.rotationSigmaDeg(), kLeast.rotation_deg, &sigmas.rotation_deg);
  narrow(std::sqrt(found.covariance.block<3, 3>(3, 3).diagonal().maxCoeff()), kLeast.translation_m,
         &sigmas.translation_m);
  if (found.covariance(6, 6) > 0.0) {
    result.td = found.td;
    narrow(found.tdSigma(), kLeast.td_s, &sigmas.td_s);
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
  int first = 0, last = window.size();
  while (first < last && old.times[first] + shift < old.imu.front().t) ++first;
  while (last > first && old.times[last - 1] + shift > old.imu.back().t) --last;
  if (last - first < 2) return nullptr;

  const auto common = std::make_shared<InitWindow::Common>();
  common->calibration = calibration;
  common->imu = old.imu;
  common->speeds = old.speeds;
  for (int k = first; k < last; ++k) {
    common->times.push_back(old.times[k] + shift);
    common->keyframe_lines.push_back(old.keyframe_lines[k]);
    for (WindowLine& line : common->keyframe_lines.back()) line.keyframe -= first;
  }
  const auto within = [&](int, auto* observation) {
    observation->keyframe -= first;
    return 0 <= observation->keyframe && observation->keyframe < last - first;
  };
  select(old.line_tracks, old.line_observations, within, &common->line_tracks,
         &common->line_observations);
  const std::shared_ptr<InitWindow> out(new InitWindow());
  out->common_ = common;
  select(window.point_tracks_, window.point_observations_, within, &out->point_tracks_,
         &out->point_observations_);
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

std::shared_ptr<const InitWindow> withObservations(const InitWindow& window,
                                                   const std::vector<char>& keep) {
  if (keep.size() != window.point_observations_.size()) return nullptr;
  const std::shared_ptr<InitWindow> out(new InitWindow());
  out->common_ = window.common_;
  const auto judge = [&keep](int a, WindowPoint*) { return keep[a] != kDropObservation; };
  select(window.point_tracks_, window.point_observations_, judge, &out->point_tracks_,
         &out->point_observations_);
  return out;
}

}  // namespace slim_init
