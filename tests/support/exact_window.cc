// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/exact_window.h"

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <stdexcept>

#include "geometry/so3.h"
#include "imu/preintegration.h"

namespace slim_init {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double min, double max) {
  return std::uniform_real_distribution<double>(min, max)(random);
}
double gaussian(Random& random) { return std::normal_distribution<double>(0.0, 1.0)(random); }
Eigen::Vector3d gaussian3(Random& random) {
  const double x = gaussian(random), y = gaussian(random), z = gaussian(random);
  return {x, y, z};
}

// Angular rate in b [rad/s].
Eigen::Vector3d angularRate(const ExactWindowOptions& options, double t) {
  if (options.angular_rate) return options.angular_rate(t);
  switch (options.motion) {
    case Motion::kExcited:
      return {0.30 * std::sin(1.9 * t), 0.25 * std::cos(1.3 * t + 0.5), 0.20 * std::sin(2.3 * t)};
    case Motion::kPureRotation:
      return {0.25 * std::sin(1.1 * t + 0.3), 0.30 * std::cos(0.9 * t), 0.20};
    case Motion::kConstantVelocity:
      return {0.02 * std::sin(2.0 * t), 0.02 * std::cos(1.7 * t), 0.0};
    case Motion::kHover: return Eigen::Vector3d::Zero();
    case Motion::kFromRest:
      if (t < 0.0) return Eigen::Vector3d::Zero();
      return {0.3 * std::sin(1.9 * t), 0.0, 0.2 * std::sin(2.3 * t)};
  }
  return Eigen::Vector3d::Zero();
}

// Acceleration in w [m/s^2].
Eigen::Vector3d acceleration(Motion motion, double t) {
  if (motion == Motion::kFromRest && t >= 0.0) {
    return {1.2 * std::cos(1.7 * t), 1.5 * std::sin(3.0 * t), 0.9};
  }
  if (motion != Motion::kExcited) return Eigen::Vector3d::Zero();
  return {1.5 * std::sin(2.1 * t), 1.2 * std::cos(1.7 * t + 0.4), 0.9 * std::sin(2.9 * t + 1.0)};
}

Eigen::Vector3d initialVelocity(Motion motion) {
  switch (motion) {
    case Motion::kExcited: return {0.3, -0.4, 0.1};
    case Motion::kConstantVelocity: return {0.1, 0.5, 0.05};
    default: return Eigen::Vector3d::Zero();
  }
}

constexpr double kHalfWidth = 0.75, kHalfHeight = 0.5;  // of the image, on the plane z = 1

bool project(const NavState& state, const Calibration& calibration, const Eigen::Vector3d& X_w,
             Eigen::Vector2d* uv) {
  const Eigen::Matrix3d R_w_c = state.R_w_b * calibration.R_b_c;
  const Eigen::Vector3d c = state.p_w_b + state.R_w_b * calibration.t_b_c;
  const Eigen::Vector3d X_c = R_w_c.transpose() * (X_w - c);
  if (X_c.z() < 0.3) return false;
  *uv = X_c.head<2>() / X_c.z();
  return std::abs(uv->x()) < kHalfWidth && std::abs(uv->y()) < kHalfHeight;
}

// Projects at the exposure of the row in which the point then is.
class RowProjector {
 public:
  RowProjector(const ExactWindow& exact, const std::vector<ImuSample>& imu,
               const Eigen::Vector3d& gravity_w)
      : exact_(exact), imu_(imu), gravity_w_(gravity_w) {}

  bool project(int k, const Eigen::Vector3d& X_w, Eigen::Vector2d* uv, double* row) const {
    const Calibration& calibration = exact_.true_calibration;
    if (!slim_init::project(exact_.truth[k], calibration, X_w, uv)) return false;
    *row = 0.5 * uv->y() / kHalfHeight;
    // A fixed point: the row moves by less than a hundredth of its change of time.
    for (int round = 0; round < 12 && calibration.readout_s > 0.0; ++round) {
      const NavState state = stateAt(k, *row * calibration.readout_s);
      if (!slim_init::project(state, calibration, X_w, uv)) return false;
      *row = 0.5 * uv->y() / kHalfHeight;
    }
    return true;
  }

