// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "random.h"
#include "slim_init/simulation/trajectory.h"

namespace slim_init::simulation {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kEyeHeight =
    1.5;  // [m] above the floor z = 0, a person's chest or a drone indoors

// amplitude * sin(2 pi frequency t + phase)
struct Sinusoid {
  double amplitude = 0.0;
  double frequency_hz = 0.0;
  double phase = 0.0;  // [rad]
};

// Value and first two time derivatives of one scalar.
struct Jet {
  double value = 0.0;
  double first = 0.0;
  double second = 0.0;
};

// offset + rate t + a sum of sinusoids.
struct Wave {
  double offset = 0.0;
  double rate = 0.0;
  std::vector<Sinusoid> terms;

  Jet at(double t) const {
    Jet jet{offset + rate * t, rate, 0.0};
    for (const Sinusoid& term : terms) {
      const double omega = 2.0 * M_PI * term.frequency_hz;
      const double angle = omega * t + term.phase;
      const double s = term.amplitude * std::sin(angle);
      jet.value += s;
      jet.first += omega * term.amplitude * std::cos(angle);
      jet.second -= omega * omega * s;
    }
    return jet;
  }
};

// Position x, y, z in w [m] and heading angles [rad]: R_w_h = Rz(yaw) Ry(pitch) Rx(roll), where the
// heading frame h has x forward, y left, z up.
struct Motion {
  Wave x, y, z;
  Wave roll, pitch, yaw;
};

class AnalyticTrajectory : public Trajectory {
 public:
  AnalyticTrajectory(Motion motion, const Eigen::Matrix3d& R_h_b, double duration)
      : motion_(std::move(motion)), R_h_b_(R_h_b), duration_(duration) {}

  double begin() const override { return 0.0; }
  double end() const override { return duration_; }

