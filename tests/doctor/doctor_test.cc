// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Every check from both sides, on simulated tracks and IMU data.
#include "slim_init/doctor/doctor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "checks.h"
#include "handheld.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/simulation/feature_simulator.h"
#include "slim_init/simulation/motion_sensors.h"
#include "slim_init/simulation/world.h"
#include "support/gaussian.h"
#include "support/text_parts.h"

namespace slim_init::evaluation {
namespace {

using Eigen::Vector3d;

/// Of the motion of Handheld: some windows do not show the scale.
constexpr double kQuiet = 0.2;

/// A recording without fault. `td`: true offset of the image stamps.
DoctorData recording(const Handheld& motion, double td = 0.0) {
  DoctorData data;
  data.name = "handheld";
  data.calibration.R_b_c = handheldExtrinsic();
  data.calibration.t_b_c = Vector3d(0.05, -0.02, 0.01);
  data.calibration.td = td;
  data.imu = simulation::simulateImu(motion, simulation::ImuSimulationOptions());
  std::vector<double> times;
  for (int k = 4; k * 0.05 < motion.duration_s - 0.2; ++k) times.push_back(k * 0.05);
  std::vector<Vector3d> path;
  for (const double t : times) path.push_back(motion.at(t).p_w_b);
  const simulation::World world = simulation::makeWorld({}, path);
  simulation::FeatureSimulationOptions options;
  options.pixel_noise = 0.4;
  data.frames = simulation::simulateFeatures(motion, world, data.calibration, times, options);
  data.calibration.td = 0.0;
  for (const double t : times) {
    ImageFacts image;
    image.t = t;
    image.p99 = 200.0;
    image.blur_px = 0.8;
    data.images.push_back(image);
  }
  return data;
}

DoctorReport examined(const DoctorData& data) { return examine(data, DoctorOptions()); }

const Finding& find(const DoctorReport& report, const std::string& check) {
  for (const Finding& f : report.findings) {
    if (f.check == check) return f;
  }
  ADD_FAILURE() << "no check " << check;
  static const Finding none;
  return none;
}

/// Names of the findings that are warnings or errors. Whether `slim` starts follows from the others
/// and has tests of its own.
std::set<std::string> complaints(const DoctorReport& report) {
  std::set<std::string> names;
  for (const Finding& f : report.findings) {
    if (f.severity >= Severity::kWarning && f.check != "starts") names.insert(f.check);
  }
  return names;
}

using Names = std::set<std::string>;

template <typename T>
void keepEvery(std::size_t step, std::vector<T>* list) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < list->size(); k += step) (*list)[kept++] = (*list)[k];
  list->resize(kept);
}

void expectTheOnlyError(const DoctorReport& report, const char* check) {
  EXPECT_EQ(complaints(report), Names{check}) << doctorText(report, false);
  EXPECT_EQ(report.exitCode(), 2) << check;
}

class Doctor : public ::testing::Test {
 protected:
  static DoctorData good() {
    static const DoctorData data = recording(Handheld());
    return data;
  }
  static DoctorData standing() {
    Handheld motion;
    motion.turning.setZero();
    motion.moving = 0.0;
    return recording(motion);
  }
  DoctorData data_ = good();
};

TEST_F(Doctor, IsQuietOnGoodData) {
  const DoctorReport report = examined(good());
  EXPECT_EQ(report.exitCode(), 0) << doctorText(report, false);
  EXPECT_EQ(report.worst(), Severity::kOk) << doctorText(report, false);
  EXPECT_NEAR(report.alignment.td, 0.0, 1e-3);
  EXPECT_LT(find(report, "extrinsic_rotation").value, 0.4);
  EXPECT_NEAR(report.alignment.gyro_scale, 1.0, 0.01);
  const Vector3d bias = simulation::ImuSimulationOptions().gyro_bias;
  EXPECT_LT((report.alignment.gyro_bias - bias).norm(), 0.005);
}