 private:
  // The body dt after keyframe k; backwards from it by the same samples.
  NavState stateAt(int k, double dt) const {
    const NavState& at = exact_.truth[k];
    const auto integral = [&](double from, double to) {
      return preintegrate(imu_, from, to, {at.gyro_bias, at.accel_bias},
                          exact_.calibration.imu_noise, PreintegrationParts::kMean);
    };
    if (dt >= 0.0) return propagate(at, integral(at.t, at.t + dt), gravity_w_);
    const Preintegration pre = integral(at.t + dt, at.t);
    NavState before = at;
    before.t = at.t + dt;
    before.R_w_b = at.R_w_b * pre.dR.transpose();
    before.v_w_b = at.v_w_b - gravity_w_ * pre.dt - before.R_w_b * pre.dv;
    before.p_w_b = at.p_w_b - before.v_w_b * pre.dt - 0.5 * gravity_w_ * pre.dt * pre.dt -
                   before.R_w_b * pre.dp;
    return before;
  }

  const ExactWindow& exact_;
  const std::vector<ImuSample>& imu_;
  Eigen::Vector3d gravity_w_;
};

// Hands in a calibration that is off by a draw, and stamps to match its td.
void miscalibrate(const ExactWindowOptions& options, ExactWindow* exact) {
  const CalibrationSigmas& sigmas = options.calibration_error;
  if (sigmas == kExactCalibration) return;
  Random random(options.seed + 3000);
  const Eigen::Vector3d rotation = sigmas.rotation_deg * M_PI / 180.0 * gaussian3(random);
  const Eigen::Vector3d translation = sigmas.translation_m * gaussian3(random);
  exact->true_calibration.td = sigmas.td_s * gaussian(random);
  exact->calibration.R_b_c = exact->true_calibration.R_b_c * expSO3(-rotation);
  exact->calibration.t_b_c = exact->true_calibration.t_b_c - translation;
  for (FrameObservation& frame : exact->keyframes) frame.t -= exact->true_calibration.td;
}

// A place seen by keyframe `state` at a random bearing and depth.
Eigen::Vector3d randomPlace(Random& random, const NavState& state, const Calibration& calibration) {
  const double z = uniform(random, 2.0, 8.0);
  const double x = uniform(random, -0.9 * kHalfWidth, 0.9 * kHalfWidth);
  const double y = uniform(random, -0.9 * kHalfHeight, 0.9 * kHalfHeight);
  const Eigen::Vector3d X_b =
      calibration.R_b_c * Eigen::Vector3d(x * z, y * z, z) + calibration.t_b_c;
  return state.p_w_b + state.R_w_b * X_b;
}

Eigen::Vector3d noisyBearing(Random& random, const Eigen::Vector2d& uv, double sigma,
                             bool angular) {
  const double dx = sigma * gaussian(random), dy = sigma * gaussian(random);
  if (angular) {
    const Eigen::Vector3d bearing = uv.homogeneous().normalized();
    return (bearing + tangentBasis(bearing) * Eigen::Vector2d(dx, dy)).normalized();
  }
  return Eigen::Vector3d(uv.x() + dx, uv.y() + dy, 1.0).normalized();
}

}  // namespace

Calibration eurocCalibration() {
  Calibration calibration;
  Eigen::Matrix3d R;
  R << 0.0148655429818, -0.999880929698, 0.00414029679422, 0.999557249008, 0.0149672133247,
      0.025715529948, -0.0257744366974, 0.00375618835797, 0.999660727178;
  calibration.R_b_c = nearestRotation(R);
  calibration.t_b_c = Eigen::Vector3d(-0.0216401454975, -0.064676986768, 0.00981073058949);
  calibration.focal_px = 458.0;
  return calibration;
}

ExactWindowOptions drawnFromTheModel(unsigned seed, double accel_bias_sigma) {
  ExactWindowOptions options;
  options.seed = seed;
  options.pixel_noise = 0.6;
  options.angular_noise = true;
  options.imu_noise = true;
  Random random(seed + 2000);
  options.accel_bias = accel_bias_sigma * gaussian3(random);
  return options;
}

ExactWindowOptions drawnWithCalibration(unsigned seed, double accel_bias_sigma) {
  ExactWindowOptions options = drawnFromTheModel(seed, accel_bias_sigma);
  options.calibration_error = CalibrationSigmas();
  // Samples to either side of the keyframes, which td moves.
  options.keyframe_offset_s = 0.0217;
  return options;
}

ExactWindowOptions drawnWithExactCalibration(unsigned seed, double accel_bias_sigma) {
  ExactWindowOptions options = drawnFromTheModel(seed, accel_bias_sigma);
  options.calibration_sigmas = kExactCalibration;
  return options;
}

ExactWindowOptions drawnStream(unsigned seed, Motion motion, int keyframes) {
  ExactWindowOptions options = drawnWithExactCalibration(seed, 0.05);
  options.motion = motion;
  options.keyframes = keyframes;
  options.interval_s = 0.1;
  return options;
}

