// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// Growing windows, asked at every image, of motions and scenes that suggest a wrong scale: the
// first accepted answer is never wrong by more than a quarter. Where the data cannot tell the
// scale, there is none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "geometry/so3.h"
#include "slim_init/initializer.h"
#include "support/exact_window.h"
#include "support/text_parts.h"

namespace slim_init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDuration = 3.2;    // [s]
constexpr double kImageRate = 10.0;  // [Hz], as hosts have it
constexpr double kImuRate = 200.0;   // [Hz]
constexpr double kFocalPx = 458.0;
constexpr double kHalfWidth = 0.8, kHalfHeight = 0.52;  // of the image, at unit distance

/// Position of the body [m] and attitude of a camera that looks along x, as a rotation vector.
struct BodyMotion {
  std::function<Vector3d(double t)> position;
  std::function<Vector3d(double t)> rotation;
};

/// Where track `i` is at time t, in the world [m].
using PointMotion = std::function<Vector3d(int i, const Vector3d& place, double t)>;

struct Scene {
  BodyMotion motion;
  int points = 60;
  double nearest_m = 2.0, farthest_m = 8.0;
  Vector3d accel_bias = Vector3d(-0.02, 0.1, 0.09);
  PointMotion moved;  ///< none: the scene is rigid
  int standing = 0;   ///< the first tracks stay where they are in the first image
};

/// Smooth irregular motion with an amplitude [m] per axis.
std::function<Vector3d(double)> sway(std::mt19937* random, double low_hz, double high_hz,
                                     double amplitude) {
  std::uniform_real_distribution<double> phase(0.0, 2.0 * M_PI), rate(low_hz, high_hz);
  std::vector<Vector3d> w, p;
  for (int k = 0; k < 3; ++k) {
    w.push_back(2.0 * M_PI * Vector3d{rate(*random), rate(*random), rate(*random)});
    p.push_back(Vector3d{phase(*random), phase(*random), phase(*random)});
  }
  return [w, p, amplitude](double t) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < w.size(); ++k) {
      sum += amplitude / std::sqrt(3.0) * (w[k] * t + p[k]).array().sin().matrix();
    }
    return sum;
  };
}

class Recording {
 public:
  Recording(const Scene& scene, unsigned seed) : scene_(scene), random_(seed) {
    calibration.imu_noise = ImuNoise();
    makeImu();
    makeFrames();
  }

  NavState truth(double t) const {
    constexpr double h = 1e-3;
    NavState state;
    state.t = t;
    state.R_w_b = attitude(t);
    state.p_w_b = scene_.motion.position(t);
    state.v_w_b = (scene_.motion.position(t + h) - scene_.motion.position(t - h)) / (2.0 * h);
    return state;
  }

  Calibration calibration = eurocCalibration();
  std::vector<ImuSample> imu;
  std::vector<FrameObservation> frames;

 private:
  Matrix3d attitude(double t) const {
    Matrix3d R_x_c;  // a camera that looks along x
    R_x_c << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return expSO3(scene_.motion.rotation(t)) * R_x_c * calibration.R_b_c.transpose();
  }

  void makeImu() {
    constexpr double h = 1e-3;
    std::normal_distribution<double> normal;
    const auto noise = [&](double density) {
      const double sigma = density * std::sqrt(kImuRate);
      return Vector3d(sigma * Vector3d{normal(random_), normal(random_), normal(random_)});
    };
    const Vector3d gravity(0.0, 0.0, -calibration.gravity_magnitude);
    const Vector3d gyro_bias(-0.002, 0.02, 0.07);
    for (int k = -20; k / kImuRate < kDuration + 0.1; ++k) {
      ImuSample sample;
      sample.t = k / kImuRate;
      const auto& p = scene_.motion.position;
      const Vector3d a = (p(sample.t + h) - 2.0 * p(sample.t) + p(sample.t - h)) / (h * h);
      const Matrix3d R = attitude(sample.t);
      sample.accel = R.transpose() * (a - gravity) + scene_.accel_bias +
                     noise(calibration.imu_noise.accel_density);
      sample.gyro =
          logSO3(attitude(sample.t - h).transpose() * attitude(sample.t + h)) / (2.0 * h) +
          gyro_bias + noise(calibration.imu_noise.gyro_density);
      imu.push_back(sample);
    }
  }