TEST_F(Doctor, SaysWhatItCannotCheckStandingStill) {
  const DoctorReport report = examined(standing());
  EXPECT_EQ(report.exitCode(), 0) << doctorText(report, false);
  for (const char* check :
       {"rotation_agreement", "gyro_scale", "time_offset", "extrinsic_rotation"}) {
    EXPECT_EQ(find(report, check).severity, Severity::kNotChecked) << check;
    EXPECT_TRUE(std::isnan(find(report, check).value)) << check;
  }
  EXPECT_EQ(find(report, "gravity").severity, Severity::kOk);
  EXPECT_EQ(find(report, "gyro_bias").severity, Severity::kOk);
  EXPECT_EQ(find(report, "acceleration").severity, Severity::kNote);
  expectParts(find(report, "acceleration").message, "stands still");
}

TEST_F(Doctor, MeasuresTheTimeOffset) {
  for (const double td : {-0.03, 0.03}) {
    DoctorData data = recording(Handheld(), td);
    const DoctorReport report = examined(data);
    EXPECT_EQ(complaints(report), Names{"time_offset"}) << doctorText(report, false);
    // Within what the solver estimates: a warning, with the line to paste.
    EXPECT_EQ(report.exitCode(), 1) << doctorText(report, false);
    EXPECT_NEAR(find(report, "time_offset").value, 1e3 * td, 1.0);
    expectParts(report.lines, "td: ");
    EXPECT_FALSE(contains(report.lines, "extrinsic")) << report.lines;
    EXPECT_LT(std::abs(report.alignment.td - td), 5.0 * report.alignment.td_sigma + 2e-4);
    ASSERT_TRUE(report.answers.calibration.has_value());
    EXPECT_LT(std::abs(report.answers.calibration->td - td),
              5.0 * report.answers.calibration->tdSigma() + 2e-4);
    data.calibration.td = td;
    EXPECT_EQ(examined(data).worst(), Severity::kOk);
  }
}

TEST_F(Doctor, WarnsOfASmallTimeOffsetAndRefusesWhatTheSolverDoesNotEstimate) {
  const DoctorReport small = examined(recording(Handheld(), 0.009));
  EXPECT_EQ(find(small, "time_offset").severity, Severity::kWarning);
  EXPECT_EQ(small.exitCode(), 1) << doctorText(small, false);
  const DoctorReport beyond = examined(recording(Handheld(), 0.1));
  EXPECT_EQ(find(beyond, "time_offset").severity, Severity::kError) << doctorText(beyond, false);
  EXPECT_EQ(beyond.exitCode(), 2);
  EXPECT_NEAR(find(beyond, "time_offset").value, 100.0, 2.0);
}

TEST_F(Doctor, FindsTheExtrinsicTurnedAboutAnyAxis) {
  const std::vector<Vector3d> axes = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ(),
                                      Vector3d(1.0, -2.0, 0.5).normalized()};
  for (const Vector3d& axis : axes) {
    for (const double sign : {-1.0, 1.0}) {
      DoctorData data = good();
      data.calibration.R_b_c *= expSO3(sign * 0.5 * M_PI * axis);
      const DoctorReport report = examined(data);
      expectTheOnlyError(report, "extrinsic_rotation");
      EXPECT_NEAR(find(report, "extrinsic_rotation").value, 90.0, 0.5);
      EXPECT_LT(
          kDegPerRad * logSO3(handheldExtrinsic().transpose() * report.alignment.R_b_c).norm(),
          0.4);
    }
  }
}

// Turns about one axis leave the rotation about it open; what the solver knows about it comes from
// the acceleration.
TEST_F(Doctor, TurnsAboutOneAxisLeaveThatAxisToTheAcceleration) {
  Handheld motion;
  motion.turning = Vector3d(0.0, 0.0, 0.3);
  DoctorData data = recording(motion);
  const DoctorReport quiet = examined(data);
  EXPECT_EQ(quiet.exitCode(), 0) << doctorText(quiet, false);
  EXPECT_GT(quiet.alignment.R_covariance.trace(), 0.01);
  ASSERT_TRUE(quiet.answers.calibration.has_value());
  EXPECT_LT(kDegPerRad *
                logSO3(handheldExtrinsic().transpose() * quiet.answers.calibration->R_b_c).norm(),
            5.0 * quiet.answers.calibration->rotationSigmaDeg() + 0.2);
  EXPECT_EQ(find(quiet, "time_offset").severity, Severity::kOk);
  // A turn about another axis shows all the same. Here the camera's y is the body's -z.
  data.calibration.R_b_c *= expSO3(Vector3d(0.5 * M_PI, 0.0, 0.0));
  EXPECT_EQ(complaints(examined(data)), Names{"extrinsic_rotation"});
}