ExactWindow makeExactWindow(const ExactWindowOptions& options) {
  ExactWindow out;
  out.calibration = eurocCalibration();
  out.calibration.sigmas = options.calibration_sigmas;
  const Eigen::Vector3d gravity_w(0.0, 0.0, -out.calibration.gravity_magnitude);
  Random random(options.seed);

  // Samples along the designed motion; the attitude at the samples is integrated step by step.
  const double h = 1.0 / options.imu_rate_hz;
  const double duration = (options.keyframes - 1) * options.interval_s + options.keyframe_offset_s;
  const Eigen::Vector3d mount_up(0.0, 1.1, 0.0);  // EuRoC-like: the body's x axis points up
  // Motion and scene turn with the yaw, so that the sensors see the same for any yaw and origin.
  const Eigen::Matrix3d R_w_h = expSO3(Eigen::Vector3d(0, 0, options.yaw_rad));
  Eigen::Matrix3d R_w_b = R_w_h * expSO3(-1.4 * mount_up);
  const Eigen::Matrix3d R_w_b_start = R_w_b;
  Random noise(options.seed + 1000);
  // A few samples more where the keyframes are moved or rows have times of their own.
  const bool margin = options.readout_s > 0.0 || options.calibration_error.td_s > 0.0;
  const double end = duration + (margin ? 0.02 + options.readout_s : 0.0);
  const double begin = options.motion == Motion::kFromRest ? options.rest_s : 0.0;
  for (int k = 0; (k - 2) * h < end; ++k) {
    const double t = k * h - begin;
    ImuSample sample;
    sample.t = k * h;
    sample.gyro = angularRate(options, t) + options.gyro_bias;
    sample.accel = R_w_b.transpose() * (R_w_h * acceleration(options.motion, t) - gravity_w) +
                   options.accel_bias;
    out.imu.push_back(sample);
    R_w_b *= expSO3(0.5 * h * (angularRate(options, t) + angularRate(options, t + h)));
  }

  // The truth at the keyframes is the integral of these samples.
  NavState state;
  state.R_w_b = R_w_b_start;
  state.p_w_b = options.origin;
  state.v_w_b = R_w_h * initialVelocity(options.motion);
  state.gyro_bias = options.gyro_bias;
  state.accel_bias = options.accel_bias;
  const auto advance = [&](double t) {
    if (t <= state.t) return;
    state = propagate(state,
                      preintegrate(out.imu, state.t, t, {options.gyro_bias, options.accel_bias},
                                   out.calibration.imu_noise, PreintegrationParts::kMean),
                      gravity_w);
    state.t = t;
  };
  state.t = 0.0;
  for (int k = 0; k < options.keyframes; ++k) {
    advance(options.keyframe_offset_s + k * options.interval_s);
    out.truth.push_back(state);
  }
  const std::vector<ImuSample> true_imu = out.imu;
  if (options.imu_noise) {
    const double root = std::sqrt(options.imu_rate_hz);
    for (ImuSample& sample : out.imu) {
      sample.gyro += out.calibration.imu_noise.gyro_density * root * gaussian3(noise);
      sample.accel += out.calibration.imu_noise.accel_density * root * gaussian3(noise);
    }
  }

  out.calibration.readout_s = options.readout_s;
  out.true_calibration = out.calibration;
  out.keyframes.resize(options.keyframes);
  for (int k = 0; k < options.keyframes; ++k) out.keyframes[k].t = out.truth[k].t;
  const RowProjector projector(out, true_imu, gravity_w);
  const double sigma = options.pixel_noise / out.calibration.focal_px;
  for (int id = 0; id < options.points; ++id) {
    const Eigen::Vector3d X_w =
        randomPlace(random, out.truth[id % options.keyframes], out.calibration);
    for (int k = 0; k < options.keyframes; ++k) {
      Eigen::Vector2d uv;
      PointObservation point;
      if (!projector.project(k, X_w, &uv, &point.row)) continue;
      point.id = id;
      point.bearing = noisyBearing(random, uv, sigma, options.angular_noise);
      out.keyframes[k].points.push_back(point);
    }
  }
  for (int id = 0; id < options.lines; ++id) {
    Eigen::Vector3d direction = gaussian3(random).normalized();
    if (id % 5 < 3 || options.parallel_lines_only) {
      direction = Eigen::Vector3d::UnitZ();
    } else if (id % 5 == 3) {
      direction = Eigen::Vector3d::UnitX();
    }
    direction = R_w_h * direction;
    const Eigen::Vector3d middle =
        randomPlace(random, out.truth[(3 * id) % options.keyframes], out.calibration);
    for (int k = 0; k < options.keyframes; ++k) {
      Eigen::Vector2d s, e;
      const double from = uniform(random, 0.3, 0.5), to = uniform(random, 0.3, 0.5);
      LineObservation line;
      if (!projector.project(k, middle - from * direction, &s, &line.start_row)) continue;
      if (!projector.project(k, middle + to * direction, &e, &line.end_row)) continue;
      if ((e - s).norm() * out.calibration.focal_px < 20.0) continue;
      line.id = id;
      line.start_bearing = noisyBearing(random, s, sigma, options.angular_noise);
      line.end_bearing = noisyBearing(random, e, sigma, options.angular_noise);
      line.length_px = (e - s).norm() * out.calibration.focal_px;
      line.detection_confidence = 0.9;
      line.match_quality = 0.95;
      out.keyframes[k].lines.push_back(line);
    }
  }
  miscalibrate(options, &out);
  out.window = InitWindow::create(out.calibration, out.keyframes, out.imu);
  return out;
}

