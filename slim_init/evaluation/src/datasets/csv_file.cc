// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "datasets/truth_csv.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>

namespace slim_init::evaluation {

std::string CsvFile::open(const std::string& path, const std::string& header) {
  path_ = path;
  last_ns_ = -1;
  file_.open(path, std::ios::binary | std::ios::trunc);
  file_ << header << "\n";
  return file_.good() ? "" : path + " cannot be written";
}

std::string CsvFile::checkStamp(std::int64_t stamp_ns) {
  if (stamp_ns <= last_ns_) {
    return path_ + ": stamp " + std::to_string(stamp_ns) + " ns must be " +
           (last_ns_ < 0 ? "at least 0" : "after the " + std::to_string(last_ns_) + " ns before");
  }
  last_ns_ = stamp_ns;
  return "";
}

std::string CsvFile::add(std::int64_t stamp_ns, const std::vector<double>& values) {
  if (std::string problem = checkStamp(stamp_ns); !problem.empty()) return problem;
  std::string row = std::to_string(stamp_ns);
  for (const double value : values) {
    if (!std::isfinite(value)) {
      return path_ + ": a value at " + std::to_string(stamp_ns) + " ns is not finite";
    }
    char text[32];
    std::snprintf(text, sizeof(text), ",%.17g", value);
    row += text;
  }
  file_ << row << "\n";
  return file_.good() ? "" : path_ + " cannot be written";
}

std::string CsvFile::addText(std::int64_t stamp_ns, const std::string& text) {
  if (std::string problem = checkStamp(stamp_ns); !problem.empty()) return problem;
  file_ << stamp_ns << "," << text << "\n";
  return file_.good() ? "" : path_ + " cannot be written";
}

std::string CsvFile::finish() {
  file_.close();
  return file_.good() ? "" : path_ + " cannot be written";
}

std::string TruthCsv::open(const std::string& path) {
  return file_.open(path,
                    "#timestamp [ns],p_w_b_x [m],p_w_b_y [m],p_w_b_z [m],q_w_b_w [],q_w_b_x [],"
                    "q_w_b_y [],q_w_b_z [],v_w_b_x [m s^-1],v_w_b_y [m s^-1],v_w_b_z [m s^-1],"
                    "b_g_x [rad s^-1],b_g_y [rad s^-1],b_g_z [rad s^-1],b_a_x [m s^-2],"
                    "b_a_y [m s^-2],b_a_z [m s^-2]");
}

std::string TruthCsv::add(std::int64_t stamp_ns, const NavState& state) {
  const Eigen::Quaterniond q(state.R_w_b);
  const Eigen::Vector3d& p = state.p_w_b;
  const Eigen::Vector3d& v = state.v_w_b;
  const Eigen::Vector3d& bg = state.gyro_bias;
  const Eigen::Vector3d& ba = state.accel_bias;
  return file_.add(stamp_ns, {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(),
                              bg.x(), bg.y(), bg.z(), ba.x(), ba.y(), ba.z()});
}

}  // namespace slim_init::evaluation