TEST_F(Doctor, FindsTheGyroInDegrees) {
  for (ImuSample& sample : data_.imu) sample.gyro *= kDegPerRad;
  const DoctorReport report = examined(data_);
  EXPECT_TRUE(complaints(report).count("gyro_scale")) << doctorText(report, false);
  EXPECT_NEAR(find(report, "gyro_scale").value, kDegPerRad, 1.0);
  expectParts(find(report, "gyro_scale").message, "deg/s");
  EXPECT_EQ(find(report, "gyro_scale").severity, Severity::kError);
  // The rest is measured in spite of it.
  for (const char* check : {"time_offset", "extrinsic_rotation", "gravity"}) {
    EXPECT_EQ(find(report, check).severity, Severity::kOk) << check;
  }
  data_ = standing();
  for (ImuSample& sample : data_.imu) sample.gyro *= kDegPerRad;
  EXPECT_EQ(find(examined(data_), "gyro_bias").severity, Severity::kError);
}

TEST_F(Doctor, FindsTheAccelerometerInG) {
  for (const bool moving : {false, true}) {
    DoctorData data = moving ? good() : standing();
    for (ImuSample& sample : data.imu) sample.accel /= 9.80665;
    const DoctorReport report = examined(data);
    expectTheOnlyError(report, "accel_unit");
    expectParts(find(report, "accel_unit").message, "in g");
  }
}

TEST_F(Doctor, FindsGravityTakenOffAndMisscaled) {
  for (ImuSample& sample : data_.imu) sample.accel *= 0.3;
  EXPECT_EQ(find(examined(data_), "accel_unit").severity, Severity::kError);
  // What is left of a flight may well have a norm of one.
  data_ = good();
  std::vector<double> norms;
  for (ImuSample& sample : data_.imu) {
    sample.accel -= Handheld().at(sample.t).R_w_b.transpose() * Vector3d(0.0, 0.0, 9.81);
    norms.push_back(sample.accel.norm());
  }
  for (ImuSample& sample : data_.imu) sample.accel /= median(norms);
  expectParts(find(examined(data_), "accel_unit").advice, "Gravity has been removed");
  data_ = good();
  for (ImuSample& sample : data_.imu) sample.accel *= 1.08;
  const DoctorReport report = examined(data_);
  EXPECT_EQ(complaints(report), Names{"gravity"});
  EXPECT_EQ(find(report, "gravity").severity, Severity::kWarning);
}

TEST_F(Doctor, FindsASlowImuLostSamplesAndTwoClocksAndNothingElse) {
  keepEvery(10, &data_.imu);
  DoctorReport report = examined(data_);
  expectTheOnlyError(report, "imu_rate");
  EXPECT_NEAR(find(report, "imu_rate").value, 20.0, 0.1);

  data_ = good();
  std::mt19937 random(1);
  data_.imu.erase(std::remove_if(data_.imu.begin(), data_.imu.end(),
                                 [&random](const ImuSample&) { return random() % 10 == 0; }),
                  data_.imu.end());
  report = examined(data_);
  expectTheOnlyError(report, "imu_lost");
  EXPECT_NEAR(find(report, "imu_lost").value, 10.0, 1.5);

  data_ = good();
  for (FrameObservation& frame : data_.frames) frame.t += 1000.0;
  for (ImageFacts& image : data_.images) image.t += 1000.0;
  report = examined(data_);
  expectTheOnlyError(report, "clocks");
  EXPECT_EQ(find(report, "time_offset").severity, Severity::kNotChecked);
}

