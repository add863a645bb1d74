// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "slim_init/evaluation/from_rest.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>

#include "slim_init/evaluation/provisional.h"
#include "slim_init/initializer.h"
#include "stream_start.h"

namespace slim_init::evaluation {
namespace {

// A body is at rest that stays within this distance [m] for this long [s].
constexpr double kRestDistance = 0.005;
constexpr double kRestTime = 1.0;
// An initializer has seen so much of the rest [s].
constexpr double kSeenBefore = 3.0;
constexpr double kMovingSpeed = 0.03;  // [m/s]: three standard deviations of the prior

// The first accepted estimate after one onset, or the last refusal.
FromRestRecord start(const Sequence& sequence, const MotionOnset& onset, const ImuLimits& limits,
                     IInitializer* initializer) {
  FromRestRecord record;
  record.t_onset = onset.t;
  StreamStart streams(sequence, onset.first, limits, initializer);
  for (std::size_t frame = onset.first; frame < sequence.frames.size(); ++frame) {
    const double t = streams.timeOf(frame);
    if (t > onset.t + kLongestStart) break;
    streams.add(frame);
    const InitResult answer = initializer->initialize();
    record.status = answer.status;
    record.message = answer.message;
    record.after_s = t - onset.t;
    const bool moves = sequence.truth[frame].v_w_b.norm() > kMovingSpeed;
    if (answer.status == InitStatus::kStationary && answer.gates.empty() && moves) {
      ++record.false_rests;
    }
    if (!answer.success()) continue;
    const NewestErrors errors = evaluateNewest(answer, sequence);
    record.log_scale = errors.log_scale;
    record.velocity = errors.velocity;
    record.scale_sigma = answer.scale_sigma;
    record.from_rest = std::isfinite(answer.at_rest_since);
    break;
  }
  return record;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return kNotComputed;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace

std::vector<MotionOnset> motionOnsets(const Sequence& sequence) {
  std::vector<MotionOnset> onsets;
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

std::string runFromRest(const Sequence& sequence, const InitializerOptions& initializer,
                        std::vector<FromRestRecord>* records) {
  records->clear();
  for (const bool with_prior : {true, false}) {
    InitializerOptions options = initializer;
    options.slim.start_from_rest = with_prior;
    for (const MotionOnset& onset : motionOnsets(sequence)) {
      std::string error;
      const std::unique_ptr<IInitializer> fresh =
          makeInitializer(sequence.calibration, options, &error);
      if (fresh == nullptr) return error;
      records->push_back(start(sequence, onset, options.imu, fresh.get()));
      records->back().with_prior = with_prior;
    }
  }
  return "";
}

std::string fromRestTable(const std::vector<FromRestRecord>& records) {
  std::ostringstream out;
  out << std::setprecision(3);
  for (const bool with_prior : {true, false}) {
    std::vector<double> times;
    int starts = 0, joined = 0, within = 0, beyond = 0, false_rests = 0;
    double squares = 0.0, normalized = 0.0;
    for (const FromRestRecord& record : records) {
      if (record.with_prior != with_prior) continue;
      ++starts;
      false_rests += record.false_rests;
      if (!record.accepted()) continue;
      times.push_back(record.after_s);
      if (record.from_rest) ++joined;
      const double error = std::abs(std::expm1(record.log_scale));
      if (error <= 0.1) ++within;
      if (!(error <= 0.25)) ++beyond;
      squares += error * error;
      normalized += std::pow(record.log_scale / record.scale_sigma, 2);
    }
    const auto n = static_cast<double>(times.size());
    out << (with_prior ? "with the rest as a prior: " : "without:                  ")
        << times.size() << " of " << starts << " starts accepted";
    if (!times.empty()) {
      out << " (" << joined << " from the rest), " << quantile(times, 0.5) << " s median, "
          << quantile(times, 0.9) << " s p90 after " << 100.0 * kOnsetDistance << " cm; scale RMSE "
          << std::sqrt(squares / n) << ", " << 100.0 * within / n << " % within 10 %, " << beyond
          << " beyond 25 %, error over sigma " << std::sqrt(normalized / n);
    }
    if (with_prior) out << "; false rests " << false_rests;
    out << "\n";
  }
  return out.str();
}

std::string fromRestCsv(const std::vector<FromRestRecord>& records) {
  std::ostringstream out;
  out << "t_onset,with_prior,status,after_s,log_scale_error,scale_sigma,velocity_error,from_rest,"
         "false_rests\n";
  for (const FromRestRecord& r : records) {
    out << r.t_onset << ',' << r.with_prior << ',' << toString(r.status) << ',' << r.after_s << ','
        << r.log_scale << ',' << r.scale_sigma << ',' << r.velocity << ',' << r.from_rest << ','
        << r.false_rests << '\n';
  }
  return out.str();
}

}  // namespace slim_init::evaluation