  Kinematics at(double t) const override {
    t = std::clamp(t, 0.0, duration_);
    Kinematics k;
    const Jet position[3] = {motion_.x.at(t), motion_.y.at(t), motion_.z.at(t)};
    for (int axis = 0; axis < 3; ++axis) {
      k.p_w_b[axis] = position[axis].value;
      k.v_w_b[axis] = position[axis].first;
      k.a_w_b[axis] = position[axis].second;
    }
    const Jet roll = motion_.roll.at(t);
    const Jet pitch = motion_.pitch.at(t);
    const Jet yaw = motion_.yaw.at(t);
    const Eigen::Matrix3d R_w_h = (Eigen::AngleAxisd(yaw.value, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(pitch.value, Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(roll.value, Eigen::Vector3d::UnitX()))
                                      .toRotationMatrix();
    // Each angle's rate turns about its own axis, seen from the frame after all rotations.
    const double sr = std::sin(roll.value), cr = std::cos(roll.value);
    const double sp = std::sin(pitch.value), cp = std::cos(pitch.value);
    const Eigen::Vector3d omega_h(roll.first - yaw.first * sp,
                                  pitch.first * cr + yaw.first * sr * cp,
                                  yaw.first * cr * cp - pitch.first * sr);
    k.R_w_b = R_w_h * R_h_b_;
    k.omega_b = R_h_b_.transpose() * omega_h;
    return k;
  }

 private:
  Motion motion_;
  Eigen::Matrix3d R_h_b_;
  double duration_;
};

// Hands out sinusoids with random phases.
class Phases {
 public:
  Phases(unsigned seed, const std::string& name) : random_(seed, ("trajectory/" + name).c_str()) {}
  double next() { return random_.uniform(0.0, 2.0 * M_PI); }
  Sinusoid wave(double amplitude, double frequency_hz) { return {amplitude, frequency_hz, next()}; }

 private:
  Random random_;
};

// A vehicle at rest: sums of amplitudes keep it within 3 mm and 0.2 deg of its mean pose.
Motion hover(Phases phases) {
  Motion m;
  for (Wave* w : {&m.x, &m.y, &m.z}) {
    w->terms = {phases.wave(1.2e-3, 0.31), phases.wave(0.4e-3, 0.83)};
  }
  for (Wave* w : {&m.roll, &m.pitch, &m.yaw}) {
    w->terms = {phases.wave(0.08 * kDegree, 0.27), phases.wave(0.03 * kDegree, 0.71)};
  }
  m.z.offset = kEyeHeight;
  return m;
}

// A drone on a circle of 1.5 m at 1.2 m/s that looks at the same wall all the way, as an outward
// look would turn at 45 deg/s and end every track within half a second.
Motion circle(Phases phases) {
  constexpr double kRadius = 1.5;  // [m]
  constexpr double kTurnsPerSecond = 0.125;
  const double phase = phases.next();
  Motion m;
  m.x.terms = {{kRadius, kTurnsPerSecond, phase + 0.5 * M_PI}, phases.wave(0.08, 0.37)};
  m.y.terms = {{kRadius, kTurnsPerSecond, phase}, phases.wave(0.08, 0.41)};
  m.z = {kEyeHeight, 0.0, {phases.wave(0.30, 0.21), phases.wave(0.04, 0.63)}};
  m.yaw.terms = {phases.wave(0.30, 0.08), phases.wave(0.08, 0.33)};
  m.pitch.terms = {phases.wave(0.06, 0.33), phases.wave(0.02, 0.90)};
  m.roll.terms = {phases.wave(0.07, 0.29), phases.wave(0.02, 0.80)};
  return m;
}

// A drone on a lying eight of 4 m by 2 m at 0.6 to 1.4 m/s, looking about.
Motion figureEight(Phases phases) {
  constexpr double kLoopsPerSecond = 1.0 / 13.0;
  const double phase = phases.next();
  Motion m;
  m.x.terms = {{2.0, kLoopsPerSecond, phase}};
  m.y.terms = {{1.0, 2.0 * kLoopsPerSecond, 2.0 * phase}};
  m.z = {kEyeHeight, 0.0, {phases.wave(0.25, 0.19), phases.wave(0.03, 0.70)}};
  m.yaw.terms = {phases.wave(0.50, 0.09), phases.wave(0.08, 0.35)};
  m.pitch.terms = {phases.wave(0.07, 0.31), phases.wave(0.02, 0.85)};
  m.roll.terms = {phases.wave(0.08, 0.27), phases.wave(0.02, 0.75)};
  return m;
}

// A person carrying the camera: sway at the stride, bounce at the step, slow wander between walls.
Motion corridorWalk(Phases phases) {
  constexpr double kStep = 1.8;            // [Hz] footfalls
  constexpr double kStride = 0.5 * kStep;  // [Hz] left and right together
  Motion m;
  m.x = {0.0, 0.8, {phases.wave(0.003, kStep), phases.wave(0.12, 0.12)}};
  m.y.terms = {phases.wave(0.012, kStride), phases.wave(0.08, 0.10)};
  m.z = {kEyeHeight, 0.0, {phases.wave(0.008, kStep)}};
  m.yaw.terms = {phases.wave(0.03, kStride), phases.wave(0.06, 0.15)};
  m.pitch.terms = {phases.wave(0.02, kStep)};
  m.roll.terms = {phases.wave(0.02, kStride)};
  return m;
}

// Forward at 0.5 m/s with a wobble of centimetres: little parallax, little excitation.
Motion constantVelocity(Phases phases) {
  Motion m;
  m.x.rate = 0.5;
  m.y.terms = {phases.wave(0.012, 0.5), phases.wave(0.04, 0.2)};
  m.z = {kEyeHeight, 0.0, {phases.wave(0.015, 0.7)}};
  m.yaw.terms = {phases.wave(0.03, 0.3)};
  m.pitch.terms = {phases.wave(0.02, 0.4)};
  m.roll.terms = {phases.wave(0.02, 0.35)};
  return m;
}

// The body stands still and looks about; two frequencies each, so that no second is without motion.
Motion pureRotation(Phases phases) {
  Motion m;
  m.z.offset = kEyeHeight;
  m.yaw.terms = {phases.wave(28.0 * kDegree, 0.17), phases.wave(3.0 * kDegree, 0.60)};
  m.pitch.terms = {phases.wave(20.0 * kDegree, 0.13), phases.wave(3.0 * kDegree, 0.50)};
  m.roll.terms = {phases.wave(3.0 * kDegree, 0.25)};
  return m;
}

struct Builtin {
  const char* name;
  Motion (*make)(Phases);
};

constexpr Builtin kBuiltins[] = {
    {"hover", hover},
    {"circle", circle},
    {"figure-eight", figureEight},
    {"corridor-walk", corridorWalk},
    {"constant-velocity", constantVelocity},
    {"pure-rotation", pureRotation},
};

}  // namespace

const std::vector<std::string>& builtinTrajectoryNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Builtin& builtin : kBuiltins) list.emplace_back(builtin.name);
    return list;
  }();
  return names;
}

std::unique_ptr<Trajectory> makeBuiltinTrajectory(const std::string& name, double duration_s,
                                                  const Eigen::Matrix3d& R_b_c, unsigned seed,
                                                  std::string* error) {
  const auto* builtin = std::find_if(std::begin(kBuiltins), std::end(kBuiltins),
                                     [&](const Builtin& b) { return name == b.name; });
  if (builtin == std::end(kBuiltins)) {
    std::string names;
    for (const std::string& known : builtinTrajectoryNames()) names += ' ' + known;
    if (error != nullptr) *error = "unknown trajectory '" + name + "', must be one of" + names;
    return nullptr;
  }
  // Camera (z forward, x right, y down) in the heading frame (x forward, y left, z up).
  Eigen::Matrix3d R_h_c;
  R_h_c << 0, 0, 1,  //
      -1, 0, 0,      //
      0, -1, 0;
  const Eigen::Matrix3d R_c_b = Eigen::Quaterniond(R_b_c).normalized().conjugate().matrix();
  return std::make_unique<AnalyticTrajectory>(builtin->make(Phases(seed, name)), R_h_c * R_c_b,
                                              duration_s);
}

}  // namespace slim_init::simulation
