// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// What the stand-ins share: the parts that a host's estimator holds and its state, reduced to what
// slim_init touches. A stand-in may define before it
//   STAND_IN_FEATURE_SIZE    numbers per tracked point, 7 by default
//   STAND_IN_FEATURE_EXTRA   members of a feature that only this host has
//   STAND_IN_MANAGER_EXTRA   members of the feature manager that only this host has
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <list>
#include <map>
#include <utility>
#include <vector>

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

const int WINDOW_SIZE = 10;

// The host's parameters, as its file has them.
extern int ESTIMATE_EXTRINSIC, ESTIMATE_TD;
extern double TD;
extern std::vector<Matrix3d> RIC;
extern std::vector<Vector3d> TIC;

#ifndef STAND_IN_FEATURE_SIZE
#define STAND_IN_FEATURE_SIZE 7
#endif
typedef Eigen::Matrix<double, STAND_IN_FEATURE_SIZE, 1> FeatureVector;
typedef std::map<int, std::vector<std::pair<int, FeatureVector>>> ImageFeatures;

/// Counts its deletions: a prior must not stay, nor be deleted twice.
struct MarginalizationInfo {
  static int& deleted() {
    static int count = 0;
    return count;
  }
  ~MarginalizationInfo() { ++deleted(); }
};

/// Keeps what it was given.
struct IntegrationBase {
  IntegrationBase() = default;
  IntegrationBase(const Vector3d& first_accel, const Vector3d& first_gyro, const Vector3d& new_ba,
                  const Vector3d& new_bg)
      : accel{first_accel}, gyro{first_gyro}, ba(new_ba), bg(new_bg) {}
  void push_back(double dt, const Vector3d& new_accel, const Vector3d& new_gyro) {
    sum_dt += dt;
    accel.push_back(new_accel);
    gyro.push_back(new_gyro);
  }
  std::vector<Vector3d> accel, gyro;
  double sum_dt = 0.0;
  Vector3d ba = Vector3d::Zero(), bg = Vector3d::Zero();
  Eigen::Matrix<double, 15, 15> covariance = Eigen::Matrix<double, 15, 15>::Zero();
  void repropagate(const Vector3d& new_ba, const Vector3d& new_bg) {
    ba = new_ba;
    bg = new_bg;
  }
};

struct FeaturePerFrame {
  Vector3d point;
};

struct Feature {
  int feature_id = 0;
  int start_frame = 0;
  std::vector<FeaturePerFrame> feature_per_frame;
  double estimated_depth = 5.0;
  int solve_flag = 1;
#ifdef STAND_IN_FEATURE_EXTRA
  STAND_IN_FEATURE_EXTRA
#endif
};

struct FeatureManager {
  std::list<Feature> feature;
  Matrix3d ric = Matrix3d::Zero();
  int triangulations = 0;
#ifdef STAND_IN_MANAGER_EXTRA
  STAND_IN_MANAGER_EXTRA
#endif
  void setRic(Matrix3d new_ric[]) { ric = new_ric[0]; }
  void triangulate(int, Vector3d[], Matrix3d[], Vector3d[], Matrix3d[]) { ++triangulations; }
};

/// The time offset that most hosts estimate; PL-VINS has none.
struct TimeOffset {
  double td = 0.0;
  void resetTd() { td = TD; }
};
struct NoTimeOffset {
  void resetTd() {}
};

/// The members that are alike in all hosts. `Header` is what the window keeps of a frame.
template <typename Header, int kCameras, typename Offset = TimeOffset>
class EstimatorParts : public Offset {
 public:
  enum SolverFlag { INITIAL, NON_LINEAR };
  enum MarginalizationFlag { MARGIN_OLD = 0, MARGIN_SECOND_NEW = 1 };

  EstimatorParts() {
    for (IntegrationBase*& pre_integration : pre_integrations)
      pre_integration = new IntegrationBase;
    clearParts();
    resets = 0;
  }
  ~EstimatorParts() {
    for (IntegrationBase* pre_integration : pre_integrations) delete pre_integration;
    delete last_marginalization_info;
  }
  EstimatorParts(const EstimatorParts&) = delete;
  EstimatorParts& operator=(const EstimatorParts&) = delete;

  void setParameter() {
    ric[0] = RIC[0];
    tic[0] = TIC[0];
    this->resetTd();
  }
  void clearParts() {
    for (int i = 0; i <= WINDOW_SIZE; i++) {
      Ps[i].setZero();
      Vs[i].setZero();
      Rs[i].setIdentity();
      Bas[i].setZero();
      Bgs[i].setZero();
    }
    ric[0].setIdentity();
    tic[0].setZero();
    solver_flag = INITIAL;
    marginalization_flag = MARGIN_SECOND_NEW;
    frame_count = 0;
    initial_timestamp = 0.0;
    failure_occur = false;
    resets++;
  }
  bool initialStructure() {
    stock_tries++;
    return stock_succeeds;
  }
  bool failureDetection() {
    compared_to = last_P;
    return fails-- > 0;
  }
  void optimization() { optimizations++; }
  void slideWindow() {
    const int first = marginalization_flag == MARGIN_OLD ? 0 : WINDOW_SIZE - 1;
    for (int i = first; i < WINDOW_SIZE; i++) {
      Headers[i] = Headers[i + 1];
      Ps[i] = Ps[i + 1];
      Vs[i] = Vs[i + 1];
      Rs[i] = Rs[i + 1];
      Bas[i] = Bas[i + 1];
      Bgs[i] = Bgs[i + 1];
    }
  }

  SolverFlag solver_flag;
  MarginalizationFlag marginalization_flag;
  Vector3d g;
  Matrix3d ric[kCameras];
  Vector3d tic[kCameras];
  Vector3d Ps[(WINDOW_SIZE + 1)];
  Vector3d Vs[(WINDOW_SIZE + 1)];
  Matrix3d Rs[(WINDOW_SIZE + 1)];
  Vector3d Bas[(WINDOW_SIZE + 1)];
  Vector3d Bgs[(WINDOW_SIZE + 1)];
  Matrix3d last_R, last_R0;
  Vector3d last_P, last_P0;
  Header Headers[(WINDOW_SIZE + 1)];
  IntegrationBase* pre_integrations[(WINDOW_SIZE + 1)];
  Vector3d acc_0, gyr_0;
  std::vector<double> dt_buf[(WINDOW_SIZE + 1)];
  std::vector<Vector3d> linear_acceleration_buf[(WINDOW_SIZE + 1)];
  std::vector<Vector3d> angular_velocity_buf[(WINDOW_SIZE + 1)];
  int frame_count;
  FeatureManager f_manager;
  bool failure_occur;
  double initial_timestamp;
  double para_Pose[WINDOW_SIZE + 1][7];  // position, then quaternion x, y, z, w
  MarginalizationInfo* last_marginalization_info = nullptr;
  std::vector<double*> last_marginalization_parameter_blocks;

  // For the test: what it plays, and what was seen.
  MarginalizationFlag next_flag = MARGIN_OLD;
  bool stock_succeeds = false;
  int fails = 0;                              // this many calls of failureDetection()
  Vector3d compared_to = Vector3d::Zero();    // last_P at its last call
  Matrix3d host_turn = Matrix3d::Identity();  // by which the host turns its optimized window
  int stock_tries = 0, resets = 0, optimizations = 0;
};
