// Copyright (c) 2026, the slim_init authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_faults.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace slim_init::tools {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

using Random = std::mt19937_64;

double uniform(Random& random) { return std::uniform_real_distribution<double>(0.0, 1.0)(random); }
double normal(Random& random) { return std::normal_distribution<double>()(random); }

// Whether the track is one of the `share` that are afflicted, the same in every image.
bool isChosen(FeatureId id, double share) {
  std::uint64_t x = static_cast<std::uint64_t>(id) * 0x9e3779b97f4a7c15ull;
  x ^= x >> 32;
  return static_cast<double>(x & 0xffff) < share * 65536.0;
}

using Fault = std::function<void(const FaultInput&)>;
using Image = Delivered<FrameObservation>;

// `change`(sample) for the samples with trouble.
template <typename Change>
Fault eachSample(Change change) {
  return [change](const FaultInput& in) {
    for (auto& imu : in.streams.imu) {
      if (in.trouble.holds(imu.true_t)) change(imu.message);
    }
  };
}

// `change`(sample as delivered, input) for all samples, `change`(frame as delivered, input) for all
// images, and `change`(point, time of its image, input) for the points of those with trouble.
template <typename Change>
Fault eachImu(Change change) {
  return [change](const FaultInput& in) {
    for (auto& imu : in.streams.imu) change(imu, in);
  };
}
template <typename Change>
Fault eachFrame(Change change) {
  return [change](const FaultInput& in) {
    for (auto& frame : in.streams.frames) change(frame, in);
  };
}
template <typename Change>
Fault eachPoint(Change change) {
  return eachFrame([change](Image& frame, const FaultInput& in) {
    if (!in.trouble.holds(frame.true_t)) return;
    for (PointObservation& point : frame.message.points) change(point, frame.true_t, in);
  });
}

template <typename List, typename Is>
void removeIf(List& list, const Is& is) {
  list.erase(std::remove_if(list.begin(), list.end(), is), list.end());
}

// Moves a point by pixels on the image plane.
void move(PointObservation& point, double x_px, double y_px, const FaultInput& in) {
  const Eigen::Vector3d ray = point.bearing / point.bearing.z();
  const Eigen::Vector3d by = Eigen::Vector3d(x_px, y_px, 0.0) / in.streams.calibration.focal_px;
  point.bearing = (ray + by).normalized();
}

void imuGapOf(double seconds, const FaultInput& in) {
  const Trouble gap = {in.trouble.begin, in.trouble.begin + seconds};
  removeIf(in.streams.imu, [&](const auto& imu) { return gap.holds(imu.true_t); });
}

void shiftImuStamps(double seconds, const FaultInput& in) {
  for (auto& imu : in.streams.imu) {
    if (imu.true_t >= in.trouble.begin) imu.message.t += seconds;
  }
}