  // Points in the first view, some of which leave it.
  void makeFrames() {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::normal_distribution<double> pixel(0.0, calibration.pointSigmaPx() / kFocalPx);
    const auto cameraAt = [&](double t, Vector3d* centre) {
      const Matrix3d R = attitude(t);
      *centre = scene_.motion.position(t) + R * calibration.t_b_c;
      return Matrix3d(R * calibration.R_b_c);
    };
    Vector3d first;
    const Matrix3d R_first = cameraAt(0.0, &first);
    std::vector<Vector3d> places;
    for (int i = 0; i < scene_.points; ++i) {
      const double share = 0.5 + 0.5 * unit(random_);
      const double depth = scene_.nearest_m + share * (scene_.farthest_m - scene_.nearest_m);
      places.push_back(first + R_first * Vector3d{depth * kHalfWidth * unit(random_),
                                                  depth * kHalfHeight * unit(random_), depth});
    }
    for (int k = 0; k / kImageRate <= kDuration; ++k) {
      FrameObservation frame;
      frame.t = k / kImageRate;
      Vector3d centre;
      const Matrix3d R = cameraAt(frame.t, &centre);
      for (int i = 0; i < scene_.points; ++i) {
        const Vector3d at = scene_.moved ? scene_.moved(i, places[i], frame.t) : places[i];
        const Vector3d in_c = i < scene_.standing ? Vector3d(R_first.transpose() * (at - first))
                                                  : Vector3d(R.transpose() * (at - centre));
        const Eigen::Vector2d seen = in_c.head<2>() / in_c.z();
        if (in_c.z() < 0.2 || std::abs(seen.x()) > kHalfWidth || std::abs(seen.y()) > kHalfHeight) {
          continue;
        }
        PointObservation point;
        point.id = i;
        point.bearing =
            Vector3d{seen.x() + pixel(random_), seen.y() + pixel(random_), 1.0}.normalized();
        frame.points.push_back(point);
      }
      frames.push_back(frame);
    }
  }

  const Scene& scene_;
  std::mt19937 random_;
};

struct FirstAnswer {
  bool accepted = false;
  double at_s = kNotComputed;
  double scale_error = kNotComputed;  ///< |estimated / true - 1|
  double tilt_deg = kNotComputed;     ///< of the newest attitude
  std::vector<std::string> warnings;
};

FirstAnswer ask(const Recording& recording, const InitializerOptions& options) {
  FirstAnswer answer;
  const auto initializer = makeInitializer(recording.calibration, options);
  std::size_t next = 0;
  for (const FrameObservation& frame : recording.frames) {
    while (next < recording.imu.size() && recording.imu[next].t < frame.t + 0.01) {
      initializer->addImu(recording.imu[next++]);
    }
    initializer->addFrame(frame);
    const InitResult result = initializer->initialize();
    if (!result.success()) continue;
    std::vector<NavState> truth;
    for (const NavState& state : result.states) truth.push_back(recording.truth(state.t));
    answer.accepted = true;
    answer.at_s = frame.t;
    answer.warnings = result.warnings;
    answer.scale_error = std::abs(scaleError(result.states, truth));
    const Vector3d up = result.states.back().R_w_b.row(2), true_up = truth.back().R_w_b.row(2);
    answer.tilt_deg = std::atan2(up.cross(true_up).norm(), up.dot(true_up)) * 180.0 / M_PI;
    return answer;
  }
  return answer;
}

/// Accepts whatever has an estimate.
InitializerOptions trusting() {
  InitializerOptions options;
  options.gates.mode = GateMode::kOff;
  return options;
}

constexpr double kWrong = 0.25;

struct Tally {
  int accepted = 0, wrong = 0, wrong_if_trusted = 0;
  int of_static_tracks = 0;  ///< answers with that warning
};