TEST_F(Doctor, FindsAGapJitterAndDisorder) {
  data_.imu.erase(data_.imu.begin() + 1000, data_.imu.begin() + 1009);
  DoctorReport report = examined(data_);
  EXPECT_EQ(find(report, "imu_gap").severity, Severity::kOk) << "nine samples are 50 ms";
  data_.imu.erase(data_.imu.begin() + 1000, data_.imu.begin() + 1010);
  report = examined(data_);
  EXPECT_EQ(find(report, "imu_gap").severity, Severity::kWarning);
  EXPECT_NEAR(find(report, "imu_gap").value, 100.0, 0.1);

  data_ = good();
  for (std::size_t k = 0; k < data_.imu.size(); k += 2) data_.imu[k].t += 0.002;
  report = examined(data_);
  EXPECT_EQ(find(report, "imu_jitter").severity, Severity::kWarning);
  EXPECT_EQ(find(report, "imu_lost").severity, Severity::kOk) << doctorText(report, false);

  data_ = good();
  data_.imu_disorder.out_of_order = 3;
  data_.image_disorder.unreadable = 50;
  report = examined(data_);
  EXPECT_EQ(find(report, "imu_order").severity, Severity::kWarning);
  EXPECT_EQ(find(report, "image_order").severity, Severity::kError);
  // The faults are those of a longer recording.
  data_.images_beyond_limit = 9950;
  EXPECT_EQ(find(examined(data_), "image_order").severity, Severity::kWarning);
  data_ = good();
  for (std::size_t k = data_.imu.size() / 2; k < data_.imu.size(); ++k) data_.imu[k].t += 20.0;
  for (std::size_t k = data_.images.size() / 2; k < data_.images.size(); ++k) {
    data_.images[k].t += 20.0;
  }
  report = examined(data_);
  EXPECT_EQ(find(report, "imu_lost").severity, Severity::kOk);
  EXPECT_EQ(find(report, "images_lost").severity, Severity::kOk);
}

TEST_F(Doctor, FindsSlowAndLostImages) {
  keepEvery(4, &data_.images);
  EXPECT_EQ(find(examined(data_), "image_rate").severity, Severity::kWarning);
  data_ = good();
  for (std::size_t k = 20; k < data_.images.size(); k += 10) {
    data_.images.erase(data_.images.begin() + static_cast<std::ptrdiff_t>(k));
  }
  EXPECT_EQ(find(examined(data_), "images_lost").severity, Severity::kWarning);
  data_.images.resize(1);
  EXPECT_EQ(find(examined(data_), "image_rate").severity, Severity::kNotChecked);
}

TEST_F(Doctor, FindsAGyroThatIsLeftHandedSilentOrOfAnotherRecording) {
  for (ImuSample& sample : data_.imu) sample.gyro.y() *= -1.0;
  const DoctorReport report = examined(data_);
  EXPECT_EQ(find(report, "rotation_agreement").severity, Severity::kError);
  expectParts(find(report, "rotation_agreement").advice, "left-handed");
  EXPECT_EQ(find(report, "extrinsic_rotation").severity, Severity::kNotChecked);
  for (ImuSample& sample : data_.imu) sample.gyro.setZero();
  EXPECT_EQ(find(examined(data_), "rotation_agreement").severity, Severity::kError);
  data_ = good();
  Handheld other;
  other.turning = Vector3d(0.25, -0.1, 0.2);
  for (ImuSample& sample : data_.imu) {
    sample.gyro = other.at(1.37 * (other.duration_s - sample.t)).omega_b;
  }
  EXPECT_EQ(find(examined(data_), "rotation_agreement").severity, Severity::kError);
}

TEST_F(Doctor, FindsBlackWhiteBlurredRepeatedAndForeignImages) {
  // Severity of a check if every n-th image is changed.
  const auto severity = [](const char* check, std::size_t every, auto change) {
    DoctorData data = good();
    for (std::size_t k = 0; k < data.images.size(); k += every) change(&data.images[k]);
    return find(examined(data), check).severity;
  };
  const auto black = [](ImageFacts* image) { image->p99 = 6.0; };
  EXPECT_EQ(severity("image_black", 1, black), Severity::kError);
  EXPECT_EQ(severity("image_black", 20, black), Severity::kWarning);
  const auto dim = [](ImageFacts* image) { image->p99 = 30.0; };
  EXPECT_EQ(severity("image_black", 1, dim), Severity::kOk);
  const auto white = [](ImageFacts* image) { image->saturated = 0.7; };
  EXPECT_EQ(severity("image_white", 2, white), Severity::kWarning);
  EXPECT_EQ(severity("image_white", 50, white), Severity::kOk);
  const auto blurred = [](ImageFacts* image) { image->blur_px = 4.0; };
  EXPECT_EQ(severity("image_blur", 1, blurred), Severity::kError);
  EXPECT_EQ(severity("image_blur", 10, blurred), Severity::kOk);
  const auto repeated = [](ImageFacts* image) { image->repeats = true; };
  EXPECT_EQ(severity("image_repeated", 10, repeated), Severity::kWarning);
  const auto foreign = [](ImageFacts* image) { image->right_size = false; };
  EXPECT_EQ(severity("image_size", 1, foreign), Severity::kError);
}

