// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/starts.h"

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
// Images at exactly this time count [s].
constexpr double kStampRounding = 1e-3;
// The estimate at a time is that of the image nearest to it [s].
constexpr double kSameTime = 0.024;
// How an estimator ends well: with an error of position and of the last window's scale below these.
constexpr double kMaxAte = 0.3;  // [m]
constexpr double kMaxScaleError = 0.1;
// A body is at rest that stays within this distance [m] for this long [s].
constexpr double kRestDistance = 0.005;
constexpr double kRestTime = 1.0;
// An initializer has seen so much of the rest [s].
constexpr double kSeenBefore = 3.0;
constexpr double kMovingSpeed = 0.03;  // [m/s]: three standard deviations of the prior

// Squared length of the error in its standard deviations, per degree of freedom.
double normalized(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) return kNotComputed;
  return llt.matrixL().solve(error).squaredNorm() / static_cast<double>(error.size());
}

// Against the ground truth at the times of the states; nothing where one of them has none.
NewestErrors errorsOf(const InitResult& answer, const Sequence& sequence) {
  NewestErrors out;
  std::vector<NavState> truth;
  for (const NavState& state : answer.states) {
    truth.push_back(truthAt(sequence, state.t));
    if (!std::isfinite(truth.back().t)) return out;
  }
  if (truth.empty()) return out;
  const NavState &state = answer.states.back(), &there = truth.back();
  const Eigen::Matrix3d R_b_w = state.R_w_b.transpose();
  const Eigen::Vector3d v = R_b_w * state.v_w_b;
  const Eigen::Vector3d velocity = v - there.R_w_b.transpose() * there.v_w_b;
  const Eigen::Vector3d up = R_b_w.col(2), true_up = there.R_w_b.transpose().col(2);
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

// Solves at every image after one start.
void runStart(const Sequence& sequence, const Start& start, const StartRun& run, StartRecord record,
              IInitializer* initializer, std::vector<StartRecord>* records) {
  StreamStart streams(sequence, start.first, run.initializer.imu, initializer);
  bool answered = false;
  for (std::size_t frame = start.first; frame < sequence.frames.size(); ++frame) {
    record.after_s = streams.timeOf(frame) - start.t;
    if (answered && (run.look_s < 0.0 || record.after_s > run.look_s + kStampRounding)) break;
    if (record.after_s > run.last_s + kStampRounding) break;
    streams.add(frame);
    const auto begin = std::chrono::steady_clock::now();
    const InitResult answer = initializer->initialize();
    const auto end = std::chrono::steady_clock::now();
    StartRecord solve = record;
    solve.status = answer.status;
    solve.solve_ms = std::chrono::duration<double, std::milli>(end - begin).count();
    solve.false_rest = answer.status == InitStatus::kStationary && answer.gates.empty() &&
                       sequence.truth[frame].v_w_b.norm() > kMovingSpeed;
    if (solve.answered()) {
      solve.errors = errorsOf(answer, sequence);
      solve.scale_sigma = answer.scale_sigma;
      solve.from_rest = std::isfinite(answer.at_rest_since);
      solve.first = !answered;
      if (solve.first && run.downstream) solve.downstream = run.downstream(sequence, answer);
      answered = true;
    }
    records->push_back(std::move(solve));
  }
}

// The finite values of the records.
template <typename Value>
std::vector<double> collect(const std::vector<const StartRecord*>& records, Value value) {
  std::vector<double> out;
  for (const StartRecord* record : records) {
    if (const double x = value(*record); std::isfinite(x)) out.push_back(x);
  }
  return out;
}

template <typename Is>
std::size_t count(const std::vector<const StartRecord*>& records, Is is) {
  return static_cast<std::size_t>(
      std::count_if(records.begin(), records.end(), [&](const StartRecord* r) { return is(*r); }));
}

double scaleError(const StartRecord& r) { return std::abs(std::expm1(r.errors.log_scale)); }

void describe(const std::string& title, const std::vector<const StartRecord*>& records,
              std::size_t starts, std::ostringstream* out) {
  *out << title << ": " << records.size() << " of " << starts;
  if (records.empty()) {
    *out << "\n";
    return;
  }
  const auto of = [&](auto value) { return collect(records, value); };
  const auto times = of([](const StartRecord& r) { return r.after_s; });
  const auto velocities = of([](const StartRecord& r) { return r.errors.velocity; });
  const auto scales = of(scaleError);
  const auto overSigma = [&](auto value) { return std::sqrt(mean(of(value))); };
  *out << ", after " << median(times) << " s median, " << quantile(times, 0.9)
       << " s p90; velocity error " << median(velocities) << " m/s median, "
       << quantile(velocities, 1.0) << " maximum, "
       << count(records, [](const StartRecord& r) { return r.errors.velocity > 1.0; })
       << " beyond 1; scale RMSE " << rootMeanSquare(scales) << ", "
       << count(records, [](const StartRecord& r) { return scaleError(r) <= 0.1; })
       << " within 10 %, "
       << count(records, [](const StartRecord& r) { return !(scaleError(r) <= 0.25); })
       << " beyond 25 %; error over sigma: velocity "
       << overSigma([](const StartRecord& r) { return r.errors.velocity_squared; }) << ", tilt "
       << overSigma([](const StartRecord& r) { return r.errors.tilt_squared; }) << ", scale "
       << overSigma([](const StartRecord& r) { return r.errors.log_scale_squared; }) << "; solve "
       << median(of([](const StartRecord& r) { return r.solve_ms; })) << " ms\n";
}

}  // namespace