ExactWindow noisyWindow(ExactWindowOptions options) {
  options.pixel_noise = 0.6;
  options.imu_noise = true;
  return makeExactWindow(options);
}

ExactWindow noisyWindow(Motion motion, unsigned seed) {
  ExactWindowOptions options;
  options.motion = motion;
  options.seed = seed;
  return noisyWindow(options);
}

std::shared_ptr<const InitWindow> madeWindow(const Calibration& calibration,
                                             const std::vector<FrameObservation>& keyframes,
                                             const std::vector<ImuSample>& imu,
                                             const std::vector<SpeedSample>& speeds) {
  std::string error;
  auto window = InitWindow::create(calibration, keyframes, imu, &error, speeds);
  if (window == nullptr) throw std::runtime_error(error);
  return window;
}

std::shared_ptr<const InitWindow> windowOf(const ExactWindow& exact,
                                           const std::vector<FrameObservation>& keyframes) {
  return madeWindow(exact.calibration, keyframes, exact.imu);
}

std::shared_ptr<const InitWindow> windowOf(const ExactWindow& exact) {
  return windowOf(exact, exact.keyframes);
}

std::shared_ptr<const InitWindow> miscalibrated(const ExactWindow& exact,
                                                const Eigen::Vector3d& turn, double td,
                                                const CalibrationSigmas& sigmas) {
  Calibration calibration = exact.calibration;
  calibration.R_b_c = calibration.R_b_c * expSO3(-turn);
  calibration.sigmas = sigmas;
  std::vector<FrameObservation> keyframes = exact.keyframes;
  for (FrameObservation& frame : keyframes) frame.t -= td;
  std::vector<ImuSample> imu = exact.imu;
  if (keyframes.front().t < imu.front().t) {
    imu.insert(imu.begin(), imu.front());
    imu.front().t = keyframes.front().t;
  }
  if (keyframes.back().t > imu.back().t) {
    imu.push_back(imu.back());
    imu.back().t = keyframes.back().t;
  }
  return madeWindow(calibration, keyframes, imu);
}

ExactWindow withSlidingPoints(ExactWindow exact, int points) {
  for (std::size_t k = 0; k < exact.keyframes.size(); ++k) {
    for (PointObservation& point : exact.keyframes[k].points) {
      if (point.id >= points) continue;
      const double shift = 8.0 / exact.calibration.focal_px * static_cast<double>(k);
      const double way = 1.3 * static_cast<double>(point.id);
      point.bearing += shift * Eigen::Vector3d(std::cos(way), std::sin(way), 0.0);
      point.bearing.normalize();
    }
  }
  exact.window = windowOf(exact);
  return exact;
}

void shift(double dx_px, double dy_px, double focal_px, PointObservation* point) {
  const Eigen::Vector3d f = point->bearing / point->bearing.z();
  point->bearing = (f + Eigen::Vector3d(dx_px / focal_px, dy_px / focal_px, 0.0)).normalized();
}

double scaleError(const std::vector<NavState>& estimate, const std::vector<NavState>& truth) {
  const auto spread = [](const std::vector<NavState>& states) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const NavState& state : states) mean += state.p_w_b;
    mean /= static_cast<double>(states.size());
    double sum = 0.0;
    for (const NavState& state : states) sum += (state.p_w_b - mean).squaredNorm();
    return std::sqrt(sum);
  };
  return spread(estimate) / spread(truth) - 1.0;
}

double gravityErrorRad(const Eigen::Vector3d& gravity_b0, const NavState& first_truth) {
  const Eigen::Vector3d truth = first_truth.R_w_b.transpose() * Eigen::Vector3d(0, 0, -1);
  return std::atan2(gravity_b0.cross(truth).norm(), gravity_b0.dot(truth));
}

}  // namespace slim_init
