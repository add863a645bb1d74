// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/provisional.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>

#include "reference_so3.h"
#include "slim_init/evaluation/metrics.h"
#include "slim_init/evaluation/statistics.h"
#include "slim_init/initializer.h"
#include "stream_start.h"

namespace slim_init::evaluation {
namespace {

constexpr double kDegPerRad = 180.0 / M_PI;
// Images at exactly this age count [s].
constexpr double kStampRounding = 1e-3;
// The question at an age is that of the image nearest to it [s].
constexpr double kSameAge = 0.024;
// How an estimator ends well: with an error of position and of the last window's scale below these.
constexpr double kMaxAte = 0.3;  // [m]
constexpr double kMaxScaleError = 0.1;

// Squared length of the error in its standard deviations, per degree of freedom.
double normalized(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) return kNotComputed;
  return llt.matrixL().solve(error).squaredNorm() / static_cast<double>(error.size());
}

double gateValue(const InitResult& answer, GateName name) {
  for (const GateValue& gate : answer.gates) {
    if (gate.name == name) return gate.value;
  }
  return kNotComputed;
}

// `truth` at the times of the states.
NewestErrors errorsOf(const InitResult& answer, const std::vector<NavState>& truth) {
  NewestErrors out;
  if (answer.states.empty() || truth.size() != answer.states.size()) return out;
  const NavState &state = answer.states.back(), &there = truth.back();
  const Eigen::Matrix3d R_b_w = state.R_w_b.transpose();
  const Eigen::Vector3d v = R_b_w * state.v_w_b;
  const Eigen::Vector3d velocity = v - there.R_w_b.transpose() * there.v_w_b;
  const Eigen::Vector3d up = R_b_w.col(2), true_up = there.R_w_b.transpose().col(2);
  out.speed = there.v_w_b.norm();
  out.velocity = velocity.norm();
  out.tilt_deg = kDegPerRad * std::atan2(up.cross(true_up).norm(), up.dot(true_up));
  const WindowMetrics metrics = evaluateWindow(answer, truth);
  if (metrics.computed() && metrics.scale > 0.0) out.log_scale = -std::log(metrics.scale);
  out.log_scale_squared = out.log_scale * out.log_scale / (answer.scale_sigma * answer.scale_sigma);

  const auto last = static_cast<Eigen::Index>(answer.states.size()) - 1;
  if (answer.covariance.rows() < 9 * (last + 1)) return out;
  const Eigen::Matrix<double, 9, 9> P = answer.covariance.block<9, 9>(9 * last, 9 * last);
  // R^T v and R^T e_z with the attitude R Exp(theta). Two axes across the vertical.
  Eigen::Matrix<double, 3, 9> of_velocity = Eigen::Matrix<double, 3, 9>::Zero();
  of_velocity.leftCols<3>() = reference::skew(v);
  of_velocity.rightCols<3>() = R_b_w;
  Eigen::Matrix<double, 2, 3> across;
  across.row(0) = up.unitOrthogonal();
  across.row(1) = up.cross(across.row(0).transpose());
  const Eigen::Matrix<double, 2, 3> of_tilt = across * reference::skew(up);
  out.velocity_squared = normalized(velocity, of_velocity * P * of_velocity.transpose());
  out.tilt_squared =
      normalized(across * (up - true_up), of_tilt * P.topLeftCorner<3, 3>() * of_tilt.transpose());
  return out;
}

std::vector<double> finite(std::vector<double> values) {
  const auto is_not = [](double value) { return !std::isfinite(value); };
  values.erase(std::remove_if(values.begin(), values.end(), is_not), values.end());
  return values;
}

double meanOf(const std::vector<double>& values) { return mean(finite(values)); }
double medianOf(const std::vector<double>& values) { return median(finite(values)); }

template <typename Value>
std::vector<double> collect(const std::vector<const ProvisionalRecord*>& records, Value value) {
  std::vector<double> out;
  for (const ProvisionalRecord* record : records) out.push_back(value(*record));
  return out;
}

void describe(const char* title, const std::vector<const ProvisionalRecord*>& records, int trials,
              std::ostringstream* out) {
  const auto errors =
      collect(records, [](const ProvisionalRecord& r) { return r.errors.velocity; });
  double largest = 0.0;
  int beyond = 0;
  for (const double error : errors) {
    if (std::isfinite(error)) largest = std::max(largest, error);
    if (error > 1.0) ++beyond;
  }
  *out << title << ": " << records.size() << " of " << trials;
  if (records.empty()) {
    *out << "\n";
    return;
  }
  const auto of = [&](auto value) { return collect(records, value); };
  *out << "; velocity error " << medianOf(errors) << " m/s median, " << largest << " maximum, "
       << beyond << " beyond 1, " << 100.0 * medianOf(of([](const ProvisionalRecord& r) {
                                       return r.errors.velocity / r.errors.speed;
                                     }))
       << " % of the speed; squared error over covariance: velocity "
       << meanOf(of([](const ProvisionalRecord& r) { return r.errors.velocity_squared; }))
       << ", tilt " << meanOf(of([](const ProvisionalRecord& r) { return r.errors.tilt_squared; }))
       << ", scale "
       << meanOf(of([](const ProvisionalRecord& r) { return r.errors.log_scale_squared; }))
       << "; solve " << medianOf(of([](const ProvisionalRecord& r) { return r.solve_ms; }))
       << " ms\n";
}

}  // namespace