Tally askAll(unsigned seeds, const std::function<Scene(std::mt19937*)>& make) {
  Tally tally;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    std::mt19937 random(100 + seed);
    const Scene scene = make(&random);
    const Recording recording(scene, seed);
    const FirstAnswer answer = ask(recording, InitializerOptions());
    tally.accepted += answer.accepted ? 1 : 0;
    const bool wrong = answer.accepted && !(answer.scale_error <= kWrong);
    tally.wrong += wrong ? 1 : 0;
    tally.of_static_tracks +=
        anyContains(answer.warnings, "point tracks are static in the image") ? 1 : 0;
    EXPECT_FALSE(wrong) << "seed " << seed << ": off by " << answer.scale_error << " after "
                        << answer.at_s << " s";
    EXPECT_FALSE(answer.tilt_deg > 8.0) << "seed " << seed << ": " << answer.tilt_deg << " deg";
    const FirstAnswer trusted = ask(recording, trusting());
    tally.wrong_if_trusted += trusted.accepted && !(trusted.scale_error <= kWrong) ? 1 : 0;
  }
  return tally;
}

// Nothing wrong is accepted of scenes that give something wrong to accept.
void expectRefused(unsigned seeds, const std::function<Scene(std::mt19937*)>& make) {
  EXPECT_GT(askAll(seeds, make).wrong_if_trusted, 0);
}

BodyMotion excited(std::mt19937* random) {
  const auto path = sway(random, 0.3, 1.2, 0.25);
  const auto turn = sway(random, 0.2, 0.8, 0.08);
  return {path, turn};
}

/// Constant velocity and acceleration, with a shake.
std::function<Vector3d(double)> shaken(const Vector3d& velocity, const Vector3d& acceleration,
                                       const std::function<Vector3d(double)>& shake) {
  return [=](double t) -> Vector3d { return velocity * t + 0.5 * acceleration * t * t + shake(t); };
}

// Hand-held, without it and with it: what refuses the other scenes must not refuse these.
TEST(Adversarial, APartOfTheVehicleInView) {
  for (const auto& [seeds, standing] : {std::pair(4, 0), std::pair(6, 18)}) {
    const Tally tally = askAll(seeds, [points = standing](std::mt19937* random) {
      Scene scene;
      scene.motion = excited(random);
      scene.standing = points;
      return scene;
    });
    EXPECT_EQ(tally.accepted, seeds) << standing;
    EXPECT_EQ(tally.of_static_tracks, standing > 0 ? seeds : 0) << standing;
  }
}

// Constant velocity with few points, a hover that drifts, a vehicle with constant acceleration.
TEST(Adversarial, MotionsThatLeaveTheScaleOpen) {
  struct Case {
    Vector3d velocity, acceleration;  // [m/s], [m/s^2]
    double low_hz, high_hz, shake_m, turn_rad;
    int points;
    double nearest_m, farthest_m;
  };
  for (const Case& one : {Case{{0.8, 0, 0}, {0, 0, 0}, 0.5, 2.0, 0.002, 0.01, 15, 2.0, 8.0},
                          Case{{0, 0.08, 0}, {0, 0, 0}, 0.5, 2.0, 0.004, 0.02, 60, 4.0, 12.0},
                          Case{{2.0, 0, 0}, {1.6, 0, 0}, 1.0, 3.0, 0.003, 0.005, 60, 8.0, 40.0}}) {
    SCOPED_TRACE(one.velocity.transpose());
    expectRefused(4, [&one](std::mt19937* random) {
      Scene scene;
      const auto shake = sway(random, one.low_hz, one.high_hz, one.shake_m);
      scene.motion.position = shaken(one.velocity, one.acceleration, shake);
      scene.motion.rotation = sway(random, 0.3, 1.0, one.turn_rad);
      scene.points = one.points;
      scene.nearest_m = one.nearest_m;
      scene.farthest_m = one.farthest_m;
      return scene;
    });
  }
}

// Constant acceleration along gravity is a bias of the accelerometer at any scale.
TEST(Adversarial, GravityAgainstAccelerometerBias) {
  expectRefused(4, [](std::mt19937* random) {
    Scene scene;
    scene.motion.position = [](double t) { return Vector3d(0.0, 0.4 * t, 0.1 * t * t); };
    scene.motion.rotation = sway(random, 0.2, 0.6, 0.003);
    scene.accel_bias = Vector3d(0.1, -0.12, 0.1);
    return scene;
  });
}