TEST_F(Doctor, FindsTooFewPointsAndShortTracks) {
  for (FrameObservation& frame : data_.frames)
    frame.points.resize(std::min<std::size_t>(frame.points.size(), 10));
  EXPECT_EQ(find(examined(data_), "points").severity, Severity::kError);
  data_ = good();
  FeatureId id = 0;
  for (FrameObservation& frame : data_.frames) {
    for (PointObservation& p : frame.points) p.id = id++;
    frame.lines.clear();
  }
  const DoctorReport report = examined(data_);
  EXPECT_EQ(find(report, "point_survival").severity, Severity::kError);
  EXPECT_EQ(find(report, "lines").severity, Severity::kNote);
  EXPECT_EQ(find(report, "rotation_agreement").severity, Severity::kNotChecked);
}

TEST_F(Doctor, StartsAreThoseOfTheSolver) {
  const DoctorReport right = examined(good());
  EXPECT_EQ(find(right, "starts").severity, Severity::kOk) << doctorText(right, false);
  EXPECT_GE(right.answers.windows, 3);
  EXPECT_EQ(right.answers.accepted, right.answers.windows);
  EXPECT_EQ(right.answers.refused, 0);
  EXPECT_EQ(right.lines, "");
  // Specific force of another unit: nothing that the solver could estimate.
  for (ImuSample& sample : data_.imu) sample.accel /= 9.80665;
  const DoctorReport refused = examined(data_);
  EXPECT_EQ(find(refused, "starts").severity, Severity::kError) << doctorText(refused, false);
  EXPECT_GT(refused.answers.refused, 0);
  // Standing still is no fault.
  const DoctorReport waiting = examined(standing());
  EXPECT_EQ(find(waiting, "starts").severity, Severity::kNote) << doctorText(waiting, false);
  EXPECT_EQ(waiting.answers.accepted, 0);
  EXPECT_EQ(waiting.answers.refused, 0);
}

TEST_F(Doctor, OneRefusedWindowAmongAcceptedOnesIsNoWarning) {
  const auto severity = [](int accepted, int refused, int waiting) {
    WindowEstimates answers;
    answers.accepted = accepted;
    answers.refused = refused;
    answers.windows = accepted + refused + waiting;
    answers.statuses["inconsistent_residuals"] = refused;
    answers.messages["inconsistent_residuals"] = "chi-square";
    Findings findings;
    checkEstimates(answers, DoctorOptions(), &findings);
    return findings.back().severity;
  };
  EXPECT_EQ(severity(6, 1, 0), Severity::kOk);
  EXPECT_EQ(severity(3, 1, 0), Severity::kOk);
  EXPECT_EQ(severity(2, 1, 0), Severity::kWarning);
  EXPECT_EQ(severity(5, 2, 0), Severity::kWarning);
  EXPECT_EQ(severity(19, 2, 0), Severity::kOk);
  EXPECT_EQ(severity(2, 5, 0), Severity::kError);
  EXPECT_EQ(severity(0, 1, 0), Severity::kError);
}

TEST_F(Doctor, AnUncertainScaleWantsMotion) {
  Handheld motion;
  motion.moving = kQuiet;
  DoctorOptions options;
  options.initializer.gates.min_parallax_px = 1.0;
  const DoctorReport report = examine(recording(motion), options);
  EXPECT_GT(report.answers.statuses.count("scale_too_uncertain"), 0u) << doctorText(report, false);
  EXPECT_EQ(report.answers.refused, 0) << doctorText(report, false);
  EXPECT_LT(find(report, "starts").severity, Severity::kWarning) << doctorText(report, false);
}

