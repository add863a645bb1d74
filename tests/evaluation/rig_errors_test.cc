// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/rig_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "evaluation/circle_sequence.h"
#include "slim_init/evaluation/metrics.h"
#include "slim_init/evaluation/protocol.h"
#include "slim_init/evaluation/statistics.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

constexpr double kRadToDeg = 57.29577951308232;

Calibration someTruth() {
  Calibration truth;
  truth.R_b_c = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  truth.t_b_c = Eigen::Vector3d(0.1, -0.2, 0.3);
  truth.td = 0.005;
  truth.readout_s = 0.02;
  return truth;
}

TEST(RigErrors, NoneLeaveTheCalibrationAsItIs) {
  const Calibration truth = someTruth();
  const Calibration assumed = assumedCalibration(truth, RigErrors(), kAllTrials);
  EXPECT_EQ(assumed.R_b_c, truth.R_b_c);
  EXPECT_EQ(assumed.td, truth.td);
  EXPECT_EQ(assumed.readout_s, truth.readout_s);
  EXPECT_FALSE(RigErrors().any());
}

TEST(RigErrors, TheTruthIsTheCalibrationPlusTheError) {
  RigErrors errors;
  errors.td_s = 0.012;
  errors.extrinsic_deg = 3.0;
  errors.readout_s = -0.005;
  const Calibration truth = someTruth();
  const Calibration assumed = assumedCalibration(truth, errors, kAllTrials);
  EXPECT_NEAR(truth.td, assumed.td + 0.012, 1e-15);
  EXPECT_NEAR(assumed.readout_s, 0.015, 1e-15);
  EXPECT_EQ(assumed.t_b_c, truth.t_b_c);
  const CalibrationDifference difference = calibrationDifference(assumed, truth);
  EXPECT_NEAR(difference.td_s, -0.012, 1e-15);
  EXPECT_NEAR(difference.rotation_deg, 3.0, 1e-9);
  EXPECT_NEAR(difference.readout_s, -0.005, 1e-15);
  // One axis for all trials, another one with another seed.
  EXPECT_EQ(assumedCalibration(truth, errors, 7).R_b_c, assumed.R_b_c);
  errors.seed = 2;
  EXPECT_GT((assumedCalibration(truth, errors, kAllTrials).R_b_c - assumed.R_b_c).norm(), 1e-3);
  errors.readout_s = -truth.readout_s;
  EXPECT_EQ(assumedCalibration(truth, errors, kAllTrials).readout_s, 0.0);
}

// Uniform over the whole range, every trial on its own, the same again with the same seed.
TEST(RigErrors, RandomRigsAreUniform) {
  RigErrors errors;
  errors.td_s = -0.05;  // the sign does not matter
  errors.extrinsic_deg = 10.0;
  errors.random = true;
  const Calibration truth = someTruth();
  constexpr int kTrials = 4000;
  double td_sum = 0.0, td_square = 0.0, deg_sum = 0.0, td_most = 0.0, deg_most = 0.0;
  Eigen::Vector3d axis_sum = Eigen::Vector3d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    const Calibration assumed = assumedCalibration(truth, errors, trial);
    const CalibrationDifference d = calibrationDifference(assumed, truth);
    td_sum += d.td_s;
    td_square += d.td_s * d.td_s;
    td_most = std::max(td_most, std::abs(d.td_s));
    deg_sum += d.rotation_deg;
    deg_most = std::max(deg_most, d.rotation_deg);
    axis_sum += Eigen::AngleAxisd(truth.R_b_c.transpose() * assumed.R_b_c).axis();
    EXPECT_EQ(assumedCalibration(truth, errors, trial).R_b_c, assumed.R_b_c);
  }
  // Four standard deviations of the means of uniform variables.
  const double n = kTrials;
  EXPECT_NEAR(td_sum / n, 0.0, 4.0 * 0.05 / std::sqrt(3.0 * n));
  EXPECT_NEAR(td_square / n, 0.05 * 0.05 / 3.0, 4.0 * 0.05 * 0.05 * std::sqrt(4.0 / 45.0 / n));
  EXPECT_NEAR(deg_sum / n, 5.0, 4.0 * 10.0 / std::sqrt(12.0 * n));
  EXPECT_LT(axis_sum.norm() / n, 4.0 / std::sqrt(n));
  EXPECT_TRUE(td_most <= 0.05 && td_most > 0.0495) << td_most;
  EXPECT_TRUE(deg_most <= 10.0 + 1e-9 && deg_most > 9.9) << deg_most;
  // Nothing of it for all trials alike, as the front end is told.
  EXPECT_EQ(assumedCalibration(truth, errors, kAllTrials).td, truth.td);
}

