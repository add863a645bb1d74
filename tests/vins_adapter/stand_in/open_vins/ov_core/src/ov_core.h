// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The types of OpenVINS that the inserted lines meet, as far as they touch them.
#pragma once

#include <Eigen/Core>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#define PRINT_INFO(...) \
  std::snprintf(ov_core::line, sizeof(ov_core::line), __VA_ARGS__), ov_core::print()

namespace ov_core {

extern char line[2000];
extern std::vector<std::string> printed;
void print();

struct ImuData {
  double timestamp;
  Eigen::Matrix<double, 3, 1> wm;
  Eigen::Matrix<double, 3, 1> am;
};

class Feature {
 public:
  std::size_t featid;
  std::unordered_map<std::size_t, std::vector<Eigen::VectorXf>> uvs;
  std::unordered_map<std::size_t, std::vector<Eigen::VectorXf>> uvs_norm;
  std::unordered_map<std::size_t, std::vector<double>> timestamps;
};

class FeatureDatabase {
 public:
  std::unordered_map<std::size_t, std::shared_ptr<Feature>> get_internal_data() { return features; }
  std::unordered_map<std::size_t, std::shared_ptr<Feature>> features;
};

class TrackBase {
 public:
  std::shared_ptr<FeatureDatabase> get_feature_database() { return database; }
  std::shared_ptr<FeatureDatabase> database = std::make_shared<FeatureDatabase>();
};

class CamBase {
 public:
  Eigen::MatrixXd get_value() { return value; }
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(8, 1);
};

class YamlParser {
 public:
  std::string get_config_folder() { return folder; }
  void parse_config(const std::string& name, std::string& result, bool required = true) {
    if (texts.count(name) > 0) result = texts[name];
    found_all = found_all && (!required || texts.count(name) > 0);
  }
  void parse_config(const std::string& name, bool& result) {
    if (texts.count(name) > 0) result = texts[name] == "true";
  }
  std::string folder;
  std::map<std::string, std::string> texts;
  bool found_all = true;
};

}  // namespace ov_core

namespace ov_type {
class Type {};
class PoseJPL : public Type {};
class IMU;
}  // namespace ov_type
