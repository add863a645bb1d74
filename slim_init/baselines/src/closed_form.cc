// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "closed_form.h"

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "scale/gravity_constrained.h"

namespace slim_init::baselines {
namespace {

// Rows of one track: point_columns f + motion_columns [v_0, g] = rhs.
struct TrackRows {
  Eigen::Matrix<double, Eigen::Dynamic, 3> point_columns;
  Eigen::Matrix<double, Eigen::Dynamic, 7> others;  // [motion columns | rhs]
};

TrackRows rowsOf(const InitWindow& window, const Track& track, const LinearMotion& motion,
                 const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  const Calibration& calibration = window.calibration();
  TrackRows rows;
  rows.point_columns.resize(2 * track.size(), 3);
  rows.others.resize(2 * track.size(), 7);
  for (int i = 0; i < track.size(); ++i) {
    const WindowPoint& observation = window.pointObservations()[track.begin + i];
    const int k = observation.keyframe;
    const Eigen::Vector2d uv = observation.bearing.hnormalized();
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0, 0.0, -uv.x(), 0.0, 1.0, -uv.y();
    projection *= calibration.R_b_c.transpose();
    const Eigen::Matrix<double, 2, 3> Y = projection * R_b0_bk[k].transpose();
    const auto position = motion.position.middleRows<3>(3 * k);
    rows.point_columns.middleRows<2>(2 * i) = Y;
    rows.others.block<2, 3>(2 * i, 0) = -Y * position.leftCols<3>();
    rows.others.block<2, 3>(2 * i, 3) = -Y * position.rightCols<3>();
    rows.others.block<2, 1>(2 * i, 6) =
        Y * motion.position0.segment<3>(3 * k) + projection * calibration.t_b_c;
  }
  return rows;
}

}  // namespace

ClosedForm solveClosedForm(const InitWindow& window, const std::vector<int>& tracks,
                           const LinearMotion& motion,
                           const std::vector<Eigen::Matrix3d>& R_b0_bk) {
  // Q^T of the point's columns: its first three rows give the point, the others are free of it.
  std::vector<Eigen::Matrix3d> R;
  std::vector<Eigen::Matrix<double, 3, 7>> head;
  Eigen::Matrix<double, 7, 7> N = Eigen::Matrix<double, 7, 7>::Zero();
  for (const int t : tracks) {
    TrackRows rows = rowsOf(window, window.pointTracks()[t], motion, R_b0_bk);
    const Eigen::HouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 3>> qr(rows.point_columns);
    rows.others.applyOnTheLeft(qr.householderQ().adjoint());
    R.push_back(qr.matrixQR().topRows<3>().triangularView<Eigen::Upper>());
    head.push_back(rows.others.topRows<3>());
    const auto free_of_point = rows.others.bottomRows(rows.others.rows() - 3);
    N.noalias() += free_of_point.transpose() * free_of_point;
  }

  ClosedForm out;
  Eigen::VectorXd x;
  if (!solveGravityConstrained(N.topLeftCorner<6, 6>(), N.topRightCorner<6, 1>(),
                               window.calibration().gravity_magnitude, &x)) {
    return out;
  }
  out.velocity_b0 = x.head<3>();
  out.gravity_b0 = x.tail<3>();
  for (std::size_t i = 0; i < R.size(); ++i) {
    const Eigen::Vector3d rhs = head[i].col(6) - head[i].leftCols<6>() * x;
    out.points_b0.push_back(R[i].triangularView<Eigen::Upper>().solve(rhs));
  }
  out.valid = true;
  return out;
}

}  // namespace slim_init::baselines