std::vector<Start> startsEvery(int stride, int limit, double seconds, const Sequence& sequence) {
  std::vector<Start> starts;
  const auto timeOf = [&](const FrameObservation& frame) {
    return sequence.calibration.imuTime(frame.t);
  };
  for (std::size_t first = 0; first < sequence.frames.size();
       first += static_cast<std::size_t>(stride)) {
    const double t = timeOf(sequence.frames[first]);
    if (limit > 0 && starts.size() >= static_cast<std::size_t>(limit)) break;
    if (timeOf(sequence.frames.back()) < t + seconds) break;
    starts.push_back({first, t});
  }
  return starts;
}

std::vector<Start> motionOnsets(const Sequence& sequence) {
  std::vector<Start> onsets;
  const std::vector<NavState>& truth = sequence.truth;
  std::size_t first = 0;  // of the present rest
  for (std::size_t k = 1; k < truth.size(); ++k) {
    if (!std::isfinite(truth[k].t) || !std::isfinite(truth[first].t)) {
      first = k;
      continue;
    }
    const double distance = (truth[k].p_w_b - truth[first].p_w_b).norm();
    if (distance < kRestDistance) continue;
    if (truth[k].t - truth[first].t < kRestTime) {
      // Not a rest: the next one may begin later.
      ++first;
      k = first;
      continue;
    }
    while (k < truth.size() && (truth[k].p_w_b - truth[first].p_w_b).norm() < kOnsetDistance) ++k;
    if (k == truth.size()) break;
    std::size_t begin = first;
    while (truth[k].t - truth[begin].t > kSeenBefore) ++begin;
    onsets.push_back({begin, truth[k].t});
    first = k;
  }
  return onsets;
}

std::string runStarts(const Sequence& sequence, const std::vector<Start>& starts,
                      const StartRun& run, std::vector<StartRecord>* records) {
  StartRecord record;
  record.with_prior = run.initializer.slim.start_from_rest;
  for (const Start& start : starts) {
    std::string error;
    const std::unique_ptr<IInitializer> fresh =
        makeInitializer(sequence.calibration, run.initializer, &error);
    if (fresh == nullptr) return error;
    record.t_start = start.t;
    runStart(sequence, start, run, record, fresh.get(), records);
    ++record.start;
  }
  return "";
}

std::string startsTable(const std::string& title, const std::vector<StartRecord>& records,
                        std::size_t starts, double look_s) {
  std::vector<const StartRecord*> all, first, later;
  for (const StartRecord& record : records) {
    all.push_back(&record);
    if (record.first) first.push_back(&record);
    if (record.answered() && std::abs(record.after_s - look_s) < kSameTime) {
      later.push_back(&record);
    }
  }
  std::ostringstream out;
  out << std::setprecision(3);
  describe(title, first, starts, &out);
  if (look_s >= 0.0) {
    std::ostringstream at;
    at << "estimates at " << look_s << " s";
    describe(at.str(), later, starts, &out);
  }
  const std::size_t rests = count(first, [](const StartRecord& r) { return r.from_rest; });
  const std::size_t false_rests = count(all, [](const StartRecord& r) { return r.false_rest; });
  if (rests + false_rests > 0) {
    out << "from the rest: " << rests << "; false rests " << false_rests << "\n";
  }
  const std::size_t ran = count(first, [](const StartRecord& r) { return r.downstream.ran; });
  if (ran > 0) {
    // A last window that hardly moved has no scale to be wrong.
    const std::size_t well = count(first, [](const StartRecord& r) {
      const DownstreamRecord& d = r.downstream;
      return d.ran && !d.diverged && d.ate < kMaxAte && !(d.scale_error > kMaxScaleError);
    });
    out << "estimator started from the first estimate: " << well << " of " << ran
        << " end well (ATE below " << kMaxAte << " m, scale within " << 100.0 * kMaxScaleError
        << " %)\n";
  }
  return out.str();
}

std::string startsCsv(const std::vector<StartRecord>& records) {
  std::ostringstream out;
  out << "start,t_start,with_prior,after_s,status,first,from_rest,false_rest,velocity_error,"
         "velocity_squared,tilt_error_deg,tilt_squared,log_scale_error,log_scale_squared,"
         "scale_sigma,solve_ms,downstream_ran,downstream_diverged,ate,downstream_scale_error\n";
  for (const StartRecord& r : records) {
    out << r.start << ',' << r.t_start << ',' << r.with_prior << ',' << r.after_s << ','
        << toString(r.status) << ',' << r.first << ',' << r.from_rest << ',' << r.false_rest << ','
        << r.errors.velocity << ',' << r.errors.velocity_squared << ',' << r.errors.tilt_deg << ','
        << r.errors.tilt_squared << ',' << r.errors.log_scale << ',' << r.errors.log_scale_squared
        << ',' << r.scale_sigma << ',' << r.solve_ms << ',' << r.downstream.ran << ','
        << r.downstream.diverged << ',' << r.downstream.ate << ',' << r.downstream.scale_error
        << '\n';
  }
  return out.str();
}

}  // namespace slim_init::evaluation