// The rows are where they are, whatever readout time is given; nobody needs to have declared one.
TEST(RigErrors, AReadoutTimeCanBeWrongOrNotDeclared) {
  Sequence sequence = makeCircleSequence(1.0);
  sequence.calibration.readout_s = 0.02;
  for (FrameObservation& frame : sequence.frames) {
    for (PointObservation& point : frame.points) point.row = 0.2;
  }
  for (const double error : {0.005, -0.02}) {
    RigErrors errors;
    errors.readout_s = error;
    Sequence wrong = sequence;
    ASSERT_EQ(applyRigErrors(errors, &wrong), "");
    EXPECT_NEAR(wrong.calibration.readout_s, 0.02 + error, 1e-15);
    EXPECT_EQ(wrong.trueCalibration().readout_s, 0.02);
    EXPECT_EQ(wrong.frames[3].points[1].row, 0.2);
  }
}

TEST(RigErrors, SaysWhatCannotBe) {
  Sequence sequence = makeCircleSequence(1.0);
  RigErrors errors;
  errors.imu_rate_hz = 400.0;
  EXPECT_EQ(applyRigErrors(errors, &sequence),
            "--imu-rate is 400, must be at most 200, the rate of the IMU data");
  errors = RigErrors();
  errors.readout_s = 0.005;
  expectParts(applyRigErrors(errors, &sequence), "global shutter");
  sequence.calibration.readout_s = 0.01;
  errors.readout_s = -0.02;
  expectParts(applyRigErrors(errors, &sequence), "readout_s is -0.02, must be at least -0.01");
  errors = RigErrors();
  errors.td_s = -0.5;
  sequence.calibration.td = 0.9;
  expectParts(applyRigErrors(errors, &sequence), "td is 1.4");
}

// The circle at 200 Hz from zero on, with a change to each sample.
template <typename Change>
std::vector<ImuSample> circleImu(int last, const Change& change) {
  std::vector<ImuSample> imu;
  for (int k = 0; k <= last; ++k) {
    imu.push_back(Circle().imu(k / 200.0));
    change(k, &imu.back());
  }
  return imu;
}

// The same after a change of the rate.
std::vector<ImuSample> atRate(double rate_hz, std::vector<ImuSample> imu) {
  RigErrors errors;
  errors.imu_rate_hz = rate_hz;
  EXPECT_EQ(disturbImu(errors, &imu), "");
  return imu;
}

// A vibration at half the sampling rate averages out; picked samples would make a bias of it. The
// recorded rate is left as it is.
TEST(DisturbImu, ALowerRateAveragesVibration) {
  const auto vibrating = circleImu(
      1000, [](int k, ImuSample* sample) { sample->accel.z() += k % 2 == 0 ? 5.0 : -5.0; });
  const auto slow = atRate(100.0, vibrating), same = atRate(200.0, vibrating);
  ASSERT_EQ(slow.size(), 501u);
  for (std::size_t k = 1; k + 1 < slow.size(); ++k) {
    EXPECT_NEAR(slow[k].accel.z(), Circle().g, 1e-9) << k;
  }
  EXPECT_EQ(atRate(208.0, vibrating).size(), 1041u) << "an IMU that runs 4 % slow is no error";
  ASSERT_EQ(same.size(), vibrating.size());
  for (std::size_t k = 0; k < same.size(); ++k) {
    EXPECT_NEAR(same[k].accel.z(), vibrating[k].accel.z(), 1e-9) << k;
  }
}