std::vector<StreamFault> imuFaults() {
  return {
      {"imu-spike", "one sample of 1000 m/s^2", false,
       [](const FaultInput& in) {
         for (auto& imu : in.streams.imu) {
           if (imu.true_t < in.trouble.begin) continue;
           imu.message.accel.x() += 1000.0;
           return;
         }
       }},
      {"imu-spike-within-limits", "+100 m/s^2 for 25 ms", false,
       [](const FaultInput& in) {
         eachSample([](ImuSample& sample) { sample.accel.x() += 100.0; })(
             {{in.trouble.begin, in.trouble.begin + 0.025}, in.random, in.streams});
       }},
      {"imu-noise", "noise of 20 m/s^2 and 1 rad/s", false,
       eachImu([](Delivered<ImuSample>& imu, const FaultInput& in) {
         for (int i = 0; i < 3 && in.trouble.holds(imu.true_t); ++i) {
           imu.message.accel[i] += 20.0 * normal(in.random);
           imu.message.gyro[i] += normal(in.random);
         }
       })},
      {"imu-stuck", "the sensor repeats one sample", false,
       [](const FaultInput& in) {
         const ImuSample* first = nullptr;
         eachSample([&first](ImuSample& sample) {
           if (first == nullptr) first = &sample;
           sample.accel = first->accel;
           sample.gyro = first->gyro;
         })(in);
       }},
      {"imu-saturated", "rates end at 0.5 rad/s, forces at 12 m/s^2", true,
       eachSample([](ImuSample& sample) {
         sample.gyro = sample.gyro.cwiseMax(-0.5).cwiseMin(0.5);
         sample.accel = sample.accel.cwiseMax(-12.0).cwiseMin(12.0);
       })},
      {"imu-axes-swapped", "x and y exchanged", true, eachSample([](ImuSample& sample) {
         std::swap(sample.gyro.x(), sample.gyro.y());
         std::swap(sample.accel.x(), sample.accel.y());
       })},
      {"imu-scale", "forces times 1.05", true,
       eachSample([](ImuSample& sample) { sample.accel *= 1.05; })},
      {"imu-gap-150ms", "no samples for 0.15 s", false,
       [](const FaultInput& in) { imuGapOf(0.15, in); }},
      {"imu-gap-600ms", "no samples for 0.6 s", false,
       [](const FaultInput& in) { imuGapOf(0.6, in); }},
      {"imu-drops", "one sample in ten is missing", true,
       [](const FaultInput& in) {
         removeIf(in.streams.imu, [&](const auto&) { return uniform(in.random) < 0.1; });
       }},
      {"imu-jitter", "stamps off by 2 ms", true,
       eachImu([](Delivered<ImuSample>& imu, const FaultInput& in) {
         imu.message.t += 0.002 * normal(in.random);
       })},
      {"imu-bursts", "samples arrive 0.2 s at a time", true,
       eachImu([](Delivered<ImuSample>& imu, const FaultInput&) {
         imu.arrival = 0.2 * std::ceil(imu.arrival / 0.2);
       })},
      {"imu-clock-200ppm", "the IMU's clock runs away by 200 ppm", true,
       eachImu([](Delivered<ImuSample>& imu, const FaultInput& in) {
         imu.message.t += 200e-6 * (imu.true_t - in.streams.imu.front().true_t);
       })},
      {"imu-jump-ahead", "stamps of the IMU jump 5 s ahead and stay there", false,
       [](const FaultInput& in) { shiftImuStamps(5.0, in); }},
      {"imu-jump-back", "stamps of the IMU jump 5 s back and stay there", false,
       [](const FaultInput& in) { shiftImuStamps(-5.0, in); }},
  };
}

std::vector<StreamFault> cameraFaults() {
  return {
      {"camera-drops", "every second image is missing", true,
       [](const FaultInput& in) {
         removeIf(in.streams.frames, [&](const auto&) { return uniform(in.random) < 0.5; });
       }},
      {"camera-repeats", "one image in five comes twice", true,
       [](const FaultInput& in) {
         std::vector<Delivered<FrameObservation>> frames;
         for (const auto& frame : in.streams.frames) {
           frames.push_back(frame);
           if (uniform(in.random) < 0.2) frames.push_back(frame);
         }
         in.streams.frames = frames;
       }},
      {"camera-late", "images arrive 0.5 s late", true,
       eachFrame([](Image& frame, const FaultInput&) { frame.arrival += 0.5; })},
      {"camera-order", "one image in five arrives after the next", true,
       eachFrame([](Image& frame, const FaultInput& in) {
         frame.arrival += uniform(in.random) < 0.2 ? 0.12 : 0.0;
       })},
      {"camera-jitter", "stamps off by 2 ms", true,
       eachFrame([](Image& frame, const FaultInput& in) {
         frame.message.t += 0.002 * normal(in.random);
       })},
      {"camera-gone", "no images", false,
       [](const FaultInput& in) {
         removeIf(in.streams.frames,
                  [&](const auto& frame) { return in.trouble.holds(frame.true_t); });
       }},
      {"camera-dark", "images with nothing in them; tracks are new afterwards", false,
       eachFrame([](Image& frame, const FaultInput& in) {
         if (in.trouble.holds(frame.true_t)) frame.message.points.clear();
         if (in.trouble.holds(frame.true_t)) frame.message.lines.clear();
         if (frame.true_t < in.trouble.end) return;
         for (PointObservation& point : frame.message.points) point.id += 1000000;
         for (LineObservation& line : frame.message.lines) line.id += 1000000;
       })},
      {"lens-half-covered", "nothing in the left half", true,
       eachFrame([](Image& frame, const FaultInput&) {
         removeIf(frame.message.points,
                  [](const PointObservation& p) { return p.bearing.x() < 0; });
         removeIf(frame.message.lines, [](const LineObservation& l) {
           return l.start_bearing.x() < 0 || l.end_bearing.x() < 0;
         });
       })},
      {"lens-drops", "one track in ten stands still in the image", true,
       eachPoint([](PointObservation& point, double, const FaultInput&) {
         if (!isChosen(point.id, 0.1)) return;
         const double angle = static_cast<double>(point.id % 360) * kRadPerDeg;
         point.bearing = Eigen::Vector3d(0.3 * std::cos(angle), 0.3 * std::sin(angle), 1.0);
         point.bearing.normalize();
       })},
      {"vehicle-in-view", "three tracks in ten stand still in the lower part of the image", true,
       eachPoint([](PointObservation& point, double, const FaultInput& in) {
         if (!isChosen(point.id, 0.3)) return;
         // Places all over the lower part, and the noise of a tracker on them. One number after the
         // other: compilers differ in the order of arguments.
         const double sigma = 0.3 / in.streams.calibration.focal_px;
         const double v = sigma * normal(in.random), u = sigma * normal(in.random);
         const double x = static_cast<double>(point.id % 97) / 97.0 - 0.5;
         const double y = 0.2 + 0.2 * static_cast<double>(point.id % 31) / 31.0;
         point.bearing = Eigen::Vector3d(x + u, y + v, 1.0).normalized();
       })},
      {"moving-object", "a third of the tracks moves by 60 px/s besides", true,
       eachPoint([](PointObservation& point, double t, const FaultInput& in) {
         if (isChosen(point.id, 0.33)) move(point, 60.0 * (t - in.trouble.begin), 0.0, in);
       })},
  };
}