NewestErrors evaluateNewest(const InitResult& answer, const Sequence& sequence) {
  std::vector<NavState> truth;
  for (const NavState& state : answer.states) {
    truth.push_back(truthAt(sequence, state.t));
    if (!std::isfinite(truth.back().t)) return NewestErrors();
  }
  return errorsOf(answer, truth);
}

std::string runProvisional(const Sequence& sequence, const InitializerOptions& initializer,
                           const ProvisionalRun& options, std::vector<ProvisionalRecord>* records) {
  records->clear();
  if (options.stride < 1)
    return "stride is " + std::to_string(options.stride) + ", must be at least 1";
  int trials = 0;
  for (std::size_t first = 0; first < sequence.frames.size();
       first += static_cast<std::size_t>(options.stride)) {
    const int trial = static_cast<int>(first) / options.stride;
    if (options.max_trials > 0 && trials >= options.max_trials) break;
    std::string error;
    const std::unique_ptr<IInitializer> asked =
        makeInitializer(sequence.calibration, initializer, &error);
    if (asked == nullptr) return error;
    StreamStart start(sequence, first, initializer.imu, asked.get());
    const double t_first = start.timeOf(first);
    // Data that end earlier make no trial.
    if (start.timeOf(sequence.frames.size() - 1) < t_first + options.last_s) break;
    ++trials;
    bool answered = false;
    for (std::size_t frame = first; frame < sequence.frames.size(); ++frame) {
      const double age = start.timeOf(frame) - t_first;
      if (age > (answered ? options.look_s : options.last_s) + kStampRounding) break;
      start.add(frame);
      const auto begin = std::chrono::steady_clock::now();
      const InitResult answer = asked->initialize();
      const auto end = std::chrono::steady_clock::now();
      ProvisionalRecord record;
      record.trial = trial;
      record.t_start = sequence.frames[first].t;
      record.data_s = age;
      record.status = answer.status;
      record.message = answer.message;
      record.solve_ms = std::chrono::duration<double, std::milli>(end - begin).count();
      if (record.answered()) {
        record.errors = evaluateNewest(answer, sequence);
        record.velocity_sigma = gateValue(answer, GateName::kVelocitySigma);
        record.scale_sigma = answer.scale_sigma;
        record.first = !answered;
        if (record.first && options.downstream) {
          record.downstream = options.downstream(sequence, answer);
        }
        answered = true;
      }
      records->push_back(record);
    }
  }
  return "";
}

std::string provisionalTable(const std::vector<ProvisionalRecord>& records, double look_s) {
  std::vector<const ProvisionalRecord*> first, later;
  std::vector<double> times;
  int trials = 0, ran = 0, well = 0, last_trial = -1;
  for (const ProvisionalRecord& record : records) {
    if (record.trial != last_trial) ++trials;
    last_trial = record.trial;
    if (record.first) {
      first.push_back(&record);
      times.push_back(record.data_s);
      if (record.downstream.ran) {
        ++ran;
        // A last window that hardly moved has no scale to be wrong.
        const DownstreamRecord& d = record.downstream;
        if (!d.diverged && d.ate < kMaxAte && !(d.scale_error > kMaxScaleError)) ++well;
      }
    }
    if (record.answered() && std::abs(record.data_s - look_s) < kSameAge) {
      later.push_back(&record);
    }
  }
  std::ostringstream out;
  out << std::setprecision(3);
  std::sort(times.begin(), times.end());
  describe("first estimates", first, trials, &out);
  if (!times.empty()) {
    out << "time to the first estimate: " << medianOf(times) << " s median, "
        << times[static_cast<std::size_t>(0.9 * static_cast<double>(times.size() - 1))]
        << " s p90\n";
  }
  std::ostringstream title;
  title << "estimates at " << look_s << " s";
  describe(title.str().c_str(), later, trials, &out);
  if (ran > 0) {
    out << "estimator started from the first estimate: " << well << " of " << ran
        << " end well (ATE below " << kMaxAte << " m, scale within " << 100.0 * kMaxScaleError
        << " %)\n";
  }
  return out.str();
}

std::string provisionalCsv(const std::vector<ProvisionalRecord>& records) {
  std::ostringstream out;
  out << "trial,t_start,data_s,status,first,speed,velocity_error,velocity_squared,tilt_error_deg,"
         "tilt_squared,log_scale_error,log_scale_squared,velocity_sigma,scale_sigma,solve_ms,"
         "downstream_ran,downstream_diverged,ate,downstream_scale_error\n";
  for (const ProvisionalRecord& r : records) {
    out << r.trial << ',' << r.t_start << ',' << r.data_s << ',' << toString(r.status) << ','
        << r.first << ',' << r.errors.speed << ',' << r.errors.velocity << ','
        << r.errors.velocity_squared << ',' << r.errors.tilt_deg << ',' << r.errors.tilt_squared
        << ',' << r.errors.log_scale << ',' << r.errors.log_scale_squared << ',' << r.velocity_sigma
        << ',' << r.scale_sigma << ',' << r.solve_ms << ',' << r.downstream.ran << ','
        << r.downstream.diverged << ',' << r.downstream.ate << ',' << r.downstream.scale_error
        << '\n';
  }
  return out.str();
}

}  // namespace slim_init::evaluation