TEST(DisturbImu, ALowerRateIsInterpolated) {
  // Linear: interpolation is exact.
  const auto imu = atRate(
      90.0, circleImu(2000, [](int, ImuSample* sample) { sample->accel.x() = 3.0 * sample->t; }));
  ASSERT_EQ(imu.size(), 901u);
  for (std::size_t k = 0; k < imu.size(); ++k) {
    EXPECT_NEAR(imu[k].t, static_cast<double>(k) / 90.0, 1e-12);
    EXPECT_NEAR(imu[k].accel.x(), 3.0 * imu[k].t, 1e-12);
  }
}

// What is not there cannot be interpolated.
TEST(DisturbImu, AGapStaysOne) {
  std::vector<ImuSample> imu = circleImu(400, [](int, ImuSample*) {});
  imu.erase(imu.begin() + 101, imu.begin() + 160);  // from 0.505 to 0.795 s
  imu = atRate(100.0, imu);
  double longest = 0.0;
  for (std::size_t k = 1; k < imu.size(); ++k) longest = std::max(longest, imu[k].t - imu[k - 1].t);
  // And no mean reaches into it.
  EXPECT_GE(longest, 0.3);
  EXPECT_LE(longest, 0.3 + 2 * 0.0101);
  // A bad first stamp is a gap of decades, which takes no time.
  const std::size_t samples = imu.size();
  imu.front().t -= 1.4e9;
  EXPECT_NEAR(static_cast<double>(atRate(100.0, imu).size()), static_cast<double>(samples), 5.0);
}

TEST(DisturbImu, JitterKeepsTheOrderAndDropoutItsShare) {
  const std::vector<ImuSample> clean = circleImu(20000, [](int, ImuSample*) {});
  RigErrors errors;
  errors.imu_jitter_s = 0.001;
  std::vector<ImuSample> imu = clean;
  ASSERT_EQ(disturbImu(errors, &imu), "");
  ASSERT_EQ(imu.size(), clean.size());
  std::vector<double> off;
  for (std::size_t k = 0; k < imu.size(); ++k) {
    off.push_back(imu[k].t - clean[k].t);
    EXPECT_EQ(imu[k].gyro, clean[k].gyro);
    EXPECT_LE(std::abs(off.back()), 0.45 * 0.005 + 1e-12);
    if (k > 0) {
      ASSERT_GT(imu[k].t, imu[k - 1].t);
    }
  }
  // Cutting off at 2.25 standard deviations takes 3.5 % of it.
  EXPECT_NEAR(rootMeanSquare(off), 0.001, 5e-5);
  EXPECT_NEAR(std::accumulate(off.begin(), off.end(), 0.0) / off.size(), 0.0, 4e-5);

  errors = RigErrors();
  errors.imu_dropout = 0.1;
  imu = clean;
  ASSERT_EQ(disturbImu(errors, &imu), "");
  const double kept = static_cast<double>(imu.size()) / static_cast<double>(clean.size());
  EXPECT_NEAR(kept, 0.9, 4.0 * std::sqrt(0.09 / 20001.0));
  std::vector<ImuSample> again = clean;
  ASSERT_EQ(disturbImu(errors, &again), "");
  EXPECT_EQ(again.size(), imu.size());
}

TEST(TruthAt, IsThatOfTheSequence) {
  Sequence sequence = makeCircleSequence(2.0);
  EXPECT_EQ(truthAt(sequence, 0.51).p_w_b, Circle().state(0.51).p_w_b);
  EXPECT_TRUE(std::isnan(truthAt(sequence, -0.01).t));
  EXPECT_TRUE(std::isnan(truthAt(sequence, 2.01).t));
  EXPECT_TRUE(std::isnan(truthAt(sequence, kNotComputed).t));
  sequence.truth = nullptr;
  EXPECT_TRUE(std::isnan(truthAt(sequence, 0.55).t));
}