std::vector<StreamFault> otherFaults() {
  return {
      {"tracker-wrong-ids", "one track in twenty has another's id", true,
       eachFrame([](Image& frame, const FaultInput& in) {
         std::vector<PointObservation>& points = frame.message.points;
         for (std::size_t i = 0; i + 1 < points.size(); ++i) {
           if (uniform(in.random) < 0.05) std::swap(points[i].id, points[i + 1].id);
         }
       })},
      {"tracker-drift", "every track wanders by 3 px/s", true,
       eachPoint([](PointObservation& point, double t, const FaultInput& in) {
         const double angle = static_cast<double>(point.id * 137 % 360) * kRadPerDeg;
         const double px = 3.0 * (t - in.trouble.begin);
         move(point, px * std::cos(angle), px * std::sin(angle), in);
       })},
      {"tracker-gross-errors", "one observation in five displaced by 20 px", true,
       eachPoint([](PointObservation& point, double, const FaultInput& in) {
         if (uniform(in.random) >= 0.2) return;
         const double dy = 20.0 * normal(in.random), dx = 20.0 * normal(in.random);
         move(point, dx, dy, in);
       })},
      {"tracker-mixed-lines", "ids of the lines in any order", true,
       eachFrame([](Image& frame, const FaultInput& in) {
         auto& lines = frame.message.lines;
         std::vector<FeatureId> ids;
         for (const LineObservation& line : lines) ids.push_back(line.id);
         std::shuffle(ids.begin(), ids.end(), in.random);
         for (std::size_t i = 0; i < lines.size(); ++i) lines[i].id = ids[i];
       })},
      {"tracker-nan", "one point of every image is not a number", true,
       eachFrame([](Image& frame, const FaultInput& in) {
         std::vector<PointObservation>& points = frame.message.points;
         if (!points.empty()) points[in.random() % points.size()].bearing.x() = kNotComputed;
       })},
      {"tracker-few-points", "twelve points in an image", true,
       eachFrame([](Image& frame, const FaultInput&) {
         std::vector<PointObservation>& points = frame.message.points;
         std::sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.id < b.id; });
         points.resize(std::min<std::size_t>(points.size(), 12));
       })},
      {"host-td", "td error of 20 ms", true,
       [](const FaultInput& in) { in.streams.calibration.td += 0.02; }},
      {"host-extrinsic", "extrinsic rotation error of 3 deg", true,
       [](const FaultInput& in) {
         const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
         in.streams.calibration.R_b_c *=
             Eigen::AngleAxisd(3.0 * kRadPerDeg, axis).toRotationMatrix();
       }},
      {"host-lever-arm", "lever arm error of 5 cm", true,
       [](const FaultInput& in) {
         in.streams.calibration.t_b_c += Eigen::Vector3d(0.03, -0.03, 0.03);
       }},
      {"host-restart", "the host is restarted", false,
       [](const FaultInput& in) { in.streams.restart = in.trouble.end; }},
  };
}

}  // namespace

const std::vector<StreamFault>& streamFaults() {
  static const std::vector<StreamFault> faults = [] {
    std::vector<StreamFault> all = {{"none", "as recorded", false, [](const FaultInput&) {}}};
    for (const auto& group : {imuFaults(), cameraFaults(), otherFaults()}) {
      all.insert(all.end(), group.begin(), group.end());
    }
    return all;
  }();
  return faults;
}

}  // namespace slim_init::tools