TEST_F(Doctor, TheCalibrationIsThatOfTheSolver) {
  const DoctorData data = good();
  DoctorData off = data;
  off.calibration.R_b_c *= expSO3(Vector3d(0.0, 3.0 / kDegPerRad, 0.0));
  off.calibration.t_b_c += Vector3d(0.15, 0.0, 0.0);
  const DoctorReport report = examined(off);
  EXPECT_EQ(complaints(report), (Names{"extrinsic_rotation", "extrinsic_translation"}))
      << doctorText(report, false);
  EXPECT_EQ(find(report, "extrinsic_rotation").severity, Severity::kWarning);
  ASSERT_TRUE(report.answers.calibration.has_value());
  const CalibrationEstimate& found = *report.answers.calibration;
  EXPECT_LT(kDegPerRad * logSO3(data.calibration.R_b_c.transpose() * found.R_b_c).norm(), 0.3);
  EXPECT_LT((found.t_b_c - data.calibration.t_b_c).norm(), 0.03);
  expectParts(report.lines,
              "extrinsicRotation: !!opencv-matrix|extrinsicTranslation: !!opencv-matrix");
  EXPECT_FALSE(contains(report.lines, "td:"));
  expectParts(doctorText(report, false), "in place of those that it has:\n# rotation: ");
  EXPECT_EQ(nlohmann::json::parse(doctorJson(report))["lines"], report.lines);
  // With the lines in the file there is nothing to say.
  off.calibration.R_b_c = found.R_b_c;
  off.calibration.t_b_c = found.t_b_c;
  EXPECT_EQ(complaints(examined(off)), Names());
}

TEST_F(Doctor, AnUnknownRotationIsMeasuredAndWritten) {
  data_.calibration.R_b_c.setIdentity();
  data_.calibration.sigmas.rotation_deg = 180.0;
  data_.has_rotation = false;
  const DoctorReport report = examined(data_);
  EXPECT_EQ(find(report, "extrinsic_rotation").severity, Severity::kNote)
      << doctorText(report, false);
  expectParts(report.lines, "# rotation: standard deviation");
  EXPECT_EQ(complaints(report), Names());
}

TEST_F(Doctor, NoiseOfTheImuIsMeasured) {
  const ImuNoise sheet;
  const DoctorReport quiet = examined(good());
  const ImuNoise& measured = quiet.answers.measured_noise;
  EXPECT_NEAR(measured.accel_density / sheet.accel_density, 1.0, 0.4);
  EXPECT_EQ(find(quiet, "accel_noise").severity, Severity::kOk);
  EXPECT_EQ(find(quiet, "gyro_noise").severity, Severity::kOk);
  EXPECT_GT(quiet.answers.assumed_noise.accel_density, sheet.accel_density);

  Gaussian noise(3);  // 0.5 m/s^2: rotors
  for (ImuSample& sample : data_.imu) sample.accel += 0.5 * Vector3d{noise(), noise(), 0.0};
  const DoctorReport shaking = examined(data_);
  EXPECT_EQ(find(shaking, "accel_noise").severity, Severity::kNote);
  expectParts(find(shaking, "accel_noise").message,
              " times as much. It vibrates, or slim_init.noise.accel_density is too low");
  EXPECT_EQ(find(shaking, "gyro_noise").severity, Severity::kOk);

  data_ = good();
  data_.calibration.imu_noise.gyro_density *= 30.0;
  expectParts(find(examined(data_), "gyro_noise").message, "inflated");
}

CalibrationEstimate estimateAt(const Vector3d& turn, double td, double rotation_sigma,
                               double td_sigma) {
  CalibrationEstimate e;
  e.R_b_c = expSO3(turn);
  e.td = td;
  e.covariance.diagonal() << Vector3d::Constant(rotation_sigma * rotation_sigma),
      Vector3d::Constant(1e-4), td_sigma * td_sigma, 0.0;
  return e;
}