/// A method that knows the circle, and the true td (zero) where it is asked to estimate it.
FakeSolver makeCalibratingSolver(bool estimates) {
  return FakeSolver(estimates ? "estimates" : "believes", [estimates](const InitWindow& window) {
    const double shift = estimates ? -window.calibration().td : 0.0;
    InitResult result = perfectResult(window, Circle(), shift);
    if (!estimates) return result;
    result.states.erase(result.states.begin());  // as where the IMU data do not cover it
    result.gravity_b0 = result.states.front().R_w_b.transpose() * result.gravity_w;
    result.calibration.emplace();
    result.calibration->R_b_c =
        Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix();
    result.calibration->td = 0.002;
    result.calibration->covariance.diagonal().head<3>().setConstant(0.01 * 0.01);
    result.calibration->covariance(6, 6) = 0.001 * 0.001;
    result.warnings = {"td is off"};
    return result;
  });
}

// A found td takes the first state of the first window to before the truth: that window cannot be
// judged, for no method. A state far from its window is no correction of td but a wrong answer.
TEST(RigProtocol, AnAnswerWhereThereIsNoTruthIsNotJudged) {
  const Sequence sequence = makeCircleSequence(6.0);
  const auto moved = [](double shift) {
    return FakeSolver("moved", [shift](const InitWindow& window) {
      return perfectResult(window, Circle(), shift);
    });
  };
  const FakeSolver early = moved(-0.02), late = moved(0.02), far = moved(-0.2),
                   right = makePerfectSolver("right");
  const ProtocolResult plain = runProtocol(sequence, {&right});
  EXPECT_EQ(plain.counts.not_evaluable, 0);
  ASSERT_EQ(plain.windows.front().trial, 0);

  const ProtocolResult without_first = runProtocol(sequence, {&right, &early});
  EXPECT_EQ(without_first.counts.not_evaluable, 1);
  EXPECT_EQ(without_first.counts.windows, plain.counts.windows - 1);
  EXPECT_EQ(without_first.counts.trials, plain.counts.trials);
  ASSERT_EQ(without_first.windows.size(), plain.windows.size() - 1);
  EXPECT_EQ(without_first.windows.front().trial, 1);
  for (const WindowRecord& window : without_first.windows) {
    for (const MethodRecord& record : window.methods) EXPECT_TRUE(record.metrics.success());
  }

  ProtocolOptions limited;
  limited.max_windows = 2;
  for (limited.threads = 1; limited.threads < 3; ++limited.threads) {
    const ProtocolResult result = runProtocol(sequence, {&right, &early}, limited);
    EXPECT_EQ(result.counts.windows, 2);
    EXPECT_EQ(result.counts.trials, 3) << "the first is not judged and does not count";
  }

  EXPECT_EQ(runProtocol(sequence, {&late}).counts.not_evaluable, 0);
  const ProtocolResult wrong = runProtocol(sequence, {&far});
  EXPECT_EQ(wrong.counts.not_evaluable, 0);
  EXPECT_FALSE(wrong.windows.front().methods.front().metrics.computed());
}

