// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
//
// The bytes are a host: any order of calls to the adapter, with any stamps and values.
#include <vector>

#include "observations.h"
#include "slim_init/initializer.h"
#include "slim_init/vins_adapter/host_adapter.h"

namespace {

using slim_init::fuzz::Bytes;
using namespace slim_init::vins_adapter;  // NOLINT: what is tested

slim_init::vins_adapter::HostState state(double t, Bytes* bytes) {
  HostState out;
  out.stamp = t;
  out.P = bytes->vector(3.0);
  out.V = bytes->vector(2.0);
  out.Ba = bytes->vector(0.1);
  out.Bg = bytes->vector(0.01);
  if (bytes->byte() > 250) out.R(0, 0) = bytes->number(1.0);
  return out;
}

void check(const HostResult& answer) {
  FUZZ_CHECK(answer.result.validate().empty(), answer.result.validate());
  for (const HostState& at : answer.window.states) {
    FUZZ_CHECK(at.P.allFinite() && at.V.allFinite() && at.R.allFinite(), answer.message);
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  // A good flight with changes, or anything.
  const bool flies = bytes.byte() < 192;
  const auto& flight = slim_init::fuzz::flight();
  const slim_init::Calibration calibration =
      flies ? flight.calibration : slim_init::fuzz::rig(&bytes);
  if (!calibration.validate().empty()) return 0;
  std::vector<slim_init::FrameObservation> frames = flight.keyframes;
  std::vector<slim_init::ImuSample> imu = flight.imu;
  if (flies) slim_init::fuzz::change(&frames, &imu, &bytes);
  std::size_t next_frame = 0, next_sample = 0;
  slim_init::InitializerOptions inner =
      slim_init::fuzz::switched(slim_init::InitializerOptions(), &bytes);
  if (!inner.validate().empty()) inner = slim_init::InitializerOptions();
  HostOptions options;
  options.reinit = true;
  options.watchdog = true;
  options.max_wait_ms = -1.0;  // an input that is found has to be found again
  options.estimate_td = bytes.byte() > 127;
  options.estimate_extrinsic = bytes.byte() > 127;
  std::string error;
  const auto adapter =
      HostAdapter::create(slim_init::makeInitializer(calibration, inner), options, &error);
  FUZZ_CHECK(adapter != nullptr, error);

  double now = 0.0;
  std::vector<double> stamps;
  std::vector<HostState> window;
  while (!bytes.empty()) {
    const int call = bytes.below(13);
    // Time goes on; sometimes it jumps.
    const double t = bytes.byte() < 252 ? now : now + bytes.number(5.0);
    switch (call) {
      case 0:
      case 1:
      case 2: {
        if (flies && next_frame == frames.size()) return 0;
        slim_init::FrameObservation frame =
            flies ? frames[next_frame++] : slim_init::fuzz::frame(t, &bytes);
        // The samples up to the frame.
        while (flies && next_sample < imu.size() && imu[next_sample].t < frame.t + 0.02) {
          const slim_init::ImuSample& sample = imu[next_sample++];
          adapter->addImu(sample.t, sample.accel, sample.gyro);
        }
        now = flies ? frame.t : now + 0.1;
        stamps.push_back(frame.t);
        if (stamps.size() > 11) stamps.erase(stamps.begin());
        adapter->addFrame(std::move(frame));
        break;
      }
      case 3: adapter->addLines(t, slim_init::fuzz::frame(t, &bytes).lines); break;
      case 4: adapter->setTd(bytes.number(0.1)); break;
      case 5: check(adapter->seed(stamps)); break;
      case 6: {
        std::vector<HostState> healthy(1 + bytes.below(3));
        for (HostState& one : healthy) one = state(t - 0.1 * bytes.below(20), &bytes);
        check(adapter->recover(stamps, healthy));
        check(adapter->bridge(stamps, healthy));
        break;
      }
      case 7: adapter->propagate(state(now - 1.0, &bytes), t); break;
      case 8: {
        window.push_back(state(t, &bytes));
        if (window.size() > 11) window.erase(window.begin());
        adapter->prepare(window, calibration.R_b_c, calibration.t_b_c);
        adapter->watch(window, calibration.R_b_c, calibration.t_b_c, bytes.byte() > 127);
        break;
      }
      case 9: adapter->imuIntervals(stamps); break;
      case 10: {
        std::vector<double> any(bytes.below(12));
        for (double& one : any) one = now + bytes.number(3.0);
        check(adapter->seed(any));
        break;
      }
      case 11: {
        // 25 s of flight; after 20 the biases are known.
        HostState healthy = state(t, &bytes);
        for (int i = 0; i < 50; ++i, healthy.stamp += 0.5) adapter->learn(healthy);
        break;
      }
      default: {
        if (flies) break;
        // Up to half a second of samples.
        const int count = 5 + bytes.below(20);
        for (int i = 0; i < count; ++i) {
          const slim_init::ImuSample sample = slim_init::fuzz::sample(t - 0.1 + 0.01 * i, &bytes);
          adapter->addImu(sample.t, sample.accel, sample.gyro);
        }
        break;
      }
    }
  }
  return 0;
}