TEST(Adversarial, Elevator) {
  expectRefused(6, [](std::mt19937* random) {
    Scene scene;
    // 1 m/s^2 for a second and a half, then constant velocity.
    scene.motion.position = [](double t) {
      const double fast = std::max(t - 1.5, 0.0);
      return Vector3d(0.0, 0.0, 0.5 * (t - fast) * (t - fast) + 1.5 * fast);
    };
    scene.motion.rotation = sway(random, 0.2, 0.8, 0.01);
    return scene;
  });
}

// A turn at constant speed, far from the scene: the shape alone begins at 0.6 to 0.8 of the scale,
// and the cost over the scale knows the other minimum.
TEST(Adversarial, AWideTurn) {
  static constexpr double kRadius = 60.0, kRate = 0.33;  // [m], [rad/s]
  const Tally tally = askAll(6, [](std::mt19937* random) {
    Scene scene;
    const auto shake = sway(random, 0.3, 1.0, 0.05);
    scene.motion.position = [shake](double t) -> Vector3d {
      return kRadius * Vector3d(std::sin(kRate * t), 1.0 - std::cos(kRate * t), 0.0) + shake(t);
    };
    scene.motion.rotation = [](double t) { return Vector3d(0.0, 0.0, kRate * t); };
    scene.nearest_m = 40.0;
    scene.farthest_m = 160.0;
    scene.points = 100;
    return scene;
  });
  EXPECT_GE(tally.accepted, 2) << "none without a refinement at that scale";
}

// Half of the image is something that moves by itself, as fast as the camera.
TEST(Adversarial, AMovingObjectFillsHalfOfTheImage) {
  expectRefused(2, [](std::mt19937* random) {
    Scene scene;
    scene.motion = excited(random);
    const auto object = sway(random, 0.2, 0.6, 0.4);
    scene.moved = [object](int i, const Vector3d& place, double t) {
      return i % 2 == 0 ? place : Vector3d(place + object(t) - object(0.0));
    };
    return scene;
  });
}

// Somebody walks through a far scene before a rig that is held still: a bias of the gyroscope lets
// the scene move and the person stand.
TEST(Adversarial, APersonBeforeAFarScene) {
  expectRefused(8, [](std::mt19937* random) {
    Scene scene;
    scene.motion = {sway(random, 0.3, 2.0, 0.015), sway(random, 0.3, 2.0, 0.015)};
    scene.points = 100;
    scene.nearest_m = 10.0;
    scene.farthest_m = 60.0;
    scene.moved = [](int i, const Vector3d& place, double t) {
      if (i % 5 > 0) return place;
      return Vector3d(place * (2.0 + 0.1 * (i % 30)) / place.x() + Vector3d(0.0, t, 0.1 * t));
    };
    return scene;
  });
}

// Tracks that jump to the next repetition of a texture, and points seen in a mirror that tilts:
// their images turn about it by twice the angle.
TEST(Adversarial, RepetitiveTextureInAMirror) {
  // More places than elsewhere: what the search finds here is right even if it is trusted.
  const Tally tally = askAll(8, [](std::mt19937* random) {
    Scene scene;
    scene.motion = excited(random);
    const double jump_at = std::uniform_real_distribution<double>(0.3, 1.5)(*random);
    const auto tilt = sway(random, 0.2, 0.5, 0.03);
    scene.moved = [jump_at, tilt](int i, const Vector3d& place, double t) {
      const Vector3d mirror(4.0, 0.0, 0.0);
      if (i % 3 == 0 && t > jump_at) return Vector3d(place + Vector3d(0.0, 0.4, 0.0));
      if (i % 3 == 1) return Vector3d(mirror + expSO3(2.0 * tilt(t)) * (place - mirror));
      return place;
    };
    return scene;
  });
  EXPECT_EQ(tally.wrong + tally.wrong_if_trusted, 0);
}

}  // namespace
}  // namespace slim_init