// An answer is right when it is right at its own times, whatever the window believed.
TEST(RigProtocol, ComparesAtTheTimesOfTheStates) {
  Sequence sequence = makeCircleSequence(6.0);
  RigErrors errors;
  errors.td_s = 0.02;
  ASSERT_EQ(applyRigErrors(errors, &sequence), "");
  const FakeSolver estimates = makeCalibratingSolver(true), believes = makeCalibratingSolver(false);
  ProtocolOptions options;
  options.rig = errors;
  const ProtocolResult result = runProtocol(sequence, {&estimates, &believes}, options);
  ASSERT_GT(result.windows.size(), 5u);
  // Windows begin 20 ms early; the first one has no IMU data there and no truth.
  EXPECT_NEAR(std::remainder(result.windows[1].t_start + 0.02, 0.05), 0.0, 1e-9);
  for (const WindowRecord& window : result.windows) {
    EXPECT_NEAR(window.rig.td_s, -0.02, 1e-12);
    EXPECT_NEAR(window.rig.rotation_deg, 0.0, 1e-12);
    for (const MethodRecord& record : window.methods) {
      ASSERT_TRUE(record.metrics.computed()) << record.metrics.failure;
      EXPECT_LT(record.metrics.scale_error, 1e-6);
      EXPECT_LT(record.metrics.pose_rmse, 1e-6);
    }
    const MethodRecord& record = window.methods[0];
    EXPECT_NEAR(record.calibration.td_s, 0.002, 1e-12);
    EXPECT_NEAR(record.calibration.tdOverSigma(), 2.0, 1e-9);
    EXPECT_NEAR(record.calibration.rotation_deg, 0.01 * kRadToDeg, 1e-9);
    EXPECT_NEAR(record.calibration.rotation_over_sigma, 1.0 / std::sqrt(3.0), 1e-9);
    EXPECT_TRUE(std::isnan(record.calibration.readout_s));        // a global shutter
    EXPECT_TRUE(std::isnan(record.calibration.readout_sigma_s));  // held as exact
    EXPECT_EQ(record.answer.warnings, std::vector<std::string>{"td is off"});
    EXPECT_FALSE(window.methods[1].calibration.computed());
  }
}

TEST(RigProtocol, EveryTrialHasARandomRigOfItsOwn) {
  const Sequence sequence = makeCircleSequence(12.0);
  const FakeSolver estimates = makeCalibratingSolver(true);
  ProtocolOptions options;
  options.rig.td_s = 0.05;
  options.rig.extrinsic_deg = 10.0;
  options.rig.random = true;
  std::vector<double> answers[2];
  for (const int threads : {1, 4}) {
    options.threads = threads;
    const ProtocolResult result = runProtocol(sequence, {&estimates}, options);
    ASSERT_GT(result.windows.size(), 10u);
    for (const WindowRecord& window : result.windows) {
      const Calibration told = assumedCalibration(sequence.calibration, options.rig, window.trial);
      EXPECT_EQ(window.rig.td_s, told.td);
      EXPECT_GT(window.rig.rotation_deg, 0.0);
      // The first frames of the first trial lie before the IMU data where td is too small.
      const double late = window.t_start - 0.5 * window.trial - told.td;
      EXPECT_NEAR(std::remainder(late, 0.05), 0.0, 1e-9);
      if (window.trial > 0) {
        EXPECT_NEAR(late, 0.0, 1e-9);
      }
      ASSERT_TRUE(window.methods[0].metrics.computed()) << window.methods[0].metrics.failure;
      EXPECT_LT(window.methods[0].metrics.scale_error, 1e-6);
      answers[threads > 1].push_back(window.rig.td_s);
    }
  }
  EXPECT_EQ(answers[0], answers[1]);
}

// What the estimator is started with beside an answer is what the method was told, or found.
TEST(RigProtocol, TheEstimatorGoesOnWithTheCalibrationOfTheAnswer) {
  const Sequence sequence = makeCircleSequence(6.0);
  const FakeSolver estimates = makeCalibratingSolver(true), believes = makeCalibratingSolver(false);
  ProtocolOptions options;
  options.rig.td_s = 0.05;
  options.rig.random = true;
  std::vector<double> tds;
  options.downstream = [&](const Sequence&, const Calibration& given, const InitResult& answer) {
    tds.push_back(answer.calibration.has_value() ? answer.calibration->td : given.td);
    return DownstreamRecord();
  };
  options.max_windows = 1;
  const ProtocolResult result = runProtocol(sequence, {&estimates, &believes}, options);
  ASSERT_EQ(tds.size(), 2u);
  EXPECT_EQ(tds[0], 0.002);
  EXPECT_EQ(tds[1], result.windows[0].rig.td_s);
}

}  // namespace
}  // namespace slim_init::evaluation
