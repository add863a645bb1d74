// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Frames, samples and rigs out of bytes.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "fuzz_target.h"
#include "slim_init/options.h"
#include "slim_init/state_prior.h"
#include "slim_init/types.h"
#include "support/exact_window.h"

namespace slim_init::fuzz {

inline FrameObservation frame(double t, Bytes* bytes) {
  FrameObservation out;
  out.t = t;
  out.points.resize(bytes->below(32));
  for (PointObservation& point : out.points) {
    point.id = bytes->byte() < 250 ? bytes->below(40) : static_cast<FeatureId>(-1);
    point.bearing = bytes->ray();
  }
  out.lines.resize(bytes->below(6));
  for (LineObservation& line : out.lines) {
    line.id = bytes->below(8);
    line.start_bearing = bytes->ray();
    line.end_bearing = bytes->ray();
    line.length_px = bytes->number(100.0);
    line.detection_confidence = bytes->number(1.0);
    line.match_quality = bytes->number(1.0);
  }
  return out;
}

inline ImuSample sample(double t, Bytes* bytes) {
  ImuSample out;
  out.t = t;
  out.gyro = bytes->vector(1.0);
  out.accel = Eigen::Vector3d(0, 0, 9.81) + bytes->vector(5.0);
  return out;
}

/// Mostly a rig that validate() accepts.
inline Calibration rig(Bytes* bytes) {
  Calibration out;
  if (bytes->byte() < 128) return out;
  const Eigen::Vector3d turn = bytes->vector(2.0);
  if (turn.norm() > 1e-6) {
    out.R_b_c = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  out.t_b_c = bytes->vector(0.2);
  out.td = bytes->number(0.05);
  out.sigmas.rotation_deg = std::abs(bytes->number(10.0));
  out.sigmas.td_s = std::abs(bytes->number(0.05));
  out.readout_s = bytes->byte() < 200 ? 0.0 : std::abs(bytes->number(0.03));
  out.sigma_px = std::abs(bytes->number(2.0));
  return out;
}

/// `options` with some of the switches that a user has turned; as they are where the bytes are
/// zero.
inline InitializerOptions switched(InitializerOptions options, Bytes* bytes) {
  SlimOptions& slim = options.slim;
  RefinementOptions& refinement = options.refinement;
  int which = bytes->byte();
  which |= bytes->byte() << 8;
  int bit = 1;
  for (bool* flag :
       {&options.provisional.enabled, &slim.vanishing_points, &slim.prune_tracks, &slim.prune_lines,
        &slim.refine, &refinement.use_lines, &refinement.estimate_accel_bias}) {
    *flag ^= (which & bit) != 0;
    bit <<= 1;
  }
  if ((which & bit) != 0) options.gates.mode = GateMode::kOff;
  return options;
}

/// Mostly what validate() accepts: a covariance made of columns.
inline StatePrior prior(NavState state, Bytes* bytes) {
  StatePrior out;
  state.v_w_b += bytes->vector(1.0);
  state.gyro_bias += bytes->vector(0.1);
  state.accel_bias += bytes->vector(0.5);
  out.state = state;
  Eigen::Matrix<double, 15, 1> sigma;
  for (int i = 0; i < 15; ++i) sigma[i] = 1e-4 + std::abs(bytes->number(0.3));
  out.covariance = sigma.cwiseAbs2().asDiagonal();
  for (int i = bytes->below(4); i > 0; --i) {
    Eigen::Matrix<double, 15, 1> column;
    for (int j = 0; j < 15; ++j) column[j] = bytes->number(0.1);
    out.covariance += column * column.transpose();
  }
  if (bytes->byte() > 250) {
    const int row = bytes->below(15), column = bytes->below(15);
    out.covariance(row, column) = bytes->number(1.0);
  }
  return out;
}

/// Four seconds of flight without errors, a frame each 0.1 s: what is solved, before it is changed.
inline const ExactWindow& flight() {
  static const ExactWindow exact = [] {
    ExactWindowOptions options = atTenHertz(40);
    options.points = 30;
    options.lines = 5;
    options.imu_rate_hz = 100.0;
    return makeExactWindow(options);
  }();
  return exact;
}

/// Changes up to 12 values of frames and samples to anything.
inline void change(std::vector<FrameObservation>* frames, std::vector<ImuSample>* imu,
                   Bytes* bytes) {
  for (int changes = bytes->below(13); changes > 0; --changes) {
    FrameObservation& frame = (*frames)[bytes->below(static_cast<int>(frames->size()))];
    const int sample = (bytes->byte() << 8 | bytes->byte()) % static_cast<int>(imu->size());
    const int point = bytes->below(static_cast<int>(frame.points.size()));
    const int line = bytes->below(static_cast<int>(frame.lines.size()));
    switch (bytes->below(9)) {
      case 0: frame.t += bytes->number(0.2); break;
      case 1: frame.points.resize(point); break;
      case 2: frame.lines.resize(line); break;
      case 3:
        if (!frame.points.empty()) frame.points[point].bearing = bytes->ray();
        break;
      case 4:
        if (!frame.points.empty()) frame.points[point].id = bytes->below(40);
        break;
      case 5:
        if (!frame.lines.empty()) frame.lines[line].end_bearing = bytes->ray();
        break;
      case 6: (*imu)[sample].t += bytes->number(0.1); break;
      case 7: (*imu)[sample].accel += bytes->vector(100.0); break;
      default: (*imu)[sample].gyro += bytes->vector(10.0); break;
    }
  }
}

}  // namespace slim_init::fuzz
