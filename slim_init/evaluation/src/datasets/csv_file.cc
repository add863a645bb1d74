// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/csv_file.h"

#include <Eigen/Geometry>

namespace slim_init::evaluation {

std::string CsvFile::open(const std::string& path, const std::string& header) {
  path_ = path;
  file_.open(path, std::ios::binary | std::ios::trunc);
  file_.precision(17);
  file_ << header << "\n";
  return problem();
}

std::string CsvFile::add(std::int64_t stamp_ns, const Eigen::Ref<const Eigen::VectorXd>& values) {
  file_ << stamp_ns;
  for (Eigen::Index i = 0; i < values.size(); ++i) file_ << ',' << values[i];
  file_ << "\n";
  return problem();
}

std::string CsvFile::addText(std::int64_t stamp_ns, const std::string& text) {
  file_ << stamp_ns << "," << text << "\n";
  return problem();
}

std::string CsvFile::finish() {
  file_.close();
  return problem();
}

std::string openTruth(const std::string& path, CsvFile* file) {
  return file->open(path,
                    "#timestamp [ns],p_w_b_x [m],p_w_b_y [m],p_w_b_z [m],q_w_b_w [],q_w_b_x [],"
                    "q_w_b_y [],q_w_b_z [],v_w_b_x [m s^-1],v_w_b_y [m s^-1],v_w_b_z [m s^-1],"
                    "b_g_x [rad s^-1],b_g_y [rad s^-1],b_g_z [rad s^-1],b_a_x [m s^-2],"
                    "b_a_y [m s^-2],b_a_z [m s^-2]");
}

std::string writeTruth(std::int64_t stamp_ns, const NavState& state, CsvFile* file) {
  const Eigen::Quaterniond q(state.R_w_b);
  Eigen::Matrix<double, 16, 1> row;
  row << state.p_w_b, q.w(), q.vec(), state.v_w_b, state.gyro_bias, state.accel_bias;
  return file->add(stamp_ns, row);
}

}  // namespace slim_init::evaluation