TEST(CombinedCalibration, CountsThePriorOnceAndTheScatter) {
  Calibration prior;
  prior.sigmas = {10.0, 0.05, 0.05, 0.0};
  // Estimates that know nothing but the prior leave it as it is.
  std::vector<CalibrationEstimate> none(5,
                                        estimateAt(Vector3d::Zero(), 0.0, 10.0 / kDegPerRad, 0.05));
  for (CalibrationEstimate& e : none) {
    e.covariance.diagonal().segment<3>(3).setConstant(0.05 * 0.05);
  }
  const OptionalCalibration still = combinedCalibration(none, prior);
  ASSERT_TRUE(still.has_value());
  EXPECT_NEAR(still->tdSigma(), 0.05, 1e-6);
  EXPECT_NEAR(still->rotationSigmaDeg(), 10.0, 1e-4);
  // Four that agree: half the standard deviation; one far off hardly counts.
  std::vector<CalibrationEstimate> all(4,
                                       estimateAt(Vector3d(0.02, 0.0, -0.01), 0.01, 0.01, 0.002));
  const OptionalCalibration agree = combinedCalibration(all, prior);
  EXPECT_NEAR(agree->td, 0.01, 1e-4);
  EXPECT_NEAR(agree->tdSigma(), 0.001, 2e-5);
  EXPECT_LT((logSO3(agree->R_b_c) - Vector3d(0.02, 0.0, -0.01)).norm(), 2e-4);
  all.push_back(estimateAt(Vector3d(0.5, 0.0, 0.0), -0.04, 0.01, 0.002));
  EXPECT_NEAR(combinedCalibration(all, prior)->td, 0.01, 1e-3);
  // Estimates that scatter by more than they say: so does their mean.
  for (std::size_t i = 0; i < 4; ++i) all[i].td += i % 2 == 0 ? 0.008 : -0.008;
  all.pop_back();
  EXPECT_GT(combinedCalibration(all, prior)->tdSigma(), 0.0015);

  all.resize(kMinEstimates - 1);
  EXPECT_FALSE(combinedCalibration(all, prior).has_value());
  std::vector<CalibrationEstimate> exact(4);  // no covariance
  EXPECT_FALSE(combinedCalibration(exact, prior).has_value());
}

TEST_F(Doctor, HasAnAnswerForEmptyData) {
  const DoctorReport report = examined(DoctorData());
  EXPECT_EQ(report.exitCode(), 2);
  EXPECT_FALSE(doctorText(report, true).empty());
  EXPECT_NO_THROW(nlohmann::json::parse(doctorJson(report)));
}

TEST_F(Doctor, EqualDataGiveEqualReports) {
  EXPECT_EQ(doctorJson(examined(good())), doctorJson(examined(good())));
}

TEST_F(Doctor, WritesATableAndJson) {
  data_.calibration.R_b_c *= expSO3(Vector3d(0.0, 0.5 * M_PI, 0.0));
  const DoctorReport report = examined(data_);
  std::istringstream lines(doctorText(report, false));
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_LE(line.size(), 100u) << line;
    EXPECT_EQ(line.find('\033'), std::string::npos);
    const bool widest = contains(line, " gyro_noise ");  // the columns stay apart
    EXPECT_EQ(line.find("0.000017 to 0.0017"), widest ? 63u : std::string::npos) << line;
  }
  EXPECT_GT(count, report.findings.size());
  EXPECT_NE(doctorText(report, true).find("\033[31m"), std::string::npos);

  const auto json = nlohmann::json::parse(doctorJson(report));
  EXPECT_EQ(json["exit_code"], 2);
  EXPECT_EQ(json["worst"], "error");
  EXPECT_EQ(json["findings"].size(), report.findings.size());
  Names names;
  for (const auto& f : json["findings"]) {
    names.insert(f["check"].get<std::string>());
    EXPECT_FALSE(f["message"].get<std::string>().empty()) << f["check"];
    if (f["severity"] == "error") {
      EXPECT_FALSE(f["advice"].get<std::string>().empty()) << f["check"];
    }
  }
  EXPECT_EQ(names.size(), report.findings.size()) << "a check is listed twice";
}

}  // namespace
}  // namespace slim_init::evaluation
