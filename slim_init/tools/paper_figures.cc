// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "paper_figures.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "slim_init/types.h"

namespace slim_init::tools {
namespace {

constexpr std::size_t kSequences = 11;

struct AccuracyRow {
  PaperMetric metric;
  const char* method;
  std::array<double, kSequences> printed;
  double average;
};

constexpr AccuracyRow kTableI[] = {
    {PaperMetric::kScale,
     "vins",
     {0.151, 0.153, 0.187, 0.182, 0.225, 0.222, 0.182, 0.260, 0.170, 0.161, 0.255},
     0.195},
    {PaperMetric::kScale,
     "openvins",
     {0.137, 0.121, 0.111, 0.151, 0.161, 0.125, 0.101, 0.151, 0.149, 0.117, 0.118},
     0.131},
    {PaperMetric::kScale,
     "drt-l",
     {0.120, 0.124, 0.119, 0.157, 0.178, 0.127, 0.091, 0.187, 0.137, 0.112, 0.142},
     0.136},
    {PaperMetric::kScale,
     "slim-paper",
     {0.092, 0.100, 0.116, 0.144, 0.161, 0.100, 0.085, 0.189, 0.104, 0.083, 0.149},
     0.120},
    {PaperMetric::kGravityDeg,
     "vins",
     {1.409, 1.130, 2.261, 1.940, 1.629, 3.417, 1.007, 1.378, 1.363, 1.615, 1.505},
     1.696},
    {PaperMetric::kGravityDeg,
     "openvins",
     {1.931, 1.558, 2.239, 1.758, 2.326, 3.332, 3.255, 3.946, 1.835, 3.251, 4.760},
     2.745},
    {PaperMetric::kGravityDeg,
     "drt-l",
     {0.948, 0.968, 0.917, 1.062, 0.943, 3.250, 0.914, 2.547, 1.096, 1.149, 1.218},
     1.365},
    {PaperMetric::kGravityDeg,
     "slim-paper",
     {0.944, 0.933, 0.912, 0.993, 0.907, 3.224, 0.937, 2.158, 1.096, 1.142, 1.176},
     1.311},
    {PaperMetric::kVelocity,
     "vins",
     {0.077, 0.084, 0.184, 0.148, 0.200, 0.087, 0.160, 0.165, 0.057, 0.091, 0.138},
     0.126},
    {PaperMetric::kVelocity,
     "openvins",
     {0.153, 0.111, 0.250, 0.186, 0.200, 0.109, 0.338, 0.184, 0.150, 0.280, 0.148},
     0.192},
    {PaperMetric::kVelocity,
     "drt-l",
     {0.060, 0.066, 0.131, 0.192, 0.163, 0.058, 0.093, 0.229, 0.052, 0.076, 0.127},
     0.113},
    {PaperMetric::kVelocity,
     "slim-paper",
     {0.054, 0.056, 0.126, 0.162, 0.140, 0.042, 0.084, 0.209, 0.039, 0.068, 0.116},
     0.100},
    {PaperMetric::kPose,
     "vins",
     {0.074, 0.087, 0.180, 0.151, 0.205, 0.078, 0.171, 0.172, 0.054, 0.083, 0.116},
     0.125},
    {PaperMetric::kPose,
     "openvins",
     {0.103, 0.087, 0.163, 0.179, 0.188, 0.073, 0.174, 0.117, 0.117, 0.147, 0.109},
     0.132},
    {PaperMetric::kPose,
     "drt-l",
     {0.071, 0.081, 0.163, 0.260, 0.213, 0.067, 0.102, 0.157, 0.056, 0.084, 0.134},
     0.126},
    {PaperMetric::kPose,
     "slim-paper",
     {0.063, 0.069, 0.161, 0.214, 0.185, 0.048, 0.084, 0.155, 0.041, 0.067, 0.123},
     0.110},
};

/// A printed figure with one or two names: method, group or variant.
struct Printed {
  const char* name;
  const char* group;
  double value;
};

constexpr Printed kTableII[] = {
    {"vins", "Machine Hall", 63.84},  {"openvins", "Machine Hall", 60.22},
    {"drt-l", "Machine Hall", 91.77}, {"slim-paper", "Machine Hall", 94.01},
    {"vins", "Vicon Room 1", 22.97},  {"openvins", "Vicon Room 1", 62.90},
    {"drt-l", "Vicon Room 1", 72.08}, {"slim-paper", "Vicon Room 1", 73.14},
    {"vins", "Vicon Room 2", 28.78},  {"openvins", "Vicon Room 2", 59.35},
    {"drt-l", "Vicon Room 2", 71.51}, {"slim-paper", "Vicon Room 2", 72.11},
};

constexpr Printed kGyroBias[] = {{"slim-paper", "", 1.913}, {"slim-paper[no-vp]", "", 1.941}};

constexpr Printed kFig6[] = {{"slim-paper", "", 4.141},
                             {"drt-l", "", 4.150},
                             {"vins", "", 29.615},
                             {"openvins", "", 284.715}};

/// Scale, gravity [deg], velocity [m/s], pose [m], in the order of PaperMetric.
struct DegenerateRow {
  const char* name;
  std::array<double, 4> printed;
};

constexpr DegenerateRow kTableIII[] = {{"drt-l", {0.166, 4.212, 0.254, 0.216}},
                                       {"slim-paper", {0.151, 4.137, 0.240, 0.206}}};

constexpr DegenerateRow kTableIV[] = {
    {"slim-paper[no-lines]", {0.166, 4.212, 0.254, 0.216}},
    {"slim-paper[no-line-epipolar]", {0.162, 4.142, 0.245, 0.215}},
    {"slim-paper[no-line-normal]", {0.158, 4.196, 0.245, 0.212}},
    {"slim-paper", {0.151, 4.137, 0.240, 0.206}}};

template <std::size_t N>
double find(const Printed (&table)[N], const std::string& name, const std::string& group = "") {
  for (const Printed& entry : table) {
    if (entry.name == name && entry.group == group) return entry.value;
  }
  return kNotComputed;
}

template <std::size_t N>
double find(const DegenerateRow (&table)[N], const std::string& name, PaperMetric metric) {
  for (const DegenerateRow& row : table) {
    if (row.name == name) return row.printed[static_cast<std::size_t>(metric)];
  }
  return kNotComputed;
}

const AccuracyRow* findRow(PaperMetric metric, const std::string& method) {
  const auto* row =
      std::find_if(std::begin(kTableI), std::end(kTableI), [&](const AccuracyRow& candidate) {
        return candidate.metric == metric && candidate.method == method;
      });
  return row == std::end(kTableI) ? nullptr : row;
}

}  // namespace

const std::vector<std::string>& paperSequences() {
  static const std::vector<std::string> kNames = {"MH_01", "MH_02", "MH_03", "MH_04",
                                                  "MH_05", "V1_01", "V1_02", "V1_03",
                                                  "V2_01", "V2_02", "V2_03"};
  return kNames;
}

double paperAccuracy(PaperMetric metric, const std::string& method, const std::string& sequence) {
  const AccuracyRow* row = findRow(metric, method);
  const auto& names = paperSequences();
  const auto column = std::find(names.begin(), names.end(), sequence);
  if (row == nullptr || column == names.end()) return kNotComputed;
  return row->printed[static_cast<std::size_t>(column - names.begin())];
}

double paperAccuracyAverage(PaperMetric metric, const std::string& method) {
  const AccuracyRow* row = findRow(metric, method);
  return row == nullptr ? kNotComputed : row->average;
}

double paperSuccess(const std::string& method, const std::string& group) {
  return find(kTableII, method, group);
}

double paperDegenerate(PaperMetric metric, const std::string& method) {
  return find(kTableIII, method, metric);
}

double paperAblation(PaperMetric metric, const std::string& variant) {
  return find(kTableIV, variant, metric);
}

double paperGyroBiasPct(const std::string& variant) { return find(kGyroBias, variant); }

double paperSolveMs(const std::string& method) { return find(kFig6, method); }

}  // namespace slim_init::tools
